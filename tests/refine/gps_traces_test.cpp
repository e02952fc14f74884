// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/random.hpp"
#include "orthodrive/refine/refine_roads.hpp"
#include "refine/road_scene.hpp"

namespace orthodrive {
namespace {

using namespace test;

GpsTraces no_traces() { return {.crs = {"EPSG:32633"}}; }

struct Drive {
  Vec2 error_m;         ///< of the receiver, the same all along
  double beside_m = 0;  ///< to the right of the line, as driven
  bool backwards = false;
  double jitter_m = 0.0;
  std::uint64_t seed = 1;
};

/// A point every 8 m, as at one a second in a village.
void add_trace(GpsTraces& traces, Polyline line, const Drive& drive) {
  if (drive.backwards) std::reverse(line.begin(), line.end());
  const double total = length_m(line);
  const std::vector<Vec2> t = tangents(line);
  const std::vector<double> s = arc_lengths_m(line);
  Random random(drive.seed);
  GpsTrace trace{.recording = traces.traces.size()};
  for (double at = 0.0; at <= total; at += 8.0) {
    const auto i = static_cast<std::size_t>(std::lower_bound(s.begin(), s.end() - 1, at) - s.begin());
    trace.line.push_back(line[i] - left_normal(t[i]) * drive.beside_m + drive.error_m +
                         Vec2{drive.jitter_m * random.normal(), drive.jitter_m * random.normal()});
  }
  traces.traces.push_back(std::move(trace));
}

Polyline traced_curve() {
  return trace(360.0, [](double s) { return at(20.0 + s, 200.0 + 30.0 * std::sin(s / 55.0)); });
}

/// The map lies `off_m` to the left of a road that trees hide for its whole length.
RoadScene hidden_road(double off_m) {
  RoadScene scene = make_scene(400.0);
  scene.truth.push_back({traced_curve(), 5.5});
  add_way(scene, 1, map_line(scene.truth[0].line, {.offset_m = [off_m](double) { return off_m; }}, 5.5));
  return scene;
}

std::vector<double> offsets_from(const RoadPath& path, const TrueRoad& truth, double margin_m = 0.0) {
  std::vector<double> offsets;
  const double total = length_m(truth.line);
  for (const RoadNode& node : path.nodes) {
    const LineProjection at = project_onto(truth.line, node.p);
    if (at.s_m >= margin_m && at.s_m <= total - margin_m) offsets.push_back(at.offset_m);
  }
  return offsets;
}

double mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double v : values) sum += v;
  return sum / static_cast<double>(values.size());
}

int count_of(const Findings& findings, const std::string& code) {
  return static_cast<int>(std::ranges::count_if(findings, [&](const Finding& f) { return f.code == code; }));
}

TEST(GpsTraces, a_hidden_road_follows_what_traces_agree_on) {
  const RoadScene scene = hidden_road(5.0);
  GpsTraces traces = no_traces();
  for (const Vec2 error : {Vec2{2.0, 2.5}, Vec2{-3.0, -1.0}, Vec2{1.0, -1.5}})  // none on average
    for (const bool backwards : {false, true})
      add_trace(traces, traced_curve(), {error, 0.25 * 5.5, backwards, 0.5, traces.traces.size() + 1});
  const RoadNetwork without = refine_roads(scene.osm, scene.labels).roads;
  EXPECT_GT(mean(offsets_from(without.paths[0], scene.truth[0])), 4.5);
  const auto result = refine_roads(scene.osm, scene.labels, {}, nullptr, traces);
  ASSERT_EQ(result.roads.paths.size(), 1u);
  const std::vector<double> offsets = offsets_from(result.roads.paths[0], scene.truth[0]);
  // Six receivers know the place to some 1.3 m, the map to 5 m: a tenth of its error is left.
  EXPECT_NEAR(mean(offsets), 0.5, 0.35);
  for (const double offset : offsets) EXPECT_LT(std::abs(offset), 1.3);
}

