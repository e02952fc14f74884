#include "photo_site.hpp"

#include "orthodrive/geo/crs.hpp"
#include "orthodrive/io/raster_io.hpp"

namespace orthodrive::app {

SiteFrame site_of_photo(const std::filesystem::path& photo) {
  const io::RasterInfo info = io::raster_info(photo);
  const Box2 box = bounds_of(info.outline_lonlat.outer);
  SiteFrame site{utm_crs(0.5 * (box.min_x + box.max_x), 0.5 * (box.min_y + box.max_y)), {}};
  const CoordinateTransform transform({"EPSG:4326"}, site.crs);
  for (const Vec2 p : info.outline_lonlat.outer) site.area.outer.push_back(transform.target_from_source(p));
  return site;
}

}  // namespace orthodrive::app
