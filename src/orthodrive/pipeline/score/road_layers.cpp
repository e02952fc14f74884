// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/pipeline/score/road_layers.hpp"

#include <cmath>
#include <optional>

#include "orthodrive/io/raster/raster_io.hpp"
#include "orthodrive/io/support/vector_io.hpp"
#include "orthodrive/report/road_pictures.hpp"

namespace orthodrive {
namespace fs = std::filesystem;

void write_road_overlay(const fs::path& path, const fs::path& photo_path, const ScoredRoadsView& view) {
  const RoadSurfaces surfaces{surface_polygons(view.roads), surface_polygons(view.truth)};
  const GridFrame frame = road_picture_frame(surfaces, view.region);
  std::optional<Photo> photo;
  if (!photo_path.empty())
    photo = io::read_photo(photo_path, {view.roads.crs, polygon_of(frame.bounds())}, {.gsd_m = frame.gsd_m});
  io::write_png(path, picture_of_road_errors(surfaces, view.region, frame, photo ? &*photo : nullptr).rgb);
}

namespace {
io::NumberLayer polygon_layer(const char* name, const MultiPolygon& polygons) {
  io::NumberLayer layer{.name = name, .fields = {"area_m2"}};
  for (const Polygon& polygon : polygons) layer.rows.push_back({polygon, {area_m2(polygon)}});
  return layer;
}

io::NumberLayer line_layer(const ScoredRoadsView& view) {
  struct Errors {
    std::vector<double> offset_m, width_m;
  };
  std::vector<Errors> of_line(view.truth.lines.size());
  for (const RoadPlace& place : view.scores.places) {
    if (!std::isnan(place.offset_m)) of_line[place.line].offset_m.push_back(place.offset_m);
    if (!std::isnan(place.width_error_m)) of_line[place.line].width_m.push_back(place.width_error_m);
  }
  io::NumberLayer layer{.name = "truth_lines",
                        .fields = {"mean_abs_offset_m", "p95_offset_m", "mean_abs_width_error_m", "n"}};
  for (std::size_t i = 0; i < of_line.size(); ++i) {
    const ErrorSummary offset = summarize(of_line[i].offset_m), width = summarize(of_line[i].width_m);
    layer.rows.push_back(
        {view.truth.lines[i].line, {offset.mean_abs, offset.p95, width.mean_abs, static_cast<double>(offset.n)}});
  }
  return layer;
}

io::NumberLayer sample_layer(const RoadScores& scores) {
  io::NumberLayer layer{
      .name = "truth_samples",
      .fields = {"line", "offset_m", "width_error_m", "offset_before_m", "sigma_offset_m", "sigma_width_m"}};
  for (const RoadPlace& place : scores.places)
    layer.rows.push_back({place.p,
                          {static_cast<double>(place.line), place.offset_m, place.width_error_m, place.offset_before_m,
                           place.sigma_offset_m, place.sigma_width_m}});
  return layer;
}
}  // namespace

void write_road_layers(const fs::path& path, const ScoredRoadsView& view) {
  const SurfaceErrors errors = surface_errors(view.roads, view.truth, view.region);
  io::write_layers(
      path,
      {polygon_layer("false_positive", errors.false_positive), polygon_layer("false_negative", errors.false_negative),
       line_layer(view), sample_layer(view.scores)},
      view.roads.crs);
}

}  // namespace orthodrive
