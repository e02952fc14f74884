// SPDX-License-Identifier: Apache-2.0
#include "roadquery/opendrive/broken_links.hpp"

#include <optional>
#include <set>
#include <utility>

#include "roadquery/roads/road_ends.hpp"

namespace roadquery {
namespace {

bool has_lane(const LaneSection& section, int id) { return id == 0 || find_lane(section, id) != nullptr; }

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
    check_end({&road, ContactPoint::start});
    check_end({&road, ContactPoint::end});
    for (std::size_t i = 0; i < road.sections.size(); ++i) {
      const bool first = i == 0, last = i + 1 == road.sections.size();
      const LaneSection* before = first ? neighbour(road.predecessor) : &road.sections[i - 1];
      const LaneSection* after = last ? neighbour(road.successor) : &road.sections[i + 1];
      for (const auto* side : {&road.sections[i].left, &road.sections[i].right})
        for (const Lane& lane : *side) {
          check_lane(road, before, lane.predecessor, road.sections[i].s);
          check_lane(road, after, lane.successor, last ? road.length : road.sections[i + 1].s);
        }
    }
  }

  void check(const Junction& junction) {
    for (const Connection& connection : junction.connections) {
      const Road* via = find(connection.connecting_road);
      const Road* incoming = find(connection.incoming_road);
      // 0 stands for no incoming road, too, as virtual junctions have it.
      if (via == nullptr || (incoming == nullptr && connection.incoming_road != 0)) {
        add(BrokenLink::Kind::connection, via ? via->id : incoming ? incoming->id : -1, 0.0);
        continue;
      }
      const LaneSection& entry = RoadEnd{via, connection.contact}.section();
      for (const LaneLink& link : connection.lane_links) {
        const bool left = incoming == nullptr || has_lane(incoming->sections.front(), link.from) ||
                          has_lane(incoming->sections.back(), link.from);
        if (!left || !has_lane(entry, link.to)) add(BrokenLink::Kind::lane, via->id, 0.0);
      }
    }
  }

  [[nodiscard]] const Road* find(int id) const {
    const auto found = by_id_.find(id);
    return found ? &map_.roads[*found] : nullptr;
  }

  /// The lanes behind an end of a road: none where a junction is, or nothing.
  [[nodiscard]] const LaneSection* neighbour(const RoadLink& link) const {
    const Road* road = link.kind == LinkKind::road ? find(link.id) : nullptr;
    return road == nullptr ? nullptr : &RoadEnd{road, link.contact}.section();
  }

  void check_end(const RoadEnd& end) {
    const RoadLink& link = end.link();
    if (link.kind == LinkKind::road && find(link.id) == nullptr) add(BrokenLink::Kind::road, end.road->id, end.s());
    if (link.kind == LinkKind::junction && !junctions_.contains(link.id))
      add(BrokenLink::Kind::junction, end.road->id, end.s());
  }

  void check_lane(const Road& road, const LaneSection* beyond, const std::optional<int>& linked, double s) {
    if (beyond != nullptr && linked && !has_lane(*beyond, *linked)) add(BrokenLink::Kind::lane, road.id, s);
  }

  void add(BrokenLink::Kind kind, int road, double s) { broken_.push_back({kind, {road, s}}); }

  const RoadMap& map_;
  RoadsById by_id_;
  std::set<int> junctions_;
  std::vector<BrokenLink> broken_;
};

const char* what_of(BrokenLink::Kind kind) {
  switch (kind) {
    case BrokenLink::Kind::road:
      return "links of roads name a <road> that the file does not have: they lead nowhere";
    case BrokenLink::Kind::junction:
      return "links of roads name a <junction> that the file does not have: they lead nowhere";
    case BrokenLink::Kind::connection:
      return "connections of junctions name a <road> that the file does not have: they lead nowhere";
    case BrokenLink::Kind::lane:
      break;
  }
  return "links of lanes name a <lane> that is not on the other side: they lead nowhere";
}

}  // namespace

std::vector<BrokenLink> broken_links(const RoadMap& map) { return Links(map).take(); }

void note_broken_links(const RoadMap& map, NoteList& notes) {
  for (const BrokenLink& link : broken_links(map))
    notes.add("opendrive.broken_link", what_of(link.kind), true, link.where);
}

}  // namespace roadquery
