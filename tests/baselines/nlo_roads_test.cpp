// SPDX-License-Identifier: Apache-2.0
// The baseline of the thesis: does it count pixels right, and do its two weight sets behave as table 3.4 says?

#include "orthodrive/baselines/nlo_roads.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "orthodrive/baselines/label_strips.hpp"
#include "orthodrive/baselines/nlo_fit.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/core/random.hpp"
#include "refine/road_scene.hpp"

namespace orthodrive {
namespace {

using namespace baselines;
using namespace test;

const std::vector<NloPass> set_1{nlo_set_1}, set_2{nlo_set_2}, set_1_then_2{nlo_set_1, nlo_set_2};

RoadError print(const char* what, const RoadError& e) {
  std::printf("%s: offset mean %.3f max %.3f m, width mean %.3f max %.3f m (%d nodes)\n", what, e.mean_offset_m,
              e.max_offset_m, e.mean_width_m, e.max_width_m, e.count);
  return e;
}

std::vector<std::string> codes(const Findings& findings) {
  std::vector<std::string> result;
  for (const Finding& finding : findings) result.push_back(finding.code);
  return result;
}

// ---- counting pixels

/// The sums of eq. 3.3 over all pixels of the raster and 80 around it, by geo's point in polygon.
StripSum brute_force(const LabelMap& labels, const std::array<float, 256>& costs, const LabelStrip& strip) {
  const Polygon polygon{{strip.border_a, strip.border_b, strip.far_b, strip.far_a}, {}};
  const Vec2 normal = left_normal(normalized(strip.border_b - strip.border_a));
  StripSum sum;
  const int around = 80;
  for (int row = -around; row < labels.frame.height + around; ++row)
    for (int col = -around; col < labels.frame.width + around; ++col) {
      const Vec2 p = labels.frame.center_of(col, row);
      if (!contains(polygon, p)) continue;
      const bool in_raster = row >= 0 && row < labels.frame.height && col >= 0 && col < labels.frame.width;
      const std::uint8_t label = in_raster ? labels.labels.at(col, row) : label_nodata;
      const double d = std::min(1.0, std::abs(dot(p - strip.border_a, normal)) / strip.width_m);
      sum.weight += d, sum.cost += d * costs[label];
      sum.labelled |= label != label_nodata;
    }
  return sum;
}

TEST(LabelStrips, pixel_sum_equals_brute_force) {
  RoadScene scene = make_scene(20.0, 0.25);
  Random random(4);
  for (std::uint8_t& label : scene.labels.labels.data) {
    label = static_cast<std::uint8_t>(8.0 * random.uniform());
    if (random.uniform() < 0.1) label = label_nodata;
    if (random.uniform() < 0.05) label = 77;  // not in the table
  }
  const LabelCosts costs = label_costs(scene.labels.classes, 0.7);
  int with_pixels = 0, outside = 0;
  for (int k = 0; k < 500; ++k) {
    // Also partly and wholly outside the labels, thin ones, and some that fold over themselves.
    const auto anywhere = [&](double size) {
      return Vec2{size * (random.uniform() - 0.5), size * (random.uniform() - 0.5)};
    };
    const Vec2 a = at(10, 10) + anywhere(30.0), b = a + anywhere(6.0);
    const Vec2 out = left_normal(normalized(b - a)) * 1.25;
    const LabelStrip strip{a, b, a + out + anywhere(k % 3 * 1.0), b + out + anywhere(k % 3 * 1.0), 1.25};
    StripSum sum;
    add_strip(scene.labels, k % 2 ? costs.inside : costs.outside, strip, sum);
    const StripSum expected = brute_force(scene.labels, k % 2 ? costs.inside : costs.outside, strip);
    ASSERT_NEAR(sum.weight, expected.weight, 1e-6) << k;
    ASSERT_NEAR(sum.cost, expected.cost, 1e-6) << k;
    EXPECT_EQ(sum.labelled, expected.labelled) << k;
    with_pixels += expected.cost > 0.0 ? 1 : 0, outside += expected.labelled ? 0 : 1;
  }
  EXPECT_GT(with_pixels, 100);
  EXPECT_GT(outside, 50);
}

TEST(LabelStrips, a_known_strip) {
  // Ground of 0.25 m pixels; the strip reaches 1 m to the left of a border along y = 10: four rows at 1/8 .. 7/8 m.
  RoadScene scene = make_scene(20.0, 0.25);
  paint(scene.labels, {at(0, 10.5), at(20, 10.5), at(20, 10.75), at(0, 10.75)}, label_road);  // the third row
  const LabelCosts costs = label_costs(scene.labels.classes, 1.0);
  const LabelStrip strip{at(5, 10), at(7, 10), at(5, 11), at(7, 11), 1.0};
  StripSum sum;
  add_strip(scene.labels, costs.outside, strip, sum);
  EXPECT_NEAR(sum.weight, 8 * (0.125 + 0.375 + 0.625 + 0.875), 1e-9);
  EXPECT_NEAR(sum.mean(), 0.625 / 2.0, 1e-9);
  EXPECT_EQ(StripSum{}.mean(), 0.0);
  sum = {};
  add_strip(scene.labels, costs.outside, {at(1e9, 1e9), at(1e9 + 2, 1e9), at(1e9, 1e9 + 1), at(1e9 + 2, 1e9 + 1), 1.0},
            sum);
  EXPECT_EQ(sum.cost, 0.0) << "far beyond the raster there is no road to pay for";
  EXPECT_FALSE(sum.labelled);
}

TEST(LabelStrips, costs_are_those_of_table_3_2) {
  const ClassTable& classes = default_class_table();
  const LabelCosts costs = label_costs(classes, 0.5);
  for (std::size_t i = 0; i < classes.classes.size(); ++i) {
    const Role role = classes.classes[i].role;
    EXPECT_EQ(costs.outside[i], role == Role::road ? 1.0F : 0.0F) << classes.classes[i].name;
    EXPECT_EQ(costs.inside[i], role == Role::road         ? 0.0F
                               : role == Role::maybe_road ? 0.2F
                                                          : 1.0F)
        << classes.classes[i].name;
  }
  EXPECT_EQ(costs.outside[label_nodata], 0.0F);
  EXPECT_EQ(costs.inside[label_nodata], 0.5F);
}

// ---- the method

TEST(NloRoads, published_weights) {
  const NloRoadsOptions options;
  ASSERT_EQ(options.passes.size(), 2u);
  EXPECT_EQ(options.passes[0].weight_angle, 1.0);
  EXPECT_EQ(options.passes[1].weight_angle, 20.0);
  EXPECT_EQ(options.passes[1].weight_width, 10.0);
  EXPECT_EQ(options.passes[1].weight_offset, 0.0);
  EXPECT_EQ(options.strip_m, 1.25);
  EXPECT_FALSE(options.filter_and_join);
}

TEST(NloRoads, straight_road_shifted_by_2_m_is_recovered) {
  RoadScene scene = make_scene(240.0, 0.2);
  add_truth(scene, straight(at(20, 100), at(220, 141)), 6.0);
  add_way(scene, 1, map_line(scene.truth[0].line, {.offset_m = [](double) { return 2.0; }}, 5.5));
  for (const auto& passes : {set_1, set_1_then_2}) {
    const auto result = refine_roads_nlo(scene.osm, scene.labels, {.passes = passes});
    const RoadPath& path = result.roads.paths[0];
    const RoadError after = print("refined", compare(path, scene.truth[0], 5.0));
    EXPECT_LT(after.mean_offset_m, 0.15);
    EXPECT_LT(after.max_offset_m, 0.4);
    EXPECT_LT(after.mean_width_m, 0.3);
    EXPECT_NEAR(path.nodes[50].offset_m, -2.0, 0.3) << "positive to the left";
    EXPECT_LT(result.solve.cost_after, 0.1 * result.solve.cost_before);
    EXPECT_TRUE(result.findings.empty());
    for (std::size_t i = 0; i + 1 < path.nodes.size(); ++i)
      EXPECT_NEAR(path.nodes[i + 1].s_m - path.nodes[i].s_m, 2.0, 0.3);
  }
}

/// A bending road whose borders wave on their own, under blobs of wrong labels.
RoadScene make_wavy() {
  RoadScene scene = make_scene(260.0, 0.25);
  const Polyline line = trace(230.0, [](double s) { return at(15.0 + s, 130.0 + 15.0 * std::sin(s / 40.0)); });
  const std::vector<Vec2> t = tangents(line);
  Ring left, right;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const double s = 0.5 * static_cast<double>(i);
    left.push_back(line[i] + left_normal(t[i]) * (3.0 + 0.5 * std::sin(s / 4.0)));
    right.push_back(line[i] - left_normal(t[i]) * (3.0 + 0.5 * std::sin(s / 3.0 + 1.0)));
  }
  left.insert(left.end(), right.rbegin(), right.rend());
  paint(scene.labels, left, label_road);
  Random random(9);
  for (int k = 0; k < 60; ++k) {
    const Vec2 p = line[static_cast<std::size_t>(random.uniform() * static_cast<double>(line.size()))];
    paint_disc(scene.labels, p + Vec2{8.0 * random.uniform() - 4.0, 8.0 * random.uniform() - 4.0}, 0.8,
               k % 2 ? label_vegetation : label_road);
  }
  scene.truth.push_back({line, 6.0});
  add_way(scene, 1,
          map_line(line, {.node_spacing_m = 10.0, .offset_m = [](double s) { return 0.6 * std::sin(s / 25.0); }}, 5.5));
  return scene;
}

double width_variance_m2(const RoadPath& path) {
  double mean = 0.0, variance = 0.0;
  const auto n = static_cast<double>(path.nodes.size());
  for (const RoadNode& node : path.nodes) mean += node.width_m / n;
  for (const RoadNode& node : path.nodes) variance += std::pow(node.width_m - mean, 2) / n;
  return variance;
}

/// Square metres in which the surface of the path and the road of the labels differ.
double difference_m2(const RoadPath& path, const LabelMap& labels) {
  Raster<std::uint8_t> surface(labels.frame.width, labels.frame.height);
  for (const Ring& cell : surface_cells(path)) fill_polygon(surface, labels.frame, Polygon{cell, {}}, std::uint8_t{1});
  std::size_t pixels = 0;
  for (std::size_t i = 0; i < surface.data.size(); ++i)
    pixels += (surface.data[i] == 1) != (labels.labels.data[i] == label_road);
  return static_cast<double>(pixels) * labels.frame.gsd_m * labels.frame.gsd_m;
}

TEST(NloRoads, set_1_is_nearer_to_the_labels_and_set_2_is_smoother) {
  const RoadScene scene = make_wavy();
  double variance[3], difference[3];
  const std::vector<NloPass>* const sets[] = {&set_1, &set_1_then_2, &set_2};
  for (int k = 0; k < 3; ++k) {
    const RoadPath path = refine_roads_nlo(scene.osm, scene.labels, {.passes = *sets[k]}).roads.paths[0];
    variance[k] = width_variance_m2(path), difference[k] = difference_m2(path, scene.labels);
    std::printf("width variance %.4f m2, difference to the labels %.1f m2\n", variance[k], difference[k]);
  }
  EXPECT_LT(variance[1], 0.5 * variance[0]) << "smoothed by the second pass";
  EXPECT_LT(variance[2], 0.5 * variance[0]);
  EXPECT_LT(difference[0], difference[1]);
  EXPECT_LT(difference[0], difference[2]);
}

TEST(NloRoads, nothing_leaves_its_bounds) {
  RoadScene scene = make_wavy();
  for (RoadNode& node : scene.osm.paths[0].nodes) node.p.y += 4.0;  // half of it lies beside the road
  for (const auto& passes : {set_1, set_2, set_1_then_2}) {
    const NloRoadsOptions options{
        .passes = passes, .max_offset_m = 3.0, .min_width_factor = 0.8, .max_width_factor = 1.1};
    const RoadPath path = refine_roads_nlo(scene.osm, scene.labels, options).roads.paths[0];
    bool at_bound = false;
    for (const RoadNode& node : path.nodes) {
      EXPECT_LE(std::abs(node.offset_m), 3.0 + 1e-6);
      EXPECT_GE(node.width_m, 0.8 * 5.5 - 1e-9);
      EXPECT_LE(node.width_m, 1.1 * 5.5 + 1e-9);
      at_bound |= std::abs(node.offset_m) > 2.9;
    }
    EXPECT_TRUE(at_bound) << "the bound is felt";
  }
}

TEST(NloRoads, second_pass_starts_from_the_first) {
  const RoadScene scene = make_wavy();
  NloPass idle = nlo_set_2;
  idle.max_iterations = 0;
  const auto one = refine_roads_nlo(scene.osm, scene.labels, {.passes = set_1});
  const auto two = refine_roads_nlo(scene.osm, scene.labels, {.passes = {nlo_set_1, idle}});
  for (std::size_t i = 0; i < one.roads.paths[0].nodes.size(); ++i) {
    EXPECT_EQ(one.roads.paths[0].nodes[i].p, two.roads.paths[0].nodes[i].p);
    EXPECT_EQ(one.roads.paths[0].nodes[i].width_m, two.roads.paths[0].nodes[i].width_m);
  }
  EXPECT_LE(one.solve.iterations, 20);
  EXPECT_LT(one.solve.cost_after, one.solve.cost_before);
}

TEST(NloRoads, any_thread_count_gives_the_same) {
  RoadScene scene = make_wavy();
  for (int k = 0; k < 3; ++k)
    add_way(scene, 2 + k, map_line(scene.truth[0].line, {.offset_m = [k](double) { return 0.4 * k; }}, 5.0));
  const auto one = refine_roads_nlo(scene.osm, scene.labels, {.threads = 1}),
             two = refine_roads_nlo(scene.osm, scene.labels, {.threads = 2});
  for (std::size_t p = 0; p < one.roads.paths.size(); ++p)
    for (std::size_t i = 0; i < one.roads.paths[p].nodes.size(); ++i) {
      EXPECT_EQ(one.roads.paths[p].nodes[i].p, two.roads.paths[p].nodes[i].p);
      EXPECT_EQ(one.roads.paths[p].nodes[i].width_m, two.roads.paths[p].nodes[i].width_m);
    }
  EXPECT_EQ(one.solve.cost_after, two.solve.cost_after);
}

TEST(NloRoads, outside_the_labels_the_osm_line_stays) {
  RoadScene scene = make_scene(100.0);
  add_truth(scene, straight(at(0, 50), at(100, 50)), 6.0);
  add_way(scene, 1,
          {{.p = at(300, 50), .width_m = 5.0}, {.p = at(330, 50), .width_m = 5.0}, {.p = at(350, 80), .width_m = 5.0}});
  add_way(
      scene, 2,
      {{.p = at(20, 50.9), .width_m = 5.0}, {.p = at(120, 50.9), .width_m = 5.0}, {.p = at(150, 90), .width_m = 5.0}});
  const auto result = refine_roads_nlo(scene.osm, scene.labels, {.passes = set_2});
  EXPECT_EQ(codes(result.findings), std::vector<std::string>{"refine.outside_labels"});
  EXPECT_NEAR(result.findings[0].x_m, at(330, 0).x, 10.0);
  for (const RoadNode& node : result.roads.paths[0].nodes) {
    EXPECT_EQ(node.offset_m, 0.0);
    EXPECT_EQ(node.width_m, 5.0);
  }
  for (const RoadNode& node : result.roads.paths[1].nodes)
    if (node.p.x > at(103, 0).x) {
      EXPECT_EQ(node.offset_m, 0.0) << node.p.x - at(0, 0).x;
    }
  EXPECT_NEAR(result.roads.paths[1].nodes[20].offset_m, -0.9, 0.3);
}

TEST(NloRoads, no_length_and_repeated_nodes_give_no_nan) {
  RoadScene scene = make_scene(100.0);
  add_truth(scene, straight(at(10, 50), at(90, 50)), 6.0);
  const auto node = [](double x, double y, std::int64_t id = 0) {
    return RoadNode{.p = at(x, y), .osm_node = id, .width_m = 5.0};
  };
  add_way(scene, 1, {node(50, 50), node(50, 50)});  // no length
  add_way(scene, 2,
          {node(10, 50.9), node(40, 50.9, 7), node(40, 50.9, 8), node(40, 50.9), node(90, 50.9)});  // repeated nodes
  add_way(scene, 3, {node(20, 50.9), node(20, 50.9), node(60, 50.9), node(60, 50.9)});              // at the ends
  add_way(scene, 4, {node(50, 50), node(60, 50), node(50, 50)});                                    // there and back
  add_way(scene, 5, {node(50, 50), node(50.001, 50), node(50.4, 50.1), node(20, 49)});  // a hairpin, tiny steps
  add_way(scene, 6, {node(30, 40, 1), node(60, 40), node(60, 60), node(30, 60), node(30, 40, 1)});  // closed
  for (const bool filter_and_join : {false, true}) {
    const auto result = refine_roads_nlo(scene.osm, scene.labels, {.filter_and_join = filter_and_join});
    ASSERT_EQ(result.roads.paths.size(), 6u);
    for (const RoadPath& path : result.roads.paths)
      for (const RoadNode& n : path.nodes)
        EXPECT_TRUE(std::isfinite(n.p.x) && std::isfinite(n.p.y) && std::isfinite(n.offset_m) && n.width_m >= 1.0)
            << path.osm_id;
    EXPECT_TRUE(std::isfinite(result.solve.cost_before) && std::isfinite(result.solve.cost_after));
    EXPECT_EQ(codes(result.findings), std::vector<std::string>{"refine.no_length"});
    const auto& repeated = result.roads.paths[1].nodes;
    EXPECT_EQ(repeated[15].osm_node, 7);
    EXPECT_EQ(repeated[16].osm_node, 8);
    if (!filter_and_join) {
      EXPECT_EQ(repeated[15].p, repeated[16].p);
    }
    EXPECT_NEAR(repeated[16].p.y, at(0, 50).y, 0.4);
    EXPECT_EQ(result.roads.paths[5].nodes.front().p, result.roads.paths[5].nodes.back().p);
    EXPECT_EQ(result.roads.paths[5].nodes.back().osm_node, 1);
  }
}

// ---- the extras

double largest_angle(const RoadPath& path) {
  double largest = 0.0;
  for (std::size_t i = 1; i + 1 < path.nodes.size(); ++i) {
    const Vec2 in = path.nodes[i].p - path.nodes[i - 1].p, out = path.nodes[i + 1].p - path.nodes[i].p;
    largest = std::max(largest, std::abs(std::atan2(cross(in, out), dot(in, out))));
  }
  return largest;
}

TEST(NloRoads, filter_and_join_lowers_curvature_peaks_and_joins_roads) {
  RoadScene scene = make_scene(200.0, 0.25);
  add_truth(scene, straight(at(20, 100), at(180, 100)), 7.0);
  add_truth(scene, straight(at(100, 100), at(100, 180)), 5.0);
  const auto node = [](double x, double y, std::int64_t id = 0) {
    return RoadNode{.p = at(x, y), .osm_node = id, .width_m = 5.5};
  };
  add_way(scene, 1, {node(20, 101), node(60, 100), node(100, 101, 5), node(140, 99), node(180, 100)}, "primary");
  add_way(scene, 2, {node(100, 101, 5), node(101, 140), node(101, 180)}, "service");
  const auto plain = refine_roads_nlo(scene.osm, scene.labels, {.passes = set_1});
  const auto joined = refine_roads_nlo(scene.osm, scene.labels, {.passes = set_1, .filter_and_join = true});
  EXPECT_LT(largest_angle(joined.roads.paths[0]), 0.7 * largest_angle(plain.roads.paths[0]));
  const auto shared = [](const RoadPath& path) {
    return std::find_if(path.nodes.begin(), path.nodes.end(), [](const RoadNode& n) { return n.osm_node == 5; })->p;
  };
  EXPECT_GT(distance(shared(plain.roads.paths[0]), shared(plain.roads.paths[1])), 0.1) << "each way has its own offset";
  EXPECT_EQ(shared(joined.roads.paths[0]), shared(joined.roads.paths[1]));
  // Set 1 lets the primary road wander into the mouth of the other; the filter takes that back.
  const double y = at(0, 100).y;
  EXPECT_GT(std::abs(shared(plain.roads.paths[0]).y - y), 1.0);
  EXPECT_NEAR(shared(joined.roads.paths[0]).y, y, 0.8);
}

TEST(NloRoads, no_roads_give_no_roads) {
  EXPECT_TRUE(refine_roads_nlo(make_scene(50.0).osm, make_scene(50.0).labels).roads.paths.empty());
}

TEST(NloRoads, wrong_input_is_refused) {
  RoadScene scene = make_scene(50.0);
  EXPECT_THROW((void)refine_roads_nlo(scene.osm, scene.labels, {.passes = {}}), OptionError);
  EXPECT_THROW((void)refine_roads_nlo(scene.osm, scene.labels, {.strip_m = 0.0}), OptionError);
  EXPECT_THROW((void)refine_roads_nlo(scene.osm, scene.labels, {.max_offset_m = -1.0}), OptionError);
  EXPECT_THROW((void)refine_roads_nlo(scene.osm, scene.labels, {.min_width_factor = 1.1}), OptionError);
  EXPECT_THROW((void)refine_roads_nlo(scene.osm, scene.labels, {.max_width_factor = 0.9}), OptionError);
  EXPECT_THROW((void)refine_roads_nlo(scene.osm, scene.labels, {.unlabelled_cost = 2.0}), OptionError);
  EXPECT_THROW((void)refine_roads_nlo(scene.osm, scene.labels, {.passes = {{.weight_width = -1.0}}}), OptionError);
  scene.osm.crs = {"EPSG:32634"};
  EXPECT_THROW((void)refine_roads_nlo(scene.osm, scene.labels), OptionError);
  scene = make_scene(50.0);
  add_way(scene, 1, {{.p = at(5, 5)}, {.p = at(40, 5)}});  // no width
  EXPECT_THROW((void)refine_roads_nlo(scene.osm, scene.labels), OptionError);
}

}  // namespace
}  // namespace orthodrive
