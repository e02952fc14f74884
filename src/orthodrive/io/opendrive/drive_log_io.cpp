// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/opendrive/drive_log_io.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <map>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/median.hpp"
#include "orthodrive/io/support/gdal_support.hpp"
#include "orthodrive/io/support/npy_reader.hpp"
#include "roadquery/text/text.hpp"

namespace orthodrive::io {
namespace fs = std::filesystem;

namespace {

constexpr double rad = std::numbers::pi / 180.0;
constexpr double gap_s = 1.0, gap_steps = 5.0;
constexpr double jump_m = 5.0, jump_z_m = 2.0;  // more than the scatter from one fix to the next
constexpr double fastest_mps = 100.0;           // where no speed was recorded
constexpr double margin_m = 200.0;              // so far outside the area a log may still help its border

/// What a source says, before it has a place in the site.
struct RawPose {
  DrivePose pose;
  double lon = not_recorded, lat = not_recorded;
  double true_heading_rad = not_recorded;  ///< counter-clockwise from true east
};
struct RawLog {
  std::vector<RawPose> poses;
  std::vector<DriveImu> imu;
};

// --- comma2k19

/// Columns of the matrix of a Hamilton quaternion: the rotated axes.
std::array<Vec3, 3> axes_of(double w, double x, double y, double z) {
  const double n = std::sqrt(w * w + x * x + y * y + z * z);
  w /= n, x /= n, y /= n, z /= n;
  return {Vec3{1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)},
          Vec3{2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)},
          Vec3{2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)}};
}

