// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/elevate/profiles/control_heights.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "orthodrive/geo/segment.hpp"
#include "orthodrive/geo/spatial_index.hpp"
#include "orthodrive/model/roads/osm_node_id.hpp"

namespace orthodrive::elevate {
namespace {

constexpr double beside_road_m = 2.0;       // of the carriageway's edge: the precision of roads from photos
constexpr double least_half_width_m = 1.5;  // roads without a width
constexpr double of_crossing_m = 20.0;      // a deck is as wide
constexpr double no_meeting_m = 50.0;       // roads on two levels do not meet as near (grade_separations)

struct Candidate {
  RoadPlace place;
  double distance_m = 0.0;
};

std::string name_of(const HeightControlPoint& point) {
  std::string name = std::isnan(point.z_m) ? fmt::format("control point of {:.2f} m clearance", point.clearance_m)
                                           : fmt::format("control point of {:.2f} m", point.z_m);
  if (point.osm_id != 0) name += fmt::format(" on way {}", point.osm_id);
  if (point.layer) name += fmt::format(" on layer {}", *point.layer);
  return name;
}

void report(Findings& findings, Severity severity, const char* code, Vec2 p, std::string message) {
  findings.push_back({severity, code, std::move(message), p.x, p.y});
}

bool is_meant(const HeightControlPoint& point, const RoadPath& path) {
  return (point.osm_id == 0 || point.osm_id == path.osm_id) && (!point.layer || *point.layer == path.layer);
}

/// The nearest place of each way that the point can be of, nearest way first.
std::vector<Candidate> candidates_of(const RoadNetwork& roads, const SegmentIndex& index, double reach_m,
                                     const HeightControlPoint& point) {
  std::vector<Candidate> found;
  for (const SegmentIndex::Segment& segment : index.near(point.p, reach_m)) {
    const RoadPath& path = roads.paths[segment.line];
    if (!is_meant(point, path)) continue;
    const RoadNode &a = path.nodes[segment.index], &b = path.nodes[segment.index + 1];
    const double f = share_along(a.p, b.p, point.p);
    const double distance_m = distance(a.p + (b.p - a.p) * f, point.p);
    if (distance_m > std::max(least_half_width_m, 0.5 * a.width_m) + beside_road_m) continue;
    const Candidate candidate{{segment.line, segment.index, f}, distance_m};
    const auto same = std::find_if(found.begin(), found.end(),
                                   [&](const Candidate& other) { return other.place.path == segment.line; });
    if (same == found.end())
      found.push_back(candidate);
    else if (distance_m < same->distance_m)
      *same = candidate;
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const Candidate& a, const Candidate& b) { return a.distance_m < b.distance_m; });
  return found;
}

/// Roads that meet near the point have one height there, whatever their layers.
bool meet_near(const RoadPath& a, const RoadPath& b, Vec2 p) {
  for (const RoadNode& node : a.nodes)
    if (is_osm_node(node.osm_node) && distance(node.p, p) < no_meeting_m)
      for (const RoadNode& other : b.nodes)
        if (other.osm_node == node.osm_node) return true;
  return false;
}

bool are_two_levels(const RoadNetwork& roads, const std::vector<GradeSeparation>& levels, const Candidate& a,
                    const Candidate& b, Vec2 p) {
  const std::size_t i = a.place.path, k = b.place.path;
  if (meet_near(roads.paths[i], roads.paths[k], p)) return false;
  if (roads.paths[i].layer != roads.paths[k].layer) return true;
  return std::any_of(levels.begin(), levels.end(), [&](const GradeSeparation& level) {
    const bool is_pair = std::minmax(level.crossing.path_a, level.crossing.path_b) == std::minmax(i, k);
    return is_pair && distance(level.crossing.p, p) < no_meeting_m;
  });
}

std::optional<RoadPlace> match_height(const RoadNetwork& roads, const SegmentIndex& index, double reach_m,
                                      const std::vector<GradeSeparation>& levels, const HeightControlPoint& point,
                                      Findings& findings) {
  const std::vector<Candidate> found = candidates_of(roads, index, reach_m, point);
  if (found.empty()) {
    report(findings, Severity::warning, "elevate.control_point_off_road", point.p,
           fmt::format("{} lies on no road (half its width and {:.0f} m count) and is left out", name_of(point),
                       beside_road_m));
    return {};
  }
  for (const Candidate& other : found)
    if (other.place.path != found.front().place.path && are_two_levels(roads, levels, found.front(), other, point.p)) {
      const RoadPath &a = roads.paths[found.front().place.path], &b = roads.paths[other.place.path];
      report(findings, Severity::warning, "elevate.control_point_ambiguous", point.p,
             fmt::format("{} lies on way {} (layer {}) and on way {} (layer {}), which are on two levels, and is left "
                         "out; give it the osm_id or the layer of its road",
                         name_of(point), a.osm_id, a.layer, b.osm_id, b.layer));
      return {};
    }
  return found.front().place;
}

GradeSeparation* match_crossing(const RoadNetwork& roads, std::vector<GradeSeparation>& levels,
                                const HeightControlPoint& point, Findings& findings) {
  GradeSeparation* best = nullptr;
  double best_m = of_crossing_m;
  for (GradeSeparation& level : levels) {
    const double distance_m = distance(level.crossing.p, point.p);
    if (distance_m >= best_m || !is_meant(point, roads.paths[level.upper()])) continue;
    best = &level, best_m = distance_m;
  }
  if (!best)
    report(findings, Severity::warning, "elevate.control_point_no_crossing", point.p,
           fmt::format("{}: no road passes over another one within {:.0f} m; the clearance is left out", name_of(point),
                       of_crossing_m));
  return best;
}

RoadPlace place_on(const PathCrossing& crossing, bool of_a) {
  return of_a ? RoadPlace{crossing.path_a, crossing.segment_a, crossing.fraction_a}
              : RoadPlace{crossing.path_b, crossing.segment_b, crossing.fraction_b};
}

/// The road that gives way at a crossing is measured there: it is not moved for the clearance.
void mark_measured(const ControlHeights& control, const RoadNetwork& roads, std::vector<GradeSeparation>& levels) {
  for (GradeSeparation& level : levels)
    for (const HeightObservation& height : control.heights) {
      if (height.at.path != (level.raise ? level.upper() : level.lower())) continue;
      const Vec2 p = roads.paths[height.at.path].nodes[height.at.segment].p;
      if (distance(p, level.crossing.p) < no_meeting_m) level.is_measured = true;
    }
}

double at(const RoadNetwork& roads, const RoadPlace& place, double RoadNode::*value) {
  const auto& nodes = roads.paths[place.path].nodes;
  return nodes[place.segment].*value * (1.0 - place.fraction) + nodes[place.segment + 1].*value * place.fraction;
}

}  // namespace

