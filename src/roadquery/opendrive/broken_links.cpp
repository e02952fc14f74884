// SPDX-License-Identifier: Apache-2.0
#include "roadquery/opendrive/broken_links.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "roadquery/roads/road_ends.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace roadquery {
namespace {

using Kind = BrokenLink::Kind;

constexpr double most_apart_m = 0.1;        // more than any rounding between the ends of two reference lines
constexpr double least_lane_m = 0.5;        // narrower lanes begin or end there
constexpr double least_before_share = 0.1;  // of the narrower lane's width that lies before the other one

bool has_lane(const LaneSection& section, int id) { return id == 0 || find_lane(section, id) != nullptr; }

bool drives_along(const Road& road, int lane_id) { return (lane_id < 0) == (road.driving_side == DrivingSide::right); }

bool has_cross_section(const Road& road) { return !road.superelevation.empty() || !road.shape.empty(); }

/// The lanes at one end of a section.
struct SectionEnd {
  const Road* road = nullptr;
  const LaneSection* section = nullptr;
  double s = 0.0;
  bool turned = false;    ///< seen against the direction of its road
  double beside_m = 0.0;  ///< of its reference line, to the left of the one that it is seen from

  /// Both borders of a lane as t of the road that the end is seen from, the smaller one first.
  [[nodiscard]] std::array<double, 2> span(const Lane& lane) const {
    const double sign = lane.id > 0 ? 1.0 : -1.0;
    double inner = evaluate(road->lane_offset, s), outer = inner;
    for (const Lane& other : lane.id > 0 ? section->left : section->right) {
      inner = outer, outer += sign * lane_width(other, s - section->s);
      if (other.id == lane.id) break;
    }
    if (turned) inner = -inner, outer = -outer;
    return {beside_m + std::min(inner, outer), beside_m + std::max(inner, outer)};
  }
};

/// Whether two lanes lie one behind the other, as far as they are wide.
bool meet(std::array<double, 2> a, std::array<double, 2> b) {
  const double narrower = std::min(a[1] - a[0], b[1] - b[0]);
  return narrower < least_lane_m || std::min(a[1], b[1]) - std::max(a[0], b[0]) >= least_before_share * narrower;
}

class Links {
 public:
  explicit Links(const RoadMap& map) : map_(map), by_id_(map) {
    for (const Junction& junction : map.junctions) junctions_.insert(junction.id);
    for (const Road& road : map.roads) check(road);
    for (const Junction& junction : map.junctions) check(junction);
  }
  std::vector<BrokenLink> take() { return std::move(broken_); }

 private:
  void check(const Road& road) {
    const RoadEnd begin{&road, ContactPoint::start}, finish{&road, ContactPoint::end};
    check_end(begin);
    check_end(finish);
    for (std::size_t i = 0; i < road.sections.size(); ++i) {
      const LaneSection& section = road.sections[i];
      const bool first = i == 0, last = i + 1 == road.sections.size();
      const SectionEnd start{&road, &section, section.s},
          end{&road, &section, last ? road.length : road.sections[i + 1].s};
      const SectionEnd before = first ? neighbour(begin) : SectionEnd{&road, &road.sections[i - 1], section.s};
      const SectionEnd after = last ? neighbour(finish) : SectionEnd{&road, &road.sections[i + 1], end.s};
      for (const auto* side : {&section.left, &section.right})
        for (const Lane& lane : *side) {
          check_lane(start, lane, lane.predecessor, before);
          check_lane(end, lane, lane.successor, after);
        }
    }
  }

  void check(const Junction& junction) {
    for (const Connection& connection : junction.connections) {
      const Road* via = find(connection.connecting_road);
      const Road* incoming = find(connection.incoming_road);
      // 0 stands for no incoming road, too, as virtual junctions have it.
      if (via == nullptr || (incoming == nullptr && connection.incoming_road != 0)) {
        add(Kind::connection, {via ? via->id : incoming ? incoming->id : -1, 0.0});
        continue;
      }
      const RoadEnd entry{via, connection.contact};
      for (const LaneLink& link : connection.lane_links) {
        const bool left = incoming == nullptr || has_lane(incoming->sections.front(), link.from) ||
                          has_lane(incoming->sections.back(), link.from);
        if (!left || !has_lane(entry.section(), link.to)) add(Kind::lane, {via->id, 0.0});
        if (via->junction == junction.id) check_entry(entry, find_lane(entry.section(), link.to));
      }
    }
  }

  [[nodiscard]] const Road* find(int id) const {
    const auto found = by_id_.find(id);
    return found ? &map_.roads[*found] : nullptr;
  }