TEST(GpsTraces, the_error_of_a_hidden_road_is_as_large_as_stated) {
  constexpr int scenes = 30;
  Random random(5);
  double squares = 0.0, variances = 0.0;
  for (int k = 0; k < scenes; ++k) {
    const RoadScene scene = hidden_road(random.uniform(-7.0, 7.0));
    GpsTraces traces = no_traces();
    for (int t = 0; t < 3; ++t)
      add_trace(traces, traced_curve(),
                {{3.0 * random.normal(), 3.0 * random.normal()},
                 0.25 * 5.5,
                 t % 2 == 0,
                 0.5,
                 static_cast<std::uint64_t>(10 * k + t)});
    const RoadPath path = refine_roads(scene.osm, scene.labels, {}, nullptr, traces).roads.paths.at(0);
    const double error = mean(offsets_from(path, scene.truth[0]));
    squares += error * error, variances += std::pow(path.nodes[path.nodes.size() / 2].sigma_offset_m, 2);
  }
  const double error_m = std::sqrt(squares / scenes), sigma_m = std::sqrt(variances / scenes);
  std::printf("error %.2f m, stated %.2f m\n", error_m, sigma_m);
  EXPECT_LT(error_m, 3.0 / std::sqrt(3.0) * 1.25);  // three receivers of 3 m; with chance of 30 scenes
  EXPECT_GT(sigma_m / error_m, 0.75);
  EXPECT_LT(sigma_m / error_m, 1.5);
}

TEST(GpsTraces, traces_do_not_spoil_a_road_that_is_seen) {
  RoadScene scene = make_scene(400.0);
  add_truth(scene, traced_curve(), 6.0);
  add_way(scene, 1, map_line(scene.truth[0].line, {.offset_m = [](double) { return 2.0; }}, 5.5));
  GpsTraces traces = no_traces();
  for (const int seed : {1, 2})
    add_trace(traces, traced_curve(), {{1.0, -5.0}, 1.5, false, 1.0, static_cast<std::uint64_t>(seed)});
  const RoadPath without = refine_roads(scene.osm, scene.labels).roads.paths.at(0),
                 with = refine_roads(scene.osm, scene.labels, {}, nullptr, traces).roads.paths.at(0);
  const RoadError before = compare(without, scene.truth[0]), after = compare(with, scene.truth[0]);
  EXPECT_LT(after.mean_offset_m, before.mean_offset_m + 0.03);
  EXPECT_LT(after.max_offset_m, before.max_offset_m + 0.1);
}

TEST(GpsTraces, drivers_keep_to_their_side_of_two_way_roads) {
  const auto offset_of = [](const std::string& highway, double width_m, Oneway oneway, double beside_m,
                            DrivingSide driving_side) {
    RoadScene scene = make_scene(400.0);
    const Polyline line = straight(at(20, 200), at(380, 200));
    add_way(scene, 1, map_line(line, {}, width_m), highway);
    scene.osm.paths[0].oneway = oneway;
    GpsTraces traces = no_traces();
    for (int k = 0; k < 5; ++k) add_trace(traces, line, {{}, beside_m});
    const auto result = refine_roads(scene.osm, scene.labels, {.driving_side = driving_side}, nullptr, traces);
    return result.roads.paths[0].nodes[90].offset_m;
  };
  EXPECT_NEAR(offset_of("primary", 8.0, Oneway::no, 2.0, DrivingSide::right), 0.0, 0.1);
  EXPECT_NEAR(offset_of("primary", 8.0, Oneway::no, -2.0, DrivingSide::left), 0.0, 0.1);
  EXPECT_LT(offset_of("primary", 8.0, Oneway::no, 2.0, DrivingSide::left), -2.5);
  EXPECT_NEAR(offset_of("track", 3.5, Oneway::no, 0.0, DrivingSide::right), 0.0, 0.1);
  EXPECT_NEAR(offset_of("primary", 8.0, Oneway::forward, 0.0, DrivingSide::right), 0.0, 0.1);
}

