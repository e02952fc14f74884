// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/tiles/scene_io.hpp"

#include <fmt/format.h>
#include <meshoptimizer.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "orthodrive/core/atomic_file.hpp"
#include "orthodrive/io/raster/raster_io.hpp"
#include "orthodrive/io/tiles/glb_file.hpp"

namespace orthodrive::io {
namespace {

constexpr int photo_jpeg_quality = 79;  // the photo is about a third of all bytes
constexpr int position_exponent = -10;  // the scene's plan grid: 1/1024 m
constexpr int place_exponent = -11;     // of tileable textures: half a texel of 4 mm in 4 m
constexpr int instance_exponent = -7;   // of copies: 8 mm, in turns half a degree, in colours a hundredth
// glTF 2.0: filters and wrap modes of samplers.
constexpr int filter_nearest = 9728, filter_linear = 9729, linear_mipmap_linear = 9987, clamp_to_edge = 33071,
              repeat = 10497;

/// glTF is y up: east, up, south. 3D Tiles turns it back.
std::array<float, 3> y_up(const std::array<float, 3>& v) { return {v[0], v[2], -v[1]}; }

/// Multiples of 1/1024 m, of the height before it is lowered: so those of neighbours whose origins differ stay equal.
float lowered(float z, double origin_m) {
  constexpr double steps = 1024.0;
  return static_cast<float>(std::floor(static_cast<double>(z) * steps + 0.5) / steps - origin_m);
}

/// Order in which vertices are used, for compression and caches.
TriMesh in_drawing_order(const TriMesh& mesh) {
  TriMesh ordered = mesh;
  const std::size_t count = mesh.positions.size();
  const std::vector<MeshPart> whole = {{SurfaceMaterial::photo, 0, mesh.indices.size()}};
  for (const MeshPart& part : mesh.parts.empty() ? whole : mesh.parts)
    if (part.index_count > 0)
      meshopt_optimizeVertexCache(&ordered.indices[part.first_index], &mesh.indices[part.first_index], part.index_count,
                                  count);
  std::vector<std::uint32_t> remap(count);
  const std::size_t used =
      meshopt_optimizeVertexFetchRemap(remap.data(), ordered.indices.data(), ordered.indices.size(), count);
  for (std::uint32_t& v : ordered.indices) v = remap[v];
  const auto reorder = [&](auto& values) {
    if (values.empty()) return;
    auto moved = values;
    for (std::size_t i = 0; i < count; ++i)
      if (remap[i] < used) moved[remap[i]] = values[i];
    moved.resize(used);
    values = std::move(moved);
  };
  reorder(ordered.positions);
  reorder(ordered.normals);
  reorder(ordered.uv);
  reorder(ordered.tile_uv);
  reorder(ordered.colors);
  reorder(ordered.features);
  return ordered;
}

/// Leaves have holes, which JPEG cannot hold, and their colour alone.
bool has_color_alone(SurfaceMaterial material) { return material == SurfaceMaterial::leaves; }
bool has_normal_map(SurfaceMaterial material) {
  return material != SurfaceMaterial::photo && !has_color_alone(material);
}
std::vector<std::uint8_t> encode_picture(const Raster<std::uint8_t>& picture) {
  return picture.channels == 4 ? encode_png(picture) : encode_jpeg(picture);
}

using TextureOf = std::function<SurfaceTexture(SurfaceMaterial)>;

/// The indices of all materials and pictures of a file.
class Materials {
 public:
  Materials(GlbFile& file, PhotoFormat format) : file_(file), format_(format) {}
  /// With pictures inside, and a photo that is lit like all else.
  Materials(GlbFile& file, TextureOf texture_of) : file_(file), texture_of_(std::move(texture_of)) {}

  /// Of the meshes that are added from here on.
  void set_photo(const Raster<std::uint8_t>& rgb) { at_[SurfaceMaterial::photo] = add_photo(rgb); }
  int index(SurfaceMaterial material) {
    const auto [at, is_new] = at_.try_emplace(material, 0);
    if (is_new) at->second = add_tileable(material);
    return at->second;
  }

  /// A picture inside the file. Returns the texture.
  int add_picture(std::span<const std::uint8_t> bytes, const char* mime_type, int min_filter, int mag_filter) {
    return add_texture({{"mimeType", mime_type}, {"bufferView", file_.add_bytes(bytes)}}, min_filter, mag_filter,
                       clamp_to_edge);
  }

