#include "orthodrive/drive/driving_line.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "orthodrive/core/error.hpp"
#include "orthodrive/geo/polyline.hpp"

namespace orthodrive {
namespace {

using roadquery::Lane;
using roadquery::Road;

constexpr double spacing_m = 1.0;
constexpr double min_route_m = 10.0;
constexpr double blend_base_m = 12.0, blend_per_jump = 12.0;
constexpr double half_car_m = 0.9;
constexpr double edge_room_m = 1.4;  // drivers keep the middle of the car so far from the edge where they can
constexpr double shortest_wave_m = 15.0;

/// Outer borders of the outermost driving lanes: sidewalks and shoulders are no room to drive in.
roadquery::Edges driving_edges(const Road& road, double s) {
  const auto& section = roadquery::section_at(road, s);
  const auto width_m = [&](const std::vector<Lane>& lanes) {
    double outer = 0.0, driven = 0.0;
    for (const Lane& lane : lanes) {
      outer += roadquery::lane_width(lane, s - section.s);
      if (lane.type == roadquery::LaneType::driving) driven = outer;
    }
    return driven;
  };
  const double offset = roadquery::evaluate(road.lane_offset, s);
  return {offset + width_m(section.left), offset - width_m(section.right)};
}

/// t of the centre of the outermost driving lane in that direction; on a narrow road nearer to its middle.
double lane_center_t(const Road& road, bool forward, double s) {
  const auto& section = roadquery::section_at(road, s);
  const bool right = forward != road.left_hand_traffic;
  double outer = 0.0, center = 0.0;
  for (const Lane& lane : right ? section.right : section.left) {
    const double width = roadquery::lane_width(lane, s - section.s);
    if (lane.type == roadquery::LaneType::driving) center = outer + 0.5 * width;
    outer += width;
  }
  const double t = roadquery::evaluate(road.lane_offset, s) + (right ? -center : center);
  const auto edges = driving_edges(road, s);
  const double middle = 0.5 * (edges.left_t + edges.right_t);
  return right ? std::max(t, std::min(edges.right_t + edge_room_m, middle))
               : std::min(t, std::max(edges.left_t - edge_room_m, middle));
}

/// A step of the route with the shift to the left (in driving direction) that makes its ends meet its neighbours.
struct Piece {
  const Road* road = nullptr;
  bool forward = true;
  double shift_begin_m = 0.0, shift_end_m = 0.0;

  [[nodiscard]] Vec2 point(double driven_m) const {
    const double s = forward ? driven_m : road->length - driven_m;
    const double t = lane_center_t(*road, forward, s) + (forward ? 1.0 : -1.0) * shift(driven_m);
    const auto p = roadquery::surface_point(*road, s, t);
    return {p.x, p.y};
  }
  /// Whether the lane centre shifted to the left by so much stays on the road with room for half a car.
  [[nodiscard]] bool has_room(double driven_m, double shift_m) const {
    const double s = forward ? driven_m : road->length - driven_m;
    const double t = lane_center_t(*road, forward, s) + (forward ? shift_m : -shift_m);
    const auto edges = driving_edges(*road, s);
    return t + half_car_m <= edges.left_t && t - half_car_m >= edges.right_t;
  }
  [[nodiscard]] Vec2 left(double driven_m) const {
    const double hdg = roadquery::reference_point(*road, forward ? driven_m : road->length - driven_m).hdg;
    const double sign = forward ? 1.0 : -1.0;
    return {-sign * std::sin(hdg), sign * std::cos(hdg)};
  }