TEST(GpsTraces, carriageways_are_told_apart_by_the_direction_of_their_traffic) {
  // Both hidden, 11 m apart. The map is 4 m off to the north: its southern line is 7 m from the northern traces.
  RoadScene scene = make_scene(400.0);
  const Polyline east = straight(at(20, 200), at(380, 200)), west = straight(at(380, 211), at(20, 211));
  add_way(scene, 1, map_line(east, {.offset_m = [](double) { return 4.0; }}, 7.5), "primary");
  add_way(scene, 2, map_line(west, {.offset_m = [](double) { return -4.0; }}, 7.5), "primary");
  for (RoadPath& path : scene.osm.paths) path.oneway = Oneway::forward;
  GpsTraces traces = no_traces();
  for (int k = 0; k < 4; ++k) add_trace(traces, east, {}), add_trace(traces, west, {});
  const RoadNetwork roads = refine_roads(scene.osm, scene.labels, {}, nullptr, traces).roads;
  EXPECT_NEAR(roads.paths[0].nodes[90].p.y, at(0, 200).y, 0.8);
  EXPECT_NEAR(roads.paths[1].nodes[90].p.y, at(0, 211).y, 0.8);
}

TEST(GpsTraces, parallel_roads_keep_their_own_traces) {
  RoadScene scene = make_scene(400.0);
  const Polyline main = straight(at(20, 200), at(380, 200)), service = straight(at(20, 190), at(380, 190));
  add_way(scene, 1, map_line(main, {}, 6.5), "secondary");
  add_way(scene, 2, map_line(service, {}, 4.0), "service");
  GpsTraces traces = no_traces();
  for (const bool backwards : {false, true})
    for (const double error_m : {-1.5, 1.5}) {
      add_trace(traces, main, {{0.0, error_m}, 0.25 * 6.5, backwards});
      add_trace(traces, service, {{0.0, -error_m}, 0.0, backwards});
    }
  const RoadNetwork roads = refine_roads(scene.osm, scene.labels, {}, nullptr, traces).roads;
  for (const RoadPath& path : roads.paths) EXPECT_NEAR(path.nodes[90].offset_m, 0.0, 0.4) << path.highway;
}

TEST(GpsTraces, one_that_took_another_way_is_outvoted) {
  const RoadScene scene = hidden_road(0.0);
  GpsTraces traces = no_traces();
  for (int k = 0; k < 4; ++k) add_trace(traces, traced_curve(), {{}, 0.25 * 5.5, k % 2 == 0});
  add_trace(traces, traced_curve(), {{}, 10.0, true});
  const RoadPath path = refine_roads(scene.osm, scene.labels, {}, nullptr, traces).roads.paths.at(0);
  EXPECT_LT(std::abs(mean(offsets_from(path, scene.truth[0]))), 0.9);  // the mean of all is 1.7 m off
}

TEST(GpsTraces, laps_of_one_recording_are_one_witness) {
  const auto sigma_with = [](std::size_t recordings) {
    const RoadScene scene = hidden_road(0.0);
    GpsTraces traces = no_traces();
    for (int k = 0; k < 8; ++k) add_trace(traces, traced_curve(), {{}, 0.25 * 5.5});
    for (std::size_t k = 0; k < traces.traces.size(); ++k) traces.traces[k].recording = k % recordings;
    return refine_roads(scene.osm, scene.labels, {}, nullptr, traces).roads.paths.at(0).nodes[90].sigma_offset_m;
  };
  EXPECT_GT(sigma_with(1), 1.6 * sigma_with(8));
}