 private:
  int add(GltfJson material) {
    file_.json["materials"].push_back(std::move(material));
    return static_cast<int>(file_.json["materials"].size()) - 1;
  }

  int sampler(int min_filter, int mag_filter, int wrap) {
    const GltfJson wanted = {{"magFilter", mag_filter}, {"minFilter", min_filter}, {"wrapS", wrap}, {"wrapT", wrap}};
    GltfJson& all = file_.json["samplers"];
    const auto found = std::ranges::find(all, wanted);
    if (found != all.end()) return static_cast<int>(found - all.begin());
    all.push_back(wanted);
    return static_cast<int>(all.size()) - 1;
  }

  int add_texture(GltfJson image, int min_filter, int mag_filter, int wrap) {
    const bool webp = image.value("mimeType", "") == "image/webp";
    file_.json["images"].push_back(std::move(image));
    const std::size_t source = file_.json["images"].size() - 1;
    GltfJson texture = {{"sampler", sampler(min_filter, mag_filter, wrap)}};
    if (webp) {
      texture["extensions"]["EXT_texture_webp"]["source"] = source;
      file_.use_extension("EXT_texture_webp", true);
    } else {
      texture["source"] = source;
    }
    file_.json["textures"].push_back(std::move(texture));
    return static_cast<int>(file_.json["textures"].size()) - 1;
  }

  /// The photo holds its own light, so the material is unlit where the viewer can do that.
  int add_photo(const Raster<std::uint8_t>& rgb) {
    GltfJson material = {{"name", "photo"},
                         {"pbrMetallicRoughness", {{"metallicFactor", 0.0}, {"roughnessFactor", 1.0}}}};
    if (!texture_of_) {
      material["extensions"]["KHR_materials_unlit"] = GltfJson::object();
      file_.use_extension("KHR_materials_unlit", false);
    }
    if (!rgb.empty()) {
      const bool webp = format_ == PhotoFormat::webp;
      const auto bytes = webp ? encode_webp(rgb) : encode_jpeg(rgb, photo_jpeg_quality);
      material["pbrMetallicRoughness"]["baseColorTexture"]["index"] =
          add_picture(bytes, webp ? "image/webp" : "image/jpeg", linear_mipmap_linear, filter_linear);
    }
    return add(std::move(material));
  }

  /// The mesh's colours times a tileable texture, both in the mesh's second set of coordinates.
  int add_tileable(SurfaceMaterial of) {
    const SurfaceTexture inside = texture_of_ ? texture_of_(of) : SurfaceTexture{};
    const auto texture = [&](std::string_view picture, const Raster<std::uint8_t>& rgb) {
      GltfJson image = {{"uri", material_file(of, picture)}};
      if (texture_of_)
        image = {{"mimeType", has_color_alone(of) ? "image/png" : "image/jpeg"},
                 {"bufferView", file_.add_bytes(encode_picture(rgb))}};
      const int index = add_texture(std::move(image), linear_mipmap_linear, filter_linear, repeat);
      return GltfJson{{"index", index}, {"texCoord", 1}};
    };
    if (has_color_alone(of))
      return add(
          {{"name", to_string(of)},
           {"pbrMetallicRoughness", {{"baseColorTexture", texture("color", inside.color)}, {"metallicFactor", 0.0}}},
           {"alphaMode", "MASK"},
           {"doubleSided", true}});
    GltfJson material = {{"name", to_string(of)},
                         {"pbrMetallicRoughness",
                          {{"baseColorTexture", texture("color", inside.color)},
                           {"metallicFactor", 0.0},
                           {"metallicRoughnessTexture", texture("roughness", inside.roughness)}}},
                         {"normalTexture", texture("normal", inside.normal_rgb)}};
    if (of == SurfaceMaterial::verge) material["alphaMode"] = "BLEND";
    return add(std::move(material));
  }

