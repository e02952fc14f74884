// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/synth/paint/scene_raster.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "orthodrive/core/noise.hpp"
#include "orthodrive/core/parallel.hpp"
#include "orthodrive/model/roads/highway_class.hpp"
#include "orthodrive/synth/paint/world.hpp"

namespace orthodrive::synth {
namespace {
constexpr int band_rows = 64;
constexpr double road_reach_m = 6.0;  // beyond its edge a road changes nothing
constexpr float far_from_roads_m = 9.0f;
constexpr double deck_edge_m = 0.4;                        // parapet of a bridge, outside the carriageway
constexpr float kerb_m = 1.2f, kerb_banking_rad = 0.013f;  // kerbs where a circuit bends: R below some 220 m
constexpr float shoulder_m = 0.6f, verge_m = 2.2f, kerbstone_m = 0.3f;

/// Minimum of two distances that rounds the corner between them (Quilez, polynomial smooth minimum).
float smooth_min(float a, float b, float k) {
  const float h = std::max(k - std::abs(a - b), 0.0f) / k;
  return std::min(a, b) - h * h * k * 0.25f;
}

/// Corners are rounded where roads meet across, not where a slip road leaves at a few degrees: rounding its gore would
/// pave tens of metres beyond the nose, and both outer edges.
float rounding_m(const SceneSource& source, std::int32_t segment_a, std::int32_t segment_b) {
  const auto direction = [&](std::int32_t segment) {
    const auto i = static_cast<std::size_t>(segment);
    return normalized(source.road_samples[i + 1].p - source.road_samples[i].p);
  };
  const auto sine = static_cast<float>(std::abs(cross(direction(segment_a), direction(segment_b))));
  return std::max(0.2f, static_cast<float>(source.plan.corner_rounding_m) * smoothstep(0.15f, 0.9f, sine));
}

struct FieldCell {
  std::uint16_t number = 0;
  double border_m = 0.0;  ///< distance to the next field, about
};

/// Long narrow parcels: the Voronoi cells of a jittered grid in a turned and stretched frame.
FieldCell field_cell(const SitePlan& plan, Vec2 p, std::uint32_t seed) {
  const double turn = 6.28 * unit_hash(1, 2, seed), c = std::cos(turn), s = std::sin(turn);
  const double x = (c * p.x + s * p.y) / plan.field_m.x, y = (-s * p.x + c * p.y) / plan.field_m.y;
  const int ix = static_cast<int>(std::floor(x)), iy = static_cast<int>(std::floor(y));
  double nearest = 1e9, second = 1e9;
  std::uint32_t number = 0;
  for (int j = iy - 1; j <= iy + 1; ++j)
    for (int i = ix - 1; i <= ix + 1; ++i) {
      const double dx = i + 0.5 + 0.3 * signed_hash(i, j, seed + 1) - x,
                   dy = j + 0.5 + 0.3 * signed_hash(i, j, seed + 2) - y;
      const double d = dx * dx + dy * dy;
      if (d < nearest)
        second = nearest, nearest = d, number = hash_lattice(i, j, seed + 3);
      else
        second = std::min(second, d);
    }
  return {static_cast<std::uint16_t>(number & 0xffffu),
          0.5 * (std::sqrt(second) - std::sqrt(nearest)) * std::min(plan.field_m.x, plan.field_m.y)};
}

/// Fields that follow the slope: cut where the ground rises by a step, and across.
FieldCell terrace_cell(const SceneSource& source, Vec2 p, std::uint32_t seed) {
  constexpr double d = 2.0;
  const double step_m = source.plan.terrace_m, z = ground_height(source, p);
  const double zx = (ground_height(source, p + Vec2{d, 0.0}) - z) / d,
               zy = (ground_height(source, p + Vec2{0.0, d}) - z) / d, slope = std::max(0.004, std::hypot(zx, zy));
  const double level = z / step_m + 0.4 * value_noise(p.x / 60.0, p.y / 60.0, seed + 4);
  const int step = static_cast<int>(std::floor(level));
  const double turn = 6.28 * unit_hash(1, 2, seed);
  const double along = (std::cos(turn) * p.x + std::sin(turn) * p.y) / source.plan.field_m.y + unit_hash(step, 7, seed);
  const int piece = static_cast<int>(std::floor(along));
  const double to_step_m = std::min(level - step, step + 1.0 - level) * step_m / slope,
               to_piece_m = std::min(along - piece, piece + 1.0 - along) * source.plan.field_m.y;
  return {static_cast<std::uint16_t>(hash_lattice(step, piece, seed + 5) & 0xffffu), std::min(to_step_m, to_piece_m)};
}

/// A range of rows of the scene; bands are painted independently of each other.
struct Band {
  GridFrame frame;  ///< of these rows
  int first = 0, rows = 0;
  Box2 box;
};

void paint_covers(const SceneSource& source, const Band& band, SceneRaster& scene) {
  for (int row = band.first; row < band.first + band.rows; ++row)
    for (int col = 0; col < scene.frame.width; ++col) {
      scene.cover.at(col, row) = Cover::field;
      scene.detail.at(col, row) = 0;
    }
  const auto fill = [&](const Polygon& polygon, Cover cover, std::uint16_t detail) {
    if (!bounds_of(polygon.outer).overlaps(band.box)) return;
    rasterize(polygon, band.frame, [&](int row, int begin, int end) {
      for (int col = begin; col < end; ++col) {
        scene.cover.at(col, band.first + row) = cover;
        scene.detail.at(col, band.first + row) = detail;
      }
    });
  };
  if (source.plan.circuit) fill({sample(source.plan.roads[*source.plan.circuit].alignment, 4.0), {}}, Cover::meadow, 0);
  for (std::size_t i = 0; i < source.objects.areas.size(); ++i)
    fill(source.objects.areas[i].polygon, source.objects.areas[i].cover, static_cast<std::uint16_t>(i));
  for (int row = band.first; row < band.first + band.rows; ++row)
    for (int col = 0; col < scene.frame.width; ++col)
      if (scene.cover.at(col, row) == Cover::field) {
        const Vec2 p = scene.frame.center_of(col, row);
        const FieldCell cell = source.plan.terrace_m > 0.0 ? terrace_cell(source, p, source.seed + 11)
                                                           : field_cell(source.plan, p, source.seed + 11);
        scene.detail.at(col, row) = cell.number;
        if (cell.border_m < source.plan.bund_m) scene.cover.at(col, row) = Cover::verge;
      }
}

/// Distance to the edge of a straight piece of carriageway. Ends of a road are flat, and what lies beyond them counts
/// as farther away than it is: or a side road that ends in the middle of the main one would bulge the main road's far
/// edge. Decks end sharply.
double edge_distance(const RoadSample& a, const RoadSample& b, bool first, bool last, Vec2 p) {
  const double beyond_end = a.bridge || b.bridge ? 1000.0 : 4.0;
  constexpr double joint_m = 0.8;  // enough for the wedge outside a bend, less than a segment: no rounded ends
  const Vec2 d = b.p - a.p;
  const double n = length(d), along = dot(p - a.p, d) / n, across = std::abs(cross(d, p - a.p)) / n;
  const double overshoot = std::max(-along, along - n);
  const double half_m = a.half_width_m + std::clamp(along / n, 0.0, 1.0) * (b.half_width_m - a.half_width_m);
  if (overshoot <= 0.0) return across - half_m;
  if ((first && along < 0.0) || (last && along > n)) return std::max(across - half_m, beyond_end * overshoot);
  if (overshoot > joint_m) return far_from_roads_m;
  return std::hypot(across, overshoot) - half_m;
}

/// What is painted in one go: a road at grade, or a deck.
struct RoadLayer {
  std::uint16_t road = 0;
  bool bridge = false;
  int priority = 0;
};

/// Of the roads that are sampled: from the least important up, then the decks of bridges, which lie over everything.
std::vector<RoadLayer> layers_of(const SceneSource& source) {
  std::set<std::uint16_t> roads, decks;
  for (const RoadSample& sample : source.road_samples) {
    roads.insert(sample.road);
    if (sample.bridge) decks.insert(sample.road);
  }
  std::vector<RoadLayer> layers;
  layers.reserve(roads.size());
  for (const std::uint16_t r : roads) layers.push_back({r, false, surface_priority(source.plan, r)});
  for (const std::uint16_t r : decks) layers.push_back({r, true, 1000});
  std::stable_sort(layers.begin(), layers.end(),
                   [](const RoadLayer& a, const RoadLayer& b) { return a.priority < b.priority; });
  return layers;
}

/// The nearest segment of a layer's road and the distance to its edge.
struct NearSegment {
  float edge_m = far_from_roads_m;
  std::int32_t segment = -1;
};

std::size_t cell_of(const Band& band, const GridFrame& frame, int col, int row) {
  return static_cast<std::size_t>(row - band.first) * static_cast<std::size_t>(frame.width) +
         static_cast<std::size_t>(col);
}

/// False where the layer does not touch the band; `near` is then as it was.
bool find_nearest(const SceneSource& source, const RoadLayer& layer, const Band& band, const GridFrame& frame,
                  std::vector<NearSegment>& near) {
  const auto& samples = source.road_samples;
  bool touched = false;
  for (std::size_t i = 0; i + 1 < samples.size(); ++i) {
    const RoadSample &a = samples[i], &b = samples[i + 1];
    if (a.road != layer.road || a.last || (a.bridge || b.bridge) != layer.bridge) continue;
    const double reach = a.half_width_m + road_reach_m;
    const Box2 box{std::min(a.p.x, b.p.x) - reach, std::min(a.p.y, b.p.y) - reach, std::max(a.p.x, b.p.x) + reach,
                   std::max(a.p.y, b.p.y) + reach};
    if (!box.overlaps(band.box)) continue;
    if (!touched) std::fill(near.begin(), near.end(), NearSegment{}), touched = true;
    const Vec2 low = frame.pixel_from_world({box.min_x, box.max_y}),
               high = frame.pixel_from_world({box.max_x, box.min_y});
    const int row0 = std::max(band.first, static_cast<int>(low.y)),
              row1 = std::min(band.first + band.rows, static_cast<int>(high.y) + 1);
    const int col0 = std::max(0, static_cast<int>(low.x)), col1 = std::min(frame.width, static_cast<int>(high.x) + 1);
    const bool closed = source.plan.roads[a.road].alignment.closed;
    // Where only a stretch is sampled, its ends lie too far away to be seen.
    const bool begins = i == 0 || samples[i - 1].last;
    const bool first = begins ? !closed : (samples[i - 1].bridge || a.bridge) != layer.bridge;
    const bool last = b.last ? !closed : (b.bridge || samples[i + 2].bridge) != layer.bridge;
    for (int row = row0; row < row1; ++row)
      for (int col = col0; col < col1; ++col) {
        const auto edge = static_cast<float>(edge_distance(a, b, first, last, frame.center_of(col, row)));
        NearSegment& n = near[cell_of(band, frame, col, row)];
        if (edge < n.edge_m) n = {edge, static_cast<std::int32_t>(i)};
      }
  }
  return touched;
}

/// Lays a layer on those before it: carriageways that meet at grade become one with rounded corners, decks cover.
void merge_layer(const SceneSource& source, const RoadLayer& layer, const Band& band,
                 const std::vector<NearSegment>& near, SceneRaster& scene) {
  for (int row = band.first; row < band.first + band.rows; ++row)
    for (int col = 0; col < scene.frame.width; ++col) {
      const NearSegment& n = near[cell_of(band, scene.frame, col, row)];
      if (n.segment < 0) continue;
      float& edge = scene.road_edge_m.at(col, row);
      std::int32_t& segment = scene.road_segment.at(col, row);
      if (layer.bridge) {
        if (n.edge_m > deck_edge_m) continue;
        edge = n.edge_m, segment = n.segment, scene.road_count.at(col, row) = 1;
        continue;
      }
      const std::int32_t under = segment;
      if (n.edge_m < 0.0f || n.edge_m < edge) segment = n.segment;
      const float rounding = source.plan.round_corners_by_angle && under >= 0
                                 ? rounding_m(source, under, n.segment)
                                 : static_cast<float>(source.plan.corner_rounding_m);
      edge = edge >= far_from_roads_m ? n.edge_m : smooth_min(edge, n.edge_m, rounding);
      if (n.edge_m < 0.3f) ++scene.road_count.at(col, row);
    }
}

/// Carriageways, and what lies along their edges: kerbs, pavements, shoulders, verges.
void cover_roads(const SceneSource& source, const Band& band, SceneRaster& scene) {
  for (int row = band.first; row < band.first + band.rows; ++row)
    for (int col = 0; col < scene.frame.width; ++col) {
      const std::int32_t segment = scene.road_segment.at(col, row);
      if (segment < 0) continue;
      const float edge = scene.road_edge_m.at(col, row);
      Cover& cover = scene.cover.at(col, row);
      const RoadSample& place = source.road_samples[static_cast<std::size_t>(segment)];
      const PlannedRoad& road = source.plan.roads[place.road];
      const std::string& highway = road.highway;
      const bool unpaved = road.pavement == Pavement::gravel || road.pavement == Pavement::dirt;
      const bool walk = highway == "residential" && !unpaved && source.plan.walk_to_m > 0.0;
      if (edge <= 0.0f)
        cover = Cover::road;
      else if (is_raceway(highway)) {
        if (edge < kerb_m && place.road == source.plan.circuit && std::abs(place.banking) > kerb_banking_rad &&
            scene.road_count.at(col, row) < 2)
          cover = Cover::kerb;
        else if (edge < verge_m && cover == Cover::field)
          cover = Cover::meadow;
      } else if (is_paved(cover) || cover == Cover::gravel || cover == Cover::path || cover == Cover::parking ||
                 cover == Cover::rails || cover == Cover::river)
        continue;
      else if (walk && edge < source.plan.walk_to_m) {
        if (edge < kerbstone_m || edge >= source.plan.walk_from_m) cover = Cover::sidewalk;
      } else if (edge < shoulder_m && !unpaved)
        cover = Cover::gravel;
      else if (edge < verge_m && cover == Cover::field)
        cover = Cover::verge;
    }
}

void paint_roads(const SceneSource& source, const std::vector<RoadLayer>& layers, const Band& band,
                 SceneRaster& scene) {
  for (int row = band.first; row < band.first + band.rows; ++row)
    for (int col = 0; col < scene.frame.width; ++col) {
      scene.road_segment.at(col, row) = -1;
      scene.road_edge_m.at(col, row) = far_from_roads_m;
      scene.road_count.at(col, row) = 0;
    }
  std::vector<NearSegment> near(static_cast<std::size_t>(scene.frame.width) * static_cast<std::size_t>(band.rows));
  for (const RoadLayer& layer : layers)
    if (find_nearest(source, layer, band, scene.frame, near)) merge_layer(source, layer, band, near, scene);
  cover_roads(source, band, scene);
}

/// Calls visit(col, row, u, v) for the pixels of the band in a turned rectangle; u along, v across.
template <typename Visit>
void for_rectangle(const Band& band, const GridFrame& frame, Vec2 center, double heading, double half_u, double half_v,
                   const Visit& visit) {
  const double reach = std::hypot(half_u, half_v);
  const Vec2 low = frame.pixel_from_world(center + Vec2{-reach, reach}),
             high = frame.pixel_from_world(center + Vec2{reach, -reach});
  const int row0 = std::max(band.first, static_cast<int>(std::floor(low.y))),
            row1 = std::min(band.first + band.rows, static_cast<int>(std::ceil(high.y)));
  const int col0 = std::max(0, static_cast<int>(std::floor(low.x))),
            col1 = std::min(frame.width, static_cast<int>(std::ceil(high.x)));
  const Vec2 along{std::cos(heading), std::sin(heading)};
  for (int row = row0; row < row1; ++row)
    for (int col = col0; col < col1; ++col) {
      const Vec2 d = frame.center_of(col, row) - center;
      const double u = dot(d, along), v = cross(along, d);
      if (std::abs(u) <= half_u && std::abs(v) <= half_v) visit(col, row, u, v);
    }
}

/// Branches run outwards and grow thinner; twigs fill what lies between them.
void spread_twigs(const SceneSource& source, const Tree& t, const Band& band, SceneRaster& scene) {
  const auto seed = source.seed + static_cast<std::uint32_t>(t.id);
  const double arms = 5.0 + 4.0 * unit_hash(t.id, 8, source.seed);
  for_rectangle(band, scene.frame, t.center, 0.0, 1.1 * t.radius_m, 1.1 * t.radius_m,
                [&](int col, int row, double u, double v) {
                  const double d = std::hypot(u, v) / t.radius_m + 0.2 * fractal_noise(u / 1.5, v / 1.5, seed, 2);
                  if (d >= 1.0) return;
                  const double turn = std::atan2(v, u) * arms / 3.14159265358979;
                  const float branch = std::abs(value_noise(turn + 0.8 * d, 1.6 * d, seed + 2)),
                              twig = value_noise(u / 0.45, v / 0.45, seed + 3);
                  const auto dense = static_cast<float>(0.62 * std::sqrt(1.0 - d));
                  const float share = std::clamp(dense + 0.30f * (0.5f - branch) + 0.22f * twig, 0.0f, 0.9f);
                  std::uint8_t& hidden = scene.twigs.at(col, row);
                  hidden = std::max(hidden, static_cast<std::uint8_t>(255.0f * share));
                  if (d < 0.8) scene.bare_crown.at(col, row) = 1;
                  if (branch > 0.45f) return;  // where the sun shines through
                  float& top = scene.twig_height_m.at(col, row);
                  top = std::max(top, static_cast<float>(t.height_m * (1.0 - 0.5 * d)));
                });
}

/// Of covers that stand up from the ground.
float standing_m(Cover cover, Vec2 p, std::uint32_t seed) {
  if (cover == Cover::barrier) return 1.1f;
  if (cover == Cover::rock) return std::max(0.0f, 2.0f + 2.2f * fractal_noise(p.x / 7.0, p.y / 7.0, seed + 95, 4));
  if (cover == Cover::debris) return std::max(0.0f, 0.4f + 0.5f * fractal_noise(p.x / 1.5, p.y / 1.5, seed + 96, 2));
  return 0.0f;
}

/// Heights of decks of bridges over the ground, their parapets too; nothing stands anywhere else yet.
void raise_bridges(const SceneSource& source, const Band& band, SceneRaster& scene) {
  const GridFrame& frame = scene.frame;
  for (int row = band.first; row < band.first + band.rows; ++row)
    for (int col = 0; col < frame.width; ++col) {
      scene.object.at(col, row) = -1;
      float& height = scene.height_m.at(col, row);
      height = standing_m(scene.cover.at(col, row), frame.center_of(col, row), source.seed);
      const std::int32_t segment = scene.road_segment.at(col, row);
      if (segment < 0) continue;
      const RoadSample& a = source.road_samples[static_cast<std::size_t>(segment)];
      const RoadSample& b = source.road_samples[static_cast<std::size_t>(segment) + 1];
      if (!(a.bridge || b.bridge)) continue;
      height = std::max(0.0f, 0.5f * (a.z_m + b.z_m) - ground_height(source, frame.center_of(col, row))) +
               (scene.road_edge_m.at(col, row) > 0.0f ? 0.9f : 0.0f);
    }
}

void raise_car(const Car& c, std::int32_t number, const Band& band, SceneRaster& scene) {
  for_rectangle(band, scene.frame, c.center, c.heading_rad, c.half_length_m, c.half_width_m,
                [&](int col, int row, double u, double v) {
                  if (std::hypot(std::max(0.0, std::abs(u) - c.half_length_m + 0.5),
                                 std::max(0.0, std::abs(v) - c.half_width_m + 0.5)) > 0.5)
                    return;
                  float& top = scene.height_m.at(col, row);
                  if (scene.object.at(col, row) >= 0) return;  // under a crown or a roof
                  top += static_cast<float>(std::abs(u) < 0.55 * c.half_length_m ? c.height_m : 0.65 * c.height_m);
                  scene.object.at(col, row) = number;
                });
}

void raise_objects(const SceneSource& source, const Band& band, SceneRaster& scene) {
  const GridFrame& frame = scene.frame;
  raise_bridges(source, band, scene);
  const auto put = [&](int col, int row, double height, std::int32_t number) {
    float& top = scene.height_m.at(col, row);
    if (static_cast<float>(height) <= top) return;
    top = static_cast<float>(height);
    scene.object.at(col, row) = number;
  };
  std::int32_t number = 0;
  for (const House& h : source.objects.houses) {
    constexpr double eaves_m = 0.4;
    for_rectangle(band, frame, h.center, h.heading_rad, h.half_length_m + eaves_m, h.half_width_m + eaves_m,
                  [&](int col, int row, double, double v) {
                    put(col, row,
                        h.roof == RoofShape::flat ? h.eave_m : h.eave_m + (h.half_width_m - std::abs(v)) * h.pitch,
                        number);
                  });
    ++number;
  }
  for (const Tree& t : source.objects.trees) {
    if (t.leaves == Leaves::bare) {
      spread_twigs(source, t, band, scene);
      ++number;
      continue;
    }
    const auto seed = source.seed + static_cast<std::uint32_t>(t.id);
    for_rectangle(band, frame, t.center, 0.0, 1.2 * t.radius_m, 1.2 * t.radius_m,
                  [&](int col, int row, double u, double v) {
                    const double lumps = fractal_noise(u / 1.3, v / 1.3, seed, 2);
                    const double d = std::hypot(u, v) / t.radius_m + 0.28 * lumps;
                    if (d >= 1.0) return;
                    const double dome = t.conifer ? 1.0 - 0.75 * d : 0.55 + 0.45 * std::sqrt(1.0 - d * d);
                    put(col, row, t.height_m * dome - 0.35 * lumps, number);
                  });
    ++number;
  }
  for (const Car& c : source.objects.cars) raise_car(c, number++, band, scene);
}

/// Of default_class_table(); in a struct, as the 38 classes have some of the names, too.
struct Default {
  enum : std::uint8_t { ground, road, parking, building, vegetation, grass, water, rail };
};

/// Of what covers the ground.
std::uint8_t class_of(const SceneSource& source, Cover cover, std::uint16_t detail) {
  switch (cover) {
    case Cover::road:
      return Default::road;
    case Cover::parking:
    case Cover::kerb:
      return Default::parking;
    case Cover::paved:  // drives and yards: with a world, as photos are painted by hand (models/training/README.md)
    case Cover::drive:
    case Cover::apron:
      return source.world != nullptr ? Default::ground : Default::parking;
    case Cover::water:
    case Cover::pool:
    case Cover::river:
      return Default::water;
    case Cover::rails:
      return Default::rail;
    case Cover::orchard:
      return Default::grass;
    case Cover::field: {
      if (source.world != nullptr) return field_look(*source.world, detail).soil ? Default::ground : Default::grass;
      const auto crop = static_cast<Crop>(detail % crop_count);
      return crop == Crop::ploughed || crop == Crop::stubble ? Default::ground : Default::grass;
    }
    case Cover::meadow:
    case Cover::lawn:
    case Cover::verge:
      return Default::grass;
    case Cover::forest_floor:
      return Default::vegetation;
    case Cover::garden_bed:
    case Cover::gravel:
    case Cover::path:
    case Cover::gravel_trap:
    case Cover::sidewalk:
    case Cover::snow:
    case Cover::dirt:
    case Cover::debris:
    case Cover::rock:
    case Cover::barrier:
      return Default::ground;
  }
  return Default::ground;
}
}  // namespace

float ground_height(const SceneSource& source, Vec2 p_local) {
  const Vec2 q = source.earth_frame.pixel_from_world(p_local) - Vec2{0.5, 0.5};
  const int col = static_cast<int>(q.x), row = static_cast<int>(q.y);
  const auto u = static_cast<float>(q.x - col), v = static_cast<float>(q.y - row);
  const Raster<float>& z = source.earth.height_m;
  return (z.at(col, row) * (1.0f - u) + z.at(col + 1, row) * u) * (1.0f - v) +
         (z.at(col, row + 1) * (1.0f - u) + z.at(col + 1, row + 1) * u) * v;
}

SceneRaster rasterize_scene(const SceneSource& source, const GridFrame& frame, int threads) {
  SceneRaster scene{frame,
                    Raster<Cover>(frame.width, frame.height),
                    Raster<std::uint16_t>(frame.width, frame.height),
                    Raster<std::int32_t>(frame.width, frame.height),
                    Raster<float>(frame.width, frame.height),
                    Raster<std::uint8_t>(frame.width, frame.height),
                    Raster<std::int32_t>(frame.width, frame.height),
                    Raster<float>(frame.width, frame.height)};
  if (std::any_of(source.objects.trees.begin(), source.objects.trees.end(),
                  [](const Tree& tree) { return tree.leaves == Leaves::bare; })) {
    scene.twigs = scene.bare_crown = Raster<std::uint8_t>(frame.width, frame.height);
    scene.twig_height_m = Raster<float>(frame.width, frame.height);
  }
  const std::vector<RoadLayer> layers = layers_of(source);
  parallel_for(static_cast<std::size_t>((frame.height + band_rows - 1) / band_rows), threads, [&](std::size_t i) {
    Band band;
    band.first = static_cast<int>(i) * band_rows;
    band.rows = std::min(band_rows, frame.height - band.first);
    band.frame = frame;
    band.frame.height = band.rows, band.frame.first_row += band.first;
    band.box = band.frame.bounds();
    paint_covers(source, band, scene);
    paint_roads(source, layers, band, scene);
    raise_objects(source, band, scene);
  });
  return scene;
}

Raster<std::uint8_t> label_scene(const SceneSource& source, const SceneRaster& scene, int threads) {
  const ObjectCounts counts = counts_of(source.objects);
  Raster<std::uint8_t> labels(scene.frame.width, scene.frame.height);
  parallel_for(static_cast<std::size_t>(scene.frame.height), threads, [&](std::size_t i) {
    const int row = static_cast<int>(i);
    for (int col = 0; col < scene.frame.width; ++col) {
      const std::int32_t object = scene.object.at(col, row);
      std::uint8_t label = class_of(source, scene.cover.at(col, row), scene.detail.at(col, row));
      if (object >= 0 && object < counts.houses)
        label = Default::building;
      else if (object >= counts.houses && object < counts.houses + counts.trees)
        label = Default::vegetation;
      else if (object < 0 && !scene.bare_crown.data.empty() && scene.bare_crown.at(col, row) != 0 &&
               (label == Default::ground || label == Default::grass))
        label = Default::vegetation;
      labels.at(col, row) = label;
    }
  });
  return labels;
}

}  // namespace orthodrive::synth
