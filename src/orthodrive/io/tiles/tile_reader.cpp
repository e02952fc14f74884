// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/tiles/tile_reader.hpp"

#include <fmt/format.h>
#include <meshoptimizer.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>
#include <regex>
#include <span>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/printable.hpp"
#include "orthodrive/core/whole_number.hpp"
#include "orthodrive/io/raster/raster_io.hpp"
#include "orthodrive/io/tiles/glb_file.hpp"

namespace orthodrive::io {
namespace fs = std::filesystem;
using Json = nlohmann::json;

namespace {

std::size_t size_of(int type) {
  switch (type) {
    case byte_type:
    case unsigned_byte_type:
      return 1;
    case short_type:
    case unsigned_short_type:
      return 2;
    case unsigned_int_type:
    case float_type:
      return 4;
    default:
      throw Error(fmt::format("component type {} is not of glTF", type));
  }
}

std::size_t component_count(const std::string& type) {
  for (const auto& [name, width] : {std::pair{"SCALAR", 1U}, {"VEC2", 2U}, {"VEC3", 3U}, {"VEC4", 4U}})
    if (type == name) return width;
  throw Error("accessor of type " + type);
}

double number_at(const std::uint8_t* at, int type, bool normalized) {
  const auto read = [&]<typename T>(T value, double full) {
    std::memcpy(&value, at, sizeof value);
    return static_cast<double>(value) / (normalized ? full : 1.0);
  };
  switch (type) {
    case byte_type:
      return read(std::int8_t{}, 127.0);
    case unsigned_byte_type:
      return read(std::uint8_t{}, 255.0);
    case short_type:
      return read(std::int16_t{}, 32767.0);
    case unsigned_short_type:
      return read(std::uint16_t{}, 65535.0);
    case unsigned_int_type:
      return read(std::uint32_t{}, 1.0);
    default:
      return read(float{}, 1.0);
  }
}

std::size_t count_of(const Json& value) { return whole_number<std::size_t>(value, "a count, a length or an index"); }
std::size_t count_or_zero(const Json& object, const char* name) {
  const auto found = object.find(name);
  return found == object.end() ? 0 : count_of(*found);
}

/// A glb in memory.
class Glb {
 public:
  explicit Glb(const fs::path& path) {
    std::ifstream stream(path, std::ios::binary);
    bytes_.assign(std::istreambuf_iterator<char>(stream), {});
    if (!stream.good() && !stream.eof()) throw Error("cannot be read");
    const std::size_t json_size = word(12);
    if (word(0) != 0x46546c67U || word(16) != 0x4e4f534aU || json_size > bytes_.size() - 20)
      throw Error("is no binary glTF");
    json = Json::parse(bytes_.begin() + 20, bytes_.begin() + 20 + static_cast<std::ptrdiff_t>(json_size));
    bin_ = 20 + json_size + 8;
  }

  /// All numbers of an accessor, element after element.
  [[nodiscard]] std::vector<double> numbers(const Json& index) {
    const Json& accessor = json.at("accessors").at(count_of(index));
    const int type = whole_number<int>(accessor.at("componentType"), "a componentType");
    const std::size_t width = component_count(accessor.at("type")), count = count_of(accessor.at("count")),
                      size = size_of(type);
    const std::size_t view_index = count_of(accessor.at("bufferView")), offset = count_or_zero(accessor, "byteOffset");
    const View& view = unpacked(view_index);
    const std::size_t stride = view.stride > 0 ? view.stride : width * size;
    const std::size_t size_of_all = view.bytes.size();
    if (count > size_of_all || offset > size_of_all || stride > size_of_all ||
        (count > 0 && (count - 1) * stride + width * size > size_of_all - offset))
      throw Error(fmt::format("accessor {} reaches beyond its view", index.dump()));
    // Any number of meshes may show the same accessor, each with a copy of its own.
    constexpr std::size_t most_numbers = 50'000'000;  // of a file; our tiles have some 100 000
    if (count * width > most_numbers - numbers_read_) throw Error("its meshes are absurdly large");
    numbers_read_ += count * width;
    std::vector<double> values;
    values.reserve(count * width);
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t k = 0; k < width; ++k)
        values.push_back(
            number_at(&view.bytes[offset + i * stride + k * size], type, accessor.value("normalized", false)));
    return values;
  }

  /// The picture that a material shows, if it lies in the file.
  [[nodiscard]] std::span<const std::uint8_t> picture_of(const Json& material) const {
    const auto shown = material.find("pbrMetallicRoughness");
    if (shown == material.end() || !shown->contains("baseColorTexture")) return {};
    const Json& texture = json.at("textures").at(count_of(shown->at("baseColorTexture").at("index")));
    const Json& source = texture.contains("source") ? texture : texture.at("extensions").at("EXT_texture_webp");
    const Json& image = json.at("images").at(count_of(source.at("source")));
    if (!image.contains("bufferView")) return {};
    return part(json.at("bufferViews").at(count_of(image.at("bufferView"))));
  }

