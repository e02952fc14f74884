// SPDX-License-Identifier: Apache-2.0
// Other worlds: grids, lanes and farmland, seasons, pavements, low suns. All from exact truth.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "orthodrive/core/error.hpp"
#include "orthodrive/model/roads/road_material.hpp"
#include "orthodrive/synth/ground/terrain.hpp"
#include "orthodrive/synth/make_site.hpp"
#include "orthodrive/synth/paint/mood.hpp"
#include "orthodrive/synth/paint/world.hpp"
#include "orthodrive/synth/plan/plan_presets.hpp"
#include "sanitized.hpp"
#include "synth/site_helpers.hpp"

namespace orthodrive::synth {
namespace {

enum : std::uint8_t { ground, road, parking, building, vegetation, grass, water };  // default_class_table()

struct WorldPlanCase {
  SitePlan (*make)(double, std::uint64_t);
  double size_m = 0.0;
  std::uint64_t seed = 0;
  double narrowest_m = 0.0, widest_m = 0.0, least_km_per_km2 = 0.0;
};
class SettledPlans : public testing::TestWithParam<WorldPlanCase> {
 protected:
  const SitePlan& plan = planned(GetParam().make, GetParam().size_m, GetParam().seed).plan;
};
std::vector<WorldPlanCase> world_plan_cases() {
  std::vector<WorldPlanCase> cases;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const double size_m = seed < 4 ? 400.0 : 800.0;
    cases.push_back({plan_grid, size_m, seed, 3.2, 16.0, 12.0});
    cases.push_back({plan_lanes, size_m, seed, 2.5, 8.0, 18.0});
    cases.push_back({plan_farmland, size_m, seed, 2.5, 6.8, 6.0});
  }
  return cases;
}
INSTANTIATE_TEST_SUITE_P(SizesAndSeeds, SettledPlans, testing::ValuesIn(unless_sanitized(world_plan_cases(), 8)));

TEST_P(SettledPlans, roads_are_curvature_continuous_meet_exactly_and_connect) {
  for (const PlannedRoad& planned : plan.roads) expect_continuous(planned);
  EXPECT_EQ(expect_arms_meet(plan), 1u);
  expect_apart(plan);
}

TEST_P(SettledPlans, widths_and_density_are_those_of_the_kind) {
  double road_m = 0.0;
  const Box2 site{0.0, 0.0, plan.size_m, plan.size_m};
  for (const PlannedRoad& planned : plan.roads) {
    EXPECT_GE(planned.width_m, GetParam().narrowest_m);
    EXPECT_LE(planned.width_m, GetParam().widest_m);
    for (const Vec2 p : sample(planned.alignment, 1.0)) road_m += site.contains(p) ? 1.0 : 0.0;
  }
  EXPECT_GT(road_m / 1000.0, GetParam().least_km_per_km2 * plan.size_m * plan.size_m / 1e6);
}

TEST_P(SettledPlans, slopes_are_for_cars) {
  const Terrain& terrain = planned(GetParam().make, GetParam().size_m, GetParam().seed).terrain;
  for (std::size_t r = 0; r < plan.roads.size(); ++r)
    for (double s = 0.5; s < plan.roads[r].alignment.length_m; s += 1.0)
      ASSERT_LE(std::abs(terrain.profiles[r].gradient(s)), 0.13) << "road " << r << " at " << s;
}

TEST(SettledPlans, refuse_sizes_they_cannot_fill) {
  EXPECT_THROW((void)plan_grid(200.0, 1), OptionError);
  EXPECT_THROW((void)plan_lanes(100.0, 1), OptionError);
  EXPECT_THROW((void)plan_farmland(305.0, 1), OptionError);
}

struct WorldSiteCase {
  Preset preset;
  const char* world;
};
SynthOptions small_world(const WorldSiteCase& c) {
  return {.size_m = 300.0, .gsd_m = 0.5, .seed = 3, .world = c.world};
}
const SynthSite& site_of(const WorldSiteCase& c) {
  static std::map<std::pair<int, std::string>, SynthSite> sites;
  const auto key = std::pair(static_cast<int>(c.preset), std::string(c.world));
  if (!sites.contains(key)) sites.emplace(key, make_preset(c.preset, small_world(c)));
  return sites.at(key);
}

class WorldSites : public testing::TestWithParam<WorldSiteCase> {
 protected:
  const SynthSite& site = site_of(GetParam());
};
INSTANTIATE_TEST_SUITE_P(Small, WorldSites,
                         testing::Values(WorldSiteCase{Preset::grid, "america"}, WorldSiteCase{Preset::lanes, "japan"},
                                         WorldSiteCase{Preset::farmland, "baltic"},
                                         WorldSiteCase{Preset::village, "winter"},
                                         WorldSiteCase{Preset::farmland, ""}));

TEST_P(WorldSites, same_seed_same_bytes_for_any_thread_count) {
  SynthOptions options = small_world(GetParam());
  options.threads = 3;
  EXPECT_EQ(fingerprint(make_preset(GetParam().preset, options)), fingerprint(site));
}

TEST_P(WorldSites, labels_agree_with_the_surfaces) {
  const Agreement agreement = compare_labels(site);
  EXPECT_LT(agreement.outside, 0.03);  // rounded corners
  EXPECT_LT(agreement.wrong, 0.012);
}

TEST_P(WorldSites, every_class_of_open_land_is_there_and_roads_are_seen) {
  std::map<int, double> share;
  for (const std::uint8_t label : site.labels.labels.data)
    share[label] += 1.0 / static_cast<double>(site.labels.labels.data.size());
  EXPECT_GT(share[road], 0.02);
  EXPECT_LT(share[road], 0.35);
  EXPECT_GT(share[building], 0.001);
  EXPECT_GT(share[vegetation], 0.005);
  EXPECT_GT(share[grass], 0.01);
  EXPECT_GT(share[ground], 0.01);
  double seen = 0.0;
  for (const SynthSurface& surface : site.surfaces)
    seen += surface.visibility / static_cast<double>(site.surfaces.size());
  EXPECT_GT(seen, 0.7);
}

TEST_P(WorldSites, map_says_the_surface_that_the_truth_has) {
  for (const RoadPath& path : site.roads.paths) {
    const auto way =
        std::find_if(site.osm.ways.begin(), site.osm.ways.end(), [&](const OsmWay& w) { return w.id == path.osm_id; });
    ASSERT_NE(way, site.osm.ways.end());
    const auto tag = way->tags.find("surface");
    EXPECT_EQ(tag == way->tags.end() ? "" : tag->second, path.surface);
    EXPECT_EQ(tag == way->tags.end(), GetParam().world[0] == '\0');
    EXPECT_EQ(path.known_surface.surface, surface_of_tags(path.highway, path.surface, "").surface);
  }
}

TEST(Worlds, width_in_the_labels_is_that_of_the_truth) {
  const SynthSite site = make_preset(Preset::lanes, {.size_m = 200.0, .gsd_m = 0.1, .seed = 4, .world = "japan"});
  const GridFrame& frame = site.labels.frame;
  std::vector<double> errors;
  for (const RoadPath& path : site.roads.paths)
    for (std::size_t i = 12; i + 12 < path.nodes.size(); i += 3) {
      const auto joins = [&](const RoadNode& n) { return n.osm_node != 0; };
      const auto from = path.nodes.begin() + static_cast<long>(i) - 12;
      if (std::any_of(from, from + 24, joins)) continue;  // near a junction, or at a node of the map
      const Vec2 along = normalized(path.nodes[i + 1].p - path.nodes[i - 1].p), across = left_normal(along);
      double width_m = 0.0;
      bool hidden = false;
      for (double t = -6.0; t <= 6.0; t += 0.02) {
        const Vec2 q = frame.pixel_from_world(path.nodes[i].p + across * t);
        const int col = static_cast<int>(q.x), row = static_cast<int>(q.y);
        if (!site.labels.labels.inside(col, row)) continue;
        const std::uint8_t label = site.labels.labels.at(col, row);
        hidden = hidden || (label != road && std::abs(t) < 0.5 * path.nodes[i].width_m - 0.2);
        width_m += label == road ? 0.02 : 0.0;
      }
      if (!hidden) errors.push_back(std::abs(width_m - path.nodes[i].width_m));
    }
  ASSERT_GT(errors.size(), 30u);
  std::sort(errors.begin(), errors.end());
  EXPECT_LT(errors[errors.size() * 9 / 10], 0.16);  // a pixel and a half
}

TEST(Worlds, a_road_is_seen_through_bare_branches) {
  const auto mean_visibility = [](const char* world) {
    const SynthSite site = make_preset(Preset::village, {.size_m = 400.0, .gsd_m = 1.0, .seed = 5, .world = world});
    double sum = 0.0;
    for (const SynthSurface& surface : site.surfaces) sum += surface.visibility;
    return sum / static_cast<double>(site.surfaces.size());
  };
  const double bare = mean_visibility("baltic"), green = mean_visibility("france");
  EXPECT_GT(bare, green + 0.005);
}

TEST(Worlds, trees_and_pavements_follow_the_world) {
  const World baltic = make_world("baltic", 1);
  SitePlan plan = plan_farmland(800.0, 2);
  pave_roads(plan, baltic, 2);
  std::set<Pavement> pavements;
  for (const PlannedRoad& planned : plan.roads) {
    pavements.insert(planned.pavement);
    EXPECT_EQ(planned.surface, surface_tag(planned.pavement));
  }
  EXPECT_TRUE(pavements.contains(Pavement::gravel));
  EXPECT_TRUE(pavements.contains(Pavement::dirt));
  EXPECT_FALSE(pavements.contains(Pavement::plain));
  SiteObjects objects;
  for (int i = 0; i < 1000; ++i) objects.trees.push_back({{7.0 * i, 3.0 * i}, 3.0, 8.0, false, i});
  dress_objects(objects, baltic, 2);
  std::map<Leaves, int> leaves;
  int conifers = 0;
  for (const Tree& tree : objects.trees) conifers += tree.conifer ? 1 : 0, ++leaves[tree.leaves];
  EXPECT_GT(conifers, 100);
  EXPECT_LT(conifers, 500);
  EXPECT_NEAR(leaves[Leaves::bare], 0.93 * (1000 - conifers), 60);
}

TEST(Worlds, a_pavement_that_the_plan_has_stays) {
  SitePlan plan = plan_village(1000.0, 1);
  pave_roads(plan, make_world("america", 1), 1);
  EXPECT_TRUE(std::any_of(plan.roads.begin(), plan.roads.end(), [](const PlannedRoad& r) {
    return r.surface == "fine_gravel" && r.pavement == Pavement::gravel;
  }));
}

TEST(Worlds, suns_stand_in_the_south_and_every_world_has_its_own_light) {
  std::set<int> elevations;
  for (const char* name : world_names)
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      const World world = make_world(name, seed);
      const Mood mood = make_mood(seed, &world);
      EXPECT_GT(mood.sun_azimuth_rad, 1.8);  // shadows are swept from south to north
      EXPECT_LT(mood.sun_azimuth_rad, 4.5);
      EXPECT_GT(mood.sun_elevation_rad, 0.3);
      EXPECT_GT(mood.blur, 0.0f);
      EXPECT_LE(mood.blur, 0.34f);
      elevations.insert(static_cast<int>(mood.sun_elevation_rad * 57.3 / 10.0));
    }
  EXPECT_GE(elevations.size(), 4u);  // from 20 to 60 degrees
}

