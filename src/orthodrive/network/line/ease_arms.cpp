// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/line/ease_arms.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>
#include <utility>

namespace orthodrive::network {
namespace {

using roadquery::Cubic;

constexpr double arm_fade_m = 20.0, longest_fade_m = 50.0, shortest_fade_m = 2.0;
constexpr double gradient_break = 0.02, banking_break = 0.01;
constexpr double longest_corner_m = 8.0;  // from the edge of the main road to the cut
constexpr double same_level_m = 1.5;
// What a change may be for each metre over which it fades out.
constexpr double height_per_m = 0.03, gradient_per_m = 0.006, banking_per_m = 0.0033;
constexpr double walking_pace = 2.0;  // roads too short for 20 m are driven slowly: banking may change by so many times

/// The chain that runs through a vertex.
struct Main {
  ChainIndex chain;
  double s = 0.0;
};

/// Of the chains through each vertex the one of the highest class, then the widest; where none goes through, of those
/// that end there.
Table<VertexIndex, std::optional<Main>> main_chains(const RoadNetwork& roads, const Topology& topology,
                                                    const ChainGeometries& geometry) {
  Table<VertexIndex, std::optional<Main>> mains(topology.vertices.size());
  const auto ends = [&](const Main& main) { return main.s <= 0.0 || main.s >= geometry[main.chain].length_m; };
  const auto rank = [&](const Main& main) {
    const DirectedPiece piece = topology.chains[main.chain].pieces[piece_at(geometry[main.chain], main.s)];
    return std::tuple(!ends(main), road_rank(roads.paths[topology.pieces[piece.piece].path].highway),
                      width_at(geometry[main.chain], main.s));
  };
  const auto consider = [&](VertexIndex vertex, const Main& main) {
    std::optional<Main>& best = mains[vertex];
    if (!best || rank(*best) < rank(main)) best = main;
  };
  for (const ChainIndex c : topology.chains.indices()) {
    const Chain& chain = topology.chains[c];
    if (geometry[c].empty()) continue;
    for (std::size_t k = 0; k < chain.pieces.size(); ++k)
      if (k > 0 || !geometry[c].closed) consider(start_vertex(topology, chain.pieces[k]), {c, geometry[c].vertex_s[k]});
    if (!geometry[c].closed) consider(end_vertex(topology, chain.pieces.back()), {c, geometry[c].length_m});
  }
  return mains;
}

/// The main road's surface, carried on beyond its edge.
struct MainSurface {
  double z = 0.0;
  Vec2 slope;             ///< in x and y
  double beyond_m = 0.0;  ///< of the edge; not positive on the carriageway
};

MainSurface surface_at(const ChainGeometry& chain, double s, Vec2 p) {
  constexpr int iterations = 3;
  Pose pose = pose_at(chain.plan, s);
  for (int i = 0; i < iterations; ++i) {
    s = std::clamp(s + dot(p - pose.p, pose.direction), 0.0, plan_length(chain.plan));
    pose = pose_at(chain.plan, s);
  }
  const double t = cross(pose.direction, p - pose.p), side = t < 0.0 ? -1.0 : 1.0;
  const double across = std::tan(value_at(chain.superelevation, s)) - side * value_at(chain.crown, s);
  const double along = slope_at(chain.elevation, s), beyond_end_m = dot(p - pose.p, pose.direction);
  const Vec2 left = left_normal(pose.direction);
  return {value_at(chain.elevation, s) + beyond_end_m * along + t * across, pose.direction * along + left * across,
          std::abs(t) - 0.5 * width_at(chain, s)};
}

/// Who is the main road where stretches begin and end.
class MainRoads {
 public:
  MainRoads(const RoadNetwork& roads, const Topology& topology, const JunctionPlan& junctions,
            const ChainGeometries& geometry)
      : junctions_(junctions),
        geometry_(geometry),
        at_vertex_(main_chains(roads, topology, geometry)),
        in_junction_(static_cast<std::size_t>(junctions.junctions)) {
    for (const VertexIndex v : at_vertex_.indices()) {
      const int junction = junctions.junction_of_vertex[v];
      const std::optional<Main>& main = at_vertex_[v];
      if (junction >= 0 && main) in_junction_[static_cast<std::size_t>(junction)].push_back(*main);
    }
  }

