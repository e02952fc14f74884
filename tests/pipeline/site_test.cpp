#include "orthodrive/pipeline/site.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

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
std::string message_of(const std::string& text, const std::vector<std::string>& overrides = {}) {
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
  EXPECT_EQ(site.photo.filename(), "p.tif");
  EXPECT_TRUE(site.photo.is_absolute());
  EXPECT_EQ(site.dtm.size(), 2u);
  EXPECT_EQ(site.osm.size(), 1u);
}

TEST(Site, overrides_take_toml_values_and_bare_words) {
  const Site site =
      read_site(site_file(area + sources), {"drive.route=Circuit", "sources.dtm=['c.tif']", "name=Other"});
  EXPECT_EQ(site.route, "Circuit");
  EXPECT_EQ(site.name, "Other");
  ASSERT_EQ(site.dtm.size(), 1u);
  EXPECT_EQ(site.dtm[0].filename(), "c.tif");
}

TEST(Site, weather_is_dry_or_wet) {
  EXPECT_EQ(read_site(site_file(area + sources)).weather, Weather::dry);
  EXPECT_EQ(read_site(site_file(area + sources + "[network]\nweather = \"wet\"\n")).weather, Weather::wet);
  EXPECT_THAT(message_of<OptionError>(area + sources, {"network.weather=snow"}), HasSubstr("must be dry or wet"));
}

TEST(Site, the_network_adapts_to_a_site_that_asks_for_it) {
  EXPECT_FALSE(read_site(site_file(area + sources)).adapt);
  EXPECT_TRUE(read_site(site_file(area + sources + "[segment]\nadapt = true\n")).adapt);
  EXPECT_THAT(message_of<OptionError>(area + sources, {"segment.adapt=very"}),
              HasSubstr("segment.adapt must be true or false"));
}

TEST(Site, drive_logs_are_sources_that_a_site_may_have) {
  EXPECT_TRUE(read_site(site_file(area + sources)).drive_logs.empty());
  const Site site = read_site(site_file(area + sources + "drive_logs=['a.csv', 'comma/segment']\n"));
  ASSERT_EQ(site.drive_logs.size(), 2u);
  EXPECT_TRUE(site.drive_logs[1].is_absolute());
  EXPECT_EQ(site.drive_logs[1].filename(), "segment");
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
  EXPECT_THAT(message_of<OptionError>(area + sources + "[refine]\ndriving_side='up'\n"), HasSubstr("driving_side"));
}

TEST(Site, network_files_are_chosen_in_their_section) {
  const Site plain = read_site(site_file(area + sources));
  EXPECT_TRUE(plain.crg.empty());
  EXPECT_EQ(plain.opendrive, "1.7");
  const Site site =
      read_site(site_file(area + sources + "[network]\ncrg=['way/7', 'all-of-route']\nopendrive='1.8'\n"));
  EXPECT_EQ(site.crg, (std::vector<std::string>{"way/7", "all-of-route"}));
  EXPECT_EQ(site.opendrive, "1.8");
  EXPECT_THAT(message_of<OptionError>(area + sources + "[network]\nopendrive='1.6'\n"), HasSubstr("network.opendrive"));
}

TEST(Site, mistakes_are_told_with_file_and_place) {
  EXPECT_THAT(message_of<OptionError>(area + sources + "[drive]\nrute='x'\n"),
              AllOf(HasSubstr("drive.rute"), HasSubstr("route")));
  EXPECT_THAT(message_of<InputError>("name = \n"), HasSubstr("line 1"));
  EXPECT_THAT(message_of<OptionError>(sources), HasSubstr("[area]"));
  EXPECT_THAT(message_of<OptionError>(area), HasSubstr("sources.photo"));
  EXPECT_THAT(message_of<OptionError>("[area]\nbbox_wgs84=[12.1, 57, 12.0, 58]\n" + sources), HasSubstr("west < east"));
  EXPECT_THAT(message_of<OptionError>("[area]\nbounds=[0, 0, 10, 10]\n" + sources), HasSubstr("area.crs"));
  EXPECT_THAT(message_of<Error>("[area]\ncrs='EPSG:1'\nbounds=[0, 0, 10, 10]\n" + sources), HasSubstr("EPSG:1"));
  EXPECT_THAT(message_of<OptionError>(area + sources, {"nonsense"}), HasSubstr("section.key=value"));
  EXPECT_THROW((void)read_site("/nonexistent/site.toml"), InputError);
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
