// SPDX-License-Identifier: Apache-2.0
#pragma once
// The pictures of the report: every stage's result over the photo.

#include <vector>

#include "orthodrive/model/roads/road_network.hpp"
#include "orthodrive/model/scene.hpp"
#include "orthodrive/report/canvas.hpp"
#include "roadquery/map/road_map.hpp"

namespace orthodrive {

[[nodiscard]] Canvas picture_of_input(const Photo& photo, const RoadNetwork& osm, const Box2& box);
/// Road surfaces colored by |offset| from OSM: viridis over 0 .. max_offset_m.
[[nodiscard]] Canvas picture_of_offsets(const Photo& photo, const RoadNetwork& roads, const Box2& box,
                                        double max_offset_m);
/// OSM lines white, refined edges orange.
[[nodiscard]] Canvas picture_of_refinement(const Photo& photo, const RoadNetwork& osm, const RoadNetwork& roads,
                                           const Box2& box);
/// Road surfaces colored by |gradient|: viridis over 0 .. max_gradient.
[[nodiscard]] Canvas picture_of_gradients(const Photo& photo, const RoadNetwork& roads, const Box2& box,
                                          double max_gradient);
/// Lane borders of the OpenDRIVE roads: roads white, connecting roads of junctions orange, bridges blue.
[[nodiscard]] Canvas picture_of_network(const Photo& photo, const roadquery::RoadMap& map, const Box2& box);
/// The triangles of a tile from above: terrain shaded by its slope, roads orange.
[[nodiscard]] Canvas picture_of_tile(const SceneTile& tile, double tile_size_m, int max_px);
/// The driven line, colored by speed: viridis over 0 .. the fastest.
[[nodiscard]] Canvas picture_of_lap(const Photo& photo, std::span<const Vec2> line, std::span<const double> speed_mps,
                                    const Box2& box);

/// Squares of `size_m` around the places where refinement moved roads most, at least two sizes apart.
[[nodiscard]] std::vector<Box2> telling_places(const RoadNetwork& roads, double size_m, std::size_t count);
/// The square around the junction with the most connections.
[[nodiscard]] Box2 busiest_junction(const roadquery::RoadMap& map, double size_m);

}  // namespace orthodrive
