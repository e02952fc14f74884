// SPDX-License-Identifier: Apache-2.0
// OpenDRIVE files: read, made ready, asked on the roads, beside them and at no place at all. References to OpenCRG
// files find one that is there.

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>
#include <stdexcept>
#include <vector>

#include "memory_file.hpp"
#include "roadquery/crg/road_crgs.hpp"
#include "roadquery/query/road_query.hpp"

namespace {

/// a.crg, which the corpus refers to.
std::string write_surface() {
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("fuzz_opendrive_" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  std::ofstream out(folder / "a.crg");
  out << "$ROAD_CRG\nREFERENCE_LINE_INCREMENT = 5\nREFERENCE_LINE_START_S = 0.01\nLONG_SECTION_V_INCREMENT = 2\n"
         "$KD_DEFINITION\n#:LRFI\nD:reference line phi,rad\nD:long section 1,m\nD:long section 2,m\nD:long section "
         "3,m\n$$$$\n";
  for (int row = 0; row < 20; ++row) out << "      0.03      0.01      0.00      0.02\n";
  return folder.string();
}

void ask(const roadquery::RoadQuery& query) {
  const double infinite = std::numeric_limits<double>::infinity();
  const auto& roads = query.map().roads;
  const std::vector<bool> on_level(roads.size(), true);
  roadquery::Cursor cursor;
  for (std::size_t i = 0; i < roads.size() && i < 4; ++i)
    for (const double share : {0.0, 0.4, 1.0}) {
      const double s = share * roads[i].length;
      const roadquery::PlanPoint p = roadquery::reference_point(roads[i], s);
      for (const double beside : {-2.0, 0.1, 40.0}) {
        const double x = p.x - beside * std::sin(p.hdg), y = p.y + beside * std::cos(p.hdg);
        roadquery::Cursor fresh;
        (void)query.find(x, y, std::nan(""), fresh);
        (void)query.find(x, y, 20.0, cursor);
        (void)query.find_height(x, y, 1.0, cursor);
        (void)query.at(i, s + beside, beside);
        (void)query.sample(x, y, 1.0, on_level);
      }
    }
  for (const double odd : {std::nan(""), infinite, -infinite, 1e300, -1e9}) {
    (void)query.find(odd, 0.0, 0.0, cursor), (void)query.find(0.0, odd, odd, cursor);
    (void)query.find(10.0, 0.5, odd, cursor);
    (void)query.at(0, odd, 0.0), (void)query.at(0, 1.0, odd);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static fuzz::MemoryFile file;
  static const std::string folder = write_surface();
  try {
    roadquery::RoadMap map = roadquery::read_opendrive(file.with(data, size));
    try {
      map.crgs = std::make_shared<const roadquery::RoadCrgs>(map, folder);
    } catch (const std::runtime_error& error) {
      fuzz::expect_one_line(error.what());
    }
    ask(roadquery::RoadQuery(std::move(map)));
  } catch (const std::runtime_error& error) {
    fuzz::expect_one_line(error.what());
  }
  return 0;
}
