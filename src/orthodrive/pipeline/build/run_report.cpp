// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/pipeline/build/run_report.hpp"

#include <algorithm>

#include "orthodrive/core/atomic_file.hpp"
#include "orthodrive/io/raster/raster_io.hpp"
#include "orthodrive/io/support/read_file.hpp"
#include "orthodrive/io/support/vector_io.hpp"
#include "orthodrive/report/site_report.hpp"

namespace orthodrive {
namespace {
namespace fs = std::filesystem;

std::string read_if_there(const fs::path& file) { return fs::exists(file) ? io::read_file(file) : std::string(); }

std::vector<ReportStage> report_stages(const std::vector<StageRecord>& records) {
  std::vector<ReportStage> stages;
  stages.reserve(records.size());
  for (const StageRecord& record : records)
    stages.push_back({.name = record.stage,
                      .numbers = record.outcome.numbers,
                      .findings = record.outcome.findings,
                      .seconds = record.seconds,
                      .peak_memory_bytes = record.peak_memory_bytes,
                      .taken_over = record.skipped});
  return stages;
}
}  // namespace

StageOutcome run_report(SiteBuild& build, const std::vector<StageRecord>& records, const nlohmann::json& scores) {
  const Site& site = build.site;
  Sources& sources = build.context.sources;
  const fs::path& out_dir = build.out_dir;
  const fs::path tile_file = out_dir / ".orthodrive" / "scene_tile.png";
  const LabelMap labels = io::read_labels(out_dir / "labels.tif");
  const RoadNetwork roads = io::read_roads(out_dir / "roads.gpkg");
  const roadquery::RoadMap map = roadquery::read_opendrive((out_dir / "roads.xodr").string());
  const std::vector<ReportStage> stages = report_stages(records);
  const int threads = build.context.threads;
  const PhotoSource photo = io::open_photo(site.photos, site.frame, {.threads = threads});
  const Box2 box = photo.frame.bounds();
  const double overview_gsd_m = std::max(box.width(), box.height()) / report_overview_px;
  const Photo overview =
      io::read_photo(site.photos, site.frame,
                     {.gsd_m = std::max(photo.frame.gsd_m, overview_gsd_m), .threads = threads, .overviews = true});
  const SiteReportView view{
      .name = site.name,
      .area = site.frame.area,
      .attribution = site.attribution,
      .overview = overview,
      .photo = photo,
      .osm = sources.osm(site.osm, site.frame).roads,
      .dtms = sources.terrain(site.dtm, site.frame).dtms,
      .labels = labels,
      .roads = roads,
      .map = map,
      .scene_tile = fs::exists(tile_file) ? std::optional(io::read_image(tile_file)) : std::nullopt,
      .lap_csv = read_if_there(out_dir / "drive" / "lap.csv"),
      .lap_plots = read_if_there(out_dir / ".orthodrive" / "lap_plots.html"),
      .stages = stages,
      .scores = scores,
      .encoders = {.jpeg = io::encode_jpeg, .png = io::encode_png}};
  write_text_file(out_dir / "report.html", site_report_html(view));
  return {};
}

}  // namespace orthodrive
