// SPDX-License-Identifier: Apache-2.0
#pragma once
// Height of sea level over the ellipsoid.

#include <memory>
#include <string>

namespace orthodrive {

struct ProjOperation;

/// From the best of PROJ's world-wide grids that is installed (EGM2008, else EGM96; Debian: proj-data has EGM96 at
/// 15'). Not for use from two threads at once.
class Geoid {
 public:
  Geoid();
  ~Geoid();
  Geoid(Geoid&&) noexcept;
  Geoid& operator=(Geoid&&) noexcept;
  /// The grid's file; empty where none is installed.
  [[nodiscard]] const std::string& grid() const { return grid_; }
  /// Over WGS84; 0 without a grid.
  [[nodiscard]] double height_m(double longitude_deg, double latitude_deg) const;

 private:
  std::unique_ptr<ProjOperation> proj_;
  std::string grid_;
};

}  // namespace orthodrive
