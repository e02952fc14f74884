// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/roads/continuation.hpp"

#include <algorithm>
#include <cmath>

namespace orthodrive {

double bend_rad(const MeetingEnd& from, const MeetingEnd& to) {
  const Vec2 in = from.direction * -1.0;
  return std::abs(std::atan2(cross(in, to.direction), dot(in, to.direction)));
}

Vec2 direction_into(std::span<const Vec2> line, const ContinuationRule& rule) {
  const bool whole_line = rule.look_ahead_share >= 1.0;  // point_at ends where the line does
  const double reach_m =
      whole_line ? rule.look_ahead_m : std::min(rule.look_ahead_m, rule.look_ahead_share * length_m(line));
  return normalized(point_at(line, reach_m) - line.front());
}

namespace {

/// Nobody may drive from one into the other, either way round.
bool is_closed(const MeetingEnd& a, const MeetingEnd& b) {
  return a.path->oneway != Oneway::no && b.path->oneway != Oneway::no && a.at_last == b.at_last;
}

double largest_bend_rad(const MeetingEnd& a, const MeetingEnd& b, bool alone, const ContinuationRule& rule) {
  if (alone) return is_closed(a, b) ? rule.max_bend_apart_rad : rule.max_bend_alone_rad;
  return a.ring >= 0 && a.ring == b.ring ? rule.max_bend_on_ring_rad : rule.max_bend_rad;
}

}  // namespace

std::vector<std::optional<std::size_t>> pair_ends(std::span<const MeetingEnd> ends, bool alone,
                                                  const ContinuationRule& rule) {
  struct Candidate {
    bool off_ring = true, other_way = false;
    double cost_rad = 0.0;
    std::size_t a = 0, b = 0;
    auto operator<=>(const Candidate&) const = default;
  };
  std::vector<Candidate> candidates;
  for (std::size_t a = 0; a < ends.size(); ++a)
    for (std::size_t b = a + 1; b < ends.size(); ++b) {
      const RoadPath &from = *ends[a].path, &to = *ends[b].path;
      const bool on_ring = ends[a].ring >= 0 && ends[a].ring == ends[b].ring;
      const double bend = bend_rad(ends[a], ends[b]);
      if (!(bend < largest_bend_rad(ends[a], ends[b], alone, rule))) continue;
      const double cost = bend + (from.highway != to.highway ? rule.other_class_rad : 0.0) +
                          (from.name != to.name ? rule.other_name_rad : 0.0);
      candidates.push_back({!on_ring, rule.same_way_first && &from != &to, cost, a, b});
    }
  std::sort(candidates.begin(), candidates.end());
  std::vector<std::optional<std::size_t>> partner(ends.size());
  for (const Candidate& c : candidates)
    if (!partner[c.a] && !partner[c.b]) partner[c.a] = c.b, partner[c.b] = c.a;
  return partner;
}

}  // namespace orthodrive
