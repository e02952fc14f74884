// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/pipeline/score/score.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <ranges>

#include "orthodrive/core/atomic_file.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/evaluate/scenes/texture_position.hpp"
#include "orthodrive/io/raster/raster_io.hpp"
#include "orthodrive/io/support/vector_io.hpp"
#include "orthodrive/io/tiles/tile_reader.hpp"
#include "orthodrive/pipeline/files/read_network.hpp"
#include "orthodrive/pipeline/score/network_verdict.hpp"
#include "orthodrive/pipeline/score/road_layers.hpp"
#include "orthodrive/report/label_report.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace orthodrive {
namespace fs = std::filesystem;

namespace {
void check_options(const LabelScoreOptions& options, bool truth_has_classes) {
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
LabelComparisonView compare_labels(const LabelMap& prediction, const LabelMap& truth,
                                   const ComparisonOptions& comparison, const fs::path& merge_file) {
  try {
    return {prediction, truth, comparison};
  } catch (const OptionError& error) {
    throw InputError(merge_file.string(), error.what());
  }
}

/// Classes are matched by name: where the prediction's table has none of those that the truth shows, every pixel is
/// wrong, which says nothing of the labels.
void require_common_class(const ClassTable& prediction, const LabelScores& scores, const ScoreRequest& request) {
  std::vector<std::string> shown;
  for (const ClassScore& score : scores.classes) {
    if (score.truth_pixels == 0) continue;
    if (std::ranges::find(prediction.classes, score.info.name, &ClassInfo::name) != prediction.classes.end()) return;
    shown.push_back(score.info.name);
  }
  if (!shown.empty())
    throw InputError(request.scored.string(),
                     fmt::format("has none of the classes of {}: {} here, {} there", request.truth.string(),
                                 fmt::join(prediction.classes | std::views::transform(&ClassInfo::name), ", "),
                                 fmt::join(shown, ", ")));
}

/// Reads the photo piece by piece around what the page shows.
std::function<std::optional<Photo>(const GridFrame&)> photo_reader(const fs::path& file, const Crs& crs) {
  if (file.empty()) return {};
  return [file, crs](const GridFrame& frame) -> std::optional<Photo> {
    try {
      return io::read_photo(file, {crs, polygon_of(frame.bounds())}, {.gsd_m = frame.gsd_m});
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

  const LabelComparisonView view = compare_labels(prediction, truth.map, comparison, options.merge);
  const LabelScores scores = evaluate_labels(view, {.confidence = confidence ? &*confidence : nullptr});
  if (comparison.merge.empty()) require_common_class(prediction.classes, scores, request);
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

namespace {
/// Before anything is scored: places are written as longitudes and latitudes.
void require_place(const fs::path& file, const roadquery::RoadMap& map) {
  const roadquery::PlanPoint at = roadquery::reference_point(map.roads.front(), 0.0);
  try {
    (void)CoordinateTransform(Crs{map.geo_reference}, Crs{"EPSG:4326"}).target_from_source({at.x, at.y});
  } catch (const Error& error) {
    throw InputError(file.string(),
                     fmt::format("has a geoReference that does not place it on Earth ({}); leave --findings and "
                                 "--layers out, or write a PROJ string there",
                                 error.what()));
  }
}
}  // namespace

ScoreJson score_network(const ScoreRequest& request, const NetworkScoreOptions& options) {
  if (!fs::exists(request.scored)) throw InputError(request.scored.string(), "no such file");
  const roadquery::RoadMap map = roadquery::read_opendrive(request.scored.string());
  const bool placed = !options.findings.empty() || !options.layers.empty();
  if (placed && map.geo_reference.empty())
    throw InputError(request.scored.string(), "has no geoReference, so nobody knows where on Earth its places lie");
  if (placed) require_place(request.scored, map);
  ScoreJson scores = to_json(evaluate_network(map));
  for (const Finding& note : reading_findings(map))
    scores["reading"].push_back({{"code", note.code}, {"message", note.message}, {"x", note.x_m}, {"y", note.y_m}});
  const NetworkVerdict verdict = judge_network(map, {.threads = options.threads});
  scores["verdict"] = to_json(verdict);
  scores["faults"] = faults_json(verdict);
  if (!options.findings.empty()) io::write_findings(options.findings, findings_of(verdict), {map.geo_reference});
  if (!options.layers.empty()) write_verdict_layers(options.layers, verdict, {map.geo_reference});
  return scores;
}
ScoreJson score_network(const ScoreRequest& request) { return score_network(request, {}); }

namespace {

/// Brightness of a photo between its own pixels' middles (bilinear), at places of another CRS. Not for two threads.
class PhotoBrightness {
 public:
  PhotoBrightness(const fs::path& file, const Crs& crs)
      : photo_(io::read_placed_image(file)), to_photo_(crs, photo_.crs) {}
  [[nodiscard]] std::optional<double> at(Vec2 p) {
    const Vec2 px = pixel(p) - Vec2{0.5, 0.5};
    const double col = std::floor(px.x), row = std::floor(px.y);
    double sum = 0.0;
    for (int k = 0; k < 4; ++k) {
      const int c = static_cast<int>(col) + k % 2, r = static_cast<int>(row) + k / 2;
      if (!photo_.rgb.inside(c, r)) return std::nullopt;
      const double u = k % 2 == 1 ? px.x - col : 1.0 - (px.x - col), v = k / 2 == 1 ? px.y - row : 1.0 - (px.y - row);
      sum += u * v * (photo_.rgb.at(c, r, 0) + photo_.rgb.at(c, r, 1) + photo_.rgb.at(c, r, 2)) / 3.0;
    }
    return sum;
  }

 private:
  [[nodiscard]] Vec2 pixel_exactly(Vec2 p) const {
    const auto& c = photo_.world_from_pixel;
    const Vec2 from_corner = to_photo_.target_from_source(p) - Vec2{c[0], c[3]};
    const double determinant = c[1] * c[5] - c[2] * c[4];
    return Vec2{c[5] * from_corner.x - c[2] * from_corner.y, c[1] * from_corner.y - c[4] * from_corner.x} *
           (1.0 / determinant);
  }
  /// Linear within cells of 32 m: 0.1 mm from the transform, which takes a hundred times as long.
  [[nodiscard]] Vec2 pixel(Vec2 p) {
    constexpr double cell_m = 32.0;
    const Vec2 cell{std::floor(p.x / cell_m) * cell_m, std::floor(p.y / cell_m) * cell_m};
    if (!(cell.x == cell_.x && cell.y == cell_.y)) {
      cell_ = cell;
      corner_ = pixel_exactly(cell);
      east_ = (pixel_exactly(cell + Vec2{cell_m, 0.0}) - corner_) * (1.0 / cell_m);
      north_ = (pixel_exactly(cell + Vec2{0.0, cell_m}) - corner_) * (1.0 / cell_m);
    }
    return corner_ + east_ * (p.x - cell.x) + north_ * (p.y - cell.y);
  }

  io::PlacedImage photo_;
  CoordinateTransform to_photo_;
  Vec2 cell_{std::nan(""), std::nan("")}, corner_, east_, north_;
};

}  // namespace

ScoreJson score_scene(const ScoreRequest& request, const SceneScoreOptions& options) {
  if (!fs::exists(request.truth)) throw InputError(request.truth.string(), "no such file");
  roadquery::RoadMap map = roadquery::read_opendrive(request.truth.string());
  std::optional<PhotoBrightness> photo;
  if (!options.photo.empty()) {
    if (map.geo_reference.empty())
      throw InputError(request.truth.string(), "has no geoReference, so its place in the photo is unknown");
    photo.emplace(options.photo, Crs{map.geo_reference});
  }
  roadquery::remove_lane_heights(map);
  const roadquery::RoadQuery roads(std::move(map));
  SceneScorer scorer(roads);
  TexturePosition texture;
  for (const io::TileFile& file : io::read_tileset(request.scored)) {
    const SceneTile tile = file.level == 0 ? io::read_tile_glb(file) : SceneTile{.level = file.level};
    scorer.add(tile, file.bytes);
    if (!photo) continue;
    const TexturePosition of_tile = texture_position(tile, [&](Vec2 p) { return photo->at(p); });
    const std::size_t windows = texture.windows + of_tile.windows;
    if (of_tile.error_px > texture.error_px) texture = of_tile;
    texture.windows = windows;
  }
  ScoreJson scores = to_json(scorer.finish());
  if (photo)
    scores["texture"] = {
        {"windows", texture.windows}, {"error_px", texture.error_px}, {"x", texture.at.x}, {"y", texture.at.y}};
  return scores;
}
ScoreJson score_scene(const ScoreRequest& request) { return score_scene(request, {}); }

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
