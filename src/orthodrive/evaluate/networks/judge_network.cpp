// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/evaluate/networks/judge_network.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <tuple>

#include "orthodrive/evaluate/networks/track_samples.hpp"
#include "orthodrive/geo/angle.hpp"

namespace orthodrive {
namespace {

using evaluate::AxleSample;
using evaluate::LanePiece;
using evaluate::LanePlace;
using evaluate::PathPoint;
namespace judged = evaluate::judged;

constexpr std::array kind_names{"hole",           "step",       "vertical_acceleration",
                                "twist",          "gap",        "heading_jump",
                                "curvature_jump", "width_jump", "grip_jump"};
constexpr std::array fault_limits{0.0, 0.010, 5.0, 0.05, 0.05, 0.02, 1.0, 0.12, 2.0};  // in the units of FaultKind
constexpr double window_m = 12.0;     // of a path through a link, to each side
constexpr double edge_inset_m = 0.1;  // of the lines along which holes are looked for at a link
constexpr double near_joint_m = 1.0;  // how far from the joint those reach
constexpr double one_place_m = 5.0;   // faults of a kind nearer than this are one place
// Natural frequency of the body on its springs: the golden car's sqrt(63.3) rad/s (Sayers 1995, On the calculation of
// International Roughness Index from longitudinal road profile, table 1). A change of gradient at speed v gives the
// body v dg for an initial velocity and so at most v dg omega.
constexpr double body_frequency_radps = 7.96;

/// What one lane has to say.
struct Report {
  std::array<double, fault_kinds> worst{};
  std::vector<Fault> faults;
  double track_length_m = 0.0;
};
template <typename Archive>
void fields(Archive& archive, Report& report) {
  archive(report.worst, report.faults, report.track_length_m);
}

class Judge {
 public:
  explicit Judge(const roadquery::RoadQuery& query) : query_(query) {}

  Report lane(const LanePiece& piece, const std::vector<LanePiece>& pieces) {
    std::vector<PathPoint> path;
    evaluate::append_places(piece, 0.0, piece.length(), judged::step_m, path);
    report_.track_length_m += 2.0 * piece.length();
    judge_path(path);
    judge_plan(piece);
    for (const std::size_t next : piece.next) link(piece, pieces[next], pieces);
    return std::move(report_);
  }

 private:
  void add(FaultKind kind, double value, const PathPoint& at, double x, double y) {
    const double limit = driving_limit(kind);
    double& worst = report_.worst[static_cast<std::size_t>(kind)];
    worst = std::max(worst, value);
    if (!(value <= limit))
      report_.faults.push_back({kind, value, limit, x, y, at.piece->road->id, at.piece->lane->id, at.s});
  }

  void judge_path(const std::vector<PathPoint>& path) {
    for (const std::vector<AxleSample>& run : evaluate::sample_axles(query_, path)) {
      judge_wheels(run);
      judge_body(run);
    }
  }

  void judge_wheels(const std::vector<AxleSample>& run) {
    for (std::size_t i = 0; i < run.size(); ++i) {
      for (std::size_t wheel = 0; wheel < 2; ++wheel) {
        const evaluate::WheelSample& here = run[i].wheels[wheel];
        if (!here.on_road) {
          add(FaultKind::hole, hole_length_m(run, i, wheel), run[i].at, here.x, here.y);
        } else if (i > 0 && run[i - 1].wheels[wheel].on_road) {
          add(FaultKind::step, step_m(run, i, wheel), run[i].at, here.x, here.y);
          add_grip(here.friction, run[i - 1].wheels[wheel].friction, run[i]);
        }
      }
      if (run[i].on_road()) add_grip(run[i].wheels[0].friction, run[i].wheels[1].friction, run[i]);
      if (i > 1 && i + 1 < run.size() && run[i - 2].at.piece == run[i + 1].at.piece)
        add(FaultKind::heading_jump, heading_jump_rad(run, i), run[i].at, run[i].wheels[0].x, run[i].wheels[0].y);
    }
  }

  /// How far the turn to sample i leaves what the turns before and after it explain: a bend is no jump.
  static double heading_jump_rad(const std::vector<AxleSample>& run, std::size_t i) {
    const auto turn = [&](std::size_t k) { return wrapped_angle(run[k].heading_rad - run[k - 1].heading_rad); };
    return outside(turn(i), turn(i - 1), turn(i + 1));
  }
  /// 0 between the two neighbours.
  static double outside(double value, double a, double b) {
    return std::max({std::min(a, b) - value, value - std::max(a, b), 0.0});
  }

