// SPDX-License-Identifier: Apache-2.0
// Lanes that tags tell the widths of: on a road, where roads meet and through junctions.

#include <fmt/format.h>

#include <random>

#include "network_support.hpp"
#include "orthodrive/network/lanes/lanes.hpp"

namespace orthodrive {
namespace {

using namespace orthodrive::network_test;
using roadquery::Road;

const Road& plain_road_of(const roadquery::RoadMap& map, const std::string& osm_id) {
  for (const Road& road : map.roads)
    if (road.junction < 0 && road.osm_id == osm_id) return road;
  throw std::runtime_error("no road of way " + osm_id);
}

std::vector<double> widths_at(const std::vector<roadquery::Lane>& lanes, double s) {
  std::vector<double> widths;
  for (const roadquery::Lane& lane : lanes) widths.push_back(roadquery::lane_width(lane, s));
  return widths;
}

void expect_widths(const std::vector<roadquery::Lane>& lanes, double s, const std::vector<double>& wanted,
                   double within = 1e-6) {
  const std::vector<double> widths = widths_at(lanes, s);
  ASSERT_EQ(widths.size(), wanted.size());
  for (std::size_t i = 0; i < wanted.size(); ++i) EXPECT_NEAR(widths[i], wanted[i], within) << "lane " << i;
}

RoadPath three_lanes(std::int64_t id, double x0, double width_m, const std::string& widths) {
  RoadPath path = make_path({{x0, 0}, {x0 + 200.0, 0}}, {id, id + 1},
                            {.osm_id = id, .highway = "secondary", .width_m = width_m, .oneway = Oneway::forward});
  path.lanes = path.lanes_forward = 3, path.widths_forward = widths;
  return path;
}

BuildNetworkOptions driving_on(DrivingSide side) {
  BuildNetworkOptions options;
  options.driving_side = side;
  return options;
}

TEST(LaneWidths, each_lane_has_its_own_from_left_to_right) {
  const RoadPath path = three_lanes(1, 0.0, 9.0, "3.5|3|2.5");
  const Road right = plain_road_of(build_network(network_of({path})).map, "1");
  expect_widths(right.sections[0].right, 100.0, {3.5, 3.0, 2.5});
  const Road left = plain_road_of(build_network(network_of({path}), driving_on(DrivingSide::left)).map, "1");
  expect_widths(left.sections[0].left, 100.0, {2.5, 3.0, 3.5});
}

TEST(LaneWidths, lanes_keep_their_ratio_where_the_road_has_another_width) {
  for (const double width_m : {8.4, 9.3}) {
    const Road road = plain_road_of(build_network(network_of({three_lanes(1, 0.0, width_m, "3.5|3|2.5")})).map, "1");
    const double k = width_m / 9.0;
    expect_widths(road.sections[0].right, 100.0, {3.5 * k, 3.0 * k, 2.5 * k});
  }
  // What is wider than all lanes are told to be lies beside them.
  const Road wide = plain_road_of(build_network(network_of({three_lanes(1, 0.0, 12.0, "3.5|3|2.5")})).map, "1");
  const std::vector<double> lanes = widths_at(wide.sections[0].right, 100.0);
  EXPECT_NEAR(lanes[1] / lanes[0], 3.0 / 3.5, 1e-6);
  EXPECT_NEAR(lanes[0], 3.5, 1e-6);
}

TEST(LaneWidths, a_lane_of_which_nothing_is_told_takes_what_is_left) {
  const Road road = plain_road_of(build_network(network_of({three_lanes(1, 0.0, 9.4, "3.5|3|")})).map, "1");
  expect_widths(road.sections[0].right, 100.0, {3.5, 3.0, 2.9});
  const Road narrow = plain_road_of(build_network(network_of({three_lanes(1, 0.0, 8.0, "|3.5|3.5")})).map, "1");
  const std::vector<double> lanes = widths_at(narrow.sections[0].right, 100.0);
  EXPECT_NEAR(lanes[0] / lanes[1], 2.2 / 3.5, 1e-6) << "as wide as a car needs, all in that ratio";
}

TEST(LaneWidths, both_directions_and_the_lane_between_them) {
  RoadPath path = make_path({{0, 0}, {200, 0}}, {1, 2}, {.osm_id = 1, .highway = "secondary", .width_m = 12.5});
  path.lanes = 4, path.lanes_forward = 2, path.lanes_backward = path.lanes_both_ways = 1;
  path.widths_forward = "3|3.5", path.widths_backward = "3.5", path.widths_both_ways = "2.5";
  const Road road = plain_road_of(build_network(network_of({path})).map, "1");
  expect_widths(road.sections[0].right, 100.0, {2.5, 3.0, 3.5});
  expect_widths(road.sections[0].left, 100.0, {3.5});
  EXPECT_NEAR(roadquery::evaluate(road.lane_offset, 100.0), 6.25 - 3.5, 1e-6) << "between the directions";
  path.widths_backward.clear(), path.widths_both_ways.clear();
  expect_widths(plain_road_of(build_network(network_of({path})).map, "1").sections[0].right, 100.0, {3.0, 3.0, 3.5});
}

TEST(LaneWidths, placement_counts_them) {
  RoadPath path = three_lanes(1, 0.0, 9.0, "3.5|3|2.5");
  path.placement = {false, 1.0, 1.0};
  const Road road = plain_road_of(build_network(network_of({path})).map, "1");
  EXPECT_NEAR(roadquery::evaluate(road.lane_offset, 100.0), 3.5, 0.01) << "the right edge of lane 1";
}

/// Largest step of the edges of linked lanes at joints of roads.
double largest_edge_step_m(const roadquery::RoadMap& map) {
  const auto edges = [](const Road& road, bool at_end) {
    const double s = at_end ? road.length : 0.0;
    std::map<int, double> outer;
    for (const auto* side : {&road.sections.front().left, &road.sections.front().right}) {
      double t = roadquery::evaluate(road.lane_offset, s);
      for (const roadquery::Lane& lane : *side)
        outer[lane.id] = t += (lane.id > 0 ? 1.0 : -1.0) * roadquery::lane_width(lane, s);
    }
    return outer;
  };
  double step_m = 0.0;
  for (const Road& road : map.roads) {
    if (road.successor.kind != roadquery::LinkKind::road) continue;
    const Road& next = *road_by_id(map, road.successor.id);
    const bool next_end = road.successor.contact == roadquery::ContactPoint::end;
    const std::map<int, double> a = edges(road, true), b = edges(next, next_end);
    if (next_end) continue;
    for (const auto* side : {&road.sections.front().left, &road.sections.front().right})
      for (const roadquery::Lane& lane : *side)
        if (lane.successor) step_m = std::max(step_m, std::abs(a.at(lane.id) - b.at(*lane.successor)));
  }
  return step_m;
}

TEST(LaneWidths, no_lane_steps_sideways_where_roads_of_other_widths_meet) {
  std::mt19937 dice(7);  // NOLINT: the same roads every time
  const std::vector<std::string> lists{"3.5|3|2.5", "2.5|3|3.5", "", "3.5||3", "3|3|3"};
  for (int round = 0; round < 20; ++round) {
    std::vector<RoadPath> paths;
    for (int i = 0; i < 4; ++i) {
      RoadPath path = three_lanes(i + 1, 200.0 * i, 9.0, lists[dice() % lists.size()]);
      if (dice() % 3 == 0) {  // a lane ends or opens
        path.lanes = path.lanes_forward = 2;
        path.widths_forward = path.widths_forward.empty() ? "" : "5|4";
      }
      paths.push_back(path);
    }
    const NetworkResult result = build_network(network_of(paths));
    expect_sound(result.map);
    EXPECT_LT(largest_edge_step_m(result.map), 1e-6) << "round " << round;
  }
}

TEST(LaneWidths, equal_lanes_are_written_as_without_the_tag) {
  const auto lanes_of = [](const std::string& widths) {
    return plain_road_of(
               build_network(network_of({three_lanes(1, 0.0, 9.0, widths), three_lanes(2, 200.0, 9.0, widths)})).map,
               "1")
        .sections[0]
        .right;
  };
  const auto with = lanes_of("3|3|3"), without = lanes_of("");
  ASSERT_EQ(with.size(), without.size());
  for (std::size_t i = 0; i < with.size(); ++i) {
    ASSERT_EQ(with[i].width.size(), without[i].width.size()) << "no taper where nothing changes";
    EXPECT_NEAR(with[i].width[0].a, without[i].width[0].a, 1e-12);
  }
}

TEST(LaneWidths, connecting_roads_have_the_widths_of_their_lanes) {
  RoadPath west = three_lanes(1, -200.0, 9.0, "3.5|3|2.5");
  west.nodes.back().osm_node = 9;
  RoadPath east = three_lanes(3, 0.0, 9.0, "3.5|3|2.5");
  east.nodes.front().osm_node = 9;
  const RoadPath side = make_path({{0, 0}, {0, 100}}, {9, 6}, {.osm_id = 5, .width_m = 6.0});
  const NetworkResult result = build_network(network_of({west, east, side}));
  expect_sound(result.map);
  int checked = 0;
  for (const Road* road : connecting_roads(result.map)) {
    const Road& from = *road_by_id(result.map, road->predecessor.id);
    for (const roadquery::Lane& lane : road->sections[0].right) {
      if (!lane.predecessor || *lane.predecessor > 0 || from.osm_id != "1") continue;
      const roadquery::Lane& before = from.sections[0].right[static_cast<std::size_t>(-*lane.predecessor - 1)];
      EXPECT_NEAR(roadquery::lane_width(lane, 0.0), roadquery::lane_width(before, from.length), 1e-6);
      ++checked;
    }
  }
  EXPECT_GE(checked, 4);
}

}  // namespace
}  // namespace orthodrive
