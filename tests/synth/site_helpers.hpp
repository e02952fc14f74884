// SPDX-License-Identifier: Apache-2.0
#pragma once
// What several tests of synthetic sites need.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <set>
#include <stdexcept>
#include <string>
#include <tuple>

#include "orthodrive/core/hash.hpp"
#include "orthodrive/synth/ground/terrain.hpp"
#include "orthodrive/synth/make_site.hpp"
#include "orthodrive/synth/plan/site_plan.hpp"

namespace orthodrive::synth {

template <typename T>
std::string bytes(const std::vector<T>& data) {
  return {reinterpret_cast<const char*>(data.data()), data.size() * sizeof(T)};
}

/// Everything a site holds, in one hash.
inline std::string fingerprint(const SynthSite& site) {
  std::string all = bytes(site.photo.rgb.data) + bytes(site.labels.labels.data) + bytes(site.dtm_1m.height_m.data) +
                    bytes(site.dtm_10m.height_m.data) + bytes(site.true_dtm.height_m.data);
  const auto add = [&all](const auto& value) { all.append(reinterpret_cast<const char*>(&value), sizeof(value)); };
  for (const OsmNode& node : site.osm.nodes) add(node.id), add(node.p);
  for (const OsmWay& way : site.osm.ways) {
    add(way.id), all += bytes(way.nodes);
    for (const auto& [key, value] : way.tags) all += key + "=" + value + ";";
  }
  for (const RoadPath& path : site.roads.paths)
    for (const RoadNode& n : path.nodes)
      for (const double v : {n.p.x, n.p.y, n.s_m, n.offset_m, n.width_m, n.z_m, n.gradient, n.banking}) add(v);
  for (const SynthSurface& surface : site.surfaces) add(surface.visibility);
  return hash_bytes(all);
}

/// A plan and its terrain, made once for all that is asked of them.
struct Planned {
  SitePlan plan;
  Terrain terrain;
};
inline const Planned& planned(SitePlan (*make)(double, std::uint64_t), double size_m, std::uint64_t seed) {
  static std::map<std::tuple<SitePlan (*)(double, std::uint64_t), double, std::uint64_t>, Planned> all;
  const std::tuple key{make, size_m, seed};
  if (const auto made = all.find(key); made != all.end()) return made->second;
  const SitePlan plan = make(size_m, seed);
  return all.emplace(key, Planned{plan, make_terrain(plan, seed)}).first->second;
}

inline std::size_t circuit_of(const SitePlan& plan) {
  if (!plan.circuit) throw std::logic_error("the plan has no circuit");
  return *plan.circuit;
}

/// Position, heading and curvature agree where elements meet.
inline void expect_continuous(const PlannedRoad& road) {
  const Alignment& a = road.alignment;
  const std::size_t joints = a.closed ? a.elements.size() : a.elements.size() - 1;
  for (std::size_t i = 0; i < joints; ++i) {
    const AlignmentPoint end = evaluate(a.elements[i], a.elements[i].length_m);
    const AlignmentElement& next = a.elements[(i + 1) % a.elements.size()];
    ASSERT_LT(distance(end.p, next.start), 1e-7) << road.name;
    ASSERT_NEAR(std::sin(0.5 * (end.heading_rad - next.heading_rad)), 0.0, 1e-9) << road.name;
    ASSERT_NEAR(end.curvature_1pm, next.k_begin_1pm, 1e-12) << road.name;
    ASSERT_GE(a.elements[i].length_m, 0.0) << road.name;
  }
}

/// Arms of a junction lie on each other; returns how many groups of roads junctions connect.
inline std::size_t expect_arms_meet(const SitePlan& plan) {
  std::vector<std::size_t> group(plan.roads.size());
  for (std::size_t i = 0; i < group.size(); ++i) group[i] = i;
  for (const PlannedJunction& junction : plan.junctions) {
    EXPECT_GE(junction.arms.size(), 2u);
    for (const PlannedJunction::Arm& arm : junction.arms) {
      EXPECT_LT(distance(evaluate(plan.roads[arm.road].alignment, arm.s_m).p, junction.p), 1e-6)
          << plan.roads[arm.road].name << " at " << arm.s_m << " of " << plan.roads[arm.road].alignment.length_m
          << " m, with " << plan.roads[junction.arms[0].road].name;
      const std::size_t from = group[arm.road], to = group[junction.arms[0].road];
      std::replace(group.begin(), group.end(), from, to);
    }
  }
  return std::set<std::size_t>(group.begin(), group.end()).size();
}

/// No road's carriageway touches one that it neither meets nor bridges.
inline void expect_apart(const SitePlan& plan) {
  for (std::size_t a = 0; a < plan.roads.size(); ++a)
    for (std::size_t b = 0; b < a; ++b) {
      const bool meet = std::any_of(plan.junctions.begin(), plan.junctions.end(), [&](const PlannedJunction& j) {
        const auto has = [&](std::size_t road) {
          return std::any_of(j.arms.begin(), j.arms.end(), [&](const auto& arm) { return arm.road == road; });
        };
        return has(a) && has(b);
      });
      const bool bridged = std::any_of(plan.bridges.begin(), plan.bridges.end(), [&](const PlannedBridge& bridge) {
        return std::any_of(bridge.under.begin(), bridge.under.end(), [&](const auto& below) {
          return (bridge.over == a && below.road == b) || (bridge.over == b && below.road == a);
        });
      });
      if (meet || bridged) continue;
      const Polyline line = sample(plan.roads[b].alignment, 4.0);
      for (const Vec2 p : sample(plan.roads[a].alignment, 4.0))
        ASSERT_GT(project_onto(line, p).distance_m, 0.5 * (plan.roads[a].width_m + plan.roads[b].width_m) + 1.5)
            << "roads " << a << " and " << b;
    }
}

/// Share of the pixels labelled road that lie outside all surfaces, and of surface pixels that are neither road nor
/// under a crown; on the site's own grid.
struct Agreement {
  double outside = 0.0, wrong = 0.0;
};
inline Agreement compare_labels(const SynthSite& site) {
  const Raster<std::uint8_t>& labels = site.labels.labels;
  Raster<std::uint8_t> covered(labels.width, labels.height);
  for (const SynthSurface& surface : site.surfaces)
    fill_polygon(covered, site.labels.frame, surface.polygon, std::uint8_t{1});
  double road = 0.0, outside = 0.0, surface = 0.0, wrong = 0.0;
  for (std::size_t i = 0; i < labels.data.size(); ++i) {
    const bool is_road = labels.data[i] == 1, hidden = labels.data[i] == 4;
    road += is_road ? 1.0 : 0.0, outside += is_road && covered.data[i] == 0 ? 1.0 : 0.0;
    surface += covered.data[i], wrong += covered.data[i] != 0 && !is_road && !hidden ? 1.0 : 0.0;
  }
  return {outside / road, wrong / surface};
}

}  // namespace orthodrive::synth
