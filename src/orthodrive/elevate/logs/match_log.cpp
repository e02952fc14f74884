// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/elevate/logs/match_log.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "orthodrive/elevate/logs/ways_on_roads.hpp"
#include "orthodrive/geo/angle.hpp"
#include "orthodrive/geo/segment.hpp"
#include "orthodrive/geo/spatial_index.hpp"

namespace orthodrive {

using namespace elevate;

/// The roads, prepared for many recordings.
struct LogMatcher::Roads {
  SegmentIndex segments;
  WaysOnRoads ways;
};

namespace {

constexpr double keyframe_m = 10.0;        // between matched poses; the others are placed on the way between them
constexpr double lateral_sigma_m = 2.5;    // of a car beside the centre line: lanes, and the error of the line itself
constexpr double heading_sigma_rad = 0.3;  // of the direction of travel to that of the road
constexpr double mean_detour_m = 3.0;   // beta of eq. 2: mean difference between the way on roads and the straight line
constexpr double no_road_sigmas = 3.5;  // beyond this many standard deviations "on no road" is more probable
constexpr double unmatched_finding_m = 50.0;  // a stretch without road of this length is reported
constexpr double slowest_heading_mps = 1.5;   // below, positions give no direction of travel
constexpr double longest_detour_m = 40.0;     // a way on roads may be longer than the straight line by so much
constexpr double leave_road_log = -6.0;  // ln of the probability to leave roads, or to come back, between two poses
constexpr double impossible = -1e300;

/// A state of the hidden Markov model.
struct Candidate {
  DirectedPlace place;
  double log_emission = 0.0;
};

/// A pose that is matched; the last state, after all candidates, is "on no road".
struct Keyframe {
  std::size_t pose = 0;
  std::vector<Candidate> candidates;
};

std::vector<Polyline> lines_of(const RoadNetwork& roads) {
  std::vector<Polyline> lines;
  lines.reserve(roads.paths.size());
  for (const RoadPath& path : roads.paths) lines.push_back(centerline(path));
  return lines;
}

std::vector<Keyframe> choose_keyframes(const std::vector<DrivePose>& poses) {
  std::vector<Keyframe> frames{{0, {}}};
  for (std::size_t i = 1; i < poses.size(); ++i)
    if (distance(poses[i].p, poses[frames.back().pose].p) >= keyframe_m) frames.push_back({i, {}});
  if (frames.size() > 1 && frames.back().pose + 1 < poses.size()) frames.back().pose = poses.size() - 1;
  return frames;
}

/// Direction of travel at a pose: that of the movement around it where it is long and fast enough, because a car may
/// reverse; else the attitude's heading, which needs no speed.
double travel_heading(const std::vector<DrivePose>& poses, std::size_t i, double slowest_mps) {
  constexpr double chord_m = 5.0;  // long enough for the scatter of positions
  std::size_t a = i, b = i;
  while (a > 0 && distance(poses[a].p, poses[i].p) < chord_m) --a;
  while (b + 1 < poses.size() && distance(poses[b].p, poses[i].p) < chord_m) ++b;
  const double run_m = distance(poses[a].p, poses[b].p), time_s = poses[b].time_s - poses[a].time_s;
  if (run_m >= chord_m && run_m >= slowest_mps * time_s) {
    const Vec2 d = poses[b].p - poses[a].p;
    return std::atan2(d.y, d.x);
  }
  return poses[i].heading_rad;
}

/// The place on a road nearest to a pose.
struct NearestPlace {
  DirectedPlace place;
  double distance_m = std::numeric_limits<double>::infinity(), road_heading = 0.0;
};

/// On segments of one path that follow each other.
NearestPlace nearest_on(const RoadNetwork& roads, std::span<const SegmentIndex::Segment> segments, Vec2 p) {
  NearestPlace nearest;
  for (const auto [line, index] : segments) {
    const RoadNode &from = roads.paths[line].nodes[index], &to = roads.paths[line].nodes[index + 1];
    const Vec2 d = to.p - from.p;
    if (!(dot(d, d) > 0.0)) continue;
    const double f = share_along(from.p, to.p, p);
    const double distance_m = distance(p, from.p + d * f);
    if (distance_m >= nearest.distance_m) continue;
    nearest = {
        {line, from.s_m + f * (to.s_m - from.s_m), cross(d, p - from.p) / length(d)}, distance_m, std::atan2(d.y, d.x)};
  }
  return nearest;
}

/// The place on a path nearest to p among the parts between two s.
LogPlace project_between(const RoadPath& path, double s_low, double s_high, Vec2 p, double& distance_m) {
  const auto& nodes = path.nodes;
  auto at = std::upper_bound(nodes.begin(), nodes.end(), s_low, [](double s, const RoadNode& n) { return s < n.s_m; });
  std::size_t i = at == nodes.begin() ? 0 : static_cast<std::size_t>(at - nodes.begin()) - 1;
  LogPlace best;
  distance_m = std::numeric_limits<double>::infinity();
  for (; i + 1 < nodes.size() && (nodes[i].s_m <= s_high || distance_m == std::numeric_limits<double>::infinity());
       ++i) {
    const RoadNode &a = nodes[i], &b = nodes[i + 1];
    const double run = b.s_m - a.s_m;
    if (!(run > 0.0)) continue;
    const Vec2 d = b.p - a.p;
    const double n2 = std::max(1e-12, dot(d, d));
    const double low = std::clamp((s_low - a.s_m) / run, 0.0, 1.0), high = std::clamp((s_high - a.s_m) / run, low, 1.0);
    const double f = std::clamp(dot(p - a.p, d) / n2, low, high);
    const double far = distance(p, a.p + d * f);
    if (far < distance_m) {
      distance_m = far;
      best.s_m = a.s_m + f * run, best.offset_m = cross(d, p - a.p) / std::sqrt(n2);
    }
  }
  return best;
}

/// The matching of one recording, in its steps.
class Matching {
 public:
  Matching(const RoadNetwork& roads, const SegmentIndex& segments, const WaysOnRoads& ways,
           const std::vector<DrivePose>& poses)
      : roads_(roads),
        segments_(segments),
        ways_(ways),
        poses_(poses),
        no_road_log_(-0.5 * no_road_sigmas * no_road_sigmas),
        frames_(choose_keyframes(poses)) {}

