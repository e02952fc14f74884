// SPDX-License-Identifier: Apache-2.0
// The catalogue that comes with the tool, and site files made of it. Nothing here asks a server.

#include "orthodrive/pipeline/sources/catalogue.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "io/scratch.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/pipeline/sources/new_site.hpp"
#include "orthodrive/pipeline/sources/site.hpp"
#include "paths.hpp"

namespace orthodrive {
namespace {
using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;
using testing::ThrowsMessage;

const Catalogue& catalogue() {
  static const Catalogue read = read_catalogue(paths::in_source("catalogue"));
  return read;
}

const CatalogueSource& source(const std::string& id) {
  for (const CatalogueSource& entry : catalogue().sources)
    if (entry.id == id) return entry;
  throw Error("no source " + id);
}

Polygon around(double lon, double lat, double half_deg = 0.01) {
  return polygon_of_box({lon - half_deg, lat - half_deg, lon + half_deg, lat + half_deg});
}

NewSiteOptions area_at(double lon, double lat, double half_deg = 0.01) {
  return {.name = "Here",
          .area = around(lon, lat, half_deg),
          .box = LonLatBox{lon - half_deg, lat - half_deg, lon + half_deg, lat + half_deg}};
}

TEST(Catalogue, every_entry_is_complete) {
  std::set<std::string> whats;
  for (const CatalogueSource& entry : catalogue().sources) {
    SCOPED_TRACE(entry.id);
    whats.insert(entry.what);
    for (const std::string* text :
         {&entry.name, &entry.licence, &entry.licence_url, &entry.attribution, &entry.checked, &entry.checked_against})
      EXPECT_FALSE(text->empty());
    EXPECT_TRUE(entry.licence_url.starts_with("https://"));
    if (entry.kind == "wmts") {
      EXPECT_FALSE(entry.layer.empty());
      EXPECT_FALSE(entry.tile_matrix_set.empty());
    }
    if (entry.kind == "wms") {
      EXPECT_FALSE(entry.layer.empty());
    }
    if (entry.kind == "xyz") {
      for (const char* field : {"{z}", "{x}", "{y}"}) EXPECT_THAT(entry.url, HasSubstr(field));
    }
    // A url with fields of cells has cells, and the other way round.
    const bool has_fields = entry.url.find("{west") != std::string::npos ||
                            entry.url.find("{sw}") != std::string::npos ||
                            entry.url.find("{nw}") != std::string::npos || entry.url.find("{row}") != std::string::npos;
    EXPECT_EQ(has_fields, entry.cells.has_value());
    if (entry.what == "photo") {
      EXPECT_LE(entry.resolution_m, 1.0);
    }
  }
  EXPECT_EQ(whats, (std::set<std::string>{"photo", "terrain", "osm"}));
  std::set<std::string> extracts;
  for (const CatalogueArea& area : catalogue().areas)
    if (!area.geofabrik.empty()) {  // Australia's states have no extract of their own
      EXPECT_TRUE(extracts.insert(area.geofabrik).second) << area.id;
    }
}

TEST(Catalogue, capitals_lie_in_their_countries_and_neighbours_do_not) {
  const std::vector<std::tuple<double, double, std::string>> places{
      {16.37, 48.21, "at-basemap"},       {7.45, 46.95, "ch-swissimage"},
      {2.35, 48.86, "fr-bdortho"},        {8.74, 41.92, "fr-bdortho"},
      {6.96, 50.94, "de-nw-dop"},         {11.58, 48.14, "de-by-dop20"},
      {4.90, 52.37, "nl-luchtfoto"},      {18.07, 59.33, "se-ortofoto"},
      {14.42, 50.09, "cz-ortofoto"},      {-104.99, 39.74, "us-naip"},
      {-80.19, 25.76, "us-naip"},         {139.77, 35.68, "jp-gsi-photo"},
      {127.68, 26.21, "jp-gsi-photo"},    {-3.70, 40.42, "es-pnoa"},
      {2.65, 39.57, "es-pnoa"},           {4.35, 50.85, "be-ngi"},
      {19.04, 47.50, "hu-oi2022"},        {21.01, 52.23, "pl-orto"},
      {24.75, 59.44, "ee-foto"},          {19.15, 48.74, "sk-zbgis"},
      {9.18, 48.78, "de-bw-dop20"},       {14.33, 51.76, "de-bb-dop20"},
      {8.68, 50.11, "de-he-dop20"},       {12.14, 54.09, "de-mv-dop20"},
      {9.73, 52.37, "de-ni-dop20"},       {7.77, 49.44, "de-rp-dop20"},
      {13.74, 51.05, "de-sn-dop20"},      {11.63, 52.13, "de-st-dop20"},
      {9.92, 54.31, "de-sh-dop20"},       {11.03, 50.98, "de-th-dop20"},
      {6.95, 49.35, "de-sl-dop20"},       {19.82, 41.33, "al-orto20"},
      {23.32, 42.70, "bg-maf"},           {33.04, 34.69, "cy-dls2014"},
      {12.57, 55.68, "dk-geodanmark"},    {24.94, 60.17, "fi-ortokuva"},
      {15.98, 45.81, "hr-dof2022"},       {-21.94, 64.15, "is-loftmynd"},
      {9.55, 47.13, "li-orthofoto"},      {25.28, 54.69, "lt-ort10lt"},
      {6.13, 49.61, "lu-ortho"},          {24.11, 56.95, "lv-orto"},
      {19.26, 42.44, "me-dof2018"},       {14.45, 35.90, "mt-ortho2018"},
      {-9.14, 38.72, "pt-ortos2025"},     {26.10, 44.43, "ro-aiga"},
      {14.51, 46.06, "si-dof025"},        {174.78, -41.29, "nz-linz"},
      {-79.38, 43.70, "ca-on-2018"},      {-71.30, 46.80, "ca-qc-imagerie"},
      {-63.58, 44.65, "ca-ns-ortho"},     {-66.64, 45.96, "ca-nb-geonb"},
      {151.00, -33.87, "au-nsw-imagery"}, {149.13, -35.28, "au-nsw-imagery"},
      {153.03, -27.47, "au-qld-imagery"}, {138.60, -34.93, "au-sa-mosaic"},
      {144.96, -37.75, "au-vic-aerial"}};
  for (const auto& [lon, lat, id] : places) {
    EXPECT_EQ(coverage_of(catalogue(), source(id), around(lon, lat)), 1.0) << id;
    for (const CatalogueSource& other : catalogue().sources) {
      if (other.what != "photo" || other.areas == source(id).areas) continue;
      EXPECT_EQ(coverage_of(catalogue(), other, around(lon, lat)), 0.0) << id << " in " << other.id;
    }
  }
  for (const auto& [lon, lat] : {std::pair{12.50, 41.90}, {10.75, 59.91}, {0.0, 0.0}})  // Rome, Oslo, the sea
    for (const CatalogueSource& other : catalogue().sources) {
      if (other.what != "photo") continue;
      EXPECT_EQ(coverage_of(catalogue(), other, around(lon, lat)), 0.0) << other.id;
    }
  const double half = coverage_of(catalogue(), source("de-by-dop20"), polygon_of_box({12.9, 47.9, 13.1, 48.1}));
  EXPECT_GT(half, 0.05);  // the border to Austria
  EXPECT_LT(half, 0.95);
}

TEST(Catalogue, laws_of_speed_are_found_by_place) {
  const std::vector<Country> countries = read_countries(paths::in_source("catalogue"));
  SpeedLaws laws = read_speed_laws(paths::in_source("catalogue"));
  EXPECT_GE(laws.laws.size(), 60u);
  constexpr double mile_km = 1.609344;
  // Berlin, Lyon, Roma, Oslo, Leeds, Denver, Sapporo, Auckland, Perth, Warszawa, Dublin, Madrid
  const std::vector<std::tuple<double, double, std::string, double, double>> places{
      {13.40, 52.52, "DE", 50, 100},
      {4.83, 45.76, "FR", 50, 80},
      {12.50, 41.90, "IT", 50, 90},
      {10.75, 59.91, "NO", 50, 80},
      {-1.55, 53.80, "GB", 30 * mile_km, 60 * mile_km},
      {141.35, 43.06, "JP", 60, 60},
      {174.76, -36.85, "NZ", 50, 100},
      {115.86, -31.95, "AU", 50, 100},
      {21.01, 52.23, "PL", 50, 90},
      {-3.70, 40.42, "ES", 30, 90}};
  for (const auto& [lon, lat, id, urban, rural] : places) {
    const Country* country = country_at(countries, {lon, lat});
    ASSERT_NE(country, nullptr) << id;
    EXPECT_EQ(country->id, id);
    laws.here = id;
    EXPECT_NEAR(speed_of_context(laws, "urban"), urban, 1e-6) << id;
    EXPECT_NEAR(speed_of_context(laws, "rural"), rural, 1e-6) << id;
  }
  for (const SpeedLaw& law : laws.laws)  // each is of a country that a place can have, or of a part of one
    EXPECT_TRUE(std::ranges::any_of(countries, [&](const Country& c) {
      return c.id == law.country.substr(0, law.country.find('-'));
    })) << law.country;
  EXPECT_EQ(country_at(countries, {0.0, 0.0}), nullptr) << "the sea";
  EXPECT_NO_THROW(check_country("SE"));
  const PlaceRules tokyo = rules_at({"EPSG:32654"}, {382000, 3948000, 384000, 3950000});
  EXPECT_EQ(tokyo.country, "JP");
  EXPECT_EQ(tokyo.driving_side, DrivingSide::left);
  EXPECT_EQ(rules_at({}, {0, 0, 1, 1}).driving_side, DrivingSide::right);
  EXPECT_THAT([] { check_country("SEE"); }, ThrowsMessage<OptionError>(HasSubstr("'SEE' is no country")));
}

struct KnownPlace {
  std::string law;
  double lon, lat;
};
// Capitals of all parts with a law of their own.
const std::vector<KnownPlace> capitals_of_parts{
    {"AU-NT", 130.84, -12.46}, {"AU-WA", 115.86, -31.95}, {"BE-BRU", 4.35, 50.85},   {"BE-VLG", 3.72, 51.05},
    {"BE-WAL", 4.87, 50.47},   {"CA-MB", -97.14, 49.90},  {"CA-NT", -114.37, 62.45}, {"CA-NU", -68.52, 63.75},
    {"CA-PE", -63.13, 46.24},  {"CA-QC", -71.21, 46.81},  {"CA-YT", -135.06, 60.72}, {"GB-NIR", -5.93, 54.60},
    {"GB-SCT", -3.19, 55.95},  {"GB-WLS", -3.18, 51.48},  {"US-AL", -86.30, 32.37},  {"US-AR", -92.29, 34.75},
    {"US-AZ", -112.07, 33.45}, {"US-CA", -121.49, 38.58}, {"US-CO", -104.99, 39.74}, {"US-CT", -72.68, 41.76},
    {"US-DC", -77.04, 38.90},  {"US-DE", -75.52, 39.16},  {"US-FL", -84.28, 30.44},  {"US-GA", -84.39, 33.75},
    {"US-ID", -116.20, 43.62}, {"US-IL", -89.65, 39.80},  {"US-IN", -86.16, 39.77},  {"US-KS", -95.68, 39.05},
    {"US-KY", -84.87, 38.20},  {"US-MA", -71.06, 42.36},  {"US-MD", -76.49, 38.98},  {"US-ME", -69.78, 44.31},
    {"US-MN", -93.09, 44.95},  {"US-MO", -92.17, 38.58},  {"US-MS", -90.18, 32.30},  {"US-MT", -112.04, 46.59},
    {"US-NC", -78.64, 35.78},  {"US-ND", -100.78, 46.81}, {"US-NE", -96.70, 40.81},  {"US-NH", -71.54, 43.21},
    {"US-NJ", -74.76, 40.22},  {"US-NM", -105.94, 35.69}, {"US-NV", -119.77, 39.16}, {"US-OR", -123.04, 44.94},
    {"US-RI", -71.41, 41.82},  {"US-SC", -81.03, 34.00},  {"US-SD", -100.35, 44.37}, {"US-TN", -86.78, 36.16},
    {"US-TX", -97.74, 30.27},  {"US-VA", -77.44, 37.54},  {"US-VT", -72.58, 44.26},  {"US-WA", -122.90, 47.04},
    {"US-WY", -104.82, 41.14}};
// Near borders, on islands, on both sides of a river; and in parts that have no law of their own.
const std::vector<KnownPlace> places_at_borders{
    {"US-MO", -94.578, 39.100}, {"US-KS", -94.640, 39.110}, {"US-NJ", -74.060, 40.720}, {"US", -74.000, 40.740},
    {"US-VA", -77.110, 38.870}, {"US-IL", -87.650, 41.850}, {"US-IN", -87.490, 41.600}, {"US", -83.080, 42.350},
    {"US-TX", -106.48, 31.770}, {"US-CA", -118.41, 33.390}, {"US-MA", -70.080, 41.280}, {"US-WA", -122.64, 45.660},
    {"US-OR", -122.68, 45.520}, {"US-NV", -119.95, 39.240}, {"CA-QC", -75.720, 45.480}, {"CA", -75.690, 45.400},
    {"CA", -83.020, 42.300},    {"CA", -79.380, 43.650},    {"BE-BRU", 4.340, 50.800},  {"BE-VLG", 4.430, 50.930},
    {"BE-WAL", 4.400, 50.710},  {"BE-VLG", 5.460, 50.780},  {"BE-WAL", 5.570, 50.630},  {"GB", -2.890, 53.190},
    {"GB-WLS", -3.000, 53.050}, {"GB", -2.930, 54.890},     {"GB-SCT", -3.070, 55.005}, {"GB-SCT", -1.150, 60.160},
    {"GB-NIR", -6.340, 54.180}, {"IE", -6.400, 54.000},     {"GB", -0.120, 51.500},     {"AU", 151.21, -33.870},
    {"MX", -117.03, 32.510},    {"BE-WAL", 2.930, 50.760},  {"FR", 2.35, 48.85},        {"DE", 13.40, 52.52}};

TEST(Catalogue, lines_along_roads_are_painted_as_the_country_does) {
  const std::vector<Country> countries = read_countries(paths::in_source("catalogue"));
  RoadMarkRules rules = read_road_marks(paths::in_source("catalogue"));
  EXPECT_GE(rules.rules.size(), 25u);
  for (const RoadMarkRule& rule : rules.rules) EXPECT_NE(country_of(countries, rule.country), nullptr) << rule.country;
  const auto color_at = [&](double lon, double lat) {
    rules.here = law_at(*country_at(countries, {lon, lat}), {lon, lat});
    return rule_here(rules).between_directions;
  };
  for (const auto& [lon, lat] : {std::pair{-104.99, 39.74}, {-79.38, 43.65}, {10.75, 59.91}, {126.98, 37.57}})
    EXPECT_EQ(color_at(lon, lat), "yellow") << lon;  // Denver, Toronto, Oslo, Seoul
  for (const auto& [lon, lat] : {std::pair{13.40, 52.52}, {18.07, 59.33}, {-1.55, 53.80}, {174.76, -36.85}})
    EXPECT_EQ(color_at(lon, lat), "standard") << lon;  // Berlin, Stockholm, Leeds, Auckland
}

TEST(Catalogue, laws_of_parts_are_found_by_place) {
  const std::vector<Country> countries = read_countries(paths::in_source("catalogue"));
  SpeedLaws laws = read_speed_laws(paths::in_source("catalogue"));
  const auto law_of = [&](const KnownPlace& place) {
    const Country* country = country_at(countries, {place.lon, place.lat});
    return country ? law_at(*country, {place.lon, place.lat}) : std::string("none");
  };
  std::set<std::string> with_law, with_place;
  for (const SpeedLaw& law : laws.laws)
    if (law.country.find('-') != std::string::npos) with_law.insert(law.country);
  for (const KnownPlace& place : capitals_of_parts) {
    EXPECT_EQ(law_of(place), place.law);
    with_place.insert(place.law);
    laws.here = place.law;
    const auto law = std::ranges::find(laws.laws, place.law, &SpeedLaw::country);
    ASSERT_NE(law, laws.laws.end()) << place.law;
    EXPECT_EQ(speed_of_context(laws, "urban"), law->urban) << place.law;
  }
  EXPECT_EQ(with_place, with_law);
  for (const KnownPlace& place : places_at_borders)
    EXPECT_EQ(law_of(place), place.law) << place.lon << " " << place.lat;
  const PlaceRules austin = rules_at({"EPSG:32614"}, {620000, 3348000, 622000, 3350000});
  EXPECT_EQ(austin.country, "US-TX");
  laws.here = "US-TX";
  EXPECT_NEAR(lawful_speed_kmh(laws, {.highway = "tertiary", .speed_context = "rural"}), 60 * 1.609344, 1e-9);
  EXPECT_EQ(rules_at({"EPSG:32755"}, {693000, 6092000, 694000, 6093000}).country, "AU")
      << "Canberra has the common law";
}

TEST(Catalogue, parts_of_countries_may_be_told) {
  EXPECT_NO_THROW(check_country("US-CA"));
  EXPECT_NO_THROW(check_country("BE-VLG"));
  EXPECT_THAT(
      [] { check_country("US-NY"); },
      ThrowsMessage<OptionError>(HasSubstr(
          "'US-NY' is no part of United States of America that has a law of its own in the catalogue; take US")));
  EXPECT_THAT([] { check_country("XX-NY"); }, ThrowsMessage<OptionError>(HasSubstr("'XX-NY' is no country")));
}

TEST(Catalogue, of_parts_that_overlap_the_smaller_polygon_counts) {
  const Country country{.id = "AA",
                        .parts = {{"AA-1", "round it", {polygon_of_box({0.0, 0.0, 9.0, 9.0})}},
                                  {"AA-2",
                                   "in it and beside it",
                                   {polygon_of_box({10.0, 0.0, 30.0, 20.0}), polygon_of_box({4.0, 4.0, 5.0, 5.0})}}}};
  EXPECT_EQ(law_at(country, {4.5, 4.5}), "AA-2");
  EXPECT_EQ(law_at(country, {5.5, 4.5}), "AA-1");
  EXPECT_EQ(law_at(country, {20.0, 4.5}), "AA-2");
  EXPECT_EQ(law_at(country, {9.5, 4.5}), "AA");
  EXPECT_EQ(law_at({.id = "BB"}, {4.5, 4.5}), "BB");
}

TEST(Catalogue, the_extract_is_the_smallest_that_holds_the_place) {
  EXPECT_EQ(extract_area(catalogue(), around(11.58, 48.14))->geofabrik, "europe/germany/bayern");
  EXPECT_EQ(extract_area(catalogue(), around(13.40, 52.52))->geofabrik, "europe/germany/berlin");
  EXPECT_EQ(extract_area(catalogue(), around(6.95, 49.35))->geofabrik, "europe/germany/saarland");
  EXPECT_EQ(extract_area(catalogue(), around(-104.99, 39.74))->geofabrik, "north-america/us/colorado");
  EXPECT_EQ(extract_area(catalogue(), around(0.0, 0.0)), nullptr);
  EXPECT_EQ(extract_area(catalogue(), polygon_of_box({11, 46.5, 12, 48.5})), nullptr);  // Germany and Austria
}

TEST(Catalogue, addresses_of_cells_are_those_of_the_servers) {
  EXPECT_THAT(cell_urls(source("copernicus-glo30"), around(11.58, 48.14)),
              ElementsAre("https://copernicus-dem-30m.s3.amazonaws.com/Copernicus_DSM_COG_10_N48_00_E011_00_DEM/"
                          "Copernicus_DSM_COG_10_N48_00_E011_00_DEM.tif"));
  EXPECT_THAT(cell_urls(source("copernicus-glo30"), polygon_of_box({-0.1, -0.1, 0.1, 0.1})),
              ElementsAre(HasSubstr("_S01_00_W001_00_"), HasSubstr("_S01_00_E000_00_"), HasSubstr("_N00_00_W001_00_"),
                          HasSubstr("_N00_00_E000_00_")));
  EXPECT_THAT(cell_urls(source("us-3dep-10m"), around(-105.5, 40.5)),
              ElementsAre("https://prd-tnm.s3.amazonaws.com/StagedProducts/Elevation/13/TIFF/current/n41w106/"
                          "USGS_13_n41w106.tif"));
  EXPECT_THAT(cell_urls(source("de-by-dgm1"), around(11.575, 48.137, 0.001)),
              Contains("https://download1.bayernwolke.de/a/dgm/dgm1/691_5334.tif"));
  EXPECT_THAT(cell_urls(source("at-als-dtm"), around(16.37, 48.21)),
              ElementsAre("https://data.bev.gv.at/download/ALS/DTM/20250915/"
                          "ALS_DTM_CRS3035RES50000mN2800000E4750000.tif"));
  // Sheets of Topo50 as LINZ names them: those of Auckland, Aoraki and the Three Kings.
  EXPECT_THAT(cell_urls(source("nz-lidar1"), around(174.76, -36.86, 0.001)), ElementsAre(HasSubstr("/2193/BA32.tiff")));
  EXPECT_THAT(cell_urls(source("nz-lidar1"), around(170.142, -43.595, 0.001)),
              ElementsAre(HasSubstr("/2193/BX15.tiff")));
  EXPECT_THAT(cell_urls(source("nz-lidar1"), around(172.05, -34.15, 0.001)), ElementsAre(HasSubstr("/2193/AS21.tiff")));
  EXPECT_THAT([] { (void)cell_urls(source("nz-lidar1"), around(174.0, -30.0)); },
              ThrowsMessage<OptionError>(HasSubstr("no sheet of nz-lidar1 reaches the area")));
  EXPECT_THAT(cell_urls(source("de-bw-dgm1"), around(9.22, 48.76, 0.001)),  // as a public test has it
              ElementsAre("https://opengeodata.lgl-bw.de/data/dgm/dgm1_32_515_5400_2_bw.zip"));
  EXPECT_THAT(cell_urls(source("de-sn-dgm1"), around(13.74, 51.045, 0.0005)),
              ElementsAre(HasSubstr("/dgm1_33410_5654_2_sn_tiff.zip")));
  const std::vector<std::string> ahn = cell_urls(source("nl-ahn"), around(5.0, 52.1, 0.002));
  EXPECT_THAT(ahn.front(), HasSubstr("&WIDTH=2000&HEIGHT=2000"));
  for (const std::string& url : ahn) EXPECT_THAT(url, Not(HasSubstr("{")));
  EXPECT_THAT(
      [] {
        (void)cell_urls(source("nl-ahn"), polygon_of_box({3.5, 51.0, 6.5, 53.0}));
      },
      ThrowsMessage<OptionError>(HasSubstr("more than 10000")));
}

TEST(Catalogue, mistakes_in_its_files_are_told_with_their_line) {
  const Scratch scratch;
  const std::string area = "[[area]]\nid = 'A'\nname = 'a'\nrings = [[[0,0],[1,0],[1,1],[0,0]]]\n";
  const std::string photo =
      "[[source]]\nid = 'p'\nname = 'p'\nwhat = 'photo'\nareas = ['A']\nkind = 'xyz'\nurl = "
      "'https://x/{z}/{x}/{y}'\nresolution_m = 1\nlicence = 'l'\nattribution = 'a'\nchecked = 'memory'\n";
  const auto message = [&](const std::string& areas, const std::string& photos, const std::string& terrain = "") {
    write_bytes(scratch / "areas.toml", areas);
    write_bytes(scratch / "photo.toml", photos);
    write_bytes(scratch / "terrain.toml", terrain);
    write_bytes(scratch / "osm.toml", "");
    try {
      (void)read_catalogue(scratch.folder());
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("none");
  };
  EXPECT_EQ(message(area, photo), "none");
  EXPECT_THAT(message(area, photo + "layr = 'x'\n"),
              HasSubstr("photo.toml:12: 'layr' is not known here; did you mean 'layer'?"));
  EXPECT_THAT(message(area, photo + photo), HasSubstr("photo.toml:13: 'id' 'p' is there already"));
  EXPECT_THAT(message("", photo), HasSubstr("names 'A', which areas.toml does not have"));
  EXPECT_THAT(message("[[area]]\nid = 'A'\nname = 'a'\nrings = [[[0,0],[1,0],[1,1]]]\n", photo),
              HasSubstr("areas.toml:4: a ring needs three corners and its first one again"));
  EXPECT_THAT(message(area, photo, photo), HasSubstr("terrain.toml:4: 'what' must be terrain, not 'photo'"));
  std::string terrain = photo;
  terrain.replace(terrain.find("'photo'"), 7, "'terrain'");
  EXPECT_THAT(message(area, photo, terrain), HasSubstr("needs vertical_datum and vertical_unit"));
  terrain.replace(terrain.find("'p'"), 3, "'t'");
  terrain += "vertical_datum = 'd'\nvertical_unit = 'm'\n[source.cells]\ncrs = 'EPSG:25832'\n";
  EXPECT_EQ(message(area, photo, terrain + "size = [1000, 2000]\norigin = [500, 0]\nrows = ['A']\n"), "none");
  EXPECT_THAT(message(area, photo, terrain), HasSubstr("'cells.size' is missing"));
  EXPECT_THAT(message(area, photo, terrain + "size = 0\n"), HasSubstr("must be greater than 0"));
  EXPECT_THAT(message(area, photo, terrain + "size = [1, 2, 3]\n"), HasSubstr("must be two numbers, east and north"));
  EXPECT_THAT(message(area, photo, terrain + "size = 1\norigin = [1]\n"),
              HasSubstr("must be two numbers, east and north"));
}

TEST(Catalogue, cells_may_begin_anywhere_and_be_no_squares) {
  CatalogueSource sheets{.id = "s", .url = "{west}_{south}_{east}_{north}_{width}_{height}", .resolution_m = 10.0};
  sheets.cells = SourceCells{"EPSG:25832", {2000.0, 3000.0}, {500000.0 - 300.0, 5000000.0 + 100.0}, {}};
  const CoordinateTransform lonlat_from_utm(Crs{"EPSG:25832"}, Crs{"EPSG:4326"});
  const Vec2 place = lonlat_from_utm.target_from_source({502000.0, 5004000.0});
  EXPECT_THAT(cell_urls(sheets, around(place.x, place.y, 1e-4)), ElementsAre("501700_5003100_503700_5006100_200_300"));
  sheets.cells = SourceCells{"EPSG:4326", {0.5, 0.25}, {}, {}};
  EXPECT_THAT(cell_urls(sheets, around(8.1, 50.1, 0.01)), ElementsAre("8_50_8.5_50.25_5566_2783"));
}

TEST(NewSite, the_best_sources_of_a_place_are_chosen) {
  EXPECT_THAT(new_site(catalogue(), area_at(16.37, 48.21)).sources,
              ElementsAre("at-basemap", "osm-overpass", "at-als-dtm"));
  EXPECT_THAT(new_site(catalogue(), area_at(11.58, 48.14)).sources,
              ElementsAre("de-by-dop20", "osm-overpass", "de-by-dgm1"));
  EXPECT_THAT(new_site(catalogue(), area_at(-105.2, 40.0)).sources,
              ElementsAre("us-naip", "osm-overpass", "us-3dep-1m"));
  EXPECT_THAT(new_site(catalogue(), area_at(7.45, 46.95)).sources,
              ElementsAre("ch-swissimage", "osm-overpass", "ch-swissalti3d"));
  // Where the national model has to be fetched by hand, the world's goes in.
  EXPECT_THAT(new_site(catalogue(), area_at(19.15, 48.74)).sources,
              ElementsAre("sk-zbgis", "osm-overpass", "copernicus-glo30"));
  EXPECT_THAT(new_site(catalogue(), area_at(24.94, 60.17)).sources,
              ElementsAre("fi-ortokuva", "osm-overpass", "fi-dem2"));
  // Below one with gaps lies the best that has none.
  EXPECT_THAT(new_site(catalogue(), area_at(-79.38, 43.70)).sources,
              ElementsAre("ca-on-2018", "osm-overpass", "ca-hrdem1", "ca-mrdem30"));
  EXPECT_THAT(new_site(catalogue(), area_at(-79.38, 43.70)).text,
              HasSubstr("dtm = [\"sources/dtm.tif\", \"sources/dtm_below.tif\"]  # best first"));
  EXPECT_THAT(new_site(catalogue(), area_at(174.76, -36.86)).sources,
              ElementsAre("nz-linz", "osm-overpass", "nz-lidar1", "copernicus-glo30"));
  EXPECT_THAT(new_site(catalogue(), area_at(151.00, -33.87)).sources,
              ElementsAre("au-nsw-imagery", "osm-overpass", "au-nsw-dem5"));
  // Near a border the country's own comes before what a neighbour's outline seems to cover, however fine that is.
  EXPECT_THAT(new_site(catalogue(), area_at(9.17, 47.675, 0.005)).sources,
              ElementsAre("de-bw-dop20", "osm-overpass", "de-bw-dgm1"));
  // More than Overpass should be asked for.
  EXPECT_THAT(new_site(catalogue(), area_at(11.58, 48.44, 0.13)).sources,
              ElementsAre("de-by-dop20", "osm-geofabrik", "de-by-dgm1"));
}

TEST(NewSite, what_it_writes_is_a_site_file_with_a_fetch_table_a_source) {
  const Scratch scratch;
  const NewSite made = new_site(catalogue(), area_at(14.42, 50.09));
  EXPECT_TRUE(made.findings.empty());
  write_bytes(scratch / "here.toml", made.text);
  const Site site = read_site(scratch / "here.toml");
  EXPECT_EQ(site.name, "Here");
  EXPECT_EQ(site.frame.crs.definition, "EPSG:32633");
  EXPECT_NEAR(area_m2(site.frame.area), area_m2(site_frame_of(around(14.42, 50.09)).area), 1e-3);
  EXPECT_EQ(site.photos, std::vector{scratch / "sources/photo.tif"});  // of a WMS
  EXPECT_EQ(site.attribution.size(), 3u);
  std::size_t tables = 0;
  for (auto at = made.text.find("[[fetch]]"); at != std::string::npos; at = made.text.find("[[fetch]]", at + 1))
    ++tables;
  EXPECT_EQ(tables, 3u);
  EXPECT_THAT(made.text, AllOf(HasSubstr("vertical_datum = \"Bpv\""), HasSubstr("layer = \"GR_ORTFOTORGB\""),
                               HasSubstr("to = \"sources/roads.osm\""), HasSubstr("resolution_m = 0.2\n")));
  EXPECT_THAT(new_site(catalogue(), area_at(11.58, 48.44, 0.13)).text,
              HasSubstr("url = \"https://download.geofabrik.de/europe/germany/bayern-latest.osm.pbf\""));
}

TEST(NewSite, sheets_of_squares_become_a_list_and_an_index_stays_one) {
  const std::string dresden = new_site(catalogue(), area_at(13.74, 51.05)).text;
  EXPECT_THAT(dresden, AllOf(HasSubstr("kind = \"sheets\"\nurls = [\n"), HasSubstr("crs = \"EPSG:25833\"\n")));
  NewSiteOptions hannover = area_at(9.73, 52.37);
  hannover.photos = {"de-ni-dop20-sheets"};
  EXPECT_THAT(new_site(catalogue(), hannover).text, HasSubstr("kind = \"sheets\"\nurl = \"https://arcgis-geojson"));
  const Scratch scratch;
  write_bytes(scratch / "here.toml", dresden);
  const Site site = read_site(scratch / "here.toml");
  const auto terrain = std::ranges::find(site.fetch, scratch / "sources/dtm.tif", &remote::FetchSource::to);
  ASSERT_NE(terrain, site.fetch.end());
  EXPECT_EQ(terrain->crs, "EPSG:25833");
  EXPECT_FALSE(terrain->urls.empty());
}

TEST(NewSite, a_polygon_and_odd_names_survive_writing_and_reading) {
  const Scratch scratch;
  NewSiteOptions options = area_at(14.42, 50.09);
  options.box.reset();
  options.name = "U \"Zlatého\" \\ lva\n\x01";
  options.area.holes.push_back({{14.418, 50.088}, {14.418, 50.092}, {14.422, 50.092}});
  write_bytes(scratch / "here.toml", new_site(catalogue(), options).text);
  const Site site = read_site(scratch / "here.toml");
  EXPECT_EQ(site.name, options.name);
  ASSERT_EQ(site.frame.area.holes.size(), 1u);
  EXPECT_NEAR(area_m2(site.frame.area), area_m2(site_frame_of(options.area).area), 5.0);
}

TEST(NewSite, a_border_with_very_many_corners_is_simplified_and_said) {
  NewSiteOptions options = area_at(14.42, 50.09);
  options.box.reset();
  options.area.outer.clear();
  for (int i = 0; i < 9000; ++i) {
    const double angle = 2.0 * 3.14159265358979 * i / 9000, radius = 0.05 + 1e-5 * (i % 2);
    options.area.outer.push_back({14.42 + radius * std::cos(angle), 50.09 + radius * std::sin(angle)});
  }
  const NewSite made = new_site(catalogue(), options);
  ASSERT_FALSE(made.findings.empty());
  EXPECT_EQ(made.findings.back().code, "new.simplified");
  const Scratch scratch;
  write_bytes(scratch / "here.toml", made.text);
  EXPECT_NEAR(area_m2(read_site(scratch / "here.toml").frame.area) / area_m2(site_frame_of(options.area).area), 1.0,
              2e-3);
}

TEST(NewSite, local_files_take_the_place_of_sources) {
  NewSiteOptions options = area_at(0.0, 0.0);  // the sea
  options.photo_files = {"my photo.tif"};
  options.osm_file = "../roads.osm";
  options.dtm_files = {"a.tif", "b.tif"};
  const Scratch scratch;
  const NewSite made = new_site(catalogue(), options);
  EXPECT_TRUE(made.sources.empty());
  EXPECT_THAT(made.text, Not(HasSubstr("[[fetch]]")));
  write_bytes(scratch / "here.toml", made.text);
  const Site site = read_site(scratch / "here.toml");
  EXPECT_EQ(site.photos, std::vector{scratch / "my photo.tif"});
  EXPECT_EQ(site.dtm.size(), 2u);
}

TEST(NewSite, photos_are_named_by_priority_each_with_its_fetch_table) {
  NewSiteOptions options = area_at(0.0, 0.0);
  options.box = LonLatBox{12.75, 47.945, 13.02, 47.955};  // across the border of Bavaria and Austria
  options.area = polygon_of_box(*options.box);
  options.photos = {"at-basemap", "de-by-dop20"};
  const NewSite made = new_site(catalogue(), options);
  EXPECT_THAT(made.text, HasSubstr("photo = [\"sources/photo.mbtiles\", \"sources/photo_2.tif\"]  # best first\n"));
  const Scratch scratch;
  write_bytes(scratch / "here.toml", made.text);
  const Site site = read_site(scratch / "here.toml");
  EXPECT_EQ(site.photos, (std::vector{scratch / "sources/photo.mbtiles", scratch / "sources/photo_2.tif"}));
  for (const std::filesystem::path& photo : site.photos)
    EXPECT_EQ(std::ranges::count(site.fetch, photo, &remote::FetchSource::to), 1) << photo;
  EXPECT_EQ(site.attribution.size(), 5u) << "of both photos, roads, and two models of terrain";
  options.photos = {"at-basemap", "at-basemap"};
  EXPECT_THROW((void)new_site(catalogue(), options), OptionError);
}

TEST(NewSite, terrain_that_covers_a_part_gets_the_worlds_beside_it) {
  NewSiteOptions options = area_at(0.0, 0.0);
  options.box = LonLatBox{12.75, 47.945, 13.02, 47.955};  // across the border of Bavaria and Austria
  options.area = polygon_of_box(*options.box);
  const NewSite made = new_site(catalogue(), options);
  EXPECT_EQ(made.sources.back(), "copernicus-glo30");
  EXPECT_THAT(made.text, HasSubstr("dtm = [\"sources/dtm.tif\", \"sources/dtm_world.tif\"]"));
  EXPECT_FALSE(made.findings.empty());
  EXPECT_EQ(made.findings.front().code, "new.partly_covered");
  EXPECT_EQ(made.findings.size(), 2u);  // photo and terrain
}

TEST(NewSite, says_the_side_of_the_road_where_it_is_the_left) {
  EXPECT_THAT(new_site(catalogue(), area_at(139.71, 35.66)).text,
              HasSubstr("[refine]\ndriving_side = \"left\"  # Japan\n"));
  for (const auto& [lon, lat, country] :
       {std::tuple{33.04, 34.69, "Cyprus"}, {138.60, -34.93, "Australia"}, {174.78, -41.29, "New Zealand"}})
    EXPECT_THAT(new_site(catalogue(), area_at(lon, lat)).text,
                HasSubstr(fmt::format("driving_side = \"left\"  # {}\n", country)));
  for (const auto& [lon, lat] : {std::pair{16.37, 48.21}, {24.94, 60.17}, {-79.38, 43.70}})
    EXPECT_THAT(new_site(catalogue(), area_at(lon, lat)).text, Not(HasSubstr("driving_side")));
}

TEST(NewSite, what_cannot_be_says_what_to_do) {
  const auto message = [](const NewSiteOptions& options) {
    try {
      (void)new_site(catalogue(), options);
    } catch (const OptionError& error) {
      return std::string(error.what());
    }
    return std::string("none");
  };
  EXPECT_THAT(message(area_at(0.0, 0.0)),
              AllOf(HasSubstr("no photo of the catalogue can be fetched for 0.00000, 0.00000"), HasSubstr("Austria"),
                    HasSubstr("--photo-file")));
  EXPECT_THAT(message(area_at(50.09, 14.42)),
              HasSubstr("with longitude first it would be --bbox 14.41,50.08,14.43,50.1, where cz-ortofoto is"));
  EXPECT_THAT(message(area_at(14.5, 49.8, 0.4)), HasSubstr("km2, and a site at most 2500"));
  NewSiteOptions options = area_at(14.42, 50.09);
  options.photos = {"cz-ortfoto"};
  EXPECT_THAT(message(options),
              HasSubstr("--photo cz-ortfoto: the catalogue has no such source; did you mean 'cz-ortofoto'?"));
  options.photos = {"at-basemap"};
  EXPECT_THAT(message(options), HasSubstr("--photo at-basemap: it lies elsewhere (AT)"));
  options.photos = {"copernicus-glo30"};
  EXPECT_THAT(message(options), HasSubstr("no such source"));
  // A source that has to be fetched by hand can be named, and is taken where there is no other: the site file says how.
  NewSiteOptions swedish = area_at(18.07, 59.33);
  swedish.photos = {"se-ortofoto"};
  const NewSite made = new_site(catalogue(), swedish);
  EXPECT_EQ(made.findings.front().code, "new.by_hand");
  for (const auto& [lon, lat, said] : {std::tuple{18.07, 59.33, "se-ortofoto cannot be fetched: Needs an account"},
                                       {12.57, 55.68, "dk-geodanmark cannot be fetched: Needs a free account"}}) {
    const NewSite unnamed = new_site(catalogue(), area_at(lon, lat));
    EXPECT_EQ(unnamed.findings.front().code, "new.by_hand");
    EXPECT_THAT(unnamed.findings.front().message, HasSubstr(said));
  }
}

TEST(NewSite, keys_of_users_stay_names_in_the_site_file) {
  NewSiteOptions danish = area_at(12.57, 55.68);
  danish.photos = {"dk-geodanmark"};
  EXPECT_THAT(new_site(catalogue(), danish).text, HasSubstr("?apikey={env:DATAFORDELER_API_KEY}\""));
  EXPECT_THAT(new_site(catalogue(), area_at(174.78, -41.29)).text, HasSubstr("?api={env:LINZ_API_KEY}\""));
}

TEST(NewSite, the_table_lists_what_covers_an_area) {
  const Polygon munich = around(11.58, 48.14);
  const std::string here = source_table(catalogue(), &munich), all = source_table(catalogue(), nullptr);
  EXPECT_THAT(here, AllOf(HasSubstr("de-by-dop20"), HasSubstr("copernicus-glo30"), Not(HasSubstr("at-basemap"))));
  for (const CatalogueSource& entry : catalogue().sources) EXPECT_THAT(all, HasSubstr(entry.id));
}

}  // namespace
}  // namespace orthodrive