TEST(GpsTraces, a_receiver_errs_alike_over_hundreds_of_metres) {
  RoadScene scene = make_scene(1000.0);
  const Polyline line = straight(at(20, 500), at(980, 500));
  add_way(scene, 1, map_line(line, {}, 5.5));
  GpsTraces traces = no_traces();
  add_trace(traces, line, {{}, 0.25 * 5.5});
  const auto sigma_m = [&] {
    const auto nodes = refine_roads(scene.osm, scene.labels, {}, nullptr, traces).roads.paths.at(0).nodes;
    return nodes[nodes.size() / 2].sigma_offset_m;
  };
  EXPECT_GT(sigma_m(), 2.1);  // 3 m of the receiver, 5 m of the map: 2.6 m
  scene.osm.paths.clear();
  EXPECT_GT(sigma_m(), 2.1);  // what only traces know has no map to agree with
}

TEST(GpsTraces, tell_which_of_two_bands_is_the_road) {
  for (const double side : {-1.0, 1.0}) {
    RoadScene scene = make_scene(400.0);
    for (const double y : {195.5, 204.5}) add_truth(scene, straight(at(20, y), at(380, y)), 5.0);
    add_way(scene, 1, map_line(straight(at(20, 200), at(380, 200)), {}, 5.5));
    GpsTraces traces = no_traces();
    for (const bool backwards : {false, true})
      add_trace(traces, straight(at(20, 200 + 4.5 * side), at(380, 200 + 4.5 * side)),
                {{0.0, 1.0}, 0.25 * 5.5, backwards});
    const RoadPath path = refine_roads(scene.osm, scene.labels, {}, nullptr, traces).roads.paths.at(0);
    EXPECT_NEAR(path.nodes[90].offset_m, 4.5 * side, 0.2);
  }
}

TEST(GpsTraces, roads_without_traces_follow_the_map_s_shift_that_traces_tell) {
  RoadScene scene = make_scene(400.0);
  const auto add = [&](std::int64_t id, double y) {
    scene.truth.push_back({straight(at(20, y), at(380, y)), 5.5});
    add_way(scene, id, map_line(scene.truth.back().line, {.offset_m = [](double) { return 4.0; }}, 5.5));
  };
  add(1, 150), add(2, 190);
  GpsTraces traces = no_traces();
  for (const Vec2 error : {Vec2{0.0, 2.0}, Vec2{0.0, -2.0}})
    for (const bool backwards : {false, true}) add_trace(traces, scene.truth[0].line, {error, 0.25 * 5.5, backwards});
  const RoadNetwork roads = refine_roads(scene.osm, scene.labels, {}, nullptr, traces).roads;
  EXPECT_LT(std::abs(mean(offsets_from(roads.paths[1], scene.truth[1]))), 2.0);
  EXPECT_GT(roads.paths[1].nodes[90].sigma_offset_m, roads.paths[0].nodes[90].sigma_offset_m);
}

/// A road of the map, and a track off it that the labels show and three traces know.
struct Lacking {
  RoadScene scene = make_scene(400.0);
  GpsTraces traces = no_traces();
};
Polyline track_line() {
  return trace(260.0, [](double s) { return at(150.0 + 25.0 * std::sin(s / 60.0), 100.0 + s); });
}
Lacking make_lacking(double jitter_m = 0.5) {
  Lacking lacking;
  add_truth(lacking.scene, straight(at(20, 100), at(380, 100)), 6.0);
  add_truth(lacking.scene, track_line(), 4.0);
  add_way(lacking.scene, 1,
          {{.p = at(20, 102), .osm_node = 5, .width_m = 5.5}, {.p = at(380, 102), .osm_node = 6, .width_m = 5.5}},
          "tertiary");
  // All come from the road and turn into the track; one turns round at its end and comes back.
  Polyline there = straight(at(60, 98.5), at(147, 98.5));
  const Polyline track = track_line();
  there.insert(there.end(), track.begin() + 8, track.end());
  Polyline there_and_back = there;
  there_and_back.insert(there_and_back.end(), there.rbegin(), there.rend());
  add_trace(lacking.traces, there, {{2.0, 1.0}, 0.0, false, jitter_m, 1});
  add_trace(lacking.traces, there_and_back, {{-3.0, 1.5}, 0.0, false, jitter_m, 2});
  there.resize(there.size() - 60);
  add_trace(lacking.traces, there, {{1.0, -2.0}, 0.0, true, jitter_m, 3});
  return lacking;
}

