// SPDX-License-Identifier: Apache-2.0
#pragma once
// Hills, road profiles cut and filled into them, and the bare earth that results.

#include <cstdint>
#include <optional>
#include <vector>

#include "orthodrive/geo/raster.hpp"
#include "orthodrive/math/cubic_spline.hpp"
#include "orthodrive/synth/ground/height_field.hpp"
#include "orthodrive/synth/plan/site_plan.hpp"

namespace orthodrive::synth {

/// A sum of cosine waves: smooth, band limited, the same at every place for the same seed. Or surveyed ground.
struct Hills {
  struct Wave {
    double kx_1pm = 0.0, ky_1pm = 0.0, phase_rad = 0.0, amplitude_m = 0.0;
  };
  double base_m = 0.0;
  std::vector<Wave> waves;
  std::optional<HeightField> surveyed;  ///< instead of the waves
  [[nodiscard]] double height_m(Vec2 p_local) const;
};

/// Height along a road: a natural (closed roads: periodic) cubic spline, so C2.
struct Profile {
  CubicSpline spline;
  [[nodiscard]] double z(double s) const { return spline.at(s); }
  [[nodiscard]] double gradient(double s) const { return spline.slope(s); }
};

struct Terrain {
  Hills hills;
  std::vector<Profile> profiles;  ///< one per road of the plan
};

/// Clearance plus thickness of the deck: height of the upper road above the lower one at a bridge.
constexpr double bridge_rise_m = 6.2;
constexpr double max_gradient = 0.10;

/// Hills with a relief of 20 - 60 m (less for sites below 1 km and for plans that say so), lowered until every road
/// stays below max_gradient; or the ground of the plan's surveyed heights as it is, in a region with level land and
/// such hills from 250 m beside it on (the circuit may be as steep as it is).
[[nodiscard]] Terrain make_terrain(const SitePlan& plan, std::uint64_t seed);

/// Superelevation from curvature, rad, positive = left side higher.
[[nodiscard]] double banking_rad(const PlannedRoad& road, double curvature_1pm);

/// A place on the surface of a road, every metre: what terrain and painter look up.
struct RoadSample {
  Vec2 p;
  float s_m = 0.0f, z_m = 0.0f, banking = 0.0f, half_width_m = 0.0f;
  std::uint16_t road = 0;
  bool bridge = false;
  bool last = false;  ///< no segment from here to the next sample: end of the road or of what is sampled of it
};
[[nodiscard]] std::vector<RoadSample> sample_roads(const SitePlan& plan, const Terrain& terrain, double step_m);
/// Of some stretches: those of the whole roads, from a little before each stretch to a little behind it.
[[nodiscard]] std::vector<RoadSample> sample_roads(const SitePlan& plan, const Terrain& terrain,
                                                   const std::vector<Stretch>& stretches, double step_m);

struct BareEarth {
  Raster<float> height_m;     ///< hills with road beds; bridges left out
  Raster<float> clearance_m;  ///< distance to the edge of the nearest carriageway, negative inside, at most 40
};
/// `frame` in local metres.
[[nodiscard]] BareEarth make_bare_earth(const SitePlan& plan, const Terrain& terrain, const GridFrame& frame,
                                        int threads);
/// Roads farther away than this leave the ground as it is.
constexpr double max_clearance_m = 40.0;
/// Of a window: `stretches` are those within max_clearance_m of it.
[[nodiscard]] BareEarth make_bare_earth(const SitePlan& plan, const Terrain& terrain,
                                        const std::vector<Stretch>& stretches, const GridFrame& frame, int threads);

}  // namespace orthodrive::synth
