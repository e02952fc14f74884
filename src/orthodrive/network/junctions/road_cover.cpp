// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/junctions/road_cover.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "roadquery/surface/junction_surface.hpp"

namespace orthodrive::network {
namespace {

constexpr double cover_step_m = 1.0;
constexpr double off_end_m = 1e-6;   // further from the part's last cross section than this is beyond its end
constexpr double straight_m = 1e-3;  // corners of pieces that lie so near to a straight edge are left out
constexpr double min_piece_area_m2 = 1e-6, right_angle_rad = 0.5 * std::numbers::pi;

/// Without the points that lie on the straight line between their neighbours. The ends stay.
std::vector<Vec2> without_straight(const std::vector<Vec2>& points) {
  std::vector<Vec2> kept{points.front()};
  std::size_t from = 0;
  for (std::size_t to = 2; to < points.size(); ++to) {
    const Vec2 chord = points[to] - points[from];
    const double length = std::hypot(chord.x, chord.y);
    bool straight = length > 0.0;
    for (std::size_t i = from + 1; i < to && straight; ++i)
      straight = std::abs(cross(chord, points[i] - points[from])) <= straight_m * length;
    if (!straight) from = to - 1, kept.push_back(points[from]);
  }
  if (points.size() > 1) kept.push_back(points.back());
  return kept;
}

/// Cross sections so many that neither the reference line nor an edge runs further than a metre between two: where the
/// line turns within less than that, at the inner edge of a tight turn, the outer edge still goes round in an arc.
int sections_of(const roadquery::Road& road, double s0, double s1) {
  constexpr int most = 64;  // times as many: a turn on the spot
  const int steps = std::max(1, static_cast<int>(std::ceil((s1 - s0) / cover_step_m)));
  double longest = 1.0;
  for (int i = 0; i <= 4 * steps; ++i) {
    const double s = s0 + (s1 - s0) * i / (4.0 * steps);
    const double k = roadquery::reference_point(road, s).curvature;
    const roadquery::Edges all = roadquery::road_edges(road, s);
    longest = std::max({longest, 1.0 - k * all.left_t, 1.0 - k * all.right_t});
  }
  constexpr double usual = 2.5;  // bends of which the arcs keep near enough to their chords
  return longest > usual ? steps * std::min(most, static_cast<int>(std::ceil(longest))) : steps;
}

}  // namespace

RoadCover::RoadCover(const roadquery::Road& road, Vec2 origin, double s0, double s1) : road_(&road), origin_(origin) {
  const int steps = sections_of(road, s0, s1);
  std::vector<Vec2> corners;
  for (int i = 0; i <= steps; ++i) {
    const double s = s0 + (s1 - s0) * i / steps;
    const roadquery::PlanPoint p = roadquery::reference_point(road, s);
    s_.push_back(s);
    reference_.push_back(p);
    line_.push_back(Vec2{p.x, p.y} - origin);
    const roadquery::Edges all = edges(s, true);
    for (const double t : {all.left_t, all.right_t}) {
      const roadquery::SurfacePoint corner = roadquery::surface_point(road, s, t, p);
      corners.push_back(Vec2{corner.x, corner.y} - origin);
    }
  }
  bounds_ = bounds_of(corners);
  // An edge moves less between two samples than this, and the nearest sample of a place is at most half a step off its
  // foot.
  constexpr double edge_m = 0.5;
  for (std::size_t i = 0; i < corners.size(); ++i)
    reach_m_ = std::max(reach_m_, distance(corners[i], line_[i / 2]) + 0.5 * cover_step_m + edge_m);
}

roadquery::Edges RoadCover::edges(double s, bool with_sidewalks) const {
  return with_sidewalks ? roadquery::road_edges(*road_, s) : carriageway_edges(*road_, s);
}

std::optional<RoadCover::Place> RoadCover::find(Vec2 p, bool with_sidewalks) const {
  constexpr double chord_m = 1.0;  // of the bounds' corners from the edges between them
  if (!bounds_.grown(chord_m).contains(p)) return std::nullopt;
  std::size_t nearest = 0;
  double least = INFINITY;
  for (std::size_t i = 0; i < line_.size(); ++i) {
    const Vec2 d = p - line_[i];
    if (dot(d, d) < least) least = dot(d, d), nearest = i;
  }
  if (least > reach_m_ * reach_m_) return std::nullopt;
  // The foot of p, roughly: most roads are told from it to lie elsewhere.
  constexpr double near_m = 0.05, beside_m = 1.0;
  double s = s_[nearest];
  for (int iteration = 0; iteration < 12; ++iteration) {  // Newton on (p - r(s)) . r'(s) = 0
    const roadquery::PlanPoint r = iteration == 0 ? reference_[nearest] : roadquery::reference_point(*road_, s);
    const Vec2 tangent{std::cos(r.hdg), std::sin(r.hdg)}, d = p - (Vec2{r.x, r.y} - origin_);
    const double along = dot(d, tangent), across = cross(tangent, d);
    const double wanted = s + along / (r.speed * std::max(1.0 - r.curvature * across, 0.1));
    const double next = std::clamp(wanted, s_.front(), s_.back());
    const bool is_there = std::abs(next - s) < near_m;
    s = next;
    if (!is_there) continue;
    const roadquery::Edges all = edges(s, with_sidewalks);
    if (std::abs(wanted - next) > beside_m || across > all.left_t + beside_m || across < all.right_t - beside_m)
      return std::nullopt;
    break;
  }
  const roadquery::RoadPosition over = roadquery::position_over(*road_, p.x + origin_.x, p.y + origin_.y, s);
  s = std::clamp(over.s, s_.front(), s_.back());
  if (std::abs(over.beyond_m + over.s - s) > off_end_m) return std::nullopt;
  const Place place{s, over.t};
  const roadquery::Edges all = edges(s, with_sidewalks);
  if (place.t > all.left_t || place.t < all.right_t) return std::nullopt;
  return place;
}

double RoadCover::height(const Place& place) const { return roadquery::surface_height(*road_, place.s, place.t); }

std::vector<Polygon> RoadCover::pieces(bool with_sidewalks, const Box2& box) const {
  std::vector<Polygon> result;
  std::vector<Vec2> left, right;  // of the sections of the open ring
  double heading = 0.0;
  const auto close = [&] {
    if (left.empty()) return;
    Ring ring = without_straight(right);
    const std::vector<Vec2> back = without_straight(left);
    ring.insert(ring.end(), back.rbegin(), back.rend());
    if (ring.size() >= 4 && signed_area_m2(ring) > min_piece_area_m2) result.push_back({std::move(ring), {}});
    left.clear(), right.clear();
  };
  for (std::size_t i = 0; i < s_.size(); ++i) {
    const roadquery::Edges all = edges(s_[i], with_sidewalks);
    const roadquery::SurfacePoint l = roadquery::surface_point(*road_, s_[i], all.left_t),
                                  r = roadquery::surface_point(*road_, s_[i], all.right_t);
    const Vec2 at_left = Vec2{l.x, l.y} - origin_, at_right = Vec2{r.x, r.y} - origin_;
    const double h = roadquery::reference_point(*road_, s_[i]).hdg;
    if (!left.empty()) {
      const Vec2 forward{std::cos(h), std::sin(h)}, before_left = left.back(), before_right = right.back();
      const bool folds = dot(at_left - before_left, forward) < 0.0 || dot(at_right - before_right, forward) < 0.0;
      const bool turned = std::abs(h - heading) > right_angle_rad;
      if (folds) {
        close();
        Ring hull = convex_hull({before_left, before_right, at_right, at_left});
        if (hull.size() >= 3 && signed_area_m2(hull) > min_piece_area_m2) result.push_back({std::move(hull), {}});
      } else if (turned) {
        left.push_back(at_left), right.push_back(at_right);
        close();
      }
    }
    if (!box.contains(line_[i])) {
      if (!left.empty()) left.push_back(at_left), right.push_back(at_right), close();
      continue;
    }
    if (left.empty()) {
      heading = h;
    }
    left.push_back(at_left), right.push_back(at_right);
  }
  close();
  return result;
}

}  // namespace orthodrive::network
