// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/elevate/profiles/network_profiles.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "orthodrive/core/disjoint_sets.hpp"
#include "orthodrive/core/median.hpp"

namespace orthodrive::elevate {
namespace {

// Terrain.
constexpr double cauchy_scale = 2.385;  // in sigma: 95 % efficient where errors are normal (Huber, Robust Statistics)
// No model knows a carriageway better: rounding and survey, and a pixel averages over crown (2.5 %), edge and verge.
constexpr double smallest_sigma_m = 0.02, smallest_sigma_per_gsd = 0.01;
constexpr double first_sigma_m = 0.05, first_sigma_per_gsd = 0.02;  // until the residuals have been seen
// Junctions: exact to what drivers and tools could notice, with room to the precision of the solver.
constexpr double tie_height_sigma_m = 1e-4, tie_gradient_sigma = 1e-5;
constexpr double cross_slope_sigma = 0.025;  // drainage (RASt 06: 2.5 %) is all that is known of it beforehand
constexpr double known_banking_sigma = 1e-3;
// Of roads that part: no road is banked by more than the second, and tighter ones twist junctions.
constexpr double shared_sigma_m = 0.05, shared_sigma_per_m = 0.1;
// Limits give way where they would keep a road off a terrain that is sure of itself over more than this length: those
// of the gradient, and those of the curvature (which a bump in the terrain breaks over a longer one).
constexpr double gradient_gives_way_m = 10.0, gradient_gives_way_pixels = 1.0;
constexpr double curvature_gives_way_m = 20.0, curvature_gives_way_pixels = 2.0;
constexpr double limit_margin = 0.01;  // aim this much inside, so that the slack of the bounds stays inside too
// Clearance and tunnels hold against the terrain of a ramp this long, to a millimetre.
constexpr double clearance_pull_m = 2000.0, clearance_slack_m = 1e-3;
constexpr double control_pull_m = 2000.0, control_slack_m = 1e-3;  // likewise
constexpr double tunnel_pull_m = 30.0, tunnel_slack_m = 0.02;
// Where nothing is measured gradients fade over this length (bridges hang between their ends, roads run out level).
constexpr double fading_length_m = 200.0;
constexpr double determined_weight = 1e-4;  // of a gradient of 1: only decides what nothing else does

std::size_t at(int i) { return static_cast<std::size_t>(i); }

std::array<Term, 3> knot_curvature(const ProfileChain& chain, int k) {
  const double c = 1.0 / (chain.step_m * chain.step_m);
  return {Term{chain.coefficient(k), c}, Term{chain.coefficient(k + 1), -2.0 * c}, Term{chain.coefficient(k + 2), c}};
}
std::array<Term, 2> knot_gradient(const ProfileChain& chain, int k) {
  const double c = 0.5 / chain.step_m;
  return {Term{chain.coefficient(k), -c}, Term{chain.coefficient(k + 2), c}};
}

/// F(a): integral of (1 - |p|) (1 - |q|) exp(-a |p - q|) over p and q in [-1, 1].
double second_difference_response(double a) {
  constexpr int steps = 32;
  constexpr double h = 2.0 / steps;
  double sum = 0.0;
  for (int i = 0; i < steps; ++i)
    for (int k = 0; k < steps; ++k) {
      const double p = -1.0 + (i + 0.5) * h, q = -1.0 + (k + 0.5) * h;
      sum += (1.0 - std::abs(p)) * (1.0 - std::abs(q)) * std::exp(-a * std::abs(p - q)) * h * h;
    }
  return sum;
}

}  // namespace

NetworkProfiles::NetworkProfiles(const RoadNetwork& roads, const ProfileChains& chains,
                                 const std::vector<PathJunction>& junctions, const TerrainSamples& terrain,
                                 const ControlHeights& control, const std::vector<std::vector<double>>& start_m)
    : roads_(roads),
      chains_(chains),
      junctions_(junctions),
      terrain_(terrain),
      control_(control),
      start_m_(start_m),
      shared_(find_shared_pavement(roads, chains, junctions)) {
  for (const RoadPath& path : roads.paths) limits_of_path_.push_back(design_limits(path.highway));
  for (const ProfileChain& chain : chains.chains) knots_.push_back(knots_of(chain));
  for (const double gsd_m : terrain.gsd_m) sigma_m_.push_back(first_sigma_m + first_sigma_per_gsd * gsd_m);
  seen_sigma_m_ = sigma_m_;
  for (const DesignLimits& limits : limits_of_path_)
    curvature_sigma_1pm_[limits.design_speed_kmh] = comfortable_curvature_1pm(limits.design_speed_kmh);
  find_grounded_chains();
  for (const ProfileChain& chain : chains.chains)
    for (int i = 0; i < chain.unknowns(); ++i) {  // a coefficient is near the height at its own knot
      const double s_m = std::clamp((i - 1) * chain.step_m, 0.0, chain.length_m);
      const auto after = std::lower_bound(chain.places.begin(), chain.places.end(), s_m,
                                          [](const ChainPlace& place, double s) { return place.s_m < s; });
      const ChainPlace& place = after == chain.places.end() ? chain.places.back() : *after;
      x_.push_back(start_m[place.path][place.node]);
    }
  for (const PathJunction& junction : junctions) {
    const JunctionArm& arm = junction.arms.front();
    x_.insert(x_.end(), {start_m[arm.path][arm.node], 0.0, 0.0});
  }
}

std::vector<NetworkProfiles::Knot> NetworkProfiles::knots_of(const ProfileChain& chain) const {
  std::vector<Knot> knots;
  std::size_t place = 0, from = 0;
  for (int k = 0; k <= chain.intervals; ++k) {
    const double s_m = k * chain.step_m, reach_m = 1.5 * chain.step_m;
    while (place + 1 < chain.places.size() && chain.places[place + 1].s_m <= s_m) ++place;
    while (from < chain.places.size() && chain.places[from].s_m < s_m - reach_m) ++from;
    Knot knot{place, &limits_of_path_[chain.places[place].path], false, false};
    for (std::size_t i = from; i < chain.places.size() && chain.places[i].s_m <= s_m + reach_m; ++i)
      knot.is_grounded = knot.is_grounded || terrain_.of_node[chain.places[i].path][chain.places[i].node].is_road;
    const double curve_m = vertical_curve_length_m(knot.limits->design_speed_kmh);
    knot.is_near_end = !chain.closed && std::min(s_m, chain.length_m - s_m) < curve_m;
    knots.push_back(knot);
  }
  return knots;
}

void NetworkProfiles::find_grounded_chains() {
  const std::size_t n = chains_.chains.size();
  DisjointSets met(n);
  for (const PathJunction& junction : junctions_)
    for (const JunctionArm& arm : junction.arms) {
      const JunctionArm& first = junction.arms.front();
      met.join(chains_.of_node[arm.path][arm.node].chain, chains_.of_node[first.path][first.node].chain);
    }
  std::vector<bool> grounded(n, false);
  for (std::size_t c = 0; c < n; ++c)
    for (const ChainPlace& place : chains_.chains[c].places)
      if (terrain_.of_node[place.path][place.node].is_road) grounded[met.find(c)] = true;
  for (const HeightObservation& height : control_.heights)
    grounded[met.find(chains_.of_node[height.at.path][height.at.segment].chain)] = true;
  for (std::size_t c = 0; c < n; ++c) chain_is_grounded_.push_back(grounded[met.find(c)]);
}

/// Errors of a terrain model are alike within a pixel: what share of an independent observation a node is.
double NetworkProfiles::observation_share(std::size_t path, std::size_t node) const {
  const auto& nodes = roads_.paths[path].nodes;
  double spacing_m = 0.0;
  if (node > 0) spacing_m += 0.5 * distance(nodes[node - 1].p, nodes[node].p);
  if (node + 1 < nodes.size()) spacing_m += 0.5 * distance(nodes[node].p, nodes[node + 1].p);
  return std::clamp(spacing_m / terrain_.gsd_m[terrain_.of_node[path][node].source], 1e-3, 1.0);
}

/// The most that the terrain can pull at a road, by its length: the largest force of the Cauchy loss is half its scale.
double NetworkProfiles::pull_per_m() const {
  double pull = 0.0, length = 0.0;
  for (std::size_t p = 0; p < roads_.paths.size(); ++p)
    for (std::size_t n = 0; n + 1 < roads_.paths[p].nodes.size(); ++n) {
      const TerrainSample& sample = terrain_.of_node[p][n];
      if (!sample.is_road) continue;
      pull += 0.5 * cauchy_scale * observation_share(p, n) / (loosening_ * sigma_m_[sample.source]);
      length += distance(roads_.paths[p].nodes[n].p, roads_.paths[p].nodes[n + 1].p);
    }
  return length > 0.0 ? pull / length : 1.0;
}

void NetworkProfiles::add_terrain(RobustFit& fit) const {
  constexpr double unknown_sigma_m = 5.0;  // of the heights that chains without any terrain are held at
  for (std::size_t c = 0; c < chains_.chains.size(); ++c)
    for (const ChainPlace& place : chains_.chains[c].places) {
      const TerrainSample& sample = terrain_.of_node[place.path][place.node];
      const auto terms = chains_.chains[c].height(place.s_m);
      if (!chain_is_grounded_[c]) {
        fit.add_square(terms, start_m_[place.path][place.node], 1.0 / (unknown_sigma_m * unknown_sigma_m));
      } else if (sample.is_road) {
        const double sigma_m = loosening_ * sigma_m_[sample.source];
        fit.add_cauchy(terms, sample.z_m, observation_share(place.path, place.node) / (sigma_m * sigma_m),
                       cauchy_scale * sigma_m);
      }
    }
}

void NetworkProfiles::add_design(RobustFit& fit) const {
  const double pull = pull_per_m(), gsd_m = terrain_.coarsest_gsd_m;
  const double gradient_length_m = std::max(gradient_gives_way_m, gradient_gives_way_pixels * gsd_m);
  const double curvature_length_m = std::max(curvature_gives_way_m, curvature_gives_way_pixels * gsd_m);
  for (std::size_t c = 0; c < chains_.chains.size(); ++c) {
    const ProfileChain& chain = chains_.chains[c];
    for (int k = 0; k < chain.intervals + (chain.closed ? 0 : 1); ++k) {
      const Knot& knot = knots_[c][at(k)];
      const DesignLimits& limits = *knot.limits;
      const auto gradient = knot_gradient(chain, k);
      const auto curvature = knot_curvature(chain, k);
      // Vertical curvature is a first-order autoregressive process, alike over the length of a vertical curve.
      // What the terrain tells of roads does not hold where there is none, and less where a road bends into another
      // one.
      const double usual_sigma = curvature_sigma_1pm_.at(limits.design_speed_kmh),
                   comfort = comfortable_curvature_1pm(limits.design_speed_kmh);
      const double sigma = !knot.is_grounded  ? comfort
                           : knot.is_near_end ? std::sqrt(usual_sigma * comfort)
                                              : usual_sigma;
      const double alike = std::exp(-chain.step_m / vertical_curve_length_m(limits.design_speed_kmh));
      if (k == 0 && !chain.closed) {
        fit.add_square(curvature, 0.0, 1.0 / (sigma * sigma));
      } else {
        const auto before = knot_curvature(chain, k > 0 ? k - 1 : chain.intervals - 1);
        std::array<Term, 6> terms;
        for (std::size_t i = 0; i < 3; ++i)
          terms[i] = curvature[i], terms[i + 3] = {before[i].unknown, -alike * before[i].factor};
        fit.add_square(terms, 0.0, 1.0 / (sigma * sigma * (1.0 - alike * alike)));
      }
      const double usual = 0.5 * limits.gradient;
      fit.add_square(gradient, 0.0,
                     determined_weight + (knot.is_grounded ? 0.0 : chain.step_m / (fading_length_m * usual * usual)));

      // The force that holds the limits is that of terrain which pulls with all its might over these lengths: of a
      // gradient the sum of the forces on one side, of a curvature their moment.
      const double inside = 1.0 - limit_margin, steepest = inside * limits.gradient;
      const double gradient_slack = limit_margin * limits.gradient;
      fit.add_bounds(gradient, -steepest, steepest, pull * 0.5 * gradient_length_m * chain.step_m / gradient_slack,
                     gradient_slack);
      const double curvature_slack = limit_margin / std::max(limits.crest_radius_m, limits.sag_radius_m);
      fit.add_bounds(curvature, -inside / limits.crest_radius_m, inside / limits.sag_radius_m,
                     pull * 0.125 * curvature_length_m * curvature_length_m * chain.step_m / curvature_slack,
                     curvature_slack);
    }
  }
}

/// Roads that meet lie in one plane at their node. Its fall across the most important road is that road's banking.
void NetworkProfiles::add_junctions(RobustFit& fit) const {
  for (std::size_t j = 0; j < junctions_.size(); ++j) {
    const int z = chains_.unknowns + 3 * static_cast<int>(j), east = z + 1, north = z + 2;
    const JunctionArm* main = nullptr;
    for (const JunctionArm& arm : junctions_[j].arms) {
      const NodePlace& place = chains_.of_node[arm.path][arm.node];
      const ProfileChain& chain = chains_.chains[place.chain];
      const auto height = chain.height(place.s_m), gradient = chain.gradient(place.s_m);
      const Vec2 direction = arm.direction * (place.forward ? 1.0 : -1.0);
      std::array<Term, 5> same_height{};
      std::copy(height.begin(), height.end(), same_height.begin());
      same_height[4] = {z, -1.0};
      fit.add_square(same_height, 0.0, 1.0 / (tie_height_sigma_m * tie_height_sigma_m));
      std::array<Term, 6> same_plane{};
      std::copy(gradient.begin(), gradient.end(), same_plane.begin());
      same_plane[4] = {east, -direction.x}, same_plane[5] = {north, -direction.y};
      fit.add_square(same_plane, 0.0, 1.0 / (tie_gradient_sigma * tie_gradient_sigma));
      if (!main || road_rank(roads_.paths[arm.path].highway) > road_rank(roads_.paths[main->path].highway)) main = &arm;
    }
    const Vec2 left = left_normal(main->direction);
    const RoadNode& node = roads_.paths[main->path].nodes[main->node];
    // Measured banking takes precedence: the gradient of a road that ends here is smoothed over a vertical curve.
    const bool is_guess =
        node.banking_source == BankingSource::design || node.banking_source == BankingSource::interpolated;
    const double sigma = node.banking_source == BankingSource::unset || node.banking_source == BankingSource::none
                             ? cross_slope_sigma
                         : is_guess ? std::max(known_banking_sigma, node.sigma_banking)
                                    : known_banking_sigma;
    fit.add_square(std::array{Term{east, left.x}, Term{north, left.y}}, std::tan(node.banking), 1.0 / (sigma * sigma));
  }
}

std::array<Term, 4> NetworkProfiles::height_terms(std::size_t path, std::size_t segment, double fraction) const {
  const NodePlace &a = chains_.of_node[path][segment], &b = chains_.of_node[path][segment + 1];
  return chains_.chains[a.chain].height(a.s_m + fraction * (b.s_m - a.s_m));
}

namespace {
std::array<Term, 8> difference(const std::array<Term, 4>& upper, const std::array<Term, 4>& lower) {
  std::array<Term, 8> terms;
  for (std::size_t i = 0; i < 4; ++i) terms[i] = upper[i], terms[i + 4] = {lower[i].unknown, -lower[i].factor};
  return terms;
}
}  // namespace

/// The rows of heights come first (share_of_control).
void NetworkProfiles::add_control(RobustFit& fit) const {
  for (const HeightObservation& h : control_.heights)
    fit.add_square(height_terms(h.at.path, h.at.segment, h.at.fraction), h.z_m, 1.0 / (h.sigma_m * h.sigma_m));
  for (const RiseObservation& r : control_.rises)
    fit.add_square(difference(height_terms(r.upper.path, r.upper.segment, r.upper.fraction),
                              height_terms(r.lower.path, r.lower.segment, r.lower.fraction)),
                   r.rise_m, 1.0 / (r.sigma_m * r.sigma_m));
}

/// Control points take precedence over the terrain and the limits of the class: the road is within a sigma of them.
void NetworkProfiles::hold_control(RobustFit& fit) const {
  const double weight = pull_per_m() * control_pull_m / control_slack_m;
  for (const HeightObservation& h : control_.heights)
    fit.add_bounds(height_terms(h.at.path, h.at.segment, h.at.fraction), h.z_m - h.sigma_m, h.z_m + h.sigma_m, weight,
                   control_slack_m);
  for (const RiseObservation& r : control_.rises)
    fit.add_bounds(difference(height_terms(r.upper.path, r.upper.segment, r.upper.fraction),
                              height_terms(r.lower.path, r.lower.segment, r.lower.fraction)),
                   r.rise_m - r.sigma_m, r.rise_m + r.sigma_m, weight, control_slack_m);
}

/// Roads that part lie in one cross section as long as they share pavement: the main road's banking, as far as it is
/// known.
void NetworkProfiles::add_shared_pavement(RobustFit& fit) const {
  for (const SharedPavement& place : shared_) {
    const RoadNode& node = roads_.paths[place.main_path].nodes[place.main_node];
    const double sigma_m = std::max(shared_sigma_m, shared_sigma_per_m * std::abs(place.left_m));
    fit.add_square(difference(chains_.chains[place.other_chain].height(place.other_s_m),
                              chains_.chains[place.main_chain].height(place.main_s_m)),
                   std::tan(node.banking) * place.left_m, 1.0 / (sigma_m * sigma_m));
  }
}

RobustFit NetworkProfiles::build(const std::vector<HeightLimit>& limits) const {
  RobustFit fit(x_.size());
  add_control(fit);
  add_terrain(fit);
  add_design(fit);
  add_junctions(fit);
  add_shared_pavement(fit);
  const double pull = pull_per_m();
  for (std::size_t p = 0; p < roads_.paths.size(); ++p) {  // tunnels lie under the terrain
    if (!roads_.paths[p].tunnel) continue;
    for (std::size_t n = 1; n + 1 < roads_.paths[p].nodes.size(); ++n) {
      const NodePlace& place = chains_.of_node[p][n];
      const double z_m = terrain_.of_node[p][n].z_m;
      if (!std::isnan(z_m))
        fit.add_bounds(chains_.chains[place.chain].height(place.s_m), -INFINITY, z_m,
                       pull * tunnel_pull_m / tunnel_slack_m, tunnel_slack_m);
    }
  }
  for (const HeightLimit& limit : limits) {
    fit.add_bounds(height_terms(limit.path, limit.segment, limit.fraction), limit.low_m, limit.high_m,
                   pull * clearance_pull_m / clearance_slack_m, clearance_slack_m);
  }
  return fit;
}

RobustFit::Summary NetworkProfiles::solve(const std::vector<HeightLimit>& limits, int max_iterations,
                                          double loosening) {
  constexpr double step_tolerance_m = 2e-4;
  loosening_ = loosening;
  RobustFit fit = build(limits);
  hold_control(fit);
  return fit.solve(x_, max_iterations, loosening * step_tolerance_m);
}

void NetworkProfiles::estimate_scales() {
  estimate_terrain_sigma();
  estimate_curvature_sigma();
}

void NetworkProfiles::estimate_terrain_sigma() {
  constexpr std::size_t least_nodes = 30;  // fewer tell nothing
  constexpr double mad_of_normal = 0.6745;
  for (std::size_t d = 0; d < sigma_m_.size(); ++d) {
    std::vector<double> sizes;
    for (std::size_t p = 0; p < roads_.paths.size(); ++p)
      for (std::size_t n = 0; n < roads_.paths[p].nodes.size(); ++n) {
        const TerrainSample& sample = terrain_.of_node[p][n];
        if (!sample.is_road || sample.source != d) continue;
        const NodePlace& place = chains_.of_node[p][n];
        sizes.push_back(std::abs(value(chains_.chains[place.chain].height(place.s_m)) - sample.z_m));
      }
    if (sizes.size() < least_nodes) continue;
    seen_sigma_m_[d] = median(std::move(sizes)) / mad_of_normal;
    sigma_m_[d] = std::max(smallest_sigma_m + smallest_sigma_per_gsd * terrain_.gsd_m[d], seen_sigma_m_[d]);
  }
}

/// Method of moments: second differences z(s - L) - 2 z(s) + z(s + L) of the terrain have the variance
/// sigma^2 L^4 F(L / length) + 6 sigma_terrain^2 when curvature is the process of add_design. Comfort (AASHTO) is the
/// most, as second differences also see what is not road, a tenth of it the least. Differences beyond ten robust
/// sigmas, as at bridges and cuttings, count as that much.
void NetworkProfiles::estimate_curvature_sigma() {
  constexpr double widest_gap_m = 6.0, outlier_sigmas = 10.0, mad_of_normal = 0.6745, least_share = 0.1;
  constexpr std::size_t least_samples = 50;
  const auto reach_m = [&](double speed_kmh) {
    return std::max(1.5 * vertical_curve_length_m(speed_kmh), 3.0 * terrain_.coarsest_gsd_m);
  };
  struct Sample {
    double difference_m, noise_m2;
  };
  std::map<double, std::vector<Sample>> samples;
  for (const ProfileChain& chain : chains_.chains) {
    std::vector<const ChainPlace*> grounded;
    for (const ChainPlace& place : chain.places)
      if (terrain_.of_node[place.path][place.node].is_road) grounded.push_back(&place);
    const auto terrain = [&](const ChainPlace* place) -> const TerrainSample& {
      return terrain_.of_node[place->path][place->node];
    };
    const auto z_at = [&](double s_m) {
      const auto after = std::lower_bound(grounded.begin(), grounded.end(), s_m,
                                          [](const ChainPlace* place, double s) { return place->s_m < s; });
      if (after == grounded.end() || after == grounded.begin()) return std::nan("");
      const ChainPlace *a = *(after - 1), *b = *after;
      if (b->s_m - a->s_m > widest_gap_m) return std::nan("");
      const double f = b->s_m > a->s_m ? (s_m - a->s_m) / (b->s_m - a->s_m) : 0.0;
      return terrain(a).z_m * (1.0 - f) + terrain(b).z_m * f;
    };
    for (const ChainPlace* place : grounded) {
      const double speed_kmh = limits_of_path_[place->path].design_speed_kmh, reach = reach_m(speed_kmh);
      const double difference_m = z_at(place->s_m - reach) - 2.0 * terrain(place).z_m + z_at(place->s_m + reach);
      const double sigma_m = seen_sigma_m_[terrain(place).source];
      if (!std::isnan(difference_m)) samples[speed_kmh].push_back({difference_m, 6.0 * sigma_m * sigma_m});
    }
  }
  for (auto& [speed_kmh, of_speed] : samples) {
    if (of_speed.size() < least_samples) continue;
    std::vector<double> sizes;
    sizes.reserve(of_speed.size());
    for (const Sample& sample : of_speed) sizes.push_back(std::abs(sample.difference_m));
    const double largest_m = outlier_sigmas * median(std::move(sizes)) / mad_of_normal;
    double sum = 0.0;
    for (const Sample& sample : of_speed)
      sum += std::pow(std::min(std::abs(sample.difference_m), largest_m), 2) - sample.noise_m2;
    const double variance_m2 = std::max(0.0, sum / static_cast<double>(of_speed.size()));
    const double reach = reach_m(speed_kmh), comfort = comfortable_curvature_1pm(speed_kmh);
    const double response = second_difference_response(reach / vertical_curve_length_m(speed_kmh));
    const double sigma = std::sqrt(variance_m2 / response) / (reach * reach);
    curvature_sigma_1pm_[speed_kmh] = std::clamp(sigma, least_share * comfort, comfort);
  }
}

double NetworkProfiles::value(std::span<const Term> terms) const {
  double sum = 0.0;
  for (const Term& term : terms) sum += term.factor * x_[at(term.unknown)];
  return sum;
}

double NetworkProfiles::height_m(std::size_t path, std::size_t segment, double fraction) const {
  return value(height_terms(path, segment, fraction));
}

/// How far every coefficient follows when all control points rise by 1: their share in the heights; the terrain has the
/// rest.
std::vector<double> NetworkProfiles::share_of_control(const SparseJacobian& rows) const {
  if (control_.heights.empty()) return std::vector<double>(x_.size(), 0.0);
  std::vector<double> right(rows.row_start.size() - 1, 0.0);
  for (std::size_t i = 0; i < control_.heights.size(); ++i) right[i] = 1.0 / control_.heights[i].sigma_m;
  return solve_normal(rows, right);
}

void NetworkProfiles::write(const std::vector<HeightLimit>& limits, RoadNetwork& roads) const {
  const SparseJacobian rows = build(limits).weighted_rows(x_);  // what holds the control points knows no more than they
  const InverseNormal inverse(rows);
  const std::vector<double> share = share_of_control(rows);
  for (std::size_t p = 0; p < roads.paths.size(); ++p)
    for (std::size_t n = 0; n < roads.paths[p].nodes.size(); ++n) {
      const NodePlace& place = chains_.of_node[p][n];
      const ProfileChain& chain = chains_.chains[place.chain];
      const auto height = chain.height(place.s_m), gradient = chain.gradient(place.s_m);
      RoadNode& node = roads.paths[p].nodes[n];
      node.z_m = value(height);
      node.gradient = value(gradient) * (place.forward ? 1.0 : -1.0);
      double variance = 0.0;
      for (const Term& a : height)
        for (const Term& b : height) variance += a.factor * b.factor * inverse.at(a.unknown, b.unknown);
      // Nodes of one slope err together: their spread does not average out, and the fit cannot know it.
      const TerrainSample& sample = terrain_.of_node[p][n];
      double of_control = 0.0;
      for (const Term& term : height) of_control += term.factor * share[at(term.unknown)];
      const double spread_m = sample.is_road ? (1.0 - std::clamp(of_control, 0.0, 1.0)) * sample.spread_m : 0.0;
      node.sigma_z_m = std::hypot(std::sqrt(std::max(0.0, variance)), spread_m);
    }
  for (std::size_t j = 0; j < junctions_.size(); ++j)
    for (const JunctionArm& arm : junctions_[j].arms)
      roads.paths[arm.path].nodes[arm.node].z_m = x_[at(chains_.unknowns) + 3 * j];
}

template <typename Excess>
std::vector<LimitBreach> NetworkProfiles::breaches(Excess&& excess) const {
  std::vector<LimitBreach> result;
  for (std::size_t c = 0; c < chains_.chains.size(); ++c) {
    const ProfileChain& chain = chains_.chains[c];
    bool open = false;
    for (int k = 0; k <= chain.intervals; ++k) {
      const Knot& knot = knots_[c][at(k)];
      const auto [size, limit] = excess(chain, k, *knot.limits);
      if (!(size > limit * (1.0 + limit_margin))) {
        open = false;
        continue;
      }
      if (!open) result.push_back({});
      LimitBreach& breach = result.back();
      if (!open || size / limit > breach.worst / breach.limit) {
        const ChainPlace& place = chain.places[knot.place];
        breach.path = place.path, breach.node = place.node, breach.worst = size, breach.limit = limit;
      }
      breach.length_m += chain.step_m;
      open = true;
    }
  }
  return result;
}

std::vector<LimitBreach> NetworkProfiles::gradient_breaches() const {
  return breaches([&](const ProfileChain& chain, int k, const DesignLimits& limits) {
    return std::pair{std::abs(value(knot_gradient(chain, k))), limits.gradient};
  });
}

std::vector<LimitBreach> NetworkProfiles::curvature_breaches() const {
  return breaches([&](const ProfileChain& chain, int k, const DesignLimits& limits) {
    const double curvature = value(knot_curvature(chain, k));
    return std::pair{std::abs(curvature), 1.0 / (curvature < 0.0 ? limits.crest_radius_m : limits.sag_radius_m)};
  });
}

}  // namespace orthodrive::elevate
