#include "orthodrive/pipeline/score.hpp"

#include <algorithm>
#include <cmath>

#include "orthodrive/core/error.hpp"
#include "orthodrive/io/raster_io.hpp"
#include "orthodrive/io/vector_io.hpp"

namespace orthodrive {
namespace fs = std::filesystem;

ScoreJson score_labels(const ScoreRequest& request) {
  const LabelMap prediction = io::read_labels(request.scored);
  const auto truth = read_label_truth(inside_folder(request.truth, "labels.tif"), prediction);
  if (const auto* roads = std::get_if<MultiPolygon>(&truth))
    return to_json(evaluate_road_role(prediction, *roads, read_region(request.region, prediction.crs)));
  const LabelMap& map = std::get<LabelMap>(truth);
  return to_json(evaluate_labels(prediction, map, read_region(request.region, map.crs)));
}

ScoreJson score_roads(const ScoreRequest& request) {
  const RoadNetwork roads = read_scored_roads(request.scored, request.truth);
  return to_json(evaluate_roads(roads, read_road_truth(request.truth, roads.crs),
                                {.region = read_region(request.region, roads.crs)}));
}

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

ScoreJson score_network(const ScoreRequest& request) {
  if (!fs::exists(request.scored)) throw InputError(request.scored.string(), "no such file");
  return to_json(evaluate_network(roadquery::read_opendrive(request.scored.string())));
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
