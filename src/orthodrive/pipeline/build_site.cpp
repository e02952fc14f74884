#include "orthodrive/pipeline/build_site.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <mutex>
#include <optional>

#include "orthodrive/core/aside_file.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/core/hash.hpp"
#include "orthodrive/drive/drive_report.hpp"
#include "orthodrive/drive/simulate_lap.hpp"
#include "orthodrive/elevate/elevate_roads.hpp"
#include "orthodrive/io/drive_log_io.hpp"
#include "orthodrive/io/gpx_reader.hpp"
#include "orthodrive/io/opendrive_io.hpp"
#include "orthodrive/io/raster_io.hpp"
#include "orthodrive/io/scene_io.hpp"
#include "orthodrive/io/vector_io.hpp"
#include "orthodrive/io/weights_io.hpp"
#include "orthodrive/model/sample_height.hpp"
#include "orthodrive/network/build_network.hpp"
#include "orthodrive/pipeline/crg_files.hpp"
#include "orthodrive/pipeline/pictures.hpp"
#include "orthodrive/pipeline/refine_files.hpp"
#include "orthodrive/pipeline/report.hpp"
#include "orthodrive/pipeline/road_relief.hpp"
#include "orthodrive/pipeline/score.hpp"
#include "orthodrive/refine/refine_roads.hpp"
#include "orthodrive/scene/build_scene.hpp"
#include "orthodrive/segment/segment_mosaic.hpp"

namespace orthodrive {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;

/// The sources, opened and checked before anything is written. The photo comes when the first stage asks for it.
struct Sources {
  RoadNetwork osm;
  Findings osm_findings, dtm_findings;
  io::GpxTraces gpx;
  io::DriveLogs drive_logs;
  std::vector<HeightGrid> dtms;
  SegmentModel model;
  RefineWeights refine_weights;
  json hashes = json::object();
};


RoadNetwork read_all_osm(const Site& site, Findings& findings) {
  RoadNetwork all;
  for (const fs::path& file : site.osm) {
    RoadNetwork roads = io::read_osm_roads(file, site.frame, &findings);
    all.crs = roads.crs;
    std::move(roads.paths.begin(), roads.paths.end(), std::back_inserter(all.paths));
  }
  std::stable_sort(all.paths.begin(), all.paths.end(), [](const RoadPath& a, const RoadPath& b) { return a.osm_id < b.osm_id; });
  for (std::size_t i = 1; i < all.paths.size(); ++i)
    if (all.paths[i].osm_id == all.paths[i - 1].osm_id && all.paths[i].part == all.paths[i - 1].part)
      throw OptionError(fmt::format("sources.osm: way {} is in two of the files, keep one", all.paths[i].osm_id));
  return all;
}

Sources open_sources(const Site& site) {
  Sources sources;
  (void)io::raster_info(site.photo);
  sources.osm = read_all_osm(site, sources.osm_findings);
  sources.gpx = io::read_gpx(site.gpx, site.frame);
  sources.drive_logs = io::read_drive_logs(site.drive_logs, site.frame);
  sources.dtms = io::read_dtms(site.dtm, site.frame, {.least_coverage = io::least_site_coverage}, &sources.dtm_findings);
  const fs::path model_file = io::find_model(site.model);
  sources.model = load_model(io::read_file(model_file), model_file.string());
  if (site.crf && !sources.model.crf) {
    throw InputError(model_file.string(), "has no CRF: train one with orthodrive train --crf, or leave 'crf' of [segment] false");
  }

  const auto add = [&](const std::string& role, const fs::path& file) {
    sources.hashes[role].push_back({{"file", file.filename().string()}, {"hash", hash_file(file)}});
  };
  const auto add_raster = [&](const std::string& role, const fs::path& file) {
    add(role, file);  // a raster may have its place in a file beside it, which counts as well
    json outline = json::array();
    for (const Vec2 p : io::raster_info(file).outline_lonlat.outer) outline.push_back({p.x, p.y});
    sources.hashes[role].back()["outline_hash"] = hash_bytes(outline.dump());
  };
  add_raster("photo", site.photo);
  for (const fs::path& file : site.osm) add("osm", file);
  for (const fs::path& file : site.gpx) add("gpx", file);
  for (const fs::path& log : site.drive_logs)
    for (const fs::path& file : io::drive_log_files(log)) add("drive_logs", file);
  for (const fs::path& file : site.dtm) add_raster("dtm", file);
  add("model", model_file);
  if (!site.refine_weights.empty()) {
    sources.refine_weights = read_refine_weights(site.refine_weights);
    add("refine_weights", site.refine_weights);
  }
  return sources;
}

/// Everything of a site that is not a file and changes results.
json options_of(const Site& site) {
  json ring = json::array();
  for (const Vec2 p : site.frame.area.outer) ring.push_back({p.x, p.y});
  return {{"name", site.name}, {"crs", site.frame.crs.definition}, {"area", hash_bytes(ring.dump())}, {"model", site.model}, {"crf", site.crf},
          {"dtm_sampling", site.dtm_sampling}, {"route", site.route}, {"attribution", site.attribution}};
}

/// Mean over all nodes; they lie about 2 m apart everywhere.
template <typename Value>
double mean_over_nodes(const RoadNetwork& roads, const Value& value) {
  double sum = 0.0, count = 0.0;
  for (const RoadPath& path : roads.paths)
    for (const RoadNode& node : path.nodes) sum += value(node), count += 1.0;
  return count > 0.0 ? sum / count : 0.0;
}

/// The tile with most road triangles is the one to show.
class TilePicture {
 public:
  void offer(const SceneTile& tile) {
    std::size_t triangles = 0;
    for (const TriMesh& mesh : tile.meshes)
      if (mesh.name == "road") triangles += mesh.indices.size() / 3;
    const std::lock_guard lock(mutex_);
    const bool earlier = std::pair(tile.column, tile.row) < std::pair(best_.column, best_.row);
    if (triangles > most_ || (triangles == most_ && most_ > 0 && earlier)) {  // ties by address: any thread order, one picture
      best_ = tile;
      best_.texture_rgb = {};
      most_ = triangles;
    }
  }
  [[nodiscard]] const SceneTile& best() const { return best_; }

