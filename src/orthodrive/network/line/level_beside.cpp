// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/line/level_beside.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <utility>
#include <vector>

#include "roadquery/surface/blend.hpp"

namespace orthodrive::network {
namespace {

constexpr int passes = 2;  // a road may give way to one that gives way itself
constexpr double along_strip_m = 4.0;
constexpr double broken_strip_m = 5.0;  // what is free for less is one strip
constexpr double shortest_level_fade_m = 20.0, level_height_per_m = 0.03, level_banking_per_m = 0.0033;
constexpr double fork_level_m = 4.0;  // roads that part at one node had one height there
constexpr double felt_mps2 = 1.0;
constexpr double level_flush_m = 0.5 * flush_m;  // two that add up are flush
constexpr double steepest = 2.0;                 // times that where there is no room to fade out more slowly

/// What is to be added to a chain at s.
struct Levelled {
  double s = 0.0, z = 0.0, banking = 0.0;
  double overlap_m = 0.0, speed_mps = 0.0;
};

/// Rise for each metre to the left of the axis, on one side of it.
double across_of(const RoadSection& q, double side) { return q.banking - side * q.crown; }

/// For `q`, which gives way to `other` and shares a strip `overlap_m` wide with it.
Levelled level_with(const RoadSection& q, const RoadSection& other, double overlap_m, double half_m,
                    double other_half_m) {
  const double left_m = cross(q.direction, other.p - q.p), side = left_m < 0.0 ? -1.0 : 1.0;
  const double meet_m = side * 0.5 * (half_m + std::abs(left_m) - other_half_m);
  const Vec2 left = left_normal(q.direction), at = q.p + left * meet_m;
  const double other_side = cross(other.direction, at - other.p) < 0.0 ? -1.0 : 1.0;
  const double wanted = across_of(other, other_side) * dot(left_normal(other.direction), left);
  const double change = wanted - across_of(q, side);
  const double least = overlap_m > 0.0 ? 2.0 * level_flush_m / overlap_m : INFINITY;
  const double banking = change - std::clamp(change, -least, least);
  return {q.s, other.height_at(at) - q.height_at(at) - meet_m * banking, banking, overlap_m, q.speed_mps};
}

/// What a road has in common with one other.
struct Strip {
  std::vector<Levelled> places;  ///< along the chain of the road that gives way

  [[nodiscard]] double begin() const { return places.front().s; }
  [[nodiscard]] double end() const { return places.back().s; }
  [[nodiscard]] double length_m() const { return end() - begin(); }
};

/// Whether `q` gives way: inside junctions nothing does, and beside what lies in a junction of its own it does as on
/// the road.
bool yields(const RoadSection& q, const RoadSection& other, const JunctionPlan& junctions) {
  return q.junction < 0 && ((other.junction >= 0 && !is_own_junction(q, other, junctions)) || gives_way(q, other));
}

/// Of all roads, by the chain.
std::map<ChainIndex, std::vector<Strip>> find_strips(const std::vector<RoadSection>& sections,
                                                     const JunctionPlan& junctions, const ChainGeometries& geometry) {
  const std::vector<double> room = room_of(sections, junctions);
  const SectionIndex index(sections);
  std::map<std::pair<std::size_t, ChainIndex>, std::vector<Levelled>> between;  // a stretch and the other chain
  for (std::size_t i = 0; i < sections.size(); ++i) {
    const RoadSection& q = sections[i];
    if (q.junction >= 0 || geometry[q.chain].closed) continue;
    std::map<ChainIndex, Levelled> beside;
    for (const std::uint32_t k : index.near(q.p, q.half_m)) {
      const RoadSection& other = sections[k];
      if (other.chain == q.chain || !are_side_by_side(q, other) || !yields(q, other, junctions)) continue;
      if (std::abs(q.z - other.z) > (part_at_a_node(q, other, junctions) ? fork_level_m : roadquery::same_level_m))
        continue;
      const double apart_m = std::abs(cross(q.direction, other.p - q.p)), overlap_m = room[i] + room[k] - apart_m;
      if (overlap_m <= -0.5 * section_margin_m) continue;
      const Levelled level = level_with(q, other, overlap_m, room[i], room[k]);
      const auto [it, is_new] = beside.try_emplace(other.chain, level);
      if (!is_new && it->second.overlap_m < overlap_m) it->second = level;
    }
    for (const auto& [chain, level] : beside) between[{q.stretch, chain}].push_back(level);
  }
  std::map<ChainIndex, std::vector<Strip>> strips;
  for (const auto& [between_whom, all] : between) {
    std::vector<Strip>& of_chain = strips[junctions.stretches[between_whom.first].chain];
    for (std::size_t i = 0; i < all.size(); ++i) {
      if (i == 0 || all[i].s - all[i - 1].s > broken_strip_m) of_chain.emplace_back();
      of_chain.back().places.push_back(all[i]);
    }
  }
  return strips;
}

/// One profile of a strip's change: its value at every few metres of the strip, and how it fades out.
class StripProfile {
 public:
  StripProfile(const std::vector<Levelled>& all, double Levelled::*part) {
    for (const Levelled& at : all)
      if (samples_.empty() || at.s - samples_.back().s >= along_strip_m) samples_.push_back({at.s, at.*part});
    if (samples_.back().s < all.back().s) samples_.push_back({all.back().s, all.back().*part});
  }

