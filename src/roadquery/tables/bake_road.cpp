// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "roadquery/surface/poly_curve.hpp"
#include "roadquery/surface/road_surface.hpp"
#include "roadquery/surface/shift_cubic.hpp"
#include "roadquery/tables/bake_lanes.hpp"
#include "roadquery/tables/baked_surface.hpp"
#include "roadquery/tables/overlaps.hpp"

namespace roadquery {
namespace {

constexpr double longest_station_m = 4.0;  // of about a cell of the index
// Of a station's polynomials at its ends; up to baked_plan_error_m where a station would be shorter than this.
constexpr double planned_error_m = 1e-8, short_half_m = 0.5;
constexpr double same_break_m = 1e-6;
constexpr double turn_sample_m = 2.0;

// What no road has, but a damaged file: time and memory would grow without bound.
constexpr double most_turn_rad = 630.0, farthest_m = 1e8, widest_m = 1000.0, most_length_m = 1e7, most_speed = 100.0;
constexpr std::size_t most_stations = 8'000'000;  // 1 GB

[[noreturn]] void unusable(const Road& road, const std::string& what) {
  throw std::runtime_error("road " + std::to_string(road.id) + " " + what);
}

float f(double v) { return static_cast<float>(v); }

/// Position, heading and rates of an element at ds, for the polynomials around it.
struct Middle {
  PlanPoint at;
  double along[5] = {1.0, 0.0, 0.0, 0.0, 0.0}, left[4] = {0.0, 0.0, 0.0, 0.0};
};

/// Taylor series of a line of curvature k + k1 u: x + i y = integral of exp(i (k u + k1 u^2 / 2)).
void expand_clothoid(double k, double k1, Middle& middle) {
  middle.along[2] = -k * k / 6.0, middle.along[3] = -k * k1 / 8.0;
  middle.along[4] = k * k * k * k / 120.0 - k1 * k1 / 40.0;
  middle.left[0] = 0.5 * k, middle.left[1] = k1 / 6.0, middle.left[2] = -k * k * k / 24.0;
  middle.left[3] = -k * k * k1 / 20.0;
}

void expand_poly(const PlanElement& e, const ParamPoly3& q, double ds, Middle& middle) {
  const PolySeries series = series_around(q, place_along(e, q, ds), middle.at.hdg - e.hdg);
  std::copy(series.along.begin(), series.along.end(), middle.along);
  std::copy(series.left.begin() + 1, series.left.end(), middle.left);
}

double spiral_rate(const PlanElement& e, const Spiral& spiral) {
  return e.length > 0.0 ? (spiral.curvature_end - spiral.curvature_start) / e.length : 0.0;
}

Middle expand(const PlanElement& e, double ds) {
  Middle middle{evaluate(e, ds)};
  if (std::holds_alternative<Arc>(e.shape)) expand_clothoid(middle.at.curvature, 0.0, middle);
  if (const auto* spiral = std::get_if<Spiral>(&e.shape))
    expand_clothoid(middle.at.curvature, spiral_rate(e, *spiral), middle);
  if (const auto* poly = std::get_if<ParamPoly3>(&e.shape)) expand_poly(e, *poly, ds, middle);
  return middle;
}

/// Half the length for which the first terms left out of the series are small enough.
double planned_half_m(const PlanElement& e, double begin, double end) {
  double k = 0.0, k1 = 0.0;
  if (const auto* arc = std::get_if<Arc>(&e.shape)) k = std::abs(arc->curvature);
  if (const auto* spiral = std::get_if<Spiral>(&e.shape)) {
    k1 = std::abs(spiral_rate(e, *spiral));
    k = std::max(std::abs(evaluate(e, begin - e.s).curvature), std::abs(evaluate(e, end - e.s).curvature));
  }
  const double rate = k * k * k * (k * k / 720.0 + k1 / 72.0) + k * k1 * k1 / 48.0 + k1 * k1 * k1 / 336.0;
  const auto half_for = [&](double error_m) { return std::pow(error_m / std::max(rate, 1e-15), 1.0 / 6.0); };
  const double half = std::max(half_for(planned_error_m), std::min(short_half_m, half_for(0.5 * baked_plan_error_m)));
  return std::clamp(half, shortest_half_m, 0.5 * longest_station_m);
}

void check_turn(const Road& road, const PlanElement& element, double begin, double end) {
  // The turn is not monotonous in a spiral through 0 or a polynomial: sum it over samples.
  const int samples = 1 + static_cast<int>((end - begin) / turn_sample_m);
  const double step = (end - begin) / samples;
  double turn = 0.0;
  for (int k = 0; k < samples; ++k)
    turn += step * std::abs(evaluate(element, begin - element.s + (k + 0.5) * step).curvature);
  if (turn > most_turn_rad) unusable(road, "turns more than 100 times round within one <geometry>");
}

/// The last item that starts at s or before, for rising s; nullptr before the first.
template <typename Item>
class Walk {
 public:
  explicit Walk(std::span<const Item> items) : items_(items) {}
  const Item* at(double s) {
    while (next_ < items_.size() && items_[next_].s <= s) ++next_;
    return next_ == 0 ? nullptr : &items_[next_ - 1];
  }

