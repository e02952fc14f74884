// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/noise.hpp"
#include "orthodrive/geo/spatial_index.hpp"
#include "orthodrive/synth/plan/countryside.hpp"
#include "orthodrive/synth/plan/interchange.hpp"
#include "orthodrive/synth/plan/plan_presets.hpp"
#include "orthodrive/synth/plan/trackside.hpp"

namespace orthodrive::synth {
namespace {
constexpr double overhang_m = 150.0;        // roads that leave the site go on by this
constexpr double strip_free_m = 230.0;      // from the motorway's axis: only roads across it
constexpr double join_within_m = 45.0;      // junctions on both sides of a street become one if nearer than this
constexpr double least_to_corner_m = 90.0;  // from a street's junction to the next larger road

/// How much of a region is built on.
struct Density {
  const char* name = "Region";
  double towns = 1.0 / 3.0, villages = 1.0 / 3.0;  ///< shares of the settlements; the rest are hamlets
  double half_low = 0.3, half_high = 0.36;         ///< half a town's extent over the grid's
  double farms = 0.65;                             ///< share of the places for a farm that have one
};
constexpr Density country;
constexpr Density conurbation{
    .name = "Conurbation", .towns = 1.0, .villages = 0.0, .half_low = 0.41, .half_high = 0.42, .farms = 0.0};

/// Bends the plan, which is drawn on a square grid: large waves for the land, small ones for streets. Their slopes sum
/// to less than 0.6 at worst (0.2 rms), so that lines keep their order and cross at large angles. The small ones
/// fade out at the motorway, which roads cross straight.
class Warp {
 public:
  Warp(double motorway_y, Random& random) : motorway_y_(motorway_y) {
    const auto add = [&](double amplitude_m, double wavelength_m, bool small) {
      const double angle = random.uniform(0.0, 2.0 * std::numbers::pi), k = 2.0 * std::numbers::pi / wavelength_m;
      const double toward = random.uniform(0.0, 2.0 * std::numbers::pi);
      waves_.push_back({Vec2{std::cos(angle), std::sin(angle)} * k,
                        Vec2{std::cos(toward), std::sin(toward)} * amplitude_m,
                        random.uniform(0.0, 2.0 * std::numbers::pi), small});
    };
    for (int i = 0; i < 3; ++i) add(45.0, random.uniform(4000.0, 7000.0), false);
    for (int i = 0; i < 4; ++i) add(8.0, random.uniform(500.0, 900.0), true);
  }
  [[nodiscard]] Vec2 at(Vec2 p) const {
    const double small = smoothstep(250.0f, 500.0f, static_cast<float>(std::abs(p.y - motorway_y_)));
    Vec2 moved = p;
    for (const Wave& w : waves_)
      moved = moved + w.amplitude * ((w.small ? small : 1.0) * std::sin(dot(w.k, p) + w.phase_rad));
    return moved;
  }

 private:
  struct Wave {
    Vec2 k, amplitude;
    double phase_rad = 0.0;
    bool small = false;
  };
  double motorway_y_;
  std::vector<Wave> waves_;
};

/// Half the extent of a settlement; none: a hamlet without streets of its own.
struct Extent {
  double x = 0.0, y = 0.0;
  bool town = false;
  [[nodiscard]] bool hamlet() const { return x == 0.0; }
};

/// A street along x, and where others meet it from below.
struct Street {
  std::size_t road = 0;
  double y = 0.0;
  std::map<double, Vec2> junctions;  ///< by x
};

/// The plan is drawn on a square grid of settlements: rows and columns are the larger roads, which cross in the
/// settlements' middles; lanes run halfway between them; a motorway runs between two rows. Everything is bent by the
/// warp. Ends of roads lie exactly on the curves that they meet.
class RegionPlanner {
 public:
  RegionPlanner(double size_m, std::uint64_t seed, const Density& density)
      : planner_(size_m, seed),
        density_(density),
        random_(planner_.random_),
        size_m_(size_m),
        count_(std::max(2, static_cast<int>(std::lround(size_m / 2000.0)))),
        unit_m_(size_m / count_),
        motorway_y_(unit_m_ * (count_ / 2)),
        warp_(motorway_y_, random_) {}

