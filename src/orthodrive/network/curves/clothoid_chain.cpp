// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/curves/clothoid_chain.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numbers>
#include <queue>

#include "orthodrive/geo/angle.hpp"
#include "orthodrive/math/cholesky.hpp"

namespace orthodrive::network {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }
Vec2 heading_vector(double heading) { return {std::cos(heading), std::sin(heading)}; }

constexpr int max_unknowns = 20;
constexpr int max_iterations = 16;
constexpr int trial_iterations = 3, polish_iterations = 6;  // of least squares before the window may close
constexpr double hopeless = 10.0;  // times the tolerance after the trial iterations: more of them would not help
constexpr int polish_stride = 4;
constexpr double closed_m = 1e-10, closed_rad = 1e-11;  // what may be left of a window's end condition

/// Along one element from its start, with the moments of its tangent up to `ds`.
struct ElementWalk {
  double heading_rad, length_m, k0, k1, rate;
  TangentMoments sum{};
  double ds = 0.0;

  ElementWalk(const Knot& start, double end_curvature, double length)
      : heading_rad(start.heading_rad),
        length_m(length),
        k0(start.curvature),
        k1(end_curvature),
        rate((end_curvature - start.curvature) / length) {}
  [[nodiscard]] double heading_at(double u) const { return heading_rad + u * (k0 + 0.5 * rate * u); }
  void to(double end) {
    const double h = end - ds;
    if (h <= 0.0) return;
    const TangentMoments m = tangent_moments(heading_at(ds), k0 + rate * ds, rate, h);
    sum.m0 = sum.m0 + m.m0;
    sum.m1 = sum.m1 + m.m1 + m.m0 * ds;
    sum.m2 = sum.m2 + m.m2 + m.m1 * (2.0 * ds) + m.m0 * (ds * ds);
    ds = end;
  }
};

}  // namespace

/// A run of elements that is fitted anew.
struct ClothoidChain::Window {
  int elements = 0;
  std::array<int, max_elements + 1> joint{};  ///< of the chain; that of a closed chain's seam may stand at both ends
  std::array<double, max_elements> length_m{};
  std::array<ElementKind, max_elements> kind{};
  std::array<Knot, max_elements + 1> knot{};
  bool free_start = false, free_end = false;
  std::size_t first_node = 0, nodes = 0;
  std::vector<double> s, e, weight;  ///< of the nodes: foot, from the start of the window; lateral distance
  double max_e = 0.0, max_curvature = 0.0, max_rate = 0.0;
  Knot target;  ///< where it has to end unless free_end

  // Unknowns: index into the vector, -1: given.
  int unknowns = 0, u_shift = -1, u_heading = -1;
  std::array<int, max_elements + 1> u_curvature{};
  std::array<int, max_elements> u_length{};

  // Normal equations and end conditions at the present values.
  double h[max_unknowns][max_unknowns];
  double g[max_unknowns];
  int conditions = 0;
  double c[3][max_unknowns];
  double rest[3];
  // Derivatives by the unknowns of the place and heading where the present element starts.
  std::array<Vec2, max_unknowns> by_u;
  std::array<double, max_unknowns> turn_by_u;

  bool number_unknowns();
  void clear_equations();
  void add_node(std::size_t j, int p, const ElementWalk& walk, Vec2 t);
  void pass_element(int p, const ElementWalk& walk, Vec2 t);
  void set_conditions(Vec2 last_node, Vec2 t, bool derive);
  bool step(bool only_close);
  [[nodiscard]] bool closes() const {
    for (int i = 0; i < conditions; ++i)
      if (!(std::abs(rest[i]) < (i == 2 ? closed_rad : closed_m))) return false;
    return true;
  }
};

