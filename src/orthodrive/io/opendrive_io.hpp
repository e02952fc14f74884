#pragma once
// OpenDRIVE 1.7 writing. Reading is roadquery::read_opendrive, which simulators share.

#include <filesystem>

#include "roadquery/road_map.hpp"

namespace orthodrive::io {

/// Valid against the ASAM 1.7.0 schema. Numbers in fixed steps (1e-8 m, 1e-12 rad, 1e-14 1/m; polynomials with 13 digits:
/// joints stay closed to a micrometre), no date: same roads, same bytes. Throws Error for a map without roads, which the
/// schema does not allow.
void write_opendrive(const std::filesystem::path& path, const roadquery::RoadMap& map);

}  // namespace orthodrive::io
