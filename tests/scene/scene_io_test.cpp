// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/tiles/scene_io.hpp"

#include <gtest/gtest.h>
#include <meshoptimizer.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <tuple>

#include "orthodrive/geo/crs.hpp"
#include "paths.hpp"

namespace orthodrive {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

fs::path test_folder() { return fs::temp_directory_path() / "scene"; }

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

constexpr io::TileFileOptions plain{.compressed = false};

TEST(SceneIo, glb_is_y_up_and_placed_from_the_middle_of_the_tile) {
  const auto entry = io::write_tile_glb(test_folder(), small_tile(), plain);
  EXPECT_EQ(entry.uri, "tile_5_7.glb");
  EXPECT_EQ(entry.bounds, (Box2{500000.0, 5400000.0, 500480.0, 5400480.0}));
  EXPECT_EQ(std::tuple(entry.origin.x, entry.origin.y, entry.origin.z), std::tuple(500240.0, 5400240.0, 201.0))
      << "whole metres, between lowest and highest";
  const Glb glb = read_glb(test_folder() / entry.uri);
  ASSERT_EQ(glb.json["meshes"].size(), 2U);
  EXPECT_EQ(glb.json["meshes"][0]["name"], "terrain");
  EXPECT_EQ(glb.json["meshes"][1]["name"], "road");
  const Json& positions =
      glb.json["accessors"][glb.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"].get<int>()];
  EXPECT_EQ(positions["max"], (Json{240.0, 2.0, 240.0}));
  std::array<float, 3> third{};
  std::memcpy(
      third.data(),
      &glb.bytes[glb.json["bufferViews"][positions["bufferView"].get<int>()]["byteOffset"].get<std::size_t>() + 24],
      12);
  EXPECT_EQ(third, (std::array<float, 3>{-240.0F, 2.0F, -240.0F}));
  EXPECT_EQ(glb.bytes.substr(0, 2), "\xff\xd8");  // the JPEG comes first
}

TEST(SceneIo, labels_become_feature_ids_with_a_table) {
  SceneTile tile = small_tile();
  tile.labels = Raster<std::uint8_t>(16, 16, 1, 1);
  tile.classes = {"small",
                  {{.name = "ground", .color = {0, 160, 10}, .role = Role::ground},
                   {.name = "asphalt", .color = {255, 1, 2}, .role = Role::road}}};
  const fs::path own = test_folder() / "labels";
  const Glb glb = read_glb(own / io::write_tile_glb(own, tile, plain).uri);
  const Json& ids = glb.json["meshes"][1]["primitives"][0]["extensions"]["EXT_mesh_features"]["featureIds"][0];
  EXPECT_EQ(ids["featureCount"], 2);
  EXPECT_EQ(ids["nullFeatureId"], 255);
  const Json& image = glb.json["images"][glb.json["textures"][ids["texture"]["index"].get<int>()]["source"].get<int>()];
  EXPECT_EQ(image["mimeType"], "image/png");
  const Json& table = glb.json["extensions"]["EXT_structural_metadata"]["propertyTables"][0];
  EXPECT_EQ(table["count"], 2);
  const auto texts_of = [&](const char* property) {
    const Json& texts = glb.json["bufferViews"][table["properties"][property]["values"].get<int>()];
    return glb.bytes.substr(texts["byteOffset"].get<std::size_t>(), texts["byteLength"].get<std::size_t>());
  };
  EXPECT_EQ(texts_of("name"), "groundasphalt");
  EXPECT_EQ(texts_of("color"), "#00a00a#ff0102");
  for (const Json& view : glb.json["bufferViews"]) EXPECT_EQ(view.value("byteOffset", 0) % 8, 0);
}

TEST(SceneIo, roads_and_buildings_are_rows_of_a_table) {
  SceneTile tile = small_tile();
  tile.labels = Raster<std::uint8_t>(16, 16, 1, 1);
  tile.classes = {"small", {{.name = "ground", .role = Role::ground}}};
  tile.features = {
      {.kind = "road", .id = "7", .osm_id = "way/12", .name = "Straße", .lane_id = "-2", .lane_type = "biking"},
      {.kind = "building"}};
  tile.meshes[1].features = {0, 0, 1};
  const fs::path own = test_folder() / "objects";
  const Glb glb = read_glb(own / io::write_tile_glb(own, tile, plain).uri);
  const Json& primitive = glb.json["meshes"][1]["primitives"][0];
  const Json& ids = primitive["extensions"]["EXT_mesh_features"]["featureIds"];
  ASSERT_EQ(ids.size(), 2U);
  EXPECT_EQ(ids[1]["attribute"], 0);
  EXPECT_EQ(ids[1]["featureCount"], 2);
  const Json& table =
      glb.json["extensions"]["EXT_structural_metadata"]["propertyTables"][ids[1]["propertyTable"].get<int>()];
  EXPECT_EQ(table["class"], "object");
  for (const auto& [property, value] : {std::pair{"name", "Straße"}, {"lane_id", "-2"}, {"lane_type", "biking"}}) {
    const Json& texts = glb.json["bufferViews"][table["properties"][property]["values"].get<int>()];
    EXPECT_EQ(glb.bytes.substr(texts["byteOffset"].get<std::size_t>(), texts["byteLength"].get<std::size_t>()), value);
  }
  const Json& accessor = glb.json["accessors"][primitive["attributes"]["_FEATURE_ID_0"].get<int>()];
  std::array<float, 3> rows{};
  std::memcpy(rows.data(),
              &glb.bytes[glb.json["bufferViews"][accessor["bufferView"].get<int>()]["byteOffset"].get<std::size_t>() +
                         accessor.value("byteOffset", 0)],
              12);
  EXPECT_EQ(rows, (std::array<float, 3>{0.0F, 0.0F, 1.0F}));
  EXPECT_EQ(glb.json["meshes"][0]["primitives"][0]["extensions"]["EXT_mesh_features"]["featureIds"].size(), 1U);
}

/// A tile whose road has two tileable materials.
SceneTile tile_with_materials() {
  SceneTile tile = small_tile();
  TriMesh& road = tile.meshes[1];
  road.indices = {0, 1, 2, 0, 1, 2};
  road.parts = {{SurfaceMaterial::asphalt, 0, 3}, {SurfaceMaterial::verge, 3, 3}};
  road.tile_uv.assign(3, {0.5F, 0.25F});
  road.colors.assign(3, {65535, 32768, 0, 65535});
  return tile;
}

TEST(SceneIo, parts_share_vertices_and_name_pictures_beside_the_file) {
  const fs::path own = test_folder() / "materials";
  const Glb glb = read_glb(own / io::write_tile_glb(own, tile_with_materials(), plain).uri);
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
  tree.mesh.colors.assign(3, {1000, 2000, 500, 65535});
  tree.instances = {{.position = {10.0F, 20.0F, 3.0F}, .yaw_rad = 0.5F, .scale = {2.0F, 2.5F, 8.0F}},
                    {.position = {-239.0F, 5.0F, 1.0F}, .scale = {3.0F, 3.0F, 9.0F}, .tint = {0.9F, 1.1F, 0.7F}}};
  return tile;
}

TEST(SceneIo, trees_are_copies_of_one_mesh) {
  const fs::path own = test_folder() / "trees";
  const io::TileEntry entry = io::write_tile_glb(own, tile_with_trees(), plain);
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
                &glb.bytes[glb.json["bufferViews"][accessor["bufferView"].get<int>()].value("byteOffset", 0) +
                           accessor.value("byteOffset", 0)],
                result.size() * sizeof(float));
    return result;
  };
  EXPECT_EQ(values("TRANSLATION", 3), (std::vector<float>{10.0F, 2.0F, -20.0F, -239.0F, 0.0F, -5.0F}));
  EXPECT_EQ(values("SCALE", 3), (std::vector<float>{2.0F, 8.0F, 2.5F, 3.0F, 9.0F, 3.0F}));
  EXPECT_EQ(values("_COLOR_0", 3), (std::vector<float>{1.0F, 1.0F, 1.0F, 0.9F, 1.1F, 0.7F}));
  const std::vector<float> turns = values("ROTATION", 4);
  EXPECT_FLOAT_EQ(turns[1], std::sin(0.25F));
  EXPECT_FLOAT_EQ(turns[3], std::cos(0.25F));
  const Json& primitive = glb.json["meshes"][node["mesh"].get<int>()]["primitives"][0]["attributes"];
  EXPECT_EQ(primitive["TEXCOORD_0"], primitive["TEXCOORD_1"]) << "no photo: one set under both names";
}