  static double hole_length_m(const std::vector<AxleSample>& run, std::size_t i, std::size_t wheel) {
    std::size_t first = i, last = i;
    while (first > 0 && !run[first - 1].wheels[wheel].on_road) --first;
    while (last + 1 < run.size() && !run[last + 1].wheels[wheel].on_road) ++last;
    return std::max(run[last].driven_m - run[first].driven_m, 1e-3);
  }

  /// How far the rise from sample i - 1 to i, or to i + 1, leaves what the slopes before and after it explain: a ramp
  /// is no step. The rise over two samples counts because a sample on the joint itself is the mean of both sides.
  static double step_m(const std::vector<AxleSample>& run, std::size_t i, std::size_t wheel) {
    const auto known = [&](std::size_t from, std::size_t to) {
      for (std::size_t k = from; k <= to; ++k)
        if (!run[k].wheels[wheel].on_road) return false;
      return true;
    };
    const auto slope = [&](std::size_t from, std::size_t to) {
      return (run[to].wheels[wheel].z - run[from].wheels[wheel].z) /
             std::max(run[to].driven_m - run[from].driven_m, 0.02);
    };
    double step = 0.0;
    for (const std::size_t to : {i, i + 1}) {
      if (i < 2 || to + 1 >= run.size() || !known(i - 2, to + 1)) break;
      step = std::max(step, outside(slope(i - 1, to), slope(i - 2, i - 1), slope(to, to + 1)) *
                                (run[to].driven_m - run[i - 1].driven_m));
    }
    return step;
  }

  void add_grip(double a, double b, const AxleSample& axle) {
    const double ratio = std::min(a, b) > 0.0 ? std::max(a, b) / std::min(a, b) : std::max(a, b) > 0.0 ? 1e9 : 1.0;
    add(FaultKind::grip_jump, ratio, axle.at, axle.wheels[0].x, axle.wheels[0].y);
  }

  /// By how much the four wheels of a car leave a plane, over the track: on a straight road the change of the slope
  /// across within a wheelbase. A car is a rectangle and stands along the chord of a bend: on a plane it is not
  /// twisted, however it turns there. NaN where a wheel would stand beside the road.
  double twist(const AxleSample& rear, const AxleSample& front) const {
    constexpr double straight_rad = 0.05;
    if (std::abs(wrapped_angle(front.heading_rad - rear.heading_rad)) < straight_rad) return front.roll() - rear.roll();
    const auto middle = [](const AxleSample& axle) {
      return std::pair{0.5 * (axle.wheels[0].x + axle.wheels[1].x), 0.5 * (axle.wheels[0].y + axle.wheels[1].y)};
    };
    const auto [x0, y0] = middle(rear);
    const auto [x1, y1] = middle(front);
    const double chord = std::hypot(x1 - x0, y1 - y0);
    if (chord < 0.5 * judged::wheelbase_m) return NAN;  // sharper than any car turns
    const double track = std::min(rear.track_m, front.track_m);
    const double left_x = -(y1 - y0) / chord * 0.5 * track, left_y = (x1 - x0) / chord * 0.5 * track;
    const auto across = [&](const AxleSample& axle, double x, double y) {
      roadquery::Cursor cursor;
      const auto left = query_.find(x + left_x, y + left_y, axle.wheels[0].z, cursor);
      const auto right = query_.find(x - left_x, y - left_y, axle.wheels[1].z, cursor);
      return left && right ? left->z - right->z : NAN;
    };
    return (across(front, x1, y1) - across(rear, x0, y0)) / track;
  }

