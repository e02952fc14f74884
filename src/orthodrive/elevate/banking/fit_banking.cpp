// SPDX-License-Identifier: Apache-2.0
// Each terrain pixel on the carriageway is one equation: rise over the profile = a + t b - g(t) c - h(t) d, with the
// unknown rise a of the terrain over the profile, slope b and crown slope c at its station; g(t) is |t| averaged over
// the pixel; d is how much more the ground falls beyond both edges, h(t) what of the pixel lies there times how far.
// All of them run smoothly along the chain. b is an integrated random walk, whose posterior mean is the cubic smoothing
// spline (Wahba 1978): banking changes along straight ramps. Pixels count under a Cauchy loss (kerbs, walls,
// banks), by reweighting.
//
// Roof or plane: both are fitted; a two-state Viterbi path over the stations takes the roof where it explains the
// pixels better by more than its parameters are worth (BIC), and changes seldom. A last fit holds c at 0 on planes.

#include "orthodrive/elevate/banking/fit_banking.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "orthodrive/core/median.hpp"
#include "orthodrive/math/banded_normal.hpp"

namespace orthodrive::elevate {
namespace {

// Smoothness. Least mean error on the synthetic villages 11 to 14 with a 2 m grid; docs/measured/banking.md has the
// errors on sites that had no part in it.
constexpr double slope_bend_density = 4e-8;    // 1/m3: variance a metre of the change of the slope's rate
constexpr double slope_walk_density = 3.5e-6;  // 1/m: keeps gaps from swinging; 2 % in 80 m
// Factor on both where a side road turns into its main road's plane: over banking_runout_m where
// nothing is measured, else no further than the terrain shows the mouth.
constexpr double runout_haste = 1000.0, measured_runout_m = 8.0;
constexpr double crown_walk_density = 2e-6;   // 1/m: 1.4 % in 100 m
constexpr double rise_walk_density = 2.5e-4;  // m2/m: 5 cm in 10 m, the error of a smoothed profile
// Weak pulls: one observation of this sigma per this length.
constexpr double slope_pull_sigma = 0.02, slope_pull_m = 50.0;   // to the design
constexpr double crown_pull_sigma = 0.05, crown_pull_m = 100.0;  // to 0
constexpr double rise_pull_sigma_m = 0.5, rise_pull_m = 50.0;    // to 0
// Slope of verges against the carriageway: 12 % (RAL 2012), banks of 1 : 3, kerbs up; and its difference between the
// sides.
constexpr double verge_pull_sigma = 0.3, verge_pull_m = 50.0, verge_walk_density = 3e-4;
constexpr double uneven_verge_sigma = 0.05;
constexpr double held_sigma = 0.002;   // of the design where nothing is measured
constexpr double plane_sigma = 5e-4;   // of planes of junctions: roads must agree there
constexpr double design_sigma = 0.02;  // what is measured in Kvarnbyn has an rms of 2.2 %
constexpr double held_crown_sigma = 2e-4;

constexpr double cauchy_95 = 2.3849;  // scale in sigmas: 95 % efficiency under Gaussian noise (Holland and Welsch 1977)
constexpr double first_scale_m = 0.3;  // first round: nearly all count
constexpr int most_rounds = 12, last_rounds = 4;
constexpr double settled = 1e-5;
constexpr double sigma_prior_samples = 50.0;  // the given noise counts like this number of pixels
constexpr double least_sigma_m = 0.01;
constexpr double independent_m2 = 1.0;  // laser points are about a metre apart: finer pixels repeat them

constexpr double switch_cost = 3.0;  // log likelihood: one change between roof and plane in some 20 stations is chance
constexpr double roof_cost_per_m = 0.023;  // BIC: half the log of 100 pixels for one crown slope in 100 m
constexpr double least_crown = 0.005;      // less is none; a gutter in the middle (negative) is none either
constexpr double largest_crown = 0.06;
constexpr double zero_crown = 5e-4;  // what held planes leave

constexpr double beside_m = 5.0;          // a station this near to pixels is measured
constexpr double longest_gap_m = 100.0;   // between measured stations; longer ones follow the design in their middle
constexpr double longest_end_m = 30.0;    // beyond the last measured station
constexpr std::size_t least_samples = 8;  // on a chain

enum Unknown : std::size_t { rise, slope, crown, verge, unknowns };

/// What a pixel rises by for a unit slope beyond the carriageway's edge: of the part that reaches over it the mean
/// distance from the edge.
double mean_beyond(double t, double gsd_m, double half_width_m) {
  const double over_m = std::max(0.0, std::abs(t) + 0.5 * gsd_m - half_width_m);
  return 0.5 * over_m * over_m / gsd_m;
}

/// |t| averaged over a pixel as wide as its edge.
double mean_abs(double t, double gsd_m) {
  const double half = 0.5 * gsd_m;
  return std::abs(t) >= half ? std::abs(t) : (t * t + half * half) / gsd_m;
}

struct Field {
  std::vector<double> rise, slope, crown, verge, slope_variance;
};

class ChainSystem {
 public:
  explicit ChainSystem(const StationChain& chain)
      : chain_(chain), n_(chain.stations.size()), normal_(unknowns * n_, unknowns * (chain.closed ? 5 : 3) - 1) {}

