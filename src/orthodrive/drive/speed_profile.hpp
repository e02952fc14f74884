#pragma once
// How fast the car may be at each place of its line.

#include <vector>

#include "orthodrive/drive/driving_line.hpp"
#include "orthodrive/drive/vehicle.hpp"

namespace orthodrive {

constexpr double gravity_mps2 = 9.80665;
constexpr double air_density_kgpm3 = 1.2;
constexpr double crawl_mps = 2.0;  ///< the car never plans to be slower: open lines begin and end with it

/// One speed a line point: the limit by curvature and banking, lowered by a backward pass with the brakes and a forward
/// pass with the engine, both with gradient, drag, rolling resistance and the friction ellipse.
/// (Quasi-steady-state method, e.g. Brayshaw and Harrison 2005.)
[[nodiscard]] std::vector<double> plan_speed(const DrivingLine& line, const Vehicle& vehicle, const Driver& driver);

/// Deceleration by drag and rolling resistance.
[[nodiscard]] double resistance_mps2(const Vehicle& vehicle, double speed_mps);
/// Acceleration that the engine can give, without resistances.
[[nodiscard]] double engine_mps2(const Vehicle& vehicle, double speed_mps);

}  // namespace orthodrive
