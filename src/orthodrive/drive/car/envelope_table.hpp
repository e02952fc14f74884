// SPDX-License-Identifier: Apache-2.0
#pragma once
// The limits of a car, looked up instead of solved.

#include <array>
#include <vector>

#include "orthodrive/drive/car/axle_slip.hpp"
#include "vehicle/envelope.hpp"

namespace orthodrive {

/// vehicle::grip_of at nodes of speed, load and friction, and of the share of the lateral limit that is used; linear
/// between them (of shares in their angle on the friction ellipse). The engine's limit, which jumps from gear to gear,
/// is applied to what was looked up. Within 0.2 m/s2 of vehicle::envelope up to 1.6 times the weight (0.3 with both
/// axles driven, up to half the lateral limit). A plan asks a hundred thousand times, and a driver 200 times a second.
/// Beyond the nodes the outermost count; friction goes on in proportion.
class EnvelopeTable {
 public:
  explicit EnvelopeTable(const vehicle::CarParameters& car);
  [[nodiscard]] vehicle::Envelope at(const vehicle::EnvelopeQuery& query) const;
  /// One number of it, which takes less time.
  [[nodiscard]] double max_lateral_mps2(const vehicle::EnvelopeQuery& query) const;
  /// `slope_mps2`: gravity along the road, which is not subtracted but counts for what is spun up.
  [[nodiscard]] double max_drive_mps2(const vehicle::EnvelopeQuery& query, double slope_mps2 = 0.0) const;
  [[nodiscard]] double max_brake_mps2(const vehicle::EnvelopeQuery& query) const;
  [[nodiscard]] const AxleSlip& front_slip() const { return front_slip_; }
  [[nodiscard]] const AxleSlip& rear_slip() const { return rear_slip_; }

 private:
  static constexpr std::size_t speeds = 34, normals = 9, frictions = 5, shares = 17;
  static constexpr double speed_step_mps = 3.0, normal_step_mps2 = 3.0, friction_step = 0.2;

  struct Nodes {  ///< the eight around a place, and their weights
    std::array<std::size_t, 8> at{};
    std::array<double, 8> weight{};
  };
  [[nodiscard]] static std::size_t node(std::size_t speed, std::size_t normal, std::size_t friction) {
    return (speed * normals + normal) * frictions + friction;
  }
  [[nodiscard]] static Nodes around(const vehicle::EnvelopeQuery& query);
  [[nodiscard]] double lateral_at(const Nodes& nodes) const;
  /// All of it but the lateral limit.
  [[nodiscard]] vehicle::Grip look_up(const vehicle::EnvelopeQuery& query) const;

  vehicle::CarParameters car_;
  AxleSlip front_slip_, rear_slip_;
  std::vector<double> lateral_mps2_;  ///< a node each
  std::vector<vehicle::Grip> grip_;   ///< a node and share each
};

}  // namespace orthodrive
