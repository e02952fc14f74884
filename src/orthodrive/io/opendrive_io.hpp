#pragma once
// OpenDRIVE 1.7 writing. Reading is roadquery::read_opendrive, which simulators share.

#include <filesystem>

#include "roadquery/road_map.hpp"

namespace orthodrive::io {

/// Numbers with fixed steps (1e-6 m, 1e-9 rad and 1/m), no date: same roads, same bytes. Valid against the ASAM 1.7.0 schema.
void write_opendrive(const std::filesystem::path& path, const roadquery::RoadMap& map);

}  // namespace orthodrive::io