double dot3(const Vec3& a, const Vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

/// East, north and up at a place, in ECEF.
struct LocalFrame {
  Vec3 east, north, up;
  LocalFrame(double lon, double lat)
      : east{-std::sin(lon), std::cos(lon), 0.0},
        north{-std::sin(lat) * std::cos(lon), -std::sin(lat) * std::sin(lon), std::cos(lat)},
        up{std::cos(lat) * std::cos(lon), std::cos(lat) * std::sin(lon), std::sin(lat)} {}
  [[nodiscard]] Vec3 from_ecef(const Vec3& v) const { return {dot3(east, v), dot3(north, v), dot3(up, v)}; }
};

/// The names of one array in the two layouts; empty when the folder has neither.
fs::path find_array(const fs::path& folder, const char* ours, const char* published) {
  for (const char* name : {ours, published})
    if (fs::is_regular_file(folder / name)) return folder / name;
  return {};
}

NpyTable need_array(const fs::path& folder, const char* ours, const char* published) {
  const fs::path file = find_array(folder, ours, published);
  if (file.empty())
    throw InputError(folder.string(), fmt::format("is no comma2k19 segment: has neither {} nor {}", ours, published));
  return read_npy(file);
}

void need_shape(const fs::path& folder, const char* what, const NpyTable& table, std::size_t rows,
                std::size_t columns) {
  if (table.rows != rows || table.columns != columns)
    throw InputError(folder.string(), fmt::format("{} are {} x {} values, need {} x {} as there are times", what,
                                                  table.rows, table.columns, rows, columns));
}

/// An array that a segment may lack.
std::optional<NpyTable> find_table(const fs::path& folder, const char* ours, const char* published, const char* what,
                                   std::size_t rows, std::size_t columns) {
  const fs::path file = find_array(folder, ours, published);
  if (file.empty()) return std::nullopt;
  NpyTable table = read_npy(file);
  need_shape(folder, what, table, rows, columns);
  return table;
}

void set_attitude(RawPose& pose, const LocalFrame& frame, const NpyTable& quaternions, std::size_t i) {
  const auto axes = axes_of(quaternions.at(i, 0), quaternions.at(i, 1), quaternions.at(i, 2), quaternions.at(i, 3));
  const Vec3 forward = frame.from_ecef(axes[0]), left = frame.from_ecef(axes[1]) * -1.0,
             up = frame.from_ecef(axes[2]) * -1.0;
  // Yaw, pitch, roll in this order (ISO 8855, 5.2): R = Rz Ry Rx.
  pose.pose.pitch_rad = -std::asin(std::clamp(forward.z, -1.0, 1.0));
  pose.pose.roll_rad = std::atan2(left.z, up.z);
  pose.true_heading_rad = std::atan2(forward.y, forward.x);
}

/// Speed on the vehicle's bus, where no velocities were recorded. Linear between its times.
void set_bus_speed(const fs::path& folder, std::vector<RawPose>& poses) {
  const fs::path file = find_array(folder, "can/speed_t.npy", "processed_log/CAN/speed/t");
  if (file.empty()) return;
  const NpyTable times = read_npy(file);
  const auto speeds =
      find_table(folder, "can/speed_value.npy", "processed_log/CAN/speed/value", "speeds", times.rows, 1);
  if (!speeds) return;
  for (RawPose& raw : poses) {
    const auto after = static_cast<std::size_t>(
        std::upper_bound(times.values.begin(), times.values.end(), raw.pose.time_s) - times.values.begin());
    if (after == 0 || after == times.rows) continue;
    const double f = (raw.pose.time_s - times.at(after - 1)) / (times.at(after) - times.at(after - 1));
    raw.pose.speed_mps = speeds->at(after - 1) * (1.0 - f) + speeds->at(after) * f;
  }
}

RawLog read_comma_segment(const fs::path& folder) {
  const NpyTable times = need_array(folder, "pose/times.npy", "global_pos/frame_times");
  const NpyTable positions = need_array(folder, "pose/positions_ecef.npy", "global_pos/frame_positions");
  need_shape(folder, "positions", positions, times.rows, 3);
  const auto velocities =
      find_table(folder, "pose/velocities_ecef.npy", "global_pos/frame_velocities", "velocities", times.rows, 3);
  const auto attitudes =
      find_table(folder, "pose/orientations_ecef.npy", "global_pos/frame_orientations", "orientations", times.rows, 4);
  RawLog log;
  for (std::size_t i = 0; i < times.rows; ++i) {
    RawPose pose;
    pose.pose.time_s = times.at(i);
    const Vec3 ecef{positions.at(i, 0), positions.at(i, 1), positions.at(i, 2)};
    if (std::isfinite(ecef.x + ecef.y + ecef.z) && std::sqrt(dot3(ecef, ecef)) > 6.3e6) {
      const Vec3 place = geographic_from_ecef(ecef);
      pose.lon = place.x, pose.lat = place.y, pose.pose.z_m = place.z;
      const LocalFrame frame(place.x * rad, place.y * rad);
      if (velocities) {
        const Vec3 v = frame.from_ecef({velocities->at(i, 0), velocities->at(i, 1), velocities->at(i, 2)});
        pose.pose.speed_mps = std::hypot(v.x, v.y), pose.pose.climb_mps = v.z;
      }
      if (attitudes) set_attitude(pose, frame, *attitudes, i);
    }
    log.poses.push_back(pose);
  }
  if (!velocities) set_bus_speed(folder, log.poses);
  if (const fs::path file = find_array(folder, "imu/accelerometer_t.npy", "processed_log/IMU/accelerometer/t");
      !file.empty()) {
    const NpyTable imu_times = read_npy(file);
    const auto force = find_table(folder, "imu/accelerometer_value.npy", "processed_log/IMU/accelerometer/value",
                                  "accelerations", imu_times.rows, 3);
    const auto rates =
        find_table(folder, "imu/gyro_value.npy", "processed_log/IMU/gyro/value", "rates of turn", imu_times.rows, 3);
    for (std::size_t i = 0; i < imu_times.rows; ++i) {
      DriveImu imu{.time_s = imu_times.at(i)};
      if (force) imu.specific_force_mps2 = {force->at(i, 0), -force->at(i, 1), -force->at(i, 2)};
      if (rates) imu.yaw_rate_radps = -rates->at(i, 2);
      log.imu.push_back(imu);
    }
  }
  return log;
}

// --- CSV

enum class Column {
  time,
  lat,
  lon,
  alt,
  sigma,
  roll,
  pitch,
  heading,
  acc_x,
  acc_y,
  acc_z,
  yaw_rate,
  speed,
  climb,
  count
};
constexpr std::array<std::string_view, static_cast<std::size_t>(Column::count)> column_names{
    "time_s",      "lat",        "lon",        "alt_m",      "sigma_m",      "roll_deg",  "pitch_deg",
    "heading_deg", "acc_x_mps2", "acc_y_mps2", "acc_z_mps2", "yaw_rate_dps", "speed_mps", "climb_mps"};

constexpr std::string_view blanks_and_quotes = " \t\r\"";

std::vector<std::string_view> cells_of(std::string_view line) {
  std::vector<std::string_view> cells;
  for (std::size_t at = 0;;) {
    const auto comma = line.find(',', at);
    cells.push_back(roadquery::trimmed(line.substr(at, comma - at), blanks_and_quotes));
    if (comma == std::string_view::npos) return cells;
    at = comma + 1;
  }
}

class CsvLog {
 public:
  explicit CsvLog(const fs::path& file) : file_(file), in_(file) {
    if (!in_ || !fs::is_regular_file(file)) throw InputError(file.string(), "no such drive log");
    if (!next_line()) throw InputError(file.string(), "is empty, need a first line with the names of the columns");
    column_of_.fill(npos);
    const auto names = cells_of(line_);
    for (std::size_t i = 0; i < names.size(); ++i) {
      const auto known = std::ranges::find(column_names, names[i]);
      if (known == column_names.end())
        unknown_.emplace_back(names[i]);
      else if (auto& column = column_of_[static_cast<std::size_t>(known - column_names.begin())]; column == npos)
        column = i;
      else
        throw InputError(file.string(), fmt::format("line {}: column {} is there twice", number_, names[i]));
    }
    columns_ = names.size();
    for (const Column needed : {Column::time, Column::lat, Column::lon})
      if (!has(needed))
        throw InputError(file.string(), fmt::format("line {}: no column {}; a drive log in CSV needs time_s, lat, lon",
                                                    number_, column_names[static_cast<std::size_t>(needed)]));
  }

  RawLog read() {
    const bool imu = has(Column::acc_x) || has(Column::acc_y) || has(Column::acc_z) || has(Column::yaw_rate);
    RawLog log;
    while (next_line()) {
      cells_ = cells_of(line_);
      if (cells_.size() != columns_)
        throw InputError(file_.string(), fmt::format("line {}: {} values, the first line names {} columns", number_,
                                                     cells_.size(), columns_));
      const double time = value(Column::time);
      if (!std::isfinite(time)) throw InputError(file_.string(), fmt::format("line {}: no time", number_));
      if (imu)
        log.imu.push_back(
            {time, {value(Column::acc_x), value(Column::acc_y), value(Column::acc_z)}, value(Column::yaw_rate) * rad});
      const double lat = value(Column::lat), lon = value(Column::lon);
      if (imu && std::isnan(lat) && std::isnan(lon)) continue;  // inertial values come more often than fixes
      RawPose& raw = log.poses.emplace_back();
      raw.lat = lat, raw.lon = lon;
      raw.true_heading_rad = (90.0 - value(Column::heading)) * rad;
      DrivePose& pose = raw.pose;
      pose.time_s = time, pose.z_m = value(Column::alt);
      if (const double sigma = value(Column::sigma); sigma > 0.0) pose.sigma_p_m = sigma;
      pose.roll_rad = value(Column::roll) * rad, pose.pitch_rad = value(Column::pitch) * rad;
      pose.speed_mps = value(Column::speed), pose.climb_mps = value(Column::climb);
    }
    return log;
  }
  [[nodiscard]] const std::vector<std::string>& unknown_columns() const { return unknown_; }

 private:
  static constexpr std::size_t npos = static_cast<std::size_t>(-1);

  bool next_line() {
    while (std::getline(in_, line_)) {
      ++number_;
      if (number_ == 1 && line_.starts_with("\xef\xbb\xbf")) line_.erase(0, 3);
      const auto text = roadquery::trimmed(line_, blanks_and_quotes);
      if (!text.empty() && text.front() != '#') return true;
    }
    return false;
  }
  [[nodiscard]] bool has(Column column) const { return column_of_[static_cast<std::size_t>(column)] != npos; }
  [[nodiscard]] double value(Column column) const {
    if (!has(column)) return not_recorded;
    std::string_view text = cells_[column_of_[static_cast<std::size_t>(column)]];
    if (text.empty()) return not_recorded;
    if (text.front() == '+') text.remove_prefix(1);
    double number = 0.0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc{} || end != text.data() + text.size())
      throw InputError(file_.string(), fmt::format("line {}: {} is '{}', need a number or nothing", number_,
                                                   column_names[static_cast<std::size_t>(column)], text));
    return std::isfinite(number) ? number : not_recorded;
  }

  fs::path file_;
  std::ifstream in_;
  std::string line_;
  std::size_t number_ = 0, columns_ = 0;
  std::array<std::size_t, column_names.size()> column_of_{};
  std::vector<std::string_view> cells_;
  std::vector<std::string> unknown_;
};

