// SPDX-License-Identifier: Apache-2.0
#pragma once
// The fields of structs that several rooms leave in archives (core/byte_archive.hpp).

#include "orthodrive/core/byte_archive.hpp"
#include "orthodrive/core/finding.hpp"
#include "orthodrive/geo/polygon.hpp"
#include "orthodrive/geo/raster.hpp"
#include "orthodrive/geo/vec.hpp"
#include "orthodrive/model/rasters/class_table.hpp"
#include "orthodrive/model/rasters/map_alignment.hpp"

namespace orthodrive {

template <typename Archive>
void fields(Archive& archive, Finding& f) {
  archive(f.severity, f.code, f.message, f.x_m, f.y_m);
}
template <typename Archive>
void fields(Archive& archive, Vec2& p) {
  archive(p.x, p.y);
}
template <typename Archive>
void fields(Archive& archive, Vec3& p) {
  archive(p.x, p.y, p.z);
}
template <typename Archive>
void fields(Archive& archive, Box2& b) {
  archive(b.min_x, b.min_y, b.max_x, b.max_y);
}
template <typename Archive>
void fields(Archive& archive, Polygon& p) {
  archive(p.outer, p.holes);
}
template <typename Archive, typename T>
void fields(Archive& archive, Raster<T>& r) {
  archive(r.width, r.height, r.channels, r.data);
}
template <typename Archive>
void fields(Archive& archive, PlaceAlignment& a) {
  archive(a.displacement_m, a.sigma_m, a.half_width_m, a.sigma_half_width_m);
}
template <typename Archive>
void fields(Archive& archive, ClassInfo& c) {
  archive(c.name, c.color, c.role, c.cost_false_positive, c.cost_false_negative);
}
template <typename Archive>
void fields(Archive& archive, ClassTable& t) {
  archive(t.name, t.classes);
}

}  // namespace orthodrive