  SitePlan plan() {
    add_motorway();
    for (int j = 0; j < count_; ++j) add_row(j);
    for (int i = 0; i < count_; ++i) add_column(i);
    draw_extents();
    for (int j = 0; j < count_; ++j)
      for (int i = 0; i < count_; ++i) lay_out_settlement(i, j);
    for (int i = 0; i <= count_; ++i) add_lanes_along_y(i);
    for (int j = 0; j <= count_; ++j) add_lanes_along_x(j);
    const std::size_t last_road = planner_.plan_.roads.size();
    for (std::size_t r = first_lane_; r < last_road; ++r) add_farms(r);
    lay_out_ground();
    SitePlan plan = std::move(planner_.plan_);
    plan.name = density_.name, plan.route = plan.roads[motorway_.roads[0]].name;
    plan.surroundings = Surroundings::region, plan.relief = 0.35, plan.round_corners_by_angle = true;
    find_junctions(plan, [&](std::size_t a, std::size_t b) -> std::optional<std::size_t> {
      if (plan.roads[a].highway == "motorway" && plan.roads[b].highway != "motorway_link") return b;
      return std::nullopt;
    });
    const auto [main, opposite] = motorway_.roads;
    plan.ties.push_back({opposite, main, 0.0, plan.roads[opposite].alignment.length_m, false});
    for (const Slip& slip : slips_) add_ties(plan, slip);
    return plan;
  }

 private:
  [[nodiscard]] Vec2 at(double x, double y) const {
    const Vec2 p = warp_.at({x, y});
    return planner_.place(p.x / size_m_, p.y / size_m_);
  }
  [[nodiscard]] double middle(int i) const { return (i + 0.5) * unit_m_; }

  /// Corners of a line between two places of the square grid, every `step_m` or less.
  [[nodiscard]] std::vector<Corner> corners(Vec2 from, Vec2 to, double step_m, double radius_m) const {
    const int count = std::max(1, static_cast<int>(std::ceil(distance(from, to) / step_m)));
    std::vector<Corner> line;
    for (int i = 0; i <= count; ++i) {
      const Vec2 p = from + (to - from) * (static_cast<double>(i) / count);
      line.push_back({at(p.x, p.y), radius_m});
    }
    return line;
  }
  /// A line whose ends, where they are given, lie on other roads.
  [[nodiscard]] std::vector<Corner> between(Vec2 from, Vec2 to, std::optional<Vec2> begin, std::optional<Vec2> end) {
    std::vector<Corner> line = corners(from, to, 160.0, 600.0);
    if (begin) line.front().p = *begin;
    if (end) line.back().p = *end;
    return line;
  }

  std::size_t add(const std::string& highway, const std::string& name, const std::vector<Corner>& corners) {
    return planner_.add(planner_.street(highway, name, corners));
  }
  /// The point of a road nearest to a place of the square grid.
  Vec2 on(std::size_t road, double x, double y) {
    const Alignment& a = planner_.plan_.roads[road].alignment;
    Polyline& line = lines_[road];
    if (line.empty()) line = sample(a, search_step_m);
    return evaluate(a, nearest_s(a, line, at(x, y))).p;
  }

  void add_motorway() {
    const double shoulder_m = random_.uniform(2.0, 3.4), width_m = strip_m + 2 * lane_m + shoulder_m,
                 median_m = random_.uniform(3.5, 6.0);
    motorway_ = add_carriageways(
        planner_, corners({-2.0 * overhang_m, motorway_y_}, {size_m_ + 2.0 * overhang_m, motorway_y_}, 1000.0, 4000.0),
        {"A 9", "A 9 Gegenrichtung"}, {2, width_m, 0.5 * (median_m + width_m)});
  }

