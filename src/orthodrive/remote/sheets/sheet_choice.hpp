// SPDX-License-Identifier: Apache-2.0
#pragma once
// Which sheets of an index an area needs.

#include <string>
#include <vector>

#include "orthodrive/model/site_frame.hpp"
#include "orthodrive/remote/sheets/sheet.hpp"

namespace orthodrive::remote {

/// The box around the area and 100 m, as a raster is cut: a mosaic of the sheets that touch it has no hole that the
/// provider's does not have.
class SheetArea {
 public:
  /// Throws InputError (of `name`) across the antimeridian and for an empty area.
  SheetArea(const SiteFrame& site, const std::string& name);
  [[nodiscard]] const Box2& box() const { return box_; }  ///< degrees
  /// More than a square metre of the footprint (degrees) lies in it. A footprint of more than 10 000 corners counts by
  /// its box.
  [[nodiscard]] bool touches(const MultiPolygon& footprint) const;
  /// The part of the footprint in it, in metres from its middle.
  [[nodiscard]] MultiPolygon part_of(const MultiPolygon& footprint) const;
  [[nodiscard]] double area_m2() const;

 private:
  [[nodiscard]] MultiPolygon in_metres(const MultiPolygon& degrees) const;
  Box2 box_;
  Vec2 middle_, metres_per_degree_;
  MultiPolygon area_;  ///< metres from the middle
};

struct SheetChoice {
  std::vector<Sheet> sheets;     ///< the newest first; the first covers the later
  std::size_t same_place = 0;    ///< left out: a newer one, or an earlier of the index, shows the same place
  std::size_t other_offers = 0;  ///< left out: in another CRS or format than those that cover most, they show no more
};

/// Of sheets that touch the area: one per place, of the CRS and format that covers most of it; of equals that in the
/// CRS of the site, then the first. Where these lack something, sheets of other CRSs and formats (none that only a
/// licensed GDAL reads) are added: two zones of a country meet in an area. Throws InputError (of `name`) for more than
/// most_sheets.
[[nodiscard]] SheetChoice choose_sheets(std::vector<Sheet> sheets, const SheetArea& area, const Crs& site_crs,
                                        const std::string& name);

}  // namespace orthodrive::remote
