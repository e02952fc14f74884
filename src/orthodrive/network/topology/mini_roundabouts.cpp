// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/topology/mini_roundabouts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <map>
#include <numbers>
#include <optional>
#include <utility>

#include "orthodrive/math/cholesky.hpp"
#include "orthodrive/model/roads/osm_node_id.hpp"

namespace orthodrive::network {
namespace {

// DMRB TD 54/07 (2007), 1.1: at most 28 m across. FGSV, RASt 06, 6.3.5: 13 to 22 m, a lane of 4 to 6 m.
constexpr double usual_disc_m = 16.0, most_disc_m = 40.0, widest_lane_m = 6.0;
constexpr double middle_m = 5.4;             // round which the lane runs: bends with less are eased (chain_line.cpp)
constexpr double least_ring_radius_m = 4.0;  // of the middle of a lane of 2.6 m
constexpr double room_share = 0.4;  // of the way to the next junction: there may be a disc at its other end, too
constexpr double dead_end_rest_m = 4.0;
constexpr double ring_step_m = 1.0;
constexpr double one_place_m = 1.0;  // arms that meet the ring nearer to each other have one node there

double ring_lane_m(double disc_m) { return std::min(widest_lane_m, 0.5 * (disc_m - middle_m)); }
double ring_radius_m(double disc_m) { return 0.5 * (disc_m - ring_lane_m(disc_m)); }
/// The disc whose lane has this radius.
double disc_of_radius_m(double radius) {
  const double widest_of_narrow = ring_radius_m(middle_m + 2.0 * widest_lane_m);
  return radius <= widest_of_narrow ? 4.0 * radius - middle_m : 2.0 * radius + widest_lane_m;
}

/// An id that no map has: real ones are below 2^50.
std::int64_t ring_node(std::int64_t osm_node, std::size_t arm) {
  constexpr std::int64_t beyond = std::int64_t{1} << 50;
  return -beyond - (std::abs(osm_node) * 128 + static_cast<std::int64_t>(arm) * 2 + (osm_node < 0 ? 1 : 0));
}

using Uses = std::map<std::int64_t, int>;
Uses uses_of_nodes(const RoadNetwork& roads) {
  Uses uses;
  for (const RoadPath& path : roads.paths)
    for (const RoadNode& node : path.nodes)
      if (is_osm_node(node.osm_node)) ++uses[node.osm_node];
  return uses;
}

/// A path cut at every visit of the node.
std::vector<RoadPath> parts_between(const RoadPath& path, std::int64_t osm_node) {
  std::vector<RoadPath> parts;
  std::size_t from = 0;
  for (std::size_t i = 1; i < path.nodes.size(); ++i) {
    if (path.nodes[i].osm_node != osm_node && i + 1 < path.nodes.size()) continue;
    RoadPath part = path;
    part.nodes.assign(path.nodes.begin() + static_cast<std::ptrdiff_t>(from),
                      path.nodes.begin() + static_cast<std::ptrdiff_t>(i) + 1);
    parts.push_back(std::move(part));
    from = i;
  }
  return parts;
}

/// Of the lane's middle, as far as an arm that begins at the node has room for it.
double ring_room_m(const RoadPath& arm, const Uses& uses) {
  double length = 0.0;
  for (std::size_t i = 1; i < arm.nodes.size(); ++i) {
    length += distance(arm.nodes[i - 1].p, arm.nodes[i].p);
    if (const auto use = uses.find(arm.nodes[i].osm_node); use != uses.end() && use->second > 1)
      return room_share * length;
  }
  return length - dead_end_rest_m;
}

/// Lets an arm that begins in the middle begin on the circle. False where it never leaves it.
bool begin_on_circle(Vec2 middle, double radius, RoadPath& arm) {
  const auto outside = std::find_if(arm.nodes.begin() + 1, arm.nodes.end(), [&](const RoadNode& node) {
    return distance(node.p, middle) > radius + 0.25 * ring_step_m;
  });
  if (outside == arm.nodes.end()) return false;
  const RoadNode a = *(outside - 1), b = *outside;
  double low = 0.0, high = 1.0;
  for (int i = 0; i < 40; ++i) {
    const double share = 0.5 * (low + high);
    (distance(a.p + (b.p - a.p) * share, middle) < radius ? low : high) = share;
  }
  RoadNode begin = b;
  begin.p = a.p + (b.p - a.p) * low;
  begin.width_m = a.width_m + (b.width_m - a.width_m) * low;
  begin.z_m = a.z_m + (b.z_m - a.z_m) * low;
  arm.nodes.erase(arm.nodes.begin(), outside);
  arm.nodes.insert(arm.nodes.begin(), begin);
  measure_path(arm);
  return true;
}

/// Where a road meets the ring.
struct RingArm {
  std::size_t part = 0;
  bool at_end = false;  ///< of the part
  double angle = 0.0, z_m = 0.0;
};

/// Height round the ring: a plane through the arms as far as they tell one, and what is left of them evenly between.
class RingHeight {
 public:
  explicit RingHeight(const std::vector<RingArm>& arms) : arms_(arms) {
    double normal[3][3] = {};
    for (const RingArm& arm : arms) {
      const std::array<double, 3> w = {1.0, std::cos(arm.angle), std::sin(arm.angle)};
      for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t k = 0; k <= i; ++k) normal[i][k] += w[i] * w[k];
        plane_[i] += w[i] * (arm.z_m - arms.front().z_m);
      }
    }
    constexpr double little = 1e-6;  // of all planes through few arms the most level one
    for (std::size_t i = 1; i < 3; ++i) normal[i][i] += little;
    const SymmetricMatrix a = SymmetricMatrix::dense(&normal[0][0], 3, 3);
    if (factorize(a, {.absolute = 1e-9}))
      solve_factored(a, plane_);
    else
      plane_ = {};
  }
  /// `share` of the way from one arm to the next.
  [[nodiscard]] double between(std::size_t arm, std::size_t next, double share, double angle) const {
    const double smooth = share * share * (3.0 - 2.0 * share);
    return on_plane(angle) + rest(arm) * (1.0 - smooth) + rest(next) * smooth;
  }
  /// Rise of the plane from the middle to the ring.
  [[nodiscard]] double rise_outwards(double angle) const {
    return plane_[1] * std::cos(angle) + plane_[2] * std::sin(angle);
  }

