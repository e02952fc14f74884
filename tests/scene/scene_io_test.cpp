#include "orthodrive/io/scene_io.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "orthodrive/geo/crs.hpp"
#include "paths.hpp"

namespace orthodrive {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

const fs::path folder = fs::path(testing::TempDir()) / "orthodrive_scene_io_test";

SceneTile small_tile() {
  SceneTile tile{.column = 5, .row = 7, .origin = {500240.0, 5400240.0, 200.0}, .min_z_m = 200.0, .max_z_m = 203.0};
  tile.meshes.push_back({MeshKind::terrain,
                         {{-240.0F, -240.0F, 0.0F}, {240.0F, -240.0F, 1.0F}, {-240.0F, 240.0F, 3.0F}},
                         {{0.0F, 0.0F, 1.0F}, {0.0F, 0.0F, 1.0F}, {0.0F, 0.0F, 1.0F}},
                         {{0.0F, 1.0F}, {1.0F, 1.0F}, {0.0F, 0.0F}},
                         {0, 1, 2}});
  tile.meshes.push_back(tile.meshes[0]);
  tile.meshes[1].kind = MeshKind::road;
  tile.texture_rgb = Raster<std::uint8_t>(16, 16, 3, 77);
  return tile;
}

std::string read(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  std::stringstream text;
  text << stream.rdbuf();
  return text.str();
}

struct Glb {
  Json json;
  std::string bytes;
};
Glb read_glb(const fs::path& path) {
  const std::string file = read(path);
  std::uint32_t length = 0;
  std::memcpy(&length, &file[12], 4);
  return {Json::parse(file.substr(20, length)), file.substr(20 + length + 8)};
}

TEST(SceneIo, glb_is_y_up_and_placed_from_the_site_origin) {
  const auto entry = io::write_tile_glb(folder, small_tile(), {500000.0, 5400000.0, 190.0});
  EXPECT_EQ(entry.uri, "tile_5_7.glb");
  EXPECT_EQ(entry.bounds, (Box2{500000.0, 5400000.0, 500480.0, 5400480.0}));
  const Glb glb = read_glb(folder / entry.uri);
  ASSERT_EQ(glb.json["meshes"].size(), 2U);
  EXPECT_EQ(glb.json["meshes"][0]["name"], "terrain");
  EXPECT_EQ(glb.json["meshes"][1]["name"], "road");
  // East 240, north 240, up 10 from the site's origin: x east, y up, z south.
  EXPECT_EQ(glb.json["nodes"][0]["translation"], (Json{240.0, 10.0, -240.0}));
  const Json& positions =
      glb.json["accessors"][glb.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"].get<int>()];
  EXPECT_EQ(positions["max"], (Json{240.0, 3.0, 240.0}));
  std::array<float, 3> third{};
  std::memcpy(
      third.data(),
      &glb.bytes[glb.json["bufferViews"][positions["bufferView"].get<int>()]["byteOffset"].get<std::size_t>() + 24],
      12);
  EXPECT_EQ(third, (std::array<float, 3>{-240.0F, 3.0F, -240.0F}));
  EXPECT_EQ(glb.bytes.substr(0, 2), "\xff\xd8");  // the JPEG comes first
}

TEST(SceneIo, labels_become_feature_ids_with_a_table) {
  SceneTile tile = small_tile();
  tile.labels = Raster<std::uint8_t>(16, 16, 1, 1);
  tile.classes = {"small", {{.name = "ground", .role = Role::ground}, {.name = "asphalt", .role = Role::road}}};
  const fs::path own = folder / "labels";
  const Glb glb = read_glb(own / io::write_tile_glb(own, tile, {}).uri);
  const Json& ids = glb.json["meshes"][1]["primitives"][0]["extensions"]["EXT_mesh_features"]["featureIds"][0];
  EXPECT_EQ(ids["featureCount"], 2);
  EXPECT_EQ(ids["nullFeatureId"], 255);
  const Json& image = glb.json["images"][glb.json["textures"][ids["texture"]["index"].get<int>()]["source"].get<int>()];
  EXPECT_EQ(image["mimeType"], "image/png");
  const Json& table = glb.json["extensions"]["EXT_structural_metadata"]["propertyTables"][0];
  EXPECT_EQ(table["count"], 2);
  const Json& names = glb.json["bufferViews"][table["properties"]["name"]["values"].get<int>()];
  EXPECT_EQ(glb.bytes.substr(names["byteOffset"].get<std::size_t>(), names["byteLength"].get<std::size_t>()),
            "groundasphalt");
  for (const Json& view : glb.json["bufferViews"]) EXPECT_EQ(view.value("byteOffset", 0) % 8, 0);
}

/// A tile whose road has two tileable materials.
SceneTile tile_with_materials() {
  SceneTile tile = small_tile();
  TriMesh& road = tile.meshes[1];
  road.indices = {0, 1, 2, 0, 1, 2};
  road.parts = {{SurfaceMaterial::asphalt, 0, 3}, {SurfaceMaterial::verge, 3, 3}};
  road.tile_uv.assign(3, {0.5F, 0.25F});
  road.tangents.assign(3, {1.0F, 0.0F, 0.0F, 1.0F});
  road.colors.assign(3, {65535, 32768, 0, 65535});
  return tile;
}

TEST(SceneIo, parts_share_vertices_and_name_pictures_beside_the_file) {
  const fs::path own = folder / "materials";
  const Glb glb = read_glb(own / io::write_tile_glb(own, tile_with_materials(), {}).uri);
  const Json& parts = glb.json["meshes"][1]["primitives"];
  ASSERT_EQ(parts.size(), 2U);
  EXPECT_EQ(parts[0]["attributes"], parts[1]["attributes"]);
  const auto material = [&](int part) { return glb.json["materials"][parts[part]["material"].get<int>()]; };
  EXPECT_EQ(material(0)["name"], "asphalt");
  EXPECT_EQ(material(1)["alphaMode"], "BLEND");
  const Json color = material(0)["pbrMetallicRoughness"]["baseColorTexture"];
  EXPECT_EQ(color["texCoord"], 1);
  const Json& image = glb.json["images"][glb.json["textures"][color["index"].get<int>()]["source"].get<int>()];
  EXPECT_EQ(image["uri"], "materials/asphalt_color.jpg");
  const Json& colors = glb.json["accessors"][parts[0]["attributes"]["COLOR_0"].get<int>()];
  EXPECT_EQ(colors["normalized"], true);
  EXPECT_EQ(glb.json["materials"][0]["name"], "photo");
}

SceneTile tile_with_trees() {
  SceneTile tile = small_tile();
  InstancedMesh& tree = tile.instanced.emplace_back();
  tree.mesh = {.kind = MeshKind::tree,
               .positions = {{-1.0F, 0.0F, 0.0F}, {1.0F, 0.0F, 0.0F}, {0.0F, 0.0F, 1.0F}},
               .normals = {{0.0F, -1.0F, 0.0F}, {0.0F, -1.0F, 0.0F}, {0.0F, -1.0F, 0.0F}},
               .indices = {0, 1, 2},
               .parts = {{SurfaceMaterial::foliage, 0, 3}},
               .tile_uv = {{0.0F, 0.0F}, {1.0F, 0.0F}, {0.5F, 1.0F}}};
  tree.mesh.tangents.assign(3, {1.0F, 0.0F, 0.0F, 1.0F});
  tree.mesh.colors.assign(3, {1000, 2000, 500, 65535});
  tree.instances = {{.position = {10.0F, 20.0F, 3.0F}, .yaw_rad = 0.5F, .scale = {2.0F, 2.5F, 8.0F}},
                    {.position = {-239.0F, 5.0F, 1.0F}, .scale = {3.0F, 3.0F, 9.0F}, .tint = {0.9F, 1.1F, 0.7F}}};
  return tile;
}

TEST(SceneIo, trees_are_copies_of_one_mesh) {
  const fs::path own = folder / "trees";
  const io::TileEntry entry = io::write_tile_glb(own, tile_with_trees(), {});
  EXPECT_EQ(entry.bounds.min_x, 500240.0 - 242.0) << "crowns reach over the tile's border";
  const Glb glb = read_glb(own / entry.uri);
  EXPECT_EQ(glb.json["extensionsRequired"], Json({"EXT_mesh_gpu_instancing"}));
  const Json& node = glb.json["nodes"][2];
  EXPECT_EQ(node["name"], "tree");
  const Json& attributes = node["extensions"]["EXT_mesh_gpu_instancing"]["attributes"];
  const auto values = [&](const char* name, std::size_t width) {
    const Json& accessor = glb.json["accessors"][attributes[name].get<int>()];
    EXPECT_EQ(accessor["count"], 2);
    std::vector<float> result(2 * width);
    std::memcpy(result.data(),
                &glb.bytes[glb.json["bufferViews"][accessor["bufferView"].get<int>()].value("byteOffset", 0)],
                result.size() * sizeof(float));
    return result;
  };
  EXPECT_EQ(values("TRANSLATION", 3), (std::vector<float>{10.0F, 3.0F, -20.0F, -239.0F, 1.0F, -5.0F}));
  EXPECT_EQ(values("SCALE", 3), (std::vector<float>{2.0F, 8.0F, 2.5F, 3.0F, 9.0F, 3.0F}));
  EXPECT_EQ(values("_COLOR_0", 3), (std::vector<float>{1.0F, 1.0F, 1.0F, 0.9F, 1.1F, 0.7F}));
  const std::vector<float> turns = values("ROTATION", 4);
  EXPECT_FLOAT_EQ(turns[1], std::sin(0.25F));
  EXPECT_FLOAT_EQ(turns[3], std::cos(0.25F));
  const Json& primitive = glb.json["meshes"][node["mesh"].get<int>()]["primitives"][0]["attributes"];
  EXPECT_EQ(primitive["TEXCOORD_0"], primitive["TEXCOORD_1"]) << "no photo: one set under both names";
}

TEST(SceneIo, same_tile_gives_the_same_bytes) {
  (void)io::write_tile_glb(folder, small_tile(), {});
  const std::string first = read(folder / "tile_5_7.glb");
  (void)io::write_tile_glb(folder, small_tile(), {});
  EXPECT_EQ(first, read(folder / "tile_5_7.glb"));
}

TEST(SceneIo, khronos_validator_finds_no_error) {
  const fs::path source = paths::source_dir;
  if (!fs::exists(source / "viewer/node_modules/gltf-validator"))
    GTEST_SKIP() << "gltf-validator is not installed: npm ci --prefix viewer";
  const fs::path own = folder / "validated";
  SceneTile labelled = small_tile();
  labelled.labels = Raster<std::uint8_t>(16, 16, 1, 1);
  labelled.classes = default_class_table();
  const auto entry = io::write_tile_glb(own, labelled, {500000.0, 5400000.0, 190.0});
  SceneTile with_materials = tile_with_materials();
  with_materials.row = 9;
  (void)io::write_tile_glb(own, with_materials, {});
  const SurfaceTexture grey{Raster<std::uint8_t>(64, 64, 3, 128), Raster<std::uint8_t>(64, 64, 3, 128),
                            Raster<std::uint8_t>(64, 64, 3, 128)};
  SceneTile with_trees = tile_with_trees();
  with_trees.row = 10;
  with_trees.labels = labelled.labels, with_trees.classes = labelled.classes;
  (void)io::write_tile_glb(own, with_trees, {});
  for (const SurfaceMaterial material : {SurfaceMaterial::asphalt, SurfaceMaterial::verge, SurfaceMaterial::foliage})
    io::write_material(own, material, grey);
  SceneTile untextured = small_tile();
  untextured.row = 8;
  untextured.texture_rgb = {};
  (void)io::write_tile_glb(own, untextured, {});
  const std::string script = (source / "tools/validate_gltf.mjs").string();
  EXPECT_EQ(std::system(("node '" + script + "' '" + own.string() + "' > /dev/null").c_str()), 0);
  // The check itself can fail: an index beyond the vertices.
  SceneTile broken = small_tile();
  broken.meshes[0].indices[2] = 9;
  (void)io::write_tile_glb(own, broken, {});
  EXPECT_NE(std::system(("node '" + script + "' '" + (own / entry.uri).string() + "' > /dev/null").c_str()), 0);
}

TEST(SceneIo, tileset_places_the_site_on_the_earth) {
  const Crs crs{"EPSG:32633"};
  const Vec3 origin{322560.0, 6394305.0, 10.0};  // 3 degrees west of the central meridian: convergence -2.5 degrees
  io::write_tileset(folder, {{"tile_1_2.glb", {322000.0, 6394000.0, 322480.0, 6394480.0}, 5.0, 45.0}}, crs, origin);
  const Json tileset = Json::parse(read(folder / "tileset.json"));
  EXPECT_EQ(tileset["asset"]["version"], "1.1");
  EXPECT_EQ(tileset["asset"]["extras"]["orthodrive"]["crs"], "EPSG:32633");
  EXPECT_EQ(tileset["asset"]["extras"]["orthodrive"]["origin"], (Json{322560.0, 6394305.0, 10.0}));
  const Json& child = tileset["root"]["children"][0];
  EXPECT_EQ(child["content"]["uri"], "tile_1_2.glb");
  EXPECT_EQ(child["boundingVolume"]["box"],
            (Json{-320.0, -65.0, 15.0, 240.0, 0.0, 0.0, 0.0, 240.0, 0.0, 0.0, 0.0, 20.0}));

  const auto m = tileset["root"]["transform"].get<std::vector<double>>();  // column by column
  const CoordinateTransform to_geographic(crs, Crs{"EPSG:4326"});
  // A flat map leaves the earth by d^2 / 2R: 0.16 m at 1.4 km.
  for (const Vec3 d :
       {Vec3{0.0, 0.0, 0.0}, Vec3{1000.0, 0.0, 0.0}, Vec3{0.0, -1000.0, 0.0}, Vec3{1000.0, 1000.0, 30.0}}) {
    const Vec2 lonlat = to_geographic.target_from_source({origin.x + d.x, origin.y + d.y});
    const Vec3 truth = ecef_from_geographic(lonlat.x, lonlat.y, origin.z + d.z);
    EXPECT_NEAR(m[0] * d.x + m[4] * d.y + m[8] * d.z + m[12], truth.x, 0.2);
    EXPECT_NEAR(m[1] * d.x + m[5] * d.y + m[9] * d.z + m[13], truth.y, 0.2);
    EXPECT_NEAR(m[2] * d.x + m[6] * d.y + m[10] * d.z + m[14], truth.z, 0.2);
  }
}

}  // namespace
}  // namespace orthodrive
