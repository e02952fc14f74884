#include "orthodrive/io/scene_io.hpp"

#include <fmt/format.h>
#include <tiny_gltf.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>

#include "orthodrive/core/atomic_file.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/io/raster_io.hpp"

namespace orthodrive::io {
namespace {

/// glTF is y up: east, up, south. 3D Tiles turns it back.
std::array<float, 3> y_up(const std::array<float, 3>& v) { return {v[0], v[2], -v[1]}; }

/// Appends values to the only buffer, each block on a multiple of eight bytes (EXT_structural_metadata wants that; glTF
/// four), and describes them by view and accessor.
class GltfBuffer {
 public:
  explicit GltfBuffer(tinygltf::Model& model) : model_(model) { model_.buffers.emplace_back(); }

  int add_view(const void* bytes, std::size_t size, int target) {
    auto& data = model_.buffers[0].data;
    data.resize((data.size() + 7) / 8 * 8);
    tinygltf::BufferView view;
    view.buffer = 0;
    view.byteOffset = data.size();
    view.byteLength = size;
    view.target = target;
    const auto* first = static_cast<const unsigned char*>(bytes);
    data.insert(data.end(), first, first + size);
    model_.bufferViews.push_back(view);
    return static_cast<int>(model_.bufferViews.size()) - 1;
  }
  template <typename T>
  tinygltf::Accessor& add_accessor(const std::vector<T>& values, int target, int component_type, int type) {
    tinygltf::Accessor accessor;
    accessor.bufferView = add_view(values.data(), values.size() * sizeof(T), target);
    accessor.componentType = component_type;
    accessor.type = type;
    accessor.count = values.size();
    model_.accessors.push_back(accessor);
    return model_.accessors.back();
  }
  [[nodiscard]] int last_accessor() const { return static_cast<int>(model_.accessors.size()) - 1; }

 private:
  tinygltf::Model& model_;
};

/// The vertices of a mesh, as the primitives of its parts share them.
std::map<std::string, int> add_vertices(GltfBuffer& buffer, const TriMesh& mesh) {
  std::map<std::string, int> attributes;
  const auto add = [&](const char* name, const auto& values, int component_type, int type) -> tinygltf::Accessor& {
    auto& accessor = buffer.add_accessor(values, TINYGLTF_TARGET_ARRAY_BUFFER, component_type, type);
    attributes[name] = buffer.last_accessor();
    return accessor;
  };
  std::vector<std::array<float, 3>> positions, normals;
  std::array<float, 3> low, high;
  low.fill(std::numeric_limits<float>::max());
  high.fill(std::numeric_limits<float>::lowest());
  for (const auto& p : mesh.positions) {
    positions.push_back(y_up(p));
    for (std::size_t k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], positions.back()[k]);
      high[k] = std::max(high[k], positions.back()[k]);
    }
  }
  for (const auto& n : mesh.normals) normals.push_back(y_up(n));
  auto& accessor = add("POSITION", positions, TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_VEC3);
  accessor.minValues.assign(low.begin(), low.end());
  accessor.maxValues.assign(high.begin(), high.end());
  add("NORMAL", normals, TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_VEC3);
  // glTF counts sets of coordinates from 0 without a gap: what shows no photo has the second set as its first, too.
  if (!mesh.uv.empty()) add("TEXCOORD_0", mesh.uv, TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_VEC2);
  if (!mesh.tile_uv.empty()) add("TEXCOORD_1", mesh.tile_uv, TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_VEC2);
  if (mesh.uv.empty()) attributes["TEXCOORD_0"] = attributes.at("TEXCOORD_1");
  if (!mesh.tangents.empty()) {
    std::vector<std::array<float, 4>> tangents;
    for (const auto& t : mesh.tangents) tangents.push_back({t[0], t[2], -t[1], t[3]});
    add("TANGENT", tangents, TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_VEC4);
  }
  if (!mesh.colors.empty()) {
    add("COLOR_0", mesh.colors, TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT, TINYGLTF_TYPE_VEC4).normalized = true;
  }
  return attributes;
}

tinygltf::Primitive add_part(GltfBuffer& buffer, const TriMesh& mesh, const MeshPart& part,
                             const std::map<std::string, int>& vertices, int material) {
  tinygltf::Primitive primitive;
  primitive.mode = TINYGLTF_MODE_TRIANGLES;
  primitive.material = material;
  primitive.attributes = vertices;
  const auto first = mesh.indices.begin() + static_cast<std::ptrdiff_t>(part.first_index);
  const std::vector<std::uint32_t> indices(first, first + static_cast<std::ptrdiff_t>(part.index_count));
  buffer.add_accessor(indices, TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER, TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT,
                      TINYGLTF_TYPE_SCALAR);
  primitive.indices = buffer.last_accessor();
  return primitive;
}

