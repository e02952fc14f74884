// SPDX-License-Identifier: Apache-2.0
// orthodrive scene: textured terrain with the roads cut in, as 3D Tiles.

#include <memory>

#include "choice_option.hpp"
#include "commands.hpp"
#include "load_runs.hpp"
#include "scene_inputs.hpp"
#include "stage_output.hpp"

namespace orthodrive::app {
namespace {
struct SceneCommand {
  SceneFiles files;
  RunSceneOptions options;
  IdleOptions idle;
};
}  // namespace

void add_scene(CLI::App& app, Context& context) {
  auto command = std::make_shared<SceneCommand>();
  CLI::App* cmd = app.add_subcommand("scene", "Cut the roads into the terrain and write textured 3D Tiles.");
  const CLI::Option* photo = add_scene_inputs(*cmd, command->files, command->idle);
  cmd->add_option("-o,--output", command->files.folder, "folder for tileset.json and *.glb; replaced when all is done")
      ->required();
  cmd->add_option("--terrain-grid", command->files.terrain_grid,
                  "write the terrain, holes filled, as an ESRI ASCII grid for the road query of simulators");
  SceneOptions& o = command->options.scene;
  command->idle.excludes(
      cmd->add_option("--margin", command->options.margin_m, "without a photo: ground around the roads, m")
          ->check(CLI::Range(20.0, 5000.0))
          ->capture_default_str(),
      {photo});
  cmd->add_option("--terrain-step", o.terrain_step_m, "distance of terrain vertices, m")->capture_default_str();
  cmd->add_option("--verge", o.verge_m, "width of the strip from a road's edge to the DTM, m")->capture_default_str();
  cmd->add_option("--max-texture", o.max_texture_px, "texture pixels along a tile's side")->capture_default_str();
  add_choice<io::PhotoFormat>(*cmd, "--photo-format", command->options.files.photo,
                              {{"jpeg", io::PhotoFormat::jpeg}, {"webp", io::PhotoFormat::webp}},
                              "of the photo in the tiles: jpeg or webp");
  cmd->add_flag_callback(
      "--uncompressed", [command] { command->options.files.compressed = false; },
      "plain floats, for readers without EXT_meshopt_compression");
  cmd->footer(
      "Reads roads, photo and terrain, or roads alone; writes DIR/tileset.json (3D Tiles 1.1) and one .glb for each "
      "480 m tile\n"
      "and for each tile of the coarser levels.\n"
      "Memory: the roads (about 5 MB a km2 of town) and two blocks of 3.7 km2 (some 250 MB each), whatever the photo.\n"
      "Examples:\n"
      "  orthodrive scene --network any.xodr -o landscape/scene\n"
      "  orthodrive scene --network out/roads.xodr --labels out/labels.tif --photo ortho.tif --dtm dtm.tif -o "
      "out/scene\n"
      "  orthodrive scene --network roads.xodr --photo ortho.jpg --dtm dtm_1m.tif --dtm dtm_10m.tif --max-texture 1024 "
      "-o scene\n"
      "  orthodrive scene --network roads.xodr --photo ortho.jpg --dtm dtm.tif --roads way/26182390 -o one_road");
  cmd->callback([command, &context] {
    command->idle.refuse();
    StageContext stage = stage_context(context);
    print_outcome(runs().run_scene(command->files, command->options, stage), stage);
  });
}

}  // namespace orthodrive::app
