// SPDX-License-Identifier: Apache-2.0
// Dual carriageways of maps without the tag `oneway`.

#include "orthodrive/network/topology/carriageways.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "network_support.hpp"
#include "orthodrive/geo/crs.hpp"
#include "orthodrive/io/support/vector_io.hpp"
#include "paths.hpp"

namespace orthodrive::network_test {
namespace {

using network::assume_carriageways;

RoadPath street(std::int64_t osm_id, const std::vector<Vec2>& corners, const std::vector<std::int64_t>& ids,
                const std::string& highway = "tertiary") {
  RoadPath path = make_path(corners, ids, {.osm_id = osm_id, .highway = highway});
  path.name = "Storgatan";
  return path;
}

/// A road from the west that parts into a southern (2) and a northern (3, 4) carriageway, which meet again.
RoadNetwork parted(const std::string& highway = "tertiary") {
  return network_of({street(1, {{0, 0}, {100, 0}}, {1, 2}, highway),
                     street(2, {{100, 0}, {130, -8}, {370, -8}, {400, 0}}, {2, 0, 0, 3}, highway),
                     street(3, {{100, 0}, {130, 8}, {250, 8}}, {2, 0, 4}, highway),
                     street(4, {{400, 0}, {370, 8}, {250, 8}}, {3, 0, 4}, highway),
                     street(5, {{400, 0}, {500, 0}}, {3, 5}, highway),
                     make_path({{250, 8}, {250, 90}}, {4, 6}, {.osm_id = 6})});
}

/// Whether a way is one-way, and then whether towards the east.
std::string driven(const RoadPath& path) {
  if (path.oneway == Oneway::no) return "both";
  return path.nodes.back().p.x > path.nodes.front().p.x ? "east" : "west";
}

TEST(Carriageways, side_by_side_are_driven_as_the_side_of_the_traffic_has_it) {
  for (const DrivingSide side : {DrivingSide::right, DrivingSide::left}) {
    Findings findings;
    const RoadNetwork roads = assume_carriageways(parted(), side, findings);
    const bool right = side == DrivingSide::right;
    EXPECT_EQ(driven(roads.paths[0]), "both");
    EXPECT_EQ(driven(roads.paths[1]), right ? "east" : "west");
    EXPECT_EQ(driven(roads.paths[2]), right ? "west" : "east");
    EXPECT_EQ(driven(roads.paths[3]), right ? "west" : "east");
    EXPECT_EQ(driven(roads.paths[4]), "both");
    EXPECT_EQ(driven(roads.paths[5]), "both");
    ASSERT_EQ(findings.size(), 3u);
    for (const Finding& finding : findings) EXPECT_EQ(finding.code, "network.carriageway_assumed");
  }
}

TEST(Carriageways, are_assumed_on_the_way_to_a_network_but_not_in_a_map_with_tags) {
  const auto assumed = [](const RoadNetwork& roads) {
    const NetworkResult result = build_network(roads);
    expect_sound(result.map);
    return std::ranges::count(result.findings, "network.carriageway_assumed", &Finding::code);
  };
  RoadNetwork roads = parted();
  EXPECT_EQ(assumed(roads), 3);
  roads.paths.push_back(make_path({{0, 300}, {90, 300}}, {21, 22}, {.osm_id = 9, .oneway = Oneway::forward}));
  EXPECT_EQ(assumed(roads), 0);
}

TEST(Carriageways, are_of_one_class_and_name_and_no_side_streets) {
  const auto assumed = [](const RoadNetwork& roads) {
    Findings findings;
    (void)assume_carriageways(roads, DrivingSide::right, findings);
    return findings.size();
  };
  EXPECT_EQ(assumed(parted("residential")), 0u);
  RoadNetwork named = parted();
  named.paths[1].name = "Lillgatan";
  EXPECT_EQ(assumed(named), 0u);
  RoadNetwork classes = parted();
  classes.paths[1].highway = "secondary";
  EXPECT_EQ(assumed(classes), 0u);
  RoadNetwork apart = parted();  // 35 m
  for (RoadNode& node : apart.paths[1].nodes) node.p.y -= node.p.y < site_origin.y - 7.0 ? 19.0 : 0.0;
  EXPECT_EQ(assumed(apart), 0u);
}

TEST(Carriageways, are_not_the_two_sides_of_a_hairpin) {
  std::vector<Vec2> bend = circle_points({300, 10}, 10.0, -0.5 * 3.14159265, 3.14159265);
  const RoadNetwork hairpin =
      network_of({street(1, {{0, 0}, {300, 0}}, {1, 2}), street(2, bend, std::vector<std::int64_t>(bend.size(), 0)),
                  street(3, {{300, 20}, {0, 20}}, {3, 4})});
  RoadNetwork roads = hairpin;
  roads.paths[1].nodes.front().osm_node = 2, roads.paths[1].nodes.back().osm_node = 3;
  Findings findings;
  (void)assume_carriageways(roads, DrivingSide::right, findings);
  EXPECT_TRUE(findings.empty());
}

TEST(Carriageways, from_whose_end_nothing_would_lead_stay_two_way) {
  // Two pairs: the one ends where the other begins, and who drives on the right comes to that place from both.
  const RoadNetwork roads =
      network_of({street(1, {{-300, 0}, {0, 0}}, {1, 2}), street(2, {{-300, 10}, {-20, 10}}, {3, 4}),
                  street(3, {{0, 0}, {300, 0}}, {2, 5}), street(4, {{20, -10}, {300, -10}}, {6, 7})});
  Findings findings;
  const RoadNetwork result = assume_carriageways(roads, DrivingSide::right, findings);
  EXPECT_EQ(driven(result.paths[0]), "both");
  EXPECT_EQ(driven(result.paths[1]), "west");
  EXPECT_EQ(driven(result.paths[2]), "both");
  EXPECT_EQ(driven(result.paths[3]), "east");
}

TEST(Carriageways, of_a_real_town_are_guessed_as_its_tags_say) {
  const std::filesystem::path osm = paths::in_source("..") / "shared/data/pardubice/roads.osm";
  if (!std::filesystem::exists(osm)) GTEST_SKIP() << "NOT TESTED: no " << osm;
  SiteFrame site{{"EPSG:32633"}, {}};
  const CoordinateTransform from_lonlat({"EPSG:4326"}, site.crs);
  for (const Vec2 p : {Vec2{15.7, 50.0}, {15.8, 50.0}, {15.8, 50.1}, {15.7, 50.1}})
    site.area.outer.push_back(from_lonlat.target_from_source(p));
  const RoadNetwork tagged = io::read_osm_roads(osm, site);
  RoadNetwork lost = tagged;
  for (RoadPath& path : lost.paths)
    if (!path.roundabout) path.oneway = Oneway::no;
  Findings findings;
  const RoadNetwork guessed = assume_carriageways(lost, DrivingSide::right, findings);
  double right_m = 0.0, wrong_way_m = 0.0, two_way_m = 0.0, missed_m = 0.0;
  for (std::size_t i = 0; i < tagged.paths.size(); ++i) {
    const RoadPath &truth = tagged.paths[i], &guess = guessed.paths[i];
    if (truth.roundabout || road_rank(truth.highway) < road_rank("tertiary")) continue;
    const double length = length_m(centerline(truth));
    const bool same_way = guess.nodes.front().p == truth.nodes.front().p;
    if (guess.oneway == Oneway::no)
      missed_m += truth.oneway == Oneway::no ? 0.0 : length;
    else if (truth.oneway == Oneway::no)
      two_way_m += length;
    else
      (same_way ? right_m : wrong_way_m) += length;
  }
  const double guessed_m = right_m + wrong_way_m + two_way_m;
  EXPECT_GT(right_m, 10000.0);
  EXPECT_LT(wrong_way_m + two_way_m, 0.01 * guessed_m) << wrong_way_m << " the wrong way, " << two_way_m << " two-way";
  EXPECT_LT(missed_m, 0.25 * (right_m + wrong_way_m + missed_m)) << "one-way streets alone cannot be seen";
}

}  // namespace
}  // namespace orthodrive::network_test
