#include <algorithm>
#include <cmath>
#include <map>

#include "orthodrive/network/crown_shape.hpp"
#include "orthodrive/network/lanes.hpp"
#include "orthodrive/network/road_parts.hpp"

namespace orthodrive::network {
namespace {

using roadquery::ContactPoint;
using roadquery::LinkKind;
using roadquery::Road;
using roadquery::RoadLink;
using roadquery::RoadMap;

constexpr double min_part_m = 0.5;  // shorter pieces of way are left to the road before them

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// s along the chain where roads of a stretch begin and end.
std::vector<double> cuts_of(const ChainGeometry& geometry, const Stretch& stretch) {
  const double begin = stretch.s0 + stretch.trim0_m, end = stretch.s1 - stretch.trim1_m;
  std::vector<double> cuts{begin};
  for (const double s : geometry.vertex_s)
    if (s > cuts.back() + min_part_m && s < end - min_part_m) cuts.push_back(s);
  cuts.push_back(end);
  return cuts;
}

std::vector<ProfileSample> widths_between(const ChainGeometry& geometry, std::size_t piece, double s0, double s1) {
  std::vector<ProfileSample> samples{{0.0, width_at(geometry, s0 + 1e-6)}};
  for (const ProfileSample& sample : geometry.widths[piece])
    if (sample.s > s0 + 1e-3 && sample.s < s1 - 1e-3) samples.push_back({sample.s - s0, sample.value});
  samples.push_back({s1 - s0, width_at(geometry, s1 - 1e-6)});
  return samples;
}

double median(std::vector<ProfileSample> samples) {
  const auto middle = samples.begin() + static_cast<std::ptrdiff_t>(samples.size() / 2);
  std::nth_element(samples.begin(), middle, samples.end(),
                   [](const ProfileSample& a, const ProfileSample& b) { return a.value < b.value; });
  return middle->value;
}

Road make_road(const NetworkPlan& plan, int chain, double s0, double s1) {
  const ChainGeometry& geometry = plan.geometry[at(chain)];
  const std::size_t k = piece_at(geometry, 0.5 * (s0 + s1));
  const ChainPiece part = plan.topology.chains[at(chain)].pieces[k];
  const RoadPath& path = plan.roads.paths[at(plan.topology.pieces[at(part.piece)].path)];

  Road road;
  road.name = path.name;
  road.left_hand_traffic = plan.options.left_hand_traffic;
  road.osm_id = std::to_string(path.osm_id);
  road.highway = path.highway;
  road.layer = path.layer, road.bridge = path.bridge, road.tunnel = path.tunnel;
  road.plan = slice_plan(geometry.plan, s0, s1);
  road.length = plan_length(road.plan);
  road.elevation = slice_profile(geometry.elevation, s0, s1);
  road.superelevation = slice_profile(geometry.superelevation, s0, s1);
  std::vector<roadquery::Cubic> crown = slice_profile(geometry.crown, s0, s1);
  std::vector<ProfileSample> widths = widths_between(geometry, k, s0, s1);
  if (part.reversed) {
    road.plan = reverse_plan(road.plan);
    road.elevation = reverse_profile(road.elevation, road.length);
    road.superelevation = reverse_profile(road.superelevation, road.length, -1.0);
    crown = reverse_profile(crown, road.length);
    std::reverse(widths.begin(), widths.end());
    for (ProfileSample& sample : widths) sample.s = (s1 - s0) - sample.s;
  }
  road.shape = crown_shape(crown, road.length);
  add_lanes(road, lane_layout(path, median(geometry.widths[k]), plan.options.left_hand_traffic), widths,
            plan.options.width_tolerance_m);
  return road;
}

/// One end of a road.
struct RoadEnd {
  int road = 0;
  bool at_end = false;
};

void set_link(RoadMap& map, RoadEnd end, RoadLink link) {
  Road& road = map.roads[at(end.road)];
  (end.at_end ? road.successor : road.predecessor) = link;
}

roadquery::Lane& lane_of(Road& road, int id) {
  roadquery::LaneSection& section = road.sections.front();
  return id > 0 ? section.left[at(id - 1)] : section.right[at(-id - 1)];
}

/// Lanes that leave `from` at its end and go on in `to`, from the inside out.
void link_lanes(RoadMap& map, RoadEnd from, RoadEnd to) {
  Road &a = map.roads[at(from.road)], &b = map.roads[at(to.road)];
  const std::vector<int> out = lanes_of_direction(a, from.at_end), in = lanes_of_direction(b, !to.at_end);
  for (std::size_t i = 0; i < std::min(out.size(), in.size()); ++i) {
    roadquery::Lane &lane_a = lane_of(a, out[i]), &lane_b = lane_of(b, in[i]);
    (from.at_end ? lane_a.successor : lane_a.predecessor) = in[i];
    (to.at_end ? lane_b.successor : lane_b.predecessor) = out[i];
  }
}

void link_roads(RoadMap& map, RoadEnd a, RoadEnd b) {
  const auto contact = [](RoadEnd e) { return e.at_end ? ContactPoint::end : ContactPoint::start; };
  set_link(map, a, {LinkKind::road, map.roads[at(b.road)].id, contact(b)});
  set_link(map, b, {LinkKind::road, map.roads[at(a.road)].id, contact(a)});
  link_lanes(map, a, b);
  link_lanes(map, b, a);
}

}  // namespace

std::vector<std::vector<JunctionEnd>> add_roads(const NetworkPlan& plan, RoadMap& map) {
  std::vector<std::vector<JunctionEnd>> ends(at(plan.junctions.junctions));
  const auto add_end = [&](int vertex, JunctionEnd end) {
    end.vertex = vertex;
    std::vector<JunctionEnd>& junction = ends[at(plan.junctions.junction_of_vertex[at(vertex)])];
    junction.push_back(end);
    return static_cast<int>(junction.size()) - 1;
  };
  const auto connect_through = [&](int vertex, int a, int b) {
    std::vector<JunctionEnd>& junction = ends[at(plan.junctions.junction_of_vertex[at(vertex)])];
    junction[at(a)].through = b;
    junction[at(b)].through = a;
  };

  // The ends between which a chain runs through a junction: the last one that was left, and the very first one for
  // closed chains.
  struct Open {
    int vertex = -1, end = -1;
  };
  Open left, first;
  int chain = -1;
  const auto close_chain = [&] {
    if (chain >= 0 && plan.geometry[at(chain)].closed && left.end >= 0 && first.end >= 0)
      connect_through(left.vertex, left.end, first.end);
  };
  for (std::size_t i = 0; i < plan.junctions.stretches.size(); ++i) {
    const Stretch& stretch = plan.junctions.stretches[i];
    if (stretch.chain != chain) {
      close_chain();
      chain = stretch.chain, left = first = {};
    }
    if (stretch.inside) continue;
    const ChainGeometry& geometry = plan.geometry[at(chain)];
    const std::vector<double> cuts = cuts_of(geometry, stretch);
    const int first_road = static_cast<int>(map.roads.size());
    std::vector<bool> reversed;
    for (std::size_t k = 0; k + 1 < cuts.size(); ++k) {
      map.roads.push_back(make_road(plan, chain, cuts[k], cuts[k + 1]));
      map.roads.back().id = static_cast<int>(map.roads.size());
      const std::size_t piece = piece_at(geometry, 0.5 * (cuts[k] + cuts[k + 1]));
      reversed.push_back(plan.topology.chains[at(chain)].pieces[piece].reversed);
    }
    const int last_road = static_cast<int>(map.roads.size()) - 1;
    const RoadEnd begin{first_road, reversed.front()}, end{last_road, !reversed.back()};
    for (std::size_t k = 0; k + 1 < reversed.size(); ++k)
      link_roads(map, {first_road + static_cast<int>(k), !reversed[k]},
                 {first_road + static_cast<int>(k) + 1, reversed[k + 1]});

    const int index = static_cast<int>(i);
    if (stretch.vertex0 >= 0) {
      const int e = add_end(stretch.vertex0, {begin.road, begin.at_end, 0, index, cuts.front()});
      if (left.end >= 0) connect_through(stretch.vertex0, left.end, e);
      else first = {stretch.vertex0, e};
    }
    left = {};
    if (stretch.vertex1 >= 0)
      left = {stretch.vertex1, add_end(stretch.vertex1, {end.road, end.at_end, 0, index, cuts.back()})};
    if (geometry.closed && stretch.vertex0 < 0) link_roads(map, end, begin);
  }
  close_chain();
  return ends;
}

}  // namespace orthodrive::network