  void add(std::initializer_list<std::pair<std::size_t, double>> stations, Unknown unknown, double target,
           double weight) {
    std::array<std::size_t, 3> index{};
    std::array<double, 3> coefficients{};
    std::size_t count = 0;
    for (const auto& [station, coefficient] : stations)
      index[count] = at(station, unknown), coefficients[count++] = coefficient;
    normal_.add({index.data(), count}, {coefficients.data(), count}, target, weight);
  }
  void add(const AcrossSample& sample, double weight) {
    const std::array index{at(sample.station, rise), at(sample.station, slope), at(sample.station, crown),
                           at(sample.station, verge)};
    const std::array coefficients{1.0, static_cast<double>(sample.t_m), -mean_abs(sample.t_m, sample.gsd_m),
                                  -mean_beyond(sample.t_m, sample.gsd_m, half_width_m(sample))};
    normal_.add(index, coefficients, sample.rise_m, weight);
  }
  [[nodiscard]] Field solve(bool with_variances = false) const {
    const BandedNormal::Solution solution = normal_.solve(with_variances);
    Field field;
    for (std::size_t i = 0; i < n_; ++i) {
      field.rise.push_back(solution.x[at(i, rise)]), field.slope.push_back(solution.x[at(i, slope)]);
      field.crown.push_back(solution.x[at(i, crown)]), field.verge.push_back(solution.x[at(i, verge)]);
      if (with_variances) field.slope_variance.push_back(solution.variance[at(i, slope)]);
    }
    return field;
  }