using Value = tinygltf::Value;

int add_texture(tinygltf::Model& model, tinygltf::Image image, int min_filter, int mag_filter, int wrap) {
  model.images.push_back(std::move(image));
  tinygltf::Sampler sampler;
  sampler.minFilter = min_filter;
  sampler.magFilter = mag_filter;
  sampler.wrapS = sampler.wrapT = wrap;
  model.samplers.push_back(sampler);
  tinygltf::Texture texture;
  texture.source = static_cast<int>(model.images.size()) - 1;
  texture.sampler = static_cast<int>(model.samplers.size()) - 1;
  model.textures.push_back(texture);
  return static_cast<int>(model.textures.size()) - 1;
}

/// A picture of the whole tile, inside the file. Returns the index of the new texture.
int add_tile_texture(tinygltf::Model& model, int image_view, const char* mime_type, int min_filter, int mag_filter) {
  tinygltf::Image image;
  image.mimeType = mime_type;
  image.bufferView = image_view;
  return add_texture(model, std::move(image), min_filter, mag_filter, TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE);
}

/// A tileable picture beside the file.
int add_tileable_texture(tinygltf::Model& model, std::string uri) {
  tinygltf::Image image;
  image.uri = std::move(uri);
  return add_texture(model, std::move(image), TINYGLTF_TEXTURE_FILTER_LINEAR_MIPMAP_LINEAR,
                     TINYGLTF_TEXTURE_FILTER_LINEAR, TINYGLTF_TEXTURE_WRAP_REPEAT);
}

/// The photo holds its own light, so the material is unlit where the viewer can do that.
int add_photo_material(tinygltf::Model& model, GltfBuffer& buffer, const Raster<std::uint8_t>& rgb) {
  tinygltf::Material material;
  material.name = "photo";
  material.pbrMetallicRoughness.metallicFactor = 0.0;
  material.pbrMetallicRoughness.roughnessFactor = 1.0;
  material.extensions["KHR_materials_unlit"] = Value(Value::Object{});
  model.extensionsUsed.push_back("KHR_materials_unlit");
  if (!rgb.empty()) {
    const auto jpeg = encode_jpeg(rgb);
    material.pbrMetallicRoughness.baseColorTexture.index =
        add_tile_texture(model, buffer.add_view(jpeg.data(), jpeg.size(), 0), "image/jpeg",
                         TINYGLTF_TEXTURE_FILTER_LINEAR_MIPMAP_LINEAR, TINYGLTF_TEXTURE_FILTER_LINEAR);
  }
  model.materials.push_back(material);
  return 0;
}

/// The mesh's colours times a tileable texture, both in the mesh's second set of coordinates.
int add_tileable_material(tinygltf::Model& model, SurfaceMaterial of) {
  tinygltf::Material material;
  material.name = std::string(to_string(of));
  const auto texture = [&](std::string_view picture) {
    return add_tileable_texture(model, material_file(of, picture));
  };
  auto& pbr = material.pbrMetallicRoughness;
  pbr.baseColorTexture.index = texture("color");
  pbr.metallicRoughnessTexture.index = texture("roughness");
  material.normalTexture.index = texture("normal");
  pbr.baseColorTexture.texCoord = pbr.metallicRoughnessTexture.texCoord = material.normalTexture.texCoord = 1;
  pbr.metallicFactor = 0.0;
  if (of == SurfaceMaterial::verge) material.alphaMode = "BLEND";
  model.materials.push_back(material);
  return static_cast<int>(model.materials.size()) - 1;
}

/// The index of each material that the tile's meshes have.
class TileMaterials {
 public:
  TileMaterials(tinygltf::Model& model, GltfBuffer& buffer, const Raster<std::uint8_t>& photo) : model_(model) {
    at_[SurfaceMaterial::photo] = add_photo_material(model, buffer, photo);
  }
  int index(SurfaceMaterial material) {
    const auto [at, is_new] = at_.try_emplace(material, 0);
    if (is_new) at->second = add_tileable_material(model_, material);
    return at->second;
  }

 private:
  tinygltf::Model& model_;
  std::map<SurfaceMaterial, int> at_;
};

Value strings_property(GltfBuffer& buffer, const std::vector<std::string>& strings) {
  std::string text;
  std::vector<std::uint32_t> offsets = {0};
  for (const std::string& s : strings) {
    text += s;
    offsets.push_back(static_cast<std::uint32_t>(text.size()));
  }
  const int values = buffer.add_view(text.data(), text.size(), 0);
  const int ends = buffer.add_view(offsets.data(), offsets.size() * sizeof(offsets[0]), 0);
  return Value(Value::Object{{"values", Value(values)}, {"stringOffsets", Value(ends)}});
}

