// SPDX-License-Identifier: Apache-2.0
#pragma once
// Engine: torque over speed and pedal, idle, rev limit, fuel.

#include "vehicle/car_parameters.hpp"

namespace vehicle {

inline constexpr double rpm_per_radps = 9.549296585513721;  // 60 / (2 pi)

/// Full-load torque in N m, linear between the points of the map, constant before the first and after the last.
[[nodiscard]] double full_load_nm(const Engine& engine, double rpm);
/// Torque that friction and pumping take with the throttle closed, positive.
[[nodiscard]] double drag_nm(const Engine& engine, double rpm);
/// Torque at the crankshaft for that pedal (0 .. 1): linear from drag to full load; the idle governor holds idle_rpm
/// from below, the fuel is cut over the last 1 % around limit_rpm.
[[nodiscard]] double crankshaft_nm(const Engine& engine, double rpm, double throttle);
/// Heat of the fuel in W (Willans line; Guzzella and Sciarretta, Vehicle Propulsion Systems, 3rd ed., sec. 3.2.1): work
/// on the pistons, which is that of the crankshaft and the drag, over the indicated efficiency. 0 when dragged.
[[nodiscard]] double fuel_w(const Engine& engine, double rpm, double torque_nm);

}  // namespace vehicle
