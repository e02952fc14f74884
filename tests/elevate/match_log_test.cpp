// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/elevate/logs/match_log.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "orthodrive/core/random.hpp"

namespace orthodrive {
namespace {

const Crs log_crs{"EPSG:32633"};

RoadPath line(std::int64_t osm_id, Vec2 a, Vec2 b, std::int64_t node_a = 0, std::int64_t node_b = 0,
              Oneway oneway = Oneway::no) {
  RoadPath path{.osm_id = osm_id, .highway = "residential", .oneway = oneway};
  const int steps = std::max(1, static_cast<int>(std::lround(distance(a, b) / 2.0)));
  for (int i = 0; i <= steps; ++i) {
    const double f = static_cast<double>(i) / steps;
    path.nodes.push_back({.p = a + (b - a) * f, .s_m = f * distance(a, b), .width_m = 6.0});
  }
  path.nodes.front().osm_node = node_a, path.nodes.back().osm_node = node_b;
  return path;
}

/// A drive along corners at 10 m/s and 10 Hz, with an error that changes slowly and one that does not.
DriveRecording drive(const std::vector<Vec2>& corners, double error_m, std::uint64_t seed = 1) {
  Random random(seed);
  const double angle = random.uniform(0.0, 6.28);
  const Vec2 shift = Vec2{std::cos(angle), std::sin(angle)} * error_m;
  DriveRecording recording;
  double time = 0.0;
  for (std::size_t c = 0; c + 1 < corners.size(); ++c) {
    const double run = distance(corners[c], corners[c + 1]);
    for (double s = 0.0; s < run; s += 1.0, time += 0.1) {
      const Vec2 scatter{0.3 * random.normal(), 0.3 * random.normal()};
      recording.poses.push_back({.time_s = time,
                                 .p = corners[c] + (corners[c + 1] - corners[c]) * (s / run) + shift + scatter,
                                 .sigma_p_m = 4.0,
                                 .speed_mps = 10.0});
    }
  }
  return recording;
}

/// Share of poses on that path, in that direction.
double share_on(const MatchLogResult& match, std::size_t path, bool forward) {
  double on = 0.0;
  for (const auto& place : match.places) on += place && place->path == path && place->forward == forward;
  return on / static_cast<double>(match.places.size());
}

TEST(MatchLog, a_drive_of_5_m_error_follows_the_roads_round_a_corner) {
  const RoadNetwork roads{log_crs,
                          {line(1, {0, 0}, {300, 0}, 1, 2), line(2, {300, 0}, {300, 300}, 2, 3),
                           line(3, {300, 0}, {600, 0}, 2, 4), line(4, {0, 60}, {600, 60})}};
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const DriveRecording recording = drive({{10, 0}, {300, 0}, {300, 290}}, 5.0, seed);
    const MatchLogResult match = LogMatcher(roads).match(recording, "a");
    EXPECT_GT(share_on(match, 0, true), 0.46) << seed;
    EXPECT_GT(share_on(match, 1, true), 0.46) << seed;
    EXPECT_GT(match.matched_m, 0.97 * match.length_m);
    EXPECT_THAT(match.findings, testing::IsEmpty());
  }
}

TEST(MatchLog, places_are_those_of_the_car) {
  const RoadNetwork roads{log_crs, {line(1, {0, 0}, {300, 0})}};
  DriveRecording recording;
  for (int i = 0; i <= 200; ++i) recording.poses.push_back({.time_s = 0.1 * i, .p = {250.0 - i, 1.5}});
  const MatchLogResult match = LogMatcher(roads).match(recording, "a");
  for (int i = 0; i <= 200; ++i) {
    ASSERT_TRUE(match.places[i]) << i;
    EXPECT_NEAR(match.places[i]->s_m, 250.0 - i, 1e-9);
    EXPECT_NEAR(match.places[i]->offset_m, 1.5, 1e-9);
    EXPECT_FALSE(match.places[i]->forward);
  }
}

TEST(MatchLog, carriageways_side_by_side_are_told_by_their_direction) {
  // 8 m apart, one way each; the receiver is 5 m off, so that the wrong one is often the nearer.
  const RoadNetwork roads{
      log_crs, {line(1, {0, 0}, {500, 0}, 0, 0, Oneway::forward), line(2, {500, 8}, {0, 8}, 0, 0, Oneway::forward)}};
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    EXPECT_GT(share_on(LogMatcher(roads).match(drive({{5, 0}, {495, 0}}, 5.0, seed), "a"), 0, true), 0.97) << seed;
    EXPECT_GT(share_on(LogMatcher(roads).match(drive({{495, 8}, {5, 8}}, 5.0, seed), "a"), 1, true), 0.97) << seed;
  }
}

