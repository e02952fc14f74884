// SPDX-License-Identifier: Apache-2.0
#pragma once
// GPX: positions that receivers recorded while somebody drove.

#include <filesystem>
#include <vector>

#include "orthodrive/core/finding.hpp"
#include "orthodrive/model/roads/gps_traces.hpp"
#include "orthodrive/model/site_frame.hpp"

namespace orthodrive::io {

struct GpxTraces {
  GpsTraces traces;   ///< site CRS
  Findings findings;  ///< "gpx.outside_area": recordings of which no point is near the area
};

/// The tracks (trk, not the planned rte) of GPX 1.0 and 1.1 files, as far as they are near the area. Every segment is a
/// recording of its own. It is split where two points are more than 60 m or 30 s apart; points without a fix (fix none,
/// coordinates missing, 0/0, NaN or out of range) are left out. Throws InputError for a file that is missing, no GPX or
/// cut off (with the line), and for one without a track point. Needs some ten times the size of a file in memory.
[[nodiscard]] GpxTraces read_gpx(const std::vector<std::filesystem::path>& files, const SiteFrame& site);

}  // namespace orthodrive::io
