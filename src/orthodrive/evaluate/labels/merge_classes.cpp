// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/evaluate/labels/merge_classes.hpp"

#include <algorithm>

#include "orthodrive/core/error.hpp"

namespace orthodrive {
namespace {
std::size_t find_class(const std::vector<ClassInfo>& classes, const std::string& name) {
  const auto at = std::find_if(classes.begin(), classes.end(), [&](const ClassInfo& c) { return c.name == name; });
  return static_cast<std::size_t>(at - classes.begin());
}

void check(const std::vector<ClassInfo>& classes, const MergeTable& table) {
  for (const auto& [from, to] : table) {
    if (find_class(classes, from) == classes.size())
      throw OptionError("class '" + from + "' is to be merged, but neither label map has it; take it out");
    if (from != to && table.contains(to))
      throw OptionError("class '" + from + "' is to be merged into '" + to + "', which goes into '" + table.at(to) +
                        "' itself; name the last class for both");
  }
}
}  // namespace

MergedClasses merge_classes(const std::vector<ClassInfo>& classes, const MergeTable& table) {
  check(classes, table);
  const auto target = [&](const ClassInfo& c) {
    const auto at = table.find(c.name);
    return at == table.end() ? c.name : at->second;
  };
  MergedClasses merged;
  for (const ClassInfo& c : classes) {
    const std::string name = target(c);
    const bool stays = name == c.name;
    const bool new_class = find_class(classes, name) == classes.size();
    if (!stays && (!new_class || find_class(merged.classes, name) < merged.classes.size())) continue;
    merged.classes.push_back(c);
    merged.classes.back().name = name;
  }
  for (const ClassInfo& c : classes)
    merged.from_old.push_back(static_cast<std::uint16_t>(find_class(merged.classes, target(c))));
  return merged;
}

}  // namespace orthodrive
