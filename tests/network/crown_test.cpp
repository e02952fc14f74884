// Crowns of nodes as lateral shapes of roads.

#include "network_support.hpp"
#include "orthodrive/network/crown_shape.hpp"
#include "orthodrive/network/fit_profile.hpp"

namespace orthodrive {
namespace {

using namespace orthodrive::testing;
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
  int crowned = 0;
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
      for (const double t : {-2.5, 2.5})
        EXPECT_NEAR(roadquery::surface_point(road, s, t).z, roadquery::surface_point(other, s_other, turned * t).z,
                    1e-6)
            << "road " << road.id << " to " << other.id;
    };
    check(road.predecessor, 0.0);
    check(road.successor, road.length);
  }
  EXPECT_EQ(crowned, 2);
}

TEST(Crown, none_makes_no_shapes) {
  const auto map = build_network(network_of({make_path({{0, 0}, {80, 0}}, {1, 2})})).map;
  EXPECT_TRUE(map.roads.at(0).shape.empty());
}

}  // namespace
}  // namespace orthodrive
