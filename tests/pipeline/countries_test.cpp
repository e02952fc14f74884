// SPDX-License-Identifier: Apache-2.0
// One place in each country of which the catalogue has photos: what `orthodrive new` writes for it. Sides, speeds and
// licences are typed here from the laws and the providers' terms, not read from the catalogue.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "io/scratch.hpp"
#include "orthodrive/pipeline/sources/catalogue.hpp"
#include "orthodrive/pipeline/sources/new_site.hpp"
#include "orthodrive/pipeline/sources/site.hpp"
#include "paths.hpp"

namespace orthodrive {
namespace {
using testing::HasSubstr;

constexpr double mile_km = 1.609344;

struct Expected {
  const char* country;
  const char* town;
  double lon, lat;
  const char *photo, *licence, *terrain;
  double urban_kmh, rural_kmh;  ///< of cars in and out of built-up areas, on ordinary roads
  DrivingSide side = DrivingSide::right;
  bool by_hand = false;  ///< its photo needs an account, or does not cover the country
};

const char* const world = "copernicus-glo30";
const char* const by = "CC BY 4.0";

// The 28 European countries of the list of open orthophotos that a public project keeps, Slovenia, the USA, Canada,
// Japan and New Zealand. Where a part of a country has a law of its own, the place says whose it is.
const std::vector<Expected> expected{
    {"AL", "Tirana", 19.82, 41.33, "al-orto20", "CC0", world, 40, 80},                     // Kodi Rrugor
    {"AT", "Graz", 15.44, 47.07, "at-basemap", by, "at-als-dtm", 50, 100},                 // StVO § 20
    {"BE", "Gent (Flanders)", 3.72, 51.05, "be-ngi", by, "be-vlg-dhmv2", 50, 70},          // wegcode art. 11
    {"BG", "Sofia", 23.32, 42.70, "bg-maf", by, world, 50, 90, DrivingSide::right, true},  // ЗДвП чл. 21
    {"CH", "Bern", 7.45, 46.95, "ch-swissimage", "OpenBY", "ch-swissalti3d", 50, 80},      // VRV Art. 4a
    {"CY", "Limassol", 33.04, 34.69, "cy-dls2014", "Open", world, 50, 80, DrivingSide::left},
    {"CZ", "Brno", 16.61, 49.20, "cz-ortofoto", by, "cz-dmr5g", 50, 90},                           // 361/2000 § 18
    {"DE", "München", 11.58, 48.14, "de-by-dop20", by, "de-by-dgm1", 50, 100},                     // StVO § 3
    {"DK", "Aarhus", 10.20, 56.16, "dk-geodanmark", by, world, 50, 80, DrivingSide::right, true},  // færdselsloven § 42
    {"EE", "Tartu", 26.72, 58.38, "ee-foto", by, "ee-dtm1", 50, 90},                     // liiklusseadus § 15
    {"ES", "Zaragoza", -0.88, 41.65, "es-pnoa", by, "es-mdt05", 30, 90},                 // RGC art. 48 to 50, 2021
    {"FI", "Tampere", 23.76, 61.50, "fi-ortokuva", by, "fi-dem2", 50, 80},               // tieliikennelaki
    {"FR", "Lyon", 4.83, 45.76, "fr-bdortho", "Licence Ouverte", "fr-rgealti", 50, 80},  // R413-2, R413-3
    {"HR", "Zagreb", 15.98, 45.81, "hr-dof2022", "open data", world, 50, 90},            // ZSPC čl. 54
    {"HU", "Szeged", 20.15, 46.25, "hu-oi2022", by, world, 50, 90},                      // KRESZ 26. §
    {"IS", "Akureyri", -18.09, 65.68, "is-loftmynd", by, world, 50, 90, DrivingSide::right,
     true},                                                                                 // umferðarlög 37. gr.
    {"LI", "Vaduz", 9.52, 47.14, "li-orthofoto", "Opendata BY", "ch-swissalti3d", 50, 80},  // VRV Art. 4a
    {"LT", "Kaunas", 23.90, 54.90, "lt-ort10lt", "any use", "lt-dtm2020", 50, 90},          // KET 129
    {"LU", "Luxembourg", 6.13, 49.61, "lu-ortho", "CC0", "lu-lidar2024", 50, 90},           // code de la route art. 139
    {"LV", "Rīga", 24.11, 56.95, "lv-orto", by, world, 50, 90},                             // CSN 99
    {"ME", "Podgorica", 19.26, 42.44, "me-dof2018", "Free", world, 50, 80},                 // ZBSP čl. 35
    {"MT", "Mosta", 14.43, 35.91, "mt-ortho2018", "No limitations", world, 50, 80, DrivingSide::left, true},
    {"NL", "Utrecht", 5.12, 52.09, "nl-luchtfoto", by, "nl-ahn", 50, 80},                         // RVV 20, 21
    {"PL", "Kraków", 19.94, 50.06, "pl-orto", "any use", "pl-nmt1", 50, 90},                      // PoRD art. 20
    {"PT", "Coimbra", -8.43, 40.21, "pt-ortos2025", by, world, 50, 90},                           // CE art. 27
    {"RO", "Cluj-Napoca", 23.59, 46.77, "ro-aiga", by, world, 50, 90, DrivingSide::right, true},  // OUG 195 art. 49, 50
    {"SE", "Uppsala", 17.64, 59.86, "se-ortofoto", by, world, 50, 70, DrivingSide::right, true},  // TrF 3 kap. 17 §
    {"SK", "Žilina", 18.74, 49.22, "sk-zbgis", by, world, 50, 90},                                // 8/2009 § 16
    {"SI", "Maribor", 15.65, 46.56, "si-dof025", by, "si-dmr1", 50, 90},                          // ZPrCP 46. člen
    {"US", "Denver (Colorado)", -104.99, 39.74, "us-naip", "Public domain", "us-3dep-1m", 30 * mile_km,
     55 * mile_km},  // C.R.S. 42-4-1101
    {"CA", "Toronto (Ontario)", -79.38, 43.70, "ca-on-2018", "Open Government", "ca-hrdem1", 50, 80},  // HTA s. 128
    {"JP", "東京", 139.70, 35.69, "jp-gsi-photo", by, world, 60, 60, DrivingSide::left},               // 施行令 11
    {"NZ", "Auckland", 174.76, -36.86, "nz-linz", by, "nz-lidar1", 50, 100, DrivingSide::left},        // SSL Rule 2022
};

NewSite made_for(const Expected& place) {
  static const Catalogue catalogue = read_catalogue(paths::in_source("catalogue"));
  constexpr double half_deg = 0.005;
  const LonLatBox box{place.lon - half_deg, place.lat - half_deg, place.lon + half_deg, place.lat + half_deg};
  return new_site(catalogue, {.name = place.town, .area = polygon_of_box(box), .box = box});
}

TEST(NewInCountries, has_a_photo_and_terrain_with_its_licence) {
  EXPECT_EQ(expected.size(), 33u);
  for (const Expected& place : expected) {
    SCOPED_TRACE(place.town);
    const NewSite made = made_for(place);
    ASSERT_GE(made.sources.size(), 3u);
    EXPECT_EQ(made.sources[0], place.photo);
    EXPECT_EQ(made.sources[2], place.terrain);
    EXPECT_EQ(std::ranges::any_of(made.findings, [](const Finding& f) { return f.code == "new.by_hand"; }),
              place.by_hand);
    const auto table = made.text.substr(made.text.find("to = \"sources/photo"));
    const auto licence = table.substr(table.find("licence = "), 200);
    EXPECT_THAT(licence.substr(0, licence.find('\n')), HasSubstr(place.licence));
    EXPECT_THAT(made.text, HasSubstr("vertical_datum = "));
  }
}

TEST(NewInCountries, its_site_file_has_the_side_and_the_limits_of_the_law) {
  const Scratch scratch;
  SpeedLaws laws = read_speed_laws(paths::in_source("catalogue"));
  for (const Expected& place : expected) {
    SCOPED_TRACE(place.town);
    write_bytes(scratch / "here.toml", made_for(place).text);
    const Site site = read_site(scratch / "here.toml");
    EXPECT_FALSE(site.photos.empty());
    EXPECT_FALSE(site.dtm.empty());
    EXPECT_GE(site.attribution.size(), 3u);
    const PlaceRules rules = rules_at(site.frame.crs, bounds_of(site.frame.area.outer));
    EXPECT_EQ(rules.country.substr(0, 2), place.country);
    EXPECT_EQ(rules.driving_side, place.side);
    laws.here = rules.country;
    EXPECT_NEAR(speed_of_context(laws, "urban"), place.urban_kmh, 1e-6);
    EXPECT_NEAR(speed_of_context(laws, "rural"), place.rural_kmh, 1e-6);
  }
}

}  // namespace
}  // namespace orthodrive
