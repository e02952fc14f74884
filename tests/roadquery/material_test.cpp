// SPDX-License-Identifier: Apache-2.0
// What lanes are made of: names of surfaces, and <material> as others write it.

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "roadquery/map/road_map.hpp"
#include "roadquery/roads/lane_material.hpp"

namespace {

using roadquery::surface_class_of;
using roadquery::SurfaceClass;

TEST(SurfaceClass, names_of_osm_and_of_others) {
  EXPECT_EQ(surface_class_of("asphalt"), SurfaceClass::asphalt);
  EXPECT_EQ(surface_class_of("chipseal"), SurfaceClass::asphalt);
  EXPECT_EQ(surface_class_of("concrete:plates"), SurfaceClass::concrete) << "what stands before the colon";
  EXPECT_EQ(surface_class_of("concrete:lanes"), SurfaceClass::concrete);
  EXPECT_EQ(surface_class_of("sett"), SurfaceClass::setts);
  EXPECT_EQ(surface_class_of("unhewn_cobblestone"), SurfaceClass::setts);
  EXPECT_EQ(surface_class_of("cobblestone:flattened"), SurfaceClass::setts);
  EXPECT_EQ(surface_class_of("compacted"), SurfaceClass::gravel);
  EXPECT_EQ(surface_class_of("unpaved"), SurfaceClass::gravel);
  EXPECT_EQ(surface_class_of("mud"), SurfaceClass::ground);
  EXPECT_EQ(surface_class_of("  ASPHALT "), SurfaceClass::asphalt) << "neither case nor spaces count";
  EXPECT_EQ(surface_class_of("Tarmac"), SurfaceClass::asphalt);
  EXPECT_EQ(surface_class_of("seal;gravel"), SurfaceClass::gravel) << "the first one that is known";
  for (const char* unknown : {"", ";", ":", "lava", "7", "asphalted"})
    EXPECT_FALSE(surface_class_of(unknown)) << unknown;
}

TEST(SurfaceClass, every_class_is_read_as_it_is_written) {
  for (const SurfaceClass surface :
       {SurfaceClass::asphalt, SurfaceClass::concrete, SurfaceClass::setts, SurfaceClass::gravel, SurfaceClass::ground})
    EXPECT_EQ(surface_class_of(to_string(surface)), surface);
}

constexpr const char* head = R"(<OpenDRIVE><header revMajor="1" revMinor="4"/><road id="1" length="40" junction="-1">
<planView><geometry s="0" x="0" y="0" hdg="0" length="40"><line/></geometry></planView><lanes><laneSection s="0">
<center><lane id="0" type="none"/></center><right><lane id="-1" type="driving"><width sOffset="0" a="3" b="0" c="0" d="0"/>)";
constexpr const char* tail = "</lane></right></laneSection></lanes></road></OpenDRIVE>";

roadquery::Lane read_lane(const std::string& materials) {
  const std::filesystem::path file =
      std::filesystem::path(testing::TempDir()) /
      ("material_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()) + ".xodr");
  std::ofstream(file) << head << materials << tail;
  return roadquery::read_opendrive(file.string()).roads.at(0).sections.at(0).right.at(0);
}

TEST(ReadMaterial, entries_along_a_lane) {
  const roadquery::Lane lane = read_lane(
      R"(<material sOffset="0" surface="Cobble" friction="0.61" roughness="0.015"/><material sOffset="12.5" friction="0.9"/>)");
  ASSERT_EQ(lane.materials.size(), 2u);
  EXPECT_EQ(lane.materials[0].surface, SurfaceClass::setts);
  EXPECT_EQ(lane.materials[0].friction, 0.61);
  EXPECT_EQ(lane.materials[0].roughness, 0.015);
  EXPECT_EQ(lane.materials[1].surface, SurfaceClass::asphalt) << "no text";
  EXPECT_EQ(roadquery::material_at(lane, 12.4).friction, 0.61);
  EXPECT_EQ(roadquery::material_at(lane, 12.5).friction, 0.9) << "an entry begins where it says";
  EXPECT_EQ(roadquery::material_at(lane, 1e9).friction, 0.9);
}

TEST(ReadMaterial, an_unknown_text_keeps_the_friction_of_the_file) {
  const roadquery::Lane lane = read_lane(R"(<material sOffset="3" surface="carpet" friction="0.33"/>)");
  ASSERT_EQ(lane.materials.size(), 1u);
  EXPECT_EQ(lane.materials[0].surface, SurfaceClass::asphalt);
  EXPECT_EQ(lane.materials[0].friction, 0.33);
  EXPECT_EQ(roadquery::material_at(lane, 2.9).friction, 1.0) << "before the first entry: asphalt";
  EXPECT_EQ(roadquery::material_at(read_lane(""), 5.0).friction, 1.0) << "none at all";
}

TEST(ReadMaterial, refuses_what_cannot_be) {
  EXPECT_THROW((void)read_lane(R"(<material sOffset="0" friction="-0.1"/>)"), std::runtime_error);
  EXPECT_THROW((void)read_lane(R"(<material sOffset="0" friction="grippy"/>)"), std::runtime_error);
  EXPECT_THROW((void)read_lane(R"(<material sOffset="0" friction="1" roughness="-1"/>)"), std::runtime_error);
}

}  // namespace
