// SPDX-License-Identifier: Apache-2.0
// Tiles come back as they were written, and broken ones give one line.
#include "orthodrive/io/tiles/tile_reader.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/memory.hpp"
#include "orthodrive/core/random.hpp"
#include "orthodrive/geo/crs.hpp"
#include "orthodrive/io/raster/raster_io.hpp"
#include "orthodrive/io/tiles/scene_io.hpp"
#include "orthodrive/io/tiles/tileset_io.hpp"
#include "scratch.hpp"

namespace orthodrive {
namespace {
namespace fs = std::filesystem;

SceneTile small_tile() {
  SceneTile tile{
      .column = 1042, .row = 11250, .origin = {500400.0, 5400240.0, 190.0}, .min_z_m = 191.0, .max_z_m = 199.0};
  TriMesh ground{.kind = MeshKind::terrain};
  Random random(3);
  for (int row = 0; row < 10; ++row)
    for (int col = 0; col < 10; ++col) {
      const auto on_grid = [](double v) { return static_cast<float>(std::floor(v * 1024.0) / 1024.0); };
      ground.positions.push_back({on_grid(col * 48.0 - 240.0 + (col % 9 ? random.uniform(0.0, 9.0) : 0.0)),
                                  on_grid(row * 48.0 - 240.0), on_grid(random.uniform(1.0, 9.0))});
      ground.normals.push_back({0.0F, 0.0F, 1.0F});
      ground.uv.push_back({0.1F * static_cast<float>(col), 0.1F * static_cast<float>(row)});
    }
  for (std::uint32_t row = 0; row < 9; ++row)
    for (std::uint32_t col = 0; col < 9; ++col) {
      const std::uint32_t a = 10 * row + col;
      ground.indices.insert(ground.indices.end(), {a, a + 1, a + 11, a, a + 11, a + 10});
    }
  tile.meshes = {ground};
  InstancedMesh& tree = tile.instanced.emplace_back();
  tree.mesh = {.kind = MeshKind::tree,
               .positions = {{-1.0F, 0.0F, 0.0F}, {1.0F, 0.0F, 0.0F}, {0.0F, 0.0F, 1.0F}},
               .normals = {{0.0F, -1.0F, 0.0F}, {0.0F, -1.0F, 0.0F}, {0.0F, -1.0F, 0.0F}},
               .indices = {0, 1, 2},
               .parts = {{SurfaceMaterial::foliage, 0, 3}},
               .tile_uv = {{0.0F, 0.0F}, {1.0F, 0.0F}, {0.5F, 1.0F}}};
  tree.mesh.colors.assign(3, {1000, 2000, 500, 65535});
  tree.instances = {{.position = {10.0F, 20.0F, 3.0F}, .yaw_rad = 0.5F, .scale = {2.0F, 2.5F, 8.0F}}};
  tile.texture_rgb = Raster<std::uint8_t>(16, 16, 3, 90);
  return tile;
}

/// Triangles by their corners in the site CRS, each from its least corner on.
std::vector<std::array<std::array<double, 3>, 3>> triangles_of(const SceneTile& tile, const TriMesh& mesh) {
  std::vector<std::array<std::array<double, 3>, 3>> all;
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    auto& t = all.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) {
      const auto& p = mesh.positions[mesh.indices[i + k]];
      t[k] = {tile.origin.x + double{p[0]}, tile.origin.y + double{p[1]}, tile.origin.z + double{p[2]}};
    }
    std::ranges::rotate(t, std::ranges::min_element(t));
  }
  std::ranges::sort(all);
  return all;
}

class TileReader : public testing::Test {
 protected:
  [[nodiscard]] io::TileFile write(bool compressed) const {
    const SceneTile tile = small_tile();
    io::TileFileOptions options;
    options.compressed = compressed;
    Findings findings;
    io::write_tileset(folder, {io::write_tile_glb(folder, tile, options)}, Crs{"EPSG:32633"},
                      {500000.0, 5400000.0, 190.0}, findings);
    const std::vector<io::TileFile> files = io::read_tileset(folder);
    EXPECT_EQ(files.size(), 1U);
    return files.front();
  }
  const Scratch scratch;
  const fs::path folder = scratch / "tiles";
  void SetUp() override { fs::create_directories(folder); }
};