// --- both

/// The poses of a source with a place in the site, and what had to be left out.
class Placer {
 public:
  explicit Placer(const SiteFrame& site)
      : site_(site), site_from_lonlat_(Crs{"EPSG:4326"}, site.crs), area_(lonlat_bounds(site.area.outer, site.crs)) {
    constexpr double degree_m = 111'000.0;
    const double middle = 0.5 * (area_.min_y + area_.max_y) * rad, margin = margin_m / degree_m;
    const double margin_lon = margin / std::max(0.01, std::cos(middle));
    near_ = {area_.min_x - margin_lon, area_.min_y - margin, area_.max_x + margin_lon, area_.max_y + margin};
  }

  std::vector<DrivePose> place(const fs::path& source, const RawLog& log, Findings& findings) const {
    std::vector<DrivePose> poses;
    std::size_t placeless = 0, outside = 0, backwards = 0, no_attitude = 0;
    Ring far;
    double last_s = -HUGE_VAL;
    for (const RawPose& raw : log.poses) {
      const Vec2 lonlat{raw.lon, raw.lat};
      if (!(std::abs(raw.lon) <= 180.0 && std::abs(raw.lat) <= 90.0) || (raw.lon == 0.0 && raw.lat == 0.0)) {
        ++placeless;
      } else if (!(raw.pose.time_s > last_s)) {
        ++backwards;
      } else if (last_s = raw.pose.time_s; !near_.contains(lonlat)) {
        ++outside, far.push_back(lonlat);
      } else {
        poses.push_back(raw.pose);
        poses.back().p = site_from_lonlat_.target_from_source(lonlat);
        poses.back().heading_rad = grid_heading(lonlat, raw.true_heading_rad);
        no_attitude += std::isnan(raw.pose.pitch_rad) && std::isnan(raw.pose.climb_mps) && std::isnan(raw.pose.z_m);
      }
    }
    const Box2 middle = bounds_of(site_.area.outer);
    const Vec2 where = poses.empty() ? Vec2{0.5 * (middle.min_x + middle.max_x), 0.5 * (middle.min_y + middle.max_y)}
                                     : poses.front().p;
    const auto report = [&](std::size_t count, const char* code, const std::string& what) {
      if (count > 0)
        findings.push_back(
            {Severity::warning, code,
             fmt::format("{}: {} of {} poses {}", source.filename().string(), count, log.poses.size(), what), where.x,
             where.y});
    };
    report(placeless, "drive_log.no_position", "have no position and are left out");
    report(backwards, "drive_log.time_order", "are not later than the one before and are left out");
    if (outside > 0)
      report(outside, "drive_log.outside_area",
             fmt::format("are not near the area ({}; the area is {})", describe_lonlat(bounds_of(far)),
                         describe_lonlat(area_)));
    report(no_attitude, "drive_log.no_attitude", "have neither height, climb nor pitch: they say nothing of gradients");
    return poses;
  }

