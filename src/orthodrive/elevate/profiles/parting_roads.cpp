// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/elevate/profiles/parting_roads.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>

namespace orthodrive::elevate {
namespace {

constexpr double place_step_m = 5.0, farthest_m = 300.0;
constexpr double least_gap_m = 3.0;
const double narrow_cos = std::cos(40.0 * M_PI / 180.0);
constexpr double direction_m = 10.0;  // over which the direction of a road that leaves a node is seen

/// A road as it leaves a node.
struct Ray {
  std::size_t chain = 0;
  double s_m = 0.0, sign = 1.0;
  Vec2 direction;
};

/// A place of a chain.
struct ChainPoint {
  Vec2 p;
  const ChainPlace* nearest = nullptr;
};

/// A place along a chain; of a closed one, the same place on its first round.
double first_round(const ProfileChain& chain, double s_m) {
  return chain.closed ? s_m - std::floor(s_m / chain.length_m) * chain.length_m : s_m;
}

std::optional<ChainPoint> point_of(const RoadNetwork& roads, const ProfileChain& chain, double s_m) {
  s_m = first_round(chain, s_m);
  if (s_m < 0.0 || s_m > chain.places.back().s_m) return std::nullopt;
  const auto after = std::lower_bound(chain.places.begin() + 1, chain.places.end() - 1, s_m,
                                      [](const ChainPlace& place, double s) { return place.s_m < s; });
  const ChainPlace &a = *(after - 1), &b = *after;
  const double f = b.s_m > a.s_m ? std::clamp((s_m - a.s_m) / (b.s_m - a.s_m), 0.0, 1.0) : 0.0;
  const Vec2 p = roads.paths[a.path].nodes[a.node].p, q = roads.paths[b.path].nodes[b.node].p;
  return ChainPoint{p + (q - p) * f, f < 0.5 ? &a : &b};
}

const RoadNode& node_of(const RoadNetwork& roads, const ChainPoint& point) {
  return roads.paths[point.nearest->path].nodes[point.nearest->node];
}

/// The roads that leave a junction: one or two of each chain that visits it, ordered by chain and place.
std::vector<Ray> rays_of(const RoadNetwork& roads, const ProfileChains& chains, const PathJunction& junction) {
  std::vector<Ray> rays;
  for (const JunctionArm& arm : junction.arms) {
    const NodePlace& at = chains.of_node[arm.path][arm.node];
    const auto from = point_of(roads, chains.chains[at.chain], at.s_m);
    for (const double sign : {1.0, -1.0}) {
      const auto to = point_of(roads, chains.chains[at.chain], at.s_m + sign * direction_m);
      if (!from || !to || distance(from->p, to->p) < 0.5 * direction_m) continue;
      rays.push_back({at.chain, at.s_m, sign, normalized(to->p - from->p)});
    }
  }
  const auto key = [](const Ray& ray) { return std::tuple(ray.chain, ray.s_m, ray.sign); };
  std::sort(rays.begin(), rays.end(), [&](const Ray& a, const Ray& b) { return key(a) < key(b); });
  rays.erase(std::unique(rays.begin(), rays.end(), [&](const Ray& a, const Ray& b) { return key(a) == key(b); }),
             rays.end());
  return rays;
}

/// The place of the chain nearest to p, within a step of `along_m` from the ray's start; it moves there.
std::optional<ChainPoint> follow_ray(const RoadNetwork& roads, const ProfileChain& chain, const Ray& ray, Vec2 p,
                                     double& along_m) {
  constexpr double fine_m = 0.25;
  std::optional<ChainPoint> nearest;
  const double from_m = along_m;
  for (double l_m = from_m; l_m <= from_m + 2.0 * place_step_m; l_m += fine_m) {
    const auto point = point_of(roads, chain, ray.s_m + ray.sign * l_m);
    if (!point) break;
    if (!nearest || distance(point->p, p) < distance(nearest->p, p)) nearest = point, along_m = l_m;
  }
  return nearest;
}

void follow_both(const RoadNetwork& roads, const ProfileChains& chains, const Ray& main, const Ray& other,
                 std::vector<SharedPavement>& shared) {
  const ProfileChain &a = chains.chains[main.chain], &b = chains.chains[other.chain];
  double other_m = 0.0;
  std::optional<int> layers;  // between the two at the node
  for (double main_m = place_step_m; main_m <= farthest_m; main_m += place_step_m) {
    const auto at = point_of(roads, a, main.s_m + main.sign * main_m),
               before = point_of(roads, a, main.s_m + main.sign * (main_m - place_step_m));
    if (!at || !before) return;
    const auto beside = follow_ray(roads, b, other, at->p, other_m);
    if (!beside) return;
    const double off_m = distance(at->p, beside->p);
    if (off_m > 0.5 * (node_of(roads, *at).width_m + node_of(roads, *beside).width_m) + least_gap_m) return;
    const int above = roads.paths[at->nearest->path].layer - roads.paths[beside->nearest->path].layer;
    if (above != layers.value_or(above)) return;
    layers = above;
    const double way = main.sign * (at->nearest->forward ? 1.0 : -1.0);  // of the path
    const double side = cross(at->p - before->p, beside->p - at->p) * way > 0.0 ? 1.0 : -1.0;
    shared.push_back({main.chain, other.chain, first_round(a, main.s_m + main.sign * main_m),
                      first_round(b, other.s_m + other.sign * other_m), side * off_m, at->nearest->path,
                      at->nearest->node, beside->nearest->path, beside->nearest->node});
  }
}

/// Class, then width, at the node that a ray leaves.
std::tuple<int, double> weight_of(const RoadNetwork& roads, const ProfileChains& chains, const Ray& ray) {
  const auto at = point_of(roads, chains.chains[ray.chain], ray.s_m + ray.sign * direction_m);
  if (!at) return {};
  return {road_rank(roads.paths[at->nearest->path].highway), node_of(roads, *at).width_m};
}

}  // namespace

std::vector<SharedPavement> find_shared_pavement(const RoadNetwork& roads, const ProfileChains& chains,
                                                 const std::vector<PathJunction>& junctions) {
  std::vector<SharedPavement> shared;
  for (const PathJunction& junction : junctions) {
    const std::vector<Ray> rays = rays_of(roads, chains, junction);
    for (std::size_t i = 0; i < rays.size(); ++i)
      for (std::size_t k = i + 1; k < rays.size(); ++k) {
        if (rays[i].chain == rays[k].chain || dot(rays[i].direction, rays[k].direction) < narrow_cos) continue;
        const bool first = weight_of(roads, chains, rays[i]) >= weight_of(roads, chains, rays[k]);
        follow_both(roads, chains, first ? rays[i] : rays[k], first ? rays[k] : rays[i], shared);
      }
  }
  return shared;
}

}  // namespace orthodrive::elevate
