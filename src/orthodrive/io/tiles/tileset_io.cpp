// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/tiles/tileset_io.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <tuple>

#include "orthodrive/core/atomic_file.hpp"

namespace orthodrive::io {
namespace {

using TilesetJson = nlohmann::ordered_json;

/// Not drawn, only compared: the error of a scene without any tile. Bigger than any screen error a viewer accepts.
constexpr double nothing_drawn_error_m = 1e4;

double dot_product(Vec3 a, Vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
double norm(Vec3 a) { return std::sqrt(dot_product(a, a)); }

/// 3D Tiles multiplies the transforms from the root on: this one, below `parent`, gives `tile`.
Placement relative_to(const Placement& parent, const Placement& tile) {
  // The three directions of a placement are at right angles.
  const auto local = [&](Vec3 v) {
    return Vec3{dot_product(v, parent.east) / dot_product(parent.east, parent.east),
                dot_product(v, parent.north) / dot_product(parent.north, parent.north),
                dot_product(v, parent.up) / dot_product(parent.up, parent.up)};
  };
  return {local(tile.east), local(tile.north), local(tile.up), local(tile.at - parent.at)};
}

TilesetJson transform_json(const Placement& p) {
  return {p.east.x, p.east.y, p.east.z, 0.0, p.north.x, p.north.y, p.north.z, 0.0,
          p.up.x,   p.up.y,   p.up.z,   0.0, p.at.x,    p.at.y,    p.at.z,    1.0};
}

struct Volume {
  Box2 box;
  double min_z = 0.0, max_z = 0.0;
};

Volume joined(const Volume& a, const Volume& b) {
  return {{std::min(a.box.min_x, b.box.min_x), std::min(a.box.min_y, b.box.min_y), std::max(a.box.max_x, b.box.max_x),
           std::max(a.box.max_y, b.box.max_y)},
          std::min(a.min_z, b.min_z),
          std::max(a.max_z, b.max_z)};
}

TilesetJson box_json(const Volume& v, Vec3 origin) {
  const double x = 0.5 * v.box.width(), y = 0.5 * v.box.height(), z = 0.5 * (v.max_z - v.min_z);
  return {{"box",
           {v.box.min_x + x - origin.x, v.box.min_y + y - origin.y, v.min_z + z - origin.z, x, 0.0, 0.0, 0.0, y, 0.0,
            0.0, 0.0, z}}};
}

class Tree {
 public:
  Tree(const std::vector<TileEntry>& tiles, const Crs& crs, Vec3 site_origin)
      : lonlat_from_site_(crs, Crs{"EPSG:4326"}), site_origin_(site_origin) {
    for (const TileEntry& tile : tiles) {
      at_[{tile.level, tile.column, tile.row}] = &tile;
      top_level_ = std::max(top_level_, tile.level);
    }
  }
  [[nodiscard]] const Geoid& geoid() const { return geoid_; }

  [[nodiscard]] TilesetJson root() const {
    const Placement placement = placement_at(lonlat_from_site_, geoid_, site_origin_);
    TilesetJson json = {{"transform", transform_json(placement)}};
    TilesetJson children = TilesetJson::array();
    Volume all{};
    for (const auto& [key, tile] : at_) {
      if (tile->level != top_level_ && parent_of(*tile) != nullptr) continue;
      auto [child, volume] = node(*tile, placement);
      all = children.empty() ? volume : joined(all, volume);
      children.push_back(std::move(child));
    }
    json["boundingVolume"] = box_json(all, site_origin_);
    json["geometricError"] = nothing_drawn_error_m;
    json["refine"] = "REPLACE";
    if (!children.empty()) json["children"] = std::move(children);
    return json;
  }

 private:
  using Key = std::tuple<int, int, int>;

  [[nodiscard]] const TileEntry* parent_of(const TileEntry& tile) const {
    const auto found = at_.find({tile.level + 1, tile.column >> 1, tile.row >> 1});
    return found == at_.end() ? nullptr : found->second;
  }

  [[nodiscard]] std::pair<TilesetJson, Volume> node(const TileEntry& tile, const Placement& parent) const {
    const Placement placement = placement_at(lonlat_from_site_, geoid_, tile.origin);
    Volume volume{tile.bounds, tile.min_z_m, tile.max_z_m};
    TilesetJson children = TilesetJson::array();
    for (const int k : {0, 1, 2, 3}) {
      const auto found = at_.find({tile.level - 1, 2 * tile.column + k / 2, 2 * tile.row + k % 2});
      if (found == at_.end()) continue;
      auto [child, child_volume] = node(*found->second, placement);
      volume = joined(volume, child_volume);
      children.push_back(std::move(child));
    }
    const Vec3 moved = tile.origin - site_origin_;
    TilesetJson json = {{"transform", transform_json(relative_to(parent, placement))},
                        {"boundingVolume", box_json(volume, tile.origin)},
                        {"geometricError", tile.geometric_error_m},
                        {"content", {{"uri", tile.uri}}},
                        {"extras", {{"origin", {moved.x, moved.y, moved.z}}}}};
    if (!children.empty()) json["children"] = std::move(children);
    return {std::move(json), volume};
  }

  CoordinateTransform lonlat_from_site_;
  Geoid geoid_;
  Vec3 site_origin_;
  std::map<Key, const TileEntry*> at_;
  int top_level_ = 0;
};

}  // namespace

Placement placement_at(const CoordinateTransform& lonlat_from_site, const Geoid& geoid, Vec3 origin) {
  constexpr double step_m = 100.0;
  const auto ecef = [&](double dx, double dy) {
    const Vec2 lonlat = lonlat_from_site.target_from_source({origin.x + dx, origin.y + dy});
    return ecef_from_geographic(lonlat.x, lonlat.y, origin.z + geoid.height_m(lonlat.x, lonlat.y));
  };
  const Vec3 east = (ecef(step_m, 0.0) - ecef(-step_m, 0.0)) * (0.5 / step_m);
  const Vec3 north = (ecef(0.0, step_m) - ecef(0.0, -step_m)) * (0.5 / step_m);
  const double scale = 0.5 * (norm(east) + norm(north));  // conformal: the same in all directions
  const Vec3 unit_east = east * (1.0 / norm(east));
  const Vec3 upwards = cross(east, north);
  const Vec3 up = upwards * (1.0 / norm(upwards));
  return {unit_east * scale, cross(up, unit_east) * scale, up, ecef(0.0, 0.0)};
}

void write_tileset(const std::filesystem::path& folder, const std::vector<TileEntry>& tiles, const Crs& crs,
                   Vec3 site_origin, Findings& findings) {
  const Tree tree(tiles, crs, site_origin);
  if (tree.geoid().grid().empty())
    findings.push_back({Severity::warning, "scene.no_geoid",
                        "PROJ has no geoid grid (egm96_15.gtx of Debian's proj-data): on a globe the scene lies as if "
                        "its heights counted from the ellipsoid, up to 100 m off",
                        site_origin.x, site_origin.y});
  const TilesetJson extras = {{"crs", crs.definition}, {"origin", {site_origin.x, site_origin.y, site_origin.z}}};
  const TilesetJson tileset = {{"asset", {{"version", "1.1"}, {"extras", {{"orthodrive", extras}}}}},
                               {"geometricError", nothing_drawn_error_m},
                               {"root", tree.root()}};
  write_text_file(folder / "tileset.json", tileset.dump(1) + "\n");
}

}  // namespace orthodrive::io
