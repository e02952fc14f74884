// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/objects/map_objects.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>

#include "orthodrive/geo/spatial_index.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace orthodrive::scene {
namespace {

constexpr LinearColor steel = {0.30F, 0.31F, 0.32F}, dark = {0.03F, 0.03F, 0.03F}, red = {0.45F, 0.01F, 0.01F},
                      white = {0.75F, 0.75F, 0.75F}, yellow = {0.7F, 0.45F, 0.02F}, green = {0.02F, 0.2F, 0.06F},
                      blue = {0.01F, 0.07F, 0.35F}, wood = {0.16F, 0.09F, 0.05F}, grey = {0.2F, 0.2F, 0.2F},
                      brick = {0.28F, 0.11F, 0.07F}, glass = {0.35F, 0.42F, 0.45F};
constexpr double foot_m = 0.4, beside_m = 0.7, furthest_beside_m = 3.0, beside_step_m = 0.5;

/// Where an object stands; `ahead`: where it looks.
struct Stand {
  Vec3 foot;
  Vec2 ahead{1.0, 0.0};
};

/// Bodies in the frame of a stand: x ahead, y to the left, z up.
class Bodies {
 public:
  Bodies(const Stand& stand, std::vector<StructureFace>& faces) : stand_(stand), faces_(faces) {}

  struct Extent {
    double from, to;
  };
  void box(Extent x, Extent y, Extent z, const LinearColor& color) {
    const std::array<Vec2, 4> c = {Vec2{x.from, y.from}, {x.to, y.from}, {x.to, y.to}, {x.from, y.to}};
    for (std::size_t i = 0; i < 4; ++i) {
      const Vec2 a = c[i], b = c[(i + 1) % 4];
      face({at(a, z.from), at(b, z.from), at(b, z.to), at(a, z.to)}, color);
    }
    face({at(c[0], z.to), at(c[1], z.to), at(c[2], z.to), at(c[3], z.to)}, color);
    face({at(c[3], z.from), at(c[2], z.from), at(c[1], z.from), at(c[0], z.from)}, color);
  }
  void pole(double radius_m, double top_m, const LinearColor& color) {
    box({-radius_m, radius_m}, {-radius_m, radius_m}, {-foot_m, top_m}, color);
  }
  /// A bar with a square level section.
  void strut(const Vec3& from, const Vec3& to, double half_m, const LinearColor& color) {
    if (from.z > to.z) return strut(to, from, half_m, color);
    constexpr std::array<Vec2, 4> square = {Vec2{-1.0, -1.0}, {1.0, -1.0}, {1.0, 1.0}, {-1.0, 1.0}};
    for (std::size_t i = 0; i < 4; ++i) {
      const Vec2 a = square[i] * half_m, b = square[(i + 1) % 4] * half_m;
      face({at(Vec2{from.x, from.y} + a, from.z), at(Vec2{from.x, from.y} + b, from.z), at(Vec2{to.x, to.y} + b, to.z),
            at(Vec2{to.x, to.y} + a, to.z)},
           color);
    }
  }
  /// A cone's part of eight sides, closed above.
  void cone(double low_radius_m, double high_radius_m, Extent z, const LinearColor& color) {
    constexpr int sides = 8;
    const auto on = [&](int k, double radius_m, double height_m) {
      const double angle = 2.0 * std::numbers::pi * k / sides;
      return at({radius_m * std::cos(angle), radius_m * std::sin(angle)}, height_m);
    };
    for (int k = 0; k < sides; ++k) {
      face({on(k, low_radius_m, z.from), on(k + 1, low_radius_m, z.from), on(k + 1, high_radius_m, z.to),
            on(k, high_radius_m, z.to)},
           color);
      face({at({}, z.to), at({}, z.to), on(k, high_radius_m, z.to), on(k + 1, high_radius_m, z.to)}, color);
    }
  }
  /// A flat polygon that looks ahead, and its grey back. `first`: angle of a corner from the left, towards above.
  void plate(double x_m, double z_m, double radius_m, int corners, double first, const LinearColor& color) {
    const auto on = [&](int k) {
      const double angle = first + 2.0 * std::numbers::pi * k / corners;
      return at({x_m, radius_m * std::cos(angle)}, z_m + radius_m * std::sin(angle));
    };
    const Vec3 middle = at({x_m, 0.0}, z_m);
    for (int k = 0; k < corners; ++k) {
      face({middle, middle, on(k), on(k + 1)}, color);
      face({middle, middle, on(k + 1), on(k)}, grey);
    }
  }

