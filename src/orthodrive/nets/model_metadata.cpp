// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/nets/model_metadata.hpp"

#include <fmt/format.h>

#include "orthodrive/core/error.hpp"
#include "orthodrive/model/rasters/class_table_json.hpp"

namespace orthodrive {

ModelMetadata parse_model_metadata(const std::map<std::string, std::string>& metadata, const std::string& source) {
  try {
    const auto finest = metadata.find("finest_gsd_m");
    ModelMetadata result{metadata.at("architecture"), class_table_from_json(metadata.at("classes")),
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
                                           {"classes", class_table_to_json(metadata.classes)},
                                           {"gsd_m", fmt::format("{}", metadata.gsd_m)}};
  if (metadata.finest_gsd_m > 0.0) items["finest_gsd_m"] = fmt::format("{}", metadata.finest_gsd_m);
  return items;
}

}  // namespace orthodrive
