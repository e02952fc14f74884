// SPDX-License-Identifier: Apache-2.0
#pragma once
// Evaluation of baked roads: the foot of a point on a station's piece of line, and the surface there. Inline, because
// this is what a tyre waits for.

#include <algorithm>
#include <cmath>

#include "roadquery/surface/cross_section.hpp"
#include "roadquery/tables/baked_road.hpp"

namespace roadquery {

/// A place of a station: u of its polynomials, and the line there in the station's frame.
struct LinePlace {
  double u;
  double ahead_m;  ///< what is left of the distance along the line (less the surface's) when u was clamped
  double left_m;   ///< horizontal distance of the point from the line, positive to the left
  double dx_du, dy_du;
  double inverse_speed;
  double bend_x, bend_y;  ///< second derivatives
};

/// Of the surface at a place.
struct SurfacePlace {
  double t, z;
  double sin_bank, cos_bank;
  double h;                 ///< lateral profile
  const ShapePiece* shape;  ///< the piece of it; null: none
  double ahead_m;           ///< the point lies this far ahead of the line at u: 0 unless the station is turned
  double slope, cos_pitch;  ///< of the line there: 0 and 1 unless the station is turned
  double bank_slope;        ///< derivative of the superelevation, of a turned station
};

/// (x, y) in the station's frame.
struct FramePoint {
  double along = 0.0, left = 0.0;
};
inline FramePoint in_frame(const Station& q, double x, double y) {
  const double dx = x - q.x, dy = y - q.y;
  return {dx * q.cos_hdg + dy * q.sin_hdg, dy * q.cos_hdg - dx * q.sin_hdg};
}

/// Two numbers at once: along the heading, and to the left.
using Pair = double __attribute__((vector_size(16)));
inline Pair load_pair(const float (&pair)[2]) {
  // Of four floats, of which two count: g++ 12 converts two by themselves one after the other.
  using Floats = float __attribute__((vector_size(16)));
  using Doubles = double __attribute__((vector_size(32)));
  double both = 0.0;
  __builtin_memcpy(&both, pair, sizeof both);
  const Doubles wide = __builtin_convertvector(reinterpret_cast<Floats>(Pair{both, 0.0}), Doubles);
  return __builtin_shufflevector(wide, wide, 0, 1);
}
inline Pair load_pair(const double (&pair)[2]) {
  Pair loaded;
  __builtin_memcpy(&loaded, pair, sizeof loaded);
  return loaded;
}

/// The line at u in the station's frame, and its derivatives by u.
struct LinePolynomial {
  Pair position, tangent, bend;
};
inline LinePolynomial line_at(const Station& q, double u) {
  constexpr Pair three = {3.0, 3.0}, four = {4.0, 4.0}, five = {5.0, 5.0};
  const Pair speed = {q.speed, 0.0}, uu = {u, u}, u2 = uu * uu;
  const Pair c2 = load_pair(q.bend[0]), c4 = load_pair(q.bend[2]);
  const Pair b3 = uu * load_pair(q.bend[1]), b5 = uu * load_pair(q.bend[3]);
  const Pair low = c2 + b3, high = c4 + b5;                      // of the position
  const Pair low1 = low + (low + b3), high1 = four * high + b5;  // of its first derivative
  return {uu * (speed + uu * (low + u2 * high)), speed + uu * (low1 + u2 * high1),
          (low1 + three * b3) + u2 * (three * high1 + five * b5)};
}

/// The place in the station's frame that lies `off` ahead of the line's point and to its left.
inline FramePoint place_beside(const LinePolynomial& line, const FramePoint& off) {
  const double speed = std::sqrt(line.tangent[0] * line.tangent[0] + line.tangent[1] * line.tangent[1]);
  return {line.position[0] + (off.along * line.tangent[0] - off.left * line.tangent[1]) / speed,
          line.position[1] + (off.along * line.tangent[1] + off.left * line.tangent[0]) / speed};
}

/// Foot on the circle of curvature in the middle: a start for foot_on, and how far to go to the right station.
inline double guess_u(const Station& q, const FramePoint& p) {
  const double speed = q.speed, speed2 = speed * speed;
  const double turn = 2.0 * (q.bend[0][1] * p.left + q.bend[0][0] * p.along);
  // Of a start the fourth order may be missed.
  if (std::abs(turn) < 0.1 && std::abs(speed2 - 1.0) < 1e-3) return p.along * ((1.0 + turn) * (1.0 + turn * turn));
  return p.along * speed / std::max(speed2 - turn, 0.2 * speed2);
}

/// About where a point lies on a station: u of its foot, and how far to the left of the line.
struct NearPlace {
  double u = 0.0, left_m = 0.0;
};
inline NearPlace near_place(const Station& q, double x, double y) {
  const FramePoint p = in_frame(q, x, y);
  const double u = guess_u(q, p);
  return {u, p.left - u * u * static_cast<double>(q.bend[0][1])};
}
/// Of u, next to the station's ends: what near_place() may miss.
inline double end_margin_m(const Station& q) { return 0.01 + 0.02 * q.half_m; }
inline bool is_in_core(const Station& q, const StationJunction& junction, const NearPlace& place) {
  return std::abs(place.u) <= q.half_m - end_margin_m(q) && place.left_m >= junction.core_right * free_step_m &&
         place.left_m <= junction.core_left * free_step_m;
}

inline double inverse_root(double square) {
  const double e = square - 1.0;
  return std::abs(e) < 1e-4 ? 1.0 - 0.5 * e + 0.375 * e * e : 1.0 / std::sqrt(square);
}

/// The place at u, seen from a point at `offset` from the line's point there.
inline LinePlace place_at(double u, Pair offset, Pair tangent, Pair bend) {
  const double inverse_speed = inverse_root(tangent[0] * tangent[0] + tangent[1] * tangent[1]);
  return {u,
          (offset[0] * tangent[0] + offset[1] * tangent[1]) * inverse_speed,
          (offset[1] * tangent[0] - offset[0] * tangent[1]) * inverse_speed,
          tangent[0],
          tangent[1],
          inverse_speed,
          bend[0],
          bend[1]};
}
inline LinePlace place_at(const Station& q, double u, const FramePoint& p) {
  const LinePolynomial line = line_at(q, u);
  return place_at(u, Pair{p.along, p.left} - line.position, line.tangent, line.bend);
}

/// Foot of the perpendicular from p onto the station's line, by Newton's method from u on; up to half a metre and a
/// quarter beyond the station's ends, where the polynomials still hold roughly. With guess_u as the start the result
/// does not depend on where the point came from. `turned`: the place that p lies `ahead` of instead.
template <bool turned = false>
inline LinePlace foot_on(const Station& q, const FramePoint& p, double u, double ahead_m = 0.0) {
  constexpr double last_step_m = 1e-3;  // Newton's next one would be below 1e-7 m
  constexpr double least_share = 0.05;
  constexpr int max_steps = 16;
  const double bound = 1.25 * q.half_m + 0.5;
  for (int i = 0;; ++i) {
    const LinePolynomial line = line_at(q, u);
    const Pair offset = Pair{p.along, p.left} - line.position;
    const Pair speed2 = line.tangent * line.tangent, down = offset * line.tangent, turn = offset * line.bend;
    const double square = speed2[0] + speed2[1], rest = square - (turn[0] + turn[1]);
    double along = down[0] + down[1];
    if constexpr (turned) along -= ahead_m * q.speed;
    // Beyond the centre of curvature the Newton step would point away from the line.
    const double step = along / std::max(rest, least_share * square);
    const double next = std::clamp(u + step, -bound, bound), d = next - u;
    u = next;
    // Near the centre the error after a step is its square over the share that is left.
    const double small = rest > 0.5 * square ? last_step_m : 1e-6;
    if (std::abs(d) < small || i + 1 == max_steps) {
      const Pair bend = line.bend + 6.0 * d * load_pair(q.bend[1]);
      return place_at(u, offset - d * (line.tangent + 0.5 * d * line.bend), line.tangent + d * line.bend, bend);
    }
  }
}

inline double cubic_at(const double (&c)[4], double ds) { return c[0] + ds * (c[1] + ds * (c[2] + ds * c[3])); }

/// Two cubics of ds.
inline Pair cubics_at(const double (&c)[4][2], double ds) {
  const Pair d = {ds, ds};
  return load_pair(c[0]) + d * (load_pair(c[1]) + d * (load_pair(c[2]) + d * load_pair(c[3])));
}

inline void sin_cos(double angle, double& sine, double& cosine) {
  if (std::abs(angle) < 0.25) {  // series to 1e-11
    const double a = angle * angle, a2 = a * a;
    sine = angle * ((1.0 - a * (1.0 / 6.0)) + a2 * (1.0 / 120.0 - a * (1.0 / 5040.0)));
    cosine = (1.0 - a * 0.5) + a2 * ((1.0 / 24.0 - a * (1.0 / 720.0)) + a2 * (1.0 / 40320.0));
  } else {
    sine = std::sin(angle), cosine = std::cos(angle);
  }
}

/// Superelevation, and height over the middle.
struct Profile {
  double bank, rise;
};
inline Profile profile_at(const Station& q, double u) {
  const Pair uu = {u, u};
  const Pair sum = uu * (load_pair(q.profile[0]) + uu * (load_pair(q.profile[1]) + uu * load_pair(q.profile[2])));
  return {static_cast<double>(q.bank) + sum[0], sum[1]};
}
/// Their derivatives by u.
inline Profile profile_slope_at(const Station& q, double u) {
  constexpr Pair two = {2.0, 2.0}, three = {3.0, 3.0};
  const Pair uu = {u, u};
  const Pair sum =
      load_pair(q.profile[0]) + uu * (two * load_pair(q.profile[1]) + uu * (three * load_pair(q.profile[2])));
  return {sum[0], sum[1]};
}

/// A piece of the lateral profile at one s: c0 + c1 dt + c2 dt^2 + c3 dt^3.
struct ShapeSlice {
  Pair low, high;  // c0 and c1, c2 and c3

