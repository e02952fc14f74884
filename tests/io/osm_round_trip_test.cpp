// SPDX-License-Identifier: Apache-2.0
// What write_osm writes, read_osm reads.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/places.hpp"
#include "io/scratch.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/io/osm/osm_reader.hpp"
#include "orthodrive/io/osm/osm_writer.hpp"

namespace orthodrive {
namespace {

TEST(OsmRoundTrip, nodes_ways_and_tags_come_back_sorted_by_id) {
  const Scratch scratch;
  OsmData data{.crs = utm33};
  data.nodes = {{2, origin + Vec2{30.0, 40.0}}, {1, origin}};
  data.ways = {{.id = 9, .nodes = {1, 2, 1}, .tags = {{"highway", "track"}, {"name", "A <\"&'> B"}}},
               {.id = 4, .nodes = {2, 1}}};
  io::write_osm(scratch / "a.osm", data);
  const OsmData read = io::read_osm(scratch / "a.osm", utm33);
  ASSERT_EQ(read.nodes.size(), 2u);
  EXPECT_EQ(read.nodes[0].id, 1);
  EXPECT_NEAR(distance(read.nodes[1].p, origin + Vec2{30.0, 40.0}), 0.0, 0.01);
  ASSERT_EQ(read.ways.size(), 2u);
  EXPECT_EQ(read.ways[0].id, 4);
  EXPECT_EQ(read.ways[1].nodes, data.ways[0].nodes);
  EXPECT_EQ(read.ways[1].tags, data.ways[0].tags);
}

TEST(OsmRoundTrip, a_way_to_nowhere_is_refused) {
  const Scratch scratch;
  OsmData data{.crs = utm33};
  data.nodes = {{1, origin}};
  data.ways = {{.id = 9, .nodes = {1, 7}}};
  EXPECT_THROW(io::write_osm(scratch / "a.osm", data), Error);
  EXPECT_FALSE(std::filesystem::exists(scratch / "a.osm"));
}

}  // namespace
}  // namespace orthodrive