  /// None where it is the chain itself. Where that came there from another main road within the junction and still lies
  /// beside its edge, that one; and where it lies beside the edge of another main road of the junction, nearer than to
  /// its own, that one. `p`: where the stretch is cut.
  [[nodiscard]] std::optional<Main> of(std::size_t i, bool at_s1, Vec2 p) const {
    std::optional<Main> main = own_or_before(i, at_s1, p);
    const Stretch& stretch = junctions_.stretches[i];
    if (!main || main->chain == stretch.chain) return main;
    double nearest_m = std::min(beyond_m(*main, p), beside_m);
    for (const Main& other : in_junction_[static_cast<std::size_t>(
             junctions_.junction_of_vertex[at_s1 ? stretch.vertex1 : stretch.vertex0])])
      if (const double away_m = beyond_m(other, p); other.chain != stretch.chain && away_m < nearest_m)
        main = other, nearest_m = away_m;
    return main;
  }

 private:
  static constexpr double beside_m = 7.5;  // corners are up to 6.8 m long (stretches.hpp)

  [[nodiscard]] double beyond_m(const Main& main, Vec2 p) const {
    return surface_at(geometry_[main.chain], main.s, p).beyond_m;
  }
  [[nodiscard]] std::optional<Main> own_or_before(std::size_t i, bool at_s1, Vec2 p) const {
    const std::vector<Stretch>& all = junctions_.stretches;
    const ChainIndex chain = all[i].chain;
    for (bool passed = false;; passed = true) {
      const VertexIndex vertex = at_s1 ? all[i].vertex1 : all[i].vertex0;
      if (!vertex) return std::nullopt;
      const std::optional<Main>& main = at_vertex_[vertex];
      if (!main) return std::nullopt;
      if (main->chain != chain || main->s != (at_s1 ? all[i].s1 : all[i].s0))
        return passed && beyond_m(*main, p) > beside_m ? std::nullopt : main;
      if (at_s1 ? i + 1 == all.size() : i == 0) return std::nullopt;
      i = at_s1 ? i + 1 : i - 1;
      if (all[i].chain != chain || !all[i].inside) return std::nullopt;
    }
  }

