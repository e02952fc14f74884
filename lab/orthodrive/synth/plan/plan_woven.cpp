// SPDX-License-Identifier: Apache-2.0
// Lanes and farmland: rows of bent roads from edge to edge, links from row to row, dead ends.

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "orthodrive/core/error.hpp"
#include "orthodrive/synth/plan/countryside.hpp"
#include "orthodrive/synth/plan/plan_presets.hpp"
#include "orthodrive/synth/plan/street_frame.hpp"

namespace orthodrive::synth {
namespace {

struct Between {
  double low = 0.0, high = 0.0;
};
struct RoadKind {
  const char* highway = "";
  Between width_m;
  int lanes = 2;
  double share = 1.0;
};
struct Weave {
  Between row_gap_m, corner_gap_m, link_gap_m, dead_end_gap_m;
  double wander_m = 0.0;  ///< rows leave their line by this at most
  double slant_m = 0.0;   ///< ends of a link differ by this at most
  Between radius_m;
  double least_joint_gap_m = 14.0;
  RoadKind main;  ///< the middle row
  std::vector<RoadKind> rows, links, dead_ends;
};

class WovenPlanner {
 public:
  WovenPlanner(double size_m, std::uint64_t seed, Weave weave)
      : planner_(size_m, seed),
        random_(planner_.random_),
        weave_(std::move(weave)),
        box_{0.0, 0.0, size_m, size_m},
        frame_(size_m, random_.uniform(-std::numbers::pi, std::numbers::pi)),
        joints_(planner_, weave_.least_joint_gap_m) {}

  void weave() {
    lay_rows();
    for (std::size_t j = 0; j + 1 < rows_.size(); ++j) lay_links(j);
    for (std::size_t j = 0; j < rows_.size(); ++j) lay_dead_ends(j);
  }
  SitePlan finish(const char* name, double relief) {
    SitePlan plan = std::move(planner_.plan_);
    plan.name = name, plan.surroundings = Surroundings::settled, plan.relief = relief;
    join_roads(plan);
    return plan;
  }
  [[nodiscard]] double turn_rad() const { return frame_.turn_rad(); }
  [[nodiscard]] SitePlan& plan() { return planner_.plan_; }
  [[nodiscard]] Random& random() { return random_; }
  [[nodiscard]] double in(Between range) { return random_.uniform(range.low, range.high); }
  [[nodiscard]] Vec2 anywhere(double margin) {
    const double size = box_.width();
    return {random_.uniform(margin, 1.0 - margin) * size, random_.uniform(margin, 1.0 - margin) * size};
  }
  /// To the nearest road's middle, `most_m` at most.
  [[nodiscard]] double room_m(Vec2 p, double most_m) const {
    double room = most_m;
    for (const Polyline& line : lines_) room = std::min(room, project_onto(line, p).distance_m);
    return room;
  }

 private:
  struct Row {
    std::size_t road = 0;
    double v = 0.0;
    StreetFrame::Span span;
  };

  std::size_t add(const RoadKind& kind, Alignment line, const std::string& name = "") {
    lines_.push_back(sample(line, 4.0));
    return planner_.add({.highway = kind.highway,
                         .name = name,
                         .width_m = in(kind.width_m),
                         .lanes = kind.lanes,
                         .alignment = std::move(line)});
  }
  [[nodiscard]] const RoadKind& any(const std::vector<RoadKind>& kinds) {
    double draw = random_.uniform();
    for (const RoadKind& kind : kinds) {
      if (draw < kind.share) return kind;
      draw -= kind.share;
    }
    return kinds.back();
  }

  void lay_rows() {
    const double reach = frame_.reach_m();
    constexpr double beyond_m = 40.0;
    bool has_main = false;
    for (double v = -reach + random_.uniform(0.3, 0.7) * weave_.row_gap_m.high; v < reach; v += in(weave_.row_gap_m)) {
      const auto span = frame_.span(v, false, beyond_m);
      if (!span || span->end - span->begin < 150.0) continue;
      std::vector<Corner> corners{{frame_.at(span->begin, v), 0.0}};
      for (double u = span->begin + in(weave_.corner_gap_m); u < span->end - 0.6 * weave_.corner_gap_m.low;
           u += in(weave_.corner_gap_m))
        corners.push_back({frame_.at(u, v + random_.uniform(-weave_.wander_m, weave_.wander_m)), in(weave_.radius_m)});
      corners.push_back({frame_.at(span->end, v), 0.0});
      Alignment line = round_corners(corners, false);
      if (!frame_.passes_once(line, 120.0)) continue;
      const bool main = !has_main && v > -0.3 * reach;
      has_main = has_main || main;
      const std::size_t road = add(main ? weave_.main : any(weave_.rows), std::move(line), main ? "Main Road" : "");
      rows_.push_back({road, v, *span});
    }
  }