  void add_row(int j) {
    rows_.push_back(add(j % 2 == 0 ? "secondary" : "tertiary", fmt::format("Querstrasse {}", j + 1),
                        between({-overhang_m, middle(j)}, {size_m_ + overhang_m, middle(j)}, {}, {})));
  }

  /// On a bridge over the motorway; on every third column there is an interchange with roundabouts.
  void add_column(int i) {
    const double x = middle(i);
    const Vec2 south{x, -overhang_m}, north{x, size_m_ + overhang_m};
    const std::string name = fmt::format("Landesstrasse {}", i + 1);
    if (i % 3 != 1) {
      const std::size_t road = add("tertiary", name, between(south, north, {}, {}));
      columns_.push_back({road, road});
      return;
    }
    constexpr double straight_m = 300.0;
    const Vec2 low{x, motorway_y_ - straight_m}, high{x, motorway_y_ + straight_m};
    const InterchangeSizes sizes{std::min(420.0, 0.38 * unit_m_), 140.0, 95.0};
    const Crossings crossings =
        place_heads(planner_.plan_, motorway_,
                    round_corners({{at(low.x, low.y), 0.0}, {at(high.x, high.y), 0.0}}, false), sizes, true);
    const bool first_is_low =
        distance(crossings.heads[0].p, at(low.x, low.y)) < distance(crossings.heads[1].p, at(low.x, low.y));
    const Head &lower = crossings.heads[first_is_low ? 0 : 1], &upper = crossings.heads[first_is_low ? 1 : 0];
    std::vector<Corner> below = between(south, low, {}, {}), above = between(high, north, {}, {});
    below.push_back({lower.end_from(at(low.x, low.y)), 0.0});
    above.insert(above.begin(), {upper.end_from(at(high.x, high.y)), 0.0});
    columns_.push_back({add("secondary", name, below), add("secondary", name, above)});
    add("secondary", name, {{lower.end_from(upper.p), 0.0}, {upper.end_from(lower.p), 0.0}});
    for (const Head& head : crossings.heads) {
      add_ring(planner_, head, fmt::format("Kreisel {}", ++rings_));
      rings_at_.push_back(head.p);
    }
    const std::vector<Slip> slips = add_slip_roads(planner_, motorway_, crossings, sizes);
    slips_.insert(slips_.end(), slips.begin(), slips.end());
  }
  [[nodiscard]] std::size_t column(int i, double y) const {
    return columns_[static_cast<std::size_t>(i)][y < motorway_y_ ? 0 : 1];
  }

  /// The first draw is a town, whatever the size.
  void draw_extents() {
    const int all = count_ * count_;
    std::vector<int> order(static_cast<std::size_t>(all));
    for (int k = 0; k < all; ++k) order[static_cast<std::size_t>(k)] = k;
    for (std::size_t k = order.size(); k > 1; --k) std::swap(order[k - 1], order[random_.below(k)]);
    extents_.assign(order.size(), {});
    for (int k = 0; k < all; ++k) {
      const int j = order[static_cast<std::size_t>(k)] / count_;
      const bool by_motorway = std::abs(middle(j) - motorway_y_) < unit_m_;
      const double most = density_.half_high * unit_m_,
                   most_y = by_motorway ? 0.5 * unit_m_ - strip_free_m - 30.0 : most;
      Extent extent;
      if (k <= static_cast<int>(density_.towns * all + 1e-9))
        extent = {half_of_town(), half_of_town(), true};
      else if (k <= static_cast<int>((density_.towns + density_.villages) * all + 1e-9))
        extent = {random_.uniform(220.0, 330.0), random_.uniform(170.0, 260.0), false};
      extent.x = std::min(extent.x, most), extent.y = std::min(extent.y, most_y);
      extents_[static_cast<std::size_t>(order[static_cast<std::size_t>(k)])] = extent;
    }
  }