TEST(SceneIo, area_is_one_file_with_all_in_it) {
  std::array<SceneTile, 2> tiles = {tile_with_trees(), tile_with_materials()};
  tiles[1].column = 6, tiles[1].origin.x += 480.0;
  const SurfaceTexture grey{Raster<std::uint8_t>(64, 64, 3, 128), Raster<std::uint8_t>(64, 64, 3, 128),
                            Raster<std::uint8_t>(64, 64, 3, 128)};
  const fs::path own = test_folder() / "area";
  fs::create_directories(own);
  io::write_area_glb(own / "area.glb", tiles, {500000.0, 5400000.0, 190.0},
                     [&](SurfaceMaterial) { return SurfaceTexture(grey); });
  const Glb glb = read_glb(own / "area.glb");
  std::map<std::string, int> count;
  for (const Json& node : glb.json["nodes"]) ++count[node["name"]];
  EXPECT_EQ(count,
            (std::map<std::string, int>{{"terrain", 2}, {"road", 2}, {"tree", 2}, {"tile_5_7", 1}, {"tile_6_7", 1}}));
  ASSERT_EQ(glb.json["scenes"][0]["nodes"].size(), 2U);
  const Json& first = glb.json["nodes"][glb.json["scenes"][0]["nodes"][0].get<int>()];
  EXPECT_EQ(first["translation"], (Json{240.0, 10.0, -240.0}));
  EXPECT_EQ(first["children"].size(), 4U);
  EXPECT_EQ(glb.json["nodes"][2]["translation"], (Json{10.0, 3.0, -20.0}));
  EXPECT_FALSE(glb.json.contains("extensionsRequired"));
  EXPECT_FALSE(glb.json.contains("extensionsUsed")) << "lit, and no extension";
  for (const Json& image : glb.json["images"]) EXPECT_TRUE(image.contains("bufferView"));
  if (!fs::exists(fs::path(paths::source_dir) / "viewer/node_modules/gltf-validator"))
    GTEST_SKIP() << "gltf-validator is not installed: npm ci --prefix viewer";
  const std::string script = (fs::path(paths::source_dir) / "tools/validate_gltf.mjs").string();
  EXPECT_EQ(std::system(("node '" + script + "' '" + (own / "area.glb").string() + "' > /dev/null").c_str()), 0);
}

