// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/structures/structures.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

#include "orthodrive/model/roads/highway_class.hpp"
#include "orthodrive/scene/look/mesh_materials.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace orthodrive::scene {
namespace {

constexpr LinearColor concrete = {0.36F, 0.35F, 0.33F}, rail_steel = {0.30F, 0.31F, 0.32F};

constexpr double beam_width_m = 0.5, beam_rise_m = 0.15;  // RIZ-ING Kap: edge beams
constexpr double railing_m = railing_height_m - beam_rise_m;
constexpr double rail_bar_m = 0.05, post_step_m = 2.0, post_m = 0.06;  // above the beam
constexpr double rail_off_m = 0.75, rail_low_m = 0.44, rail_high_m = 0.75, rail_thick_m = 0.08, rail_post_step_m = 4.0;
constexpr double longest_span_m = 25.0, pier_m = 0.9, pier_depth_m = 0.6, least_clearance_m = 2.5;
constexpr double girder_m = 0.5, girder_height_m = 0.7;
constexpr double look_m = 0.3;          // beyond a border: what is there
constexpr double free_of_road_m = 0.8;  // of piers

Vec3 at(Vec2 p, double z) { return {p.x, p.y, z}; }

class Faces {
 public:
  std::vector<StructureFace> all;
  bool are_rails = false;  ///< what is added from here on

  void quad(Vec3 a, Vec3 b, Vec3 c, Vec3 d, const LinearColor& color) {
    all.push_back({.corners = {a, b, c, d}, .color = color, .is_rail = are_rails});
  }

  /// A bar between two cross sections of four corners each (right low, right high, left high, left low, seen along the
  /// bar): its sides, and its ends where they are asked for.
  void bar(const std::array<Vec3, 4>& from, const std::array<Vec3, 4>& to, const LinearColor& color, bool first,
           bool last) {
    for (std::size_t i = 0; i < 4; ++i) {
      const std::size_t k = (i + 1) % 4;
      quad(from[i], to[i], to[k], from[k], color);
    }
    if (first) quad(from[0], from[1], from[2], from[3], color);
    if (last) quad(to[3], to[2], to[1], to[0], color);
  }

