// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/pipeline/stages/run_scene.hpp"

#include <fmt/format.h>

#include <mutex>
#include <set>

#include "orthodrive/core/atomic_file.hpp"
#include "orthodrive/core/byte_archive.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/core/parallel.hpp"
#include "orthodrive/geo/geo_reference.hpp"
#include "orthodrive/geo/overlay.hpp"
#include "orthodrive/io/raster/raster_io.hpp"
#include "orthodrive/io/raster/terrain_grid_io.hpp"
#include "orthodrive/io/tiles/scene_io.hpp"
#include "orthodrive/io/vector/building_reader.hpp"
#include "orthodrive/io/vector/surroundings_reader.hpp"
#include "orthodrive/io/vector/tree_reader.hpp"
#include "orthodrive/model/rasters/sample_height.hpp"
#include "orthodrive/pipeline/files/read_network.hpp"
#include "orthodrive/pipeline/stages/bare_road_finding.hpp"
#include "orthodrive/pipeline/stages/choose_roads.hpp"
#include "orthodrive/report/site_pictures.hpp"
#include "orthodrive/scene/buildings/archived_tiles.hpp"
#include "orthodrive/scene/ground/generic_ground.hpp"
#include "orthodrive/scene/ground/generic_terrain.hpp"
#include "orthodrive/scene/ground/terrain_windows.hpp"
#include "orthodrive/scene/look/surface_texture.hpp"
#include "orthodrive/scene/plan/plan_grid.hpp"
#include "roadquery/roads/road_structures.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace orthodrive {
namespace fs = std::filesystem;

namespace io {
template <typename Archive>
void fields(Archive& archive, TileEntry& e) {
  archive(e.uri, e.level, e.column, e.row, e.origin, e.bounds, e.min_z_m, e.max_z_m, e.geometric_error_m);
}
}  // namespace io

