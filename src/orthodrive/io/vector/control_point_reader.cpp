// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/vector/control_point_reader.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <optional>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/printable.hpp"
#include "orthodrive/io/support/vector_io.hpp"

namespace orthodrive::io {
namespace {
namespace fs = std::filesystem;

constexpr double outside_m = 20.0;  // roads at the edge of the area are as wide

struct Range {
  double least, most;
  const char* unit;
  bool whole = false;
};
constexpr Range heights{-1500.0, 30000.0, " m"}, clearances{0.1, 500.0, " m"}, sigmas{0.001, 100.0, " m"},
    layers{-20.0, 20.0, "", true}, ids{1.0, 9e15, "", true};  // whole numbers up to 2^53 are exact

/// One feature of a file, for its messages.
class Row {
 public:
  Row(const fs::path& file, std::size_t number, const Feature& feature)
      : file_(file), number_(number), feature_(feature) {}

  [[noreturn]] void fail(const std::string& what) const {
    throw InputError(file_.string(), fmt::format("feature {}: {}", number_, what));
  }
  /// None: no such field, or an empty one.
  [[nodiscard]] std::optional<double> number(const char* field, const Range& range) const {
    const auto at = feature_.tags.find(field);
    if (at == feature_.tags.end() || at->second.empty()) return {};
    const std::string& text = at->second;
    double value = 0.0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    const bool is_number = error == std::errc{} && end == text.data() + text.size() && std::isfinite(value);
    if (!is_number || value < range.least || value > range.most || (range.whole && value != std::floor(value)))
      fail(fmt::format("'{}' is '{}', need a {}number from {:.15g} to {:.15g}{}", field, printable(text),
                       range.whole ? "whole " : "", range.least, range.most, range.unit));
    return value;
  }

 private:
  const fs::path& file_;
  std::size_t number_;
  const Feature& feature_;
};

HeightControlPoint point_of(const Row& row, const Feature& feature) {
  if (feature.points.size() != 1 || !feature.lines.empty() || !feature.polygons.empty())
    row.fail("is no single point; a height control point is a point with 'z_m' or 'clearance_m'");
  HeightControlPoint point{.p = feature.points.front()};
  const auto z_m = row.number("z_m", heights), clearance_m = row.number("clearance_m", clearances);
  if (!z_m && !clearance_m)
    row.fail("has neither 'z_m' (height of the road, m) nor 'clearance_m' (of a deck over the road below, m)");
  point.z_m = z_m.value_or(point.z_m);
  point.clearance_m = clearance_m.value_or(point.clearance_m);
  point.sigma_m = row.number("sigma_m", sigmas).value_or(point.sigma_m);
  if (const auto id = row.number("osm_id", ids)) point.osm_id = static_cast<std::int64_t>(*id);
  if (const auto layer = row.number("layer", layers)) point.layer = static_cast<int>(*layer);
  return point;
}

bool is_outside(const Polygon& area, Vec2 p) {
  if (contains(area, p)) return false;
  Polyline outline = area.outer;
  if (outline.size() < 3) return true;
  outline.push_back(outline.front());
  return project_onto(outline, p).distance_m > outside_m;
}

}  // namespace

ControlPoints read_control_points(const std::vector<fs::path>& files, const SiteFrame& site) {
  ControlPoints result;
  for (const fs::path& file : files) {
    const std::vector<Feature> features = read_features(file, site.crs);
    if (features.empty()) throw InputError(file.string(), "has no point; need points with 'z_m' or 'clearance_m'");
    for (std::size_t i = 0; i < features.size(); ++i) {
      const HeightControlPoint point = point_of(Row(file, i + 1, features[i]), features[i]);
      if (!is_outside(site.area, point.p))
        result.points.push_back(point);
      else
        result.findings.push_back(
            {Severity::warning, "control_points.outside_area",
             fmt::format("{}: feature {} lies outside the area and is left out", file.filename().string(), i + 1),
             point.p.x, point.p.y});
    }
  }
  return result;
}

}  // namespace orthodrive::io
