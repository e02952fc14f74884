// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/pipeline/stages/run_segment.hpp"

#include <fmt/format.h>

#include "orthodrive/core/error.hpp"
#include "orthodrive/io/models/alignment_io.hpp"
#include "orthodrive/io/models/weights_io.hpp"
#include "orthodrive/io/raster/raster_io.hpp"
#include "orthodrive/model/roads/map_lines.hpp"
#include "orthodrive/pipeline/sources/map_labels.hpp"
#include "orthodrive/pipeline/stages/adapt_part.hpp"

namespace orthodrive {
namespace fs = std::filesystem;

namespace {
std::optional<CrfModel> choose_crf(const SegmentModel& model, const fs::path& model_file,
                                   const RunSegmentOptions& options, const StageContext& context) {
  if (options.crf == CrfUse::none) return std::nullopt;
  std::optional<CrfModel> crf = model.crf;
  if (!options.crf_set.empty())
    crf = crf_of(parse_crf_set(options.crf_set), static_cast<int>(model.classes.classes.size()));
  if (!crf && options.crf == CrfUse::trained)
    throw InputError(model_file.string(),
                     "has no CRF: train one with orthodrive train --crf, or leave 'crf' of [segment] false");
  if (!crf) {
    context.info("the model has no trained CRF: using the widths and weights of the reference's grid search");
    crf = reference_crf(static_cast<int>(model.classes.classes.size()));
  }
  if (options.crf_iterations > 0) crf->parameters.iterations = options.crf_iterations;
  return crf;
}

/// Where the paths of a map are asked for their alignment.
struct MapPlaces {
  std::vector<std::vector<double>> s_m;  ///< one per path
  std::vector<Vec2> points;              ///< of all of them
};
MapPlaces places_of(const RoadNetwork& roads) {
  MapPlaces places;
  for (const RoadPath& path : roads.paths) {
    const Polyline line = centerline(path);
    // No photo shows a tunnel, and no raster of the map has it.
    places.s_m.push_back(path.tunnel ? std::vector<double>{} : places_along(length_m(line)));
    for (const double s : places.s_m.back()) places.points.push_back(point_at(line, s));
  }
  return places;
}
RoadAlignment by_path(const MapPlaces& places, const std::vector<PlaceAlignment>& alignments) {
  RoadAlignment result;
  std::size_t next = 0;
  for (const std::vector<double>& of_path : places.s_m) {
    std::vector<AlignedPlace>& path = result.emplace_back();
    for (const double s : of_path)
      path.push_back({s, alignments.empty() ? PlaceAlignment{} : alignments[next]}), ++next;
  }
  return result;
}

Sources::Files or_else(const Sources::Files& files, const Sources::Files& otherwise) {
  return files.empty() ? otherwise : files;
}

Finding finding_of(const AdaptReport& report, Vec2 at) {
  const std::string told =
      report.kept ? fmt::format(
                        "the network adapted to the site: on {} cells held back its roads agree with the map with an "
                        "IoU of {:.3f} (before: {:.3f}; kappa {:.3f}, before: {:.3f}); it learned from {} cells",
                        report.held_back_cells, report.after.iou, report.before.iou, report.after.kappa,
                        report.before.kappa, report.learned_cells)
                  : "the network as shipped, not adapted to the site: " + report.why_not;
  return {report.kept ? Severity::info : Severity::warning, report.kept ? "segment.adapted" : "segment.not_adapted",
          told, at.x, at.y};
}

nlohmann::json adapt_numbers(const AdaptReport& report) {
  return {{"kept", report.kept},
          {"cells", report.learned_cells},
          {"cells_held_back", report.held_back_cells},
          {"road_iou", {report.before.iou, report.after.iou}},
          {"kappa", {report.before.kappa, report.after.kappa}},
          {"kappa_by_photo_alone", report.alone.kappa},
          {"kappa_with_edges", {report.before.kappa_with_edges, report.after.kappa_with_edges}}};
}

/// The rasters to write; those without a name are left out.
struct LabelStreams {
  io::RasterStream labels;
  std::optional<io::RasterStream> confidence, road_probability;

