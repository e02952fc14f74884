// SPDX-License-Identifier: Apache-2.0
// What is in an OpenDRIVE file? Reads one and prints its roads by class, the elements of their reference lines, its
// junctions, and how the longest road goes on. Links roadquery alone, which needs nothing but the standard library.
//
// Read first: src/roadquery/map/road_map.hpp (the structs), src/roadquery/surface/road_surface.hpp (their evaluation).
// Next: 03_refine_one_road.cpp.
//
//   example_read_a_network FILE.xodr

#include <algorithm>
#include <cstdio>
#include <exception>
#include <map>
#include <string>

#include "roadquery/road_map.hpp"
#include "roadquery/road_surface.hpp"

using namespace roadquery;

namespace {

const char* name_of(const PlanShape& shape) {
  static const char* const names[] = {"lines", "arcs", "spirals", "cubic polynomials"};  // in the order of the variant
  return names[shape.index()];
}

void print_link(const char* which, const RoadLink& link) {
  if (link.kind == LinkKind::none) std::printf("  %s: nothing\n", which);
  if (link.kind == LinkKind::junction) std::printf("  %s: junction %d\n", which, link.id);
  if (link.kind == LinkKind::road)
    std::printf("  %s: road %d, at its %s\n", which, link.id, link.contact == ContactPoint::start ? "start" : "end");
}

void print_network(const RoadMap& map) {
  std::map<std::string, double> metres;
  std::map<std::string, int> elements;
  for (const Road& road : map.roads) {
    metres[road.junction >= 0 ? "(in a junction)" : road.highway] += road.length;
    for (const PlanElement& element : road.plan) ++elements[name_of(element.shape)];
  }
  std::printf("%zu roads, %zu junctions\n", map.roads.size(), map.junctions.size());
  for (const auto& [highway, m] : metres) std::printf("  %-20s %8.0f m\n", highway.c_str(), m);
  for (const auto& [kind, count] : elements) std::printf("  %-20s %8d\n", kind.c_str(), count);
}

void print_road(const Road& road) {
  std::printf("road %d \"%s\": %.1f m\n", road.id, road.name.c_str(), road.length);
  print_link("before it", road.predecessor);
  print_link("after it", road.successor);
  for (const double s : {0.0, 0.5 * road.length, road.length}) {
    const SurfacePoint p = surface_point(road, s, 0.0);
    const Edges edges = road_edges(road, s);
    std::printf("  s %7.1f: x %.1f, y %.1f, z %.2f, %.1f m wide, gradient %+.1f %%\n", s, p.x, p.y, p.z,
                edges.left_t - edges.right_t, 100.0 * gradient(road, s));
  }
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 2) return std::fprintf(stderr, "usage: %s FILE.xodr\n", argv[0]), 2;
  const RoadMap map = read_opendrive(argv[1]);
  print_network(map);
  const auto longest = std::max_element(map.roads.begin(), map.roads.end(),
                                        [](const Road& a, const Road& b) { return a.length < b.length; });
  if (longest != map.roads.end()) print_road(*longest);
  return 0;
} catch (const std::exception& e) {
  std::fprintf(stderr, "%s\n", e.what());
  return 1;
}