  Json json;

 private:
  struct View {
    std::vector<std::uint8_t> bytes;
    std::size_t stride = 0;
  };

  [[nodiscard]] std::uint32_t word(std::size_t at) const {
    if (bytes_.size() < at + 4) throw Error("ends too soon");
    std::uint32_t value = 0;
    std::memcpy(&value, &bytes_[at], sizeof value);
    return value;
  }

  [[nodiscard]] std::span<const std::uint8_t> part(const Json& view) const {
    const std::size_t offset = count_or_zero(view, "byteOffset"), length = count_of(view.at("byteLength"));
    if (bin_ > bytes_.size() || offset > bytes_.size() - bin_ || length > bytes_.size() - bin_ - offset)
      throw Error("a view reaches beyond the file");
    return std::span(bytes_).subspan(bin_ + offset, length);
  }

  const View& unpacked(std::size_t index) {
    const Json& view = json.at("bufferViews").at(index);
    if (views_.size() <= index) views_.resize(index + 1);
    std::optional<View>& known = views_[index];
    if (known) return *known;
    View& result = known.emplace();
    result.stride = count_or_zero(view, "byteStride");
    if (!view.contains("extensions")) {
      const auto bytes = part(view);
      result.bytes.assign(bytes.begin(), bytes.end());
      return result;
    }
    const Json& packed = view.at("extensions").at("EXT_meshopt_compression");
    const auto from = part(packed);
    const std::size_t count = count_of(packed.at("count")), stride = count_of(packed.at("byteStride"));
    // The codec needs two bits for 16 bytes that are alike: a view does not expand further.
    constexpr std::size_t largest_stride = 256, most_expansion = 64, slack = 65536;
    if (stride == 0 || stride > largest_stride || count > (most_expansion * from.size() + slack) / stride)
      throw Error("a view is absurdly large");
    result.bytes.resize(count * stride);
    result.stride = count_or_zero(view, "byteStride");
    const bool are_indices = packed.at("mode") == "TRIANGLES";
    if (are_indices ? count % 3 != 0 || (stride != 2 && stride != 4) : stride % 4 != 0)
      throw Error("a view has an odd size");
    const int wrong = are_indices
                          ? meshopt_decodeIndexBuffer(result.bytes.data(), count, stride, from.data(), from.size())
                          : meshopt_decodeVertexBuffer(result.bytes.data(), count, stride, from.data(), from.size());
    if (wrong != 0) throw Error("a compressed view is broken");
    const std::string filter = packed.value("filter", "");
    if (filter == "EXPONENTIAL") meshopt_decodeFilterExp(result.bytes.data(), count, stride);
    if (filter == "OCTAHEDRAL" && (stride == 4 || stride == 8))
      meshopt_decodeFilterOct(result.bytes.data(), count, stride);
    return result;
  }