 private:
  std::span<const Item> items_;
  std::size_t next_ = 0;
};

/// Makes the stations of one road, from its start to its end.
class StationMaker {
 public:
  StationMaker(const Road& road, std::uint32_t index, BakedRoads& baked)
      : road_(road), index_(index), baked_(baked), first_stretch_(baked.stretches.size()) {
    bake_lanes(road, baked);
    rows_ = bake_shapes(road, baked);
    breaks_ = find_breaks();
  }

  void add_element(const PlanElement& element, double begin, double end) {
    check_turn(road_, element, begin, end);
    auto next = std::upper_bound(breaks_.begin(), breaks_.end(), begin + same_break_m);
    for (double from = begin; from < end;) {
      const double to = next != breaks_.end() && *next < end - same_break_m ? *next++ : end;
      const double half = planned_half_m(element, from, to);
      const int count = std::max(1, static_cast<int>(std::ceil((to - from) / (2.0 * half))));
      for (int i = 0; i < count; ++i)
        add_station(element, from + (to - from) * i / count, from + (to - from) * (i + 1) / count);
      from = to;
    }
  }

 private:
  std::vector<double> find_breaks() const {
    std::vector<double> breaks;
    for (const auto* cubics : {&road_.elevation, &road_.superelevation})
      for (const Cubic& c : *cubics) breaks.push_back(c.s);
    for (const ShapeRow& row : rows_) breaks.push_back(row.s);
    for (std::size_t i = first_stretch_; i < baked_.stretches.size(); ++i) breaks.push_back(baked_.stretches[i].s);
    std::sort(breaks.begin(), breaks.end());
    std::vector<double> apart;
    for (const double s : breaks)
      if (apart.empty() || s - apart.back() > same_break_m) apart.push_back(s);
    return apart;
  }

  void add_station(const PlanElement& element, double begin, double end) {
    const double s = 0.5 * (begin + end), half = 0.5 * (end - begin);
    const Middle middle = expand(element, s - element.s);
    Station station;
    station.x = middle.at.x, station.y = middle.at.y;
    station.cos_hdg = std::cos(middle.at.hdg), station.sin_hdg = std::sin(middle.at.hdg);
    station.speed = f(middle.along[0]);
    for (int i = 0; i < 4; ++i) station.bend[i][0] = f(middle.along[i + 1]), station.bend[i][1] = f(middle.left[i]);
    station.s = s, station.half_m = f(half);
    // Of cubics no length is planned: they are cut until they are as good as clothoids.
    const bool is_poly = std::holds_alternative<ParamPoly3>(element.shape) && half > short_half_m;
    const double most_m = is_poly ? planned_error_m : baked_plan_error_m;
    if (half > 2.0 * shortest_half_m &&
        (error_at(station, element, half) > most_m || error_at(station, element, -half) > most_m)) {
      add_station(element, begin, s);
      add_station(element, s, end);
      return;
    }
    add_profiles(station);
    add_lanes(station, half);
    baked_.stations.push_back(station);
    if (baked_.stations.size() > most_stations) unusable(road_, "and those before it bend and change too often");
  }

