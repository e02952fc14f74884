// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/synth/true_surfaces.hpp"

#include <array>
#include <cmath>
#include <utility>

namespace orthodrive::synth {
namespace {
Polygon carriageway(const RoadPath& path) {
  const Ring ring = surface_ring(path);
  const std::size_t n = path.nodes.size();
  if (path.nodes.front().p != path.nodes.back().p) return {ring, {}};
  // Closed: two rings instead of a strip that touches itself. The first and the last node coincide.
  Ring right(ring.begin(), ring.begin() + static_cast<long>(n) - 1),
      left(ring.begin() + static_cast<long>(n), ring.end() - 1);
  if (std::abs(signed_area_m2(right)) < std::abs(signed_area_m2(left))) std::swap(right, left);
  return {right, {left}};
}
}  // namespace

std::vector<SynthSurface> true_surfaces(const RoadNetwork& roads) {
  std::vector<SynthSurface> surfaces;
  surfaces.reserve(roads.paths.size());
  for (const RoadPath& path : roads.paths) surfaces.push_back({path.osm_id, path.highway, 1.0, carriageway(path)});
  return surfaces;
}

void SeenPixels::count(const Polygon& carriageway, const Raster<std::uint8_t>& labels, const GridFrame& frame,
                       const ClassTable& classes) {
  std::array<bool, 256> is_road{};
  for (std::size_t i = 0; i < classes.classes.size(); ++i) is_road[i] = classes.classes[i].role == Role::road;
  rasterize(carriageway, frame, [&](int row, int begin, int end) {
    all += end - begin;
    for (int col = begin; col < end; ++col) visible += is_road[labels.at(col, row)] ? 1 : 0;
  });
}

}  // namespace orthodrive::synth
