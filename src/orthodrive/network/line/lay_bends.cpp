// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/line/lay_bends.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "orthodrive/network/curves/fit_profile.hpp"

namespace orthodrive::network {
namespace {

constexpr double moved_m = 0.05;
constexpr double beside_m = 4.0;      // so far beside the bend the carriageway counts for its plane
constexpr double bend_fade_m = 30.0;  // as where ends meet: chain_line.cpp

/// A line of nodes; closed ones go on after their last node.
class BendRing {
 public:
  BendRing(const std::vector<ChainLineNode>& nodes, bool closed)
      : nodes_(nodes), closed_(closed), count_(closed ? nodes.size() - 1 : nodes.size()) {}
  [[nodiscard]] std::size_t count() const { return count_; }
  [[nodiscard]] bool has(std::ptrdiff_t i) const {
    return closed_ || (i >= 0 && i < static_cast<std::ptrdiff_t>(count_));
  }
  [[nodiscard]] std::size_t index(std::ptrdiff_t i) const {
    const auto n = static_cast<std::ptrdiff_t>(count_);
    return static_cast<std::size_t>((i % n + n) % n);
  }
  [[nodiscard]] const ChainLineNode& at(std::ptrdiff_t i) const { return nodes_[index(i)]; }
  /// Of the line at node i.
  [[nodiscard]] Vec2 direction(std::ptrdiff_t i) const {
    return normalized(at(has(i + 1) ? i + 1 : i).p - at(has(i - 1) ? i - 1 : i).p);
  }
  /// Whether ways may meet there that have a plane in common, not a banking: the node has that of one of them.
  [[nodiscard]] bool is_corner(std::ptrdiff_t i) const {
    if (!has(i - 1) || !has(i + 1)) return false;
    const Vec2 in = at(i).p - at(i - 1).p, out = at(i + 1).p - at(i).p;
    return std::abs(std::atan2(cross(in, out), dot(in, out))) > corner_rad;
  }
  /// Rise a metre on the way from node i to the next one or the one before.
  [[nodiscard]] double slope(std::ptrdiff_t i, int way) const {
    const double step = distance(at(i).p, at(i + way).p);
    return step > 0.0 ? (at(i + way).z_m - at(i).z_m) / step : 0.0;
  }

 private:
  const std::vector<ChainLineNode>& nodes_;
  bool closed_;
  std::size_t count_;
};

/// z = z0 + slope (p - origin)
struct BendPlane {
  Vec2 origin, slope;
  double z0 = 0.0;
  [[nodiscard]] double at(Vec2 p) const { return z0 + dot(slope, p - origin); }
};

/// Least squares; the points do not lie on one line.
class PlaneSum {
 public:
  explicit PlaneSum(Vec2 origin, double z) : origin_(origin), z_(z) {}
  void add(Vec2 p, double z) {
    const Vec2 d = p - origin_;
    n_ += 1.0, sum_ = sum_ + d, z_sum_ += z - z_, zd_ = zd_ + d * (z - z_);
    xx_ += d.x * d.x, xy_ += d.x * d.y, yy_ += d.y * d.y;
  }
  [[nodiscard]] BendPlane solve() const {
    const Vec2 mean = sum_ * (1.0 / n_);
    const double z = z_sum_ / n_, xx = xx_ - n_ * mean.x * mean.x, xy = xy_ - n_ * mean.x * mean.y,
                 yy = yy_ - n_ * mean.y * mean.y;
    const Vec2 right = zd_ - mean * (n_ * z);
    const double determinant = xx * yy - xy * xy;
    BendPlane plane{origin_ + mean, {}, z_ + z};
    if (determinant > 0.0)
      plane.slope = {(yy * right.x - xy * right.y) / determinant, (xx * right.y - xy * right.x) / determinant};
    return plane;
  }

 private:
  Vec2 origin_, sum_, zd_;
  double z_, n_ = 0.0, z_sum_ = 0.0, xx_ = 0.0, xy_ = 0.0, yy_ = 0.0;
};

/// The middle and the edges of the carriageway at nodes first to last, and beside them.
BendPlane bend_plane_of(const BendRing& before, std::ptrdiff_t first, std::ptrdiff_t last) {
  const auto walk_out = [&](std::ptrdiff_t from, int way) {
    double gone_m = 0.0;
    std::ptrdiff_t i = from;
    while (before.has(i + way) && std::abs(i - from) < static_cast<std::ptrdiff_t>(before.count())) {
      gone_m += distance(before.at(i).p, before.at(i + way).p);
      if (gone_m > beside_m) break;
      i += way;
    }
    return i;
  };
  PlaneSum sum(before.at(first).p, before.at(first).z_m);
  for (std::ptrdiff_t i = walk_out(first, -1); i <= walk_out(last, 1); ++i) {
    const ChainLineNode& node = before.at(i);
    if (before.is_corner(i)) {
      sum.add(node.p, node.z_m);
      continue;
    }
    const Vec2 left = left_normal(before.direction(i)) * (0.25 * (node.width_before_m + node.width_after_m));
    const double rise = length(left) * std::tan(node.banking);
    sum.add(node.p, node.z_m), sum.add(node.p + left, node.z_m + rise), sum.add(node.p - left, node.z_m - rise);
  }
  return sum.solve();
}

/// Nodes first to last moved.
struct Run {
  std::ptrdiff_t first = 0, last = 0;
};

std::vector<Run> moved_runs(const BendRing& now, const BendRing& before, const std::vector<std::size_t>& was) {
  const auto n = static_cast<std::ptrdiff_t>(now.count());
  const auto moved = [&](std::ptrdiff_t i) {
    const std::size_t k = now.index(i);
    return distance(now.at(i).p, before.at(static_cast<std::ptrdiff_t>(was[k])).p) > moved_m;
  };
  std::ptrdiff_t begin = 0;  // a closed line is read from a node that did not move
  while (begin < n && now.has(-1) && moved(begin)) ++begin;
  std::vector<Run> runs;
  for (std::ptrdiff_t i = begin; i < begin + n && begin < n; ++i) {
    if (!moved(i)) continue;
    if (runs.empty() || runs.back().last + 1 != i) runs.push_back({i, i});
    runs.back().last = i;
  }
  return runs;
}

class BendLayer {
 public:
  BendLayer(std::vector<ChainLineNode>& nodes, const std::vector<ChainLineNode>& before,
            const std::vector<std::size_t>& was, bool closed)
      : nodes_(nodes), was_(was), closed_(closed), now_(nodes, closed), old_(before, closed) {}

