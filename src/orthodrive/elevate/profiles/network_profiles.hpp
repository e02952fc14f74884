// SPDX-License-Identifier: Apache-2.0
#pragma once
// The profiles of all roads of a network, fitted at once. docs/elevate.md tells the model and where its numbers come
// from.

#include <map>
#include <vector>

#include "orthodrive/elevate/profiles/control_heights.hpp"
#include "orthodrive/elevate/profiles/parting_roads.hpp"
#include "orthodrive/elevate/terrain/profile_chains.hpp"
#include "orthodrive/elevate/terrain/terrain_samples.hpp"
#include "orthodrive/model/roads/design_limits.hpp"
#include "orthodrive/roads/path_junctions.hpp"

namespace orthodrive::elevate {

/// At `fraction` between two nodes a road lies at most at high_m and at least at low_m.
struct HeightLimit {
  std::size_t path = 0, segment = 0;
  double fraction = 0.0, low_m = -INFINITY, high_m = INFINITY;
};

/// A stretch of a chain whose profile is steeper or more curved than its class allows.
struct LimitBreach {
  std::size_t path = 0, node = 0;  ///< nearest to the worst place
  double length_m = 0.0, worst = 0.0, limit = 0.0;
};

class NetworkProfiles {
 public:
  /// Keeps references to all of them.
  NetworkProfiles(const RoadNetwork& roads, const ProfileChains& chains, const std::vector<PathJunction>& junctions,
                  const TerrainSamples& terrain, const ControlHeights& control,
                  const std::vector<std::vector<double>>& start_m);

  /// From where the last call ended. `loosening` widens the terrain's standard deviation and with it the loss: begun
  /// wide and narrowed, the fit does not follow the terrain into a valley that a bridge spans (graduated non-convexity,
  /// Blake and Zisserman, Visual Reconstruction, 1987).
  RobustFit::Summary solve(const std::vector<HeightLimit>& limits, int max_iterations, double loosening = 1.0);
  /// Estimates the standard deviations of the terrain models from their residuals, and then the roads' vertical
  /// curvature, by design speed, from the terrain along them.
  void estimate_scales();

  [[nodiscard]] double height_m(std::size_t path, std::size_t segment, double fraction) const;
  [[nodiscard]] const std::vector<double>& terrain_sigma_m() const { return sigma_m_; }
  /// z_m, gradient, sigma_z_m of every node. Where roads meet they have the same z.
  void write(const std::vector<HeightLimit>& limits, RoadNetwork& roads) const;
  [[nodiscard]] std::vector<LimitBreach> gradient_breaches() const;
  [[nodiscard]] std::vector<LimitBreach> curvature_breaches() const;

 private:
  struct Knot {
    std::size_t place = 0;  // of the chain, nearest before
    const DesignLimits* limits = nullptr;
    bool is_grounded = false;  // terrain within one and a half knots
    bool is_near_end = false;  // within a vertical curve of the end of an open chain
  };
  [[nodiscard]] std::vector<Knot> knots_of(const ProfileChain& chain) const;
  [[nodiscard]] RobustFit build(const std::vector<HeightLimit>& limits) const;
  [[nodiscard]] std::array<Term, 4> height_terms(std::size_t path, std::size_t segment, double fraction) const;
  [[nodiscard]] std::vector<double> share_of_control(const SparseJacobian& rows) const;
  void add_control(RobustFit& fit) const;
  void hold_control(RobustFit& fit) const;
  void add_terrain(RobustFit& fit) const;
  void add_design(RobustFit& fit) const;
  void add_junctions(RobustFit& fit) const;
  void add_shared_pavement(RobustFit& fit) const;
  void find_grounded_chains();
  void estimate_terrain_sigma();
  void estimate_curvature_sigma();
  [[nodiscard]] double observation_share(std::size_t path, std::size_t node) const;
  [[nodiscard]] double pull_per_m() const;
  [[nodiscard]] double value(std::span<const Term> terms) const;
  template <typename Excess>
  [[nodiscard]] std::vector<LimitBreach> breaches(Excess&& excess) const;

  const RoadNetwork& roads_;
  const ProfileChains& chains_;
  const std::vector<PathJunction>& junctions_;
  const TerrainSamples& terrain_;
  const ControlHeights& control_;
  const std::vector<std::vector<double>>& start_m_;
  std::vector<SharedPavement> shared_;
  std::vector<DesignLimits> limits_of_path_;
  std::vector<std::vector<Knot>> knots_;          // of each chain
  std::vector<bool> chain_is_grounded_;           // or hangs together with one that is
  std::vector<double> sigma_m_;                   // of each terrain model
  std::vector<double> seen_sigma_m_;              // the same without the floor
  std::map<double, double> curvature_sigma_1pm_;  // by design speed
  double loosening_ = 1.0;
  std::vector<double> x_;  // coefficients of all chains; height and gradient east, north of each junction
};

}  // namespace orthodrive::elevate