TEST(Worlds, random_worlds_differ_and_unknown_ones_are_refused) {
  std::set<std::string> mixes;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const World world = make_world("random", seed);
    mixes.insert(std::string(world.season->name) + world.streets->name + world.light->name + world.roofs->name);
  }
  EXPECT_GE(mixes.size(), 36u);
  EXPECT_THROW((void)make_world("moon", 1), OptionError);
  EXPECT_THROW((void)make_preset(Preset::village, {.size_m = 300.0, .gsd_m = 1.0, .world = "moon"}), OptionError);
}

/// Stripes of 1 m, bright and dark.
PhotoTextures striped(const std::string& name) {
  PhotoTextures textures{.gsd_m = 0.5};
  Raster<std::uint8_t> tile(8, 8, 3);
  for (int row = 0; row < 8; ++row)
    for (int col = 0; col < 8; ++col)
      for (int c = 0; c < 3; ++c) tile.at(col, row, c) = col / 2 % 2 == 0 ? 192 : 64;
  textures.tiles.emplace(name, tile);
  return textures;
}

TEST(PhotoTextures, keep_their_mean_at_any_scale_and_go_on_at_their_edges) {
  for (const double gsd_m : {0.25, 0.5, 1.0, 4.0}) {
    const TextureSampler sampler(striped("road"), gsd_m, 5);
    const int px = static_cast<int>(4.0 / gsd_m);  // of the tile
    double sum = 0.0, least = 2.0, most = 0.0;
    for (int col = 0; col < px; ++col) {
      const float f = sampler.at(Texture::road, col - 1000 * px, 3)[1];
      EXPECT_EQ(f, sampler.at(Texture::road, col + 7 * px, 3)[1]);
      sum += f, least = std::min<double>(least, f), most = std::max<double>(most, f);
    }
    EXPECT_NEAR(sum / px, 1.0, 1e-5) << gsd_m;
    EXPECT_NEAR(most - least, gsd_m < 2.0 ? 1.0 : 0.0, gsd_m < 2.0 ? 0.3 : 1e-5) << gsd_m;
  }
  const TextureSampler sampler(striped("road"), 0.5, 5);
  EXPECT_EQ(sampler.at(Texture::grass, 1, 2), (std::array{1.0f, 1.0f, 1.0f})) << "no tile";
}