  std::vector<std::uint8_t> bytes_;
  std::size_t bin_ = 0, numbers_read_ = 0;
  std::vector<std::optional<View>> views_;
};

/// glTF's axes (y up) to x east, y north, z up.
std::vector<std::array<float, 3>> z_up(const std::vector<double>& values) {
  std::vector<std::array<float, 3>> result;
  for (std::size_t i = 0; i + 2 < values.size(); i += 3)
    result.push_back(
        {static_cast<float>(values[i]), static_cast<float>(-values[i + 2]), static_cast<float>(values[i + 1])});
  return result;
}

MeshKind kind_of(const std::string& name) {
  for (int k = 0; k < static_cast<int>(mesh_kind_count); ++k)
    if (to_string(static_cast<MeshKind>(k)) == name) return static_cast<MeshKind>(k);
  throw Error("mesh \"" + name + "\" is none of a scene's");
}

TriMesh read_mesh(Glb& glb, const Json& index) {
  const Json& mesh = glb.json.at("meshes").at(count_of(index));
  TriMesh result{.kind = kind_of(mesh.at("name"))};
  for (const Json& primitive : mesh.at("primitives")) {
    const Json& attributes = primitive.at("attributes");
    if (result.positions.empty()) {
      result.positions = z_up(glb.numbers(attributes.at("POSITION")));
      result.normals = z_up(glb.numbers(attributes.at("NORMAL")));
      if (result.normals.size() != result.positions.size()) throw Error("a mesh lacks normals");
      const std::vector<double> uv = glb.numbers(attributes.at("TEXCOORD_0"));
      for (std::size_t i = 0; i + 1 < uv.size(); i += 2)
        result.uv.push_back({static_cast<float>(uv[i]), static_cast<float>(uv[i + 1])});
    }
    const std::size_t first = result.indices.size();
    for (const double v : glb.numbers(primitive.at("indices"))) {
      if (!(v >= 0.0 && v < static_cast<double>(result.positions.size()))) throw Error("an index lies beyond its mesh");
      result.indices.push_back(static_cast<std::uint32_t>(v));
    }
    if ((result.indices.size() - first) % 3 != 0) throw Error("a mesh has a part of a triangle");
    result.parts.push_back({SurfaceMaterial::photo, first, result.indices.size() - first});
  }
  return result;
}

std::vector<MeshInstance> read_copies(Glb& glb, const Json& attributes) {
  const auto positions = z_up(glb.numbers(attributes.at("TRANSLATION")));
  const std::vector<double> turns = glb.numbers(attributes.at("ROTATION")),
                            scales = glb.numbers(attributes.at("SCALE"));
  if (turns.size() != 4 * positions.size() || scales.size() != 3 * positions.size()) throw Error("copies lack numbers");
  std::vector<MeshInstance> copies;
  copies.reserve(positions.size());
  for (std::size_t i = 0; i < positions.size(); ++i)
    copies.push_back({.position = positions[i],
                      .yaw_rad = static_cast<float>(2.0 * std::atan2(turns[4 * i + 1], turns[4 * i + 3])),
                      .scale = {static_cast<float>(scales[3 * i]), static_cast<float>(scales[3 * i + 2]),
                                static_cast<float>(scales[3 * i + 1])}});
  return copies;
}

/// The level, column and row that the name of a tile says. No other text: it becomes a path.
void read_tile_name(const std::string& uri, TileFile& file) {
  constexpr std::size_t longest = 64;  // of a name whose numbers fit
  static const std::regex form("(?:level([0-9]{1,2})|tile)_(-?[0-9]{1,9})_(-?[0-9]{1,9})\\.glb");
  std::smatch parts;
  if (uri.size() > longest || !std::regex_match(uri, parts, form))
    throw Error("tile \"" + printable(uri) + "\" is none of ours");
  if (parts[1].matched) file.level = std::stoi(parts[1]);
  file.column = std::stoi(parts[2]), file.row = std::stoi(parts[3]);
}

constexpr int deepest = 64;  // levels of a tileset: each has tiles of twice the size

void add_tiles(const Json& tile, const fs::path& folder, Vec3 site_origin, std::vector<TileFile>& files,
               int depth = 0) {
  if (depth > deepest) throw Error(fmt::format("tiles lie in each other more than {} deep", deepest));
  if (tile.contains("content")) {
    const std::string uri = tile.at("content").at("uri");
    TileFile file{.path = folder / uri, .geometric_error_m = tile.at("geometricError")};
    read_tile_name(uri, file);
    const Json& origin = tile.at("extras").at("origin");
    file.origin = site_origin + Vec3{origin.at(0), origin.at(1), origin.at(2)};
    file.bytes = fs::file_size(file.path);
    files.push_back(std::move(file));
  }
  const auto children = tile.find("children");  // by reference: a copy descends all levels
  if (children == tile.end()) return;
  for (const Json& child : *children) add_tiles(child, folder, site_origin, files, depth + 1);
}

/// What reading throws, with the file's name.
template <typename Read>
auto with_name(const fs::path& path, const Read& read) {
  try {
    return read();
  } catch (const std::exception& error) {
    throw InputError(path.string(),
                     fmt::format("is no tile of ours: {}; write it with `orthodrive scene`", printable(error.what())));
  }
}

}  // namespace

std::vector<TileFile> read_tileset(const fs::path& folder) {
  const fs::path path = folder / "tileset.json";
  if (!fs::exists(path)) throw InputError(path.string(), "no such file; give the folder that `orthodrive scene` wrote");
  return with_name(path, [&] {
    std::ifstream stream(path);
    const Json tileset = Json::parse(stream);
    const Json& origin = tileset.at("asset").at("extras").at("orthodrive").at("origin");
    std::vector<TileFile> files;
    add_tiles(tileset.at("root"), folder, {origin.at(0), origin.at(1), origin.at(2)}, files);
    return files;
  });
}

SceneTile read_tile_glb(const TileFile& file) {
  return with_name(file.path, [&] {
    Glb glb(file.path);
    SceneTile tile{.level = file.level,
                   .column = file.column,
                   .row = file.row,
                   .origin = file.origin,
                   .geometric_error_m = file.geometric_error_m};
    const Json no_materials = Json::array();
    const auto materials = glb.json.find("materials");
    for (const Json& material : materials == glb.json.end() ? no_materials : *materials)
      if (material.value("name", "") == to_string(SurfaceMaterial::photo))
        if (const auto bytes = glb.picture_of(material); !bytes.empty()) tile.texture_rgb = decode_image(bytes);
    for (const Json& node : glb.json.at("nodes")) {
      TriMesh mesh = read_mesh(glb, node.at("mesh"));
      if (node.contains("extensions") && node.at("extensions").contains("EXT_mesh_gpu_instancing")) {
        const Json& attributes = node.at("extensions").at("EXT_mesh_gpu_instancing").at("attributes");
        tile.instanced.push_back({std::move(mesh), read_copies(glb, attributes)});
      } else {
        tile.meshes.push_back(std::move(mesh));
      }
    }
    return tile;
  });
}

}  // namespace orthodrive::io
