// SPDX-License-Identifier: Apache-2.0
// Sites round surveyed tracks: a made-up one whose edges are known by formula, and the Red Bull Ring.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <numbers>
#include <set>

#include "orthodrive/core/error.hpp"
#include "orthodrive/io/osm/osm_reader.hpp"
#include "orthodrive/synth/ground/terrain.hpp"
#include "orthodrive/synth/make_region.hpp"
#include "orthodrive/synth/plan/plan_from_track.hpp"
#include "paths.hpp"
#include "sanitized.hpp"
#include "synth/site_helpers.hpp"

namespace orthodrive::synth {
namespace {
namespace fs = std::filesystem;

constexpr double pi = std::numbers::pi;
constexpr Vec2 place{480000.0, 5230000.0};

/// A bean of 100 to 180 m: left and right bends, an off-centre line, a width that changes.
std::vector<TrackRow> bean(int rows = 160) {
  std::vector<TrackRow> track;
  for (int i = 0; i < rows; ++i) {
    const double a = 2.0 * pi * i / rows, r = 140.0 + 40.0 * std::cos(2.0 * a);
    track.push_back(
        {place + Vec2{r * std::cos(a), r * std::sin(a)}, 6.0 + 0.8 * std::sin(3.0 * a), 5.5 + 0.7 * std::cos(2.0 * a)});
  }
  return track;
}

std::string csv_of(const std::vector<TrackRow>& track) {
  std::string text = "# x_m,w_tr_left_m,w_tr_right_m,utm33_e,utm33_n\n";
  for (const TrackRow& row : track)
    text += fmt::format("0,{:.4f},{:.4f},{:.4f},{:.4f}\r\n", row.left_m, row.right_m, row.p.x, row.p.y);
  return text;
}

TEST(ParseTrack, reads_columns_by_name) {
  const std::vector<TrackRow> track = bean(), read = parse_track(csv_of(track), "t.csv");
  ASSERT_EQ(read.size(), track.size());
  EXPECT_LT(distance(read[7].p, track[7].p), 1e-3);
  EXPECT_NEAR(read[7].left_m, track[7].left_m, 1e-4);
  EXPECT_NEAR(read[7].right_m, track[7].right_m, 1e-4);
}

TEST(ParseTrack, a_repeated_first_row_is_dropped) {
  std::vector<TrackRow> track = bean();
  track.push_back(track.front());
  EXPECT_EQ(parse_track(csv_of(track), "t.csv").size(), track.size() - 1);
}

TEST(ParseTrack, bad_input_is_named_in_one_line) {
  const auto message = [](const std::string& text) {
    try {
      (void)parse_track(text, "t.csv");
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("no error");
  };
  const auto expect = [&](const std::string& text, const std::string& part) {
    const std::string what = message(text);
    EXPECT_NE(what.find(part), std::string::npos) << what;
    EXPECT_EQ(what.find("t.csv: "), 0u) << what;
    EXPECT_EQ(what.find('\n'), std::string::npos) << what;
  };
  std::vector<TrackRow> track = bean();
  track[3].left_m = 0.0;
  expect(csv_of(track), "line 5: widths");
  track = bean();
  track[3].right_m = -1.0;
  expect(csv_of(track), "line 5: widths");
  track = bean();
  track[4].p = track[3].p;
  expect(csv_of(track), "line 6");
  track = bean();
  track.resize(120);
  expect(csv_of(track), "not closed");
  expect(csv_of(bean(9)), "9 rows");
  expect("", "empty");
  expect("# utm33_e,utm33_n,w_tr_right_m\n1,2,3\n", "no column 'w_tr_left_m'");
  std::string text = csv_of(bean());
  text.replace(text.find("480"), 3, "abc");
  expect(text, "need a number");
  expect(csv_of(bean()) + "1,2\n", "need a number");
  expect(csv_of(bean()) + "1,nan,2,3,4\n", "need a number");
}

TEST(ParseHeights, reads_and_refuses) {
  const std::vector<Vec3> heights =
      parse_heights("# lon,lat,elev_m\n15,47,600\n15.001,47,601\n15,47.001,603\n", "h.csv");
  ASSERT_EQ(heights.size(), 3u);
  EXPECT_NEAR(heights[0].x, 500000.0, 1e-3);
  EXPECT_EQ(heights[2].z, 603.0);
  EXPECT_THROW((void)parse_heights("lon,lat\n15,47\n", "h.csv"), InputError);
  EXPECT_THROW((void)parse_heights("lon,lat,elev_m\n15,47,1\n15,47,1\n", "h.csv"), InputError);
  EXPECT_THROW((void)parse_heights("lon,lat,elev_m\n15,470,1\n15,47,1\n15,47,1\n", "h.csv"), InputError);
}

TEST(FitHeights, follows_rounded_heights_and_is_a_plane_far_away) {
  const auto ground = [](double x, double y) { return 600.0 + 0.02 * x + 0.01 * y + 8.0 * std::sin(x / 150.0); };
  std::vector<Vec3> points;
  for (int i = 0; i < 120; ++i) {
    const double a = 2.0 * pi * i / 120.0, x = 400.0 + 300.0 * std::cos(a), y = 400.0 + 300.0 * std::sin(a);
    points.push_back({x, y, std::round(ground(x, y))});
  }
  const HeightField field = fit_heights(points, {0.0, 0.0, 800.0, 800.0});
  double square = 0.0;
  for (const Vec3& p : points) square += std::pow(field.at({p.x, p.y}) - ground(p.x, p.y), 2.0);
  EXPECT_LT(std::sqrt(square / 120.0), 1.0);  // hills of 8 m
  // Continuous between the grid's cells.
  for (double x = 3.0; x < 780.0; x += 7.3)
    EXPECT_NEAR(field.at({x, 300.0}), 0.5 * (field.at({x - 0.5, 300.0}) + field.at({x + 0.5, 300.0})), 2e-3);
}

TEST(SplineAlignment, passes_the_points_and_is_curvature_continuous_in_its_own_length) {
  std::vector<Vec2> points;
  for (const TrackRow& row : bean()) points.push_back(row.p - place);
  const Alignment line = spline_through(points, true);
  for (std::size_t i = 0; i < points.size(); ++i)
    EXPECT_LT(distance(evaluate(line, line.curve.s_m[i]).p, points[i]), 1e-9);
  for (double s = 0.0; s < line.length_m + 5.0; s += 0.37) {
    const AlignmentPoint a = evaluate(line, s - 0.01), b = evaluate(line, s + 0.01);
    EXPECT_NEAR(distance(a.p, b.p), 0.02, 1e-6);  // s is length, also across the seam
    EXPECT_NEAR(std::remainder(b.heading_rad - a.heading_rad, 2.0 * pi),
                0.02 * 0.5 * (a.curvature_1pm + b.curvature_1pm), 1e-6);
    EXPECT_LT(std::abs(b.curvature_1pm - a.curvature_1pm), 2e-4);
  }
}

TEST(FromTrack, carriageway_lies_between_the_given_edges) {
  const TrackSources sources{.rows = bean(), .file = "t.csv"};
  const SitePlan plan = plan_from_track(sources, 1);
  EXPECT_LT(measure_track(sources.rows, make_site(plan, {.gsd_m = 2.0}).roads).edge_most_m, 0.02);
  EXPECT_TRUE(plan.roads[0].alignment.closed);
  // The line is the middle of the edges, not the surveyed line: where left and right differ it is off by half of that.
  const Vec2 p = sources.rows[26].p - plan.world_from_local;
  const AlignmentPoint q = evaluate(plan.roads[0].alignment, nearest_s(plan.roads[0].alignment, p));
  EXPECT_NEAR(distance(q.p, p), 0.5 * std::abs(sources.rows[26].left_m - sources.rows[26].right_m), 0.02);
}

TEST(MeasureTrack, sees_a_circle_that_was_moved) {
  RoadPath circle;
  constexpr int n = 1000;
  for (int i = 0; i <= n; ++i) {
    const double a = 2.0 * pi * i / n;
    circle.nodes.push_back(
        {.p = place + Vec2{100.0 * std::cos(a), 100.0 * std::sin(a)}, .s_m = 100.0 * a, .width_m = 12.0});
  }
  const RoadNetwork truth{.paths = {circle}};
  std::vector<TrackRow> rows;
  for (int i = 0; i < 120; ++i) {
    const double a = 2.0 * pi * i / 120;
    rows.push_back({place + Vec2{99.0 * std::cos(a), 99.0 * std::sin(a)}, 7.0, 5.0});
  }
  const TrackErrors none = measure_track(rows, truth);
  EXPECT_NEAR(none.lap_m, 2.0 * pi * 100.0, 1e-9);
  EXPECT_LT(none.edge_mean_m, 1e-3);
  EXPECT_LT(none.edge_most_m, 0.02);  // at the seam a path's normal is that of one segment
  for (TrackRow& row : rows) row.p.x += 0.3;
  const TrackErrors moved = measure_track(rows, truth);  // by 0.3 |cos a|
  EXPECT_NEAR(moved.edge_mean_m, 0.3 * 2.0 / pi, 2e-3);
  EXPECT_NEAR(moved.edge_most_m, 0.3, 2e-3);
  EXPECT_EQ(measure_track(rows, {}).lap_m, 0.0);
}

TEST(FromTrack, site_is_painted_like_the_presets) {
  const TrackSources sources{.rows = bean(), .file = "t.csv"};
  const SitePlan plan = plan_from_track(sources, 1);
  SynthOptions options{.gsd_m = 0.5, .seed = 1, .threads = 1};
  const SynthSite site = make_site(plan, options);
  options.threads = 3;
  EXPECT_EQ(fingerprint(make_site(plan, options)), fingerprint(site));
  EXPECT_EQ(site.crs.definition, "EPSG:32633");
  EXPECT_TRUE(site.bounds.contains(place));
  ASSERT_EQ(site.roads.paths.size(), 1u);
  EXPECT_EQ(site.roads.paths[0].nodes.front().p, site.roads.paths[0].nodes.back().p);
  const Agreement agreement = compare_labels(site);
  EXPECT_LT(agreement.outside, 0.005);
  EXPECT_LT(agreement.wrong, 0.002);
  EXPECT_GT(site.surfaces[0].visibility, 0.998);
  for (const RoadNode& node : site.roads.paths[0].nodes) EXPECT_NEAR(node.width_m, 11.5, 1.6);
}

/// The bean's line as two OSM ways of 40 nodes.
OsmData bean_osm(bool against) {
  OsmData osm;
  const std::vector<TrackRow> rows = bean(40);
  for (int i = 0; i < 40; ++i)
    osm.nodes.push_back({500 + i, rows[static_cast<std::size_t>(against ? (40 - i) % 40 : i)].p + Vec2{1.0, -0.5}});
  OsmWay first{.id = 900,
               .tags = {{"highway", "raceway"}, {"name", "Bean \"1\""}, {"oneway", "yes"}, {"sport", "motor"}}};
  OsmWay second = first;
  second.id = 800;
  for (int i = 10; i <= 30; ++i) first.nodes.push_back(500 + i);
  for (int i = 30; i <= 50; ++i) second.nodes.push_back(500 + i % 40);
  osm.ways = {second, first};
  return osm;
}

TEST(FromTrack, given_ways_are_kept_and_the_truth_has_their_ids_and_direction) {
  for (const bool against : {false, true}) {
    const TrackSources sources{.rows = bean(), .file = "t.csv", .osm = bean_osm(against), .osm_file = "t.osm"};
    const SitePlan plan = plan_from_track(sources, 1);
    const SynthSite site = make_site(plan, {.gsd_m = 2.0});
    ASSERT_EQ(std::ranges::count_if(site.osm.ways, [](const OsmWay& way) { return way.tags.contains("highway"); }), 2);
    EXPECT_EQ(site.osm.ways[0].id, 800);
    EXPECT_EQ(site.osm.ways[0].nodes, sources.osm.ways[0].nodes);
    EXPECT_EQ(site.osm.ways[1].tags.at("sport"), "motor");
    for (const OsmNode& node : site.osm.nodes)
      if (node.id < 540) {
        EXPECT_LT(distance(node.p, sources.osm.nodes[static_cast<std::size_t>(node.id - 500)].p), 1e-6);
      }
    ASSERT_EQ(site.roads.paths.size(), 2u);
    for (std::size_t i = 0; i < 2; ++i) {
      const RoadPath& path = site.roads.paths[i];
      EXPECT_EQ(path.osm_id, site.osm.ways[i].id);
      EXPECT_EQ(path.nodes.front().osm_node, site.osm.ways[i].nodes.front());
      EXPECT_EQ(path.nodes.back().osm_node, site.osm.ways[i].nodes.back());
      const Vec2 way_begin = sources.osm.nodes[static_cast<std::size_t>(site.osm.ways[i].nodes.front() - 500)].p;
      EXPECT_LT(distance(path.nodes.front().p, way_begin), 2.5);
      for (const RoadNode& node : path.nodes) EXPECT_LT(std::abs(node.offset_m), 2.5);
    }
    EXPECT_LT(distance(site.roads.paths[0].nodes.back().p, site.roads.paths[1].nodes.front().p), 1e-8);
    const TrackErrors errors = measure_track(sources.rows, site.roads);
    EXPECT_NEAR(errors.lap_m, plan.roads[0].alignment.length_m, 1e-6);
    EXPECT_LT(errors.edge_most_m, 0.02);
  }
}

TEST(FromTrack, osm_that_does_not_fit_is_refused) {
  TrackSources sources{.rows = bean(), .file = "t.csv", .osm = bean_osm(false), .osm_file = "t.osm"};
  sources.osm.ways.pop_back();
  EXPECT_THROW((void)plan_from_track(sources, 1), InputError);
  sources.osm = bean_osm(false);
  for (OsmNode& node : sources.osm.nodes) node.p.x += 100.0;
  EXPECT_THROW((void)plan_from_track(sources, 1), InputError);
  sources.osm = {};
  for (TrackRow& row : sources.rows) row.p = place + (row.p - place) * 20.0;
  EXPECT_THROW((void)plan_from_track(sources, 1), InputError);
  sources.rows = bean();
  sources.heights = {{place.x, place.y, 600.0}, {place.x + 9000.0, place.y, 600.0}, {place.x, place.y + 9.0, 600.0}};
  EXPECT_THROW((void)plan_from_track(sources, 1), InputError);
}

TEST(FromTrack, with_a_size_it_has_a_country_round_it) {
  const TrackSources sources{.rows = bean(), .file = "t.csv"};
  for (const std::uint64_t seed : unless_sanitized<std::uint64_t>({1, 2, 3}, 3)) {
    const SitePlan plan = plan_from_track(sources, seed, 2000.0), small = plan_from_track(sources, seed);
    EXPECT_EQ(plan.size_m, 2000.0);
    const Polyline track = sample(plan.roads[0].alignment, 2.0);
    EXPECT_LT(distance(track.front() + plan.world_from_local,
                       sample(small.roads[0].alignment, 2.0).front() + small.world_from_local),
              1e-6);
    std::size_t inside = 0, streets = 0;
    for (std::size_t r = 1; r < plan.roads.size(); ++r) {
      streets += plan.roads[r].highway == "residential" ? 1 : 0;
      for (const Vec2 p : sample(plan.roads[r].alignment, 10.0)) {
        EXPECT_GT(project_onto(track, p).distance_m, 60.0) << plan.roads[r].name;
        inside += Box2{0.0, 0.0, plan.size_m, plan.size_m}.contains(p) ? 1 : 0;
      }
    }
    EXPECT_GT(streets, 5u);
    EXPECT_GT(inside, 800u) << "8 km of road";
    EXPECT_EQ(expect_arms_meet(plan), 2u) << "all but the track are connected";
    const Terrain terrain = make_terrain(plan, seed);
    for (std::size_t r = 1; r < plan.roads.size(); ++r)
      for (double s = 0.0; s < plan.roads[r].alignment.length_m; s += 5.0)
        EXPECT_LT(std::abs(terrain.profiles[r].gradient(s)), 0.101);
  }
  EXPECT_THROW((void)plan_from_track(sources, 1, 1000.0), OptionError);
  EXPECT_THROW((void)plan_from_track(sources, 1, 2005.0), OptionError);
  EXPECT_THROW((void)plan_from_track(sources, 1, 10010.0), OptionError);
}

TEST(FromTrack, a_country_is_made_tile_by_tile_with_the_given_ways) {
  const TrackSources sources{.rows = bean(), .file = "t.csv", .osm = bean_osm(false), .osm_file = "t.osm"};
  const SitePlan plan = plan_from_track(sources, 1, 1400.0);
  const auto made = [&](int threads, int tile_px) {
    std::map<std::pair<std::int64_t, std::int64_t>, std::uint8_t> labels;
    SynthSite site = make_region(plan, {.gsd_m = 2.0, .seed = 1, .threads = threads, .tile_px = tile_px},
                                 {[&](const RegionPicture& tile) {
                                    for (int row = 0; row < tile.box.height; ++row)
                                      for (int col = 0; col < tile.box.width; ++col)
                                        labels[{tile.box.row + row, tile.box.col + col}] = tile.labels.at(col, row);
                                  },
                                  [](const RegionHeights&) {}});
    for (const auto& [place, label] : labels) site.labels.labels.data.push_back(label);
    return site;
  };
  const SynthSite site = made(1, 700);
  if (!sanitized) {
    const SynthSite same = made(2, 128);
    EXPECT_EQ(site.labels.labels.data, same.labels.labels.data);
    EXPECT_EQ(fingerprint(site), fingerprint(same));
  }
  ASSERT_GT(site.osm.ways.size(), 40u);
  EXPECT_EQ(site.osm.ways[0].id, 800);
  EXPECT_EQ(site.osm.ways[0].nodes, sources.osm.ways[0].nodes);
  EXPECT_TRUE(site.route_closed);
  std::set<std::int64_t> ids;
  std::size_t traps = 0;
  for (const OsmWay& way : site.osm.ways) {
    EXPECT_TRUE(ids.insert(way.id).second);
    traps += way.tags.contains("natural") && way.tags.at("natural") == "shingle" ? 1 : 0;
  }
  EXPECT_GT(traps, 0u);
  RoadNetwork track = site.roads;
  std::erase_if(track.paths, [](const RoadPath& path) { return path.highway != "raceway"; });
  EXPECT_EQ(track.paths.size(), 2u);
  EXPECT_LT(measure_track(sources.rows, track).edge_most_m, 0.02);
}

TEST(RedBullRing, edges_lap_length_and_heights) {
  const fs::path folder = paths::in_source("../shared/data/spielberg");
  if (!fs::exists(folder / "spielberg_utm33.csv")) GTEST_SKIP() << "no data: " << folder;
  const auto text = [&](const char* name) {
    std::ifstream file(folder / name);
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  TrackSources sources{.rows = parse_track(text("spielberg_utm33.csv"), "track"),
                       .osm = io::read_osm(folder / "osm_way_red_bull_ring.osm", {"EPSG:32633"}),
                       .heights = parse_heights(text("elevation_zaggyai.csv"), "heights")};
  const SitePlan plan = plan_from_track(sources, 7);
  const TrackErrors errors = measure_track(sources.rows, make_site(plan, {.gsd_m = 2.0}).roads);
  EXPECT_LT(errors.edge_mean_m, 0.003);
  EXPECT_LT(errors.edge_p95_m, 0.005);
  EXPECT_LT(errors.edge_most_m, 0.1);  // rows 7 m apart along the outer edge of a bend of 12 m
  EXPECT_NEAR(errors.lap_m, 4318.0, 0.002 * 4318.0);
  const double length_m = plan.roads[0].alignment.length_m;
  ASSERT_TRUE(plan.osm);
  ASSERT_EQ(plan.osm->ways.size(), 2u);
  EXPECT_EQ(plan.osm->ways[0].osm_id, 84416553);
  EXPECT_EQ(plan.osm->ways[1].osm_id, 347958266);
  const Terrain terrain = make_terrain(plan, 7);
  double square = 0.0, steepest = 0.0;
  for (const Vec3& h : plan.heights) square += std::pow(terrain.hills.height_m({h.x, h.y}) - h.z, 2.0);
  EXPECT_LT(std::sqrt(square / static_cast<double>(plan.heights.size())), 8.0);
  for (double s = 0.0; s < length_m; s += 2.0) steepest = std::max(steepest, std::abs(terrain.profiles[0].gradient(s)));
  EXPECT_LT(steepest, 0.15);  // the ring climbs 12 %
  EXPECT_GT(steepest, 0.06);
}

}  // namespace
}  // namespace orthodrive::synth