  void lay_links(std::size_t j) {
    const Row &low = rows_[j], &high = rows_[j + 1];
    const double begin = std::max(low.span.begin, high.span.begin), end = std::min(low.span.end, high.span.end);
    for (double u = begin + in(weave_.link_gap_m) * random_.uniform(0.3, 1.0); u < end; u += in(weave_.link_gap_m)) {
      const double slant = random_.uniform(-weave_.slant_m, weave_.slant_m);
      const auto a = joints_.find(low.road, frame_.at(u - slant, low.v), true),
                 b = joints_.find(high.road, frame_.at(u + slant, high.v), true);
      if (!a || !b || !leaves_aside(a->q, b->q.p) || !leaves_aside(b->q, a->q.p)) continue;
      const double bend = random_.uniform(-0.5, 0.5) * weave_.slant_m;
      const Vec2 middle = (a->q.p + b->q.p) * 0.5 + left_normal(normalized(b->q.p - a->q.p)) * bend;
      Alignment line = round_corners({{a->q.p, 0.0}, {middle, in(weave_.radius_m)}, {b->q.p, 0.0}}, false);
      if (!frame_.passes_once(line, 25.0) || !is_free(line, {low.road, high.road}, false)) continue;
      joints_.take(*a), joints_.take(*b);
      add(any(weave_.links), std::move(line));
    }
  }

  /// To either side of a row, into what lies between it and the next.
  void lay_dead_ends(std::size_t j) {
    const Row row = rows_[j];
    for (double u = row.span.begin + in(weave_.dead_end_gap_m); u < row.span.end; u += in(weave_.dead_end_gap_m)) {
      const double side = random_.below(2) ? 1.0 : -1.0, length = weave_.row_gap_m.low * random_.uniform(0.4, 0.65);
      const auto a = joints_.find(row.road, frame_.at(u, row.v), false);
      if (!a || !box_.grown(-10.0).contains(a->q.p)) continue;
      const Vec2 out = left_normal(Vec2{std::cos(a->q.heading_rad), std::sin(a->q.heading_rad)}) * side;
      const Vec2 aside = left_normal(out) * (0.3 * length * random_.uniform(-1.0, 1.0));
      Alignment line = round_corners(
          {{a->q.p, 0.0}, {a->q.p + out * (0.6 * length), in(weave_.radius_m)}, {a->q.p + out * length + aside, 0.0}},
          false);
      if (!frame_.passes_once(line, 20.0) || !is_free(line, {row.road}, true)) continue;
      joints_.take(*a);
      add(any(weave_.dead_ends), std::move(line));
    }
  }

  /// Keeps away from all roads but those that it joins.
  [[nodiscard]] bool is_free(const Alignment& line, const std::vector<std::size_t>& joined, bool dead_end) const {
    const Polyline points = sample(line, 4.0);
    const Box2 near = bounds_of(points).grown(weave_.least_joint_gap_m);
    for (std::size_t r = 0; r < lines_.size(); ++r) {
      const bool joins = std::find(joined.begin(), joined.end(), r) != joined.end();
      if (!bounds_of(lines_[r]).overlaps(near)) continue;
      for (const Vec2 p : points) {
        const double apart = project_onto(lines_[r], p).distance_m;
        // A link may share the joint of another one; from there on they go apart.
        const double from_ends =
            dead_end ? distance(p, points.front()) : std::min(distance(p, points.front()), distance(p, points.back()));
        const double need = std::min(weave_.least_joint_gap_m - 2.0, (joins ? 0.6 : 0.7) * from_ends);
        if (apart < need - 0.1) return false;
      }
    }
    return true;
  }