  /// Emissions: eq. 1 of the paper times a normal distribution of the heading.
  void find_candidates() {
    for (Keyframe& frame : frames_) {
      const DrivePose& pose = poses_[frame.pose];
      const double sigma_m = std::hypot(pose.sigma_p_m, lateral_sigma_m);
      const double reach_m = (no_road_sigmas + 1.0) * sigma_m;
      const double heading = travel_heading(poses_, frame.pose, slowest_heading_mps);
      const auto near = segments_.near(pose.p, reach_m);
      for (std::size_t a = 0, b = 0; a < near.size(); a = b) {  // the nearest place of every run of segments in a row
        while (b < near.size() && near[b].line == near[a].line && near[b].index - near[a].index == b - a) ++b;
        const NearestPlace nearest = nearest_on(roads_, std::span(near).subspan(a, b - a), pose.p);
        if (nearest.distance_m < reach_m) add_candidates(nearest, sigma_m, heading, frame);
      }
    }
  }

  /// The most probable sequence of states (Viterbi). Transitions: eq. 2 of the paper.
  void find_states() {
    std::vector<std::vector<double>> score(frames_.size());
    std::vector<std::vector<std::size_t>> came_from(frames_.size());
    for (std::size_t k = 0; k < frames_.size(); ++k) {
      const auto& now = frames_[k].candidates;
      score[k].assign(now.size() + 1, k == 0 ? 0.0 : impossible);
      came_from[k].assign(now.size() + 1, 0);
      if (k > 0) add_transitions(k, score[k - 1], score[k], came_from[k]);
      for (std::size_t c = 0; c < now.size(); ++c) score[k][c] += now[c].log_emission;
      score[k][now.size()] += no_road_log_;
    }
    states_.resize(frames_.size());
    states_.back() =
        static_cast<std::size_t>(std::max_element(score.back().begin(), score.back().end()) - score.back().begin());
    for (std::size_t k = frames_.size() - 1; k > 0; --k) states_[k - 1] = came_from[k][states_[k]];
  }

  /// Poses between two matched ones lie on the way between them.
  void place_poses(MatchLogResult& result) const {
    for (std::size_t k = 0; k < frames_.size(); ++k) {
      if (on_road(k)) {
        const DirectedPlace& at = place(k);
        result.places[frames_[k].pose] = LogPlace{at.path, at.s_m, at.offset_m, at.forward};
      }
      if (k == 0) continue;
      const double run_m = run_before_m(k);
      result.length_m += run_m;
      if (!on_road(k - 1) || !on_road(k)) continue;
      result.matched_m += run_m;
      const auto way = ways_.stretches(place(k - 1), place(k), reach_between(k, place(k - 1)));
      for (std::size_t i = frames_[k - 1].pose + 1; i < frames_[k].pose; ++i)
        result.places[i] = place_on(way, poses_[i].p, place(k).forward);
    }
  }

  /// What is on no road, stretch by stretch.
  void report(const std::string& name, MatchLogResult& result) const {
    const auto add = [&](Severity severity, const char* code, double run_m, std::size_t pose) {
      const Vec2 p = poses_[pose].p;
      result.findings.push_back(
          {severity, code, fmt::format("{}: {:.0f} m from {:.2f} s on match no road", name, run_m, poses_[pose].time_s),
           p.x, p.y});
    };
    if (std::none_of(result.places.begin(), result.places.end(), [](const auto& at) { return at.has_value(); })) {
      add(Severity::warning, "drive_log.no_match", result.length_m, 0);
      return;
    }
    for (std::size_t k = 1; k < frames_.size();) {
      if (on_road(k) && on_road(k - 1)) {
        ++k;
        continue;
      }
      const std::size_t first = k - 1;
      double run_m = 0.0;
      for (; k < frames_.size() && !(on_road(k) && on_road(k - 1)); ++k) run_m += run_before_m(k);
      if (run_m >= unmatched_finding_m) add(Severity::info, "drive_log.unmatched", run_m, frames_[first].pose);
    }
  }