namespace {
/// Files that name one CRS in two ways; by its text where a datum shift is all that differs, as our older files have
/// none. The place is in `b`.
bool mean_the_same(const Crs& a, const Crs& b, Vec2 p) {
  return proj_string(a) == proj_string(b) || is_same_place(a, b, p);
}

bool is_understood(const Crs& crs, Vec2 place) {
  try {
    (void)CoordinateTransform(crs, {"EPSG:4326"}).target_from_source(place);
    return true;
  } catch (const Error&) {
    return false;
  }
}

Vec2 first_place(const roadquery::RoadMap& roads) {
  if (roads.roads.empty()) return {};
  const roadquery::PlanPoint p = roadquery::reference_point(roads.roads.front(), 0.0);
  return {p.x, p.y};
}

/// Empty where the roads' CRS can be used; else what is wrong with it.
std::string fault_of_reference(const roadquery::RoadMap& roads) {
  if (roads.geo_reference.empty()) return "the roads have no geoReference";
  if (is_understood({roads.geo_reference}, first_place(roads))) return "";
  return fmt::format("the roads' geoReference \"{}\" is not understood", roads.geo_reference);
}

/// As the roads name it, where maps are laid on them.
Crs crs_of_roads(const std::string& network_file, const roadquery::RoadMap& roads) {
  if (!fault_of_reference(roads).empty())
    throw InputError(network_file,
                     (roads.geo_reference.empty()
                          ? std::string("has no geoReference")
                          : fmt::format("has the geoReference \"{}\", which is not understood", roads.geo_reference)) +
                         ", so maps cannot be laid on its roads; leave the maps out, or write a PROJ string such as "
                         "+proj=utm +zone=33 +datum=WGS84 into the <header>");
  return {roads.geo_reference};
}

/// The CRS of the roads beside a photo or terrain model, by that file's name for it when both are the same. Roads that
/// do not know theirs have the file's: a finding says so.
Crs crs_beside(const roadquery::RoadMap& roads, const fs::path& file, const Crs& of_file, Findings& findings) {
  const std::string fault = fault_of_reference(roads);
  if (fault.empty())
    return mean_the_same(of_file, {roads.geo_reference}, first_place(roads)) ? of_file : Crs{roads.geo_reference};
  const Vec2 place = first_place(roads);
  findings.push_back({Severity::warning, "scene.crs_of_ground",
                      fmt::format("{}: their coordinates are taken to be those of {}", fault, file.string()), place.x,
                      place.y});
  return of_file;
}

/// Where roads are all there is, nothing need lie at its place on the earth: the scene takes the coordinates as they
/// are, around 0 north, 0 east. A finding says so.
Crs crs_of_roads_alone(const roadquery::RoadMap& roads, Findings& findings) {
  const std::string fault = fault_of_reference(roads);
  if (fault.empty()) return {roads.geo_reference};
  const Vec2 place = first_place(roads);
  findings.push_back({Severity::info, "scene.local_frame",
                      fault + ": the scene has the coordinates of the file, and lies at 0 north, 0 east on a globe",
                      place.x, place.y});
  return {"+proj=tmerc +lat_0=0 +lon_0=0 +k=1 +x_0=0 +y_0=0 +datum=WGS84 +units=m +no_defs"};
}

/// The photo with the site that it is of.
struct PlacedPhoto {
  SiteFrame site;
  PhotoSource photo;
};

/// Without a site the area is what the photos show: on its own grid where it is one photo in the CRS of the roads,
/// warped otherwise.
PlacedPhoto open_placed_photo(const SceneFiles& files, const roadquery::RoadMap& roads, int threads,
                              Findings& findings) {
  const io::ReadPhotoOptions photo_options{.threads = threads};
  const fs::path& first = files.photos.front();
  const io::RasterInfo info = io::raster_info(first);
  PlacedPhoto placed{.site = {crs_beside(roads, first, info.crs, findings), {}}};
  const bool one = files.photos.size() == 1;
  if (one && placed.site.crs != info.crs) {
    const CoordinateTransform to_geographic(placed.site.crs, Crs{"EPSG:4326"});
    for (const Vec2 p : info.outline_lonlat.outer)
      placed.site.area.outer.push_back(to_geographic.source_from_target(p));
    placed.photo = io::open_photo(first, placed.site, photo_options);
    return placed;
  }
  placed.site.area = area_of_photos(files.photos, placed.site.crs);
  placed.photo = one ? io::open_photo_native(first) : io::open_photo(files.photos, placed.site, photo_options);
  placed.site.area = photo_outline(placed.photo);
  if (placed.site.area.outer.empty())
    throw InputError(names_of(files.photos), "has no valid pixel, give a photo that shows the roads");
  return placed;
}

std::optional<Polygon> largest_common_part(const Polygon& a, const Polygon& b) {
  const MultiPolygon common = intersection_of({a}, {b}, scene::plan_grid_m);
  if (common.empty()) return std::nullopt;
  return *std::ranges::max_element(common, {}, [](const Polygon& p) { return area_m2(p); });
}

/// All that a scene is made of, opened or read. Without a terrain model the ground follows the roads, without a photo
/// it is drawn: the scene knows no difference.
struct SceneInputs {
  Findings findings;
  roadquery::RoadMap all_roads;  ///< of the network
  roadquery::RoadMap roads;      ///< that are cut into the ground
  SiteFrame site;
  PhotoSource photo;
  Terrain terrain;
  std::optional<LabelSource> labels;
  std::vector<Building> buildings;
  std::vector<Vec2> trees;
  MapSurroundings surroundings;