  /// Distance in plan from the exact line; infinite where that is not a number.
  [[nodiscard]] static double error_at(const Station& q, const PlanElement& element, double u) {
    const PlanPoint exact = evaluate(element, q.s - element.s + u);
    const LinePolynomial at = line_at(q, u);
    const double a = at.position[0], l = at.position[1];
    const double error =
        std::hypot(q.x + a * q.cos_hdg - l * q.sin_hdg - exact.x, q.y + a * q.sin_hdg + l * q.cos_hdg - exact.y);
    return std::isnan(error) ? std::numeric_limits<double>::infinity() : error;
  }

  void add_profiles(Station& station) {
    double shifted[4];
    if (const Cubic* c = elevation_.at(station.s)) {
      shift_cubic({c->a, c->b, c->c, c->d}, station.s - c->s, shifted);
      station.z = shifted[0];
      for (int i = 0; i < 3; ++i) station.profile[i][1] = f(shifted[i + 1]);
    }
    if (const Cubic* c = superelevation_.at(station.s)) {
      shift_cubic({c->a, c->b, c->c, c->d}, station.s - c->s, shifted);
      station.bank = f(shifted[0]);
      for (int i = 0; i < 3; ++i) station.profile[i][0] = f(shifted[i + 1]);
    }
    while (next_row_ < rows_.size() && rows_[next_row_].s <= station.s) ++next_row_;
    if (next_row_ == 0) return;
    station.shapes = rows_[next_row_ - 1].first & 0x3fffffffu, station.shape_count = rows_[next_row_ - 1].count;
  }

  void add_lanes(Station& station, double half) {
    while (first_stretch_ + next_stretch_ + 1 < baked_.stretches.size() &&
           baked_.stretches[first_stretch_ + next_stretch_ + 1].s <= station.s)
      ++next_stretch_;
    station.lanes = static_cast<std::uint32_t>(first_stretch_ + next_stretch_);
    double reach = 0.0;
    for (const double u : {-half, -0.5 * half, 0.0, 0.5 * half, half}) {
      const Edges edges = road_edges(road_, station.s + u);
      reach = std::max({reach, std::abs(edges.left_t), std::abs(edges.right_t)});
    }
    if (!(std::max(std::abs(station.x), std::abs(station.y)) <= farthest_m))
      unusable(road_, "leaves the area where its CRS has coordinates");
    if (std::abs(station.speed) > most_speed) unusable(road_, "has a line more than 100 times as long as it says");
    if (!(reach <= widest_m)) unusable(road_, "is wider than 1 km");
    LaneStretch& lanes = baked_.stretches[station.lanes];
    lanes.road = index_, lanes.reach_m = std::max(lanes.reach_m, f(reach));
  }

