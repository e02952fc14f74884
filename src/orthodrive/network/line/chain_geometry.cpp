// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/line/chain_geometry.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>

#include "orthodrive/network/curves/fit_spline.hpp"
#include "orthodrive/network/line/limit_warp.hpp"

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

/// Sets plan and length; returns where the nodes lie on it.
PlanFit fit_reference_line(const ChainLine& line, const FitChainOptions& options, ChainGeometry& geometry) {
  std::vector<Vec2> points;
  std::vector<double> max_curvature;
  points.reserve(line.nodes.size());
  for (const ChainLineNode& node : line.nodes) {
    points.push_back(node.p);
    // Where the inner edge of the carriageway would fold over.
    max_curvature.push_back(2.0 / std::max({node.width_before_m, node.width_after_m, 1.0}));
  }
  PlanFit plan = fit_plan(
      points, {.tolerance_m = options.plan_tolerance_m, .closed = geometry.closed, .max_curvature = max_curvature});
  const Vec2 where = points[plan.farthest_point];
  if (!plan.clothoids)
    geometry.findings.push_back({Severity::warning, "network.no_clothoids",
                                 "no chain of clothoids follows these nodes; the road is made of cubics", where.x,
                                 where.y});
  else if (plan.max_deviation_m > options.plan_tolerance_m + 1e-6)
    geometry.findings.push_back(
        {Severity::info, "network.off_the_nodes",
         fmt::format("the road's nodes lie up to {:.2f} m from its reference line", plan.max_deviation_m), where.x,
         where.y});
  geometry.plan = std::move(plan.elements);
  geometry.length_m = plan_length(geometry.plan);
  geometry.max_plan_deviation_m = plan.max_deviation_m;
  return plan;
}

void fit_profiles(const ChainLine& line, std::span<const double> node_s, const FitChainOptions& options,
                  ChainGeometry& geometry) {
  std::vector<ProfileSample> z, banking, crown;
  for (std::size_t i = 0; i < line.nodes.size(); ++i) {
    z.push_back({node_s[i], line.nodes[i].z_m});
    banking.push_back({node_s[i], line.nodes[i].banking});
    crown.push_back({node_s[i], std::tan(line.nodes[i].crown)});
  }
  ProfileFit elevation = fit_spline(z, {options.elevation_tolerance_m, geometry.closed}, geometry.vertex_s);
  geometry.elevation = std::move(elevation.cubics);
  geometry.max_elevation_error_m = elevation.max_error;
  const auto is_not_zero = [](const ProfileSample& b) { return b.value != 0.0; };
  if (std::any_of(banking.begin(), banking.end(), is_not_zero))
    geometry.superelevation = fit_profile(banking, {options.banking_tolerance_rad, geometry.closed}).cubics;
  if (std::any_of(crown.begin(), crown.end(), is_not_zero))
    geometry.crown = fit_profile(crown, {options.banking_tolerance_rad, geometry.closed}).cubics;
}

std::vector<std::vector<ProfileSample>> widths_of_pieces(const ChainLine& line, std::span<const double> node_s) {
  std::vector<std::vector<ProfileSample>> all;
  for (std::size_t k = 0; k + 1 < line.joint.size(); ++k) {
    std::vector<ProfileSample>& widths = all.emplace_back();
    for (std::size_t i = line.joint[k]; i <= line.joint[k + 1]; ++i)
      widths.push_back({node_s[i], i == line.joint[k] ? line.nodes[i].width_after_m : line.nodes[i].width_before_m});
  }
  return all;
}

}  // namespace

ChainGeometry fit_chain(const Chain& chain, const PieceLines& pieces, const FitChainOptions& options) {
  ChainGeometry geometry;
  geometry.closed = chain.closed;
  const ChainLine line = chain_line(chain, pieces, geometry.eased_nodes, geometry.findings);
  if (line.nodes.size() < 2) return geometry;
  const PlanFit plan = fit_reference_line(line, options, geometry);
  for (const std::size_t joint : line.joint) geometry.vertex_s.push_back(plan.point_s[joint]);
  fit_profiles(line, plan.point_s, options, geometry);
  geometry.widths = widths_of_pieces(line, plan.point_s);
  limit_warp(geometry, options.banking_tolerance_rad);
  if (chain.closed) {
    repeat(geometry.plan, geometry.length_m);
    repeat(geometry.elevation, geometry.length_m);
    repeat(geometry.superelevation, geometry.length_m);
    repeat(geometry.crown, geometry.length_m);
  }
  return geometry;
}

std::size_t piece_at(const ChainGeometry& geometry, double s) {
  const auto after = std::upper_bound(geometry.vertex_s.begin(), geometry.vertex_s.end(), wrapped(geometry, s));
  const auto index = static_cast<std::ptrdiff_t>(after - geometry.vertex_s.begin()) - 1;
  return static_cast<std::size_t>(
      std::clamp(index, std::ptrdiff_t{0}, static_cast<std::ptrdiff_t>(geometry.widths.size()) - 1));
}

double width_at(const ChainGeometry& geometry, double s) {
  return interpolate(geometry.widths[piece_at(geometry, s)], wrapped(geometry, s));
}

}  // namespace orthodrive::network