 private:
  /// Closed chains are folded (0, n-1, 1, n-2, ...), so that the band also holds the seam.
  [[nodiscard]] std::size_t at(std::size_t station, Unknown unknown) const {
    const std::size_t place = !chain_.closed         ? station
                              : 2 * station < n_ + 1 ? 2 * station
                                                     : 2 * (n_ - 1 - station) + 1;
    return unknowns * std::min(place, n_ - 1) + unknown;
  }
  [[nodiscard]] double half_width_m(const AcrossSample& sample) const {
    return chain_.stations[sample.station].half_width_m;
  }
  const StationChain& chain_;
  std::size_t n_;
  BandedNormal normal_;
};

/// Distance along the chain to the nearest station with samples, behind and ahead.
struct Nearness {
  std::vector<double> behind_m, ahead_m;
};
Nearness distances_to(const StationChain& chain, const std::vector<bool>& there) {
  const std::size_t n = chain.stations.size();
  constexpr double far = std::numeric_limits<double>::infinity();
  Nearness near{std::vector<double>(n, far), std::vector<double>(n, far)};
  double gone = far;
  for (std::size_t k = 0; k < (chain.closed ? 2 * n : n); ++k) {
    const std::size_t i = k % n;
    near.behind_m[i] = gone = there[i] ? 0.0 : gone;
    gone += step_m(chain, i);
  }
  gone = far;
  for (std::size_t k = chain.closed ? 2 * n : n; k-- > 0;) {
    const std::size_t i = k % n;
    gone = there[i] ? 0.0 : gone + step_m(chain, i);
    near.ahead_m[i] = gone;
  }
  return near;
}

class BankingProblem {
 public:
  BankingProblem(const StationChain& chain, const std::vector<AcrossSample>& samples, const DesignBanking& design,
                 const std::vector<BankingAnchor>& anchors, const BankingOptions& options)
      : chain_(chain),
        samples_(samples),
        design_(design),
        sigma_m_(options.terrain_sigma_m),
        given_sigma_m_(options.terrain_sigma_m),
        base_(chain) {
    weights_.resize(samples.size(), 1.0);
    find_sources();
    std::vector<bool> anchored(chain.stations.size(), false), on_other(chain.stations.size(), false);
    for (const BankingAnchor& anchor : anchors)
      anchored[anchor.station] = true, on_other[anchor.station] = on_other[anchor.station] || !anchor.is_main;
    const Nearness near = distances_to(chain, anchored), near_other = distances_to(chain, on_other);
    for (std::size_t i = 0; i < anchored.size(); ++i) {
      runs_out_.push_back(std::min(near.behind_m[i], near.ahead_m[i]) < banking_runout_m);
      const bool is_design = source_[i] == BankingSource::design;
      const bool to_other = std::min(near_other.behind_m[i], near_other.ahead_m[i]) < measured_runout_m;
      in_haste_.push_back(is_design ? runs_out_[i] : to_other);
    }
    add_smoothness();
    add_given(anchors);
  }

  BankingFit solve() {
    std::vector<bool> plane(chain_.stations.size(), false);
    if (!samples_.empty()) {
      const Field roof = fit_robustly(plane, most_rounds, true);
      const std::vector<bool> all(plane.size(), true);
      plane = choose_planes(roof, system(all).solve());
      fit_robustly(plane, last_rounds, false);
    }
    const Field field = system(plane).solve(true);
    BankingFit fit{field.slope, field.crown, {}, source_};
    for (double& c : fit.crown) c = c < zero_crown ? 0.0 : std::min(c, largest_crown);
    for (std::size_t i = 0; i < field.slope.size(); ++i)
      fit.sigma_slope.push_back(std::sqrt(field.slope_variance[i] +
                                          (source_[i] == BankingSource::design ? design_sigma * design_sigma : 0.0)));
    return fit;
  }

 private:
  void find_sources() {
    const std::size_t n = chain_.stations.size();
    std::vector<bool> sampled(n, false);
    for (const AcrossSample& sample : samples_) sampled[sample.station] = true;
    const Nearness near = distances_to(chain_, sampled);
    source_.assign(n, BankingSource::design);
    for (std::size_t i = 0; i < n; ++i) {
      const bool structure = chain_.stations[i].bridge || chain_.stations[i].tunnel;
      if (std::min(near.behind_m[i], near.ahead_m[i]) <= beside_m && !structure)
        source_[i] = BankingSource::dtm;
      else if (near.behind_m[i] + near.ahead_m[i] <= longest_gap_m ||
               std::min(near.behind_m[i], near.ahead_m[i]) <= longest_end_m)
        source_[i] = BankingSource::interpolated;
    }
  }

