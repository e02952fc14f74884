// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/drive/line/bounded_line.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "orthodrive/math/box_qp.hpp"

namespace orthodrive {
namespace {

constexpr int max_rounds = 30, max_halvings = 8;
constexpr double least_room_m = 1e-3;     // between the bounds
constexpr double settled_m = 1e-3;        // no offset changes by more: done
constexpr double least_stiffness = 1e-9;  // of every offset, so that a straight line has one solution
constexpr std::size_t reach = 3;          // the change of curvature at i involves the points i - 1 to i + 2

/// Curvature at the middle of three points and its derivatives by their offsets along their normals.
struct CurvatureRow {
  double value = 0.0;
  std::array<double, 3> by{};
  double way_m = 0.0;  ///< half the way from the first to the last point
  std::array<double, 3> way_by{};

  /// Curvature times the root of the way it stands for (in steps): its square adds up to the integral along the line.
  [[nodiscard]] CurvatureRow weighted(double step_m) const {
    const double root = std::sqrt(way_m / step_m);
    CurvatureRow row{value * root};
    if (way_m <= 0.0) return row;
    for (std::size_t i = 0; i < 3; ++i) row.by[i] = by[i] * root + 0.5 * row.value / way_m * way_by[i];
    return row;
  }
};

/// The angle between the two pieces over their mean length. The circle through the points would call a spike straight.
CurvatureRow curvature_row(const std::array<Vec2, 3>& p, const std::array<Vec2, 3>& normal) {
  const Vec2 a = p[1] - p[0], b = p[2] - p[1];
  const double la = length(a), lb = length(b);
  CurvatureRow row;
  if (la * lb <= 0.0) return row;
  row.way_m = 0.5 * (la + lb);
  row.value = std::atan2(cross(a, b), dot(a, b)) / row.way_m;
  row.way_by = {-0.5 * dot(a, normal[0]) / la, 0.5 * (dot(a, normal[1]) / la - dot(b, normal[1]) / lb),
                0.5 * dot(b, normal[2]) / lb};
  const std::array<double, 3> turn_by = {cross(a, normal[0]) / (la * la),
                                         -cross(b, normal[1]) / (lb * lb) - cross(a, normal[1]) / (la * la),
                                         cross(b, normal[2]) / (lb * lb)};
  for (std::size_t i = 0; i < 3; ++i) row.by[i] = (turn_by[i] - row.value * row.way_by[i]) / row.way_m;
  return row;
}

/// The problem of one call: sums of squares over the points, and the order of unknowns that keeps the matrix banded.
class LineFit {
 public:
  LineFit(const LineBetweenEdges& task, const LineCosts& costs)
      : task_(task), costs_(costs), normals_(left_normals(task.reference, task.closed)), n_(task.reference.size()) {
    const double total = length_m(task.reference);
    step_m_ = total / static_cast<double>(std::max<std::size_t>(n_ - 1, 1));
  }

  [[nodiscard]] double cost(const std::vector<double>& offset) const {
    double sum = 0.0;
    std::vector<CurvatureRow> rows = curvatures(offset);
    for (std::size_t i = 0; i < n_; ++i) {
      const double off = offset[i] - task_.wanted_m[i];
      const double bend = rows[i].weighted(step_m_).value;
      const double beyond = beyond_limit(rows[i].value);
      sum += costs_.offset * off * off + costs_.curvature_m4 * bend * bend + costs_.sharp_m4 * beyond * beyond;
      if (!has_rate(i)) continue;
      const double rate = (rows[next(i)].value - rows[i].value) / step_m_;
      sum += costs_.curvature_rate_m6 * rate * rate;
    }
    return sum;
  }

  /// Gauss-Newton's step from these offsets, within the bounds.
  [[nodiscard]] std::vector<double> step(const std::vector<double>& offset) const {
    const std::size_t band = std::min((task_.closed ? 2 : 1) * reach, n_ - 1);
    std::vector<double> entries(n_ * (band + 1), 0.0), gradient(n_, 0.0), lower(n_), upper(n_);
    const SymmetricMatrix matrix = SymmetricMatrix::banded(entries, band);
    // Adds weight * (value + sum by * step)^2 / 2.
    const auto add = [&](double weight, double value, std::span<const std::size_t> at, std::span<const double> by) {
      for (std::size_t a = 0; a < at.size(); ++a) {
        gradient[at[a]] += weight * value * by[a];
        for (std::size_t b = 0; b < at.size(); ++b)
          if (at[b] <= at[a]) matrix(at[a], at[b]) += weight * by[a] * by[b];
      }
    };
    const std::vector<CurvatureRow> rows = curvatures(offset);
    for (std::size_t i = 0; i < n_; ++i) {
      const std::array<std::size_t, 1> here = {place(i)};
      constexpr std::array<double, 1> one = {1.0};
      add(costs_.offset, offset[i] - task_.wanted_m[i], here, one);
      matrix(here[0], here[0]) += least_stiffness;
      if (!has_curvature(i)) continue;
      const std::array<std::size_t, 3> three = {place(before(i)), here[0], place(next(i))};
      const CurvatureRow bend = rows[i].weighted(step_m_);
      if (costs_.curvature_m4 > 0.0) add(costs_.curvature_m4, bend.value, three, bend.by);
      const double beyond = beyond_limit(rows[i].value);
      if (beyond != 0.0) add(costs_.sharp_m4, beyond, three, rows[i].by);
      if (costs_.curvature_rate_m6 <= 0.0 || !has_rate(i)) continue;
      const CurvatureRow &r = rows[i], &q = rows[next(i)];
      const std::array<std::size_t, 4> four = {three[0], three[1], three[2], place(next(next(i)))};
      const std::array<double, 4> by = {-r.by[0], q.by[0] - r.by[1], q.by[1] - r.by[2], q.by[2]};
      add(costs_.curvature_rate_m6 / (step_m_ * step_m_), q.value - r.value, four, by);
    }
    for (std::size_t i = 0; i < n_; ++i) {
      const auto [low, high] = bounds(i);
      lower[place(i)] = low - offset[i], upper[place(i)] = high - offset[i];
    }
    const std::vector<double> folded = minimize_in_box(matrix, gradient, lower, upper);
    std::vector<double> step(n_);
    for (std::size_t i = 0; i < n_; ++i) step[i] = folded[place(i)];
    return step;
  }

