#include "orthodrive/scene/buildings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "orthodrive/core/parallel.hpp"
#include "orthodrive/core/random.hpp"
#include "orthodrive/geo/overlay.hpp"
#include "orthodrive/geo/spatial_index.hpp"
#include "orthodrive/scene/build_scene.hpp"
#include "orthodrive/scene/plan_grid.hpp"
#include "orthodrive/scene/surface_texture.hpp"
#include "orthodrive/scene/tile_materials.hpp"

namespace orthodrive::scene {
namespace {

constexpr double min_area_m2 = 4.0;     // of a building
constexpr double min_shared_m2 = 0.01;  // less is touching
constexpr double min_told_m2 = 1.0;     // smaller cuts are no finding: maps are drawn by hand
constexpr double straight_m = 0.02;     // corners that are less than this off a straight wall are none
constexpr double road_clearance_m = 0.1;
constexpr double foot_depth_m = 0.5;  // of walls below the lowest ground
constexpr double bay_m = 3.2;         // distance of windows
constexpr double min_bay_m = 1.6;     // shorter walls have none
constexpr double house_pitch = 0.7;   // 35 degrees
constexpr double small_m2 = 60.0, house_m2 = 300.0;
constexpr double max_rise_share = 0.5;  // of a building's height

/// What is known of a building before it stands anywhere.
struct Style {
  double height_m = 0.0;  ///< ground to eaves, or to the ridge where `with_roof`
  bool with_roof = false;
  int storeys = 1;
  bool windows = true;
  RoofShape roof = RoofShape::flat;
};

bool is_one_of(const std::string& use, std::initializer_list<const char*> names) {
  return std::ranges::find(names, use) != names.end();
}

RoofShape roof_shape(const Building& building, RoofShape otherwise) {
  if (building.roof_shape.empty()) return otherwise;
  if (building.roof_shape == "flat") return RoofShape::flat;
  return is_one_of(building.roof_shape, {"hipped", "pyramidal", "half-hipped", "dome", "cone"}) ? RoofShape::hipped
                                                                                                : RoofShape::gabled;
}

Style style_of(const Building& building, double area) {
  const std::string& use = building.use;
  const bool shed = is_one_of(use, {"garage", "garages", "shed", "hut", "greenhouse", "kiosk"}) || area < small_m2;
  const bool hall = is_one_of(
      use, {"industrial", "warehouse", "retail", "supermarket", "barn", "hangar", "commercial", "manufacture"});
  const bool house = !shed && !hall && area <= house_m2;
  Style style;
  if (shed) {
    style = {2.6, false, 1, false, area > 25.0 ? RoofShape::gabled : RoofShape::flat};
  } else if (hall) {
    style = {8.0, false, 2, false, RoofShape::flat};
  } else if (house) {
    style = {5.6, false, 2, true, RoofShape::gabled};
  } else {
    style = {9.0, false, 3, true, RoofShape::flat};
  }
  style.roof = roof_shape(building, style.roof);
  if (building.levels > 0.0) {
    style.height_m = (shed || hall ? style.height_m / style.storeys : 3.0) * building.levels;
    style.storeys = std::max(1, static_cast<int>(std::lround(building.levels)));
  }
  if (building.height_m > 0.0) {
    style.height_m = building.height_m;
    style.with_roof = true;
    if (building.levels <= 0.0) style.storeys = 0;  // as many as fit below the eaves
  }
  return style;
}

/// Linear colours of plaster, brick and wood; one a building, by its place.
LinearColor wall_color(Vec2 middle) {
  static constexpr LinearColor palette[] = {{0.62F, 0.58F, 0.50F}, {0.66F, 0.65F, 0.62F}, {0.58F, 0.47F, 0.30F},
                                            {0.52F, 0.50F, 0.46F}, {0.42F, 0.20F, 0.13F}, {0.60F, 0.52F, 0.38F},
                                            {0.38F, 0.10F, 0.07F}, {0.50F, 0.54F, 0.56F}};
  const auto cell = [](double v) { return static_cast<std::uint64_t>(std::llround(v)); };
  Random random(derive_seed(cell(middle.x), cell(middle.y)));
  return palette[random.below(std::size(palette))];
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
  std::erase_if(polygon.holes, [](const Ring& hole) { return std::abs(signed_area_m2(hole)) < min_area_m2; });
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

/// A building before it is dressed, and what its cuts say.
struct Outlined {
  PlacedBuilding building;
  bool stands = false;
  Findings findings;
};

/// Takes off the footprint what others have of it. It no longer stands when less than half is left.
void cut(const MultiPolygon& taken, const char* code, const char* who, Outlined& at) {
  Polygon& footprint = at.building.footprint;
  const double shared = shared_m2(footprint, taken);
  if (shared < min_shared_m2) return;
  const double before = area_m2(footprint);
  footprint = largest(difference_of({footprint}, taken, plan_grid_m));
  at.stands = footprint.outer.size() >= 3 && area_m2(footprint) >= std::max(0.5 * before, min_area_m2);
  if (at.stands && shared < min_told_m2) return;
  at.findings.push_back({Severity::info, code,
                         fmt::format("a building of {:.0f} m2 shares {:.1f} m2 with {} and is {}", before, shared, who,
                                     at.stands ? "cut" : "left out"),
                         at.building.middle.x, at.building.middle.y});
}

/// Footprint relative to its middle, clean and beside the roads.
Outlined outline_of(const Building& building, std::span<const RoadLevel* const> levels, const Outline& area) {
  Outlined at;
  if (building.footprint.outer.size() < 3) return at;
  const Box2 box = bounds_of(building.footprint.outer);
  PlacedBuilding& placed = at.building;
  placed.middle = snap_to_grid({0.5 * (box.min_x + box.max_x), 0.5 * (box.min_y + box.max_y)});
  if (!area.contains(placed.middle)) return at;
  const Polygon local = moved(building.footprint, placed.middle * -1.0);
  placed.footprint = without_straight_corners(largest(union_of(std::span(&local, 1), plan_grid_m)));
  at.stands = placed.footprint.outer.size() >= 3 && area_m2(placed.footprint) >= min_area_m2;
  MultiPolygon paved;
  for (const RoadLevel* level : levels)
    for (Polygon& piece : level->paved_near(box.grown(road_clearance_m), placed.middle))
      paved.push_back(std::move(piece));
  if (!at.stands || paved.empty()) return at;
  cut(buffer_of(paved, road_clearance_m, 2), "scene.building_on_road", "roads", at);
  if (at.stands) placed.footprint = without_straight_corners(std::move(placed.footprint));
  return at;
}

void dress(const Building& building, const Ground& ground, const Photo& photo, PlacedBuilding& placed) {
  const Style style = style_of(building, area_m2(placed.footprint));
  placed.windows = style.windows;
  placed.use = building.use, placed.osm_id = building.osm_id;
  placed.roof = make_roof(placed.footprint, style.roof, house_pitch, max_rise_share * style.height_m);
  const double eaves_m = style.with_roof ? style.height_m - placed.roof.rise_m : style.height_m;
  placed.storeys = style.storeys > 0 ? style.storeys : std::max(1, static_cast<int>(std::lround(eaves_m / 3.0)));
  double sum_m = 0.0, lowest_m = std::numeric_limits<double>::infinity();
  for (const Vec2 p : placed.footprint.outer) {
    const double z = ground.height_m(placed.middle + p);
    sum_m += z;
    lowest_m = std::min(lowest_m, z);
  }
  placed.base_z_m = sum_m / static_cast<double>(placed.footprint.outer.size());
  placed.foot_z_m = lowest_m - foot_depth_m;
  placed.eaves_z_m = placed.base_z_m + eaves_m;
  placed.wall_color = building.wall_color.value_or(wall_color(placed.middle));
  placed.roof_color =
      building.roof_color ? *building.roof_color : photo_median(photo, moved(placed.footprint, placed.middle));
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
  for (std::size_t i = 0; i < buildings.size(); ++i) {
    if (!buildings[i].stands) continue;
    MultiPolygon before;
    for (const std::uint32_t k : index.touching(boxes[i]))
      if (k < i && buildings[k].stands)
        before.push_back(
            moved(buildings[k].building.footprint, buildings[k].building.middle - buildings[i].building.middle));
    if (before.empty()) continue;
    // One set: walls that neighbours share would make it invalid.
    cut(union_of(before, plan_grid_m), "scene.building_overlap", "others", buildings[i]);
  }
}

/// Adds flat shaded faces to the mesh.
class FaceBuilder {
 public:
  FaceBuilder(TriMesh& mesh, Vec3 origin) : mesh_(mesh), origin_(origin) {}

  /// A face of corners in one plane, counter-clockwise from outside, as a fan. `right`: direction of the texture's
  /// first coordinate; (u, v) of a corner are its distances from `from` along `right` and down, over the size.
  void add(SurfaceMaterial material, std::span<const Vec3> corners, const LinearColor& color, Vec3 from,
           Vec2 texture_m) {
    const Vec3 n = normal_of(corners);
    const double flat = std::hypot(n.x, n.y);
    const Vec3 right = flat > 1e-6 ? Vec3{-n.y / flat, n.x / flat, 0.0} : Vec3{1.0, 0.0, 0.0};
    const Vec3 up = {n.y * right.z - n.z * right.y, n.z * right.x - n.x * right.z, n.x * right.y - n.y * right.x};
    const auto first = static_cast<std::uint32_t>(mesh_.positions.size());
    const auto f = [](double v) { return static_cast<float>(v); };
    for (const Vec3& p : corners) {
      const Vec3 local = p - origin_, d = p - from;
      mesh_.positions.push_back({f(local.x), f(local.y), f(local.z)});
      mesh_.normals.push_back({f(n.x), f(n.y), f(n.z)});
      mesh_.tile_uv.push_back({f((d.x * right.x + d.y * right.y + d.z * right.z) / texture_m.x),
                               f(-(d.x * up.x + d.y * up.y + d.z * up.z) / texture_m.y)});
      mesh_.colors.push_back(mesh_color(color));
    }
    for (std::uint32_t k = 2; k < corners.size(); ++k) parts_.add(material, {first, first + k - 1, first + k});
  }
  void finish() { parts_.finish(mesh_); }

 private:
  static Vec3 normal_of(std::span<const Vec3> c) {
    const Vec3 a = c[1] - c[0], b = c[2] - c[0];
    const Vec3 n = {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
    const double length = std::hypot(n.x, n.y, n.z);
    return length > 0.0 ? n * (1.0 / length) : Vec3{0.0, 0.0, 1.0};
  }
  TriMesh& mesh_;
  Vec3 origin_;
  PartedTriangles parts_;
};

void add_walls(const PlacedBuilding& building, FaceBuilder& faces) {
  const double storey_m = (building.eaves_z_m - building.base_z_m) / building.storeys;
  const auto add = [&](const Ring& ring) {
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const Vec2 a = building.middle + ring[i], b = building.middle + ring[(i + 1) % ring.size()];
      const double length_m = distance(a, b);
      const double bays = std::max(1.0, std::round(length_m / bay_m));
      const bool windows = building.windows && length_m >= min_bay_m;
      const Vec2 texture_m = windows ? Vec2{length_m / bays, storey_m} : Vec2{surface_texture_m, surface_texture_m};
      const std::array<Vec3, 4> wall = {Vec3{a.x, a.y, building.foot_z_m}, Vec3{b.x, b.y, building.foot_z_m},
                                        Vec3{b.x, b.y, building.eaves_z_m}, Vec3{a.x, a.y, building.eaves_z_m}};
      faces.add(windows ? SurfaceMaterial::facade : SurfaceMaterial::concrete, wall, building.wall_color,
                {a.x, a.y, building.base_z_m}, texture_m);
    }
  };
  add(building.footprint.outer);
  for (const Ring& hole : building.footprint.holes) add(hole);
}

void add_roof(const PlacedBuilding& building, FaceBuilder& faces) {
  const Vec3 at{building.middle.x, building.middle.y, building.eaves_z_m};
  const auto add = [&](const std::array<Vec3, 3>& t, SurfaceMaterial material, const LinearColor& color) {
    const std::array<Vec3, 3> corners = {at + t[0], at + t[1], at + t[2]};
    faces.add(material, corners, color, at, {surface_texture_m, surface_texture_m});
  };
  const bool flat = building.roof.shape == RoofShape::flat;
  for (const auto& slope : building.roof.slopes)
    add(slope, flat ? SurfaceMaterial::gravel : SurfaceMaterial::roof_tiles, building.roof_color);
  for (const auto& gable : building.roof.gables) add(gable, SurfaceMaterial::concrete, building.wall_color);
}

}  // namespace

std::vector<PlacedBuilding> place_buildings(std::span<const Building> buildings,
                                            std::span<const RoadLevel* const> levels, const Outline& area,
                                            const Ground& ground, const Photo& photo, int threads, Findings& findings) {
  std::vector<Outlined> outlined(buildings.size());
  parallel_for(buildings.size(), threads, [&](std::size_t i) { outlined[i] = outline_of(buildings[i], levels, area); });
  cut_apart(outlined);
  parallel_for(buildings.size(), threads, [&](std::size_t i) {
    if (outlined[i].stands) dress(buildings[i], ground, photo, outlined[i].building);
  });
  std::vector<PlacedBuilding> placed;
  for (Outlined& at : outlined) {
    findings.insert(findings.end(), at.findings.begin(), at.findings.end());
    if (at.stands) placed.push_back(std::move(at.building));
  }
  return placed;
}

TriMesh building_mesh(std::span<const PlacedBuilding* const> buildings, Vec3 origin) {
  TriMesh mesh{.kind = MeshKind::building};
  FaceBuilder faces(mesh, origin);
  std::uint32_t feature = 0;
  for (const PlacedBuilding* building : buildings) {
    add_walls(*building, faces);
    add_roof(*building, faces);
    mesh.features.resize(mesh.positions.size(), feature++);
  }
  faces.finish();
  return mesh;
}

}  // namespace orthodrive::scene
