// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/line/raise_humps.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "orthodrive/model/roads/traffic_calming.hpp"
#include "orthodrive/network/curves/fit_plan.hpp"

namespace orthodrive::network {
namespace {

constexpr double off_junction_m = 1.0, off_road_end_m = 0.5;
constexpr double same_break_m = 1e-6;
constexpr double shortest_plateau_m = 1.0;  // of a way that is a table
constexpr double longer_share = 3.0;        // of a way than a hump that lies somewhere on it

/// Where a hump is wished: its middle on a chain.
struct Wish {
  ChainIndex chain;
  double s = 0.0, plateau_m = 0.0;
  const HumpProfile* profile = nullptr;
  std::string of;  ///< "node 5"
  Vec2 p;

  [[nodiscard]] double length_m() const { return profile->length_m() - profile->plateau_m + plateau_m; }
};

class HumpRaiser {
 public:
  HumpRaiser(const RoadNetwork& roads, const Topology& topology, const JunctionPlan& junctions,
             const std::vector<std::vector<double>>& cuts, ChainGeometries& geometry, Findings& findings)
      : roads_(roads),
        topology_(topology),
        junctions_(junctions),
        cuts_(cuts),
        geometry_(geometry),
        findings_(findings) {
    for (const ChainIndex c : topology.chains.indices())
      for (std::size_t k = 0; k < topology.chains[c].pieces.size(); ++k)
        if (!geometry[c].empty()) place_of_piece_.try_emplace(topology.chains[c].pieces[k].piece, c, k);
  }

  std::vector<RaisedHump> run() {
    of_nodes();
    for (const auto& [piece, place] : place_of_piece_) of_way(piece);
    return std::move(raised_);
  }

 private:
  void leave_out(const Wish& wish, const std::string& why) {
    findings_.push_back({Severity::info, "network.hump_left_out",
                         fmt::format("{}: traffic_calming={} is left out, {}", wish.of, wish.profile->value, why),
                         wish.p.x, wish.p.y});
  }

  void of_nodes() {
    std::map<std::int64_t, std::vector<const HumpProfile*>> wanted;
    for (const NodeSign& sign : roads_.signs)
      if (sign.kind == NodeSignKind::traffic_calming)
        if (const HumpProfile* profile = hump_profile(sign.value)) wanted[sign.osm_node].push_back(profile);
    if (wanted.empty()) return;
    for (const auto& [index, place] : place_of_piece_) {
      const PathPiece& piece = topology_.pieces[index];
      const RoadPath& path = roads_.paths[piece.path];
      for (std::size_t i = piece.first; i <= piece.last; ++i) {
        const auto here = wanted.find(path.nodes[i].osm_node);
        if (here == wanted.end()) continue;
        for (const HumpProfile* profile : here->second) {
          Wish wish{
              place.first,    s_of(index, place, i), profile->plateau_m, profile, fmt::format("node {}", here->first),
              path.nodes[i].p};
          const VertexIndex vertex = i == piece.first  ? piece.first_vertex
                                     : i == piece.last ? piece.last_vertex
                                                       : VertexIndex{};
          if (vertex && junctions_.junction_of_vertex[vertex] >= 0)
            leave_out(wish, "raised junctions are not built");
          else
            raise(wish);
        }
        wanted.erase(here);  // a node where two ways meet has one hump
      }
    }
  }

  void of_way(PieceIndex index) {
    const PathPiece& piece = topology_.pieces[index];
    const RoadPath& path = roads_.paths[piece.path];
    const HumpProfile* profile = hump_profile(path.traffic_calming);
    if (!profile) return;
    const auto& place = place_of_piece_.at(index);
    const double a = s_of(index, place, piece.first), b = s_of(index, place, piece.last), length = std::abs(b - a);
    Wish wish{place.first,
              0.5 * (a + b),
              profile->plateau_m,
              profile,
              fmt::format("way {}", path.osm_id),
              path.nodes[(piece.first + piece.last) / 2].p};
    if (profile->plateau_m > 0.0 && profile->value == "table") {
      const auto [low, high] = between_cuts(wish);
      const double from = std::max(low, std::min(a, b)), to = std::min(high, std::max(a, b));
      wish.s = 0.5 * (from + to), wish.plateau_m = std::max(to - from - 2.0 * profile->ramp_m, shortest_plateau_m);
      return raise(wish);
    }
    if (length > longer_share * profile->length_m())
      return leave_out(wish, fmt::format("where on its {:.0f} m it lies is not told; map it on a node", length));
    raise(wish);
  }

