#include "orthodrive/network/ease_arms.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace orthodrive::network {
namespace {

using roadquery::Cubic;

constexpr double fade_m = 20.0, shortest_fade_m = 3.0;
constexpr double gradient_break = 0.03, banking_break = 0.02;
constexpr double longest_corner_m = 8.0;  // from the edge of the main road to the cut
constexpr double same_level_m = 1.5;
// What a change may be for each metre over which it fades out.
constexpr double height_per_m = 0.03, gradient_per_m = 0.006, banking_per_m = 0.0033;

const Cubic* cubic_at(const std::vector<Cubic>& cubics, double s) {
  if (cubics.empty()) return nullptr;
  const auto after =
      std::upper_bound(cubics.begin(), cubics.end(), s, [](double v, const Cubic& c) { return v < c.s; });
  return &*(after == cubics.begin() ? after : after - 1);
}
double value_of(const std::vector<Cubic>& cubics, double s) {
  const Cubic* cubic = cubic_at(cubics, s);
  return cubic ? value_at(*cubic, s) : 0.0;
}
double slope_of(const std::vector<Cubic>& cubics, double s) {
  const Cubic* cubic = cubic_at(cubics, s);
  return cubic ? slope_at(*cubic, s) : 0.0;
}

/// The chain that runs through a vertex.
struct Main {
  ChainIndex chain;
  double s = 0.0;
};

/// Of the chains through each vertex the one of the highest class, then the widest.
Table<VertexIndex, std::optional<Main>> chains_through(const RoadNetwork& roads, const Topology& topology,
                                                       const ChainGeometries& geometry) {
  Table<VertexIndex, std::optional<Main>> through(topology.vertices.size());
  const auto rank = [&](const Main& main) {
    const DirectedPiece piece = topology.chains[main.chain].pieces[piece_at(geometry[main.chain], main.s)];
    return std::pair(road_rank(roads.paths[topology.pieces[piece.piece].path].highway),
                     width_at(geometry[main.chain], main.s));
  };
  for (const ChainIndex c : topology.chains.indices()) {
    const Chain& chain = topology.chains[c];
    if (geometry[c].empty()) continue;
    for (std::size_t k = 1; k < chain.pieces.size(); ++k) {
      const Main main{c, geometry[c].vertex_s[k]};
      std::optional<Main>& best = through[start_vertex(topology, chain.pieces[k])];
      if (!best || rank(*best) < rank(main)) best = main;
    }
  }
  return through;
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
  const double across = std::tan(value_of(chain.superelevation, s)) - side * value_of(chain.crown, s);
  const double along = slope_of(chain.elevation, s);
  const Vec2 left = left_normal(pose.direction);
  return {value_of(chain.elevation, s) + t * across, pose.direction * along + left * across,
          std::abs(t) - 0.5 * width_at(chain, s)};
}

/// Adds change, slope and value at `cut`, that fade out towards `end`; beyond the cut it goes on straight.
void add_change(std::vector<Cubic>& cubics, double cut, double end, double value, double slope) {
  if (cubics.empty()) cubics.push_back({});
  const auto split = [&](double s) {
    const auto after =
        std::upper_bound(cubics.begin(), cubics.end(), s, [](double v, const Cubic& c) { return v < c.s; });
    if (after == cubics.begin()) return;
    const Cubic before = *(after - 1);
    constexpr double same_m = 1e-9;
    if (s - before.s < same_m) return;
    const double ds = s - before.s;
    cubics.insert(after, {s, value_at(before, s), slope_at(before, s), before.c + 3.0 * before.d * ds, before.d});
  };
  split(cut), split(end);
  const bool forth = end > cut;  // the road lies beyond the cut
  const Cubic fade = forth ? hermite(cut, end, value, 0.0, slope, 0.0) : hermite(end, cut, 0.0, value, 0.0, slope);
  for (std::size_t i = 0; i < cubics.size(); ++i) {
    Cubic& c = cubics[i];
    const double middle = i + 1 < cubics.size() ? 0.5 * (c.s + cubics[i + 1].s) : c.s + 1e-6;
    if (forth ? middle > end : middle < end) continue;
    if (forth ? middle < cut : middle > cut) {
      c.a += value + slope * (c.s - cut), c.b += slope;
      continue;
    }
    const double ds = c.s - fade.s;
    c.a += value_at(fade, c.s), c.b += slope_at(fade, c.s), c.c += fade.c + 3.0 * fade.d * ds, c.d += fade.d;
  }
}

double limited(double value, double limit) { return std::clamp(value, -limit, limit); }

struct Change {
  double z = 0.0, gradient = 0.0, banking = 0.0;  ///< along the chain
};

/// What is to be added at the cut `s` of a chain that ends at the main road; nothing where it lies well.
std::optional<Change> change_at(const ChainGeometry& side, double s, bool at_s1, const ChainGeometry& main,
                                double main_s, double fade) {
  const Pose pose = pose_at(side.plan, s);
  const Vec2 in = at_s1 ? pose.direction : pose.direction * -1.0;
  const MainSurface surface = surface_at(main, main_s, pose.p);
  const double sign = at_s1 ? 1.0 : -1.0;
  const double z = value_of(side.elevation, s), gradient = sign * slope_of(side.elevation, s);
  const double banking = sign * std::tan(value_of(side.superelevation, s));
  if (std::abs(z - surface.z) > same_level_m) return std::nullopt;
  const double along = dot(surface.slope, in), across = dot(surface.slope, left_normal(in));
  const double wanted_gradient = along + limited(gradient - along, gradient_break);
  const double wanted_banking = across + limited(banking - across, banking_break);
  const double corner = std::clamp(surface.beyond_m, 0.0, longest_corner_m);
  const double wanted_z = surface.z - 0.5 * corner * (wanted_gradient - along);
  const Change change{limited(wanted_z - z, height_per_m * fade),
                      sign * limited(wanted_gradient - gradient, gradient_per_m * fade),
                      sign * limited(std::atan(wanted_banking) - std::atan(banking), banking_per_m * fade)};
  constexpr double no_height_m = 0.01, no_slope = 0.005;
  if (std::abs(change.z) < no_height_m && std::abs(change.gradient) < no_slope && std::abs(change.banking) < no_slope)
    return std::nullopt;
  return change;
}

}  // namespace