 private:
  [[nodiscard]] Vec3 at(Vec2 p, double z) const {
    const Vec2 left = left_normal(stand_.ahead);
    return {stand_.foot.x + stand_.ahead.x * p.x + left.x * p.y, stand_.foot.y + stand_.ahead.y * p.x + left.y * p.y,
            stand_.foot.z + z};
  }
  void face(const std::array<Vec3, 4>& corners, const LinearColor& color) {
    faces_.push_back({.corners = corners, .color = color});
  }
  const Stand& stand_;
  std::vector<StructureFace>& faces_;
};

bool is_of_traffic(ObjectKind kind) { return kind <= ObjectKind::bus_shelter; }
bool is_large(ObjectKind kind) { return kind == ObjectKind::power_tower || kind >= ObjectKind::tower; }

double radius_of(const MapObject& object) {
  if (object.radius_m > 0.0) return object.radius_m;
  switch (object.kind) {
    case ObjectKind::tower:
      return 3.0;
    case ObjectKind::chimney:
      return 1.5;
    case ObjectKind::storage_tank:
      return 5.0;
    default:
      return 0.3;
  }
}

/// Of the disc that an object takes up on the ground and overhead where cars drive.
double room_m(const MapObject& object) {
  switch (object.kind) {
    case ObjectKind::bus_shelter:
      return 2.1;
    case ObjectKind::power_tower:
      return 2.9;
    case ObjectKind::power_pole:
      return 1.0;
    case ObjectKind::bench:
    case ObjectKind::recycling:
      return 1.1;
    case ObjectKind::gate:
    case ObjectKind::lift_gate:
      return 1.6;
    case ObjectKind::tower:
    case ObjectKind::mast:
    case ObjectKind::chimney:
    case ObjectKind::storage_tank:
      return 1.05 * radius_of(object);
    default:
      return 0.6;
  }
}

void draw_sign(ObjectKind kind, Bodies& bodies) {
  constexpr double pi = std::numbers::pi, radius_m = 0.35, front_m = 0.05, gap_m = 0.006;
  const double z = kind == ObjectKind::city_sign ? 2.2 : 2.5;
  bodies.pole(0.04, z + 0.3, steel);
  const auto two = [&](int corners, double first, const LinearColor& rim, const LinearColor& inner, double share) {
    bodies.plate(front_m, z, radius_m, corners, first, rim);
    bodies.plate(front_m + gap_m, z, share * radius_m, corners, first, inner);
  };
  switch (kind) {
    case ObjectKind::stop_sign:
      return two(8, pi / 8, white, red, 0.93);
    case ObjectKind::give_way_sign:
      return two(3, -0.5 * pi, red, white, 0.6);
    case ObjectKind::warning_sign:
      return two(3, 0.5 * pi, red, white, 0.6);
    case ObjectKind::speed_sign:
      return two(16, 0.0, red, white, 0.75);
    case ObjectKind::city_sign:
      return bodies.box({front_m, front_m + 0.03}, {-0.5, 0.5}, {z - 0.33, z + 0.33}, yellow);
    default:
      return bodies.box({front_m, front_m + 0.03}, {-0.3, 0.3}, {z - 0.3, z + 0.3}, blue);
  }
}

void draw_signals(Bodies& bodies) {
  bodies.pole(0.07, 3.4, steel);
  bodies.box({0.05, 0.3}, {-0.17, 0.17}, {2.4, 3.4}, dark);
  constexpr std::array<LinearColor, 3> lights = {red, yellow, green};
  for (std::size_t k = 0; k < 3; ++k)
    bodies.plate(0.31, 3.22 - 0.32 * static_cast<double>(k), 0.11, 12, 0.0, lights[k]);
}

void draw_bus_stop(bool has_shelter, Bodies& bodies) {
  if (!has_shelter) {
    bodies.pole(0.04, 2.9, steel);
    bodies.plate(0.05, 2.6, 0.25, 16, 0.0, yellow);
    bodies.plate(0.056, 2.6, 0.18, 16, 0.0, green);
    return;
  }
  for (const double side : {-1.5, 1.5})
    for (const double along : {-0.6, 0.6})
      bodies.box({along - 0.04, along + 0.04}, {side - 0.04, side + 0.04}, {-foot_m, 2.3}, steel);
  bodies.box({-0.64, -0.6}, {-1.5, 1.5}, {0.2, 2.2}, glass);
  bodies.box({-0.75, 0.8}, {-1.65, 1.65}, {2.3, 2.42}, grey);
  bodies.box({-0.5, -0.15}, {-1.0, 1.0}, {0.42, 0.48}, wood);
}

void draw_tower(double height_m, Bodies& bodies) {
  constexpr double low_m = 1.6, high_m = 0.3, leg_m = 0.09, brace_m = 0.05, arms_m = 20.3, arm_m = 5.5;
  constexpr int storeys = 5;
  const auto half_at = [&](double z) { return low_m + (high_m - low_m) * z / height_m; };
  const auto corner = [&](int k, double z) {
    const double r = half_at(z);
    return Vec3{k == 0 || k == 3 ? r : -r, k < 2 ? r : -r, z};
  };
  for (int k = 0; k < 4; ++k) {
    bodies.strut(corner(k, -foot_m), corner(k, height_m), leg_m, steel);
    for (int i = 0; i < storeys; ++i) {
      const double low = height_m * i / storeys, high = height_m * (i + 1) / storeys;
      bodies.strut(corner(k, low), corner((k + 1) % 4, high), brace_m, steel);
      bodies.strut(corner((k + 1) % 4, low), corner(k, high), brace_m, steel);
    }
  }
  bodies.box({-0.1, 0.1}, {-arm_m, arm_m}, {arms_m - 0.2, arms_m}, steel);
  for (const double side : {-1.0, 1.0})  // what holds the arms
    for (const double along : {-1.0, 1.0})
      bodies.strut({0.0, side * arm_m, arms_m}, {along * half_at(arms_m + 1.5), side * half_at(arms_m), arms_m + 1.5},
                   brace_m, steel);
}

void draw(const MapObject& object, Bodies& bodies) {
  const double given_m = object.height_m, radius_m = radius_of(object);
  const auto height_m = [&](double usual_m) { return given_m > 0.0 ? given_m : usual_m; };
  switch (object.kind) {
    case ObjectKind::traffic_signals:
      return draw_signals(bodies);
    case ObjectKind::bus_stop:
    case ObjectKind::bus_shelter:
      return draw_bus_stop(object.kind == ObjectKind::bus_shelter, bodies);
    case ObjectKind::power_tower:
      return draw_tower(std::max(22.0, height_m(26.0)), bodies);
    case ObjectKind::power_pole:
      bodies.pole(0.13, 9.0, wood);
      return bodies.box({-0.06, 0.06}, {-0.9, 0.9}, {8.4, 8.55}, wood);
    case ObjectKind::bench:
      bodies.box({-0.2, 0.25}, {-0.8, 0.8}, {0.42, 0.47}, wood);
      bodies.box({-0.26, -0.2}, {-0.8, 0.8}, {0.5, 0.9}, wood);
      for (const double side : {-0.6, 0.6}) bodies.box({-0.2, 0.2}, {side - 0.04, side + 0.04}, {-foot_m, 0.42}, grey);
      return;
    case ObjectKind::waste_basket:
      return bodies.cone(0.2, 0.24, {-0.05, 0.85}, grey);
    case ObjectKind::post_box:
      bodies.pole(0.06, 0.8, steel);
      return bodies.box({-0.18, 0.18}, {-0.25, 0.25}, {0.8, 1.45}, yellow);
    case ObjectKind::telephone:
      return bodies.box({-0.42, 0.42}, {-0.42, 0.42}, {-foot_m, 2.3}, glass);
    case ObjectKind::recycling:
      return bodies.box({-0.6, 0.6}, {-0.75, 0.75}, {-foot_m, 1.6}, green);
    case ObjectKind::bollard:
      return bodies.cone(0.08, 0.07, {-foot_m, 0.9}, grey);
    case ObjectKind::gate:
    case ObjectKind::lift_gate: {
      const bool lifts = object.kind == ObjectKind::lift_gate;
      for (const double side : {-1.4, 1.4})
        bodies.box({-0.06, 0.06}, {side - 0.06, side + 0.06}, {-foot_m, 1.2}, steel);
      bodies.box({-0.03, 0.03}, {-1.4, 1.4}, {0.95, 1.05}, lifts ? red : steel);
      if (!lifts) bodies.box({-0.03, 0.03}, {-1.4, 1.4}, {0.4, 0.5}, steel);
      return;
    }
    case ObjectKind::fire_hydrant:
      return bodies.cone(0.13, 0.1, {-foot_m, 0.8}, red);
    case ObjectKind::tower:
      return bodies.cone(radius_m, 0.8 * radius_m, {-foot_m, height_m(25.0)}, grey);
    case ObjectKind::mast:
      return bodies.cone(0.3, 0.1, {-foot_m, height_m(25.0)}, steel);
    case ObjectKind::chimney:
      return bodies.cone(radius_m, 0.7 * radius_m, {-foot_m, height_m(30.0)}, brick);
    case ObjectKind::storage_tank:
      return bodies.cone(radius_m, radius_m, {-foot_m, height_m(8.0)}, white);
    default:
      return draw_sign(object.kind, bodies);
  }
}

// ---- places

class Places {
 public:
  Places(const ObjectPlaces& places, std::span<const MapPowerLine> lines) : places_(places) {
    for (const MapPowerLine& line : lines)
      for (std::size_t i = 0; i < line.line.size(); ++i) {
        const Vec2 before = line.line[i > 0 ? i - 1 : 0], after = line.line[std::min(i + 1, line.line.size() - 1)];
        line_points_.push_back({line.line[i], normalized(after - before)});
        boxes_.push_back({line.line[i].x, line.line[i].y, line.line[i].x, line.line[i].y});
      }
    index_ = SpatialIndex(boxes_);
  }

