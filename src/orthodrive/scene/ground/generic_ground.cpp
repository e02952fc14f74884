// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/ground/generic_ground.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include "orthodrive/core/noise.hpp"
#include "orthodrive/geo/spatial_index.hpp"
#include "orthodrive/model/rasters/raster_source.hpp"
#include "orthodrive/scene/roads/crossing_roads.hpp"
#include "orthodrive/scene/roads/road_tint.hpp"
#include "roadquery/roads/lane_material.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace orthodrive::scene {
namespace {

constexpr double ground_pixel_m = 0.5;
constexpr Rgb water_blue = {62, 84, 92}, gravel_grey = {150, 142, 126}, parking_grey = {104, 104, 102},
              roof_red = {118, 84, 70}, sidewalk_grey = {136, 134, 130};
constexpr std::array<double, 3> lush = {84.0, 102.0, 52.0}, dry = {124.0, 122.0, 78.0};  // sRGB
constexpr std::array<double, 3> patches_m = {128.0, 32.0, 8.0};  // wavelengths of the grass' colours
constexpr double grass_grain = 0.10;                             // share of brightness that differs from pixel to pixel
constexpr double lane_chord_m = 0.1, longest_lane_chord_m = 20.0;  // of lanes, from their exact borders

Rgb color_of_surface(roadquery::SurfaceClass surface) {
  switch (surface) {
    case roadquery::SurfaceClass::concrete:
      return {150, 148, 142};
    case roadquery::SurfaceClass::setts:
      return {112, 108, 102};
    case roadquery::SurfaceClass::gravel:
      return {146, 136, 116};
    case roadquery::SurfaceClass::ground:
      return {122, 102, 76};
    case roadquery::SurfaceClass::asphalt:
      break;
  }
  return {96, 96, 97};
}

std::int32_t cell_of(double place_m) { return static_cast<std::int32_t>(std::floor(place_m / ground_pixel_m)); }

/// By the pixel's place: the same in every window.
Rgb grass_at(Vec2 p, std::int32_t col, std::int32_t row) {
  double share = 0.5;
  for (std::uint32_t i = 0; i < patches_m.size(); ++i)
    share += 0.5 * value_noise(p.x / patches_m[i], p.y / patches_m[i], i) / static_cast<double>(patches_m.size());
  const double light = 1.0 + 0.5 * grass_grain * signed_hash(col, row, patches_m.size());
  Rgb rgb{};
  for (std::size_t c = 0; c < rgb.size(); ++c)
    rgb[c] = static_cast<std::uint8_t>(std::lround(light * (lush[c] + share * (dry[c] - lush[c]))));
  return rgb;
}

struct PaintedArea {
  Polygon polygon;
  Rgb color{};
};

/// Areas in the order in which they are painted.
class Painting {
 public:
  explicit Painting(const DrawnMap& map) {
    if (map.surroundings != nullptr) {
      add(map.surroundings->water, water_blue);
      add(map.surroundings->gravel, gravel_grey);
      add(map.surroundings->parking, parking_grey);
    }
    for (const Building& building : map.buildings) areas_.push_back({building.footprint, roof_red});
    for (const roadquery::Junction& junction : map.roads.junctions) add_junction(junction);
    const std::vector<bool> over = lying_over(map.roads.roads);
    for (const RoadStructure wanted : {RoadStructure::ground, RoadStructure::deck})
      for (std::size_t i = 0; i < over.size(); ++i)
        if (structure_of(map.roads.roads[i], over[i]) == wanted) add_road(map.roads.roads[i]);
    std::vector<Box2> boxes;
    boxes.reserve(areas_.size());
    for (const PaintedArea& area : areas_) boxes.push_back(bounds_of(area.polygon.outer));
    index_ = SpatialIndex(boxes);
  }

  /// `frame`: of the picture.
  void paint(const GridFrame& frame, Raster<std::uint8_t>& rgb) const {
    for (const std::uint32_t i : index_.touching(frame.bounds())) {
      const PaintedArea& area = areas_[i];
      rasterize(area.polygon, frame, [&](int row, int begin, int end) {
        for (int col = begin; col < end; ++col)
          for (std::size_t c = 0; c < area.color.size(); ++c) rgb.at(col, row, static_cast<int>(c)) = area.color[c];
      });
    }
  }

