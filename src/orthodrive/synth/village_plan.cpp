#include "orthodrive/synth/village_plan.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "orthodrive/core/random.hpp"
#include "orthodrive/model/road_network.hpp"

namespace orthodrive::synth {
namespace {
constexpr double streets_from_size_m = 450.0;  // below, streets of 5 m width would touch each other
constexpr double overhang = 0.06;              // roads that leave the site go on by this share of its size

/// Builds the plan in the unit square, turned and mirrored by seed.
class Planner {
 public:
  Planner(double size_m, std::uint64_t seed)
      : random_(derive_seed(seed, 1)),
        quarter_turns_(static_cast<int>(random_.below(4))),
        mirrored_(random_.below(2) == 1) {
    plan_.size_m = size_m;
  }

  [[nodiscard]] Vec2 place(double u, double v) const {
    Vec2 p{mirrored_ ? 0.5 - u : u - 0.5, v - 0.5};
    for (int i = 0; i < quarter_turns_; ++i) p = left_normal(p);
    return (p + Vec2{0.5, 0.5}) * plan_.size_m;
  }
  [[nodiscard]] Vec2 jittered(double u, double v) {
    const double du = random_.uniform(-0.012, 0.012), dv = random_.uniform(-0.012, 0.012);
    return place(u + du, v + dv);
  }
  /// A point of another road near (u, v), to start or end a branch there.
  [[nodiscard]] Vec2 branch_point(std::size_t road, double u, double v) const {
    const Alignment& a = plan_.roads[road].alignment;
    return evaluate(a, nearest_s(a, place(u, v))).p;
  }
  std::size_t add(PlannedRoad road) {
    plan_.roads.push_back(std::move(road));
    return plan_.roads.size() - 1;
  }
  [[nodiscard]] Corner corner(double u, double v, double min_radius_m, double max_radius_m) {
    const Vec2 p = jittered(u, v);
    return {p, random_.uniform(min_radius_m, max_radius_m)};
  }
  /// True widths differ from the defaults of untagged ways by 8 to 20 %, to either side.
  [[nodiscard]] double true_width_m(const std::string& highway, int lanes, bool oneway) {
    const double share = random_.uniform(0.08, 0.20) * (random_.below(2) == 0 ? -1.0 : 1.0);
    return default_width_m(highway, lanes, oneway ? Oneway::forward : Oneway::no) * (1.0 + share);
  }
  PlannedRoad street(const std::string& highway, const std::string& name, const std::vector<Corner>& corners) {
    return {.highway = highway,
            .name = name,
            .width_m = true_width_m(highway, 0, false),
            .alignment = round_corners(corners, false)};
  }

  VillagePlan plan_;
  Random random_;

