// SPDX-License-Identifier: Apache-2.0
// Mini-roundabouts: one node of the map, a ring of the network.

#include <gtest/gtest.h>

#include <set>

#include "network_support.hpp"
#include "orthodrive/network/paint/mini_roundabout_marks.hpp"
#include "orthodrive/network/paint/waiting_lines.hpp"
#include "roadquery/query/road_query.hpp"

namespace orthodrive {
namespace {

using namespace orthodrive::network_test;
using roadquery::Road;

/// Roads of 100 m from node 9 in the middle towards these directions, on a slope.
RoadNetwork star(const std::vector<double>& degrees, const NodeSign& sign) {
  const auto height = [](Vec2 p) { return 100.0 + 0.03 * p.x - 0.02 * p.y; };
  std::vector<RoadPath> paths;
  for (const double angle : degrees) {
    const double a = angle * M_PI / 180.0;
    const auto id = static_cast<std::int64_t>(paths.size()) + 1;
    paths.push_back(
        make_path({{0, 0}, Vec2{std::cos(a), std::sin(a)} * 100.0}, {9, 100 + id}, {.osm_id = id, .height = height}));
  }
  RoadNetwork roads = network_of(std::move(paths));
  roads.signs = {sign};
  return roads;
}

NodeSign mini(std::string turn = "", double size_m = 0.0) {
  return {.osm_node = 9, .kind = NodeSignKind::mini_roundabout, .value = std::move(turn), .size_m = size_m};
}

bool has_finding(const NetworkResult& result, const std::string& code) {
  return std::ranges::any_of(result.findings, [&](const Finding& f) { return f.code == code; });
}

/// Of all lanes that are driven inside the ring's junctions and on the ring: which way round the middle they go,
/// +1 anticlockwise; and the nearest and furthest place of their middles.
struct RoundTrip {
  double least_turn = INFINITY, nearest_m = INFINITY;
};
RoundTrip round_trip(const roadquery::RoadMap& map, double side) {
  RoundTrip trip;
  for (const Road& road : map.roads) {
    if (road.junction < 0 && road.length > 50.0) continue;
    const auto& lanes = side > 0.0 ? road.sections.front().right : road.sections.front().left;
    for (const double share : {0.25, 0.5, 0.75}) {
      const double s = share * road.length;
      double t = roadquery::evaluate(road.lane_offset, s);
      if (!lanes.empty()) t -= side * 0.5 * roadquery::lane_width(lanes.front(), s);
      const auto p = roadquery::surface_point(road, s, t);
      const Vec2 from_middle = Vec2{p.x, p.y} - site_origin;
      const double hdg = roadquery::reference_point(road, s).hdg;
      trip.nearest_m = std::min(trip.nearest_m, length(from_middle));
      if (length(from_middle) < 5.8)  // beyond, roads lead in and out
        trip.least_turn =
            std::min(trip.least_turn, side * cross(normalized(from_middle), {std::cos(hdg), std::sin(hdg)}));
    }
  }
  return trip;
}

int give_way_lines(const roadquery::RoadMap& map) {
  int lines = 0;
  for (const Road& road : map.roads)
    for (const auto& object : road.objects) lines += object.name == network::give_way_line;
  return lines;
}

TEST(MiniRoundabouts, cars_go_round_the_middle_and_give_way) {
  for (const DrivingSide side : {DrivingSide::right, DrivingSide::left})
    for (const std::vector<double>& arms :
         {std::vector<double>{0, 90, 180}, {10, 95, 170, 280}, {0, 60, 130, 200, 290}}) {
      const NetworkResult result = build_network(star(arms, mini()), {.driving_side = side});
      const RoundTrip trip = round_trip(result.map, side == DrivingSide::right ? 1.0 : -1.0);
      EXPECT_GT(trip.least_turn, 0.3) << "in the direction of traffic all round";
      EXPECT_GT(trip.nearest_m, 2.0) << "nobody drives over the middle";
      EXPECT_EQ(give_way_lines(result.map), static_cast<int>(arms.size()));
      const JointGaps gaps = joint_gaps(result.map);
      EXPECT_LT(gaps.position_m, 1e-3);
      EXPECT_LT(gaps.z_m, 0.01);
      EXPECT_LT(gaps.heading_rad, 0.01);
      EXPECT_TRUE(std::ranges::all_of(result.map.junctions, [](const auto& j) { return j.surface.has_value(); }));
    }
}

TEST(MiniRoundabouts, the_disc_is_as_wide_as_its_tag_says) {
  const auto furthest = [](double size_m) {
    const NetworkResult result = build_network(star({0, 120, 240}, mini("", size_m)));
    double most = 0.0;
    for (const Road& road : result.map.roads) {
      if (road.junction >= 0 || road.length > 60.0) continue;
      const roadquery::Edges edges = roadquery::road_edges(road, 0.5 * road.length);
      for (const double t : {edges.left_t, edges.right_t}) {
        const auto p = roadquery::surface_point(road, 0.5 * road.length, t);
        most = std::max(most, distance({p.x, p.y}, site_origin));
      }
    }
    return most;
  };
  EXPECT_NEAR(furthest(0.0), 8.0, 0.3);
  EXPECT_NEAR(furthest(24.0), 12.0, 0.3);
}

TEST(MiniRoundabouts, the_middle_is_paved) {
  for (const double size_m : {0.0, 28.0}) {
    const NetworkResult result = build_network(star({0, 90, 180}, mini("", size_m)));
    const roadquery::RoadQuery query(result.map);
    for (double r = 0.0; r < 7.5; r += 0.5)
      for (int k = 0; k < 12; ++k) {
        const double a = k * M_PI / 6.0, x = r * std::cos(a), y = r * std::sin(a);
        roadquery::Cursor cursor;
        const double z = 100.0 + 0.03 * x - 0.02 * y;
        const auto hit = query.find(site_origin.x + x, site_origin.y + y, z, cursor);
        ASSERT_TRUE(hit.has_value()) << size_m << ": " << x << ", " << y;
        EXPECT_NEAR(hit->z, z, 0.1);
      }
  }
}

TEST(MiniRoundabouts, a_mark_lies_in_the_middle) {
  const NetworkResult result = build_network(star({0, 90, 180}, mini()));
  int marks = 0;
  for (const Road& road : result.map.roads)
    for (const auto& object : road.objects) {
      if (object.name != network::mini_roundabout_mark) continue;
      const auto p = roadquery::surface_point(road, object.s, object.t);
      EXPECT_LT(distance({p.x, p.y}, site_origin), 0.3);
      ++marks;
    }
  EXPECT_EQ(marks, 1);
}

TEST(MiniRoundabouts, where_one_road_passes_or_ends) {
  for (const std::vector<double>& arms : {std::vector<double>{0, 180}, {0, 100}, {30}}) {
    const NetworkResult result = build_network(star(arms, mini()));
    EXPECT_FALSE(result.map.junctions.empty());
    EXPECT_EQ(give_way_lines(result.map), static_cast<int>(arms.size()));
    EXPECT_LT(joint_gaps(result.map).position_m, 1e-3);
  }
}

TEST(MiniRoundabouts, near_other_junctions_discs_are_smaller_or_left_out) {
  RoadNetwork roads = star({0, 90, 180}, mini());
  roads.paths.push_back(make_path({{-5, -60}, {4, 0}}, {201, 200}, {.osm_id = 20}));
  RoadPath& first = roads.paths.front();  // another junction 4 m from the middle
  first.nodes[2].osm_node = 200;
  const NetworkResult plain = build_network(roads);
  EXPECT_TRUE(has_finding(plain, "network.no_room_for_mini_roundabout"));
  EXPECT_GE(give_way_lines(plain.map), 3) << "all give way all the same";
  // Two of them 22 m apart.
  roads = network_of({make_path({{-100, 0}, {0, 0}, {22, 0}, {120, 0}}, {1, 9, 10, 2}, {.osm_id = 1}),
                      make_path({{0, 0}, {0, 100}}, {9, 3}, {.osm_id = 2}),
                      make_path({{22, 0}, {22, -100}}, {10, 4}, {.osm_id = 3})});
  roads.signs = {mini(), mini()};
  roads.signs.back().osm_node = 10;
  const NetworkResult result = build_network(roads);
  EXPECT_FALSE(has_finding(result, "network.no_room_for_mini_roundabout"));
  EXPECT_GE(give_way_lines(result.map), 4);
  std::set<std::pair<std::string, double>> seen;
  EXPECT_LT(joint_gaps(result.map).position_m, 1e-3);
}

TEST(MiniRoundabouts, the_driving_side_counts_where_the_tag_says_otherwise) {
  const NetworkResult result = build_network(star({0, 90, 180}, mini("clockwise")));
  EXPECT_TRUE(has_finding(result, "network.roundabout_against_traffic"));
  EXPECT_GT(round_trip(result.map, 1.0).least_turn, 0.3);
  EXPECT_FALSE(
      has_finding(build_network(star({0, 90, 180}, mini("anticlockwise"))), "network.roundabout_against_traffic"));
}

TEST(MiniRoundabouts, order_and_ids_of_ways_do_not_matter) {
  const auto lengths = [](const RoadNetwork& roads) {
    const NetworkResult result = build_network(roads);
    std::multiset<long> all;
    for (const Road& road : result.map.roads) all.insert(std::lround(road.length * 100.0));
    return all;
  };
  RoadNetwork roads = star({0, 90, 180}, mini()), other = roads;
  std::ranges::reverse(other.paths);
  for (RoadPath& path : other.paths) path.osm_id += 70;
  EXPECT_EQ(lengths(roads), lengths(other));
}

}  // namespace
}  // namespace orthodrive
