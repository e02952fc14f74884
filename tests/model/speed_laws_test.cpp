// SPDX-License-Identifier: Apache-2.0
// Limits where no sign tells: cases of the law, classes of roads, countries and their parts.

#include "orthodrive/model/roads/speed_laws.hpp"

#include <gtest/gtest.h>

namespace orthodrive {
namespace {
constexpr double mile_km = 1.609344;

SpeedLaws some_laws(const std::string& here = "") {
  const SpeedLaw de{.country = "DE", .living_street = 7, .urban = 50, .rural = 100, .motorway = 130};
  const SpeedLaw be{.country = "BE", .urban = 50, .rural = 90, .motorway = 120};
  const SpeedLaw flanders{.country = "BE-VLG", .rural = 70};
  const SpeedLaw gb{.country = "GB",
                    .unit_kmh = mile_km,
                    .urban = 30 * mile_km,
                    .rural = 60 * mile_km,
                    .rural_dual = 70 * mile_km,
                    .motorway = 70 * mile_km};
  return {{de, be, flanders, gb}, here};
}

RoadPath road(const std::string& highway, const std::string& context = "", Oneway oneway = Oneway::no) {
  RoadPath path{.highway = highway, .oneway = oneway};
  path.speed_context = context;
  path.nodes.resize(2);
  return path;
}

TEST(SpeedLaws, cases_of_the_law_as_tags_name_them) {
  const SpeedLaws laws = some_laws("DE");
  EXPECT_EQ(speed_of_context(laws, "rural"), 100.0) << "of the country in which the road lies";
  EXPECT_EQ(speed_of_context(laws, "BE:rural"), 90.0) << "the one that the tag names goes first";
  EXPECT_EQ(speed_of_context(laws, "BE-VLG:rural"), 70.0) << "a part's own law";
  EXPECT_EQ(speed_of_context(laws, "BE-VLG:motorway"), 120.0) << "else that of the country";
  EXPECT_EQ(speed_of_context(laws, "BE:trunk"), 90.0) << "no word of motor roads: as any road outside of towns";
  EXPECT_EQ(speed_of_context(laws, "XX:trunk"), 100.0) << "no law at all: the world's";
  EXPECT_EQ(speed_of_context(laws, "XX:urban"), 50.0);
  EXPECT_NEAR(speed_of_context(laws, "GB:nsl_single"), 60 * mile_km, 1e-9);
  EXPECT_NEAR(speed_of_context(laws, "GB:nsl_dual"), 70 * mile_km, 1e-9);
  EXPECT_NEAR(speed_of_context(laws, "GB:nsl_restricted"), 30 * mile_km, 1e-9);
  EXPECT_EQ(speed_of_context(laws, "BE:nsl_dual"), 90.0) << "no word of carriageways of their own: as any road";
  EXPECT_EQ(speed_of_context(laws, "DE:zone30"), 30.0);
  EXPECT_EQ(speed_of_context(laws, "DE:zone:30"), 30.0);
  EXPECT_NEAR(speed_of_context(laws, "GB:zone20"), 20 * mile_km, 1e-9) << "in the country's own unit";
  EXPECT_EQ(speed_of_context(laws, "walk"), 7.0);
  EXPECT_EQ(speed_of_context(laws, "DE:moon"), 0.0);
  for (const char* text : {"DE:urban", "rural", "walk", "FR:zone30", "GB:nsl_single"})
    EXPECT_TRUE(is_speed_context(text)) << text;
  for (const char* text : {"", "50", "fast", "DE:", ":", "DE:zone", "30 mph", "none", "DE:zone-5"})
    EXPECT_FALSE(is_speed_context(text)) << text;
}

TEST(SpeedLaws, a_road_without_a_sign_has_the_limit_of_its_class_and_place) {
  const SpeedLaws german = some_laws("DE"), british = some_laws("GB");
  EXPECT_EQ(lawful_speed_kmh(german, road("primary", "rural")), 100.0);
  EXPECT_EQ(lawful_speed_kmh(german, road("primary", "urban")), 50.0);
  EXPECT_EQ(lawful_speed_kmh(german, road("primary")), 50.0) << "nothing tells: as in a town";
  EXPECT_EQ(lawful_speed_kmh(german, road("trunk")), 100.0) << "but trunk roads, which lead past them";
  EXPECT_EQ(lawful_speed_kmh(german, road("trunk", "DE:urban")), 50.0);
  EXPECT_EQ(lawful_speed_kmh(german, road("motorway", "urban", Oneway::forward)), 130.0);
  EXPECT_EQ(lawful_speed_kmh(german, road("living_street", "urban")), 7.0);
  EXPECT_EQ(lawful_speed_kmh(german, road("service", "rural")), 30.0) << "no law names driveways";
  EXPECT_EQ(lawful_speed_kmh(german, road("raceway")), 0.0);
  EXPECT_NEAR(lawful_speed_kmh(british, road("residential", "urban")), 30 * mile_km, 1e-9);
  EXPECT_NEAR(lawful_speed_kmh(british, road("primary", "rural")), 60 * mile_km, 1e-9);
  RoadPath dual = road("primary", "rural", Oneway::forward);
  dual.lanes = 2;
  EXPECT_NEAR(lawful_speed_kmh(british, dual), 70 * mile_km, 1e-9);
  dual.lanes = 1;
  EXPECT_NEAR(lawful_speed_kmh(british, dual), 60 * mile_km, 1e-9) << "an arm at an island";
  EXPECT_EQ(lawful_speed_kmh({}, road("residential")), 50.0) << "no country is known";
}

TEST(SpeedLaws, signs_go_first_and_lists_get_numbers) {
  RoadNetwork roads;
  roads.paths = {road("primary", "rural"), road("primary", "rural"), road("primary")};
  roads.paths[0].speed_limit_kmh = 70.0;
  roads.paths[1].speeds_backward = "GB:nsl_single";
  roads.paths[1].speed_limit_kmh = 40.0;
  roads.paths[2].speeds_forward = "|DE:rural|80";
  Findings findings;
  settle_speeds(some_laws("DE"), roads, findings);
  EXPECT_EQ(roads.paths[0].speed_limit_kmh, 70.0);
  EXPECT_EQ(roads.paths[1].speeds_backward, "96.5606");
  EXPECT_EQ(roads.paths[2].speeds_forward, "|100|80");
  EXPECT_EQ(roads.paths[2].speed_limit_kmh, 100.0) << "the largest that its lanes have";
  EXPECT_TRUE(findings.empty()) << "all of them have signs";
  roads.paths = {road("raceway")};
  roads.paths[0].speeds_forward = "250";
  settle_speeds(some_laws("DE"), roads, findings);
  EXPECT_EQ(roads.paths[0].speed_limit_kmh, 250.0);
  roads.paths = {road("secondary", "rural")};
  settle_speeds(some_laws("DE"), roads, findings);
  EXPECT_EQ(roads.paths[0].speed_limit_kmh, 100.0);
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].code, "network.speed_by_law");
  EXPECT_NE(findings[0].message.find("of the law of DE: 0 in towns, 1 outside"), std::string::npos)
      << findings[0].message;
}

}  // namespace
}  // namespace orthodrive
