// SPDX-License-Identifier: Apache-2.0
// Odd data, from files to a road network: what comes out can be driven, and findings say where and what was assumed.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>

#include "io/npy_bytes.hpp"
#include "opendrive_peers.hpp"
#include "orthodrive/core/random.hpp"
#include "orthodrive/io/raster/raster_io.hpp"
#include "orthodrive/io/support/vector_io.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace orthodrive {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::HasSubstr;

const Crs utm33{"EPSG:32633"};
constexpr Vec2 corner{460000.0, 5270000.0};  // of the sites that synth makes
constexpr double size_m = 300.0;

/// What comes of roads and terrain: no step, no kink, no loose end, and where the findings are.
struct Driven {
  json scores, findings;  ///< of evaluate network; features of elevate and network
  roadquery::RoadMap map;
  RoadNetwork roads;  ///< with heights

  [[nodiscard]] std::optional<json> finding(const std::string& code) const {
    for (const json& feature : findings)
      if (feature["properties"]["code"] == code) return feature;
    return std::nullopt;
  }
  /// The finding is there, says so, and lies on the site.
  void expect_finding(const std::string& code, const std::string& says) const {
    const auto found = finding(code);
    ASSERT_TRUE(found) << code << " is not in " << findings.dump(1);
    EXPECT_THAT((*found)["properties"]["message"].get<std::string>(), HasSubstr(says));
    const CoordinateTransform site_from_lonlat(Crs{"EPSG:4326"}, utm33);
    const Vec2 p = site_from_lonlat.target_from_source(
        {(*found)["geometry"]["coordinates"][0].get<double>(), (*found)["geometry"]["coordinates"][1].get<double>()});
    const Box2 site{corner.x, corner.y, corner.x + size_m, corner.y + size_m};
    EXPECT_TRUE(site.grown(1.0).contains(p)) << code << " at " << p.x << ", " << p.y;
  }
};

/// Largest distance of the surfaces of linked roads where they meet, over the width of both.
double largest_step_m(const roadquery::RoadMap& map) {
  const auto road_of = [&](int id) -> const roadquery::Road* {
    for (const roadquery::Road& road : map.roads)
      if (road.id == id) return &road;
    return nullptr;
  };
  double worst = 0.0;
  for (const roadquery::Road& road : map.roads)
    for (const bool at_end : {false, true}) {
      const roadquery::RoadLink& link = at_end ? road.successor : road.predecessor;
      if (link.kind != roadquery::LinkKind::road) continue;
      const roadquery::Road* other = road_of(link.id);
      if (!other) continue;
      const bool other_end = link.contact == roadquery::ContactPoint::end;
      const double s = at_end ? road.length : 0.0, s_other = other_end ? other->length : 0.0;
      const double sign = at_end == other_end ? -1.0 : 1.0;
      const auto has = [](const roadquery::Road& r, double at, double t) {
        const auto edges = roadquery::road_edges(r, at);
        return t >= edges.right_t - 1e-6 && t <= edges.left_t + 1e-6;
      };
      for (const double t : {-1.0, 0.0, 1.0}) {
        if (!has(road, s, t) || !has(*other, s_other, sign * t)) continue;  // a crown ends at the road's edge
        const auto a = roadquery::surface_point(road, s, t), b = roadquery::surface_point(*other, s_other, sign * t);
        worst = std::max(worst, std::hypot(a.x - b.x, a.y - b.y, a.z - b.z));
      }
    }
  return worst;
}

/// OSM by hand, in metres from the corner of the site.
class OsmText {
 public:
  int node(double x, double y) {
    const Vec2 p = lonlat_.target_from_source(corner + Vec2{x, y});
    nodes_ += fmt::format("<node id=\"{}\" lat=\"{:.9f}\" lon=\"{:.9f}\"/>", ++count_, p.y, p.x);
    return count_;
  }
  void way(const std::vector<int>& nodes, const std::vector<std::pair<std::string, std::string>>& tags) {
    ways_ += fmt::format("<way id=\"{}\">", 1000 + ++way_count_);
    for (const int node : nodes) ways_ += fmt::format("<nd ref=\"{}\"/>", node);
    for (const auto& [key, value] : tags) ways_ += fmt::format("<tag k=\"{}\" v=\"{}\"/>", key, value);
    ways_ += "</way>";
  }
  [[nodiscard]] std::string text() const { return "<osm version=\"0.6\">" + nodes_ + ways_ + "</osm>"; }

