// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "orthodrive/core/error.hpp"
#include "orthodrive/model/rasters/rasters.hpp"

namespace orthodrive {
namespace {

/// Cost inside a road of a pixel that is surely none, against 1 for a sure road outside: the edge of a road then lies
/// where its probability is 0.75 / 1.75 = 43 %. About a third of what lies within 4 m of hand-drawn carriageways is
/// road.
constexpr float no_road_inside = 0.75F;

struct Costs {
  std::array<float, 256> outside{}, inside{};  // 0..255, by label
  std::array<bool, 256> known{}, road{}, maybe{};
};

Costs costs_of(const ClassTable& table) {
  Costs costs;
  for (std::size_t i = 0; i < std::min<std::size_t>(table.classes.size(), label_nodata); ++i) {
    costs.outside[i] = static_cast<float>(255.0 * table.classes[i].cost_false_positive);
    costs.inside[i] = static_cast<float>(255.0 * table.classes[i].cost_false_negative);
    costs.known[i] = true;
    costs.road[i] = table.classes[i].role == Role::road;
    costs.maybe[i] = table.classes[i].role == Role::maybe_road;
  }
  return costs;
}

std::uint8_t byte_of(float value) { return static_cast<std::uint8_t>(std::lround(value)); }

struct PixelCosts {
  std::uint8_t outside = 0, inside = 0;
};

/// For every label, every probability of road that a byte holds.
std::vector<PixelCosts> costs_by_bytes(const Costs& costs) {
  std::vector<PixelCosts> table(256 * 256);
  for (std::size_t label = 0; label < 256; ++label) {
    if (!costs.known[label]) continue;
    const float rest_outside = costs.road[label] ? 0.0F : costs.outside[label];
    const float rest_inside = costs.maybe[label] ? costs.inside[label] : 255.0F * no_road_inside;
    for (std::size_t road = 0; road < 256; ++road) {
      const float p = static_cast<float>(road) / 255.0F;
      table[256 * label + road] = {byte_of(p * 255.0F + (1.0F - p) * rest_outside), byte_of((1.0F - p) * rest_inside)};
    }
  }
  return table;
}

}  // namespace

RoadEvidence road_evidence(const LabelMap& labels) {
  const Costs costs = costs_of(labels.classes);
  RoadEvidence evidence{labels.crs, labels.frame, labels.labels, labels.labels};
  for (std::uint8_t& cost : evidence.outside.data) cost = byte_of(costs.outside[cost]);
  for (std::uint8_t& cost : evidence.inside.data) cost = byte_of(costs.inside[cost]);
  return evidence;
}

RoadEvidence road_evidence(const LabelMap& labels, const ConfidenceMap& road_probability) {
  if (!(labels.frame == road_probability.frame) || !(labels.crs == road_probability.crs))
    throw OptionError("the road probability is on another grid than the labels: take both from one run of `segment`");
  const std::vector<PixelCosts> by_bytes = costs_by_bytes(costs_of(labels.classes));
  RoadEvidence evidence{labels.crs, labels.frame, labels.labels, labels.labels};
  for (std::size_t i = 0; i < labels.labels.data.size(); ++i) {
    const PixelCosts& costs = by_bytes[256 * labels.labels.data[i] + road_probability.confidence.data[i]];
    evidence.outside.data[i] = costs.outside;
    evidence.inside.data[i] = costs.inside;
  }
  return evidence;
}

}  // namespace orthodrive
