// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/buildings/building_mesh.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "orthodrive/core/random.hpp"
#include "orthodrive/scene/buildings/eaves.hpp"
#include "orthodrive/scene/look/facade_picture.hpp"
#include "orthodrive/scene/look/mesh_materials.hpp"
#include "orthodrive/scene/look/surface_texture.hpp"
#include "orthodrive/scene/structures/structures.hpp"

namespace orthodrive::scene {
namespace {

constexpr double bay_m = 3.2;      // distance of windows
constexpr double min_bay_m = 1.6;  // shorter walls have none
constexpr double proud_m = 0.03;   // of doors before walls
constexpr double chimney_m = 1.1, chimney_along_m = 0.7, chimney_across_m = 0.45, chimney_sunk_m = 0.6;
constexpr LinearColor soffit_wood = {0.30F, 0.28F, 0.25F}, stove_steel = {0.30F, 0.31F, 0.32F},
                      brick = {0.25F, 0.09F, 0.06F};

/// Where a face shows which part of a picture: (u, v) of a corner are `offset` and its distances from `from` to the
/// right and down, over the size.
struct PictureAt {
  Vec3 from;
  Vec2 size_m{surface_texture_m, surface_texture_m};
  Vec2 offset;
};

/// Adds flat shaded faces to the mesh. Corners of faces of one building that look the same way share their vertices.
class FaceBuilder {
 public:
  FaceBuilder(TriMesh& mesh, Vec3 origin) : mesh_(mesh), origin_(origin) {}

  /// Of the faces from here on.
  void begin_building() { known_.clear(); }
  void set_color(const LinearColor& color) { color_ = mesh_color(color), known_.clear(); }

  /// A face of corners in one plane, counter-clockwise from outside, as a fan.
  void add(SurfaceMaterial material, std::span<const Vec3> corners, const PictureAt& picture) {
    add(material, corners, picture, normal_of(corners));
  }
  void add(SurfaceMaterial material, std::span<const Vec3> corners, const PictureAt& picture, const Vec3& n) {
    const double flat = std::hypot(n.x, n.y);
    const Vec3 right = flat > 1e-6 ? Vec3{-n.y / flat, n.x / flat, 0.0} : Vec3{1.0, 0.0, 0.0};
    const Vec3 up = cross(n, right);
    std::vector<std::uint32_t> face;
    for (const Vec3& p : corners) {
      const Vec3 d = p - picture.from;
      const auto f = [](double v) { return static_cast<float>(v); };
      face.push_back(vertex(material, p, n,
                            {f(picture.offset.x + (d.x * right.x + d.y * right.y + d.z * right.z) / picture.size_m.x),
                             f(picture.offset.y - (d.x * up.x + d.y * up.y + d.z * up.z) / picture.size_m.y)}));
    }
    for (std::size_t k = 2; k < face.size(); ++k)
      if (face[0] != face[k - 1] && face[k - 1] != face[k] && face[k] != face[0])
        parts_.add(material, {face[0], face[k - 1], face[k]});
  }
  void finish() { parts_.finish(mesh_); }

 private:
  using Key = std::array<std::int64_t, 7>;