 private:
  /// The grid's north is not the true one: a small step in the heading's direction is drawn in the grid.
  double grid_heading(Vec2 lonlat, double true_heading_rad) const {
    if (std::isnan(true_heading_rad)) return not_recorded;
    constexpr double step_deg = 1e-4, e2 = 0.00669437999014;  // WGS84
    const double sine = std::sin(lonlat.y * rad), cosine = std::max(0.01, std::cos(lonlat.y * rad));
    const double n_over_m = (1.0 - e2 * sine * sine) / (1.0 - e2);  // radii of curvature: a degree north is shorter
    const Vec2 ahead =
        lonlat + Vec2{std::cos(true_heading_rad) / cosine, std::sin(true_heading_rad) * n_over_m} * step_deg;
    const Vec2 d = site_from_lonlat_.target_from_source(ahead) - site_from_lonlat_.target_from_source(lonlat);
    return std::atan2(d.y, d.x);
  }

  const SiteFrame& site_;
  CoordinateTransform site_from_lonlat_;
  Box2 area_, near_;
};

double usual_step_s(const std::vector<DrivePose>& poses) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < poses.size(); ++i) steps.push_back(poses[i].time_s - poses[i - 1].time_s);
  if (steps.empty()) return 0.0;
  return median(std::move(steps));
}

