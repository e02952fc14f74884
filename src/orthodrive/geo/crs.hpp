// SPDX-License-Identifier: Apache-2.0
#pragma once
// Coordinate reference systems by their EPSG code or any text PROJ understands.

#include <memory>
#include <string>

#include "orthodrive/geo/vec.hpp"

namespace orthodrive {

struct ProjOperation;

struct Crs {
  std::string definition;  ///< "EPSG:32633", WKT or a PROJ string
  friend bool operator==(const Crs&, const Crs&) = default;
};

/// The WGS84 UTM zone of a place, the site CRS when the site file names none.
[[nodiscard]] Crs utm_crs(double longitude_deg, double latitude_deg);
/// PROJ string ("+proj=utm +zone=33 +datum=WGS84 +units=m"), for OpenDRIVE's geoReference.
[[nodiscard]] std::string proj_string(const Crs& crs);

/// Transforms points; geographic coordinates are (longitude, latitude) in degrees whatever the CRS's axis order.
/// Not for use from two threads at once. Throws Error for an unknown CRS and for points that cannot be transformed.
class CoordinateTransform {
 public:
  CoordinateTransform(const Crs& source, const Crs& target);
  ~CoordinateTransform();
  CoordinateTransform(CoordinateTransform&&) noexcept;
  CoordinateTransform& operator=(CoordinateTransform&&) noexcept;
  [[nodiscard]] Vec2 target_from_source(Vec2 p) const;
  [[nodiscard]] Vec2 source_from_target(Vec2 p) const;

 private:
  std::unique_ptr<ProjOperation> proj_;
};

/// WGS84 longitude, latitude (degrees) and ellipsoidal height (m) to earth-centred earth-fixed metres.
[[nodiscard]] Vec3 ecef_from_geographic(double longitude_deg, double latitude_deg, double height_m);

/// Inverse of ecef_from_geographic: longitude (deg), latitude (deg), ellipsoidal height (m), to 1e-9 deg and 1e-4 m for
/// places within 100 km of the ellipsoid (Bowring, Transformation from spatial to geographical coordinates, 1976).
[[nodiscard]] Vec3 geographic_from_ecef(const Vec3& p);

}  // namespace orthodrive
