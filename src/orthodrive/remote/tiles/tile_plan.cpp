// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/remote/tiles/tile_plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "orthodrive/core/error.hpp"
#include "orthodrive/io/support/crs_facts.hpp"
#include "orthodrive/remote/http/url_template.hpp"
#include "orthodrive/remote/tiles/tile_services.hpp"

namespace orthodrive::remote {
namespace {
constexpr double margin_m = 20.0;  // resampling looks a few pixels beyond the area

/// Units of the CRS per metre on the ground, in the middle of the area (geometric mean of both directions).
double units_per_metre(const SiteFrame& site, const Crs& crs) {
  const Box2 box = bounds_of(site.area.outer);
  const Vec2 middle{0.5 * (box.min_x + box.max_x), 0.5 * (box.min_y + box.max_y)};
  const CoordinateTransform target_from_site(site.crs, crs);
  constexpr double step_m = 10.0;
  const Vec2 at = target_from_site.target_from_source(middle);
  const Vec2 east = target_from_site.target_from_source(middle + Vec2{step_m, 0.0}) - at;
  const Vec2 north = target_from_site.target_from_source(middle + Vec2{0.0, step_m}) - at;
  return std::sqrt(std::abs(cross(east, north))) / step_m;
}

double estimated_bytes_a_pixel(const std::string& mime) {
  return mime.find("png") != std::string::npos ? 1.8 : 0.3;  // of aerial photos as services send them
}

Service service_of(const FetchSource& source, const SiteFrame& site, double resolution, HttpClient& client,
                   Secrets& secrets) {
  switch (source.kind) {
    case FetchKind::wmts:
      return wmts_service(source, site, client, secrets);
    case FetchKind::wms:
      return wms_service(source, site, resolution, client, secrets);
    default:
      return template_service(source, secrets);
  }
}

/// Tiles a service says it has at a level.
std::vector<TileAddress> within(std::vector<TileAddress> tiles, const std::optional<TileLimits>& limits) {
  if (!limits) return tiles;
  std::erase_if(tiles, [&](const TileAddress& t) {
    return t.column < limits->min_column || t.column > limits->max_column || t.row < limits->min_row ||
           t.row > limits->max_row;
  });
  return tiles;
}

OptionError too_many(const FetchSource& source, double tiles, double gsd_m) {
  const double factor = std::sqrt(tiles / static_cast<double>(most_tiles));
  return OptionError(
      fmt::format("{}: about {:.0f} million tiles at {:.2f} m, more than the {} million that are fetched at once; say "
                  "resolution_m = {:.1f} "
                  "or take a smaller area",
                  source.to_text, std::ceil(tiles / 1e6), gsd_m, most_tiles / 1000000, gsd_m * factor));
}
}  // namespace

TilePlan plan_tiles(const FetchSource& source, const SiteFrame& site, HttpClient& client, Secrets& secrets) {
  (void)lonlat_box(site, margin_m, source.to_text);  // an area that cannot be fetched is told before a server is asked
  const Service service = service_of(source, site, source.resolution_m, client, secrets);
  const Polygon area = area_in(site, service.set.crs, margin_m, source.to_text);
  const double scale = units_per_metre(site, service.set.crs);
  const TileMatrix& matrix = service.set.matrices[fine_enough(service.set, source.resolution_m * scale)];
  TilePlan plan;
  plan.crs = service.set.crs, plan.matrix = matrix, plan.matrix_set = service.set.identifier,
  plan.format = service.format;
  if (plan.crs.definition == "EPSG:3857") plan.zoom = quad_zoom(matrix);
  plan.gsd_m = matrix.resolution / scale;
  const auto tiles = tiles_over(matrix, area, most_tiles);
  if (!tiles) throw too_many(source, most_tiles_over(matrix, area), plan.gsd_m);
  const auto limits = service.limits.find(matrix.identifier);
  plan.tiles = within(*tiles, limits == service.limits.end() ? std::nullopt : std::optional(limits->second));
  if (plan.tiles.empty())
    throw InputError(source.to_text, "the service has no tiles in the area; take another source or area");
  plan.estimated_mb = static_cast<double>(plan.tiles.size()) * matrix.tile_width * matrix.tile_height *
                      estimated_bytes_a_pixel(plan.format.empty() ? source.url : plan.format) / 1e6;
  plan.url_of = [url_of = service.url_of, matrix](TileAddress tile) { return url_of(matrix, tile); };
  plan.identity = fmt::format("{} {} {} {:.12g} {:.12g} {:.12g} {}", service.identity, plan.crs.definition,
                              matrix.identifier, matrix.resolution, matrix.left, matrix.top, matrix.tile_width);
  return plan;
}

}  // namespace orthodrive::remote
