// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/baselines/mrf_evidence.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <mutex>
#include <utility>

#include "orthodrive/baselines/tile_grid.hpp"
#include "orthodrive/core/parallel.hpp"
#include "orthodrive/geo/polygon.hpp"

namespace orthodrive {
namespace {

using namespace baselines;

constexpr double finest_step_along_m = 0.15;
constexpr int max_samples_along = 400;

int samples_along(const ProfileStrip& strip, double gsd_m) {
  const double step_m = std::max(gsd_m, finest_step_along_m);
  return std::clamp(static_cast<int>(std::ceil(distance(strip.a, strip.b) / step_m)), 1, max_samples_along);
}

/// Sums of bytes over the samples along a strip, by knot. Integers: any order of adding gives the same.
struct RawSums {
  std::vector<std::uint32_t> non_road, road_beside, edge, count;
  void resize(std::size_t knots) {
    for (auto* v : {&non_road, &road_beside, &edge, &count}) v->assign(knots, 0);
  }
  void add(const RawSums& other) {
    const auto plus = [](std::vector<std::uint32_t>& to, const std::vector<std::uint32_t>& from) {
      for (std::size_t k = 0; k < to.size(); ++k) to[k] += from[k];
    };
    plus(non_road, other.non_road), plus(road_beside, other.road_beside), plus(edge, other.edge),
        plus(count, other.count);
  }
};

std::size_t knots_of(const ProfileStrip& strip) { return static_cast<std::size_t>(2 * strip.half_knots + 1); }

/// Calls visit(knot, col, row) for the pixel of every sample of the strip.
template <typename Visit>
void for_samples(const ProfileStrip& strip, const GridFrame& frame, double step_m, const Visit& visit) {
  const int along = samples_along(strip, frame.gsd_m);
  for (int j = 0; j < along; ++j) {
    const Vec2 base = strip.a + (strip.b - strip.a) * ((j + 0.5) / along);
    for (int k = -strip.half_knots; k <= strip.half_knots; ++k) {
      const Vec2 pixel = frame.pixel_from_world(base + strip.normal * (k * step_m));
      visit(static_cast<std::size_t>(k + strip.half_knots), static_cast<std::int64_t>(std::floor(pixel.x)),
            static_cast<std::int64_t>(std::floor(pixel.y)));
    }
  }
}

PixelBox reach_of(const ProfileStrip& strip, const GridFrame& frame, double step_m) {
  const Vec2 side = strip.normal * (strip.half_knots * step_m);
  const Box2 box = bounds_of({strip.a - side, strip.b - side, strip.b + side, strip.a + side});
  const Vec2 north_west = frame.pixel_from_world({box.min_x, box.max_y}),
             south_east = frame.pixel_from_world({box.max_x, box.min_y});
  const auto col = static_cast<std::int64_t>(std::floor(north_west.x)),
             row = static_cast<std::int64_t>(std::floor(north_west.y));
  return {col, row, static_cast<int>(std::floor(south_east.x) - static_cast<double>(col)) + 1,
          static_cast<int>(std::floor(south_east.y) - static_cast<double>(row)) + 1};
}

CrossSums finish(const ProfileStrip& strip, const RawSums& raw, int along, const CrossSumOptions& options,
                 double edge_cap_m) {
  const std::size_t knots = knots_of(strip);
  CrossSums sums{.half_knots = strip.half_knots};
  sums.non_road_m.assign(knots, 0.0F), sums.road_beside_m.assign(knots, 0.0F), sums.edge_m.assign(knots, 0.0F);
  const auto mean = [&](const std::vector<std::uint32_t>& bytes, std::size_t k) {
    return (bytes[k] / 255.0 + 0.5 * (along - static_cast<double>(raw.count[k]))) / along;
  };
  double inside = 0.0, beside = 0.0;
  for (std::size_t k = 0; k < knots; ++k) {
    sums.seen += static_cast<double>(raw.count[k]) / (static_cast<double>(along) * static_cast<double>(knots));
    sums.edge_m[k] = static_cast<float>(edge_cap_m * mean(raw.edge, k));
    if (k > 0) {  // trapezoids
      inside += 0.5 * options.step_m * (mean(raw.non_road, k - 1) + mean(raw.non_road, k));
      beside += 0.5 * options.step_m * (mean(raw.road_beside, k - 1) + mean(raw.road_beside, k));
    }
    sums.non_road_m[k] = static_cast<float>(inside);
    sums.road_beside_m[k] = static_cast<float>(beside);
  }
  return sums;
}

}  // namespace

MrfEvidenceSource mrf_photo_evidence(const PhotoSource& photo, const RoadForests& forests,
                                     const EdgeDistanceOptions& options) {
  return {photo.crs, photo.frame, options.cap_m, [&photo, &forests, options](const PixelBox& box) {
            RoadProbabilities p = predict_road_forests(forests, photo, box);
            const auto opposite = [](Raster<std::uint8_t> raster) {
              for (std::uint8_t& value : raster.data) value = static_cast<std::uint8_t>(255 - value);
              return raster;
            };
            return MrfEvidence{opposite(std::move(p.road)), opposite(std::move(p.context)),
                               edge_distance(photo, box, options), std::move(p.valid)};
          }};
}

std::vector<CrossSums> sum_across(std::span<const ProfileStrip> strips, const MrfEvidenceSource& source,
                                  const CrossSumOptions& options, Monitor* monitor) {
  std::map<std::pair<std::int64_t, std::int64_t>, std::vector<std::size_t>> strips_of;  // by row and column of the tile
  std::vector<RawSums> raw(strips.size());
  for (std::size_t i = 0; i < strips.size(); ++i) {
    raw[i].resize(knots_of(strips[i]));
    if (!strips[i].wanted) continue;
    const PixelBox seen = intersection(reach_of(strips[i], source.frame, options.step_m), pixels_of(source.frame));
    if (seen.empty()) continue;
    for (const PixelBox& tile : tiles_of(seen)) strips_of[{tile.row, tile.col}].push_back(i);
  }
  const std::vector<std::pair<std::pair<std::int64_t, std::int64_t>, std::vector<std::size_t>>> tiles(strips_of.begin(),
                                                                                                      strips_of.end());

  std::mutex mutex;
  parallel_for(
      tiles.size(), options.threads,
      [&](std::size_t t) {
        const PixelBox tile = intersection({tiles[t].first.second, tiles[t].first.first, mrf_tile_px, mrf_tile_px},
                                           pixels_of(source.frame));
        const MrfEvidence evidence = source.read(tile);
        for (const std::size_t i : tiles[t].second) {
          RawSums part;
          part.resize(knots_of(strips[i]));
          for_samples(strips[i], source.frame, options.step_m,
                      [&](std::size_t knot, std::int64_t col, std::int64_t row) {
                        if (col < tile.col || col >= tile.end_col() || row < tile.row || row >= tile.end_row()) return;
                        const int x = static_cast<int>(col - tile.col), y = static_cast<int>(row - tile.row);
                        if (evidence.valid.at(x, y) == 0) return;
                        part.non_road[knot] += evidence.non_road.at(x, y);
                        part.road_beside[knot] += evidence.road_beside.at(x, y);
                        part.edge[knot] += evidence.edge_distance.at(x, y);
                        ++part.count[knot];
                      });
          const std::lock_guard lock(mutex);
          raw[i].add(part);
        }
      },
      [&](std::size_t done) {
        if (monitor)
          monitor->progress(static_cast<double>(done) / static_cast<double>(tiles.size()), "roads in the photo");
      });

  std::vector<CrossSums> sums;
  sums.reserve(strips.size());
  for (std::size_t i = 0; i < strips.size(); ++i)
    sums.push_back(finish(strips[i], raw[i], samples_along(strips[i], source.frame.gsd_m), options, source.edge_cap_m));
  return sums;
}

}  // namespace orthodrive
