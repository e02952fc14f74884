// SPDX-License-Identifier: Apache-2.0
// Unpaved roads that the labels show and no tag tells of.

#include "orthodrive/refine/photo_surface.hpp"

#include <gtest/gtest.h>

#include "refine/road_scene.hpp"

namespace orthodrive {
namespace {

using namespace test;

/// A way of 100 m through the middle of a scene of 120 m, known by what is usual for its class.
RoadPath usual_way(const std::string& highway) {
  RoadPath path{.osm_id = 1, .highway = highway};
  path.known_surface = surface_of_tags(highway, "", "");
  for (int i = 0; i <= 50; ++i) path.nodes.push_back({.p = at(10.0 + 2.0 * i, 60.0), .s_m = 2.0 * i, .width_m = 4.0});
  return path;
}

KnownSurface seen(const RoadPath& path, const LabelMap& labels) {
  RoadNetwork roads;
  roads.paths = {path};
  const int changed = classify_by_photo(roads, labels);
  EXPECT_EQ(changed, roads.paths[0].known_surface.surface == path.known_surface.surface ? 0 : 1);
  return roads.paths[0].known_surface;
}

void paint_strip(LabelMap& labels, double from_x, double to_x, std::uint8_t label) {
  paint(labels, {at(from_x, 55), at(to_x, 55), at(to_x, 65), at(from_x, 65)}, label);
}

TEST(PhotoSurface, bare_earth_along_a_service_road_makes_it_gravel_and_grass_makes_it_ground) {
  RoadScene scene = make_scene(120.0);
  EXPECT_EQ(seen(usual_way("service"), scene.labels).surface, SurfaceClass::ground) << "all grass";
  EXPECT_EQ(seen(usual_way("service"), scene.labels).source, SurfaceSource::photo);
  paint_strip(scene.labels, 0, 120, label_ground);
  EXPECT_EQ(seen(usual_way("service"), scene.labels).surface, SurfaceClass::gravel);
}

TEST(PhotoSurface, a_majority_of_sixty_percent_of_what_is_visible_decides) {
  RoadScene scene = make_scene(120.0);
  paint_strip(scene.labels, 0, 120, label_road);
  paint_strip(scene.labels, 0, 65, label_ground);  // 55 of 100 m
  EXPECT_EQ(seen(usual_way("service"), scene.labels).source, SurfaceSource::highway);
  paint_strip(scene.labels, 65, 75, label_ground);  // 65 of 100 m
  EXPECT_EQ(seen(usual_way("service"), scene.labels).surface, SurfaceClass::gravel);
  paint_strip(scene.labels, 0, 120, label_vegetation);  // trees hide all of it
  EXPECT_EQ(seen(usual_way("service"), scene.labels).source, SurfaceSource::highway);
  paint_strip(scene.labels, 90, 120, label_ground);  // 20 m are to be seen
  EXPECT_EQ(seen(usual_way("service"), scene.labels).surface, SurfaceClass::gravel);
}

TEST(PhotoSurface, tags_and_streets_are_left_alone_and_a_road_label_paves_no_track) {
  RoadScene scene = make_scene(120.0);
  EXPECT_EQ(seen(usual_way("residential"), scene.labels).surface, SurfaceClass::asphalt);
  RoadPath tagged = usual_way("service");
  tagged.known_surface = {SurfaceClass::setts, SurfaceSource::tag};
  EXPECT_EQ(seen(tagged, scene.labels).surface, SurfaceClass::setts);
  paint_strip(scene.labels, 0, 120, label_road);
  EXPECT_EQ(seen(usual_way("track"), scene.labels).surface, SurfaceClass::gravel);
  EXPECT_EQ(seen(usual_way("track"), scene.labels).source, SurfaceSource::highway);
}

TEST(PhotoSurface, roads_outside_the_photo_and_of_one_place_stay) {
  RoadScene scene = make_scene(120.0);
  RoadPath far = usual_way("service"), point = usual_way("service");
  for (RoadNode& node : far.nodes) node.p = node.p + Vec2{5000.0, 0.0};
  for (RoadNode& node : point.nodes) node.p = at(60, 60);
  EXPECT_EQ(seen(far, scene.labels).source, SurfaceSource::highway);
  EXPECT_EQ(seen(point, scene.labels).source, SurfaceSource::highway);
}

}  // namespace
}  // namespace orthodrive
