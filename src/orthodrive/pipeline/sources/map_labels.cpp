// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/pipeline/sources/map_labels.hpp"

#include <algorithm>
#include <memory>

#include "orthodrive/io/vector/building_reader.hpp"
#include "orthodrive/io/vector/surroundings_reader.hpp"
#include "orthodrive/segment/paint_labels.hpp"

namespace orthodrive {
namespace {

// Bands of doubt to both sides of the edges of ways. They are alike: of a map that lies beside the roads by chance,
// what is said to be road beyond the true edge then weighs as much as what is said to be none within it, and the edge
// that is learned stays where it is. With 1.25 m inside and 3 m outside roads became wider.
constexpr double wide_band_m = 2.0, narrow_band_m = 1.25;

ClassSet of_roles(const ClassTable& table, std::initializer_list<Role> roles) {
  ClassSet set = unknown_class;
  for (std::size_t c = 0; c < table.classes.size(); ++c)
    if (std::find(roles.begin(), roles.end(), table.classes[c].role) != roles.end()) set |= only(static_cast<int>(c));
  return set;
}

ClassSet all_of(const ClassTable& table) {
  ClassSet set = unknown_class;
  for (std::size_t c = 0; c < table.classes.size(); ++c) set |= only(static_cast<int>(c));
  return set;
}

std::vector<PaintShape> shapes_of(const MultiPolygon& polygons) {
  std::vector<PaintShape> shapes;
  shapes.reserve(polygons.size());
  for (const Polygon& polygon : polygons) shapes.push_back({.polygons = {polygon}});
  return shapes;
}

Box2 bounds_of_shape(const PaintShape& shape) {
  if (shape.polygons.empty()) return bounds_of(shape.line).grown(0.5 * shape.width_m);
  return bounds_of(shape.polygons.front().outer);
}

/// A coat with the box of each shape, so that a cell paints what touches it.
struct Coat {
  PaintLayer layer;
  std::vector<Box2> boxes;
};

}  // namespace

WeakLabels map_labels(const RoadNetwork& roads, const Sources::Files& buildings, const Sources::Files& surroundings,
                      const SiteFrame& site, const ClassTable& classes) {
  const MapSurroundings around = io::read_surroundings(surroundings, site);
  PaintLayer water{.shapes = shapes_of(around.water),
                   .classes = of_roles(classes, {Role::water}),
                   .unknown_inside_m = 2.0,
                   .unknown_outside_m = 4.0};
  PaintLayer parking{.shapes = shapes_of(around.parking),
                     .classes = of_roles(classes, {Role::road, Role::maybe_road, Role::ground}),
                     .unknown_inside_m = 0.5,
                     .unknown_outside_m = 1.5};
  PaintLayer houses{.classes = of_roles(classes, {Role::building}), .unknown_inside_m = 1.5, .unknown_outside_m = 2.5};
  PaintLayer vague{.unknown_outside_m = 0.5};  // paths of any surface, and what a roof on posts stands over
  for (const Building& building : io::read_buildings(buildings, site))
    if (!building.is_part) (building.has_walls ? houses : vague).shapes.push_back({.polygons = {building.footprint}});
  for (const MapPath& path : around.paths) vague.shapes.push_back({.line = path.line, .width_m = path.width_m});
  PaintLayer tracks{.classes = of_roles(classes, {Role::road, Role::ground}),
                    .unknown_inside_m = narrow_band_m,
                    .unknown_outside_m = narrow_band_m};
  PaintLayer service{.classes = of_roles(classes, {Role::road, Role::maybe_road}),
                     .unknown_inside_m = narrow_band_m,
                     .unknown_outside_m = narrow_band_m};
  PaintLayer carriageways{
      .classes = of_roles(classes, {Role::road}), .unknown_inside_m = wide_band_m, .unknown_outside_m = wide_band_m};
  for (const RoadPath& path : roads.paths) {
    if (path.tunnel) continue;
    PaintLayer& layer = path.highway == "track" ? tracks : path.highway == "service" ? service : carriageways;
    layer.shapes.push_back({.line = centerline(path), .width_m = path.nodes.front().width_m});
  }
  auto coats = std::make_shared<std::vector<Coat>>();
  for (PaintLayer* layer : {&water, &parking, &houses, &vague, &tracks, &service, &carriageways}) {
    Coat& coat = coats->emplace_back(Coat{std::move(*layer), {}});
    for (const PaintShape& shape : coat.layer.shapes)
      coat.boxes.push_back(bounds_of_shape(shape).grown(coat.layer.unknown_outside_m));
  }
  const ClassSet background = all_of(classes) & ~of_roles(classes, {Role::road});
  return [coats, background](const GridFrame& frame, MapEdges edges) {
    const bool sharp = edges == MapEdges::sharp;
    const Box2 box = frame.bounds();
    std::vector<PaintLayer> layers;
    for (const Coat& coat : *coats) {
      PaintLayer& layer =
          layers.emplace_back(PaintLayer{.classes = coat.layer.classes,
                                         .merge_over = coat.layer.merge_over,
                                         .unknown_inside_m = sharp ? 0.0 : coat.layer.unknown_inside_m,
                                         .unknown_outside_m = sharp ? 0.0 : coat.layer.unknown_outside_m});
      for (std::size_t i = 0; i < coat.boxes.size(); ++i)
        if (coat.boxes[i].overlaps(box)) layer.shapes.push_back(coat.layer.shapes[i]);
    }
    return paint_labels(frame, background, layers);
  };
}

}  // namespace orthodrive
