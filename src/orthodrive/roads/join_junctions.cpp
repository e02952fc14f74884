// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/roads/join_junctions.hpp"

#include <ceres/ceres.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>

#include "orthodrive/model/roads/osm_node_id.hpp"

namespace orthodrive {
namespace {

// Weights of the linear least-squares problem, 1/m. Lines decide; what they leave open (roads that meet at a small
// angle) is decided by the fitted nodes along the lines.
constexpr double along_weight = 0.2, end_weight = 0.5;
// Two junctions d metres apart on one chain should move alike with weight 20 / d: a short link keeps its direction.
constexpr double link_weight_m = 20.0;
constexpr double meeting_sigma_m = 0.05;  // of a side road that ends; more for roads that count more

struct Incidence {
  std::size_t chain = 0, node = 0;
};
struct Junction {
  std::vector<Incidence> incidences;
  double p[2] = {0.0, 0.0};
};

/// weight * direction . (P - p)
class OnLineCost final : public ceres::SizedCostFunction<1, 2> {
 public:
  OnLineCost(Vec2 p, Vec2 direction, double weight) : p_(p), w_(direction * weight) {}
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    residuals[0] = dot(w_, Vec2{parameters[0][0], parameters[0][1]} - p_);
    if (jacobians && jacobians[0]) jacobians[0][0] = w_.x, jacobians[0][1] = w_.y;
    return true;
  }

 private:
  Vec2 p_, w_;
};

/// weight * ((P - p) - (Q - q))
class MoveAlikeCost final : public ceres::SizedCostFunction<2, 2, 2> {
 public:
  MoveAlikeCost(Vec2 p_minus_q, double weight) : difference_(p_minus_q), weight_(weight) {}
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    residuals[0] = weight_ * (parameters[0][0] - parameters[1][0] - difference_.x);
    residuals[1] = weight_ * (parameters[0][1] - parameters[1][1] - difference_.y);
    for (int k = 0; jacobians && k < 2; ++k) {
      if (!jacobians[k]) continue;
      const double w = k == 0 ? weight_ : -weight_;
      jacobians[k][0] = w, jacobians[k][1] = 0.0, jacobians[k][2] = 0.0, jacobians[k][3] = w;
    }
    return true;
  }

 private:
  Vec2 difference_;
  double weight_;
};

double smooth_decay(double x) { return x >= 1.0 ? 0.0 : 1.0 - x * x * (3.0 - 2.0 * x); }

/// Where a junction lies on a chain.
struct Incident {
  std::size_t node = 0;
  Junction* junction = nullptr;
};
/// Where a chain has to pass.
struct Stop {
  std::size_t node = 0;
  Vec2 p;
};

std::map<std::int64_t, Junction> find_junctions(const std::vector<RoadChain>& chains) {
  std::map<std::int64_t, Junction> junctions;
  for (std::size_t c = 0; c < chains.size(); ++c) {
    const std::size_t count = chains[c].nodes.size() - (chains[c].closed ? 1 : 0);  // the last node repeats the first
    for (std::size_t i = 0; i < count; ++i)
      if (const auto id = chains[c].nodes[i].osm_node; is_osm_node(id)) junctions[id].incidences.push_back({c, i});
  }
  std::erase_if(junctions, [](const auto& item) { return item.second.incidences.size() < 2; });
  return junctions;
}

std::vector<std::vector<Incident>> incidents_of(const std::vector<RoadChain>& chains,
                                                std::map<std::int64_t, Junction>& junctions) {
  std::vector<std::vector<Incident>> stops(chains.size());
  for (auto& [id, junction] : junctions)
    for (const auto [c, i] : junction.incidences) stops[c].push_back({i, &junction});
  for (auto& of_chain : stops)
    std::sort(of_chain.begin(), of_chain.end(), [](const Incident& a, const Incident& b) { return a.node < b.node; });
  return stops;
}

/// How much a chain's own line counts at a junction.
double weight_at(const RoadChain& chain, std::size_t node) {
  const bool passes = chain.closed || (node > 0 && node + 1 < chain.nodes.size());
  return (1.0 + chain.rank) * (passes ? 1.0 : end_weight);
}

