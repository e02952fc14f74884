// SPDX-License-Identifier: Apache-2.0
#include "roadquery/random_roads.hpp"

#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "roadquery/surface/poly_curve.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace roadquery::test {
namespace {

/// One element at most 60 m long that goes on from where the last one ended.
void append_random(RandomRoad& made, PlanPoint from, Dice& dice) {
  Road& road = made.road;
  PlanElement element{road.length, from.x, from.y, from.hdg, dice.between(8.0, 60.0), Line{}};
  std::optional<Cubic> v_of_u;
  switch (dice.below(5)) {
    case 1:
      element.shape = Arc{dice.between(-0.02, 0.02)};
      break;
    case 2:
      element.shape = Spiral{dice.between(-0.015, 0.015), dice.between(-0.015, 0.015)};
      break;
    case 3: {
      const double along = element.length;
      const ParamPoly3 poly{0.0,
                            along,
                            dice.between(-2, 2),
                            dice.between(-1, 1),
                            0.0,
                            0.0,
                            dice.between(-0.2, 0.2) * along,
                            dice.between(-0.1, 0.1) * along,
                            true};
      element.shape = poly;
      element.length = curve_length(element, poly);
      break;
    }
    case 4:
      v_of_u = Cubic{0.0, 0.0, dice.one_in(2) ? 0.0 : dice.between(-0.3, 0.3), dice.between(-5e-3, 5e-3),
                     dice.between(-2e-5, 2e-5)};
      element.hdg -= std::atan(v_of_u->b);
      element.shape = from_poly3(*v_of_u, element.length);
      break;
    default:
      break;
  }
  road.length += element.length;
  road.plan.push_back(element);
  made.poly3.push_back(v_of_u);
}

/// Continuous, from 0 on.
std::vector<Cubic> random_profile(double length, double value, double slope, Dice& dice) {
  std::vector<Cubic> cubics;
  double s = 0.0, a = dice.between(-value, value);
  for (int count = 1 + dice.below(3); count > 0 && s < length - 2.0; --count) {
    cubics.push_back({s, a, dice.between(-slope, slope), dice.between(-slope, slope) / length,
                      dice.between(-slope, slope) / (length * length)});
    const double next = dice.between(s + 1.0, length);
    a = evaluate(cubics, next), s = next;
  }
  return cubics;
}

void add_shape(RandomRoad& made, Dice& dice) {
  Road& road = made.road;
  double s = 0.0;
  for (int rows = 1 + dice.below(3); rows > 0 && s < road.length; --rows, s += dice.between(5.0, 40.0)) {
    double t = dice.between(-15.0, -5.0), a = dice.between(-0.3, 0.3);
    for (int cubics = 1 + dice.below(4); cubics > 0; --cubics) {
      const ShapeCubic cubic{s, t, a, dice.between(-0.05, 0.05), dice.between(-2e-3, 2e-3), dice.between(-1e-4, 1e-4)};
      road.shape.push_back(cubic);
      const double dt = dice.between(1.0, 7.0);
      a += dt * (cubic.b + dt * (cubic.c + dt * cubic.d)), t += dt;
    }
  }
}

/// Two planes of <shape>; where a slope changes, the old ones until a hundredth of a metre before.
void add_crossfall(RandomRoad& made, Dice& dice) {
  Road& road = made.road;
  double s = 0.0;
  const auto planes = [&](double at, const CrossfallStep& step) {
    road.shape.push_back({at, -20.0, -20.0 * step.right, step.right, 0.0, 0.0});
    road.shape.push_back({at, 0.0, 0.0, -step.left, 0.0, 0.0});
  };
  for (int steps = 1 + dice.below(3); steps > 0 && s < road.length; --steps, s += dice.between(5.0, 40.0)) {
    if (s > 0.0) planes(s - 0.01, made.crossfall.back());
    made.crossfall.push_back({s, dice.between(-0.02, 0.05), dice.between(-0.02, 0.05)});
    planes(s, made.crossfall.back());
  }
}

/// The cubic of a strip at s, begun at an edge `from_t` of a strip whose own edge is at `edge`.
ShapeCubic strip_cubic(const RandomStrips::Strip& strip, double s, double edge, double from_t) {
  double p[4];
  for (std::size_t i = 0; i < 4; ++i) p[i] = strip.height[i].a + strip.height[i].b * s;
  const double x = from_t - edge;
  return {s,
          from_t,
          p[0] + x * (p[1] + x * (p[2] + x * p[3])),
          p[1] + x * (2.0 * p[2] + x * 3.0 * p[3]),
          p[2] + 3.0 * x * p[3],
          p[3]};
}

/// Rows of <shape> at both ends of the road.
void add_strips(RandomRoad& made, Dice& dice) {
  Road& road = made.road;
  RandomStrips strips{dice.between(-1.0, 1.0), {}};
  for (const int side : {-1, 1}) {
    const bool has_outer = dice.one_in(2);
    for (int i = 1; i <= (has_outer ? 2 : 1); ++i) {
      RandomStrips::Strip strip{side * i, i == 2 && dice.one_in(2), has_outer && i == 1 ? dice.between(1.0, 5.0) : 0.0};
      const double sizes[] = {0.1, 0.05, 2e-3, 1e-4};
      for (std::size_t k = 0; k < 4; ++k)
        strip.height[k] = {0.0, dice.between(-sizes[k], sizes[k]), dice.between(-sizes[k], sizes[k]) / road.length};
      strips.strips.push_back(strip);
    }
  }
  const auto find = [&](int id) -> const RandomStrips::Strip* {
    for (const RandomStrips::Strip& strip : strips.strips)
      if (strip.id == id) return &strip;
    return nullptr;
  };
  for (const double s : {0.0, road.length}) {
    const auto add_outer = [&](int side, double from_t) {
      const RandomStrips::Strip *inner = find(side), *outer = find(2 * side);
      if (outer == nullptr) return;
      const double edge = strips.t_offset + side * inner->width;
      ShapeCubic cubic = strip_cubic(*outer, s, edge, from_t);
      if (outer->relative) cubic.a += strip_cubic(*inner, s, strips.t_offset, edge).a;
      road.shape.push_back(cubic);
    };
    add_outer(-1, -20.0);
    const double right = find(-2) != nullptr ? strips.t_offset - find(-1)->width : -20.0;
    road.shape.push_back(strip_cubic(*find(-1), s, strips.t_offset, right));
    road.shape.push_back(strip_cubic(*find(1), s, strips.t_offset, strips.t_offset));
    add_outer(1, strips.t_offset + find(1)->width);
  }
  made.strips = std::move(strips);
}

class LaneMaker {
 public:
  LaneMaker(bool connecting, Dice& dice) : connecting_(connecting), dice_(dice) {}