ClothoidChain::ClothoidChain(std::span<const Vec2> nodes, bool closed, const ClothoidSpline& start,
                             std::span<const std::size_t> knot_at, const ChainLimits& limits)
    : nodes_(nodes), closed_(closed), limits_(limits), ds_(nodes.size(), 0.0), distance_(nodes.size(), 0.0) {
  const std::size_t n = start.knots.size();
  for (std::size_t i = 0; i < n; ++i) {
    Joint joint{.knot = start.knots[i]};
    joint.previous = i > 0 ? static_cast<int>(i) - 1 : (closed ? static_cast<int>(n) - 1 : -1);
    joint.next = i + 1 < n ? static_cast<int>(i) + 1 : (closed ? 0 : -1);
    if (joint.next >= 0) {
      joint.length_m = start.length_m[i];
      joint.first_node = knot_at[i];
      const std::size_t end = i + 1 < n ? knot_at[i + 1] : (closed ? nodes.size() + knot_at[0] : nodes.size());
      joint.nodes = end - knot_at[i];
      if (!closed && joint.next == static_cast<int>(n) - 1) joint.nodes = nodes.size() - knot_at[i];
      ++alive_elements_;
    }
    joints_.push_back(joint);
  }
  // Feet: guessed by share of the chord, then found exactly window by window.
  for (int i = first_, k = 0; k < alive_elements_; i = joints_[at(i)].next, ++k) {
    const Joint& joint = joints_[at(i)];
    double length = 0.0;
    std::vector<double> along{0.0};
    for (std::size_t j = 1; j <= joint.nodes; ++j) {
      const bool end = joint.first_node + j >= nodes_.size() && !closed_;
      if (!end) length += distance(nodes_[wrapped(joint.first_node + j - 1)], nodes_[wrapped(joint.first_node + j)]);
      along.push_back(length);
    }
    for (std::size_t j = 0; j < joint.nodes; ++j)
      ds_[wrapped(joint.first_node + j)] = length > 0.0 ? joint.length_m * along[j] / length : 0.0;
  }
  Window window;
  for (int i = first_, k = 0; k < alive_elements_; i = joints_[at(i)].next, ++k) {
    if (!collect(i, 0, 1, window)) continue;
    for (int pass = 0; pass < 3; ++pass) evaluate(window, false);
    for (std::size_t j = 0; j < window.nodes; ++j) {
      const std::size_t node = wrapped(window.first_node + j);
      ds_[node] = std::clamp(window.s[j], 0.0, joints_[at(i)].length_m), distance_[node] = std::abs(window.e[j]);
    }
  }
}

/// The window of `back` elements before joint `from` and `ahead` elements from it on, as far as the chain reaches.
bool ClothoidChain::collect(int from, int back, int ahead, Window& w) const {
  int start = from, count = 0;
  const int most = std::min(max_elements, alive_elements_);
  for (; count < std::min(back, most - 1) && joints_[at(start)].previous >= 0; ++count)
    start = joints_[at(start)].previous;
  const int wanted = std::min(count + ahead, most);
  w.elements = 0, w.nodes = 0;
  w.first_node = joints_[at(start)].first_node;
  w.s.clear(), w.e.clear(), w.weight.clear();
  w.max_e = w.max_curvature = w.max_rate = 0.0;
  int i = start;
  double s = 0.0;
  for (; w.elements < wanted && joints_[at(i)].next >= 0; i = joints_[at(i)].next) {
    const Joint& joint = joints_[at(i)];
    const std::size_t p = at(w.elements++);
    w.joint[p] = i, w.knot[p] = joint.knot, w.length_m[p] = joint.length_m, w.kind[p] = joint.kind;
    for (std::size_t j = 0; j < joint.nodes; ++j) {
      const std::size_t node = wrapped(joint.first_node + j);
      w.s.push_back(s + ds_[node]);
      w.max_e = std::max(w.max_e, distance_[node]);
    }
    w.nodes += joint.nodes;
    s += joint.length_m;
    const double k0 = joint.knot.curvature, k1 = joints_[at(joint.next)].knot.curvature;
    w.max_curvature = std::max({w.max_curvature, std::abs(k0), std::abs(k1)});
    w.max_rate = std::max(w.max_rate, std::abs(k1 - k0) / joint.length_m);
  }
  if (w.elements == 0) return false;
  w.joint[at(w.elements)] = i;
  w.knot[at(w.elements)] = w.target = joints_[at(i)].knot;
  w.free_start = joints_[at(start)].previous < 0;
  w.free_end = joints_[at(i)].next < 0;
  w.e.assign(w.nodes, 0.0);
  w.weight.assign(w.nodes, 1.0);
  return true;
}

