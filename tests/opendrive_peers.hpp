// SPDX-License-Identifier: Apache-2.0
#pragma once
// Real readers of OpenDRIVE: the ASAM schema (xmllint) and SUMO (netconvert).

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <set>
#include <string>

#include "app/run_tool.hpp"
#include "paths.hpp"
#include "roadquery/map/road_map.hpp"

namespace orthodrive {

/// xmllint includes a schema twice when its path has "..": the path is made canonical.
inline const std::filesystem::path opendrive_schema =
    std::filesystem::weakly_canonical(paths::in_source("../shared/data/opendrive/xsd/1.7.0/opendrive_17_core.xsd"));

inline Arguments validate_opendrive(const std::filesystem::path& xodr) {
  return {"/usr/bin/xmllint", "--noout", "--schema", opendrive_schema.string(), xodr.string()};
}
inline void expect_valid_opendrive(const std::filesystem::path& xodr) {
  const ToolRun run = run_program(validate_opendrive(xodr));
  EXPECT_EQ(run.exit_code, 0) << run.err.substr(0, 2000);
}

/// SUMO reads the file without error and makes at least one edge of every road outside junctions.
inline void expect_sumo_finds_all_roads(const std::filesystem::path& xodr, const std::filesystem::path& scratch) {
  const std::filesystem::path net = scratch / "out.net.xml";
  setenv("SUMO_HOME", "/usr/share/sumo", 1);
  const ToolRun run = run_program(
      {"/usr/bin/netconvert", "--opendrive-files", xodr.string(), "--xml-validation", "never", "-o", net.string()});
  ASSERT_EQ(run.exit_code, 0) << run.err.substr(0, 2000);
  EXPECT_EQ(run.err.find("Error"), std::string::npos) << run.err.substr(0, 2000);
  const std::string text = bytes_of(net), key = "<edge id=\"";
  std::set<int> edges;
  for (std::size_t at = text.find(key); at != std::string::npos; at = text.find(key, at + 1)) {
    const char* id = text.c_str() + at + key.size();
    // "-12#1": against road 12, its second part
    if (*id != ':') edges.insert(std::abs(static_cast<int>(std::strtol(id, nullptr, 10))));
  }
  std::size_t roads = 0;
  for (const roadquery::Road& road : roadquery::read_opendrive(xodr.string()).roads)
    if (road.junction < 0) {
      EXPECT_TRUE(edges.count(road.id)) << "road " << road.id;
      ++roads;
    }
  EXPECT_GT(roads, 0u);
}

}  // namespace orthodrive