 private:
  CoordinateTransform lonlat_{utm33, Crs{"EPSG:4326"}};
  std::string nodes_, ways_;
  int count_ = 0, way_count_ = 0;
};

class OddData : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    site_ = fs::temp_directory_path() / ("orthodrive-odd-data-" + std::to_string(getpid()));
    const ToolRun made = run_tool({"--quiet", "synth", "--seed", "5", "--size", "300", "--gsd", "0.5", "-o", site_});
    ASSERT_EQ(made.exit_code, 0) << made.err;
  }
  static void TearDownTestSuite() { fs::remove_all(site_); }

  [[nodiscard]] static fs::path true_roads() { return site_ / "truth/roads.gpkg"; }

  /// The terrain of the site, spoiled pixel by pixel.
  fs::path terrain(const std::string& source, const std::function<float(Vec2, float)>& spoiled) const {
    const Box2 box{corner.x - 60.0, corner.y - 60.0, corner.x + size_m + 60.0, corner.y + size_m + 60.0};
    HeightGrid grid = io::read_heights(site_ / source, utm33, box);
    for (int row = 0; row < grid.frame.height; ++row)
      for (int col = 0; col < grid.frame.width; ++col)
        grid.height_m.at(col, row) = spoiled(grid.frame.center_of(col, row), grid.height_m.at(col, row));
    const fs::path file = scratch_ / ("odd_" + source);
    io::write_dtm(file, grid);
    return file;
  }

  /// Through the tool: heights, network, scores.
  Driven drive(const fs::path& roads, const std::vector<fs::path>& dtms, const std::vector<fs::path>& logs = {}) const {
    const fs::path elevated = scratch_ / "elevated.gpkg", xodr = scratch_ / "roads.xodr";
    Arguments arguments{"--quiet", "elevate", "--roads",    roads,
                        "-o",      elevated,  "--findings", scratch_ / "heights.geojson"};
    for (const fs::path& dtm : dtms) arguments.insert(arguments.end(), {"--dtm", dtm});
    for (const fs::path& log : logs) arguments.insert(arguments.end(), {"--log", log});
    expect_success(arguments);
    expect_success({"--quiet", "network", "--roads", elevated, "-o", xodr, "--findings", scratch_ / "network.geojson"});
    Driven driven;
    driven.scores = json::parse(expect_success({"evaluate", "network", xodr, "--json"}).out);
    driven.findings = json::array();
    for (const char* name : {"heights.geojson", "network.geojson"}) {
      const json file = json::parse(bytes_of(scratch_ / name));
      for (const json& feature : file["features"]) driven.findings.push_back(feature);
    }
    driven.map = roadquery::read_opendrive(xodr);
    driven.roads = io::read_roads(elevated);

    const json& s = driven.scores;
    EXPECT_LE(s["max_gradient_kink"].get<double>(), 1e-3);
    EXPECT_LE(s["max_joint_gap_m"].get<double>(), 1e-3);
    EXPECT_LE(s["max_heading_jump_rad"].get<double>(), 1e-3);
    EXPECT_LE(s["max_curvature_jump"].get<double>(), 1e-3);
    for (const char* count : {"broken_links", "lane_link_errors", "dead_lanes"}) EXPECT_EQ(s[count], 0) << count;
    EXPECT_GE(s["min_lane_width_m"].get<double>(), 2.0);
    EXPECT_LE(largest_step_m(driven.map), 1e-3);
    expect_valid_opendrive(xodr);
    expect_sumo_finds_all_roads(xodr, scratch_.folder());
    return driven;
  }
  Driven drive_osm(const OsmText& osm) const {
    write_bytes(scratch_ / "odd.osm", osm.text());
    expect_success({"--quiet", "refine", "--method", "none", "--osm", scratch_ / "odd.osm", "--labels",
                    site_ / "truth/labels.tif", "-o", scratch_ / "odd.gpkg"});
    return drive(scratch_ / "odd.gpkg", {site_ / "dtm_1m.tif"});
  }
  /// Mean and largest distance of heights from the truth, where `counts`.
  struct HeightError {
    double mean_m = 0.0, largest_m = 0.0;
  };
  static HeightError height_error(const Driven& driven, const std::function<bool(Vec2)>& counts = {}) {
    const RoadNetwork truth = io::read_roads(true_roads());
    HeightError error;
    double nodes = 0.0;
    for (std::size_t k = 0; k < truth.paths.size(); ++k)
      for (std::size_t n = 0; n < truth.paths[k].nodes.size(); ++n) {
        const RoadNode &a = driven.roads.paths.at(k).nodes.at(n), &b = truth.paths[k].nodes[n];
        if (counts && !counts(b.p)) continue;
        error.mean_m += std::abs(a.z_m - b.z_m), nodes += 1.0;
        error.largest_m = std::max(error.largest_m, std::abs(a.z_m - b.z_m));
      }
    error.mean_m /= nodes;
    return error;
  }

  static ToolRun expect_success(const Arguments& arguments) {
    ToolRun run = run_tool(arguments);
    EXPECT_EQ(run.exit_code, 0) << testing::PrintToString(arguments) << "\n" << run.err;
    return run;
  }
  static inline fs::path site_;
  const Scratch scratch_;
};

