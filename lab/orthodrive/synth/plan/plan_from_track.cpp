// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/synth/plan/plan_from_track.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/random.hpp"
#include "orthodrive/model/roads/road_network.hpp"
#include "orthodrive/synth/plan/plan_country.hpp"
#include "orthodrive/synth/plan/trackside.hpp"

namespace orthodrive::synth {
namespace {
constexpr double margin_m = 120.0;             // of the site round the track
constexpr double largest_m = 4000.0;           // site, as for the presets
constexpr double largest_country_m = 10000.0;  // heights take a time that grows with the area
constexpr double osm_reach_m = 25.0;           // OSM is right to a few metres; the next road is farther away

Polyline closed_line(const std::vector<TrackRow>& rows) {
  Polyline line;
  for (const TrackRow& row : rows) line.push_back(row.p);
  line.push_back(rows.front().p);
  return line;
}

/// The ways along the track as one loop, in the order of travel.
std::vector<OsmWay> find_loop(const TrackSources& sources, const std::map<std::int64_t, Vec2>& places) {
  const Polyline track = closed_line(sources.rows);
  std::vector<OsmWay> near;
  for (const OsmWay& way : sources.osm.ways) {
    const auto highway = way.tags.find("highway");
    if (highway == way.tags.end() || !is_drivable(highway->second) || way.nodes.size() < 2) continue;
    if (std::all_of(way.nodes.begin(), way.nodes.end(), [&](std::int64_t id) {
          return places.contains(id) && project_onto(track, places.at(id)).distance_m < osm_reach_m;
        }))
      near.push_back(way);
  }
  if (near.empty())
    throw InputError(sources.osm_file,
                     fmt::format("no drivable way within {} m of the track of {}", osm_reach_m, sources.file));
  std::vector<OsmWay> loop{near.front()};
  near.erase(near.begin());
  while (loop.back().nodes.back() != loop.front().nodes.front()) {
    const auto next = std::find_if(near.begin(), near.end(),
                                   [&](const OsmWay& way) { return way.nodes.front() == loop.back().nodes.back(); });
    if (next == near.end())
      throw InputError(sources.osm_file, fmt::format("the ways along the track do not close to a loop: none begins at "
                                                     "node {}, where way {} ends",
                                                     loop.back().nodes.back(), loop.back().id));
    loop.push_back(*next);
    near.erase(next);
  }
  return loop;
}

/// True when the loop runs against the rows.
bool runs_against(const std::vector<TrackRow>& rows, const std::vector<OsmWay>& loop,
                  const std::map<std::int64_t, Vec2>& places) {
  Ring track, osm;
  for (const TrackRow& row : rows) track.push_back(row.p);
  for (const OsmWay& way : loop)
    for (std::size_t i = 0; i + 1 < way.nodes.size(); ++i) osm.push_back(places.at(way.nodes[i]));
  return (signed_area_m2(track) > 0.0) != (signed_area_m2(osm) > 0.0);
}

/// The place of a curve on the line through p across `direction`, near s.
Vec2 across(const Alignment& edge, double s, Vec2 p, Vec2 direction) {
  for (int i = 0; i < 20; ++i) {
    const AlignmentPoint q = evaluate(edge, s);
    const double step =
        dot(p - q.p, direction) / std::max(0.3, dot({std::cos(q.heading_rad), std::sin(q.heading_rad)}, direction));
    s += std::clamp(step, -1.0, 1.0);
    if (std::abs(step) < 1e-9) break;
  }
  return evaluate(edge, s).p;
}

/// Middle line and width of the strip between the edges, which stand across the surveyed line. Across the middle line,
/// which runs a little askew to it, they are found by iteration, at four stations a row: in the tightest hairpins rows
/// are as far apart as the inner edge's radius.
void lay_carriageway(const std::vector<TrackRow>& rows, Vec2 world_from_local, PlannedRoad& road) {
  TrackEdges edges = track_edges(rows);
  for (std::vector<Vec2>* side : {&edges.left, &edges.right})
    for (Vec2& p : *side) p = p - world_from_local;
  const Alignment left_edge = spline_through(edges.left, true), right_edge = spline_through(edges.right, true);
  constexpr std::size_t stations = 4;
  const auto station_s = [](const Alignment& edge, std::size_t i) {
    const double part = static_cast<double>(i % stations) / stations;
    return edge.curve.s_m[i / stations] * (1.0 - part) + edge.curve.s_m[i / stations + 1] * part;
  };
  std::vector<Vec2> middle;
  middle.reserve(stations * rows.size());
  for (std::size_t i = 0; i < stations * rows.size(); ++i)
    middle.push_back(
        (evaluate(left_edge, station_s(left_edge, i)).p + evaluate(right_edge, station_s(right_edge, i)).p) * 0.5);
  std::vector<double> width_m(middle.size());
  for (int iteration = 0; iteration < 6; ++iteration) {
    road.alignment = spline_through(middle, true);
    for (std::size_t i = 0; i < middle.size(); ++i) {
      const AlignmentPoint q = evaluate(road.alignment, road.alignment.curve.s_m[i]);
      const Vec2 direction{std::cos(q.heading_rad), std::sin(q.heading_rad)};
      const Vec2 l = across(left_edge, station_s(left_edge, i), q.p, direction),
                 r = across(right_edge, station_s(right_edge, i), q.p, direction);
      middle[i] = (l + r) * 0.5;
      width_m[i] = distance(l, r);
    }
  }
  width_m.push_back(width_m.front());
  road.width_along = periodic_spline(road.alignment.curve.s_m, std::move(width_m));
  road.width_m = road.width_along.values.front();
}

GivenOsm place_ways(const std::vector<OsmWay>& loop, const std::map<std::int64_t, Vec2>& places,
                    const Alignment& track) {
  GivenOsm osm;
  std::map<std::int64_t, Vec2> used;
  const auto s_of = [&](std::int64_t node) {
    const double s = std::fmod(nearest_s(track, places.at(node)), track.length_m);
    return s < 0.0 ? s + track.length_m : s;
  };
  for (const OsmWay& way : loop) {
    const double begin = s_of(way.nodes.front()), end = s_of(way.nodes.back());
    osm.ways.push_back({way.id, way.nodes.front(), way.nodes.back(), begin, end > begin ? end : end + track.length_m});
    for (const std::int64_t node : way.nodes) used.emplace(node, places.at(node));
    osm.data.ways.push_back(way);
  }
  for (const auto& [id, p] : used) osm.data.nodes.push_back({id, p});
  // Sorted by id, as files are.
  std::sort(osm.ways.begin(), osm.ways.end(), [](const auto& a, const auto& b) { return a.osm_id < b.osm_id; });
  std::sort(osm.data.ways.begin(), osm.data.ways.end(), [](const auto& a, const auto& b) { return a.id < b.id; });
  return osm;
}
}  // namespace

TrackEdges track_edges(const std::vector<TrackRow>& rows) {
  std::vector<Vec2> points;
  points.reserve(rows.size());
  for (const TrackRow& row : rows) points.push_back(row.p);
  const Alignment surveyed = spline_through(points, true);
  TrackEdges edges;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const double heading = evaluate(surveyed, surveyed.curve.s_m[i]).heading_rad;
    const Vec2 normal{-std::sin(heading), std::cos(heading)};
    edges.left.push_back(rows[i].p + normal * rows[i].left_m);
    edges.right.push_back(rows[i].p - normal * rows[i].right_m);
  }
  return edges;
}