 private:
  int quarter_turns_;
  bool mirrored_;
};

std::size_t add_circuit(Planner& planner) {
  constexpr int corners = 10;  // even, so that straights face each other north and south, where the spine crosses
  std::vector<Corner> ring;
  for (int i = 0; i < corners; ++i) {
    const double angle = std::numbers::pi * (0.5 + (2.0 * i + 1.0) / corners) + planner.random_.uniform(-0.06, 0.06);
    // In and out in turn: left bends and right bends.
    const double radius = 0.31 + (i % 2 == 0 ? 0.022 : -0.022) + planner.random_.uniform(-0.045, 0.045);
    ring.push_back({planner.place(0.5 + 1.08 * radius * std::cos(angle), 0.54 + 0.96 * radius * std::sin(angle)),
                    planner.random_.uniform(50.0, 220.0)});
  }
  return planner.add({.highway = "tertiary",
                      .name = "Circuit",
                      .width_m = planner.random_.uniform(8.0, 9.5),
                      .alignment = round_corners(ring, true)});
}

/// The crossings of all pairs of roads and the ends of branches become junctions; the spine's first crossing with the
/// circuit becomes the bridge.
void find_junctions(VillagePlan& plan, std::size_t spine) {
  const auto add_arm = [&](Vec2 p, PlannedJunction::Arm arm) {
    auto it = std::find_if(plan.junctions.begin(), plan.junctions.end(),
                           [&](const PlannedJunction& j) { return distance(j.p, p) < 2.0; });
    if (it == plan.junctions.end()) it = plan.junctions.insert(it, {.p = p});
    const bool known = std::any_of(it->arms.begin(), it->arms.end(), [&](const PlannedJunction::Arm& a) {
      return a.road == arm.road && std::abs(a.s_m - arm.s_m) < 5.0;
    });
    if (!known) it->arms.push_back(arm);
  };
  const auto& roads = plan.roads;
  for (std::size_t b = 0; b < roads.size(); ++b)
    for (std::size_t a = 0; a < roads.size(); ++a) {  // ends of b on a
      if (a == b || roads[b].alignment.closed) continue;
      for (const double s : {0.0, roads[b].alignment.length_m}) {
        const Vec2 p = evaluate(roads[b].alignment, s).p;
        const double on_a = nearest_s(roads[a].alignment, p);
        if (distance(evaluate(roads[a].alignment, on_a).p, p) > 1e-6) continue;
        add_arm(p, {a, on_a});
        add_arm(p, {b, s});
      }
    }
  for (std::size_t b = 1; b < roads.size(); ++b)
    for (std::size_t a = 0; a < b; ++a)
      for (const AlignmentCrossing& c : crossings(roads[a].alignment, roads[b].alignment)) {
        const AlignmentPoint pa = evaluate(roads[a].alignment, c.s_a_m), pb = evaluate(roads[b].alignment, c.s_b_m);
        const bool bridge = b == spine && a == circuit_road && plan.bridges.empty();
        if (!bridge) {
          add_arm(pa.p, {a, c.s_a_m});
          add_arm(pa.p, {b, c.s_b_m});
          continue;
        }
        const double sine = std::abs(std::sin(pa.heading_rad - pb.heading_rad)), cosine = std::sqrt(1.0 - sine * sine);
        plan.bridges.push_back(
            {.over = b,
             .under = a,
             .s_over_m = c.s_b_m,
             .s_under_m = c.s_a_m,
             .half_length_m = (0.5 * roads[a].width_m + 0.5 * roads[b].width_m * cosine) / sine + 5.0});
      }
}
}  // namespace

VillagePlan plan_village(double size_m, std::uint64_t seed) {
  Planner planner(size_m, seed);
  const auto corner = [&](double u, double v, double r0, double r1) { return planner.corner(u, v, r0, r1); };
  const std::size_t circuit = add_circuit(planner);

  const std::size_t main = planner.add(
      planner.street("secondary", "Hauptstrasse",
                     {corner(-overhang, 0.09, 0, 1), corner(0.15, 0.055, 120, 260), corner(0.36, 0.105, 120, 260),
                      corner(0.62, 0.06, 120, 260), corner(0.82, 0.10, 120, 260), corner(1.0 + overhang, 0.07, 0, 1)}));
  // From the north over the circuit, through the village, across the circuit at grade, to the main road.
  const std::size_t spine = planner.add(planner.street("tertiary", "Dorfstrasse",
                                                       {corner(0.47, 1.0 + overhang, 0, 1),
                                                        corner(0.505, 0.95, 60, 140),
                                                        corner(0.495, 0.73, 60, 140),
                                                        corner(0.515, 0.56, 50, 120),
                                                        corner(0.485, 0.36, 50, 120),
                                                        corner(0.505, 0.15, 60, 140),
                                                        {planner.branch_point(main, 0.50, 0.08), 0.0}}));
  const std::size_t street = planner.add(planner.street("residential", "Gartengasse",
                                                        {{planner.branch_point(circuit, 0.19, 0.64), 0.0},
                                                         corner(0.29, 0.60, 30, 70),
                                                         corner(0.40, 0.51, 30, 70),
                                                         corner(0.61, 0.51, 30, 70),
                                                         corner(0.70, 0.60, 30, 70),
                                                         {planner.branch_point(circuit, 0.81, 0.64), 0.0}}));
  const std::size_t lane = planner.add({.highway = "service",
                                        .width_m = planner.true_width_m("service", 0, true),
                                        .lanes = 1,
                                        .oneway = true,
                                        .alignment = round_corners({{planner.branch_point(spine, 0.49, 0.41), 0.0},
                                                                    {planner.place(0.42, 0.41), 8.0},
                                                                    {planner.place(0.42, 0.30), 8.0},
                                                                    {planner.branch_point(spine, 0.49, 0.30), 0.0}},
                                                                   false)});
  {
    const double gap = 0.5 * planner.plan_.roads[lane].width_m / size_m, depth = 17.0 / size_m;
    planner.plan_.parking.outer = {planner.place(0.42 - gap, 0.322), planner.place(0.42 - gap, 0.388),
                                   planner.place(0.42 - gap - depth, 0.388), planner.place(0.42 - gap - depth, 0.322)};
  }
  planner.add(planner.street(
      "unclassified", "Feldweg",
      {{planner.branch_point(circuit, 0.20, 0.44), 0.0}, corner(0.10, 0.40, 40, 90), corner(-overhang, 0.46, 0, 1)}));
  if (size_m >= streets_from_size_m) {
    const std::size_t west = planner.add(planner.street("residential", "Bachweg",
                                                        {{planner.branch_point(circuit, 0.31, 0.29), 0.0},
                                                         corner(0.33, 0.36, 25, 50),
                                                         corner(0.305, 0.46, 25, 50),
                                                         {planner.branch_point(street, 0.34, 0.56), 0.0}}));
    planner.add(planner.street("residential", "Kirchgasse",
                               {{planner.branch_point(spine, 0.49, 0.35), 0.0},
                                corner(0.61, 0.36, 25, 50),
                                corner(0.665, 0.44, 25, 50),
                                {planner.branch_point(street, 0.66, 0.56), 0.0}}));
    planner.add(planner.street("residential", "Am Hang",
                               {{planner.branch_point(street, 0.42, 0.51), 0.0},
                                corner(0.405, 0.60, 20, 40),
                                corner(0.37, 0.68, 20, 40),
                                corner(0.41, 0.76, 0, 1)}));
    planner.add(planner.street(
        "residential", "Lindenweg",
        {{planner.branch_point(spine, 0.50, 0.68), 0.0}, corner(0.58, 0.665, 20, 40), corner(0.655, 0.725, 0, 1)}));
    planner.add(
        planner.street("service", "", {{planner.branch_point(west, 0.315, 0.42), 0.0}, corner(0.25, 0.43, 0, 1)}));
    planner.add(planner.street(
        "service", "",
        {{planner.branch_point(circuit, 0.80, 0.42), 0.0}, corner(0.86, 0.40, 15, 30), corner(0.91, 0.33, 0, 1)}));
  }
  find_junctions(planner.plan_, spine);
  return std::move(planner.plan_);
}

int surface_priority(const VillagePlan& plan, std::size_t road) {
  return 2 * road_rank(plan.roads[road].highway) + (road == circuit_road ? 1 : 0);
}

bool on_bridge(const VillagePlan& plan, std::size_t road, double s_m) {
  return std::any_of(plan.bridges.begin(), plan.bridges.end(), [&](const PlannedBridge& b) {
    return b.over == road && std::abs(s_m - b.s_over_m) <= b.half_length_m;
  });
}

}  // namespace orthodrive::synth
