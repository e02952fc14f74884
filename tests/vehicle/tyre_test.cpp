// SPDX-License-Identifier: Apache-2.0
// The Magic Formula against the formula written out, and the transient slip against its closed form.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "vehicle/cars.hpp"
#include "vehicle/tyre_deflection.hpp"

namespace vehicle {
namespace {

using test::preset;

/// D sin(C atan(B x - E (B x - atan(B x)))), slope B C D.
double formula(double slope, double c, double d, double e, double x) {
  const double bx = slope / (c * d) * x;
  return d * std::sin(c * std::atan(bx - e * (bx - std::atan(bx))));
}

TEST(MagicFormula, pure_slip_is_the_formula_of_the_book) {
  const Tyre t = preset("family_car").front_tyre;
  for (const double load : {1000.0, 4000.0, 7000.0}) {
    const double dfz = load / 4000.0 - 1.0;
    for (double slip = -1.0; slip <= 1.0; slip += 0.05) {
      const double dx = load * (1.21 - 0.037 * dfz), kx = load * (21.51 - 0.163 * dfz) * std::exp(0.245 * dfz);
      const double dy = load * (0.99 - 0.145 * dfz);
      const double ky = 14.95 * 4000.0 * std::sin(2.0 * std::atan(load / (2.13 * 4000.0)));
      EXPECT_NEAR(magic_formula(t, load, 1.0, {slip, 0.0, 0.0}).fx_n, formula(kx, 1.685, dx, 0.344, slip), 1e-3);
      EXPECT_NEAR(magic_formula(t, load, 1.0, {0.0, slip, 0.0}).fy_n, formula(ky, 1.193, dy, -1.003, slip), 1e-3);
    }
  }
}

TEST(MagicFormula, aligning_moment_is_force_times_trail) {
  const Tyre t = preset("family_car").front_tyre;
  const TyreForces f = magic_formula(t, 4000.0, 1.0, {0.0, 1e-4, 0.0});
  EXPECT_NEAR(f.mz_nm / f.fy_n, -0.1 * t.radius_m, 1e-5);  // q_dz1 R_0 at the nominal load
  EXPECT_LT(std::abs(magic_formula(t, 4000.0, 1.0, {0.0, 0.4, 0.0}).mz_nm), 0.5 * 0.1 * t.radius_m * 3800.0);
}

TEST(MagicFormula, camber_pushes_where_the_wheel_leans) {
  const Tyre t = preset("family_car").front_tyre;
  EXPECT_NEAR(magic_formula(t, 4000.0, 1.0, {0.0, 0.0, 0.001}).fy_n, 4000.0 * 0.92 * 0.001, 0.01);
}

TEST(MagicFormula, friction_scales_the_peak_and_not_the_slope) {
  const Tyre t = preset("sports_car").rear_tyre;
  const TyreGrip dry = tyre_grip(t, 5000.0, 0.0, 1.0), wet = tyre_grip(t, 5000.0, 0.0, 0.6);
  EXPECT_DOUBLE_EQ(wet.dx_n, 0.6 * dry.dx_n);
  EXPECT_DOUBLE_EQ(wet.dy_n, 0.6 * dry.dy_n);
  EXPECT_DOUBLE_EQ(wet.ky_nprad, dry.ky_nprad);
}

TEST(MagicFormula, combined_slip_stays_near_the_friction_ellipse) {
  double most = 0.0;
  for (const std::string& name : test::presets) {
    const Tyre t = preset(name).rear_tyre;
    for (const double load : {1000.0, 4000.0, 8000.0}) {
      const TyreGrip g = tyre_grip(t, load, 0.0, 1.0);
      for (double kappa = -1.0; kappa <= 1.0; kappa += 0.005) {
        for (double alpha = -1.0; alpha <= 1.0; alpha += 0.005) {
          const TyreForces f = magic_formula(t, load, 1.0, {kappa, alpha, 0.0});
          most = std::max(most, std::hypot(f.fx_n / g.dx_n, f.fy_n / g.dy_n));
        }
      }
    }
  }
  test::record("largest force over the friction ellipse, combined slip of all presets", 1.0, most, 3);
  EXPECT_LE(most, 1.06);  // the weighting functions are fitted to measurements, not to an ellipse
  EXPECT_GE(most, 0.99);
}

TEST(MagicFormula, side_force_of_a_slick_peaks_at_5_to_8_degrees) {
  for (const Tyre& t : {preset("gt3_like").front_tyre, preset("gt3_like").rear_tyre})
    for (const double load : {1000.0, 4000.0, 8000.0}) {
      double most_n = 0.0, peak_rad = 0.0;
      for (double alpha = 0.0; alpha < 0.5; alpha += 1e-3) {
        const double force_n = magic_formula(t, load, 1.0, {0.0, std::tan(alpha), 0.0}).fy_n;
        if (force_n > most_n) most_n = force_n, peak_rad = alpha;
      }
      EXPECT_GT(peak_rad, 5.0 * std::numbers::pi / 180.0) << load;
      EXPECT_LT(peak_rad, 8.0 * std::numbers::pi / 180.0) << load;
      EXPECT_NEAR(most_n, tyre_grip(t, load, 0.0, 1.0).dy_n, 1e-3 * most_n);
    }
}

TEST(MagicFormula, is_odd) {
  const Tyre t = preset("gt3_like").front_tyre;
  const TyreForces a = magic_formula(t, 3000.0, 0.9, {0.03, 0.05, 0.02});
  const TyreForces b = magic_formula(t, 3000.0, 0.9, {0.03, -0.05, -0.02});
  EXPECT_EQ(a.fx_n, b.fx_n);
  EXPECT_EQ(a.fy_n, -b.fy_n);
  EXPECT_EQ(a.mz_nm, -b.mz_nm);
}

TEST(TyreDeflection, reaches_63_percent_after_the_relaxation_length) {
  const Tyre t = preset("family_car").front_tyre;
  const TyreGrip grip = tyre_grip(t, t.nominal_load_n, 0.0, 1.0);
  for (const double speed : {5.0, 30.0, 80.0}) {
    TyreDeflection tyre;
    const double dt = 1e-5, sigma = t.relaxation_lat_m, steady = 0.02;
    double way = 0.0, slip = 0.0;
    while (slip < steady * (1.0 - std::exp(-1.0))) {
      slip = tyre.step(dt, t, grip, {speed, 0.0, -steady * speed}).tan_alpha;
      way += dt * speed;
    }
    EXPECT_NEAR(way, sigma, 2.0 * dt * speed);
  }
}

TEST(TyreDeflection, is_exact_for_any_step) {
  const Tyre t = preset("family_car").front_tyre;
  const TyreGrip grip = tyre_grip(t, t.nominal_load_n, 0.0, 1.0);
  TyreDeflection once, often;
  const ContactMotion motion{40.0, -1.0, -2.0};
  const Slip a = once.step(0.004, t, grip, motion);
  Slip b;
  for (int i = 0; i < 4; ++i) b = often.step(0.001, t, grip, motion);
  EXPECT_NEAR(a.kappa, b.kappa, 1e-12);
  EXPECT_NEAR(a.tan_alpha, b.tan_alpha, 1e-12);
}

TEST(TyreDeflection, is_a_spring_at_rest) {
  const Tyre t = preset("family_car").front_tyre;
  const TyreGrip grip = tyre_grip(t, t.nominal_load_n, 0.0, 1.0);
  TyreDeflection tyre;
  tyre.step(1e-3, t, grip, {0.0, -1.0, 0.0});  // 1 mm
  const Slip slip = tyre.step(1e-3, t, grip, {0.0, 0.0, 0.0});
  EXPECT_NEAR(slip.kappa * grip.kx_n, 1e-3 * carcass_stiffness(t).long_npm, 1e-6);
  for (int i = 0; i < 100000; ++i) tyre.step(1e-3, t, grip, {0.0, 0.0, 0.0});
  EXPECT_EQ(tyre.step(1e-3, t, grip, {0.0, 0.0, 0.0}).kappa, slip.kappa);     // does not creep
  for (int i = 0; i < 1000; ++i) tyre.step(1e-3, t, grip, {0.0, -1.0, 0.0});  // dragged on by a metre
  EXPECT_LT(tyre.u_m(), 0.03);
}

}  // namespace
}  // namespace vehicle