  /// The lanes behind an end of a road: none where a junction is, or nothing.
  [[nodiscard]] SectionEnd neighbour(const RoadEnd& end) const {
    const Road* road = end.link().kind == LinkKind::road ? find(end.link().id) : nullptr;
    if (road == nullptr) return {};
    const RoadEnd beyond{road, end.link().contact};
    const PlanPoint at = reference_point(*end.road, end.s()), behind = reference_point(*road, beyond.s());
    const double beside_m = (behind.y - at.y) * std::cos(at.hdg) - (behind.x - at.x) * std::sin(at.hdg);
    return {road, &beyond.section(), beyond.s(), beyond.contact == end.contact, beside_m};
  }

  /// Roads of junctions may begin beside the reference line of the road that leads to them.
  void check_reference_lines(const RoadEnd& end, const Road& other) {
    if (end.road->junction != -1 || other.junction != -1) return;
    const PlanPoint a = reference_point(*end.road, end.s()),
                    b = reference_point(other, RoadEnd{&other, end.link().contact}.s());
    if (std::hypot(a.x - b.x, a.y - b.y) > most_apart_m) add(Kind::apart, {end.road->id, end.s()});
  }

  void check_end(const RoadEnd& end) {
    const RoadLink& link = end.link();
    const NotePlace place{end.road->id, end.s()};
    if (link.kind == LinkKind::junction && !junctions_.contains(link.id)) add(Kind::junction, place);
    if (link.kind != LinkKind::road) return;
    if (const Road* other = find(link.id))
      check_reference_lines(end, *other);
    else
      add(Kind::road, place);
  }

  /// A car gets onto a lane of a connecting road where that begins to lead. Some writers list both ends of the road.
  void check_entry(const RoadEnd& entry, const Lane* lane) {
    if (lane == nullptr || lane->type != LaneType::driving) return;
    if (drives_along(*entry.road, lane->id) != (entry.contact == ContactPoint::start))
      add(Kind::against, {entry.road->id, entry.s()}, false);
  }

  void check_lane(const SectionEnd& at, const Lane& lane, const std::optional<int>& linked, const SectionEnd& beyond) {
    if (beyond.section == nullptr || !linked || *linked == 0) return;
    const NotePlace place{at.road->id, at.s};
    const Lane* other = find_lane(*beyond.section, *linked);
    if (other == nullptr) return add(Kind::lane, place);
    if (lane.level != other->level)
      add(Kind::level, place, has_cross_section(*at.road) || has_cross_section(*beyond.road));
    // Lanes of junctions are led to where they begin.
    if (at.road->junction != -1 || beyond.road->junction != -1) return;
    if (!meet(at.span(lane), beyond.span(*other))) add(Kind::beside, place, is_driven(lane.type));
  }

  void add(Kind kind, NotePlace where, bool bears = true) { broken_.push_back({kind, where, bears}); }

  const RoadMap& map_;
  RoadsById by_id_;
  std::set<int> junctions_;
  std::vector<BrokenLink> broken_;
};

struct LinkNote {
  const char* code = "opendrive.broken_link";
  const char* text = "";
};

LinkNote note_of(Kind kind) {
  constexpr const char* wrong = "opendrive.wrong_link";
  switch (kind) {
    case Kind::road:
      return {.text = "links of roads name a <road> that the file does not have: they lead nowhere"};
    case Kind::junction:
      return {.text = "links of roads name a <junction> that the file does not have: they lead nowhere"};
    case Kind::connection:
      return {.text = "connections of junctions name a <road> that the file does not have: they lead nowhere"};
    case Kind::lane:
      return {.text = "links of lanes name a <lane> that is not on the other side: they lead nowhere"};
    case Kind::apart:
      return {wrong,
              "reference lines of roads that are linked do not meet at their contactPoint: look which end is meant"};
    case Kind::against:
      return {wrong, "connections of junctions lead onto a lane against its direction: nobody drives there"};
    case Kind::beside:
      return {wrong, "lanes are linked that lie beside each other: whoever drives there jumps aside"};
    case Kind::level:
      break;
  }
  return {"opendrive.level",
          "lanes with level=\"true\" are linked to lanes without it: they are level as far as they say so"};
}

}  // namespace

std::vector<BrokenLink> broken_links(const RoadMap& map) { return Links(map).take(); }

void note_broken_links(const RoadMap& map, NoteList& notes) {
  for (const BrokenLink& link : broken_links(map)) {
    const LinkNote note = note_of(link.kind);
    notes.add(note.code, note.text, link.bears, link.where);
  }
}

}  // namespace roadquery