  /// Upright, with a rectangle of half sizes `u` (along) and `v` (across) as plan.
  void post(Vec2 p, Vec2 u, Vec2 v, double low, double high, const LinearColor& color) {
    const std::array<Vec2, 4> c = {p - u - v, p + u - v, p + u + v, p - u + v};
    for (std::size_t i = 0; i < 4; ++i) {
      const std::size_t k = (i + 1) % 4;
      quad(at(c[i], low), at(c[k], low), at(c[k], high), at(c[i], high), color);
    }
    quad(at(c[0], high), at(c[1], high), at(c[2], high), at(c[3], high), color);
  }
};

// ---- along borders

/// Places of a border in a row, with the directions in which an offset line lies outwards.
struct BorderRun {
  std::vector<Vec3> points;
  std::vector<Vec2> outwards;  ///< times an offset: mitred at corners
};

Vec2 outwards_of(const BorderSegment& s) { return left_normal(normalized(s.b - s.a)) * -1.0; }

/// The runs of a level's border for which `wanted(a, b, outwards)` holds.
template <typename Wanted>
std::vector<BorderRun> runs_of(const RoadLevel& level, const Wanted& wanted) {
  std::multimap<std::pair<double, double>, const BorderSegment*> from;
  std::set<std::pair<double, double>> ends;
  const auto key = [](Vec2 p) { return std::pair(p.x, p.y); };
  for (const BorderSegment& s : level.outline().segments())
    if (wanted(s, outwards_of(s))) from.emplace(key(s.a), &s), ends.insert(key(s.b));
  // First the runs that begin somewhere, by that place; what is left then are rings, which begin in the south-west.
  std::vector<BorderRun> runs;
  const auto follow = [&](auto next) {
    BorderRun& run = runs.emplace_back();
    run.points.push_back(at(next->second->a, next->second->a_z_m));
    std::vector<Vec2> normals;
    while (next != from.end()) {
      const BorderSegment& s = *next->second;
      run.points.push_back(at(s.b, s.b_z_m));
      normals.push_back(outwards_of(s));
      from.erase(next);
      next = from.find(key(s.b));
    }
    for (std::size_t i = 0; i <= normals.size(); ++i)
      run.outwards.push_back(mitre(normals[i == 0 ? 0 : i - 1], normals[std::min(i, normals.size() - 1)]));
  };
  for (const auto& start : std::vector(from.begin(), from.end()))
    if (!ends.contains(start.first))
      if (const auto found = from.find(start.first); found != from.end()) follow(found);
  while (!from.empty()) follow(from.begin());
  return runs;
}

/// Whether a place lies on the surface of a road that cars drive, or not far over it. The road query knows more of
/// roads than their meshes show: it goes on a little beyond their ends.
bool is_driven(const StructureInput& input, const Vec3& p) {
  constexpr double border_m = 0.01, below_m = 0.3, above_m = 4.5;
  const auto is_over = [&](double dx, double dy) {
    roadquery::Cursor cursor;
    const auto z = input.query.find_height(p.x + dx, p.y + dy, p.z, cursor);
    return z && p.z - *z > -below_m && p.z - *z < above_m;
  };
  return is_over(0.0, 0.0) && is_over(border_m, 0.0) && is_over(-border_m, 0.0) && is_over(0.0, border_m) &&
         is_over(0.0, -border_m);
}

struct Strip {
  double near_m = 0.0, far_m = 0.0;  ///< outwards
};

/// The parts of a run whose points have no road within the strip.
std::vector<BorderRun> free_parts(const StructureInput& input, const BorderRun& run, const Strip& strip) {
  std::vector<BorderRun> parts;
  bool is_open = false;
  const auto is_free = [&](std::size_t i) {
    const Vec3 p = run.points[i];
    const auto is_at = [&](double off_m) {
      return is_driven(input, at(Vec2{p.x, p.y} + run.outwards[i] * off_m, p.z));
    };
    return !is_at(strip.near_m) && !is_at(0.5 * (strip.near_m + strip.far_m)) && !is_at(strip.far_m);
  };
  for (std::size_t i = 0; i < run.points.size(); ++i) {
    if (!is_free(i)) {
      is_open = false;
      continue;
    }
    if (!is_open) parts.emplace_back();
    is_open = true;
    parts.back().points.push_back(run.points[i]);
    parts.back().outwards.push_back(run.outwards[i]);
  }
  std::erase_if(parts, [](const BorderRun& part) { return part.points.size() < 2; });
  return parts;
}

/// A bar of a rectangular profile along a run: from `near` to `far` m outwards and `low` to `high` m above the border.
void add_bar(const BorderRun& run, double near_m, double far_m, double low_m, double high_m, const LinearColor& color,
             Faces& faces) {
  const auto section = [&](std::size_t i) {
    const Vec3 p = run.points[i];
    const Vec2 inside = Vec2{p.x, p.y} + run.outwards[i] * near_m, outside = Vec2{p.x, p.y} + run.outwards[i] * far_m;
    return std::array{at(outside, p.z + low_m), at(outside, p.z + high_m), at(inside, p.z + high_m),
                      at(inside, p.z + low_m)};
  };
  for (std::size_t i = 0; i + 1 < run.points.size(); ++i)
    faces.bar(section(i), section(i + 1), color, i == 0, i + 2 == run.points.size());
}

/// The edge beam. Beside the deck it has no face: the deck's own side lies there.
void add_beam(const BorderRun& run, double depth_m, Faces& faces) {
  const auto corner = [&](std::size_t i, double off_m, double rise_m) {
    const Vec3 p = run.points[i];
    return at(Vec2{p.x, p.y} + run.outwards[i] * off_m, p.z + rise_m);
  };
  const auto section = [&](std::size_t i) {
    return std::array{corner(i, 0.0, -depth_m), corner(i, beam_width_m, -depth_m), corner(i, beam_width_m, beam_rise_m),
                      corner(i, 0.0, beam_rise_m), corner(i, 0.0, 0.0)};
  };
  for (std::size_t i = 0; i + 1 < run.points.size(); ++i) {
    const auto from = section(i), to = section(i + 1);
    for (std::size_t k = 0; k + 1 < from.size(); ++k) faces.quad(from[k], to[k], to[k + 1], from[k + 1], concrete);
  }
  const auto first = section(0), last = section(run.points.size() - 1);
  faces.quad(first[0], first[1], first[2], first[3], concrete);
  faces.quad(last[3], last[2], last[1], last[0], concrete);
}

struct PostOptions {
  double off_m = 0.0, step_m = 1.0, low_m = 0.0, high_m = 1.0;
};

/// At the same places along the road beside it (s), wherever the run begins.
void add_posts(const StructureInput& input, const BorderRun& run, const PostOptions& options, const LinearColor& color,
               Faces& faces) {
  constexpr double from_end = 0.02;  // share of a segment: on the border's corner another road may be as near
  for (std::size_t i = 0; i + 1 < run.points.size(); ++i) {
    const Vec3 a = run.points[i], b = run.points[i + 1];
    const Vec2 line{b.x - a.x, b.y - a.y};
    const double length_m = std::hypot(line.x, line.y);
    if (!(length_m > 0.0)) continue;
    const Vec2 along = line * (1.0 / length_m), out = left_normal(along) * -1.0;
    const auto hit_at = [&](double share) {
      const Vec3 p = a + (b - a) * share;
      roadquery::Cursor cursor;
      return input.query.find(p.x - out.x * look_m, p.y - out.y * look_m, p.z, cursor, roadquery::hit_position);
    };
    const auto first = hit_at(from_end), last = hit_at(1.0 - from_end);
    if (!first || !last || first->road != last->road || first->s == last->s) continue;
    const double s_per_share = (last->s - first->s) / (1.0 - 2.0 * from_end), s_a = first->s - from_end * s_per_share;
    const double low_s = s_a + std::min(0.0, s_per_share), high_s = s_a + std::max(0.0, s_per_share);
    for (double s = (std::ceil(low_s / options.step_m - 0.5) + 0.5) * options.step_m; s < high_s; s += options.step_m) {
      const Vec3 p = a + (b - a) * ((s - s_a) / s_per_share);
      if (is_driven(input, at(Vec2{p.x, p.y} + out * options.off_m, p.z))) continue;
      faces.post(Vec2{p.x, p.y} + out * options.off_m, along * (0.5 * post_m), out * (-0.5 * post_m),
                 p.z + options.low_m, p.z + options.high_m, color);
    }
  }
}

bool is_paved(const StructureInput& input, Vec2 p, double z) {
  constexpr double level_m = 2.0;
  const auto near = [&](const RoadLevel& level) {
    const auto on = level.sample(p, 0.0);
    return on && std::abs(on->z_m - z) < level_m;
  };
  return near(input.roads) || std::ranges::any_of(input.decks, near);
}

/// Both ends of the strip beside a border are free.
bool is_free_beside(const StructureInput& input, const BorderSegment& s, Vec2 outwards, double reach_m) {
  const double z = 0.5 * (s.a_z_m + s.b_z_m);
  for (const double share : {0.05, 0.5, 0.95})
    for (const double off_m : {look_m, reach_m})
      if (is_paved(input, s.a + (s.b - s.a) * share + outwards * off_m, z)) return false;
  return true;
}

/// The road inside a border if the border runs along it; nullptr at the open end of a road.
const roadquery::Road* road_along(const StructureInput& input, const BorderSegment& s, Vec2 outwards) {
  constexpr double along = 0.7;  // cosine
  const Vec2 p = (s.a + s.b) * 0.5 - outwards * look_m;
  roadquery::Cursor cursor;
  const auto hit = input.query.find(p.x, p.y, 0.5 * (s.a_z_m + s.b_z_m), cursor, roadquery::hit_position);
  if (!hit) return nullptr;
  const roadquery::Road& road = input.query.map().roads[static_cast<std::size_t>(hit->road)];
  const double hdg = roadquery::reference_point(road, hit->s).hdg;
  const Vec2 line = normalized(s.b - s.a);
  return std::abs(line.x * std::cos(hdg) + line.y * std::sin(hdg)) > along ? &road : nullptr;
}

void add_deck_sides(const StructureInput& input, const RoadLevel& deck, Faces& faces) {
  const auto add_side = [&](const BorderRun& run) {
    add_beam(run, input.deck_thickness_m, faces);
    faces.are_rails = true;
    const double off_m = 0.5 * beam_width_m, top_m = beam_rise_m + railing_m;
    for (const double height_m : {top_m - rail_bar_m, beam_rise_m + 0.5 * railing_m, beam_rise_m + 0.12})
      add_bar(run, off_m - 0.5 * rail_bar_m, off_m + 0.5 * rail_bar_m, height_m, height_m + rail_bar_m, rail_steel,
              faces);
    add_posts(input, run, {off_m, post_step_m, beam_rise_m, top_m - rail_bar_m}, rail_steel, faces);
    faces.are_rails = false;
  };
  for (const BorderRun& run : runs_of(deck, [&](const BorderSegment&s, Vec2 outwards) {
         return road_along(input, s, outwards) != nullptr && is_free_beside(input, s, outwards, beam_width_m);
       }))
    for (const BorderRun& part : free_parts(input, run, {0.0, beam_width_m})) add_side(part);
}

void add_guard_rails(const StructureInput& input, Faces& faces) {
  faces.are_rails = true;
  for (const BorderRun& run : runs_of(input.roads, [&](const BorderSegment&s, Vec2 outwards) {
         const roadquery::Road* road = road_along(input, s, outwards);
         return road != nullptr && is_fast_class(road->highway) && is_free_beside(input, s, outwards, rail_off_m + 0.5);
       })) {
    for (const BorderRun& part : free_parts(input, run, {rail_off_m, rail_off_m + rail_thick_m + post_m})) {
      add_bar(part, rail_off_m, rail_off_m + rail_thick_m, rail_low_m, rail_high_m, rail_steel, faces);
      add_posts(input, part, {rail_off_m + rail_thick_m + 0.5 * post_m, rail_post_step_m, -0.5, rail_high_m - 0.05},
                rail_steel, faces);
    }
  }
}

// ---- around islands

constexpr double island_kerb_m = 0.12, island_stone_m = 0.15, kerb_foot_m = 0.1, kerb_gap_m = 0.05;
constexpr double least_island_m2 = 3.0, largest_island_m2 = 150.0, largest_ring_m2 = 3000.0;
constexpr LinearColor kerb_stone = {0.36F, 0.355F, 0.34F};

/// How much of a ring of border segments around a hole has what beside it, m.
struct RingLook {
  double length_m = 0.0, lanes_m = 0.0, circling_m = 0.0, against_m = 0.0, area_m2 = 0.0;
};

RingLook look_around(const StructureInput& input, std::span<const BorderSegment> ring) {
  constexpr double along = 0.7;  // cosine
  RingLook look;
  for (const BorderSegment& s : ring) {
    const double length_m = distance(s.a, s.b);
    look.length_m += length_m;
    look.area_m2 -= 0.5 * cross(s.a - ring.front().a, s.b - ring.front().a);  // holes are clockwise
    const Vec2 line = normalized(s.b - s.a), p = (s.a + s.b) * 0.5 + left_normal(line) * look_m;
    roadquery::Cursor cursor;
    const auto hit = input.query.find(p.x, p.y, 0.5 * (s.a_z_m + s.b_z_m), cursor, roadquery::hit_position);
    if (!hit || hit->lane_id == 0) continue;
    const roadquery::Road& road = input.query.map().roads[static_cast<std::size_t>(hit->road)];
    const roadquery::LaneSection& section = roadquery::section_at(road, hit->s);
    const auto& side = hit->lane_id > 0 ? section.left : section.right;
    const auto lane = std::ranges::find(side, hit->lane_id, &roadquery::Lane::id);
    if (lane == side.end() || lane->type != roadquery::LaneType::driving) continue;
    look.lanes_m += length_m;
    const bool drives_right = road.driving_side == roadquery::DrivingSide::right;
    const double hdg = roadquery::reference_point(road, hit->s).hdg;
    const double cosine = (line.x * std::cos(hdg) + line.y * std::sin(hdg)) *
                          ((hit->lane_id < 0) == drives_right ? 1.0 : -1.0) * (drives_right ? -1.0 : 1.0);
    if (cosine > along) look.circling_m += length_m;
    if (cosine < -along) look.against_m += length_m;
  }
  return look;
}

/// Traffic goes around the middle of a roundabout in one direction, and has it on the side of the oncoming lanes.
/// Blocks of houses have sidewalks or lanes of the other direction around them. Small holes in carriageways are islands
/// anyway.
bool is_island(const RingLook& look) {
  if (look.area_m2 < least_island_m2 || look.lanes_m < 0.9 * look.length_m) return false;
  const bool is_circled = look.circling_m > 0.8 * look.length_m && look.against_m < 0.05 * look.length_m;
  return look.area_m2 < largest_island_m2 || (is_circled && look.area_m2 < largest_ring_m2);
}

void add_island_kerbs(const StructureInput& input, Faces& faces) {
  const std::vector<BorderSegment>& segments = input.roads.outline().segments();
  std::vector<bool> is_kerbed(segments.size(), false);
  std::size_t first = 0;  // segments stand in the order of the rings
  for (const Polygon& polygon : input.roads.polygons()) {
    first += polygon.outer.size();
    for (const Ring& hole : polygon.holes) {
      if (std::abs(signed_area_m2(hole)) < largest_ring_m2 &&
          is_island(look_around(input, std::span(segments).subspan(first, hole.size()))))
        std::fill_n(is_kerbed.begin() + static_cast<std::ptrdiff_t>(first), hole.size(), true);
      first += hole.size();
    }
  }
  const auto wanted = [&](const BorderSegment& s, Vec2 outwards) {
    if (!is_kerbed[static_cast<std::size_t>(&s - segments.data())]) return false;
    return std::ranges::none_of(std::array{0.02, 0.5, 0.98}, [&](double share) {
      const Vec2 p = s.a + (s.b - s.a) * share;
      return is_paved(input, p + outwards * (island_stone_m + kerb_gap_m), 0.5 * (s.a_z_m + s.b_z_m));
    });
  };
  for (BorderRun& run : runs_of(input.roads, wanted)) {
    // Where an island is narrow the stone is narrower, in its tips there is none: the road opposite is free of it.
    std::vector<BorderRun> with_room(1);
    for (std::size_t i = 0; i < run.points.size(); ++i) {
      const Vec3 p = run.points[i];
      const auto is_on_road = [&] {
        return is_paved(input, Vec2{p.x, p.y} + run.outwards[i] * (island_stone_m + kerb_gap_m), p.z);
      };
      for (int halves = 0; halves < 3 && is_on_road(); ++halves) run.outwards[i] = run.outwards[i] * 0.5;
      if (is_on_road()) {
        with_room.emplace_back();
        continue;
      }
      with_room.back().points.push_back(p);
      with_room.back().outwards.push_back(run.outwards[i]);
    }
    for (const BorderRun& wide : with_room)
      for (const BorderRun& part : free_parts(input, wide, {0.0, island_stone_m}))
        add_bar(part, 0.0, island_stone_m, -kerb_foot_m, island_kerb_m, kerb_stone, faces);
  }
}

// ---- below decks

struct DeckPlace {
  Vec2 p, along;
  double under_z = 0.0, clearance_m = 0.0, half_width_m = 0.0;
};

DeckPlace deck_place(const StructureInput& input, const roadquery::Road& road, double s) {
  const roadquery::Edges edges = roadquery::road_edges(road, s);
  const double t = 0.5 * (edges.left_t + edges.right_t);
  const auto middle = roadquery::surface_point(road, s, t);
  const double hdg = roadquery::reference_point(road, s).hdg;
  DeckPlace place{{middle.x, middle.y}, {std::cos(hdg), std::sin(hdg)}};
  place.under_z = middle.z - input.deck_thickness_m;
  place.clearance_m = place.under_z - input.ground.height_m(place.p);
  place.half_width_m = 0.5 * (edges.left_t - edges.right_t);
  return place;
}

/// Whether a pier's foot keeps off all roads below.
bool may_stand(const StructureInput& input, const DeckPlace& place) {
  const Vec2 across = left_normal(place.along);
  for (double along = -0.5 * pier_m - free_of_road_m; along <= 0.5 * pier_m + free_of_road_m + 1e-9; along += 0.5)
    for (double side = -0.7 * place.half_width_m - free_of_road_m;
         side <= 0.7 * place.half_width_m + free_of_road_m + 1e-9; side += 0.5) {
      const Vec2 p = place.p + place.along * along + across * side;
      if (input.roads.sample(p, 0.0)) return false;
      for (const RoadLevel& deck : input.decks) {
        const auto on = deck.sample(p, 0.0);
        if (on && on->z_m < place.under_z - 1.0) return false;
      }
    }
  return true;
}

void add_pier(const StructureInput& input, const DeckPlace& place, Faces& faces) {
  const Vec2 across = left_normal(place.along);
  double foot_z = place.under_z;
  for (const double side : {-0.7, 0.0, 0.7})
    foot_z = std::min(foot_z, input.ground.height_m(place.p + across * (side * place.half_width_m)));
  faces.post(place.p, place.along * (0.5 * pier_m), across * (0.7 * place.half_width_m), foot_z - pier_depth_m,
             place.under_z + 0.05, concrete);
}

void add_piers(const StructureInput& input, const roadquery::Road& road, Faces& faces) {
  const int spans = static_cast<int>(std::ceil(road.length / longest_span_m));
  for (int i = 1; i < spans; ++i) {
    const double s = road.length * i / spans, most_m = 0.35 * road.length / spans;
    for (int k = 0; k <= static_cast<int>(most_m) * 2; ++k) {  // to the nearest free place
      const int away_m = (k + 1) / 2;
      const double moved = away_m * (k % 2 == 0 ? 1.0 : -1.0);
      const DeckPlace place = deck_place(input, road, s + moved);
      if (place.clearance_m < least_clearance_m || !may_stand(input, place)) continue;
      add_pier(input, place, faces);
      break;
    }
  }
}

void add_girders(const StructureInput& input, const roadquery::Road& road, Faces& faces) {
  constexpr double step_m = 3.0;
  const int steps = std::max(1, static_cast<int>(std::ceil(road.length / step_m)));
  for (const double side : {-0.5, 0.5}) {
    std::optional<std::array<Vec3, 4>> before;
    bool is_first = true;
    for (int i = 0; i <= steps; ++i) {
      const DeckPlace place = deck_place(input, road, road.length * i / steps);
      if (place.clearance_m < least_clearance_m) {
        before.reset(), is_first = true;
        continue;
      }
      const Vec2 right = left_normal(place.along) * -1.0, p = place.p + right * (side * place.half_width_m);
      const Vec2 outer = p + right * (0.5 * girder_m), inner = p - right * (0.5 * girder_m);
      const double low = place.under_z - girder_height_m, high = place.under_z + 0.05;
      const std::array<Vec3, 4> here = {at(outer, low), at(outer, high), at(inner, high), at(inner, low)};
      if (before) faces.bar(*before, here, concrete, is_first, i == steps), is_first = false;
      before = here;
    }
  }
}

// ---- at the ends of decks

/// Places of a deck's cross section and the lowest ground below it.
struct DeckEdges {
  std::array<Vec3, 2> edges;  ///< of the underside, right one first seen along the road
  double ground_m = 0.0;
};

DeckEdges deck_edges(const StructureInput& input, const roadquery::Road& road, double s) {
  const roadquery::Edges edges = roadquery::road_edges(road, s);
  DeckEdges result{.ground_m = std::numeric_limits<double>::infinity()};
  constexpr double inside_m = 0.1;  // of the deck's sides: faces in one plane would flicker
  for (std::size_t k = 0; k < 2; ++k) {
    const auto p = roadquery::surface_point(road, s, k == 0 ? edges.right_t + inside_m : edges.left_t - inside_m);
    result.edges[k] = {p.x, p.y, p.z - input.deck_thickness_m};
  }
  for (const double share : {0.0, 0.5, 1.0}) {
    const Vec3 p = result.edges[0] + (result.edges[1] - result.edges[0]) * share;
    result.ground_m = std::min(result.ground_m, input.ground.height_m({p.x, p.y}));
  }
  return result;
}

/// Whether the deck goes over into a road on the ground there.
bool ends_on_ground(const StructureInput& input, const roadquery::Road& road, bool at_end) {
  const auto end = roadquery::reference_point(road, at_end ? road.length : 0.0);
  const double off_m = (at_end ? 1.0 : -1.0) * look_m;
  const Vec2 beyond = Vec2{end.x, end.y} + Vec2{std::cos(end.hdg), std::sin(end.hdg)} * off_m;
  return input.roads.sample(beyond, 0.0).has_value();
}

/// Walls from the first place where the deck is clear of the ground.
void add_abutment(const StructureInput& input, const roadquery::Road& road, bool at_end, Faces& faces) {
  constexpr double step_m = 0.5, longest_m = 12.0, clear_m = 0.3, foot_m = 0.6, into_deck_m = 0.05;
  if (!ends_on_ground(input, road, at_end)) return;
  std::vector<DeckEdges> sections;
  bool is_clear = false;
  for (double in_m = 0.0; !is_clear && in_m <= std::min(longest_m, 0.5 * road.length); in_m += step_m) {
    sections.push_back(deck_edges(input, road, at_end ? road.length - in_m : in_m));
    const DeckEdges& last = sections.back();
    is_clear = last.ground_m < std::min(last.edges[0].z, last.edges[1].z) - clear_m;
  }
  if (!is_clear || sections.size() < 2) return;
  const auto wall = [&](const Vec3& a, const Vec3& b, double a_foot, double b_foot) {
    faces.quad({a.x, a.y, a_foot}, {b.x, b.y, b_foot}, {b.x, b.y, b.z + into_deck_m}, {a.x, a.y, a.z + into_deck_m},
               concrete);
  };
  const auto foot = [&](const DeckEdges& section) {
    return std::min({section.ground_m, section.edges[0].z, section.edges[1].z}) - foot_m;
  };
  // Outside is away from the bank: ahead at the deck's start, behind at its end.
  const DeckEdges& front = sections.back();
  const std::size_t right = at_end ? 1 : 0, left = 1 - right;
  wall(front.edges[right], front.edges[left], foot(front), foot(front));
  for (std::size_t i = 1; i < sections.size(); ++i) {
    const DeckEdges &near = sections[i - 1], &far = sections[i];
    wall(near.edges[right], far.edges[right], foot(near), foot(far));
    wall(far.edges[left], near.edges[left], foot(far), foot(near));
  }
}

}  // namespace

