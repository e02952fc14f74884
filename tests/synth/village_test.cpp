// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "orthodrive/core/error.hpp"
#include "orthodrive/model/rasters/sample_height.hpp"
#include "orthodrive/synth/ground/terrain.hpp"
#include "orthodrive/synth/plan/plan_presets.hpp"
#include "sanitized.hpp"
#include "synth/site_helpers.hpp"

namespace orthodrive {
namespace {

using namespace synth;

const SynthOptions small_village{.size_m = 300.0, .gsd_m = 0.5, .seed = 5};

const SynthSite& small_site() {
  static const SynthSite site = make_preset(Preset::village, small_village);
  return site;
}

std::map<std::int64_t, Polyline> osm_lines(const OsmData& osm) {
  std::map<std::int64_t, Vec2> places;
  for (const OsmNode& node : osm.nodes) places.emplace(node.id, node.p);
  std::map<std::int64_t, Polyline> lines;
  for (const OsmWay& way : osm.ways)
    for (const std::int64_t id : way.nodes) lines[way.id].push_back(places.at(id));
  return lines;
}

TEST(Village, same_seed_same_bytes_for_any_thread_count) {
  SynthOptions options = small_village;
  options.threads = 1;
  const std::string one = fingerprint(make_preset(Preset::village, options));
  options.threads = 2;
  EXPECT_EQ(fingerprint(make_preset(Preset::village, options)), one);
  EXPECT_EQ(fingerprint(small_site()), one);
}

TEST(Village, another_seed_is_another_village) {
  SynthOptions options = small_village;
  options.seed = 6;
  EXPECT_NE(fingerprint(make_preset(Preset::village, options)), fingerprint(small_site()));
}

TEST(Village, refuses_sizes_it_cannot_fill) {
  EXPECT_THROW((void)make_preset(Preset::village, {.size_m = 100.0}), OptionError);
  EXPECT_THROW((void)make_preset(Preset::village, {.size_m = 305.0}), OptionError);
  EXPECT_THROW((void)make_preset(Preset::village, {.size_m = 300.0, .gsd_m = 0.0}), OptionError);
  const SynthOptions wrong{.size_m = 300.0, .osm_offset_min_m = 3.0, .osm_offset_max_m = 2.0};
  EXPECT_THROW((void)make_preset(Preset::village, wrong), OptionError);
}

class Plans : public testing::TestWithParam<std::tuple<double, int>> {
 protected:
  const Planned& made =
      planned(plan_village, std::get<0>(GetParam()), static_cast<std::uint64_t>(std::get<1>(GetParam())));
  const SitePlan& plan = made.plan;
};
INSTANTIATE_TEST_SUITE_P(SizesAndSeeds, Plans,
                         testing::Combine(testing::Values(200.0, 300.0, 1000.0), testing::Range(1, sanitized ? 2 : 6)));

TEST_P(Plans, roads_are_curvature_continuous_and_the_circuit_closes) {
  for (const PlannedRoad& road : plan.roads) expect_continuous(road);
  EXPECT_TRUE(plan.roads[circuit_of(plan)].alignment.closed);
  const double length_m = plan.roads[circuit_of(plan)].alignment.length_m;
  EXPECT_GT(length_m, 1.5 * plan.size_m);
  EXPECT_LT(length_m, 2.5 * plan.size_m);
}

TEST_P(Plans, has_a_bridge_a_crossing_and_tees_and_all_roads_connect) {
  EXPECT_EQ(plan.bridges.size(), 1u);
  std::size_t tees = 0, crossings = 0;
  for (const PlannedJunction& junction : plan.junctions) {
    std::size_t ends = 0;
    for (const PlannedJunction::Arm& arm : junction.arms) {
      const Alignment& a = plan.roads[arm.road].alignment;
      ends += !a.closed && (arm.s_m < 1e-6 || arm.s_m > a.length_m - 1e-6) ? 1 : 0;
    }
    (ends > 0 ? tees : crossings) += 1;
  }
  EXPECT_GE(tees, 5u);
  EXPECT_GE(crossings, 2u);
  EXPECT_EQ(expect_arms_meet(plan), 1u);
}

TEST_P(Plans, heights_are_smooth_agree_at_junctions_and_clear_the_bridge) {
  const Terrain& terrain = made.terrain;
  for (std::size_t r = 0; r < plan.roads.size(); ++r) {
    const Profile& profile = terrain.profiles[r];
    const double length_m = plan.roads[r].alignment.length_m;
    for (double s = 0.5; s < length_m; s += 0.5) {
      ASSERT_LE(std::abs(profile.gradient(s)), 0.12) << plan.roads[r].name << " at " << s;
      ASSERT_NEAR((profile.z(s) - profile.z(s - 0.5)) / 0.5, profile.gradient(s - 0.25), 1e-3)
          << plan.roads[r].name << " at " << s;
    }
    if (plan.roads[r].alignment.closed) {
      EXPECT_NEAR(profile.z(0.0), profile.z(length_m), 1e-9);
      EXPECT_NEAR(profile.gradient(0.0), profile.gradient(length_m), 1e-6);
    }
  }
  for (const PlannedJunction& junction : plan.junctions)
    for (const PlannedJunction::Arm& arm : junction.arms)
      EXPECT_NEAR(terrain.profiles[arm.road].z(arm.s_m),
                  terrain.profiles[junction.arms[0].road].z(junction.arms[0].s_m), 1e-6);
  for (const PlannedBridge& bridge : plan.bridges)
    EXPECT_NEAR(terrain.profiles[bridge.over].z(bridge.s_over_m) -
                    terrain.profiles[bridge.under[0].road].z(bridge.under[0].s_m),
                bridge_rise_m, 0.05);
}

TEST(Village, osm_lies_one_to_four_metres_from_the_truth) {
  for (const std::uint64_t seed : {5, 6, 7}) {
    SynthOptions options = small_village;
    options.seed = seed, options.size_m = 600.0, options.gsd_m = 2.0;
    const SynthSite site = make_preset(Preset::village, options);
    const auto lines = osm_lines(site.osm);
    double sum = 0.0, most = 0.0, nodes = 0.0;
    for (const RoadPath& path : site.roads.paths)
      for (const RoadNode& node : path.nodes) {
        const double off = std::abs(node.offset_m);
        EXPECT_LE(off, project_onto(lines.at(path.osm_id), node.p).distance_m + 1e-9);
        sum += off, most = std::max(most, off), ++nodes;
      }
    EXPECT_GT(sum / nodes, 1.0) << "seed " << seed;
    EXPECT_LT(sum / nodes, 3.0) << "seed " << seed;
    EXPECT_LE(most, 4.0) << "seed " << seed;
  }
}

TEST(Village, without_offsets_osm_lies_on_the_truth) {
  SynthOptions options = small_village;
  options.osm_offset_min_m = options.osm_offset_max_m = 0.0;
  const SynthSite site = make_preset(Preset::village, options);
  for (const RoadPath& path : site.roads.paths)
    for (const RoadNode& node : path.nodes)
      EXPECT_LT(std::abs(node.offset_m), 0.6) << path.name;  // chords of bends only
}

TEST(Village, ways_that_meet_share_a_node) {
  const SynthSite& site = small_site();
  std::map<std::int64_t, std::set<std::int64_t>> ways_of_node;
  for (const OsmWay& way : site.osm.ways)
    if (way.tags.contains("highway"))
      for (const std::int64_t id : way.nodes) ways_of_node[id].insert(way.id);
  std::size_t shared = 0;
  for (const RoadPath& path : site.roads.paths)
    for (const RoadNode& node : path.nodes) {
      if (node.osm_node == 0) continue;
      ASSERT_TRUE(ways_of_node.contains(node.osm_node));
      EXPECT_TRUE(ways_of_node.at(node.osm_node).contains(path.osm_id));
      shared += ways_of_node.at(node.osm_node).size() > 1 ? 1 : 0;
    }
  EXPECT_GE(shared, 12u);
}

TEST(Village, osm_has_the_tags_that_later_stages_read) {
  const SynthSite& site = small_site();
  std::map<std::string, int> count;
  for (const OsmWay& way : site.osm.ways) {
    for (const auto& [key, value] : way.tags) ++count[key];
    if (way.tags.contains("name") && way.tags.at("name") == site.route_name) {
      EXPECT_EQ(way.nodes.front(), way.nodes.back());
    }
    if (way.tags.contains("bridge")) {
      EXPECT_EQ(way.tags.at("layer"), "1");
    }
  }
  EXPECT_EQ(count["bridge"], 1);
  EXPECT_EQ(count["oneway"], 1);
  EXPECT_EQ(count["amenity"], 1);
  EXPECT_GE(count["building"], 3);
  EXPECT_LT(count["width"], count["highway"] / 2);
}

TEST(Village, surfaces_are_as_wide_as_the_roads) {
  const SynthSite& site = small_site();
  ASSERT_EQ(site.surfaces.size(), site.roads.paths.size());
  for (std::size_t i = 0; i < site.surfaces.size(); ++i) {
    const RoadPath& path = site.roads.paths[i];
    EXPECT_EQ(site.surfaces[i].osm_id, path.osm_id);
    // Pappus: the area of a strip is its width times the length of its middle line, bends or not.
    EXPECT_NEAR(area_m2(site.surfaces[i].polygon) / path.nodes.back().s_m, path.nodes[0].width_m, 0.02) << path.name;
    EXPECT_GT(site.surfaces[i].visibility, 0.2) << path.name;
    EXPECT_LE(site.surfaces[i].visibility, 1.0);
    EXPECT_NE(path.nodes[0].width_m, default_width_m(path.highway, 0, path.oneway));
  }
}

TEST(Village, centre_lines_lie_on_road_or_are_hidden) {
  const SynthSite& site = small_site();
  enum : std::uint8_t { road = 1, building = 3, vegetation = 4 };
  std::size_t on_road = 0, hidden = 0;
  Vec2 deck;
  for (const RoadPath& path : site.roads.paths)
    if (path.bridge) deck = path.nodes[path.nodes.size() / 2].p;
  for (const RoadPath& path : site.roads.paths)
    for (const RoadNode& node : path.nodes) {
      if (!path.bridge && distance(node.p, deck) < 10.0) continue;  // below the parapets
      const Vec2 q = site.labels.frame.pixel_from_world(node.p);
      const int col = static_cast<int>(q.x), row = static_cast<int>(q.y);
      if (!site.labels.labels.inside(col, row)) continue;
      const std::uint8_t label = site.labels.labels.at(col, row);
      ASSERT_TRUE(label == road || label == vegetation) << path.name << " label " << int(label);
      ++(label == road ? on_road : hidden);
    }
  EXPECT_GT(on_road, 8 * hidden);
  EXPECT_GT(hidden, 0u);  // some crowns hide the road: that is what refinement has to live with
}

TEST(Village, bare_earth_holds_the_road_beds_and_the_road_below_the_bridge) {
  const SynthSite& site = small_site();
  std::size_t compared = 0;
  const RoadPath* deck = nullptr;
  for (const RoadPath& path : site.roads.paths) {
    if (path.bridge) {
      deck = &path;
      continue;
    }
    if (path.name != site.route_name && path.highway != "secondary") continue;  // others give way at junctions
    for (const RoadNode& node : path.nodes) {
      EXPECT_NEAR(sample_bilinear(site.true_dtm, node.p), node.z_m, 0.05) << path.name << " at " << node.s_m;
      ++compared;
    }
  }
  EXPECT_GT(compared, 300u);
  ASSERT_NE(deck, nullptr);
  const RoadNode& middle = deck->nodes[deck->nodes.size() / 2];
  EXPECT_GT(middle.z_m - sample_bilinear(site.true_dtm, middle.p), 4.5);
}

TEST(Village, terrain_models_have_the_stated_noise) {
  const SynthSite& site = small_site();
  const auto& truth = site.true_dtm.height_m.data;
  const auto& noisy = site.dtm_1m.height_m.data;
  double square = 0.0;
  for (std::size_t i = 0; i < truth.size(); ++i) square += (truth[i] - noisy[i]) * (truth[i] - noisy[i]);
  EXPECT_NEAR(std::sqrt(square / static_cast<double>(truth.size())), small_village.dtm_1m_sigma_m, 0.002);
  EXPECT_EQ(site.dtm_10m.frame.gsd_m, 10.0);
  EXPECT_EQ(site.dtm_10m.frame.bounds(), site.true_dtm.frame.bounds());
}

TEST(Village, truth_is_consistent_along_the_roads) {
  for (const RoadPath& path : small_site().roads.paths)
    for (std::size_t i = 1; i < path.nodes.size(); ++i) {
      const RoadNode &a = path.nodes[i - 1], &b = path.nodes[i];
      const double ds = b.s_m - a.s_m;
      ASSERT_GT(ds, 0.0);
      ASSERT_LT(ds, 2.0);
      EXPECT_NEAR(distance(a.p, b.p), ds, 0.01);
      EXPECT_NEAR((b.z_m - a.z_m) / ds, 0.5 * (a.gradient + b.gradient), 2e-3);
      EXPECT_LE(std::abs(b.banking), 0.05);
      EXPECT_LT(std::abs(b.banking - a.banking), 0.02);
    }
}

TEST(Village, the_outer_side_of_a_bend_is_higher) {
  const PlannedRoad road{.highway = "tertiary", .width_m = 6.0};
  EXPECT_LT(banking_rad(road, 0.02), 0.0);  // left turn: right side higher
  EXPECT_GT(banking_rad(road, -0.02), 0.0);
  EXPECT_EQ(banking_rad(road, 0.0), 0.0);
}

}  // namespace
}  // namespace orthodrive
