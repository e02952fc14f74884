// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/roads/ring_paths.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <numeric>
#include <utility>

#include "orthodrive/geo/roundness.hpp"
#include "orthodrive/model/roads/highway_class.hpp"
#include "orthodrive/model/roads/osm_node_id.hpp"

namespace orthodrive {
namespace {

constexpr double least_round_m = 25.0, most_round_m = 220.0, least_roundness = 0.92;
constexpr std::size_t most_parts = 12;

class RingSearch {
 public:
  explicit RingSearch(const RoadNetwork& roads)
      : roads_(roads), on_ring_(roads.paths.size(), false), first_of_ring_(roads.paths.size()) {
    std::iota(first_of_ring_.begin(), first_of_ring_.end(), std::size_t{0});
    std::map<std::int64_t, std::size_t> tagged_at;  // a node, and a tagged way that ends there
    for (std::size_t i = 0; i < roads.paths.size(); ++i) {
      const RoadPath& path = roads.paths[i];
      on_ring_[i] = path.roundabout;
      for (const std::int64_t node : {path.nodes.front().osm_node, path.nodes.back().osm_node})
        if (path.roundabout && is_osm_node(node)) unite(i, tagged_at.try_emplace(node, i).first->second);
      lengths_m_.push_back(length_m(centerline(path)));
      const bool may_be_part = path.oneway == Oneway::forward && !is_raceway(path.highway) && !path.tunnel &&
                               is_osm_node(path.nodes.front().osm_node) && is_osm_node(path.nodes.back().osm_node) &&
                               lengths_m_.back() <= most_round_m;
      if (may_be_part) from_[path.nodes.front().osm_node].push_back(i);
    }
  }

  std::vector<int> run() {
    for (const auto& [node, paths] : from_)
      for (const std::size_t path : paths)
        if (!on_ring_[path]) extend({path}, lengths_m_[path]);
    std::vector<int> ring(roads_.paths.size(), -1);
    int count = 0;
    for (std::size_t i = 0; i < ring.size(); ++i)
      if (on_ring_[i]) ring[i] = first_of(i) == i ? count++ : ring[first_of(i)];
    return ring;
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
    for (const std::size_t part : parts) on_ring_[part] = true, unite(part, parts.front());
    return true;
  }

  /// The lowest path of its ring.
  [[nodiscard]] std::size_t first_of(std::size_t path) const {
    while (first_of_ring_[path] != path) path = first_of_ring_[path];
    return path;
  }
  void unite(std::size_t a, std::size_t b) {
    const auto [low, high] = std::minmax({first_of(a), first_of(b)});
    first_of_ring_[high] = low;
  }

  const RoadNetwork& roads_;
  std::vector<bool> on_ring_;
  std::vector<std::size_t> first_of_ring_;  ///< a lower path of the same ring, or itself
  std::vector<double> lengths_m_;
  std::map<std::int64_t, std::vector<std::size_t>> from_;  ///< one-way paths by the node that they begin at
};

}  // namespace

std::vector<int> rings_of_paths(const RoadNetwork& roads) { return RingSearch(roads).run(); }

double usual_ring_width_m(double centre_line_m) {
  struct Design {
    double outer_diameter_m, width_m;
  };
  constexpr std::array<Design, 6> designs{{{13, 4.0}, {22, 6.0}, {26, 6.75}, {30, 6.0}, {35, 5.25}, {40, 4.875}}};
  const double middle_m =
      centre_line_m / std::numbers::pi;  // diameter of the centre line: that of the edge less a width
  const auto middle_of = [](const Design& d) { return d.outer_diameter_m - d.width_m; };
  const auto after = std::ranges::upper_bound(designs, middle_m, {}, middle_of);
  if (after == designs.begin()) return designs.front().width_m;
  if (after == designs.end()) return designs.back().width_m;
  const Design &a = *(after - 1), &b = *after;
  return std::lerp(a.width_m, b.width_m, (middle_m - middle_of(a)) / (middle_of(b) - middle_of(a)));
}

}  // namespace orthodrive