TrackErrors measure_track(const std::vector<TrackRow>& rows, const RoadNetwork& truth) {
  TrackErrors errors;
  std::vector<Polyline> sides;
  for (const RoadPath& path : truth.paths) {
    if (path.nodes.empty()) continue;
    errors.lap_m += path.nodes.back().s_m;
    const Ring ring = surface_ring(path);  // one side, then the other side backwards
    const auto half = ring.begin() + static_cast<long>(path.nodes.size());
    sides.emplace_back(ring.begin(), half);
    sides.emplace_back(half, ring.end());
  }
  if (sides.empty()) return errors;
  const TrackEdges edges = track_edges(rows);
  std::vector<double> off_m;
  for (const std::vector<Vec2>* side : {&edges.left, &edges.right})
    for (const Vec2 p : *side) {
      double nearest = std::numeric_limits<double>::infinity();
      for (const Polyline& line : sides) nearest = std::min(nearest, project_onto(line, p).distance_m);
      off_m.push_back(nearest);
    }
  std::sort(off_m.begin(), off_m.end());
  for (const double off : off_m) errors.edge_mean_m += off / static_cast<double>(off_m.size());
  errors.edge_p95_m = off_m[off_m.size() * 95 / 100];
  errors.edge_most_m = off_m.back();
  return errors;
}

