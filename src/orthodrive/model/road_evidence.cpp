#include <algorithm>
#include <array>
#include <cmath>

#include "orthodrive/model/rasters.hpp"

namespace orthodrive {

RoadEvidence road_evidence(const LabelMap& labels) {
  std::array<std::uint8_t, 256> outside{}, inside{};
  for (std::size_t i = 0; i < std::min<std::size_t>(labels.classes.classes.size(), label_nodata); ++i) {
    outside[i] = static_cast<std::uint8_t>(std::lround(255.0 * labels.classes.classes[i].cost_false_positive));
    inside[i] = static_cast<std::uint8_t>(std::lround(255.0 * labels.classes.classes[i].cost_false_negative));
  }
  RoadEvidence evidence{labels.crs, labels.frame, labels.labels, labels.labels};
  for (std::uint8_t& cost : evidence.outside.data) cost = outside[cost];
  for (std::uint8_t& cost : evidence.inside.data) cost = inside[cost];
  return evidence;
}

}  // namespace orthodrive