  [[nodiscard]] std::vector<Stand> of(const MapObject& object) const {
    roadquery::Cursor cursor;
    if (!std::isfinite(object.at.x + object.at.y)) return {};
    const auto hit = places_.query.find(object.at.x, object.at.y, std::nan(""), cursor, roadquery::hit_position);
    if (hit) return is_of_traffic(object.kind) ? beside_road(object, *hit) : std::vector<Stand>{};
    if (!is_free(object.at, room_m(object))) return {};
    return {{{object.at.x, object.at.y, places_.ground.height_m(object.at)}, looks(object)}};
  }

 private:
  [[nodiscard]] bool is_free(Vec2 p, double room) const { return places_.space.around(p, room) >= room; }

  /// Along its line for who carries wires; at the nearest road for others, against the gradient of its distance.
  [[nodiscard]] Vec2 looks(const MapObject& object) const {
    constexpr double turned_m = 0.25, same_place_m = 1.0;
    const Vec2 p = object.at;
    if (object.kind == ObjectKind::power_tower || object.kind == ObjectKind::power_pole) {
      for (const std::uint32_t i : index_.near(p, same_place_m))
        if (distance(line_points_[i].at, p) < same_place_m && length(line_points_[i].along) > 0.0)
          return line_points_[i].along;
      return {1.0, 0.0};
    }
    const auto away = [&](double x, double y) {
      return places_.roads.outline().nearest({p.x + x, p.y + y}).distance_m;
    };
    const Vec2 towards{away(-turned_m, 0.0) - away(turned_m, 0.0), away(0.0, -turned_m) - away(0.0, turned_m)};
    const bool is_known = std::isfinite(towards.x) && std::isfinite(towards.y) && length(towards) > 0.0;
    return is_known ? normalized(towards) : Vec2{1.0, 0.0};
  }

