// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/report/road_pictures.hpp"

#include <algorithm>
#include <cmath>

#include "orthodrive/core/error.hpp"

namespace orthodrive {

GridFrame road_picture_frame(const RoadSurfaces& surfaces, const ScoreRegion& region, int max_px) {
  constexpr double finest_m = 0.25, margin_m = 10.0;
  Ring corners;
  for (const auto* set : {&surfaces.ours, &surfaces.truth})
    for (const Polygon& polygon : *set) corners.insert(corners.end(), polygon.outer.begin(), polygon.outer.end());
  if (corners.empty()) throw Error("no road surface to make a picture of");
  Box2 box = bounds_of(corners).grown(margin_m);
  if (region.area) {
    Ring edge;
    for (const Polygon& polygon : *region.area) edge.insert(edge.end(), polygon.outer.begin(), polygon.outer.end());
    const Box2 area = bounds_of(edge);
    if (area.overlaps(box))
      box = {std::max(box.min_x, area.min_x), std::max(box.min_y, area.min_y), std::min(box.max_x, area.max_x),
             std::min(box.max_y, area.max_y)};
  }
  // Two pixels less: a covering grid reaches beyond the box on both sides.
  return covering_grid(box, std::max(finest_m, std::max(box.width(), box.height()) / (max_px - 2)));
}

namespace {
constexpr std::array<double, 3> right{255, 235, 150}, false_positive{230, 25, 25}, false_negative{30, 80, 245};
}  // namespace

Canvas picture_of_road_errors(const RoadSurfaces& surfaces, const ScoreRegion& region, const GridFrame& frame,
                              const Photo* photo) {
  constexpr double pale = 0.65, weight_right = 0.45, weight_wrong = 0.8;  // the rest lets the photo shine through
  Raster<std::uint8_t> ours(frame.width, frame.height), truth(frame.width, frame.height);
  for (const Polygon& polygon : surfaces.ours) fill_polygon(ours, frame, polygon, std::uint8_t{1});
  for (const Polygon& polygon : surfaces.truth) fill_polygon(truth, frame, polygon, std::uint8_t{1});
  const Raster<std::uint8_t> counts = region_mask(frame, region);
  Canvas canvas{frame, Raster<std::uint8_t>(frame.width, frame.height, 3)};
  for (int row = 0; row < frame.height; ++row)
    for (int col = 0; col < frame.width; ++col) {
      const double grey = grey_at(photo, frame.center_of(col, row));
      const bool our = ours.at(col, row) != 0, true_road = truth.at(col, row) != 0;
      const std::array<double, 3>& color = our && true_road ? right : our ? false_positive : false_negative;
      const double weight = !our && !true_road ? 0.0 : our && true_road ? weight_right : weight_wrong;
      for (std::size_t k = 0; k < 3; ++k) {
        double value = grey + weight * (color[k] - grey);
        if (counts.at(col, row) == 0) value = pale * 255.0 + (1.0 - pale) * grey;
        canvas.rgb.at(col, row, static_cast<int>(k)) =
            static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 255.0)));
      }
    }
  return canvas;
}

}  // namespace orthodrive
