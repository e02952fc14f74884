#include "orthodrive/roads/ring_paths.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>

#include "orthodrive/geo/roundness.hpp"

namespace orthodrive {
namespace {

constexpr double least_round_m = 25.0, most_round_m = 220.0, least_roundness = 0.92;
constexpr std::size_t most_parts = 12;

class RingSearch {
 public:
  explicit RingSearch(const RoadNetwork& roads) : roads_(roads), on_ring_(roads.paths.size(), false) {
    for (std::size_t i = 0; i < roads.paths.size(); ++i) {
      const RoadPath& path = roads.paths[i];
      on_ring_[i] = path.roundabout;
      lengths_m_.push_back(length_m(centerline(path)));
      const bool may_be_part = path.oneway == Oneway::forward && path.highway != "raceway" && !path.tunnel &&
                               path.nodes.front().osm_node > 0 && path.nodes.back().osm_node > 0 &&
                               lengths_m_.back() <= most_round_m;
      if (may_be_part) from_[path.nodes.front().osm_node].push_back(i);
    }
  }

  std::vector<bool> run() {
    for (const auto& [node, paths] : from_)
      for (const std::size_t path : paths)
        if (!on_ring_[path]) extend({path}, lengths_m_[path]);
    return std::move(on_ring_);
  }

 private:
  /// A path may be part of several loops; the first round one counts.
  bool extend(std::vector<std::size_t> parts, double length_m) {
    const std::int64_t begin = roads_.paths[parts.front()].nodes.front().osm_node,
                       end = roads_.paths[parts.back()].nodes.back().osm_node;
    if (begin == end) return length_m >= least_round_m && accept(parts);
    if (parts.size() == most_parts) return false;
    const auto next = from_.find(end);
    if (next == from_.end()) return false;
    for (const std::size_t path : next->second) {
      if (length_m + lengths_m_[path] > most_round_m || std::ranges::find(parts, path) != parts.end()) continue;
      std::vector<std::size_t> longer = parts;
      longer.push_back(path);
      if (extend(std::move(longer), length_m + lengths_m_[path])) return true;
    }
    return false;
  }

  bool accept(const std::vector<std::size_t>& parts) {
    Ring ring;
    for (const std::size_t part : parts)
      for (std::size_t i = 0; i + 1 < roads_.paths[part].nodes.size(); ++i)
        ring.push_back(roads_.paths[part].nodes[i].p);
    if (std::abs(roundness(ring)) < least_roundness) return false;
    for (const std::size_t part : parts) on_ring_[part] = true;
    return true;
  }

  const RoadNetwork& roads_;
  std::vector<bool> on_ring_;
  std::vector<double> lengths_m_;
  std::map<std::int64_t, std::vector<std::size_t>> from_;  ///< one-way paths by the node that they begin at
};

}  // namespace

std::vector<bool> paths_on_rings(const RoadNetwork& roads) { return RingSearch(roads).run(); }

}  // namespace orthodrive
