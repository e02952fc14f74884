// SPDX-License-Identifier: Apache-2.0
#pragma once
// How rough a road is, by ISO 8608:2016: displacement PSD G_d(n) = G_d(n0) (n / n0)^-w with n0 = 0.1 cycles/m; and a
// surface with that PSD, made up but the same for the same seed.

#include <cstdint>
#include <vector>

namespace orthodrive {

inline constexpr double roughness_n0_cycles_per_m = 0.1;

/// A stretch of a path whose roughness was measured.
struct RoughnessStretch {
  std::int64_t osm_id = 0;
  int part = 0;
  double s_begin_m = 0.0, s_end_m = 0.0;  ///< along the path
  char iso_8608_class = 'A';              ///< A (smooth) to H
  double gd_n0_m3 = 0.0;                  ///< G_d(n0) of one wheel track; a road of class A has 16e-6
  double waviness = 2.0;                  ///< w
  double sigma_ln_gd = 0.0;               ///< standard deviation of ln G_d(n0): 0.69 is a factor of two
};

/// Class of a G_d(n0): limits 32e-6 m3 (A to B), then four times each (ISO 8608:2016, table C.1).
[[nodiscard]] char iso_8608_class(double gd_n0_m3);
/// Geometric mean of a class, 16e-6 m3 for 'A', four times each up to 'H'. Throws OptionError for other letters.
[[nodiscard]] double iso_8608_mean_m3(char road_class);

struct RoughnessFieldOptions {
  double shortest_wave_m = 0.1;  ///< along the road; the longest are 20 m long
  int waves = 160;
};

/// A height to add to a road's surface, a pure function of the place (s along the path, t to its left). Along every
/// line t = constant its PSD is that of the stretch, within the band; across it is as rough as along (isotropic, as
/// Kamash and Robson, The application of isotropy in road surface modelling, 1978, have it). Outside the stretches it
/// is 0. Plane waves sum a_i cos(2 pi (n_i s + m_i t) + phase_i): a_i^2 / 2 = G_d(n_i) dn_i, and m_i is drawn from the
/// distribution that an isotropic surface has given n_i, Student's t with w degrees of freedom (Abel transform of
/// n^-w).
class RoughnessField {
 public:
  /// Stretches of one path in ascending s. Throws OptionError for a band without width and a waviness of 1 or less.
  RoughnessField(std::vector<RoughnessStretch> stretches, std::uint64_t seed,
                 const RoughnessFieldOptions& options = {});

  [[nodiscard]] double height_m(double s_m, double t_m) const;
  /// Standard deviation of the height in a stretch: the root of the sum of the waves' powers.
  [[nodiscard]] double rms_m(std::size_t stretch) const;

 private:
  struct Wave {
    double amplitude_m, n_s, n_t, phase;  ///< angular wave numbers in rad/m
  };
  /// A stretch: where it has come and gone by half, and its waves. All have the same ones along, with the same phase.
  struct Level {
    double rises_m, falls_m;
    std::vector<Wave> waves;
  };
  std::vector<Level> levels_;
  double half_blend_m_ = 0.0;
};

}  // namespace orthodrive
