// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/objects/line_objects.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "orthodrive/scene/look/mesh_materials.hpp"
#include "orthodrive/scene/plants/tree_shapes.hpp"

namespace orthodrive::scene {
namespace {

constexpr double clearance_m = 0.1, finest_m = 0.25, barrier_foot_m = 0.4;

/// Seen along the line: places to the right of it and over the ground, from the right foot over the top to the left.
struct Profile {
  std::array<Vec2, 4> corners;
  LinearColor color{};
  SurfaceMaterial material = SurfaceMaterial::concrete;
};

Profile box(double left_m, double right_m, double low_m, double high_m, const LinearColor& color,
            SurfaceMaterial material) {
  return {{Vec2{right_m, low_m}, {right_m, high_m}, {left_m, high_m}, {left_m, low_m}}, color, material};
}

/// Directions to the right of a line's points, as long as a mitre needs.
std::vector<Vec2> rights_of(const Polyline& line) {
  std::vector<Vec2> rights;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const auto right = [&](std::size_t k) { return left_normal(normalized(line[k + 1] - line[k])) * -1.0; };
    rights.push_back(mitre(right(i == 0 ? 0 : i - 1), right(std::min(i, line.size() - 2))));
  }
  return rights;
}

/// The largest part of them along the line.
double lean_of(const Polyline& line) {
  const std::vector<Vec2> rights = rights_of(line);
  double lean = 0.0;
  for (std::size_t i = 1; i < line.size(); ++i) {
    const Vec2 along = normalized(line[i] - line[i - 1]);
    for (const Vec2 right : {rights[i - 1], rights[i]}) lean = std::max(lean, std::abs(dot(right, along)));
  }
  return lean;
}

/// Parts of a line in a row, each no longer than the step, where a disc around its ends and all between is free.
class FreeRuns {
 public:
  struct Options {
    double half_width_m = 0.0, step_m = 4.0;
    double room_m = std::numeric_limits<double>::infinity();  ///< over the ground, below decks
  };
  FreeRuns(const FreeSpace& space, const Ground& ground, const Options& options)
      : space_(space), ground_(ground), options_(options) {}

  [[nodiscard]] std::vector<Polyline> of(const Polyline& line) {
    runs_.clear();
    is_open_ = false;
    if (line.size() < 2) return {};
    lean_ = lean_of(line);
    for (std::size_t i = 1; i < line.size(); ++i) {
      const double length_m = distance(line[i - 1], line[i]);
      if (!(length_m > 1e-3) || !(length_m < longest_m)) continue;
      const int parts = static_cast<int>(std::ceil(length_m / options_.step_m));
      const auto at = [&](int k) { return line[i - 1] + (line[i] - line[i - 1]) * (static_cast<double>(k) / parts); };
      for (int k = 0; k < parts; ++k) add(at(k), at(k + 1));
    }
    return std::move(runs_);
  }

 private:
  static constexpr double longest_m = 5000.0;  // a longer piece is a mistake

  /// The whole piece where it is free, else its halves.
  void add(Vec2 a, Vec2 b) {
    const Vec2 middle = (a + b) * 0.5;
    const double length_m = distance(a, b);
    const double half_m = options_.half_width_m;
    const double reach_m = std::hypot(0.5 * length_m + lean_ * half_m, half_m) + clearance_m;
    const double below_z_m = ground_.height_m(middle) + options_.room_m;
    if (space_.around(middle, reach_m, {.below_z_m = below_z_m}) >= reach_m) {
      if (!is_open_) runs_.push_back({a});
      runs_.back().push_back(b);
      is_open_ = true;
    } else if (length_m > 2.0 * finest_m) {
      add(a, middle);
      add(middle, b);
    } else {
      is_open_ = false;
    }
  }