/// What the photo shows, the 3D Tiles 1.1 way: a feature id texture (EXT_mesh_features) whose ids are the rows of a
/// table with each class's name and role (EXT_structural_metadata). Returns the extension of the primitives.
Value add_labels(tinygltf::Model& model, GltfBuffer& buffer, const Raster<std::uint8_t>& labels,
                 const ClassTable& table) {
  const auto png = encode_png(labels);
  const int texture = add_tile_texture(model, buffer.add_view(png.data(), png.size(), 0), "image/png",
                                       TINYGLTF_TEXTURE_FILTER_NEAREST, TINYGLTF_TEXTURE_FILTER_NEAREST);
  std::vector<std::string> names, roles;
  for (const ClassInfo& info : table.classes) names.push_back(info.name), roles.push_back(to_string(info.role));
  const int count = static_cast<int>(names.size());
  const Value string_type(Value::Object{{"type", Value(std::string("STRING"))}});
  const Value schema(Value::Object{
      {"id", Value(std::string("orthodrive"))},
      {"classes", Value(Value::Object{
                      {"label", Value(Value::Object{{"properties", Value(Value::Object{{"name", string_type},
                                                                                       {"role", string_type}})}})}})}});
  const Value properties(
      Value::Object{{"name", strings_property(buffer, names)}, {"role", strings_property(buffer, roles)}});
  const Value rows(
      Value::Object{{"class", Value(std::string("label"))}, {"count", Value(count)}, {"properties", properties}});
  model.extensions["EXT_structural_metadata"] =
      Value(Value::Object{{"schema", schema}, {"propertyTables", Value(Value::Array{rows})}});
  model.extensionsUsed.push_back("EXT_structural_metadata");
  model.extensionsUsed.push_back("EXT_mesh_features");
  const Value channel(Value::Array{Value(0)});
  const Value ids(Value::Object{
      {"featureCount", Value(count)},
      {"nullFeatureId", Value(static_cast<int>(label_nodata))},
      {"label", Value(std::string("label"))},
      {"texture", Value(Value::Object{{"index", Value(texture)}, {"texCoord", Value(0)}, {"channels", channel}})},
      {"propertyTable", Value(0)}});
  return Value(Value::Object{{"featureIds", Value(Value::Array{ids})}});
}

struct Frame {
  Vec3 east, north, up, at;
};

Vec3 cross_product(Vec3 a, Vec3 b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
double norm(Vec3 a) { return std::sqrt(a.x * a.x + a.y * a.y + a.z * a.z); }

/// How one metre of the site CRS to the east, to the north and up lies in ECEF at the origin: turned by the meridian
/// convergence and stretched by the scale of the projection (UTM: conformal). Heights are stretched alike, by 0.04 % at
/// most, because renderers expect a uniform scale.
Frame ecef_frame(const Crs& crs, Vec3 origin) {
  constexpr double step_m = 100.0;
  const CoordinateTransform to_geographic(crs, Crs{"EPSG:4326"});
  const auto ecef = [&](double dx, double dy) {
    const Vec2 lonlat = to_geographic.target_from_source({origin.x + dx, origin.y + dy});
    return ecef_from_geographic(lonlat.x, lonlat.y, origin.z);
  };
  const Vec2 lonlat = to_geographic.target_from_source({origin.x, origin.y});
  const double lon = lonlat.x * std::numbers::pi / 180.0, lat = lonlat.y * std::numbers::pi / 180.0;
  const Vec3 up{std::cos(lat) * std::cos(lon), std::cos(lat) * std::sin(lon), std::sin(lat)};
  const Vec3 east = (ecef(step_m, 0.0) - ecef(-step_m, 0.0)) * (0.5 / step_m);
  const Vec3 north = (ecef(0.0, step_m) - ecef(0.0, -step_m)) * (0.5 / step_m);
  const double scale = 0.5 * (norm(east) + norm(north));
  const Vec3 unit_east = east * (1.0 / norm(east));
  return {unit_east * scale, cross_product(up, unit_east) * scale, up * scale, ecef(0.0, 0.0)};
}

using Json = nlohmann::ordered_json;

Json box_json(const Box2& b, double min_z, double max_z) {
  const double x = 0.5 * b.width(), y = 0.5 * b.height(), z = 0.5 * (max_z - min_z);
  return {{"box", {b.min_x + x, b.min_y + y, min_z + z, x, 0.0, 0.0, 0.0, y, 0.0, 0.0, 0.0, z}}};
}

}  // namespace

