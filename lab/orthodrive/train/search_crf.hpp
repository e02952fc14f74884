// SPDX-License-Identifier: Apache-2.0
#pragma once
// Widths and weights of the CRF's kernels by search on a grid, before anything is learned (thesis, section 2.4.1).

#include <span>
#include <string>
#include <vector>

#include "orthodrive/crf/crf_model.hpp"
#include "orthodrive/geo/raster.hpp"
#include "orthodrive/model/rasters/allowed_classes.hpp"

namespace orthodrive {

/// What a network says about a crop whose labels are known.
struct CrfSample {
  Raster<std::uint8_t> rgb;
  Raster<ClassSet> allowed;  ///< of the same size
  std::vector<float> unary;  ///< pixels x classes, -log p
};

/// Share of the gain over no CRF that may be given up for a smaller lattice, and for fewer iterations.
inline constexpr double tolerated_loss = 0.2;

struct CrfSearchOptions {
  std::vector<double> theta_alpha_px{5.0, 9.0, 13.5, 20.0, 30.0}, theta_beta{5.0, 11.0, 20.0};
  std::vector<float> appearance_weight{1.0F, 2.5F, 5.0F, 10.0F};
  std::vector<double> theta_gamma_px{1.0, 1.75, 3.0};
  std::vector<float> smoothness_weight{0.5F, 1.5F, 3.0F};
  int iterations = 10;
  std::vector<int> fewer_iterations{3, 5};  ///< tried at the end
  int threads = 0;
};

/// One row of the search.
struct CrfTrial {
  CrfWidths widths;
  float appearance_weight = 0.0F, smoothness_weight = 0.0F;
  int iterations = 0;
  double vertices_per_pixel = 0.0;  ///< of the appearance kernel's lattice: what an iteration costs
  double pixel_accuracy = 0.0, mean_iou = 0.0;
};
struct CrfSearch {
  CrfModel best;                 ///< Potts
  std::vector<CrfTrial> trials;  ///< the first has no CRF at all
  /// Widths and weights whose chosen value is the first or last of several that were tried: a better one may lie
  /// beyond.
  std::vector<std::string> at_edges;
};
/// First the appearance kernel alone, then the smoothness kernel beside it, then fewer iterations; judged by the mean
/// of pixel accuracy and mean IoU over all samples. Of what keeps most of the best gain the cheapest is taken: the
/// curve is flat, the cost is not. When nothing is better than no CRF, the weights are 0.
[[nodiscard]] CrfSearch search_crf(std::span<const CrfSample> samples, int classes,
                                   const CrfSearchOptions& options = {});

}  // namespace orthodrive