TEST(GpsTraces, a_path_that_only_traces_know_is_added_once_and_lies_on_the_road) {
  const Lacking lacking = make_lacking();
  const auto result = refine_roads(lacking.scene.osm, lacking.scene.labels, {}, nullptr, lacking.traces);
  ASSERT_EQ(result.roads.paths.size(), 2u);
  const RoadPath &road = result.roads.paths[0], &track = result.roads.paths[1];
  EXPECT_EQ(track.osm_id, -1);
  EXPECT_EQ(track.highway, "track");
  const RoadError error = compare(track, lacking.scene.truth[1], 10.0);
  std::printf("track: offset mean %.3f max %.3f m, width mean %.3f m\n", error.mean_offset_m, error.max_offset_m,
              error.mean_width_m);
  EXPECT_LT(error.mean_offset_m, 0.2);
  EXPECT_LT(error.max_offset_m, 0.8);
  EXPECT_LT(error.mean_width_m, 0.5);
  EXPECT_NEAR(length_m(centerline(track)), length_m(track_line()), 12.0);

  // They meet in one point, on the road.
  const auto meets = [&](const RoadNode& node) {
    return node.osm_node > 0 && node.osm_node == track.nodes.front().osm_node;
  };
  const auto shared = std::ranges::find_if(road.nodes, meets);
  ASSERT_NE(shared, road.nodes.end());
  EXPECT_EQ(shared->p, track.nodes.front().p);
  EXPECT_LT(distance(shared->p, at(150, 100)), 3.0);
  EXPECT_NEAR(shared->p.y, at(0, 100).y, 0.3);
  EXPECT_EQ(track.nodes.back().osm_node, 0);
  EXPECT_EQ(road.nodes.front().osm_node, 5);

  ASSERT_EQ(count_of(result.findings, "refine.path_from_gpx"), 1);
  const auto found =
      std::ranges::find_if(result.findings, [](const Finding& f) { return f.code == "refine.path_from_gpx"; });
  EXPECT_EQ(found->severity, Severity::info);
  EXPECT_THAT(found->message, testing::AllOf(testing::HasSubstr("way -1"), testing::HasSubstr("of 3 recording")));
  EXPECT_LT(project_onto(track_line(), {found->x_m, found->y_m}).distance_m, 6.0);
}

TEST(GpsTraces, what_is_seen_of_a_road_tells_the_error_of_its_traces) {
  RoadScene scene = make_scene(400.0);
  add_truth(scene, traced_curve(), 4.0);
  paint(scene.labels, {at(200, 0), at(400, 0), at(400, 400), at(200, 400)}, label_vegetation);
  GpsTraces traces = no_traces();
  for (const bool backwards : {false, true}) add_trace(traces, traced_curve(), {{1.0, -3.5}, 0.0, backwards});
  const auto result = refine_roads(scene.osm, scene.labels, {}, nullptr, traces);
  ASSERT_EQ(result.roads.paths.size(), 1u);
  double hidden_m = 0.0, count = 0.0;
  for (const RoadNode& node : result.roads.paths[0].nodes)
    if (node.p.x > at(220, 0).x) hidden_m += project_onto(traced_curve(), node.p).distance_m, count += 1.0;
  std::printf("hidden part of the traces: %.2f m\n", hidden_m / count);
  EXPECT_LT(hidden_m / count, 0.5);  // the traces are 3 m off
}

