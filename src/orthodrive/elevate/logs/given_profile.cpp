// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/elevate/logs/given_profile.hpp"

#include <algorithm>

namespace orthodrive::elevate {
namespace {

constexpr double smallest_sigma_z_m = 0.02, smallest_sigma_banking_rad = 0.001;

}  // namespace

GivenProfile given_profile_at(const RoadNetwork& roads, const LogChains& chains, std::size_t chain, double along_m,
                              const FuseDriveLogsOptions& options) {
  const auto& parts = chains.chains[chain].parts;
  auto part = std::upper_bound(parts.begin(), parts.end(), along_m,
                               [](double s, const LogChain::Part& p) { return s < p.begin_m; });
  if (part != parts.begin()) --part;
  const double sign = part->reversed ? -1.0 : 1.0;
  const double s = std::clamp(part->reversed ? part->begin_m + part->length_m - along_m : along_m - part->begin_m, 0.0,
                              part->length_m);
  const auto& nodes = roads.paths[part->path].nodes;
  const auto after =
      std::upper_bound(nodes.begin() + 1, nodes.end() - 1, s, [](double x, const RoadNode& n) { return x < n.s_m; });
  const RoadNode &a = *(after - 1), &b = *after;
  const double run = std::max(1e-6, b.s_m - a.s_m), u = std::clamp((s - a.s_m) / run, 0.0, 1.0), v = 1.0 - u;
  const auto mixed = [&](double x, double y) { return v * x + u * y; };
  const auto sigma_z = [&](const RoadNode& n) {
    return std::max(smallest_sigma_z_m, n.sigma_z_m > 0.0 ? n.sigma_z_m : options.unknown_sigma_z_m);
  };
  const auto sigma_banking = [&](const RoadNode& n) {
    return std::max(smallest_sigma_banking_rad,
                    n.sigma_banking > 0.0 ? n.sigma_banking : options.unknown_sigma_banking_rad);
  };
  return {v * v * (1.0 + 2.0 * u) * a.z_m + u * u * (3.0 - 2.0 * u) * b.z_m +
              u * v * run * (v * a.gradient - u * b.gradient),  // Hermite
          sign * mixed(a.gradient, b.gradient),
          sign * mixed(a.banking, b.banking),
          (b.banking - a.banking) / run,  // against the path both the banking and the step change sign
          mixed(a.crown, b.crown),
          mixed(sigma_z(a), sigma_z(b)),
          mixed(sigma_banking(a), sigma_banking(b))};
}

}  // namespace orthodrive::elevate