 private:
  [[nodiscard]] double on_plane(double angle) const {
    return arms_.front().z_m + plane_[0] + plane_[1] * std::cos(angle) + plane_[2] * std::sin(angle);
  }
  [[nodiscard]] double rest(std::size_t arm) const { return arms_[arm].z_m - on_plane(arms_[arm].angle); }

  const std::vector<RingArm>& arms_;
  std::array<double, 3> plane_{};
};

/// One mini-roundabout while it is laid.
class MiniRoundabout {
 public:
  MiniRoundabout(const RoadNetwork& roads, const NodeSign& sign, DrivingSide side)
      : sign_(sign), turn_(side == DrivingSide::left ? -1.0 : 1.0) {
    int visits = 0;
    for (std::size_t i = 0; i < roads.paths.size(); ++i) {
      const RoadPath& path = roads.paths[i];
      int here = 0;
      for (const RoadNode& node : path.nodes)
        if (node.osm_node == sign.osm_node) middle_ = middle_ + node.p, ++here;
      if (here == 0) continue;
      visits += here;
      if (path.roundabout) is_on_ring_ = true;
      for (RoadPath& part : parts_between(path, sign.osm_node)) parts_.push_back({i, std::move(part)});
    }
    if (visits > 0) middle_ = middle_ * (1.0 / visits);
  }
  [[nodiscard]] bool exists() const { return !parts_.empty() && !is_on_ring_; }
  [[nodiscard]] Vec2 middle() const { return middle_; }
  [[nodiscard]] MiniRoundaboutDisc disc() const { return {middle_, 0.5 * disc_m_, radius_}; }

