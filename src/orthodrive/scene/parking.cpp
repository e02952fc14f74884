#include "orthodrive/scene/parking.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>

#include "orthodrive/core/parallel.hpp"
#include "orthodrive/geo/narrowest_rectangle.hpp"
#include "orthodrive/geo/overlay.hpp"
#include "orthodrive/geo/spatial_index.hpp"
#include "orthodrive/scene/drape.hpp"
#include "orthodrive/scene/plan_grid.hpp"
#include "orthodrive/scene/tile_materials.hpp"

namespace orthodrive::scene {
namespace {

constexpr double cell_m = 96.0;  // a tile has whole ones: parts of large areas depend on what is near alone
constexpr double clearance_m = 0.05, min_area_m2 = 20.0;
constexpr double bay_width_m = 2.5, bay_depth_m = 5.0, aisle_m = 6.0, line_m = 0.1, line_gap_m = 0.15;
constexpr double asphalt_lift_m = 0.03, line_lift_m = 0.036;

/// Where rows of bays begin across an area of that width.
std::vector<double> rows_across(double width_m) {
  std::vector<double> rows;
  if (width_m < bay_depth_m - 0.5) return rows;
  for (double at_m = 0.0; at_m + bay_depth_m <= width_m + 0.5; at_m += 2.0 * bay_depth_m + aisle_m) {
    rows.push_back(at_m);
    if (at_m + 2.0 * bay_depth_m + aisle_m <= width_m + 0.5) rows.push_back(at_m + bay_depth_m + aisle_m);
  }
  return rows;
}

/// Lines between the bays of the whole area that lie on the ground.
std::vector<std::array<Vec2, 4>> lines_of(const Polygon& area, const Polygon& ground) {
  std::vector<std::array<Vec2, 4>> lines;
  Ring frame = narrowest_rectangle(area.outer);
  if (frame.size() != 4) return lines;
  if (distance(frame[0], frame[1]) < distance(frame[1], frame[2])) std::ranges::rotate(frame, frame.begin() + 1);
  const Vec2 along = normalized(frame[1] - frame[0]), across = left_normal(along);
  const double length_m = distance(frame[0], frame[1]), width_m = distance(frame[1], frame[2]);
  for (const double row_m : rows_across(width_m)) {
    for (int k = 1; k * bay_width_m < length_m - 0.5 * bay_width_m; ++k) {
      const auto at = [&](double x_m, double y_m) {
        return frame[0] + along * (k * bay_width_m + x_m) + across * (row_m + y_m);
      };
      const double low_m = line_gap_m, high_m = bay_depth_m - line_gap_m;
      const std::array<Vec2, 4> line = {at(-0.5 * line_m, low_m), at(0.5 * line_m, low_m), at(0.5 * line_m, high_m),
                                        at(-0.5 * line_m, high_m)};
      const std::array<Vec2, 3> middle = {at(0.0, 0.25 * bay_depth_m), at(0.0, 0.5 * bay_depth_m),
                                          at(0.0, 0.75 * bay_depth_m)};
      const auto is_on = [&](Vec2 p) { return contains(ground, p); };
      if (std::ranges::all_of(line, is_on) && std::ranges::all_of(middle, is_on)) lines.push_back(line);
    }
  }
  return lines;
}

/// All that takes the place of asphalt.
class Taken {
 public:
  explicit Taken(const ParkingSite& site) : site_(site) {
    std::vector<Box2> boxes;
    for (const PlacedBuilding& building : site.buildings)
      boxes.push_back(bounds_of(moved(building.footprint, building.middle).outer));
    buildings_ = SpatialIndex(boxes);
  }
  [[nodiscard]] MultiPolygon near(const Box2& box, Vec2 from) const {
    MultiPolygon taken;
    for (const RoadLevel* level : site_.levels)
      for (Polygon& piece : level->driven_near(box, from)) taken.push_back(std::move(piece));
    for (const std::uint32_t i : buildings_.touching(box)) {
      const PlacedBuilding& building = site_.buildings[i];
      if (!building.hovers) taken.push_back(moved(building.footprint, building.middle - from));
    }
    for (const WaterBody& body : site_.waters.bodies())
      if (body.box.overlaps(box))
        for (const Polygon& shore : body.shores) taken.push_back(moved(shore, from * -1.0));
    return taken;
  }