/// Curvatures that are one unknown (both ends of an arc), zero (ends of a line) or given (at the window's border);
/// false where these contradict.
bool ClothoidChain::Window::number_unknowns() {
  unknowns = 0;
  u_shift = u_heading = -1;
  if (free_start) u_shift = unknowns++, u_heading = unknowns++;
  for (int first = 0; first <= elements;) {
    int last = first;
    while (last < elements && kind[at(last)] != ElementKind::clothoid) {
      if (kind[at(last)] != kind[at(first)] && last > first) return false;  // line beside arc: the curvature would jump
      ++last;
    }
    // Joints first .. last have one curvature, and so has the line that may end here.
    bool given = false, straight = last > first && kind[at(first)] == ElementKind::line;
    double value = 0.0;
    const auto give = [&](double v) {
      if (given && v != value) return false;
      given = true, value = v;
      return true;
    };
    if (straight && !give(0.0)) return false;
    if (first == 0 && !free_start && !give(knot[0].curvature)) return false;
    if (last == elements && !free_end && !give(target.curvature)) return false;
    double mean = 0.0;
    for (int i = first; i <= last; ++i) mean += knot[at(i)].curvature / (last - first + 1);
    const int u = given ? -1 : unknowns++;
    for (int i = first; i <= last; ++i) {
      u_curvature[at(i)] = u;
      knot[at(i)].curvature = given ? value : mean;
    }
    first = last + 1;
  }
  for (int p = 0; p < elements; ++p) u_length[at(p)] = unknowns++;
  conditions = free_end ? 1 : 3;
  return unknowns <= max_unknowns;
}

void ClothoidChain::Window::clear_equations() {
  for (int i = 0; i < unknowns; ++i) {
    g[i] = 0.0;
    for (int k = 0; k <= i; ++k) h[i][k] = 0.0;
  }
  by_u = {}, turn_by_u = {};
  if (u_shift >= 0)
    by_u[at(u_shift)] = left_normal(heading_vector(knot[0].heading_rad)), turn_by_u[at(u_heading)] = 1.0;
}

/// What node j, seen across the tangent `t`, adds to the normal equations.
void ClothoidChain::Window::add_node(std::size_t j, int p, const ElementWalk& walk, Vec2 t) {
  const int n = unknowns, u0 = u_curvature[at(p)], u1 = u_curvature[at(p) + 1], ul = u_length[at(p)];
  std::array<double, max_unknowns> row;
  const double forward = dot(t, walk.sum.m0);
  for (int i = 0; i < n; ++i) row[at(i)] = cross(t, by_u[at(i)]) + turn_by_u[at(i)] * forward;
  const double t1 = dot(t, walk.sum.m1), t2 = dot(t, walk.sum.m2) / (2.0 * walk.length_m);
  if (u0 >= 0) row[at(u0)] += t1 - t2;
  if (u1 >= 0) row[at(u1)] += t2;
  row[at(ul)] -= walk.rate * t2;
  for (int i = 0; i < n; ++i) {
    const double wr = weight[j] * row[at(i)];
    g[i] += wr * e[j];
    for (int m = 0; m <= i; ++m) h[i][m] += wr * row[at(m)];
  }
}

/// From the start of element p to its end, where the tangent is `t`.
void ClothoidChain::Window::pass_element(int p, const ElementWalk& walk, Vec2 t) {
  const double l = walk.length_m;
  const int u0 = u_curvature[at(p)], u1 = u_curvature[at(p) + 1], ul = u_length[at(p)];
  for (int i = 0; i < unknowns; ++i) by_u[at(i)] = by_u[at(i)] + left_normal(walk.sum.m0) * turn_by_u[at(i)];
  const Vec2 m1 = left_normal(walk.sum.m1), m2 = left_normal(walk.sum.m2) * (0.5 / l);
  if (u0 >= 0) by_u[at(u0)] = by_u[at(u0)] + m1 - m2, turn_by_u[at(u0)] += 0.5 * l;
  if (u1 >= 0) by_u[at(u1)] = by_u[at(u1)] + m2, turn_by_u[at(u1)] += 0.5 * l;
  by_u[at(ul)] = by_u[at(ul)] + t - m2 * walk.rate;
  turn_by_u[at(ul)] += 0.5 * (walk.k0 + walk.k1);
}

