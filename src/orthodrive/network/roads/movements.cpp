// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/roads/movements.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <optional>
#include <utility>

#include "orthodrive/network/lanes/lanes.hpp"

namespace orthodrive::network {
namespace {

constexpr double max_turn_back_rad = 140.0 * std::numbers::pi / 180.0;  // into a road that leads back

// What a driver still calls straight on when arrows are read.
constexpr double straight_turn_rad = 35.0 * std::numbers::pi / 180.0;

/// The lanes that arrows give a turn: from the first to the last that shows it. `bits`: what the turn may be called.
bool take_arrow_lanes(const std::vector<unsigned>& arrows, unsigned bits, bool main, Movement& m) {
  const auto shows = [&](unsigned lane) { return (lane & bits) != 0 || (main && (lane & ~unsigned{turn_merge}) == 0); };
  const auto first = std::find_if(arrows.begin(), arrows.end(), shows);
  if (first == arrows.end()) return false;
  const auto last = std::find_if(arrows.rbegin(), arrows.rend(), shows).base();
  m.first_in = static_cast<std::size_t>(first - arrows.begin());
  m.count_in = static_cast<std::size_t>(last - first);
  return true;
}

/// Lanes of a way on. By the arrows where there are any; else the straightest way (`main`) takes all lanes, and others
/// the lane next to where they go, or as many as the main way lacks (`surplus`). Arrows are no prohibition: a turn that
/// none shows takes its lanes, too.
void choose_lanes(Movement& m, bool main, double main_turn_rad, std::size_t surplus, const Gate& in, const Gate& out,
                  DrivingSide driving_side) {
  const std::size_t lanes_in = in.lanes.size(), lanes_out = out.lanes.size();
  const bool left = m.turn_rad > 0.0;
  // An exit of a ring may bend inwards, too, but less than the ring does. Turning round is done inwards.
  const bool inwards = std::abs(m.turn_rad) > max_turn_rad ||
                       (m.turn_rad > (main ? 0.0 : main_turn_rad)) != (driving_side == DrivingSide::left);
  const bool straight = std::abs(m.turn_rad) < straight_turn_rad;
  const unsigned side = left ? turn_left : turn_right;
  const unsigned bits = main && straight ? unsigned{turn_through} : straight ? (side | turn_through) : side;
  if (!in.arrows.empty() && take_arrow_lanes(in.arrows, bits, main, m)) {
    m.count_out = std::min(m.count_in, lanes_out);
    // Lanes that turn outwards enter outside, all others inside.
    m.first_out = straight || inwards ? 0 : lanes_out - m.count_out;
    if (straight && m.count_out == m.count_in) m.first_out = std::min(m.first_in, lanes_out - m.count_out);
    return;
  }
  if (main) {
    m.count_in = lanes_in, m.count_out = std::min(lanes_in, lanes_out);
    return;
  }
  m.count_in = m.count_out = std::clamp<std::size_t>(surplus, 1, lanes_out);
  m.first_in = inwards ? 0 : lanes_in - m.count_in, m.first_out = inwards ? 0 : lanes_out - m.count_out;
}

/// Whether both roads lead to the same other junction.
bool leads_back(const JunctionPlan& junctions, const JunctionEnd& from, const JunctionEnd& to) {
  const auto far_junction = [&](const JunctionEnd& end) {
    const Stretch& stretch = junctions.stretches[end.stretch];
    const VertexIndex vertex = end.at_begin ? stretch.vertex1 : stretch.vertex0;
    return vertex ? junctions.junction_of_vertex[vertex] : -1;
  };
  return far_junction(from) >= 0 && far_junction(from) == far_junction(to);
}

/// Movements from one end, without their lanes; the first one is the main one: the chain's own, or the straightest.
/// `sharp` collects turns that turn round; they are used only where a road has no other way in. `followed`:
/// restrictions over ways that one has come over.
std::vector<Movement> movements_from(const NetworkPlan& plan, const TurnRules& rules,
                                     const std::vector<InnerWay>& inside, const std::vector<JunctionEnd>& ends,
                                     const std::vector<Gate>& in, const std::vector<Gate>& out, std::size_t from,
                                     std::vector<Movement>& sharp, std::set<std::size_t>& followed) {
  std::vector<Movement> movements;
  if (in[from].lanes.empty()) return movements;
  const std::optional<DrivenWay> driven = driven_in(rules, way_to_cut(plan, rules, ends[from]));
  if (!driven) return movements;
  const std::vector<Arrival> arrivals =
      arrivals_from(plan, inside, rules, {ends[from].vertex, *driven, in[from].pose.direction});
  for (const Arrival& arrival : arrivals)
    for (const FollowedRestriction& f : arrival.driven.followed)
      if (rules.is_complete(f)) followed.insert(f.restriction);
  for (std::size_t to = 0; to < ends.size(); ++to) {
    bool reached = false, turned = true;
    std::vector<Leg> legs;  // of the first that comes there without turning round
    const InnerWay way_out = way_to_cut(plan, rules, ends[to]);
    for (const Arrival& arrival : arrivals) {
      if (arrival.vertex != ends[to].vertex ||
          !driven_over(rules, arrival.driven, node_of(plan, arrival.vertex), way_out, true))
        continue;
      const bool round = arrival.turned || (arrival.on && turns_round(arrival.direction, out[to].pose.direction));
      if (!reached || (turned && !round)) legs = arrival.legs;
      reached = true;
      turned = turned && round;
    }
    if (out[to].lanes.empty() || !reached) continue;
    // Back into the same road: only round a circuit, not round a block's inner drive.
    if (ends[to].stretch == ends[from].stretch && static_cast<int>(to) != ends[from].through) continue;
    movements.push_back({.from = static_cast<int>(from),
                         .to = static_cast<int>(to),
                         .turn_rad = angle_between(in[from].pose.direction, out[to].pose.direction),
                         .turned = turned,
                         .legs = std::move(legs)});
  }
  if (movements.empty()) return movements;
  const auto bend = [&](const Movement& m) {
    return std::pair{m.turned, m.to == ends[from].through ? -1.0 : std::abs(m.turn_rad)};
  };
  const auto main = std::min_element(movements.begin(), movements.end(),
                                     [&](const Movement& a, const Movement& b) { return bend(a) < bend(b); });
  std::rotate(movements.begin(), main, main + 1);
  const int main_to = movements.front().to;
  const bool main_turned = movements.front().turned;
  const auto is_sharp = [&](const Movement& m) {
    const bool back = leads_back(plan.junctions, ends[from], ends[as_index(m.to)]);
    return m.to != main_to &&
           ((m.turned && !main_turned) || std::abs(m.turn_rad) > (back ? max_turn_back_rad : max_turn_rad));
  };
  std::copy_if(movements.begin(), movements.end(), std::back_inserter(sharp), is_sharp);
  std::erase_if(movements, is_sharp);
  return movements;
}

/// Of the sharp turns into a road that nothing else leads into, the widest.
std::vector<Movement> only_ways_in(const std::vector<Movement>& movements, const std::vector<Movement>& sharp,
                                   std::size_t ends) {
  std::vector<Movement> only;
  for (std::size_t to = 0; to < ends; ++to) {
    const auto leads_there = [to](const Movement& m) { return m.to == static_cast<int>(to); };
    if (std::any_of(movements.begin(), movements.end(), leads_there)) continue;
    const Movement* widest = nullptr;
    for (const Movement& m : sharp)
      if (leads_there(m) && (!widest || std::abs(m.turn_rad) < std::abs(widest->turn_rad))) widest = &m;
    if (widest) only.push_back(*widest);
  }
  return only;
}

/// Turns back that are left out: from there a driver comes to that road only after turning round elsewhere.
void report_left_out(const NetworkPlan& plan, const std::vector<JunctionEnd>& ends, const std::vector<Gate>& in,
                     const std::vector<Movement>& movements, const std::vector<Movement>& sharp, Findings& findings) {
  constexpr double degrees = 180.0 / std::numbers::pi;
  for (const Movement& m : sharp) {
    const JunctionEnd &from = ends[as_index(m.from)], &to = ends[as_index(m.to)];
    const bool kept = std::ranges::any_of(
        movements, [&m](const Movement& other) { return other.from == m.from && other.to == m.to; });
    if (kept || m.turned || std::abs(m.turn_rad) > max_turn_rad) continue;
    findings.push_back({Severity::info, "network.turn_left_out",
                        fmt::format("no turn of {:.0f} degrees from way {} into way {}, which leads back",
                                    std::abs(m.turn_rad) * degrees, plan.roads.paths[from.path].osm_id,
                                    plan.roads.paths[to.path].osm_id),
                        in[as_index(m.from)].pose.p.x, in[as_index(m.from)].pose.p.y});
  }
}

/// Every lane out of the junction is fed: where more lanes lead out than any way in brings, the outermost lane (or
/// innermost, for what opens inside) of the straightest way in leads into the others, too.
void feed_all_lanes(const std::vector<JunctionEnd>& ends, const std::vector<Gate>& out,
                    std::vector<Movement>& movements) {
  const std::size_t own = movements.size();
  for (std::size_t to = 0; to < ends.size(); ++to) {
    std::vector<bool> fed(out[to].lanes.size(), false);
    const Movement* main = nullptr;
    const auto bend = [&](const Movement& m) {
      return ends[as_index(m.from)].through == m.to ? -1.0 : std::abs(m.turn_rad);
    };
    for (std::size_t i = 0; i < own; ++i) {
      const Movement& m = movements[i];
      if (m.to != static_cast<int>(to)) continue;
      for (std::size_t k = 0; k < std::min(m.count_in, m.count_out); ++k) fed[m.first_out + k] = true;
      if (!main || bend(m) < bend(*main)) main = &m;
    }
    if (!main) continue;
    const Movement best = *main;
    for (std::size_t lane = 0; lane < fed.size(); ++lane) {
      if (fed[lane]) continue;
      Movement m = best;
      m.first_in = lane < best.first_out ? best.first_in : best.first_in + best.count_in - 1;
      m.first_out = lane, m.count_in = m.count_out = 1;
      movements.push_back(m);
    }
  }
}

/// The middle of a gate's lane.
Vec2 middle_of(const Gate& gate, std::size_t lane, DrivingSide driving_side) {
  const double side = driving_side == DrivingSide::left ? 1.0 : -1.0;
  const double t = gate.inner_t_m + side * (lane_from_m(gate, lane) + 0.5 * lane_width_m(gate, lane));
  return gate.pose.p + left_normal(gate.pose.direction) * t;
}

/// Lanes turn round towards the oncoming traffic: not into a lane that lies on their other side, as where the map draws
/// carriageways nearer to each other than their lanes are wide.
void keep_lanes_that_have_room(const NetworkPlan& plan, const std::vector<JunctionEnd>& ends,
                               const std::vector<Gate>& in, const std::vector<Gate>& out,
                               std::vector<Movement>& movements, Findings& findings) {
  constexpr double back_rad = 175.0 * std::numbers::pi / 180.0;  // beyond, the side is that of the oncoming traffic
  const DrivingSide driving_side = plan.options.driving_side;
  const auto has_room = [&](const Movement& m, std::size_t lane) {
    const Gate &from = in[as_index(m.from)], &to = out[as_index(m.to)];
    const bool left = std::abs(m.turn_rad) > back_rad ? driving_side == DrivingSide::right : m.turn_rad > 0.0;
    const Vec2 inwards = left_normal(from.pose.direction) * (left ? 1.0 : -1.0);
    const Vec2 across =
        middle_of(to, m.first_out + lane, driving_side) - middle_of(from, m.first_in + lane, driving_side);
    return dot(across, inwards) > 0.0;
  };
  for (Movement& m : movements) {
    if (!m.legs.empty() || std::abs(m.turn_rad) <= max_turn_rad) continue;
    std::size_t first = 0, end = std::min(m.count_in, m.count_out);
    while (first < end && !has_room(m, first)) ++first;
    while (end > first && !has_room(m, end - 1)) --end;
    if (end - first == std::min(m.count_in, m.count_out)) continue;
    findings.push_back({Severity::warning, "network.no_room_to_turn",
                        fmt::format("{} of {} lanes turn round from way {} into way {}: the others lie across each "
                                    "other, as the carriageways are drawn",
                                    end - first, std::min(m.count_in, m.count_out),
                                    plan.roads.paths[ends[as_index(m.from)].path].osm_id,
                                    plan.roads.paths[ends[as_index(m.to)].path].osm_id),
                        in[as_index(m.from)].pose.p.x, in[as_index(m.from)].pose.p.y});
    m.first_in += first, m.first_out += first, m.count_in = m.count_out = end - first;
  }
  std::erase_if(movements, [](const Movement& m) { return m.count_in == 0; });
}

}  // namespace

std::vector<Movement> movements_of(const NetworkPlan& plan, const TurnRules& rules, const std::vector<InnerWay>& inside,
                                   const std::vector<JunctionEnd>& ends, const std::vector<Gate>& in,
                                   const std::vector<Gate>& out, std::set<std::size_t>& followed, Findings& findings) {
  std::vector<Movement> movements, sharp;
  for (std::size_t from = 0; from < ends.size(); ++from) {
    std::vector<Movement> on = movements_from(plan, rules, inside, ends, in, out, from, sharp, followed);
    for (std::size_t i = 0; i < on.size(); ++i) {
      const std::size_t lanes = in[from].lanes.size(), lanes_on = out[as_index(on[0].to)].lanes.size();
      choose_lanes(on[i], i == 0, on[0].turn_rad, lanes - std::min(lanes, lanes_on), in[from], out[as_index(on[i].to)],
                   plan.options.driving_side);
      movements.push_back(on[i]);
    }
  }
  for (Movement& m : only_ways_in(movements, sharp, ends.size())) {
    choose_lanes(m, false, 0.0, 0, in[as_index(m.from)], out[as_index(m.to)], plan.options.driving_side);
    movements.push_back(m);
  }
  report_left_out(plan, ends, in, movements, sharp, findings);
  feed_all_lanes(ends, out, movements);
  keep_lanes_that_have_room(plan, ends, in, out, movements, findings);
  return movements;
}

}  // namespace orthodrive::network
