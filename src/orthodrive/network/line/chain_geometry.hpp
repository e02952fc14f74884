// SPDX-License-Identifier: Apache-2.0
#pragma once
// The fitted form of a chain: reference line, profile and widths over one s.

#include <vector>

#include "orthodrive/network/curves/fit_plan.hpp"
#include "orthodrive/network/curves/fit_profile.hpp"
#include "orthodrive/network/line/chain_line.hpp"

namespace orthodrive::network {

struct ChainGeometry {
  bool closed = false;
  double length_m = 0.0;  ///< one round for closed chains, whose plan and profiles go round twice: [0, 2 length]
  std::vector<roadquery::PlanElement> plan;
  std::vector<roadquery::Cubic> elevation, superelevation;  ///< superelevation empty when all banking is zero
  std::vector<roadquery::Cubic> crown;                      ///< tangent of RoadNode::crown; empty when all are zero
  std::vector<double> vertex_s;                             ///< of every vertex along the chain: pieces + 1
  std::vector<std::vector<ProfileSample>> widths;           ///< of every piece, at least two samples, s not decreasing
  double max_plan_deviation_m = 0.0, max_elevation_error_m = 0.0;
  int eased_nodes = 0;
  Findings findings;

  [[nodiscard]] bool empty() const { return plan.empty(); }  ///< a chain shorter than 0.25 m
};

using ChainGeometries = Table<ChainIndex, ChainGeometry>;

struct FitChainOptions {
  double plan_tolerance_m = 0.0, elevation_tolerance_m = 0.0, banking_tolerance_rad = 0.0;  ///< see BuildNetworkOptions
};

[[nodiscard]] ChainGeometry fit_chain(const Chain& chain, const PieceLines& pieces, const FitChainOptions& options);

/// Carriageway width at s; s beyond one round of a closed chain is wrapped.
[[nodiscard]] double width_at(const ChainGeometry& geometry, double s);
/// Index along the chain of the piece that holds s.
[[nodiscard]] std::size_t piece_at(const ChainGeometry& geometry, double s);

}  // namespace orthodrive::network