  double half_of_town() { return random_.uniform(density_.half_low, density_.half_high) * unit_m_; }

  /// Streets along x between two collectors, streets across from one to the next.
  void lay_out_settlement(int i, int j) {
    const Extent extent = extents_[static_cast<std::size_t>(j * count_ + i)];
    if (extent.hamlet()) return;
    const double x = middle(i), y = middle(j);
    ++settlement_;
    std::array<std::size_t, 2> collectors{};
    for (const int side : {0, 1})
      collectors[static_cast<std::size_t>(side)] =
          add(extent.town ? "tertiary" : "residential", fmt::format("Ringstrasse {}", 2 * settlement_ + side - 1),
              between({x + (side == 0 ? -extent.x : extent.x), y - extent.y},
                      {x + (side == 0 ? -extent.x : extent.x), y + extent.y}, {}, {}));
    std::vector<Street> streets;
    for (const double offset : street_offsets(extent.y)) {
      if (offset == 0.0) {
        streets.push_back({rows_[static_cast<std::size_t>(j)], y, {}});
        continue;
      }
      const Vec2 begin{x - extent.x, y + offset}, end{x + extent.x, y + offset};
      streets.push_back({add("residential", next_name(),
                             between(begin, end, on(collectors[0], begin.x, begin.y), on(collectors[1], end.x, end.y))),
                         y + offset,
                         {}});
    }
    for (std::size_t k = 0; k + 1 < streets.size(); ++k) {
      add_streets_across(streets[k], streets[k + 1], x - extent.x, x, extent.town);
      add_streets_across(streets[k], streets[k + 1], x, x + extent.x, extent.town);
    }
    add_outline({x, y}, extent);
  }

  /// Of the streets along x from the row, ascending; the outermost are the border.
  std::vector<double> street_offsets(double half_m) {
    std::vector<double> offsets{-half_m, 0.0, half_m};
    for (const double side : {-1.0, 1.0})
      for (double y = random_.uniform(110.0, 145.0); y < half_m - 100.0; y += random_.uniform(115.0, 165.0))
        offsets.push_back(side * y);
    std::sort(offsets.begin(), offsets.end());
    return offsets;
  }

  std::string next_name() { return fmt::format("Gasse {}", ++streets_); }

  /// The place on the lower street at x, or a junction near it, which moves x.
  Vec2 place_on(const Street& street, double& x) {
    const auto after = street.junctions.lower_bound(x - join_within_m);
    if (after == street.junctions.end() || after->first > x + join_within_m) return on(street.road, x, street.y);
    x = after->first;
    return after->second;
  }

  void add_streets_across(Street& lower, Street& upper, double west, double east, bool town) {
    const double depth_m = upper.y - lower.y;
    double last = west;
    for (double wanted = west + random_.uniform(110.0, 170.0); wanted < east - 105.0;
         wanted += random_.uniform(110.0, 190.0)) {
      double x = wanted;
      const Vec2 begin = place_on(lower, x);
      if (x - last < least_to_corner_m || x > east - least_to_corner_m) continue;
      if (x - last > 175.0) add_dead_end(lower, 0.5 * (last + x), depth_m);
      last = x;
      const double x_end = x + random_.uniform(-12.0, 12.0);
      const Vec2 end = on(upper.road, x_end, upper.y);
      upper.junctions.emplace(x_end, end);
      const std::size_t road = add("residential", next_name(),
                                   {{begin, 0.0},
                                    {at(0.5 * (x + x_end) + random_.uniform(-7.0, 7.0), lower.y + 0.5 * depth_m), 60.0},
                                    {end, 0.0}});
      if (town && random_.uniform() < 0.15) add_car_park(road);
    }
  }

