// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/drive/car/envelope_table.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace orthodrive {
namespace {

/// Two neighbouring nodes and the weight of the second.
struct Between {
  std::size_t low = 0;
  double weight = 0.0;
};

/// `place` in steps from the first of so many nodes; beyond the last it stays there or goes on.
Between between(double place, std::size_t nodes, bool goes_on) {
  const double inside = std::clamp(place, 0.0, static_cast<double>(nodes - 1));
  const auto low = std::min(static_cast<std::size_t>(inside), nodes - 2);
  return {low, (goes_on ? std::max(place, 0.0) : inside) - static_cast<double>(low)};
}

}  // namespace

EnvelopeTable::EnvelopeTable(const vehicle::CarParameters& car)
    : car_(car), front_slip_(car, true), rear_slip_(car, false) {
  constexpr std::size_t nodes = speeds * normals * frictions;
  lateral_mps2_.resize(nodes), grip_.resize(nodes * shares);
  for (std::size_t v = 0; v < speeds; ++v)
    for (std::size_t n = 0; n < normals; ++n)
      for (std::size_t f = 0; f < frictions; ++f) {
        vehicle::EnvelopeQuery query{speed_step_mps * static_cast<double>(v), normal_step_mps2 * static_cast<double>(n),
                                     0.0, friction_step * static_cast<double>(f + 1)};
        double& most = lateral_mps2_[node(v, n, f)];
        for (std::size_t k = 0; k < shares; ++k) {
          const double angle = 0.5 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(shares - 1);
          query.lateral_mps2 = most * std::sin(angle);  // none at first
          const vehicle::Grip grip = vehicle::grip_of(car, query);
          most = grip.max_lateral_mps2;
          grip_[node(v, n, f) * shares + k] = grip;
        }
      }
}

EnvelopeTable::Nodes EnvelopeTable::around(const vehicle::EnvelopeQuery& query) {
  const std::array<Between, 3> at = {between(query.speed_mps / speed_step_mps, speeds, false),
                                     between(query.normal_mps2 / normal_step_mps2, normals, false),
                                     between(query.friction / friction_step - 1.0, frictions, true)};
  Nodes nodes;
  for (std::size_t c = 0; c < 8; ++c) {
    const std::array<std::size_t, 3> high = {c & 1, (c >> 1) & 1, c >> 2};
    nodes.at[c] = node(at[0].low + high[0], at[1].low + high[1], at[2].low + high[2]);
    nodes.weight[c] = 1.0;
    for (std::size_t i = 0; i < 3; ++i) nodes.weight[c] *= high[i] == 1 ? at[i].weight : 1.0 - at[i].weight;
  }
  return nodes;
}

double EnvelopeTable::lateral_at(const Nodes& nodes) const {
  double lateral = 0.0;
  for (std::size_t c = 0; c < 8; ++c) lateral += nodes.weight[c] * lateral_mps2_[nodes.at[c]];
  return lateral;
}

vehicle::Grip EnvelopeTable::look_up(const vehicle::EnvelopeQuery& query) const {
  const Nodes nodes = around(query);
  const double used = std::min(std::abs(query.lateral_mps2) / std::max(lateral_at(nodes), 1e-3), 1.0);
  const Between share =
      between(std::asin(used) / (0.5 * std::numbers::pi) * static_cast<double>(shares - 1), shares, false);
  vehicle::Grip grip;
  const auto add = [&](double weight, const vehicle::Grip& node) {
    grip.driving_mps2 += weight * node.driving_mps2;
    grip.holding_drive_mps2 += weight * node.holding_drive_mps2;
    grip.holding_brake_mps2 += weight * node.holding_brake_mps2;
    for (std::size_t i = 0; i < 2; ++i) {
      grip.rolling_n[i] += weight * node.rolling_n[i];
      grip.driving_n[i] += weight * node.driving_n[i];
    }
    for (std::size_t i = 0; i < 4; ++i) {
      grip.braking_n[i] += weight * node.braking_n[i];
      grip.brakes_n[i] += weight * node.brakes_n[i];
    }
  };
  for (std::size_t c = 0; c < 8; ++c) {
    const vehicle::Grip* node = &grip_[nodes.at[c] * shares + share.low];
    add(nodes.weight[c] * (1.0 - share.weight), node[0]);
    add(nodes.weight[c] * share.weight, node[1]);
  }
  return grip;
}

double EnvelopeTable::max_lateral_mps2(const vehicle::EnvelopeQuery& query) const { return lateral_at(around(query)); }

double EnvelopeTable::max_drive_mps2(const vehicle::EnvelopeQuery& query, double slope_mps2) const {
  constexpr int rounds = 6;
  const vehicle::Grip grip = look_up(query);
  const double mass = car_.body.mass_kg, front = car_.differential.front_share;
  const vehicle::FullDrive engine = vehicle::full_drive(car_, query.speed_mps);
  const double resisting_mps2 = vehicle::resistance_n(car_, query.speed_mps, query.normal_mps2) / mass;
  // The acceleration moves load between the axles, and what they hold limits it; it also spins up wheels and engine.
  const double against_mps2 = resisting_mps2 + slope_mps2;
  double along =
      std::min(grip.driving_mps2, (engine.force_n + engine.spinning_kg * against_mps2) / (mass + engine.spinning_kg));
  for (int n = 0; n < rounds; ++n) {
    const double engine_n = engine.force_n - engine.spinning_kg * (along - against_mps2);
    const double u = grip.driving_mps2 > 0.0 ? along / grip.driving_mps2 : 0.0;
    const auto axle = [&](std::size_t i) { return grip.rolling_n[i] + u * (grip.driving_n[i] - grip.rolling_n[i]); };
    along = (std::min(axle(0), front * engine_n) + std::min(axle(1), (1.0 - front) * engine_n)) / mass;
  }
  return std::min(along, grip.holding_drive_mps2) - resisting_mps2;
}

double EnvelopeTable::max_brake_mps2(const vehicle::EnvelopeQuery& query) const {
  const vehicle::Grip grip = look_up(query);
  double sum_n = 0.0;
  for (std::size_t i = 0; i < 4; ++i) sum_n += std::min(grip.braking_n[i], grip.brakes_n[i]);
  const double mass = car_.body.mass_kg;
  return std::min(sum_n / mass, grip.holding_brake_mps2) +
         vehicle::resistance_n(car_, query.speed_mps, query.normal_mps2) / mass;
}

vehicle::Envelope EnvelopeTable::at(const vehicle::EnvelopeQuery& query) const {
  return {max_lateral_mps2(query), max_drive_mps2(query), max_brake_mps2(query)};
}

}  // namespace orthodrive
