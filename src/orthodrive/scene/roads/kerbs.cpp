// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/roads/kerbs.hpp"

#include <algorithm>
#include <cmath>

#include "orthodrive/scene/look/mesh_materials.hpp"
#include "orthodrive/scene/plan/drape.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace orthodrive::scene {
namespace {

constexpr double max_kerb_piece_m = 5.0, kerb_chord_error_m = 0.01;
constexpr double least_lift_m = 0.004;  // over the road where a ramp begins: both would flicker
constexpr double below_m = 0.03;        // the foot of a face lies in the road
constexpr double on_kerb_edge_m = 1e-6;

LinearColor color_of(KerbLook look) {
  switch (look) {
    case KerbLook::stone:
      return {0.36F, 0.355F, 0.34F};
    case KerbLook::red:
      return {0.42F, 0.025F, 0.02F};
    case KerbLook::white:
      return {0.60F, 0.60F, 0.58F};
    case KerbLook::slabs:
      break;
  }
  return {0.27F, 0.265F, 0.255F};
}

/// A raised lane of one section, in s of the road.
struct RaisedLane {
  const roadquery::Road& road;
  const roadquery::LaneSection& section;
  const roadquery::Lane& lane;
  bool is_race() const { return lane.type == roadquery::LaneType::border; }
  double inner_t(double s) const {
    const bool left = lane.id > 0;
    double t = roadquery::evaluate(road.lane_offset, s);
    for (const roadquery::Lane& other : left ? section.left : section.right) {
      if (other.id == lane.id) break;
      t += (left ? 1.0 : -1.0) * roadquery::lane_width(other, s - section.s);
    }
    return t;
  }
  /// The cross section at s between two shares of the way from the carriageway: places and lifts, right one first.
  void cut(double s, double from_m, double to_m, std::array<Vec2, 2>& places, std::array<double, 2>& lifts) const {
    const double sign = lane.id > 0 ? 1.0 : -1.0, width = roadquery::lane_width(lane, s - section.s);
    const auto height = roadquery::lane_height_at(lane.heights, s - section.s);
    const double inner = inner_t(s);
    for (std::size_t k = 0; k < 2; ++k) {
      const double off = std::min(width, (k == 0) == (sign > 0.0) ? from_m : to_m);
      const auto p = roadquery::surface_point(road, s, inner + sign * off);
      places[k] = {p.x, p.y};
      lifts[k] = height.value[0] + (width > 0.0 ? off / width : 0.0) * (height.value[1] - height.value[0]);
    }
  }
};

/// The blocks of a race track's kerb count from the start of its road.
int block_at(double s) { return static_cast<int>(std::floor(s / race_block_m)); }

/// Where pieces begin and end.
std::vector<double> cuts_of(const RaisedLane& raised, double from, double to) {
  std::vector<double> cuts = {from, to};
  for (int block = block_at(from) + 1; raised.is_race() && block <= block_at(to); ++block)
    cuts.push_back(block * race_block_m);
  for (const roadquery::LaneHeight& height : raised.lane.heights) cuts.push_back(raised.section.s + height.s_offset);
  for (const roadquery::PlanElement& element : raised.road.plan) cuts.push_back(element.s);
  std::erase_if(cuts, [&](double s) { return s < from || s > to; });
  std::ranges::sort(cuts);
  constexpr double same_m = 1e-3;
  cuts.erase(std::unique(cuts.begin(), cuts.end(), [](double a, double b) { return b - a < same_m; }), cuts.end());
  std::vector<double> all;
  for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
    const double a = cuts[i], b = cuts[i + 1];
    double bend = 1e-6;
    for (const double share : {0.0, 0.5, 1.0})
      bend = std::max(bend, std::abs(roadquery::reference_point(raised.road, a + share * (b - a)).curvature));
    const double step_m = std::clamp(std::sqrt(8.0 * kerb_chord_error_m / bend), 0.25, max_kerb_piece_m);
    const int parts = std::max(1, static_cast<int>(std::ceil((b - a) / step_m)));
    for (int k = 0; k < parts; ++k) all.push_back(a + (b - a) * k / parts);
  }
  if (!cuts.empty()) all.push_back(cuts.back());
  return all;
}

/// A part of the cross section from the carriageway outwards.
struct KerbStrip {
  double from_m = 0.0, to_m = 0.0;
  KerbLook look = KerbLook::slabs;
  bool steps_inwards = false, steps_outwards = false;  ///< has a face on that side
};

std::vector<KerbStrip> strips_of(const RaisedLane& raised) {
  constexpr double whole_m = 1e6;
  if (raised.is_race()) return {{0.0, whole_m, KerbLook::white, false, true}};
  return {{0.0, kerb_stone_m, KerbLook::stone, true, false}, {kerb_stone_m, whole_m, KerbLook::slabs, false, true}};
}

void add_pieces(const RaisedLane& raised, double from, double to, std::vector<KerbPiece>& pieces) {
  const bool left = raised.lane.id > 0;
  const std::vector<double> cuts = cuts_of(raised, from, to);
  for (const KerbStrip& strip : strips_of(raised)) {
    for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
      std::array<Vec2, 2> start, end;
      std::array<double, 2> low, high;
      raised.cut(cuts[i], strip.from_m, strip.to_m, start, low);
      raised.cut(cuts[i + 1], strip.from_m, strip.to_m, end, high);
      KerbPiece piece{{start[0], end[0], end[1], start[1]}, {low[0], high[0], high[1], low[1]}, {}, strip.look};
      if (raised.is_race() && block_at(0.5 * (cuts[i] + cuts[i + 1])) % 2 == 0) piece.look = KerbLook::red;
      if (*std::ranges::max_element(piece.lift_m) <= 0.0) continue;
      if (cross(end[0] - start[0], start[1] - start[0]) <= 0.0) continue;  // folded, or without width
      piece.is_border[0] = left ? strip.steps_inwards : strip.steps_outwards;
      piece.is_border[2] = left ? strip.steps_outwards : strip.steps_inwards;
      piece.is_border[3] = i == 0, piece.is_border[1] = i + 2 == cuts.size();
      pieces.push_back(piece);
    }
  }
}

