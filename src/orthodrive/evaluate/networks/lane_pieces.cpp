// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/evaluate/networks/lane_pieces.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <tuple>

namespace orthodrive::evaluate {
namespace {

using roadquery::ContactPoint;
using roadquery::Lane;
using roadquery::LinkKind;
using roadquery::Road;
using roadquery::RoadMap;
using roadquery::RoadsById;

class Pieces {
 public:
  Pieces(const RoadMap& map, const RoadsById& by_id) : map_(map), by_id_(by_id) {
    for (const roadquery::Junction& junction : map.junctions) junctions_[junction.id] = &junction;
    for (const Road& road : map.roads) add(road);
    for (LanePiece& piece : pieces_) link(piece);
  }
  std::vector<LanePiece> take() { return std::move(pieces_); }

 private:
  using Key = std::tuple<const Road*, std::size_t, int, bool>;  // road, section, lane, whether along s

  void add(const Road& road) {
    for (std::size_t k = 0; k < road.sections.size(); ++k) {
      const roadquery::LaneSection& section = road.sections[k];
      const double end = k + 1 < road.sections.size() ? road.sections[k + 1].s : road.length;
      if (!(end > section.s)) continue;
      for (const auto* side : {&section.left, &section.right})
        for (const Lane& lane : *side) {
          const bool forward = (lane.id < 0) != (road.driving_side == roadquery::DrivingSide::left);
          const auto add_piece = [&](bool along) {
            index_[{&road, k, lane.id, along}] = pieces_.size();
            pieces_.push_back({&road, k, &lane, section.s, end, along, {}});
          };
          if (lane.type == roadquery::LaneType::driving) add_piece(forward);
          // Of roads without another one: turn lanes between the directions lead nowhere on.
          if (lane.type == roadquery::LaneType::bidirectional && is_shared(section)) add_piece(true), add_piece(false);
        }
    }
  }

  static bool is_shared(const roadquery::LaneSection& section) {
    const auto drives = [](const Lane& lane) { return lane.type == roadquery::LaneType::driving; };
    return std::ranges::none_of(section.left, drives) && std::ranges::none_of(section.right, drives);
  }

  void add_next(LanePiece& piece, const Road& road, std::size_t section, int lane, bool enter_forward) {
    const auto found = index_.find({&road, section, lane, enter_forward});
    if (found != index_.end()) piece.next.push_back(found->second);
  }
  void enter(LanePiece& piece, int road_id, ContactPoint contact, int lane) {
    const auto index = by_id_.find(road_id);
    if (!index) return;
    const Road& road = map_.roads[*index];
    const bool at_start = contact == ContactPoint::start;
    add_next(piece, road, at_start ? 0 : road.sections.size() - 1, lane, at_start);
  }

  void link(LanePiece& piece) {
    const Road& road = *piece.road;
    const std::optional<int> lane = piece.forward ? piece.lane->successor : piece.lane->predecessor;
    const bool last = piece.forward ? piece.section + 1 == road.sections.size() : piece.section == 0;
    if (!last) {
      if (lane) add_next(piece, road, piece.forward ? piece.section + 1 : piece.section - 1, *lane, piece.forward);
      return;
    }
    const roadquery::RoadLink& exit = piece.forward ? road.successor : road.predecessor;
    if (exit.kind == LinkKind::road && lane) enter(piece, exit.id, exit.contact, *lane);
    if (exit.kind != LinkKind::junction) return;
    const auto junction = junctions_.find(exit.id);
    if (junction == junctions_.end()) return;
    for (const roadquery::Connection& connection : junction->second->connections) {
      if (connection.incoming_road != road.id || !begins_here(connection, road, piece.forward)) continue;
      for (const roadquery::LaneLink& l : connection.lane_links)
        if (l.from == piece.lane->id) enter(piece, connection.connecting_road, connection.contact, l.to);
    }
  }

  /// A road with both ends in one junction has connections from either.
  [[nodiscard]] bool begins_here(const roadquery::Connection& connection, const Road& road, bool at_end) const {
    const auto index = by_id_.find(connection.connecting_road);
    if (!index) return false;
    const Road& connecting = map_.roads[*index];
    const roadquery::RoadLink& from =
        connection.contact == ContactPoint::start ? connecting.predecessor : connecting.successor;
    return from.kind != LinkKind::road ||
           (from.id == road.id && from.contact == (at_end ? ContactPoint::end : ContactPoint::start));
  }

  const RoadMap& map_;
  const RoadsById& by_id_;
  std::map<int, const roadquery::Junction*> junctions_;
  std::map<Key, std::size_t> index_;
  std::vector<LanePiece> pieces_;
};

}  // namespace

std::vector<LanePiece> lane_pieces(const RoadMap& map, const RoadsById& by_id) { return Pieces(map, by_id).take(); }

LanePlace lane_place(const LanePiece& piece, double s) {
  const Road& road = *piece.road;
  const roadquery::LaneSection& section = road.sections[piece.section];
  const double in_section = s - section.s, side = piece.lane->id > 0 ? 1.0 : -1.0;
  double centre = roadquery::evaluate(road.lane_offset, s), slope = roadquery::derivative(road.lane_offset, s);
  LanePlace place;
  for (const Lane& lane : piece.lane->id > 0 ? section.left : section.right) {
    const double width = roadquery::lane_width(lane, in_section), rate = roadquery::derivative(lane.width, in_section);
    const double share = lane.id == piece.lane->id ? 0.5 : 1.0;
    centre += side * share * width, slope += side * share * rate;
    if (lane.id != piece.lane->id) continue;
    place.width_m = width;
    break;
  }
  const roadquery::PlanPoint& reference = place.reference = roadquery::reference_point(road, s);
  const double stretch = 1.0 - centre * reference.curvature;  // of the lane's middle over the reference line
  place.centre_t = centre;
  place.heading_rad = reference.hdg + std::atan2(slope, stretch) + (piece.forward ? 0.0 : std::numbers::pi);
  place.curvature = (piece.forward ? 1.0 : -1.0) * (std::abs(stretch) > 1e-3 ? reference.curvature / stretch : 0.0);
  return place;
}

}  // namespace orthodrive::evaluate
