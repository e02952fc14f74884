// SPDX-License-Identifier: Apache-2.0
#pragma once
// The sources of a run, each read once and kept for the stages that follow.

#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "orthodrive/core/monitor.hpp"
#include "orthodrive/io/opendrive/drive_log_io.hpp"
#include "orthodrive/io/vector/control_point_reader.hpp"
#include "orthodrive/io/vector/gpx_reader.hpp"
#include "orthodrive/model/rasters/rasters.hpp"
#include "orthodrive/model/roads/road_network.hpp"
#include "orthodrive/model/site_frame.hpp"
#include "orthodrive/segment/segment_model.hpp"

namespace orthodrive {

struct OsmRoads {
  RoadNetwork roads;  ///< of all files, by osm_id, then part
  Findings findings;
};
struct Terrain {
  std::vector<HeightGrid> dtms;  ///< best first
  Findings findings;
};

/// A run has one site and one of each source: what was read first is what every later call gets, whatever it asks for.
class Sources {
 public:
  using Files = std::vector<std::filesystem::path>;
  /// What is in several of the files counts once (io::read_osm_roads); nodes in one place are one (join_places).
  const OsmRoads& osm(const Files& files, const SiteFrame& site);
  const io::GpxTraces& gpx(const Files& files, const SiteFrame& site);
  const io::DriveLogs& drive_logs(const Files& files, const SiteFrame& site);
  const io::ControlPoints& control_points(const Files& files, const SiteFrame& site);
  const Terrain& terrain(const Files& dtm, const SiteFrame& site);
  const SegmentModel& model(const std::filesystem::path& file);
  /// Roles asked for since the last call ("osm", "gpx", "drive_logs", "control_points", "dtm", "model"); those without
  /// files are not counted. What is kept in memory opens no file: this shows what a stage depends on.
  [[nodiscard]] std::set<std::string> take_asked() { return std::exchange(asked_, {}); }

 private:
  std::set<std::string> asked_;
  std::optional<OsmRoads> osm_;
  std::optional<io::GpxTraces> gpx_;
  std::optional<io::DriveLogs> drive_logs_;
  std::optional<io::ControlPoints> control_points_;
  std::optional<Terrain> terrain_;
  std::optional<SegmentModel> model_;
};

[[nodiscard]] Terrain read_terrain(const Sources::Files& dtm, const SiteFrame& site);

/// What the photo shows; of several the box around all of them. Of terrain models likewise.
[[nodiscard]] Polygon area_of_photos(const Sources::Files& photos, const Crs& crs);
/// The same in the UTM zone of its centre: the site of photos that no site file describes.
[[nodiscard]] SiteFrame site_of_photos(const Sources::Files& photos);

/// The names of files for a message.
[[nodiscard]] std::string names_of(const Sources::Files& files);

}  // namespace orthodrive
