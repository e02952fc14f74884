// SPDX-License-Identifier: Apache-2.0
#pragma once
// The options of the commands that build a scene: what it is built from.

#include "commands.hpp"
#include "idle_options.hpp"
#include "orthodrive/pipeline/stages/run_scene.hpp"

namespace orthodrive::app {

/// `files` outlives `cmd`. Returns --photo.
inline CLI::Option* add_scene_inputs(CLI::App& cmd, SceneFiles& files, IdleOptions& idle) {
  cmd.add_option("--network", files.network, "roads (OpenDRIVE); their geoReference is the scene's CRS")->required();
  cmd.add_option("--roads", files.chosen_roads,
                 "only these roads are cut into the ground, the others stay as the photo shows them: names, ids of "
                 "roads, way/ID of OSM ways, highway/CLASS; with commas")
      ->delimiter(',');
  cmd.add_option("--bare-width", files.bare_width_m, "of roads that are a reference line without lanes, m")
      ->check(CLI::Range(2.0, 100.0))
      ->capture_default_str();
  CLI::Option* photo = cmd.add_option(
      "--photo", files.photos,
      "orthophoto (any GDAL raster): texture and extent; may be repeated, best first; none: the ground is drawn in "
      "plain colours, around the roads");
  idle.needs(cmd.add_option("--labels", files.labels,
                            "label map of that photo: its classes become feature ids of the tiles; trees, and "
                            "buildings that maps lack"),
             {photo});
  cmd.add_option("--dtm", files.dtm,
                 "bare-earth terrain model, best first; later ones fill its holes; none: the ground follows the roads");
  cmd.add_option("--buildings", files.buildings,
                 "maps with building=* (.osm, .osm.pbf, GeoJSON, GeoPackage); labels show what they lack");
  cmd.add_option("--trees", files.trees, "maps with natural=tree and natural=tree_row; labels show what they lack");
  cmd.add_option("--surroundings", files.surroundings, "maps with barrier=*, water, railways and street lamps");
  return photo;
}

}  // namespace orthodrive::app