std::vector<StructureFace> build_structures(const StructureInput& input) {
  Faces faces;
  for (const RoadLevel& deck : input.decks) {
    add_deck_sides(input, deck, faces);
    for (const roadquery::Road* road : deck.roads()) {
      add_girders(input, *road, faces);
      add_piers(input, *road, faces);
      for (const bool at_end : {false, true}) add_abutment(input, *road, at_end, faces);
    }
  }
  // Girders, piers and abutments where another road runs just below the deck.
  std::erase_if(faces.all, [&](const StructureFace& face) {
    return std::ranges::any_of(face.corners, [&](const Vec3& p) { return is_driven(input, p); });
  });
  add_island_kerbs(input, faces);
  add_guard_rails(input, faces);
  sort_by_place(faces.all);  // the borders' own order depends on where their rings begin
  return std::move(faces.all);
}

void sort_by_place(std::vector<StructureFace>& faces) {
  std::ranges::stable_sort(faces, {}, [](const StructureFace& face) {
    const Vec3& p = face.corners[0];
    return std::tuple(p.x, p.y, p.z);
  });
}

std::map<TileAddress, std::vector<StructureFace>> by_tile(std::span<const StructureFace> faces) {
  std::map<TileAddress, std::vector<StructureFace>> tiles;
  for (const StructureFace& face : faces) {
    const auto& c = face.corners;
    tiles[tile_at({0.25 * (c[0].x + c[1].x + c[2].x + c[3].x), 0.25 * (c[0].y + c[1].y + c[2].y + c[3].y)})].push_back(
        face);
  }
  return tiles;
}

void add_faces(std::span<const StructureFace> faces, const FaceFilter& filter, Vec3 origin, TriMesh& mesh) {
  const auto f = [](double v) { return static_cast<float>(v); };
  for (const StructureFace& face : faces) {
    if (face.is_rail != filter.is_rail || face.material != filter.material) continue;
    const Vec3 a = face.corners[2] - face.corners[0], b = face.corners[3] - face.corners[1];
    const Vec3 n = cross(a, b);
    const double length = std::hypot(n.x, n.y, n.z);
    if (!(length > 1e-9)) continue;
    const auto base = static_cast<std::uint32_t>(mesh.positions.size());
    for (const Vec3& corner : face.corners) {
      const Vec3 p = corner - origin;
      mesh.positions.push_back({f(p.x), f(p.y), f(p.z)});
      mesh.normals.push_back({f(n.x / length), f(n.y / length), f(n.z / length)});
      mesh.colors.push_back(mesh_color(face.color));
    }
    mesh.indices.insert(mesh.indices.end(), {base, base + 1, base + 2, base, base + 2, base + 3});
  }
}

}  // namespace orthodrive::scene
