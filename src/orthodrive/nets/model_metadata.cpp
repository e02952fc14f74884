#include "orthodrive/nets/model_metadata.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "orthodrive/core/error.hpp"

namespace orthodrive {
namespace {

// The same layout as io::class_table_to_json writes into label maps.
nlohmann::json json_from_classes(const ClassTable& table) {
  nlohmann::json classes = nlohmann::json::array();
  for (const ClassInfo& c : table.classes) {
    classes.push_back({{"name", c.name},
                       {"color", c.color},
                       {"role", to_string(c.role)},
                       {"cost_false_positive", c.cost_false_positive},
                       {"cost_false_negative", c.cost_false_negative}});
  }
  return {{"name", table.name}, {"classes", classes}};
}

ClassTable classes_from_json(const nlohmann::json& json) {
  ClassTable table{json.at("name").get<std::string>(), {}};
  for (const auto& entry : json.at("classes")) {
    table.classes.push_back({entry.at("name").get<std::string>(), entry.at("color").get<std::array<std::uint8_t, 3>>(),
                             role_from_string(entry.at("role").get<std::string>()),
                             entry.at("cost_false_positive").get<double>(),
                             entry.at("cost_false_negative").get<double>()});
  }
  return table;
}

}  // namespace

ModelMetadata parse_model_metadata(const std::map<std::string, std::string>& metadata, const std::string& source) {
  try {
    const auto finest = metadata.find("finest_gsd_m");
    ModelMetadata result{metadata.at("architecture"), classes_from_json(nlohmann::json::parse(metadata.at("classes"))),
                         std::stod(metadata.at("gsd_m")), finest == metadata.end() ? 0.0 : std::stod(finest->second)};
    if (!(result.gsd_m > 0.0)) throw Error("gsd_m is not above 0");
    return result;
  } catch (const std::exception& error) {
    throw InputError(
        source,
        fmt::format(
            "has no model metadata (architecture, classes, gsd_m): {}; use a file written by 'orthodrive train'",
            error.what()));
  }
}

std::map<std::string, std::string> format_model_metadata(const ModelMetadata& metadata) {
  std::map<std::string, std::string> items{{"architecture", metadata.architecture},
                                           {"classes", json_from_classes(metadata.classes).dump()},
                                           {"gsd_m", fmt::format("{}", metadata.gsd_m)}};
  if (metadata.finest_gsd_m > 0.0) items["finest_gsd_m"] = fmt::format("{}", metadata.finest_gsd_m);
  return items;
}

}  // namespace orthodrive
