// SPDX-License-Identifier: Apache-2.0
#pragma once
// What a measuring car recorded: where it was, how it was turned, what its inertial sensors felt. On disk: comma2k19
// folders and CSV (io/opendrive/drive_log_io).
//
// Vehicle axes and signs are those of ISO 8855: x forward, y left, z up; roll positive = left side up, pitch positive =
// nose down, heading counter-clockwise from the x axis of the site CRS. What was not recorded is NaN.

#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "orthodrive/geo/crs.hpp"
#include "orthodrive/geo/vec.hpp"

namespace orthodrive {

inline constexpr double not_recorded = std::numeric_limits<double>::quiet_NaN();

/// Position and attitude at one time, as a receiver or a GNSS/INS filter gives them.
struct DrivePose {
  double time_s = 0.0;
  Vec2 p;                     ///< site CRS
  double z_m = not_recorded;  ///< any datum: its offset to the site's heights is estimated
  double sigma_p_m = 2.0;     ///< standard deviation of each coordinate of p
  double roll_rad = not_recorded, pitch_rad = not_recorded;
  double heading_rad = not_recorded;
  double speed_mps = not_recorded;  ///< horizontal, over the ground
  double climb_mps = not_recorded;  ///< vertical velocity, up
};

/// Inertial sensors at one time. Specific force: at rest on level ground it is (0, 0, +9.81).
struct DriveImu {
  double time_s = 0.0;
  Vec3 specific_force_mps2{not_recorded, not_recorded, not_recorded};
  double yaw_rate_radps = not_recorded;  ///< about z, positive in a left turn
};

/// A drive without gaps. Times ascend strictly in both series; imu lies within the times of the poses.
struct DriveRecording {
  std::size_t source = 0;  ///< recordings of one source (file, folder) share one mounting of the sensor in one car
  std::vector<DrivePose> poses;
  std::vector<DriveImu> imu;
};

struct DriveLog {
  Crs crs;
  std::vector<std::string> sources;  ///< names, for messages
  std::vector<DriveRecording> recordings;
};

}  // namespace orthodrive