  Planner planner_;
  Random& random_;
  Weave weave_;
  Box2 box_;
  StreetFrame frame_;
  Joints joints_;
  std::vector<Row> rows_;
  std::vector<Polyline> lines_;
};

void add_wood(WovenPlanner& woven, Between radius_share, double margin) {
  SitePlan& plan = woven.plan();
  const Vec2 p = woven.anywhere(margin);
  const double radius_m = woven.in(radius_share)*plan.size_m;
  const Ring ring = blob(woven.random(), p, radius_m);
  for (const Settlement& s : plan.settlements)
    if (contains(s.outline, p) || std::any_of(ring.begin(), ring.end(), [&](Vec2 q) { return contains(s.outline, q); }))
      return;
  add_area(plan, ring, Cover::forest_floor, true);
}

void add_pond(WovenPlanner& woven, double largest_m) {
  Vec2 best;
  double room = 0.0;
  for (int i = 0; i < 60; ++i) {
    const Vec2 p = woven.anywhere(0.08);
    const double here = woven.room_m(p, 1.75 * largest_m + 8.0);
    if (here > room) best = p, room = here;
  }
  const double radius_m = (room - 8.0) / 1.75;
  if (radius_m < 5.0) return;
  add_area(woven.plan(), blob(woven.random(), best, 1.25 * radius_m), Cover::meadow, false);
  add_area(woven.plan(), blob(woven.random(), best, radius_m), Cover::water, true);
}

/// Houses behind those along the lanes, so that a block is built up to its middle.
void add_houses_behind(WovenPlanner& woven, double tries_per_ha) {
  SitePlan& plan = woven.plan();
  Random& random = woven.random();
  constexpr double front_m = 17.0, apart_m = 12.0;
  const int tries = static_cast<int>(tries_per_ha * plan.size_m * plan.size_m / 1e4);
  for (int i = 0; i < tries; ++i) {
    const Vec2 p = woven.anywhere(0.01);
    const bool built_up = std::any_of(plan.settlements.begin(), plan.settlements.end(),
                                      [&](const Settlement& s) { return contains(s.outline, p); });
    const bool free = std::none_of(plan.buildings.begin(), plan.buildings.end(),
                                   [&](const House& h) { return distance(h.center, p) < apart_m; });
    if (!built_up || !free || woven.room_m(p, 60.0) < front_m) continue;
    const auto tone = static_cast<float>(random.uniform(0.3, 0.6));
    House house{p,
                woven.turn_rad() + random.normal() * 0.08 + (random.below(2) ? 0.5 * std::numbers::pi : 0.0),
                random.uniform(4.0, 6.5),
                random.uniform(3.2, 5.0),
                random.uniform(3.5, 7.5),
                random.uniform(0.4, 0.7)};
    house.color = {tone, tone, tone};
    plan.buildings.push_back(house);
  }
}

/// Small areas between the houses of a settlement.
void add_yards(WovenPlanner& woven, int count, Between half_m, const std::vector<Cover>& covers) {
  for (int i = 0; i < count; ++i) {
    const Vec2 p = woven.anywhere(0.02);
    const double heading = woven.random().uniform(0.0, std::numbers::pi);
    add_area(woven.plan(), rectangle(p, heading, woven.in(half_m), woven.in(half_m)),
             covers[woven.random().below(covers.size())], false);
  }
}

Weave weave_of_lanes() {
  return {
      .row_gap_m = {44.0, 70.0},
      .corner_gap_m = {45.0, 95.0},
      .link_gap_m = {38.0, 110.0},
      .dead_end_gap_m = {60.0, 220.0},
      .wander_m = 8.5,
      .slant_m = 9.0,
      .radius_m = {8.0, 40.0},
      .least_joint_gap_m = 13.0,
      .main = {"tertiary", {6.0, 8.0}},
      .rows = {{"residential", {3.2, 5.2}, 1, 0.7}, {"residential", {5.0, 6.2}, 2, 0.3}},
      .links = {{"residential", {2.6, 4.2}, 1, 0.75}, {"unclassified", {3.0, 4.5}, 1, 0.25}},
      .dead_ends = {{"service", {2.5, 3.4}, 1, 1.0}},
  };
}

Weave weave_of_farmland() {
  return {
      .row_gap_m = {120.0, 190.0},
      .corner_gap_m = {70.0, 180.0},
      .link_gap_m = {120.0, 300.0},
      .dead_end_gap_m = {110.0, 320.0},
      .wander_m = 26.0,
      .slant_m = 30.0,
      .radius_m = {20.0, 120.0},
      .least_joint_gap_m = 18.0,
      .main = {"tertiary", {5.2, 6.8}},
      .rows = {{"unclassified", {3.6, 5.2}, 1, 0.4}, {"track", {2.6, 4.0}, 1, 0.6}},
      .links = {{"track", {2.5, 3.8}, 1, 0.8}, {"unclassified", {3.4, 4.8}, 1, 0.2}},
      .dead_ends = {{"track", {2.5, 3.4}, 1, 0.7}, {"service", {2.8, 3.8}, 1, 0.3}},
  };
}

/// Houses that stand close to narrow lanes.
void settle_lanes(Settling& s, bool town, Random& random) {
  s.lots = {.least_length_m = 9.0,
            .most_length_m = 16.0,
            .walk_m = 0.3,
            .least_setback_m = 0.6,
            .most_setback_m = 3.0,
            .least_depth_m = 14.0,
            .most_depth_m = 21.0,
            .least_half_front_m = 3.4,
            .most_half_front_m = 6.5,
            .side_gap_m = 0.8,
            .least_half_deep_m = 4.0,
            .most_half_deep_m = 6.5,
            .least_eave_m = 4.0,
            .most_eave_m = town ? 11.0 : 7.0,
            .road_gap_m = 0.7,
            .house_gap_m = 0.6};
  s.built_share = random.uniform(0.75, 0.97);
  s.lawn_share = random.uniform(0.05, 0.35);
  s.tree_clearance_m = random.uniform(0.8, 2.0);
  s.roadside_trees = random.uniform(0.0, 0.25);
  s.scattered_per_ha = random.uniform(1.0, 5.0);
}

/// Yards and barns beside roads, where there is room.
void add_farms(WovenPlanner& woven, int farms) {
  Random& random = woven.random();
  SitePlan& plan = woven.plan();
  for (int i = 0; i < farms; ++i) {
    const std::size_t r = random.below(plan.roads.size());
    const PlannedRoad& road = plan.roads[r];
    const AlignmentPoint q = evaluate(road.alignment, random.uniform(0.1, 0.9) * road.alignment.length_m);
    const Vec2 along{std::cos(q.heading_rad), std::sin(q.heading_rad)},
        out = left_normal(along) * (random.below(2) ? 1.0 : -1.0);
    const Vec2 yard = q.p + out * (0.5 * road.width_m + 16.0);
    if (woven.room_m(yard + out * 9.0, 60.0) < 24.0 || woven.room_m(yard + out * 9.0 + along * 26.0, 60.0) < 18.0 ||
        woven.room_m(yard + out * 9.0 - along * 26.0, 60.0) < 18.0)
      continue;
    add_area(plan, rectangle(yard + out * 4.0, q.heading_rad, random.uniform(20.0, 30.0), 16.0),
             random.uniform() < 0.5 ? Cover::gravel : Cover::paved, false);
    add_farm(plan, yard, out, random);
  }
}
}  // namespace

SitePlan plan_lanes(double size_m, std::uint64_t seed) {
  check_preset_size(size_m, 200.0, 2000.0);
  WovenPlanner woven(size_m, seed, weave_of_lanes());
  woven.weave();
  Random& random = woven.random();
  SitePlan& plan = woven.plan();
  const bool town = random.uniform() < 0.5;
  const int quarters = town ? 1 : 2 + static_cast<int>(random.below(2));
  for (int i = 0; i < quarters; ++i) {
    const double radius_m = (town ? random.uniform(0.5, 0.9) : random.uniform(0.12, 0.24)) * size_m;
    const Ring ring = blob(random, woven.anywhere(town ? 0.4 : 0.2), radius_m);
    plan.settlements.push_back({{ring, {}}, town});
    add_area(plan, ring, Cover::gravel, false);  // paved areas of the plan are kept free
  }
  const int yards = static_cast<int>(size_m * size_m / 1e4 * random.uniform(2.0, 6.0));
  const std::vector<Cover> covers{Cover::lawn, Cover::garden_bed, Cover::paved, Cover::meadow, Cover::garden_bed};
  const std::size_t first_yard = plan.areas.size();
  add_yards(woven, yards, {4.0, 14.0}, covers);
  std::erase_if(plan.areas, [&](const Area& area) {  // the others would lie in the fields
    return static_cast<std::size_t>(area.id) >= first_yard &&
           std::none_of(plan.settlements.begin(), plan.settlements.end(),
                        [&](const Settlement& s) { return contains(s.outline, area.polygon.outer.front()); });
  });
  add_houses_behind(woven, random.uniform(20.0, 90.0));
  for (int i = 0; i < 5; ++i) add_wood(woven, {0.05, 0.12}, 0.0);
  if (random.uniform() < 0.5) add_pond(woven, 18.0);
  plan.field_m = {random.uniform(16.0, 34.0), random.uniform(30.0, 70.0)};
  plan.bund_m = random.uniform(0.5, 1.1);
  const bool terraced = random.uniform() < 0.5;
  plan.terrace_m = terraced ? random.uniform(0.5, 1.2) : 0.0;
  plan.walk_to_m = 0.0, plan.corner_rounding_m = 3.0;
  settle_lanes(plan.settling, town, random);
  return woven.finish("Lanes", terraced ? random.uniform(0.6, 1.2) : random.uniform(0.2, 0.5));
}

SitePlan plan_farmland(double size_m, std::uint64_t seed) {
  check_preset_size(size_m, 300.0, 2000.0);
  WovenPlanner woven(size_m, seed, weave_of_farmland());
  woven.weave();
  Random& random = woven.random();
  SitePlan& plan = woven.plan();
  const int hamlets = 1 + static_cast<int>(random.below(2));
  for (int i = 0; i < hamlets; ++i) {
    const Ring ring = blob(random, woven.anywhere(0.2), random.uniform(0.08, 0.14) * size_m);
    plan.settlements.push_back({{ring, {}}, false});
    add_area(plan, ring, Cover::meadow, false);
  }
  const int woods = 3 + static_cast<int>(random.below(6));
  for (int i = 0; i < woods; ++i) add_wood(woven, {0.06, 0.17}, 0.0);
  if (random.uniform() < 0.6) add_pond(woven, 45.0);
  const int meadows = static_cast<int>(size_m / 160.0);
  for (int i = 0; i < meadows; ++i)
    add_area(plan, blob(random, woven.anywhere(0.0), random.uniform(18.0, 60.0)), Cover::meadow, false);
  const int orchards = static_cast<int>(size_m / 200.0) + static_cast<int>(random.below(4));
  for (int i = 0; i < orchards; ++i) {
    const double heading = random.uniform(0.0, std::numbers::pi);
    const Ring ring = rectangle(woven.anywhere(0.05), heading, random.uniform(20.0, 60.0), random.uniform(15.0, 45.0));
    add_area(plan, ring, Cover::meadow, false);
    plan.settling.orchards.push_back(
        {{ring, {}}, heading, random.uniform(3.5, 7.5), random.uniform(2.5, 6.0), random.uniform(0.9, 2.2)});
  }
  add_farms(woven, 2 + static_cast<int>(size_m / 250.0));
  plan.field_m = {random.uniform(40.0, 100.0), random.uniform(90.0, 260.0)};
  plan.bund_m = random.uniform(0.0, 1.5);
  plan.terrace_m = random.uniform() < 0.25 ? random.uniform(1.0, 2.5) : 0.0;
  plan.walk_to_m = 0.0, plan.corner_rounding_m = 5.0;
  Settling& s = plan.settling;
  s.lots.road_gap_m = 3.0;
  s.built_share = random.uniform(0.4, 0.8);
  s.tree_clearance_m = random.uniform(1.6, 4.2);
  s.roadside_trees = random.uniform(0.0, 0.35);
  s.scattered_per_ha = random.uniform(0.3, 2.0);
  return woven.finish("Farmland", random.uniform(0.3, 0.8));
}

}  // namespace orthodrive::synth