  LabelStreams(const SegmentFiles& files, const Crs& crs, const GridFrame& frame, const ClassTable& classes)
      : labels(io::stream_labels(files.labels, crs, frame, classes)) {
    if (!files.confidence.empty()) confidence.emplace(io::stream_confidence(files.confidence, crs, frame));
    if (!files.road_probability.empty())
      road_probability.emplace(io::stream_confidence(files.road_probability, crs, frame));
  }
  void write(const PixelBox& box, const LabelledPixels& pixels) {
    labels.write(box, pixels.labels);
    if (confidence) confidence->write(box, pixels.confidence);
    if (road_probability) road_probability->write(box, pixels.road_probability);
  }
  void finish() {
    labels.finish();
    if (confidence) confidence->finish();
    if (road_probability) road_probability->finish();
  }
};

/// All that labelling a site reads.
struct SegmentInputs {
  SegmentInputs(const SegmentFiles& files, const RunSegmentOptions& run, StageContext& context)
      : model_file(io::find_model(files.model)),
        model(context.sources.model(model_file)),
        site(run.site ? *run.site : site_of_photos(files.photos)) {
    if (run.adapt && files.osm.empty())
      throw OptionError("adapt: give the OSM roads of the photo, too; the network learns from them");
    if (!run.adapt && !model.sees_map && !files.osm.empty())
      throw OptionError(fmt::format("--osm changes nothing: {} sees no map; leave it out, or take a model that does",
                                    model_file.string()));
    if (!run.site && !model.sees_map && !files.alignment.empty())
      throw OptionError(fmt::format(
          "--alignment changes nothing: {} sees no map; leave it out, or take a model that does", model_file.string()));
    if (!files.osm.empty()) roads = &context.sources.osm(files.osm, site).roads;
    map = map_lines(seen());
    places = places_of(seen());
    photo = io::open_photo(files.photos, site, {.threads = context.threads}, &findings);
    crf = choose_crf(model, model_file, run, context);
    window_px = run.window_px;
    threads = context.threads;
  }
  SegmentInputs(const SegmentInputs&) = delete;
  /// The roads that the network sees.
  [[nodiscard]] const RoadNetwork& seen() const {
    static const RoadNetwork none;
    return roads && model.sees_map ? *roads : none;
  }
  [[nodiscard]] SegmentOptions options() const {
    return {.window_px = window_px, .threads = threads, .map = &map, .places = places.points, .crf = crf};
  }

