// SPDX-License-Identifier: Apache-2.0
#pragma once
// OpenDRIVE 1.7 and 1.8 writing. Reading is roadquery::read_opendrive, which simulators share.

#include <filesystem>

#include "roadquery/map/road_map.hpp"

namespace orthodrive::io {

struct WriteOpenDriveOptions {
  int minor_version = 7;  ///< 1.7 or 1.8; others throw OptionError
  bool absolute = false;  ///< coordinates of the geoReference themselves, without a header <offset>
  /// The surfaces of junctions as <boundary> and <elevationGrid>, too; 1.8 only, else OptionError. SUMO's netconvert
  /// refuses a file with <elevationGrid>.
  bool junction_grids = false;
};

/// Valid against the ASAM schema 1.7.0 or 1.8.1. What is written is the same for both but for the version in the
/// header: all elements of it exist in 1.7 and are not deprecated in 1.8; junction grids come besides. Places in steps
/// of 1e-7 m, lengths of 1e-8 m; headings, curvatures and coefficients with as many decimals as move what they make
/// along their piece by less than 1e-7 m (headings and curvatures 1e-6 m) (superelevation: 1e-8 rad, widths: 1e-10 m),
/// in their shortest notation, so joints stay closed to a micrometre. What has its default is left out (a lane's
/// `level`, road marks of type none), and of connecting roads what the roads say that they connect
/// (connecting_road.hpp). No date: same roads, same bytes. Throws Error for a map without roads, which the schema does
/// not allow. Coordinates are local: less the whole kilometres of the middle of the roads, which stand in the header's
/// <offset> (1.7, t_header_Offset) and give the coordinates of the geoReference when added. Simulators that compute in
/// single precision would otherwise have steps of half a metre (ulp of a UTM northing). Nothing is lost: whole
/// kilometres are subtracted exactly.
void write_opendrive(const std::filesystem::path& path, const roadquery::RoadMap& map,
                     const WriteOpenDriveOptions& options = {});

}  // namespace orthodrive::io
