// SPDX-License-Identifier: Apache-2.0
#pragma once
// report.html of a built site: one page a person wants to look at, with pictures, plots and numbers of every stage.

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "orthodrive/core/finding.hpp"
#include "orthodrive/model/rasters/raster_source.hpp"
#include "orthodrive/model/roads/road_network.hpp"
#include "orthodrive/report/html.hpp"
#include "roadquery/map/road_map.hpp"

namespace orthodrive {

/// A stage as the page shows it.
struct ReportStage {
  std::string name;
  nlohmann::json numbers;
  Findings findings;
  double seconds = 0.0;
  std::uint64_t peak_memory_bytes = 0;
  bool taken_over = false;  ///< from an earlier run
};

/// Twice what pictures of whole areas have.
constexpr int report_overview_px = 2800;

/// What the page shows. Borrowed, in the site CRS.
struct SiteReportView {
  const std::string& name;
  const Polygon& area;
  const std::vector<std::string>& attribution;
  const Photo& overview;     ///< of the whole area, report_overview_px along its longer side, or all that the photo has
  const PhotoSource& photo;  ///< for places seen close up
  const RoadNetwork& osm;
  const std::vector<HeightGrid>& dtms;
  const LabelMap& labels;
  const RoadNetwork& roads;  ///< refined, with heights
  const roadquery::RoadMap& map;
  std::optional<Raster<std::uint8_t>> scene_tile;  ///< picture of one tile
  std::string lap_csv;                             ///< as lap_report.hpp makes it; empty: not driven
  std::string lap_plots;                           ///< likewise
  const std::vector<ReportStage>& stages;
  const nlohmann::json& scores;  ///< of the result and of the input against the site's truth; null without truth
  PictureEncoders encoders;
};

/// Self-contained; pictures are inline JPEGs.
[[nodiscard]] std::string site_report_html(const SiteReportView& view);

}  // namespace orthodrive