  void add_smoothness() {
    const std::size_t n = chain_.stations.size();
    for (std::size_t i = 0; i < n; ++i) {
      const bool has_next = i + 1 < n || (chain_.closed && n > 1), has_previous = i > 0 || chain_.closed;
      const std::size_t next = (i + 1) % n, previous = (i + n - 1) % n;
      const double ahead = has_next ? step_m(chain_, i) : 0.0, behind = has_previous ? step_m(chain_, previous) : 0.0;
      const double cell = std::max(0.5, 0.5 * (ahead + behind));
      base_.add({{i, 1.0}}, slope, design_.slope[i], cell / (slope_pull_sigma * slope_pull_sigma * slope_pull_m));
      base_.add({{i, 1.0}}, crown, 0.0, cell / (crown_pull_sigma * crown_pull_sigma * crown_pull_m));
      base_.add({{i, 1.0}}, rise, 0.0, cell / (rise_pull_sigma_m * rise_pull_sigma_m * rise_pull_m));
      base_.add({{i, 1.0}}, verge, 0.0, cell / (verge_pull_sigma * verge_pull_sigma * verge_pull_m));
      if (!has_next) continue;
      const double haste = in_haste_[i] ? runout_haste : 1.0;
      base_.add({{i, -1.0}, {next, 1.0}}, slope, 0.0, 1.0 / (haste * slope_walk_density * ahead));
      base_.add({{i, -1.0}, {next, 1.0}}, crown, 0.0, 1.0 / (crown_walk_density * ahead));
      base_.add({{i, -1.0}, {next, 1.0}}, rise, 0.0, 1.0 / (rise_walk_density * ahead));
      base_.add({{i, -1.0}, {next, 1.0}}, verge, 0.0, 1.0 / (verge_walk_density * ahead));
      if (has_previous)
        base_.add({{previous, 1.0 / behind}, {i, -1.0 / behind - 1.0 / ahead}, {next, 1.0 / ahead}}, slope, 0.0,
                  1.0 / (haste * slope_bend_density * cell));
    }
  }

  /// Planes of junctions, and the design where nothing is measured: not where the road runs out into such a plane.
  void add_given(const std::vector<BankingAnchor>& anchors) {
    constexpr double weight = 1.0 / (held_sigma * held_sigma), plane_weight = 1.0 / (plane_sigma * plane_sigma);
    const std::size_t n = chain_.stations.size();
    for (const BankingAnchor& anchor : anchors) {
      base_.add({{anchor.station, 1.0}}, slope, anchor.slope, plane_weight);
      if (!anchor.is_main) base_.add({{anchor.station, 1.0}}, crown, 0.0, weight);
    }
    for (std::size_t i = 0; i < n; ++i) {
      if (source_[i] != BankingSource::design || runs_out_[i]) continue;
      base_.add({{i, 1.0}}, slope, design_.slope[i], weight);
      base_.add({{i, 1.0}}, crown, design_.crown[i], weight);
    }
  }

  [[nodiscard]] ChainSystem system(const std::vector<bool>& plane) const {
    ChainSystem system = base_;
    for (std::size_t k = 0; k < samples_.size(); ++k) system.add(samples_[k], weights_[k] * information(samples_[k]));
    for (std::size_t i = 0; i < plane.size(); ++i)
      if (plane[i]) system.add({{i, 1.0}}, crown, 0.0, 1.0 / (held_crown_sigma * held_crown_sigma));
    return system;
  }
  [[nodiscard]] double information(const AcrossSample& sample) const {
    const double uneven_m = uneven_verge_sigma * beyond(sample);
    return std::min(1.0, sample.gsd_m * sample.gsd_m / independent_m2) / (sigma_m_ * sigma_m_ + uneven_m * uneven_m);
  }
  [[nodiscard]] double beyond(const AcrossSample& sample) const {
    return mean_beyond(sample.t_m, sample.gsd_m, chain_.stations[sample.station].half_width_m);
  }
  [[nodiscard]] double residual(const Field& field, const AcrossSample& sample) const {
    const std::size_t i = sample.station;
    return sample.rise_m - (field.rise[i] + sample.t_m * field.slope[i] -
                            mean_abs(sample.t_m, sample.gsd_m) * field.crown[i] - beyond(sample) * field.verge[i]);
  }

