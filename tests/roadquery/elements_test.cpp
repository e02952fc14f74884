// SPDX-License-Identifier: Apache-2.0
// docs/opendrive_elements.md says of every element what opendrive/element_table has.

#include <gtest/gtest.h>

#include <array>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "paths.hpp"
#include "roadquery/opendrive/element_table.hpp"

namespace roadquery {
namespace {

using Named = std::map<std::string, std::array<std::set<std::string>, 3>>;  // by parent: read, passed, missed

std::set<std::string> in_quotes(const std::string& cell) {
  std::set<std::string> words;
  for (std::size_t at = 0; (at = cell.find('`', at)) != std::string::npos;) {
    const std::size_t end = cell.find('`', at + 1);
    words.insert(cell.substr(at + 1, end - at - 1));
    at = end + 1;
  }
  return words;
}

Named of_page() {
  std::ifstream in(orthodrive::paths::in_source("docs/opendrive_elements.md"));
  Named named;
  bool in_table = false;
  for (std::string line; std::getline(in, line);) {
    if (line == "| in | read | passed over | not read |") in_table = true;
    if (!in_table || !line.starts_with("| ") || line.starts_with("| in ")) {
      if (line.empty()) in_table = false;
      continue;
    }
    std::vector<std::string> cells;
    std::istringstream row(line.substr(1));
    for (std::string cell; std::getline(row, cell, '|');) cells.push_back(cell);
    const std::set<std::string> parent = in_quotes(cells.at(0));
    const std::string name = !parent.empty() ? *parent.begin() : cells[0].find("all") != std::string::npos ? "*" : "";
    for (std::size_t i = 0; i < 3; ++i) named[name][i] = in_quotes(cells.at(i + 1));
  }
  return named;
}

TEST(OpenDriveElements, the_page_and_the_table_are_one) {
  Named named;
  for (const OpenDriveElement& element : opendrive_elements())
    named[std::string(element.parent)][static_cast<std::size_t>(element.use)].insert(std::string(element.name));
  EXPECT_EQ(of_page(), named);
}

TEST(OpenDriveElements, are_found_by_parent_then_everywhere) {
  ASSERT_NE(find_element("road", "userData"), nullptr);
  EXPECT_EQ(find_element("road", "userData")->use, ElementUse::read);
  EXPECT_EQ(find_element("lane", "userData")->use, ElementUse::passed);
  EXPECT_EQ(find_element("lane", "include")->use, ElementUse::missed);
  EXPECT_EQ(find_element("lane", "lane"), nullptr);
}

}  // namespace
}  // namespace roadquery
