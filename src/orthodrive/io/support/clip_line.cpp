// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/support/clip_line.hpp"

#include <algorithm>

#include "orthodrive/geo/segment.hpp"

namespace orthodrive::io {
namespace {
/// Positions 0 < t < 1 on the segment a-b where it meets the ring.
void add_cuts(Vec2 a, Vec2 b, const Ring& ring, std::vector<double>& cuts) {
  const Box2 box = segment_box(a, b);
  for (std::size_t i = 0, j = ring.size() - 1; i < ring.size(); j = i++) {
    if (!box.overlaps(segment_box(ring[j], ring[i]))) continue;
    const Vec2 d = b - a, e = ring[i] - ring[j];
    const double denominator = cross(d, e);
    if (denominator == 0.0) continue;  // parallel: the neighbouring edges cut
    const double t = cross(ring[j] - a, e) / denominator, u = cross(ring[j] - a, d) / denominator;
    if (t > 0.0 && t < 1.0 && u >= 0.0 && u <= 1.0) cuts.push_back(t);
  }
}
}  // namespace

std::vector<std::vector<ClippedPoint>> clip_line(const Polyline& line, const Polygon& area) {
  std::vector<std::vector<ClippedPoint>> pieces;
  if (area.outer.size() < 3) return pieces;
  const Box2 bounds = bounds_of(area.outer);
  std::vector<ClippedPoint> piece;
  const auto finish = [&] {
    if (piece.size() >= 2) pieces.push_back(std::move(piece));
    piece.clear();
  };
  std::vector<double> cuts;
  for (std::size_t i = 0; i + 1 < line.size(); ++i) {
    const Vec2 a = line[i], b = line[i + 1];
    if (!bounds.overlaps(segment_box(a, b))) {
      finish();
      continue;
    }
    cuts.assign({0.0, 1.0});
    add_cuts(a, b, area.outer, cuts);
    for (const Ring& hole : area.holes) add_cuts(a, b, hole, cuts);
    std::sort(cuts.begin(), cuts.end());
    cuts.erase(std::unique(cuts.begin(), cuts.end()), cuts.end());
    for (std::size_t k = 0; k + 1 < cuts.size(); ++k) {
      const double t0 = cuts[k], t1 = cuts[k + 1];
      if (!contains(area, a + (0.5 * (t0 + t1)) * (b - a))) {
        // A cut starts outside here: the border point ends the piece. At t0 = 0 the vertex has done so already.
        if (!piece.empty() && t0 > 0.0) piece.push_back({a + t0 * (b - a), {}});
        finish();
        continue;
      }
      if (piece.empty()) piece.push_back(t0 > 0.0 ? ClippedPoint{a + t0 * (b - a), {}} : ClippedPoint{a, i});
      if (t1 == 1.0) piece.push_back({b, i + 1});
    }
  }
  finish();
  return pieces;
}

}  // namespace orthodrive::io
