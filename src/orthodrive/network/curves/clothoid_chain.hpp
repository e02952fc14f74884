// SPDX-License-Identifier: Apache-2.0
#pragma once
// A chain of clothoids, arcs and lines beside nodes, and what makes it shorter: joints are taken out and elements made
// straight or round while all nodes stay near.
//
// Every change is a small least squares problem: the elements of a window (a few to each side of the change) may change
// their lengths and the curvatures at their joints, the rest of the chain stands still. Gauss-Newton on the nodes'
// lateral distances under the condition that the window ends where it ended: place, heading and curvature at its border
// do not change, so the whole stays continuous to rounding whatever its length, and the cost is linear in it.

#include <cstdint>
#include <span>
#include <vector>

#include "orthodrive/network/curves/clothoid.hpp"

namespace orthodrive::network {

enum class ElementKind : std::uint8_t { clothoid, arc, line };

struct ChainLimits {
  double tolerance_m = 0.05;
  double min_element_m = 0.5;
  double max_curvature_rate = 0.0;        ///< 1/m^2
  std::span<const double> max_curvature;  ///< 1/m, one per node; empty: no limit
};

class ClothoidChain {
 public:
  /// `start` has its knots at the nodes `at` (ascending, first and last node of an open chain). Closed chains: the
  /// nodes do not repeat the first one.
  ClothoidChain(std::span<const Vec2> nodes, bool closed, const ClothoidSpline& start, std::span<const std::size_t> at,
                const ChainLimits& limits);

  /// Takes joints out, `count` neighbours at a time, those that bend least first, as long as the limits hold.
  void remove_knots(int count);
  /// Makes straight elements lines and round ones arcs where the limits hold.
  void snap_kinds();

  /// Moves the line to where least squares wants it.
  void polish();

  struct Element {
    Knot start;
    double length_m = 0.0, end_curvature = 0.0;
    ElementKind kind = ElementKind::clothoid;
  };
  [[nodiscard]] std::vector<Element> elements() const;
  /// Of every node: where its foot lies (element of elements(), distance from the element's start) and how far away it
  /// is.
  struct Foot {
    std::size_t element = 0;
    double ds_m = 0.0, distance_m = 0.0;
  };
  [[nodiscard]] std::vector<Foot> feet() const;

 private:
  static constexpr int max_elements = 8;
  struct Joint {
    Knot knot;
    int next = -1, previous = -1;  ///< -1: the end of an open chain, or taken out
    double length_m = 0.0;         ///< of the element that begins here
    ElementKind kind = ElementKind::clothoid;
    std::size_t first_node = 0, nodes = 0;  ///< whose feet lie on that element; counted on past the last node
    bool alive = true;
  };
  struct Window;

  [[nodiscard]] std::size_t wrapped(std::size_t node) const {
    return node < nodes_.size() ? node : node - nodes_.size();
  }
  [[nodiscard]] bool collect(int from, int back, int ahead, Window& window) const;
  [[nodiscard]] bool solve(Window& window, int least_iterations);
  void evaluate(Window& window, bool derive);
  [[nodiscard]] bool within_limits(const Window& window) const;
  void commit(const Window& window);
  [[nodiscard]] bool remove(int joint, int count);
  [[nodiscard]] bool change_kind(int joint, ElementKind kind);
  [[nodiscard]] double removal_cost(int joint, int count) const;

  std::span<const Vec2> nodes_;
  bool closed_;
  ChainLimits limits_;
  std::vector<Joint> joints_;
  std::vector<double> ds_, distance_;  ///< of every node: on its element, from it
  int alive_elements_ = 0;
  int first_ = 0;  ///< a joint that is alive; the start of open chains
};

}  // namespace orthodrive::network
