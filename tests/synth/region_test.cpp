// SPDX-License-Identifier: Apache-2.0
// Regions: what the plan must hold for every size and seed, and a small one painted tile by tile.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "orthodrive/core/error.hpp"
#include "orthodrive/geo/spatial_index.hpp"
#include "orthodrive/model/rasters/sample_height.hpp"
#include "orthodrive/synth/ground/terrain.hpp"
#include "orthodrive/synth/make_region.hpp"
#include "orthodrive/synth/plan/plan_index.hpp"
#include "orthodrive/synth/plan/plan_presets.hpp"
#include "sanitized.hpp"
#include "synth/site_helpers.hpp"

namespace orthodrive::synth {
namespace {

std::size_t count_of(const SitePlan& plan, const std::string& highway) {
  return static_cast<std::size_t>(std::count_if(plan.roads.begin(), plan.roads.end(),
                                                [&](const PlannedRoad& road) { return road.highway == highway; }));
}

/// Kilometres of road, without the motorway and its links, a square kilometre of all towns.
double town_density(const SitePlan& plan) {
  double road_m = 0.0, square_m = 0.0;
  for (const Settlement& s : plan.settlements) square_m += s.town ? area_m2(s.outline) : 0.0;
  for (const PlannedRoad& road : plan.roads) {
    if (is_fast(road)) continue;
    constexpr double step_m = 5.0;
    for (double at = 0.5 * step_m; at < road.alignment.length_m; at += step_m) {
      const Vec2 p = evaluate(road.alignment, at).p;
      const bool in_town = std::any_of(plan.settlements.begin(), plan.settlements.end(),
                                       [&](const Settlement& s) { return s.town && contains(s.outline, p); });
      road_m += in_town ? step_m : 0.0;
    }
  }
  return 1e3 * road_m / square_m;
}

/// Least angle between roads that leave a junction, slip roads left out.
double sharpest_junction_rad(const SitePlan& plan) {
  double sharpest = 9.0;
  for (const PlannedJunction& junction : plan.junctions) {
    std::vector<Vec2> away;
    for (const PlannedJunction::Arm& arm : junction.arms) {
      const PlannedRoad& road = plan.roads[arm.road];
      if (road.highway == "motorway_link") continue;
      const double heading = evaluate(road.alignment, arm.s_m).heading_rad;
      const Vec2 along{std::cos(heading), std::sin(heading)};
      if (road.alignment.closed || arm.s_m < road.alignment.length_m - 1.0) away.push_back(along);
      if (road.alignment.closed || arm.s_m > 1.0) away.push_back(along * -1.0);
    }
    for (std::size_t i = 0; i < away.size(); ++i)
      for (std::size_t j = 0; j < i; ++j)
        sharpest = std::min(sharpest, std::abs(std::atan2(cross(away[i], away[j]), dot(away[i], away[j]))));
  }
  return sharpest;
}

/// Every crossing of two lines is a junction or lies under a deck.
void expect_crossings_known(const SitePlan& plan) {
  std::vector<Polyline> lines;
  lines.reserve(plan.roads.size());
  for (const PlannedRoad& road : plan.roads) lines.push_back(sample(road.alignment, 1.0));
  const SegmentIndex index(lines);
  const auto meet = [&](std::size_t a, std::size_t b, Vec2 p) {
    return std::any_of(plan.junctions.begin(), plan.junctions.end(), [&](const PlannedJunction& j) {
      const auto has = [&](std::size_t r) {
        return std::any_of(j.arms.begin(), j.arms.end(), [&](const auto& arm) { return arm.road == r; });
      };
      return distance(j.p, p) < 1.5 && has(a) && has(b);
    });
  };
  std::size_t crossings = 0;
  for (std::size_t a = 0; a < lines.size(); ++a)
    for (std::size_t i = 0; i + 1 < lines[a].size(); ++i) {
      const Vec2 p = lines[a][i], q = lines[a][i + 1];
      const Box2 box{std::min(p.x, q.x), std::min(p.y, q.y), std::max(p.x, q.x), std::max(p.y, q.y)};
      for (const SegmentIndex::Segment& s : index.touching(box)) {
        if (s.line <= a) continue;
        const Vec2 u = lines[s.line][s.index], v = lines[s.line][s.index + 1];
        if (cross(q - p, u - p) * cross(q - p, v - p) > 0.0 || cross(v - u, p - u) * cross(v - u, q - u) > 0.0)
          continue;
        const Vec2 at = (p + q) * 0.5;
        ++crossings;
        const bool bridged = std::any_of(plan.bridges.begin(), plan.bridges.end(), [&](const PlannedBridge& bridge) {
          return std::any_of(bridge.under.begin(), bridge.under.end(), [&](const auto& below) {
            const Vec2 deck = evaluate(plan.roads[below.road].alignment, below.s_m).p;
            return distance(deck, at) < 2.0 && std::set{bridge.over, below.road} == std::set<std::size_t>{a, s.line};
          });
        });
        ASSERT_TRUE(bridged || meet(a, s.line, at))
            << plan.roads[a].name << " and " << plan.roads[s.line].name << " at " << at.x << ' ' << at.y;
      }
    }
  EXPECT_GT(crossings, 20u);
}

double least_gap_of_junctions_m(const SitePlan& plan) {
  std::map<std::size_t, std::vector<double>> places;
  for (const PlannedJunction& junction : plan.junctions)
    for (const PlannedJunction::Arm& arm : junction.arms) places[arm.road].push_back(arm.s_m);
  double least = 1e9;
  for (auto& [road, s] : places) {
    if (plan.roads[road].roundabout) continue;
    std::sort(s.begin(), s.end());
    for (std::size_t i = 1; i < s.size(); ++i) least = std::min(least, s[i] - s[i - 1]);
  }
  return least;
}

struct RegionPlanCase {
  double size_m = 0.0;
  std::uint64_t seed = 0;
  SitePlan (*make)(double, std::uint64_t) = plan_region;
};
// Names of tests are made of it.
void PrintTo(const RegionPlanCase& c, std::ostream* out) { *out << c.size_m << " m, seed " << c.seed; }
class RegionPlans : public testing::TestWithParam<RegionPlanCase> {
 protected:
  const SitePlan& plan = planned(GetParam().make, GetParam().size_m, GetParam().seed).plan;
};
class CountryPlans : public RegionPlans {};
const std::vector<RegionPlanCase> countries =
    unless_sanitized<RegionPlanCase>({{2000.0, 1}, {2500.0, 2}, {2990.0, 3}, {4000.0, 4}, {5000.0, 5}, {6500.0, 6}}, 6);
INSTANTIATE_TEST_SUITE_P(SizesAndSeeds, RegionPlans, testing::ValuesIn(countries));
INSTANTIATE_TEST_SUITE_P(SizesAndSeeds, CountryPlans, testing::ValuesIn(countries));
INSTANTIATE_TEST_SUITE_P(Conurbations, RegionPlans,
                         testing::ValuesIn(unless_sanitized<RegionPlanCase>({{2000.0, 1, plan_conurbation},
                                                                             {2990.0, 2, plan_conurbation},
                                                                             {5000.0, 3, plan_conurbation}},
                                                                            3)));

/// In the site, a square kilometre.
double km_of_road(const SitePlan& plan) {
  const Box2 site{0.0, 0.0, plan.size_m, plan.size_m};
  double road_m = 0.0;
  for (const PlannedRoad& road : plan.roads)
    for (const Vec2 p : sample(road.alignment, 1.0)) road_m += site.contains(p) ? 1.0 : 0.0;
  return road_m / 1e3 / (plan.size_m * plan.size_m / 1e6);
}

// Its map has 242.8 km of roads on 23.03 km2.
TEST(ConurbationPlan, has_as_much_road_as_pardubice) {
  for (const double size_m : {3160.0, 10000.0}) EXPECT_NEAR(km_of_road(plan_conurbation(size_m, 7)), 10.5, 0.8);
  EXPECT_LT(km_of_road(plan_region(10000.0, 7)), 8.0);
}

TEST_P(RegionPlans, roads_are_curvature_continuous_and_all_connected) {
  for (const PlannedRoad& road : plan.roads) expect_continuous(road);
  EXPECT_EQ(expect_arms_meet(plan), 1u);
}

TEST_P(RegionPlans, no_roads_cross_without_a_junction_or_a_bridge) {
  expect_crossings_known(plan);
  EXPECT_GT(sharpest_junction_rad(plan), 0.7);  // 40 degrees
  EXPECT_GT(least_gap_of_junctions_m(plan), 20.0);
}

TEST_P(CountryPlans, has_the_parts_that_it_names) {
  const double size_m = plan.size_m;
  EXPECT_EQ(plan.roads[0].name, plan.route);
  EXPECT_EQ(plan.roads[0].highway, "motorway");
  EXPECT_GT(plan.roads[0].alignment.length_m, size_m);
  for (double s = 0.0; s < plan.roads[0].alignment.length_m; s += 20.0)
    ASSERT_LT(std::abs(evaluate(plan.roads[0].alignment, s).curvature_1pm), 1.0 / 1500.0);
  const auto columns = static_cast<std::size_t>(std::max(2L, std::lround(size_m / 2000.0)));
  EXPECT_EQ(plan.bridges.size(), columns);
  for (const PlannedBridge& bridge : plan.bridges) EXPECT_EQ(bridge.under.size(), 2u);
  const std::size_t interchanges = (columns + 1) / 3;
  EXPECT_EQ(count_of(plan, "motorway_link"), 4 * interchanges);
  EXPECT_EQ(std::count_if(plan.roads.begin(), plan.roads.end(), [](const auto& r) { return r.roundabout; }),
            static_cast<long>(2 * interchanges));
  EXPECT_GE(count_of(plan, "unclassified"), columns * columns);
  EXPECT_GT(count_of(plan, "residential"), 20u);
  EXPECT_GE(town_density(plan), 8.0);
  const auto areas = [&](Cover cover) {
    return std::count_if(plan.areas.begin(), plan.areas.end(), [&](const Area& area) { return area.cover == cover; });
  };
  EXPECT_GT(areas(Cover::water), 0);
  EXPECT_GT(areas(Cover::forest_floor), 0);
  for (const Area& area : plan.areas) {
    if (area.cover != Cover::water) continue;
    for (const PlannedRoad& road : plan.roads)
      for (const Vec2 p : sample(road.alignment, 5.0)) ASSERT_FALSE(contains(area.polygon, p)) << road.name;
  }
}

TEST_P(RegionPlans, heights_are_smooth_and_bridges_clear_the_motorway) {
  const Terrain& terrain = planned(GetParam().make, GetParam().size_m, GetParam().seed).terrain;
  for (std::size_t r = 0; r < plan.roads.size(); ++r)
    for (double s = 1.0; s < plan.roads[r].alignment.length_m; s += 2.0)
      ASSERT_LE(std::abs(terrain.profiles[r].gradient(s)), 0.12) << plan.roads[r].name << " at " << s;
  for (const PlannedJunction& junction : plan.junctions)
    for (const PlannedJunction::Arm& arm : junction.arms)
      EXPECT_NEAR(terrain.profiles[arm.road].z(arm.s_m),
                  terrain.profiles[junction.arms[0].road].z(junction.arms[0].s_m), 1e-6);
  for (const PlannedBridge& bridge : plan.bridges)
    for (const PlannedBridge::Below& below : bridge.under)
      EXPECT_NEAR(terrain.profiles[bridge.over].z(below.s_over_m) - terrain.profiles[below.road].z(below.s_m),
                  bridge_rise_m, 0.05);
}

TEST(RegionPlan, index_finds_all_roads_and_areas_of_a_box) {
  const SitePlan plan = plan_region(2500.0, 8);
  const PlanIndex index(plan);
  const Box2 box{700.0, 900.0, 1100.0, 1150.0};
  const std::vector<Stretch> stretches = index.stretches(box);
  std::size_t inside = 0;
  for (std::size_t r = 0; r < plan.roads.size(); ++r)
    for (double s = 0.0; s < plan.roads[r].alignment.length_m; s += 1.0) {
      if (!box.contains(evaluate(plan.roads[r].alignment, s).p)) continue;
      ++inside;
      ASSERT_EQ(std::count_if(stretches.begin(), stretches.end(),
                              [&](const Stretch& q) { return q.road == r && q.s_begin_m <= s && s <= q.s_end_m; }),
                1)
          << plan.roads[r].name << " at " << s;
    }
  EXPECT_GT(inside, 400u);
  double all_m = 0.0;
  for (const Stretch& q : stretches) all_m += q.s_end_m - q.s_begin_m;
  EXPECT_LT(all_m, 3.0 * static_cast<double>(inside));
}

/// The rasters of a region put together again.
SynthSite assembled(const SitePlan& plan, const SynthOptions& options) {
  const RegionFrames frames = region_frames(plan, options);
  const auto raster = [](const GridFrame& frame, int channels, auto fill) {
    return Raster<decltype(fill)>(frame.width, frame.height, channels, fill);
  };
  auto rgb = raster(frames.photo, 3, std::uint8_t{0}), labels = raster(frames.photo, 1, std::uint8_t{255});
  auto true_1m = raster(frames.dtm_1m, 1, -1e9f), dtm_1m = true_1m, dtm_10m = raster(frames.dtm_10m, 1, -1e9f);
  const auto put = [](auto& whole, const PixelBox& box, const auto& part) {
    ASSERT_EQ(std::pair(part.width, part.height), std::pair(box.width, box.height));
    for (int row = 0; row < box.height; ++row)
      std::copy_n(&part.at(0, row), box.width * part.channels,
                  &whole.at(static_cast<int>(box.col), static_cast<int>(box.row) + row));
  };
  SynthSite site =
      make_region(plan, options,
                  {[&](const RegionPicture& tile) { put(rgb, tile.box, tile.rgb), put(labels, tile.box, tile.labels); },
                   [&](const RegionHeights& tile) {
                     put(true_1m, tile.box_1m, tile.true_1m);
                     put(dtm_1m, tile.box_1m, tile.dtm_1m);
                     put(dtm_10m, tile.box_10m, tile.dtm_10m);
                   }});
  site.photo = {site.crs, frames.photo, rgb, {}};
  site.labels = {site.crs, frames.photo, labels, default_class_table()};
  site.true_dtm = {site.crs, frames.dtm_1m, true_1m, ""}, site.dtm_1m = {site.crs, frames.dtm_1m, dtm_1m, ""};
  site.dtm_10m = {site.crs, frames.dtm_10m, dtm_10m, ""};
  return site;
}

const SynthOptions quick_region{
    .size_m = 2000.0, .gsd_m = sanitized ? 1.6 : 0.8, .seed = 3, .threads = 1, .tile_px = 700};
const SynthSite& small_region() {
  static const SynthSite site = assembled(plan_region(quick_region.size_m, quick_region.seed), quick_region);
  return site;
}

TEST(Region, does_not_depend_on_threads_and_tiles) {
  if (sanitized) GTEST_SKIP() << runs_again;
  SynthOptions other = quick_region;
  other.threads = 3, other.tile_px = 333;
  const SynthSite site = assembled(plan_region(quick_region.size_m, quick_region.seed), other), &same = small_region();
  EXPECT_EQ(site.photo.rgb.data, same.photo.rgb.data);
  EXPECT_EQ(site.labels.labels.data, same.labels.labels.data);
  EXPECT_EQ(site.true_dtm.height_m.data, same.true_dtm.height_m.data);
  EXPECT_EQ(fingerprint(site), fingerprint(same));
}

TEST(Region, osm_has_unique_ids_and_the_buildings_of_the_labels) {
  const SynthSite& site = small_region();
  std::set<std::int64_t> nodes, ways;
  for (const OsmNode& node : site.osm.nodes) EXPECT_TRUE(nodes.insert(node.id).second);
  std::size_t buildings = 0;
  for (const OsmWay& way : site.osm.ways) {
    EXPECT_TRUE(ways.insert(way.id).second);
    buildings += way.tags.contains("building") ? 1 : 0;
  }
  EXPECT_GT(buildings, 200u);
  constexpr std::uint8_t building = 3;
  const double built_m2 =
      static_cast<double>(std::count(site.labels.labels.data.begin(), site.labels.labels.data.end(), building)) *
      quick_region.gsd_m * quick_region.gsd_m;
  EXPECT_GT(built_m2, 50.0 * static_cast<double>(buildings));
  EXPECT_LT(built_m2, 250.0 * static_cast<double>(buildings));
}

TEST(Region, labels_agree_with_the_true_carriageways) {
  SynthSite site = small_region();
  std::erase_if(site.surfaces, [](const SynthSurface& s) { return s.polygon.outer.size() < 3; });
  const Agreement agreement = compare_labels(site);
  EXPECT_LT(agreement.outside, 0.06);  // rounded corners
  EXPECT_LT(agreement.wrong, 0.06);
  for (const SynthSurface& surface : site.surfaces) EXPECT_LE(surface.visibility, 1.0);
}

TEST(Region, bare_earth_holds_the_road_beds) {
  const SynthSite& site = small_region();
  std::size_t compared = 0, off = 0, decks = 0;
  for (const RoadPath& path : site.roads.paths) {
    if (path.bridge) {
      const RoadNode& middle = path.nodes[path.nodes.size() / 2];
      EXPECT_GT(middle.z_m - sample_bilinear(site.true_dtm, middle.p), 4.5);
      ++decks;
      continue;
    }
    for (const RoadNode& node : path.nodes) {
      const double apart_m = std::abs(sample_bilinear(site.true_dtm, node.p) - node.z_m);
      if (path.highway == "motorway") {
        EXPECT_LT(apart_m, 0.05) << path.name << " at " << node.s_m;
      }
      ++compared, off += apart_m > 0.1 ? 1 : 0;
    }
  }
  EXPECT_EQ(decks, 2u);
  EXPECT_GT(compared, 20000u);
  EXPECT_LT(static_cast<double>(off), 0.01 * static_cast<double>(compared));  // lesser roads give way at junctions
}

TEST(Region, terrain_models_have_the_stated_noise) {
  const SynthSite& site = small_region();
  double sum = 0.0, square = 0.0;
  const std::size_t n = site.true_dtm.height_m.data.size();
  for (std::size_t i = 0; i < n; ++i) {
    const double error = site.dtm_1m.height_m.data[i] - site.true_dtm.height_m.data[i];
    sum += error, square += error * error;
  }
  EXPECT_NEAR(sum / static_cast<double>(n), 0.0, 0.001);
  EXPECT_NEAR(std::sqrt(square / static_cast<double>(n)), quick_region.dtm_1m_sigma_m, 0.001);
  EXPECT_EQ(site.dtm_10m.frame.bounds(), site.true_dtm.frame.bounds());
}

TEST(Region, wrong_options_are_refused) {
  EXPECT_THROW((void)plan_region(1990.0, 1), OptionError);
  EXPECT_THROW((void)plan_region(40010.0, 1), OptionError);
  EXPECT_THROW((void)plan_region(2505.0, 1), OptionError);
  EXPECT_THROW((void)region_frames({.size_m = 2000.0}, {.gsd_m = 0.5, .tile_px = 0}), OptionError);
  EXPECT_THROW((void)make_preset(Preset::region, {.size_m = 2000.0}), OptionError);
}

}  // namespace
}  // namespace orthodrive::synth