/// Between the lines of the piece's two ends and of its two sides by the distances to both.
double lift_at(const KerbPiece& piece, Vec2 p) {
  const auto& c = piece.corners;
  const auto beside = [&](std::size_t a, std::size_t b) {
    const Vec2 along = c[b] - c[a];
    const double length = std::hypot(along.x, along.y);
    return length > 0.0 ? std::max(0.0, cross(along, p - c[a]) / length) : 0.0;
  };
  const double start = beside(3, 0), end = beside(1, 2), right = beside(0, 1), left = beside(2, 3);
  const double u = start + end > 0.0 ? start / (start + end) : 0.0,
               v = right + left > 0.0 ? right / (right + left) : 0.0;
  const auto& h = piece.lift_m;
  return (1.0 - v) * ((1.0 - u) * h[0] + u * h[1]) + v * ((1.0 - u) * h[3] + u * h[2]);
}

class KerbBuilder {
 public:
  explicit KerbBuilder(TriMesh& mesh) : mesh_(mesh) {}

  void add_top(const KerbPiece& piece, std::span<const DrapedCorner> part) {
    const auto base = static_cast<std::uint32_t>(mesh_.positions.size());
    for (const DrapedCorner& c : part) add(c.p, top(piece, c), c.normal);
    for (std::uint32_t k = 2; k < part.size(); ++k)
      mesh_.indices.insert(mesh_.indices.end(), {base, base + k - 1, base + k});
  }
  /// The faces along the part's edges that lie on a border of the piece.
  void add_faces(const KerbPiece& piece, std::span<const DrapedCorner> part) {
    for (std::size_t i = 0; i < 4; ++i) {
      if (!piece.is_border[i]) continue;
      const Vec2 a = piece.corners[i], along = normalized(piece.corners[(i + 1) % 4] - a);
      const auto is_on = [&](const DrapedCorner& c) { return std::abs(cross(along, c.p - a)) < on_kerb_edge_m; };
      for (std::size_t k = 0; k < part.size(); ++k) {
        const DrapedCorner &p = part[k], &q = part[(k + 1) % part.size()];
        if (is_on(p) && is_on(q) && std::max(lift_at(piece, p.p), lift_at(piece, q.p)) > least_lift_m)
          add_face(piece, p, q, left_normal(along) * -1.0);
      }
    }
  }

 private:
  static double top(const KerbPiece& piece, const DrapedCorner& c) {
    return c.z + std::max(least_lift_m, lift_at(piece, c.p));
  }
  void add(Vec2 p, double z, const std::array<double, 3>& n) {
    const auto f = [](double v) { return static_cast<float>(v); };
    mesh_.positions.push_back({f(p.x), f(p.y), f(z)});
    mesh_.normals.push_back({f(n[0]), f(n[1]), f(n[2])});
  }
  void add_face(const KerbPiece& piece, const DrapedCorner& p, const DrapedCorner& q, Vec2 outwards) {
    const auto base = static_cast<std::uint32_t>(mesh_.positions.size());
    const std::array<double, 3> n = {outwards.x, outwards.y, 0.0};
    add(p.p, p.z - below_m, n), add(q.p, q.z - below_m, n);
    add(q.p, top(piece, q), n), add(p.p, top(piece, p), n);
    mesh_.indices.insert(mesh_.indices.end(), {base, base + 1, base + 2, base, base + 2, base + 3});
  }
  TriMesh& mesh_;
};

}  // namespace

std::vector<KerbPiece> kerb_pieces(const roadquery::Road& road) {
  std::vector<KerbPiece> pieces;
  for (std::size_t i = 0; i < road.sections.size(); ++i) {
    const roadquery::LaneSection& section = road.sections[i];
    const double end = i + 1 < road.sections.size() ? road.sections[i + 1].s : road.length;
    for (const auto* side : {&section.left, &section.right})
      for (const roadquery::Lane& lane : *side)
        if (!lane.heights.empty()) add_pieces({road, section, lane}, section.s, end, pieces);
  }
  return pieces;
}

void add_kerbs(const TriMesh& road, std::size_t first_index, std::span<const KerbPiece> pieces, TriMesh& kerbs) {
  std::vector<std::array<Vec2, 4>> polygons;
  polygons.reserve(pieces.size());
  for (const KerbPiece& piece : pieces) polygons.push_back(piece.corners);
  KerbBuilder builder(kerbs);
  cut_at_mesh(road, first_index, polygons, [&](std::size_t number, std::span<const DrapedCorner> part) {
    const std::size_t first = kerbs.positions.size();
    builder.add_top(pieces[number], part);
    builder.add_faces(pieces[number], part);
    const auto color = mesh_color(color_of(pieces[number].look));
    kerbs.colors.insert(kerbs.colors.end(), kerbs.positions.size() - first, color);
  });
}

}  // namespace orthodrive::scene
