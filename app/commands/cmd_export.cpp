// SPDX-License-Identifier: Apache-2.0
// orthodrive export: the scene of an area in one file, for programs that are no viewers.

#include <memory>
#include <vector>

#include "commands.hpp"
#include "load_runs.hpp"
#include "scene_inputs.hpp"
#include "stage_output.hpp"

namespace orthodrive::app {
namespace {
struct ExportCommand {
  SceneFiles files;
  ExportOptions options;
  std::vector<double> bounds;
  IdleOptions idle;
};
}  // namespace

void add_export(CLI::App& app, Context& context) {
  auto command = std::make_shared<ExportCommand>();
  CLI::App* cmd = app.add_subcommand("export", "Write the scene of an area as one .glb, for Blender and game engines.");
  add_scene_inputs(*cmd, command->files, command->idle);
  cmd->add_option("--bbox", command->bounds, "west south east north of the area in the CRS of the roads, m; none: all")
      ->expected(4);
  cmd->add_option("--glb", command->options.glb, "file to write")->required();
  cmd->footer(
      "Reads what `orthodrive scene` reads; writes one .glb with everything in it: full detail, plain floats, "
      "materials\n"
      "that are lit, a node for each tile, each tree a node. The summary names the origin of its coordinates.\n"
      "Memory: the photo (4 bytes a pixel) and some 20 MB a tile.\n"
      "Examples:\n"
      "  orthodrive export --network roads.xodr --photo ortho.jpg --dtm dtm.tif --bbox 322000 6394000 322500 6394500 "
      "--glb area.glb\n"
      "  orthodrive export --network roads.xodr --labels labels.tif --photo ortho.jpg --dtm dtm.tif --buildings "
      "map.osm "
      "--glb all.glb");
  cmd->callback([command, &context] {
    command->idle.refuse();
    if (const auto& b = command->bounds; !b.empty()) {
      if (!(b[0] < b[2] && b[1] < b[3])) throw OptionError("--bbox: west must be below east, south below north");
      command->options.bounds = Box2{b[0], b[1], b[2], b[3]};
    }
    StageContext stage = stage_context(context);
    print_outcome(runs().run_export(command->files, command->options, stage), stage);
  });
}

}  // namespace orthodrive::app
