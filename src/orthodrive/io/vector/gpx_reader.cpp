// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/vector/gpx_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <optional>
#include <pugixml.hpp>
#include <string_view>

#include "orthodrive/core/error.hpp"
#include "orthodrive/io/support/gdal_support.hpp"

namespace orthodrive::io {
namespace fs = std::filesystem;

namespace {

constexpr double trace_gap_m = 60.0, trace_gap_s = 30.0;  // between them the way is not known
constexpr double trace_margin_m = 200.0;                  // so far outside the area a trace may still help its border

struct Fix {
  Vec2 lonlat;
  std::optional<double> time_s;
};
using Recording = std::vector<Fix>;

/// Writers differ in the prefix of the namespace: only the name counts.
std::string_view local_name(const pugi::xml_node& node) {
  const std::string_view name = node.name();
  const auto colon = name.find(':');
  return colon == std::string_view::npos ? name : name.substr(colon + 1);
}

std::optional<double> number(const pugi::xml_attribute& attribute) {
  std::string_view text = attribute.value();
  while (!text.empty() && (text.front() == ' ' || text.front() == '+')) text.remove_prefix(1);
  double value = 0.0;
  if (std::from_chars(text.data(), text.data() + text.size(), value).ec != std::errc{} || !std::isfinite(value))
    return std::nullopt;
  return value;
}

/// Seconds of xsd:dateTime, e.g. 2016-05-01T12:00:00.5Z. The zone is ignored: only differences within a recording
/// count.
std::optional<double> seconds_of(const char* text) {
  int year = 0, month = 0, day = 0, hour = 0, minute = 0;
  double second = 0.0;
  // NOLINTNEXTLINE(bugprone-unchecked-string-to-number-conversion): what is too large makes no date that is ok().
  if (std::sscanf(text, "%d-%d-%dT%d:%d:%lf", &year, &month, &day, &hour, &minute, &second) != 6) return std::nullopt;
  const std::chrono::year_month_day date{std::chrono::year{year}, std::chrono::month{static_cast<unsigned>(month)},
                                         std::chrono::day{static_cast<unsigned>(day)}};
  if (!date.ok()) return std::nullopt;
  const auto days = std::chrono::sys_days{date}.time_since_epoch().count();
  return (static_cast<double>(days) * 24.0 + hour) * 3600.0 + minute * 60.0 + second;
}

std::optional<Fix> fix_of(const pugi::xml_node& point) {
  const auto lon = number(point.attribute("lon")), lat = number(point.attribute("lat"));
  if (!lon || !lat || std::abs(*lon) > 180.0 || std::abs(*lat) > 90.0 || (*lon == 0.0 && *lat == 0.0))
    return std::nullopt;
  Fix fix{{*lon, *lat}, std::nullopt};
  for (const pugi::xml_node& child : point.children()) {
    if (local_name(child) == "fix" && std::strcmp(child.child_value(), "none") == 0) return std::nullopt;
    if (local_name(child) == "time") fix.time_s = seconds_of(child.child_value());
  }
  return fix;
}

std::ptrdiff_t line_number(const fs::path& file, std::ptrdiff_t offset) {
  std::FILE* in = std::fopen(file.c_str(), "rb");
  if (!in) return 1;
  std::ptrdiff_t line = 1;
  for (int c = 0; offset > 0 && (c = std::fgetc(in)) != EOF; --offset) line += c == '\n';
  std::fclose(in);
  return line;
}

std::vector<Recording> read_recordings(const fs::path& file) {
  if (!fs::exists(file)) throw InputError(file.string(), "no such file");
  pugi::xml_document document;
  const pugi::xml_parse_result parsed = document.load_file(file.c_str());
  if (!parsed)
    throw InputError(file.string(), fmt::format("line {}: no GPX, or cut off ({}); get the file again",
                                                line_number(file, parsed.offset), parsed.description()));
  const pugi::xml_node root = document.document_element();
  if (local_name(root) != "gpx")
    throw InputError(file.string(), fmt::format("is <{}>, need <gpx>; convert it to GPX", root.name()));
  std::vector<Recording> recordings;
  std::size_t points = 0, fixes = 0;
  for (const pugi::xml_node& track : root.children()) {
    if (local_name(track) != "trk") continue;
    for (const pugi::xml_node& segment : track.children()) {
      if (local_name(segment) != "trkseg") continue;
      Recording& recording = recordings.emplace_back();
      for (const pugi::xml_node& point : segment.children()) {
        if (local_name(point) != "trkpt") continue;
        ++points;
        if (const auto fix = fix_of(point)) recording.push_back(*fix);
      }
      fixes += recording.size();
    }
  }
  if (points == 0)
    throw InputError(file.string(), "has no track points (trk/trkseg/trkpt); routes and waypoints were not driven");
  if (fixes == 0)
    throw InputError(file.string(),
                     fmt::format("none of its {} track points has a fix (longitude and latitude)", points));
  return recordings;
}

/// The parts of a recording without gaps and inside the box.
void add_traces(const Recording& recording, std::size_t number, const Box2& near_lonlat,
                const CoordinateTransform& site_from_lonlat, std::vector<GpsTrace>& traces) {
  Polyline line;
  const auto finish = [&] {
    if (line.size() > 1) traces.push_back({std::move(line), number});
    line = {};
  };
  const Fix* before = nullptr;
  for (const Fix& fix : recording) {
    if (!near_lonlat.contains(fix.lonlat)) {  // far ones may not even have a place in the CRS
      finish();
      continue;
    }
    const Vec2 p = site_from_lonlat.target_from_source(fix.lonlat);
    const bool late = before && before->time_s && fix.time_s && std::abs(*fix.time_s - *before->time_s) > trace_gap_s;
    if (!line.empty() && (late || distance(line.back(), p) > trace_gap_m)) finish();
    if (line.empty() || !(line.back() == p)) line.push_back(p);
    before = &fix;
  }
  finish();
}

Finding outside_area(const fs::path& file, std::size_t outside, std::size_t all, const Box2& box, const Box2& area,
                     const SiteFrame& site) {
  // The place of a finding must have coordinates in the site CRS, which far ones may lack: the area's middle.
  const Box2 middle = bounds_of(site.area.outer);
  return {Severity::warning, "gpx.outside_area",
          fmt::format("{}: {} of {} recordings have no point near the area ({}; the area is {})",
                      file.filename().string(), outside, all, describe_lonlat(box), describe_lonlat(area)),
          0.5 * (middle.min_x + middle.max_x), 0.5 * (middle.min_y + middle.max_y)};
}

}  // namespace

GpxTraces read_gpx(const std::vector<fs::path>& files, const SiteFrame& site) {
  GpxTraces result{.traces = {.crs = site.crs}};
  if (files.empty()) return result;
  const CoordinateTransform site_from_lonlat(Crs{"EPSG:4326"}, site.crs);
  const Box2 area = lonlat_bounds(site.area.outer, site.crs);
  const double degree_m = 111'000.0;
  const double margin_lat = trace_margin_m / degree_m,
               margin_lon = margin_lat / std::max(0.01, std::cos(0.5 * (area.min_y + area.max_y) * M_PI / 180.0));
  const Box2 near{area.min_x - margin_lon, area.min_y - margin_lat, area.max_x + margin_lon, area.max_y + margin_lat};
  std::size_t number = 0;
  for (const fs::path& file : files) {
    const std::vector<Recording> recordings = read_recordings(file);
    std::size_t outside = 0;
    Ring far;
    for (const Recording& recording : recordings) {
      if (!recording.empty() &&
          std::ranges::none_of(recording, [&](const Fix& fix) { return near.contains(fix.lonlat); })) {
        ++outside;
        for (const Fix& fix : recording) far.push_back(fix.lonlat);
      }
      add_traces(recording, number++, near, site_from_lonlat, result.traces.traces);
    }
    if (outside > 0)
      result.findings.push_back(outside_area(file, outside, recordings.size(), bounds_of(far), area, site));
  }
  return result;
}

}  // namespace orthodrive::io