  fs::path model_file;
  SegmentModel model;
  SiteFrame site;
  const RoadNetwork* roads = nullptr;
  MapLines map;
  MapPlaces places;
  PhotoSource photo;
  Findings findings;  ///< of the photos
  std::optional<CrfModel> crf;
  int window_px = 0, threads = 0;
};
}  // namespace

void help_segment(const SegmentFiles& files, const RunSegmentOptions& options, StageContext& context) {
  const SegmentInputs in(files, options, context);
  CellExchange& exchange = *context.exchange;
  segment_windows(
      in.photo, in.model, [&](std::size_t windows) { return exchange.next_cell(windows); },
      [&](std::size_t window, const std::string& bytes) {
        CellFolder(exchange.store(CellExchange::cells), window).commit(bytes);
      },
      in.options(), context.monitor);
}

StageOutcome run_segment(const SegmentFiles& files, const RunSegmentOptions& options, StageContext& context) {
  SegmentInputs in(files, options, context);
  std::optional<AdaptReport> adaptation;
  if (options.adapt) {
    const AdaptPart& part = adapt_part();
    const WeakLabels labels = map_labels(*in.roads, or_else(files.buildings, files.osm),
                                         or_else(files.surroundings, files.osm), in.site, in.model.classes);
    const AdaptedModel adapted = part.adapt_model(io::read_weights(in.model_file), in.model_file.string(), in.photo,
                                                  labels, in.map, {.threads = context.threads}, context.monitor);
    adaptation = adapted.report;
    if (adapted.report.kept) {
      in.model = load_model(adapted.file, in.model_file.string() + ", adapted");
      in.crf = choose_crf(in.model, in.model_file, options, context);
    }
  }
  SegmentOptions segment = in.options();
  if (context.exchange && !options.adapt)  // a network that adapts learns from all of the site first
    segment.made = [&](std::size_t window) { return context.exchange->take(CellExchange::cells, window); };
  const GridFrame frame = label_frame(in.photo.frame, in.model);
  LabelStreams streams(files, in.photo.crs, frame, in.model.classes);
  SegmentSummary segmented = segment_mosaic(
      in.photo, in.model, [&](const PixelBox& box, const LabelledPixels& pixels) { streams.write(box, pixels); },
      segment, context.monitor);
  if (options.site && segmented.labelled_pixels == 0)
    throw InputError(names_of(files.photos),
                     "has no data in the area (nodata, alpha or mask); take another photo or area");
  streams.finish();
  if (!files.alignment.empty())
    io::write_alignment(files.alignment, in.seen(), by_path(in.places, segmented.alignments));
  StageOutcome outcome{.numbers = {{"photo_gsd_m", in.photo.frame.gsd_m},
                                   {"gsd_m", frame.gsd_m},
                                   {"pixels", static_cast<std::int64_t>(frame.width) * frame.height}},
                       .findings = std::move(in.findings)};
  append(outcome.findings, segmented.findings);
  if (adaptation) {
    outcome.numbers["adapt"] = adapt_numbers(*adaptation);
    outcome.findings.push_back(finding_of(
        *adaptation, in.photo.frame.world_from_pixel(0.5 * in.photo.frame.width, 0.5 * in.photo.frame.height)));
  }
  return outcome;
}

BuildStage segment_stage(SiteBuild& build) {
  const Site& site = build.site;
  const fs::path model_file = io::find_model(site.model);
  const RunSegmentOptions options{
      .site = site.frame, .crf = site.crf ? CrfUse::trained : CrfUse::none, .adapt = site.adapt};
  const bool needs_map = site.adapt || build.context.sources.model(model_file).sees_map;
  const Sources::Files none, osm = needs_map ? site.osm : none,
                             buildings = site.adapt ? or_else(site.buildings, site.osm) : none,
                             surroundings = site.adapt ? or_else(site.surroundings, site.osm) : none;
  const SegmentFiles files{.photos = site.photos,
                           .model = site.model,
                           .osm = osm,
                           .buildings = buildings,
                           .surroundings = surroundings,
                           .labels = build.out_dir / "labels.tif",
                           .confidence = build.out_dir / "confidence.tif",
                           .road_probability = build.out_dir / "road_probability.tif",
                           .alignment = build.out_dir / ".orthodrive/alignment.csv"};
  std::function<void()> help;
  if (!site.adapt) help = [=, &build] { help_segment(files, options, build.context); };
  nlohmann::json options_in_key = frame_options(site.frame);
  options_in_key.update({{"segment.crf", site.crf}, {"segment.adapt", site.adapt}});
  return {.name = "segment",
          .version = 8,
          .sources = {{"photo", site.photos, SourceRole::Kind::raster},
                      {"model", {model_file}},
                      {"osm", osm},
                      {"buildings", buildings},
                      {"surroundings", surroundings}},
          .options = options_in_key,
          .outputs = {"labels.tif", "confidence.tif", "road_probability.tif", ".orthodrive/alignment.csv"},
          .check =
              [=, &build, &site] {
                for (const fs::path& photo : site.photos) (void)io::raster_info(photo);
                const SegmentModel& model = build.context.sources.model(model_file);
                (void)choose_crf(model, model_file, options, build.context);
                if (site.adapt) adapt_part().require_adaptable(model, model_file.string());
              },
          .run = [=, &build] { return run_segment(files, options, build.context); },
          .help = help};
}

}  // namespace orthodrive
