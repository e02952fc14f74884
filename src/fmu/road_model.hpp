// SPDX-License-Identifier: Apache-2.0
#pragma once
// Variables that both models have: which road.

#include <optional>

#include "fmu/model.hpp"
#include "roadquery/query/ground_query.hpp"

namespace fmu {

/// Value references of the road's parameters, in every model.
enum RoadParameter : std::size_t { time_ref, road_file_ref, terrain_file_ref, header_offset_ref, road_parameters_end };

/// time and the parameters above.
[[nodiscard]] std::vector<Variable> road_variables();
/// The file that a parameter names, else that of the resources; nothing when that is not there.
[[nodiscard]] std::optional<std::filesystem::path> file_of(const std::string& parameter,
                                                           const std::filesystem::path& resources, const char* file);
/// Reads what they name: roads.xodr, terrain.asc (if there is one) of the resources by default.
[[nodiscard]] std::unique_ptr<roadquery::GroundQuery> read_ground(const Values& values,
                                                                  const std::filesystem::path& resources);

}  // namespace fmu
