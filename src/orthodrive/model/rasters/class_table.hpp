// SPDX-License-Identifier: Apache-2.0
#pragma once
// Classes are data: a table comes with each model, no code knows "class 33". Later stages use roles and costs only.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace orthodrive {

/// What a class means to later stages.
enum class Role : std::uint8_t { ground, road, maybe_road, building, vegetation, water, rail, other };

[[nodiscard]] const char* to_string(Role role);
/// Throws OptionError for an unknown name.
[[nodiscard]] Role role_from_string(const std::string& name);

struct ClassInfo {
  std::string name;
  std::array<std::uint8_t, 3> color{};
  Role role = Role::other;
  double cost_false_positive = 0.0;  ///< cost of such a pixel just outside a road, 0..1 (thesis table 3.2)
  double cost_false_negative = 1.0;  ///< cost of such a pixel inside a road near its border, 0..1
};

struct ClassTable {
  std::string name;
  std::vector<ClassInfo> classes;  ///< index = label value
};

constexpr std::uint8_t label_nodata = 255;  ///< no photo here, or ignored in training and evaluation

/// The table of the shipped model and of the synthetic sites:
/// 0 ground, 1 road, 2 parking (maybe_road), 3 building, 4 vegetation (trees, shrubs), 5 grass (ground), 6 water, 7
/// rail.
[[nodiscard]] const ClassTable& default_class_table();

}  // namespace orthodrive
