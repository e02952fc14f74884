// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/evaluate/scenes/evaluate_scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "orthodrive/core/median.hpp"

namespace orthodrive {
namespace {

constexpr double allowed_road_error_m = 0.02;
constexpr double clear_below_m = 0.3, clear_above_m = 4.5, border_m = 0.02;  // of what stands beside roads
constexpr std::size_t most_told = 20;                                        // faults of a kind

using Place = std::array<double, 3>;

Place place_of(const SceneTile& tile, const std::array<float, 3>& p) {
  // Exact: origins are whole metres or halves of tiles, positions multiples of 1/1024 m in plan.
  return {tile.origin.x + static_cast<double>(p[0]), tile.origin.y + static_cast<double>(p[1]),
          tile.origin.z + static_cast<double>(p[2])};
}

bool is_road(MeshKind kind) { return kind == MeshKind::road || kind == MeshKind::tunnel_road; }

bool is_surface(MeshKind kind) {
  return kind == MeshKind::terrain || kind == MeshKind::water || is_road(kind) || kind == MeshKind::road_body;
}

bool stands(MeshKind kind) {
  return !is_surface(kind) && kind != MeshKind::verge && kind != MeshKind::marking && kind != MeshKind::kerb;
}

/// Kerbs and beams belong to roads, rails lie in stations, wires hang over roofs.
bool is_beside_buildings(MeshKind kind) {
  return kind == MeshKind::tree || kind == MeshKind::barrier || kind == MeshKind::lamp || kind == MeshKind::object;
}

double plan_area_m2(const TriMesh& mesh) {
  double twice = 0.0;
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    const auto &a = mesh.positions[mesh.indices[i]], &b = mesh.positions[mesh.indices[i + 1]],
               &c = mesh.positions[mesh.indices[i + 2]];
    twice += (double{b[0]} - a[0]) * (double{c[1]} - a[1]) - (double{b[1]} - a[1]) * (double{c[0]} - a[0]);
  }
  return 0.5 * twice;
}

/// From the surface nearest in height. Beside the border of a deck that is the road below it: a chord of the border may
/// lie as far beside it as the mesh may be off, so the least error of around counts there.
std::optional<double> error_of_road(const roadquery::RoadQuery& roads, const Place& p) {
  constexpr double other_level_m = 1.0, beside_m = 0.03;
  const auto error_at = [&](double dx, double dy) {
    roadquery::Cursor cursor;
    const auto z = roads.find_height(p[0] + dx, p[1] + dy, p[2], cursor);
    return z ? std::optional(std::abs(*z - p[2])) : std::nullopt;
  };
  std::optional<double> least = error_at(0.0, 0.0);
  if (!least || *least < other_level_m) return least;
  for (const auto& [dx, dy] : {std::pair{beside_m, 0.0}, {-beside_m, 0.0}, {0.0, beside_m}, {0.0, -beside_m}})
    if (const auto error = error_at(dx, dy)) least = std::min(*least, *error);
  return least;
}

/// Takes edges that run in both directions out of a list. Calls crowded(edge, number) for those of more than two
/// triangles.
template <typename Edge, typename Crowded>
std::vector<Edge> unpaired(const std::vector<Edge>& edges, const Crowded& crowded) {
  struct Turned {
    Edge edge;  // from the lesser end
    int sign = 1;
  };
  std::vector<Turned> all;
  all.reserve(edges.size());
  for (const Edge& e : edges) all.push_back(e[0] < e[1] ? Turned{e, 1} : Turned{{e[1], e[0]}, -1});
  std::ranges::sort(all, {}, &Turned::edge);
  std::vector<Edge> open;
  for (std::size_t i = 0, end = 0; i < all.size(); i = end) {
    int sum = 0;
    for (end = i; end < all.size() && all[end].edge == all[i].edge; ++end) sum += all[end].sign;
    if (end - i > 2) crowded(all[i].edge, end - i);
    for (int k = 0; k < std::abs(sum); ++k)
      open.push_back(sum > 0 ? all[i].edge : Edge{all[i].edge[1], all[i].edge[0]});
  }
  return open;
}

}  // namespace