  void add_dead_end(const Street& street, double x, double depth_m) {
    const double length_m = std::min(depth_m - 50.0, random_.uniform(50.0, 90.0)), wanted = x;
    if (length_m < 45.0 || random_.uniform() < 0.35) return;
    const Vec2 begin = place_on(street, x);
    if (std::abs(x - wanted) > 20.0) return;
    add("residential", next_name(), {{begin, 0.0}, {at(x, street.y + length_m), 0.0}});
  }

  void add_car_park(std::size_t road) {
    const PlannedRoad& street = planner_.plan_.roads[road];
    const AlignmentPoint q = evaluate(street.alignment, 0.5 * street.alignment.length_m);
    const Vec2 along{std::cos(q.heading_rad), std::sin(q.heading_rad)}, outward = left_normal(along);
    const Vec2 corner = q.p + outward * (0.5 * street.width_m) - along * 20.0;
    add_area({corner, corner + along * 40.0, corner + along * 40.0 + outward * 17.0, corner + outward * 17.0},
             Cover::parking, true);
  }
  void add_area(Ring ring, Cover cover, bool mapped) {
    synth::add_area(planner_.plan_, std::move(ring), cover, mapped);
  }

  void add_outline(Vec2 center, const Extent& extent) {
    constexpr double lots_m = 40.0;
    const double x = extent.x + lots_m, y = extent.y + lots_m;
    const std::array<Vec2, 5> square{center + Vec2{-x, -y}, center + Vec2{x, -y}, center + Vec2{x, y},
                                     center + Vec2{-x, y}, center + Vec2{-x, -y}};
    Ring outline;
    for (std::size_t k = 0; k < 4; ++k) {
      const std::vector<Corner> side = corners(square[k], square[k + 1], 80.0, 0.0);
      for (std::size_t c = 0; c + 1 < side.size(); ++c) outline.push_back(side[c].p);
    }
    add_area(outline, Cover::meadow, false);
    planner_.plan_.settlements.push_back({{std::move(outline), {}}, extent.town});
  }

  [[nodiscard]] double lane_place(int i) {
    const double jitter_m = random_.uniform(-0.04, 0.04) * unit_m_;
    if (i == 0) return 0.05 * unit_m_;
    if (i == count_) return size_m_ - 0.05 * unit_m_;
    return i * unit_m_ + jitter_m;
  }

  /// From row to row; dead ends before the motorway.
  void add_lanes_along_y(int i) {
    if (first_lane_ == 0) first_lane_ = planner_.plan_.roads.size();
    const double x = lane_place(i);
    const auto lane = [&](double from, double to, std::optional<int> row_from, std::optional<int> row_to) {
      const auto end = [&](std::optional<int> row) -> std::optional<Vec2> {
        if (!row) return std::nullopt;
        return on(rows_[static_cast<std::size_t>(*row)], x, middle(*row));
      };
      add("unclassified", fmt::format("Feldweg {}", ++lanes_), between({x, from}, {x, to}, end(row_from), end(row_to)));
    };
    lane(-overhang_m, middle(0), {}, 0);
    for (int j = 0; j + 1 < count_; ++j) {
      if (j + 1 != count_ / 2) {
        lane(middle(j), middle(j + 1), j, j + 1);
        continue;
      }
      lane(middle(j), motorway_y_ - strip_free_m, j, {});
      lane(motorway_y_ + strip_free_m, middle(j + 1), {}, j + 1);
    }
    lane(middle(count_ - 1), size_m_ + overhang_m, count_ - 1, {});
  }

  /// From column to column, across the lanes along y; none beside the motorway.
  void add_lanes_along_x(int j) {
    if (j == count_ / 2) return;
    const double y = lane_place(j);
    const auto lane = [&](double from, double to, std::optional<int> column_from, std::optional<int> column_to) {
      const auto end = [&](std::optional<int> i) -> std::optional<Vec2> {
        if (!i) return std::nullopt;
        return on(column(*i, y), middle(*i), y);
      };
      add("unclassified", fmt::format("Feldweg {}", ++lanes_),
          between({from, y}, {to, y}, end(column_from), end(column_to)));
    };
    lane(-overhang_m, middle(0), {}, 0);
    for (int i = 0; i + 1 < count_; ++i) lane(middle(i), middle(i + 1), i, i + 1);
    lane(middle(count_ - 1), size_m_ + overhang_m, count_ - 1, {});
  }