 private:
  [[nodiscard]] double shift(double driven_m) const {
    const auto fade = [&](double shift_m, double from_end_m) {
      const double over_m = std::min(blend_base_m + blend_per_jump * std::abs(shift_m), road->length);
      const double u = over_m > 0.0 ? std::clamp(1.0 - from_end_m / over_m, 0.0, 1.0) : 0.0;
      return shift_m * u * u * (3.0 - 2.0 * u);
    };
    return fade(shift_begin_m, driven_m) + fade(shift_end_m, road->length - driven_m);
  }
};

std::vector<Piece> join_lanes(const roadquery::RoadMap& map, const Route& route) {
  std::vector<Piece> pieces;
  for (const RouteStep& step : route.steps) {
    pieces.push_back({&map.roads[static_cast<std::size_t>(step.road)], step.forward});
  }
  const std::size_t joints = route.closed ? pieces.size() : pieces.size() - 1;
  std::vector<std::pair<double, double>> shifts(joints);  // at the end of the one road, at the start of the next
  for (std::size_t i = 0; i < joints; ++i) {
    const Piece &a = pieces[i], &b = pieces[(i + 1) % pieces.size()];
    const double end_m = a.road->length;
    const double jump_m = dot(b.point(0.0) - a.point(end_m), a.left(end_m));
    const bool room_before = a.has_room(end_m, jump_m), room_after = b.has_room(0.0, -jump_m);
    const double share_before = room_before == room_after ? 0.5 : room_before ? 1.0 : 0.0;
    shifts[i] = {share_before * jump_m, (share_before - 1.0) * jump_m};
  }
  for (std::size_t i = 0; i < joints; ++i) {
    pieces[i].shift_end_m = shifts[i].first;
    pieces[(i + 1) % pieces.size()].shift_begin_m = shifts[i].second;
  }
  return pieces;
}

/// The joined lanes in steps of the same length; of a closed line the first point is not repeated.
Polyline sample(const std::vector<Piece>& pieces, bool closed) {
  Polyline raw;
  const auto add = [&](Vec2 p) {
    if (raw.empty() || distance(raw.back(), p) > 1e-3) raw.push_back(p);
  };
  for (const Piece& piece : pieces) {
    const int steps = std::max(1, static_cast<int>(std::ceil(piece.road->length / (0.5 * spacing_m))));
    for (int k = 0; k <= steps; ++k) add(piece.point(piece.road->length * k / steps));
  }
  if (closed && raw.size() > 1) add(raw.front());
  const double total_m = length_m(raw);
  if (raw.size() < 2 || total_m < min_route_m) {
    throw Error(fmt::format("the route is only {:.1f} m long, need at least {:.0f} m to drive", total_m, min_route_m));
  }
  const auto count = static_cast<std::size_t>(std::lround(total_m / spacing_m));
  const std::vector<double> s = arc_lengths_m(raw);
  Polyline line;
  std::size_t segment = 0;
  for (std::size_t i = 0; i < count + (closed ? 0 : 1); ++i) {
    const double at = total_m * static_cast<double>(i) / static_cast<double>(count);
    while (segment + 2 < raw.size() && s[segment + 1] < at) ++segment;
    const double u = (at - s[segment]) / (s[segment + 1] - s[segment]);
    line.push_back(raw[segment] * (1.0 - u) + raw[segment + 1] * u);
  }
  return line;
}

/// Solves (I + weight D'D) p = q in place, D the third difference, by Cholesky's method on the band.
void smooth_open(std::vector<Vec2>& q, double weight) {
  const std::size_t n = q.size();
  if (n < 4) return;
  constexpr std::array<double, 4> d = {-1.0, 3.0, -3.0, 1.0};
  std::vector<std::array<double, 4>> band(n);  // band[i][k]: matrix element (i, i - k)
  for (std::size_t i = 0; i < n; ++i) band[i][0] = 1.0;
  for (std::size_t row = 0; row + 3 < n; ++row) {
    for (std::size_t a = 0; a < 4; ++a) {
      for (std::size_t b = 0; b <= a; ++b) band[row + a][a - b] += weight * d[a] * d[b];
    }
  }
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = std::min<std::size_t>(3, i); k > 0; --k) {
      double sum = band[i][k];
      for (std::size_t m = k + 1; m <= std::min<std::size_t>(3, i); ++m) sum -= band[i][m] * band[i - k][m - k];
      band[i][k] = sum / band[i - k][0];
    }
    double sum = band[i][0];
    for (std::size_t m = 1; m <= std::min<std::size_t>(3, i); ++m) sum -= band[i][m] * band[i][m];
    band[i][0] = std::sqrt(sum);
    for (std::size_t m = 1; m <= std::min<std::size_t>(3, i); ++m) q[i] = q[i] - q[i - m] * band[i][m];
    q[i] = q[i] * (1.0 / band[i][0]);
  }
  for (std::size_t i = n; i-- > 0;) {
    for (std::size_t m = 1; m <= 3 && i + m < n; ++m) q[i] = q[i] - q[i + m] * band[i + m][m];
    q[i] = q[i] * (1.0 / band[i][0]);
  }
}

/// The closed line is unrolled by so much at each end that the ends no longer matter in the middle.
void smooth(Polyline& line, bool closed, double step_m) {
  const double weight = std::pow(shortest_wave_m / (2.0 * std::numbers::pi * step_m), 6.0);
  const Vec2 origin = line.front();  // small numbers: UTM coordinates would cost digits
  for (Vec2& p : line) p = p - origin;
  if (closed) {
    const auto n = static_cast<std::ptrdiff_t>(line.size());
    const auto margin = static_cast<std::ptrdiff_t>(8.0 * shortest_wave_m / step_m);
    Polyline unrolled;
    for (std::ptrdiff_t i = -margin; i < n + margin; ++i)
      unrolled.push_back(line[static_cast<std::size_t>(((i % n) + n) % n)]);
    smooth_open(unrolled, weight);
    std::copy_n(unrolled.begin() + margin, n, line.begin());
  } else {
    smooth_open(line, weight);
  }
  for (Vec2& p : line) p = p + origin;
}