  SceneInputs(const SceneFiles& files, const RunSceneOptions& options, StageContext& context)
      : all_roads(read_network(files.network, findings)) {
    if (const auto bare = widen_bare_roads(all_roads, files.bare_width_m, "scene")) findings.push_back(*bare);
    roads = files.chosen_roads.empty() ? all_roads : map_of_chosen(all_roads, files.chosen_roads, "--roads");
    place(files, options, context);
    for (roadquery::RoadMap* map : {&all_roads, &roads}) {
      *map = roadquery::cut_at_structures(std::move(*map));
      if (!fault_of_reference(*map).empty()) map->geo_reference = site.crs.definition;
    }
    if (files.dtm.empty())
      terrain.dtms = {scene::generic_terrain(all_roads, box(), files.network.string())};
    else  // The models are kept for other stages only where a site is built.
      terrain = options.site ? context.sources.terrain(files.dtm, site) : read_terrain(files.dtm, site);
    if (!files.labels.empty()) {
      labels = io::open_labels(files.labels);
      if (!mean_the_same(labels->crs, site.crs, site.area.outer.front()))
        throw InputError(files.labels.string(),
                         "is not in the CRS of the roads; write it with `orthodrive segment` from the same photo");
    }
    buildings = io::read_buildings(files.buildings, site, &findings);
    trees = io::read_trees(files.trees, site);
    surroundings = io::read_surroundings(files.surroundings, site, &findings);
    if (files.photos.empty()) photo = scene::generic_ground({all_roads, buildings, &surroundings}, site.crs, box());
  }
  [[nodiscard]] HeightSource heights() const { return merged_source(terrain.dtms, box()); }
  [[nodiscard]] SceneSource source(Polygon area) const {
    return {.roads = roads,
            .terrain = heights(),
            .photo = photo,
            .area = std::move(area),
            .labels = labels,
            .buildings = buildings,
            .trees = trees,
            .surroundings = &surroundings};
  }

 private:
  /// CRS and area, with the photo if there is one.
  void place(const SceneFiles& files, const RunSceneOptions& options, StageContext& context) {
    if (!files.photos.empty()) {
      const io::ReadPhotoOptions on_site{.threads = context.threads};
      PlacedPhoto placed = options.site
                               ? PlacedPhoto{*options.site, io::open_photo(files.photos, *options.site, on_site)}
                               : open_placed_photo(files, roads, context.threads, findings);
      site = std::move(placed.site), photo = std::move(placed.photo);
      return;
    }
    const std::string name = files.network.string();
    site.area = scene::area_around_roads(roads, options.margin_m, name);
    const bool has_maps = !files.buildings.empty() || !files.trees.empty() || !files.surroundings.empty();
    if (has_maps)
      site.crs = crs_of_roads(name, roads);
    else if (files.dtm.empty())
      site.crs = crs_of_roads_alone(roads, findings);
    else if (fault_of_reference(roads).empty())
      site.crs = {roads.geo_reference};
    else
      site.crs = crs_beside(roads, files.dtm.front(), io::raster_info(files.dtm.front()).crs, findings);
    if (files.dtm.empty()) return;
    const auto on_terrain = largest_common_part(site.area, area_of_photos(files.dtm, site.crs));
    if (!on_terrain) throw InputError(names_of(files.dtm), "shares no ground with the roads of " + name);
    site.area = *on_terrain;
  }
  /// Of the ground with some of what lies around it.
  [[nodiscard]] Box2 box() const { return bounds_of(site.area.outer).grown(50.0); }
};

/// The tile with most road triangles is the one to show.
class TilePicture {
 public:
  void offer(const SceneTile& tile) {
    std::size_t triangles = 0;
    for (const TriMesh& mesh : tile.meshes)
      if (mesh.kind == MeshKind::road) triangles += mesh.indices.size() / 3;
    const bool earlier = std::pair(tile.column, tile.row) < std::pair(best_.column, best_.row);
    if (triangles > most_ ||
        (triangles == most_ && most_ > 0 && earlier)) {  // ties by address: any thread order, one picture
      best_ = tile;
      best_.texture_rgb = {};
      most_ = triangles;
    }
  }
  [[nodiscard]] const SceneTile& best() const { return best_; }