  GlbFile& file_;
  PhotoFormat format_ = PhotoFormat::jpeg;
  TextureOf texture_of_;
  std::map<SurfaceMaterial, int> at_;
};

GltfJson strings_property(GlbFile& file, const std::vector<std::string>& strings) {
  std::string text;
  std::vector<std::uint32_t> offsets = {0};
  for (const std::string& s : strings) {
    text += s;
    offsets.push_back(static_cast<std::uint32_t>(text.size()));
  }
  if (text.empty()) text = " ";  // a view of a buffer has at least a byte
  const int values = file.add_bytes(text);
  const int ends = file.add_bytes(
      std::span(reinterpret_cast<const std::uint8_t*>(offsets.data()), offsets.size() * sizeof(offsets[0])));
  return {{"values", values}, {"stringOffsets", ends}};
}

/// A table of strings (EXT_structural_metadata). Returns its index.
std::size_t add_table(GlbFile& file, const char* class_name,
                      const std::vector<std::pair<const char*, std::vector<std::string>>>& columns) {
  file.use_extension("EXT_structural_metadata", false);
  file.use_extension("EXT_mesh_features", false);
  GltfJson& metadata = file.json["extensions"]["EXT_structural_metadata"];
  metadata["schema"]["id"] = "orthodrive";
  GltfJson rows = {{"class", class_name}, {"count", columns.front().second.size()}};
  for (const auto& [name, values] : columns) {
    metadata["schema"]["classes"][class_name]["properties"][name] = {{"type", "STRING"}};
    rows["properties"][name] = strings_property(file, values);
  }
  metadata["propertyTables"].push_back(std::move(rows));
  return metadata["propertyTables"].size() - 1;
}

/// What the photo shows, the 3D Tiles 1.1 way: a feature id texture (EXT_mesh_features) whose ids are the rows of a
/// table with each class's name, role and colour (#rrggbb). Returns the feature ids of the primitives.
GltfJson add_labels(GlbFile& file, Materials& materials, const Raster<std::uint8_t>& labels, const ClassTable& table) {
  const int texture = materials.add_picture(encode_png(labels), "image/png", filter_nearest, filter_nearest);
  std::vector<std::string> names, roles, colors;
  names.reserve(table.classes.size());
  roles.reserve(table.classes.size());
  for (const ClassInfo& info : table.classes) {
    names.push_back(info.name), roles.push_back(to_string(info.role));
    colors.push_back(fmt::format("#{:02x}{:02x}{:02x}", info.color[0], info.color[1], info.color[2]));
  }
  return {{"featureCount", names.size()},
          {"nullFeatureId", static_cast<int>(label_nodata)},
          {"label", "label"},
          {"texture", {{"index", texture}, {"texCoord", 0}, {"channels", GltfJson::array({0})}}},
          {"propertyTable", add_table(file, "label", {{"name", names}, {"role", roles}, {"color", colors}})}};
}

/// Lanes of roads and buildings: ids of vertices, rows of a table of their own.
GltfJson add_objects(GlbFile& file, const std::vector<SceneFeature>& features) {
  std::vector<std::string> kinds, ids, osm_ids, names, types, lane_ids, lane_types;
  kinds.reserve(features.size());
  ids.reserve(features.size());
  osm_ids.reserve(features.size());
  for (const SceneFeature& f : features) {
    kinds.push_back(f.kind), ids.push_back(f.id), osm_ids.push_back(f.osm_id);
    names.push_back(f.name), types.push_back(f.type);
    lane_ids.push_back(f.lane_id), lane_types.push_back(f.lane_type);
  }
  const std::size_t table = add_table(file, "object",
                                      {{"kind", kinds},
                                       {"id", ids},
                                       {"osm_id", osm_ids},
                                       {"name", names},
                                       {"type", types},
                                       {"lane_id", lane_ids},
                                       {"lane_type", lane_types}});
  return {{"featureCount", features.size()},
          {"nullFeatureId", features.size()},
          {"label", "object"},
          {"attribute", 0},
          {"propertyTable", table}};
}

/// Directions of the first coordinate of tileable textures, at right angles to the normals; fourth: 1 where normal x
/// tangent points up in the picture, else -1 (Lengyel, Computing Tangent Space Basis Vectors for an Arbitrary Mesh,
/// 2001).
std::vector<std::array<float, 4>> tangents_of(const TriMesh& mesh) {
  const auto vec = [](const std::array<float, 3>& p) { return Vec3{p[0], p[1], p[2]}; };
  const auto dot3 = [](const Vec3& a, const Vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; };
  std::vector<Vec3> along(mesh.positions.size()), up(mesh.positions.size());
  for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
    const std::uint32_t a = mesh.indices[i], b = mesh.indices[i + 1], c = mesh.indices[i + 2];
    const Vec3 ab = vec(mesh.positions[b]) - vec(mesh.positions[a]),
               ac = vec(mesh.positions[c]) - vec(mesh.positions[a]);
    const auto step = [&](std::uint32_t to) {
      return Vec2{double{mesh.tile_uv[to][0]} - double{mesh.tile_uv[a][0]},
                  double{mesh.tile_uv[to][1]} - double{mesh.tile_uv[a][1]}};
    };
    const Vec2 ub = step(b), uc = step(c);
    const double turned = cross(ub, uc) < 0.0 ? -1.0 : 1.0;
    const Vec3 u = (ab * uc.y - ac * ub.y) * turned, v = (ab * uc.x - ac * ub.x) * turned;
    for (const std::uint32_t vertex : {a, b, c}) along[vertex] = along[vertex] + u, up[vertex] = up[vertex] + v;
  }
  std::vector<std::array<float, 4>> tangents;
  for (std::size_t i = 0; i < along.size(); ++i) {
    const Vec3 n = vec(mesh.normals[i]);
    Vec3 t = along[i] - n * dot3(n, along[i]);
    double length = std::hypot(t.x, t.y, t.z);
    if (!(length > 1e-9)) {  // no triangle, or one without area in the picture
      t = std::abs(n.z) > 0.5 ? Vec3{n.z, 0.0, -n.x} : Vec3{-n.y, n.x, 0.0};
      length = std::hypot(t.x, t.y, t.z);
    }
    t = t * (1.0 / length);
    const Vec3 side = cross(n, t);
    const auto f = [](double value) { return static_cast<float>(value); };
    tangents.push_back({f(t.x), f(t.y), f(t.z), dot3(side, up[i]) < 0.0 ? -1.0F : 1.0F});
  }
  return tangents;
}

/// The vertices of a mesh, as the primitives of its parts share them.
GltfJson add_vertices(GlbFile& file, const TriMesh& mesh, double origin_m) {
  GltfJson attributes;
  std::vector<std::array<float, 3>> positions, normals;
  positions.reserve(mesh.positions.size());
  for (const auto& p : mesh.positions) positions.push_back(y_up({p[0], p[1], lowered(p[2], origin_m)}));
  normals.reserve(mesh.normals.size());
  for (const auto& n : mesh.normals) normals.push_back(y_up(n));
  attributes["POSITION"] = file.add_positions(positions, position_exponent);
  attributes["NORMAL"] = file.add_directions(normals);
  // glTF counts sets of coordinates from 0 without a gap: what shows no photo has the second set as its first, too.
  if (!mesh.uv.empty()) attributes["TEXCOORD_0"] = file.add_shares(mesh.uv);
  if (!mesh.tile_uv.empty()) attributes["TEXCOORD_1"] = file.add_numbers(mesh.tile_uv, place_exponent);
  if (mesh.uv.empty()) attributes["TEXCOORD_0"] = attributes.at("TEXCOORD_1");
  if (!mesh.tile_uv.empty() && std::ranges::any_of(mesh.parts, has_normal_map, &MeshPart::material)) {
    std::vector<std::array<float, 4>> tangents = tangents_of(mesh);
    for (auto& t : tangents) t = {t[0], t[2], -t[1], t[3]};
    attributes["TANGENT"] = file.add_tangents(tangents);
  }
  if (!mesh.colors.empty()) attributes["COLOR_0"] = file.add_colors(mesh.colors);
  if (!mesh.features.empty()) {
    std::vector<float> ids;
    ids.reserve(mesh.features.size());
    for (const std::uint32_t id : mesh.features) ids.push_back(static_cast<float>(id));
    attributes["_FEATURE_ID_0"] = file.add_scalars(ids);
  }
  return attributes;
}

/// EXT_mesh_gpu_instancing: where the copies of a node's mesh stand. _COLOR_0 is their tint (three.js reads it).
GltfJson instancing(GlbFile& file, const std::vector<MeshInstance>& instances, double origin_m) {
  std::vector<std::array<float, 3>> translations, scales, tints;
  std::vector<std::array<float, 4>> rotations;
  translations.reserve(instances.size());
  for (const MeshInstance& copy : instances) {
    translations.push_back(y_up({copy.position[0], copy.position[1], lowered(copy.position[2], origin_m)}));
    scales.push_back({copy.scale[0], copy.scale[2], copy.scale[1]});
    rotations.push_back({0.0F, std::sin(0.5F * copy.yaw_rad), 0.0F, std::cos(0.5F * copy.yaw_rad)});
    tints.push_back(copy.tint);
  }
  GltfJson attributes;
  attributes["TRANSLATION"] = file.add_numbers(translations, instance_exponent);
  attributes["ROTATION"] = file.add_numbers(rotations, instance_exponent);
  attributes["SCALE"] = file.add_numbers(scales, instance_exponent);
  attributes["_COLOR_0"] = file.add_numbers(tints, instance_exponent);
  return {{"attributes", attributes}};
}

/// Adds meshes with their nodes.
class Nodes {
 public:
  Nodes(GlbFile& file, Materials& materials, double origin_m)
      : file_(file), materials_(materials), origin_m_(origin_m) {}

