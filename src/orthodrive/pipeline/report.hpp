#pragma once
// report.html of a built site: one file a person wants to look at, with pictures, plots and numbers of every stage.

#include <filesystem>
#include <nlohmann/json.hpp>
#include <vector>

#include "orthodrive/model/rasters.hpp"
#include "orthodrive/model/road_network.hpp"
#include "orthodrive/pipeline/site.hpp"
#include "orthodrive/pipeline/stage_cache.hpp"

namespace orthodrive {

struct ReportInput {
  const Site& site;
  std::filesystem::path out_dir;        ///< labels.tif, roads.gpkg, roads.xodr, drive/lap.csv are read from here
  const Photo& photo;
  const RoadNetwork& osm;
  const std::vector<HeightGrid>& dtms;
  const std::vector<StageRecord>& stages;
  nlohmann::json scores;                ///< of the result and of the input against the site's truth; null without truth
};

/// Writes out_dir/report.html (self-contained; pictures are inline JPEGs).
void write_report(const ReportInput& input);

}  // namespace orthodrive
