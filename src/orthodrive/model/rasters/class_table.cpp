// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/model/rasters/class_table.hpp"

#include "orthodrive/core/error.hpp"

namespace orthodrive {
namespace {
constexpr std::array role_names{"ground", "road", "maybe_road", "building", "vegetation", "water", "rail", "other"};
}

const char* to_string(Role role) { return role_names.at(static_cast<std::size_t>(role)); }

Role role_from_string(const std::string& name) {
  for (std::size_t i = 0; i < role_names.size(); ++i)
    if (name == role_names[i]) return static_cast<Role>(i);
  throw OptionError("class role '" + name +
                    "' is unknown, use one of ground road maybe_road building vegetation water rail other");
}

const ClassTable& default_class_table() {
  // Costs after the reference: road 100 % false positive, parking 20 % false negative, the rest 100 % false negative.
  // Trees hide roads: a crown over the carriageway is weak evidence against it.
  static const ClassTable table{"orthodrive-8",
                                {{"ground", {192, 163, 19}, Role::ground, 0.0, 1.0},
                                 {"road", {76, 76, 76}, Role::road, 1.0, 0.0},
                                 {"parking", {19, 163, 192}, Role::maybe_road, 0.0, 0.2},
                                 {"building", {230, 23, 23}, Role::building, 0.0, 1.0},
                                 {"vegetation", {28, 115, 11}, Role::vegetation, 0.0, 0.5},
                                 {"grass", {115, 230, 92}, Role::ground, 0.0, 1.0},
                                 {"water", {19, 62, 192}, Role::water, 0.0, 1.0},
                                 {"rail", {153, 84, 15}, Role::rail, 0.0, 1.0}}};
  return table;
}

}  // namespace orthodrive
