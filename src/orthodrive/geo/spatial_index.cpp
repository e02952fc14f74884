// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/geo/spatial_index.hpp"

#include <algorithm>
#include <boost/geometry/geometries/box.hpp>
#include <boost/geometry/geometries/point_xy.hpp>
#include <boost/geometry/index/rtree.hpp>
#include <boost/iterator/function_output_iterator.hpp>
#include <utility>

#include "orthodrive/geo/segment.hpp"

namespace orthodrive {
namespace {

namespace bg = boost::geometry;
using TreeBox = bg::model::box<bg::model::d2::point_xy<double>>;
using Entry = std::pair<TreeBox, std::uint32_t>;

constexpr double rounding_m = 1e-6;      // of what callers compute from UTM coordinates, a hundredfold
constexpr std::size_t node_entries = 8;  // of 4, 8, 16 and 32 the fastest for the point queries of the scene stage

TreeBox tree_box(const Box2& box) { return {{box.min_x, box.min_y}, {box.max_x, box.max_y}}; }

std::vector<Entry> entries_of(std::span<const Box2> boxes) {
  std::vector<Entry> entries;
  entries.reserve(boxes.size());
  for (std::size_t i = 0; i < boxes.size(); ++i)
    entries.emplace_back(tree_box(boxes[i]), static_cast<std::uint32_t>(i));
  return entries;
}

}  // namespace

struct SpatialIndex::Tree {
  explicit Tree(std::span<const Box2> boxes) : rtree(entries_of(boxes)) {}  // a range at once: packed
  bg::index::rtree<Entry, bg::index::quadratic<node_entries>> rtree;
};

SpatialIndex::SpatialIndex(std::span<const Box2> boxes) {
  if (!boxes.empty()) tree_ = std::make_shared<const Tree>(boxes);
}

std::vector<std::uint32_t> SpatialIndex::touching(const Box2& box) const {
  std::vector<std::uint32_t> found;
  if (!tree_) return found;
  tree_->rtree.query(bg::index::intersects(tree_box(box.grown(rounding_m))),
                     boost::make_function_output_iterator([&](const Entry& entry) { found.push_back(entry.second); }));
  std::sort(found.begin(), found.end());
  return found;
}

std::vector<std::uint32_t> SpatialIndex::near(Vec2 p, double reach_m) const {
  return touching(Box2{p.x, p.y, p.x, p.y}.grown(reach_m));
}

SegmentIndex::SegmentIndex(std::span<const Polyline> lines) {
  std::vector<Box2> boxes;
  for (std::size_t l = 0; l < lines.size(); ++l)
    for (std::size_t i = 0; i + 1 < lines[l].size(); ++i) {
      segments_.push_back({static_cast<std::uint32_t>(l), static_cast<std::uint32_t>(i)});
      boxes.push_back(segment_box(lines[l][i], lines[l][i + 1]));
    }
  index_ = SpatialIndex(boxes);
}

std::vector<SegmentIndex::Segment> SegmentIndex::touching(const Box2& box) const {
  std::vector<Segment> found;
  for (const std::uint32_t i : index_.touching(box)) found.push_back(segments_[i]);
  return found;
}

std::vector<SegmentIndex::Segment> SegmentIndex::near(Vec2 p, double reach_m) const {
  return touching(Box2{p.x, p.y, p.x, p.y}.grown(reach_m));
}

}  // namespace orthodrive
