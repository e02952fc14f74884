// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/line/leave_room.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "orthodrive/network/line/road_sections.hpp"
#include "roadquery/surface/blend.hpp"

namespace orthodrive::network {
namespace {

constexpr double taper = 0.05;  // the middle of an outer lane moves by 3/8 of that at most: about 1 degree
constexpr double taper_reach_m = 2.0 * deepest_overlap_m / taper;
constexpr double shortened_m = 10.0;  // dead ends, at most, and by no more than half of their road
constexpr double end_step_m = 0.25, across_step_m = 0.5;

/// Whether a cross section at a dead end touches no other surface of another height.
bool is_clear(const RoadSection& end, const std::vector<RoadSection>& sections, const SectionIndex& index) {
  const int steps = std::max(1, static_cast<int>(std::ceil(2.0 * end.half_m / across_step_m)));
  const std::vector<std::uint32_t> near = index.near(end.p, end.half_m + section_margin_m + widest_bank_m);
  for (int k = 0; k <= steps; ++k) {
    const Vec2 at = end.p + left_normal(end.direction) * (end.half_m * (2.0 * k / steps - 1.0));
    for (const std::uint32_t i : near) {
      const RoadSection& other = sections[i];
      const Vec2 d = at - other.p;
      if (other.stretch == end.stretch || std::abs(dot(d, other.direction)) > section_step_m) continue;
      if (!roadquery::is_same_level(end.z, other.z)) continue;
      const double bank = bank_m(std::abs(end.height_at(at) - other.height_at(at)));
      if (bank > 0.0 && std::abs(cross(other.direction, d)) - other.half_m < section_margin_m + bank) return false;
    }
  }
  return true;
}

struct RoomLimit {
  double s = 0.0, width_m = 0.0;
};

/// Widths of a piece under the limits, which taper.
std::vector<ProfileSample> narrowed(const std::vector<ProfileSample>& widths, const std::vector<RoomLimit>& limits) {
  std::vector<double> places;
  places.reserve(widths.size());
  for (const ProfileSample& sample : widths) places.push_back(sample.s);
  const double from = widths.front().s, to = widths.back().s;
  for (const RoomLimit& limit : limits)
    if (limit.s > from && limit.s < to) places.push_back(limit.s);
  // Where the taper ends, too, there must be places: a metre apart it is near enough.
  for (double s = std::max(from, limits.front().s - taper_reach_m); s < std::min(to, limits.back().s + taper_reach_m);
       s += section_step_m)
    places.push_back(s);
  std::sort(places.begin(), places.end());
  std::vector<ProfileSample> result;
  for (const double s : places) {
    if (!result.empty() && s - result.back().s < 1e-3 && s < to) continue;
    const auto after = std::lower_bound(widths.begin(), widths.end(), s,
                                        [](const ProfileSample& sample, double x) { return sample.s < x; });
    double width = after == widths.begin() ? widths.front().value : after == widths.end() ? widths.back().value : 0.0;
    if (after != widths.begin() && after != widths.end()) {
      const ProfileSample &a = *(after - 1), &b = *after;
      width = b.s > a.s ? a.value + (b.value - a.value) * (s - a.s) / (b.s - a.s) : b.value;
    }
    for (const RoomLimit& limit : limits) width = std::min(width, limit.width_m + taper * std::abs(s - limit.s));
    result.push_back({s, width});
  }
  return result;
}

}  // namespace

void end_before_roads(const RoadNetwork& roads, const Topology& topology, const JunctionPlan& junctions,
                      const ChainGeometries& geometry, std::vector<std::vector<double>>& cuts) {
  const SectionMaker maker(roads, topology, junctions, geometry);
  const std::vector<RoadSection> sections = maker.all(cuts);
  const SectionIndex index(sections);
  for (std::size_t i = 0; i < cuts.size(); ++i) {
    const Stretch& stretch = junctions.stretches[i];
    if (stretch.inside || geometry[stretch.chain].closed) continue;
    const auto shorten = [&](double& end, double other) {
      const double reach_m = std::min(shortened_m, 0.5 * std::abs(end - other)), inwards = other > end ? 1.0 : -1.0;
      for (double by_m = 0.0; by_m <= reach_m; by_m += end_step_m)
        if (is_clear(maker.at(i, -1, end + inwards * by_m), sections, index)) {
          end += inwards * by_m;
          return;
        }
    };
    if (!stretch.vertex0) shorten(cuts[i].front(), cuts[i][1]);
    if (!stretch.vertex1) shorten(cuts[i].back(), cuts[i][cuts[i].size() - 2]);
  }
}

void leave_room_beside(const RoadNetwork& roads, const Topology& topology, const JunctionPlan& junctions,
                       const std::vector<std::vector<double>>& cuts, ChainGeometries& geometry) {
  const std::vector<RoadSection> sections = SectionMaker(roads, topology, junctions, geometry).all(cuts);
  const std::vector<double> room = room_of(sections, junctions);
  std::map<std::size_t, std::vector<RoomLimit>> limits;  // by the stretch
  for (std::size_t i = 0; i < sections.size(); ++i)
    if (room[i] < sections[i].half_m) limits[sections[i].stretch].push_back({sections[i].s, 2.0 * room[i]});
  for (const auto& [stretch, of_stretch] : limits) {
    ChainGeometry& chain = geometry[junctions.stretches[stretch].chain];
    const Stretch& whole = junctions.stretches[stretch];
    const std::size_t first = piece_at(chain, std::max(whole.s0, of_stretch.front().s - taper_reach_m)),
                      last = piece_at(chain, std::min(whole.s1, of_stretch.back().s + taper_reach_m) - 1e-6);
    for (std::size_t k = first; k <= last; ++k) chain.widths[k] = narrowed(chain.widths[k], of_stretch);
  }
}

}  // namespace orthodrive::network