/// What is left between the end of the window, with tangent `t`, and where it has to end: the target, or beside the
/// last node.
void ClothoidChain::Window::set_conditions(Vec2 last_node, Vec2 t, bool derive) {
  const Knot& end = knot[at(elements)];
  if (free_end) {
    rest[0] = dot(t, last_node - end.p);
    if (derive)
      for (int i = 0; i < unknowns; ++i) c[0][i] = dot(t, by_u[at(i)]);
  } else {
    rest[0] = target.p.x - end.p.x, rest[1] = target.p.y - end.p.y;
    rest[2] = wrapped_angle(target.heading_rad - end.heading_rad);
    if (derive)
      for (int i = 0; i < unknowns; ++i) c[0][i] = by_u[at(i)].x, c[1][i] = by_u[at(i)].y, c[2][i] = turn_by_u[at(i)];
  }
}

/// Walks along the window: knots, feet and distances of the nodes, and with `derive` the normal equations.
void ClothoidChain::evaluate(Window& w, bool derive) {
  if (derive) w.clear_equations();
  if (w.free_start) {  // the line begins beside the first node
    const Vec2 along = heading_vector(w.knot[0].heading_rad);
    w.knot[0].p = w.knot[0].p + along * dot(along, nodes_.front() - w.knot[0].p);
  }
  std::size_t j = 0;
  double begin = 0.0;
  w.max_e = 0.0;
  Vec2 t;
  for (int p = 0; p < w.elements; ++p) {
    const Knot& knot = w.knot[at(p)];
    ElementWalk walk(knot, w.knot[at(p) + 1].curvature, w.length_m[at(p)]);
    const double l = walk.length_m;
    const bool last = p + 1 == w.elements;
    for (; j < w.nodes && (w.s[j] < begin + l || last); ++j) {
      walk.to(std::clamp(w.s[j] - begin, walk.ds, l));
      const double k = walk.k0 + walk.rate * walk.ds;
      t = heading_vector(walk.heading_at(walk.ds));
      const Vec2 q = nodes_[wrapped(w.first_node + j)] - (knot.p + walk.sum.m0);
      const double along = dot(t, q), across = cross(t, q), slack = std::max(1.0 - k * across, 0.3);
      // To the foot: a Newton step, and what the line bends away on the way.
      w.e[j] = across - 0.5 * k * along * along / slack;
      w.s[j] = begin + walk.ds + std::clamp(along / slack, -4.0, 4.0);
      w.max_e = std::max(w.max_e, std::abs(w.e[j]));
      if (derive) w.add_node(j, p, walk, t);
    }
    walk.to(l);
    const double heading = walk.heading_at(l);
    t = heading_vector(heading);
    if (derive) w.pass_element(p, walk, t);
    w.knot[at(p) + 1].p = knot.p + walk.sum.m0, w.knot[at(p) + 1].heading_rad = heading;
    begin += l;
  }
  w.set_conditions(nodes_.back(), t, derive);
}