  /// `before` and `behind`: where it has faded out; at a free end of the chain the change goes on as it is.
  void add_to(std::vector<roadquery::Cubic>& profile, double before, double behind, bool level_before,
              bool level_behind) const {
    if (std::ranges::all_of(samples_, [](const ProfileSample& at) { return at.value == 0.0; })) return;
    const auto add = [&](const ProfileSample& a, const ProfileSample& b, double slope_a, double slope_b) {
      if (b.s > a.s) add_cubic(profile, hermite(a.s, b.s, a.value, b.value, slope_a, slope_b), b.s);
    };
    add({before, level_before ? samples_.front().value : 0.0}, samples_.front(), 0.0, level_before ? 0.0 : slope(0));
    for (std::size_t i = 0; i + 1 < samples_.size(); ++i)
      add(samples_[i], samples_[i + 1], i == 0 && level_before ? 0.0 : slope(i),
          i + 2 == samples_.size() && level_behind ? 0.0 : slope(i + 1));
    const std::size_t last = samples_.size() - 1;
    add(samples_[last], {behind, level_behind ? samples_[last].value : 0.0}, level_behind ? 0.0 : slope(last), 0.0);
  }

 private:
  [[nodiscard]] double slope(std::size_t i) const {
    const ProfileSample &a = samples_[i > 0 ? i - 1 : i], &b = samples_[std::min(i + 1, samples_.size() - 1)];
    return b.s > a.s ? (b.value - a.value) / (b.s - a.s) : 0.0;
  }
  std::vector<ProfileSample> samples_;
};

/// Over which the change at the end of a strip fades out.
double fade_of(const Levelled& at) {
  constexpr double hermite_bend = 6.0;  // largest second derivative times length2 over height
  return std::max({shortest_level_fade_m, std::abs(at.z) / level_height_per_m,
                   std::abs(at.banking) / level_banking_per_m,
                   at.speed_mps * std::sqrt(hermite_bend * std::abs(at.z) / felt_mps2)});
}

/// Within which it has to.
double least_fade_m(const Levelled& at) {
  return std::max(broken_strip_m, std::abs(at.z) / (steepest * level_height_per_m));
}

/// Whether a strip has anything to change, and no step of its own: then the other road is one of another level.
bool is_worth(const Strip& strip) {
  const std::vector<Levelled>& all = strip.places;
  for (std::size_t i = 1; i < all.size(); ++i)
    if (std::abs(all[i].z - all[i - 1].z) > level_flush_m + steepest * level_height_per_m * (all[i].s - all[i - 1].s))
      return false;
  return std::ranges::any_of(all,
                             [](const Levelled& at) { return std::abs(at.z) >= level_flush_m || at.banking != 0.0; });
}

/// Those that leave each other room to fade out, the longest first; then along the chain.
std::vector<Strip> without_conflicts(std::vector<Strip> strips) {
  std::erase_if(strips, [](const Strip& strip) { return !is_worth(strip); });
  std::ranges::stable_sort(strips, std::greater<>(), &Strip::length_m);
  std::vector<Strip> kept;
  for (const Strip& strip : strips)
    if (std::ranges::all_of(kept, [&](const Strip& other) {
          const bool is_before = strip.begin() < other.begin();
          const Strip &a = is_before ? strip : other, &b = is_before ? other : strip;
          return b.begin() - a.end() >= least_fade_m(a.places.back()) + least_fade_m(b.places.front());
        }))
      kept.push_back(strip);
  std::ranges::sort(kept, {}, &Strip::begin);
  return kept;
}

void change_heights(ChainGeometry& chain, const std::vector<Strip>& strips) {
  for (std::size_t k = 0; k < strips.size(); ++k) {
    const std::vector<Levelled>& places = strips[k].places;
    const double begin = strips[k].begin(), end = strips[k].end();
    // Between two strips each has half of the way.
    const double free0 = k > 0 ? 0.5 * (strips[k - 1].end() + begin) : 0.0;
    const double free1 = k + 1 < strips.size() ? 0.5 * (end + strips[k + 1].begin()) : chain.length_m;
    const double before = std::max(free0, begin - fade_of(places.front()));
    const double behind = std::min(free1, end + fade_of(places.back()));
    const bool level_before = begin - before < least_fade_m(places.front());
    const bool level_behind = behind - end < least_fade_m(places.back());
    StripProfile(places, &Levelled::z).add_to(chain.elevation, before, behind, level_before, level_behind);
    StripProfile(places, &Levelled::banking).add_to(chain.superelevation, before, behind, level_before, level_behind);
  }
}

}  // namespace

void level_beside(const RoadNetwork& roads, const Topology& topology, const JunctionPlan& junctions, const Cuts& cuts,
                  ChainGeometries& geometry) {
  for (int pass = 0; pass < passes; ++pass) {
    const std::vector<RoadSection> sections = SectionMaker(roads, topology, junctions, geometry).all(cuts);
    for (auto& [chain, strips] : find_strips(sections, junctions, geometry))
      change_heights(geometry[chain], without_conflicts(std::move(strips)));
  }
}

}  // namespace orthodrive::network