  std::vector<Lane> side(int sign, double length, const std::vector<Lane>& before) {
    std::vector<Lane> lanes;
    const int count = dice_.below(4) + (connecting_ ? 1 : 0);
    const int first_level = dice_.one_in(5) ? dice_.below(4) : 9;
    for (int i = 0; i < count; ++i) {
      lanes.push_back(lane(sign * (i + 1), length));
      lanes.back().level = i >= first_level;
      if (!before.empty() && !dice_.one_in(4))
        lanes.back().predecessor = sign * (1 + dice_.below(static_cast<int>(before.size())));
      if (dice_.one_in(2)) lanes.back().successor = sign * (1 + dice_.below(3));
    }
    return lanes;
  }

  std::vector<RoadMark> marks(double length) {
    std::vector<RoadMark> result;
    for (double s = 0.0; s < length && !dice_.one_in(3); s += dice_.between(1.0, 30.0))
      result.push_back({s, dice_.one_of<const char*>({"solid", "broken", "none", "solid solid", "curb", "grass"}),
                        dice_.one_of({0.12, 0.15, 0.3})});
    return result;
  }

 private:
  Lane lane(int id, double length) {
    Lane made;
    made.id = id;
    make_use(made);
    made.width = random_profile(length, 0.0, 0.3 / length, dice_);
    const double wide = dice_.between(1.5, 4.0);
    for (Cubic& c : made.width) c.a += wide;
    made.marks = marks(length);
    for (double s = 0.0; s < length && (connecting_ || dice_.one_in(2)); s += dice_.between(1.0, 30.0)) {
      made.materials.push_back({s,
                                dice_.one_of({SurfaceClass::asphalt, SurfaceClass::concrete, SurfaceClass::setts,
                                              SurfaceClass::gravel, SurfaceClass::ground}),
                                dice_.one_of({1.0, 0.8, 0.45}), dice_.one_of({0.0, 0.002})});
      if (connecting_) break;
    }
    for (double s = 0.0; s < length && dice_.one_in(3); s += dice_.between(1.0, 30.0))
      made.heights.push_back({s, dice_.between(-0.1, 0.2), dice_.between(-0.1, 0.2)});
    for (double s = dice_.one_in(2) ? 0.0 : 3.0; s < length && dice_.one_in(2); s += dice_.between(1.0, 30.0))
      made.speeds.push_back({s, dice_.one_of({0.0, 30.0, 60.0, 100.0}) / 3.6});
    return made;
  }
  void make_use(Lane& lane) {
    lane.type =
        dice_.one_of({LaneType::driving, LaneType::driving, LaneType::driving, LaneType::none, LaneType::shoulder,
                      LaneType::border, LaneType::sidewalk, LaneType::parking, LaneType::biking, LaneType::other,
                      LaneType::bidirectional, LaneType::bus, LaneType::taxi});
    if (lane.type == LaneType::bus)
      lane.allowed = dice_.one_in(2) ? std::vector<std::string>{"bus"} : std::vector<std::string>{"bus", "taxi"};
    if (lane.type == LaneType::taxi) lane.allowed = {"taxi"};
    if (lane.type == LaneType::other && dice_.one_in(2)) lane.allowed = {"truck"};
    if (lane.type == LaneType::driving && dice_.one_in(6)) lane.allowed = {"bus", "passengerCar"};
  }

