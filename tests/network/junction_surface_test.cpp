// SPDX-License-Identifier: Apache-2.0
// The surface of junctions from exact truth: planes, slopes, crowns, arms that disagree, and what must hold for all.

#include "roadquery/surface/junction_surface.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "io/scratch.hpp"
#include "network_support.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/geo/overlay.hpp"
#include "orthodrive/io/opendrive/opendrive_io.hpp"
#include "orthodrive/network/junctions/fit_junction_surfaces.hpp"
#include "orthodrive/network/junctions/junction_area.hpp"
#include "orthodrive/network/junctions/junction_field.hpp"
#include "roadquery/make_road.hpp"
#include "roadquery/opendrive/junction_surface_text.hpp"
#include "roadquery/query/road_query.hpp"

namespace orthodrive {
namespace {

using namespace orthodrive::network_test;
using roadquery::JunctionHeight;
using roadquery::JunctionSurface;
using roadquery::RoadMap;

const JunctionSurface& only_surface(const RoadMap& map) {
  EXPECT_EQ(map.junctions.size(), 1u);
  const std::optional<JunctionSurface>& surface = map.junctions.at(0).surface;
  if (!surface) throw Error("the junction has no surface");
  return *surface;
}

JunctionHeight at(const JunctionSurface& surface, Vec2 p) {
  return roadquery::evaluate(surface, p.x + site_origin.x, p.y + site_origin.y);
}

/// Calls visit(x, y) for places of the area, 0.25 m apart.
template <typename Visit>
void inside(const JunctionSurface& surface, const Visit& visit) {
  Ring ring;
  for (const auto& [x, y] : surface.boundary) ring.push_back({x, y});
  const Box2 box = bounds_of(ring);
  for (double x = box.min_x; x < box.max_x; x += 0.25)
    for (double y = box.min_y; y < box.max_y; y += 0.25)
      if (roadquery::contains(surface, x, y)) visit(x, y);
}

/// What must hold for the surfaces of every map.
void expect_sound_surfaces(const RoadMap& map, double off_m) {
  for (const roadquery::Junction& junction : map.junctions) {
    ASSERT_TRUE(junction.surface) << junction.id;
    const JunctionSurface& surface = *junction.surface;
    Ring ring;
    for (const auto& [x, y] : surface.boundary) ring.push_back({x - site_origin.x, y - site_origin.y});
    EXPECT_GT(signed_area_m2(ring), 0.0);
    EXPECT_TRUE(is_simple(ring)) << junction.id;
    for (const roadquery::Road& road : map.roads) {
      const bool begins = road.predecessor.kind == roadquery::LinkKind::junction && road.predecessor.id == junction.id;
      const bool ends = road.successor.kind == roadquery::LinkKind::junction && road.successor.id == junction.id;
      for (const double s : {0.0, road.length}) {
        if (s == 0.0 ? !begins : !ends) continue;
        const roadquery::Edges edges = roadquery::road_edges(road, s);
        for (int i = 0; i <= 20; ++i) {
          const double t = edges.right_t + (edges.left_t - edges.right_t) * i / 20.0;
          const roadquery::SurfacePoint p = roadquery::surface_point(road, s, t);
          const JunctionHeight h = roadquery::evaluate(surface, p.x, p.y);
          EXPECT_NEAR(h.z, p.z, 1e-3) << "road " << road.id << " at t " << t;
          if (!road.shape.empty() && std::abs(t) < 1e-9) continue;  // the ridge of a crown has two slopes
          EXPECT_NEAR(h.dz_dx, -p.normal[0] / p.normal[2], 1e-3) << "road " << road.id << " at t " << t;
          EXPECT_NEAR(h.dz_dy, -p.normal[1] / p.normal[2], 1e-3) << "road " << road.id << " at t " << t;
        }
      }
      if (road.junction != junction.id) continue;
      for (double s = 0.05; s < road.length; s += 0.5)
        for (const double share : {0.01, 0.5, 0.99}) {
          const roadquery::Edges edges = roadquery::road_edges(road, s);
          const roadquery::SurfacePoint p =
              roadquery::surface_point(road, s, edges.right_t + share * (edges.left_t - edges.right_t));
          EXPECT_TRUE(roadquery::contains(surface, p.x, p.y)) << "road " << road.id << " at " << s << ", " << share;
          EXPECT_NEAR(roadquery::evaluate(surface, p.x, p.y).z, p.z, off_m) << "road " << road.id << " at " << s;
        }
    }
  }
}

/// Four arms of 60 m, the second way banked as given.
RoadNetwork crossing_on(const std::function<double(Vec2)>& height, double banking = 0.0, double width_m = 7.0) {
  return network_of({make_path({{-60, 0}, {0, 0}, {60, 0}}, {1, 2, 3},
                               {.osm_id = 1, .highway = "secondary", .width_m = width_m, .height = height}),
                     make_path({{0, -60}, {0, 0}, {0, 60}}, {4, 2, 5},
                               {.osm_id = 2, .width_m = width_m, .height = height, .banking = [banking](double) {
                                  return banking;
                                }})});
}

TEST(JunctionSurfaces, PlanarArmsGiveThePlane) {
  const RoadMap map = build_network(crossing_on([](Vec2 p) { return 50.0 + 0.03 * p.x; }, -std::atan(0.03))).map;
  const JunctionSurface& surface = only_surface(map);
  expect_sound_surfaces(map, 5.5e-3);  // profiles are fitted to the surface within 5 mm
  int places = 0;
  inside(surface, [&](double x, double y) {
    const JunctionHeight h = roadquery::evaluate(surface, x, y);
    EXPECT_NEAR(h.z, 50.0 + 0.03 * (x - site_origin.x), 1.5e-4);  // heights are multiples of 0.1 mm
    EXPECT_NEAR(h.dz_dx, 0.03, 1e-3);
    EXPECT_NEAR(h.dz_dy, 0.0, 1e-3);
    ++places;
  });
  EXPECT_GT(places, 1000);
}

TEST(JunctionSurfaces, CornersHaveTheKerbRadiusOfTheSideRoad) {
  const RoadMap map = build_network(crossing_on([](Vec2) { return 0.0; })).map;
  const JunctionSurface& surface = only_surface(map);
  // Edges 3.5 m off the lines: the arc's centre lies at (8.5, 8.5), its nearest point to the corner 5 (sqrt 2 - 1) off.
  const double corner = 3.5 + 5.0 * (1.0 - std::sqrt(0.5));
  for (const Vec2 sign : {Vec2{1, 1}, {1, -1}, {-1, 1}, {-1, -1}}) {
    const auto paved = [&](double d) {
      return roadquery::contains(surface, site_origin.x + sign.x * d, site_origin.y + sign.y * d);
    };
    EXPECT_TRUE(paved(corner - 0.03));
    EXPECT_FALSE(paved(corner + 0.05));
  }
}

TEST(JunctionSurfaces, CornersHaveTheKerbRadiusThatWasSeen) {
  RoadNetwork roads = crossing_on([](Vec2) { return 0.0; });
  for (RoadPath& path : roads.paths)
    for (RoadNode& node : path.nodes)
      if (node.osm_node == 2) node.kerb_radius_m = 9.0;
  const RoadMap map = build_network(roads).map;
  const JunctionSurface& surface = only_surface(map);
  const double corner = 3.5 + 9.0 * (1.0 - std::sqrt(0.5));
  for (const Vec2 sign : {Vec2{1, 1}, {1, -1}, {-1, 1}, {-1, -1}}) {
    const auto paved = [&](double d) {
      return roadquery::contains(surface, site_origin.x + sign.x * d, site_origin.y + sign.y * d);
    };
    EXPECT_TRUE(paved(corner - 0.03));
    EXPECT_FALSE(paved(corner + 0.05));
  }
}

TEST(JunctionSurfaces, CrownOfTheMainRoadStaysWhereASideRoadMeetsIt) {
  RoadNetwork roads = network_of(
      {make_path({{-60, 0}, {0, 0}, {60, 0}}, {1, 2, 3},
                 {.osm_id = 1, .highway = "primary", .width_m = 7.0, .height = [](Vec2) { return 10.0; }}),
       make_path({{0, 0}, {0, -60}}, {2, 4}, {.osm_id = 2, .height = [](Vec2 p) { return 10.0 - 0.04 * p.y; }})});
  for (RoadPath& path : roads.paths)
    for (RoadNode& node : path.nodes) node.crown = std::atan(0.025);
  const RoadMap map = build_network(roads).map;
  const JunctionSurface& surface = only_surface(map);
  expect_sound_surfaces(map, 0.08);  // a road that turns across the ridge and the foot of the side road is no plane
  for (double x = -6.0; x <= 6.0; x += 0.37)
    for (const double y : {-2.6, -1.3, 1.3, 2.6})
      EXPECT_NEAR(at(surface, {x, y}).z, 10.0 - 0.025 * std::abs(y), 0.008) << x << " " << y;
  EXPECT_NEAR(at(surface, {0.0, 0.0}).z, 10.0, 0.015) << "the ridge is rounded";
}

/// Largest change of slope over a step of 1 cm, as a curvature in 1/m.
double largest_curvature(const JunctionSurface& surface) {
  constexpr double step_m = 0.01;
  double largest = 0.0;
  inside(surface, [&](double x, double y) {
    const JunctionHeight h = roadquery::evaluate(surface, x, y), e = roadquery::evaluate(surface, x + step_m, y),
                         n = roadquery::evaluate(surface, x, y + step_m);
    largest =
        std::max({largest, std::abs(e.dz_dx - h.dz_dx), std::abs(n.dz_dy - h.dz_dy), std::abs(e.dz_dy - h.dz_dy)});
  });
  return largest / step_m;
}

TEST(JunctionSurfaces, ArmsOfDifferentGradientMeetWithoutAKink) {
  // 6 % down to the junction and level behind it, on both ways.
  const RoadMap map = build_network(crossing_on([](Vec2 p) { return 5.0 + 0.06 * std::max({-p.x, -p.y, 0.0}); })).map;
  expect_sound_surfaces(map, 0.12);  // turns lie on a slope of 15 % that twists over half their width
  // A kink of 6 % would show as 0.06 over 1 cm: 6 1/m.
  EXPECT_LT(largest_curvature(only_surface(map)), 2.0);
}

TEST(JunctionSurfaces, TurningRoadsThatDisagreeGetOneSurface) {
  // A saddle: arms rise along x and fall along y by 2 to 4 %, without banking, so that every turn has a height of its
  // own.
  BuildNetworkOptions without;
  without.junction_surfaces = false;
  const auto saddle = [](Vec2 p) { return 20.0 + 0.0015 * (p.x * p.x - p.y * p.y); };
  const RoadNetwork roads = crossing_on(saddle, 0.0, 14.0);
  RoadMap map = build_network(roads, without).map;
  EXPECT_FALSE(map.junctions.front().surface);
  const network::JunctionSurfaceSummary summary = network::add_junction_surfaces(map, {});
  EXPECT_EQ(summary.junctions, 1);
  EXPECT_GT(summary.max_disagreement_m, 0.05);
  EXPECT_LE(summary.max_road_off_after_m, summary.max_road_off_before_m);
  const JunctionSurface& surface = only_surface(map);
  expect_sound(map);
  expect_sound_surfaces(map, summary.max_road_off_after_m + 1e-3);
  double steepest = 0.0;
  inside(surface, [&](double x, double y) {
    const JunctionHeight h = roadquery::evaluate(surface, x, y);
    steepest = std::max(steepest, std::hypot(h.dz_dx, h.dz_dy));
  });
  // Beside a corner the arms are 0.3 m apart in height and 5 m in plan, level across at both.
  EXPECT_LT(steepest, 0.3);
}

TEST(JunctionSurfaces, DoNotDependOnPlaceOrOrder) {
  const auto height = [](Vec2 p) { return 30.0 + 0.02 * p.x - 0.03 * p.y + 0.001 * p.x * p.y; };
  RoadNetwork roads = crossing_on(height);
  const JunctionSurface first = only_surface(build_network(roads).map);
  std::swap(roads.paths[0], roads.paths[1]);
  const JunctionSurface turned = only_surface(build_network(roads).map);
  const Vec2 shift{1234.25, -777.75};
  for (RoadPath& path : roads.paths)
    for (RoadNode& node : path.nodes) node.p = node.p + shift;
  const JunctionSurface moved = only_surface(build_network(roads).map);
  inside(first, [&](double x, double y) {
    const double z = roadquery::evaluate(first, x, y).z;
    EXPECT_NEAR(roadquery::evaluate(turned, x, y).z, z, 1e-3);
    EXPECT_NEAR(roadquery::evaluate(moved, x + shift.x, y + shift.y).z, z, 1e-3);
  });
}

TEST(JunctionSurfaces, OddJunctionsSurvive) {
  using roadquery::test::make_road;
  // One arm, and a connecting road of no length beside one that turns.
  RoadMap map;
  map.roads = {make_road(1, {.x = -20.0, .length = 20.0}, 3.0), make_road(2, {.length = 0.0}, 3.0),
               make_road(3, {.length = 6.0, .shape = roadquery::Arc{0.2}}, 3.0)};
  map.roads[0].successor = {roadquery::LinkKind::junction, 1};
  map.roads[1].junction = map.roads[2].junction = 1;
  map.junctions = {{.id = 1}, {.id = 2, .name = "nothing in it"}};
  const network::JunctionSurfaceSummary summary = network::add_junction_surfaces(map, {});
  EXPECT_EQ(summary.junctions, 1);
  const std::optional<JunctionSurface>& surface = map.junctions[0].surface;
  ASSERT_TRUE(surface.has_value());
  EXPECT_FALSE(map.junctions[1].surface);
  EXPECT_NEAR(roadquery::evaluate(*surface, 2.0, 0.0).z, 3.0, 1e-4);
}

TEST(JunctionSurfaces, LittleGapsThatArmsCloseArePaved) {
  // Two arms of 4 m leave side by side, 0.6 m apart, and touch 6 m further out: too little for a verge.
  using roadquery::test::make_road;
  const roadquery::Road across = make_road(1, {.x = -3.0, .y = -6.0, .hdg = 0.5 * M_PI, .length = 12.0}, 0.0, 3.0);
  const roadquery::Road upper = make_road(2, {.x = 0.0, .y = 2.3, .length = 30.0}, 0.0, 2.0);
  const roadquery::Road lower = make_road(3, {.x = 0.0, .y = -2.3, .hdg = 0.1, .length = 30.0}, 0.0, 2.0);
  const auto is_paved = [&](const MultiPolygon& area) { return contains(area, {1.0, 0.1}); };
  EXPECT_TRUE(is_paved(network::junction_area({{&across}, {&upper, &lower}, {false, false}, {}}, 5.0, {})));
  // What does not close stays open.
  const roadquery::Road parallel = make_road(4, {.x = 0.0, .y = -2.3, .length = 30.0}, 0.0, 2.0);
  EXPECT_FALSE(is_paved(network::junction_area({{&across}, {&upper, &parallel}, {false, false}, {}}, 5.0, {})));
}

TEST(JunctionSurfaces, CarsHaveRoomRoundTheEndOfAGoreThatTheyTurnRound) {
  // A track forks by 32 degrees: both prongs are 4.4 m wide and lead away from the stem.
  const double angle = 32.0 * M_PI / 180.0, half_m = 2.2, radius_m = 4.0;
  const Vec2 way{std::cos(angle), std::sin(angle)}, middle{std::cos(0.5 * angle), std::sin(0.5 * angle)};
  const auto paved = [&](Oneway oneway, double away_m) {
    const PathOptions o{.highway = "track", .width_m = 2.0 * half_m};
    PathOptions prong = o;
    prong.osm_id = 2, prong.oneway = oneway;
    const RoadMap map = build_network(network_of({make_path({{-80, 0}, {0, 0}, {80, 0}}, {1, 9, 2}, o),
                                                  make_path({{0, 0}, way * 80.0}, {9, 3}, prong)}))
                            .map;
    const Vec2 p = site_origin + middle * away_m;
    return roadquery::contains(only_surface(map), p.x, p.y);
  };
  // The kerb touches both edges with an arc of 4 m.
  const double kerb_m = (half_m + radius_m) / std::sin(0.5 * angle) - radius_m;
  EXPECT_TRUE(paved(Oneway::no, kerb_m - 0.2));
  EXPECT_FALSE(paved(Oneway::no, kerb_m + 0.2));
}

TEST(JunctionSurfaces, GoresThatNobodyTurnsRoundStay) {
  // A ramp leaves a one-way road: between them lies a verge from where they have parted on.
  const PathOptions main{.highway = "track", .width_m = 4.0, .oneway = Oneway::forward};
  PathOptions ramp = main;
  ramp.osm_id = 2;
  const double angle = 32.0 * M_PI / 180.0;
  const RoadMap map =
      build_network(network_of({make_path({{-80, 0}, {0, 0}, {80, 0}}, {1, 9, 2}, main),
                                make_path({{0, 0}, Vec2{std::cos(angle), std::sin(angle)} * 80.0}, {9, 3}, ramp)}))
          .map;
  const Vec2 p = site_origin + Vec2{std::cos(0.5 * angle), std::sin(0.5 * angle)} * 15.0;
  EXPECT_FALSE(roadquery::contains(only_surface(map), p.x, p.y));
}

TEST(JunctionSurfaces, IslandOfARingStaysOutside) {
  const Ring outer = circle_points({0, 0}, 20.0, 0.0, 2.0 * M_PI), inner = circle_points({0, 0}, 9.0, 0.0, -2.0 * M_PI);
  const Ring ring = network::woven_ring({{outer, {inner}}, {{{30, 0}, {40, 0}, {40, 5}, {30, 5}}, {}}});
  JunctionSurface surface;
  for (const Vec2 p : ring) surface.boundary.push_back({p.x, p.y});
  for (double angle = 0.05; angle < 6.28; angle += 0.1) {
    EXPECT_FALSE(roadquery::contains(surface, 8.0 * std::cos(angle), 8.0 * std::sin(angle)));
    EXPECT_TRUE(roadquery::contains(surface, 14.0 * std::cos(angle), 14.0 * std::sin(angle)));
    EXPECT_FALSE(roadquery::contains(surface, 22.0 * std::cos(angle), 22.0 * std::sin(angle)));
  }
  EXPECT_TRUE(roadquery::contains(surface, 35.0, 2.0));
  EXPECT_NEAR(signed_area_m2(ring), signed_area_m2(outer) + signed_area_m2(inner) + 50.0, 1e-6);
}

TEST(JunctionSurfaces, AreInTheFileAndComeBack) {
  const Scratch scratch;
  const RoadMap map = build_network(crossing_on([](Vec2 p) { return 40.0 + 0.001 * p.x * p.y; })).map;
  io::write_opendrive(scratch / "a.xodr", map);
  const RoadMap read = roadquery::read_opendrive((scratch / "a.xodr").string());
  const JunctionSurface &a = only_surface(map), &b = only_surface(read);
  EXPECT_EQ(a.boundary.size(), b.boundary.size());
  EXPECT_EQ(a.arms.size(), b.arms.size());
  inside(a, [&](double x, double y) {
    EXPECT_NEAR(roadquery::evaluate(a, x, y).z, roadquery::evaluate(b, x, y).z, 1e-6);
    EXPECT_TRUE(roadquery::contains(b, x, y));
  });
  io::write_opendrive(scratch / "b.xodr", read);
  EXPECT_EQ(bytes_of(scratch / "a.xodr"), bytes_of(scratch / "b.xodr"));
}

TEST(JunctionSurfaces, NodesThatNothingNeedsCostNearlyNothing) {
  JunctionSurface surface{.boundary = {{0, 0}, {1, 0}, {1, 1}}, .spacing_m = 1.0, .columns = 20, .rows = 20};
  for (int i = 0; i < 400; ++i) surface.z.push_back(5.0 + (i == 217 ? 0.03 : 0.0));
  const std::string text = roadquery::heights_text(surface, 0.0, 0.0);
  EXPECT_NE(text.find("A+F"), std::string::npos) << text;  // 0, and 95 zeros more
  EXPECT_LT(text.size(), 100u);
  JunctionSurface read;
  roadquery::read_heights(text, read);
  ASSERT_EQ(read.z.size(), surface.z.size());
  for (std::size_t i = 0; i < read.z.size(); ++i) EXPECT_NEAR(read.z[i], surface.z[i], 1e-9) << i;
  const auto refused = [&](const std::string& wrong) {
    JunctionSurface any;
    EXPECT_THROW(roadquery::read_heights(wrong, any), std::runtime_error) << wrong;
  };
  EXPECT_NO_THROW(roadquery::read_heights("0 0 1 20 20 A+FA+FA+FA+FAe", read));
  refused("0 0 1 20 20 AgGAgGAgGAgGAgG");  // 97 zeros, no writer makes such runs: a bound on what a text can ask for
  refused("0 0 1 20 20 A+FA+FA+F");        // ends too early
  refused("0 0 1 20 20 A+FA+FA+FA+FAg");   // in the middle of a number
  refused("0 0 1 20 20 A+FA+FA+FA+FAeC");  // more than nodes
  refused("0 0 1 20 20 AD");               // fewer zeros than none
  refused("0 0 1 20 20 0*99");             // a character that is no digit
  refused("0 0 1 20 20 gggggggggggggggggB");
  refused("0 0 1 1000 1000 A+F");
}

TEST(JunctionSurfaces, TextIsTheBase64VlqOfSourceMaps) {
  JunctionSurface surface{.boundary = {{1.0, 2.0}, {1.001, 1.999}, {1.124, 123458.788}, {1.124, 2.0}}};
  const std::string text = roadquery::boundary_text(surface, 0.0, 0.0);
  EXPECT_EQ(text, "1.000 2.000 CD2HqxmvrHApxmvrH");  // 1 -1, 123 123456789, 0 and back
  JunctionSurface read;
  roadquery::read_boundary(text, read);
  ASSERT_EQ(read.boundary.size(), surface.boundary.size());
  for (std::size_t i = 0; i < read.boundary.size(); ++i)
    for (const int axis : {0, 1}) EXPECT_NEAR(read.boundary[i][axis], surface.boundary[i][axis], 1e-9) << i;
}

/// Side roads that leave a main road on both sides, `gap` apart, towards each other, on ground that is no plane.
RoadNetwork staggered(double gap, const std::function<double(Vec2)>& height, Vec2 side = {12, -50}) {
  return network_of({make_path({{-90, 0}, {0, 0}, {gap, 0}, {90 + gap, 0}}, {1, 2, 3, 4},
                               {.osm_id = 1, .highway = "secondary", .width_m = 7.0, .height = height}),
                     make_path({{0, 0}, side}, {2, 5}, {.osm_id = 2, .height = height}),
                     make_path({{gap, 0}, Vec2{gap, 0} - side}, {3, 6}, {.osm_id = 3, .height = height})});
}

TEST(JunctionSurfaces, ThoseThatOverlapAreOneSurface) {
  // Too far apart to be one junction, and yet a metre is all that is left between them.
  const auto height = [](Vec2 p) { return 30.0 + 0.05 * p.x + 0.001 * p.x * p.y - 0.06 * p.y; };
  int common = 0;
  for (const double gap : {41.0, 44.0, 47.0, 50.0}) {
    const RoadMap map = build_network(staggered(gap, height, {90, -19})).map;
    ASSERT_EQ(map.junctions.size(), 2u);
    const std::optional<JunctionSurface>& first = map.junctions[0].surface;
    const std::optional<JunctionSurface>& second = map.junctions[1].surface;
    ASSERT_TRUE(first.has_value());
    ASSERT_TRUE(second.has_value());
    const JunctionSurface &a = *first, &b = *second;
    for (double x = -40.0; x < 90.0; x += 0.21)
      for (double y = -20.0; y < 20.0; y += 0.23) {
        const double px = x + site_origin.x, py = y + site_origin.y;
        if (!roadquery::contains(a, px, py) || !roadquery::contains(b, px, py)) continue;
        EXPECT_NEAR(roadquery::evaluate(a, px, py).z, roadquery::evaluate(b, px, py).z, 2e-3)
            << gap << ": " << x << " " << y;
        ++common;
      }
    for (const roadquery::Road& road : map.roads)  // short ones lie under both
      if (road.junction < 0 && road.length < 4.0)
        for (double s = 0.0; s <= road.length; s += 0.1) {
          const roadquery::SurfacePoint p = roadquery::surface_point(road, s, 1.0);
          EXPECT_TRUE(roadquery::contains(a, p.x, p.y) && roadquery::contains(b, p.x, p.y)) << s;
          EXPECT_NEAR(roadquery::evaluate(a, p.x, p.y).z, p.z, 5e-3);
        }
  }
  EXPECT_GT(common, 50) << "there was something to compare";
}

TEST(JunctionSurfaces, JoinedJunctionsStaySmall) {
  // A bus terminal: 16 bays, 8 m apart.
  std::vector<RoadPath> paths;
  std::vector<Vec2> corners{{-60, 0}};
  std::vector<std::int64_t> ids{1};
  for (int i = 0; i < 16; ++i) {
    const Vec2 p{8.0 * i, 0.0};
    corners.push_back(p), ids.push_back(10 + i);
    paths.push_back(make_path({p, p + Vec2{0.0, 40.0}}, {10 + i, 100 + i}, {.osm_id = 100 + i, .highway = "service"}));
  }
  corners.push_back({200, 0}), ids.push_back(2);
  paths.push_back(make_path(corners, ids, {.osm_id = 1}));
  const RoadMap map = build_network(network_of(std::move(paths))).map;
  expect_sound(map);
  EXPECT_GE(map.junctions.size(), 3u);
  for (const roadquery::Junction& junction : map.junctions) {
    ASSERT_TRUE(junction.surface.has_value());
    Ring ring;
    for (const auto& [x, y] : junction.surface->boundary) ring.push_back({x, y});
    EXPECT_LT(bounds_of(ring).width(), 40.0 + 30.0) << junction.id;  // 40 m between vertices, and the cuts
  }
}

TEST(JunctionSurfaces, SideRoadsTurnIntoThePlaneOfTheMainRoad) {
  // The main road banks by 5 % down to the side road, which comes down on it with 6 % and level across, as far as its
  // axis. Behind the edge, 3.5 m off, it would lie 0.4 m above the main road's plane.
  const RoadMap map =
      build_network(network_of({make_path({{-60, 0}, {0, 0}, {60, 0}}, {1, 2, 3},
                                          {.osm_id = 1,
                                           .highway = "secondary",
                                           .width_m = 7.0,
                                           .height = [](Vec2 p) { return 10.0 + 0.04 * p.x; },
                                           .banking = [](double) { return std::atan(0.05); }}),
                                make_path({{0, 0}, {0, -80}}, {2, 4},
                                          {.osm_id = 2, .height = [](Vec2 p) { return 10.0 - 0.06 * p.y; }})}))
          .map;
  const roadquery::Road* side = nullptr;
  for (const roadquery::Road& road : map.roads)
    if (road.junction < 0 && road.osm_id == "2") side = &road;
  ASSERT_NE(side, nullptr);
  const roadquery::PlanPoint end = roadquery::reference_point(*side, 0.0);
  const double y = end.y - site_origin.y, plane = 10.0 + 0.05 * y;
  EXPECT_LT(y, -3.5);
  EXPECT_NEAR(roadquery::elevation(*side, 0.0), plane + 0.5 * 0.02 * (-y - 3.5), 0.02);
  EXPECT_NEAR(roadquery::gradient(*side, 0.0), -0.05 + 0.02, 5e-3) << "2 % steeper than the plane, which falls by 5 %";
  EXPECT_NEAR(std::abs(roadquery::superelevation(*side, 0.0)), 0.04 - 0.01, 5e-3)
      << "the gradient of the main road, less 1 %";
  for (double s = 0.0; s < 20.0; s += 0.5)
    EXPECT_LT(std::abs(roadquery::derivative(side->superelevation, s)), 0.005) << "RAS-L: 0.5 %/m at 50 km/h";
  EXPECT_NEAR(roadquery::elevation(*side, 25.0), 10.0 + 0.06 * (25.0 - y), 0.03) << "as it was behind 20 m";
}

/// Gradient and slope to the left of a road's end at the junction, seen into it.
Vec2 slopes_into(const RoadMap& map, const std::string& osm_id, bool south_only) {
  for (const roadquery::Road& road : map.roads) {
    if (road.junction >= 0 || road.osm_id != osm_id) continue;
    for (const bool at_end : {false, true}) {
      if ((at_end ? road.successor : road.predecessor).kind != roadquery::LinkKind::junction) continue;
      const double s = at_end ? road.length : 0.0, sign = at_end ? 1.0 : -1.0;
      if (south_only && roadquery::reference_point(road, s).y > site_origin.y - 1.0) continue;
      return {sign * roadquery::gradient(road, s), sign * std::tan(roadquery::superelevation(road, s))};
    }
  }
  ADD_FAILURE() << "no end of way " << osm_id;
  return {};
}

TEST(JunctionSurfaces, LoopsTurnIntoThePlaneOfTheirOwnBeginning) {
  // The road climbs by 8 % through the node at which it ends, level, from the south.
  const auto height = [](Vec2 p) { return p.y < -0.5 ? 10.0 : 10.0 + 0.08 * p.x; };
  const RoadMap map = build_network(network_of({make_path({{-60, 0}, {0, 0}, {60, 0}, {60, -60}, {0, -60}, {0, 0}},
                                                          {1, 2, 0, 0, 0, 2}, {.osm_id = 1, .height = height})}))
                          .map;
  ASSERT_EQ(map.junctions.size(), 1u);
  EXPECT_NEAR(slopes_into(map, "1", true).y, -0.08 + 0.01, 0.01) << "the gradient of the road, less 1 %";
}

TEST(JunctionSurfaces, WhereNoRoadGoesThroughTheLargestOneIsTheMainRoad) {
  const auto level = [](Vec2) { return 10.0; };
  const RoadMap map =
      build_network(
          network_of(
              {make_path({{-80, 0}, {0, 0}}, {1, 2},
                         {.osm_id = 1, .highway = "primary", .height = [](Vec2 p) { return 10.0 + 0.06 * p.x; }}),
               make_path({{40, 69.3}, {0, 0}}, {3, 2}, {.osm_id = 2, .height = level}),
               make_path({{40, -69.3}, {0, 0}}, {4, 2}, {.osm_id = 3, .height = level})}))
          .map;
  ASSERT_EQ(map.junctions.size(), 1u);
  // Seen from them into the junction the plane falls by 3 % and by 5.2 % to one side.
  const Vec2 left = slopes_into(map, "2", false), right = slopes_into(map, "3", false);
  EXPECT_NEAR(left.x, -0.03 + 0.02, 5e-3);
  EXPECT_NEAR(left.y, 0.052 - 0.01, 5e-3);
  EXPECT_NEAR(right.x, -0.03 + 0.02, 5e-3);
  EXPECT_NEAR(right.y, -0.052 + 0.01, 5e-3);
  EXPECT_NEAR(slopes_into(map, "1", false).x, 0.06, 5e-3) << "the main road stays";
}

/// The one road of a way, begins at its junction.
const roadquery::Road& road_of_way(const RoadMap& map, const std::string& osm_id) {
  for (const roadquery::Road& road : map.roads)
    if (road.junction < 0 && road.osm_id == osm_id) return road;
  ADD_FAILURE() << "no road of way " << osm_id;
  return map.roads.front();
}

TEST(JunctionSurfaces, RoadsThatLeaveTheMainRoadThroughAnotherJunctionTurnIntoItsPlane) {
  // The side road meets a third one 3 m from the main road's axis, where it goes straight on itself: one junction.
  const double width_m = 3.0;
  const RoadMap map =
      build_network(
          network_of(
              {make_path({{-60, 0}, {0, 0}, {60, 0}}, {1, 2, 3},
                         {.osm_id = 1,
                          .highway = "secondary",
                          .width_m = 9.0,
                          .height = [](Vec2) { return 10.0; },
                          .banking = [](double) { return std::atan(0.05); }}),
               make_path({{0, 0}, {0, -3}, {0, -80}}, {2, 5, 4},
                         {.osm_id = 2, .width_m = width_m, .height = [](Vec2 p) { return 10.0 - 0.06 * p.y; }}),
               make_path({{0, -3}, {8, -3}, {30, -30}}, {5, 0, 6},
                         {.osm_id = 3, .width_m = width_m, .height = [](Vec2 p) { return 10.0 - 0.06 * p.y; }})}))
          .map;
  const roadquery::Road& side = road_of_way(map, "2");
  const double y = roadquery::reference_point(side, 0.0).y - site_origin.y;
  EXPECT_LT(y, -5.0);
  // The gradient may break by 2 %, half of it between the edge and the cut.
  EXPECT_NEAR(roadquery::elevation(side, 0.0), 10.0 + 0.05 * y + 0.01 * (-4.5 - y), 0.005) << y;
}

TEST(JunctionSurfaces, ForksTurnIntoTheMainRoadThatTheyLieBeside) {
  // A narrow fork leaves the side road 3.5 m from the main road, beside whose edge it runs. The side road is banked:
  // the fork carried on in its plane would lie a quarter of a metre off.
  const RoadMap map =
      build_network(
          network_of(
              {make_path({{-60, 0}, {0, 0}, {60, 0}}, {1, 2, 3},
                         {.osm_id = 1, .highway = "secondary", .width_m = 4.0, .height = [](Vec2) { return 10.0; }}),
               make_path({{0, 0}, {0, -3.5}, {0, -80}}, {2, 5, 4},
                         {.osm_id = 2,
                          .width_m = 4.0,
                          .height = [](Vec2) { return 10.0; },
                          .banking = [](double) { return std::atan(0.06); }}),
               make_path({{0, -3.5}, {60, -11.5}}, {5, 6},
                         {.osm_id = 3, .highway = "service", .width_m = 4.0, .height = [](Vec2) { return 10.0; }})}))
          .map;
  const roadquery::Road& fork = road_of_way(map, "3");
  EXPECT_GT(roadquery::reference_point(fork, 0.0).x - site_origin.x, 3.0);
  EXPECT_NEAR(roadquery::elevation(fork, 0.0), 10.0, 0.04);
}

TEST(JunctionSurfaces, RoadsThatCrossTurnIntoThePlaneOfTheMainRoadOnBothSides) {
  // A level main road with a crown of 2.5 % and 7 m: its edges lie 8.8 cm below the axis, where the level side road
  // crosses.
  RoadNetwork roads = crossing_on([](Vec2) { return 10.0; });
  for (RoadPath& path : roads.paths)
    for (RoadNode& node : path.nodes) node.crown = std::atan(0.025);
  const RoadMap map = build_network(roads).map;
  int sides = 0;
  for (const roadquery::Road& road : map.roads) {
    if (road.junction >= 0 || road.osm_id != "2") continue;
    const bool at_end = road.successor.kind == roadquery::LinkKind::junction;
    const double s = at_end ? road.length : 0.0;
    const double y = roadquery::reference_point(road, s).y - site_origin.y;
    // The gradient may break by 2 %, half of it within the corner.
    EXPECT_NEAR(roadquery::elevation(road, s), 10.0 - 0.025 * std::abs(y) + 0.01 * (std::abs(y) - 3.5), 0.005) << y;
    EXPECT_NEAR(roadquery::shape(road, s, 1.0).h, 0.0, 1e-4) << "the crown has faded out at the crossing";
    EXPECT_NEAR(roadquery::shape(road, at_end ? 0.0 : road.length, 1.0).h, -0.025, 1e-3) << "and is there before";
    ++sides;
  }
  EXPECT_EQ(sides, 2);
  const JunctionSurface& surface = only_surface(map);
  for (const double y : {3.0, 4.0, 5.0, -3.0, -4.0, -5.0})
    EXPECT_NEAR(at(surface, {0.0, y}).z, 10.0 - 0.025 * std::abs(y), 0.02) << y;
}

TEST(JunctionSurfaces, RoadsOfHalfAMetreBetweenTwoJunctionsMakeNoStep) {
  // A dual carriageway whose halves, 7 m apart, are crossed: the way between the two junctions changes its id half way.
  const auto height = [](Vec2 p) { return 30.0 + 0.05 * p.x + 0.002 * p.x * p.y - 0.06 * p.y; };
  for (const double gap : {9.0, 10.0, 11.0, 12.0, 13.0}) {
    RoadNetwork roads = staggered(gap, height);
    RoadPath& main = roads.paths.front();
    const auto middle = std::find_if(main.nodes.begin(), main.nodes.end(), [&](const RoadNode& node) {
      return std::abs(node.p.x - site_origin.x - 0.5 * gap) < 1.01;
    });
    ASSERT_NE(middle, main.nodes.end());
    middle->osm_node = 77;
    RoadPath rest = main;
    rest.osm_id = 9;
    rest.nodes.erase(rest.nodes.begin(), rest.nodes.begin() + (middle - main.nodes.begin()));
    for (RoadNode& node : rest.nodes) node.banking = 0.06;  // of its own
    main.nodes.erase(middle + 1, main.nodes.end());
    roads.paths.push_back(rest);
    const RoadMap map = build_network(roads).map;
    const roadquery::RoadQuery query(map);
    for (const double y : {-2.0, -0.5, 0.5, 2.0}) {
      double last = NAN;
      roadquery::Cursor cursor;
      for (double x = -10.0; x < 10.0 + gap; x += 0.02) {
        const auto found = query.find(site_origin.x + x, site_origin.y + y, height({x, y}), cursor);
        ASSERT_TRUE(found) << gap << ": " << x << " " << y;
        if (!std::isnan(last)) {
          EXPECT_NEAR(found->z, last, 0.01) << gap << ": " << x << " " << y;
        }
        last = found->z;
      }
    }
  }
}

// ---- the field alone

/// Largest twist of a car of 2.7 m that goes along a line in steps of 10 cm, as docs/evaluate.md has it.
double largest_twist(const RoadMap& map, Vec2 from, Vec2 to, double z) {
  const roadquery::RoadQuery query(map);
  const Vec2 along = (to - from) * (1.0 / distance(from, to)), left = left_normal(along);
  const auto roll = [&](double way_m) {
    const auto z_at = [&](double left_m) {
      const Vec2 p = site_origin + from + along * way_m + left * left_m;
      roadquery::Cursor cursor;
      const auto hit = query.find(p.x, p.y, z, cursor);
      EXPECT_TRUE(hit) << way_m << " " << left_m;
      return hit ? hit->z : 0.0;
    };
    return (z_at(0.75) - z_at(-0.75)) / 1.5;
  };
  double largest = 0.0;
  for (double way_m = 0.0; way_m + 2.7 <= distance(from, to); way_m += 0.1)
    largest = std::max(largest, std::abs(roll(way_m + 2.7) - roll(way_m)));
  return largest;
}

TEST(JunctionSurfaces, ShortSideRoadsBetweenTwoJunctionsGiveWayToTheMainRoad) {
  // The main road climbs by 8 %, the road behind it is level; 8 m of the side road stay between their junctions.
  const auto level = [](Vec2) { return 10.0; };
  RoadNetwork roads = network_of(
      {make_path({{-60, 0}, {0, 0}, {60, 0}}, {1, 2, 3},
                 {.osm_id = 1, .highway = "primary", .width_m = 7, .height = [](Vec2 p) { return 10.0 + 0.08 * p.x; }}),
       make_path({{0, 0}, {0, 22.5}}, {2, 4}, {.osm_id = 2, .height = level}),
       make_path({{-60, 22.5}, {0, 22.5}, {60, 22.5}}, {5, 4, 6}, {.osm_id = 3, .height = level})});
  const RoadMap map = build_network(roads).map;
  ASSERT_EQ(map.junctions.size(), 2u);
  EXPECT_LT(largest_twist(map, {-1.5, -1.0}, {-1.5, 23.5}, 10.0), 0.05) << "of 8 % over 7 m";
}

TEST(JunctionSurfaces, CarsTurnAcrossARidgeWithoutTwist) {
  // Both roads have crowns of 2.5 %: turning across one of them a car stands on both its sides.
  const auto twist = [](const char* highway) {
    RoadNetwork roads = network_of(
        {make_path({{-60, 0}, {0, 0}, {60, 0}}, {1, 2, 3}, {.osm_id = 1, .highway = highway, .width_m = 6.0}),
         make_path({{0, 0}, {0, -60}}, {2, 4}, {.osm_id = 2, .highway = highway, .width_m = 6.0})});
    for (RoadPath& path : roads.paths)
      for (RoadNode& node : path.nodes) node.z_m = 10.0, node.crown = std::atan(0.025);
    return largest_twist(build_network(roads).map, {-1.5, -4.5}, {4.5, 1.5}, 10.0);
  };
  EXPECT_LT(twist("residential"), 0.034);
  EXPECT_LT(twist("service"), 0.028) << "driven at walking pace: the ridge is rounded further";
}

TEST(JunctionField, IsExactForPlanesAndKeepsFixedNodes) {
  network::FieldGrid grid{{3.0, -2.0}, 0.5, 13, 9};
  std::vector<network::NodeTarget> targets(grid.size());
  const auto plane = [](Vec2 p) { return 100.0 + 0.1 * p.x - 0.07 * p.y; };
  for (const std::size_t i : {0u, 12u, 40u, 100u}) targets[i] = {plane(grid.node(i)), 0.0};
  targets[60] = {plane(grid.node(60)), 2.0};
  const std::vector<double> z = network::bend_least(grid, targets);
  for (std::size_t i = 0; i < z.size(); ++i) EXPECT_NEAR(z[i], plane(grid.node(i)), 1e-9);
  targets[60] = {plane(grid.node(60)) + 0.3, 0.0};
  EXPECT_NEAR(network::bend_least(grid, targets)[60], plane(grid.node(60)) + 0.3, 1e-12);
}

TEST(JunctionField, WithoutEnoughTargetsIsAPlane) {
  const network::FieldGrid grid{{0.0, 0.0}, 1.0, 5, 5};
  std::vector<network::NodeTarget> targets(grid.size());
  for (const double z : network::bend_least(grid, targets)) EXPECT_EQ(z, 0.0);
  targets[7] = {4.0, 1.0};
  for (const double z : network::bend_least(grid, targets)) EXPECT_NEAR(z, 4.0, 1e-6);
}

TEST(JunctionField, BendsAsAPlateDoes) {
  // A strip held at both ends with slopes of 0 and a step of 1 m between: the beam's cubic z = 3 u^2 - 2 u^3.
  const int columns = 41, rows = 3;
  const network::FieldGrid grid{{0.0, 0.0}, 0.25, columns, rows};
  std::vector<network::NodeTarget> targets(grid.size());
  for (int r = 0; r < rows; ++r)
    for (const int c : {0, 1, columns - 2, columns - 1})
      targets[static_cast<std::size_t>(r * columns + c)] = {c > 1 ? 1.0 : 0.0, 0.0};
  const std::vector<double> z = network::bend_least(grid, targets);
  for (int c = 0; c < columns; ++c) {
    const double u = std::clamp((c - 0.5) / (columns - 2.0), 0.0, 1.0);
    EXPECT_NEAR(z[static_cast<std::size_t>(columns + c)], u * u * (3.0 - 2.0 * u), 0.005) << c;
  }
}

}  // namespace
}  // namespace orthodrive