  [[nodiscard]] std::pair<double, double> bounds(std::size_t i) const {
    const double middle = 0.5 * (task_.lower_m[i] + task_.upper_m[i]);
    return {std::min(task_.lower_m[i], middle - 0.5 * least_room_m),
            std::max(task_.upper_m[i], middle + 0.5 * least_room_m)};
  }

 private:
  [[nodiscard]] std::size_t next(std::size_t i) const { return i + 1 < n_ ? i + 1 : 0; }
  [[nodiscard]] std::size_t before(std::size_t i) const { return i > 0 ? i - 1 : n_ - 1; }
  [[nodiscard]] bool has_curvature(std::size_t i) const { return task_.closed || (i > 0 && i + 1 < n_); }
  [[nodiscard]] bool has_rate(std::size_t i) const { return has_curvature(i) && has_curvature(next(i)); }
  /// What a curvature is beyond the largest one, with its sign.
  [[nodiscard]] double beyond_limit(double curvature_1pm) const {
    if (costs_.sharp_m4 <= 0.0) return 0.0;
    return std::copysign(std::max(std::abs(curvature_1pm) - costs_.most_curvature_1pm, 0.0), curvature_1pm);
  }
  /// Where unknown i stands: of a closed line the two sides are folded together, so that neighbours stay near.
  [[nodiscard]] std::size_t place(std::size_t i) const {
    if (!task_.closed) return i;
    return 2 * i < n_ ? 2 * i : 2 * (n_ - 1 - i) + 1;
  }
  [[nodiscard]] std::vector<CurvatureRow> curvatures(const std::vector<double>& offset) const {
    std::vector<CurvatureRow> rows(n_);
    const auto moved = [&](std::size_t i) { return task_.reference[i] + offset[i] * normals_[i]; };
    for (std::size_t i = 0; i < n_; ++i) {
      if (!has_curvature(i)) continue;
      const std::size_t a = before(i), b = next(i);
      rows[i] = curvature_row({moved(a), moved(i), moved(b)}, {normals_[a], normals_[i], normals_[b]});
    }
    return rows;
  }

  const LineBetweenEdges& task_;
  const LineCosts& costs_;
  std::vector<Vec2> normals_;
  std::size_t n_;
  double step_m_ = 1.0;
};

}  // namespace

double curvature_of(Vec2 before, Vec2 at, Vec2 after) { return curvature_row({before, at, after}, {}).value; }

std::vector<Vec2> left_normals(const Polyline& line, bool closed) {
  const std::size_t n = line.size();
  std::vector<Vec2> normals(n);
  for (std::size_t i = 0; i < n; ++i) {
    const Vec2 before = i > 0 ? line[i - 1] : closed ? line[n - 1] : line[i];
    const Vec2 after = i + 1 < n ? line[i + 1] : closed ? line[0] : line[i];
    normals[i] = left_normal(normalized(after - before));
  }
  return normals;
}

std::vector<double> best_offsets(const LineBetweenEdges& task, const LineCosts& costs) {
  const LineFit fit(task, costs);
  std::vector<double> offset(task.wanted_m.size());  // from the reference, which is smooth
  for (std::size_t i = 0; i < offset.size(); ++i) {
    const auto [low, high] = fit.bounds(i);
    offset[i] = std::clamp(0.0, low, high);
  }
  double cost = fit.cost(offset);
  for (int round = 0; round < max_rounds; ++round) {
    // The step may end on a bound: the solver needs to stand between them, which it does by itself.
    const std::vector<double> step = fit.step(offset);
    double share = 1.0, moved = 0.0;
    std::vector<double> tried(offset.size());
    bool better = false;
    for (int halving = 0; halving <= max_halvings && !better; ++halving, share *= 0.5) {
      moved = 0.0;
      for (std::size_t i = 0; i < offset.size(); ++i) {
        tried[i] = offset[i] + share * step[i];
        moved = std::max(moved, std::abs(share * step[i]));
      }
      const double now = fit.cost(tried);
      better = now < cost;
      if (better) cost = now, offset = tried;
    }
    if (!better || moved < settled_m) break;
  }
  return offset;
}

}  // namespace orthodrive
