// SPDX-License-Identifier: Apache-2.0
#pragma once
// Reads OpenDRIVE files of whoever wrote them.

#include <filesystem>

#include "orthodrive/core/finding.hpp"
#include "roadquery/map/road_map.hpp"

namespace orthodrive {

/// What was odd in the file, or is not kept of it (RoadMap::notes), each at its first place.
[[nodiscard]] Findings reading_findings(const roadquery::RoadMap& map);

/// Appends reading_findings(). Throws as roadquery::read_opendrive.
[[nodiscard]] roadquery::RoadMap read_network(const std::filesystem::path& file, Findings& findings);

}  // namespace orthodrive