  /// Beside the lanes that lead along the road (`forwards`) or back, looking at who comes; nothing without such lanes.
  void add_beside(const MapObject& object, const roadquery::Road& road, double s, bool forwards,
                  std::vector<Stand>& stands) const {
    const bool drives_right = road.driving_side == roadquery::DrivingSide::right;
    const bool on_right = forwards == drives_right;
    const roadquery::LaneSection& section = roadquery::section_at(road, s);
    const auto drives = [](const roadquery::Lane& lane) { return lane.type == roadquery::LaneType::driving; };
    if (std::ranges::none_of(on_right ? section.right : section.left, drives)) return;
    const roadquery::Edges edges = roadquery::road_edges(road, s);
    const auto reference = roadquery::reference_point(road, s);
    const Vec2 along{std::cos(reference.hdg), std::sin(reference.hdg)};
    const double room = room_m(object);
    for (double off_m = std::max(beside_m, room + 0.05); off_m <= furthest_beside_m; off_m += beside_step_m) {
      const double t = on_right ? edges.right_t - off_m : edges.left_t + off_m;
      const Vec2 p = Vec2{reference.x, reference.y} + left_normal(along) * t;
      if (!is_free(p, room)) continue;
      const bool faces_road = object.kind == ObjectKind::bus_stop || object.kind == ObjectKind::bus_shelter;
      const Vec2 ahead = faces_road ? left_normal(along) * (on_right ? 1.0 : -1.0) : along * (forwards ? -1.0 : 1.0);
      stands.push_back({{p.x, p.y, places_.ground.height_m(p)}, ahead});
      return;
    }
  }