/// Gauss-Newton step under the end conditions; false when the problem is singular.
bool ClothoidChain::Window::step(bool only_close) {
  const int n = unknowns;
  // Lengths and curvatures that no node sees stay where they are: as if one more node said so, weakly.
  // Lengths act on the rest with a product: the farther the line is off, the less they may change at once.
  double off = max_e * max_e;
  for (int i = 0; i < std::min(conditions, 2); ++i) off += rest[i] * rest[i];
  for (int p = 0; p < elements; ++p) {
    const double slack = 0.3 * length_m[at(p)];
    h[u_length[at(p)]][u_length[at(p)]] += (4e-4 + off) / (slack * slack);
  }
  for (int i = 0; i <= elements; ++i)
    if (u_curvature[at(i)] >= 0) h[u_curvature[at(i)]][u_curvature[at(i)]] += 1e-2;
  if (u_shift >= 0) h[u_shift][u_shift] += 1e-6, h[u_heading][u_heading] += 1e-6;
  const auto count = static_cast<std::size_t>(n);
  const SymmetricMatrix normal = SymmetricMatrix::dense(&h[0][0], count, max_unknowns);
  if (!factorize(normal)) return false;
  double x[max_unknowns], y[3][max_unknowns];
  if (only_close) std::fill_n(g, n, 0.0);
  std::copy_n(g, n, x);
  solve_factored(normal, {x, count});
  double s[3][3], r[3];
  for (int a = 0; a < conditions; ++a) {
    std::copy_n(c[a], n, y[a]);
    solve_factored(normal, {y[a], count});
  }
  for (int a = 0; a < conditions; ++a) {
    r[a] = rest[a];
    for (int i = 0; i < n; ++i) r[a] -= c[a][i] * x[i];
    for (int b = 0; b <= a; ++b) {
      s[a][b] = 0.0;
      for (int i = 0; i < n; ++i) s[a][b] += c[a][i] * y[b][i];
    }
  }
  const auto held = static_cast<std::size_t>(conditions);
  const SymmetricMatrix end = SymmetricMatrix::dense(&s[0][0], held, 3);
  if (!factorize(end)) return false;
  solve_factored(end, {r, held});
  double scale = 1.0;
  for (int i = 0; i < n; ++i)
    for (int a = 0; a < conditions; ++a) x[i] += y[a][i] * r[a];
  for (int p = 0; p < elements; ++p) {
    const double d = x[u_length[at(p)]];
    if (!std::isfinite(d)) return false;
    scale = std::min(scale, 0.4 * length_m[at(p)] / std::max(std::abs(d), 1e-300));
  }
  for (int p = 0; p < elements; ++p) length_m[at(p)] += scale * x[u_length[at(p)]];
  for (int i = 0; i <= elements; ++i)
    if (u_curvature[at(i)] >= 0) knot[at(i)].curvature += scale * x[u_curvature[at(i)]];
  if (u_shift >= 0) {
    knot[0].p = knot[0].p + left_normal(heading_vector(knot[0].heading_rad)) * (scale * x[u_shift]);
    knot[0].heading_rad += scale * x[u_heading];
  }
  return true;
}

bool ClothoidChain::within_limits(const Window& w) const {
  std::size_t node = 0;
  double s = 0.0;
  for (int p = 0; p <= w.elements; ++p) {
    const double k = w.knot[at(p)].curvature;
    while (node + 1 < w.nodes && w.s[node] < s) ++node;
    if (!limits_.max_curvature.empty() && w.nodes > 0 &&
        std::abs(k) > std::max(limits_.max_curvature[wrapped(w.first_node + node)], w.max_curvature) + 1e-9)
      return false;
    if (p == w.elements) break;
    const double l = w.length_m[at(p)];
    if (l < limits_.min_element_m) return false;
    if (std::abs(w.knot[at(p) + 1].curvature - k) / l > std::max(limits_.max_curvature_rate, w.max_rate) + 1e-9)
      return false;
    s += l;
  }
  return true;
}

bool ClothoidChain::solve(Window& w, int least_iterations) {
  const double limit = std::max(limits_.tolerance_m, w.max_e);
  if (!w.number_unknowns() || w.unknowns < w.conditions) return false;
  bool closing = false;
  double before = INFINITY;
  for (int iteration = 0; iteration < max_iterations; ++iteration) {
    evaluate(w, true);
    if (!std::isfinite(w.max_e) || w.max_e > (iteration == 0 ? 100.0 : 20.0)) return false;
    if (closing && w.closes()) {
      if (w.max_e <= limit) return within_limits(w);
      closing = false;
    }
    if (iteration >= least_iterations && !closing) {
      // The last steps only close the window: they converge quadratically, those that also move the line do not.
      if (w.max_e <= limit)
        closing = true;
      else if (w.max_e > hopeless * limit || w.max_e > before * 0.97)
        return false;
      before = w.max_e;
      // Towards the smallest largest distance: what is far counts more (iteratively reweighted, as for the 4-norm).
      for (std::size_t j = 0; j < w.nodes && !closing; ++j) {
        const double x = w.e[j] / w.max_e;
        w.weight[j] = 0.02 + x * x;
      }
    }
    if (!w.step(closing)) return false;
  }
  return false;
}

