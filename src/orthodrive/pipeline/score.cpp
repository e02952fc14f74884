#include "orthodrive/pipeline/score.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "orthodrive/core/atomic_file.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/io/raster_io.hpp"
#include "orthodrive/io/tile_reader.hpp"
#include "orthodrive/io/vector_io.hpp"
#include "orthodrive/pipeline/network_verdict.hpp"
#include "orthodrive/pipeline/road_layers.hpp"
#include "orthodrive/report/label_report.hpp"
#include "roadquery/road_surface.hpp"

namespace orthodrive {
namespace fs = std::filesystem;

namespace {
void check_options(const LabelScoreOptions& options, bool truth_has_classes) {
  if (!options.photo.empty() && options.page.empty())
    throw OptionError("--photo is shown on the page of --html; give both");
  if (!truth_has_classes && !(options.merge.empty() && options.confidence.empty() && options.page.empty()))
    throw OptionError("the truth knows roads only; --merge, --confidence and --html need truth with classes");
}

ConfidenceMap read_confidence_of(const fs::path& path, const LabelMap& prediction) {
  ConfidenceMap confidence = io::read_confidence(path);
  if (confidence.crs != prediction.crs || confidence.frame != prediction.frame)
    throw InputError(path.string(), "does not lie on the label map's grid; take both from one `orthodrive segment`");
  return confidence;
}

/// A table that does not fit the classes is a fault of its file.
LabelComparisonView compare(const LabelMap& prediction, const LabelMap& truth, const ComparisonOptions& comparison,
                            const fs::path& merge_file) {
  try {
    return {prediction, truth, comparison};
  } catch (const OptionError& error) {
    throw InputError(merge_file.string(), error.what());
  }
}

/// Reads the photo piece by piece around what the page shows.
std::function<std::optional<Photo>(const GridFrame&)> photo_reader(const fs::path& file, const Crs& crs) {
  if (file.empty()) return {};
  return [file, crs](const GridFrame& frame) -> std::optional<Photo> {
    const Box2 box = frame.bounds();
    const Ring corners{{box.min_x, box.min_y}, {box.max_x, box.min_y}, {box.max_x, box.max_y}, {box.min_x, box.max_y}};
    try {
      return io::read_photo(file, {crs, {corners, {}}}, {.gsd_m = frame.gsd_m});
    } catch (const InputError&) {
      static_cast<void>(io::raster_info(file));  // a missing or broken file says so itself
      return std::nullopt;
    }
  };
}

/// A path that does not end in .html is a folder: its labels.html.
void write_label_page(const fs::path& page, const LabelReportView& report) {
  write_text_file(page.extension() == ".html" ? page : page / "labels.html", label_report_html(report));
}
}  // namespace

ScoreJson score_labels(const ScoreRequest& request, const LabelScoreOptions& options) {
  const LabelMap prediction = io::read_labels(request.scored);
  const auto read = read_label_truth(inside_folder(request.truth, "labels.tif"), prediction);
  check_options(options, std::holds_alternative<LabelTruth>(read));
  if (const auto* roads = std::get_if<MultiPolygon>(&read))
    return to_json(evaluate_road_role(prediction, *roads, read_region(request.region, prediction.crs)));

  const LabelTruth& truth = std::get<LabelTruth>(read);
  ComparisonOptions comparison{.region = read_region(request.region, truth.map.crs)};
  if (!options.merge.empty()) comparison.merge = read_merge_table(options.merge);
  std::optional<ConfidenceMap> confidence;
  if (!options.confidence.empty()) confidence = read_confidence_of(options.confidence, prediction);

  const LabelComparisonView view = compare(prediction, truth.map, comparison, options.merge);
  const LabelScores scores = evaluate_labels(view, {.confidence = confidence ? &*confidence : nullptr});
  const std::vector<PieceScores> pieces = evaluate_pieces(view, truth.pieces);
  if (!options.page.empty())
    write_label_page(options.page, {.scored = request.scored.filename().string(),
                                    .truth = request.truth.filename().string(),
                                    .photo_on = photo_reader(options.photo, view.crs()),
                                    .photo_name = options.photo.string(),
                                    .view = view,
                                    .scores = scores,
                                    .pieces = pieces,
                                    .piece_map = truth.pieces,
                                    .merge = comparison.merge,
                                    .encoders = {.jpeg = io::encode_jpeg, .png = io::encode_png}});
  ScoreJson json = to_json(scores);
  if (!comparison.merge.empty()) json["merged"] = comparison.merge;
  if (!pieces.empty()) add_pieces(json, pieces);
  return json;
}

ScoreJson score_labels(const ScoreRequest& request) { return score_labels(request, LabelScoreOptions{}); }

namespace {
RoadNetwork in_crs(RoadNetwork roads, const Crs& crs) {
  if (roads.crs == crs) return roads;
  const CoordinateTransform there(roads.crs, crs);
  for (RoadPath& path : roads.paths)
    for (RoadNode& node : path.nodes) node.p = there.target_from_source(node.p);
  roads.crs = crs;
  return roads;
}
}  // namespace

ScoreJson score_roads(const ScoreRequest& request, const RoadScoreOptions& options) {
  if (!options.photo.empty() && options.overlay.empty())
    throw OptionError("--photo is shown in the picture of --overlay; give both");
  const RoadNetwork roads = read_scored_roads(request.scored, request.truth);
  const RoadTruth truth = read_road_truth(request.truth, roads.crs);
  const ScoreRegion region = read_region(request.region, roads.crs);
  std::optional<RoadNetwork> before;
  if (!options.before.empty()) before = in_crs(read_scored_roads(options.before, request.truth), roads.crs);
  const RoadScores scores = evaluate_roads(roads, truth, {.region = region, .before = before ? &*before : nullptr});
  if (!options.overlay.empty()) write_road_overlay(options.overlay, options.photo, {roads, truth, region, scores});
  if (!options.layers.empty()) write_road_layers(options.layers, {roads, truth, region, scores});
  return to_json(scores);
}

ScoreJson score_roads(const ScoreRequest& request) { return score_roads(request, RoadScoreOptions{}); }

namespace {
Box2 bounds_of_roads(const RoadNetwork& roads) {
  Ring points;
  for (const RoadPath& path : roads.paths)
    for (const RoadNode& node : path.nodes) points.push_back(node.p);
  return bounds_of(points);
}

}  // namespace

ScoreJson score_heights(const ScoreRequest& request) {
  const RoadNetwork roads = io::read_roads(request.scored);
  const auto has_height = [](const RoadNode& node) { return !std::isnan(node.z_m); };
  if (std::none_of(roads.paths.begin(), roads.paths.end(),
                   [&](const RoadPath& path) { return std::any_of(path.nodes.begin(), path.nodes.end(), has_height); }))
    throw InputError(request.scored.string(), "its roads have no heights; run `orthodrive elevate` first");
  const ScoreRegion region = read_region(request.region, roads.crs);
  const fs::path truth = inside_folder(request.truth, "roads.gpkg");
  if (is_vector_file(truth)) return to_json(evaluate_heights(roads, io::read_roads(truth), region));
  constexpr double margin_m = 50.0;  // gradient and banking look beyond the nodes
  const HeightGrid terrain = io::read_heights(truth, roads.crs, bounds_of_roads(roads).grown(margin_m));
  return to_json(evaluate_heights(roads, terrain, region));
}

ScoreJson score_network(const ScoreRequest& request, const NetworkScoreOptions& options) {
  if (!fs::exists(request.scored)) throw InputError(request.scored.string(), "no such file");
  const roadquery::RoadMap map = roadquery::read_opendrive(request.scored.string());
  const bool placed = !options.findings.empty() || !options.layers.empty();
  if (placed && map.geo_reference.empty())
    throw InputError(request.scored.string(), "has no geoReference, so nobody knows where on Earth its places lie");
  ScoreJson scores = to_json(evaluate_network(map));
  const JudgeNetworkOptions judging{.threads = options.threads};
  const NetworkVerdict verdict = judge_network(map, judging);
  scores["verdict"] = to_json(verdict, judging.limits);
  scores["faults"] = faults_json(verdict);
  if (!options.findings.empty()) io::write_findings(options.findings, findings_of(verdict), {map.geo_reference});
  if (!options.layers.empty()) write_verdict_layers(options.layers, verdict, {map.geo_reference});
  return scores;
}
ScoreJson score_network(const ScoreRequest& request) { return score_network(request, {}); }

ScoreJson score_scene(const ScoreRequest& request) {
  if (!fs::exists(request.truth)) throw InputError(request.truth.string(), "no such file");
  roadquery::RoadMap map = roadquery::read_opendrive(request.truth.string());
  roadquery::remove_lane_heights(map);
  const roadquery::RoadQuery roads(std::move(map));
  SceneScorer scorer(roads);
  for (const io::TileFile& file : io::read_tileset(request.scored))
    scorer.add(file.level == 0 ? io::read_tile_glb(file) : SceneTile{.level = file.level}, file.bytes);
  return to_json(scorer.finish());
}

ScoreJson score_site(const ScoreRequest& request) {
  if (!fs::is_directory(request.scored))
    throw InputError(request.scored.string(), "no such folder; give the output folder of `orthodrive build`");
  if (!fs::is_directory(request.truth))
    throw InputError(request.truth.string(), "no such folder; give a truth folder as `orthodrive synth` makes it");
  const auto part = [&](const char* ours, ScoreJson (*score)(const ScoreRequest&)) {
    return score({request.scored / ours, request.truth, request.region});
  };
  ScoreJson scores;
  if (fs::exists(request.truth / "labels.tif")) scores["labels"] = part("labels.tif", score_labels);
  scores["roads"] = part("roads.gpkg", score_roads);
  if (fs::exists(request.truth / "roads.gpkg")) scores["heights"] = part("roads.gpkg", score_heights);
  scores["network"] = part("roads.xodr", score_network);
  return scores;
}

}  // namespace orthodrive