TEST(SceneIo, same_tile_gives_the_same_bytes) {
  (void)io::write_tile_glb(test_folder(), small_tile());
  const std::string first = read(test_folder() / "tile_5_7.glb");
  (void)io::write_tile_glb(test_folder(), small_tile());
  EXPECT_EQ(first, read(test_folder() / "tile_5_7.glb"));
}

TEST(SceneIo, khronos_validator_finds_no_error) {
  const fs::path source = paths::source_dir;
  if (!fs::exists(source / "viewer/node_modules/gltf-validator"))
    GTEST_SKIP() << "gltf-validator is not installed: npm ci --prefix viewer";
  const fs::path own = test_folder() / "validated";
  SceneTile labelled = small_tile();
  labelled.labels = Raster<std::uint8_t>(16, 16, 1, 1);
  labelled.classes = default_class_table();
  labelled.features = {{.kind = "road", .id = "7"}};
  labelled.meshes[1].features = {0, 0, 0};
  const auto entry = io::write_tile_glb(own, labelled);
  SceneTile with_materials = tile_with_materials();
  with_materials.row = 9;
  (void)io::write_tile_glb(own, with_materials);
  const SurfaceTexture grey{Raster<std::uint8_t>(64, 64, 3, 128), Raster<std::uint8_t>(64, 64, 3, 128),
                            Raster<std::uint8_t>(64, 64, 3, 128)};
  SceneTile with_trees = tile_with_trees();
  with_trees.row = 10;
  with_trees.labels = labelled.labels, with_trees.classes = labelled.classes;
  (void)io::write_tile_glb(own, with_trees);
  for (const SurfaceMaterial material : {SurfaceMaterial::asphalt, SurfaceMaterial::verge, SurfaceMaterial::foliage})
    io::write_material(own, material, io::encode_material(material, grey));
  SceneTile untextured = small_tile();
  untextured.row = 8;
  untextured.texture_rgb = {};
  (void)io::write_tile_glb(own, untextured, {.photo = io::PhotoFormat::webp});
  SceneTile as_webp = tile_with_materials();
  as_webp.row = 11;
  (void)io::write_tile_glb(own, as_webp, {.photo = io::PhotoFormat::webp});
  const std::string script = (source / "tools/validate_gltf.mjs").string();
  EXPECT_EQ(std::system(("node '" + script + "' '" + own.string() + "' > /dev/null").c_str()), 0);
  // The check itself can fail: an index beyond the vertices.
  SceneTile broken = small_tile();
  broken.meshes[0].indices[2] = 9;
  (void)io::write_tile_glb(own, broken, plain);
  EXPECT_NE(std::system(("node '" + script + "' '" + (own / entry.uri).string() + "' > /dev/null").c_str()), 0);
}