TEST(GpsTraces, a_path_that_crosses_a_road_meets_it_in_one_node) {
  RoadScene scene = make_scene(400.0);
  add_way(scene, 1,
          {{.p = at(20, 200), .osm_node = 5, .width_m = 5.5}, {.p = at(380, 200), .osm_node = 6, .width_m = 5.5}});
  GpsTraces traces = no_traces();
  add_trace(traces, straight(at(150, 60), at(230, 340)), {});
  const RoadNetwork roads = refine_roads(scene.osm, scene.labels, {}, nullptr, traces).roads;
  ASSERT_EQ(roads.paths.size(), 3u);
  std::map<std::int64_t, int> incidences;
  for (const RoadPath& path : roads.paths)
    for (const RoadNode& node : path.nodes)
      if (node.osm_node > 6) ++incidences[node.osm_node];
  ASSERT_EQ(incidences.size(), 1u);
  EXPECT_EQ(incidences.begin()->second, 3);
}

TEST(GpsTraces, a_circuit_is_closed_after_its_first_lap) {
  const double r = 60.0;
  const auto circle = [&](double s) { return at(200 + 1.5 * r * std::cos(s / r), 200 + r * std::sin(s / r)); };
  RoadScene scene = make_scene(400.0);
  const Polyline lap = trace(2.0 * M_PI * r, circle);
  add_truth(scene, lap, 5.0);
  GpsTraces traces = no_traces();
  add_trace(traces, trace(2.0 * M_PI * r * 3.3, circle), {{2.0, -1.5}, 0.0, false, 0.5});
  const RoadNetwork roads = refine_roads(scene.osm, scene.labels, {}, nullptr, traces).roads;
  ASSERT_EQ(roads.paths.size(), 1u);
  const RoadPath& path = roads.paths[0];
  EXPECT_EQ(path.nodes.front().p, path.nodes.back().p);
  EXPECT_GT(path.nodes.front().osm_node, 0);
  EXPECT_EQ(path.nodes.front().osm_node, path.nodes.back().osm_node);
  EXPECT_NEAR(length_m(centerline(path)), length_m(lap), 4.0);
  EXPECT_LT(compare(path, scene.truth[0]).max_offset_m, 0.5);
}

TEST(GpsTraces, a_loop_at_the_end_of_a_path_meets_it) {
  RoadScene scene = make_scene(400.0);
  const double r = 40.0;
  Polyline line = straight(at(200, 30), at(200, 200));  // then round to the right, and back to where the loop began
  for (double s = 0.0; s < 2.0 * M_PI * r + 30.0; s += 0.5)
    line.push_back(at(200 + r - r * std::cos(s / r), 200 + r * std::sin(s / r)));
  GpsTraces traces = no_traces();
  add_trace(traces, line, {});
  const RoadNetwork roads = refine_roads(scene.osm, scene.labels, {}, nullptr, traces).roads;
  ASSERT_EQ(roads.paths.size(), 1u);
  const auto& nodes = roads.paths[0].nodes;
  ASSERT_GT(nodes.back().osm_node, 0);
  const auto again =
      std::ranges::find_if(nodes, [&](const RoadNode& n) { return n.osm_node == nodes.back().osm_node; });
  EXPECT_LT(again, nodes.end() - 1);
  EXPECT_EQ(again->p, nodes.back().p);
  EXPECT_NEAR(length_m(centerline(roads.paths[0])), 170.0 + 2.0 * M_PI * r, 20.0);
}

TEST(GpsTraces, forks_and_short_ends_of_new_paths) {
  RoadScene scene = make_scene(600.0);
  GpsTraces traces = no_traces();
  Polyline main = straight(at(50, 300), at(550, 300)), fork = straight(at(50, 302), at(300, 302)),
           stub = straight(at(400, 300), at(400, 345));
  const Polyline branch = straight(at(300, 302), at(420, 480));
  fork.insert(fork.end(), branch.begin(), branch.end());
  add_trace(traces, main, {});
  add_trace(traces, fork, {});
  add_trace(traces, stub, {});  // 45 m
  const auto result = refine_roads(scene.osm, scene.labels, {}, nullptr, traces);
  ASSERT_EQ(result.roads.paths.size(), 2u);
  EXPECT_NEAR(length_m(centerline(result.roads.paths[0])), 500.0, 8.0);
  EXPECT_NEAR(length_m(centerline(result.roads.paths[1])), length_m(branch), 12.0);
  const std::int64_t node = result.roads.paths[1].nodes.front().osm_node;
  EXPECT_GT(node, 0);
  EXPECT_TRUE(std::ranges::any_of(result.roads.paths[0].nodes, [&](const RoadNode& n) { return n.osm_node == node; }));
}