  const FreeSpace& space_;
  const Ground& ground_;
  Options options_;
  std::vector<Polyline> runs_;
  bool is_open_ = false;
  double lean_ = 0.0;  ///< how far mitres reach along the line, over the half width
};

void sweep(const Polyline& run, const Ground& ground, const Profile& profile, std::vector<StructureFace>& faces) {
  const std::vector<Vec2> rights = rights_of(run);
  const std::size_t count = profile.corners.size();
  std::vector<std::vector<Vec3>> sections;
  for (std::size_t i = 0; i < run.size(); ++i) {
    const double z = ground.height_m(run[i]);
    auto& section = sections.emplace_back();
    for (const Vec2 c : profile.corners) {
      const Vec2 p = run[i] + rights[i] * c.x;
      section.push_back({p.x, p.y, z + c.y});
    }
  }
  const auto add = [&](const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
    faces.push_back({.corners = {a, b, c, d}, .color = profile.color, .material = profile.material});
  };
  for (std::size_t i = 1; i < sections.size(); ++i)
    for (std::size_t k = 0; k + 1 < count; ++k)
      add(sections[i - 1][k], sections[i][k], sections[i][k + 1], sections[i - 1][k + 1]);
  const auto &first = sections.front(), &last = sections.back();
  add(first[0], first[1], first[count - 2], first[count - 1]);
  add(last[count - 1], last[count - 2], last[1], last[0]);
}

Profile barrier_profile(const MapBarrier& barrier) {
  const auto height = [&](double otherwise) { return barrier.height_m > 0.0 ? barrier.height_m : otherwise; };
  switch (barrier.kind) {
    case BarrierKind::hedge:
      return box(-0.4, 0.4, -barrier_foot_m, height(1.3), mean_foliage, SurfaceMaterial::foliage);
    case BarrierKind::fence:
      return box(-0.03, 0.03, -barrier_foot_m, height(1.2), {0.16F, 0.12F, 0.08F}, SurfaceMaterial::concrete);
    case BarrierKind::guard_rail:
      return box(-0.04, 0.04, 0.44, 0.75, {0.30F, 0.31F, 0.32F}, SurfaceMaterial::concrete);
    case BarrierKind::wall:
      break;
  }
  return box(-0.15, 0.15, -barrier_foot_m, height(1.6), {0.30F, 0.28F, 0.26F}, SurfaceMaterial::concrete);
}

TriMesh lamp_mesh() {
  constexpr LinearColor steel = {0.22F, 0.23F, 0.24F};
  constexpr double pole_m = 6.0, pole_half_m = 0.06, arm_m = 0.95, arm_half_m = 0.05, arm_height_m = 0.1;
  std::vector<StructureFace> faces;
  const auto block = [&](double west, double east, double half, double low, double high) {
    const std::array<Vec2, 4> c = {Vec2{west, -half}, Vec2{east, -half}, Vec2{east, half}, Vec2{west, half}};
    const auto at = [&](std::size_t k, double z) { return Vec3{c[k % 4].x, c[k % 4].y, z}; };
    for (std::size_t k = 0; k < 4; ++k)
      faces.push_back({.corners = {at(k, low), at(k + 1, low), at(k + 1, high), at(k, high)}, .color = steel});
    faces.push_back({.corners = {at(0, high), at(1, high), at(2, high), at(3, high)}, .color = steel});
    faces.push_back({.corners = {at(3, low), at(2, low), at(1, low), at(0, low)}, .color = steel});
  };
  block(-pole_half_m, pole_half_m, pole_half_m, -barrier_foot_m, pole_m);
  block(pole_half_m, arm_m, arm_half_m, pole_m - arm_height_m, pole_m);
  TriMesh mesh{.kind = MeshKind::lamp};
  add_faces(faces, {}, {}, mesh);
  add_material(SurfaceMaterial::concrete, mesh);
  return mesh;
}

}  // namespace

std::vector<StructureFace> barrier_faces(std::span<const MapBarrier> barriers, const FreeSpace& space,
                                         const Ground& ground) {
  std::vector<StructureFace> faces;
  for (const MapBarrier& barrier : barriers) {
    const Profile profile = barrier_profile(barrier);
    FreeRuns runs(space, ground, {.half_width_m = profile.corners.front().x});
    for (const Polyline& run : runs.of(barrier.line)) sweep(run, ground, profile, faces);
  }
  return faces;
}

std::vector<StructureFace> track_faces(std::span<const Polyline> tracks, const FreeSpace& space, const Ground& ground) {
  constexpr double top_m = 1.3, foot_half_m = 1.8, height_m = 0.3, gauge_half_m = 0.5 * 1.435, rail_m = 0.07;
  constexpr LinearColor stones = {0.16F, 0.145F, 0.13F}, steel = {0.14F, 0.10F, 0.08F};
  const Profile ballast{
      {Vec2{foot_half_m, -barrier_foot_m}, {top_m, height_m}, {-top_m, height_m}, {-foot_half_m, -barrier_foot_m}},
      stones,
      SurfaceMaterial::gravel};
  std::vector<StructureFace> faces;
  FreeRuns runs(space, ground, {.half_width_m = foot_half_m, .step_m = 6.0, .room_m = 5.0});
  for (const Polyline& track : tracks) {
    for (const Polyline& run : runs.of(track)) {
      sweep(run, ground, ballast, faces);
      for (const double side : {-1.0, 1.0}) {
        const double near = side * gauge_half_m, far = side * (gauge_half_m + rail_m);
        sweep(
            run, ground,
            box(std::min(near, far), std::max(near, far), height_m, height_m + 0.17, steel, SurfaceMaterial::concrete),
            faces);
      }
    }
  }
  return faces;
}

std::vector<PlacedLamp> place_lamps(std::span<const Vec2> lamps, const RoadLevel& roads, const FreeSpace& space,
                                    const Ground& ground) {
  constexpr double room_m = 0.3, turned_m = 0.25;
  std::vector<PlacedLamp> placed;
  for (const Vec2 p : lamps) {
    if (space.around(p, room_m) < room_m) continue;
    // The way to the nearest border is against the gradient of its distance.
    const auto away = [&](double x, double y) { return roads.outline().nearest({p.x + x, p.y + y}).distance_m; };
    const Vec2 towards{away(-turned_m, 0.0) - away(turned_m, 0.0), away(0.0, -turned_m) - away(0.0, turned_m)};
    const bool is_known = std::isfinite(towards.x) && std::isfinite(towards.y);
    placed.push_back({{p.x, p.y, ground.height_m(p)}, is_known ? std::atan2(towards.y, towards.x) : 0.0});
  }
  return placed;
}

InstancedMesh lamp_instances(std::span<const PlacedLamp* const> lamps, Vec3 origin) {
  const auto f = [](double v) { return static_cast<float>(v); };
  InstancedMesh result{lamp_mesh(), {}};
  for (const PlacedLamp* lamp : lamps) {
    const Vec3 at = lamp->foot - origin;
    result.instances.push_back({.position = {f(at.x), f(at.y), f(at.z)}, .yaw_rad = f(lamp->yaw_rad)});
  }
  return result;
}

}  // namespace orthodrive::scene
