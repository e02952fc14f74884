// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/synth/disturb_osm.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "orthodrive/core/noise.hpp"
#include "orthodrive/core/random.hpp"

namespace orthodrive::synth {
namespace {
constexpr std::int64_t first_way_id = 100, first_area_id = 10000;
constexpr double min_spacing_m = 7.0, max_spacing_m = 40.0;
constexpr double max_sagitta_m = 0.3;  // mappers set nodes closer in bends, so that the chord stays this near
constexpr double width_tag_share = 0.12, lanes_tag_share = 0.3;

/// Smooth displacement: length between the two offsets, direction turning slowly.
class DisplacementField {
 public:
  explicit DisplacementField(const DisturbOptions& options)
      : options_(options), seed_(static_cast<std::uint32_t>(derive_seed(options.seed, 5))) {}
  [[nodiscard]] Vec2 at(Vec2 p) const {
    const double share = 0.5 + 0.5 * value_noise(p.x / 100.0, p.y / 100.0, seed_);
    const double amount = options_.offset_min_m + (options_.offset_max_m - options_.offset_min_m) * share;
    const double angle = 6.283 * unit_hash(0, 0, seed_ + 1) + 3.0 * value_noise(p.x / 120.0, p.y / 120.0, seed_ + 2);
    return Vec2{std::cos(angle), std::sin(angle)} * amount;
  }

 private:
  DisturbOptions options_;
  std::uint32_t seed_;
};

/// Largest distance of the line from its chord between two places.
double sagitta_m(const Alignment& alignment, double from, double to) {
  const Vec2 a = evaluate(alignment, from).p, chord = normalized(evaluate(alignment, to).p - a);
  double most = 0.0;
  for (int i = 1; i < 8; ++i)
    most = std::max(most, std::abs(cross(chord, evaluate(alignment, from + (to - from) * i / 8.0).p - a)));
  return most;
}

std::map<std::string, std::string> road_tags(const PlannedRoad& road, bool bridge, Random& random) {
  std::map<std::string, std::string> tags{{"highway", road.highway}};
  if (!road.name.empty()) tags["name"] = road.name;
  if (road.oneway) tags["oneway"] = "yes";
  if (bridge) tags["bridge"] = "yes", tags["layer"] = "1";
  if (road.roundabout) tags["junction"] = "roundabout";
  if (!road.surface.empty()) tags["surface"] = road.surface;
  if (random.uniform() < lanes_tag_share || road.lanes_tagged) tags["lanes"] = fmt::format("{}", road.lanes);
  if (random.uniform() < width_tag_share)
    tags["width"] = fmt::format("{:.1f}", 0.5 * std::round(2.0 * road.width_at(0.0)));
  return tags;
}
}  // namespace

std::vector<PlannedWay> plan_ways(const SitePlan& plan) {
  std::vector<PlannedWay> ways;
  std::int64_t last_node = 0, next_way = first_way_id;
  if (plan.osm) {
    for (const OsmNode& node : plan.osm->data.nodes) last_node = std::max(last_node, node.id);
    for (const OsmWay& way : plan.osm->data.ways) next_way = std::max(next_way, way.id + 1);
    for (const GivenOsm::Way& given : plan.osm->ways)
      ways.push_back({.osm_id = given.osm_id,
                      .s_begin_m = given.s_begin_m,
                      .s_end_m = given.s_end_m,
                      .given = true,
                      .stops = {{given.s_begin_m, given.first_node}, {given.s_end_m, given.last_node}}});
  }
  // Junction j has the node j + 1 after the given ones.
  std::int64_t next_node = last_node + static_cast<std::int64_t>(plan.junctions.size()) + 1;
  for (std::size_t r = plan.osm ? 1 : 0; r < plan.roads.size(); ++r) {
    const PlannedRoad& road = plan.roads[r];
    std::vector<double> cuts{0.0, road.alignment.length_m};
    for (const PlannedBridge& b : plan.bridges)
      if (b.over == r) cuts.push_back(b.s_over_m - b.half_length_m), cuts.push_back(b.s_over_m + b.half_length_m);
    std::sort(cuts.begin(), cuts.end());
    std::int64_t cut_node = 0;
    for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
      PlannedWay way{.osm_id = next_way++,
                     .road = r,
                     .s_begin_m = cuts[i],
                     .s_end_m = cuts[i + 1],
                     .bridge = on_bridge(plan, r, 0.5 * (cuts[i] + cuts[i + 1]))};
      for (std::size_t j = 0; j < plan.junctions.size(); ++j)
        for (const PlannedJunction::Arm& arm : plan.junctions[j].arms)
          if (arm.road == r && arm.s_m >= way.s_begin_m - 1e-6 && arm.s_m <= way.s_end_m + 1e-6)
            way.stops.push_back({arm.s_m, last_node + static_cast<std::int64_t>(j) + 1});
      std::sort(way.stops.begin(), way.stops.end(), [](const auto& a, const auto& b) { return a.s_m < b.s_m; });
      if (way.stops.empty() || way.stops.front().s_m > way.s_begin_m + 1e-6)
        way.stops.insert(way.stops.begin(), {way.s_begin_m, cut_node != 0 ? cut_node : next_node++});
      if (road.alignment.closed)
        way.stops.push_back({way.s_end_m, way.stops.front().osm_node});
      else if (way.stops.back().s_m < way.s_end_m - 1e-6)
        way.stops.push_back({way.s_end_m, next_node++});
      cut_node = way.stops.back().osm_node;
      ways.push_back(std::move(way));
    }
  }
  return ways;
}