  /// Feature ids of what shows the photo, and of what has features.
  std::optional<GltfJson> labels, objects;

  void add(const TriMesh& given) { (void)add_node(given); }
  void add(const InstancedMesh& copied) {
    file_.use_extension("EXT_mesh_gpu_instancing", true);  // who draws no copies would draw one in the middle
    GltfJson copies = instancing(file_, copied.instances, origin_m_);
    add_node(copied.mesh, 0.0)["extensions"]["EXT_mesh_gpu_instancing"] = std::move(copies);
  }
  /// Without an extension: a node a copy.
  void add_each(const InstancedMesh& copied) {
    const GltfJson first = add_node(copied.mesh, 0.0);
    file_.json["nodes"].erase(file_.json["nodes"].size() - 1);
    for (const MeshInstance& copy : copied.instances) {
      GltfJson node = first;
      node["translation"] = y_up(copy.position);
      node["rotation"] = {0.0F, std::sin(0.5F * copy.yaw_rad), 0.0F, std::cos(0.5F * copy.yaw_rad)};
      node["scale"] = {copy.scale[0], copy.scale[2], copy.scale[1]};
      file_.json["nodes"].push_back(std::move(node));
    }
  }

 private:
  GltfJson& add_node(const TriMesh& given) { return add_node(given, origin_m_); }
  GltfJson& add_node(const TriMesh& given, double origin_m) {
    const TriMesh mesh = file_.compressed() ? in_drawing_order(given) : given;
    const GltfJson vertices = add_vertices(file_, mesh, origin_m);
    GltfJson primitives = GltfJson::array();
    const std::vector<MeshPart> whole = {{SurfaceMaterial::photo, 0, mesh.indices.size()}};
    for (const MeshPart& part : mesh.parts.empty() ? whole : mesh.parts) {
      const auto indices = std::span(mesh.indices).subspan(part.first_index, part.index_count);
      primitives.push_back({{"attributes", vertices},
                            {"indices", file_.add_indices(indices, mesh.positions.size())},
                            {"material", materials_.index(part.material)}});
      GltfJson& primitive = primitives.back();
      const auto add_ids = [&](const GltfJson& ids) {
        primitive["extensions"]["EXT_mesh_features"]["featureIds"].push_back(ids);
      };
      if (labels && !mesh.uv.empty()) add_ids(*labels);
      if (objects && !mesh.features.empty()) add_ids(*objects);
    }
    file_.json["meshes"].push_back({{"name", to_string(mesh.kind)}, {"primitives", std::move(primitives)}});
    auto& nodes = file_.json["nodes"];
    nodes.push_back({{"name", to_string(mesh.kind)}, {"mesh", file_.json["meshes"].size() - 1}});
    return nodes.back();
  }

