// SPDX-License-Identifier: Apache-2.0
#pragma once
// Drive logs: comma2k19 folders and CSV -> model/roads/drive_log.hpp.

#include <filesystem>
#include <vector>

#include "orthodrive/core/finding.hpp"
#include "orthodrive/model/roads/drive_log.hpp"
#include "orthodrive/model/site_frame.hpp"

namespace orthodrive::io {

struct DriveLogs {
  DriveLog log;       ///< site CRS
  Findings findings;  ///< "drive_log.gap", "drive_log.jump", "drive_log.time_order", "drive_log.no_position",
                      ///< "drive_log.unknown_column", "drive_log.outside_area", "drive_log.no_attitude"
};

/// Every file or folder is a source of its own.
///
/// A folder is a segment of comma2k19 (Schafer et al., A Commute in Data: The comma2k19 Dataset, 2018), as it is
/// published (global_pos/frame_*, processed_log/IMU/...) or as .npy files in pose/, imu/, can/. Needed are times and
/// ECEF positions; speed is that of the bus (CAN) where there are no velocities. Attitude is the Hamilton quaternion
/// whose matrix takes (forward, right, down) to ECEF, IMU axes are the same.
///
/// A CSV file (comma, first line names the columns, lines that begin with # do not count) needs time_s, lat, lon
/// (WGS84, degrees); it may have alt_m, sigma_m (of each horizontal coordinate), roll_deg (left side up positive),
/// pitch_deg (nose down positive), heading_deg (clockwise from true north), acc_x_mps2, acc_y_mps2, acc_z_mps2
/// (specific force, forward, left, up: +9.81 upwards at rest), yaw_rate_dps (positive in a left turn), speed_mps
/// (horizontal), climb_mps (up). An empty cell is a value that was not recorded; a row without position carries
/// inertial values only.
///
/// A log is split where poses are more than 1 s (five usual steps, if that is more) apart and where the position jumps
/// further than the speed allows. Poses out of the order of time and more than 200 m outside the area are left out.
/// Throws InputError for what cannot be read, with the line of a CSV.
[[nodiscard]] DriveLogs read_drive_logs(const std::vector<std::filesystem::path>& paths, const SiteFrame& site);

/// The files that belong to a log, in a fixed order: what a cache must look at.
[[nodiscard]] std::vector<std::filesystem::path> drive_log_files(const std::filesystem::path& path);

}  // namespace orthodrive::io
