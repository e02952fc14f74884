// SPDX-License-Identifier: Apache-2.0
#pragma once
// Surveyed race tracks as text tables: the format of the TUM race track database with a placement in UTM 33N.

#include <string>
#include <string_view>
#include <vector>

#include "orthodrive/geo/vec.hpp"

namespace orthodrive::synth {

/// One row: a point of the surveyed line (not the middle of the road) and the way to both edges, across the line.
struct TrackRow {
  Vec2 p;  ///< EPSG:32633
  double right_m = 0.0, left_m = 0.0;
};

/// Columns w_tr_right_m, w_tr_left_m, utm33_e, utm33_n by the names in the first line (which may begin with #), in any
/// order, others ignored. The track is closed: the last row is not a repeat of the first (a repeat is dropped).
/// Throws InputError naming `file` and the line: a column is missing, no number, a width <= 0, a row twice, fewer than
/// 10 rows, ends farther apart than three times the usual distance of rows.
[[nodiscard]] std::vector<TrackRow> parse_track(std::string_view text, const std::string& file);

/// Columns lon, lat (WGS84 degrees), elev_m. Result in EPSG:32633. Throws InputError like parse_track; needs 3 rows.
[[nodiscard]] std::vector<Vec3> parse_heights(std::string_view text, const std::string& file);

}  // namespace orthodrive::synth