/// The values of an accessor as a reader gets them: decoded where they are compressed.
std::vector<double> values_of(const Glb& glb, int accessor_index) {
  const Json& accessor = glb.json["accessors"][accessor_index];
  const Json& view = glb.json["bufferViews"][accessor["bufferView"].get<int>()];
  const std::size_t count = accessor["count"].get<std::size_t>();
  const std::size_t width = accessor["type"] == "SCALAR" ? 1 : accessor["type"].get<std::string>()[3] - '0';
  const int type = accessor["componentType"];
  const std::size_t size = type == 5126 || type == 5125 ? 4 : type == 5121 || type == 5120 ? 1 : 2;
  std::size_t stride = view.value("byteStride", width * size);
  std::vector<unsigned char> bytes(view["byteLength"].get<std::size_t>());
  const std::size_t first = accessor.value("byteOffset", 0);
  if (!view.contains("extensions")) {
    std::memcpy(bytes.data(), &glb.bytes[view["byteOffset"].get<std::size_t>()], bytes.size());
  } else {
    const Json& packed = view["extensions"]["EXT_meshopt_compression"];
    const auto* from = reinterpret_cast<const unsigned char*>(&glb.bytes[packed["byteOffset"].get<std::size_t>()]);
    stride = packed["byteStride"];
    const std::size_t all = packed["count"], length = packed["byteLength"];
    if (packed["mode"] == "TRIANGLES") {
      EXPECT_EQ(meshopt_decodeIndexBuffer(bytes.data(), all, stride, from, length), 0);
    } else {
      EXPECT_EQ(meshopt_decodeVertexBuffer(bytes.data(), all, stride, from, length), 0);
    }
    if (packed.value("filter", "") == "EXPONENTIAL") meshopt_decodeFilterExp(bytes.data(), all, stride);
    if (packed.value("filter", "") == "OCTAHEDRAL") meshopt_decodeFilterOct(bytes.data(), all, stride);
  }
  std::vector<double> values;
  const auto read = [&]<typename T>(T, const unsigned char* at, double scale) {
    T value{};
    std::memcpy(&value, at, sizeof value);
    values.push_back(static_cast<double>(value) / scale);
  };
  const bool normalized = accessor.value("normalized", false);
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t k = 0; k < width; ++k) {
      const unsigned char* at = &bytes[first + i * stride + k * size];
      if (type == 5126) read(float{}, at, 1.0);
      if (type == 5125) read(std::uint32_t{}, at, 1.0);
      if (type == 5123) read(std::uint16_t{}, at, normalized ? 65535.0 : 1.0);
      if (type == 5121) read(std::uint8_t{}, at, 255.0);
      if (type == 5120) read(std::int8_t{}, at, 127.0);
      if (type == 5122) read(std::int16_t{}, at, 32767.0);
    }
  }
  return values;
}