void solve_places(const std::vector<RoadChain>& chains, const std::vector<Polyline>& lines,
                  std::map<std::int64_t, Junction>& junctions, const std::vector<std::vector<Incident>>& stops) {
  ceres::Problem problem;
  for (auto& [id, junction] : junctions) {
    for (const auto [c, i] : junction.incidences) {
      const Polyline& line = lines[c];
      const Vec2 behind = i > 0 ? line[i - 1] : chains[c].closed ? line[line.size() - 2] : line[i];
      const Vec2 tangent = normalized(line[std::min(i + 1, line.size() - 1)] - behind);
      const double weight = weight_at(chains[c], i);
      problem.AddResidualBlock(new OnLineCost(line[i], left_normal(tangent), weight), nullptr, junction.p);
      problem.AddResidualBlock(new OnLineCost(line[i], tangent, along_weight * weight), nullptr, junction.p);
      junction.p[0] += line[i].x / static_cast<double>(junction.incidences.size());
      junction.p[1] += line[i].y / static_cast<double>(junction.incidences.size());
    }
  }
  for (std::size_t c = 0; c < chains.size(); ++c)
    for (std::size_t k = 0; k + 1 < stops[c].size(); ++k) {
      const Incident &a = stops[c][k], &b = stops[c][k + 1];
      const double apart_m = chains[c].nodes[b.node].s_m - chains[c].nodes[a.node].s_m;
      if (a.junction != b.junction)
        problem.AddResidualBlock(
            new MoveAlikeCost(lines[c][a.node] - lines[c][b.node], link_weight_m / std::max(1.0, apart_m)), nullptr,
            a.junction->p, b.junction->p);
    }
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  solver.sparse_linear_algebra_library_type = ceres::EIGEN_SPARSE;
  solver.max_num_iterations = 10;  // linear: two or three
  solver.num_threads = 1;
  solver.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
}

/// Moves the line to its stops; every move fades out before the next stop, so that each one is met exactly.
void bend_to_stops(const RoadChain& chain, const std::vector<Stop>& stops, double bend_m, Polyline& line) {
  const double total_m = chain.nodes.back().s_m;
  const auto s_of = [&](std::size_t k) { return chain.nodes[stops[k].node].s_m; };
  const Polyline fitted = line;
  for (std::size_t k = 0; k < stops.size(); ++k) {
    const Vec2 move = stops[k].p - fitted[stops[k].node];
    double behind_m = bend_m, ahead_m = bend_m;
    if (k > 0)
      behind_m = s_of(k) - s_of(k - 1);
    else if (chain.closed)
      behind_m = s_of(0) + total_m - s_of(stops.size() - 1);
    if (k + 1 < stops.size())
      ahead_m = s_of(k + 1) - s_of(k);
    else if (chain.closed)
      ahead_m = s_of(0) + total_m - s_of(k);
    for (std::size_t i = 0; i < line.size(); ++i) {
      double d = chain.nodes[i].s_m - s_of(k);
      if (chain.closed) d -= std::round(d / total_m) * total_m;
      const double reach_m = std::max(1e-6, std::min(bend_m, d < 0.0 ? behind_m : ahead_m));
      line[i] = line[i] + move * smooth_decay(std::abs(d) / reach_m);
    }
  }
  for (const Stop& stop : stops) line[stop.node] = stop.p;
  if (chain.closed) line.back() = line.front();
}

}  // namespace

std::vector<JunctionPlace> place_junctions(const std::vector<RoadChain>& chains, const std::vector<Polyline>& lines) {
  std::map<std::int64_t, Junction> junctions = find_junctions(chains);
  if (junctions.empty()) return {};
  solve_places(chains, lines, junctions, incidents_of(chains, junctions));
  std::vector<JunctionPlace> places;
  for (const auto& [id, junction] : junctions) {
    JunctionPlace& place = places.emplace_back(JunctionPlace{{junction.p[0], junction.p[1]}, {}});
    // Who counts most gives way least.
    for (const auto [c, i] : junction.incidences)
      place.passes.push_back({c, i, meeting_sigma_m * weight_at(chains[c], i)});
  }
  return places;
}

void bend_to_junctions(const std::vector<RoadChain>& chains, const std::vector<JunctionPlace>& places,
                       std::vector<Polyline>& lines, double bend_m) {
  std::vector<std::vector<Stop>> stops(chains.size());
  for (const JunctionPlace& place : places)
    for (const JunctionPlace::Pass& pass : place.passes) stops[pass.chain].push_back({pass.node, place.p});
  for (std::size_t c = 0; c < chains.size(); ++c) {
    std::sort(stops[c].begin(), stops[c].end(), [](const Stop& a, const Stop& b) { return a.node < b.node; });
    bend_to_stops(chains[c], stops[c], bend_m, lines[c]);
  }
}

}  // namespace orthodrive