/// Whether the car cannot have come from a to b; says how far apart they are.
std::optional<Finding> break_between(const std::string& source, const DrivePose& a, const DrivePose& b,
                                     double longest_step_s) {
  const double step_s = b.time_s - a.time_s, step_m = distance(a.p, b.p);
  if (step_s > longest_step_s)
    return Finding{Severity::info, "drive_log.gap",
                   fmt::format("{}: nothing for {:.1f} s after {:.2f} s ({:.0f} m), the log is split there", source,
                               step_s, a.time_s, step_m),
                   a.p.x, a.p.y};
  const double speed =
      std::isnan(a.speed_mps) && std::isnan(b.speed_mps) ? fastest_mps : std::fmax(a.speed_mps, b.speed_mps);
  const double step_z_m = std::isnan(a.z_m) || std::isnan(b.z_m) ? 0.0 : std::abs(b.z_m - a.z_m);
  if (step_m > jump_m + 1.5 * speed * step_s || step_z_m > jump_z_m + 0.5 * speed * step_s)
    return Finding{Severity::warning, "drive_log.jump",
                   fmt::format("{}: the position jumps by {:.1f} m and {:.1f} m in height at {:.2f} s, the log is "
                               "split there",
                               source, step_m, step_z_m, b.time_s),
                   b.p.x, b.p.y};
  return std::nullopt;
}

void split(const std::vector<DrivePose>& poses, std::vector<DriveImu> imu, std::size_t source, DriveLog& log,
           Findings& findings) {
  std::stable_sort(imu.begin(), imu.end(), [](const DriveImu& a, const DriveImu& b) { return a.time_s < b.time_s; });
  imu.erase(
      std::unique(imu.begin(), imu.end(), [](const DriveImu& a, const DriveImu& b) { return a.time_s == b.time_s; }),
      imu.end());
  const double longest_step_s = std::max(gap_s, gap_steps * usual_step_s(poses));
  const auto finish = [&](std::size_t begin, std::size_t end) {
    if (end - begin < 2) return;
    DriveRecording& recording = log.recordings.emplace_back();
    recording.source = source;
    recording.poses.assign(poses.begin() + static_cast<std::ptrdiff_t>(begin),
                           poses.begin() + static_cast<std::ptrdiff_t>(end));
    const auto later = [](double t, const DriveImu& i) { return t < i.time_s; };
    const auto earlier = [](const DriveImu& i, double t) { return i.time_s < t; };
    recording.imu.assign(std::lower_bound(imu.begin(), imu.end(), poses[begin].time_s, earlier),
                         std::upper_bound(imu.begin(), imu.end(), poses[end - 1].time_s, later));
  };
  std::size_t begin = 0;
  for (std::size_t i = 1; i < poses.size(); ++i) {
    const auto broken = break_between(log.sources[source], poses[i - 1], poses[i], longest_step_s);
    if (!broken) continue;
    findings.push_back(*broken);
    finish(begin, i);
    begin = i;
  }
  if (!poses.empty()) finish(begin, poses.size());
}

}  // namespace

DriveLogs read_drive_logs(const std::vector<fs::path>& paths, const SiteFrame& site) {
  DriveLogs result{.log = {.crs = site.crs}};
  if (paths.empty()) return result;
  const Placer placer(site);
  for (const fs::path& path : paths) {
    RawLog raw;
    const std::size_t source = result.log.sources.size();
    result.log.sources.push_back(path.has_filename() ? path.filename().string()
                                                     : path.parent_path().filename().string());
    if (fs::is_directory(path)) {
      raw = read_comma_segment(path);
    } else {
      CsvLog csv(path);
      raw = csv.read();
      if (!csv.unknown_columns().empty())
        result.findings.push_back(
            {Severity::info, "drive_log.unknown_column",
             fmt::format("{}: columns {} are not known and do not count; known are {}", path.filename().string(),
                         fmt::join(csv.unknown_columns(), ", "), fmt::join(column_names, ", "))});
    }
    if (raw.poses.empty()) throw InputError(path.string(), "has no pose; record times and positions");
    split(placer.place(path, raw, result.findings), std::move(raw.imu), source, result.log, result.findings);
  }
  return result;
}

std::vector<fs::path> drive_log_files(const fs::path& path) {
  if (!fs::exists(path)) throw InputError(path.string(), "no such drive log");
  if (!fs::is_directory(path)) return {path};
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(path))
    if (entry.is_regular_file()) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace orthodrive::io