  const Road& road_;
  std::uint32_t index_;
  BakedRoads& baked_;
  std::size_t first_stretch_, next_stretch_ = 0, next_row_ = 0;
  std::vector<ShapeRow> rows_;
  std::vector<double> breaks_;
  Walk<Cubic> elevation_{road_.elevation}, superelevation_{road_.superelevation};
};

void check_finite(Station& q) {
  double sum = q.z + q.bank;
  for (const auto& pair : q.profile) sum += pair[0] + pair[1];
  for (const auto& pair : q.bend) sum += pair[0] + pair[1];
  if (!std::isfinite(sum) || !(q.speed > 0.0F)) q.shape_count = unusable_station;
}

/// How far slope and cross section move points of the station along the road.
std::uint32_t turned_by(const BakedRoads& roads, const Station& station) {
  constexpr double least_m = 1e-8, most_shape_m = 1.0;
  if (station.shape_count == unusable_station) return not_turned;
  Station q = station;
  const double half = q.half_m;
  double bank = std::abs(static_cast<double>(q.bank)), slope = 0.0, power = 1.0;
  for (int i = 0; i < 3; ++i) {
    slope += (i + 1.0) * power * std::abs(static_cast<double>(q.profile[i][1]));
    power *= half;
    bank += power * std::abs(static_cast<double>(q.profile[i][0]));
  }
  const double up_m = roads.stretches[q.lanes].reach_m * bank + (q.shape_count > 0 ? most_shape_m : 0.0);
  if (!(slope * up_m > least_m)) return not_turned;
  q.turned = near_turned;
  for (const double u : {-half, 0.0, half}) {
    const AheadRange range = ahead_range(roads, q, u);
    if (!(std::max(-range.min_m, range.max_m) <= turned_m)) return far_turned;
  }
  return near_turned;
}

}  // namespace

BakedRoads bake(const RoadMap& map) {
  BakedRoads baked;
  double length_m = 0.0;
  for (const Road& road : map.roads) {
    length_m += std::max(0.0, road.length);
    if (!(length_m <= most_length_m)) unusable(road, "and those before it are longer than 10 000 km");
  }
  std::size_t breaks = 0;
  for (const Road& road : map.roads)
    breaks += road.plan.size() + road.elevation.size() + road.superelevation.size() + road.shape.size();
  baked.stations.reserve(std::min(most_stations / 2, breaks + static_cast<std::size_t>(length_m)));
  for (std::size_t i = 0; i < map.roads.size(); ++i) {
    const Road& road = map.roads[i];
    baked.first_station.push_back(static_cast<std::uint32_t>(baked.stations.size()));
    if (road.plan.empty() || road.sections.empty() || !(road.length > 0.0)) continue;
    StationMaker maker(road, static_cast<std::uint32_t>(i), baked);
    for (std::size_t k = 0; k < road.plan.size(); ++k) {
      const double begin = std::max(road.plan[k].s, 0.0);
      const double end = std::min(k + 1 < road.plan.size() ? road.plan[k + 1].s : road.length, road.length);
      if (begin < end) maker.add_element(road.plan[k], begin, end);
    }
  }
  baked.first_station.push_back(static_cast<std::uint32_t>(baked.stations.size()));
  for (Station& station : baked.stations) {
    check_finite(station);
    LaneStretch& lanes = baked.stretches[station.lanes];
    station.turned = turned_by(baked, station) & 3u;
    lanes.length_m = map.roads[lanes.road].length;
  }

  for (std::size_t i = 0; i < map.roads.size(); ++i) {
    const std::uint32_t first = baked.first_station[i], end = baked.first_station[i + 1];
    const std::uint32_t entries = end - first;
    baked.lookup_begin_.push_back(static_cast<std::uint32_t>(baked.lookup_.size()));
    baked.lookup_per_m_.push_back(entries > 0 ? static_cast<float>(entries / map.roads[i].length) : 0.0F);
    std::uint32_t at = first;
    for (std::uint32_t k = 0; k < entries; ++k) {
      const double s = k / static_cast<double>(baked.lookup_per_m_.back());
      while (at + 1 < end && baked.stations[at].s + baked.stations[at].half_m < s) ++at;
      baked.lookup_.push_back(at);
    }
  }
  return baked;
}

std::uint32_t BakedRoads::station_at(std::size_t road, double s) const {
  const std::uint32_t first = first_station[road], end = first_station[road + 1];
  if (first == end) return no_index;
  const double entry = s * static_cast<double>(lookup_per_m_[road]);
  const double last = static_cast<double>(end - first - 1);
  std::uint32_t at =
      lookup_[lookup_begin_[road] + static_cast<std::uint32_t>(entry > 0.0 ? std::min(entry, last) : 0.0)];
  while (at + 1 < end && stations[at].s + static_cast<double>(stations[at].half_m) <= s) ++at;
  while (at > first && stations[at].s - static_cast<double>(stations[at].half_m) > s) --at;
  return at;
}

}  // namespace roadquery
