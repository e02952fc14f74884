#pragma once
// The limits of a car, looked up instead of solved.

#include <array>
#include <vector>

#include "vehicle/envelope.hpp"

namespace orthodrive {

/// vehicle::envelope at nodes of speed, load and friction, and of the share of the lateral limit that is used; linear
/// between them (of shares in their angle on the friction ellipse). A plan asks a hundred thousand times, and a driver
/// 200 times a second. Beyond the nodes the outermost count; friction goes on in proportion.
class EnvelopeTable {
 public:
  explicit EnvelopeTable(const vehicle::CarParameters& car);
  [[nodiscard]] vehicle::Envelope at(const vehicle::EnvelopeQuery& query) const;

 private:
  static constexpr std::size_t speeds = 34, normals = 6, frictions = 3, shares = 9;
  static constexpr double speed_step_mps = 3.0;
  static constexpr std::array<double, normals> normal_mps2 = {3.0, 6.0, vehicle::gravity_mps2, 14.0, 20.0, 30.0};
  static constexpr std::array<double, frictions> friction = {0.25, 0.5, 1.0};

  struct Limits {
    double drive_mps2 = 0.0, brake_mps2 = 0.0;
  };
  [[nodiscard]] static std::size_t node(std::size_t speed, std::size_t normal, std::size_t friction) {
    return (speed * normals + normal) * frictions + friction;
  }

  std::vector<double> lateral_mps2_;  ///< a node each
  std::vector<Limits> limits_;        ///< a node and share each
};

}  // namespace orthodrive
