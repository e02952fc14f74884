// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/line/connecting_line.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace orthodrive::network {
namespace {

constexpr double turn_reach_m = 15.0;    // a right angle on a radius of 15 m
constexpr double least_radius_m = 12.0;  // a car turns with 6 m, a lorry with 12 m
// The line is straight where it leaves and enters a road, as long as a turn of 6 m keeps room: so a turning car passes
// one that waits.
constexpr double straight_end_m = 4.0, least_reach_m = 6.0;
constexpr double shallow_turn_rad = 35.0 * std::numbers::pi / 180.0;
constexpr double calm_acceleration_mps2 = 1.5;
constexpr double shortest_leg_m = 20.0;  // between two turns

double length_m(const Leg& leg) { return std::abs(leg.s1 - leg.s0); }

std::vector<roadquery::PlanElement> line_of(const ChainGeometries& geometry, const Leg& leg) {
  const auto& plan = geometry[leg.chain].plan;
  return leg.s0 <= leg.s1 ? slice_plan(plan, leg.s0, leg.s1) : reverse_plan(slice_plan(plan, leg.s1, leg.s0));
}

/// At a distance from where the leg begins.
Pose pose_on(const ChainGeometries& geometry, const Leg& leg, double along_m) {
  const double sign = leg.s0 <= leg.s1 ? 1.0 : -1.0;
  const Pose pose = pose_at(geometry[leg.chain].plan, leg.s0 + sign * along_m);
  return {pose.p, pose.direction * sign};
}

/// How far from where two legs meet the turn between them begins and ends.
double reach_m(const ChainGeometries& geometry, const Leg& in, const Leg& out, double speed_mps) {
  const Vec2 a = pose_on(geometry, in, std::max(0.0, length_m(in) - turn_reach_m)).direction;
  const Vec2 b = pose_on(geometry, out, std::min(length_m(out), turn_reach_m)).direction;
  const double turn_rad = std::abs(std::atan2(cross(a, b), dot(a, b)));
  const double calm_radius_m = speed_mps * speed_mps / calm_acceleration_mps2;
  const double radius_m = turn_rad < shallow_turn_rad ? std::max(calm_radius_m, least_radius_m) : least_radius_m;
  return std::max(turn_reach_m, radius_m * std::tan(0.5 * turn_rad));
}

void append(std::vector<roadquery::PlanElement>& line, std::vector<roadquery::PlanElement> more) {
  const double length = plan_length(line);
  for (roadquery::PlanElement& e : more) {
    e.s += length;
    line.push_back(std::move(e));
  }
}

}  // namespace

std::vector<roadquery::PlanElement> turn_from(const Pose& from, const Pose& to) {
  std::vector<roadquery::PlanElement> line = turn({{}, from.direction}, {to.p - from.p, to.direction});
  for (roadquery::PlanElement& e : line) e.x += from.p.x, e.y += from.p.y;
  return line;
}

std::vector<roadquery::PlanElement> connecting_line(const ChainGeometries& geometry, std::vector<Leg> legs,
                                                    double speed_mps) {
  const auto is_short = [](const Leg& leg) { return length_m(leg) < shortest_leg_m; };
  legs.erase(std::remove_if(legs.begin() + 1, legs.end() - 1, is_short), legs.end() - 1);
  std::vector<double> keep0(legs.size(), 0.0), keep1;  // what the line has of every leg, from where it begins
  for (const Leg& leg : legs) keep1.push_back(length_m(leg));
  for (std::size_t i = 0; i + 1 < legs.size(); ++i) {
    const double reach = reach_m(geometry, legs[i], legs[i + 1], speed_mps);
    const auto room = [&](std::size_t k) {
      const double length = length_m(legs[k]);
      if (k > 0 && k + 1 < legs.size()) return 0.5 * length;
      return std::max(length - straight_end_m, std::min(length, least_reach_m));
    };
    keep1[i] = length_m(legs[i]) - std::min(reach, room(i));
    keep0[i + 1] = std::min(reach, room(i + 1));
  }
  std::vector<roadquery::PlanElement> line;
  for (std::size_t i = 0; i < legs.size(); ++i) {
    const double sign = legs[i].s0 <= legs[i].s1 ? 1.0 : -1.0;
    if (keep1[i] > keep0[i])
      append(line, line_of(geometry, {legs[i].chain, legs[i].s0 + sign * keep0[i], legs[i].s0 + sign * keep1[i]}));
    if (i + 1 < legs.size())
      append(line, turn_from(pose_on(geometry, legs[i], keep1[i]), pose_on(geometry, legs[i + 1], keep0[i + 1])));
  }
  return line;
}

}  // namespace orthodrive::network