void SceneScorer::fault(const char* code, std::string message, const Place& at) {
  scores_.faults.push_back({Severity::error, code, std::move(message), at[0], at[1]});
}

void SceneScorer::note_road_error(double error_m, const Place& at) {
  worst_roads_.emplace(error_m, at);
  if (worst_roads_.size() > most_told) worst_roads_.erase(worst_roads_.begin());
}

void SceneScorer::add(const SceneTile& tile, std::uintmax_t bytes) {
  ++scores_.tiles;
  scores_.bytes += bytes;
  scores_.levels = std::max(scores_.levels, tile.level + 1);
  if (tile.level > 0) return;
  ++scores_.tiles_of_level_0;
  for (const TriMesh& mesh : tile.meshes) {
    scores_.triangles += mesh.indices.size() / 3;
    scores_.draw_calls += std::max<std::size_t>(1, mesh.parts.size());
    if (is_surface(mesh.kind) && mesh.kind != MeshKind::road_body) scores_.ground_km2 += 1e-6 * plan_area_m2(mesh);
  }
  for (const InstancedMesh& copied : tile.instanced) {
    scores_.triangles += copied.mesh.indices.size() / 3 * copied.instances.size();
    scores_.draw_calls += std::max<std::size_t>(1, copied.mesh.parts.size());
  }
  add_edges(tile);
  add_roads(tile);
  add_normals(tile);
  add_shells(tile);
  add_standing(tile);
}

void SceneScorer::add_edges(const SceneTile& tile) {
  std::vector<Edge> edges;
  for (const TriMesh& mesh : tile.meshes) {
    if (!is_surface(mesh.kind)) continue;
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3)
      for (std::size_t k = 0; k < 3; ++k)
        edges.push_back({place_of(tile, mesh.positions[mesh.indices[i + k]]),
                         place_of(tile, mesh.positions[mesh.indices[i + (k + 1) % 3]])});
  }
  const auto crowded = [&](const Edge& edge, std::size_t triangles) {
    ++scores_.crowded_edges;
    if (told_["crowded"]++ < static_cast<int>(most_told))
      fault("scene.crowded_edge", fmt::format("{} triangles have an edge in common", triangles), edge[0]);
  };
  std::ranges::copy(unpaired(edges, crowded), std::back_inserter(open_));
}

void SceneScorer::add_roads(const SceneTile& tile) {
  for (const TriMesh& mesh : tile.meshes) {
    if (!is_road(mesh.kind)) continue;
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
      std::array<Place, 3> c;
      for (std::size_t k = 0; k < 3; ++k) c[k] = place_of(tile, mesh.positions[mesh.indices[i + k]]);
      const auto check = [&](double wa, double wb, double wc) {
        Place p;
        for (std::size_t k = 0; k < 3; ++k) p[k] = wa * c[0][k] + wb * c[1][k] + wc * c[2][k];
        const std::optional<double> error = error_of_road(*roads_, p);
        if (!error) return;  // between the border and its chords
        const double error_m = *error;
        ++scores_.road_samples;
        road_errors_m_.push_back(static_cast<float>(error_m));
        scores_.road_error_m = std::max(scores_.road_error_m, error_m);
        if (error_m <= allowed_road_error_m) return;
        ++scores_.road_samples_off;
        note_road_error(error_m, p);
      };
      check(1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0);
      check(0.5, 0.5, 0.0), check(0.0, 0.5, 0.5), check(0.5, 0.0, 0.5);
    }
  }
}

void SceneScorer::add_normals(const SceneTile& tile) {
  for (const TriMesh& mesh : tile.meshes) {
    if (mesh.kind != MeshKind::terrain && !is_road(mesh.kind)) continue;
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
      const Place p = place_of(tile, mesh.positions[i]);
      constexpr double side_m = 480.0;
      if (std::fmod(p[0], side_m) != 0.0 && std::fmod(p[1], side_m) != 0.0) continue;
      // Roads and terrain meet in an edge that may be sharp: only like with like.
      border_normals_[{p[0], p[1], is_road(mesh.kind) ? p[2] + 1e6 : p[2]}].push_back(mesh.normals[i]);
    }
  }
}

