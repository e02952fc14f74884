// SPDX-License-Identifier: Apache-2.0
#pragma once
// Roads as chains of ways that go on in each other, and the cubic B-splines that are their profiles: C2 by
// construction.

#include <array>
#include <vector>

#include "orthodrive/math/robust_fit.hpp"
#include "orthodrive/model/roads/road_network.hpp"
#include "orthodrive/roads/path_links.hpp"

namespace orthodrive::elevate {

/// A node of a way on its chain.
struct ChainPlace {
  std::size_t path = 0, node = 0;
  double s_m = 0.0;     ///< along the chain
  bool forward = true;  ///< the chain runs with the way
};

/// Uniform knots k = 0 .. intervals at k * step_m; coefficients first_unknown .. + unknowns().
struct ProfileChain {
  std::vector<ChainPlace> places;  ///< in order of s; where one way goes on in the next two places share it
  double length_m = 0.0, step_m = 0.0;
  bool closed = false;
  int first_unknown = 0, intervals = 0;

  [[nodiscard]] int unknowns() const { return closed ? intervals : intervals + 3; }
  [[nodiscard]] int coefficient(int k) const { return first_unknown + (closed ? k % intervals : k); }

  /// Height and its derivatives by s as sums of coefficients. At a knot the outer coefficients of the fourth term are
  /// 0.
  [[nodiscard]] std::array<Term, 4> height(double s_m) const { return basis(s_m, 0); }
  [[nodiscard]] std::array<Term, 4> gradient(double s_m) const { return basis(s_m, 1); }
  [[nodiscard]] std::array<Term, 4> curvature(double s_m) const { return basis(s_m, 2); }

 private:
  [[nodiscard]] std::array<Term, 4> basis(double s_m, int derivative) const;
};

struct NodePlace {
  std::size_t chain = 0;
  double s_m = 0.0;
  bool forward = true;
};

struct ProfileChains {
  std::vector<ProfileChain> chains;
  std::vector<std::vector<NodePlace>> of_node;  ///< [path][node]
  int unknowns = 0;
};

/// The linked ends of ways joined. Knots are a third of the least vertical curve of the slowest class of the chain
/// apart, 4 m to 8 m: closer ones would follow nothing but noise, wider ones could not follow the tightest curve
/// allowed.
[[nodiscard]] ProfileChains make_profile_chains(const RoadNetwork& roads, const PathLinks& links);

}  // namespace orthodrive::elevate
