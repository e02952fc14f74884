// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/refine/refine_roads.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "orthodrive/core/error.hpp"
#include "refine/road_scene.hpp"

namespace orthodrive {
namespace {

using namespace test;

double wave(double s) { return 2.5 * std::sin(s / 45.0) + 1.2 * std::cos(s / 110.0); }

Polyline s_curve(double y = 200.0) {
  return trace(360.0, [y](double s) { return at(20.0 + s, y + 30.0 * std::sin(s / 55.0)); });
}

RoadError print(const char* what, const RoadError& e) {
  std::printf("%s: offset mean %.3f max %.3f m, width mean %.3f max %.3f m (%d nodes)\n", what, e.mean_offset_m,
              e.max_offset_m, e.mean_width_m, e.max_width_m, e.count);
  return e;
}

std::set<std::string> codes(const Findings& findings) {
  std::set<std::string> result;
  for (const Finding& finding : findings) result.insert(finding.code);
  return result;
}

TEST(RefineRoads, disturbed_osm_recovers_line_and_width) {
  RoadScene scene = make_scene(400.0);
  add_truth(scene, s_curve(), 7.0);
  add_way(scene, 1, map_line(scene.truth[0].line, {.offset_m = wave}, 5.5));
  const RoadError before = print("osm", compare(scene.osm.paths[0], scene.truth[0]));
  EXPECT_GT(before.mean_offset_m, 1.0);

  const auto result = refine_roads(scene.osm, scene.labels);
  const RoadPath& path = result.roads.paths.at(0);
  const RoadError after = print("refined", compare(path, scene.truth[0]));
  EXPECT_LT(after.mean_offset_m, 0.15);
  EXPECT_LT(after.max_offset_m, 0.6);
  EXPECT_LT(after.mean_width_m, 0.25);
  EXPECT_TRUE(result.solve.converged);
  EXPECT_LE(result.solve.cost_after, result.solve.cost_before);
  EXPECT_TRUE(result.findings.empty());
  for (std::size_t i = 0; i + 1 < path.nodes.size(); ++i) {
    EXPECT_NEAR(path.nodes[i + 1].s_m - path.nodes[i].s_m, 2.0, 0.8);
    EXPECT_GT(path.nodes[i].sigma_offset_m, 0.0);
  }
}

/// A race track widens and narrows within a way that its map gives one width; where trees hide it, it has that of the
/// rest of its way.
TEST(RefineRoads, a_way_that_widens_is_measured_where_it_is_seen) {
  const auto true_width_m = [](double x) { return x < 200.0 ? 9.0 : std::min(12.0, 9.0 + (x - 200.0) / 20.0); };
  RoadScene scene = make_scene(800.0);
  const Polyline line = straight(at(20, 400), at(780, 400));
  for (std::size_t i = 0; i + 1 < line.size(); ++i) {
    const double half_m = 0.5 * true_width_m(line[i].x - 500000.0);
    paint(scene.labels,
          {line[i] - Vec2{0, half_m}, line[i + 1] - Vec2{0, half_m}, line[i + 1] + Vec2{0, half_m},
           line[i] + Vec2{0, half_m}},
          label_road);
  }
  paint(scene.labels, {at(500, 380), at(560, 380), at(560, 420), at(500, 420)}, label_vegetation);
  add_way(scene, 1, map_line(line, {}, 10.0), "raceway");
  const auto result = refine_roads(scene.osm, scene.labels);
  double largest_m = 0.0, hidden_m = 1e9;
  for (const RoadNode& node : result.roads.paths.at(0).nodes) {
    const double x = node.p.x - 500000.0;
    if (x < 40.0 || x > 760.0) continue;
    if (x > 480.0 && x < 580.0)
      hidden_m = std::min(hidden_m, node.width_m);
    else
      largest_m = std::max(largest_m, std::abs(node.width_m - true_width_m(x)));
  }
  EXPECT_LT(largest_m, 0.5);  // a pixel of the labels
  EXPECT_GT(hidden_m, 10.0);
}

TEST(RefineRoads, offset_is_positive_to_the_left) {
  RoadScene scene = make_scene(200.0);
  add_truth(scene, straight(at(10, 103), at(190, 103)), 6.0);
  add_way(scene, 1, {{.p = at(10, 100), .width_m = 5.5}, {.p = at(190, 100), .width_m = 5.5}});
  add_way(scene, 2, {{.p = at(190, 100), .width_m = 5.5}, {.p = at(10, 100), .width_m = 5.5}});
  const auto result = refine_roads(scene.osm, scene.labels);
  EXPECT_NEAR(result.roads.paths[0].nodes[40].offset_m, 3.0, 0.1);
  EXPECT_NEAR(result.roads.paths[1].nodes[40].offset_m, -3.0, 0.1);
}

TEST(RefineRoads, far_off_osm_is_inside_the_capture_range) {
  RoadScene scene = make_scene(400.0);
  add_truth(scene, s_curve(), 5.0);
  add_way(scene, 1, map_line(scene.truth[0].line, {.offset_m = [](double) { return -5.5; }}, 5.5));
  const auto result = refine_roads(scene.osm, scene.labels);
  EXPECT_LT(print("refined", compare(result.roads.paths[0], scene.truth[0])).mean_offset_m, 0.2);
}

TEST(RefineRoads, trees_over_the_road_do_not_move_it) {
  RoadScene scene = make_scene(400.0);
  add_truth(scene, s_curve(), 7.0);
  add_way(scene, 1, map_line(scene.truth[0].line, {.offset_m = wave}, 5.5));
  for (const double s : {60.0, 64.0, 140.0, 146.0, 152.0, 240.0})  // crowns over the whole road
    paint_disc(scene.labels, point_at(scene.truth[0].line, s), 6.0, label_vegetation);
  for (const double s : {100.0, 190.0, 198.0, 206.0, 290.0})  // crowns over its left edge
    paint_disc(scene.labels, point_at(scene.truth[0].line, s) + Vec2{0.0, 5.0}, 4.0, label_vegetation);
  const auto result = refine_roads(scene.osm, scene.labels);
  const RoadError after = print("refined", compare(result.roads.paths[0], scene.truth[0]));
  EXPECT_LT(after.mean_offset_m, 0.3);
  EXPECT_LT(after.max_offset_m, 1.0);
  EXPECT_LT(after.mean_width_m, 0.5);
}

TEST(RefineRoads, a_map_that_the_photo_does_not_show_is_named) {
  const auto along = [](double y) { return straight(at(50.0, y), at(950.0, y)); };
  const auto named = [&](bool second_seen) {
    RoadScene scene = make_scene(1000.0);
    add_way(scene, 77, map_line(along(700.0), {}, 5.5));
    add_way(scene, 78, map_line(along(300.0), {}, 5.5));
    add_way(scene, 79, map_line(along(500.0), {}, 5.5));
    add_truth(scene, along(700.0), 5.5);
    if (second_seen) add_truth(scene, along(300.0), 5.5);
    const auto result = refine_roads(scene.osm, scene.labels);
    const auto finding = std::ranges::find(result.findings, "refine.map_unlike_photo", &Finding::code);
    if (finding != result.findings.end()) EXPECT_THAT(finding->message, testing::HasSubstr("33 % of 2.7 km"));
    return finding != result.findings.end();
  };
  EXPECT_TRUE(named(false));  // a third of the roads
  EXPECT_FALSE(named(true));
}

TEST(RefineRoads, road_that_is_not_seen_stays_with_osm_and_says_so) {
  RoadScene scene = make_scene(400.0);
  add_way(scene, 77, map_line(s_curve(), {}, 5.5));
  const auto result = refine_roads(scene.osm, scene.labels);
  EXPECT_THAT(codes(result.findings), testing::ElementsAre("refine.no_road_seen"));
  const RoadPath& path = result.roads.paths[0];
  for (const RoadNode& node : path.nodes) {
    EXPECT_LT(std::abs(node.offset_m), 1.0);
    EXPECT_NEAR(node.width_m, 5.5, 0.1);
  }

  RoadScene seen = make_scene(400.0);
  add_truth(seen, s_curve(), 5.5);
  add_way(seen, 77, map_line(s_curve(), {}, 5.5));
  const auto sure = refine_roads(seen.osm, seen.labels);
  EXPECT_GT(path.nodes[90].sigma_offset_m, 4.0 * sure.roads.paths[0].nodes[90].sigma_offset_m);
}

TEST(RefineRoads, nodata_counts_for_nothing) {
  RoadScene scene = make_scene(400.0);
  add_truth(scene, s_curve(), 7.0);
  add_way(scene, 1, map_line(scene.truth[0].line, {.offset_m = wave}, 5.5));
  paint(scene.labels, {at(180, 0), at(220, 0), at(220, 400), at(180, 400)}, label_nodata);
  const auto result = refine_roads(scene.osm, scene.labels);
  EXPECT_LT(print("refined", compare(result.roads.paths[0], scene.truth[0])).mean_offset_m, 0.3);
}

TEST(RefineRoads, parallel_carriageways_keep_apart) {
  RoadScene scene = make_scene(400.0);
  add_truth(scene, straight(at(20, 200), at(380, 200)), 5.0);
  add_truth(scene, straight(at(380, 208), at(20, 208)), 5.0);
  const auto shift = [](double sign) { return [sign](double s) { return sign * (1.5 + std::sin(s / 60.0)); }; };
  add_way(scene, 1, map_line(scene.truth[0].line, {.offset_m = shift(1.0)}, 5.5), "primary");
  add_way(scene, 2, map_line(scene.truth[1].line, {.offset_m = shift(-1.0)}, 5.5), "primary");
  const auto result = refine_roads(scene.osm, scene.labels);
  for (const int k : {0, 1}) {
    const RoadError after = print("refined", compare(result.roads.paths[k], scene.truth[k]));
    EXPECT_LT(after.mean_offset_m, 0.3);
    EXPECT_LT(after.mean_width_m, 0.5);
  }
}

TEST(RefineRoads, a_median_that_the_labels_take_for_road_stays_between_carriageways_of_a_divided_road) {
  RoadScene scene = make_scene(400.0);
  add_truth(scene, straight(at(20, 205), at(380, 205)), 9.0);
  add_truth(scene, straight(at(380, 195), at(20, 195)), 9.0);
  paint(scene.labels, {at(20, 190.5), at(380, 190.5), at(380, 209.5), at(20, 209.5)}, label_road);
  for (const int k : {0, 1}) {
    add_way(scene, k + 1, map_line(scene.truth[k].line, {}, 7.5), "primary");
    scene.osm.paths.back().oneway = Oneway::forward;
  }
  const auto roads = refine_roads(scene.osm, scene.labels).roads;
  for (const int k : {0, 1}) {
    const RoadError after = print("refined", compare(roads.paths[k], scene.truth[k], 40.0));
    EXPECT_LT(after.max_offset_m, 0.2);
    EXPECT_LT(after.max_width_m, 0.3);
  }
}

TEST(RefineRoads, dual_carriageways_do_not_collapse_onto_the_one_that_is_seen) {
  // OSM lies 5 m too far south, so that the northern line is nearer to the southern carriageway, which trees hide for
  // 120 m.
  RoadScene scene = make_scene(400.0);
  add_truth(scene, straight(at(20, 206), at(380, 206)), 7.0);
  add_truth(scene, straight(at(380, 195), at(20, 195)), 7.0);
  add_way(scene, 1, map_line(straight(at(20, 201), at(380, 201)), {}, 7.5), "primary");
  add_way(scene, 2, map_line(straight(at(380, 190), at(20, 190)), {}, 7.5), "primary");
  paint(scene.labels, {at(140, 185), at(260, 185), at(260, 199.5), at(140, 199.5)}, label_vegetation);
  const auto result = refine_roads(scene.osm, scene.labels);
  for (const int k : {0, 1}) {
    const RoadError after = print("refined", compare(result.roads.paths[k], scene.truth[k]));
    EXPECT_LT(after.mean_offset_m, 0.3);
    EXPECT_LT(after.max_offset_m, 1.0);
  }
  for (const RoadNode& node : result.roads.paths[0].nodes) EXPECT_GT(node.p.y - 0.5 * node.width_m, at(0, 199).y);
}

TEST(RefineRoads, slip_roads_merge_without_pushing_the_carriageway_aside) {
  // The slip road comes in at 4 degrees: for 120 m both are one surface in the labels. OSM lies 2 m too far north.
  RoadScene scene = make_scene(500.0);
  add_truth(scene, straight(at(20, 200), at(480, 200)), 8.0);
  add_truth(scene, straight(at(20, 176), at(363, 200)), 5.0);
  const Vec2 off{0.0, 2.0};
  const auto node = [&](Vec2 p, std::int64_t id) { return RoadNode{.p = p + off, .osm_node = id, .width_m = 7.0}; };
  add_way(scene, 1, {node(at(20, 200), 0), node(at(363, 200), 9), node(at(480, 200), 0)}, "motorway");
  add_way(scene, 2, {node(at(20, 176), 0), node(at(363, 200), 9)}, "motorway_link");
  const auto result = refine_roads(scene.osm, scene.labels);
  for (const int k : {0, 1}) {
    const RoadError after = print("refined", compare(result.roads.paths[k], scene.truth[k]));
    EXPECT_LT(after.mean_offset_m, 0.2);
    EXPECT_LT(after.max_offset_m, 1.0);
  }
}

TEST(RefineRoads, hidden_stretches_have_the_width_of_what_is_seen_of_the_road) {
  RoadScene scene = make_scene(600.0);
  add_truth(scene, straight(at(20, 200), at(580, 200)), 8.0);
  add_way(scene, 1, map_line(scene.truth[0].line, {}, 5.5));
  paint(scene.labels, {at(200, 190), at(400, 190), at(400, 210), at(200, 210)}, label_vegetation);
  const auto nodes = refine_roads(scene.osm, scene.labels).roads.paths[0].nodes;
  EXPECT_NEAR(nodes[nodes.size() / 2].width_m, 8.0, 0.3);
  EXPECT_GT(nodes[nodes.size() / 2].sigma_width_m, 1.2 * nodes[nodes.size() / 8].sigma_width_m);
}

TEST(RefineRoads, tagged_widths_count_more_than_those_of_the_class) {
  RoadScene scene = make_scene(400.0);
  add_way(scene, 1, map_line(straight(at(20, 200), at(380, 200)), {}, 5.0));
  add_truth(scene, straight(at(20, 200), at(44, 200)), 6.0);  // hardly anything is seen of it
  const auto width_of = [&](WidthSource source) {
    scene.osm.paths[0].width_source = source;
    return refine_roads(scene.osm, scene.labels).roads.paths[0].nodes[150].width_m;
  };
  EXPECT_LT(std::abs(width_of(WidthSource::tag) - 5.0), 0.9 * std::abs(width_of(WidthSource::highway) - 5.0));
}

/// Of a way of that class and default width on a road of the true width; short, so that the prior counts.
double refined_width_m(const std::string& highway, Oneway oneway, double default_m, double true_m) {
  RoadScene scene = make_scene(160.0);
  add_truth(scene, straight(at(20, 80), at(140, 80)), true_m);
  add_way(scene, 1, map_line(scene.truth[0].line, {}, default_m), highway);
  scene.osm.paths[0].oneway = oneway;
  const auto nodes = refine_roads(scene.osm, scene.labels).roads.paths[0].nodes;
  return nodes[nodes.size() / 2].width_m;
}

TEST(RefineRoads, ways_of_any_width_are_as_wide_as_the_photo_says) {
  EXPECT_NEAR(refined_width_m("service", Oneway::no, 4.0, 8.5), 8.5, 0.3) << "over 1.8 times the default";
  EXPECT_NEAR(refined_width_m("track", Oneway::no, 3.5, 2.5), 2.5, 0.3);
  EXPECT_NEAR(refined_width_m("primary", Oneway::forward, 7.5, 16.0), 16.0, 0.4) << "with shoulders and bus bays";
  EXPECT_LT(refined_width_m("primary", Oneway::no, 7.5, 16.0), 13.6) << "bounded where the class tells the width";
}

TEST(RefineRoads, curvature_changes_smoothly) {
  // Straight, a clothoid of 60 m, an arc of 80 m radius, and back; the mapper clicked every 25 m.
  const auto heading = [](double s) {
    const double ramp = std::clamp(s - 80.0, 0.0, 60.0), arc = std::clamp(s - 140.0, 0.0, 60.0),
                 down = std::clamp(s - 200.0, 0.0, 60.0);
    return (0.5 * ramp * ramp / 60.0 + arc + down - 0.5 * down * down / 60.0) / 80.0;
  };
  Polyline line{at(20, 150)};
  for (double s = 0.0; s < 340.0; s += 0.5)
    line.push_back(line.back() + Vec2{0.5 * std::cos(heading(s + 0.25)), 0.5 * std::sin(heading(s + 0.25))});
  RoadScene scene = make_scene(400.0);
  add_truth(scene, line, 7.0);
  add_way(scene, 1, map_line(line, {}, 6.0));
  const auto nodes = refine_roads(scene.osm, scene.labels).roads.paths[0].nodes;
  double largest_jump = 0.0, before = 0.0;
  for (std::size_t i = 5; i + 6 < nodes.size(); ++i) {  // the ends of a line are seen by one side only
    const Vec2 a = nodes[i].p - nodes[i - 1].p, b = nodes[i + 1].p - nodes[i].p;
    const double curvature = std::atan2(cross(a, b), dot(a, b)) / (0.5 * (length(a) + length(b)));
    if (i > 5) largest_jump = std::max(largest_jump, std::abs(curvature - before));
    before = curvature;
  }
  // The clothoids change by 1 / 80 m over 60 m, 0.0004 from node to node; pixels of half a metre do the rest.
  EXPECT_LT(largest_jump, 0.002);
}

TEST(RoadEvidence, is_the_expected_cost_of_a_pixel) {
  RoadScene scene = make_scene(2.0);  // 4 x 4 px of grass
  scene.labels.labels.at(1, 0) = label_road;
  scene.labels.labels.at(2, 0) = label_parking;
  scene.labels.labels.at(3, 0) = label_nodata;
  const RoadEvidence sure = road_evidence(scene.labels);
  EXPECT_EQ(sure.outside.data[0], 0);
  EXPECT_EQ(sure.inside.data[0], 255);
  EXPECT_EQ(sure.outside.data[1], 255);
  EXPECT_EQ(sure.inside.data[1], 0);
  EXPECT_EQ(sure.outside.data[2], 0);
  EXPECT_EQ(sure.inside.data[2], 51);
  EXPECT_EQ(sure.outside.data[3], 0);
  EXPECT_EQ(sure.inside.data[3], 0);

  ConfidenceMap road{scene.labels.crs, scene.labels.frame, Raster<std::uint8_t>(4, 4)};
  road.confidence.data[0] = 51, road.confidence.data[1] = 204, road.confidence.data[2] = 102,
  road.confidence.data[3] = 0;
  const RoadEvidence soft = road_evidence(scene.labels, road);
  EXPECT_EQ(soft.outside.data[0], 51);
  EXPECT_EQ(soft.inside.data[0], 153);  // 0.75 * 0.8
  EXPECT_EQ(soft.outside.data[1], 204);
  EXPECT_EQ(soft.inside.data[1], 38);
  EXPECT_EQ(soft.outside.data[2], 102);
  EXPECT_EQ(soft.inside.data[2], 31);
  EXPECT_EQ(soft.outside.data[3], 0);
  EXPECT_EQ(soft.inside.data[3], 0);
  road.frame.west_m += 0.5;
  EXPECT_THROW((void)road_evidence(scene.labels, road), OptionError);
}

/// Coverage of pixels by a straight road, as probabilities of a network that is sure of what it sees.
RoadEvidence soft_evidence(const LabelMap& labels, double south_y, double north_y) {
  RoadEvidence evidence = road_evidence(labels);
  for (int row = 0; row < labels.frame.height; ++row) {
    const double top = labels.frame.world_from_pixel(0, row).y, bottom = top - labels.frame.gsd_m;
    const double road = std::clamp((std::min(top, north_y) - std::max(bottom, south_y)) / labels.frame.gsd_m, 0.0, 1.0);
    for (int col = 0; col < labels.frame.width; ++col) {
      evidence.outside.at(col, row) = static_cast<std::uint8_t>(std::lround(255.0 * road));
      evidence.inside.at(col, row) = static_cast<std::uint8_t>(std::lround(255.0 * (1.0 - road)));
    }
  }
  return evidence;
}

TEST(RefineRoads, probabilities_place_edges_inside_a_pixel) {
  for (const double shift : {0.0, 0.13, 0.29, 0.44}) {
    RoadScene scene = make_scene(200.0, 1.0);
    const double south = at(0, 97.0 + shift).y, north = at(0, 103.3 + 1.5 * shift).y, middle = 0.5 * (south + north);
    add_way(scene, 1, {{.p = at(10, 99), .width_m = 5.5}, {.p = at(190, 99), .width_m = 5.5}});
    const auto result = refine_roads(scene.osm, soft_evidence(scene.labels, south, north));
    const RoadNode& node = result.roads.paths[0].nodes[45];
    EXPECT_NEAR(node.p.y, middle, 0.05) << shift;
    EXPECT_NEAR(node.width_m, north - south, 0.15) << shift;
  }
}

TEST(RefineRoads, forecourt_beside_the_road_does_not_blow_up_the_width) {
  RoadScene scene = make_scene(400.0);
  add_truth(scene, straight(at(20, 200), at(380, 200)), 6.0);
  paint(scene.labels, {at(150, 200), at(200, 200), at(200, 240), at(150, 240)}, label_road);
  add_way(scene, 1, map_line(scene.truth[0].line, {.offset_m = [](double) { return 1.5; }}, 5.5));
  const auto result = refine_roads(scene.osm, scene.labels);
  const RoadError after = print("refined", compare(result.roads.paths[0], scene.truth[0]));
  EXPECT_LT(after.mean_offset_m, 0.5);
  EXPECT_LT(after.max_width_m, 3.9);
}

/// A through road of two ways, a side road that ends on it, and a crossing road.
RoadScene make_junctions() {
  RoadScene scene = make_scene(400.0);
  add_truth(scene, straight(at(20, 200), at(380, 215)), 7.0);
  add_truth(scene, straight(at(150, 205.4), at(170, 380)), 5.0);
  add_truth(scene, straight(at(300, 20), at(290, 380)), 5.0);
  const Vec2 shift{1.5, 2.5};
  const auto node = [&](double x, double y, std::int64_t id) {
    return RoadNode{.p = at(x, y) + shift, .osm_node = id, .width_m = 5.5};
  };
  const RoadNode t = node(150, 205.4, 10), joint = node(220, 208.3, 11), cross = node(295, 211.5, 12);
  add_way(scene, 1, {node(20, 200, 1), t, joint}, "tertiary");
  add_way(scene, 2, {node(380, 215, 2), cross, joint}, "tertiary");  // against the direction of way 1
  add_way(scene, 3, {node(170, 380, 3), t});
  add_way(scene, 4, {node(300, 20, 4), cross, node(290, 380, 5)});
  return scene;
}

TEST(RefineRoads, shared_nodes_meet_in_one_point) {
  const RoadScene scene = make_junctions();
  const auto result = refine_roads(scene.osm, scene.labels);
  std::map<std::int64_t, std::vector<Vec2>> places;
  for (const RoadPath& path : result.roads.paths)
    for (const RoadNode& node : path.nodes)
      if (node.osm_node > 0) places[node.osm_node].push_back(node.p);
  for (const std::int64_t id : {10, 11, 12}) {
    ASSERT_EQ(places[id].size(), 2u) << id;
    EXPECT_EQ(places[id][0], places[id][1]) << id;
  }
  EXPECT_LT(distance(places[10][0], at(150, 205.4)), 0.6);
  for (const auto& [k, truth] : {std::pair{0, 0}, {1, 0}, {2, 1}, {3, 2}}) {
    const RoadError after = print("refined", compare(result.roads.paths[k], scene.truth[truth], 3.0));
    EXPECT_LT(after.mean_offset_m, 0.25) << k;
    EXPECT_LT(after.mean_width_m, 0.4) << k;
  }
}

TEST(RefineRoads, ways_that_continue_share_tangent_and_width) {
  const RoadScene scene = make_junctions();
  const auto roads = refine_roads(scene.osm, scene.labels).roads;
  const auto &a = roads.paths[0].nodes, &b = roads.paths[1].nodes;  // they meet with their backs
  ASSERT_EQ(a.back().osm_node, 11);
  ASSERT_EQ(b.back().osm_node, 11);
  EXPECT_EQ(a.back().width_m, b.back().width_m);
  const Vec2 in = normalized(a.back().p - a[a.size() - 2].p), out = normalized(b[b.size() - 2].p - b.back().p);
  EXPECT_LT(std::abs(cross(in, out)), 0.05);  // no more than elsewhere on the way
}

TEST(RefineRoads, roundabout_stays_closed) {
  RoadScene scene = make_scene(200.0);
  const double r = 15.0;
  add_truth(scene,
            trace(2 * M_PI * r, [&](double s) { return at(100 + r * std::cos(s / r), 100 + r * std::sin(s / r)); }),
            6.0);
  auto nodes = map_line(scene.truth[0].line, {.node_spacing_m = 10.0}, 5.0);
  for (RoadNode& node : nodes) node.p = node.p + Vec2{1.5, -1.0};
  nodes.front().osm_node = nodes.back().osm_node = 9;
  add_way(scene, 1, nodes);
  const auto result = refine_roads(scene.osm, scene.labels);
  const auto& refined = result.roads.paths[0].nodes;
  EXPECT_EQ(refined.front().p, refined.back().p);
  EXPECT_EQ(refined.front().osm_node, 9);
  EXPECT_EQ(refined.back().osm_node, 9);
  EXPECT_LT(print("refined", compare(result.roads.paths[0], scene.truth[0])).mean_offset_m, 0.3);
}

TEST(RefineRoads, any_thread_count_gives_the_same) {
  const RoadScene scene = make_junctions();
  const auto one = refine_roads(scene.osm, scene.labels, {.threads = 1}),
             four = refine_roads(scene.osm, scene.labels, {.threads = 4});
  for (std::size_t p = 0; p < one.roads.paths.size(); ++p)
    for (std::size_t i = 0; i < one.roads.paths[p].nodes.size(); ++i) {
      const RoadNode &a = one.roads.paths[p].nodes[i], &b = four.roads.paths[p].nodes[i];
      EXPECT_EQ(a.p, b.p);
      EXPECT_EQ(a.width_m, b.width_m);
      EXPECT_EQ(a.sigma_offset_m, b.sigma_offset_m);
    }
}

TEST(RefineRoads, tiny_and_degenerate_ways) {
  RoadScene scene = make_scene(100.0);
  add_way(scene, 1, {{.p = at(50, 50), .width_m = 5.0}, {.p = at(50.1, 50), .width_m = 5.0}});
  add_way(scene, 2, {{.p = at(20, 20), .width_m = 5.0}, {.p = at(20, 20), .width_m = 5.0}});      // no length
  add_way(scene, 3, {{.p = at(-500, 20), .width_m = 5.0}, {.p = at(-400, 20), .width_m = 5.0}});  // outside the labels
  add_way(scene, 4,
          {{.p = at(50, 50), .width_m = 5.0},
           {.p = at(60, 50), .width_m = 5.0},
           {.p = at(50, 50.1), .width_m = 5.0}});  // there and back
  const auto result = refine_roads(scene.osm, scene.labels);
  ASSERT_EQ(result.roads.paths.size(), 4u);
  for (const RoadPath& path : result.roads.paths) {
    EXPECT_GE(path.nodes.size(), 2u);
    for (const RoadNode& node : path.nodes) EXPECT_TRUE(std::isfinite(node.p.x) && std::isfinite(node.sigma_width_m));
  }
}

TEST(RefineRoads, a_way_that_crosses_itself_is_told_with_its_place) {
  RoadScene scene = make_scene(100.0);
  const auto node = [](double x, double y) { return RoadNode{.p = at(x, y), .width_m = 5.0}; };
  add_way(scene, 8, {node(10, 50), node(90, 50), node(90, 80), node(50, 80), node(50, 20)});
  const auto result = refine_roads(scene.osm, scene.labels);
  const auto found = std::ranges::find(result.findings, "refine.self_crossing", &Finding::code);
  ASSERT_NE(found, result.findings.end());
  EXPECT_NEAR(found->x_m, at(50, 50).x, 0.01);
  EXPECT_NEAR(found->y_m, at(50, 50).y, 0.01);
}

TEST(RefineRoads, a_way_of_100000_nodes_is_refined) {
  RoadScene scene = make_scene(300.0);
  std::vector<RoadNode> nodes;
  nodes.reserve(100000);
  for (int i = 0; i < 100000; ++i)
    nodes.push_back({.p = at(20.0 + i * 260.0 / 99999.0, 150.0 + 0.001 * (i % 2)), .width_m = 5.0});
  add_truth(scene, straight(at(20, 152), at(280, 152)), 6.0);
  add_way(scene, 1, nodes);
  const auto result = refine_roads(scene.osm, scene.labels);
  EXPECT_LT(compare(result.roads.paths[0], scene.truth[0]).mean_offset_m, 0.2);
  EXPECT_LT(result.roads.paths[0].nodes.size(), 200u);
}

TEST(RefineRoads, no_roads_give_no_roads) {
  EXPECT_TRUE(refine_roads(make_scene(50.0).osm, make_scene(50.0).labels).roads.paths.empty());
}

TEST(RefineRoads, wrong_input_is_refused) {
  RoadScene scene = make_scene(50.0);
  scene.osm.crs = {"EPSG:32634"};
  EXPECT_THROW((void)refine_roads(scene.osm, scene.labels), OptionError);
  scene = make_scene(50.0);
  add_way(scene, 1, {{.p = at(5, 5)}, {.p = at(40, 5)}});  // no width
  EXPECT_THROW((void)refine_roads(scene.osm, scene.labels), OptionError);
}

}  // namespace
}  // namespace orthodrive
