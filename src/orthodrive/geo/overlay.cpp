// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/geo/overlay.hpp"

#include <fmt/format.h>
#include <geos_c.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include "orthodrive/core/error.hpp"

namespace orthodrive {
namespace {

/// GEOS keeps its state in a context handle; each call here has its own, so that threads do not meet.
class Geos {
 public:
  Geos() : handle_(GEOS_init_r()) {
    GEOSContext_setErrorMessageHandler_r(
        handle_, [](const char* message, void* self) { static_cast<Geos*>(self)->error_ = message; }, this);
  }
  ~Geos() { GEOS_finish_r(handle_); }
  Geos(const Geos&) = delete;
  Geos& operator=(const Geos&) = delete;

  struct Deleter {
    GEOSContextHandle_t handle;
    void operator()(GEOSGeometry* g) const { GEOSGeom_destroy_r(handle, g); }
  };
  using Geometry = std::unique_ptr<GEOSGeometry, Deleter>;

  [[nodiscard]] GEOSContextHandle_t handle() const { return handle_; }
  [[nodiscard]] Geometry own(GEOSGeometry* g) const {
    if (g == nullptr) throw Error(fmt::format("polygon overlay failed in GEOS: {}", error_));
    return {g, Deleter{handle_}};
  }

  [[nodiscard]] GEOSCoordSequence* coordinates(std::span<const Vec2> points, bool close) const {
    const std::size_t n = points.size() + (close ? 1 : 0);
    GEOSCoordSequence* sequence = GEOSCoordSeq_create_r(handle_, static_cast<unsigned>(n), 2);
    for (std::size_t i = 0; i < n; ++i) {
      const Vec2 p = points[i % points.size()];
      GEOSCoordSeq_setXY_r(handle_, sequence, static_cast<unsigned>(i), p.x, p.y);
    }
    return sequence;
  }
  [[nodiscard]] GEOSGeometry* ring(const Ring& r) const {
    return GEOSGeom_createLinearRing_r(handle_, coordinates(r, true));
  }
  [[nodiscard]] Geometry polygon(const Polygon& p) const {
    std::vector<GEOSGeometry*> holes;
    for (const Ring& hole : p.holes)
      if (hole.size() >= 3) holes.push_back(ring(hole));
    return own(GEOSGeom_createPolygon_r(handle_, ring(p.outer), holes.data(), static_cast<unsigned>(holes.size())));
  }
  [[nodiscard]] Geometry lines(std::span<const Polyline> lines) const {
    std::vector<GEOSGeometry*> parts;
    parts.reserve(lines.size());
    for (const Polyline& line : lines) parts.push_back(GEOSGeom_createLineString_r(handle_, coordinates(line, false)));
    return own(
        GEOSGeom_createCollection_r(handle_, GEOS_MULTILINESTRING, parts.data(), static_cast<unsigned>(parts.size())));
  }
  [[nodiscard]] bool is_valid(const Geometry& g) const { return GEOSisValid_r(handle_, g.get()) == 1; }
  /// Of polygons alone: beside them, an overlay refuses the lines and points that make-valid may leave.
  [[nodiscard]] Geometry collect(std::span<const Polygon> polygons) const {
    std::vector<GEOSGeometry*> parts;
    for (const Polygon& p : polygons) {
      if (p.outer.size() < 3) continue;
      Geometry made = polygon(p);
      if (is_valid(made)) {
        parts.push_back(made.release());
        continue;
      }
      made = own(GEOSMakeValid_r(handle_, made.get()));
      for_each_part(made.get(), GEOS_POLYGON,
                    [&](const GEOSGeometry* part) { parts.push_back(own(GEOSGeom_clone_r(handle_, part)).release()); });
    }
    return own(
        GEOSGeom_createCollection_r(handle_, GEOS_MULTIPOLYGON, parts.data(), static_cast<unsigned>(parts.size())));
  }

  template <typename Visit>
  void for_each_part(const GEOSGeometry* g, int type, const Visit& visit) const {
    if (GEOSGeomTypeId_r(handle_, g) == type) {
      if (GEOSisEmpty_r(handle_, g) == 0) visit(g);
      return;
    }
    if (GEOSGeomTypeId_r(handle_, g) < GEOS_MULTIPOINT) return;  // a leftover of lower dimension
    for (int i = 0; i < GEOSGetNumGeometries_r(handle_, g); ++i)
      for_each_part(GEOSGetGeometryN_r(handle_, g, i), type, visit);
  }
  [[nodiscard]] Polyline points(const GEOSGeometry* line) const {
    const GEOSCoordSequence* sequence = GEOSGeom_getCoordSeq_r(handle_, line);
    unsigned n = 0;
    GEOSCoordSeq_getSize_r(handle_, sequence, &n);
    Polyline result(n);
    for (unsigned i = 0; i < n; ++i) GEOSCoordSeq_getXY_r(handle_, sequence, i, &result[i].x, &result[i].y);
    return result;
  }
  [[nodiscard]] MultiPolygon polygons(const GEOSGeometry* g) const {
    const auto oriented = [&](const GEOSGeometry* line, bool counter_clockwise) {
      Ring r = points(line);
      r.pop_back();
      if ((signed_area_m2(r) > 0.0) != counter_clockwise) std::reverse(r.begin(), r.end());
      return r;
    };
    MultiPolygon result;
    for_each_part(g, GEOS_POLYGON, [&](const GEOSGeometry* part) {
      Polygon& polygon = result.emplace_back();
      polygon.outer = oriented(GEOSGetExteriorRing_r(handle_, part), true);
      for (int h = 0; h < GEOSGetNumInteriorRings_r(handle_, part); ++h)
        polygon.holes.push_back(oriented(GEOSGetInteriorRingN_r(handle_, part, h), false));
    });
    return result;
  }