namespace {

/// Areas and houses, displaced by a third of what the roads are: mappers trace them on the photo.
void map_objects(const SiteObjects& objects, const DisplacementField& field, std::int64_t next_node,
                 std::map<std::int64_t, Vec2>& nodes, OsmData& osm) {
  std::int64_t next_area = first_area_id;
  for (const OsmWay& way : osm.ways) next_area = std::max(next_area, way.id + 1);
  const auto add_area = [&](const Ring& ring, std::map<std::string, std::string> tags) {
    OsmWay way{.id = next_area++, .tags = std::move(tags)};
    for (const Vec2 p : ring) {
      nodes.emplace(next_node, p + field.at(p) * (1.0 / 3.0));
      way.nodes.push_back(next_node++);
    }
    way.nodes.push_back(way.nodes.front());
    osm.ways.push_back(std::move(way));
  };
  for (const Area& area : objects.areas) {
    if (!area.mapped) continue;
    if (area.cover == Cover::water) add_area(area.polygon.outer, {{"natural", "water"}});
    if (area.cover == Cover::forest_floor) add_area(area.polygon.outer, {{"landuse", "forest"}});
    if (area.cover == Cover::parking) add_area(area.polygon.outer, {{"amenity", "parking"}});
    if (area.cover == Cover::gravel_trap) add_area(area.polygon.outer, {{"natural", "shingle"}, {"surface", "gravel"}});
  }
  for (const House& house : objects.houses) add_area(outline(house), {{"building", "yes"}});
}

}  // namespace

OsmData disturb_osm(const SitePlan& plan, const std::vector<PlannedWay>& ways, const SiteObjects& objects,
                    const DisturbOptions& options) {
  const DisplacementField field(options);
  Random random(derive_seed(options.seed, 6));
  std::map<std::int64_t, Vec2> nodes;
  std::int64_t next_node = 1000;
  for (const PlannedWay& way : ways)
    for (const PlannedWay::Stop& stop : way.stops) next_node = std::max(next_node, stop.osm_node + 1);
  OsmData osm;
  if (plan.osm) {
    osm.ways = plan.osm->data.ways;
    for (const OsmNode& node : plan.osm->data.nodes) {
      nodes.emplace(node.id, node.p);
      next_node = std::max(next_node, node.id + 1);
    }
  }
  for (const PlannedWay& planned : ways) {
    if (planned.given) continue;
    const Alignment& alignment = plan.roads[planned.road].alignment;
    OsmWay way{.id = planned.osm_id, .tags = road_tags(plan.roads[planned.road], planned.bridge, random)};
    const auto put = [&](std::int64_t id, double s) {
      const Vec2 p = evaluate(alignment, s).p;
      nodes.emplace(id, p + field.at(p));  // a shared node keeps its first place
      way.nodes.push_back(id);
    };
    for (std::size_t i = 0; i + 1 < planned.stops.size(); ++i) {
      const double end = planned.stops[i + 1].s_m;
      double s = planned.stops[i].s_m;
      put(planned.stops[i].osm_node, s);
      for (;;) {
        double spacing_m = random.uniform(15.0, max_spacing_m);
        if (s + spacing_m > end - min_spacing_m) spacing_m = end - s;
        while (spacing_m > min_spacing_m && sagitta_m(alignment, s, s + spacing_m) > max_sagitta_m) spacing_m *= 0.8;
        s += spacing_m;
        if (s > end - 0.5 * min_spacing_m) break;
        put(next_node++, s);
      }
    }
    put(planned.stops.back().osm_node, planned.stops.back().s_m);
    osm.ways.push_back(std::move(way));
  }

  map_objects(objects, field, next_node, nodes, osm);
  for (const auto& [id, p] : nodes) osm.nodes.push_back({id, p});
  return osm;
}

