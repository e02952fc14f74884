// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/refine/seen_places.hpp"

#include <algorithm>
#include <cmath>

namespace orthodrive::refine {

std::vector<SeenPlace> seen_on_chain(const RoadChain& chain, const RoadAlignment& alignment, double sigma_factor) {
  constexpr double farthest_m = 3.0;  // along the path
  std::vector<SeenPlace> seen(chain.nodes.size());
  bool any = false;
  for (const ChainPiece& piece : chain.pieces) {
    if (piece.path >= alignment.size() || alignment[piece.path].empty()) continue;
    const std::vector<AlignedPlace>& places = alignment[piece.path];
    const double first_m = chain.nodes[piece.first].s_m, last_m = chain.nodes[piece.last].s_m;
    for (std::size_t i = piece.first; i <= piece.last; ++i) {
      const double s_m = piece.reversed ? last_m - chain.nodes[i].s_m : chain.nodes[i].s_m - first_m;
      auto place = std::ranges::lower_bound(places, s_m, {}, &AlignedPlace::s_m);
      if (place == places.end() || (place != places.begin() && s_m - (place - 1)->s_m < place->s_m - s_m)) --place;
      if (std::abs(place->s_m - s_m) > farthest_m) continue;
      const PlaceAlignment& a = place->alignment;
      seen[i] = {dot(a.displacement_m, chain.nodes[i].normal), sigma_factor * a.sigma_m, 2.0 * a.half_width_m,
                 sigma_factor * 2.0 * a.sigma_half_width_m};
      any = any || a.sigma_m > 0.0;
    }
  }
  if (!any) seen.clear();
  return seen;
}

std::vector<ExpectedOffset> combine(const std::vector<ExpectedOffset>& expected, const std::vector<SeenPlace>& seen) {
  if (seen.empty()) return expected;
  std::vector<ExpectedOffset> both = expected;
  for (std::size_t i = 0; i < both.size(); ++i) {
    if (seen[i].sigma_m <= 0.0) continue;
    both[i] = combined(both[i], {seen[i].offset_m, seen[i].sigma_m});
  }
  return both;
}

}  // namespace orthodrive::refine
