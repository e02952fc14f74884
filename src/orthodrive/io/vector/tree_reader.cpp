// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/vector/tree_reader.hpp"

#include "orthodrive/io/support/vector_io.hpp"

namespace orthodrive::io {
namespace {

constexpr double row_step_m = 8.0;
constexpr double max_row_m = 20000.0;  // longer ones are mistakes

bool has_no_tags(const Feature& feature) {
  for (const auto& [key, value] : feature.tags)
    if (!value.empty()) return false;
  return true;
}

void add_row(const Polyline& line, const SiteFrame& site, std::vector<Vec2>& trees) {
  double length_m = 0.0;
  for (std::size_t i = 1; i < line.size(); ++i) length_m += distance(line[i - 1], line[i]);
  if (!(length_m <= max_row_m)) return;
  double to_next_m = 0.0;
  for (std::size_t i = 1; i < line.size(); ++i) {
    const double piece_m = distance(line[i - 1], line[i]);
    for (; to_next_m <= piece_m && piece_m > 0.0; to_next_m += row_step_m) {
      const Vec2 p = line[i - 1] + (line[i] - line[i - 1]) * (to_next_m / piece_m);
      if (contains(site.area, p)) trees.push_back(p);
    }
    to_next_m -= piece_m;
  }
}

}  // namespace

std::vector<Vec2> read_trees(const std::vector<std::filesystem::path>& files, const SiteFrame& site) {
  std::vector<Vec2> trees;
  for (const Feature& feature : read_features(files, site.crs)) {
    const auto natural = feature.tags.find("natural");
    const bool tree = natural != feature.tags.end() && natural->second == "tree";
    if (tree || has_no_tags(feature))
      for (const Vec2 p : feature.points)
        if (contains(site.area, p)) trees.push_back(p);
    if (natural != feature.tags.end() && natural->second == "tree_row")
      for (const Polyline& line : feature.lines) add_row(line, site, trees);
  }
  return trees;
}

}  // namespace orthodrive::io
