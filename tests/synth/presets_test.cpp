// SPDX-License-Identifier: Apache-2.0
// The circuit and the motorway junction: what must hold for every seed, and small painted sites.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "orthodrive/core/error.hpp"
#include "orthodrive/model/rasters/sample_height.hpp"
#include "orthodrive/synth/ground/terrain.hpp"
#include "orthodrive/synth/plan/plan_presets.hpp"
#include "sanitized.hpp"
#include "synth/site_helpers.hpp"

namespace orthodrive::synth {
namespace {

constexpr double least_clearance_m = 4.7;

/// Where a point lies beside a road.
struct Beside {
  double s_m = 0.0, offset_m = 0.0, distance_m = 0.0;
};
Beside beside(const Alignment& a, Vec2 p) {
  const double s = std::clamp(nearest_s(a, p), 0.0, a.length_m);
  const AlignmentPoint q = evaluate(a, s);
  return {s, cross({std::cos(q.heading_rad), std::sin(q.heading_rad)}, p - q.p), distance(p, q.p)};
}

double surface_z(const SitePlan& plan, const Terrain& terrain, std::size_t road, double s, double offset_m) {
  const double k = design_curvature_1pm(plan.roads[road].alignment, s);
  return terrain.profiles[road].z(s) + offset_m * std::tan(banking_rad(plan.roads[road], k));
}

/// Least height of the deck over the surface of the roads below it.
double clearance_m(const SitePlan& plan, const Terrain& terrain, const PlannedBridge& bridge) {
  double least = 1e9;
  const PlannedRoad& over = plan.roads[bridge.over];
  for (double s = bridge.s_over_m - bridge.half_length_m; s <= bridge.s_over_m + bridge.half_length_m; s += 1.0)
    for (const double side : {-0.5, 0.0, 0.5}) {
      const AlignmentPoint q = evaluate(over.alignment, s);
      const double offset_m = side * over.width_m;
      const Vec2 p = q.p + Vec2{-std::sin(q.heading_rad), std::cos(q.heading_rad)} * offset_m;
      for (const PlannedBridge::Below& below : bridge.under) {
        const Beside b = beside(plan.roads[below.road].alignment, p);
        if (b.distance_m > 0.5 * plan.roads[below.road].width_m) continue;
        least = std::min(least, surface_z(plan, terrain, bridge.over, s, offset_m) -
                                    surface_z(plan, terrain, below.road, b.s_m, b.offset_m));
      }
    }
  return least;
}

void expect_smooth_heights(const SitePlan& plan, const Terrain& terrain, double steepest) {
  for (std::size_t r = 0; r < plan.roads.size(); ++r)
    for (double s = 0.5; s < plan.roads[r].alignment.length_m; s += 1.0)
      ASSERT_LE(std::abs(terrain.profiles[r].gradient(s)), steepest) << "road " << r << " at " << s;
  for (const PlannedJunction& junction : plan.junctions)
    for (const PlannedJunction::Arm& arm : junction.arms)
      EXPECT_NEAR(terrain.profiles[arm.road].z(arm.s_m),
                  terrain.profiles[junction.arms[0].road].z(junction.arms[0].s_m), 1e-6);
}

/// Where a road's surface overlaps the one that it joins at a small angle, both have the same height.
void expect_ties_hold(const SitePlan& plan, const Terrain& terrain) {
  for (const PlannedTie& tie : plan.ties) {
    if (!tie.on_surface) continue;
    EXPECT_GT(tie.s_end_m - tie.s_begin_m, 20.0);
    for (double s = tie.s_begin_m; s <= tie.s_end_m; s += 1.0) {
      const Beside b = beside(plan.roads[tie.main].alignment, evaluate(plan.roads[tie.road].alignment, s).p);
      EXPECT_NEAR(terrain.profiles[tie.road].z(s), surface_z(plan, terrain, tie.main, b.s_m, b.offset_m), 0.05)
          << "road " << tie.road << " at " << s;
    }
  }
}

struct PlanCase {
  double size_m = 0.0;
  std::uint64_t seed = 0;
};
const std::vector<PlanCase> plan_cases = unless_sanitized<PlanCase>(
    {{500.0, 1}, {500.0, 2}, {500.0, 3}, {500.0, 4}, {1000.0, 5}, {1000.0, 6}, {1000.0, 7}, {1200.0, 8}}, 5);

class CircuitPlans : public testing::TestWithParam<PlanCase> {
 protected:
  const SitePlan& plan = planned(plan_circuit, GetParam().size_m, GetParam().seed).plan;
  const Terrain& terrain = planned(plan_circuit, GetParam().size_m, GetParam().seed).terrain;
};
INSTANTIATE_TEST_SUITE_P(SizesAndSeeds, CircuitPlans, testing::ValuesIn(plan_cases));

TEST_P(CircuitPlans, roads_are_curvature_continuous_and_meet) {
  for (const PlannedRoad& road : plan.roads) expect_continuous(road);
  EXPECT_EQ(expect_arms_meet(plan), 1u);
  expect_apart(plan);
}

TEST_P(CircuitPlans, track_is_a_closed_raceway_of_two_to_four_kilometres_a_square_kilometre) {
  const PlannedRoad& track = plan.roads[circuit_of(plan)];
  EXPECT_EQ(track.highway, "raceway");
  EXPECT_TRUE(track.alignment.closed);
  EXPECT_GT(track.alignment.length_m, 2.0 * plan.size_m);
  EXPECT_LT(track.alignment.length_m, 3.6 * plan.size_m);
  EXPECT_GE(track.width_m, 10.0);
  EXPECT_LE(track.width_m, 14.0);
}

TEST_P(CircuitPlans, access_road_clears_the_track_and_heights_are_smooth) {
  ASSERT_EQ(plan.bridges.size(), 1u);
  EXPECT_EQ(plan.bridges[0].under[0].road, circuit_of(plan));
  EXPECT_GT(clearance_m(plan, terrain, plan.bridges[0]), least_clearance_m);
  expect_smooth_heights(plan, terrain, 0.13);
  expect_ties_hold(plan, terrain);
}

TEST_P(CircuitPlans, buildings_stand_beside_the_roads) {
  for (std::uint64_t seed = GetParam().seed; seed < GetParam().seed + 40; seed += 8) {
    const SitePlan other = plan_circuit(GetParam().size_m, seed);
    EXPECT_GE(other.buildings.size(), 2u);
    for (const House& house : other.buildings) {
      const Ring corners = rectangle(house.center, house.heading_rad, house.half_length_m, house.half_width_m);
      for (const PlannedRoad& road : other.roads)
        for (const Vec2 p : sample(road.alignment, 2.0)) {
          EXPECT_FALSE(contains(Polygon{corners, {}}, p)) << "seed " << seed << ", " << road.highway;
          for (const Vec2 c : corners) ASSERT_GT(distance(p, c), 0.5 * road.width_m + 1.0) << "seed " << seed;
        }
    }
  }
}

TEST_P(CircuitPlans, pit_lane_leaves_and_joins_the_straight_the_way_the_track_runs) {
  const Alignment &track = plan.roads[circuit_of(plan)].alignment, &pit = plan.roads[1].alignment;
  for (const double s : {0.0, pit.length_m}) {
    const AlignmentPoint q = evaluate(pit, s);
    const Beside b = beside(track, q.p);
    EXPECT_LT(b.distance_m, 1e-6);
    EXPECT_LT(std::abs(std::remainder(q.heading_rad - evaluate(track, b.s_m).heading_rad, 6.283185307)), 0.45);
  }
  const Beside middle = beside(track, evaluate(pit, 0.5 * pit.length_m).p);
  EXPECT_GT(middle.distance_m, 0.5 * (plan.roads[0].width_m + plan.roads[1].width_m) + 5.0);
}

class JunctionPlans : public testing::TestWithParam<PlanCase> {
 protected:
  const SitePlan& plan = planned(plan_junction, GetParam().size_m, GetParam().seed).plan;
  const Terrain& terrain = planned(plan_junction, GetParam().size_m, GetParam().seed).terrain;
};
INSTANTIATE_TEST_SUITE_P(SizesAndSeeds, JunctionPlans, testing::ValuesIn(plan_cases));

TEST_P(JunctionPlans, roads_are_curvature_continuous_and_meet) {
  for (const PlannedRoad& road : plan.roads) expect_continuous(road);
  EXPECT_EQ(expect_arms_meet(plan), 1u);
  expect_apart(plan);
}

TEST_P(JunctionPlans, carriageways_run_against_each_other_and_never_overlap) {
  const PlannedRoad &a = plan.roads[0], &b = plan.roads[1];
  for (double s = 0.0; s < a.alignment.length_m; s += 5.0) {
    const AlignmentPoint q = evaluate(a.alignment, s);
    const Beside other = beside(b.alignment, q.p);
    if (other.s_m < 20.0 || other.s_m > b.alignment.length_m - 20.0) continue;  // ends
    EXPECT_GT(other.distance_m, 0.5 * (a.width_m + b.width_m) + 3.0);           // a median of 3 m at least
    EXPECT_LT(other.distance_m, 0.5 * (a.width_m + b.width_m) + 7.0);
    EXPECT_GT(other.offset_m, 0.0);  // traffic keeps right: the other carriageway has us on its left
    EXPECT_LT(std::cos(q.heading_rad - evaluate(b.alignment, other.s_m).heading_rad), -0.99);
  }
}

TEST_P(JunctionPlans, bridge_clears_both_carriageways_and_heights_are_smooth) {
  ASSERT_EQ(plan.bridges.size(), 1u);
  EXPECT_EQ(plan.bridges[0].under.size(), 2u);
  EXPECT_GT(clearance_m(plan, terrain, plan.bridges[0]), least_clearance_m);
  expect_smooth_heights(plan, terrain, 0.11);
  expect_ties_hold(plan, terrain);
}

TEST_P(JunctionPlans, slip_roads_join_at_small_angles_and_end_across) {
  std::size_t slips = 0, exits = 0;
  for (const PlannedRoad& slip : plan.roads) {
    if (slip.highway != "motorway_link") continue;
    ++slips;
    EXPECT_TRUE(slip.oneway);
    const double end_s = slip.alignment.length_m;
    const auto angle_to = [&](double s, const PlannedRoad& road) {
      const AlignmentPoint q = evaluate(slip.alignment, s);
      const Beside b = beside(road.alignment, q.p);
      return b.distance_m > 1e-6
                 ? 9.0
                 : std::abs(std::remainder(q.heading_rad - evaluate(road.alignment, b.s_m).heading_rad, 6.283185307));
    };
    double small = 9.0, large = 9.0;
    bool exit = false;
    for (const PlannedRoad& road : plan.roads)
      for (const double s : {0.0, end_s}) {
        const double angle = angle_to(s, road);
        if (road.highway == "motorway" && angle < 9.0) small = angle, exit = s == 0.0;
        if (road.highway == "secondary" && angle < 9.0) large = angle;
      }
    exits += exit ? 1 : 0;
    EXPECT_LT(small, 0.12);  // 7 degrees
    EXPECT_GT(large, 0.8);
    EXPECT_LT(large, 2.4);
  }
  EXPECT_EQ(slips, 4u);
  EXPECT_EQ(exits, 2u);
}

TEST(JunctionPlan, seeds_differ_in_heads_and_lanes) {
  std::size_t rings = 0, three_lanes = 0;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const SitePlan plan = plan_junction(500.0, seed);
    const auto count = std::count_if(plan.roads.begin(), plan.roads.end(), [](const auto& r) { return r.roundabout; });
    EXPECT_TRUE(count == 0 || count == 2);
    rings += count == 2 ? 1 : 0, three_lanes += plan.roads[0].lanes == 3 ? 1 : 0;
    EXPECT_GE(plan.roads[0].width_m, plan.roads[0].lanes * 3.75 + 2.0);
  }
  EXPECT_GT(rings, 0u);
  EXPECT_LT(rings, 8u);
  EXPECT_GT(three_lanes, 0u);
  EXPECT_LT(three_lanes, 8u);
}

struct SiteCase {
  Preset preset;
  std::uint64_t seed;
};
const SynthOptions small{.size_m = 500.0, .gsd_m = 0.5};

class PresetSites : public testing::TestWithParam<SiteCase> {
 protected:
  static const SynthSite& site() {
    static std::map<std::pair<int, std::uint64_t>, SynthSite> sites;
    const auto key = std::pair(static_cast<int>(GetParam().preset), GetParam().seed);
    if (!sites.contains(key)) {
      SynthOptions options = small;
      options.seed = GetParam().seed;
      sites.emplace(key, make_preset(GetParam().preset, options));
    }
    return sites.at(key);
  }
};
INSTANTIATE_TEST_SUITE_P(Small, PresetSites,
                         testing::Values(SiteCase{Preset::circuit, 1}, SiteCase{Preset::junction, 1},
                                         SiteCase{Preset::junction, 2}));

TEST_P(PresetSites, labels_agree_with_the_surfaces) {
  const Agreement agreement = compare_labels(site());
  EXPECT_LT(agreement.outside, 0.03);  // rounded corners
  EXPECT_LT(agreement.wrong, 0.01);    // parapets over the lower road
}

TEST_P(PresetSites, fast_roads_are_free_of_crowns) {
  for (const SynthSurface& surface : site().surfaces)
    if (surface.highway == "raceway" || surface.highway == "motorway" || surface.highway == "motorway_link") {
      EXPECT_GT(surface.visibility, 0.98) << surface.osm_id;  // what lacks are pixels of parapets
    }
}

TEST_P(PresetSites, bare_earth_is_the_road) {
  const SynthSite& s = site();
  std::size_t compared = 0;
  for (const RoadPath& path : s.roads.paths) {
    if (path.highway != "motorway" && path.name != "Circuit") continue;
    for (const RoadNode& node : path.nodes) {
      EXPECT_NEAR(sample_bilinear(s.true_dtm, node.p), node.z_m, 0.05) << path.osm_id << " at " << node.s_m;
      ++compared;
    }
  }
  EXPECT_GT(compared, 500u);
}

TEST(Presets, same_seed_same_bytes_for_any_thread_count) {
  if (sanitized) GTEST_SKIP() << runs_again;
  for (const Preset preset : {Preset::circuit, Preset::junction}) {
    SynthOptions options{.size_m = 500.0, .gsd_m = 2.0, .seed = 3, .threads = 1};
    const std::string one = fingerprint(make_preset(preset, options));
    options.threads = 3;
    EXPECT_EQ(fingerprint(make_preset(preset, options)), one);
    options.seed = 4;
    EXPECT_NE(fingerprint(make_preset(preset, options)), one);
  }
}

TEST(Presets, osm_has_the_tags_of_a_junction) {
  for (const std::uint64_t seed : unless_sanitized<std::uint64_t>({1, 2, 3, 4}, 4)) {
    const SynthSite site = make_preset(Preset::junction, {.size_m = 500.0, .gsd_m = 2.0, .seed = seed});
    std::map<std::string, int> count;
    for (const OsmWay& way : site.osm.ways) {
      const auto has = [&](const char* key, const std::string& value) {
        return way.tags.contains(key) && way.tags.at(key) == value;
      };
      if (has("highway", "motorway") || has("highway", "motorway_link")) {
        EXPECT_TRUE(has("oneway", "yes"));
        EXPECT_TRUE(way.tags.contains("lanes"));
        EXPECT_FALSE(way.tags.contains("bridge"));
      }
      if (has("bridge", "yes")) {
        EXPECT_TRUE(has("highway", "secondary"));
        EXPECT_TRUE(has("layer", "1"));
        ++count["bridge"];
      }
      if (has("junction", "roundabout")) {
        EXPECT_TRUE(has("oneway", "yes"));
        EXPECT_EQ(way.nodes.front(), way.nodes.back());
        ++count["roundabout"];
      }
    }
    EXPECT_EQ(count["bridge"], 1);
    EXPECT_TRUE(count["roundabout"] == 0 || count["roundabout"] == 2);
    const auto truth =
        std::count_if(site.roads.paths.begin(), site.roads.paths.end(), [](const auto& p) { return p.roundabout; });
    EXPECT_EQ(truth, count["roundabout"]);
    EXPECT_TRUE(site.route_name.empty());
  }
}

TEST(Presets, refuse_sizes_they_cannot_fill) {
  for (const Preset preset : {Preset::circuit, Preset::junction}) {
    EXPECT_THROW((void)make_preset(preset, {.size_m = 300.0}), OptionError);
    EXPECT_THROW((void)make_preset(preset, {.size_m = 1005.0}), OptionError);
  }
}

}  // namespace
}  // namespace orthodrive::synth
