#include "orthodrive/drive/envelope_table.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

namespace orthodrive {
namespace {

/// Two neighbouring nodes and the weight of the second.
struct Between {
  std::size_t low = 0;
  double weight = 0.0;
};

Between between(std::span<const double> nodes, double value, bool extrapolate) {
  const auto after = std::upper_bound(nodes.begin() + 1, nodes.end() - 1, value);
  const auto i = static_cast<std::size_t>(after - nodes.begin()) - 1;
  const double weight = (value - nodes[i]) / (nodes[i + 1] - nodes[i]);
  return {i, extrapolate ? std::max(weight, 0.0) : std::clamp(weight, 0.0, 1.0)};
}

}  // namespace

EnvelopeTable::EnvelopeTable(const vehicle::CarParameters& car) {
  constexpr std::size_t nodes = speeds * normals * frictions;
  lateral_mps2_.resize(nodes), limits_.resize(nodes * shares);
  for (std::size_t v = 0; v < speeds; ++v)
    for (std::size_t n = 0; n < normals; ++n)
      for (std::size_t f = 0; f < frictions; ++f) {
        vehicle::EnvelopeQuery query{speed_step_mps * static_cast<double>(v), normal_mps2[n], 0.0, friction[f]};
        const double most = vehicle::envelope(car, query).max_lateral_mps2;
        lateral_mps2_[node(v, n, f)] = most;
        for (std::size_t k = 0; k < shares; ++k) {
          const double angle = 0.5 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(shares - 1);
          query.lateral_mps2 = most * std::sin(angle);
          const vehicle::Envelope e = vehicle::envelope(car, query);
          limits_[node(v, n, f) * shares + k] = {e.max_drive_mps2, e.max_brake_mps2};
        }
      }
}

vehicle::Envelope EnvelopeTable::at(const vehicle::EnvelopeQuery& query) const {
  const double place = std::clamp(query.speed_mps / speed_step_mps, 0.0, static_cast<double>(speeds - 1));
  const auto v = std::min(static_cast<std::size_t>(place), speeds - 2);
  const std::array<Between, 3> at = {Between{v, place - static_cast<double>(v)},
                                     between(normal_mps2, query.normal_mps2, false),
                                     between(friction, query.friction, true)};
  // The eight nodes around the place and their weights.
  std::array<std::size_t, 8> corner{};
  std::array<double, 8> weight{};
  vehicle::Envelope e;
  for (std::size_t c = 0; c < 8; ++c) {
    const std::array<std::size_t, 3> high = {c & 1, (c >> 1) & 1, c >> 2};
    corner[c] = node(at[0].low + high[0], at[1].low + high[1], at[2].low + high[2]);
    weight[c] = 1.0;
    for (std::size_t i = 0; i < 3; ++i) weight[c] *= high[i] == 1 ? at[i].weight : 1.0 - at[i].weight;
    e.max_lateral_mps2 += weight[c] * lateral_mps2_[corner[c]];
  }
  const double used = std::min(std::abs(query.lateral_mps2) / std::max(e.max_lateral_mps2, 1e-3), 1.0);
  const double turn = std::asin(used) / (0.5 * std::numbers::pi) * static_cast<double>(shares - 1);
  const auto k = std::min(static_cast<std::size_t>(turn), shares - 2);
  const double u = turn - static_cast<double>(k);
  for (std::size_t c = 0; c < 8; ++c) {
    const Limits &a = limits_[corner[c] * shares + k], &b = limits_[corner[c] * shares + k + 1];
    e.max_drive_mps2 += weight[c] * ((1.0 - u) * a.drive_mps2 + u * b.drive_mps2);
    e.max_brake_mps2 += weight[c] * ((1.0 - u) * a.brake_mps2 + u * b.brake_mps2);
  }
  return e;
}

}  // namespace orthodrive
