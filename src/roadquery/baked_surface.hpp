#pragma once
// Evaluation of baked roads: the foot of a point on a station's piece of line, and the surface there. Inline, because
// this is what a tyre waits for.

#include <algorithm>
#include <cmath>

#include "roadquery/baked_road.hpp"

namespace roadquery {

/// A place of a station: u of its polynomials, and the line there in the station's frame.
struct LinePlace {
  double u;
  double ahead_m;  ///< what is left of the distance along the line when u was clamped
  double left_m;   ///< horizontal distance of the point from the line, positive to the left
  double dx_du, dy_du;
  double inverse_speed;
};

/// Of the surface at a place.
struct SurfacePlace {
  double t, z;
  double sin_bank, cos_bank;
  double h, dh_ds, dh_dt;  ///< lateral profile
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
using FloatPair = float __attribute__((vector_size(8)));
inline Pair load_pair(const float (&pair)[2]) {
  FloatPair floats;
  __builtin_memcpy(&floats, pair, sizeof floats);
  return __builtin_convertvector(floats, Pair);
}

/// The line at u in the station's frame, and its derivatives by u.
struct LinePolynomial {
  Pair position, tangent, bend;
};
inline LinePolynomial line_at(const Station& q, double u) {
  const Pair speed = {q.speed, 0.0};
  const Pair c2 = load_pair(q.bend[0]), c3 = load_pair(q.bend[1]), c4 = load_pair(q.bend[2]), c5 = load_pair(q.bend[3]);
  const double u2 = u * u;
  return {u * speed + u2 * ((c2 + u * c3) + u2 * (c4 + u * c5)),
          speed + u * ((2.0 * c2 + (3.0 * u) * c3) + u2 * (4.0 * c4 + (5.0 * u) * c5)),
          (2.0 * c2 + (6.0 * u) * c3) + u2 * (12.0 * c4 + (20.0 * u) * c5)};
}

/// Foot on the circle of curvature in the middle: a start for foot_on, and how far to go to the right station.
inline double guess_u(const Station& q, const FramePoint& p) {
  const double speed2 = static_cast<double>(q.speed) * q.speed;
  const double rest = speed2 - 2.0 * (q.bend[0][1] * p.left + q.bend[0][0] * p.along);
  return p.along * q.speed / std::max(rest, 0.2 * speed2);
}

inline double inverse_root(double square) {
  const double e = square - 1.0;
  return std::abs(e) < 1e-4 ? 1.0 - 0.5 * e + 0.375 * e * e : 1.0 / std::sqrt(square);
}

/// The place at u, seen from a point at `offset` from the line's point there.
inline LinePlace place_at(double u, Pair offset, Pair tangent) {
  const double inverse_speed = inverse_root(tangent[0] * tangent[0] + tangent[1] * tangent[1]);
  return {u,
          (offset[0] * tangent[0] + offset[1] * tangent[1]) * inverse_speed,
          (offset[1] * tangent[0] - offset[0] * tangent[1]) * inverse_speed,
          tangent[0],
          tangent[1],
          inverse_speed};
}
inline LinePlace place_at(const Station& q, double u, const FramePoint& p) {
  const LinePolynomial line = line_at(q, u);
  return place_at(u, Pair{p.along, p.left} - line.position, line.tangent);
}

/// Foot of the perpendicular from p onto the station's line, by Newton's method from u on; up to half a metre and a
/// quarter beyond the station's ends, where the polynomials still hold roughly. With guess_u as the start the result
/// does not depend on where the point came from.
inline LinePlace foot_on(const Station& q, const FramePoint& p, double u) {
  constexpr double last_step_m = 1e-3;  // Newton's next one would be below 1e-7 m
  constexpr double least_share = 0.05;
  constexpr int max_steps = 16;
  const double bound = 1.25 * q.half_m + 0.5;
  for (int i = 0;; ++i) {
    const LinePolynomial line = line_at(q, u);
    const Pair offset = Pair{p.along, p.left} - line.position;
    const Pair speed2 = line.tangent * line.tangent, down = offset * line.tangent, turn = offset * line.bend;
    const double square = speed2[0] + speed2[1], rest = square - (turn[0] + turn[1]);
    // Beyond the centre of curvature the Newton step would point away from the line.
    const double step = (down[0] + down[1]) / std::max(rest, least_share * square);
    const double next = std::clamp(u + step, -bound, bound), d = next - u;
    u = next;
    // Near the centre the error after a step is its square over the share that is left.
    const double small = rest > 0.5 * square ? last_step_m : 1e-6;
    if (std::abs(d) < small || i + 1 == max_steps)
      return place_at(u, offset - d * (line.tangent + 0.5 * d * line.bend), line.tangent + d * line.bend);
  }
}

inline double cubic_at(const double (&c)[4], double ds) { return c[0] + ds * (c[1] + ds * (c[2] + ds * c[3])); }

inline void sin_cos(double angle, double& sine, double& cosine) {
  if (std::abs(angle) < 0.25) {  // series to 1e-11
    const double a = angle * angle, a2 = a * a;
    sine = angle * ((1.0 - a * (1.0 / 6.0)) + a2 * (1.0 / 120.0 - a * (1.0 / 5040.0)));
    cosine = (1.0 - a * 0.5) + a2 * ((1.0 / 24.0 - a * (1.0 / 720.0)) + a2 * (1.0 / 40320.0));
  } else {
    sine = std::sin(angle), cosine = std::cos(angle);
  }
}

inline double bank_at(const Station& q, double u) {
  return q.bank[0] + u * (q.bank[1] + u * (q.bank[2] + u * static_cast<double>(q.bank[3])));
}
inline double rise_at(const Station& q, double u) {
  return u * (q.rise[0] + u * (q.rise[1] + u * static_cast<double>(q.rise[2])));
}

/// Lateral profile at s, t.
inline void shape_at(const ShapePiece* pieces, int count, double s, double t, SurfacePlace& place) {
  while (count > 1 && t >= static_cast<double>(pieces[1].begin)) ++pieces, --count;
  const ShapePiece& q = *pieces;
  const double dt = t - q.origin, ds = s - q.s;
  place.dh_ds = q.slope[0] + dt * (q.slope[1] + dt * (q.slope[2] + dt * static_cast<double>(q.slope[3])));
  const double b = q.value[1] + ds * q.slope[1], c = q.value[2] + ds * q.slope[2], d = q.value[3] + ds * q.slope[3];
  place.h = q.value[0] + ds * q.slope[0] + dt * (b + dt * (c + dt * d));
  place.dh_dt = b + dt * (2.0 * c + dt * 3.0 * d);
}

/// The surface at u and t.
inline void surface_at_t(const BakedRoads& roads, const Station& q, double u, double t, SurfacePlace& place) {
  sin_cos(bank_at(q, u), place.sin_bank, place.cos_bank);
  place.t = t;
  place.h = place.dh_ds = place.dh_dt = 0.0;
  if (q.shape_count > 0) shape_at(&roads.shapes[q.shapes], q.shape_count, q.s + u, t, place);
  place.z = q.z + rise_at(q, u) + t * place.sin_bank + place.h * place.cos_bank;
}

/// The surface at u, above or below the point that lies left_m horizontally to the left of the line.
inline void surface_at_left(const BakedRoads& roads, const Station& q, double u, double left_m, SurfacePlace& place) {
  sin_cos(bank_at(q, u), place.sin_bank, place.cos_bank);
  place.t = left_m / place.cos_bank;
  place.h = place.dh_ds = place.dh_dt = 0.0;
  if (q.shape_count > 0) {
    const ShapePiece* pieces = &roads.shapes[q.shapes];
    shape_at(pieces, q.shape_count, q.s + u, place.t, place);
    // Newton. The shape moves points sideways by h sin(bank), a thousandth of t: three steps are below rounding.
    for (int i = 0; i < 3 && place.sin_bank != 0.0; ++i) {
      const double miss = left_m - (place.t * place.cos_bank - place.h * place.sin_bank);
      if (std::abs(miss) < 1e-9) break;
      place.t += miss / (place.cos_bank - place.dh_dt * place.sin_bank);
      shape_at(pieces, q.shape_count, q.s + u, place.t, place);
    }
  }
  place.z = q.z + rise_at(q, u) + place.t * place.sin_bank + place.h * place.cos_bank;
}

/// Unit normal, upwards, in map axes, and the curvature in plan of the line of constant t.
struct Bearing {
  double normal[3] = {0.0, 0.0, 1.0};
  double curvature = 0.0;
};
/// As surface_point of road_surface.hpp: dP/ds x dP/dt in the frame (forward, left, up) of the line at u.
inline Bearing bearing_at(const Station& q, const LinePlace& line, const SurfacePlace& on) {
  const double u = line.u;
  const Pair bend = line_at(q, u).bend;
  const double inverse_speed = line.inverse_speed;
  const double speed = (line.dx_du * line.dx_du + line.dy_du * line.dy_du) * inverse_speed;
  const double curvature =
      (line.dx_du * bend[1] - line.dy_du * bend[0]) * inverse_speed * inverse_speed * inverse_speed;
  const double left = on.t * on.cos_bank - on.h * on.sin_bank, up = on.t * on.sin_bank + on.h * on.cos_bank;
  const double dbank = q.bank[1] + u * (2.0 * q.bank[2] + u * 3.0 * q.bank[3]);
  const double slope = q.rise[0] + u * (2.0 * q.rise[1] + u * 3.0 * q.rise[2]);
  const double s_forward = speed * (1.0 - curvature * left);
  const double s_left = -up * dbank - on.dh_ds * on.sin_bank;
  const double s_up = slope + left * dbank + on.dh_ds * on.cos_bank;
  const double t_left = on.cos_bank - on.dh_dt * on.sin_bank, t_up = on.sin_bank + on.dh_dt * on.cos_bank;
  const double n_forward = s_left * t_up - s_up * t_left, n_left = -s_forward * t_up, n_up = s_forward * t_left;
  Bearing bearing;
  if (!(n_up > 0.0)) return bearing;  // beyond the centre of curvature the surface is folded over
  const double scale = 1.0 / std::sqrt(n_forward * n_forward + n_left * n_left + n_up * n_up);
  const double tx = (q.cos_hdg * line.dx_du - q.sin_hdg * line.dy_du) * inverse_speed;
  const double ty = (q.sin_hdg * line.dx_du + q.cos_hdg * line.dy_du) * inverse_speed;
  bearing.normal[0] = (tx * n_forward - ty * n_left) * scale;
  bearing.normal[1] = (ty * n_forward + tx * n_left) * scale;
  bearing.normal[2] = n_up * scale;
  bearing.curvature = curvature / (1.0 - curvature * left);
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