  bool connecting_;
  Dice& dice_;
};

/// What a list says from s on, begun there.
template <typename Item, typename Place>
std::vector<Item> from_there_on(const std::vector<Item>& items, double s, Place Item::*place) {
  std::vector<Item> rest;
  for (Item item : items) {
    item.*place -= s;
    if (item.*place <= 0.0) rest.clear();
    item.*place = std::max(item.*place, 0.0);
    rest.push_back(std::move(item));
  }
  return rest;
}

std::vector<Lane> kept_lanes(std::vector<Lane> lanes, double by_m) {
  for (Lane& lane : lanes) {
    std::vector<Cubic> width = {begun_at(lane.width, by_m)};
    for (const Cubic& c : lane.width)
      if (c.s > by_m) width.push_back(c);
    for (Cubic& c : width) c.s -= by_m;
    lane.width = width;
    lane.marks = from_there_on(lane.marks, by_m, &RoadMark::s_offset);
    lane.materials = from_there_on(lane.materials, by_m, &LaneMaterial::s_offset);
    lane.speeds = from_there_on(lane.speeds, by_m, &SpeedLimit::s);
    if (!lane.heights.empty()) {
      const LaneHeightAt at = lane_height_at(lane.heights, by_m);
      std::vector<LaneHeight> heights = {{0.0, at.value[0], at.value[1]}};
      for (const LaneHeight& h : lane.heights)
        if (h.s_offset > by_m) heights.push_back({h.s_offset - by_m, h.inner, h.outer});
      lane.heights = heights;
    }
    lane.predecessor = lane.id;
  }
  return lanes;
}

void add_lanes(RandomRoad& made, bool connecting, Dice& dice) {
  Road& road = made.road;
  LaneMaker maker(connecting, dice);
  std::vector<double> starts = {0.0};
  while (starts.size() < 3 && dice.one_in(2) && starts.back() + 4.0 < road.length)
    starts.push_back(dice.between(starts.back() + 2.0, road.length - 1.0));
  for (std::size_t i = 0; i < starts.size(); ++i) {
    const double length = road.length - starts[i];  // lanes may go on in the next section
    LaneSection section;
    section.s = starts[i];
    const LaneSection before = i > 0 ? road.sections.back() : LaneSection{};
    int kept = i > 0 && !dice.one_in(3) ? dice.one_of({1, -1}) : 0;
    for (const int sign : {1, -1}) {
      const std::vector<Lane>& old = sign > 0 ? before.left : before.right;
      (sign > 0 ? section.left : section.right) =
          kept == sign ? kept_lanes(old, section.s - before.s) : maker.side(sign, length, old);
    }
    if (section.left.empty() && section.right.empty()) {
      section = {};
      section.s = starts[i], kept = 0;
      section.right = maker.side(-1, length, before.right);
    }
    if (kept != 0)
      for (Lane& lane : kept > 0 ? road.sections.back().left : road.sections.back().right) lane.successor = lane.id;
    section.center.type = LaneType::none;
    section.center.marks = maker.marks(length);
    made.kept_side.push_back(kept);
    road.sections.push_back(std::move(section));
  }
  for (const LaneSection& section : road.sections)
    for (const auto* side : {&section.left, &section.right})
      for (const Lane& lane : *side) made.has_level = made.has_level || lane.level;
}

void add_limits_and_objects(Road& road, bool connecting, Dice& dice) {
  constexpr double infinite = std::numeric_limits<double>::infinity();
  for (double s = 0.0; s < road.length && (connecting || !dice.one_in(3)); s += dice.between(5.0, 50.0))
    road.speed_limits.push_back(
        {s, connecting ? 10.0 : dice.one_of({0.0, infinite, 30.0 / 3.6, 50.0 / 3.6, 100.0 / 3.6, 27.0})});
  for (auto* stretches : {&road.bridges, &road.tunnels})
    if (dice.one_in(3)) stretches->push_back({0.3 * road.length, dice.between(0.4, 0.8) * road.length});
  if (dice.one_in(6)) (dice.one_in(2) ? road.bridge : road.tunnel) = true;
  if (dice.one_in(3)) {
    RoadObject object{dice.one_of<const char*>({"crosswalk", "roadMark"}), "zebra",
                      "\xdc"
                      "berweg"};
    object.s = dice.between(1.0, road.length), object.t = dice.between(-2.0, 2.0);
    object.hdg = dice.between(0.0, 3.0), object.length = 4.0, object.width = 6.5;
    if (dice.one_in(2))
      object.outline = {{object.s - 2.0, -3.0}, {object.s + 2.0, -3.0}, {object.s + 2.0, 3.0}, {object.s - 2.0, 3.0}};
    road.objects.push_back(object);
  }
  if (dice.one_in(6))
    road.surface.push_back({"belag.crg", 0.0, 0.5 * road.length, "opposite", "attached", "elevation", 0.5, -1.25, 0.03,
                            0.5, 0.0, 0.0, 0.0});
}

RandomRoad random_road(int index, bool connecting, Dice& dice) {
  RandomRoad made;
  Road& road = made.road;
  road.id = index;
  road.name =
      "Stra\xdf"
      "e " +
      std::to_string(index) + " \xe9";
  PlanPoint from{900.0 * index + dice.between(-9.0, 9.0), dice.between(-500.0, 500.0), dice.between(-3.0, 3.0), 0.0};
  for (int elements = 1 + dice.below(4); elements > 0; --elements) {
    append_random(made, from, dice);
    from = evaluate(road.plan.back(), road.plan.back().length);
  }
  road.elevation = random_profile(road.length, 80.0, 0.06, dice);
  if (dice.one_in(2)) road.superelevation = random_profile(road.length, 0.04, 3e-4, dice);
  if (dice.one_in(2)) road.lane_offset = random_profile(road.length, 1.5, 0.01, dice);
  add_lanes(made, connecting, dice);
  // Level lanes beside a step across the road would be as good as their pieces are short.
  switch (dice.below(made.has_level ? 3 : 4)) {
    case 1:
      add_shape(made, dice);
      break;
    case 2:
      add_crossfall(made, dice);
      break;
    case 3:
      road.superelevation.clear();
      add_strips(made, dice);
      break;
    default:
      break;
  }
  add_limits_and_objects(road, connecting, dice);
  return made;
}

ContactPoint random_contact(Dice& dice) { return dice.one_in(2) ? ContactPoint::start : ContactPoint::end; }

/// Two roads join, the others end at the junction or nowhere; connecting roads lead from one to another.
void link_roads(RandomMap& map, int plain, Dice& dice) {
  Junction& junction = map.junctions.emplace_back();
  junction.id = 500, junction.name = "Kreuz \xfc";
  for (std::size_t i = 0; i < map.roads.size(); ++i) {
    Road& road = map.roads[i].road;
    if (road.id < plain) {
      if (dice.one_in(2)) road.successor = {LinkKind::junction, junction.id};
      if (dice.one_in(2)) road.predecessor = {LinkKind::road, dice.below(plain), random_contact(dice)};
      continue;
    }
    road.junction = junction.id;
    road.predecessor = {LinkKind::road, dice.below(plain), random_contact(dice)};
    road.successor = {LinkKind::road, dice.below(plain), random_contact(dice)};
    Connection connection{
        static_cast<int>(junction.connections.size()), road.predecessor.id, road.id, random_contact(dice), {{-1, -1}}};
    if (dice.one_in(2)) connection.lane_links.push_back({1, dice.one_of({1, 2})});
    junction.connections.push_back(std::move(connection));
  }
  if (junction.connections.size() > 1)
    junction.priorities.push_back({junction.connections[0].connecting_road, junction.connections[1].connecting_road});
}

}  // namespace

Cubic begun_at(const std::vector<Cubic>& cubics, double s) {
  const Cubic* held = nullptr;
  for (const Cubic& c : cubics)
    if (c.s <= s) held = &c;
  if (held == nullptr) return {s};
  const double x = s - held->s;
  return {s, held->a + x * (held->b + x * (held->c + x * held->d)), held->b + x * (2.0 * held->c + x * 3.0 * held->d),
          held->c + 3.0 * x * held->d, held->d};
}

RandomMap random_map(unsigned seed, int roads) {
  Dice dice(seed);
  RandomMap map;
  const int plain = std::max(1, (2 * roads) / 3);
  for (int i = 0; i < roads; ++i) map.roads.push_back(random_road(i, i >= plain, dice));
  if (roads > plain) link_roads(map, plain, dice);
  const bool left = dice.one_in(4);
  for (RandomRoad& made : map.roads) made.road.driving_side = left ? DrivingSide::left : DrivingSide::right;
  return map;
}

}  // namespace roadquery::test