  /// Iteratively reweighted least squares; from the second round on also the noise of the pixels (median absolute
  /// deviation).
  Field fit_robustly(const std::vector<bool>& plane, int rounds, bool from_scratch) {
    Field field;
    std::vector<double> sizes(samples_.size());
    for (int round = 0; round < rounds; ++round) {
      Field next = system(plane).solve();
      double moved = round == 0 ? 1.0 : 0.0;
      for (std::size_t i = 0; round > 0 && i < next.slope.size(); ++i)
        moved = std::max(moved, std::abs(next.slope[i] - field.slope[i]));
      field = std::move(next);
      for (std::size_t k = 0; k < samples_.size(); ++k) sizes[k] = std::abs(residual(field, samples_[k]));
      if (round > 0 || !from_scratch) update_sigma(sizes);
      const double scale = from_scratch && round == 0 ? first_scale_m : cauchy_95 * sigma_m_;
      for (std::size_t k = 0; k < samples_.size(); ++k) weights_[k] = 1.0 / (1.0 + std::pow(sizes[k] / scale, 2));
      if (moved < settled) break;
    }
    return field;
  }
  void update_sigma(const std::vector<double>& sizes) {
    const double own = 1.4826 * median(sizes), n = static_cast<double>(sizes.size());
    sigma_m_ = std::max(
        least_sigma_m,
        std::sqrt((sigma_prior_samples * given_sigma_m_ * given_sigma_m_ + n * own * own) / (sigma_prior_samples + n)));
  }

  /// Log likelihood of the roof over the plane at every station, then the best path through both states.
  [[nodiscard]] std::vector<bool> choose_planes(const Field& roof, const Field& flat) const {
    const std::size_t n = chain_.stations.size();
    std::vector<double> gain(n, 0.0);
    for (std::size_t k = 0; k < samples_.size(); ++k) {
      const double r0 = residual(flat, samples_[k]), r1 = residual(roof, samples_[k]);
      gain[samples_[k].station] += 0.5 * weights_[k] * information(samples_[k]) * (r0 * r0 - r1 * r1);
    }
    for (std::size_t i = 0; i < n; ++i) {
      if (source_[i] == BankingSource::dtm) gain[i] -= roof_cost_per_m * step_m(chain_, i);
      if (roof.crown[i] < least_crown) gain[i] = std::min(gain[i], 0.0);
    }
    std::vector<std::array<bool, 2>> came_from_roof(n);
    std::array<double, 2> score{0.0, -switch_cost};  // plane, roof
    for (std::size_t i = 0; i < n; ++i) {
      const bool to_plane = score[1] - switch_cost > score[0], to_roof = score[1] >= score[0] - switch_cost;
      came_from_roof[i] = {to_plane, to_roof};
      score = {to_plane ? score[1] - switch_cost : score[0], (to_roof ? score[1] : score[0] - switch_cost) + gain[i]};
    }
    std::vector<bool> plane(n);
    bool is_roof = score[1] - switch_cost > score[0];
    for (std::size_t i = n; i-- > 0;) {
      plane[i] = !is_roof && source_[i] == BankingSource::dtm;
      is_roof = came_from_roof[i][is_roof ? 1 : 0];
    }
    return plane;
  }

  const StationChain& chain_;
  const std::vector<AcrossSample>& samples_;
  const DesignBanking& design_;
  double sigma_m_, given_sigma_m_;
  ChainSystem base_;
  std::vector<double> weights_;  // [sample]
  std::vector<BankingSource> source_;
  std::vector<bool> runs_out_;  // [station] near a plane that the road must lie in
  std::vector<bool> in_haste_;  // [station] turns quickly into it
};

}  // namespace

BankingFit fit_banking(const StationChain& chain, const std::vector<AcrossSample>& samples, const DesignBanking& design,
                       const std::vector<BankingAnchor>& anchors, const BankingOptions& options) {
  static const std::vector<AcrossSample> none;
  return BankingProblem(chain, samples.size() < least_samples ? none : samples, design, anchors, options).solve();
}

}  // namespace orthodrive::elevate
