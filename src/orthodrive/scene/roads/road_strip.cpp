// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/roads/road_strip.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace orthodrive::scene {
namespace {

constexpr double sample_step_m = 1.0;  // candidates for sections; clothoids of roads bend little within a metre
constexpr double lane_jump_m = 1e-4;   // distance of the two sections at an abrupt change of the lanes

std::vector<double> breaks(const roadquery::Road& road) {
  std::vector<double> s = {0.0, road.length};
  for (const auto& e : road.plan) s.push_back(e.s);
  for (const auto* cubics : {&road.elevation, &road.superelevation, &road.lane_offset})
    for (const auto& c : *cubics) s.push_back(c.s);
  for (const auto& c : road.shape) s.push_back(c.s);
  for (const auto& section : road.sections) {
    s.push_back(section.s - lane_jump_m);
    s.push_back(section.s);
    for (const auto* side : {&section.left, &section.right})
      for (const auto& lane : *side)
        for (const auto& c : lane.width) s.push_back(section.s + c.s);
  }
  std::erase_if(s, [&](double v) { return !(v >= 0.0 && v <= road.length); });
  std::sort(s.begin(), s.end());
  s.erase(std::unique(s.begin(), s.end(), [](double a, double b) { return b - a < 0.5 * lane_jump_m; }), s.end());
  return s;
}

/// With heights that are not finite where the road has no surface.
CrossSection cut_at(const roadquery::RoadQuery& query, std::size_t road, double s) {
  constexpr double missing = std::numeric_limits<double>::quiet_NaN();
  const auto cut = query.section(road, s);
  if (!cut) return {s, {}, {}, {0.0, 0.0, missing}};
  const auto point = [](const std::array<double, 3>& p) { return Vec3{p[0], p[1], p[2]}; };
  return {s, point(cut->left), point(cut->right), point(cut->reference)};
}

double deviation_m(const CrossSection& a, const CrossSection& b, const CrossSection& m) {
  const double u = (m.s_m - a.s_m) / (b.s_m - a.s_m);
  const auto distance = [&](const Vec3& pa, const Vec3& pb, const Vec3& pm) {
    const Vec3 d = pm - (pa * (1.0 - u) + pb * u);
    return std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z);
  };
  // The middle lies between the edges but on roads with a lateral profile.
  return std::max({distance(a.left, b.left, m.left), distance(a.right, b.right, m.right),
                   distance(a.reference, b.reference, m.reference)});
}

/// Douglas-Peucker on both edges and the middle at once: marks what must stay between two kept samples.
void keep_between(const std::vector<CrossSection>& samples, std::size_t first, std::size_t last,
                  const StripOptions& options, std::vector<bool>& keep) {
  if (last - first < 2) return;
  std::size_t worst = (first + last) / 2;
  double worst_m = 0.0;
  for (std::size_t i = first + 1; i < last; ++i) {
    const double d = deviation_m(samples[first], samples[last], samples[i]);
    if (d > worst_m) worst_m = d, worst = i;
  }
  if (worst_m <= options.tolerance_m) {
    if (samples[last].s_m - samples[first].s_m <= options.max_step_m) return;
    worst = (first + last) / 2;
  }
  keep[worst] = true;
  keep_between(samples, first, worst, options, keep);
  keep_between(samples, worst, last, options, keep);
}

bool is_finite_section(const CrossSection& c) {
  return std::isfinite(c.left.x + c.left.y + c.left.z + c.right.x + c.right.y + c.right.z + c.reference.z);
}

}  // namespace

bool has_sections(const roadquery::RoadQuery& query, std::size_t index) {
  const roadquery::Road& road = query.map().roads[index];
  if (!(road.length > lane_jump_m) || road.plan.empty() || road.sections.empty()) return false;
  const std::vector<double> fixed = breaks(road);
  return std::all_of(fixed.begin(), fixed.end(), [&](double s) { return is_finite_section(cut_at(query, index, s)); });
}

std::vector<CrossSection> cross_sections(const roadquery::RoadQuery& query, std::size_t index,
                                         const StripOptions& options) {
  if (!has_sections(query, index)) return {};
  const std::vector<double> fixed = breaks(query.map().roads[index]);
  std::vector<CrossSection> samples;
  std::vector<std::size_t> fixed_at;
  for (std::size_t i = 0; i < fixed.size(); ++i) {
    fixed_at.push_back(samples.size());
    samples.push_back(cut_at(query, index, fixed[i]));
    if (i + 1 == fixed.size()) break;
    const double gap_m = fixed[i + 1] - fixed[i];
    const int parts = std::max(1, static_cast<int>(std::ceil(gap_m / sample_step_m)));
    for (int k = 1; k < parts; ++k) samples.push_back(cut_at(query, index, fixed[i] + gap_m * k / parts));
  }
  std::vector<bool> keep(samples.size(), false);
  for (std::size_t i = 0; i < fixed_at.size(); ++i) {
    keep[fixed_at[i]] = true;
    if (i > 0) keep_between(samples, fixed_at[i - 1], fixed_at[i], options, keep);
  }
  std::vector<CrossSection> result;
  for (std::size_t i = 0; i < samples.size(); ++i)
    if (keep[i]) result.push_back(samples[i]);
  return result;
}

}  // namespace orthodrive::scene