  [[nodiscard]] std::vector<Stand> beside_road(const MapObject& object, const roadquery::Hit& hit) const {
    std::vector<Stand> stands;
    const roadquery::RoadMap& map = places_.query.map();
    const roadquery::Road& road = map.roads[static_cast<std::size_t>(hit.road)];
    if (road.bridge || road.tunnel || road.layer != 0) return stands;
    if (road.junction < 0) {
      const bool forwards = hit.s > 0.5 * road.length;
      add_beside(object, road, hit.s, forwards, stands);
      if (object.kind == ObjectKind::traffic_signals || stands.empty())
        add_beside(object, road, hit.s, !forwards, stands);
      return stands;
    }
    if (object.kind != ObjectKind::traffic_signals) return stands;
    constexpr double before_m = 1.0;
    for (const roadquery::Road& arm : map.roads) {
      if (arm.junction >= 0 || arm.bridge || arm.tunnel || arm.length < 2.0 * before_m) continue;
      const auto leads_in = [&](const roadquery::RoadLink& link) {
        return link.kind == roadquery::LinkKind::junction && link.id == road.junction;
      };
      if (leads_in(arm.successor)) add_beside(object, arm, arm.length - before_m, true, stands);
      if (leads_in(arm.predecessor)) add_beside(object, arm, before_m, false, stands);
    }
    return stands;
  }

