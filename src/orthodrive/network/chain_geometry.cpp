#include "orthodrive/network/chain_geometry.hpp"

#include "orthodrive/network/fit_spline.hpp"

#include <algorithm>
#include <cmath>

namespace orthodrive::network {
namespace {

double wrapped(const ChainGeometry& geometry, double s) {
  return geometry.closed && s >= geometry.length_m ? s - geometry.length_m : s;
}

template <typename Piecewise>
void repeat(std::vector<Piecewise>& parts, double period) {
  const std::size_t count = parts.size();
  for (std::size_t i = 0; i < count; ++i) {
    parts.push_back(parts[i]);
    parts.back().s += period;
  }
}

double interpolate(const std::vector<ProfileSample>& samples, double s) {
  const auto after = std::lower_bound(samples.begin(), samples.end(), s,
                                      [](const ProfileSample& sample, double x) { return sample.s < x; });
  if (after == samples.begin()) return samples.front().value;
  if (after == samples.end()) return samples.back().value;
  const ProfileSample &a = *(after - 1), &b = *after;
  return b.s > a.s ? a.value + (b.value - a.value) * (s - a.s) / (b.s - a.s) : b.value;
}

}  // namespace

ChainGeometry fit_chain(const Chain& chain, const std::vector<std::vector<PieceNode>>& pieces,
                        const FitChainOptions& options) {
  ChainGeometry geometry;
  geometry.closed = chain.closed;
  const ChainLine line = chain_line(chain, pieces, geometry.eased_nodes, geometry.findings);
  if (line.nodes.size() < 2) return geometry;

  std::vector<Vec2> points;
  for (const ChainNode& node : line.nodes) points.push_back(node.p);
  PlanFit plan = fit_plan(points, {options.plan_tolerance_m, chain.closed});
  geometry.plan = std::move(plan.elements);
  geometry.length_m = plan_length(geometry.plan);
  geometry.max_plan_deviation_m = plan.max_deviation_m;

  std::vector<ProfileSample> z, banking;
  for (std::size_t i = 0; i < line.nodes.size(); ++i) {
    z.push_back({plan.point_s[i], line.nodes[i].z_m});
    banking.push_back({plan.point_s[i], line.nodes[i].banking});
  }
  for (const std::size_t joint : line.joint) geometry.vertex_s.push_back(plan.point_s[joint]);
  ProfileFit elevation = fit_spline(z, {options.elevation_tolerance_m, chain.closed}, geometry.vertex_s);
  geometry.elevation = std::move(elevation.cubics);
  geometry.max_elevation_error_m = elevation.max_error;
  if (std::any_of(banking.begin(), banking.end(), [](const ProfileSample& b) { return b.value != 0.0; }))
    geometry.superelevation = fit_profile(banking, {options.banking_tolerance_rad, chain.closed}).cubics;

  for (std::size_t k = 0; k + 1 < line.joint.size(); ++k) {
    std::vector<ProfileSample> widths;
    for (std::size_t i = line.joint[k]; i <= line.joint[k + 1]; ++i)
      widths.push_back({plan.point_s[i], i == line.joint[k] ? line.nodes[i].width_after_m : line.nodes[i].width_before_m});
    geometry.widths.push_back(std::move(widths));
  }
  if (chain.closed) {
    repeat(geometry.plan, geometry.length_m);
    repeat(geometry.elevation, geometry.length_m);
    repeat(geometry.superelevation, geometry.length_m);
  }
  return geometry;
}

std::size_t piece_at(const ChainGeometry& geometry, double s) {
  const auto after = std::upper_bound(geometry.vertex_s.begin(), geometry.vertex_s.end(), wrapped(geometry, s));
  const auto index = static_cast<std::ptrdiff_t>(after - geometry.vertex_s.begin()) - 1;
  return static_cast<std::size_t>(std::clamp(index, std::ptrdiff_t{0}, static_cast<std::ptrdiff_t>(geometry.widths.size()) - 1));
}

double width_at(const ChainGeometry& geometry, double s) {
  return interpolate(geometry.widths[piece_at(geometry, s)], wrapped(geometry, s));
}

}  // namespace orthodrive::network