SitePlan plan_from_track(const TrackSources& sources, std::uint64_t seed, double size_m) {
  std::vector<TrackRow> rows = sources.rows;
  SitePlan plan{.name = "Track", .circuit = 0, .surroundings = Surroundings::country, .relief = 0.6};
  plan.round_corners_by_angle = true;
  const Box2 box = bounds_of(closed_line(rows));
  plan.size_m = 10.0 * std::ceil((std::max(box.width(), box.height()) + 2.0 * margin_m) / 10.0);
  if (plan.size_m > largest_m)
    throw InputError(sources.file, fmt::format("the track needs a site of {:.0f} m, at most {:.0f} m is painted",
                                               plan.size_m, largest_m));
  if (size_m > 0.0) {
    const double least_m = plan.size_m - 2.0 * margin_m + 2.0 * country_reach_m;
    if (!(size_m >= least_m && size_m <= largest_country_m) || std::fmod(size_m, 10.0) != 0.0)
      throw OptionError(
          fmt::format("size is {} m, need a multiple of 10 m between {:.0f} and {:.0f} for the track of {}", size_m,
                      least_m, largest_country_m, sources.file));
    plan.size_m = size_m;
  }
  const Vec2 middle{0.5 * (box.min_x + box.max_x), 0.5 * (box.min_y + box.max_y)};
  plan.world_from_local = {10.0 * std::round((middle.x - 0.5 * plan.size_m) / 10.0),
                           10.0 * std::round((middle.y - 0.5 * plan.size_m) / 10.0)};

  PlannedRoad road{.highway = "raceway", .name = "Circuit", .lanes = 1, .oneway = true};
  std::map<std::int64_t, Vec2> places;
  std::vector<OsmWay> loop;
  if (!sources.osm.ways.empty()) {
    for (const OsmNode& node : sources.osm.nodes) places.emplace(node.id, node.p);
    loop = find_loop(sources, places);
    if (runs_against(rows, loop, places)) {
      std::reverse(rows.begin(), rows.end());
      for (TrackRow& row : rows) std::swap(row.left_m, row.right_m);
    }
    const auto& tags = loop.front().tags;
    road.highway = tags.at("highway");
    if (tags.contains("name")) plan.name = road.name = tags.at("name");
    road.oneway = tags.contains("oneway") && tags.at("oneway") == "yes";
    for (auto& [id, p] : places) p = p - plan.world_from_local;
  }
  lay_carriageway(rows, plan.world_from_local, road);
  plan.roads.push_back(std::move(road));
  if (!loop.empty()) plan.osm = place_ways(loop, places, plan.roads[0].alignment);

  for (const Vec3& height : sources.heights) {
    const Vec3 local{height.x - plan.world_from_local.x, height.y - plan.world_from_local.y, height.z};
    if (!Box2{0.0, 0.0, plan.size_m, plan.size_m}.grown(2000.0).contains({local.x, local.y}))
      throw InputError(
          sources.heights_file,
          fmt::format("a height at {:.0f}, {:.0f} (UTM 33N) is more than 2 km from the track", height.x, height.y));
    plan.heights.push_back(local);
  }
  Random random(derive_seed(seed, 23));
  add_verges(plan, 0, 16.0);
  add_run_off(plan, 0, random);
  add_stands(plan, 0, 6, random);
  if (size_m > 0.0) add_country(plan, seed);
  return plan;
}

}  // namespace orthodrive::synth