float nan_height() { return std::numeric_limits<float>::quiet_NaN(); }

TEST_F(OddData, clean_data_have_no_warning) {
  const Driven driven = drive(true_roads(), {site_ / "dtm_1m.tif"});
  for (const json& finding : driven.findings) EXPECT_NE(finding["properties"]["severity"], "warning") << finding;
  EXPECT_LT(height_error(driven).mean_m, 0.05);
}

TEST_F(OddData, terrain_with_the_wrong_crs_is_refused_in_one_line) {
  const fs::path wrong = scratch_ / "zone_34.tif";
  ASSERT_EQ(
      run_program({"/usr/bin/gdal_translate", "-q", "-a_srs", "EPSG:32634", site_ / "dtm_1m.tif", wrong}).exit_code, 0);
  const ToolRun run =
      run_tool({"--quiet", "elevate", "--roads", true_roads(), "--dtm", wrong, "-o", scratch_ / "a.gpkg"});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
  EXPECT_THAT(run.err,
              testing::AllOf(HasSubstr("zone_34.tif"), HasSubstr("longitude 20.4"), HasSubstr("longitude 14.4")));
  EXPECT_FALSE(fs::exists(scratch_ / "a.gpkg"));
}

TEST_F(OddData, terrain_in_feet_is_told_by_its_slopes) {
  // Alone, nothing proves it: the heights are taken as metres and the finding says so.
  const fs::path feet = terrain("dtm_10m.tif", [](Vec2, float z) { return z / 0.3048F; });
  drive(true_roads(), {feet}).expect_finding("elevate.implausible_terrain", "feet; taken for metres as they are");
}

TEST_F(OddData, terrain_in_feet_beside_one_in_metres_becomes_metres) {
  const fs::path feet = terrain("dtm_1m.tif", [](Vec2, float z) { return z / 0.3048F; });
  for (const auto& dtms : {std::vector{feet, site_ / "dtm_10m.tif"}, std::vector{site_ / "dtm_10m.tif", feet}}) {
    const Driven driven = drive(true_roads(), dtms);
    driven.expect_finding("terrain.feet",
                          "odd_dtm_1m.tif is 3.28 times as high as dtm_10m.tif: its heights are taken for feet");
    EXPECT_LT(height_error(driven).mean_m, 0.1);
  }
}

