// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/synth/plan/track_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/median.hpp"
#include "orthodrive/geo/crs.hpp"

namespace orthodrive::synth {
namespace {
std::string_view trimmed(std::string_view text) {
  constexpr std::string_view blank = " \t\r#";
  const std::size_t first = text.find_first_not_of(blank);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

std::vector<std::string_view> split(std::string_view line) {
  std::vector<std::string_view> cells;
  for (std::size_t begin = 0;;) {
    const std::size_t comma = line.find(',', begin);
    cells.push_back(trimmed(line.substr(begin, comma == std::string_view::npos ? comma : comma - begin)));
    if (comma == std::string_view::npos) return cells;
    begin = comma + 1;
  }
}

struct TextRow {
  int line = 0;
  std::vector<double> values;  ///< in the order of the wanted columns
};

std::vector<TextRow> read_columns(std::string_view text, const std::string& file,
                                  const std::vector<std::string>& wanted) {
  std::vector<std::size_t> column;
  std::vector<TextRow> rows;
  int number = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::string_view line = text.substr(begin, end - begin);
    begin = end + 1, ++number;
    if (trimmed(line).empty() || (!column.empty() && line.front() == '#')) continue;
    const std::vector<std::string_view> cells = split(line);
    if (column.empty()) {
      for (const std::string& name : wanted) {
        const auto it = std::find(cells.begin(), cells.end(), name);
        if (it == cells.end())
          throw InputError(file,
                           fmt::format("no column '{}' in the first line, need {}", name, fmt::join(wanted, ", ")));
        column.push_back(static_cast<std::size_t>(it - cells.begin()));
      }
      continue;
    }
    TextRow row{number, {}};
    for (std::size_t i = 0; i < column.size(); ++i) {
      const std::string_view cell = column[i] < cells.size() ? cells[column[i]] : std::string_view{};
      double value = 0.0;
      const auto result = std::from_chars(cell.data(), cell.data() + cell.size(), value);
      if (result.ec != std::errc{} || result.ptr != cell.data() + cell.size() || !std::isfinite(value))
        throw InputError(file, fmt::format("line {}: {} is '{}', need a number", number, wanted[i], cell));
      row.values.push_back(value);
    }
    rows.push_back(std::move(row));
  }
  if (column.empty()) throw InputError(file, "is empty; need a line with the names of the columns, then rows");
  return rows;
}
}  // namespace

std::vector<TrackRow> parse_track(std::string_view text, const std::string& file) {
  const std::vector<TextRow> rows = read_columns(text, file, {"utm33_e", "utm33_n", "w_tr_right_m", "w_tr_left_m"});
  std::vector<TrackRow> track;
  for (const TextRow& row : rows) {
    const TrackRow t{{row.values[0], row.values[1]}, row.values[2], row.values[3]};
    if (!(t.right_m > 0.0 && t.left_m > 0.0))
      throw InputError(file, fmt::format("line {}: widths are {} m to the right and {} m to the left, need more than 0",
                                         row.line, t.right_m, t.left_m));
    if (!(t.p.x > 0.0 && t.p.x < 1e6 && t.p.y > 0.0 && t.p.y < 1e7))
      throw InputError(file, fmt::format("line {}: {}, {} is no place in UTM 33N", row.line, t.p.x, t.p.y));
    if (!track.empty() && distance(track.back().p, t.p) < 0.01)
      throw InputError(file, fmt::format("line {}: the place of the line before again", row.line));
    track.push_back(t);
  }
  if (track.size() > 1 && distance(track.front().p, track.back().p) < 0.01) track.pop_back();
  if (track.size() < 10) throw InputError(file, fmt::format("has {} rows, need at least 10", track.size()));
  std::vector<double> step_m;
  for (std::size_t i = 1; i < track.size(); ++i) step_m.push_back(distance(track[i - 1].p, track[i].p));
  const double gap_m = distance(track.front().p, track.back().p), usual_m = median(std::move(step_m));
  if (gap_m > 3.0 * usual_m)
    throw InputError(
        file,
        fmt::format("is not closed: {:.1f} m from the last row to the first, rows are {:.1f} m apart", gap_m, usual_m));
  return track;
}

std::vector<Vec3> parse_heights(std::string_view text, const std::string& file) {
  const CoordinateTransform utm_from_geographic({"EPSG:4326"}, {"EPSG:32633"});
  std::vector<Vec3> heights;
  for (const TextRow& row : read_columns(text, file, {"lon", "lat", "elev_m"})) {
    const Vec2 geographic{row.values[0], row.values[1]};
    if (std::abs(geographic.x) > 180.0 || std::abs(geographic.y) > 85.0)
      throw InputError(
          file, fmt::format("line {}: {}, {} is no longitude and latitude", row.line, geographic.x, geographic.y));
    const Vec2 p = utm_from_geographic.target_from_source(geographic);
    heights.push_back({p.x, p.y, row.values[2]});
  }
  if (heights.size() < 3) throw InputError(file, fmt::format("has {} heights, need at least 3", heights.size()));
  return heights;
}

}  // namespace orthodrive::synth
