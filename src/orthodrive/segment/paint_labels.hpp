// SPDX-License-Identifier: Apache-2.0
#pragma once
// Labels for training painted from vector maps.

#include <vector>

#include "orthodrive/geo/polygon.hpp"
#include "orthodrive/geo/polyline.hpp"
#include "orthodrive/model/rasters/allowed_classes.hpp"

namespace orthodrive {

/// A line or point with a width (a disc for one point), or polygons.
struct PaintShape {
  MultiPolygon polygons;
  Polyline line;
  double width_m = 0.0;  ///< of the line or disc
};

/// One coat of paint; later coats cover earlier ones.
struct PaintLayer {
  std::vector<PaintShape> shapes;
  ClassSet classes = unknown_class;  ///< what is inside; unknown_class erases
  /// Where what is there already is a subset of these, the classes are added instead of replacing it:
  /// a service way across a car park may be either.
  ClassSet merge_over = 0;
  /// Nothing is known from this far inside the outline to that far outside: maps and photos disagree there.
  double unknown_inside_m = 0.0, unknown_outside_m = 0.0;
};

/// Starts from `background` everywhere. Within a layer all outer bands come first, so that they do not cut shapes that
/// touch.
[[nodiscard]] Raster<ClassSet> paint_labels(const GridFrame& frame, ClassSet background,
                                            const std::vector<PaintLayer>& layers);

}  // namespace orthodrive