 private:
  GEOSContextHandle_t handle_;
  std::string error_ = "no reason given";
};

bool is_on_grid(const MultiPolygon& polygons, double grid_m) {
  const auto on_grid = [&](Vec2 p) {
    const auto is_whole = [](double steps) { return std::abs(steps - std::round(steps)) < 1e-6; };
    return is_whole(p.x / grid_m) && is_whole(p.y / grid_m);
  };
  return std::ranges::all_of(polygons, [&](const Polygon& polygon) {
    return std::ranges::all_of(polygon.outer, on_grid) &&
           std::ranges::all_of(polygon.holes, [&](const Ring& hole) { return std::ranges::all_of(hole, on_grid); });
  });
}

}  // namespace

MultiPolygon union_of(std::span<const Polygon> polygons, double grid_m) {
  const Geos geos;
  const auto all = geos.collect(polygons);
  MultiPolygon joined = geos.polygons(geos.own(GEOSUnaryUnionPrec_r(geos.handle(), all.get(), grid_m)).get());
  if (is_on_grid(joined, grid_m)) return joined;
  // GEOS gives a polygon that meets no other back as it came.
  const auto again = geos.collect(joined);
  return geos.polygons(geos.own(GEOSGeom_setPrecision_r(geos.handle(), again.get(), grid_m, 0)).get());
}

MultiPolygon intersection_of(const MultiPolygon& a, const MultiPolygon& b, double grid_m) {
  const Geos geos;
  const auto ga = geos.collect(a), gb = geos.collect(b);
  return geos.polygons(geos.own(GEOSIntersectionPrec_r(geos.handle(), ga.get(), gb.get(), grid_m)).get());
}

MultiPolygon difference_of(const MultiPolygon& a, const MultiPolygon& b, double grid_m) {
  const Geos geos;
  const auto ga = geos.collect(a), gb = geos.collect(b);
  return geos.polygons(geos.own(GEOSDifferencePrec_r(geos.handle(), ga.get(), gb.get(), grid_m)).get());
}

MultiPolygon buffer_of(const MultiPolygon& polygons, double distance_m, int arc_steps) {
  const Geos geos;
  const auto all = geos.collect(polygons);
  // What grows may overlap: GEOS joins it on the way.
  const bool is_one = distance_m > 0.0 || GEOSGetNumGeometries_r(geos.handle(), all.get()) == 1;
  const auto joined =
      geos.own(is_one ? GEOSGeom_clone_r(geos.handle(), all.get()) : GEOSUnaryUnion_r(geos.handle(), all.get()));
  if (distance_m == 0.0) return geos.polygons(joined.get());
  return geos.polygons(geos.own(GEOSBuffer_r(geos.handle(), joined.get(), distance_m, arc_steps)).get());
}

MultiPolygon buffer_of_lines(std::span<const Polyline> lines, double distance_m) {
  constexpr double mitre_limit = 1.5;  // over the distance: 1.41 at a right angle
  constexpr int arc_steps = 2;         // not used: corners are mitres
  const Geos geos;
  const auto all = geos.lines(lines);
  return geos.polygons(geos.own(GEOSBufferWithStyle_r(geos.handle(), all.get(), distance_m, arc_steps, GEOSBUF_CAP_FLAT,
                                                      GEOSBUF_JOIN_MITRE, mitre_limit))
                           .get());
}

MultiPolygon simplified(const MultiPolygon& polygons, double tolerance_m) {
  const Geos geos;
  const auto all = geos.collect(polygons);
  return geos.polygons(geos.own(GEOSTopologyPreserveSimplify_r(geos.handle(), all.get(), tolerance_m)).get());
}

std::vector<LineSegment> node_lines(std::span<const Polyline> lines, double grid_m) {
  const Geos geos;
  const auto all = geos.lines(lines);
  const auto noded = geos.own(GEOSUnaryUnionPrec_r(geos.handle(), all.get(), grid_m));
  std::vector<LineSegment> segments;
  geos.for_each_part(noded.get(), GEOS_LINESTRING, [&](const GEOSGeometry* part) {
    const Polyline line = geos.points(part);
    for (std::size_t i = 1; i < line.size(); ++i) segments.push_back({line[i - 1], line[i]});
  });
  return segments;
}

bool is_simple(const Ring& ring) {
  if (ring.size() < 3) return false;
  const Geos geos;
  return geos.is_valid(geos.polygon({ring, {}}));
}

}  // namespace orthodrive