 private:
  SceneTile best_;
  std::size_t most_ = 0;
};

/// Tiles whose files are in a folder. Takes them from any thread.
class TileList {
 public:
  void add(const SceneTile& tile, io::TileEntry entry, bool for_picture) {
    const std::lock_guard lock(mutex_);
    entries_.push_back(std::move(entry));
    for (const TriMesh& mesh : tile.meshes)
      for (const MeshPart& part : mesh.parts) materials_.insert(part.material);
    for (const InstancedMesh& copied : tile.instanced)
      for (const MeshPart& part : copied.mesh.parts) materials_.insert(part.material);
    if (for_picture && tile.level == 0) picture_.offer(tile);
  }
  void add(const TileList& other) {
    const std::lock_guard lock(mutex_);
    entries_.insert(entries_.end(), other.entries_.begin(), other.entries_.end());
    materials_.insert(other.materials_.begin(), other.materials_.end());
    picture_.offer(other.picture_.best());
  }
  [[nodiscard]] const std::vector<io::TileEntry>& entries() const { return entries_; }
  [[nodiscard]] std::vector<SurfaceMaterial> materials() const { return {materials_.begin(), materials_.end()}; }
  [[nodiscard]] const SceneTile& picture() const { return picture_.best(); }

  [[nodiscard]] std::string bytes() const {
    ByteWriter writer;
    writer(entries_, materials(), picture_.best());
    return writer.take();
  }
  void read(const std::string& bytes, const std::string& name) {
    ByteReader reader(bytes, name);
    std::vector<SurfaceMaterial> materials;
    SceneTile picture;
    reader(entries_, materials, picture);
    reader.finish();
    materials_ = {materials.begin(), materials.end()};
    picture_.offer(picture);
  }

 private:
  std::mutex mutex_;
  std::vector<io::TileEntry> entries_;
  std::set<SurfaceMaterial> materials_;
  TilePicture picture_;
};

/// What a process leaves of a cell: the list of its tiles, and what the scene needs of it.
std::string cell_bytes(const TileList& tiles, const std::string& scene) {
  ByteWriter writer;
  writer(tiles.bytes(), scene);
  return writer.take();
}

io::MaterialPictures make_material(SurfaceMaterial material) {
  return io::encode_material(material, scene::make_surface_texture(material));
}

constexpr const char* materials_loop = "materials";  // what the helpers make of it when there are no cells left

/// As another process has left them, or made now.
io::MaterialPictures material_pictures(SurfaceMaterial material, CellExchange* exchange) {
  const auto number = static_cast<std::size_t>(material);
  const std::optional<std::string> bytes = exchange ? exchange->take(materials_loop, number) : std::nullopt;
  if (!bytes) return make_material(material);
  io::MaterialPictures pictures;
  ByteReader reader(*bytes, "pictures of a material");
  reader(pictures);
  reader.finish();
  return pictures;
}

/// Of those materials that nobody has made or makes, last ones first: the process that builds begins with the first.
void help_with_materials(const std::set<SurfaceMaterial>& materials, CellExchange& exchange) {
  for (auto material = materials.rbegin(); material != materials.rend(); ++material) {
    const auto number = static_cast<std::size_t>(*material);
    if (*material == SurfaceMaterial::photo || exchange.load(materials_loop, number) ||
        exchange.claim(materials_loop, number))
      continue;
    ByteWriter writer;
    writer(make_material(*material));
    exchange.keep(materials_loop, number, writer.take());
  }
}

/// Where the tiles of a scene are written.
class TileFolder {
 public:
  TileFolder(const SceneFiles& files, const io::TileFileOptions& options)
      // A trailing slash would leave the folder without a name.
      : folder_(files.folder.has_filename() ? files.folder : files.folder.parent_path()),
        picture_file_(files.picture),
        options_(options) {
    fs::create_directories(folder_.path());
  }
  void write(const SceneTile& tile) {
    tiles_.add(tile, io::write_tile_glb(folder_.path(), tile, options_), !picture_file_.empty());
  }
  /// The tiles of a cell that another process has made. Returns what the scene needs of it.
  std::optional<std::string> take(CellExchange& exchange, std::size_t cell) {
    const std::optional<std::string> bytes = exchange.take(CellExchange::cells, cell);
    if (!bytes) return std::nullopt;
    const CellStore store = exchange.store(CellExchange::cells);
    const std::string name = store.folder(cell).string();
    std::string list, scene;
    ByteReader reader(*bytes, name);
    reader(list, scene);
    reader.finish();
    TileList tiles;
    tiles.read(list, name);
    for (const io::TileEntry& entry : tiles.entries()) {
      std::error_code failed;
      fs::copy_file(store.folder(cell) / entry.uri, folder_.path() / entry.uri, failed);
      if (failed)
        throw InputError(
            (store.folder(cell) / entry.uri).string(),
            fmt::format("cannot be copied ({}); remove its folder and make the cell again", failed.message()));
    }
    tiles_.add(tiles);
    return scene;
  }
  [[nodiscard]] bool empty() const { return tiles_.entries().empty(); }
  void finish(const Crs& crs, Vec3 origin, int threads, CellExchange* exchange, Findings& findings) {
    std::vector<SurfaceMaterial> materials = tiles_.materials();
    std::erase(materials, SurfaceMaterial::photo);
    parallel_for(materials.size(), threads, [&](std::size_t i) {
      io::write_material(folder_.path(), materials[i], material_pictures(materials[i], exchange));
    });
    io::write_tileset(folder_.path(), tiles_.entries(), crs, origin, findings);
    folder_.commit();
    if (!picture_file_.empty()) io::write_png(picture_file_, picture_of_tile(tiles_.picture(), scene_tile_m, 900).rgb);
  }

