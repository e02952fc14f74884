// SPDX-License-Identifier: Apache-2.0
// Why not PROJ's own "+towgs84": a PROJ string of an EPSG code has none since PROJ 6, and the one of a bound CRS is one
// set for all of the country, metres off where PROJ itself uses a grid.
#include "orthodrive/geo/geo_reference.hpp"

#include <fmt/format.h>
#include <proj.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>

#include "orthodrive/core/error.hpp"
#include "orthodrive/geo/proj_operation.hpp"

namespace orthodrive {
namespace {

/// Of a vector in space.
double length(Vec3 a) { return std::sqrt(a.x * a.x + a.y * a.y + a.z * a.z); }

constexpr double exact_m = 0.01;  // below it two texts say the same
const Crs wgs84{"EPSG:4326"};

/// x, y, z (m), rotations (arc seconds, position vector), scale (ppm).
using Helmert = std::array<double, 7>;

using ProjObject = std::unique_ptr<PJ, decltype(&proj_destroy)>;
ProjObject owned(PJ* object) { return {object, &proj_destroy}; }

const char* const one_line[] = {"MULTILINE=NO", nullptr};

/// The horizontal part of a CRS: grids of a vertical one are not for readers of roads.
Crs plane_crs(const Crs& crs) {
  const ProjOperation proj;
  const ProjObject object = owned(proj_create(proj.context, crs.definition.c_str()));
  if (!object) throw Error("CRS '" + crs.definition + "' is unknown");
  if (proj_get_type(object.get()) != PJ_TYPE_COMPOUND_CRS) return crs;
  const ProjObject plane = owned(proj_crs_get_sub_crs(proj.context, object.get(), 0));
  const char* text = plane ? proj_as_wkt(proj.context, plane.get(), PJ_WKT2_2019, one_line) : nullptr;
  return text ? Crs{text} : crs;
}

/// The parameters that PROJ knows for the datum around a place; zeros where it knows none.
Helmert known_shift(const Crs& crs, Vec2 lonlat) {
  Helmert shift{};
  const ProjOperation proj;
  PJ_CONTEXT* context = proj.context;
  const ProjObject own = owned(proj_create(context, crs.definition.c_str()));
  const ProjObject base = owned(own ? proj_crs_get_geodetic_crs(context, own.get()) : nullptr),
                   target = owned(proj_create(context, wgs84.definition.c_str()));
  if (!base || !target) return shift;
  PJ_OPERATION_FACTORY_CONTEXT* factory = proj_create_operation_factory_context(context, nullptr);
  constexpr double around_deg = 0.01;
  proj_operation_factory_context_set_area_of_interest(context, factory, lonlat.x - around_deg, lonlat.y - around_deg,
                                                      lonlat.x + around_deg, lonlat.y + around_deg);
  proj_operation_factory_context_set_spatial_criterion(context, factory, PROJ_SPATIAL_CRITERION_PARTIAL_INTERSECTION);
  proj_operation_factory_context_set_grid_availability_use(context, factory, PROJ_GRID_AVAILABILITY_IGNORED);
  PJ_OBJ_LIST* operations = proj_create_operations(context, base.get(), target.get(), factory);
  for (int i = 0; i < (operations ? proj_list_get_count(operations) : 0); ++i) {
    const ProjObject operation = owned(proj_list_get(context, operations, i));
    if (proj_coordoperation_get_towgs84_values(context, operation.get(), shift.data(), 7, 0)) break;
    shift = {};
  }
  proj_list_destroy(operations);
  proj_operation_factory_context_destroy(factory);
  return shift;
}

/// Tenths of a millimetre, and all that is known of small angles.
std::string towgs84_of(const Helmert& shift) {
  std::string text = " +towgs84=";
  for (std::size_t i = 0; i < shift.size(); ++i)
    text += (i ? "," : "") + (i < 3 ? fmt::format("{:.4f}", shift[i]) : fmt::format("{:.8g}", shift[i]));
  return text;
}

/// How far a reader of `text` puts the middle and the corners of the box from where they are; infinite where it can
/// put them nowhere.
double reader_error_m(const std::string& text, const Crs& crs, const Box2& box) {
  const Vec2 middle{0.5 * (box.min_x + box.max_x), 0.5 * (box.min_y + box.max_y)};
  double worst_m = 0.0;
  try {
    const CoordinateTransform read({text}, wgs84), meant(crs, wgs84);
    for (const Vec2 p : {middle, Vec2{box.min_x, box.min_y}, Vec2{box.max_x, box.min_y}, Vec2{box.max_x, box.max_y},
                         Vec2{box.min_x, box.max_y}}) {
      const Vec2 a = read.target_from_source(p), b = meant.target_from_source(p);
      worst_m = std::max(worst_m, length(ecef_from_geographic(a.x, a.y, 0.0) - ecef_from_geographic(b.x, b.y, 0.0)));
    }
  } catch (const Error&) {
    return std::numeric_limits<double>::infinity();
  }
  return worst_m;
}

/// Moves the shift until a reader of plain + "+towgs84" has the point where it is.
std::string with_shift(const std::string& plain, Helmert shift, const Crs& crs, Vec2 p) {
  constexpr int most_passes = 5;  // the second is within a tenth of a millimetre
  const Vec2 meant = CoordinateTransform(crs, wgs84).target_from_source(p);
  for (int pass = 0; pass < most_passes; ++pass) {
    const Vec2 read = CoordinateTransform({plain + towgs84_of(shift)}, wgs84).target_from_source(p);
    const Vec3 off = ecef_from_geographic(meant.x, meant.y, 0.0) - ecef_from_geographic(read.x, read.y, 0.0);
    if (length(off) < 1e-3) break;
    shift[0] += off.x, shift[1] += off.y, shift[2] += off.z;
  }
  return plain + towgs84_of(shift);
}

std::string wkt_of(const Crs& crs) {
  const ProjOperation proj;
  const ProjObject object = owned(proj_create(proj.context, crs.definition.c_str()));
  for (const PJ_WKT_TYPE type : {PJ_WKT1_GDAL, PJ_WKT2_2019})
    if (const char* text = object ? proj_as_wkt(proj.context, object.get(), type, one_line) : nullptr) return text;
  throw Error("CRS '" + crs.definition + "' can be said neither by a PROJ string nor by WKT");
}

/// The PROJ string with a shift of its datum; empty where it comes too far from the place.
std::string shifted_string(const std::string& plain, const Crs& crs, const Box2& box) {
  try {
    const Vec2 middle{0.5 * (box.min_x + box.max_x), 0.5 * (box.min_y + box.max_y)};
    const Vec2 lonlat = CoordinateTransform(crs, wgs84).target_from_source(middle);
    const std::string shifted = with_shift(plain, known_shift(crs, lonlat), crs, middle);
    if (reader_error_m(shifted, crs, box) <= geo_reference_tolerance_m) return shifted;
  } catch (const Error&) {
    return {};
  }
  return {};
}

}  // namespace

std::string geo_reference(const Crs& crs, const Box2& box) {
  const Crs plane = plane_crs(crs);
  std::string plain;
  try {
    plain = proj_string(plane);
  } catch (const Error&) {
    return wkt_of(plane);
  }
  const bool reaches_box = std::isfinite(reader_error_m(plane.definition, plane, box));
  if (!reaches_box || reader_error_m(plain, plane, box) <= exact_m) return plain;
  const std::string shifted = shifted_string(plain, plane, box);
  return shifted.empty() ? wkt_of(plane) : shifted;
}

bool is_same_place(const Crs& a, const Crs& b, Vec2 p) {
  return a == b || reader_error_m(a.definition, b, {p.x, p.y, p.x, p.y}) <= geo_reference_tolerance_m;
}

}  // namespace orthodrive
