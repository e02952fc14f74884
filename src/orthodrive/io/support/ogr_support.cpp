// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/support/ogr_support.hpp"

#include <fmt/format.h>

#include "orthodrive/core/atomic_file.hpp"
#include "orthodrive/core/error.hpp"

namespace orthodrive::io {
namespace {
Polyline from_ogr(const OGRSimpleCurve& curve) {
  Polyline line;
  line.reserve(static_cast<std::size_t>(curve.getNumPoints()));
  for (int i = 0; i < curve.getNumPoints(); ++i) line.push_back({curve.getX(i), curve.getY(i)});
  return line;
}

Ring ring_from_ogr(const OGRLinearRing& closed) {
  Ring ring = from_ogr(closed);
  if (ring.size() > 1 && ring.front() == ring.back()) ring.pop_back();
  return ring;
}

OGRLinearRing ring_to_ogr(const Ring& ring) {
  OGRLinearRing closed;
  for (const Vec2 p : ring) closed.addPoint(p.x, p.y);
  closed.closeRings();
  return closed;
}
}  // namespace

std::unique_ptr<OGRLineString> to_ogr(const Polyline& line) {
  auto result = std::make_unique<OGRLineString>();
  for (const Vec2 p : line) result->addPoint(p.x, p.y);
  return result;
}

std::unique_ptr<OGRPolygon> to_ogr(const Polygon& polygon) {
  auto result = std::make_unique<OGRPolygon>();
  OGRLinearRing outer = ring_to_ogr(polygon.outer);
  result->addRing(&outer);
  for (const Ring& hole : polygon.holes) {
    OGRLinearRing inner = ring_to_ogr(hole);
    result->addRing(&inner);
  }
  return result;
}

void append_geometry(Feature& feature, const OGRGeometry& geometry) {
  if (geometry.hasCurveGeometry()) {
    const std::unique_ptr<OGRGeometry> linear(geometry.getLinearGeometry());
    append_geometry(feature, *linear);
    return;
  }
  switch (wkbFlatten(geometry.getGeometryType())) {
    case wkbPoint: {
      const OGRPoint* point = geometry.toPoint();
      if (!point->IsEmpty()) feature.points.push_back({point->getX(), point->getY()});
      break;
    }
    case wkbLineString:
      feature.lines.push_back(from_ogr(*geometry.toLineString()));
      break;
    case wkbTriangle:
    case wkbPolygon: {
      const OGRPolygon* polygon = geometry.toPolygon();
      if (polygon->IsEmpty()) break;
      Polygon result{ring_from_ogr(*polygon->getExteriorRing()), {}};
      for (int i = 0; i < polygon->getNumInteriorRings(); ++i)
        result.holes.push_back(ring_from_ogr(*polygon->getInteriorRing(i)));
      feature.polygons.push_back(std::move(result));
      break;
    }
    default:
      if (OGR_GT_IsSubClassOf(geometry.getGeometryType(), wkbGeometryCollection))
        for (const OGRGeometry* part : *geometry.toGeometryCollection()) append_geometry(feature, *part);
  }
}

void create_field(OGRLayer& layer, const char* name, OGRFieldType type) {
  OGRFieldDefn field(name, type);
  if (layer.CreateField(&field) != OGRERR_NONE) throw Error(fmt::format("field '{}' cannot be made", name));
}

void add_feature(OGRLayer& layer, OGRFeature& feature, const std::string& file, const GdalErrors& errors) {
  if (layer.CreateFeature(&feature) != OGRERR_NONE || errors.any())
    throw Error(
        fmt::format("{}: cannot be written ({}); is the disk full or the folder read-only?", file, errors.text()));
}

void write_geopackage(const std::filesystem::path& path,
                      const std::function<void(GDALDataset& dataset, const GdalErrors& errors)>& fill) {
  AtomicFile out(path);
  struct RemoveLeftovers {
    std::filesystem::path unfinished;
    ~RemoveLeftovers() { remove_leftovers(unfinished); }
  } const leftovers{out.path()};
  const ScopedGdalOption no_fsync("OGR_SQLITE_SYNCHRONOUS", "OFF");  // the file is renamed into place when it is whole
  GdalErrors errors;
  const auto fail = [&] {
    throw Error(fmt::format("{}: cannot be written ({}); is the disk full or the folder read-only?", path.string(),
                            errors.text()));
  };
  GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("GPKG");
  DatasetPtr dataset(driver->Create(out.path().c_str(), 0, 0, 0, GDT_Unknown, nullptr));
  if (!dataset) fail();
  if (dataset->StartTransaction() != OGRERR_NONE) fail();
  fill(*dataset, errors);
  if (dataset->CommitTransaction() != OGRERR_NONE) fail();
  dataset.reset();  // writes the spatial index and the extents, and may fail now
  if (errors.any()) fail();
  out.commit();
}

}  // namespace orthodrive::io
