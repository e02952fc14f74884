// SPDX-License-Identifier: Apache-2.0
#pragma once
// Which boxes, or which segments of many lines, are near a place? An R-tree (Boost.Geometry), built once.

#include <compare>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "orthodrive/geo/polyline.hpp"
#include "orthodrive/geo/vec.hpp"

namespace orthodrive {

/// Answers are supersets: boxes up to a micrometre away count too, so that the caller's exact test decides and
/// rounding loses nothing. They ascend, so that no output depends on the tree. Queries are safe from any thread.
class SpatialIndex {
 public:
  SpatialIndex() = default;
  /// Does not keep the boxes.
  explicit SpatialIndex(std::span<const Box2> boxes);

  /// Indices of the boxes that touch the given one.
  [[nodiscard]] std::vector<std::uint32_t> touching(const Box2& box) const;
  /// Indices of the boxes that touch the square of +-reach_m around p.
  [[nodiscard]] std::vector<std::uint32_t> near(Vec2 p, double reach_m) const;

 private:
  struct Tree;
  std::shared_ptr<const Tree> tree_;  // none: empty
};

/// The same for the segments of lines.
class SegmentIndex {
 public:
  struct Segment {
    std::uint32_t line = 0, index = 0;  ///< from point `index` of a line to the next
    friend auto operator<=>(const Segment&, const Segment&) = default;
  };
  SegmentIndex() = default;
  /// Does not keep the lines.
  explicit SegmentIndex(std::span<const Polyline> lines);

  /// The segments whose boxes touch the given one, in order of line and index.
  [[nodiscard]] std::vector<Segment> touching(const Box2& box) const;
  [[nodiscard]] std::vector<Segment> near(Vec2 p, double reach_m) const;

 private:
  std::vector<Segment> segments_;
  SpatialIndex index_;
};

}  // namespace orthodrive