  /// A drive to a farm a quarter of the way along a lane, and three quarters along it: lanes cross halfway.
  void add_farms(std::size_t lane) {
    const Alignment alignment = planner_.plan_.roads[lane].alignment;
    const Box2 site{0.0, 0.0, size_m_, size_m_};
    for (const double share : {0.25, 0.75}) {
      if (alignment.length_m < 0.7 * unit_m_ || random_.uniform() < 1.0 - density_.farms) continue;
      const AlignmentPoint q = evaluate(alignment, (share + random_.uniform(-0.05, 0.05)) * alignment.length_m);
      const Vec2 along{std::cos(q.heading_rad), std::sin(q.heading_rad)};
      const Vec2 outward = left_normal(along) * (random_.below(2) ? 1.0 : -1.0);
      const double length_m = random_.uniform(0.03, 0.055) * unit_m_;
      const Vec2 yard = q.p + outward * length_m;
      if (!site.grown(-40.0).contains(yard)) continue;
      add("service", "",
          {{q.p, 0.0}, {q.p + outward * (0.5 * length_m) + along * random_.uniform(-5.0, 5.0), 40.0}, {yard, 0.0}});
      add_farm(planner_.plan_, yard, outward, random_);
    }
  }

  /// Verges, a wall in the median, grass in the rings; woods and lakes where they fit.
  void lay_out_ground() {
    SitePlan& plan = planner_.plan_;
    add_lakes_and_woods(plan, count_ * count_, {}, random_);
    for (const Slip& slip : slips_) add_verges(plan, slip.road, 10.0);
    for (const std::size_t road : motorway_.roads) add_verges(plan, road, 18.0);
    for (const Vec2 ring : rings_at_) add_area(sample(circle(ring, ring_radius_m), 2.0), Cover::meadow, false);
    const Alignment axis = round_corners(motorway_.axis, false);
    for (double s = 0.0; s < axis.length_m; s += 100.0)
      add_area(strip_along(axis, s, std::min(s + 100.0, axis.length_m), -0.3, 0.3), Cover::paved, false);
  }

  Planner planner_;
  const Density& density_;
  Random& random_;
  double size_m_;
  int count_;  ///< of rows and of columns
  double unit_m_, motorway_y_;
  Warp warp_;
  Motorway motorway_;
  std::vector<Slip> slips_;
  std::vector<Vec2> rings_at_;
  std::vector<std::size_t> rows_;
  std::vector<std::array<std::size_t, 2>> columns_;  ///< the roads below and above the motorway
  std::vector<Extent> extents_;
  std::map<std::size_t, Polyline> lines_;  ///< of roads that others end on
  std::size_t first_lane_ = 0;
  int rings_ = 0, settlement_ = 0, streets_ = 0, lanes_ = 0;
};
}  // namespace

namespace {
SitePlan plan_of(double size_m, std::uint64_t seed, const Density& density) {
  if (!(size_m >= 2000.0 && size_m <= 40000.0) || std::fmod(size_m, 10.0) != 0.0)
    throw OptionError(fmt::format("size is {} m, need a multiple of 10 m between 2000 and 40000", size_m));
  return RegionPlanner(size_m, seed, density).plan();
}
}  // namespace

SitePlan plan_region(double size_m, std::uint64_t seed) { return plan_of(size_m, seed, country); }
SitePlan plan_conurbation(double size_m, std::uint64_t seed) { return plan_of(size_m, seed, conurbation); }

}  // namespace orthodrive::synth
