// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/pipeline/sources/site.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "orthodrive/core/atomic_file.hpp"
#include "orthodrive/core/error.hpp"
#include "paths.hpp"

namespace orthodrive {
namespace {
namespace fs = std::filesystem;
using testing::HasSubstr;

const std::string sources = "[sources]\nphoto='p.tif'\nosm='r.osm'\ndtm=['a.tif','b.tif']\n";
const std::string area = "[area]\nbbox_wgs84=[12.008, 57.6495, 12.044, 57.6625]\n";

fs::path site_file(const std::string& text) {
  const fs::path path = fs::temp_directory_path() / "orthodrive_site_test" / "site.toml";
  write_text_file(path, text);
  return path;
}

template <typename E>
std::string site_message_of(const std::string& text, const std::vector<std::string>& overrides = {}) {
  try {
    (void)read_site(site_file(text), overrides);
  } catch (const E& error) {
    return error.what();
  }
  return "no error of that kind";
}

TEST(Site, a_box_of_degrees_becomes_a_turned_polygon_in_the_utm_zone) {
  const Site site = read_site(site_file("name='K'\n" + area + sources));
  EXPECT_EQ(site.frame.crs.definition, "EPSG:32633");
  const Box2 box = bounds_of(site.frame.area.outer);
  EXPECT_NEAR(area_m2(site.frame.area), 2147.0 * 1448.0, 20000.0);
  EXPECT_GT(box.width() * box.height(), 1.05 * area_m2(site.frame.area));  // turned by the convergence
  ASSERT_EQ(site.photos.size(), 1u);
  EXPECT_EQ(site.photos[0].filename(), "p.tif");
  EXPECT_TRUE(site.photos[0].is_absolute());
  EXPECT_EQ(site.dtm.size(), 2u);
  EXPECT_EQ(site.osm.size(), 1u);
}

TEST(Site, photos_keep_their_order_and_each_must_be_there) {
  const fs::path file = site_file(area + "[sources]\nphoto = [\n  'b.tif',\n  'a.tif',\n]\nosm='r.osm'\ndtm='a.tif'\n");
  for (const char* name : {"b.tif", "r.osm"}) write_text_file(file.parent_path() / name, "");
  const Site site = read_site(file);
  ASSERT_EQ(site.photos.size(), 2u);
  EXPECT_EQ(site.photos[0].filename(), "b.tif");
  EXPECT_EQ(site.photos[1].filename(), "a.tif");
  try {
    require_site_files(site);
    ADD_FAILURE() << "a.tif is not there";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("site.toml:4: 'photo': there is no "));
    EXPECT_THAT(error.what(), HasSubstr("a.tif; correct the path"));
  }
  for (const char* name : {"b.tif", "r.osm"}) fs::remove(file.parent_path() / name);
}

TEST(Site, overrides_take_toml_values_and_bare_words) {
  const Site site = read_site(site_file(area + sources), {"drive.route=Circuit", "sources.dtm=['c.tif']", "name=Other",
                                                          "scene.roads=highway/raceway"});
  EXPECT_EQ(site.route, "Circuit");
  EXPECT_EQ(site.name, "Other");
  EXPECT_EQ(site.scene_roads, std::vector<std::string>{"highway/raceway"});
  ASSERT_EQ(site.dtm.size(), 1u);
  EXPECT_EQ(site.dtm[0].filename(), "c.tif");
}

TEST(Site, weather_is_dry_or_wet) {
  EXPECT_EQ(read_site(site_file(area + sources)).weather, Weather::dry);
  EXPECT_EQ(read_site(site_file(area + sources + "[network]\nweather = \"wet\"\n")).weather, Weather::wet);
  EXPECT_THAT(site_message_of<OptionError>(area + sources, {"network.weather=snow"}),
              HasSubstr("--set network.weather=snow: 'network.weather' must be dry or wet"));
}

TEST(Site, the_network_adapts_to_a_site_that_asks_for_it) {
  EXPECT_FALSE(read_site(site_file(area + sources)).adapt);
  EXPECT_TRUE(read_site(site_file(area + sources + "[segment]\nadapt = true\n")).adapt);
  EXPECT_THAT(site_message_of<OptionError>(area + sources, {"segment.adapt=very"}),
              HasSubstr("'segment.adapt' must be true or false"));
}

TEST(Site, drive_logs_are_sources_that_a_site_may_have) {
  EXPECT_TRUE(read_site(site_file(area + sources)).drive_logs.empty());
  const Site site = read_site(site_file(area + sources + "drive_logs=['a.csv', 'comma/segment']\n"));
  ASSERT_EQ(site.drive_logs.size(), 2u);
  EXPECT_TRUE(site.drive_logs[1].is_absolute());
  EXPECT_EQ(site.drive_logs[1].filename(), "segment");
}

TEST(Site, height_control_points_are_sources_that_a_site_may_have) {
  EXPECT_TRUE(read_site(site_file(area + sources)).control_points.empty());
  const Site site = read_site(site_file(area + sources + "control_points='heights.geojson'\n"));
  ASSERT_EQ(site.control_points.size(), 1u);
  EXPECT_EQ(site.control_points[0].filename(), "heights.geojson");
}

TEST(Site, gpx_tracks_are_sources_that_a_site_may_have) {
  const Site without = read_site(site_file(area + sources));
  EXPECT_TRUE(without.gpx.empty());
  EXPECT_EQ(without.driving_side, DrivingSide::right);
  const Site site = read_site(site_file(area + sources + "gpx=['a.gpx', 'b/c.gpx']\n[refine]\ndriving_side='left'\n"));
  ASSERT_EQ(site.gpx.size(), 2u);
  EXPECT_TRUE(site.gpx[1].is_absolute());
  EXPECT_EQ(site.gpx[1].filename(), "c.gpx");
  EXPECT_EQ(site.driving_side, DrivingSide::left);
  EXPECT_THAT(site_message_of<InputError>(area + sources + "[refine]\ndriving_side='up'\n"),
              HasSubstr("site.toml:8: 'refine.driving_side' must be right or left, not 'up'"));
}

TEST(Site, one_drives_where_the_country_of_the_place_says) {
  const auto side_at = [](const std::string& box, const std::string& more = "") {
    return read_site(site_file("[area]\nbbox_wgs84 = [" + box + "]\n" + sources + more));
  };
  const Site london = side_at("-0.13, 51.50, -0.11, 51.51");
  EXPECT_EQ(london.driving_side, DrivingSide::left);
  ASSERT_EQ(london.findings.size(), 1u);
  EXPECT_EQ(london.findings[0].code, "site.driving_side");
  EXPECT_EQ(london.findings[0].severity, Severity::info);
  EXPECT_EQ(london.findings[0].message, "one drives on the left here (United Kingdom)");
  EXPECT_NEAR(london.findings[0].x_m, 699000.0, 1000.0);  // on the map, in UTM 30
  EXPECT_EQ(side_at("139.69, 35.68, 139.71, 35.69").driving_side, DrivingSide::left);
  EXPECT_EQ(side_at("151.20, -33.88, 151.21, -33.87").driving_side, DrivingSide::left);
  EXPECT_EQ(side_at("33.35, 35.17, 33.36, 35.18").driving_side, DrivingSide::left);
  for (const char* right : {"1.85, 50.95, 1.86, 50.96", "114.05, 22.55, 114.06, 22.56", "-5.36, 36.13, -5.35, 36.14"}) {
    EXPECT_EQ(side_at(right).driving_side, DrivingSide::right) << right;
    EXPECT_TRUE(side_at(right).findings.empty()) << right;
  }
  const Site odd = side_at("-0.13, 51.50, -0.11, 51.51", "[refine]\ndriving_side = 'right'\n");
  EXPECT_EQ(odd.driving_side, DrivingSide::right);
  ASSERT_EQ(odd.findings.size(), 1u);
  EXPECT_EQ(odd.findings[0].severity, Severity::warning);
  EXPECT_EQ(odd.findings[0].message, "refine.driving_side is right, but one drives on the left here (United Kingdom)");
  EXPECT_TRUE(side_at("-0.13, 51.50, -0.11, 51.51", "[refine]\ndriving_side = 'left'\n").findings.empty());
  // Bounds in metres: the place is found by their CRS, and one that is not on earth is refused where it stands.
  const auto bounds = [](const std::string& box) {
    return "[area]\nbounds = [" + box + "]\ncrs = 'EPSG:27700'\n" + sources;
  };
  EXPECT_EQ(read_site(site_file(bounds("530000, 180000, 531000, 181000"))).driving_side, DrivingSide::left);
  EXPECT_THAT(site_message_of<InputError>(bounds("1e12, 1e12, 1.1e12, 1.1e12")),
              HasSubstr("site.toml:2: 'area.bounds'"));
}

TEST(Site, network_files_are_chosen_in_their_section) {
  const Site plain = read_site(site_file(area + sources));
  EXPECT_TRUE(plain.crg.empty());
  EXPECT_EQ(plain.opendrive, "1.7");
  const Site site =
      read_site(site_file(area + sources + "[network]\ncrg=['way/7', 'all-of-route']\nopendrive='1.8'\n"));
  EXPECT_EQ(site.crg, (std::vector<std::string>{"way/7", "all-of-route"}));
  EXPECT_EQ(site.opendrive, "1.8");
  EXPECT_THAT(site_message_of<InputError>(area + sources + "[network]\nopendrive='1.6'\n"),
              HasSubstr("network.opendrive"));
}

/// What a site file says of itself, after the name of the file.
struct Mistake {
  std::string text, message;
};

void expect_told(const std::vector<Mistake>& mistakes) {
  for (const Mistake& mistake : mistakes) {
    SCOPED_TRACE(mistake.text);
    const std::string message = site_message_of<InputError>(mistake.text);
    EXPECT_THAT(message, HasSubstr("site.toml"));
    EXPECT_THAT(message, HasSubstr(mistake.message));
    EXPECT_EQ(message.find('\n'), std::string::npos);
  }
}

TEST(Site, mistakes_are_told_with_line_key_and_what_was_meant) {
  const std::vector<Mistake> mistakes{
      {"name = \n", ":1: "},
      {area + sources + "[scene]\nroad='x'\n", ":8: 'scene.road' is not known here; did you mean 'roads'?"},
      {area + sources + "[drive]\nrute='x'\n", ":8: 'drive.rute' is not known here; did you mean 'route'?"},
      {area + sources + "[dirve]\nroute='x'\n", ":7: 'dirve' is not known here; did you mean 'drive'?"},
      {area + sources + "[xyz]\n", ":7: 'xyz' is not known here; known are: area, attribution, "},
      {area + "[sources]\nfoto='p.tif'\nosm='r.osm'\ndtm='a.tif'\n",
       ":4: 'sources.foto' is not known here; did you mean"},
      {area + "[sources]\nphoto='p.tif'\ndtm='a.tif'\n", ":3: 'sources.osm' is missing here"},
      {area, ": 'sources.photo' is missing here"},
      {area + "sources = 3\n", ":3: 'area.sources' is not known here"},
      {"sources = 3\n" + area, ":1: 'sources' must be a section: [sources]"},
      {area + sources + "[segment]\ncrf='yes'\n", ":8: 'segment.crf' must be true or false"},
      {area + sources + "[segment]\nmodel=7\n", ":8: 'segment.model' must be a text"},
      {area + sources + "gpx=[1]\n", ":7: 'sources.gpx' has an entry of the wrong type"},
      {area + sources + "gpx=1\n", ":7: 'sources.gpx' must be a text or a list of texts"},
      {area + sources + "trees=''\n", ":7: 'sources.trees' is empty"},
      {area + sources + "[elevate]\nsampling='cubik'\n",
       ":8: 'elevate.sampling' must be bilinear or cubic, not 'cubik'; did you mean 'cubic'?"},
      {area + sources + "[network]\njunction_grids=true\n", ":8: 'network.junction_grids' needs network.opendrive"},
      {area + "[sources]\nphoto=[]\nosm='r.osm'\ndtm='a.tif'\n", ":4: 'sources.photo' is an empty list; name a file"},
      {area + "[sources]\nphoto=['a.tif','b.tif','./a.tif']\nosm='r.osm'\ndtm='a.tif'\n",
       ":4: 'sources.photo' names a.tif twice; name each photo once, the best first"},
      {area + "[sources]\nphoto=['a.tif',2]\nosm='r.osm'\ndtm='a.tif'\n",
       ":4: 'sources.photo' has an entry of the wrong type"},
      {area + "[sources]\nphoto=['a.tif','']\nosm='r.osm'\ndtm='a.tif'\n", ":4: 'sources.photo' is empty"},
      {area + "[sources]\nphoto='WMTS:https://x/y.xml'\nosm='r.osm'\ndtm='a.tif'\n", "an address and no file"},
  };
  expect_told(mistakes);
  EXPECT_THAT(site_message_of<OptionError>(area + sources, {"nonsense"}), HasSubstr("section.key=value"));
  EXPECT_THAT(site_message_of<OptionError>(area + sources, {"sources.foto=x.tif"}),
              HasSubstr("--set sources.foto=x.tif: 'sources.foto' is not known here; did you mean 'photo'?"));
  EXPECT_THAT(site_message_of<OptionError>(area + sources, {"drive.route=[1]"}), HasSubstr("--set drive.route=[1]: "));
  EXPECT_THROW((void)read_site("/nonexistent/site.toml"), InputError);
}

TEST(Site, mistakes_of_the_area_are_told) {
  expect_told({
      {sources, ": [area] needs one of bbox_wgs84"},
      {"[area]\n" + sources, ":1: [area] needs one of bbox_wgs84"},
      {"[area]\nbbox_wgs84=[12.1, 57, 12.0, 57.1]\n" + sources,
       ":2: 'area.bbox_wgs84': 12.1,57,12,57.1: west is east of east, need west,south,east,north in degrees; did you "
       "mean 12,57,12.1,57.1?"},
      {"[area]\nbbox_wgs84=[12.1, 57, 12.0]\n" + sources, ":2: 'area.bbox_wgs84' must be [west, south, east, north]"},
      {"[area]\nbounds=[0, 0, 100, 100]\n" + sources, ":2: 'area.bounds' needs area.crs"},
      {"[area]\ncrs='EPSG:1'\nbounds=[0, 0, 100, 100]\n" + sources, ":2: 'area.crs': CRS 'EPSG:1' is unknown"},
      {"[area]\ncrs='EPSG:4326'\nbounds=[0, 0, 100, 100]\n" + sources, ":2: 'area.crs': CRS 'EPSG:4326' has degrees"},
      {"[area]\ncrs='EPSG:3857'\nbounds=[1800000, 6400000, 1801000, 6401000]\n" + sources,
       ":2: 'area.crs': CRS 'EPSG:3857' has a unit of 0.64"},
      {"[area]\nbbox_wgs84=[12.0, 57.0, 12.1, 57.1]\ncrs='EPSG:3857'\n" + sources,
       ":3: 'area.crs': CRS 'EPSG:3857' has a unit of 0.54"},
      {"[area]\nbbox_wgs84=[-74.0, 40.7, -73.9, 40.8]\ncrs='EPSG:2263'\n" + sources,
       ":3: 'area.crs': CRS 'EPSG:2263' has a unit of 0.305 m"},
      {"[area]\nbbox_wgs84=[12.0, 57.0, 12.1, 57.1]\ncrs='EPSG:4258'\n" + sources,
       ":3: 'area.crs': CRS 'EPSG:4258' has degrees"},
      {"[area]\ncrs='EPSG:32633'\nbounds=[0, 0, 100, 30]\n" + sources, ":3: 'area.bounds': is 100 x 30 m"},
      {"[area]\npolygon=[[12.0,57.0],[12.1,57.0],[12.1,57.1]]\n" + sources, "ring 1 of a polygon is not closed"},
      {"[area]\npolygon=[[12.0,57.0],[12.1,57.1],[12.1,57.0],[12.0,57.1],[12.0,57.0]]\n" + sources,
       "its outer ring crosses or touches itself near 12.050000, 57.050000"},
      {"[area]\npolygon='none.geojson'\n" + sources, ":2: 'area.polygon': "},
  });
}

TEST(Site, a_polygon_is_an_area_inline_or_out_of_geojson) {
  const std::string ring = "[[12.0,57.0],[12.1,57.0],[12.05,57.1],[12.0,57.0]]";
  const Site inline_ring = read_site(site_file("[area]\npolygon=" + ring + "\n" + sources));
  EXPECT_EQ(inline_ring.frame.crs.definition, "EPSG:32633");
  EXPECT_NEAR(area_m2(inline_ring.frame.area), 0.5 * 6080.0 * 11140.0, 2e5);
  const std::string hole = "[[12.04,57.01],[12.04,57.02],[12.06,57.02],[12.04,57.01]]";
  const Site with_hole = read_site(site_file("[area]\npolygon=[" + ring + "," + hole + "]\n" + sources));
  ASSERT_EQ(with_hole.frame.area.holes.size(), 1u);
  EXPECT_LT(area_m2(with_hole.frame.area), area_m2(inline_ring.frame.area));

  const fs::path file = site_file("[area]\npolygon='place.geojson'\n" + sources);
  const auto geojson = [&](const std::string& geometry) {
    write_text_file(
        file.parent_path() / "place.geojson",
        R"({"type":"FeatureCollection","features":[{"type":"Feature","properties":{},"geometry":)" + geometry + "}]}");
  };
  geojson(R"({"type":"Polygon","coordinates":[)" + ring + "]}");
  EXPECT_EQ(read_site(file).frame.area.outer, inline_ring.frame.area.outer);
  geojson(R"({"type":"MultiPolygon","coordinates":[[)" + ring + "],[" + hole + "]]}");
  EXPECT_THAT([&] { (void)read_site(file); }, testing::ThrowsMessage<InputError>(HasSubstr("holds 2 polygons")));
  geojson(
      R"({"type":"Polygon","coordinates":[[[500000,6000000],[500100,6000000],[500100,6000100],[500000,6000000]]]})");
  EXPECT_THAT([&] { (void)read_site(file); }, testing::ThrowsMessage<InputError>(HasSubstr("save it in WGS84")));
  geojson(R"({"type":"Point","coordinates":[12,57]})");
  EXPECT_THAT([&] { (void)read_site(file); }, testing::ThrowsMessage<InputError>(HasSubstr("holds no polygon")));
  write_text_file(file.parent_path() / "place.geojson", "{");
  EXPECT_THAT([&] { (void)read_site(file); }, testing::ThrowsMessage<InputError>(HasSubstr("is no GeoJSON")));
}

TEST(Site, a_file_that_is_not_there_is_told_with_its_line) {
  const fs::path file = site_file(area + sources + "[truth]\ndir = 'truth'\n");
  const Site site = read_site(file);  // reading alone looks for no source: they may still have to be fetched
  for (const char* name : {"a.tif", "b.tif", "p.tif", "r.osm"}) {
    fs::remove(file.parent_path() / name);
  }
  EXPECT_THAT([&] { require_site_files(site); },
              testing::ThrowsMessage<InputError>(AllOf(HasSubstr("site.toml:6: 'dtm'"), HasSubstr("a.tif"))));
  for (const char* name : {"a.tif", "b.tif", "p.tif"}) write_text_file(file.parent_path() / name, "");
  EXPECT_THAT([&] { require_site_files(site); }, testing::ThrowsMessage<InputError>(HasSubstr("site.toml:5: 'osm'")));
  write_text_file(file.parent_path() / "r.osm", "");
  EXPECT_THAT([&] { require_site_files(site); }, testing::ThrowsMessage<InputError>(HasSubstr("site.toml:8: 'dir'")));
  fs::create_directories(file.parent_path() / "truth");
  EXPECT_NO_THROW(require_site_files(site));
  fs::remove_all(file.parent_path());
}

TEST(Site, an_area_far_from_its_meridian_is_a_finding) {
  EXPECT_TRUE(read_site(site_file(area + sources)).findings.empty());
  const Site site = read_site(site_file("[area]\ncrs='EPSG:32631'\nbbox_wgs84=[12.0, 57, 12.1, 57.1]\n" + sources));
  ASSERT_EQ(site.findings.size(), 1u);
  EXPECT_EQ(site.findings[0].code, "area.off_meridian");
  EXPECT_THAT(site.findings[0].message, HasSubstr("9.1 degrees"));
  EXPECT_TRUE(std::isfinite(site.findings[0].x_m));
}

TEST(Site, the_sites_of_the_repository_parse) {
  for (const char* name : {"kvarnbyn", "pardubice"}) {
    const Site site = read_site(paths::in_source("sites") / (std::string(name) + ".toml"));
    EXPECT_FALSE(site.attribution.empty()) << name;
    EXPECT_EQ(site.frame.crs.definition, "EPSG:32633") << name;
  }
}

}  // namespace
}  // namespace orthodrive
