// SPDX-License-Identifier: Apache-2.0
#pragma once
// Two random forests on superpixels: how likely a pixel is road, and how likely it is what lies beside roads.
//
// After Mattyus et al., Enhancing Road Maps by Parsing Aerial Images around the World, 2015, as used by the reference
// (thesis sec. 3.2.2): SLIC superpixels, OpenCV's random trees, one binary classifier each. What they leave open and
// how we filled it: docs/baselines.md.

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "orthodrive/baselines/superpixels.hpp"
#include "orthodrive/geo/pixel_box.hpp"
#include "orthodrive/geo/raster.hpp"
#include "orthodrive/model/rasters/class_table.hpp"
#include "orthodrive/model/rasters/photo_source.hpp"
#include "orthodrive/model/rasters/rasters.hpp"

namespace orthodrive {

/// Values of a training mask. Unknown: not labelled, not seen, or neither (parking, say); learned from by none.
enum class RoadMask : std::uint8_t { unknown = 0, road = 1, context = 2 };

/// Road is road; what may be road (parking) is unknown; all else is context.
[[nodiscard]] RoadMask road_mask_of(Role role);
/// The same of a label map, pixel by pixel of another grid in its CRS; unknown where the map has no label.
[[nodiscard]] Raster<std::uint8_t> road_mask(const LabelMap& labels, const GridFrame& frame);

struct RoadForestSample {
  Raster<std::uint8_t> rgb;  ///< 3 channels
  double gsd_m = 0.0;
  Raster<std::uint8_t> mask;   ///< 1 channel, RoadMask, as large as rgb
  Raster<std::uint8_t> valid;  ///< 0 where rgb means nothing; may be empty
};

struct RoadForestOptions {
  SuperpixelOptions superpixels;
  int trees = 60;
  double near_share = 0.5;  ///< of what the road forest learns as no road: the share that lies so near to one
  int max_samples = 15000;  ///< of each kind and forest; drawn by the seed
  std::uint64_t seed = 1;
  int threads = 0;  ///< 0 = all cores; the result does not depend on it
};

class RoadForests {
 public:
  struct Trees;
  explicit RoadForests(std::shared_ptr<const Trees> trees) : trees_(std::move(trees)) {}
  [[nodiscard]] const Trees& trees() const { return *trees_; }

 private:
  std::shared_ptr<const Trees> trees_;  ///< never null, never changed: copies share it
};

/// Both kinds get as many samples, whichever is rarer. Throws OptionError for samples whose rasters differ in size or
/// have no ground sampling distance, and when road or context is on none of them.
[[nodiscard]] RoadForests train_road_forests(std::span<const RoadForestSample> samples,
                                             const RoadForestOptions& options = {});

/// YAML text: the trees, how superpixels were made, and the ground sampling distances learned at.
[[nodiscard]] std::string save_road_forests(const RoadForests& forests);
/// `name` is what the errors call the text. Throws InputError when it is not such a text.
[[nodiscard]] RoadForests load_road_forests(const std::string& text, const std::string& name = "road forests");

/// Shares of the trees' votes, 0..255 = 0..1, for the pixels of a box; 0 where `valid` is 0.
struct RoadProbabilities {
  Raster<std::uint8_t> road;     ///< road, against all else
  Raster<std::uint8_t> context;  ///< beside a road, against road
  Raster<std::uint8_t> valid;    ///< 0 or 1, as the photo's
};

/// Predicts the tiles of a fixed grid that the box touches, each with a margin: a pixel has the same value in every box
/// and for every thread count. Memory is that of the box and of one tile a thread. Throws OptionError when the photo's
/// ground sampling distance differs by more than a factor of 1.6 from those learned at: textures would mean something
/// else.
[[nodiscard]] RoadProbabilities predict_road_forests(const RoadForests& forests, const PhotoSource& photo,
                                                     const PixelBox& box, int threads = 1);

}  // namespace orthodrive