  /// On the chain, of a node of a piece.
  [[nodiscard]] double s_of(PieceIndex index, const std::pair<ChainIndex, std::size_t>& place, std::size_t node) const {
    const PathPiece& piece = topology_.pieces[index];
    const std::vector<RoadNode>& nodes = roads_.paths[piece.path].nodes;
    double before = 0.0, all = 0.0;
    for (std::size_t i = piece.first + 1; i <= piece.last; ++i) {
      all += distance(nodes[i - 1].p, nodes[i].p);
      if (i == node) before = all;
    }
    const double share = all > 0.0 ? before / all : 0.0;
    const auto& [chain, k] = place;
    const double s0 = geometry_[chain].vertex_s[k], s1 = geometry_[chain].vertex_s[k + 1];
    return s0 + (s1 - s0) * (topology_.chains[chain].pieces[k].reversed ? 1.0 - share : share);
  }

  /// Of the roads about a place; none, the wrong way round, where there is no road.
  [[nodiscard]] std::pair<double, double> between_cuts(const Wish& wish) const {
    for (std::size_t i = 0; i < junctions_.stretches.size(); ++i) {
      const Stretch& stretch = junctions_.stretches[i];
      if (stretch.chain != wish.chain || stretch.inside || cuts_[i].size() < 2) continue;
      if (wish.s < stretch.s0 - same_break_m || wish.s > stretch.s1 + same_break_m) continue;
      return {cuts_[i].front() + (stretch.vertex0 ? off_junction_m : off_road_end_m),
              cuts_[i].back() - (stretch.vertex1 ? off_junction_m : off_road_end_m)};
    }
    return {0.0, -1.0};
  }

  void raise(const Wish& wish) {
    const auto [low, high] = between_cuts(wish);
    const double length = wish.length_m(), half = 0.5 * length;
    if (high - low < length)
      return leave_out(wish, fmt::format("its {:.1f} m have no room between the junctions there", length));
    const double s = std::clamp(wish.s, low + half, high - half);
    std::vector<std::pair<double, double>>& taken = taken_[wish.chain];
    for (const auto& [from, to] : taken)
      if (s + half > from && s - half < to) return leave_out(wish, "another one lies there");
    taken.emplace_back(s - half, s + half);
    ChainGeometry& chain = geometry_[wish.chain];
    const HumpProfile& profile = *wish.profile;
    for (int round = 0; round < (chain.closed ? 2 : 1); ++round)
      for (int i = 0; i < profile.count; ++i)
        add_hump(chain.elevation, s - half + i * profile.pitch_m + round * chain.length_m, profile.ramp_m,
                 wish.plateau_m, profile.height_m);
    const Pose pose = pose_at(chain.plan, s);
    raised_.push_back({std::string(profile.value), pose.p, pose.direction, length, profile.height_m});
  }

  const RoadNetwork& roads_;
  const Topology& topology_;
  const JunctionPlan& junctions_;
  const std::vector<std::vector<double>>& cuts_;
  ChainGeometries& geometry_;
  Findings& findings_;
  std::map<PieceIndex, std::pair<ChainIndex, std::size_t>> place_of_piece_;
  std::map<ChainIndex, std::vector<std::pair<double, double>>> taken_;
  std::vector<RaisedHump> raised_;
};

}  // namespace

void add_hump(std::vector<roadquery::Cubic>& profile, double begin, double ramp_m, double plateau_m, double height_m) {
  const double top = begin + ramp_m, down = top + plateau_m, end = down + ramp_m;
  add_cubic(profile, hermite(begin, top, 0.0, height_m, 0.0, 0.0), top);
  if (plateau_m > 0.0) add_cubic(profile, {top, height_m, 0.0, 0.0, 0.0}, down);
  add_cubic(profile, hermite(down, end, height_m, 0.0, 0.0, 0.0), end);
}

std::vector<RaisedHump> raise_humps(const RoadNetwork& roads, const Topology& topology, const JunctionPlan& junctions,
                                    const std::vector<std::vector<double>>& cuts, ChainGeometries& geometry,
                                    Findings& findings) {
  return HumpRaiser(roads, topology, junctions, cuts, geometry, findings).run();
}

}  // namespace orthodrive::network
