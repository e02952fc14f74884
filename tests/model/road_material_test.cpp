// SPDX-License-Identifier: Apache-2.0
// Class of a surface by tags, and what a tyre finds on it.

#include "orthodrive/model/roads/road_material.hpp"

#include <gtest/gtest.h>

#include "orthodrive/core/error.hpp"

namespace orthodrive {
namespace {

KnownSurface of(const char* highway, const char* surface = "", const char* tracktype = "") {
  return surface_of_tags(highway, surface, tracktype);
}

TEST(RoadMaterial, the_surface_tag_comes_first_then_tracktype_then_the_class_of_the_road) {
  EXPECT_EQ(of("track", "asphalt", "grade5").surface, SurfaceClass::asphalt);
  EXPECT_EQ(of("track", "asphalt", "grade5").source, SurfaceSource::tag);
  EXPECT_EQ(of("track", "lava", "grade4").surface, SurfaceClass::ground) << "a value nobody knows is no value";
  EXPECT_EQ(of("track", "", "grade1").surface, SurfaceClass::asphalt);
  EXPECT_EQ(of("track", "", "grade2").surface, SurfaceClass::gravel);
  EXPECT_EQ(of("track", "", "grade3").source, SurfaceSource::tracktype);
  EXPECT_EQ(of("track").surface, SurfaceClass::gravel);
  EXPECT_EQ(of("path").surface, SurfaceClass::ground);
  EXPECT_EQ(of("residential").surface, SurfaceClass::asphalt);
  EXPECT_EQ(of("residential").source, SurfaceSource::highway);
  EXPECT_EQ(of("").surface, SurfaceClass::asphalt);
}

TEST(RoadMaterial, friction_is_relative_to_dry_asphalt_and_water_never_helps) {
  EXPECT_EQ(material_of(SurfaceClass::asphalt, Weather::dry).friction, 1.0);
  EXPECT_EQ(material_of(SurfaceClass::asphalt, Weather::wet).friction, 0.7);
  EXPECT_EQ(material_of(SurfaceClass::setts, Weather::wet).friction, 0.5);
  for (const SurfaceClass surface : {SurfaceClass::asphalt, SurfaceClass::concrete, SurfaceClass::setts,
                                     SurfaceClass::gravel, SurfaceClass::ground}) {
    const RoadMaterial dry = material_of(surface, Weather::dry), wet = material_of(surface, Weather::wet);
    EXPECT_LE(wet.friction, dry.friction) << roadquery::to_string(surface);
    EXPECT_LE(dry.friction, 1.0);
    EXPECT_GT(wet.friction, 0.0);
    EXPECT_EQ(wet.roughness_m, dry.roughness_m);
    EXPECT_GT(dry.roughness_m, 0.0);
  }
}

TEST(RoadMaterial, names_are_read_as_they_are_written) {
  for (const Weather weather : {Weather::dry, Weather::wet}) EXPECT_EQ(weather_of(to_string(weather)), weather);
  EXPECT_THROW((void)weather_of("snow"), OptionError);
  for (const SurfaceSource source : {SurfaceSource::unset, SurfaceSource::tag, SurfaceSource::tracktype,
                                     SurfaceSource::highway, SurfaceSource::photo, SurfaceSource::truth})
    EXPECT_EQ(surface_source_of(to_string(source)), source);
  EXPECT_EQ(surface_source_of("guess"), SurfaceSource::unset);
}

}  // namespace
}  // namespace orthodrive
