// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/baselines/mrf_roads.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "baselines/photo_scene.hpp"
#include "orthodrive/baselines/infer_mrf.hpp"
#include "orthodrive/core/error.hpp"

namespace orthodrive {
namespace {

using namespace baselines;

using namespace test;

/// What its tests need of a problem, without a photo: sites in a row eastwards, each 10 m, with random costs.
MrfChain add_chain(MrfProblem& problem, Vec2 start, int count, Random& random, bool closed = false) {
  MrfChain chain{problem.sites.size(), problem.sites.size() + static_cast<std::size_t>(count), closed, 0};
  for (int i = 0; i < count; ++i) {
    MrfSite site{.a = start + Vec2{10.0 * i, 0.0},
                 .b = start + Vec2{10.0 * i + 10.0, 0.0},
                 .along = {1.0, 0.0},
                 .normal = {0.0, 1.0}};
    site.length_m = 10.0;
    site.input_width = 2, site.min_width = 1, site.max_width = 3;
    site.sums.half_knots = problem.max_offset + site.max_width + problem.context;
    site.sums.seen = 1.0;
    double non_road = 0.0, beside = 0.0;
    for (int k = -site.sums.half_knots; k <= site.sums.half_knots; ++k) {
      const double p = random.uniform();
      site.sums.non_road_m.push_back(static_cast<float>(non_road += 2.0 * p * problem.step_m));
      site.sums.road_beside_m.push_back(static_cast<float>(beside += 2.0 * (1.0 - p) * problem.step_m));
      site.sums.edge_m.push_back(static_cast<float>(2.0 * random.uniform()));
    }
    problem.sites.push_back(std::move(site));
  }
  problem.chains.push_back(chain);
  return chain;
}

MrfProblem tiny_problem() {
  MrfProblem problem{.step_m = 1.0, .max_offset = 2, .context = 1};
  problem.weights = {.smooth_offset = 0.2, .smooth_width = 0.1};
  return problem;
}

/// Least energy over all combinations of states.
double brute_force(const MrfProblem& problem) {
  std::vector<MrfState> states;
  for (const MrfSite& site : problem.sites) states.push_back({-problem.max_offset, site.min_width});
  double best = std::numeric_limits<double>::infinity();
  for (;;) {
    best = std::min(best, mrf_energy(problem, states));
    std::size_t i = 0;
    for (; i < states.size(); ++i) {
      if (++states[i].width <= problem.sites[i].max_width) break;
      states[i].width = problem.sites[i].min_width;
      if (++states[i].offset <= problem.max_offset) break;
      states[i].offset = -problem.max_offset;
    }
    if (i == states.size()) return best;
  }
}

void expect_never_rises(const std::vector<double>& energies) {
  ASSERT_FALSE(energies.empty());
  EXPECT_TRUE(std::isfinite(energies.front()));
  for (std::size_t k = 0; k + 1 < energies.size(); ++k) EXPECT_LE(energies[k + 1], energies[k]) << k;
}

TEST(InferMrf, one_road_reaches_the_least_energy_of_all_states) {
  for (const std::uint64_t seed : {1, 2, 3, 4, 5, 6}) {
    Random random(seed);
    MrfProblem problem = tiny_problem();
    add_chain(problem, {0.0, 0.0}, 4, random);
    problem.conflicts.resize(4);
    const auto result = infer_mrf(problem);
    EXPECT_NEAR(mrf_energy(problem, result.states), brute_force(problem), 1e-9) << seed;
    EXPECT_NEAR(result.energies.back(), mrf_energy(problem, result.states), 1e-9);
    EXPECT_TRUE(result.converged);
    expect_never_rises(result.energies);
  }
}

TEST(InferMrf, pieces_of_other_width_on_one_road_are_solved_exactly_too) {
  Random random(9);
  MrfProblem problem = tiny_problem();
  add_chain(problem, {0.0, 0.0}, 4, random);
  problem.sites[2].min_width = problem.sites[3].min_width = 2;
  problem.sites[0].max_width = 2;
  problem.conflicts.resize(4);
  EXPECT_NEAR(infer_mrf(problem).energies.back(), brute_force(problem), 1e-9);
}

TEST(InferMrf, a_closed_road_counts_the_step_from_its_end_to_its_beginning) {
  int optimal = 0;
  for (const std::uint64_t seed : {11, 12, 13, 14, 15}) {
    Random random(seed);
    MrfProblem problem = tiny_problem();
    problem.weights.smooth_offset = 2.0;
    add_chain(problem, {0.0, 0.0}, 4, random, true);
    problem.conflicts.resize(4);
    const auto result = infer_mrf(problem);
    expect_never_rises(result.energies);
    EXPECT_NEAR(result.energies.back(), mrf_energy(problem, result.states), 1e-9);
    const double best = brute_force(problem);
    EXPECT_LT(result.energies.back(), best + 0.3);  // blocks need not find the optimum of a cycle
    optimal += result.energies.back() < best + 1e-9;
  }
  EXPECT_GE(optimal, 3);
}

TEST(InferMrf, two_roads_side_by_side_never_overlap_and_are_near_the_optimum) {
  int optimal = 0;
  for (const std::uint64_t seed : {21, 22, 23, 24, 25, 26}) {
    Random random(seed);
    MrfProblem problem = tiny_problem();
    add_chain(problem, {0.0, 0.0}, 2, random);
    add_chain(problem, {3.0, 4.0}, 2, random);  // staggered: each site lies beside two
    problem.conflicts = find_conflicts(problem, {});
    ASSERT_EQ(problem.conflicts[0], (std::vector<std::size_t>{2}));
    ASSERT_EQ(problem.conflicts[1], (std::vector<std::size_t>{2, 3}));
    const auto result = infer_mrf(problem);
    expect_never_rises(result.energies);
    EXPECT_TRUE(std::isfinite(mrf_energy(problem, result.states)));
    EXPECT_NEAR(result.energies.back(), mrf_energy(problem, result.states), 1e-9);
    const double best = brute_force(problem);
    EXPECT_GE(result.energies.back(), best - 1e-9);
    optimal += result.energies.back() < best + 1e-9;
    // No road can be improved alone.
    for (const MrfChain& chain : problem.chains) {
      std::vector<MrfState> states = result.states;
      for (int o = -2; o <= 2; ++o)
        for (int w = 1; w <= 3; ++w)
          for (int p = -2; p <= 2; ++p)
            for (int v = 1; v <= 3; ++v) {
              states[chain.first] = {o, w}, states[chain.first + 1] = {p, v};
              EXPECT_GE(mrf_energy(problem, states), result.energies.back() - 1e-9);
            }
    }
  }
  EXPECT_GE(optimal, 3);
}

TEST(InferMrf, roads_that_cross_meet_or_lie_on_other_layers_are_not_kept_apart) {
  Random random(1);
  MrfProblem problem = tiny_problem();
  add_chain(problem, {0.0, 0.0}, 1, random);
  add_chain(problem, {0.0, 5.0}, 1, random);
  const auto conflicts = [&] { return find_conflicts(problem, {.max_angle_deg = 20.0})[0].size(); };
  const auto turn = [&](double degrees) {
    MrfSite& site = problem.sites[1];
    site.along = {std::cos(degrees * M_PI / 180.0), std::sin(degrees * M_PI / 180.0)};
    site.normal = left_normal(site.along);
    site.b = site.a + site.along * site.length_m;
  };
  EXPECT_EQ(conflicts(), 1u);
  turn(19.0);
  EXPECT_EQ(conflicts(), 1u);
  turn(21.0);
  EXPECT_EQ(conflicts(), 0u);
  turn(0.0);
  problem.sites[1].layer = 1;
  EXPECT_EQ(conflicts(), 0u);
  problem.sites[1].layer = 0;
  problem.sites[1].a = {0.0, 1.0}, problem.sites[1].b = {10.0, 1.0};  // one road on the map: they cannot be kept apart
  EXPECT_EQ(conflicts(), 0u);
  problem.sites[1].a = {0.0, 50.0}, problem.sites[1].b = {10.0, 50.0};  // out of reach
  EXPECT_EQ(conflicts(), 0u);
}

TEST(MrfOverlap, equals_a_grid_of_points) {
  Random random(4);
  for (int trial = 0; trial < 60; ++trial) {
    MrfProblem problem = tiny_problem();
    for (int k = 0; k < 2; ++k) {
      const double angle = random.uniform(0.0, 2.0 * M_PI);
      MrfSite site{.a = {random.uniform(0.0, 12.0), random.uniform(0.0, 12.0)},
                   .along = {std::cos(angle), std::sin(angle)}};
      site.length_m = random.uniform(2.0, 10.0);
      site.b = site.a + site.along * site.length_m;
      site.normal = left_normal(site.along);
      problem.sites.push_back(site);
    }
    const MrfState s{1, 2}, t{-1, 1};
    int common = 0;
    for (double x = -15.0; x < 30.0; x += 0.1)
      for (double y = -15.0; y < 30.0; y += 0.1) {
        const auto inside = [&](const MrfSite& site, const MrfState& state) {
          const Vec2 d = Vec2{x, y} - site.a;
          const double along = dot(d, site.along), across = dot(d, site.normal) - problem.offset_m(state);
          return along > 0.0 && along < site.length_m && std::abs(across) < 0.5 * problem.width_m(state);
        };
        common += inside(problem.sites[0], s) && inside(problem.sites[1], t);
      }
    const bool found = overlap(problem, 0, s, 1, t);
    if (common > 3) {
      EXPECT_TRUE(found) << trial;
    }
    if (!found) {
      EXPECT_EQ(common, 0) << trial;
    }
    EXPECT_EQ(found, overlap(problem, 1, t, 0, s));
  }
}

MrfRoadsOptions quick() { return {.threads = 1}; }

TEST(MrfRoads, a_shifted_road_is_recovered_within_a_step) {
  RoadScene scene = make_scene(200.0);
  add_truth(scene, straight(at(10, 103), at(190, 103)), 7.0);
  add_way(scene, 1, {{.p = at(10, 100), .width_m = 5.5}, {.p = at(190, 100), .width_m = 5.5}});
  add_way(scene, 2, {{.p = at(190, 106), .width_m = 5.5}, {.p = at(10, 106), .width_m = 5.5}});
  scene.osm.paths.pop_back();
  for (const RoadPolygons polygons : {RoadPolygons::smooth, RoadPolygons::douglas_peucker}) {
    MrfRoadsOptions options = quick();
    options.polygons = polygons;
    const auto result = refine_roads_mrf(scene.osm, exact_evidence(scene.labels), options);
    ASSERT_EQ(result.roads.paths.size(), 1u);
    const auto& nodes = result.roads.paths[0].nodes;
    ASSERT_EQ(nodes.size(), 19u);
    for (const RoadNode& node : nodes) {
      EXPECT_NEAR(node.offset_m, 3.0, 0.26);
      EXPECT_NEAR(node.width_m, 7.0, 0.51);
    }
    EXPECT_LT(result.energy_after, result.energy_before);
    EXPECT_TRUE(result.converged);
    EXPECT_TRUE(result.findings.empty());
    double area = 0.0;
    for (const Polygon& polygon : result.surfaces.at(0)) area += area_m2(polygon);
    EXPECT_NEAR(area, 180.0 * 7.0, 180.0 * 0.5);
  }
}

TEST(MrfRoads, offset_is_positive_to_the_left_of_the_way) {
  RoadScene scene = make_scene(120.0);
  add_truth(scene, straight(at(10, 62), at(110, 62)), 6.0);
  add_way(scene, 1, {{.p = at(110, 60), .width_m = 6.0}, {.p = at(10, 60), .width_m = 6.0}});
  EXPECT_NEAR(refine_roads_mrf(scene.osm, exact_evidence(scene.labels), quick()).roads.paths[0].nodes[5].offset_m, -2.0,
              0.26);
}

/// Two carriageways on the map, but the photo shows only one road, between them.
RoadScene make_pair() {
  RoadScene scene = make_scene(160.0);
  add_truth(scene, straight(at(10, 80), at(150, 80)), 6.0);
  add_way(scene, 1, {{.p = at(10, 83.5), .width_m = 6.0}, {.p = at(150, 83.5), .width_m = 6.0}}, "primary");
  add_way(scene, 2, {{.p = at(150, 76.5), .width_m = 6.0}, {.p = at(10, 76.5), .width_m = 6.0}}, "primary");
  return scene;
}

/// Area in common, counted by points of a fine grid.
int common_points(const MultiPolygon& a, const MultiPolygon& b) {
  int common = 0;
  for (double x = 0.0; x < 160.0; x += 0.5)
    for (double y = 65.03; y < 95.0; y += 0.1) common += contains(a, at(x, y)) && contains(b, at(x, y));
  return common;
}

TEST(MrfRoads, parallel_carriageways_never_overlap) {
  const RoadScene scene = make_pair();
  MrfRoadsOptions options = quick();
  options.polygons = RoadPolygons::douglas_peucker;
  options.simplify_m = 0.0;
  const auto apart = refine_roads_mrf(scene.osm, exact_evidence(scene.labels), options);
  EXPECT_EQ(common_points(apart.surfaces[0], apart.surfaces[1]), 0);
  expect_never_rises(apart.energies);
  options.no_overlap_angle_deg = -1.0;  // no pair is that parallel: both take the only road
  const auto together = refine_roads_mrf(scene.osm, exact_evidence(scene.labels), options);
  EXPECT_GT(common_points(together.surfaces[0], together.surfaces[1]), 1000);
}

TEST(MrfRoads, default_widths_that_overlap_on_the_map_start_narrow) {
  RoadScene scene = make_scene(160.0);
  add_truth(scene, straight(at(10, 83), at(150, 83)), 5.0);
  add_truth(scene, straight(at(10, 77), at(150, 77)), 5.0);
  add_way(scene, 1, {{.p = at(10, 83), .width_m = 8.0}, {.p = at(150, 83), .width_m = 8.0}}, "primary");
  add_way(scene, 2, {{.p = at(150, 77), .width_m = 8.0}, {.p = at(10, 77), .width_m = 8.0}}, "primary");
  const auto result = refine_roads_mrf(scene.osm, exact_evidence(scene.labels), quick());
  EXPECT_TRUE(std::isfinite(result.energy_before));
  for (const RoadPath& path : result.roads.paths)
    for (const RoadNode& node : path.nodes) {
      EXPECT_NEAR(node.width_m, 5.0, 0.51);
      EXPECT_NEAR(node.offset_m, 0.0, 0.26);
    }
}

TEST(MrfRoads, a_road_without_a_photo_keeps_osm_and_says_so) {
  RoadScene scene = make_scene(200.0);
  add_truth(scene, straight(at(10, 103), at(190, 103)), 8.0);
  paint(scene.labels, {at(0, 0), at(200, 0), at(200, 200), at(0, 200)}, label_nodata);
  add_way(scene, 77, {{.p = at(10, 100), .width_m = 5.5}, {.p = at(190, 100), .width_m = 5.5}});
  add_way(scene, 78, {{.p = at(10, -300), .width_m = 5.5}, {.p = at(190, -300), .width_m = 5.5}});  // beyond the frame
  const auto result = refine_roads_mrf(scene.osm, exact_evidence(scene.labels), quick());
  ASSERT_EQ(result.findings.size(), 2u);
  for (const Finding& finding : result.findings) EXPECT_EQ(finding.code, "refine.no_photo");
  for (const RoadPath& path : result.roads.paths)
    for (const RoadNode& node : path.nodes) {
      EXPECT_NEAR(node.offset_m, 0.0, 1e-9);
      EXPECT_NEAR(node.width_m, 5.5, 1e-9);
    }
}

TEST(MrfRoads, a_road_runs_on_through_a_gap_in_the_photo) {
  RoadScene scene = make_scene(200.0);
  add_truth(scene, straight(at(10, 103), at(190, 103)), 6.0);
  paint(scene.labels, {at(85, 0), at(115, 0), at(115, 200), at(85, 200)}, label_nodata);
  add_way(scene, 1, {{.p = at(10, 100), .width_m = 6.0}, {.p = at(190, 100), .width_m = 6.0}});
  const auto result = refine_roads_mrf(scene.osm, exact_evidence(scene.labels), quick());
  for (const RoadNode& node : result.roads.paths[0].nodes) EXPECT_NEAR(node.offset_m, 3.0, 0.3);
}

TEST(MrfRoads, a_tunnel_does_not_follow_what_lies_above) {
  RoadScene scene = make_scene(200.0);
  add_truth(scene, straight(at(10, 104), at(190, 104)), 6.0);
  add_way(scene, 1, {{.p = at(10, 100), .width_m = 6.0}, {.p = at(190, 100), .width_m = 6.0}});
  scene.osm.paths[0].tunnel = true;
  const auto result = refine_roads_mrf(scene.osm, exact_evidence(scene.labels), quick());
  for (const RoadNode& node : result.roads.paths[0].nodes) EXPECT_NEAR(node.offset_m, 0.0, 1e-9);
  EXPECT_TRUE(result.findings.empty());
}

/// A through road of two ways and a side road, shifted; a roundabout.
RoadScene make_network() {
  RoadScene scene = make_scene(260.0);
  add_truth(scene, straight(at(10, 100), at(250, 110)), 7.0);
  add_truth(scene, straight(at(100, 103.75), at(110, 250)), 5.0);
  const double r = 18.0;
  add_truth(scene,
            trace(2 * M_PI * r, [&](double s) { return at(200 + r * std::cos(s / r), 200 + r * std::sin(s / r)); }),
            6.0);
  const Vec2 shift{1.0, 2.0};
  const auto node = [&](double x, double y, std::int64_t id) {
    return RoadNode{.p = at(x, y) + shift, .osm_node = id, .width_m = 5.5};
  };
  const RoadNode t = node(100, 103.75, 10), joint = node(160, 106.25, 11);
  add_way(scene, 1, {node(10, 100, 1), t, joint}, "tertiary");
  add_way(scene, 2, {node(250, 110, 2), joint}, "tertiary");
  add_way(scene, 3, {node(110, 250, 3), t});
  auto ring = map_line(scene.truth[2].line, {.node_spacing_m = 8.0}, 5.5);
  for (RoadNode& n : ring) n.p = n.p + Vec2{1.0, -1.0};
  ring.front().osm_node = ring.back().osm_node = 9;
  add_way(scene, 4, ring);
  return scene;
}

TEST(MrfRoads, topology_is_kept_and_roads_meet_in_one_point) {
  const RoadScene scene = make_network();
  for (const RoadPolygons polygons : {RoadPolygons::smooth, RoadPolygons::douglas_peucker}) {
    MrfRoadsOptions options = quick();
    options.polygons = polygons;
    const auto result = refine_roads_mrf(scene.osm, exact_evidence(scene.labels), options);
    std::map<std::int64_t, std::vector<Vec2>> places;
    for (std::size_t p = 0; p < scene.osm.paths.size(); ++p) {
      const RoadPath &before = scene.osm.paths[p], &after = result.roads.paths[p];
      EXPECT_EQ(after.osm_id, before.osm_id);
      EXPECT_EQ(after.nodes.front().osm_node, before.nodes.front().osm_node);
      EXPECT_EQ(after.nodes.back().osm_node, before.nodes.back().osm_node);
      for (const RoadNode& node : after.nodes)
        if (node.osm_node > 0) places[node.osm_node].push_back(node.p);
    }
    for (const std::int64_t id : {9, 10, 11}) {
      ASSERT_EQ(places[id].size(), 2u) << id;
      EXPECT_EQ(places[id][0], places[id][1]) << id;
    }
    for (const auto& [path, truth] : {std::pair{0, 0}, {1, 0}, {2, 1}, {3, 2}}) {
      const RoadError error = compare(result.roads.paths[path], scene.truth[truth], path == 3 ? 0.0 : 3.0);
      EXPECT_LT(error.mean_offset_m, path == 3 ? 0.9 : 0.6) << path;  // chords of a tight circle
      EXPECT_LT(error.mean_width_m, 0.8) << path;
    }
  }
}

TEST(MrfRoads, any_thread_count_gives_the_same) {
  const RoadScene scene = make_network();
  MrfRoadsOptions options = quick();
  const auto one = refine_roads_mrf(scene.osm, exact_evidence(scene.labels), options);
  options.threads = 2;
  const auto two = refine_roads_mrf(scene.osm, exact_evidence(scene.labels), options);
  EXPECT_EQ(one.energies, two.energies);
  for (std::size_t p = 0; p < one.roads.paths.size(); ++p)
    for (std::size_t i = 0; i < one.roads.paths[p].nodes.size(); ++i) {
      EXPECT_EQ(one.roads.paths[p].nodes[i].p, two.roads.paths[p].nodes[i].p);
      EXPECT_EQ(one.roads.paths[p].nodes[i].width_m, two.roads.paths[p].nodes[i].width_m);
    }
}

TEST(MrfRoads, tiny_and_degenerate_ways) {
  RoadScene scene = make_scene(100.0);
  add_way(scene, 1, {{.p = at(50, 50), .width_m = 5.0}, {.p = at(50.1, 50), .width_m = 5.0}});
  add_way(scene, 2, {{.p = at(20, 20), .width_m = 5.0}, {.p = at(20, 20), .width_m = 5.0}});  // no length
  add_way(scene, 3, {{.p = at(-500, 20), .width_m = 5.0}, {.p = at(-400, 20), .width_m = 5.0}});
  add_way(scene, 4,
          {{.p = at(50, 50), .width_m = 5.0}, {.p = at(60, 50), .width_m = 5.0}, {.p = at(50, 50.1), .width_m = 5.0}});
  add_way(scene, 5,
          {{.p = at(10, 80), .width_m = 5.0},
           {.p = at(60, 80), .width_m = 5.0},
           {.p = at(40, 95), .width_m = 5.0},
           {.p = at(40, 60), .width_m = 5.0}});  // crosses itself
  const auto result = refine_roads_mrf(scene.osm, exact_evidence(scene.labels), quick());
  ASSERT_EQ(result.roads.paths.size(), 5u);
  for (const RoadPath& path : result.roads.paths) {
    EXPECT_GE(path.nodes.size(), 2u);
    for (const RoadNode& node : path.nodes)
      EXPECT_TRUE(std::isfinite(node.p.x + node.p.y + node.width_m + node.offset_m));
  }
  EXPECT_EQ(result.roads.paths[1].nodes.front().p, at(20, 20));
  std::set<std::string> codes;
  for (const Finding& finding : result.findings) codes.insert(finding.code);
  EXPECT_EQ(codes, (std::set<std::string>{"refine.no_length", "refine.no_photo"}));
}

TEST(MrfRoads, no_roads_give_no_roads) {
  const RoadScene scene = make_scene(50.0);
  const auto result = refine_roads_mrf(scene.osm, exact_evidence(scene.labels));
  EXPECT_TRUE(result.roads.paths.empty());
  EXPECT_EQ(result.energy_after, 0.0);
}

TEST(MrfRoads, wrong_input_is_refused) {
  RoadScene scene = make_scene(50.0);
  add_way(scene, 1, {{.p = at(5, 5), .width_m = 5.0}, {.p = at(40, 5), .width_m = 5.0}});
  const auto refine = [&](const MrfRoadsOptions& options) {
    (void)refine_roads_mrf(scene.osm, exact_evidence(scene.labels), options);
  };
  EXPECT_NO_THROW(refine({}));
  EXPECT_THROW(refine({.segment_m = 0.0}), OptionError);
  EXPECT_THROW(refine({.step_m = -0.25}), OptionError);
  EXPECT_THROW(refine({.step_m = 1e-6}), OptionError);
  EXPECT_THROW(refine({.weights = {.edge = -1.0}}), OptionError);
  scene.osm.paths[0].nodes[0].width_m = 0.0;
  EXPECT_THROW(refine({}), OptionError);
  scene.osm.paths[0].nodes = {{.p = at(5, 5), .width_m = 5.0}};
  EXPECT_THROW(refine({}), OptionError);
  scene.osm.crs = {"EPSG:32634"};
  EXPECT_THROW(refine({}), OptionError);
}

TEST(MrfRoads, from_photo_to_road) {
  const RoadScene other = make_photo_scene(200.0);
  const Photo other_photo = paint_photo(other.labels, 31);
  const RoadForests forests =
      train_road_forests(std::vector{sample_of(other.labels, other_photo)}, {.trees = 20, .max_samples = 2000});
  RoadScene scene = make_photo_scene(240.0);
  add_way(scene, 1, map_line(scene.truth[0].line, {.offset_m = [](double) { return -3.0; }}, 5.5));
  const Photo photo = paint_photo(scene.labels, 32);
  const PhotoSource source = source_of(photo);
  const auto result = refine_roads_mrf(scene.osm, mrf_photo_evidence(source, forests), quick());
  const RoadError before = compare(scene.osm.paths[0], scene.truth[0]),
                  after = compare(result.roads.paths[0], scene.truth[0]);
  std::printf("photo: offset %.2f -> %.2f m, width %.2f -> %.2f m\n", before.mean_offset_m, after.mean_offset_m,
              before.mean_width_m, after.mean_width_m);
  EXPECT_GT(before.mean_offset_m, 2.0);
  EXPECT_LT(after.mean_offset_m, 0.5);
  EXPECT_LT(after.mean_width_m, 0.8);
}

}  // namespace
}  // namespace orthodrive
