// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/model/rasters/class_table_json.hpp"

#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/whole_number.hpp"
#include "orthodrive/model/rasters/rasters.hpp"

namespace orthodrive {

std::string class_table_to_json(const ClassTable& table) {
  nlohmann::ordered_json classes = nlohmann::ordered_json::array();
  for (const ClassInfo& c : table.classes)
    classes.push_back({{"name", c.name},
                       {"color", c.color},
                       {"role", to_string(c.role)},
                       {"cost_false_positive", c.cost_false_positive},
                       {"cost_false_negative", c.cost_false_negative}});
  return nlohmann::ordered_json{{"name", table.name}, {"classes", classes}}.dump();
}

namespace {
std::array<std::uint8_t, 3> color_of(const nlohmann::json& json) {
  std::array<std::uint8_t, 3> color{};
  if (json.size() != color.size()) throw Error("a color has three numbers");
  for (std::size_t i = 0; i < color.size(); ++i) color[i] = whole_number<std::uint8_t>(json.at(i), "a color");
  return color;
}
}  // namespace

ClassTable class_table_from_json(const std::string& text) {
  try {
    const auto json = nlohmann::json::parse(text);
    ClassTable table{.name = json.at("name")};
    for (const auto& c : json.at("classes"))
      table.classes.push_back({.name = c.at("name"),
                               .color = color_of(c.at("color")),
                               .role = role_from_string(c.at("role")),
                               .cost_false_positive = c.at("cost_false_positive"),
                               .cost_false_negative = c.at("cost_false_negative")});
    if (table.classes.empty() || table.classes.size() > label_nodata) throw Error("needs 1 to 255 classes");
    return table;
  } catch (const std::exception& error) {
    throw Error(std::string("class table: ") + error.what());
  }
}

}  // namespace orthodrive