TEST_F(TileReader, gives_back_what_was_written) {
  const SceneTile tile = small_tile();
  for (const bool compressed : {false, true}) {
    const io::TileFile file = write(compressed);
    EXPECT_EQ(file.column, tile.column);
    EXPECT_EQ(file.bytes, fs::file_size(file.path));
    const SceneTile back = io::read_tile_glb(file);
    ASSERT_EQ(back.meshes.size(), 1U);
    EXPECT_EQ(back.meshes[0].kind, MeshKind::terrain);
    EXPECT_EQ(triangles_of(back, back.meshes[0]), triangles_of(tile, tile.meshes[0])) << compressed;
    for (const auto& n : back.meshes[0].normals) EXPECT_NEAR(n[2], 1.0F, 1e-6F);
    EXPECT_EQ(back.meshes[0].uv.size(), back.meshes[0].positions.size());
    ASSERT_EQ(back.texture_rgb.width, tile.texture_rgb.width);
    EXPECT_NEAR(back.texture_rgb.at(0, 0, 1), tile.texture_rgb.at(0, 0, 1), 3);
    ASSERT_EQ(back.instanced.size(), 1U);
    ASSERT_EQ(back.instanced[0].instances.size(), 1U);
    const MeshInstance& copy = back.instanced[0].instances[0];
    EXPECT_NEAR(copy.yaw_rad, 0.5F, 0.01F);
    EXPECT_NEAR(copy.scale[1], 2.5F, 0.01F);
    EXPECT_NEAR(copy.scale[2], 8.0F, 0.01F);
    EXPECT_NEAR(static_cast<double>(copy.position[2]) + back.origin.z, 193.0, 0.01);
  }
}

TEST_F(TileReader, broken_files_are_read_or_refused_in_one_line) {
  for (const bool compressed : {false, true}) {
    const io::TileFile file = write(compressed);
    std::ifstream stream(file.path, std::ios::binary);
    const std::string whole((std::istreambuf_iterator<char>(stream)), {});
    Random random(11);
    int refused = 0;
    for (int i = 0; i < 400; ++i) {
      std::string broken = whole;
      if (i % 4 == 0) broken.resize(static_cast<std::size_t>(random.uniform(0.0, static_cast<double>(whole.size()))));
      for (int k = 0; k <= i % 7 && !broken.empty(); ++k) {
        // Half of them in the text, where the numbers are that say how long things are.
        const double end = static_cast<double>(i % 2 == 0 ? broken.size() : std::min<std::size_t>(broken.size(), 4000));
        broken[static_cast<std::size_t>(random.uniform(0.0, end))] = static_cast<char>(random.next() % 256);
      }
      std::ofstream(file.path, std::ios::binary) << broken;
      try {
        (void)io::read_tile_glb(file);
      } catch (const InputError& error) {
        ++refused;
        EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
      }
    }
    EXPECT_GT(refused, 100);
  }
}

/// Addresses of tiles become paths: nothing but the name of a tile is one.
TEST_F(TileReader, tiles_lie_in_the_folder) {
  (void)write(false);
  std::ifstream stream(folder / "tileset.json");
  const std::string whole((std::istreambuf_iterator<char>(stream)), {});
  const std::string name = "tile_1042_11250.glb";
  ASSERT_NE(whole.find(name), std::string::npos);
  fs::create_directories(folder / "tile_1_2.glb");
  std::ofstream(scratch / "tile_1_2.glb") << "secret";
  for (const std::string uri :
       {"../tile_1_2.glb", "tile_1_2.glb/../../tile_1_2.glb", "/tile_1_2.glb", "tile_1_2.glb\\u0000",
        "http://a/tile_1_2.glb", "tile_99999999999999999999_2.glb", "tile_1_2.gltf", "level1_1.glb", ""}) {
    std::string changed = whole;
    changed.replace(changed.find(name), name.size(), uri);
    std::ofstream(folder / "tileset.json") << changed;
    EXPECT_THROW((void)io::read_tileset(folder), InputError) << uri;
  }
}