TEST(PhotoTextures, show_on_their_class_alone_and_leave_the_truth_as_it_is) {
  SynthOptions options{.size_m = 300.0, .gsd_m = 0.5, .seed = 3, .world = "baltic"};
  const SynthSite plain = make_preset(Preset::grid, options);
  const PhotoTextures textures = striped("road");
  options.textures = &textures;
  const SynthSite textured = make_preset(Preset::grid, options);
  EXPECT_TRUE(textured.labels.labels.data == plain.labels.labels.data);
  std::size_t changed_roads = 0, roads = 0, changed_roofs = 0, roofs = 0;
  const Raster<std::uint8_t>& labels = plain.labels.labels;
  for (int row = 1; row + 1 < labels.height; ++row)
    for (int col = 1; col + 1 < labels.width; ++col) {
      bool alone = true;  // the optics blur a pixel into its neighbours
      for (int j = -1; j <= 1; ++j)
        for (int i = -1; i <= 1; ++i) alone &= labels.at(col + i, row + j) == labels.at(col, row);
      if (!alone) continue;
      const int change = std::abs(plain.photo.rgb.at(col, row, 1) - textured.photo.rgb.at(col, row, 1));
      if (labels.at(col, row) == 1) ++roads, changed_roads += change > 10;
      if (labels.at(col, row) == 3) ++roofs, changed_roofs += change > 0;
    }
  EXPECT_GT(roads, 1000u);
  EXPECT_GT(changed_roads, roads / 2);
  EXPECT_GT(roofs, 500u);
  EXPECT_EQ(changed_roofs, 0u);
}

}  // namespace
}  // namespace orthodrive::synth
