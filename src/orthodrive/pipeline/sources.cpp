#include "orthodrive/pipeline/sources.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "orthodrive/core/error.hpp"
#include "orthodrive/io/raster_io.hpp"
#include "orthodrive/io/vector_io.hpp"
#include "orthodrive/io/weights_io.hpp"

namespace orthodrive {
namespace fs = std::filesystem;

namespace {
OsmRoads read_all_osm(const Sources::Files& files, const SiteFrame& site) {
  OsmRoads all;
  for (const fs::path& file : files) {
    RoadNetwork roads = io::read_osm_roads(file, site, &all.findings);
    all.roads.crs = roads.crs;
    std::move(roads.paths.begin(), roads.paths.end(), std::back_inserter(all.roads.paths));
  }
  std::vector<RoadPath>& paths = all.roads.paths;
  std::stable_sort(paths.begin(), paths.end(),
                   [](const RoadPath& a, const RoadPath& b) { return a.osm_id < b.osm_id; });
  for (std::size_t i = 1; i < paths.size(); ++i)
    if (paths[i].osm_id == paths[i - 1].osm_id && paths[i].part == paths[i - 1].part)
      throw OptionError(fmt::format("sources.osm: way {} is in two of the files, keep one", paths[i].osm_id));
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
const Terrain& Sources::terrain(const Files& dtm, const SiteFrame& site) {
  if (!dtm.empty()) asked_.insert("dtm");
  return kept(terrain_, [&] { return read_terrain(dtm, site); });
}
const SegmentModel& Sources::model(const fs::path& file) {
  asked_.insert("model");
  return kept(model_, [&] { return load_model(io::read_weights(file), file.string()); });
}

SiteFrame site_of_photo(const fs::path& photo) {
  const io::RasterInfo info = io::raster_info(photo);
  const Box2 box = bounds_of(info.outline_lonlat.outer);
  SiteFrame site{utm_crs(0.5 * (box.min_x + box.max_x), 0.5 * (box.min_y + box.max_y)), {}};
  const CoordinateTransform transform({"EPSG:4326"}, site.crs);
  for (const Vec2 p : info.outline_lonlat.outer) site.area.outer.push_back(transform.target_from_source(p));
  return site;
}

}  // namespace orthodrive