 private:
  AtomicFile folder_;
  fs::path picture_file_;
  io::TileFileOptions options_;
  TileList tiles_;
};

SceneOptions scene_options(const RunSceneOptions& options, const StageContext& context) {
  SceneOptions scene = options.scene;
  scene.threads = context.threads;
  return scene;
}
}  // namespace

void help_scene(const SceneFiles& files, const RunSceneOptions& options, StageContext& context) {
  const SceneInputs inputs(files, options, context);
  CellExchange& exchange = *context.exchange;
  std::optional<CellFolder> folder;
  std::optional<TileList> tiles;
  std::set<SurfaceMaterial> materials;
  const CellSink sink{
      .begin = [&](std::size_t cell) { folder.emplace(exchange.store(CellExchange::cells), cell), tiles.emplace(); },
      .write =
          [&](const SceneTile& tile) {
            tiles->add(tile, io::write_tile_glb(folder->folder(), tile, options.files), !files.picture.empty());
          },
      .finish =
          [&](const std::string& scene) {
            folder->commit(cell_bytes(*tiles, scene));
            for (const SurfaceMaterial material : tiles->materials()) materials.insert(material);
          }};
  build_scene_cells(
      inputs.source(inputs.site.area), [&](std::size_t cells) { return exchange.next_cell(cells); }, sink,
      scene_options(options, context));
  help_with_materials(materials, exchange);
}

StageOutcome run_scene(const SceneFiles& files, const RunSceneOptions& options, StageContext& context) {
  const SceneInputs inputs(files, options, context);
  const SiteFrame& site = inputs.site;
  Findings findings = inputs.findings;
  TileFolder folder(files, options.files);
  MadeCells made;
  if (context.exchange) made = [&](std::size_t cell) { return folder.take(*context.exchange, cell); };
  const SceneResult scene = build_scene(
      inputs.source(site.area), [&](const SceneTile& tile) { folder.write(tile); }, scene_options(options, context),
      context.monitor, made);
  if (folder.empty())
    throw InputError(files.photos.empty() ? files.network.string() : names_of(files.photos),
                     "shows no ground that a tile could be made of; check the area and the terrain model");
  folder.finish(site.crs, scene.origin, context.threads, context.exchange, findings);
  if (!files.terrain_grid.empty()) {
    const HeightSource heights = inputs.heights();
    HeightGrid filled{heights.crs, heights.frame, heights.read(pixels_of(heights.frame)), {}};
    scene::fill_holes(filled.height_m);
    io::write_terrain_grid(files.terrain_grid, filled);
  }
  findings.insert(findings.end(), scene.findings.begin(), scene.findings.end());
  return {.numbers = {{"levels", scene.levels},
                      {"tiles", scene.tiles},
                      {"terrain_triangles", scene.terrain_triangles},
                      {"road_triangles", scene.road_triangles},
                      {"road_surface_m2", scene.road_surface_m2},
                      {"buildings", scene.buildings},
                      {"trees", scene.trees}},
          .findings = std::move(findings),
          .summary = {fmt::format(
              "{}: {} tiles, {} levels, {} terrain and {} road triangles, {:.0f} m2 of road, {} buildings, {} "
              "trees",
              files.folder.string(), scene.tiles, scene.levels, scene.terrain_triangles, scene.road_triangles,
              scene.road_surface_m2, scene.buildings, scene.trees)}};
}

