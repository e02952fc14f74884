// orthodrive evaluate: scores against truth.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "commands.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/io/raster_io.hpp"
#include "orthodrive/io/vector_io.hpp"
#include "score_files.hpp"
#include "score_output.hpp"

namespace orthodrive::app {
namespace fs = std::filesystem;

namespace {
struct EvaluateCommand {
  fs::path scored, truth;
  RegionFiles region;
  bool json = false;
};

ScoreJson score_labels(const EvaluateCommand& command) {
  const LabelMap prediction = io::read_labels(command.scored);
  const auto truth = read_label_truth(inside_folder(command.truth, "labels.tif"), prediction);
  if (const auto* roads = std::get_if<MultiPolygon>(&truth))
    return to_json(evaluate_road_role(prediction, *roads, read_region(command.region, prediction.crs)));
  const LabelMap& map = std::get<LabelMap>(truth);
  return to_json(evaluate_labels(prediction, map, read_region(command.region, map.crs)));
}

ScoreJson score_roads(const EvaluateCommand& command) {
  const RoadNetwork roads = read_scored_roads(command.scored, command.truth);
  return to_json(evaluate_roads(roads, read_road_truth(command.truth, roads.crs),
                                {.region = read_region(command.region, roads.crs)}));
}

Box2 bounds_of_roads(const RoadNetwork& roads) {
  Ring points;
  for (const RoadPath& path : roads.paths)
    for (const RoadNode& node : path.nodes) points.push_back(node.p);
  return bounds_of(points);
}

ScoreJson score_heights(const EvaluateCommand& command) {
  const RoadNetwork roads = io::read_roads(command.scored);
  const auto has_height = [](const RoadNode& node) { return !std::isnan(node.z_m); };
  if (std::none_of(roads.paths.begin(), roads.paths.end(),
                   [&](const RoadPath& path) { return std::any_of(path.nodes.begin(), path.nodes.end(), has_height); }))
    throw InputError(command.scored.string(), "its roads have no heights; run `orthodrive elevate` first");
  const ScoreRegion region = read_region(command.region, roads.crs);
  const fs::path truth = inside_folder(command.truth, "roads.gpkg");
  if (is_vector_file(truth)) return to_json(evaluate_heights(roads, io::read_roads(truth), region));
  constexpr double margin_m = 50.0;  // gradient and banking look beyond the nodes
  const HeightGrid terrain = io::read_heights(truth, roads.crs, bounds_of_roads(roads).grown(margin_m));
  return to_json(evaluate_heights(roads, terrain, region));
}

ScoreJson score_network(const EvaluateCommand& command) {
  if (!fs::exists(command.scored)) throw InputError(command.scored.string(), "no such file");
  return to_json(evaluate_network(roadquery::read_opendrive(command.scored.string())));
}

/// What of a built site the truth folder knows about.
ScoreJson score_site(const EvaluateCommand& command) {
  if (!fs::is_directory(command.scored))
    throw InputError(command.scored.string(), "no such folder; give the output folder of `orthodrive build`");
  if (!fs::is_directory(command.truth))
    throw InputError(command.truth.string(), "no such folder; give a truth folder as `orthodrive synth` makes it");
  const auto part = [&](const char* ours, ScoreJson (*score)(const EvaluateCommand&)) {
    return score({command.scored / ours, command.truth, command.region});
  };
  ScoreJson scores;
  if (fs::exists(command.truth / "labels.tif")) scores["labels"] = part("labels.tif", score_labels);
  scores["roads"] = part("roads.gpkg", score_roads);
  if (fs::exists(command.truth / "roads.gpkg")) scores["heights"] = part("roads.gpkg", score_heights);
  scores["network"] = part("roads.xodr", score_network);
  return scores;
}
}  // namespace

void add_evaluate(CLI::App& app, Context&) {
  auto command = std::make_shared<EvaluateCommand>();
  CLI::App* cmd = app.add_subcommand(
      "evaluate", "Score labels, roads, heights, a network or a whole site against truth. Writes nothing.");
  cmd->require_subcommand(1);
  cmd->fallthrough();
  cmd->add_flag("--json", command->json, "print one JSON object on standard output instead of a table");
  cmd->add_option("--area", command->region.area,
                  "polygons (GeoJSON, GeoPackage, any CRS) that limit the score; default: everywhere");
  cmd->add_option("--ignore", command->region.ignore, "polygons taken out of the score");
  cmd->footer(
      "Examples:\n  orthodrive evaluate labels out/labels.tif site/truth/labels.tif\n"
      "  orthodrive evaluate site out --truth site/truth --json");

  const auto add = [&](const char* name, const char* purpose, const char* footer,
                       ScoreJson (*score)(const EvaluateCommand&)) {
    CLI::App* kind = cmd->add_subcommand(name, purpose);
    kind->footer(footer);
    kind->callback([command, score] {
      const ScoreJson scores = score(*command);
      fmt::print("{}", command->json ? scores.dump(2) + "\n" : to_table(scores));
    });
    return kind;
  };
  const auto positional = [&](CLI::App* kind, const char* name, fs::path& path, const char* text) {
    kind->add_option(name, path, text)->required();
  };

  CLI::App* labels = add("labels", "Pixel accuracy and intersection over union of a label map.",
                         "Compares at the truth's pixel centres; classes are matched by name. Polygons without `class` "
                         "score the road role.\n"
                         "Examples:\n  orthodrive evaluate labels out/labels.tif site/truth/labels.tif\n"
                         "  orthodrive evaluate labels out/labels.tif carriageways.geojson --area box.geojson --json",
                         score_labels);
  positional(labels, "PRED", command->scored, "label map (GeoTIFF with class table)");
  positional(labels, "TRUTH", command->truth,
             "label raster, polygons with `class`, polygons with a road `kind`, or a truth folder");

  CLI::App* roads = add(
      "roads", "Surface overlap, offset and width of roads, in metres.",
      "offset_m: from each truth centre line across to the nearest road line, every 2 m, within 15 m and 30 degrees.\n"
      "sigma_coverage: share of the offsets (and widths) within 1 and 2 stated sigma; 0.68 and 0.95 would be right.\n"
      "Examples:\n  orthodrive evaluate roads out/roads.gpkg site/truth\n"
      "  orthodrive evaluate roads site/roads.osm site/truth --json",
      score_roads);
  positional(roads, "ROADS", command->scored,
             "roads.gpkg; or .osm, .osm.pbf: as it is, with default widths, in the box of the truth");
  positional(roads, "TRUTH", command->truth,
             "polygons (id) and centre lines (of) in GeoJSON or GeoPackage, a true roads.gpkg, or a truth folder");

  CLI::App* heights = add("heights", "Errors of z (m), gradient (dz/ds) and banking (rad) at the nodes of roads.",
                          "A terrain model has no decks: with one as truth, bridges and tunnels are left out.\n"
                          "Examples:\n  orthodrive evaluate heights out/roads.gpkg site/truth/roads.gpkg\n"
                          "  orthodrive evaluate heights out/roads.gpkg dtm_1m.tif --json",
                          score_heights);
  positional(heights, "ROADS", command->scored, "roads.gpkg with heights");
  positional(heights, "TRUTH", command->truth, "terrain model in metres, a true roads.gpkg, or a truth folder");

  CLI::App* network = add(
      "network", "Size and faults of an OpenDRIVE file: kinks, gaps, clearance, what hangs together.",
      "Examples:\n  orthodrive evaluate network out/roads.xodr\n  orthodrive evaluate network out/roads.xodr --json",
      score_network);
  positional(network, "FILE", command->scored, "OpenDRIVE 1.4 - 1.8");

  CLI::App* site = add("site", "All of the above for the output folder of `orthodrive build`.",
                       "Examples:\n  orthodrive evaluate site out --truth site/truth\n  orthodrive evaluate site out "
                       "--truth site/truth --json",
                       score_site);
  positional(site, "DIR", command->scored, "output folder of `orthodrive build`");
  site->add_option("--truth", command->truth,
                   "folder with labels.tif, roads.gpkg or surface.geojson, as `orthodrive synth` makes it")
      ->required();
}

}  // namespace orthodrive::app