ControlHeights match_control_points(const RoadNetwork& roads, const std::vector<HeightControlPoint>& points,
                                    std::vector<GradeSeparation>& levels, Findings& findings) {
  ControlHeights control;
  if (points.empty()) return control;
  std::vector<Polyline> lines;
  double reach_m = least_half_width_m;
  for (const RoadPath& path : roads.paths) {
    lines.push_back(centerline(path));
    for (const RoadNode& node : path.nodes) reach_m = std::max(reach_m, 0.5 * node.width_m);
  }
  const SegmentIndex index(lines);
  for (const HeightControlPoint& point : points) {
    if (!std::isnan(point.z_m))
      if (const auto place = match_height(roads, index, reach_m + beside_road_m, levels, point, findings))
        control.heights.push_back({*place, point.z_m, point.sigma_m});
    if (std::isnan(point.clearance_m)) continue;
    GradeSeparation* level = match_crossing(roads, levels, point, findings);
    if (!level) continue;
    level->is_measured = true;
    control.rises.push_back({place_on(level->crossing, level->a_is_above),
                             place_on(level->crossing, !level->a_is_above), point.clearance_m, point.sigma_m});
  }
  mark_measured(control, roads, levels);
  return control;
}

void report_control_points(const RoadNetwork& elevated, const ControlHeights& control, const TerrainSamples& terrain,
                           const std::vector<double>& terrain_sigma_m, Findings& findings) {
  constexpr double contradicted_sigmas = 5.0, missed_sigmas = 3.0;
  for (const HeightObservation& height : control.heights) {
    const RoadPath& path = elevated.paths[height.at.path];
    const std::size_t near = height.at.segment + (height.at.fraction > 0.5 ? 1 : 0);
    const Vec2 p = path.nodes[near].p;
    const TerrainSample& sample = terrain.of_node[height.at.path][near];
    if (sample.is_road) {
      const double off_m = height.z_m - sample.z_m;
      const double sigma_m =
          std::hypot(height.sigma_m, terrain_sigma_m[sample.source], static_cast<double>(sample.spread_m));
      if (std::abs(off_m) > contradicted_sigmas * sigma_m)
        report(findings, Severity::info, "elevate.control_point_off_terrain", p,
               fmt::format("way {}: the control point of {:.2f} m lies {:.2f} m {} the terrain; the point counts",
                           path.osm_id, height.z_m, std::abs(off_m), off_m > 0.0 ? "above" : "below"));
    }
    const double missed_m = at(elevated, height.at, &RoadNode::z_m) - height.z_m;
    if (std::abs(missed_m) > missed_sigmas * height.sigma_m)
      report(findings, Severity::warning, "elevate.control_point_missed", p,
             fmt::format("way {}: its height misses the control point of {:.2f} m by {:.2f} m; other points near it "
                         "say otherwise",
                         path.osm_id, height.z_m, std::abs(missed_m)));
  }
  for (const RiseObservation& rise : control.rises) {
    const double missed_m =
        at(elevated, rise.upper, &RoadNode::z_m) - at(elevated, rise.lower, &RoadNode::z_m) - rise.rise_m;
    const RoadPath& path = elevated.paths[rise.upper.path];
    if (std::abs(missed_m) > missed_sigmas * rise.sigma_m)
      report(findings, Severity::warning, "elevate.control_point_missed", path.nodes[rise.upper.segment].p,
             fmt::format("way {}: its height over way {} misses the clearance of {:.2f} m by {:.2f} m; other points "
                         "near it say otherwise",
                         path.osm_id, elevated.paths[rise.lower.path].osm_id, rise.rise_m, std::abs(missed_m)));
  }
}

}  // namespace orthodrive::elevate
