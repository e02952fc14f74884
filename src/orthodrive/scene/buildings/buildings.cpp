// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/buildings/buildings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "orthodrive/core/parallel.hpp"
#include "orthodrive/core/random.hpp"
#include "orthodrive/geo/overlay.hpp"
#include "orthodrive/geo/polyline.hpp"
#include "orthodrive/geo/spatial_index.hpp"
#include "orthodrive/scene/buildings/free_space.hpp"
#include "orthodrive/scene/plan/plan_grid.hpp"

namespace orthodrive::scene {
namespace {

constexpr double min_building_m2 = 4.0;  // of a building
constexpr double min_shared_m2 = 0.001;  // less is touching
constexpr double min_told_m2 = 1.0;      // smaller cuts are no finding: maps are drawn by hand
constexpr double straight_m = 0.02;      // corners that are less than this off a straight wall are none
constexpr double road_clearance_m = 0.1;
constexpr double foot_depth_m = 0.5;  // of walls below the lowest ground
constexpr double over_roads_m = 4.6;  // what begins higher may stand over a road (RStVO: trucks of 4 m)
constexpr double roof_slab_m = 0.25;  // of roofs without walls
constexpr double eaves_out_m = 0.4;
constexpr double most_storey_m = 3.0;

/// Linear colours of plaster, brick and wood; one a building, by its place.
LinearColor wall_color(BuildingLook look, std::uint64_t seed) {
  static constexpr LinearColor plaster[] = {{0.62F, 0.58F, 0.50F}, {0.66F, 0.65F, 0.62F}, {0.58F, 0.47F, 0.30F},
                                            {0.52F, 0.50F, 0.46F}, {0.42F, 0.20F, 0.13F}, {0.60F, 0.52F, 0.38F},
                                            {0.38F, 0.10F, 0.07F}, {0.50F, 0.54F, 0.56F}};
  static constexpr LinearColor sheet[] = {{0.55F, 0.56F, 0.56F}, {0.40F, 0.43F, 0.45F}, {0.60F, 0.57F, 0.50F},
                                          {0.25F, 0.32F, 0.38F}, {0.62F, 0.62F, 0.60F}, {0.30F, 0.30F, 0.30F}};
  Random random(seed);
  return look == BuildingLook::hall ? sheet[random.below(std::size(sheet))] : plaster[random.below(std::size(plaster))];
}

bool is_sheet(const std::string& material) {
  return material == "metal" || material == "metal_sheet" || material == "steel" || material == "tin" ||
         material == "zinc" || material == "copper" || material == "wood";
}

SurfaceMaterial roof_material(const Building& building, const PlacedBuilding& placed) {
  const std::string& given = building.roof_material;
  if (is_sheet(given) && given != "wood") return SurfaceMaterial::cladding;
  if (given == "concrete" || given == "tar_paper" || given == "glass" || given == "eternit")
    return SurfaceMaterial::concrete;
  switch (placed.roof.shape) {
    case RoofShape::flat:
      return SurfaceMaterial::gravel;
    case RoofShape::dome:
    case RoofShape::onion:
      return SurfaceMaterial::concrete;
    case RoofShape::round:
      return SurfaceMaterial::cladding;
    default:
      return placed.look == BuildingLook::hall && given.empty() ? SurfaceMaterial::cladding
                                                                : SurfaceMaterial::roof_tiles;
  }
}

Polygon largest(const MultiPolygon& polygons) {
  const auto found = std::ranges::max_element(polygons, {}, [](const Polygon& p) { return area_m2(p); });
  return found == polygons.end() ? Polygon{} : *found;
}

/// Begins with the point furthest in the west, which is a corner: simplification keeps where a ring begins.
void begin_at_corner(Ring& ring) {
  std::ranges::rotate(ring, std::ranges::min_element(ring, {}, [](Vec2 p) { return std::pair(p.x, p.y); }));
}

/// Without points that lie on the line between their neighbours: they would be corners of roofs.
Polygon without_straight_corners(Polygon polygon) {
  std::erase_if(polygon.holes, [](const Ring& hole) { return std::abs(signed_area_m2(hole)) < min_building_m2; });
  if (polygon.outer.size() < 3) return polygon;
  begin_at_corner(polygon.outer);
  for (Ring& hole : polygon.holes) begin_at_corner(hole);
  return largest(simplified({polygon}, straight_m));
}

double shared_m2(const Polygon& footprint, const MultiPolygon& taken) {
  double shared = 0.0;
  for (const Polygon& part : intersection_of({footprint}, taken, plan_grid_m)) shared += area_m2(part);
  return shared;
}

constexpr std::size_t no_outline = std::numeric_limits<std::size_t>::max();

/// A building before it is dressed, and what its cuts say.
struct Outlined {
  PlacedBuilding building;
  BuildingStyle style;
  double low_m = 0.0;                ///< over the ground, where it begins
  std::size_t outline = no_outline;  ///< of a part: its building
  bool stands = false;
  Findings findings;
};

void tell(const char* code, std::string message, Outlined& at) {
  at.findings.push_back({Severity::info, code, std::move(message), at.building.middle.x, at.building.middle.y});
}

/// Takes off the footprint what others have of it. It no longer stands when less than half is left. Returns the area
/// that was shared.
double cut(const MultiPolygon& taken, Outlined& at) {
  Polygon& footprint = at.building.footprint;
  const double shared = shared_m2(footprint, taken);
  if (shared < min_shared_m2) return 0.0;
  const double before = area_m2(footprint);
  footprint = largest(difference_of({footprint}, taken, plan_grid_m));
  at.stands = footprint.outer.size() >= 3 && area_m2(footprint) >= std::max(0.5 * before, min_building_m2);
  return shared;
}

struct Teller {
  const char *code, *who;
};
void cut_and_tell(const MultiPolygon& taken, const Teller& teller, Outlined& at) {
  const double before = area_m2(at.building.footprint), shared = cut(taken, at);
  if (shared == 0.0 || (at.stands && shared < min_told_m2)) return;
  tell(teller.code,
       fmt::format("a building of {:.0f} m2 shares {:.1f} m2 with {} and is {}", before, shared, teller.who,
                   at.stands ? "cut" : "left out"),
       at);
}

// ---- parts

/// Of each part the outline in which its middle lies: the smallest one.
std::vector<std::size_t> outlines_of_parts(std::span<const Building> buildings) {
  std::vector<std::size_t> outlines(buildings.size(), no_outline);
  if (std::ranges::none_of(buildings, &Building::is_part)) return outlines;
  std::vector<Box2> boxes;
  boxes.reserve(buildings.size());
  for (const Building& building : buildings)
    boxes.push_back(building.is_part || building.footprint.outer.empty() ? Box2{}
                                                                         : bounds_of(building.footprint.outer));
  const SpatialIndex index(boxes);
  for (std::size_t i = 0; i < buildings.size(); ++i) {
    if (!buildings[i].is_part || buildings[i].footprint.outer.size() < 3) continue;
    const MultiPolygon clean =
        union_of(std::vector{moved(buildings[i].footprint, buildings[i].footprint.outer[0] * -1.0)}, plan_grid_m);
    const Polygon own = largest(clean);
    if (own.outer.size() < 3) continue;
    Vec2 middle;
    for (const Vec2 p : own.outer) middle = middle + p * (1.0 / static_cast<double>(own.outer.size()));
    middle = middle + buildings[i].footprint.outer[0];
    double smallest = std::numeric_limits<double>::infinity();
    for (const std::uint32_t k : index.touching({middle.x, middle.y, middle.x, middle.y})) {
      if (buildings[k].is_part || !contains(buildings[k].footprint, middle)) continue;
      if (const double m2 = area_m2(buildings[k].footprint); m2 < smallest) smallest = m2, outlines[i] = k;
    }
  }
  return outlines;
}

/// What the part does not know, as its outline has it.
Building inherited(const Building& part, const Building& outline) {
  Building all = part;
  if (all.height_m <= 0.0 && all.levels <= 0.0) all.height_m = outline.height_m, all.levels = outline.levels;
  if (all.use == "yes") all.use = outline.use;
  if (all.material.empty()) all.material = outline.material;
  if (all.roof_material.empty()) all.roof_material = outline.roof_material;
  if (!all.wall_color) all.wall_color = outline.wall_color;
  if (!all.roof_color) all.roof_color = outline.roof_color;
  if (all.osm_id.empty()) all.osm_id = outline.osm_id;
  if (all.min_height_m > 0.0 && all.height_m > 0.0 && all.min_height_m >= all.height_m) all.min_height_m = 0.0;
  return all;
}

/// Parts come before their outlines, the highest first; others as they are given.
std::vector<std::size_t> cutting_order(const std::vector<Outlined>& outlined) {
  std::vector<std::size_t> order(outlined.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  const auto rank = [&](std::size_t i) {
    const Outlined& at = outlined[i];
    const bool is_part = at.outline != no_outline;
    return std::tuple(is_part ? 0 : 1, is_part ? -top_m(at.style) : 0.0);
  };
  std::ranges::stable_sort(order, {}, rank);
  return order;
}

bool overlap_in_height(const Outlined& a, const Outlined& b) {
  constexpr double touching_m = 0.05;
  const auto high = [](const Outlined& at) { return top_m(at.style); };
  return a.low_m < high(b) - touching_m && b.low_m < high(a) - touching_m;
}

// ---- where they stand

/// Roads and decks near a footprint, of which it must keep off: all but those that it stands high over.
MultiPolygon paved_below(const Outlined& at, const BuildingSite& site) {
  const PlacedBuilding& placed = at.building;
  const Ring& outer = placed.footprint.outer;
  const Box2 local = bounds_of(outer);
  const Box2 box = Box2{local.min_x + placed.middle.x, local.min_y + placed.middle.y, local.max_x + placed.middle.x,
                        local.max_y + placed.middle.y}
                       .grown(road_clearance_m);
  MultiPolygon paved;
  for (const RoadLevel* level : site.levels) {
    for (Polygon& piece : level->driven_near(box, placed.middle)) {
      const auto is_far_below = [&](Vec2 p) {
        const auto on = level->sample(placed.middle + p);
        return on && placed.base_z_m + at.low_m - on->z_m >= over_roads_m;
      };
      if (at.low_m >= over_roads_m - 1.0 && std::ranges::all_of(piece.outer, is_far_below)) continue;
      paved.push_back(std::move(piece));
    }
  }
  return paved;
}

void find_ground(const Ring& around, const Ground& ground, PlacedBuilding& placed) {
  double sum_m = 0.0, lowest_m = std::numeric_limits<double>::infinity();
  for (const Vec2 p : around) {
    const double z = ground.height_m(p);
    sum_m += z;
    lowest_m = std::min(lowest_m, z);
  }
  placed.base_z_m = sum_m / static_cast<double>(around.size());
  placed.foot_z_m = lowest_m - foot_depth_m;
}

/// Footprint relative to its middle, clean and beside the roads. `around`: the outline of the whole building.
Outlined outline_of(const Building& building, const Ring* around, const BuildingSite& site) {
  Outlined at;
  if (building.footprint.outer.size() < 3) return at;
  const Box2 box = bounds_of(building.footprint.outer);
  PlacedBuilding& placed = at.building;
  placed.middle = snap_to_grid({0.5 * (box.min_x + box.max_x), 0.5 * (box.min_y + box.max_y)});
  if (!site.area.contains(placed.middle)) return at;
  const Polygon local = moved(building.footprint, placed.middle * -1.0);
  placed.footprint = without_straight_corners(largest(union_of(std::span(&local, 1), plan_grid_m)));
  at.stands = placed.footprint.outer.size() >= 3 && area_m2(placed.footprint) >= min_building_m2;
  if (!at.stands) return at;
  at.style = style_of(building, area_m2(placed.footprint));
  at.low_m = building.has_walls
                 ? building.min_height_m
                 : std::max(building.min_height_m,
                            at.style.height_m - roof_slab_m - (at.style.with_roof ? at.style.roof.rise_m : 0.0));
  if (at.low_m > 0.0) find_ground(around ? *around : building.footprint.outer, site.ground, placed);
  const MultiPolygon paved = paved_below(at, site);
  if (paved.empty()) return at;
  cut_and_tell(buffer_of(paved, road_clearance_m, 2), {"scene.building_on_road", "roads"}, at);
  if (at.stands) placed.footprint = without_straight_corners(std::move(placed.footprint));
  return at;
}

/// Buildings one after the other: each loses what it shares with those before it.
void cut_apart(std::vector<Outlined>& buildings) {
  std::vector<Box2> boxes;
  for (const Outlined& at : buildings) {
    const Ring& outer = at.building.footprint.outer;
    const Vec2 m = at.building.middle;
    const Box2 local = at.stands ? bounds_of(outer) : Box2{};
    boxes.push_back({local.min_x + m.x, local.min_y + m.y, local.max_x + m.x, local.max_y + m.y});
  }
  const SpatialIndex index(boxes);
  std::vector<bool> is_before(buildings.size(), false);
  for (const std::size_t i : cutting_order(buildings)) {
    is_before[i] = true;
    Outlined& at = buildings[i];
    if (!at.stands) continue;
    MultiPolygon parts, others;
    for (const std::uint32_t k : index.touching(boxes[i])) {
      const Outlined& before = buildings[k];
      if (k == i || !is_before[k] || !before.stands || !overlap_in_height(at, before)) continue;
      const bool is_family = before.outline == i || (at.outline != no_outline && before.outline == at.outline);
      (is_family ? parts : others)
          .push_back(moved(before.building.footprint, before.building.middle - at.building.middle));
    }
    // One set: walls that neighbours share would make it invalid.
    if (!parts.empty()) cut(union_of(parts, plan_grid_m), at);
    if (at.stands && !others.empty())
      cut_and_tell(union_of(others, plan_grid_m), {"scene.building_overlap", "others"}, at);
    if (at.stands && !parts.empty()) at.building.footprint = without_straight_corners(std::move(at.building.footprint));
  }
}

// ---- what they look like

/// Posts at the corners of a roof without walls and between them, where no road is.
std::vector<Vec2> posts_of(const PlacedBuilding& placed, const BuildingSite& site) {
  constexpr double in_m = 0.35, step_m = 7.0, room_m = 0.45;  // beyond their ends roads are driven for 0.25 m
  const Ring& ring = placed.footprint.outer;
  const auto inwards = [&](std::size_t k) { return left_normal(normalized(ring[(k + 1) % ring.size()] - ring[k])); };
  std::vector<Vec2> posts;
  const auto add = [&](Vec2 local) {
    const Vec2 p = placed.middle + local;
    const auto is_free = [&](const RoadLevel* level) {
      return level->outline().nearest(p).distance_m > room_m && !level->outline().contains(p);
    };
    const auto is_far = [&](Vec2 other) { return distance(other, local) > 1.0; };
    if (contains(placed.footprint, local) && std::ranges::all_of(site.levels, is_free) &&
        std::ranges::all_of(posts, is_far))
      posts.push_back(local);
  };
  for (std::size_t i = 0; i < ring.size(); ++i) {
    add(ring[i] + mitre(inwards((i + ring.size() - 1) % ring.size()), inwards(i)) * in_m);
    const Vec2 along = ring[(i + 1) % ring.size()] - ring[i];
    const int parts = static_cast<int>(length(along) / step_m);
    for (int k = 1; k < parts; ++k) add(ring[i] + along * (static_cast<double>(k) / parts) + inwards(i) * in_m);
  }
  return posts;
}

std::optional<Vec3> chimney_of(const PlacedBuilding& placed) {
  constexpr double most_m2 = 400.0, least_m2 = 60.0, with_one = 0.75;
  const double m2 = area_m2(placed.footprint);
  if (placed.look != BuildingLook::house || placed.hovers || placed.roof.shape == RoofShape::flat ||
      placed.roof.shape == RoofShape::skillion || m2 < least_m2 || m2 > most_m2)
    return std::nullopt;
  Random random(derive_seed(placed.seed, 2));
  if (random.uniform() > with_one) return std::nullopt;
  const Vec3 foot = placed.roof.ridge[0] + (placed.roof.ridge[1] - placed.roof.ridge[0]) * random.uniform(0.25, 0.75);
  return Vec3{placed.middle.x + foot.x, placed.middle.y + foot.y, placed.eaves_z_m + foot.z};
}

void dress(const Building& building, const BuildingSite& site, const Ring* around, Outlined& at) {
  PlacedBuilding& placed = at.building;
  const double m2 = area_m2(placed.footprint);
  if (at.style.look != BuildingLook::plain || at.low_m == 0.0) at.style = style_of(building, m2);
  const BuildingStyle& style = at.style;
  const auto cell = [](double v) { return static_cast<std::uint64_t>(std::llround(v)); };
  placed.seed = derive_seed(cell(placed.middle.x), cell(placed.middle.y));
  placed.look = style.look;
  placed.use = building.use, placed.osm_id = building.osm_id;
  placed.roof = make_roof(placed.footprint, style.roof);
  const double eaves_m = style.with_roof ? style.height_m - placed.roof.rise_m : style.height_m;
  placed.storeys =
      style.storeys > 0 ? style.storeys : std::max(1, static_cast<int>(std::lround(eaves_m / most_storey_m)));
  if (around) {
    find_ground(*around, site.ground, placed);
  } else {
    find_ground(moved(placed.footprint, placed.middle).outer, site.ground, placed);
  }
  placed.eaves_z_m = placed.base_z_m + eaves_m;
  placed.hovers = at.low_m > 0.0;
  if (placed.hovers) placed.foot_z_m = std::min(placed.base_z_m + at.low_m, placed.eaves_z_m - roof_slab_m);
  if (!building.has_walls) placed.posts = posts_of(placed, site);
  constexpr double parapet_m = 0.45, parapet_m2 = 300.0;
  if (placed.roof.shape == RoofShape::flat && !placed.hovers && m2 > parapet_m2) placed.parapet_m = parapet_m;
  const bool is_hall = style.look == BuildingLook::hall || (style.look == BuildingLook::shop && m2 > 800.0);
  placed.wall_material = (building.material.empty() && is_hall) || is_sheet(building.material)
                             ? SurfaceMaterial::cladding
                             : SurfaceMaterial::concrete;
  placed.roof_material = roof_material(building, placed);
  placed.wall_color = building.wall_color.value_or(wall_color(is_hall ? BuildingLook::hall : style.look, placed.seed));
  placed.roof_color =
      building.roof_color ? *building.roof_color : photo_median(site.photo, moved(placed.footprint, placed.middle));
  placed.chimney = chimney_of(placed);
}

/// Places on the roads' reference lines.
class NearRoads {
 public:
  explicit NearRoads(std::span<const RoadLevel* const> levels) {
    std::vector<Box2> boxes;
    for (const RoadLevel* level : levels)
      for (const auto& strip : level->strips())
        for (const CrossSection& section : strip) {
          places_.push_back({section.reference.x, section.reference.y});
          boxes.push_back({places_.back().x, places_.back().y, places_.back().x, places_.back().y});
        }
    index_ = SpatialIndex(boxes);
  }
  [[nodiscard]] std::optional<Vec2> nearest(Vec2 p) const {
    constexpr double reach_m = 80.0;
    const auto order = [&](Vec2 q) { return std::tuple(distance(p, q), q.x, q.y); };
    std::optional<Vec2> best;
    for (const std::uint32_t i : index_.near(p, reach_m))
      if (!best || order(places_[i]) < order(*best)) best = places_[i];
    return best;
  }

 private:
  std::vector<Vec2> places_;
  SpatialIndex index_;
};

/// The outer edge that is nearest to the road and looks at it; without a road the longest one.
std::size_t front_of(const PlacedBuilding& placed, std::optional<Vec2> road) {
  constexpr double least_m = 2.6, looks = 0.3;  // cosine
  const Ring& ring = placed.footprint.outer;
  std::size_t front = 0;
  std::tuple<bool, double> best{true, std::numeric_limits<double>::infinity()};
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Vec2 a = ring[i], b = ring[(i + 1) % ring.size()], outwards = left_normal(normalized(b - a)) * -1.0;
    double cost = -distance(a, b);
    bool is_poor = false;
    if (road) {
      const Vec2 to = *road - placed.middle - (a + b) * 0.5;
      cost = length(to);
      is_poor = distance(a, b) < least_m || dot(to, outwards) < looks * cost;
    }
    if (const std::tuple order{is_poor, cost}; order < best) best = order, front = i;
  }
  return front;
}

bool has_eaves(const PlacedBuilding& placed) {
  constexpr double most_m2 = 500.0;
  return placed.roof.shape != RoofShape::flat && placed.roof.shape != RoofShape::dome &&
         placed.roof.shape != RoofShape::onion && placed.roof.shape != RoofShape::mansard && !placed.hovers &&
         placed.look != BuildingLook::hall && area_m2(placed.footprint) < most_m2;
}

/// Whether the strip outside of an edge is free, as wide as eaves and 0.1 m more: discs around places along the edge
/// cover it. Most houses stand so free that a few large ones do; small ones see past a neighbour's wall in the corner.
bool is_free_outside(Vec2 a, Vec2 b, std::size_t number, const FreeSpace& space) {
  struct Discs {
    double step_m, off_m;
  };
  constexpr double strip_m = eaves_out_m + road_clearance_m;
  const Vec2 outwards = left_normal(normalized(b - a)) * -1.0;
  const auto are_free = [&](const Discs& discs) {
    const double radius_m = std::hypot(0.5 * discs.step_m, strip_m - discs.off_m);
    const int parts = std::max(1, static_cast<int>(std::ceil(distance(a, b) / discs.step_m)));
    for (int k = 0; k <= parts; ++k) {
      const Vec2 p = a + (b - a) * (static_cast<double>(k) / parts) + outwards * discs.off_m;
      if (space.around(p, radius_m, {.besides = number}) < radius_m) return false;
    }
    return true;
  };
  return are_free({1.0, 0.0}) || are_free({0.25, 0.27});
}

/// How far the roof may stand out over each outer edge.
std::vector<double> eaves_of(const PlacedBuilding& placed, std::size_t number, const FreeSpace& space) {
  constexpr double least_edge_m = 1.0;
  const Ring& ring = placed.footprint.outer;
  std::vector<double> out_m;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Vec2 a = placed.middle + ring[i], b = placed.middle + ring[(i + 1) % ring.size()];
    out_m.push_back(distance(a, b) >= least_edge_m && is_free_outside(a, b, number, space) ? eaves_out_m : 0.0);
  }
  if (std::ranges::all_of(out_m, [](double m) { return m == 0.0; })) out_m.clear();
  return out_m;
}

}  // namespace