  ShapeSlice(const ShapePiece& piece, double s) {
    const double ds = s - piece.s;
    low = load_pair(piece.value[0]) + ds * load_pair(piece.slope[0]);
    high = load_pair(piece.value[1]) + ds * load_pair(piece.slope[1]);
  }
  [[nodiscard]] double height(double dt) const { return low[0] + dt * low[1] + dt * dt * (high[0] + dt * high[1]); }
  [[nodiscard]] double slope(double dt) const { return low[1] + dt * (2.0 * high[0] + dt * (3.0 * high[1])); }
  [[nodiscard]] double bend(double dt) const { return 2.0 * high[0] + dt * (6.0 * high[1]); }
};

/// The piece of `count` that holds t.
inline const ShapePiece* piece_at(const ShapePiece* pieces, int count, double t) {
  while (count > 1 && t >= static_cast<double>(pieces[1].begin)) ++pieces, --count;
  return pieces;
}

/// Lateral profile at s, t.
inline void shape_at(const ShapePiece* pieces, int count, double s, double t, SurfacePlace& place) {
  place.shape = piece_at(pieces, count, t);
  const ShapeSlice row(*place.shape, s);
  const double dt = t - static_cast<double>(place.shape->origin);
  place.t = t, place.h = row.height(dt);
}

/// Second derivative of the height by u.
inline double profile_bend_at(const Station& q, double u) {
  return 2.0 * static_cast<double>(q.profile[1][1]) + 6.0 * u * static_cast<double>(q.profile[2][1]);
}

/// Slopes of the lateral profile along the road and across it, at the place of q's u.
struct ShapeSlopes {
  double along = 0.0, across = 0.0;
};
inline ShapeSlopes shape_slopes(const Station& q, double u, const SurfacePlace& on) {
  if (on.shape == nullptr) return {};
  const double dt = on.t - static_cast<double>(on.shape->origin);
  const Pair low = load_pair(on.shape->slope[0]), high = load_pair(on.shape->slope[1]);
  return {low[0] + dt * low[1] + dt * dt * (high[0] + dt * high[1]), ShapeSlice(*on.shape, q.s + u).slope(dt)};
}

/// Fills in z of a place that has all before it.
inline void lift(const Station& q, double u, const Profile& profile, SurfacePlace& place) {
  place.z = q.z + profile.rise + place.t * place.sin_bank + place.h * place.cos_bank;
  place.ahead_m = 0.0, place.slope = 0.0, place.cos_pitch = 1.0;
  if (q.turned == not_turned) return;
  const auto [bank_slope, slope] = profile_slope_at(q, u);
  place.slope = slope, place.cos_pitch = cos_of_slope(slope), place.bank_slope = bank_slope;
  const double rise = (place.t * place.sin_bank + place.h * place.cos_bank) * place.cos_pitch;
  place.z = q.z + profile.rise + rise;
  place.ahead_m = -rise * place.slope;
}

/// The surface at u and t.
inline void surface_at_t(const BakedRoads& roads, const Station& q, double u, double t, SurfacePlace& place) {
  const Profile profile = profile_at(q, u);
  sin_cos(profile.bank, place.sin_bank, place.cos_bank);
  place.t = t, place.h = 0.0, place.shape = nullptr;
  if (q.shape_count > 0) shape_at(&roads.shapes[q.shapes], q.shape_count, q.s + u, t, place);
  lift(q, u, profile, place);
}

/// The t with t cos(bank) - h(t) sin(bank) = left_m, and the lateral profile there. The profile moves points sideways
/// by h sin(bank), a thousandth of t.
inline void shape_at_left(const ShapePiece* pieces, int count, double s, double left_m, SurfacePlace& place) {
  const double t0 = left_m * (1.0 / place.cos_bank);
  place.shape = piece_at(pieces, count, t0);
  const ShapeSlice slice(*place.shape, s);
  const double dt = t0 - static_cast<double>(place.shape->origin);
  const double height = slice.height(dt), slope = slice.slope(dt), half_bend = 0.5 * slice.bend(dt);
  // One step of Halley's method: what is missed is of third order, below rounding within nearby_m.
  constexpr double nearby_m = 0.02;
  const double share = place.sin_bank / (place.cos_bank - slope * place.sin_bank);
  const double first = height * share, step = first * (1.0 + first * (share * half_bend));
  place.t = t0 + step, place.h = height + step * (slope + step * (half_bend + step * slice.high[1]));
  if (std::abs(step) < nearby_m && piece_at(pieces, count, place.t) == place.shape) return;
  shape_at(pieces, count, s, t0, place);
  for (int i = 0; i < 3; ++i) {
    const double miss = left_m - (place.t * place.cos_bank - place.h * place.sin_bank);
    if (std::abs(miss) < 1e-9) break;
    const double slope = ShapeSlice(*place.shape, s).slope(place.t - static_cast<double>(place.shape->origin));
    shape_at(pieces, count, s, place.t + miss / (place.cos_bank - slope * place.sin_bank), place);
  }
}

/// The surface at u that lies left_m horizontally to the left of the line.
inline void surface_at_left(const BakedRoads& roads, const Station& q, double u, double left_m, SurfacePlace& place) {
  const Profile profile = profile_at(q, u);
  sin_cos(profile.bank, place.sin_bank, place.cos_bank);
  if (q.shape_count > 0) {
    shape_at_left(&roads.shapes[q.shapes], q.shape_count, q.s + u, left_m, place);
  } else {
    place.t = left_m / place.cos_bank, place.h = 0.0, place.shape = nullptr;
  }
  lift(q, u, profile, place);
}

/// About how far the surface over the point left_m to the left of the line at u lies ahead of it: to a hundredth, on
/// roads as they are built.
inline double guess_ahead_m(const BakedRoads& roads, const Station& q, double u, double left_m) {
  double up = left_m * (static_cast<double>(q.bank) + u * static_cast<double>(q.profile[0][0]));
  if (q.shape_count > 0) {
    const ShapePiece* piece = piece_at(&roads.shapes[q.shapes], q.shape_count, left_m);
    up += ShapeSlice(*piece, q.s + u).height(left_m - static_cast<double>(piece->origin));
  }
  const double slope = static_cast<double>(q.profile[0][1]) + 2.0 * u * static_cast<double>(q.profile[1][1]);
  return -up * slope * (1.0 - 0.5 * slope * slope);
}

/// As guess_u where the station is turned.
inline double guess_turned_u(const BakedRoads& roads, const Station& q, const FramePoint& p) {
  const double half = q.half_m, reach = static_cast<double>(roads.stretches[q.lanes].reach_m) + 1.0;
  const double u = std::clamp(guess_u(q, p), -half, half);
  const double left_m = std::clamp(p.left - u * u * static_cast<double>(q.bend[0][1]), -reach, reach);
  if (q.turned != far_turned) return guess_u(q, {p.along - guess_ahead_m(roads, q, u, left_m), p.left});
  SurfacePlace on;
  surface_at_left(roads, q, u, left_m, on);
  return guess_u(q, {p.along - on.ahead_m, p.left});
}

/// The surface at the line's place, and what the point then lies ahead of it. Far beside the lanes it goes on as there.
inline void lay_turned(const BakedRoads& roads, const Station& q, LinePlace& line, SurfacePlace& on) {
  const double reach = static_cast<double>(roads.stretches[q.lanes].reach_m) + 1.0;
  const double left_m = std::clamp(line.left_m, -reach, reach);
  surface_at_left(roads, q, line.u, left_m, on);
  line.ahead_m -= on.ahead_m;
  if (left_m != line.left_m) surface_at_left(roads, q, line.u, line.left_m, on);
}

/// What the way along the line to p shrinks by per metre of u.
inline double nearer_by(const LinePlace& line) {
  constexpr double least_share = 0.05;
  const double square = line.dx_du * line.dx_du + line.dy_du * line.dy_du;
  const double inward = line.dx_du * line.bend_y - line.dy_du * line.bend_x;
  return std::max(square - inward * line.left_m * line.inverse_speed, least_share * square) * line.inverse_speed;
}

/// Of a turned station: the place where its surface lies over p, from u on and as far as foot_on goes, and that
/// surface.
inline void turned_foot(const BakedRoads& roads, const Station& q, const FramePoint& p, double u, LinePlace& line,
                        SurfacePlace& on) {
  constexpr double least_rate = 0.05;
  constexpr int max_steps = 16;
  const double nearby_m =
      q.turned == near_turned ? 5e-5 : 1e-8;  // times what the surface lies ahead, and the curvature
  const double bound = 1.25 * q.half_m + 0.5;
  line = foot_on<true>(q, p, u, guess_ahead_m(roads, q, u, p.left - u * u * static_cast<double>(q.bend[0][1])));
  for (int i = 0; i < max_steps; ++i) {
    const double rate = nearer_by(line), inverse_rate = 1.0 / rate;  // while the surface is on its way
    lay_turned(roads, q, line, on);
    if (std::abs(line.ahead_m) < nearby_m) {  // along the tangent
      const double step = line.ahead_m * inverse_rate;
      on.z += (on.slope + line.left_m * on.bank_slope) * step, line.u += step, line.ahead_m = 0.0;
      return;
    }
    const double up = on.t * on.sin_bank + on.h * on.cos_bank, bend = profile_bend_at(q, line.u);
    const double on_from = line.left_m * on.bank_slope * on.slope + up * on.cos_pitch * on.cos_pitch * bend;
    const double step = line.ahead_m / std::max(rate - on.cos_pitch * on_from, least_rate);
    const double next = std::clamp(line.u + step, -bound, bound);
    if (next == line.u) return;
    line = place_at(q, next, p);
  }
}

/// As tangents_at of cross_section.hpp.
inline SectionTangents tangents_at(const Station& q, const LinePlace& line, const SurfacePlace& on, double curvature) {
  const double speed = (line.dx_du * line.dx_du + line.dy_du * line.dy_du) * line.inverse_speed;
  const auto [dbank, slope] = profile_slope_at(q, line.u);
  const auto [dh_ds, dh_dt] = shape_slopes(q, line.u, on);
  const double bend = q.turned != not_turned ? profile_bend_at(q, line.u) : 0.0;
  return tangents_at(SectionPoint{on.t, on.h, on.sin_bank, on.cos_bank, on.slope * on.cos_pitch, on.cos_pitch},
                     SectionSlopes{speed, curvature, slope, bend, dbank, dh_ds, dh_dt}, q.turned != not_turned);
}
inline double curvature_at(const LinePlace& line) {
  return (line.dx_du * line.bend_y - line.dy_du * line.bend_x) * line.inverse_speed * line.inverse_speed *
         line.inverse_speed;
}

/// Unit normal, upwards, in map axes, and the curvature in plan of the line of constant t.
struct Bearing {
  double normal[3] = {0.0, 0.0, 1.0};
  double curvature = 0.0;
};
/// As surface_point of road_surface.hpp.
inline Bearing bearing_at(const Station& q, const LinePlace& line, const SurfacePlace& on) {
  const double inverse_speed = line.inverse_speed, curvature = curvature_at(line);
  const SectionTangents tangents = tangents_at(q, line, on, curvature);
  const double n_forward = tangents.normal_forward(), n_left = tangents.normal_left(), n_up = tangents.area();
  Bearing bearing;
  if (!(n_up > 0.0)) return bearing;  // beyond the centre of curvature the surface is folded over
  const double scale = 1.0 / std::sqrt(n_forward * n_forward + n_left * n_left + n_up * n_up);
  const double tx = (q.cos_hdg * line.dx_du - q.sin_hdg * line.dy_du) * inverse_speed;
  const double ty = (q.sin_hdg * line.dx_du + q.cos_hdg * line.dy_du) * inverse_speed;
  bearing.normal[0] = (tx * n_forward - ty * n_left) * scale;
  bearing.normal[1] = (ty * n_forward + tx * n_left) * scale;
  bearing.normal[2] = n_up * scale;
  bearing.curvature = curvature_beside(curvature, on.t * on.cos_bank - on.h * on.sin_bank, on.ahead_m);
  return bearing;
}

/// The lane at s, t of a stretch; nullptr beyond the edges, and between where there is no lane. As wide as its borders
/// are written, and edge_rounding_m more.
inline const BakedLane* lane_at(const BakedRoads& roads, const LaneStretch& stretch, double s, double t,
                                double edge_rounding_m) {
  const double ds = s - stretch.s;
  const BakedLane* lane = roads.lanes.data() + stretch.first;
  if (t > cubic_at(stretch.center, ds) || stretch.right_count == 0) {
    for (int i = 0; i < stretch.left_count; ++i)
      if (t <= cubic_at(lane[i].outer, ds) + edge_rounding_m) return lane + i;
    return nullptr;
  }
  lane += stretch.left_count;
  for (int i = 0; i < stretch.right_count; ++i)
    if (t >= cubic_at(lane[i].outer, ds) - edge_rounding_m) return lane + i;
  return nullptr;
}

}  // namespace roadquery