  /// Vertical acceleration of the body and twist between the axles.
  void judge_body(const std::vector<AxleSample>& run) {
    const double base_m = judged::wheelbase_m - 0.5 * judged::step_m;
    std::size_t ahead_axle = 0;  // in bends lanes are longer or shorter than the line along which samples are even
    for (std::size_t i = 0; i < run.size(); ++i) {
      while (ahead_axle < run.size() && run[ahead_axle].driven_m - run[i].driven_m < base_m) ++ahead_axle;
      const auto middle = [&](const AxleSample& axle) {
        return std::pair{0.5 * (axle.wheels[0].x + axle.wheels[1].x), 0.5 * (axle.wheels[0].y + axle.wheels[1].y)};
      };
      const auto [x, y] = middle(run[i]);
      if (ahead_axle < run.size() && run[i].on_road() && run[ahead_axle].on_road())
        if (const double value = std::abs(twist(run[i], run[ahead_axle])); !std::isnan(value))
          add(FaultKind::twist, value, run[i].at, x, y);
      const double arm_m = std::max(judged::wheelbase_m, run[i].speed_mps / body_frequency_radps);
      const auto arm = static_cast<std::size_t>(std::lround(arm_m / judged::step_m));
      if (i < arm || i + arm >= run.size()) continue;
      const AxleSample &back = run[i - arm], &front = run[i + arm];
      if (!run[i].on_road() || !back.on_road() || !front.on_road()) continue;
      const double speed = std::min({run[i].speed_mps, back.speed_mps, front.speed_mps});
      const double behind = run[i].driven_m - back.driven_m, ahead = front.driven_m - run[i].driven_m;
      const double bend =
          ((front.z() - run[i].z()) / ahead - (run[i].z() - back.z()) / behind) / (0.5 * (ahead + behind));
      add(FaultKind::vertical_acceleration, speed * speed * std::abs(bend), run[i].at, x, y);
    }
  }

  static double curvature_jump_mps2(double before, double after, double legal_mps) {
    const double most = std::max(std::abs(before), std::abs(after));
    if (most < 1e-9) return 0.0;
    const double legal = legal_mps > 0.0 ? legal_mps : judged::unlimited_speed_mps;
    return std::min(legal * legal, judged::lateral_mps2 / most) * std::abs(after - before);
  }

  /// Where elements of the reference line meet within the piece.
  void judge_plan(const LanePiece& piece) {
    const roadquery::Road& road = *piece.road;
    if (road.junction >= 0) return;
    for (std::size_t i = 0; i + 1 < road.plan.size(); ++i) {
      const double s = road.plan[i + 1].s;
      if (s < piece.s_begin || s > piece.s_end) continue;
      const double before = roadquery::evaluate(road.plan[i], road.plan[i].length).curvature;
      const double after = roadquery::evaluate(road.plan[i + 1], 0.0).curvature;
      const PathPoint at{&piece, s};
      const roadquery::SurfacePoint p = evaluate::lane_point(at, 0.0);
      add(FaultKind::curvature_jump, curvature_jump_mps2(before, after, road.speed_limit_mps), at, p.x, p.y);
    }
  }

  void link(const LanePiece& from, const LanePiece& to, const std::vector<LanePiece>& pieces) {
    std::vector<PathPoint> path;
    const double tail = std::min(window_m, from.length()), head = std::min(window_m, to.length());
    evaluate::append_places(from, from.length() - tail, from.length(), judged::step_m, path);
    evaluate::append_places(to, 0.0, head, judged::step_m, path);
    if (head < window_m && !to.next.empty()) {
      const LanePiece& third = pieces[to.next.front()];
      evaluate::append_places(third, 0.0, std::min(window_m - head, third.length()), judged::step_m, path);
    }
    judge_path(path);
    judge_joint(from, to);
  }

  void judge_joint(const LanePiece& from, const LanePiece& to) {
    const PathPoint end{&from, from.s_at(from.length())}, start{&to, to.s_at(0.0)};
    const LanePlace a = lane_place(from, end.s), b = lane_place(to, start.s);
    const roadquery::SurfacePoint p = evaluate::lane_point(end, 0.0), q = evaluate::lane_point(start, 0.0);
    add(FaultKind::width_jump, std::abs(a.width_m - b.width_m), end, p.x, p.y);
    if (std::min(a.width_m, b.width_m) < judged::least_lane_m) return;  // opens or ends here: nobody drives it
    add(FaultKind::gap, std::hypot(p.x - q.x, p.y - q.y), end, p.x, p.y);
    add(FaultKind::heading_jump, std::abs(wrapped_angle(a.heading_rad - b.heading_rad)), end, p.x, p.y);
    if (from.road->junction < 0 && to.road->junction < 0)
      add(FaultKind::curvature_jump,
          curvature_jump_mps2(a.curvature, b.curvature, std::max(from.road->speed_limit_mps, to.road->speed_limit_mps)),
          end, p.x, p.y);
    find_wedges(end, start, std::min(a.width_m, b.width_m));
  }

