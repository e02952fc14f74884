// SPDX-License-Identifier: Apache-2.0
#pragma once
// The frame of a road's cross section, as OpenDRIVE says (1.8, 8.3): heading, then pitch, then roll. The reference
// line's tangent has the slope of the elevation; the cross section is rolled about it by the superelevation. So on a
// slope points of a banked road lie ahead of their place on the reference line, or behind it. The one definition for
// the exact functions and for the tables.

#include <cmath>

namespace roadquery {

/// 1 / sqrt(1 + slope^2): the cosine of the pitch.
inline double cos_of_slope(double slope) {
  const double a = slope * slope;
  // Series to 1e-9; a slope of more than 14 % takes the root.
  if (a < 0.02) return 1.0 + a * (-0.5 + a * (0.375 + a * (-0.3125 + a * 0.2734375)));
  return 1.0 / std::sqrt(1.0 + a);
}

/// A point of a cross section: t along it and h over it.
struct SectionPoint {
  double t = 0.0, h = 0.0;
  double sin_bank = 0.0, cos_bank = 1.0;    ///< of the superelevation
  double sin_pitch = 0.0, cos_pitch = 1.0;  ///< of the slope of the reference line

  /// In the frame of the reference line's heading: metres to the left; `up` before the cross section is pitched.
  [[nodiscard]] double left() const { return t * cos_bank - h * sin_bank; }
  [[nodiscard]] double up() const { return t * sin_bank + h * cos_bank; }
  [[nodiscard]] double ahead() const { return -up() * sin_pitch; }
  [[nodiscard]] double rise() const { return up() * cos_pitch; }
};

/// How things change by s at a point, and the lateral profile across it.
struct SectionSlopes {
  double speed = 1.0, curvature = 0.0;  ///< of the reference line in plan
  double gradient = 0.0, bend = 0.0;    ///< first and second derivative of the elevation
  double dbank_ds = 0.0, dh_ds = 0.0, dh_dt = 0.0;
};

/// Derivatives of the surface point by s and by t, in the frame (forward, left, up) of the reference line's heading.
struct SectionTangents {
  double s_forward = 1.0, s_left = 0.0, s_up = 0.0;
  double t_forward = 0.0, t_left = 1.0, t_up = 0.0;

  /// Area in plan per ds dt: not positive beyond the centre of curvature, where the surface is folded over.
  [[nodiscard]] double area() const { return s_forward * t_left - s_left * t_forward; }
  /// The normal d/ds x d/dt, not of unit length; its third component is area().
  [[nodiscard]] double normal_forward() const { return s_left * t_up - s_up * t_left; }
  [[nodiscard]] double normal_left() const { return s_up * t_forward - s_forward * t_up; }
};

/// `is_turned` false: the point does not depend on the pitch, as it is not over or under the reference line, or the
/// line is level.
inline SectionTangents tangents_at(const SectionPoint& p, const SectionSlopes& d, bool is_turned) {
  const double left = p.left(), up = p.up();
  const double up_ds = left * d.dbank_ds + d.dh_ds * p.cos_bank, up_dt = p.sin_bank + d.dh_dt * p.cos_bank;
  SectionTangents at;
  at.s_forward = d.speed * (1.0 - d.curvature * left);
  at.s_left = -up * d.dbank_ds - d.dh_ds * p.sin_bank;
  at.s_up = d.gradient + up_ds;
  at.t_left = p.cos_bank - d.dh_dt * p.sin_bank;
  at.t_up = up_dt;
  if (!is_turned) return at;
  const double pitch_ds = d.bend * p.cos_pitch * p.cos_pitch;
  at.s_forward -= up_ds * p.sin_pitch + up * p.cos_pitch * pitch_ds;
  at.s_left += p.ahead() * d.curvature * d.speed;
  at.s_up = d.gradient + up_ds * p.cos_pitch - up * p.sin_pitch * pitch_ds;
  at.t_forward = -up_dt * p.sin_pitch;
  at.t_up = up_dt * p.cos_pitch;
  return at;
}

/// Curvature in plan of the line of constant t through the point, where superelevation and slope are constant.
inline double curvature_beside(double curvature, double left, double ahead) {
  const double share = 1.0 - curvature * left, across = curvature * ahead;
  return across == 0.0 || share <= 0.0 ? curvature / share : curvature / std::sqrt(share * share + across * across);
}

}  // namespace roadquery
