// orthodrive evaluate: scores against truth.

#include <fmt/format.h>

#include <memory>

#include "commands.hpp"
#include "orthodrive/pipeline/score.hpp"

namespace orthodrive::app {
namespace fs = std::filesystem;

namespace {
struct EvaluateCommand {
  ScoreRequest request;
  bool json = false;
};
}  // namespace

void add_evaluate(CLI::App& app, Context&) {
  auto command = std::make_shared<EvaluateCommand>();
  CLI::App* cmd = app.add_subcommand(
      "evaluate", "Score labels, roads, heights, a network or a whole site against truth. Writes nothing.");
  cmd->require_subcommand(1);
  cmd->fallthrough();
  cmd->add_flag("--json", command->json, "print one JSON object on standard output instead of a table");
  cmd->add_option("--area", command->request.region.area,
                  "polygons (GeoJSON, GeoPackage, any CRS) that limit the score; default: everywhere");
  cmd->add_option("--ignore", command->request.region.ignore, "polygons taken out of the score");
  cmd->footer(
      "Examples:\n  orthodrive evaluate labels out/labels.tif site/truth/labels.tif\n"
      "  orthodrive evaluate site out --truth site/truth --json");

  const auto add = [&](const char* name, const char* purpose, const char* footer,
                       ScoreJson (*score)(const ScoreRequest&)) {
    CLI::App* kind = cmd->add_subcommand(name, purpose);
    kind->footer(footer);
    kind->callback([command, score] {
      const ScoreJson scores = score(command->request);
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
  positional(labels, "PRED", command->request.scored, "label map (GeoTIFF with class table)");
  positional(labels, "TRUTH", command->request.truth,
             "label raster, polygons with `class`, polygons with a road `kind`, or a truth folder");

  CLI::App* roads = add(
      "roads", "Surface overlap, offset and width of roads, in metres.",
      "offset_m: from each truth centre line across to the nearest road line, every 2 m, within 15 m and 30 degrees.\n"
      "sigma_coverage: share of the offsets (and widths) within 1 and 2 stated sigma; 0.68 and 0.95 would be right.\n"
      "Examples:\n  orthodrive evaluate roads out/roads.gpkg site/truth\n"
      "  orthodrive evaluate roads site/roads.osm site/truth --json",
      score_roads);
  positional(roads, "ROADS", command->request.scored,
             "roads.gpkg; or .osm, .osm.pbf: as it is, with default widths, in the box of the truth");
  positional(roads, "TRUTH", command->request.truth,
             "polygons (id) and centre lines (of) in GeoJSON or GeoPackage, a true roads.gpkg, or a truth folder");

  CLI::App* heights = add("heights", "Errors of z (m), gradient (dz/ds) and banking (rad) at the nodes of roads.",
                          "A terrain model has no decks: with one as truth, bridges and tunnels are left out.\n"
                          "Examples:\n  orthodrive evaluate heights out/roads.gpkg site/truth/roads.gpkg\n"
                          "  orthodrive evaluate heights out/roads.gpkg dtm_1m.tif --json",
                          score_heights);
  positional(heights, "ROADS", command->request.scored, "roads.gpkg with heights");
  positional(heights, "TRUTH", command->request.truth, "terrain model in metres, a true roads.gpkg, or a truth folder");

  CLI::App* network = add(
      "network", "Size and faults of an OpenDRIVE file: kinks, gaps, clearance, what hangs together.",
      "Examples:\n  orthodrive evaluate network out/roads.xodr\n  orthodrive evaluate network out/roads.xodr --json",
      score_network);
  positional(network, "FILE", command->request.scored, "OpenDRIVE 1.4 - 1.8");

  CLI::App* site = add("site", "All of the above for the output folder of `orthodrive build`.",
                       "Examples:\n  orthodrive evaluate site out --truth site/truth\n  orthodrive evaluate site out "
                       "--truth site/truth --json",
                       score_site);
  positional(site, "DIR", command->request.scored, "output folder of `orthodrive build`");
  site->add_option("--truth", command->request.truth,
                   "folder with labels.tif, roads.gpkg or surface.geojson, as `orthodrive synth` makes it")
      ->required();
}

}  // namespace orthodrive::app
