// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/report/site_pictures.hpp"

#include <algorithm>
#include <cmath>

#include "roadquery/surface/road_surface.hpp"

namespace orthodrive {
namespace {
constexpr int site_overview_px = 1400, close_up_px = 640;
constexpr Color white{255, 255, 255}, orange{255, 122, 0}, yellow{255, 225, 60}, blue{40, 150, 255}, black{0, 0, 0};

int pixels_for(const Box2& box) { return std::max(box.width(), box.height()) > 600.0 ? site_overview_px : close_up_px; }

bool near(const RoadPath& path, const Box2& box) {
  return std::any_of(path.nodes.begin(), path.nodes.end(), [&](const RoadNode& n) { return box.contains(n.p); });
}

/// The piece of carriageway between node i and i + 1.
Polygon quad(const RoadPath& path, const std::vector<Vec2>& direction, std::size_t i) {
  const auto side = [&](std::size_t k, double sign) {
    return path.nodes[k].p + left_normal(direction[k]) * (sign * 0.5 * path.nodes[k].width_m);
  };
  return {{side(i, -1), side(i + 1, -1), side(i + 1, 1), side(i, 1)}, {}};
}

/// All road surfaces, each piece in the color of value(node) scaled to 0..1.
template <typename Value>
Canvas colored_surfaces(const Photo& photo, const RoadNetwork& roads, const Box2& box, const Value& value) {
  Canvas canvas = canvas_of(photo, box, pixels_for(box));
  for (std::uint8_t& v : canvas.rgb.data) v = static_cast<std::uint8_t>(v / 2);  // dimmed, so that the colors stand out
  for (const RoadPath& path : roads.paths) {
    if (!near(path, box)) continue;
    const std::vector<Vec2> direction = tangents(centerline(path));
    for (std::size_t i = 0; i + 1 < path.nodes.size(); ++i) {
      const Color color = viridis(value(path.nodes[i]));
      fill(canvas, quad(path, direction, i), color, 1.0);
      const Vec2 piece[2] = {path.nodes[i].p, path.nodes[i + 1].p};
      stroke(canvas, piece, 1.2, color);  // or a narrow road falls between the pixels of the overview
    }
  }
  return canvas;
}
}  // namespace

Canvas picture_of_input(const Photo& photo, const RoadNetwork& osm, const Box2& box) {
  Canvas canvas = canvas_of(photo, box, pixels_for(box));
  for (const RoadPath& path : osm.paths) stroke(canvas, centerline(path), 1.4, yellow, 0.9);
  return canvas;
}

Canvas picture_of_offsets(const Photo& photo, const RoadNetwork& roads, const Box2& box, double max_offset_m) {
  return colored_surfaces(photo, roads, box, [&](const RoadNode& n) { return std::abs(n.offset_m) / max_offset_m; });
}

Canvas picture_of_gradients(const Photo& photo, const RoadNetwork& roads, const Box2& box, double max_gradient) {
  return colored_surfaces(photo, roads, box, [&](const RoadNode& n) { return std::abs(n.gradient) / max_gradient; });
}

Canvas picture_of_refinement(const Photo& photo, const RoadNetwork& osm, const RoadNetwork& roads, const Box2& box) {
  Canvas canvas = canvas_of(photo, box, close_up_px);
  for (const RoadPath& path : roads.paths) {
    if (!near(path, box)) continue;
    Ring ring = surface_ring(path);
    fill(canvas, {ring, {}}, orange, 0.18);
    ring.push_back(ring.front());
    stroke(canvas, ring, 1.8, orange);
  }
  for (const RoadPath& path : osm.paths) stroke(canvas, centerline(path), 1.6, white, 0.95);
  return canvas;
}

Canvas picture_of_network(const Photo& photo, const roadquery::RoadMap& map, const Box2& box) {
  Canvas canvas = canvas_of(photo, box, pixels_for(box));
  const bool close_up = box.width() < 600.0;
  for (const roadquery::Road& road : map.roads) {
    const Color color = road.junction >= 0 ? orange : road.bridge ? blue : white;
    Polyline left, right;
    const int steps = std::max(1, static_cast<int>(std::ceil(road.length / (close_up ? 1.0 : 5.0))));
    bool inside = false;
    for (int i = 0; i <= steps; ++i) {
      const double s = road.length * i / steps;
      const roadquery::Edges edges = roadquery::road_edges(road, s);
      const auto at = [&](double t) {
        const roadquery::SurfacePoint p = roadquery::surface_point(road, s, t);
        return Vec2{p.x, p.y};
      };
      left.push_back(at(edges.left_t));
      right.push_back(at(edges.right_t));
      inside = inside || box.contains(left.back());
    }
    if (!inside) continue;
    stroke(canvas, left, close_up ? 1.8 : 1.0, color, 0.9);
    stroke(canvas, right, close_up ? 1.8 : 1.0, color, 0.9);
  }
  return canvas;
}

Canvas picture_of_tile(const SceneTile& tile, double tile_size_m, int max_px) {
  Canvas canvas;
  const double gsd = tile_size_m / max_px;
  canvas.frame = {tile.column * tile_size_m, (tile.row + 1) * tile_size_m, gsd, max_px, max_px};
  canvas.rgb = Raster<std::uint8_t>(max_px, max_px, 3, 225);
  const auto world = [&](const std::array<float, 3>& p) { return Vec2{tile.origin.x + p[0], tile.origin.y + p[1]}; };
  for (const TriMesh& mesh : tile.meshes) {
    const bool road = mesh.kind == MeshKind::road;
    for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
      const std::array<float, 3>* corner[3];
      for (std::size_t k = 0; k < 3; ++k) corner[k] = &mesh.positions[mesh.indices[i + k]];
      const Vec2 a = world(*corner[0]), b = world(*corner[1]), c = world(*corner[2]);
      // Lambert shading with light from the north-west at 45 degrees.
      const double ux = b.x - a.x, uy = b.y - a.y, uz = (*corner[1])[2] - (*corner[0])[2];
      const double vx = c.x - a.x, vy = c.y - a.y, vz = (*corner[2])[2] - (*corner[0])[2];
      const double nx = uy * vz - uz * vy, ny = uz * vx - ux * vz, nz = ux * vy - uy * vx;
      const double n = std::sqrt(nx * nx + ny * ny + nz * nz);
      const double light = n > 0.0 ? std::clamp((-0.5 * nx + 0.5 * ny + 0.7071 * nz) / n, 0.0, 1.0) : 0.0;
      const Color base = road ? orange : Color{190, 205, 180};
      Color shaded;
      for (std::size_t k = 0; k < 3; ++k)
        shaded[k] = static_cast<std::uint8_t>(base[k] * (0.35 + 0.65 * std::min(1.0, light * 1.2)));
      fill(canvas, {{a, b, c}, {}}, shaded, 1.0);
      const Vec2 outline[4] = {a, b, c, a};
      stroke(canvas, outline, 0.6, black, road ? 0.5 : 0.25);
    }
  }
  return canvas;
}

