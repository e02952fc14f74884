// SPDX-License-Identifier: Apache-2.0
#include "roadquery/roads/bare_roads.hpp"

#include <gtest/gtest.h>

#include "roadquery/query/road_query.hpp"

namespace roadquery {
namespace {

Road reference_line(int id, double y) {
  Road road;
  road.id = id;
  road.length = 100.0;
  road.plan = {{0.0, 0.0, y, 0.0, 100.0, Line{}}};
  road.elevation = {{0.0, 5.0, 0.1, 0.0, 0.0}};
  road.superelevation = {{0.0, 0.0, 0.0, 0.0, 0.0}};
  road.sections = {{}, {50.0, {}, {}, {}}};
  return road;
}

TEST(BareRoads, get_the_extruded_profile_of_their_reference_line) {
  RoadMap map;
  map.roads = {reference_line(1, 0.0), reference_line(2, 50.0)};
  map.roads[1].sections[1].right = {Lane{-1, LaneType::driving, {{0.0, 3.0, 0.0, 0.0, 0.0}}, {}, {}, {}, {}, {}}};
  EXPECT_EQ(widen_bare_roads(map, 8.0), std::vector<std::size_t>{0});
  EXPECT_TRUE(map.roads[1].sections[0].left.empty());  // has a lane somewhere: as it was
  EXPECT_TRUE(widen_bare_roads(map, 8.0).empty());
  const RoadQuery query(map);
  for (const double s : {0.5, 49.0, 51.0, 99.0}) {
    for (const double t : {-3.9, 0.1, 3.9}) {
      Cursor cursor;
      EXPECT_NEAR(query.find_height(s, t, 10.0, cursor).value_or(-1.0), 5.0 + 0.1 * s, 1e-3) << s << ' ' << t;
    }
    Cursor cursor;
    EXPECT_FALSE(query.find_height(s, 4.1, 10.0, cursor).has_value());
  }
}

}  // namespace
}  // namespace roadquery