void SceneScorer::Shells::make_index() {
  std::vector<Box2> boxes;
  boxes.reserve(triangles.size());
  for (const auto& [a, b, c] : triangles)
    boxes.push_back({std::min({a[0], b[0], c[0]}), std::min({a[1], b[1], c[1]}), std::max({a[0], b[0], c[0]}),
                     std::max({a[1], b[1], c[1]})});
  index = SpatialIndex(boxes);
}

/// A ray upwards leaves a closed shell once more than it enters it.
bool SceneScorer::Shells::contain(const Place& p) const {
  int leaves = 0;
  for (const std::uint32_t i : index.near({p[0], p[1]}, 0.0)) {
    const auto& [a, b, c] = triangles[i];
    const auto side = [&](const Place& u, const Place& v) {
      return (v[0] - u[0]) * (p[1] - u[1]) - (v[1] - u[1]) * (p[0] - u[0]);
    };
    const double wc = side(a, b), wa = side(b, c), wb = side(c, a), all = wa + wb + wc;
    const bool inside = all > 0.0 ? wa > 0.0 && wb > 0.0 && wc > 0.0 : wa < 0.0 && wb < 0.0 && wc < 0.0;
    if (inside && (wa * a[2] + wb * b[2] + wc * c[2]) / all > p[2]) leaves += all > 0.0 ? 1 : -1;
  }
  return leaves > 0;
}

void SceneScorer::add_shells(const SceneTile& tile) {
  constexpr double half_m = 240.0;
  shells_ = {};
  for (const TriMesh& mesh : tile.meshes) {
    if (mesh.kind != MeshKind::building) continue;
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
      std::array<Place, 3> triangle;
      bool reaches_over = false;
      for (std::size_t k = 0; k < 3; ++k) {
        const auto& p = mesh.positions[mesh.indices[i + k]];
        triangle[k] = place_of(tile, p);
        reaches_over |= std::max(std::abs(double{p[0]}), std::abs(double{p[1]})) > half_m;
      }
      shells_.triangles.push_back(triangle);
      if (reaches_over) over_borders_.triangles.push_back(triangle);
    }
  }
  shells_.make_index();
}

void SceneScorer::note_in_building(MeshKind kind, const Place& p) {
  ++scores_.in_building;
  const std::string message = fmt::format("{} stands in a building", to_string(kind));
  if (told_[message]++ < static_cast<int>(most_told)) fault("scene.in_building", message, p);
}

void SceneScorer::check_shells(MeshKind kind, const Place& p, const Box2& tile) {
  constexpr double border_of_tile_m = 60.0;  // buildings of a neighbour reach no further
  if (!is_beside_buildings(kind)) return;
  if (shells_.contain(p)) return note_in_building(kind, p);
  if (tile.grown(-border_of_tile_m).contains({p[0], p[1]})) return;
  if (!first_place_) first_place_ = p;
  std::array<float, 3> away;
  for (std::size_t k = 0; k < 3; ++k) away[k] = static_cast<float>(p[k] - (*first_place_)[k]);
  near_borders_[kind].push_back(away);
}

void SceneScorer::add_standing(const SceneTile& tile) {
  constexpr double half_m = 240.0;
  const Box2 box{tile.origin.x - half_m, tile.origin.y - half_m, tile.origin.x + half_m, tile.origin.y + half_m};
  for (const TriMesh& mesh : tile.meshes)
    if (stands(mesh.kind))
      for (const auto& p : mesh.positions) {
        check_standing(mesh.kind, place_of(tile, p));
        check_shells(mesh.kind, place_of(tile, p), box);
      }
  for (const InstancedMesh& copied : tile.instanced) {
    for (const MeshInstance& copy : copied.instances) {
      const double c = std::cos(static_cast<double>(copy.yaw_rad)), s = std::sin(static_cast<double>(copy.yaw_rad));
      for (const auto& p : copied.mesh.positions) {
        const double x = static_cast<double>(p[0] * copy.scale[0]), y = static_cast<double>(p[1] * copy.scale[1]);
        const Place foot = place_of(tile, copy.position);
        const Place place{foot[0] + c * x - s * y, foot[1] + s * x + c * y,
                          foot[2] + static_cast<double>(p[2] * copy.scale[2])};
        check_standing(copied.mesh.kind, place);
        check_shells(copied.mesh.kind, place, box);
      }
    }
  }
}

