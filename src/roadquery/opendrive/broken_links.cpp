// SPDX-License-Identifier: Apache-2.0
#include "roadquery/opendrive/broken_links.hpp"

#include <algorithm>
#include <optional>
#include <set>
#include <string>
#include <unordered_map>

namespace roadquery {
namespace {

bool has_lane(const LaneSection& section, int id) {
  if (id == 0) return true;
  const std::vector<Lane>& side = id > 0 ? section.left : section.right;
  return std::any_of(side.begin(), side.end(), [id](const Lane& lane) { return lane.id == id; });
}

class Links {
 public:
  Links(const RoadMap& map, NoteList& notes) : notes_(notes) {
    roads_.reserve(map.roads.size());
    for (const Road& road : map.roads) roads_.emplace(road.id, &road);
    for (const Junction& junction : map.junctions) junctions_.insert(junction.id);
  }

  void check(const Road& road) {
    check_end(road, road.predecessor, 0.0);
    check_end(road, road.successor, road.length);
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
        add("connections of junctions name a <road> that the file does not have: they lead nowhere",
            {via        ? via->id
             : incoming ? incoming->id
                        : -1,
             0.0});
        continue;
      }
      const LaneSection& entry =
          connection.contact == ContactPoint::start ? via->sections.front() : via->sections.back();
      for (const LaneLink& link : connection.lane_links) {
        const bool left = incoming == nullptr || has_lane(incoming->sections.front(), link.from) ||
                          has_lane(incoming->sections.back(), link.from);
        if (!left || !has_lane(entry, link.to)) add_lane({via->id, 0.0});
      }
    }
  }

 private:
  [[nodiscard]] const Road* find(int id) const {
    const auto found = roads_.find(id);
    return found == roads_.end() ? nullptr : found->second;
  }

  /// The lanes behind an end of a road: none where a junction is, or nothing.
  [[nodiscard]] const LaneSection* neighbour(const RoadLink& link) const {
    const Road* road = link.kind == LinkKind::road ? find(link.id) : nullptr;
    if (road == nullptr) return nullptr;
    return link.contact == ContactPoint::start ? &road->sections.front() : &road->sections.back();
  }

  void check_end(const Road& road, const RoadLink& link, double s) {
    if (link.kind == LinkKind::road && find(link.id) == nullptr)
      add("links of roads name a <road> that the file does not have: they lead nowhere", {road.id, s});
    if (link.kind == LinkKind::junction && !junctions_.contains(link.id))
      add("links of roads name a <junction> that the file does not have: they lead nowhere", {road.id, s});
  }

  void check_lane(const Road& road, const LaneSection* beyond, const std::optional<int>& linked, double s) {
    if (beyond != nullptr && linked && !has_lane(*beyond, *linked)) add_lane({road.id, s});
  }

  void add_lane(NotePlace place) {
    add("links of lanes name a <lane> that is not on the other side: they lead nowhere", place);
  }
  void add(const char* what, NotePlace place) { notes_.add("opendrive.broken_link", what, true, place); }

  NoteList& notes_;
  std::unordered_map<int, const Road*> roads_;
  std::set<int> junctions_;
};

}  // namespace

void note_broken_links(const RoadMap& map, NoteList& notes) {
  Links links(map, notes);
  for (const Road& road : map.roads) links.check(road);
  for (const Junction& junction : map.junctions) links.check(junction);
}

}  // namespace roadquery
