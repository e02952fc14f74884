// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/models/alignment_io.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "orthodrive/core/error.hpp"

namespace orthodrive {
namespace {

class AlignmentFile : public ::testing::Test {
 protected:
  void SetUp() override {
    for (const std::int64_t id : {71, 72}) {
      RoadPath path;
      path.osm_id = id;
      roads.paths.push_back(path);
    }
  }
  [[nodiscard]] std::string message_for(const std::string& text) const {
    std::ofstream(file) << text;
    try {
      (void)io::read_alignment(file, roads);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }
  RoadNetwork roads;
  std::filesystem::path file = std::filesystem::path(::testing::TempDir()) / "alignment.csv";
};

TEST_F(AlignmentFile, ComesBackAsItWasWithoutPlacesThatSayNothing) {
  const RoadAlignment written{{{0.0, {{1.25, -0.5}, 0.4, 3.0, 0.6}}, {2.0, {}}, {4.0, {{0.0, 0.125}, 2.0, 2.5, 0.3}}},
                              {}};
  io::write_alignment(file, roads, written);
  const RoadAlignment read = io::read_alignment(file, roads);
  ASSERT_EQ(read.size(), 2U);
  ASSERT_EQ(read[0].size(), 2U);
  EXPECT_TRUE(read[1].empty());
  EXPECT_EQ(read[0][1].s_m, 4.0);
  EXPECT_EQ(read[0][0].alignment.displacement_m, (Vec2{1.25, -0.5}));
  EXPECT_EQ(read[0][1].alignment.sigma_half_width_m, 0.3);
  RoadNetwork other;
  other.paths.push_back(roads.paths[1]);
  EXPECT_TRUE(io::read_alignment(file, other)[0].empty());  // ways that the map lacks now are passed over
}

TEST_F(AlignmentFile, ThatIsDamagedIsToldWithItsLine) {
  const std::string header = "osm_id,part,s_m,east_m,north_m,sigma_m,half_width_m,sigma_half_width_m\n";
  EXPECT_NE(message_for("id,x\n").find("line 1"), std::string::npos);
  EXPECT_NE(message_for("").find("line 1"), std::string::npos);
  EXPECT_EQ(message_for(header), "");
  EXPECT_NE(message_for(header + "71,0,0,1,1,0.5,3,0.5\n71,0,2,1,1\n").find("line 3"), std::string::npos);
  EXPECT_NE(message_for(header + "71,0,0,1,1,0,3,0.5\n").find("line 2"), std::string::npos);      // a sigma of nothing
  EXPECT_NE(message_for(header + "71,0,0,1,nan,0.5,3,0.5\n").find("line 2"), std::string::npos);  // no number
  EXPECT_NE(message_for(header + "1e300,0,0,1,1,0.5,3,0.5\n").find("line 2"), std::string::npos);
  EXPECT_NE(message_for(header + "71,0,0,1,1,0.5,3,0.5,9\n").find("line 2"), std::string::npos);
}

}  // namespace
}  // namespace orthodrive