 private:
  const ParkingSite& site_;
  SpatialIndex buildings_;
};

/// A square of the plan that an area touches.
struct Cell {
  const Polygon* area;
  Vec2 middle;
};

std::vector<Cell> cells_of(const MultiPolygon& areas) {
  std::vector<Cell> cells;
  for (const Polygon& area : areas) {
    if (area.outer.size() < 3) continue;
    const Box2 box = bounds_of(area.outer);
    for (double x = std::floor(box.min_x / cell_m); x * cell_m < box.max_x; ++x)
      for (double y = std::floor(box.min_y / cell_m); y * cell_m < box.max_y; ++y)
        cells.push_back({&area, {(x + 0.5) * cell_m, (y + 0.5) * cell_m}});
  }
  return cells;
}

PlacedParking place(const Cell& cell, const Taken& taken, const ParkingSite& site) {
  PlacedParking parking{.middle = cell.middle};
  const Vec2 middle = cell.middle;
  if (!site.area.contains(middle)) return parking;
  const Polygon local = moved(*cell.area, middle * -1.0);
  constexpr double half_m = 0.5 * cell_m;
  const Polygon square{{{-half_m, -half_m}, {half_m, -half_m}, {half_m, half_m}, {-half_m, half_m}}, {}};
  MultiPolygon ground = intersection_of(union_of(std::span(&local, 1), plan_grid_m), {square}, plan_grid_m);
  if (ground.empty()) return parking;
  const Box2 local_box = bounds_of_all(ground);
  const Box2 box{local_box.min_x + middle.x, local_box.min_y + middle.y, local_box.max_x + middle.x,
                 local_box.max_y + middle.y};
  if (const MultiPolygon others = taken.near(box.grown(clearance_m), middle); !others.empty())
    ground = difference_of(ground, buffer_of(union_of(others, plan_grid_m), clearance_m, 2), plan_grid_m);
  const auto add = [&](const std::array<Vec2, 4>& piece, auto& pieces) {
    auto& added = pieces.emplace_back(piece);
    for (Vec2& p : added) p = p + middle;
  };
  double largest_m2 = 0.0;
  for (const Polygon& part : ground) {
    if (area_m2(part) < min_area_m2) continue;
    for (const auto& t : make_roof(part, {}).slopes)
      add({Vec2{t[0].x, t[0].y}, {t[1].x, t[1].y}, {t[2].x, t[2].y}, {t[2].x, t[2].y}}, parking.asphalt);
    for (const auto& line : lines_of(local, part)) add(line, parking.lines);
    if (area_m2(part) <= largest_m2) continue;
    largest_m2 = area_m2(part);
    parking.color = photo_median(site.photo, moved(part, middle));
  }
  return parking;
}

}  // namespace

std::vector<PlacedParking> place_parking(const MultiPolygon& areas, const ParkingSite& site) {
  const Taken taken(site);
  const std::vector<Cell> cells = cells_of(areas);
  std::vector<PlacedParking> placed(cells.size());
  parallel_for(cells.size(), site.threads, [&](std::size_t i) { placed[i] = place(cells[i], taken, site); });
  std::erase_if(placed, [](const PlacedParking& parking) { return parking.asphalt.empty(); });
  return placed;
}

void add_parking(const TriMesh& terrain, std::span<const PlacedParking* const> parking, Vec2 center, TriMesh& asphalt,
                 TriMesh& marking) {
  std::vector<std::array<Vec2, 4>> pieces, lines;
  std::vector<std::size_t> owner;  // of a piece
  const auto append = [&](const std::vector<std::array<Vec2, 4>>& added, std::vector<std::array<Vec2, 4>>& all) {
    for (std::array<Vec2, 4> piece : added) {
      for (Vec2& p : piece) p = p - center;
      all.push_back(piece);
    }
  };
  for (std::size_t i = 0; i < parking.size(); ++i) {
    append(parking[i]->asphalt, pieces);
    owner.resize(pieces.size(), i);
    append(parking[i]->lines, lines);
  }
  using Place = std::array<std::int64_t, 2>;
  const auto f = [](double v) { return static_cast<float>(v); };
  std::vector<std::map<Place, std::uint32_t>> known(parking.size());  // parts of one area share their corners
  cut_at_mesh(terrain, 0, pieces, [&](std::size_t number, std::span<const DrapedCorner> part) {
    std::vector<std::uint32_t> corners;
    for (const DrapedCorner& c : part) {
      const Place key = {std::llround(c.p.x / plan_grid_m), std::llround(c.p.y / plan_grid_m)};
      const auto [found, is_new] =
          known[owner[number]].try_emplace(key, static_cast<std::uint32_t>(asphalt.positions.size()));
      if (is_new) {
        asphalt.positions.push_back({f(c.p.x), f(c.p.y), f(c.z + asphalt_lift_m)});
        asphalt.normals.push_back({f(c.normal[0]), f(c.normal[1]), f(c.normal[2])});
        asphalt.colors.push_back(mesh_color(parking[owner[number]]->color));
      }
      if (corners.empty() || (corners.back() != found->second && corners.front() != found->second))
        corners.push_back(found->second);
    }
    const auto at = [&](std::size_t k) {
      const auto& p = asphalt.positions[corners[k]];
      return Vec2{double{p[0]}, double{p[1]}};
    };
    for (std::size_t k = 2; k < corners.size(); ++k)
      if (cross(at(k - 1) - at(0), at(k) - at(0)) > 0.0)
        asphalt.indices.insert(asphalt.indices.end(), {corners[0], corners[k - 1], corners[k]});
  });
  drape(terrain, 0, lines, line_lift_m, marking);
}

}  // namespace orthodrive::scene
