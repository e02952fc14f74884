#include <algorithm>
#include <array>
#include <cmath>

#include "orthodrive/core/error.hpp"
#include "orthodrive/model/rasters.hpp"

namespace orthodrive {
namespace {

struct Costs {
  std::array<float, 256> outside{}, inside{};  // 0..255, by label
  std::array<bool, 256> known{}, road{};
};

Costs costs_of(const ClassTable& table) {
  Costs costs;
  for (std::size_t i = 0; i < std::min<std::size_t>(table.classes.size(), label_nodata); ++i) {
    costs.outside[i] = static_cast<float>(255.0 * table.classes[i].cost_false_positive);
    costs.inside[i] = static_cast<float>(255.0 * table.classes[i].cost_false_negative);
    costs.known[i] = true;
    costs.road[i] = table.classes[i].role == Role::road;
  }
  return costs;
}

std::uint8_t byte_of(float value) { return static_cast<std::uint8_t>(std::lround(value)); }

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
  const Costs costs = costs_of(labels.classes);
  RoadEvidence evidence{labels.crs, labels.frame, labels.labels, labels.labels};
  for (std::size_t i = 0; i < labels.labels.data.size(); ++i) {
    const std::uint8_t label = labels.labels.data[i], road = road_probability.confidence.data[i];
    const float p = static_cast<float>(road) / 255.0F;
    // Where road has won, the class of the rest is not known: as bad as any.
    const float rest_outside = costs.road[label] ? 0.0F : costs.outside[label], rest_inside = costs.road[label] ? 255.0F : costs.inside[label];
    evidence.outside.data[i] = costs.known[label] ? byte_of(p * 255.0F + (1.0F - p) * rest_outside) : std::uint8_t{0};
    evidence.inside.data[i] = costs.known[label] ? byte_of((1.0F - p) * rest_inside) : std::uint8_t{0};
  }
  return evidence;
}

}  // namespace orthodrive