void SceneScorer::check_standing(MeshKind kind, const Place& p) {
  ++scores_.standing_vertices;
  const auto is_over = [&](double x, double y) {
    roadquery::Cursor cursor;
    const auto z = roads_->find_height(x, y, p[2], cursor);
    return z && p[2] - *z > -clear_below_m && p[2] - *z < clear_above_m;
  };
  // What touches a border stands beside the road.
  for (const auto& [dx, dy] :
       {std::pair{0.0, 0.0}, {border_m, 0.0}, {-border_m, 0.0}, {0.0, border_m}, {0.0, -border_m}})
    if (!is_over(p[0] + dx, p[1] + dy)) return;
  ++scores_.on_road;
  const std::string message = fmt::format("{} stands on a road", to_string(kind));
  if (told_[message]++ < static_cast<int>(most_told)) fault("scene.on_road", message, p);
}

SceneScores SceneScorer::finish() {
  for (auto worst = worst_roads_.rbegin(); worst != worst_roads_.rend(); ++worst)
    fault("scene.road_off_surface", fmt::format("road mesh {:.3f} m from the surface", worst->first), worst->second);
  over_borders_.make_index();
  const Place from = first_place_.value_or(Place{});  // without one no place is near a border
  for (const auto& [kind, places] : near_borders_)
    for (const auto& away : places) {
      const Place p{from[0] + double{away[0]}, from[1] + double{away[1]}, from[2] + double{away[2]}};
      if (over_borders_.contain(p)) note_in_building(kind, p);
    }
  const std::vector<Edge> open = unpaired(open_, [](const Edge&, std::size_t) {});
  std::multimap<Place, std::size_t> next;
  for (std::size_t i = 0; i < open.size(); ++i) next.emplace(open[i][0], i);
  // Loops around the ground run counter-clockwise, those around holes the other way; cracks have no area.
  while (!next.empty()) {
    std::vector<std::size_t> loop;
    double twice_m2 = 0.0;
    const Place start = next.begin()->first;
    for (auto at = next.begin(); at != next.end(); at = next.find(open[loop.back()][1])) {
      const auto& [a, b] = open[at->second];
      twice_m2 += (a[0] - start[0]) * (b[1] - start[1]) - (b[0] - start[0]) * (a[1] - start[1]);
      loop.push_back(at->second);
      next.erase(at);
      if (open[loop.back()][1] == start) break;
    }
    constexpr double least_scene_m2 = 1000.0;
    if (twice_m2 > 2.0 * least_scene_m2) continue;
    scores_.open_edges += loop.size();
    if (told_["crack"]++ < static_cast<int>(most_told))
      fault("scene.crack", fmt::format("{} open edges around {:.4f} m2", loop.size(), -0.5 * twice_m2), start);
  }
  for (const auto& [place, normals] : border_normals_) {
    if (normals.size() < 2) continue;
    ++scores_.shared_vertices;
    for (const auto& n : normals) {
      const auto& first = normals.front();
      double cross2 = 0.0;
      for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t u = (k + 1) % 3, v = (k + 2) % 3;
        const double c = double{n[u]} * first[v] - double{n[v]} * first[u];
        cross2 += c * c;
      }
      scores_.normal_error_deg =
          std::max(scores_.normal_error_deg, std::asin(std::min(1.0, std::sqrt(cross2))) * 180.0 / std::numbers::pi);
    }
  }
  if (!road_errors_m_.empty()) {
    const auto rank = static_cast<std::size_t>(0.999 * static_cast<double>(road_errors_m_.size() - 1));
    scores_.road_error_p999_m = static_cast<double>(at_rank(road_errors_m_, rank));
  }
  return std::move(scores_);
}

}  // namespace orthodrive
