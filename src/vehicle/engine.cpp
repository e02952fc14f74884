// SPDX-License-Identifier: Apache-2.0
#include "vehicle/engine.hpp"

#include <algorithm>

namespace vehicle {

double full_load_nm(const Engine& e, double rpm) {
  const auto& n = e.speed_rpm;
  if (rpm <= n.front()) return e.torque_nm.front();
  if (rpm >= n.back()) return e.torque_nm.back();
  const auto i = static_cast<std::size_t>(std::upper_bound(n.begin(), n.end(), rpm) - n.begin());
  const double u = (rpm - n[i - 1]) / (n[i] - n[i - 1]);
  return e.torque_nm[i - 1] + u * (e.torque_nm[i] - e.torque_nm[i - 1]);
}

double drag_nm(const Engine& e, double rpm) {
  // Below half of idle the drag fades out, so that a standing engine stays at rest.
  const double turning = std::clamp(2.0 * rpm / e.idle_rpm, 0.0, 1.0);
  return turning * (e.drag_nm + e.drag_nm_per_krpm * rpm / 1000.0);
}

double crankshaft_nm(const Engine& e, double rpm, double throttle) {
  const double full = full_load_nm(e, rpm), drag = drag_nm(e, rpm);
  // The governor: from drag alone at idle to full load at three quarters of it.
  const double idle = std::clamp(4.0 * (1.0 - rpm / e.idle_rpm), 0.0, 1.0);
  const double fuel = std::clamp(100.0 * (1.005 - rpm / e.limit_rpm), 0.0, 1.0);
  const double share = std::max(throttle, idle) * fuel;
  return -drag + share * (full + drag);
}

double fuel_w(const Engine& e, double rpm, double torque_nm) {
  return std::max(torque_nm + drag_nm(e, rpm), 0.0) * rpm / rpm_per_radps / e.fuel_efficiency;
}

}  // namespace vehicle