TEST(GpsTraces, nothing_is_added_outside_the_photo_or_beside_a_road) {
  RoadScene scene = make_scene(400.0);
  add_way(scene, 1, map_line(straight(at(20, 200), at(380, 200)), {}, 5.5));
  paint(scene.labels, {at(0, 0), at(400, 0), at(400, 120), at(0, 120)}, label_nodata);
  GpsTraces traces = no_traces();
  add_trace(traces, straight(at(20, 217), at(380, 217)), {});  // 17 m beside
  add_trace(traces, straight(at(20, 60), at(380, 60)), {});    // nodata
  add_trace(traces, straight(at(20, -60), at(380, -60)), {});  // off the frame
  EXPECT_EQ(refine_roads(scene.osm, scene.labels, {}, nullptr, traces).roads.paths.size(), 1u);
}

TEST(GpsTraces, any_thread_count_gives_the_same) {
  const Lacking lacking = make_lacking();
  const auto one = refine_roads(lacking.scene.osm, lacking.scene.labels, {.threads = 1}, nullptr, lacking.traces),
             two = refine_roads(lacking.scene.osm, lacking.scene.labels, {.threads = 2}, nullptr, lacking.traces);
  ASSERT_EQ(one.roads.paths.size(), two.roads.paths.size());
  for (std::size_t p = 0; p < one.roads.paths.size(); ++p) {
    ASSERT_EQ(one.roads.paths[p].nodes.size(), two.roads.paths[p].nodes.size());
    for (std::size_t i = 0; i < one.roads.paths[p].nodes.size(); ++i) {
      const RoadNode &a = one.roads.paths[p].nodes[i], &b = two.roads.paths[p].nodes[i];
      EXPECT_EQ(a.p, b.p);
      EXPECT_EQ(a.width_m, b.width_m);
      EXPECT_EQ(a.sigma_offset_m, b.sigma_offset_m);
    }
  }
}

TEST(GpsTraces, a_receiver_that_stands_or_turns_makes_no_path) {
  RoadScene scene = make_scene(400.0);
  GpsTraces traces = no_traces();
  Random random(3);
  GpsTrace trace;
  for (int k = 0; k < 600; ++k) trace.line.push_back(at(200, 200) + Vec2{2.5 * random.normal(), 2.5 * random.normal()});
  traces.traces.push_back(trace);
  EXPECT_TRUE(refine_roads(scene.osm, scene.labels, {}, nullptr, traces).roads.paths.empty());
}

TEST(GpsTraces, far_ones_are_told_and_change_nothing) {
  RoadScene scene = make_scene(400.0);
  add_truth(scene, traced_curve(), 6.0);
  add_way(scene, 1, map_line(scene.truth[0].line, {}, 5.5));
  GpsTraces traces = no_traces();
  add_trace(traces, straight(at(90000, 0), at(90100, 0)), {});
  traces.traces.push_back({{at(90000, 0), at(90000, 0)}, 9});  // no length
  const auto with = refine_roads(scene.osm, scene.labels, {}, nullptr, traces),
             without = refine_roads(scene.osm, scene.labels);
  ASSERT_EQ(count_of(with.findings, "refine.traces_outside"), 1);
  EXPECT_EQ(with.roads.paths[0].nodes[50].p, without.roads.paths[0].nodes[50].p);
  traces.crs = {"EPSG:32634"};
  EXPECT_THROW((void)refine_roads(scene.osm, scene.labels, {}, nullptr, traces), OptionError);
}

}  // namespace
}  // namespace orthodrive