 private:
  void add_candidates(const NearestPlace& nearest, double sigma_m, double heading, Keyframe& frame) const {
    Candidate candidate{.place = nearest.place};
    for (const bool forward : {true, false}) {
      if (!forward && roads_.paths[nearest.place.path].oneway != Oneway::no) continue;
      candidate.place.forward = forward;
      const double turn =
          std::isnan(heading) ? 0.0 : wrapped_angle(heading - nearest.road_heading - (forward ? 0.0 : M_PI));
      candidate.log_emission =
          -0.5 * (std::pow(nearest.distance_m / sigma_m, 2) + std::pow(turn / heading_sigma_rad, 2));
      if (candidate.log_emission > 2.0 * no_road_log_) frame.candidates.push_back(candidate);
    }
  }

  void add_transitions(std::size_t k, const std::vector<double>& score_before, std::vector<double>& score,
                       std::vector<std::size_t>& came_from) const {
    const auto &before = frames_[k - 1].candidates, &now = frames_[k].candidates;
    const double straight_m = run_before_m(k);
    const auto offer = [&](std::size_t b, std::size_t c, double log_transition) {
      const double total = score_before[b] + log_transition;
      if (total > score[c]) score[c] = total, came_from[c] = b;
    };
    for (std::size_t b = 0; b < before.size(); ++b) {
      const WaysOnRoads::Reach reach = now.empty() ? WaysOnRoads::Reach{} : reach_between(k, before[b].place);
      for (std::size_t c = 0; c < now.size(); ++c) {
        const double detour_m = std::abs(ways_.way_m(before[b].place, now[c].place, reach) - straight_m);
        if (detour_m <= longest_detour_m) offer(b, c, -detour_m / mean_detour_m);
      }
      offer(b, now.size(), leave_road_log);
    }
    for (std::size_t c = 0; c < now.size(); ++c) offer(before.size(), c, leave_road_log);
    offer(before.size(), now.size(), 0.0);
  }

  /// The nearest place on a way; its last stretch is driven as its end is.
  [[nodiscard]] std::optional<LogPlace> place_on(const std::vector<DrivenStretch>& way, Vec2 p,
                                                 bool forward_at_end) const {
    std::optional<LogPlace> nearest;
    double nearest_m = std::numeric_limits<double>::infinity();
    for (const DrivenStretch& stretch : way) {
      double far_m = 0.0;
      LogPlace place = project_between(roads_.paths[stretch.path], std::min(stretch.s_from, stretch.s_to),
                                       std::max(stretch.s_from, stretch.s_to), p, far_m);
      if (far_m >= nearest_m) continue;
      nearest_m = far_m;
      place.path = stretch.path;
      const bool as_end = way.size() == 1 || stretch.s_from == stretch.s_to;
      place.forward = as_end ? forward_at_end : stretch.s_to > stretch.s_from;
      nearest = place;
    }
    return nearest;
  }

  [[nodiscard]] double run_before_m(std::size_t k) const {
    return distance(poses_[frames_[k - 1].pose].p, poses_[frames_[k].pose].p);
  }
  [[nodiscard]] WaysOnRoads::Reach reach_between(std::size_t k, const DirectedPlace& before) const {
    return ways_.reach_from(before, run_before_m(k) + longest_detour_m);
  }
  [[nodiscard]] bool on_road(std::size_t k) const { return states_[k] < frames_[k].candidates.size(); }
  [[nodiscard]] const DirectedPlace& place(std::size_t k) const { return frames_[k].candidates[states_[k]].place; }

  const RoadNetwork& roads_;
  const SegmentIndex& segments_;
  const WaysOnRoads& ways_;
  const std::vector<DrivePose>& poses_;
  double no_road_log_;
  std::vector<Keyframe> frames_;
  std::vector<std::size_t> states_;  // [keyframe]
};

}  // namespace

LogMatcher::LogMatcher(const RoadNetwork& roads)
    : network_(roads), roads_(std::make_unique<Roads>(SegmentIndex(lines_of(roads)), WaysOnRoads(roads))) {}
LogMatcher::~LogMatcher() = default;

MatchLogResult LogMatcher::match(const DriveRecording& recording, const std::string& name) const {
  MatchLogResult result;
  result.places.resize(recording.poses.size());
  if (recording.poses.empty()) return result;
  Matching matching(network_, roads_->segments, roads_->ways, recording.poses);
  matching.find_candidates();
  matching.find_states();
  matching.place_poses(result);
  matching.report(name, result);
  return result;
}

}  // namespace orthodrive