TEST(SceneIo, compressed_tiles_decode_to_what_was_written) {
  const fs::path own = test_folder() / "compressed";
  SceneTile tile = tile_with_materials();
  for (TriMesh& mesh : tile.meshes)
    for (auto& n : mesh.normals) n = {0.6F, 0.0F, 0.8F};
  const Glb packed = read_glb(own / io::write_tile_glb(own, tile).uri);
  tile.row = 8;
  const Glb flat = read_glb(own / io::write_tile_glb(own, tile, plain).uri);
  EXPECT_EQ(packed.json["extensionsRequired"], Json({"EXT_meshopt_compression", "KHR_mesh_quantization"}));
  ASSERT_EQ(packed.json["meshes"].size(), flat.json["meshes"].size());
  for (std::size_t m = 0; m < 2; ++m) {
    const Json &a = packed.json["meshes"][m]["primitives"][0], &b = flat.json["meshes"][m]["primitives"][0];
    EXPECT_EQ(values_of(packed, a["indices"]), values_of(flat, b["indices"]));
    EXPECT_EQ(values_of(packed, a["attributes"]["POSITION"]), values_of(flat, b["attributes"]["POSITION"]));
    for (const auto& [name, tolerance] : {std::pair{"NORMAL", 6e-4}, {"TEXCOORD_0", 1e-5}}) {
      const auto got = values_of(packed, a["attributes"][name]), truth = values_of(flat, b["attributes"][name]);
      ASSERT_EQ(got.size(), truth.size());
      for (std::size_t i = 0; i < got.size(); ++i) EXPECT_NEAR(got[i], truth[i], tolerance) << name;
    }
  }
  for (const auto& [name, tolerance] :
       {std::pair{"TEXCOORD_1", 6e-4}, {"COLOR_0", 0.5 / 255.0 + 1e-4}, {"TANGENT", 0.012}}) {
    const auto got = values_of(packed, packed.json["meshes"][1]["primitives"][0]["attributes"][name]);
    const auto truth = values_of(flat, flat.json["meshes"][1]["primitives"][0]["attributes"][name]);
    ASSERT_EQ(got.size(), truth.size());
    for (std::size_t i = 0; i < got.size(); ++i) EXPECT_NEAR(got[i], truth[i], tolerance) << name;
  }
  std::set<Json> layouts;  // numbers that lie alike share a view
  for (const Json& view : packed.json["bufferViews"]) {
    if (!view.contains("extensions")) continue;
    const Json& how = view["extensions"]["EXT_meshopt_compression"];
    EXPECT_TRUE(layouts.insert(Json::array({how["mode"], how["byteStride"], how.value("filter", "")})).second);
  }
  EXPECT_GT(layouts.size(), 3U);
  EXPECT_EQ(flat.json["samplers"].size(), 2U) << "of the photo, and of all that repeats";
}