  GlbFile& file_;
  Materials& materials_;
  double origin_m_ = 0.0;
};

/// What the tile covers in plan, crowns included.
Box2 bounds_of(const SceneTile& tile) {
  constexpr double far = std::numeric_limits<double>::infinity();
  Box2 bounds{far, far, -far, -far};
  const auto include = [&](const std::array<float, 3>& p, float reach_m) {
    const Vec2 q{tile.origin.x + static_cast<double>(p[0]), tile.origin.y + static_cast<double>(p[1])};
    const Box2 box = Box2{q.x, q.y, q.x, q.y}.grown(static_cast<double>(reach_m));
    bounds = {std::min(bounds.min_x, box.min_x), std::min(bounds.min_y, box.min_y), std::max(bounds.max_x, box.max_x),
              std::max(bounds.max_y, box.max_y)};
  };
  for (const TriMesh& mesh : tile.meshes)
    for (const auto& p : mesh.positions) include(p, 0.0F);
  for (const InstancedMesh& copied : tile.instanced)
    for (const MeshInstance& copy : copied.instances) include(copy.position, std::max(copy.scale[0], copy.scale[1]));
  return bounds;
}

std::string file_name(const SceneTile& tile) {
  return tile.level == 0 ? fmt::format("tile_{}_{}.glb", tile.column, tile.row)
                         : fmt::format("level{}_{}_{}.glb", tile.level, tile.column, tile.row);
}

}  // namespace