/// EXT_mesh_gpu_instancing: where the copies of a node's mesh stand. _COLOR_0 is their tint (three.js reads it).
Value instancing(GltfBuffer& buffer, const std::vector<MeshInstance>& instances) {
  std::vector<std::array<float, 3>> translations, scales, tints;
  std::vector<std::array<float, 4>> rotations;
  for (const MeshInstance& copy : instances) {
    translations.push_back(y_up(copy.position));
    scales.push_back({copy.scale[0], copy.scale[2], copy.scale[1]});
    rotations.push_back({0.0F, std::sin(0.5F * copy.yaw_rad), 0.0F, std::cos(0.5F * copy.yaw_rad)});
    tints.push_back(copy.tint);
  }
  Value::Object attributes;
  const auto add = [&](const char* name, const auto& values, int type) {
    (void)buffer.add_accessor(values, 0, TINYGLTF_COMPONENT_TYPE_FLOAT, type);
    attributes[name] = Value(buffer.last_accessor());
  };
  add("TRANSLATION", translations, TINYGLTF_TYPE_VEC3);
  add("ROTATION", rotations, TINYGLTF_TYPE_VEC4);
  add("SCALE", scales, TINYGLTF_TYPE_VEC3);
  add("_COLOR_0", tints, TINYGLTF_TYPE_VEC3);
  return Value(Value::Object{{"attributes", Value(attributes)}});
}

TileEntry write_tile_glb(const std::filesystem::path& folder, const SceneTile& tile, Vec3 site_origin) {
  tinygltf::Model model;
  model.asset.version = "2.0";
  model.asset.generator = "Orthodrive";
  GltfBuffer buffer(model);
  TileMaterials materials(model, buffer, tile.texture_rgb);
  std::optional<Value> features;
  if (!tile.labels.empty()) features = add_labels(model, buffer, tile.labels, tile.classes);
  const Vec3 shift = tile.origin - site_origin;
  tinygltf::Scene scene;
  TileEntry entry{fmt::format("tile_{}_{}.glb", tile.column, tile.row)};
  bool first = true;
  const auto include = [&](const std::array<float, 3>& p, float reach_m) {
    const Vec2 q{tile.origin.x + static_cast<double>(p[0]), tile.origin.y + static_cast<double>(p[1])};
    const Box2 box = Box2{q.x, q.y, q.x, q.y}.grown(static_cast<double>(reach_m));
    if (first) entry.bounds = box;
    first = false;
    entry.bounds = {std::min(entry.bounds.min_x, box.min_x), std::min(entry.bounds.min_y, box.min_y),
                    std::max(entry.bounds.max_x, box.max_x), std::max(entry.bounds.max_y, box.max_y)};
  };
  for (const TriMesh& mesh : tile.meshes) {
    tinygltf::Mesh gltf_mesh;
    gltf_mesh.name = std::string(to_string(mesh.kind));
    const auto vertices = add_vertices(buffer, mesh);
    const std::vector<MeshPart> whole = {{SurfaceMaterial::photo, 0, mesh.indices.size()}};
    for (const MeshPart& part : mesh.parts.empty() ? whole : mesh.parts) {
      gltf_mesh.primitives.push_back(add_part(buffer, mesh, part, vertices, materials.index(part.material)));
      if (features && !mesh.uv.empty()) gltf_mesh.primitives.back().extensions["EXT_mesh_features"] = *features;
    }
    tinygltf::Node node;
    node.name = gltf_mesh.name;
    node.mesh = static_cast<int>(model.meshes.size());
    node.translation = {shift.x, shift.z, -shift.y};
    scene.nodes.push_back(static_cast<int>(model.nodes.size()));
    model.meshes.push_back(std::move(gltf_mesh));
    model.nodes.push_back(std::move(node));
    for (const auto& p : mesh.positions) include(p, 0.0F);
  }
  for (const InstancedMesh& copied : tile.instanced) {
    tinygltf::Mesh gltf_mesh;
    gltf_mesh.name = std::string(to_string(copied.mesh.kind));
    const auto vertices = add_vertices(buffer, copied.mesh);
    for (const MeshPart& part : copied.mesh.parts)
      gltf_mesh.primitives.push_back(add_part(buffer, copied.mesh, part, vertices, materials.index(part.material)));
    tinygltf::Node node;
    node.name = gltf_mesh.name;
    node.mesh = static_cast<int>(model.meshes.size());
    node.translation = {shift.x, shift.z, -shift.y};
    for (const MeshInstance& copy : copied.instances) include(copy.position, std::max(copy.scale[0], copy.scale[1]));
    node.extensions["EXT_mesh_gpu_instancing"] = instancing(buffer, copied.instances);
    scene.nodes.push_back(static_cast<int>(model.nodes.size()));
    model.meshes.push_back(std::move(gltf_mesh));
    model.nodes.push_back(std::move(node));
  }
  if (!tile.instanced.empty()) {  // a reader that draws no copies would draw one in the middle: better none
    model.extensionsUsed.push_back("EXT_mesh_gpu_instancing");
    model.extensionsRequired.push_back("EXT_mesh_gpu_instancing");
  }
  entry.min_z_m = tile.min_z_m, entry.max_z_m = tile.max_z_m;
  model.scenes.push_back(scene);
  model.defaultScene = 0;

  const std::filesystem::path target = folder / entry.uri;
  AtomicFile out(target);
  std::ofstream stream(out.path(), std::ios::binary);
  tinygltf::TinyGLTF writer;
  writer.SetImageWriter(nullptr, nullptr);  // pictures are in the buffer or files of their own
  const bool written = writer.WriteGltfSceneToStream(&model, stream, false, true);
  stream.close();
  if (!written || !stream)
    throw Error(target.string() + ": cannot be written, is the disk full or the folder read-only?");
  out.commit();
  return entry;
}