namespace {
/// The largest part of the area within the bounds.
Polygon part_of_area(const Polygon& area, const std::optional<Box2>& bounds) {
  if (!bounds) return area;
  const auto common = largest_common_part(area, polygon_of(*bounds));
  if (!common) throw OptionError("--bbox: shares no ground with the scene");
  return *common;
}
}  // namespace

StageOutcome run_export(const SceneFiles& files, const ExportOptions& options, StageContext& context) {
  const SceneInputs inputs(files, {}, context);
  const SiteFrame& site = inputs.site;
  Findings findings = inputs.findings;
  SceneOptions of_scene = options.scene;
  of_scene.threads = context.threads;
  std::mutex mutex;
  std::vector<SceneTile> tiles;
  const auto keep = [&](const SceneTile& tile) {
    if (tile.level > 0) return;
    const std::lock_guard lock(mutex);
    tiles.push_back(tile);
  };
  const SceneResult scene =
      build_scene(inputs.source(part_of_area(site.area, options.bounds)), keep, of_scene, context.monitor);
  std::ranges::sort(tiles, {}, [](const SceneTile& tile) { return std::pair(tile.column, tile.row); });
  io::write_area_glb(options.glb, tiles, scene.origin,
                     [](SurfaceMaterial of) { return scene::make_surface_texture(of); });
  std::size_t meshes = 0, copies = 0;
  for (const SceneTile& tile : tiles) {
    meshes += tile.meshes.size();
    for (const InstancedMesh& copied : tile.instanced) copies += copied.instances.size();
  }
  findings.insert(findings.end(), scene.findings.begin(), scene.findings.end());
  return {.numbers = {{"tiles", tiles.size()}, {"meshes", meshes}, {"trees", copies}},
          .findings = std::move(findings),
          .summary = {fmt::format("{}: {} tiles with {} meshes, {} trees; origin {:.0f} {:.0f} {:.0f} of {}",
                                  options.glb.string(), tiles.size(), meshes, copies, scene.origin.x, scene.origin.y,
                                  scene.origin.z, site.crs.definition)}};
}

BuildStage scene_stage(SiteBuild& build) {
  const Site& site = build.site;
  const std::vector<fs::path>& buildings = site.buildings.empty() ? site.osm : site.buildings;
  const std::vector<fs::path>& trees = site.trees.empty() ? site.osm : site.trees;
  const std::vector<fs::path>& surroundings = site.surroundings.empty() ? site.osm : site.surroundings;
  const SceneFiles files{.network = build.out_dir / "roads.xodr",
                         .photos = site.photos,
                         .labels = build.out_dir / "labels.tif",
                         .dtm = site.dtm,
                         .buildings = buildings,
                         .trees = trees,
                         .surroundings = surroundings,
                         .chosen_roads = site.scene_roads,
                         .folder = build.out_dir / "scene",
                         .picture = build.out_dir / ".orthodrive/scene_tile.png"};
  const RunSceneOptions options{.site = site.frame};
  nlohmann::json stage_options = frame_options(site.frame);
  if (!site.scene_roads.empty()) stage_options["scene.roads"] = site.scene_roads;
  return {.name = "scene",
          .version = 8,
          .sources = {{"photo", site.photos, SourceRole::Kind::raster},
                      {"dtm", site.dtm, SourceRole::Kind::raster},
                      {"buildings", buildings},
                      {"trees", trees},
                      {"surroundings", surroundings}},
          .options = std::move(stage_options),
          .reads = {"roads.xodr", "labels.tif"},
          .outputs = {"scene", ".orthodrive/scene_tile.png"},
          .run = [=, &build] { return run_scene(files, options, build.context); },
          .help = [=, &build] { help_scene(files, options, build.context); }};
}

}  // namespace orthodrive
