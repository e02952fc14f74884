// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/roads/path_overlaps.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "orthodrive/geo/polyline.hpp"
#include "orthodrive/geo/spatial_index.hpp"

namespace orthodrive {
namespace {

constexpr double overlap_step_m = 10.0, least_overlap_m = 0.5, least_along_cos = 0.7071;
constexpr double on_top_m = 2.0;     // without a bridge or tunnel, a layer beside another is a slip of the mapper
constexpr double narrowest_m = 3.0;  // as for crossings: a road without a width is a lane

double half_carriageway_m(const RoadPath& path, std::size_t segment) {
  return 0.5 * std::max(narrowest_m, path.nodes[segment].width_m);
}

class OverlapSearch {
 public:
  explicit OverlapSearch(const RoadNetwork& roads) : roads_(roads) {
    for (const RoadPath& path : roads.paths) {
      lines_.push_back(centerline(path));
      for (const RoadNode& node : path.nodes) widest_m_ = std::max(widest_m_, node.width_m);
    }
    index_ = SegmentIndex(lines_);
  }

  std::vector<PathOverlap> run() {
    for (std::size_t p = 0; p < lines_.size(); ++p) {
      double next_m = 0.0, s_m = 0.0;
      for (std::size_t i = 0; i + 1 < lines_[p].size(); ++i) {
        const double length = distance(lines_[p][i], lines_[p][i + 1]);
        for (; length > 0.0 && next_m <= s_m + length; next_m += overlap_step_m)
          look_below(p, i, (next_m - s_m) / length);
        s_m += length;
      }
    }
    return std::move(overlaps_);
  }

 private:
  void look_below(std::size_t upper, std::size_t segment, double fraction) {
    const RoadPath& above = roads_.paths[upper];
    const Vec2 a = lines_[upper][segment], along = normalized(lines_[upper][segment + 1] - a);
    const Vec2 p = a + (lines_[upper][segment + 1] - a) * fraction;
    const double half_m = half_carriageway_m(above, segment);
    std::map<std::size_t, PathOverlap> of_lower;  // the nearest place of each
    for (const auto [lower, k] : index_.near(p, half_m + 0.5 * std::max(narrowest_m, widest_m_))) {
      const RoadPath& below = roads_.paths[lower];
      if (below.layer >= above.layer) continue;
      const Vec2 b = lines_[lower][k], span = lines_[lower][k + 1] - b;
      const double length2 = dot(span, span), f = length2 > 0.0 ? dot(p - b, span) / length2 : -1.0;
      if (f < 0.0 || f > 1.0 || std::abs(dot(normalized(span), along)) < least_along_cos) continue;
      const double away_m = distance(p, b + span * f);
      const bool is_structure = above.bridge || below.tunnel;
      if (away_m > (is_structure ? half_m + half_carriageway_m(below, k) - least_overlap_m : on_top_m)) continue;
      const auto known = of_lower.find(lower);
      if (known != of_lower.end() && known->second.distance_m <= away_m) continue;
      PathOverlap overlap{{upper, lower, segment, k, fraction, f, p}, away_m, true};
      if (lower < upper) {
        std::swap(overlap.at.path_a, overlap.at.path_b), std::swap(overlap.at.segment_a, overlap.at.segment_b);
        std::swap(overlap.at.fraction_a, overlap.at.fraction_b);
        overlap.a_is_above = false;
      }
      of_lower[lower] = overlap;
    }
    for (const auto& [lower, overlap] : of_lower) overlaps_.push_back(overlap);
  }

  const RoadNetwork& roads_;
  std::vector<Polyline> lines_;
  double widest_m_ = 0.0;
  SegmentIndex index_;
  std::vector<PathOverlap> overlaps_;
};

}  // namespace

std::vector<PathOverlap> find_overlaps(const RoadNetwork& roads) { return OverlapSearch(roads).run(); }

}  // namespace orthodrive
