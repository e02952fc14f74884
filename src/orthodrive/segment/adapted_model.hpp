// SPDX-License-Identifier: Apache-2.0
#pragma once
// A trained network that got used to the look of a site: what it learns from, and what came of it. The learning itself
// needs libtorch and lies in the laboratory (lab/orthodrive/train/adapt_model.hpp). docs/adapt.md

#include <cstdint>
#include <functional>
#include <string>

#include "orthodrive/geo/raster.hpp"
#include "orthodrive/model/rasters/allowed_classes.hpp"
#include "orthodrive/model/rasters/tensor_file.hpp"

namespace orthodrive {

/// How the edges of what a map knows are painted: with bands of doubt, or as if it were exact.
enum class MapEdges { vague, sharp };

/// The classes that each pixel of a frame may have, as the map says. Called from several threads at once.
using WeakLabels = std::function<Raster<ClassSet>(const GridFrame&, MapEdges)>;

/// What it costs does not depend on the size of the photo, but for painting the labels of its cells.
struct AdaptOptions {
  int cell_px = 320;        ///< edge of the pieces of the photo that are learned from or held back: as the shipped
                            ///< model's crops, so that padding at their borders is nothing new to it
  int most_cells = 150;     ///< of those with roads so many are taken, spread over the photo
  std::int64_t steps = 60;  ///< of `batch` cells
  int batch = 4;
  double learning_rate = 1e-3;  ///< at the peak: it rises over a twentieth of the steps and falls as a half cosine
  double least_gain = 0.1;      ///< of kappa, else the shipped weights stay: a map that errs shows less for nothing
  double least_kappa = 0.35;    ///< of the adapted network, else the map is taken for that of another place
  std::uint64_t seed = 1;
  int threads = 0;  ///< 0 = all cores; the result does not depend on it
};

/// How labels agree with the map about road.
struct RoadAgreement {
  double iou = 0.0;               ///< where the map is sure
  double kappa = 0.0;             ///< likewise. Cohen's: 1 is perfect, 0 what labels reach that do not know the place
  double kappa_with_edges = 0.0;  ///< as if the map were exact: what lies beside lies so by chance, for all labels
};

struct AdaptReport {
  int learned_cells = 0, held_back_cells = 0;
  RoadAgreement before, after;  ///< on the cells held back, beside a map that is moved
  RoadAgreement alone;          ///< after it, by the photo without a map
  bool kept = false;
  std::string why_not;  ///< where it was dropped
};

struct AdaptedModel {
  TensorFile file;  ///< the model as given where the adaptation was dropped
  AdaptReport report;
};

}  // namespace orthodrive