void ClothoidChain::commit(const Window& w) {
  // Joints of the window that are still there; those taken out have been skipped by the caller.
  std::size_t node = 0;
  double begin = 0.0;
  for (int p = 0; p < w.elements; ++p) {
    Joint& joint = joints_[at(w.joint[at(p)])];
    const bool last = p + 1 == w.elements;
    joint.knot = w.knot[at(p)];
    joint.length_m = w.length_m[at(p)];
    joint.kind = w.kind[at(p)];
    joint.next = w.joint[at(p) + 1];
    joints_[at(joint.next)].previous = w.joint[at(p)];
    joint.first_node = wrapped(w.first_node + node), joint.nodes = 0;
    for (; node < w.nodes && (w.s[node] < begin + joint.length_m || last); ++node, ++joint.nodes) {
      const std::size_t i = wrapped(w.first_node + node);
      ds_[i] = std::clamp(w.s[node] - begin, 0.0, joint.length_m);
      distance_[i] = std::abs(w.e[node]);
    }
    begin += joint.length_m;
  }
  if (w.free_end) joints_[at(w.joint[at(w.elements)])].knot = w.knot[at(w.elements)];
}

/// Takes out `count` joints from j on: one element instead of count + 1.
bool ClothoidChain::remove(int j, int count) {
  if (!joints_[at(j)].alive || joints_[at(j)].previous < 0 || alive_elements_ < count + (closed_ ? 2 : 1)) return false;
  Window w;
  if (!collect(j, 3, count + 2, w)) return false;
  int p = 0;
  while (p < w.elements && w.joint[at(p)] != j) ++p;
  if (p == 0 || p + count > w.elements) return false;
  const std::size_t a = at(p) - 1, shift = at(count), left = at(w.elements - count);
  const std::array<int, max_elements + 1> before = w.joint;
  for (std::size_t i = a + 1; i <= a + shift; ++i) {
    w.kind[a] = w.kind[a] == w.kind[i] ? w.kind[a] : ElementKind::clothoid;
    w.length_m[a] += w.length_m[i];
  }
  for (std::size_t i = a + 1; i < left; ++i) w.length_m[i] = w.length_m[i + shift], w.kind[i] = w.kind[i + shift];
  for (std::size_t i = a + 1; i <= left; ++i) w.joint[i] = w.joint[i + shift], w.knot[i] = w.knot[i + shift];
  w.elements -= count;
  if (!solve(w, trial_iterations)) return false;
  commit(w);
  for (std::size_t i = a + 1; i <= a + shift; ++i) {
    Joint& joint = joints_[at(before[i])];
    joint.alive = false;
    joint.next = joint.previous = -1;
    if (first_ == before[i]) first_ = w.joint[0];
  }
  alive_elements_ -= count;
  return true;
}

bool ClothoidChain::change_kind(int j, ElementKind kind) {
  Window w;
  if (!collect(j, 2, 3, w)) return false;
  int p = 0;
  while (p < w.elements && w.joint[at(p)] != j) ++p;
  if (p == w.elements) return false;
  w.kind[at(p)] = kind;
  if (!solve(w, trial_iterations)) return false;
  commit(w);
  return true;
}

void ClothoidChain::polish() {
  // Windows overlap by half: what stood still at the border of one moves in the next.
  int i = first_;
  for (int k = 0; k < alive_elements_; k += polish_stride)
    for (int step = 0; step < polish_stride; ++step) {
      if (step == 0) {
        Window w;
        if (collect(i, 0, 2 * polish_stride, w) && solve(w, polish_iterations)) commit(w);
      }
      if (joints_[at(i)].next < 0) return;
      i = joints_[at(i)].next;
    }
}

