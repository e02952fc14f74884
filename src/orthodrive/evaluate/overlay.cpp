#include "orthodrive/evaluate/overlay.hpp"

#include <geos_c.h>

#include <memory>
#include <string>

#include "orthodrive/core/error.hpp"

namespace orthodrive::evaluate {
namespace {
constexpr double grid_m = 1e-3;  // OverlayNG with snap rounding never fails

void keep_message(const char* message, void* text) { *static_cast<std::string*>(text) = message; }

/// GEOS with its error message; geometries hold it.
class Geos {
 public:
  Geos() : context_(GEOS_init_r()) { GEOSContext_setErrorMessageHandler_r(context_, keep_message, &message_); }
  ~Geos() { GEOS_finish_r(context_); }
  Geos(const Geos&) = delete;
  Geos& operator=(const Geos&) = delete;

  struct Delete {
    GEOSContextHandle_t context;
    void operator()(GEOSGeometry* geometry) const { GEOSGeom_destroy_r(context, geometry); }
  };
  using Ptr = std::unique_ptr<GEOSGeometry, Delete>;

  /// The union of polygons that may overlap each other and themselves.
  [[nodiscard]] Ptr union_of(const std::vector<Polygon>& polygons, Vec2 origin) const {
    std::vector<GEOSGeometry*> parts;
    for (const Polygon& polygon : polygons)
      if (polygon.outer.size() >= 3) parts.push_back(valid_polygon(polygon, origin).release());
    const Ptr all = own(GEOSGeom_createCollection_r(context_, GEOS_GEOMETRYCOLLECTION, parts.data(),
                                                    static_cast<unsigned>(parts.size())));
    return polygonal(own(GEOSUnaryUnionPrec_r(context_, all.get(), grid_m)));
  }
  [[nodiscard]] Ptr intersection(const Ptr& a, const Ptr& b) const {
    return polygonal(own(GEOSIntersectionPrec_r(context_, a.get(), b.get(), grid_m)));
  }
  [[nodiscard]] Ptr difference(const Ptr& a, const Ptr& b) const {
    return polygonal(own(GEOSDifferencePrec_r(context_, a.get(), b.get(), grid_m)));
  }
  /// The polygons of any geometry.
  [[nodiscard]] MultiPolygon polygons_of(const Ptr& geometry, Vec2 origin) const {
    MultiPolygon all;
    append_polygons(all, geometry.get(), origin);
    return all;
  }
  [[nodiscard]] bool is_simple(const Ring& outer) const {
    const Ptr polygon = own(GEOSGeom_createPolygon_r(context_, ring(outer, outer.front()), nullptr, 0));
    return GEOSisValid_r(context_, polygon.get()) == 1;
  }
  [[nodiscard]] double area_m2(const Ptr& geometry) const {
    double area = 0.0;
    if (!GEOSArea_r(context_, geometry.get(), &area)) throw Error("polygon overlay: " + message_);
    return area;
  }

