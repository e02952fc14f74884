// SPDX-License-Identifier: Apache-2.0
// orthodrive evaluate: scores against truth.

#include <fmt/format.h>

#include <functional>
#include <memory>

#include "commands.hpp"
#include "idle_options.hpp"
#include "load_runs.hpp"
#include "orthodrive/core/error.hpp"

namespace orthodrive::app {
namespace fs = std::filesystem;

namespace {
struct EvaluateCommand {
  ScoreRequest request;
  LabelScoreOptions label_options;
  RoadScoreOptions road_options;
  NetworkScoreOptions network_options;
  SceneScoreOptions scene_options;
  bool strict = false;
  bool json = false;
  IdleOptions idle;
};
using Command = std::shared_ptr<EvaluateCommand>;
using Score = std::function<ScoreJson(const EvaluateCommand&)>;

/// A kind of score, as a sub-command of its own.
CLI::App* add_kind(CLI::App* cmd, const Command& command, const char* name, const char* purpose, const char* footer,
                   const Score& score) {
  CLI::App* kind = cmd->add_subcommand(name, purpose);
  kind->footer(footer);
  kind->callback([command, score] {
    command->idle.refuse();
    const ScoreJson scores = score(*command);
    fmt::print("{}", command->json ? scores.dump(2) + "\n" : runs().to_table(scores));
    if (command->strict && !scores.at("verdict").at("pass").get<bool>())
      throw Error(fmt::format("{}: the verdict is fail, {} places are over a limit", command->request.scored.string(),
                              scores.at("faults").size()));
  });
  return kind;
}
Score of_files(ScoreJson (*Runs::*score)(const ScoreRequest&)) {
  return [score](const EvaluateCommand& c) { return (runs().*score)(c.request); };
}
void positional(CLI::App* kind, const char* name, fs::path& path, const char* text) {
  kind->add_option(name, path, text)->required();
}

void add_region(CLI::App* kind, const Command& command) {
  kind->add_option("--area", command->request.region.area,
                   "polygons (GeoJSON, GeoPackage, any CRS) that limit the score; default: everywhere");
  kind->add_option("--ignore", command->request.region.ignore, "polygons taken out of the score");
}

void add_labels(CLI::App* cmd, const Command& command) {
  CLI::App* labels = add_kind(
      cmd, command, "labels", "Accuracy, intersection over union, confusion and calibration of a label map.",
      "Compares at the truth's pixel centres; classes are matched by name. Of polygons with `class` later ones cover "
      "earlier ones, the class `unknown` is not scored, and each `piece` is scored on its own as well. Polygons "
      "without `class` score the road role.\n"
      "mean_iou counts a class that is predicted but absent from the truth as 0; mean_iou_of_truth_classes leaves it "
      "out. A class absent from both is in neither.\n"
      "Needs up to 6 bytes a pixel.\n"
      "Examples:\n  orthodrive evaluate labels out/labels.tif site/truth/labels.tif\n"
      "  orthodrive evaluate labels out/labels.tif carriageways.geojson --area box.geojson --json\n"
      "  orthodrive evaluate labels labels.tif truth.geojson --html page --photo ortho.tif --confidence "
      "confidence.tif\n"
      "  orthodrive evaluate labels labels.tif truth.tif --merge models/classes/merge_38_to_32.toml",
      [](const EvaluateCommand& c) { return runs().score_labels(c.request, c.label_options); });
  positional(labels, "PRED", command->request.scored, "label map (GeoTIFF with class table)");
  positional(labels, "TRUTH", command->request.truth,
             "label raster, polygons with `class`, polygons with a road `kind`, or a truth folder");
  add_region(labels, command);
  labels->add_option("--merge", command->label_options.merge,
                     "TOML file of lines old = \"new\": classes taken together before counting");
  labels->add_option("--confidence", command->label_options.confidence,
                     "probability of each label (0..255) as `segment --confidence` writes it: adds the calibration");
  CLI::Option* html =
      labels->add_option("--html", command->label_options.page,
                         "write a page with tables, confusion matrix and error pictures; a folder gets labels.html");
  command->idle.needs(labels->add_option("--photo", command->label_options.photo,
                                         "orthophoto in grey under the error pictures of the page"),
                      {html});
}

void add_roads(CLI::App* cmd, const Command& command) {
  CLI::App* roads = add_kind(
      cmd, command, "roads", "Surface overlap, offset and width of roads, in metres.",
      "offset_m: from each truth centre line across to the nearest road line, every 2 m, within 15 m and 30 degrees.\n"
      "sigma_coverage: share of the offsets (and widths) within 1 and 2 stated sigma; 0.68 and 0.95 would be right.\n"
      "width_variance_m2: of the width along a path, mean over the paths. largest_curvature_jump: 1/m, over 4 m of a "
      "path, with its place; mean_per_m: mean over the paths.\n"
      "edge_m: of both edges there. length_m: of our lines inside the area.\n"
      "surface_iou_of_known_ways (with --before): without ways that ran along no truth line before refinement.\n"
      "moved_away (with --before): share of the places on truth lines from which the road is further away than "
      "before.\n"
      "Examples:\n  orthodrive evaluate roads out/roads.gpkg site/truth\n"
      "  orthodrive evaluate roads site/roads.osm site/truth --json\n"
      "  orthodrive evaluate roads out/roads.gpkg site/truth --before site/roads.osm --overlay errors.png --photo "
      "site/ortho.tif --layers errors.gpkg",
      [](const EvaluateCommand& c) { return runs().score_roads(c.request, c.road_options); });
  positional(roads, "ROADS", command->request.scored,
             "roads.gpkg; or .osm, .osm.pbf: as it is, with default widths, in the box of the truth");
  positional(roads, "TRUTH", command->request.truth,
             "polygons (id) and centre lines (of) in GeoJSON or GeoPackage, a true roads.gpkg, or a truth folder");
  add_region(roads, command);
  roads->add_option("--before", command->road_options.before,
                    "the roads before refinement, in the forms of ROADS: adds moved_away");
  CLI::Option* overlay = roads->add_option(
      "--overlay", command->road_options.overlay,
      "write a PNG: road surface that is right yellow, ours alone red, the truth's alone blue; 0.25 m a pixel, coarser "
      "above 4000 pixels");
  command->idle.needs(roads->add_option("--photo", command->road_options.photo, "orthophoto in grey under the overlay"),
                      {overlay});
  roads->add_option("--layers", command->road_options.layers,
                    "write a GeoPackage: layers false_positive, false_negative, truth_lines, truth_samples");
}

void add_heights(CLI::App* cmd, const Command& command) {
  CLI::App* heights =
      add_kind(cmd, command, "heights", "Errors of z (m), gradient (dz/ds) and banking (rad) at the nodes of roads.",
               "A terrain model has no decks: with one as truth, bridges and tunnels are left out.\n"
               "gradient_energy: E_RG, height_error_energy: E_h of the thesis (eq. 3.13, 3.12); "
               "gradient_error_energy: mean squared difference to the true gradient.\n"
               "sigma_coverage: share of the heights within 1 and 2 stated sigma; 0.68 and 0.95 would be right.\n"
               "largest_kink: jump of dz/ds along ways; largest_junction_kink: of a road from the common plane of "
               "a junction; largest_step_m: between ways that share a node. With the place.\n"
               "min_clearance_m: at the crossings on two levels; level_crossings: the other ones.\n"
               "Examples:\n  orthodrive evaluate heights out/roads.gpkg site/truth/roads.gpkg\n"
               "  orthodrive evaluate heights out/roads.gpkg dtm_1m.tif --json",
               of_files(&Runs::score_heights));
  positional(heights, "ROADS", command->request.scored, "roads.gpkg with heights");
  positional(heights, "TRUTH", command->request.truth, "terrain model in metres, a true roads.gpkg, or a truth folder");
  add_region(heights, command);
}

void add_network(CLI::App* cmd, const Command& command, const Context& context) {
  CLI::App* network = add_kind(
      cmd, command, "network", "Size and faults of an OpenDRIVE file: kinks, gaps, clearance, what hangs together.",
      "verdict: both wheel tracks of every driving lane are followed through every link; what a tyre feels there is "
      "held "
      "against limits (docs/evaluate.md). `faults` lists the places that fail.\n"
      "Exit code 1 where the verdict is fail and --strict is given, else 0.\n"
      "Examples:\n  orthodrive evaluate network out/roads.xodr\n  orthodrive evaluate network out/roads.xodr --json\n"
      "  orthodrive evaluate network out/roads.xodr --strict --findings faults.geojson --layers faults.gpkg",
      [&context](const EvaluateCommand& c) {
        NetworkScoreOptions options = c.network_options;
        options.threads = context.threads;
        return runs().score_network(c.request, options);
      });
  network->add_flag("--strict", command->strict, "exit code 1 when the verdict is fail");
  network->add_option("--findings", command->network_options.findings,
                      "write the places that fail as GeoJSON points (WGS84)");
  network->add_option("--layers", command->network_options.layers,
                      "write them as a GeoPackage, a layer a kind of fault");
  positional(network, "FILE", command->request.scored, "OpenDRIVE 1.4 - 1.8");
}

void add_scene(CLI::App* cmd, const Command& command) {
  CLI::App* scene = add_kind(
      cmd, command, "scene", "Cracks, roads beside their surface and things on roads, in the tiles of a scene.",
      "open_edges: of ground, roads and decks, within tiles and between them, besides the scene's outer border.\n"
      "road_error_m: of middles of road triangles and of their edges from the surface that is driven.\n"
      "on_road: vertices of buildings, trees, barriers and the like over a road, by up to 4.5 m; in_building: those "
      "of\n"
      "trees, barriers, lamps and objects inside buildings.\n"
      "texture: with --photo, how far the tiles' pictures lie from it, in texels: the worst of windows of 48 texels.\n"
      "Examples:\n  orthodrive evaluate scene out/scene out/roads.xodr\n"
      "  orthodrive evaluate scene out/scene out/roads.xodr --photo ortho.tif --json",
      [](const EvaluateCommand& c) { return runs().score_scene(c.request, c.scene_options); });
  scene->add_option("--photo", command->scene_options.photo, "orthophoto that the tiles were made of");
  positional(scene, "DIR", command->request.scored, "folder of `orthodrive scene`");
  positional(scene, "NETWORK", command->request.truth, "the roads that it was made of (OpenDRIVE)");
}

void add_site(CLI::App* cmd, const Command& command) {
  CLI::App* site =
      add_kind(cmd, command, "site", "All of the above for the output folder of `orthodrive build`.",
               "Examples:\n  orthodrive evaluate site out --truth site/truth\n  orthodrive evaluate site out "
               "--truth site/truth --json",
               of_files(&Runs::score_site));
  positional(site, "DIR", command->request.scored, "output folder of `orthodrive build`");
  site->add_option("--truth", command->request.truth,
                   "folder with labels.tif, roads.gpkg or surface.geojson, as `orthodrive synth` makes it")
      ->required();
  add_region(site, command);
}

}  // namespace

void add_evaluate(CLI::App& app, Context& context) {
  auto command = std::make_shared<EvaluateCommand>();
  CLI::App* cmd = app.add_subcommand(
      "evaluate",
      "Score labels, roads, heights, a network or a whole site against truth. Writes nothing but what --html, "
      "--overlay and --layers name.");
  cmd->require_subcommand(1);
  cmd->fallthrough();
  cmd->add_flag("--json", command->json, "print one JSON object on standard output instead of a table");
  cmd->footer(
      "Examples:\n  orthodrive evaluate labels out/labels.tif site/truth/labels.tif\n"
      "  orthodrive evaluate site out --truth site/truth --json");
  add_labels(cmd, command);
  add_roads(cmd, command);
  add_heights(cmd, command);
  add_network(cmd, command, context);
  add_scene(cmd, command);
  add_site(cmd, command);
}

}  // namespace orthodrive::app