  /// Holes along the edges of the lane near a joint, and between its two ends.
  void find_wedges(const PathPoint& end, const PathPoint& start, double width_m) {
    const double edge = 0.5 * width_m - edge_inset_m;
    for (const double left : {edge, -edge}) {
      roadquery::SurfacePoint before = evaluate::lane_point(end, left);
      const roadquery::SurfacePoint after = evaluate::lane_point(start, left);
      const double wedge = std::hypot(after.x - before.x, after.y - before.y);
      const int steps = std::max(1, static_cast<int>(std::ceil(wedge / (0.25 * judged::step_m))));
      for (int i = 0; i <= steps; ++i) {
        const double share = static_cast<double>(i) / steps;
        look_for_road(end, before.x + share * (after.x - before.x), before.y + share * (after.y - before.y), before.z,
                      wedge);
      }
      for (double away = judged::step_m; away < near_joint_m; away += judged::step_m) {
        if (away < end.piece->length()) {
          const PathPoint at{end.piece, end.piece->s_at(end.piece->length() - away)};
          const roadquery::SurfacePoint p = evaluate::lane_point(at, left);
          look_for_road(at, p.x, p.y, p.z, judged::step_m);
        }
        if (away < start.piece->length()) {
          const PathPoint at{start.piece, start.piece->s_at(away)};
          const roadquery::SurfacePoint p = evaluate::lane_point(at, left);
          look_for_road(at, p.x, p.y, p.z, judged::step_m);
        }
      }
    }
  }
  void look_for_road(const PathPoint& at, double x, double y, double z, double size_m) {
    roadquery::Cursor cursor;
    if (!query_.find(x, y, z, cursor)) add(FaultKind::hole, std::max(size_m, 1e-3), at, x, y);
  }

  const roadquery::RoadQuery& query_;
  Report report_;
};

/// Of all faults of a kind within 5 m of each other the worst, worst first; equal ones by place.
std::vector<Fault> worst_of_places(std::vector<Fault> faults) {
  std::stable_sort(faults.begin(), faults.end(), [](const Fault& a, const Fault& b) {
    return std::tuple(a.kind, -a.value, a.x, a.y, a.road, a.lane, a.s) <
           std::tuple(b.kind, -b.value, b.x, b.y, b.road, b.lane, b.s);
  });
  using Cell = std::tuple<FaultKind, long, long>;
  std::map<Cell, std::vector<const Fault*>> kept_in;
  std::vector<Fault> kept;
  for (const Fault& fault : faults) {
    const long column = std::lround(std::floor(fault.x / one_place_m)),
               row = std::lround(std::floor(fault.y / one_place_m));
    bool again = false;
    for (long c = column - 1; c <= column + 1 && !again; ++c)
      for (long r = row - 1; r <= row + 1 && !again; ++r)
        if (const auto cell = kept_in.find({fault.kind, c, r}); cell != kept_in.end())
          again = std::any_of(cell->second.begin(), cell->second.end(), [&](const Fault* other) {
            return std::hypot(other->x - fault.x, other->y - fault.y) < one_place_m;
          });
    if (again) continue;
    kept_in[{fault.kind, column, row}].push_back(&fault);
    kept.push_back(fault);
  }
  return kept;
}

}  // namespace

const char* to_string(FaultKind kind) { return kind_names.at(static_cast<std::size_t>(kind)); }

double driving_limit(FaultKind kind) { return fault_limits.at(static_cast<std::size_t>(kind)); }

NetworkVerdict judge_network(const roadquery::RoadMap& map, const JudgeNetworkOptions& options, Monitor* monitor) {
  NetworkVerdict verdict;
  const roadquery::RoadsById by_id(map);
  const std::vector<LanePiece> pieces = evaluate::lane_pieces(map, by_id);
  const roadquery::RoadQuery query(map);
  std::vector<Report> reports(pieces.size());
  shared_for(
      options.exchange, "judge", pieces.size(), options.threads,
      [&](std::size_t i) { reports[i] = Judge(query).lane(pieces[i], pieces); },
      [&](auto& archive, std::size_t i) { archive(reports[i]); },
      [&](std::size_t done) {
        if (monitor) monitor->progress(static_cast<double>(done) / static_cast<double>(pieces.size()), "judge");
      });
  std::vector<Fault> faults;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    verdict.links += pieces[i].next.size();
    verdict.track_length_m += reports[i].track_length_m;
    for (std::size_t k = 0; k < fault_kinds; ++k) verdict.worst[k] = std::max(verdict.worst[k], reports[i].worst[k]);
    faults.insert(faults.end(), reports[i].faults.begin(), reports[i].faults.end());
  }
  verdict.lanes = pieces.size();
  verdict.faults = worst_of_places(std::move(faults));
  for (const Fault& fault : verdict.faults) ++verdict.places[static_cast<std::size_t>(fault.kind)];
  return verdict;
}

}  // namespace orthodrive