  const JunctionPlan& junctions_;
  const ChainGeometries& geometry_;
  Table<VertexIndex, std::optional<Main>> at_vertex_;
  std::vector<std::vector<Main>> in_junction_;
};

double limited(double value, double limit) { return std::clamp(value, -limit, limit); }

struct Change {
  double z = 0.0, gradient = 0.0, banking = 0.0, crown = 0.0;  ///< along the chain
};

/// The length over which a change may fade out.
double fade_of(const Change& change) {
  return std::max({std::abs(change.z) / height_per_m, std::abs(change.gradient) / gradient_per_m,
                   std::abs(change.banking) / banking_per_m, std::abs(change.crown) / banking_per_m});
}

/// What of a change may fade out over a length that there is.
Change within(const Change& change, double fade) {
  const double slow = fade < arm_fade_m ? walking_pace : 1.0;
  return {limited(change.z, height_per_m * fade), limited(change.gradient, gradient_per_m * fade),
          limited(change.banking, slow * banking_per_m * fade), limited(change.crown, slow * banking_per_m * fade)};
}

/// What is to be added at the cut `s` of a chain that ends at the main road or crosses it; nothing where it lies well.
std::optional<Change> wanted_change(const ChainGeometry& side, double s, bool at_s1, const ChainGeometry& main,
                                    double main_s) {
  const Pose pose = pose_at(side.plan, s);
  const Vec2 in = at_s1 ? pose.direction : pose.direction * -1.0;
  const MainSurface surface = surface_at(main, main_s, pose.p);
  const double sign = at_s1 ? 1.0 : -1.0;
  const double z = value_at(side.elevation, s), gradient = sign * slope_at(side.elevation, s);
  const double banking = sign * std::tan(value_at(side.superelevation, s));
  if (std::abs(z - surface.z) > same_level_m) return std::nullopt;
  const double along = dot(surface.slope, in), across = dot(surface.slope, left_normal(in));
  const double wanted_gradient = along + limited(gradient - along, gradient_break);
  const double wanted_banking = across + limited(banking - across, banking_break);
  const double corner = std::clamp(surface.beyond_m, 0.0, longest_corner_m);
  const double wanted_z = surface.z - 0.5 * corner * (wanted_gradient - along);
  const Change change{wanted_z - z, sign * (wanted_gradient - gradient),
                      sign * (std::atan(wanted_banking) - std::atan(banking)), -value_at(side.crown, s)};
  constexpr double no_height_m = 0.01, no_slope = 0.005;
  if (std::abs(change.z) < no_height_m && std::abs(change.gradient) < no_slope && std::abs(change.banking) < no_slope &&
      std::abs(change.crown) < no_slope)
    return std::nullopt;
  return change;
}

/// The change at one end of a stretch.
struct Eased {
  double cut = 0.0;
  double fade_end = 0.0;  ///< where on the stretch it has faded out; at the cut where nothing changes
  Change change;
};
struct EasedEnds {
  Eased begin, end;
};

/// Adds to a profile what `part` of the changes says (value, slope), fading out along the stretch.
template <typename Part>
void add_fading(std::vector<Cubic>& cubics, const Eased& eased, const Part& part) {
  const auto [value, slope] = part(eased.change);
  if (value == 0.0 && slope == 0.0) return;
  const double end = eased.fade_end;
  if (end > eased.cut)
    add_cubic(cubics, hermite(eased.cut, end, value, 0.0, slope, 0.0), end);
  else
    add_cubic(cubics, hermite(end, eased.cut, 0.0, value, 0.0, slope), eased.cut);
}

/// Through a junction from the changes at one cut to those at the other.
template <typename Part>
void add_between(std::vector<Cubic>& cubics, const Eased& from, const Eased& to, const Part& part) {
  const auto [value0, slope0] = part(from.change);
  const auto [value1, slope1] = part(to.change);
  if (value0 == 0.0 && slope0 == 0.0 && value1 == 0.0 && slope1 == 0.0) return;
  add_cubic(cubics, hermite(from.cut, to.cut, value0, value1, slope0, slope1), to.cut);
}

/// At an end of the chain the change goes on straight beyond the cut, for what the junction sees of it.
template <typename Part>
void add_beyond(std::vector<Cubic>& cubics, const Eased& eased, double chain_end, const Part& part) {
  const auto [value, slope] = part(eased.change);
  if (value == 0.0 && slope == 0.0) return;
  const double low = std::min(eased.cut, chain_end), high = std::max(eased.cut, chain_end);
  add_cubic(cubics, {low, value + slope * (low - eased.cut), slope, 0.0, 0.0}, high);
}

/// Of one profile of a chain, whose stretches outside junctions have these ends.
template <typename Part>
void change_profile(std::vector<Cubic>& cubics, const std::vector<EasedEnds>& stretches, double length_m,
                    const Part& part) {
  for (std::size_t i = 0; i < stretches.size(); ++i) {
    add_fading(cubics, stretches[i].begin, part);
    add_fading(cubics, stretches[i].end, part);
    if (i > 0) add_between(cubics, stretches[i - 1].end, stretches[i].begin, part);
  }
  add_beyond(cubics, stretches.front().begin, 0.0, part);
  add_beyond(cubics, stretches.back().end, length_m, part);
}

}  // namespace

void ease_arms(const RoadNetwork& roads, const Topology& topology, const JunctionPlan& junctions,
               const std::vector<std::vector<double>>& cuts, ChainGeometries& geometry) {
  const MainRoads mains(roads, topology, junctions, geometry);
  Table<ChainIndex, std::vector<EasedEnds>> eased(geometry.size());
  for (std::size_t i = 0; i < junctions.stretches.size(); ++i) {
    const Stretch& stretch = junctions.stretches[i];
    const ChainGeometry& side = geometry[stretch.chain];
    if (stretch.inside || side.closed) continue;
    const double begin = cuts[i].front(), end = cuts[i].back();
    const auto wanted_at = [&](bool at_s1) -> std::optional<Change> {
      const double cut = at_s1 ? end : begin;
      const std::optional<Main> main = mains.of(i, at_s1, pose_at(side.plan, cut).p);
      if (!main) return std::nullopt;
      return wanted_change(side, cut, at_s1, geometry[main->chain], main->s);
    };
    const std::optional<Change> at_begin = wanted_at(false), at_end = wanted_at(true);
    const double room = at_begin && at_end ? 0.5 * (end - begin) : end - begin;
    EasedEnds ends{{begin, begin, {}}, {end, end, {}}};
    const auto ease = [&](Eased& at, bool at_s1, const std::optional<Change>& wanted) {
      if (!wanted || room < shortest_fade_m) return;
      const double fade = std::min(room, std::clamp(fade_of(*wanted), arm_fade_m, longest_fade_m));
      at = {at.cut, at.cut + (at_s1 ? -fade : fade), within(*wanted, fade)};
    };
    ease(ends.begin, false, at_begin), ease(ends.end, true, at_end);
    eased[stretch.chain].push_back(ends);
  }
  for (const ChainIndex c : eased.indices()) {
    if (eased[c].empty()) continue;
    ChainGeometry& side = geometry[c];
    using Part = std::pair<double, double>;
    change_profile(side.elevation, eased[c], side.length_m, [](const Change& x) { return Part{x.z, x.gradient}; });
    change_profile(side.superelevation, eased[c], side.length_m, [](const Change& x) { return Part{x.banking, 0.0}; });
    change_profile(side.crown, eased[c], side.length_m, [](const Change& x) { return Part{x.crown, 0.0}; });
  }
}

}  // namespace orthodrive::network