Canvas picture_of_lap(const Photo& photo, std::span<const Vec2> line, std::span<const double> speed_mps,
                      const Box2& box) {
  Canvas canvas = canvas_of(photo, box, pixels_for(box));
  const double fastest = speed_mps.empty() ? 1.0 : std::max(1.0, *std::max_element(speed_mps.begin(), speed_mps.end()));
  for (std::size_t i = 0; i + 1 < line.size(); ++i)
    stroke(canvas, line.subspan(i, 2), 5.0, viridis(speed_mps[i] / fastest));
  return canvas;
}

std::vector<Box2> telling_places(const RoadNetwork& roads, double size_m, std::size_t count) {
  struct MovedStretch {
    double moved_m;
    Vec2 at;
  };
  std::vector<MovedStretch> stretches;
  constexpr std::size_t stretch = 20;  // nodes: about 40 m of road
  for (const RoadPath& path : roads.paths)
    for (std::size_t begin = 0; begin + stretch <= path.nodes.size(); begin += stretch) {
      double sum = 0.0;
      for (std::size_t i = begin; i < begin + stretch; ++i) sum += std::abs(path.nodes[i].offset_m);
      stretches.push_back({sum / stretch, path.nodes[begin + stretch / 2].p});
    }
  std::stable_sort(stretches.begin(), stretches.end(),
                   [](const MovedStretch& a, const MovedStretch& b) { return a.moved_m > b.moved_m; });
  std::vector<Vec2> chosen;
  for (const MovedStretch& moved : stretches) {
    if (chosen.size() == count) break;
    if (std::all_of(chosen.begin(), chosen.end(), [&](Vec2 p) { return distance(p, moved.at) > 2.0 * size_m; }))
      chosen.push_back(moved.at);
  }
  std::vector<Box2> boxes;
  boxes.reserve(chosen.size());
  for (const Vec2 p : chosen) boxes.push_back(Box2{p.x, p.y, p.x, p.y}.grown(0.5 * size_m));
  return boxes;
}

Box2 busiest_junction(const roadquery::RoadMap& map, double size_m) {
  const auto most = std::max_element(map.junctions.begin(), map.junctions.end(), [](const auto& a, const auto& b) {
    return a.connections.size() < b.connections.size();
  });
  Vec2 center{0.5 * (map.west + map.east), 0.5 * (map.south + map.north)};
  if (most != map.junctions.end()) {
    Vec2 sum;
    double count = 0.0;
    for (const roadquery::Road& road : map.roads)
      if (road.junction == most->id) {
        const roadquery::PlanPoint p = roadquery::reference_point(road, 0.5 * road.length);
        sum = sum + Vec2{p.x, p.y}, count += 1.0;
      }
    if (count > 0.0) center = sum * (1.0 / count);
  }
  return Box2{center.x, center.y, center.x, center.y}.grown(0.5 * size_m);
}

}  // namespace orthodrive