TEST_F(OddData, terrain_over_two_datums_or_none_is_told) {
  const auto over = [&](const char* from, const char* to, const char* vertical) {
    EXPECT_EQ(run_program({"/usr/bin/gdal_translate", "-q", "-a_srs", std::string("EPSG:32633+") + vertical,
                           site_ / from, scratch_ / to})
                  .exit_code,
              0);
    return scratch_ / to;
  };
  const fs::path fine = over("dtm_1m.tif", "egm96.tif", "5773"), coarse = over("dtm_10m.tif", "rh2000.tif", "5613");
  drive(true_roads(), {fine, coarse})
      .expect_finding("terrain.datums_differ", "heights of rh2000.tif are over Rikets hojdsystem 2000");
  drive(true_roads(), {fine, site_ / "dtm_10m.tif"})
      .expect_finding("terrain.datum_not_named", "dtm_10m.tif: no vertical datum is named");
  const fs::path told = scratch_ / "told.tif";  // as `fetch` leaves what its table names
  ASSERT_EQ(run_program({"/usr/bin/gdal_translate", "-q", "-mo", "VERTICAL_DATUM=Bpv", site_ / "dtm_10m.tif", told})
                .exit_code,
            0);
  drive(true_roads(), {fine, told}).expect_finding("terrain.datums_differ", "heights of told.tif are over Bpv");
}

TEST_F(OddData, terrain_that_says_it_is_in_feet_becomes_metres) {
  const fs::path feet = terrain("dtm_1m.tif", [](Vec2, float z) { return z / 0.3048F; });
  const fs::path said = scratch_ / "said.vrt";
  ASSERT_EQ(run_program({"/usr/bin/gdal_translate", "-q", "-of", "VRT", feet, said}).exit_code, 0);
  std::string text = bytes_of(said);
  const std::size_t at = text.find('>', text.find("<VRTRasterBand")) + 1;
  write_bytes(said, text.insert(at, "<UnitType>ft</UnitType>"));
  const Driven driven = drive(true_roads(), {said});
  EXPECT_FALSE(driven.finding("elevate.implausible_terrain"));
  EXPECT_LT(height_error(driven).mean_m, 0.05);
}

TEST_F(OddData, holes_of_the_terrain_are_bridged) {
  const Vec2 holes[] = {corner + Vec2{60, 110}, corner + Vec2{150, 150}, corner + Vec2{230, 60},
                        corner + Vec2{110, 250}};
  const auto in_hole = [&](Vec2 p) {
    return std::any_of(std::begin(holes), std::end(holes), [&](Vec2 hole) { return distance(hole, p) < 15.0; });
  };
  // -9999 is nodata that the file does not declare.
  for (const float hole : {nan_height(), -9999.0F, 3.4e38F}) {
    const fs::path dtm = terrain("dtm_1m.tif", [&](Vec2 p, float z) { return in_hole(p) ? hole : z; });
    const Driven driven = drive(true_roads(), {dtm});
    driven.expect_finding("elevate.no_terrain", "heights continue those beside");
    const HeightError error = height_error(driven);
    EXPECT_LT(error.mean_m, 0.05);
    EXPECT_LT(error.largest_m, 1.0);
  }
}

TEST_F(OddData, spikes_of_the_terrain_do_not_reach_the_road) {
  const auto is_spike = [](Vec2 p, double pixel_m) {
    // 2 % of the pixels, by a hash of their place.
    Random random(static_cast<std::uint64_t>(std::floor(p.x / pixel_m) * 1e6 + std::floor(p.y / pixel_m)));
    return random.uniform() < 0.02;
  };
  for (const auto& [source, pixel_m, mean_m, largest_m] :
       {std::tuple{"dtm_1m.tif", 1.0, 0.05, 0.3}, std::tuple{"dtm_10m.tif", 10.0, 0.15, 1.5}})
    for (const float spike_m : {50.0F, -50.0F}) {
      const fs::path dtm =
          terrain(source, [&, pixel = pixel_m](Vec2 p, float z) { return is_spike(p, pixel) ? z + spike_m : z; });
      const Driven driven = drive(true_roads(), {dtm});
      driven.expect_finding(pixel_m < 5.0 ? "elevate.terrain_spikes" : "elevate.off_terrain", "of the terrain model");
      const HeightError error = height_error(driven);
      EXPECT_LT(error.mean_m, mean_m) << source << " " << spike_m;
      EXPECT_LT(error.largest_m, largest_m) << source << " " << spike_m;
    }
}

