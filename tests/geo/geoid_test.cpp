// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/geo/geoid.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace orthodrive {
namespace {

TEST(Geoid, lies_where_its_makers_say) {
  const Geoid geoid;
  if (geoid.grid().empty()) GTEST_SKIP() << "PROJ has no geoid grid: install proj-data";
  struct Place {
    double longitude_deg, latitude_deg, height_m;
  };
  // Test points of NGA's program for EGM96 (INTPT.F); EGM2008 differs by less than half a metre there.
  for (const Place& place : {Place{269.7791550 - 360.0, 38.6281550, -31.628},
                             {305.0211140 - 360.0, -14.6212170, -2.969},
                             {102.4487290, 46.8743190, -43.575},
                             {133.8747120, -23.6174460, 15.871}})
    EXPECT_NEAR(geoid.height_m(place.longitude_deg, place.latitude_deg), place.height_m, 0.5);
}

}  // namespace
}  // namespace orthodrive