  struct LinePoint {
    Vec2 at, along;
  };
  const ObjectPlaces& places_;
  std::vector<LinePoint> line_points_;
  std::vector<Box2> boxes_;
  SpatialIndex index_;
};

// ---- wires

/// A prism of three sides along the catenary between two points.
void hang(const Vec3& a, const Vec3& b, std::vector<StructureFace>& faces) {
  constexpr double sag_share = 0.025, radius_m = 0.02, piece_m = 12.0;
  const double span_m = std::hypot(b.x - a.x, b.y - a.y), sag_m = sag_share * span_m;
  const double parameter_m = span_m * span_m / (8.0 * sag_m);  // of z = c cosh(x / c); the sag's leading term
  const int pieces = std::max(4, static_cast<int>(std::ceil(span_m / piece_m)));
  const Vec2 side = left_normal(normalized(Vec2{b.x - a.x, b.y - a.y})) * radius_m;
  const auto at = [&](int k) {
    const double share = static_cast<double>(k) / pieces, x = (share - 0.5) * span_m;
    const double below = parameter_m * (std::cosh(0.5 * span_m / parameter_m) - std::cosh(x / parameter_m));
    const Vec3 p = a + (b - a) * share;
    return std::array<Vec3, 3>{Vec3{p.x - side.x, p.y - side.y, p.z - below},
                               {p.x + side.x, p.y + side.y, p.z - below},
                               {p.x, p.y, p.z - below + 2.0 * radius_m}};
  };
  for (int k = 0; k < pieces; ++k) {
    const auto from = at(k), to = at(k + 1);
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t n = (i + 1) % 3;
      // Seen along the wire: right foot, left foot, ridge.
      faces.push_back({.corners = {from[i], from[n], to[n], to[i]}, .color = dark});
    }
  }
}

/// `ground_m`: at the points of the line, which may lie far outside of what is laid out.
void add_wires(const MapPowerLine& line, std::span<const double> ground_m, const FreeSpace& space,
               std::vector<StructureFace>& faces) {
  constexpr double longest_m = 1500.0;
  const double height_m = line.is_minor ? 8.6 : 20.0, arm_m = line.is_minor ? 0.8 : 5.0;
  const auto across_at = [&](std::size_t i) {
    const Vec2 before = line.line[i > 0 ? i - 1 : 0], after = line.line[std::min(i + 1, line.line.size() - 1)];
    return left_normal(normalized(after - before));
  };
  for (std::size_t i = 0; i + 1 < line.line.size(); ++i) {
    const Vec2 a = line.line[i], b = line.line[i + 1];
    const double span_m = distance(a, b);
    if (!(span_m > 1.0 && span_m < longest_m) || !space.is_in_area(a) || !space.is_in_area(b)) continue;
    const double a_z = ground_m[i] + height_m, b_z = ground_m[i + 1] + height_m;
    for (const double side : {-1.0, 0.0, 1.0}) {
      const Vec2 p = a + across_at(i) * (side * arm_m), q = b + across_at(i + 1) * (side * arm_m);
      hang({p.x, p.y, a_z}, {q.x, q.y, b_z}, faces);
    }
  }
}

}  // namespace

ObjectFaces object_faces(const MapSurroundings& surroundings, const ObjectPlaces& places) {
  ObjectFaces faces;
  const Places found(places, surroundings.power_lines);
  std::vector<Vec2> signals;  // several nodes of one junction give the same places
  constexpr double same_m = 0.5;
  for (const MapObject& object : surroundings.objects)
    for (const Stand& stand : found.of(object)) {
      const Vec2 foot{stand.foot.x, stand.foot.y};
      if (object.kind == ObjectKind::traffic_signals) {
        if (std::ranges::any_of(signals, [&](Vec2 p) { return distance(p, foot) < same_m; })) continue;
        signals.push_back(foot);
      }
      Bodies bodies(stand, is_large(object.kind) ? faces.large : faces.small);
      draw(object, bodies);
    }
  for (std::size_t i = 0; i < surroundings.power_lines.size(); ++i)
    add_wires(surroundings.power_lines[i], places.power_ground_m[i], places.space, faces.small);
  return faces;
}

}  // namespace orthodrive::scene