TEST(SceneIo, heights_of_a_shared_border_stay_equal_whatever_the_tiles_are_like) {
  const fs::path own = test_folder() / "border";
  std::vector<std::array<float, 3>> border;
  for (int k = 0; k < 500; ++k)
    border.push_back({240.0F, -240.0F + static_cast<float>(k) / 1024.0F, 60.0F + 0.037F * static_cast<float>(k)});
  std::vector<std::set<std::pair<double, double>>> decoded;
  for (const int side : {0, 1}) {
    SceneTile tile = small_tile();
    tile.column += side;
    tile.origin.x += 480.0 * side;
    tile.meshes.resize(1);
    TriMesh& mesh = tile.meshes[0];
    mesh.positions = border;
    for (auto& p : mesh.positions) p[0] -= 480.0F * static_cast<float>(side);
    mesh.normals.assign(border.size(), {0.0F, 0.0F, 1.0F});
    mesh.uv.assign(border.size(), {0.0F, 0.0F});
    mesh.indices.clear();
    for (std::uint32_t k = 2; k < border.size(); ++k) mesh.indices.insert(mesh.indices.end(), {k - 2, k - 1, k});
    tile.min_z_m = 200.0 + 55.0 * side, tile.max_z_m = 300.0;  // the origins differ by 27 m
    const io::TileEntry entry = io::write_tile_glb(own, tile);
    const Glb glb = read_glb(own / entry.uri);
    const auto values = values_of(glb, glb.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"]);
    auto& points = decoded.emplace_back();
    for (std::size_t i = 0; i < values.size(); i += 3)
      points.insert({entry.origin.y - values[i + 2], entry.origin.z + values[i + 1]});
  }
  EXPECT_EQ(decoded[0].size(), border.size());
  EXPECT_EQ(decoded[0], decoded[1]);
}

/// Where tileset.json puts a point of a tile, by the transforms from the root on.
Vec3 placed(const Json& root, const std::vector<std::size_t>& path, Vec3 p) {
  std::vector<const Json*> nodes = {&root};
  for (const std::size_t child : path) nodes.push_back(&(*nodes.back())["children"][child]);
  std::reverse(nodes.begin(), nodes.end());
  for (const Json* node : nodes) {
    const auto m = (*node)["transform"].get<std::vector<double>>();  // column by column
    p = {m[0] * p.x + m[4] * p.y + m[8] * p.z + m[12], m[1] * p.x + m[5] * p.y + m[9] * p.z + m[13],
         m[2] * p.x + m[6] * p.y + m[10] * p.z + m[14]};
  }
  return p;
}

/// Four tiles of 480 m under one of 960 m.
std::vector<io::TileEntry> five_entries() {
  std::vector<io::TileEntry> entries;
  for (const int level : {1, 0})
    for (int k = 0; k < (level == 1 ? 1 : 4); ++k) {
      const double side_m = 480.0 * (level + 1);
      const int column = (670 >> level) + k / 2, row = (13320 >> level) + k % 2;
      const Box2 box{column * side_m, row * side_m, (column + 1) * side_m, (row + 1) * side_m};
      entries.push_back({.uri = "t" + std::to_string(level) + std::to_string(k) + ".glb",
                         .level = level,
                         .column = column,
                         .row = row,
                         .origin = {0.5 * (box.min_x + box.max_x), 0.5 * (box.min_y + box.max_y), 20.0 + 7.0 * k},
                         .bounds = box,
                         .min_z_m = 5.0,
                         .max_z_m = 45.0 + k,
                         .geometric_error_m = 1.5 * level});
    }
  return entries;
}

TEST(SceneIo, tileset_is_a_tree_of_levels) {
  Findings findings;
  io::write_tileset(test_folder(), five_entries(), Crs{"EPSG:32633"}, {322560.0, 6394305.0, 10.0}, findings);
  const Json tileset = Json::parse(read(test_folder() / "tileset.json"));
  EXPECT_EQ(tileset["asset"]["version"], "1.1");
  EXPECT_EQ(tileset["asset"]["extras"]["orthodrive"]["crs"], "EPSG:32633");
  EXPECT_EQ(tileset["asset"]["extras"]["orthodrive"]["origin"], (Json{322560.0, 6394305.0, 10.0}));
  EXPECT_EQ(tileset["root"]["refine"], "REPLACE");
  ASSERT_EQ(tileset["root"]["children"].size(), 1U);
  const Json& top = tileset["root"]["children"][0];
  EXPECT_EQ(top["content"]["uri"], "t10.glb");
  EXPECT_EQ(top["geometricError"], 1.5);
  ASSERT_EQ(top["children"].size(), 4U);
  EXPECT_EQ(top["children"][2]["content"]["uri"], "t02.glb");
  EXPECT_EQ(top["children"][2]["geometricError"], 0.0);
  EXPECT_EQ(top["children"][2]["extras"]["origin"],
            (Json{671.5 * 480.0 - 322560.0, 13320.5 * 480.0 - 6394305.0, 24.0}));
  EXPECT_EQ(top["children"][1]["boundingVolume"]["box"],
            (Json{0.0, 0.0, -1.5, 240.0, 0.0, 0.0, 0.0, 240.0, 0.0, 0.0, 0.0, 20.5}));
  EXPECT_EQ(top["boundingVolume"]["box"], (Json{0.0, 0.0, 6.5, 480.0, 0.0, 0.0, 0.0, 480.0, 0.0, 0.0, 0.0, 21.5}));
}

TEST(SceneIo, every_tile_lies_on_the_earth_by_itself) {
  const Crs crs{"EPSG:32633"};  // 3 degrees west of the central meridian: convergence -2.5 degrees, scale 0.99998
  const std::vector<io::TileEntry> entries = five_entries();
  Findings findings;
  io::write_tileset(test_folder(), entries, crs, {340000.0, 6400000.0, 10.0},
                    findings);  // some way off: it must not matter
  const Json root = Json::parse(read(test_folder() / "tileset.json"))["root"];
  const CoordinateTransform to_geographic(crs, Crs{"EPSG:4326"});
  const Geoid geoid;
  EXPECT_EQ(findings.empty(), !geoid.grid().empty());
  const auto truth = [&](Vec3 p) {
    const Vec2 lonlat = to_geographic.target_from_source({p.x, p.y});
    return ecef_from_geographic(lonlat.x, lonlat.y, p.z + geoid.height_m(lonlat.x, lonlat.y));
  };
  const auto apart = [](Vec3 a, Vec3 b) { return std::hypot(a.x - b.x, a.y - b.y, a.z - b.z); };
  const auto at_corner = [&](const io::TileEntry& tile, const std::vector<std::size_t>& path, Vec3 p) {
    return placed(root, path, p - tile.origin);
  };
  for (std::size_t k = 0; k < 4; ++k) {
    const io::TileEntry& tile = entries[1 + k];
    EXPECT_LT(apart(at_corner(tile, {0, k}, tile.origin), truth(tile.origin)), 1e-6);
    // A flat tile leaves the earth by d^2 / 2R: 9 mm at its corners; 30 m above its origin the vertical is another.
    for (const double x : {tile.bounds.min_x, tile.bounds.max_x})
      for (const double y : {tile.bounds.min_y, tile.bounds.max_y})
        for (const double z : {10.0, 50.0})
          EXPECT_LT(apart(at_corner(tile, {0, k}, {x, y, z}), truth({x, y, z})), 0.012);
  }
  // Neighbours bend away from each other alike: their common corner is one place but for 3 mm.
  const Vec3 middle{entries[0].origin.x, entries[0].origin.y, 40.0};
  for (std::size_t k = 1; k < 4; ++k)
    EXPECT_LT(apart(at_corner(entries[1], {0, 0}, middle), at_corner(entries[1 + k], {0, k}, middle)), 0.003);
}

}  // namespace
}  // namespace orthodrive
