// SPDX-License-Identifier: Apache-2.0
#pragma once
// The rasters that stages exchange, each on a north-up grid in the site CRS.

#include <cstdint>
#include <string>

#include "orthodrive/geo/crs.hpp"
#include "orthodrive/geo/raster.hpp"
#include "orthodrive/model/rasters/class_table.hpp"

namespace orthodrive {

/// Orthophoto in the site CRS. `valid` is 0 where the source has no pixel.
struct Photo {
  Crs crs;
  GridFrame frame;
  Raster<std::uint8_t> rgb;    ///< 3 channels
  Raster<std::uint8_t> valid;  ///< 1 channel, 0 or 1
};

/// A class for every pixel; label_nodata where there is no photo.
struct LabelMap {
  Crs crs;
  GridFrame frame;
  Raster<std::uint8_t> labels;
  ClassTable classes;
};

/// A probability for every pixel, 0..255 = 0..1: of the winning class, of road.
struct ConfidenceMap {
  Crs crs;
  GridFrame frame;
  Raster<std::uint8_t> confidence;
};

/// What the photo says about roads: the expected class cost (class_table.hpp) of a pixel just outside a road and of one
/// inside it, 0..255 = 0..1. Both 0 where nothing is known.
struct RoadEvidence {
  Crs crs;
  GridFrame frame;
  Raster<std::uint8_t> outside, inside;
};
/// Of labels of probability 1.
[[nodiscard]] RoadEvidence road_evidence(const LabelMap& labels);
/// With the probability of road on the grid of the labels (throws OptionError for another), which tells how sure a
/// pixel is; the classes' own costs count for those that may be road (parking) only.
[[nodiscard]] RoadEvidence road_evidence(const LabelMap& labels, const ConfidenceMap& road_probability);

/// Heights at pixel centres in metres, NaN where there is none (nodata).
struct HeightGrid {
  Crs crs;
  GridFrame frame;
  Raster<float> height_m;
  std::string vertical_datum;  ///< as stated by the source, may be empty
};

}  // namespace orthodrive