void ease_arms(const RoadNetwork& roads, const Topology& topology, const JunctionPlan& junctions,
               const std::vector<std::vector<double>>& cuts, ChainGeometries& geometry) {
  const Table<VertexIndex, std::optional<Main>> through = chains_through(roads, topology, geometry);
  struct Eased {
    std::size_t stretch = 0;
    bool at_s1 = false;
    double s = 0.0, fade_m = 0.0;
    Change change;
  };
  std::vector<Eased> all;
  for (std::size_t i = 0; i < junctions.stretches.size(); ++i) {
    const Stretch& stretch = junctions.stretches[i];
    const ChainGeometry& side = geometry[stretch.chain];
    if (stretch.inside || side.closed) continue;
    const auto ends_here = [&](bool at_s1) -> const Main* {
      const VertexIndex vertex = at_s1 ? stretch.vertex1 : stretch.vertex0;
      if (!vertex || (at_s1 ? stretch.s1 < side.vertex_s.back() : stretch.s0 > side.vertex_s.front())) return nullptr;
      return through[vertex] && through[vertex]->chain != stretch.chain ? &*through[vertex] : nullptr;
    };
    const double length = cuts[i].back() - cuts[i].front();
    const double fade = std::min(fade_m, ends_here(false) && ends_here(true) ? 0.5 * length : length);
    if (fade < shortest_fade_m) continue;
    for (const bool at_s1 : {false, true}) {
      const Main* main = ends_here(at_s1);
      if (!main) continue;
      const double s = at_s1 ? cuts[i].back() : cuts[i].front();
      if (const auto change = change_at(side, s, at_s1, geometry[main->chain], main->s, fade))
        all.push_back({i, at_s1, s, fade, *change});
    }
  }
  for (const Eased& eased : all) {
    ChainGeometry& side = geometry[junctions.stretches[eased.stretch].chain];
    const double end = eased.at_s1 ? eased.s - eased.fade_m : eased.s + eased.fade_m;
    add_change(side.elevation, eased.s, end, eased.change.z, eased.change.gradient);
    add_change(side.superelevation, eased.s, end, eased.change.banking, 0.0);
  }
}

}  // namespace orthodrive::network