TEST_F(OddData, a_block_of_wrong_terrain_does_not_reach_the_road) {
  const Vec2 middle = corner + Vec2{150, 150};
  const fs::path dtm =
      terrain("dtm_1m.tif", [&](Vec2 p, float z) { return distance(p, middle) < 12.0 ? z + 50.0F : z; });
  const Driven driven = drive(true_roads(), {dtm});
  driven.expect_finding("elevate.off_terrain", "an error of the terrain model");
  EXPECT_LT(height_error(driven).largest_m, 1.0);
}

TEST_F(OddData, terrain_that_ends_in_the_middle_of_roads) {
  constexpr double edge_x = 460200.0, gradients_fade_m = 200.0;
  const fs::path dtm = terrain("dtm_1m.tif", [&](Vec2 p, float z) { return p.x > edge_x ? nan_height() : z; });
  const Driven driven = drive(true_roads(), {dtm});
  driven.expect_finding("elevate.no_terrain", "heights continue those beside");
  EXPECT_LT(height_error(driven, [&](Vec2 p) { return p.x < edge_x - 1.0; }).mean_m, 0.05);
  EXPECT_LT(height_error(driven).largest_m, 0.1 * gradients_fade_m) << "10 % of gradient at most, on and on";
  for (const RoadPath& path : driven.roads.paths)
    for (const RoadNode& node : path.nodes) EXPECT_LT(std::abs(node.gradient), 0.15);
}

TEST_F(OddData, a_site_whose_terrain_ends_in_the_middle_is_built_and_driven) {
  // Cut off by nodata, and by the edge of the file.
  const fs::path cut = terrain("dtm_10m.tif", [&](Vec2 p, float z) { return p.x > 460200.0 ? nan_height() : z; });
  const fs::path ends = scratch_ / "ends.tif";
  ASSERT_EQ(
      run_program({"/usr/bin/gdal_translate", "-q", "-projwin", "459950", "5270350", "460200", "5269950", cut, ends})
          .exit_code,
      0);
  for (const fs::path& dtm : {cut, ends}) {
    const fs::path out = scratch_ / dtm.stem().string();
    expect_success(
        {"--quiet", "build", site_ / "site.toml", "-o", out, "--set", "sources.dtm=[\"" + dtm.string() + "\"]"});
    EXPECT_THAT(bytes_of(out / "findings.geojson"), HasSubstr("elevate.no_terrain"));
    EXPECT_TRUE(fs::exists(out / "scene/tileset.json"));
    const json run = json::parse(bytes_of(out / "run.json"));
    for (const json& stage : run.at("stages")) {
      if (stage.at("stage") == "drive") {
        EXPECT_TRUE(stage.at("numbers").at("finished"));
      }
    }
  }
}

/// Two roads that cross in the middle, the second on the level of the ground.
OsmText crossing(std::vector<std::pair<std::string, std::string>> tags) {
  OsmText osm;
  tags.emplace_back("highway", "residential");
  const int a = osm.node(10, 150), b = osm.node(80, 150), c = osm.node(220, 150), d = osm.node(290, 150);
  osm.way({a, b}, {{"highway", "residential"}});
  osm.way({b, c}, tags);
  osm.way({c, d}, {{"highway", "residential"}});
  osm.way({osm.node(150, 10), osm.node(150, 290)}, {{"highway", "residential"}});
  return osm;
}

