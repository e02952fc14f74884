// SPDX-License-Identifier: Apache-2.0
// Crowns of nodes as lateral shapes of roads.

#include "network_support.hpp"
#include "orthodrive/network/curves/crown_shape.hpp"
#include "orthodrive/network/curves/fit_profile.hpp"
#include "roadquery/make_road.hpp"

namespace orthodrive {
namespace {

using namespace orthodrive::network_test;
using roadquery::Cubic;

double fall_at(const roadquery::Road& road, double s, double t) {
  return -roadquery::shape(road, s, t).h / std::abs(t);
}

TEST(Crown, constant_fall_needs_one_knot_and_none_needs_none) {
  const std::vector<Cubic> constant{{.s = 0.0, .a = 0.025}, {.s = 40.0, .a = 0.025}};
  EXPECT_EQ(network::crown_shape(constant, 90.0).size(), 2u);
  EXPECT_TRUE(network::crown_shape({}, 90.0).empty());
  EXPECT_TRUE(network::crown_shape(std::vector<Cubic>{{.s = 0.0, .a = 0.0}}, 90.0).empty());
}

TEST(Crown, changing_fall_is_followed_and_stays_smooth) {
  // Constant, down to nothing within 30 m, nothing.
  roadquery::Road road;
  road.length = 120.0;
  const std::vector<Cubic> fall{
      {.s = 0.0, .a = 0.025}, network::hermite(40.0, 70.0, 0.025, 0.0, 0.0, 0.0), {.s = 70.0, .a = 0.0}};
  road.shape = network::crown_shape(fall, road.length);
  EXPECT_LT(road.shape.size(), 120u);
  double before = 0.0;
  for (double s = 0.0; s <= road.length; s += 0.05) {
    EXPECT_NEAR(fall_at(road, s, 3.0), roadquery::evaluate(fall, s), 1.01e-4) << s;
    EXPECT_NEAR(fall_at(road, s, -3.0), fall_at(road, s, 3.0), 1e-15);
    const double gradient = roadquery::shape(road, s, 4.0).dh_ds;
    EXPECT_LE(std::abs(gradient - before), 1.01e-3) << "a kink at " << s;
    before = gradient;
  }
}

TEST(Crown, takes_few_entries_within_its_tolerances) {
  // Waves of 1 mm at the edge, then from 2.5 % to nothing: 4 mm leave one entry at each end of the waves.
  roadquery::Road road;
  road.length = 160.0;
  std::vector<Cubic> fall;
  fall.reserve(10);
  for (int k = 0; k < 10; ++k)
    fall.push_back(
        network::hermite(10.0 * k, 10.0 * k + 10.0, 0.025 + 1.25e-4 * (k % 2), 0.025 + 1.25e-4 * ((k + 1) % 2), 0, 0));
  fall.push_back(network::hermite(100.0, 130.0, 0.025, 0.0, 0.0, 0.0));
  fall.push_back({.s = 130.0});
  const network::CrownShapeOptions coarse{.fall_tolerance = 1e-3};
  road.shape = network::crown_shape(fall, road.length, coarse);
  EXPECT_LE(road.shape.size(), 2u * 14u);
  EXPECT_LT(road.shape.size(), network::crown_shape(fall, road.length).size());
  double before = 0.0;
  for (double s = 0.0; s <= road.length; s += 0.05) {
    EXPECT_NEAR(fall_at(road, s, 3.0), roadquery::evaluate(fall, s), 1e-3) << s;
    const double gradient = roadquery::shape(road, s, 4.0).dh_ds;
    EXPECT_LE(std::abs(gradient - before), 1.01e-3) << "a kink at " << s;
    before = gradient;
  }
  EXPECT_NEAR(fall_at(road, 0.0, 3.0), 0.025, 1e-12) << "the ends are exact: another road follows";
  EXPECT_NEAR(fall_at(road, road.length, 3.0), 0.0, 1e-12);
  EXPECT_EQ(road.shape.at(2).s, 100.0) << "the waves need none";
}

TEST(Crown, takes_as_few_entries_as_the_kinks_allow) {
  // A fall of a s^2: chords of h metres meet with a kink of 2 a h and leave its slope at the ends by half of that.
  const double a = 1.5e-5;
  for (const double length : {7.0, 15.0, 23.0, 38.0}) {
    const std::vector<Cubic> fall{{.s = 0.0, .c = a}};
    const network::CrownShapeOptions options{.fall_tolerance = 1.0};
    const double longest_m = options.max_rate_jump / (2.0 * a);  // 8.3 m
    const auto chords = static_cast<std::size_t>(std::ceil(length / longest_m));
    EXPECT_EQ(network::crown_shape(fall, length, options).size(), 2 * (chords + 1)) << length;
  }
}

TEST(Crown, kinks_are_the_smaller_the_faster_the_road) {
  // What a wheel 4 m off gets from a kink: 0.04 m/s whatever the speed limit, from 0.1 % at 40 m/s.
  const std::vector<Cubic> fall{network::hermite(0.0, 40.0, 0.025, 0.0, 0.0, 0.0)};
  roadquery::Road road = roadquery::test::make_road(1, {0.0, 0.0, 0.0, 0.0, 40.0, roadquery::Line{}});
  std::size_t fewer = 1000;
  for (const double speed : {0.0, 36.0, 14.0, 8.0}) {
    road.speed_limit_mps = speed;
    network::add_crown(road, fall, 0.1, network::max_rate_jump_of(road));
    EXPECT_LE(road.shape.size(), fewer);
    fewer = road.shape.size();
    double before = roadquery::shape(road, 0.0, 4.0).dh_ds;
    for (double s = 0.0; s <= road.length; s += 0.05) {
      const double gradient = roadquery::shape(road, s, 4.0).dh_ds;
      EXPECT_LE(std::abs(gradient - before) * (speed > 0.0 ? speed : 40.0), 0.0401) << speed << " at " << s;
      before = gradient;
    }
  }
  EXPECT_LE(fewer, 10u);
}

TEST(Crown, of_one_half_takes_one_entry_a_place) {
  const std::vector<Cubic> fall{network::hermite(0.0, 20.0, 0.025, 0.005, 0.0, -1e-4)};
  roadquery::Road both, one;
  both.length = one.length = 20.0;
  both.shape = network::crown_shape(fall, 20.0);
  for (const auto half : {network::RoadHalves::right, network::RoadHalves::left}) {
    one.shape = network::crown_shape(fall, 20.0, {.halves = half});
    EXPECT_EQ(2 * one.shape.size(), both.shape.size());
    const double side = half == network::RoadHalves::right ? -1.0 : 1.0;
    for (double s = 0.0; s <= 20.0; s += 0.25)
      for (const double t : {0.0, 0.5, 3.5})
        EXPECT_NEAR(roadquery::shape(one, s, side * t).h, roadquery::shape(both, s, side * t).h, 1e-14) << s;
  }
}

TEST(SimplifyProfile, leaves_out_joints_that_change_nothing) {
  const std::vector<Cubic> whole{{.s = 0.0, .a = 0.01, .b = 1e-3, .c = -2e-5, .d = 3e-7}};
  std::vector<Cubic> cut = network::slice_profile(whole, 0.0, 7.0);
  cut.push_back(network::slice_profile(whole, 7.0, 20.0).front());
  cut.back().s = 7.0;
  const std::vector<Cubic> again = network::simplify_profile(cut, 20.0, 1e-12);
  ASSERT_EQ(again.size(), 1u);
  EXPECT_NEAR(again[0].c, whole[0].c, 1e-15);
  EXPECT_NEAR(again[0].d, whole[0].d, 1e-16);
  EXPECT_TRUE(network::simplify_profile({}, 20.0, 1e-9).empty());
}

TEST(SimplifyProfile, stays_within_its_tolerance_and_smooth) {
  std::vector<Cubic> waves;
  const auto value = [](int k) { return 0.02 * std::sin(0.3 * k) + 1e-4 * (k % 2); };
  waves.reserve(40);
  for (int k = 0; k < 40; ++k)
    waves.push_back(network::hermite(5.0 * k, 5.0 * k + 5.0, value(k), value(k + 1), 0.0012 * std::cos(0.3 * k),
                                     0.0012 * std::cos(0.3 * (k + 1))));
  const std::vector<Cubic> simple = network::simplify_profile(waves, 200.0, 2e-4);
  EXPECT_LT(2 * simple.size(), waves.size());
  for (double s = 0.0; s <= 200.0; s += 0.1)
    EXPECT_NEAR(roadquery::evaluate(simple, s), roadquery::evaluate(waves, s), 2.2e-4) << s;
  for (std::size_t i = 1; i < simple.size(); ++i) {
    EXPECT_NEAR(network::value_at(simple[i - 1], simple[i].s), simple[i].a, 1e-12);
    EXPECT_NEAR(network::slope_at(simple[i - 1], simple[i].s), simple[i].b, 1e-12);
  }
  EXPECT_EQ(simple.front().a, waves.front().a);
  EXPECT_NEAR(network::value_at(simple.back(), 200.0), network::value_at(waves.back(), 200.0), 1e-12);
}

TEST(Crown, of_nodes_is_seen_in_the_surface_of_every_road) {
  // A crossing of two crowned roads, one drawn against the other's direction, and banking on one of them.
  RoadNetwork roads =
      network_of({make_path({{-120, 0}, {0, 0}, {120, 0}}, {1, 2, 3},
                            {.osm_id = 1, .height = [](Vec2) { return 20.0; }, .banking = [](double) { return 0.01; }}),
                  make_path({{0, -120}, {0, 0}}, {4, 2}, {.osm_id = 2, .height = [](Vec2) { return 20.0; }}),
                  make_path({{0, 120}, {0, 0}}, {5, 2}, {.osm_id = 3, .height = [](Vec2) { return 20.0; }})});
  for (RoadPath& path : roads.paths)
    for (RoadNode& node : path.nodes) node.crown = std::atan(path.osm_id == 3 ? 0.03 : 0.025);
  const roadquery::RoadMap map = build_network(roads).map;
  expect_sound(map);
  int crowned = 0, compared = 0;
  for (const roadquery::Road& road : map.roads) {
    if (road.osm_id == "1" && road.junction < 0) {
      EXPECT_NEAR(fall_at(road, 0.5 * road.length, 2.0), 0.025, 1e-9);
      const double left = roadquery::surface_point(road, 10.0, 3.0).z,
                   right = roadquery::surface_point(road, 10.0, -3.0).z;
      EXPECT_NEAR(0.5 * (left + right), 20.0 - 3.0 * 0.025 * std::cos(0.01), 1e-9);
      EXPECT_NEAR(std::abs(left - right), 6.0 * std::sin(0.01), 1e-9);
      ++crowned;
    }
    // Where roads are linked their surfaces meet, not only their reference lines.
    const auto check = [&](const roadquery::RoadLink& link, double s) {
      if (link.kind != roadquery::LinkKind::road) return;
      const roadquery::Road& other = *road_by_id(map, link.id);
      const double s_other = link.contact == roadquery::ContactPoint::end ? other.length : 0.0;
      const roadquery::PlanPoint a = roadquery::reference_point(road, s),
                                 b = roadquery::reference_point(other, s_other);
      const double turned = std::cos(a.hdg - b.hdg) > 0.0 ? 1.0 : -1.0;
      // A road has a surface between its edges; connecting roads have lanes on one side only.
      const roadquery::Edges edges = roadquery::road_edges(road, s);
      for (const double t : {-2.5, -1.0, -1e-3, 1e-3, 1.0, 2.5})
        if (t > edges.right_t && t < edges.left_t) {
          EXPECT_NEAR(roadquery::surface_point(road, s, t).z, roadquery::surface_point(other, s_other, turned * t).z,
                      1e-6)
              << "road " << road.id << " to " << other.id;
          ++compared;
        }
    };
    check(road.predecessor, 0.0);
    check(road.successor, road.length);
  }
  EXPECT_EQ(crowned, 2);
  EXPECT_GE(compared, 6 * 12) << "three places at both ends of twelve connecting roads";
}

TEST(Crown, fewer_entries_leave_the_surface_where_it_was) {
  const auto height = [](Vec2 p) { return 20.0 + 0.03 * p.x - 1e-4 * p.y * p.y; };
  RoadNetwork roads =
      network_of({make_path({{-220, 0}, {0, 0}, {220, 30}}, {1, 2, 3},
                            {.osm_id = 1,
                             .width_m = 8.0,
                             .height = height,
                             .banking = [](double s) { return 0.02 * std::sin(s / 30); }}),
                  make_path({{0, -150}, {0, 0}}, {4, 2}, {.osm_id = 2, .height = height}),
                  make_path({{0, 150}, {0, 0}}, {5, 2}, {.osm_id = 3, .oneway = Oneway::forward, .height = height})});
  for (RoadPath& path : roads.paths)
    for (RoadNode& node : path.nodes) node.crown = 0.02 + 0.005 * std::sin(node.s_m / 25.0);
  const roadquery::RoadMap few = build_network(roads).map;
  const roadquery::RoadMap many = build_network(roads, {.shape_tolerance_m = 1e-5}).map;
  expect_sound(few);
  ASSERT_EQ(few.roads.size(), many.roads.size());
  std::size_t entries_few = 0, entries_many = 0;
  for (std::size_t i = 0; i < few.roads.size(); ++i) {
    const roadquery::Road &a = few.roads[i], &b = many.roads[i];
    entries_few += a.shape.size() + a.superelevation.size();
    entries_many += b.shape.size() + b.superelevation.size();
    for (double s = 0.0; s <= a.length; s += 0.5) {
      const roadquery::Edges edges = roadquery::road_edges(a, s);
      for (int k = 0; k <= 8; ++k) {
        const double t = edges.right_t + (edges.left_t - edges.right_t) * k / 8.0;
        ASSERT_NEAR(roadquery::surface_point(a, s, t).z, roadquery::surface_point(b, s, t).z, 5e-3)
            << "road " << a.id << " at " << s << ", " << t;
      }
    }
  }
  EXPECT_LT(2 * entries_few, entries_many);
}

TEST(Crown, none_makes_no_shapes) {
  const auto map = build_network(network_of({make_path({{0, 0}, {80, 0}}, {1, 2})})).map;
  EXPECT_TRUE(map.roads.at(0).shape.empty());
}

}  // namespace
}  // namespace orthodrive