std::vector<PlacedBuilding> place_buildings(std::span<const Building> given, const BuildingSite& site,
                                            Findings& findings) {
  std::vector<Building> buildings(given.begin(), given.end());
  const std::vector<std::size_t> outlines = outlines_of_parts(given);
  const auto around = [&](std::size_t i) {
    return outlines[i] == no_outline ? nullptr : &given[outlines[i]].footprint.outer;
  };
  for (std::size_t i = 0; i < buildings.size(); ++i)
    if (outlines[i] != no_outline) buildings[i] = inherited(given[i], given[outlines[i]]);
  std::vector<Outlined> outlined(buildings.size());
  parallel_for(buildings.size(), site.threads, [&](std::size_t i) {
    outlined[i] = outline_of(buildings[i], around(i), site);
    outlined[i].outline = outlines[i];
    if (buildings[i].is_part && outlines[i] == no_outline && outlined[i].stands)
      tell("scene.part_without_building", "a part of a building lies in no building", outlined[i]);
  });
  cut_apart(outlined);
  const NearRoads roads(site.levels);
  parallel_for(buildings.size(), site.threads, [&](std::size_t i) {
    if (!outlined[i].stands) return;
    PlacedBuilding& placed = outlined[i].building;
    dress(buildings[i], site, around(i), outlined[i]);
    placed.front = front_of(placed, roads.nearest(placed.middle));
    const Ring& ring = placed.footprint.outer;
    placed.door_z_m =
        site.ground.height_m(placed.middle + (ring[placed.front] + ring[(placed.front + 1) % ring.size()]) * 0.5);
  });
  std::vector<PlacedBuilding> placed;
  for (Outlined& at : outlined) {
    findings.insert(findings.end(), at.findings.begin(), at.findings.end());
    if (at.stands) placed.push_back(std::move(at.building));
  }
  const Outline no_openings;
  const FreeSpace space({site.levels, placed, site.area, no_openings});
  std::vector<std::vector<double>> eaves(placed.size());
  parallel_for(placed.size(), site.threads, [&](std::size_t i) {
    if (has_eaves(placed[i])) eaves[i] = eaves_of(placed[i], i, space);
  });
  for (std::size_t i = 0; i < placed.size(); ++i) placed[i].eaves_m = std::move(eaves[i]);
  return placed;
}

}  // namespace orthodrive::scene