TEST_F(OddData, bridge_and_tunnel_at_once) {
  for (const auto& [layer, taken_for] : {std::pair{"1", "bridge"}, {"", "bridge"}, {"-1", "tunnel"}}) {
    std::vector<std::pair<std::string, std::string>> tags{{"bridge", "yes"}, {"tunnel", "yes"}};
    if (*layer) tags.emplace_back("layer", layer);
    const Driven driven = drive_osm(crossing(tags));
    driven.expect_finding("elevate.contradicting_tags", std::string("taken for a ") + taken_for);
    EXPECT_EQ(driven.scores["crossings"], 1);
    EXPECT_GE(driven.scores["min_clearance_m"].get<double>(), 4.7);
    std::size_t bridges = 0, tunnels = 0;
    for (const roadquery::Road& road : driven.map.roads) bridges += road.bridge, tunnels += road.tunnel;
    EXPECT_EQ(bridges, taken_for == std::string("bridge") ? 1u : 0u) << "the network says the same as the heights";
    EXPECT_EQ(tunnels, taken_for == std::string("tunnel") ? 1u : 0u);
  }
}

TEST_F(OddData, three_lanes_on_four_metres) {
  OsmText osm;
  const int middle = osm.node(150, 160);
  osm.way({osm.node(10, 150), middle, osm.node(290, 150)},
          {{"highway", "residential"}, {"lanes", "3"}, {"width", "4"}});
  osm.way({middle, osm.node(150, 10)}, {{"highway", "residential"}});
  const Driven driven = drive_osm(osm);
  driven.expect_finding("network.too_many_lanes", "3 lanes do not fit in 4.0 m, took 2");
}

TEST_F(OddData, a_roundabout_that_is_not_closed) {
  for (const int last : {14, 15}) {  // of 16 nodes: gaps of two and of one
    OsmText osm;
    std::vector<int> ring;
    for (int i = 0; i <= last; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / 16.0;
      ring.push_back(osm.node(150.0 + 15.0 * std::cos(angle), 150.0 + 15.0 * std::sin(angle)));
    }
    osm.way(ring, {{"highway", "tertiary"}, {"junction", "roundabout"}});
    osm.way({ring[0], osm.node(290, 150)}, {{"highway", "tertiary"}});
    osm.way({ring[4], osm.node(150, 290)}, {{"highway", "tertiary"}});
    osm.way({ring[8], osm.node(10, 150)}, {{"highway", "tertiary"}});
    osm.way({ring[12], osm.node(150, 10)}, {{"highway", "tertiary"}});
    const Driven driven = drive_osm(osm);
    driven.expect_finding("network.roundabout_closed", "closed the gap");
    EXPECT_EQ(driven.scores["connected_share"], 1.0);
    EXPECT_EQ(driven.scores["junctions"], 4);
  }
}

TEST_F(OddData, nine_roads_meet_in_one_node) {
  const double angles_deg[] = {0, 12, 25, 80, 95, 170, 190, 250, 330};  // as close as roads get
  OsmText osm;
  const int middle = osm.node(150, 150);
  const char* const classes[] = {"primary", "secondary", "tertiary", "residential", "service"};
  for (int i = 0; i < 9; ++i) {
    const double angle = angles_deg[i] * std::numbers::pi / 180.0;
    osm.way({middle, osm.node(150.0 + 140.0 * std::cos(angle), 150.0 + 140.0 * std::sin(angle))},
            {{"highway", classes[i % 5]}});
  }
  const Driven driven = drive_osm(osm);
  driven.expect_finding("network.many_roads", "9 roads meet in one junction");
  EXPECT_EQ(driven.scores["junctions"], 1);
  EXPECT_EQ(driven.scores["connected_share"], 1.0);
  EXPECT_GE(driven.scores["connecting_roads"].get<int>(), 9 * 5);
}