/// A small file that says it is large, or that says the same thing many times, is refused before memory is taken.
TEST_F(TileReader, small_files_do_not_become_large) {
  std::string deep = R"({"asset": {"extras": {"orthodrive": {"origin": [0, 0, 0]}}}, "root": )";
  constexpr int levels = 100'000;
  for (int i = 0; i < levels; ++i) deep += R"({"children": [)";
  deep += "{}";
  for (int i = 0; i < levels; ++i) deep += "]}";
  std::ofstream(folder / "tileset.json") << deep << "}";
  EXPECT_THROW((void)io::read_tileset(folder), InputError);

  const auto glb = [&](std::string json, std::size_t bytes) {
    json.resize((json.size() + 3) / 4 * 4, ' ');
    const auto word = [](std::size_t value) {
      std::string text(4, '\0');
      for (char& c : text) c = static_cast<char>(value & 255), value >>= 8;
      return text;
    };
    std::ofstream(folder / "tile_0_0.glb", std::ios::binary)
        << "glTF" << word(2) << word(28 + json.size() + bytes) << word(json.size()) << "JSON" << json << word(bytes)
        << std::string("BIN\0", 4) << std::string(bytes, '\xa0');
    const std::uint64_t before = peak_memory_bytes();
    EXPECT_THROW((void)io::read_tile_glb({.path = folder / "tile_0_0.glb"}), InputError);
    EXPECT_LT(peak_memory_bytes(), before + (std::uint64_t{1} << 30));
  };
  const std::string mesh = R"("meshes": [{"name": "terrain", "primitives": [{"indices": 0,
    "attributes": {"POSITION": 0, "NORMAL": 0, "TEXCOORD_0": 0}}]}], )";
  glb("{" + mesh +
          R"("nodes": [{"mesh": 0}], "accessors": [{"componentType": 5126, "type": "VEC3", "count": 9, "bufferView": 0}],
    "bufferViews": [{"byteLength": 40, "extensions": {"EXT_meshopt_compression": {"byteLength": 40, "count": 4000000,
    "byteStride": 256, "mode": "ATTRIBUTES"}}}]})",
      40);
  std::string nodes;
  for (int i = 0; i < 20'000; ++i) nodes += R"({"mesh": 0},)";
  nodes.pop_back();
  glb("{" + mesh + R"("nodes": [)" + nodes + R"(], "accessors": [{"componentType": 5121, "type": "VEC3", "count": 30000,
    "bufferView": 0}], "bufferViews": [{"byteLength": 90000}]})",
      90'000);
}

/// Pictures inside of files are pictures: other formats of GDAL's refer to files and addresses.
TEST(DecodeImage, takes_pictures_only) {
  const std::string vrt =
      R"(<VRTDataset rasterXSize="1" rasterYSize="1"><VRTRasterBand dataType="Byte" band="1"><SimpleSource>
<SourceFilename>/etc/hostname</SourceFilename></SimpleSource></VRTRasterBand></VRTDataset>)";
  EXPECT_THROW((void)io::decode_image({reinterpret_cast<const std::uint8_t*>(vrt.data()), vrt.size()}), InputError);
}

TEST_F(TileReader, another_tileset_is_refused) {
  EXPECT_THROW((void)io::read_tileset(folder), InputError);
  std::ofstream(folder / "tileset.json") << R"({"asset": {"version": "1.1"}, "root": {"content": {"uri": "b3dm"}}})";
  EXPECT_THROW((void)io::read_tileset(folder), InputError);
}

}  // namespace
}  // namespace orthodrive