TEST(MatchLog, a_parallel_road_is_not_jumped_to) {
  // 14 m beside the main road and not connected: for some of the way the error makes it the nearer one.
  const RoadNetwork roads{log_crs, {line(1, {0, 0}, {600, 0}), line(2, {0, 14}, {600, 14})}};
  DriveRecording recording = drive({{5, 0}, {595, 0}}, 0.0);
  for (DrivePose& pose : recording.poses)
    if (pose.p.x > 250 && pose.p.x < 330) pose.p.y += 9.0;
  EXPECT_GT(share_on(LogMatcher(roads).match(recording, "a"), 0, true), 0.97);
}

TEST(MatchLog, leaving_the_roads_is_seen_and_reported) {
  const RoadNetwork roads{log_crs, {line(1, {0, 0}, {300, 0}, 1, 2)}};
  const MatchLogResult match = LogMatcher(roads).match(drive({{5, 0}, {200, 0}, {200, 150}, {290, 150}}, 1.0), "a");
  EXPECT_NEAR(match.matched_m, 195.0, 25.0);
  ASSERT_EQ(match.findings.size(), 1u);
  EXPECT_EQ(match.findings[0].code, "drive_log.unmatched");
  EXPECT_NEAR(match.findings[0].x_m, 200.0, 20.0);
  EXPECT_FALSE(match.places.back());
}

TEST(MatchLog, a_drive_elsewhere_and_one_against_a_oneway_match_nothing) {
  const RoadNetwork roads{log_crs, {line(1, {0, 0}, {300, 0}, 1, 2, Oneway::forward)}};
  for (const DriveRecording& recording : {drive({{5, 80}, {295, 80}}, 1.0), drive({{295, 0}, {5, 0}}, 1.0)}) {
    const MatchLogResult match = LogMatcher(roads).match(recording, "a");
    EXPECT_EQ(match.matched_m, 0.0);
    ASSERT_EQ(match.findings.size(), 1u);
    EXPECT_EQ(match.findings[0].code, "drive_log.no_match");
  }
}

TEST(MatchLog, a_crossing_road_is_crossed) {
  RoadNetwork roads{log_crs, {line(1, {0, 0}, {400, 0}), line(2, {200, -200}, {200, 200})}};
  roads.paths[0].nodes[100].osm_node = 7, roads.paths[1].nodes[100].osm_node = 7;
  EXPECT_GT(share_on(LogMatcher(roads).match(drive({{5, 0}, {395, 0}}, 3.0), "a"), 0, true), 0.97);
  // And a turn at a node in the middle of both.
  const MatchLogResult turn = LogMatcher(roads).match(drive({{5, 0}, {200, 0}, {200, -190}}, 3.0), "a");
  EXPECT_GT(share_on(turn, 0, true), 0.46);
  EXPECT_GT(share_on(turn, 1, false), 0.44);
}

TEST(MatchLog, rounds_on_a_closed_way_go_on) {
  RoadPath ring{.osm_id = 1, .highway = "raceway", .oneway = Oneway::forward};
  const double radius = 60.0, length = 2 * M_PI * radius;
  for (int i = 0; i <= 180; ++i)
    ring.nodes.push_back(
        {.p = Vec2{std::cos(i * M_PI / 90), std::sin(i * M_PI / 90)} * radius, .s_m = length * i / 180});
  ring.nodes.back().p = ring.nodes.front().p;
  ring.nodes.front().osm_node = ring.nodes.back().osm_node = 3;
  std::vector<Vec2> corners;
  for (int i = 10; i <= 460; i += 5) corners.push_back(Vec2{std::cos(i * M_PI / 90), std::sin(i * M_PI / 90)} * radius);
  const MatchLogResult match = LogMatcher({log_crs, {ring}}).match(drive(corners, 2.0), "a");
  EXPECT_GT(share_on(match, 0, true), 0.97);
}

TEST(MatchLog, a_car_at_rest_and_a_single_pose_are_no_trouble) {
  const RoadNetwork roads{log_crs, {line(1, {0, 0}, {300, 0})}};
  DriveRecording rest;
  for (int i = 0; i < 50; ++i) rest.poses.push_back({.time_s = 0.1 * i, .p = {100, 1}});
  const MatchLogResult match = LogMatcher(roads).match(rest, "a");
  EXPECT_TRUE(match.places.front());
  rest.poses.resize(1);
  EXPECT_TRUE(LogMatcher(roads).match(rest, "a").places.front());
  EXPECT_THAT(LogMatcher(roads).match({}, "a").places, testing::IsEmpty());
}

}  // namespace
}  // namespace orthodrive