 private:
  void add(const MultiPolygon& polygons, const Rgb& color) {
    for (const Polygon& polygon : polygons) areas_.push_back({polygon, color});
  }
  void add_junction(const roadquery::Junction& junction) {
    if (!junction.surface) return;
    Polygon polygon;
    for (const auto& [x, y] : junction.surface->boundary) polygon.outer.push_back({x, y});
    areas_.push_back({std::move(polygon), color_of_surface(roadquery::SurfaceClass::asphalt)});
  }
  void add_road(const roadquery::Road& road) {
    if (!(road.length > 0.0) || road.plan.empty()) return;
    for (std::size_t i = 0; i < road.sections.size(); ++i) {
      const double end_s = i + 1 < road.sections.size() ? road.sections[i + 1].s : road.length;
      for (double s = road.sections[i].s; s < end_s;) {
        const double curvature = std::abs(roadquery::reference_point(road, s).curvature);
        const double step_m = curvature > 0.0 ? std::sqrt(8.0 * lane_chord_m / curvature) : longest_lane_chord_m;
        const double next = std::min(s + std::clamp(step_m, 1.0, longest_lane_chord_m), end_s);
        add_stretch(road, road.sections[i], s, next);
        s = next;
      }
    }
  }
  /// All lanes between two places.
  void add_stretch(const roadquery::Road& road, const roadquery::LaneSection& section, double from, double to) {
    const auto at = [&](double s, double t) {
      const auto p = roadquery::surface_point(road, s, t);
      return Vec2{p.x, p.y};
    };
    for (const double side : {1.0, -1.0}) {
      double from_t = roadquery::evaluate(road.lane_offset, from), to_t = roadquery::evaluate(road.lane_offset, to);
      for (const roadquery::Lane& lane : side > 0.0 ? section.left : section.right) {
        const double from_outer = from_t + side * roadquery::lane_width(lane, from - section.s),
                     to_outer = to_t + side * roadquery::lane_width(lane, to - section.s);
        Ring ring{at(from, from_t), at(to, to_t), at(to, to_outer), at(from, from_outer)};
        const bool is_finite = std::ranges::all_of(ring, [](Vec2 p) { return std::isfinite(p.x + p.y); });
        const bool is_sidewalk = lane.type == roadquery::LaneType::sidewalk && lane.materials.empty();
        const Rgb color =
            is_sidewalk ? sidewalk_grey : color_of_surface(roadquery::material_at(lane, from - section.s).surface);
        if (is_finite) areas_.push_back({{std::move(ring), {}}, color});
        from_t = from_outer, to_t = to_outer;
      }
    }
  }

  std::vector<PaintedArea> areas_;
  SpatialIndex index_;
};

}  // namespace

PhotoSource generic_ground(const DrawnMap& map, const Crs& crs, const Box2& box) {
  const GridFrame frame = covering_grid(box, ground_pixel_m);
  const auto painting = std::make_shared<const Painting>(map);
  return {crs, frame, [frame, painting](const PixelBox& wanted) {
            PhotoWindow window{Raster<std::uint8_t>(wanted.width, wanted.height, 3),
                               Raster<std::uint8_t>(wanted.width, wanted.height)};
            const GridFrame part = part_of(frame, wanted);
            for (int row = 0; row < wanted.height; ++row) {
              for (int col = 0; col < wanted.width; ++col) {
                const std::int64_t c = wanted.col + col, r = wanted.row + row;
                window.valid.at(col, row) = c >= 0 && r >= 0 && c < frame.width && r < frame.height;
                const Vec2 p = part.center_of(col, row);
                const Rgb rgb = grass_at(p, cell_of(p.x), cell_of(p.y));
                std::ranges::copy(rgb, &window.rgb.data[window.rgb.index(col, row)]);
              }
            }
            painting->paint(part, window.rgb);
            return window;
          }};
}

}  // namespace orthodrive::scene
