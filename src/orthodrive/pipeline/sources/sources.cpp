// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/pipeline/sources/sources.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "orthodrive/core/error.hpp"
#include "orthodrive/io/models/weights_io.hpp"
#include "orthodrive/io/raster/raster_io.hpp"
#include "orthodrive/io/support/vector_io.hpp"
#include "orthodrive/roads/cut_corners.hpp"
#include "orthodrive/roads/dead_one_ways.hpp"
#include "orthodrive/roads/drawn_twice.hpp"
#include "orthodrive/roads/join_places.hpp"

namespace orthodrive {
namespace fs = std::filesystem;

namespace {
OsmRoads read_all_osm(const Sources::Files& files, const SiteFrame& site) {
  OsmRoads all;
  if (files.empty()) return all;
  all.roads = io::read_osm_roads(files, site, &all.findings);
  join_places(all.roads, all.findings);
  draw_once(all.roads, all.findings);
  report_dead_one_ways(all.roads, all.findings);
  cut_at_corners(all.roads);
  return all;
}

template <typename T, typename Read>
const T& kept(std::optional<T>& value, const Read& read) {
  if (!value) value = read();
  return *value;
}
}  // namespace

Terrain read_terrain(const Sources::Files& files, const SiteFrame& site) {
  Terrain terrain;
  terrain.dtms = io::read_dtms(files, site, {.least_coverage = io::least_site_coverage}, &terrain.findings);
  return terrain;
}

const OsmRoads& Sources::osm(const Files& files, const SiteFrame& site) {
  if (!files.empty()) asked_.insert("osm");
  return kept(osm_, [&] { return read_all_osm(files, site); });
}
const io::GpxTraces& Sources::gpx(const Files& files, const SiteFrame& site) {
  if (!files.empty()) asked_.insert("gpx");
  return kept(gpx_, [&] { return io::read_gpx(files, site); });
}
const io::DriveLogs& Sources::drive_logs(const Files& files, const SiteFrame& site) {
  if (!files.empty()) asked_.insert("drive_logs");
  return kept(drive_logs_, [&] { return io::read_drive_logs(files, site); });
}
const io::ControlPoints& Sources::control_points(const Files& files, const SiteFrame& site) {
  if (!files.empty()) asked_.insert("control_points");
  return kept(control_points_, [&] { return io::read_control_points(files, site); });
}
const Terrain& Sources::terrain(const Files& dtm, const SiteFrame& site) {
  if (!dtm.empty()) asked_.insert("dtm");
  return kept(terrain_, [&] { return read_terrain(dtm, site); });
}
const SegmentModel& Sources::model(const fs::path& file) {
  asked_.insert("model");
  return kept(model_, [&] { return load_model(io::read_weights(file), file.string()); });
}

namespace {
Ring lonlat_of_photos(const Sources::Files& photos) {
  Ring lonlat;
  for (const fs::path& photo : photos) {
    const Ring outline = io::raster_info(photo).outline_lonlat.outer;
    lonlat.insert(lonlat.end(), outline.begin(), outline.end());
  }
  return lonlat;
}
}  // namespace

Polygon area_of_photos(const Sources::Files& photos, const Crs& crs) {
  const CoordinateTransform transform({"EPSG:4326"}, crs);
  Polygon area;
  for (const Vec2 p : lonlat_of_photos(photos)) area.outer.push_back(transform.target_from_source(p));
  if (photos.size() == 1) return area;
  return polygon_of(bounds_of(area.outer));
}

SiteFrame site_of_photos(const Sources::Files& photos) {
  const Box2 box = bounds_of(lonlat_of_photos(photos));
  const Crs crs = utm_crs(0.5 * (box.min_x + box.max_x), 0.5 * (box.min_y + box.max_y));
  return {crs, area_of_photos(photos, crs)};
}

std::string names_of(const Sources::Files& files) {
  std::string names;
  for (const fs::path& file : files) names += (names.empty() ? "" : ", ") + file.string();
  return names;
}

}  // namespace orthodrive