/// Heading and curvature from the circle through each three points.
DrivingLine with_derivatives(const Polyline& line, bool closed) {
  const std::size_t n = line.size(), count = closed ? n + 1 : n;
  DrivingLine result{closed, std::vector<LinePoint>(count)};
  double s = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    LinePoint& out = result.points[i];
    const Vec2 p = line[i % n];
    const Vec2 before = closed ? line[(i + n - 1) % n] : line[i > 0 ? i - 1 : 0];
    const Vec2 after = closed ? line[(i + 1) % n] : line[std::min(i + 1, n - 1)];
    if (i > 0) s += distance(p, line[i - 1]);
    out.s_m = s, out.x_m = p.x, out.y_m = p.y;
    const Vec2 a = p - before, b = after - p;
    out.heading_rad = std::atan2(after.y - before.y, after.x - before.x);
    if (i > 0) {
      const double last = result.points[i - 1].heading_rad;
      out.heading_rad = last + std::remainder(out.heading_rad - last, 2.0 * std::numbers::pi);
    }
    const double product = length(a) * length(b) * distance(after, before);
    out.curvature_1pm = product > 0.0 ? 2.0 * cross(a, b) / product : 0.0;
  }
  if (!closed && n > 2) {
    result.points.front().curvature_1pm = result.points[1].curvature_1pm;
    result.points.back().curvature_1pm = result.points[n - 2].curvature_1pm;
  }
  return result;
}

/// Heights and slopes from the road query; where the line runs off the road they go on as they were.
void sample_surface(DrivingLine& line, const roadquery::RoadQuery& query, double start_z_m) {
  roadquery::Cursor cursor;
  double z = start_z_m, gradient = 0.0, banking = 0.0;
  for (LinePoint& p : line.points) {
    if (const auto hit = query.find(p.x_m, p.y_m, z, cursor)) {
      const double c = std::cos(p.heading_rad), s = std::sin(p.heading_rad);
      z = hit->z;
      gradient = -(hit->normal[0] * c + hit->normal[1] * s) / hit->normal[2];
      banking = std::atan((hit->normal[0] * s - hit->normal[1] * c) / hit->normal[2]);
    }
    p.z_m = z, p.gradient = gradient, p.banking = banking;
  }
}

}  // namespace

LinePoint DrivingLine::at(double s_m) const {
  const double total = length_m();
  double laps = 0.0;
  if (closed) {
    laps = std::floor(s_m / total);
    s_m -= laps * total;
  }
  const auto after = std::upper_bound(points.begin() + 1, points.end() - 1, s_m,
                                      [](double s, const LinePoint& p) { return s < p.s_m; });
  const LinePoint &a = *(after - 1), &b = *after;
  const double u = (s_m - a.s_m) / (b.s_m - a.s_m);
  const auto mix = [u](double p, double q) { return p + u * (q - p); };
  LinePoint p{s_m, mix(a.x_m, b.x_m), mix(a.y_m, b.y_m), mix(a.heading_rad, b.heading_rad)};
  // Beyond the ends of an open line only the position goes on.
  const double v = std::clamp(u, 0.0, 1.0);
  const auto hold = [v](double p0, double q0) { return p0 + v * (q0 - p0); };
  p.heading_rad = hold(a.heading_rad, b.heading_rad) + laps * (points.back().heading_rad - points.front().heading_rad);
  p.curvature_1pm = hold(a.curvature_1pm, b.curvature_1pm);
  p.z_m = hold(a.z_m, b.z_m), p.gradient = hold(a.gradient, b.gradient), p.banking = hold(a.banking, b.banking);
  return p;
}

DrivingLine make_driving_line(const roadquery::RoadQuery& query, const Route& route) {
  const std::vector<Piece> pieces = join_lanes(query.map(), route);
  Polyline points = sample(pieces, route.closed);
  smooth(points, route.closed, spacing_m);
  DrivingLine line = with_derivatives(points, route.closed);
  const Piece& first = pieces.front();
  sample_surface(line, query, roadquery::elevation(*first.road, first.forward ? 0.0 : first.road->length));
  return line;
}

}  // namespace orthodrive