 private:
  /// Where polygons only touch, an overlay leaves lines and points; beside polygons the next overlay refuses them.
  [[nodiscard]] Ptr polygonal(Ptr geometry) const {
    const int type = GEOSGeomTypeId_r(context_, geometry.get());
    if (type == GEOS_POLYGON || type == GEOS_MULTIPOLYGON) return geometry;
    std::vector<GEOSGeometry*> parts;
    append_parts(parts, geometry.get());
    return own(
        GEOSGeom_createCollection_r(context_, GEOS_MULTIPOLYGON, parts.data(), static_cast<unsigned>(parts.size())));
  }
  void append_parts(std::vector<GEOSGeometry*>& parts, const GEOSGeometry* geometry) const {
    const int type = GEOSGeomTypeId_r(context_, geometry);
    if (type == GEOS_POLYGON) parts.push_back(own(GEOSGeom_clone_r(context_, geometry)).release());
    if (type != GEOS_MULTIPOLYGON && type != GEOS_GEOMETRYCOLLECTION) return;
    for (int i = 0; i < GEOSGetNumGeometries_r(context_, geometry); ++i)
      append_parts(parts, GEOSGetGeometryN_r(context_, geometry, i));
  }
  void append_polygons(MultiPolygon& all, const GEOSGeometry* geometry, Vec2 origin) const {
    const int type = GEOSGeomTypeId_r(context_, geometry);
    if (type == GEOS_MULTIPOLYGON || type == GEOS_GEOMETRYCOLLECTION) {
      for (int i = 0; i < GEOSGetNumGeometries_r(context_, geometry); ++i)
        append_polygons(all, GEOSGetGeometryN_r(context_, geometry, i), origin);
    } else if (type == GEOS_POLYGON && GEOSisEmpty_r(context_, geometry) == 0) {
      Polygon polygon{points_of(GEOSGetExteriorRing_r(context_, geometry), origin), {}};
      for (int i = 0; i < GEOSGetNumInteriorRings_r(context_, geometry); ++i)
        polygon.holes.push_back(points_of(GEOSGetInteriorRingN_r(context_, geometry, i), origin));
      all.push_back(std::move(polygon));
    }
  }
  [[nodiscard]] Ring points_of(const GEOSGeometry* closed, Vec2 origin) const {
    const GEOSCoordSequence* points = GEOSGeom_getCoordSeq_r(context_, closed);
    unsigned n = 0;
    GEOSCoordSeq_getSize_r(context_, points, &n);
    Ring ring;
    for (unsigned i = 0; i + 1 < n; ++i) {  // the last repeats the first
      Vec2 p;
      GEOSCoordSeq_getXY_r(context_, points, i, &p.x, &p.y);
      ring.push_back(origin + p);
    }
    return ring;
  }
  [[nodiscard]] Ptr own(GEOSGeometry* geometry) const {
    if (!geometry) throw Error("polygon overlay: " + message_);
    return Ptr(geometry, Delete{context_});
  }
  [[nodiscard]] GEOSGeometry* ring(const Ring& ring, Vec2 origin) const {
    const auto n = static_cast<unsigned>(ring.size());
    GEOSCoordSequence* points = GEOSCoordSeq_create_r(context_, n + 1, 2);
    for (unsigned i = 0; i <= n; ++i) {
      const Vec2 p = ring[i % n] - origin;  // small numbers keep the digits
      GEOSCoordSeq_setXY_r(context_, points, i, p.x, p.y);
    }
    return GEOSGeom_createLinearRing_r(context_, points);
  }
  [[nodiscard]] Ptr valid_polygon(const Polygon& polygon, Vec2 origin) const {
    std::vector<GEOSGeometry*> holes;
    for (const Ring& hole : polygon.holes)
      if (hole.size() >= 3) holes.push_back(ring(hole, origin));
    Ptr made = own(GEOSGeom_createPolygon_r(context_, ring(polygon.outer, origin), holes.data(),
                                            static_cast<unsigned>(holes.size())));
    if (GEOSisValid_r(context_, made.get()) == 1) return made;
    return polygonal(own(GEOSMakeValid_r(context_, made.get())));
  }

  std::string message_;
  GEOSContextHandle_t context_;
};
}  // namespace

namespace {
/// Both unions inside the region, relative to `origin`.
struct Unions {
  Vec2 origin;
  Geos::Ptr first, second;
};
Unions unions_in(const Geos& geos, const std::vector<Polygon>& first, const std::vector<Polygon>& second,
                 const ScoreRegion& region) {
  Vec2 origin;
  for (const auto* set : {&first, &second})
    for (const Polygon& polygon : *set)
      if (!polygon.outer.empty()) origin = polygon.outer.front();
  Unions unions{origin, geos.union_of(first, origin), geos.union_of(second, origin)};
  if (region.area) {
    const Geos::Ptr area = geos.union_of(*region.area, origin);
    unions.first = geos.intersection(unions.first, area);
    unions.second = geos.intersection(unions.second, area);
  }
  if (!region.ignore.empty()) {
    const Geos::Ptr ignore = geos.union_of(region.ignore, origin);
    unions.first = geos.difference(unions.first, ignore);
    unions.second = geos.difference(unions.second, ignore);
  }
  return unions;
}
}  // namespace

OverlapAreas overlap_areas(const std::vector<Polygon>& first, const std::vector<Polygon>& second,
                           const ScoreRegion& region) {
  const Geos geos;
  const Unions unions = unions_in(geos, first, second, region);
  return {geos.area_m2(unions.first), geos.area_m2(unions.second),
          geos.area_m2(geos.intersection(unions.first, unions.second))};
}

OverlapDifferences overlap_differences(const std::vector<Polygon>& first, const std::vector<Polygon>& second,
                                       const ScoreRegion& region) {
  const Geos geos;
  const Unions unions = unions_in(geos, first, second, region);
  return {geos.polygons_of(geos.difference(unions.first, unions.second), unions.origin),
          geos.polygons_of(geos.difference(unions.second, unions.first), unions.origin)};
}

std::vector<Polygon> carriageway_polygons(const RoadPath& path) {
  Ring strip = surface_ring(path);
  if (Geos().is_simple(strip)) return {{std::move(strip), {}}};
  std::vector<Polygon> cells;
  for (Ring& cell : surface_cells(path)) cells.push_back({std::move(cell), {}});
  return cells;
}

}  // namespace orthodrive::evaluate