TileEntry write_tile_glb(const std::filesystem::path& folder, const SceneTile& tile, const TileFileOptions& options) {
  const double lift_m = std::floor(0.5 * (tile.min_z_m + tile.max_z_m) - tile.origin.z);
  GlbFile file(options.compressed);
  Materials materials(file, options.photo);
  materials.set_photo(tile.texture_rgb);
  Nodes nodes(file, materials, lift_m);
  if (!tile.labels.empty()) nodes.labels = add_labels(file, materials, tile.labels, tile.classes);
  if (!tile.features.empty()) nodes.objects = add_objects(file, tile.features);
  for (const TriMesh& mesh : tile.meshes) nodes.add(mesh);
  for (const InstancedMesh& copied : tile.instanced) nodes.add(copied);
  GltfJson roots = GltfJson::array();
  for (std::size_t i = 0; i < file.json["nodes"].size(); ++i) roots.push_back(i);
  file.json["scenes"] = GltfJson::array({{{"nodes", std::move(roots)}}});
  file.json["scene"] = 0;
  const TileEntry entry{.uri = file_name(tile),
                        .level = tile.level,
                        .column = tile.column,
                        .row = tile.row,
                        .origin = {tile.origin.x, tile.origin.y, tile.origin.z + lift_m},
                        .bounds = bounds_of(tile),
                        .min_z_m = tile.min_z_m,
                        .max_z_m = tile.max_z_m,
                        .geometric_error_m = tile.geometric_error_m};
  file.write(folder / entry.uri);
  return entry;
}

void write_area_glb(const std::filesystem::path& path, std::span<const SceneTile> tiles, Vec3 origin,
                    const TextureOf& texture_of) {
  GlbFile file(false);
  Materials materials(file, texture_of);
  Nodes nodes(file, materials, 0.0);
  GltfJson roots = GltfJson::array();
  for (const SceneTile& tile : tiles) {
    materials.set_photo(tile.texture_rgb);
    const std::size_t first = file.json.contains("nodes") ? file.json["nodes"].size() : 0;
    for (const TriMesh& mesh : tile.meshes) nodes.add(mesh);
    for (const InstancedMesh& copied : tile.instanced) nodes.add_each(copied);
    const Vec3 shift = tile.origin - origin;
    GltfJson node = {{"name", fmt::format("tile_{}_{}", tile.column, tile.row)},
                     {"translation", {shift.x, shift.z, -shift.y}}};
    for (std::size_t i = first; i < file.json["nodes"].size(); ++i) node["children"].push_back(i);
    roots.push_back(file.json["nodes"].size());
    file.json["nodes"].push_back(std::move(node));
  }
  file.json["scenes"] = GltfJson::array({{{"nodes", std::move(roots)}}});
  file.json["scene"] = 0;
  file.write(path);
}

std::string material_file(SurfaceMaterial material, std::string_view picture) {
  return fmt::format("materials/{}_{}.{}", to_string(material), picture, has_color_alone(material) ? "png" : "jpg");
}

MaterialPictures encode_material(SurfaceMaterial material, const SurfaceTexture& texture) {
  MaterialPictures pictures;
  const auto add = [&](const Raster<std::uint8_t>& rgb) {
    const auto bytes = encode_picture(rgb);
    pictures.emplace_back(bytes.begin(), bytes.end());
  };
  add(texture.color);
  if (has_color_alone(material)) return pictures;
  add(texture.normal_rgb);
  add(texture.roughness);
  return pictures;
}

void write_material(const std::filesystem::path& folder, SurfaceMaterial material, const MaterialPictures& pictures) {
  constexpr std::array<std::string_view, 3> names = {"color", "normal", "roughness"};
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    const std::filesystem::path file = folder / material_file(material, names.at(i));
    std::filesystem::create_directories(file.parent_path());
    write_text_file(file, pictures[i]);
  }
}

}  // namespace orthodrive::io
