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
    return own(GEOSUnaryUnionPrec_r(context_, all.get(), grid_m));
  }
  [[nodiscard]] Ptr intersection(const Ptr& a, const Ptr& b) const {
    return own(GEOSIntersectionPrec_r(context_, a.get(), b.get(), grid_m));
  }
  [[nodiscard]] Ptr difference(const Ptr& a, const Ptr& b) const {
    return own(GEOSDifferencePrec_r(context_, a.get(), b.get(), grid_m));
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
    return own(GEOSMakeValid_r(context_, made.get()));
  }

  std::string message_;
  GEOSContextHandle_t context_;
};
}  // namespace

OverlapAreas overlap_areas(const std::vector<Polygon>& first, const std::vector<Polygon>& second,
                           const ScoreRegion& region) {
  Vec2 origin;
  for (const auto* set : {&first, &second})
    for (const Polygon& polygon : *set)
      if (!polygon.outer.empty()) origin = polygon.outer.front();
  const Geos geos;
  Geos::Ptr a = geos.union_of(first, origin), b = geos.union_of(second, origin);
  if (region.area) {
    const Geos::Ptr area = geos.union_of(*region.area, origin);
    a = geos.intersection(a, area);
    b = geos.intersection(b, area);
  }
  if (!region.ignore.empty()) {
    const Geos::Ptr ignore = geos.union_of(region.ignore, origin);
    a = geos.difference(a, ignore);
    b = geos.difference(b, ignore);
  }
  return {geos.area_m2(a), geos.area_m2(b), geos.area_m2(geos.intersection(a, b))};
}

std::vector<Polygon> carriageway_polygons(const RoadPath& path) {
  Ring strip = surface_ring(path);
  if (Geos().is_simple(strip)) return {{std::move(strip), {}}};
  std::vector<Polygon> cells;
  for (Ring& cell : surface_cells(path)) cells.push_back({std::move(cell), {}});
  return cells;
}

}  // namespace orthodrive::evaluate