  /// False where there is no room.
  bool cut_arms(const Uses& uses) {
    const double wished_m = sign_.size_m > 0.0 ? sign_.size_m : usual_disc_m;
    double radius = ring_radius_m(std::clamp(wished_m, disc_of_radius_m(least_ring_radius_m), most_disc_m));
    for_each_arm([&](RoadPath& arm, std::size_t, bool) {
      radius = std::min(radius, ring_room_m(arm, uses));
      return true;
    });
    disc_m_ = disc_of_radius_m(radius), radius_ = radius;
    if (!(radius >= least_ring_radius_m)) return false;
    const bool cut = for_each_arm([&](RoadPath& arm, std::size_t part, bool at_end) {
      if (!begin_on_circle(middle_, radius_, arm)) return false;
      const Vec2 out = arm.nodes.front().p - middle_;
      arms_.push_back({part, at_end, std::atan2(out.y, out.x), arm.nodes.front().z_m});
      return true;
    });
    std::ranges::stable_sort(arms_, {}, [&](const RingArm& arm) { return turn_ * arm.angle; });
    return cut && !arms_.empty();
  }

  void put_into(RoadNetwork& roads) {
    name_nodes();
    const RoadPath ring = lane_round();
    std::optional<std::size_t> last;
    for (Part& part : parts_) {
      if (last == part.path) {
        part.piece.part = free_part(roads, part.piece.osm_id);
        roads.paths.push_back(std::move(part.piece));
      } else {
        roads.paths[part.path] = std::move(part.piece);
      }
      last = part.path;
    }
    roads.paths.push_back(ring);
    roads.paths.back().part = free_part(roads, ring.osm_id);
  }

 private:
  struct Part {
    std::size_t path = 0;  ///< of which it is a piece
    RoadPath piece;
  };
  static int free_part(const RoadNetwork& roads, std::int64_t osm_id) {
    int next = 0;
    for (const RoadPath& path : roads.paths)
      if (path.osm_id == osm_id) next = std::max(next, path.part + 1);
    return next;
  }