std::string material_file(SurfaceMaterial material, std::string_view picture) {
  return fmt::format("materials/{}_{}.jpg", to_string(material), picture);
}

void write_material(const std::filesystem::path& folder, SurfaceMaterial material, const SurfaceTexture& texture) {
  const auto write = [&](std::string_view picture, const Raster<std::uint8_t>& rgb) {
    const std::filesystem::path file = folder / material_file(material, picture);
    std::filesystem::create_directories(file.parent_path());
    const auto bytes = encode_jpeg(rgb);
    write_text_file(file, std::string(bytes.begin(), bytes.end()));
  };
  write("color", texture.color_rgb);
  write("normal", texture.normal_rgb);
  write("roughness", texture.roughness);
}

void write_tileset(const std::filesystem::path& folder, const std::vector<TileEntry>& tiles, const Crs& crs,
                   Vec3 site_origin) {
  // Not drawn, only compared: the error of a scene without any tile. Bigger than any screen error a viewer accepts.
  constexpr double nothing_drawn_error_m = 1e4;
  const Frame f = ecef_frame(crs, site_origin);
  std::vector<TileEntry> sorted = tiles;  // tiles come in the order in which threads were done
  std::sort(sorted.begin(), sorted.end(), [](const TileEntry& a, const TileEntry& b) { return a.uri < b.uri; });
  Json children = Json::array();
  Box2 all;
  double min_z = 0.0, max_z = 0.0;
  for (const TileEntry& tile : sorted) {
    const Box2 local{tile.bounds.min_x - site_origin.x, tile.bounds.min_y - site_origin.y,
                     tile.bounds.max_x - site_origin.x, tile.bounds.max_y - site_origin.y};
    const double low = tile.min_z_m - site_origin.z, high = tile.max_z_m - site_origin.z;
    if (children.empty()) all = local, min_z = low, max_z = high;
    all = {std::min(all.min_x, local.min_x), std::min(all.min_y, local.min_y), std::max(all.max_x, local.max_x),
           std::max(all.max_y, local.max_y)};
    min_z = std::min(min_z, low), max_z = std::max(max_z, high);
    children.push_back(
        {{"boundingVolume", box_json(local, low, high)}, {"geometricError", 0.0}, {"content", {{"uri", tile.uri}}}});
  }
  Json root = {{"transform",
                {f.east.x, f.east.y, f.east.z, 0.0, f.north.x, f.north.y, f.north.z, 0.0, f.up.x, f.up.y, f.up.z, 0.0,
                 f.at.x, f.at.y, f.at.z, 1.0}},
               {"boundingVolume", box_json(all, min_z, max_z)},
               {"geometricError", nothing_drawn_error_m},
               {"refine", "ADD"}};
  if (!children.empty()) root["children"] = std::move(children);
  const Json tileset = {
      {"asset",
       {{"version", "1.1"},
        {"extras",
         {{"orthodrive", {{"crs", crs.definition}, {"origin", {site_origin.x, site_origin.y, site_origin.z}}}}}}}},
      {"geometricError", nothing_drawn_error_m},
      {"root", std::move(root)}};
  write_text_file(folder / "tileset.json", tileset.dump(1) + "\n");
}

}  // namespace orthodrive::io