  void lay_all() {
    std::vector<Run> runs = moved_runs(now_, old_, was_);
    std::erase_if(runs, [&](const Run& run) { return is_truer_as_it_was(run); });
    const auto n = static_cast<std::ptrdiff_t>(now_.count());
    for (std::size_t k = 0; k < runs.size(); ++k) {
      const BendPlane plane = plane_of_run(runs[k]);
      for (std::ptrdiff_t i = runs[k].first; i <= runs[k].last; ++i)
        nodes_[now_.index(i)].z_m = plane.at(now_.at(i).p), nodes_[now_.index(i)].banking = banking(plane, i);
      const std::ptrdiff_t behind = k > 0     ? runs[k - 1].last
                                    : closed_ ? runs.back().last - n
                                              : 0,
                           ahead = k + 1 < runs.size() ? runs[k + 1].first
                                   : closed_           ? runs.front().first + n
                                                       : n - 1;
      fade_out(plane, runs[k].first, -1, behind, k > 0 || closed_);
      fade_out(plane, runs[k].last, 1, ahead, k + 1 < runs.size() || closed_);
    }
  }

 private:
  [[nodiscard]] BendPlane plane_of_run(const Run& run) const {
    return bend_plane_of(old_, old_index(run.first), old_index(run.last));
  }
  /// Whether nodes that keep their heights miss the road that was there by less than its plane does: bends of little
  /// moves whose gradient or banking changes.
  [[nodiscard]] bool is_truer_as_it_was(const Run& run) const {
    const BendPlane plane = plane_of_run(run);
    double kept_m = 0.0, plane_m = 0.0;
    for (std::ptrdiff_t i = run.first; i <= run.last; ++i) {
      const ChainLineNode& before = old_.at(old_index(i));
      kept_m = std::max(kept_m, distance(now_.at(i).p, before.p) * length(plane.slope));
      plane_m = std::max(plane_m, std::abs(plane.at(before.p) - before.z_m));
    }
    return kept_m < plane_m;
  }
  /// Of node i before; further rounds of closed lines too.
  [[nodiscard]] std::ptrdiff_t old_index(std::ptrdiff_t i) const {
    const std::size_t k = now_.index(i);
    const std::ptrdiff_t round = (i - static_cast<std::ptrdiff_t>(k)) / static_cast<std::ptrdiff_t>(now_.count());
    return static_cast<std::ptrdiff_t>(was_[k]) + round * static_cast<std::ptrdiff_t>(old_.count());
  }
  [[nodiscard]] double banking(const BendPlane& plane, std::ptrdiff_t i) const {
    return std::atan(dot(plane.slope, left_normal(now_.direction(i))));
  }

  /// What the plane changes at node `end` of a bend fades out on the way to node `to`, half way if that is a bend too.
  void fade_out(const BendPlane& plane, std::ptrdiff_t end, int way, std::ptrdiff_t to, bool to_bend) {
    double room_m = 0.0;
    for (std::ptrdiff_t i = end; i != to; i += way) room_m += distance(now_.at(i).p, now_.at(i + way).p);
    const double fade = std::min(bend_fade_m, to_bend ? 0.5 * room_m : room_m);
    if (fade <= 0.0) return;
    // What did not move keeps its height but for what the plane misses it by.
    const std::ptrdiff_t old_end = old_index(end), old_next = old_index(end + way);
    const Vec2 out = normalized(old_.at(old_end + way).p - old_.at(old_end).p);
    const ChainLineNode& next = old_.at(old_next);
    const double z = plane.at(next.p) - next.z_m, slope = dot(plane.slope, out) - old_.slope(old_end, way),
                 turned = std::atan(dot(plane.slope, left_normal(out)) * way) - next.banking;
    double gone_m = 0.0;
    for (std::ptrdiff_t i = end; i != to; i += way) {
      gone_m += distance(now_.at(i).p, now_.at(i + way).p);
      if (gone_m >= fade) break;
      ChainLineNode& node = nodes_[now_.index(i + way)];
      node.z_m += value_at(hermite(0.0, fade, z, 0.0, slope, 0.0), gone_m);
      node.banking += value_at(hermite(0.0, fade, turned, 0.0, 0.0, 0.0), gone_m);
    }
  }

  std::vector<ChainLineNode>& nodes_;
  const std::vector<std::size_t>& was_;
  bool closed_;
  BendRing now_, old_;
};

}  // namespace

void lay_bends(std::vector<ChainLineNode>& nodes, const std::vector<ChainLineNode>& before,
               const std::vector<std::size_t>& was, bool closed) {
  if (nodes.size() < 3) return;
  BendLayer(nodes, before, was, closed).lay_all();
  if (closed) nodes.back().z_m = nodes.front().z_m, nodes.back().banking = nodes.front().banking;
}

}  // namespace orthodrive::network