  std::uint32_t vertex(SurfaceMaterial material, const Vec3& p, const Vec3& n, std::array<float, 2> uv) {
    constexpr double normal_steps = 1024.0;  // more than the file has
    const auto f = [](double v) { return static_cast<float>(v); };
    const auto steps = [](double v, double a_unit) { return std::llround(v * a_unit); };
    const Vec3 local = p - origin_;
    const Key key = {static_cast<std::int64_t>(material),
                     steps(local.x, 4096.0),
                     steps(local.y, 4096.0),
                     steps(local.z, 4096.0),
                     steps(n.x, normal_steps),
                     steps(n.y, normal_steps),
                     steps(n.z, normal_steps)};
    for (std::uint32_t raised : known_[key])
      if (std::abs(mesh_.tile_uv[raised][0] - uv[0]) < 1e-3F && std::abs(mesh_.tile_uv[raised][1] - uv[1]) < 1e-3F)
        return raised;
    const auto raised = static_cast<std::uint32_t>(mesh_.positions.size());
    known_[key].push_back(raised);
    mesh_.positions.push_back({f(local.x), f(local.y), f(local.z)});
    mesh_.normals.push_back({f(n.x), f(n.y), f(n.z)});
    mesh_.tile_uv.push_back(uv);
    mesh_.colors.push_back(color_);
    return raised;
  }
  static Vec3 normal_of(std::span<const Vec3> c) {
    const Vec3 n = cross(c[1] - c[0], c[2] - c[0]);
    const double length = std::hypot(n.x, n.y, n.z);
    return length > 0.0 ? n * (1.0 / length) : Vec3{0.0, 0.0, 1.0};
  }
  TriMesh& mesh_;
  Vec3 origin_;
  std::array<std::uint16_t, 4> color_{};
  std::map<Key, std::vector<std::uint32_t>> known_;
  PartedTriangles parts_;
};

Vec3 raised(Vec2 p, double z) { return {p.x, p.y, z}; }

/// A wall from one corner of the footprint to the next.
struct Wall {
  Vec2 a, b;  ///< site CRS, the building to the left
  [[nodiscard]] double length_m() const { return distance(a, b); }
  [[nodiscard]] std::array<Vec3, 4> face(double low_z, double high_z) const {
    return {raised(a, low_z), raised(b, low_z), raised(b, high_z), raised(a, high_z)};
  }
  /// A panel before it.
  [[nodiscard]] std::array<Vec3, 4> panel(double from_m, double to_m, double low_z, double high_z) const {
    const Vec2 u = normalized(b - a), out = left_normal(u) * -proud_m;
    const Vec2 p = a + u * from_m + out, q = a + u * to_m + out;
    return {raised(p, low_z), raised(q, low_z), raised(q, high_z), raised(p, high_z)};
  }
};

Wall wall_of(const PlacedBuilding& building, const Ring& ring, std::size_t edge) {
  return {building.middle + ring[edge], building.middle + ring[(edge + 1) % ring.size()]};
}

double storey_m(const PlacedBuilding& building) {
  return (building.eaves_z_m - building.parapet_m - building.base_z_m) / building.storeys;
}

/// What a wall shows; nothing: no windows.
std::optional<SurfaceMaterial> windows_on(const PlacedBuilding& building, double length_m) {
  constexpr double balconies_from_m = 9.0, sheet_m2 = 800.0;
  if (length_m < min_bay_m) return std::nullopt;
  switch (building.look) {
    case BuildingLook::house:
      return SurfaceMaterial::facade;
    case BuildingLook::flats:
      return length_m >= balconies_from_m ? SurfaceMaterial::balconies : SurfaceMaterial::facade;
    case BuildingLook::shop:
      if (area_m2(building.footprint) > sheet_m2) return std::nullopt;
      return SurfaceMaterial::facade;
    default:
      return std::nullopt;
  }
}

void add_wall(const PlacedBuilding& building, const Wall& wall, FaceBuilder& faces) {
  const double length_m = wall.length_m();
  const auto windows = windows_on(building, length_m);
  PictureAt picture{raised(wall.a, building.base_z_m)};
  if (windows) {
    const double bays = std::max(1.0, std::round(length_m / bay_m));
    picture.size_m = {facade_bays * length_m / bays, facade_bays * storey_m(building)};
    // Another of the picture's columns and rows for each building.
    picture.offset = Vec2{static_cast<double>(building.seed % facade_bays),
                          static_cast<double>(building.seed / facade_bays % facade_bays)} *
                     (1.0 / facade_bays);
  }
  faces.add(windows.value_or(building.wall_material), wall.face(building.foot_z_m, building.eaves_z_m), picture);
}

/// Shows a part of the picture of openings on a panel of a wall.
void add_opening(const Wall& wall, const OpeningPicture& shown, double middle_m, double width_m, double low_z,
                 double high_z, FaceBuilder& faces) {
  const auto panel = wall.panel(middle_m - 0.5 * width_m, middle_m + 0.5 * width_m, low_z, high_z);
  const Vec2 size = shown.to - shown.from;
  faces.add(SurfaceMaterial::openings, panel,
            {panel[3], {width_m / size.x, (high_z - low_z) / size.y}, {shown.from.x, shown.from.y}});
}

/// The middle of the bay that is nearest to a share of a wall.
double bay_middle_m(double length_m, double share) {
  const double bays = std::max(1.0, std::round(length_m / bay_m));
  return (std::clamp(std::floor(share * bays), 0.0, bays - 1.0) + 0.5) * length_m / bays;
}

void add_doors(const PlacedBuilding& building, const Wall& wall, FaceBuilder& faces) {
  const double length_m = wall.length_m(), low_z = building.door_z_m;
  const double room_m = building.eaves_z_m - low_z;
  Random random(derive_seed(building.seed, 1));
  constexpr std::array<LinearColor, 5> paints = {{{0.55F, 0.55F, 0.52F},
                                                  {0.20F, 0.10F, 0.05F},
                                                  {0.08F, 0.14F, 0.10F},
                                                  {0.30F, 0.06F, 0.05F},
                                                  {0.12F, 0.16F, 0.22F}}};
  faces.set_color(paints[random.below(paints.size())]);
  const auto several = [&](const OpeningPicture& shown, double every_m, double width_m, double height_m) {
    const int count = std::max(1, static_cast<int>(length_m / every_m));
    if (length_m < width_m + 0.4 || room_m < height_m + 0.2) return;
    for (int k = 0; k < count; ++k)
      add_opening(wall, shown, length_m * (k + 0.5) / count, width_m, low_z, low_z + height_m, faces);
  };
  switch (building.look) {
    case BuildingLook::house:
      if (length_m < 2.4 || room_m < 2.4) return;
      add_opening(wall, door_picture(static_cast<int>(random.below(2))), bay_middle_m(length_m, random.uniform()), 1.5,
                  low_z, low_z + 2.3, faces);
      return;
    case BuildingLook::flats: {
      constexpr double entrance_every_m = 16.0;
      const int count = std::max(1, static_cast<int>(std::lround(length_m / entrance_every_m)));
      if (length_m < 3.0) return;
      for (int k = 0; k < count; ++k)
        add_opening(wall, entrance_picture, bay_middle_m(length_m, (k + 0.5) / count), 2.2, low_z, low_z + 2.5, faces);
      return;
    }
    case BuildingLook::hall:
      return several(gate_picture, 14.0, std::min(4.0, 0.8 * length_m), std::min(4.2, 0.75 * room_m));
    case BuildingLook::garage: {
      const double gates = std::floor((length_m - 0.2) / 2.9);
      if (gates < 1.0 || room_m < 2.2) return;
      return add_opening(wall, garage_picture(static_cast<int>(gates)), 0.5 * length_m,
                         gates * length_m / (gates + 0.1), low_z, low_z + std::min(2.3, 0.9 * room_m), faces);
    }
    case BuildingLook::shop: {
      const double front_m = length_m - 0.6;
      if (front_m < 2.0 || room_m < 2.8) return;
      faces.set_color({0.5F, 0.5F, 0.5F});
      return add_opening(wall, shop_picture(std::max(1, static_cast<int>(std::lround(front_m / 6.0)))), 0.5 * length_m,
                         front_m, low_z, low_z + std::min(3.2, 0.8 * room_m), faces);
    }
    case BuildingLook::church:
      return several(door_picture(1), 1e9, 2.4, 3.2);
    case BuildingLook::plain:
      return;
  }
}

/// Ribbons of windows below the eaves of halls, tall windows of churches.
void add_high_windows(const PlacedBuilding& building, const Wall& wall, FaceBuilder& faces) {
  const double length_m = wall.length_m(), room_m = building.eaves_z_m - building.base_z_m;
  constexpr double least_m = 6.0;
  if (length_m < least_m || room_m < 4.5) return;
  faces.set_color({0.5F, 0.5F, 0.5F});
  if (building.look == BuildingLook::hall) {
    const double high_z = building.eaves_z_m - building.parapet_m - 0.7;
    add_opening(wall, ribbon_picture(static_cast<int>(std::ceil(length_m / 8.0))), 0.5 * length_m, length_m - 1.6,
                high_z - 1.2, high_z, faces);
  } else if (building.look == BuildingLook::church) {
    const int count = static_cast<int>(length_m / 4.0);
    for (int k = 0; k < count; ++k)
      add_opening(wall, church_picture, length_m * (k + 0.5) / count, 1.4, building.base_z_m + 0.3 * room_m,
                  building.base_z_m + 0.9 * room_m, faces);
  }
}

void add_openings(const PlacedBuilding& building, FaceBuilder& faces) {
  if (building.hovers || building.look == BuildingLook::plain) return;
  const Ring& ring = building.footprint.outer;
  if (building.look == BuildingLook::hall || building.look == BuildingLook::church)
    for (std::size_t i = 0; i < ring.size(); ++i)
      if (i != building.front || building.look == BuildingLook::hall)
        add_high_windows(building, wall_of(building, ring, i), faces);
  add_doors(building, wall_of(building, ring, building.front), faces);
}

void add_walls(const PlacedBuilding& building, BuildingDetail detail, FaceBuilder& faces) {
  faces.set_color(building.wall_color);
  const auto each = [&](const Ring& ring, const auto& use) {
    for (std::size_t i = 0; i < ring.size(); ++i) use(wall_of(building, ring, i));
  };
  const auto all = [&](const auto& use) {
    each(building.footprint.outer, use);
    for (const Ring& hole : building.footprint.holes) each(hole, use);
  };
  all([&](const Wall& wall) { add_wall(building, wall, faces); });
  if (building.parapet_m > 0.0 && detail == BuildingDetail::whole)
    all([&](const Wall& wall) {
      faces.add(building.wall_material,
                Wall{wall.b, wall.a}.face(building.eaves_z_m - building.parapet_m, building.eaves_z_m),
                {raised(wall.b, building.eaves_z_m)});
    });
}

void add_roof(const PlacedBuilding& building, BuildingDetail detail, FaceBuilder& faces) {
  const bool whole = detail == BuildingDetail::whole;
  const Vec3 eaves = raised(building.middle, building.eaves_z_m - (whole ? building.parapet_m : 0.0));
  const auto add = [&](const std::array<Vec3, 3>& t, SurfaceMaterial material, const Vec3& from) {
    const std::array<Vec3, 3> corners = {from + t[0], from + t[1], from + t[2]};
    faces.add(material, corners, {from});
  };
  for (const auto& gable : building.roof.gables) add(gable, building.wall_material, eaves);
  Eaves over{building.roof.slopes, {}};
  if (whole && !building.eaves_m.empty()) over = with_eaves(building.roof, building.footprint.outer, building.eaves_m);
  faces.set_color(building.roof_color);
  for (const auto& slope : over.slopes) add(slope, building.roof_material, eaves);
  faces.set_color(soffit_wood);
  for (const auto& t : over.soffits) {
    const std::array<Vec3, 3> corners = {eaves + t[0], eaves + t[1], eaves + t[2]};
    faces.add(SurfaceMaterial::concrete, corners, {eaves}, {0.0, 0.0, -1.0});
  }
  if (!building.hovers) return;
  faces.set_color(building.wall_color);
  const Vec3 foot = raised(building.middle, building.foot_z_m);
  for (const auto& t : make_roof(building.footprint, {}).slopes)
    add({t[0], t[2], t[1]}, SurfaceMaterial::concrete, foot);
}

/// Square posts with one normal a corner.
void add_posts(const PlacedBuilding& building, FaceBuilder& faces) {
  constexpr double half_m = 0.1;
  faces.set_color(stove_steel);
  for (const Vec2 post : building.posts) {
    const Vec2 p = building.middle + post;
    const std::array<Vec2, 4> c = {Vec2{-half_m, -half_m}, {half_m, -half_m}, {half_m, half_m}, {-half_m, half_m}};
    for (std::size_t k = 0; k < 4; ++k) {
      const std::array<Vec3, 4> side = {
          raised(p + c[k], building.base_z_m - 0.3), raised(p + c[(k + 1) % 4], building.base_z_m - 0.3),
          raised(p + c[(k + 1) % 4], building.foot_z_m + 0.05), raised(p + c[k], building.foot_z_m + 0.05)};
      faces.add(SurfaceMaterial::concrete, side, {side[0]});
    }
  }
}

TriMesh chimney_mesh() {
  std::vector<StructureFace> faces;
  const double x = 0.5 * chimney_along_m, y = 0.5 * chimney_across_m;
  const std::array<Vec2, 4> c = {Vec2{-x, -y}, {x, -y}, {x, y}, {-x, y}};
  for (std::size_t k = 0; k < 4; ++k) {
    const Vec2 a = c[k], b = c[(k + 1) % 4];
    faces.push_back({.corners = {raised(a, -chimney_sunk_m), raised(b, -chimney_sunk_m), raised(b, chimney_m),
                                 raised(a, chimney_m)},
                     .color = brick});
  }
  faces.push_back(
      {.corners = {raised(c[0], chimney_m), raised(c[1], chimney_m), raised(c[2], chimney_m), raised(c[3], chimney_m)},
       .color = {0.05F, 0.05F, 0.05F}});
  TriMesh mesh{.kind = MeshKind::building};
  add_faces(faces, {}, {}, mesh);
  add_material(SurfaceMaterial::concrete, mesh);
  return mesh;
}

}  // namespace

TriMesh building_mesh(std::span<const PlacedBuilding* const> buildings, Vec3 origin, BuildingDetail detail) {
  TriMesh mesh{.kind = MeshKind::building};
  FaceBuilder faces(mesh, origin);
  std::uint32_t feature = 0;
  for (const PlacedBuilding* building : buildings) {
    faces.begin_building();
    add_walls(*building, detail, faces);
    add_roof(*building, detail, faces);
    if (detail == BuildingDetail::whole) {
      add_openings(*building, faces);
      add_posts(*building, faces);
    }
    mesh.features.resize(mesh.positions.size(), feature++);
  }
  faces.finish();
  return mesh;
}

InstancedMesh chimney_instances(std::span<const PlacedBuilding* const> buildings, Vec3 origin) {
  const auto f = [](double v) { return static_cast<float>(v); };
  InstancedMesh result{chimney_mesh(), {}};
  for (const PlacedBuilding* building : buildings) {
    if (!building->chimney) continue;
    const Vec3 foot = *building->chimney - origin;
    const Vec3 along = building->roof.ridge[1] - building->roof.ridge[0];
    result.instances.push_back(
        {.position = {f(foot.x), f(foot.y), f(foot.z)}, .yaw_rad = f(std::atan2(along.y, along.x))});
  }
  return result;
}

double detail_reach_m(const PlacedBuilding& building) {
  double reach_m = std::max(building.parapet_m, building.chimney ? chimney_m : 0.0);
  for (const double m : building.eaves_m) reach_m = std::max(reach_m, m);
  return reach_m;
}

}  // namespace orthodrive::scene