/// A drive round the circuit of the site at 10 m/s, ten poses a second: place and what the log says of it.
struct Pose {
  double time_s = 0.0;
  Vec2 p;
  double z_m = 0.0, climb_mps = 0.0;
  Vec2 direction;
};
std::vector<Pose> drive_round(const RoadNetwork& truth) {
  std::vector<Pose> poses;
  for (const RoadPath& path : truth.paths) {
    if (path.osm_id != 100) continue;
    for (std::size_t n = 0; n + 1 < path.nodes.size(); ++n) {
      const RoadNode &a = path.nodes[n], &b = path.nodes[n + 1];
      const double run_m = distance(a.p, b.p);
      for (int i = 0; i < 2; ++i)
        poses.push_back({0.1 * static_cast<double>(poses.size()), a.p + (b.p - a.p) * (0.5 * i),
                         a.z_m + (b.z_m - a.z_m) * 0.5 * i, 10.0 * a.gradient, (b.p - a.p) * (1.0 / run_m)});
    }
  }
  return poses;
}
/// Five seconds without a pose, and two seconds 30 m to the side.
std::vector<Pose> with_a_gap_and_jumps(std::vector<Pose> poses) {
  const auto from = [&](double share) {
    return static_cast<std::ptrdiff_t>(share * static_cast<double>(poses.size()));
  };
  for (auto i = from(0.6); i < from(0.6) + 20; ++i)
    poses[static_cast<std::size_t>(i)].p = poses[static_cast<std::size_t>(i)].p + Vec2{30, 5};
  poses.erase(poses.begin() + from(0.3), poses.begin() + from(0.3) + 50);
  return poses;
}

void expect_drivable_log(const Driven& driven) {
  driven.expect_finding("drive_log.gap", "the log is split there");
  driven.expect_finding("drive_log.jump", "the log is split there");
  for (const RoadPath& path : driven.roads.paths)
    for (const RoadNode& node : path.nodes) {
      EXPECT_LT(std::abs(node.gradient), 0.15);
      EXPECT_LT(std::abs(node.banking), 0.1);
    }
}

TEST_F(OddData, csv_log_with_a_gap_and_jumps) {
  const CoordinateTransform lonlat(utm33, Crs{"EPSG:4326"});
  std::string text = "time_s,lat,lon,alt_m,climb_mps,speed_mps\n";
  for (const Pose& pose : with_a_gap_and_jumps(drive_round(io::read_roads(true_roads())))) {
    const Vec2 p = lonlat.target_from_source(pose.p);
    text += fmt::format("{:.2f},{:.9f},{:.9f},{:.3f},{:.3f},10\n", pose.time_s, p.y, p.x, pose.z_m, pose.climb_mps);
  }
  write_bytes(scratch_ / "drive.csv", text);
  const Driven driven = drive(true_roads(), {site_ / "dtm_10m.tif"}, {scratch_ / "drive.csv"});
  expect_drivable_log(driven);
  const HeightError error = height_error(driven);
  EXPECT_LT(error.mean_m, 0.1);
  EXPECT_LT(error.largest_m, 1.0);
}

TEST_F(OddData, comma2k19_log_with_a_gap_and_jumps) {
  const CoordinateTransform lonlat(utm33, Crs{"EPSG:4326"});
  std::vector<double> times, places, speeds;
  for (const Pose& pose : with_a_gap_and_jumps(drive_round(io::read_roads(true_roads())))) {
    const Vec2 p = lonlat.target_from_source(pose.p);
    const Vec2 ahead = lonlat.target_from_source(pose.p + pose.direction * 10.0);
    const Vec3 here = ecef_from_geographic(p.x, p.y, pose.z_m),
               there = ecef_from_geographic(ahead.x, ahead.y, pose.z_m + pose.climb_mps);
    times.push_back(pose.time_s);
    for (const double x : {here.x, here.y, here.z}) places.push_back(x);
    for (const double x : {there.x - here.x, there.y - here.y, there.z - here.z}) speeds.push_back(x);
  }
  fs::create_directories(scratch_ / "segment/pose");
  const std::string rows = std::to_string(times.size());
  write_bytes(scratch_ / "segment/pose/times.npy", npy("<f8", "(" + rows + ",)", times));
  write_bytes(scratch_ / "segment/pose/positions_ecef.npy", npy("<f8", "(" + rows + ", 3)", places));
  write_bytes(scratch_ / "segment/pose/velocities_ecef.npy", npy("<f8", "(" + rows + ", 3)", speeds));
  const Driven driven = drive(true_roads(), {site_ / "dtm_10m.tif"}, {scratch_ / "segment"});
  expect_drivable_log(driven);
  const HeightError error = height_error(driven);
  EXPECT_LT(error.mean_m, 0.1);
  EXPECT_LT(error.largest_m, 1.0);
}

}  // namespace
}  // namespace orthodrive