/// About how far the line moves when joints go: the triangles of curvature that are lost, integrated twice. Where
/// nothing moves, short elements go first: one that grows by a joint at a time would be walked along as often as it has
/// joints.
double ClothoidChain::removal_cost(int j, int count) const {
  int end = j;
  double l = joints_[at(joints_[at(j)].previous)].length_m;
  for (int k = 0; k < count; ++k) {
    if (joints_[at(end)].next < 0) return INFINITY;
    l += joints_[at(end)].length_m, end = joints_[at(end)].next;
  }
  const Joint& a = joints_[at(joints_[at(j)].previous)];
  const double k0 = a.knot.curvature, k1 = joints_[at(end)].knot.curvature;
  double s = a.length_m, cost = 0.0;
  for (; j != end; j = joints_[at(j)].next) {
    cost = std::max(cost, std::abs(joints_[at(j)].knot.curvature - (k0 + (k1 - k0) * s / l)));
    s += joints_[at(j)].length_m;
  }
  constexpr double cost_per_m = 1e-6;
  return cost * l * l + cost_per_m * l;
}

void ClothoidChain::remove_knots(int count) {
  struct Trial {
    double cost;
    int joint, stamp;
  };
  const auto later = [](const Trial& a, const Trial& b) {
    return a.cost != b.cost ? a.cost > b.cost : a.joint > b.joint;
  };
  std::priority_queue<Trial, std::vector<Trial>, decltype(later)> queue(later);
  std::vector<int> stamp(joints_.size(), 0);
  const auto push = [&](int j) {
    const Joint& joint = joints_[at(j)];
    if (!joint.alive || joint.previous < 0 || joint.next < 0) return;
    if (const double cost = removal_cost(j, count); std::isfinite(cost)) queue.push({cost, j, ++stamp[at(j)]});
  };
  for (std::size_t i = 0; i < joints_.size(); ++i) push(static_cast<int>(i));
  while (!queue.empty()) {
    const Trial trial = queue.top();
    queue.pop();
    if (trial.stamp != stamp[at(trial.joint)] || !joints_[at(trial.joint)].alive) continue;
    const int before = joints_[at(trial.joint)].previous;
    if (!remove(trial.joint, count)) continue;
    int i = before;
    for (int k = 0; k < count && joints_[at(i)].previous >= 0; ++k) i = joints_[at(i)].previous;
    for (int k = 0; k < 3 + count && i >= 0; ++k, i = joints_[at(i)].next) push(i);
  }
}

void ClothoidChain::snap_kinds() {
  std::vector<int> order;
  for (int i = first_, k = 0; k < alive_elements_; i = joints_[at(i)].next, ++k) order.push_back(i);
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return joints_[at(a)].length_m > joints_[at(b)].length_m; });
  for (const ElementKind kind : {ElementKind::line, ElementKind::arc})
    for (const int i : order) {
      const Joint& joint = joints_[at(i)];
      if (joint.kind != ElementKind::clothoid) continue;
      const double k0 = joint.knot.curvature, k1 = joints_[at(joint.next)].knot.curvature,
                   l2 = joint.length_m * joint.length_m;
      // How far a node in its middle would move, neighbours aside: hopeless ones are left out.
      const double off =
          kind == ElementKind::line ? std::max(std::abs(k0), std::abs(k1)) * l2 / 8.0 : std::abs(k1 - k0) * l2 / 24.0;
      if (off > 4.0 * limits_.tolerance_m) continue;
      (void)change_kind(i, kind);
    }
}

std::vector<ClothoidChain::Element> ClothoidChain::elements() const {
  std::vector<Element> result;
  for (int i = first_, k = 0; k < alive_elements_; i = joints_[at(i)].next, ++k) {
    const Joint& joint = joints_[at(i)];
    result.push_back({joint.knot, joint.length_m, joints_[at(joint.next)].knot.curvature, joint.kind});
  }
  return result;
}

std::vector<ClothoidChain::Foot> ClothoidChain::feet() const {
  std::vector<Foot> result(nodes_.size());
  std::size_t element = 0;
  for (int i = first_, k = 0; k < alive_elements_; i = joints_[at(i)].next, ++k, ++element)
    for (std::size_t j = 0; j < joints_[at(i)].nodes; ++j) {
      const std::size_t node = wrapped(joints_[at(i)].first_node + j);
      result[node] = {element, ds_[node], distance_[node]};
    }
  return result;
}

}  // namespace orthodrive::network