 private:
  std::mutex mutex_;
  SceneTile best_;
  std::size_t most_ = 0;
};

}  // namespace

BuildResult build_site(const Site& site, const fs::path& out_dir, const BuildOptions& options, Monitor* monitor) {
  Monitor silent;
  if (!monitor) monitor = &silent;
  const Sources sources = open_sources(site);
  const json site_options = options_of(site);
  StageCache cache(out_dir);
  BuildResult result;
  remove_stale_asides(out_dir);

  std::optional<Photo> photo_in_memory;
  const auto photo = [&]() -> const Photo& {
    if (!photo_in_memory) photo_in_memory = io::read_photo(site.photo, site.frame, {.threads = options.threads});
    return *photo_in_memory;
  };
  const auto labels = [&] { return io::read_labels(out_dir / "labels.tif"); };
  const fs::path refined_file = cache.private_file("refined.gpkg");

  // A key stands for the tool, the options and the sources of a stage and of all before it: one change runs what follows again.
  std::string key = hash_bytes(hash_file("/proc/self/exe") + site_options.at("crs").dump() + site_options.at("area").dump());
  const auto stage = [&](const std::string& name, const json& depends_on, const std::vector<std::string>& outputs,
                         const std::function<StageOutcome()>& body) {
    key = hash_bytes(key + name + depends_on.dump());
    if (cache.holds(name, key)) {
      result.stages.push_back(cache.load(name));
      monitor->info(fmt::format("{:<9} unchanged, taken over", name));
      return;
    }
    result.stages.push_back(cache.run(name, key, outputs, body));
    monitor->info(fmt::format("{:<9} {:6.1f} s  {:5.0f} MB", name, result.stages.back().seconds,
                              static_cast<double>(result.stages.back().peak_memory_bytes) / 1e6));
  };

  stage("segment", {sources.hashes["photo"], sources.hashes["model"], site.crf}, {"labels.tif", "confidence.tif", "road_probability.tif"}, [&] {
    // The photo streams: other stages hold it in memory, this one never does.
    const PhotoSource source = io::open_photo(site.photo, site.frame, {.threads = options.threads});
    const GridFrame frame = label_frame(source.frame, sources.model);
    io::RasterStream label_stream = io::stream_labels(out_dir / "labels.tif", source.crs, frame, sources.model.classes),
                     confidence_stream = io::stream_confidence(out_dir / "confidence.tif", source.crs, frame),
                     road_stream = io::stream_confidence(out_dir / "road_probability.tif", source.crs, frame);
    const SegmentSummary segmented = segment_mosaic(
        source, sources.model,
        [&](const PixelBox& box, const LabelledPixels& pixels) {
          label_stream.write(box, pixels.labels);
          confidence_stream.write(box, pixels.confidence);
          road_stream.write(box, pixels.road_probability);
        },
        {.threads = options.threads, .crf = site.crf ? sources.model.crf : std::nullopt}, monitor);
    if (segmented.labelled_pixels == 0)
      throw InputError(site.photo.string(), "has no data in the area (nodata, alpha or mask); take another photo or area");
    label_stream.finish();
    confidence_stream.finish();
    road_stream.finish();
    return StageOutcome{{{"photo_gsd_m", source.frame.gsd_m}, {"gsd_m", frame.gsd_m},
                         {"pixels", static_cast<std::int64_t>(frame.width) * frame.height}},
                        segmented.findings};
  });

  const json of_refine{sources.hashes["osm"], sources.hashes.value("refine_weights", json()), sources.hashes.value("gpx", json()),
                       site.drives_left};
  stage("refine", of_refine, {".orthodrive/refined.gpkg"}, [&] {
    RefineRoadsResult refined = refine_roads(
        sources.osm, read_evidence(labels(), out_dir / "road_probability.tif"),
        {.weights = sources.refine_weights, .driving_side = site.drives_left ? DrivingSide::left : DrivingSide::right, .threads = options.threads},
        monitor, sources.gpx.traces);
    refined.findings.insert(refined.findings.begin(), sources.gpx.findings.begin(), sources.gpx.findings.end());
    io::write_roads(refined_file, refined.roads);
    refined.findings.insert(refined.findings.begin(), sources.osm_findings.begin(), sources.osm_findings.end());
    return StageOutcome{{{"ways", refined.roads.paths.size()},
                         {"mean_abs_offset_m", mean_over_nodes(refined.roads, [](const RoadNode& n) { return std::abs(n.offset_m); })},
                         {"mean_sigma_offset_m", mean_over_nodes(refined.roads, [](const RoadNode& n) { return n.sigma_offset_m; })},
                         {"mean_sigma_width_m", mean_over_nodes(refined.roads, [](const RoadNode& n) { return n.sigma_width_m; })},
                         {"converged", refined.solve.converged},
                         {"iterations", refined.solve.iterations}},
                        refined.findings};
  });

  const json of_elevate{sources.hashes["dtm"], site.dtm_sampling, site.drives_left, sources.hashes.value("drive_logs", json())};
  stage("elevate", of_elevate, {"roads.gpkg"}, [&] {
    const HeightSampling sampling = site.dtm_sampling == "cubic" ? HeightSampling::cubic : HeightSampling::bilinear;
    ElevateRoadsResult elevated = elevate_roads(io::read_roads(refined_file), sources.dtms, sources.drive_logs.log,
                                                {.heights = {.sampling = sampling, .threads = options.threads},
                                                 .cross_fall = {.drives_left = site.drives_left}},
                                                monitor);
    elevated.findings.insert(elevated.findings.begin(), sources.dtm_findings.begin(), sources.dtm_findings.end());
    json numbers{{"gradient_energy_of_terrain", elevated.before.gradient},
                 {"gradient_energy", elevated.after.gradient},
                 {"height_error_energy_m2", elevated.after.height_error_m2},
                 {"cross_fall_measured_share", elevated.cross_fall_measured_share},
                 {"converged", elevated.solve.converged},
                 {"iterations", elevated.solve.iterations}};
    if (!site.drive_logs.empty()) numbers["driven_m"] = elevated.logged_m, numbers["driven_on_roads_m"] = elevated.logged_on_roads_m;
    elevated.findings.insert(elevated.findings.begin(), sources.drive_logs.findings.begin(), sources.drive_logs.findings.end());
    io::write_roads(out_dir / "roads.gpkg", elevated.roads, elevated.roughness);
    return StageOutcome{numbers, elevated.findings};
  });

  const std::vector<std::string> network_files =
      site.crg.empty() ? std::vector<std::string>{"roads.xodr"} : std::vector<std::string>{"roads.xodr", "roads_crg"};
  // The route counts where surfaces are made of it.
  const json of_network{site.name, site.drives_left, site.crg, site.opendrive, site.crg.empty() ? "" : site.route};
  stage("network", of_network, network_files, [&] {
    const RoadNetwork roads = io::read_roads(out_dir / "roads.gpkg");
    const BuildNetworkOptions network_options{.name = site.name, .left_hand_traffic = site.drives_left, .threads = options.threads};
    NetworkResult network = build_network(roads, network_options, monitor);
    if (site.crg.empty()) fs::remove_all(crg_folder(out_dir / "roads.xodr"));  // of an earlier build with other options
    CrgFilesOptions surfaces{.roads = site.crg, .route = site.route, .threads = options.threads};
    const RoadRelief relief(roads, io::read_roughness(out_dir / "roads.gpkg"), 2.0 * surfaces.u_step_m);
    surfaces.relief_of = [&](const roadquery::Road& road) { return relief.of(network.map, road); };
    const CrgFilesResult crg = write_crg_files(network.map, out_dir / "roads.xodr", surfaces);
    io::write_opendrive(out_dir / "roads.xodr", network.map, {.minor_version = site.opendrive == "1.8" ? 8 : 7});
    double length = 0.0;
    for (const roadquery::Road& road : network.map.roads) length += road.length;
    return StageOutcome{{{"roads", network.map.roads.size()}, {"junctions", network.map.junctions.size()}, {"length_m", length}, {"crg_files", crg.files},
                         {"max_plan_deviation_m", network.max_plan_deviation_m}, {"max_elevation_error_m", network.max_elevation_error_m}},
                        network.findings};
  });

  stage("scene", {site_options.at("attribution")}, {"scene", ".orthodrive/scene_tile.png"}, [&] {
    const roadquery::RoadMap map = roadquery::read_opendrive((out_dir / "roads.xodr").string());
    const HeightGrid terrain = merge_heights(sources.dtms, bounds_of(site.frame.area.outer).grown(50.0));
    AsideFile folder(out_dir / "scene");
    fs::create_directories(folder.path());
    const LabelMap tile_labels = labels();
    std::mutex mutex;
    std::vector<io::TileEntry> entries;
    std::optional<Vec3> origin;
    TilePicture picture;
    const SceneResult scene = build_scene(
        {map, terrain, photo(), site.frame.area, &tile_labels},
        [&](const SceneTile& tile, Vec3 site_origin) {
          picture.offer(tile);
          io::TileEntry entry = io::write_tile_glb(folder.path(), tile, site_origin);
          const std::lock_guard lock(mutex);
          entries.push_back(std::move(entry));
          origin = site_origin;
        },
        {.threads = options.threads}, monitor);
    if (!origin) throw Error("scene: no tile has ground, check the area and the terrain model");
    io::write_tileset(folder.path(), entries, site.frame.crs, *origin);
    folder.commit();
    io::write_png(cache.private_file("scene_tile.png"), picture_of_tile(picture.best(), scene_tile_m, 900).rgb);
    return StageOutcome{{{"tiles", scene.tiles}, {"terrain_triangles", scene.terrain_triangles}, {"road_triangles", scene.road_triangles},
                         {"road_surface_m2", scene.road_surface_m2}},
                        scene.findings};
  });

  // The drive needs the network only, but keys run in one chain: a new photo drives again, which costs a second.
  stage("drive", {site.route}, {"drive", ".orthodrive/lap_plots.html"}, [&] {
    const roadquery::RoadMap map = roadquery::read_opendrive((out_dir / "roads.xodr").string());
    const DriveResult drive = simulate_lap(map, {.route = {.route = site.route}}, monitor);
    AsideFile folder(out_dir / "drive");
    write_text_file(folder.path() / "lap.csv", lap_csv(drive));
    write_text_file(folder.path() / "report.html", lap_report_html(map, drive));
    folder.commit();
    write_text_file(cache.private_file("lap_plots.html"), fmt::format("{}", fmt::join(lap_plots(map, drive), "\n")));
    return StageOutcome{{{"route", drive.route.name}, {"closed", drive.route.closed}, {"finished", drive.finished},
                         {"length_m", drive.length_m}, {"lap_time_s", drive.lap_time_s}, {"max_speed_mps", drive.max_speed_mps},
                         {"max_lateral_mps2", drive.max_lateral_mps2}, {"max_gradient", drive.max_gradient}, {"min_gradient", drive.min_gradient}, {"climb_m", drive.climb_m},
                         {"max_line_error_m", drive.max_line_error_m}, {"tyre_queries", drive.tyre_queries},
                         {"tyre_queries_per_s", drive.tyre_queries_per_s()}, {"off_road_share", drive.off_road_share},
                         {"max_height_step_m", drive.max_height_step_m}},
                        drive.findings};
  });

  json scores;
  if (!site.truth_dir.empty())
    scores = {{"result", score_site({out_dir, site.truth_dir})}, {"input", {{"roads", score_roads({site.osm.front(), site.truth_dir})}}}};

  // The report is not a cached stage: it shows the timings, which change. It costs a few seconds.
  const StageRecord report = cache.run("report", key, {}, [&] {
    write_report({site, out_dir, photo(), sources.osm, sources.dtms, result.stages, scores});
    return StageOutcome{};
  });
  Findings findings;
  for (const StageRecord& record : result.stages)
    findings.insert(findings.end(), record.outcome.findings.begin(), record.outcome.findings.end());
  io::write_findings(out_dir / "findings.geojson", findings, site.frame.crs);
  result.stages.push_back(report);

  json run{{"tool", "orthodrive"}, {"version", options.version}, {"site", site_options}, {"inputs", sources.hashes}, {"stages", json::array()}};
  for (const StageRecord& record : result.stages)
    run["stages"].push_back({{"stage", record.stage}, {"seconds", record.seconds}, {"peak_memory_bytes", record.peak_memory_bytes},
                             {"skipped", record.skipped}, {"key", record.key}, {"numbers", record.outcome.numbers},
                             {"findings", record.outcome.findings.size()}});
  run["attribution"] = site.attribution;
  if (!scores.is_null()) run["scores"] = scores;
  write_text_file(out_dir / "run.json", run.dump(1) + "\n");
  return result;
}

}  // namespace orthodrive