RoadNetwork true_roads(const SitePlan& plan, const Terrain& terrain, const std::vector<PlannedWay>& ways,
                       const OsmData& osm) {
  std::map<std::int64_t, Vec2> osm_nodes;
  for (const OsmNode& node : osm.nodes) osm_nodes.emplace(node.id, node.p);
  const Box2 site{0.0, 0.0, plan.size_m, plan.size_m};
  RoadNetwork roads;
  for (std::size_t w = 0; w < ways.size(); ++w) {
    const PlannedWay& way = ways[w];
    const PlannedRoad& road = plan.roads[way.road];
    Polyline osm_line;
    for (const std::int64_t id : osm.ways[w].nodes) osm_line.push_back(osm_nodes.at(id));
    const auto& tags = osm.ways[w].tags;
    RoadPath path{.osm_id = way.osm_id,
                  .highway = road.highway,
                  .name = road.name,
                  .layer = way.bridge ? 1 : 0,
                  .bridge = way.bridge,
                  .oneway = road.oneway ? Oneway::forward : Oneway::no,
                  .lanes = tags.contains("lanes") ? road.lanes : 0,
                  .roundabout = road.roundabout,
                  .surface = road.surface,
                  .known_surface = {surface_of_tags(road.highway, road.surface, "").surface, SurfaceSource::truth}};
    const auto put = [&](double s_way, std::int64_t osm_node) {
      const bool beyond_seam = road.alignment.closed && s_way > road.alignment.length_m;
      const double s = beyond_seam ? s_way - road.alignment.length_m : s_way;
      const AlignmentPoint q = evaluate(road.alignment, s);
      if (!site.contains(q.p)) return;
      RoadNode node{.p = q.p, .osm_node = osm_node, .s_m = s_way, .width_m = road.width_at(s)};
      const Vec2 left{-std::sin(q.heading_rad), std::cos(q.heading_rad)};
      node.offset_m = dot(q.p - project_onto(osm_line, q.p).point, left);
      node.z_m = terrain.profiles[way.road].z(s);
      node.gradient = terrain.profiles[way.road].gradient(s);
      node.banking = banking_rad(road, design_curvature_1pm(road.alignment, s));
      node.banking_source = BankingSource::truth;
      path.nodes.push_back(node);
    };
    for (std::size_t i = 0; i + 1 < way.stops.size(); ++i) {
      const double from = way.stops[i].s_m, to = way.stops[i + 1].s_m;
      const int count = std::max(1, static_cast<int>(std::lround(to - from)));
      put(from, way.stops[i].osm_node);
      for (int k = 1; k < count; ++k) put(from + (to - from) * k / count, 0);
    }
    put(way.stops.back().s_m, way.stops.back().osm_node);
    if (path.nodes.size() < 2) continue;
    if (path.nodes.front().osm_node != 0 && path.nodes.front().osm_node == path.nodes.back().osm_node)
      path.nodes.back().p = path.nodes.front().p;  // closed: the same to the last bit
    const double start = path.nodes.front().s_m;
    for (RoadNode& node : path.nodes) node.s_m -= start;
    roads.paths.push_back(std::move(path));
  }
  return roads;
}

}  // namespace orthodrive::synth
