// orthodrive scene: textured terrain with the roads cut in, as 3D Tiles.

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "commands.hpp"
#include "orthodrive/core/aside_file.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/io/raster_io.hpp"
#include "orthodrive/io/scene_io.hpp"
#include "orthodrive/model/sample_height.hpp"
#include "orthodrive/scene/build_scene.hpp"

namespace orthodrive::app {
namespace {

struct SceneCommand {
  std::filesystem::path network, labels, photo, out;
  std::vector<std::filesystem::path> dtm;
  SceneOptions options;
};

/// The roads' CRS; by the photo's name for it when both are the same.
Crs site_crs(const std::string& network_file, const roadquery::RoadMap& roads, const Crs& photo_crs) {
  if (roads.geo_reference.empty())
    throw InputError(network_file, "has no geoReference, so its place is unknown; write it with `orthodrive network`");
  const Crs crs{roads.geo_reference};
  return proj_string(photo_crs) == proj_string(crs) ? photo_crs : crs;
}

/// The photo on its own grid where it lies in the site CRS, warped otherwise; the area is what it shows.
Photo read_photo_for(const std::filesystem::path& path, const io::RasterInfo& info, SiteFrame& site, int threads) {
  if (site.crs == info.crs) {
    Photo photo = io::read_photo_native(path);
    site.area = photo_outline(photo);
    if (site.area.outer.empty())
      throw InputError(path.string(), "has no valid pixel, give a photo that shows the roads");
    return photo;
  }
  const CoordinateTransform to_geographic(site.crs, Crs{"EPSG:4326"});
  for (const Vec2 p : info.outline_lonlat.outer) site.area.outer.push_back(to_geographic.source_from_target(p));
  return io::read_photo(path, site, {.threads = threads});
}

void run(const SceneCommand& command, const Context& context) {
  const roadquery::RoadMap roads = roadquery::read_opendrive(command.network.string());
  const io::RasterInfo info = io::raster_info(command.photo);
  SiteFrame site{site_crs(command.network.string(), roads, info.crs), {}};
  const Photo photo = read_photo_for(command.photo, info, site, context.threads);
  const HeightGrid terrain = merge_heights(io::read_dtms(command.dtm, site, {.least_coverage = io::least_site_coverage}), bounds_of(site.area.outer).grown(50.0));

  std::optional<LabelMap> labels;
  if (!command.labels.empty()) labels = io::read_labels(command.labels);
  if (labels && proj_string(labels->crs) != proj_string(site.crs))
    throw InputError(command.labels.string(),
                     "is not in the CRS of the roads; write it with `orthodrive segment` from the same photo");

  // A trailing slash would leave the folder without a name.
  AsideFile out(command.out.has_filename() ? command.out : command.out.parent_path());
  std::vector<io::TileEntry> entries;
  std::mutex mutex;
  Vec3 origin;
  SceneOptions options = command.options;
  options.threads = context.threads;
  const SceneResult result = build_scene(
      {roads, terrain, photo, site.area, labels ? &*labels : nullptr},
      [&](const SceneTile& tile, Vec3 site_origin) {
        const io::TileEntry entry = io::write_tile_glb(out.path(), tile, site_origin);
        const std::lock_guard lock(mutex);
        entries.push_back(entry);
        origin = site_origin;
      },
      options, context.monitor);
  if (entries.empty()) throw InputError(command.photo.string(), "shows no ground that a tile could be made of");
  io::write_tileset(out.path(), entries, site.crs, origin);
  out.commit();
  for (const Finding& finding : result.findings)
    context.monitor->info(fmt::format("{}: {}", finding.code, finding.message));
  context.monitor->info(fmt::format("{}: {} tiles, {} terrain and {} road triangles, {:.0f} m2 of road",
                                    command.out.string(), result.tiles, result.terrain_triangles, result.road_triangles,
                                    result.road_surface_m2));
}

}  // namespace

void add_scene(CLI::App& app, Context& context) {
  auto command = std::make_shared<SceneCommand>();
  CLI::App* cmd = app.add_subcommand("scene", "Cut the roads into the terrain and write textured 3D Tiles.");
  cmd->add_option("--network", command->network, "roads (OpenDRIVE); their geoReference is the scene's CRS")
      ->required();
  cmd->add_option("--photo", command->photo, "orthophoto (any GDAL raster): texture and extent")->required();
  cmd->add_option("--labels", command->labels, "label map of that photo: its classes become feature ids of the tiles");
  cmd->add_option("--dtm", command->dtm, "bare-earth terrain model, best first; later ones fill its holes")->required();
  cmd->add_option("-o,--output", command->out, "folder for tileset.json and *.glb; replaced when all is done")
      ->required();
  SceneOptions& o = command->options;
  cmd->add_option("--terrain-step", o.terrain_step_m, "distance of terrain vertices, m")->capture_default_str();
  cmd->add_option("--verge", o.verge_m, "width of the strip from a road's edge to the DTM, m")->capture_default_str();
  cmd->add_option("--max-texture", o.max_texture_px, "texture pixels along a tile's side")->capture_default_str();
  cmd->footer(
      "Reads roads, photo and terrain; writes DIR/tileset.json (3D Tiles 1.1) and one .glb for each 480 m tile.\n"
      "Memory: the photo (4 bytes a pixel) and some 20 MB a thread.\n"
      "Examples:\n"
      "  orthodrive scene --network out/roads.xodr --labels out/labels.tif --photo out/photo.tif --dtm dtm.tif -o "
      "out/scene\n"
      "  orthodrive scene --network roads.xodr --photo ortho.jpg --dtm dtm_1m.tif --dtm dtm_10m.tif --max-texture 1024 "
      "-o scene");
  cmd->callback([command, &context] { run(*command, context); });
}

}  // namespace orthodrive::app
