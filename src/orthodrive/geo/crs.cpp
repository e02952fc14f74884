// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/geo/crs.hpp"

#include <fmt/format.h>
#include <proj.h>

#include <cmath>
#include <numbers>

#include "orthodrive/core/error.hpp"
#include "orthodrive/geo/proj_operation.hpp"

namespace orthodrive {

Crs utm_crs(double longitude_deg, double latitude_deg) {
  const int zone = std::min(60, static_cast<int>(std::floor((longitude_deg + 180.0) / 6.0)) + 1);
  return {fmt::format("EPSG:{}", (latitude_deg >= 0.0 ? 32600 : 32700) + zone)};
}

std::string proj_string(const Crs& crs) {
  ProjOperation proj;
  proj.operation = proj_create(proj.context, crs.definition.c_str());
  const char* text = proj.operation ? proj_as_proj_string(proj.context, proj.operation, PJ_PROJ_4, nullptr) : nullptr;
  std::string result = text ? text : "";
  // Without what says nothing: "+type=crs" is PROJ's own, and esmini takes every word for a key with a value.
  for (const std::string word : {" +type=crs", " +no_defs"})
    if (const auto at = result.find(word); at != std::string::npos) result.erase(at, word.size());
  if (result.empty()) throw Error("CRS '" + crs.definition + "' is unknown or has no PROJ string");
  return result;
}

CoordinateTransform::CoordinateTransform(const Crs& source, const Crs& target)
    : proj_(std::make_unique<ProjOperation>()) {
  PJ* raw = proj_create_crs_to_crs(proj_->context, source.definition.c_str(), target.definition.c_str(), nullptr);
  if (!raw) throw Error("no transformation from CRS '" + source.definition + "' to '" + target.definition + "'");
  proj_->operation = proj_normalize_for_visualization(proj_->context, raw);
  proj_destroy(raw);
  if (!proj_->operation)
    throw Error("no transformation from CRS '" + source.definition + "' to '" + target.definition + "'");
}
CoordinateTransform::~CoordinateTransform() = default;
CoordinateTransform::CoordinateTransform(CoordinateTransform&&) noexcept = default;
CoordinateTransform& CoordinateTransform::operator=(CoordinateTransform&&) noexcept = default;

namespace {
Vec2 run(PJ* transform, PJ_DIRECTION direction, Vec2 p) {
  const PJ_COORD result = proj_trans(transform, direction, proj_coord(p.x, p.y, 0.0, HUGE_VAL));
  if (!std::isfinite(result.xy.x) || !std::isfinite(result.xy.y))
    throw Error(fmt::format("point ({}, {}) cannot be transformed to the other CRS", p.x, p.y));
  return {result.xy.x, result.xy.y};
}
}  // namespace

Vec2 CoordinateTransform::target_from_source(Vec2 p) const { return run(proj_->operation, PJ_FWD, p); }
Vec2 CoordinateTransform::source_from_target(Vec2 p) const { return run(proj_->operation, PJ_INV, p); }

Vec3 ecef_from_geographic(double longitude_deg, double latitude_deg, double height_m) {
  constexpr double a = 6378137.0, f = 1.0 / 298.257223563, e2 = f * (2.0 - f);  // WGS84
  const double lon = longitude_deg * std::numbers::pi / 180.0, lat = latitude_deg * std::numbers::pi / 180.0;
  const double n = a / std::sqrt(1.0 - e2 * std::sin(lat) * std::sin(lat));
  return {(n + height_m) * std::cos(lat) * std::cos(lon), (n + height_m) * std::cos(lat) * std::sin(lon),
          (n * (1.0 - e2) + height_m) * std::sin(lat)};
}

Vec3 geographic_from_ecef(const Vec3& p) {
  constexpr double a = 6378137.0, f = 1.0 / 298.257223563, e2 = f * (2.0 - f), b = a * (1.0 - f);  // WGS84
  const double r = std::hypot(p.x, p.y);
  double beta = std::atan2(p.z, (1.0 - f) * r), lat = 0.0;  // the reduced latitude
  for (int pass = 0; pass < 3; ++pass) {
    lat = std::atan2(p.z + e2 / (1.0 - e2) * b * std::pow(std::sin(beta), 3), r - e2 * a * std::pow(std::cos(beta), 3));
    beta = std::atan2((1.0 - f) * std::sin(lat), std::cos(lat));
  }
  const double n = a / std::sqrt(1.0 - e2 * std::sin(lat) * std::sin(lat));
  // Along the normal: good at the poles as well, where r / cos(lat) is not.
  const double height = r * std::cos(lat) + p.z * std::sin(lat) - a * a / n;
  constexpr double deg = 180.0 / std::numbers::pi;
  return {std::atan2(p.y, p.x) * deg, lat * deg, height};
}

}  // namespace orthodrive