  /// Calls visit(arm, part, at_end) for every end of a part at the node, turned so that it begins there.
  template <typename Visit>
  bool for_each_arm(const Visit& visit) {
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      RoadPath& piece = parts_[i].piece;
      const bool at_begin = piece.nodes.front().osm_node == sign_.osm_node,
                 at_end = piece.nodes.back().osm_node == sign_.osm_node;
      if (at_begin && !visit(piece, i, false)) return false;
      if (!at_end) continue;
      std::ranges::reverse(piece.nodes);
      const bool goes_on = visit(piece, i, true);
      std::ranges::reverse(piece.nodes);
      measure_path(piece);
      if (!goes_on) return false;
    }
    return true;
  }

  /// Arms that meet the ring in one place share its node.
  void name_nodes() {
    std::vector<RingArm> kept;
    for (const RingArm& arm : arms_) {
      RoadNode& node = end_of(arm);
      const auto same = std::ranges::find_if(
          kept, [&](const RingArm& other) { return distance(end_of(other).p, node.p) < one_place_m; });
      if (same != kept.end()) {
        const RoadNode& there = end_of(*same);
        node.p = there.p, node.osm_node = there.osm_node;
        continue;
      }
      node.osm_node = ring_node(sign_.osm_node, kept.size());
      kept.push_back(arm);
    }
    arms_ = std::move(kept);
  }
  RoadNode& end_of(const RingArm& arm) {
    RoadPath& piece = parts_[arm.part].piece;
    return arm.at_end ? piece.nodes.back() : piece.nodes.front();
  }

  RoadPath lane_round() {
    const auto main = std::ranges::max_element(parts_, {}, [](const Part& p) { return road_rank(p.piece.highway); });
    const RoadPath& of = main->piece;
    RoadPath ring{.osm_id = of.osm_id, .highway = of.highway, .name = of.name, .layer = of.layer};
    ring.bridge = of.bridge, ring.tunnel = of.tunnel;
    ring.oneway = Oneway::forward, ring.roundabout = true;
    ring.lanes = 1, ring.width_source = WidthSource::tag;
    ring.use = of.use;
    ring.speed_limit_kmh = of.speed_limit_kmh, ring.speed_context = of.speed_context;
    ring.surface = of.surface, ring.known_surface = of.known_surface;
    const RingHeight height(arms_);
    for (std::size_t k = 0; k < arms_.size(); ++k) {
      const std::size_t next = (k + 1) % arms_.size();
      double way = turn_ * (arms_[next].angle - arms_[k].angle);
      if (next <= k) way += 2.0 * std::numbers::pi;
      const int steps = std::max(2, static_cast<int>(std::ceil(way * radius_ / ring_step_m)));
      for (int i = 0; i < steps; ++i) {
        const double share = static_cast<double>(i) / steps, angle = arms_[k].angle + turn_ * way * share;
        RoadNode node = end_of(arms_[k]);
        if (i > 0) node.osm_node = no_osm_node;
        if (i > 0) node.p = middle_ + Vec2{std::cos(angle), std::sin(angle)} * radius_;
        node.z_m = height.between(k, next, share, angle);
        node.width_m = ring_lane_m(disc_m_), node.crown = node.gradient = 0.0;
        node.banking =
            -turn_ * std::atan(height.rise_outwards(angle) / radius_);  // the middle lies to the left of turn_ 1
        node.offset_m = 0.0, node.kerb_radius_m = 0.0;
        ring.nodes.push_back(node);
      }
    }
    ring.nodes.push_back(ring.nodes.front());
    measure_path(ring);
    return ring;
  }

  NodeSign sign_;
  double turn_;  ///< 1: to the left
  Vec2 middle_;
  bool is_on_ring_ = false;
  double disc_m_ = 0.0, radius_ = 0.0;
  std::vector<Part> parts_;
  std::vector<RingArm> arms_;  ///< in driving order
};

}  // namespace

RoadNetwork lay_mini_roundabouts(RoadNetwork roads, DrivingSide driving_side, std::vector<MiniRoundaboutDisc>& discs,
                                 Findings& findings) {
  const std::vector<NodeSign> signs = roads.signs;
  for (const NodeSign& sign : signs) {
    if (sign.kind != NodeSignKind::mini_roundabout) continue;
    MiniRoundabout place(roads, sign, driving_side);
    if (!place.exists()) continue;
    const auto tell = [&](Severity severity, const char* code, const std::string& what) {
      findings.push_back(
          {severity, code, fmt::format("node {}: {}", sign.osm_node, what), place.middle().x, place.middle().y});
    };
    const bool is_left = driving_side == DrivingSide::left;
    if (!sign.value.empty() && (sign.value == "clockwise") != is_left)
      tell(Severity::warning, "network.roundabout_against_traffic",
           fmt::format("a mini-roundabout with direction={}, where one drives on the {}; built as one drives there, "
                       "correct the tag or check the driving side",
                       sign.value, is_left ? "left" : "right"));
    if (!place.cut_arms(uses_of_nodes(roads))) {
      tell(Severity::info, "network.no_room_for_mini_roundabout",
           "a mini-roundabout so near to the next junction or road end that no car could go round it; built without "
           "its ring");
      continue;
    }
    place.put_into(roads);
    discs.push_back(place.disc());
    const auto at_node = [&](const TurnRestriction& r) { return r.via_node == sign.osm_node; };
    if (const auto left_out = std::erase_if(roads.restrictions, at_node); left_out > 0)
      tell(Severity::info, "network.turn_restriction_left_out",
           fmt::format("{} turn restrictions at a mini-roundabout: one may leave its ring by every road", left_out));
  }
  return roads;
}

}  // namespace orthodrive::network
