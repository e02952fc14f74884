// SPDX-License-Identifier: Apache-2.0
#include "roadquery/roads/road_structures.hpp"

#include <algorithm>
#include <iterator>
#include <map>
#include <optional>

#include "roadquery/roads/later_start.hpp"

namespace roadquery {
namespace {

constexpr double rounding_of_ends_m = 0.5, rounding_share = 0.05;

double spare_m(const Road& road) { return std::max(rounding_of_ends_m, rounding_share * road.length); }

bool covers(const std::vector<RoadStretch>& stretches, const Road& road) {
  return std::any_of(stretches.begin(), stretches.end(), [&](const RoadStretch& stretch) {
    return road.length > 0.0 && stretch.s_start <= 0.5 * spare_m(road) &&
           stretch.s_end >= road.length - 0.5 * spare_m(road);
  });
}

bool holds(const std::vector<RoadStretch>& stretches, double s) {
  return std::any_of(stretches.begin(), stretches.end(),
                     [&](const RoadStretch& stretch) { return s >= stretch.s_start && s <= stretch.s_end; });
}

double length_of(const std::vector<RoadStretch>& stretches) {
  double sum = 0.0;
  for (const RoadStretch& stretch : stretches) sum += stretch.s_end - stretch.s_start;
  return sum;
}

/// Where the road is cut: 0, the ends of its structures, its length.
std::vector<double> cuts_of(const Road& road) {
  std::vector<double> ends;
  for (const auto* stretches : {&road.bridges, &road.tunnels})
    for (const RoadStretch& stretch : *stretches) ends.push_back(stretch.s_start), ends.push_back(stretch.s_end);
  std::sort(ends.begin(), ends.end());
  std::vector<double> cuts = {0.0};
  for (const double s : ends)
    if (s - cuts.back() > rounding_of_ends_m && road.length - s > rounding_of_ends_m) cuts.push_back(s);
  cuts.push_back(road.length);
  return cuts;
}

/// The first section of a piece begins where the piece does: its lanes' lists count from there.
void start_section_at_0(LaneSection& section) {
  const double by_m = -section.s;
  section.s = 0.0;
  start_lane_later(section.center, by_m);
  for (auto* side : {&section.left, &section.right})
    for (Lane& lane : *side) start_lane_later(lane, by_m);
}

/// Of the lanes at a cut: the same on its other side.
void link_to_itself(LaneSection& section, std::optional<int> Lane::*link) {
  for (auto* side : {&section.left, &section.right})
    for (Lane& lane : *side) lane.*link = lane.id;
}

/// Rows of shapes from the one that holds at `from` to the first one at `to` or behind it, which shapes lead to.
void keep_rows(std::vector<ShapeCubic>& shapes, double from, double to) {
  const auto by_s = [](double s, const ShapeCubic& shape) { return s < shape.s; };
  const auto behind = std::upper_bound(shapes.begin(), shapes.end(), from, by_s);
  const auto end_row = std::find_if(behind, shapes.end(), [&](const ShapeCubic& shape) { return shape.s >= to; });
  const auto end = end_row == shapes.end() ? shapes.end() : std::upper_bound(end_row, shapes.end(), end_row->s, by_s);
  auto begin = behind;
  while (begin != shapes.begin() && (begin - 1)->s == (behind - 1)->s) --begin;
  shapes = std::vector<ShapeCubic>(begin, end);
  for (ShapeCubic& shape : shapes) shape.s -= from;
}

void keep_objects(Road& piece, double from, double to, bool last) {
  std::erase_if(piece.objects, [&](const RoadObject& object) { return object.s < from || (object.s >= to && !last); });
  for (RoadObject& object : piece.objects) {
    object.s -= from;
    for (auto& corner : object.outline) corner[0] -= from;
  }
}

/// The road between two cuts, its s from 0 on. Lists may begin before 0: they are evaluated from where they began.
Road part_of(const Road& road, double from, double to) {
  Road piece = road;
  piece.length = to - from;
  piece.bridges.clear(), piece.tunnels.clear();
  const double middle = 0.5 * (from + to);
  piece.bridge = road.bridge || holds(road.bridges, middle), piece.tunnel = road.tunnel || holds(road.tunnels, middle);
  move_back(piece.plan, from, place_s);
  std::erase_if(piece.plan, [&](const PlanElement& element) { return element.s >= piece.length; });
  for (auto* cubics : {&piece.elevation, &piece.superelevation, &piece.lane_offset}) move_back(*cubics, from, place_s);
  keep_rows(piece.shape, from, to);
  move_back(piece.speed_limits, from, place_s);
  move_back(piece.sections, from, place_s);
  std::erase_if(piece.sections, [&](const LaneSection& section) {
    return section.s >= piece.length && &section != &piece.sections.front();
  });
  if (from > 0.0 && piece.sections.front().s < 0.0) {
    start_section_at_0(piece.sections.front());
    link_to_itself(piece.sections.front(), &Lane::predecessor);
  }
  const bool is_last = to >= road.length;
  if (!is_last) link_to_itself(piece.sections.back(), &Lane::successor);
  keep_objects(piece, from, to, is_last);
  return piece;
}

/// Gives the pieces of a road their numbers and links; where the last one has another number than the road, says so.
void chain_pieces(std::vector<Road>& pieces, int& next_id, std::map<int, int>& last_of) {
  const int id = pieces.front().id;
  const RoadLink successor = pieces.back().successor;
  for (std::size_t i = 1; i < pieces.size(); ++i) pieces[i].id = next_id++;
  for (std::size_t i = 0; i + 1 < pieces.size(); ++i) {
    pieces[i].successor = {LinkKind::road, pieces[i + 1].id, ContactPoint::start};
    pieces[i + 1].predecessor = {LinkKind::road, pieces[i].id, ContactPoint::end};
  }
  pieces.back().successor = successor;
  last_of[id] = pieces.back().id;
}

/// Links and connections that touch the end of a road that was cut touch its last piece.
void redirect(RoadMap& map, const std::map<int, int>& last_of, int first_piece_id) {
  std::map<int, std::vector<int>> touched;  // roads at the ends of a road, by its number
  const auto move = [&](RoadLink& link) {
    if (link.kind != LinkKind::road || link.contact != ContactPoint::end) return;
    const auto found = last_of.find(link.id);
    if (found != last_of.end()) link.id = found->second;
  };
  for (Road& road : map.roads) {
    if (road.id < first_piece_id) move(road.predecessor);  // pieces behind the first name each other already
    move(road.successor);
    for (const RoadLink* link : {&road.predecessor, &road.successor})
      if (link->kind == LinkKind::road) touched[road.id].push_back(link->id);
  }
  for (Junction& junction : map.junctions) {
    for (Connection& connection : junction.connections) {
      const auto found = last_of.find(connection.incoming_road);
      if (found == last_of.end()) continue;
      const std::vector<int>& ends = touched[connection.connecting_road];
      if (std::find(ends.begin(), ends.end(), found->second) != ends.end() &&
          std::find(ends.begin(), ends.end(), found->first) == ends.end())
        connection.incoming_road = found->second;
    }
  }
}

}  // namespace

void finish_structures(Road& road) {
  for (auto* stretches : {&road.bridges, &road.tunnels}) {
    for (RoadStretch& stretch : *stretches)
      stretch = {std::clamp(stretch.s_start, 0.0, std::max(road.length, 0.0)),
                 std::clamp(stretch.s_end, 0.0, std::max(road.length, 0.0))};
    std::erase_if(*stretches, [](const RoadStretch& stretch) { return !(stretch.s_end > stretch.s_start); });
    std::sort(stretches->begin(), stretches->end(),
              [](const RoadStretch& a, const RoadStretch& b) { return a.s_start < b.s_start; });
  }
  road.bridge = road.bridge || covers(road.bridges, road);
  road.tunnel = road.tunnel || covers(road.tunnels, road);
}

bool is_on_structure(const Road& road, double s) {
  return road.bridge || road.tunnel || holds(road.bridges, s) || holds(road.tunnels, s);
}

RoadMap cut_at_structures(RoadMap map) {
  int next_id = 0;
  for (const Road& road : map.roads) next_id = std::max(next_id, road.id + 1);
  for (const Junction& junction : map.junctions) next_id = std::max(next_id, junction.id + 1);
  const int first_piece_id = next_id;
  std::vector<Road> roads;
  std::map<int, int> last_of;
  for (Road& road : map.roads) {
    const std::vector<double> cuts = cuts_of(road);
    const bool whole = road.bridge || road.tunnel || (road.bridges.empty() && road.tunnels.empty());
    if (!whole && (road.junction >= 0 || !road.surface.empty())) {
      road.bridge = length_of(road.bridges) > 0.5 * road.length;
      road.tunnel = length_of(road.tunnels) > 0.5 * road.length;
    }
    if (whole || cuts.size() < 3 || road.junction >= 0 || !road.surface.empty()) {
      roads.push_back(std::move(road));
      continue;
    }
    std::vector<Road> pieces;
    for (std::size_t i = 0; i + 1 < cuts.size(); ++i) pieces.push_back(part_of(road, cuts[i], cuts[i + 1]));
    chain_pieces(pieces, next_id, last_of);
    roads.insert(roads.end(), std::make_move_iterator(pieces.begin()), std::make_move_iterator(pieces.end()));
  }
  map.roads = std::move(roads);
  if (last_of.empty()) return map;
  std::sort(map.roads.begin(), map.roads.end(), [](const Road& a, const Road& b) { return a.id < b.id; });
  redirect(map, last_of, first_piece_id);
  return map;
}

}  // namespace roadquery
