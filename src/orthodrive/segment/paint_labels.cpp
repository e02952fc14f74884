// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/segment/paint_labels.hpp"

#include <algorithm>
#include <cmath>

#include "orthodrive/geo/segment.hpp"

namespace orthodrive {
namespace {

/// Calls visit(col, row) for the pixels whose centre is within `radius_m` of the segment.
template <typename Visit>
void visit_capsule(const GridFrame& frame, Vec2 a, Vec2 b, double radius_m, const Visit& visit) {
  const Vec2 p = frame.pixel_from_world({std::min(a.x, b.x) - radius_m, std::max(a.y, b.y) + radius_m});
  const Vec2 q = frame.pixel_from_world({std::max(a.x, b.x) + radius_m, std::min(a.y, b.y) - radius_m});
  const int begin_col = std::max(0, static_cast<int>(std::floor(p.x))),
            begin_row = std::max(0, static_cast<int>(std::floor(p.y)));
  const int end_col = static_cast<int>(std::min<double>(frame.width, std::ceil(q.x)));
  const int end_row = static_cast<int>(std::min<double>(frame.height, std::ceil(q.y)));
  for (int row = begin_row; row < end_row; ++row) {
    for (int col = begin_col; col < end_col; ++col) {
      if (distance_to_segment(a, b, frame.center_of(col, row)) <= radius_m) visit(col, row);
    }
  }
}

template <typename Visit>
void visit_line(const GridFrame& frame, const Polyline& line, double radius_m, const Visit& visit) {
  if (radius_m <= 0.0 || line.empty()) return;
  if (line.size() == 1) visit_capsule(frame, line[0], line[0], radius_m, visit);
  for (std::size_t i = 1; i < line.size(); ++i) visit_capsule(frame, line[i - 1], line[i], radius_m, visit);
}

Polyline outline_of(const Ring& ring) {
  Polyline line = ring;
  if (!line.empty()) line.push_back(line.front());
  return line;
}

class Painter {
 public:
  Painter(Raster<ClassSet>& sets, const GridFrame& frame) : sets_(sets), frame_(frame) {}

  void erase_outer_band(const PaintShape& shape, const PaintLayer& layer) {
    const auto erase_pixel = [&](int col, int row) {
      if (!merges(sets_.at(col, row), layer)) sets_.at(col, row) = unknown_class;
    };
    visit_line(frame_, shape.line, 0.5 * shape.width_m + layer.unknown_outside_m, erase_pixel);
    visit_outlines(shape, layer.unknown_outside_m, erase_pixel);
  }

  void fill(const PaintShape& shape, const PaintLayer& layer) {
    visit_line(frame_, shape.line, 0.5 * shape.width_m - layer.unknown_inside_m,
               [&](int col, int row) { put(col, row, layer); });
    for (const Polygon& polygon : shape.polygons) {
      rasterize(polygon, frame_, [&](int row, int begin, int end) {
        for (int col = begin; col < end; ++col) put(col, row, layer);
      });
    }
    visit_outlines(shape, layer.unknown_inside_m, [&](int col, int row) { sets_.at(col, row) = unknown_class; });
  }

 private:
  static bool merges(ClassSet set, const PaintLayer& layer) {
    return set != unknown_class && (set & ~layer.merge_over) == 0;
  }

  void put(int col, int row, const PaintLayer& layer) {
    ClassSet& set = sets_.at(col, row);
    set = merges(set, layer) ? static_cast<ClassSet>(set | layer.classes) : layer.classes;
  }

  template <typename Visit>
  void visit_outlines(const PaintShape& shape, double radius_m, const Visit& visit) const {
    for (const Polygon& polygon : shape.polygons) {
      visit_line(frame_, outline_of(polygon.outer), radius_m, visit);
      for (const Ring& hole : polygon.holes) visit_line(frame_, outline_of(hole), radius_m, visit);
    }
  }

  Raster<ClassSet>& sets_;
  const GridFrame& frame_;
};

}  // namespace

Raster<ClassSet> paint_labels(const GridFrame& frame, ClassSet background, const std::vector<PaintLayer>& layers) {
  Raster<ClassSet> sets(frame.width, frame.height, 1, background);
  Painter painter(sets, frame);
  for (const PaintLayer& layer : layers) {
    for (const PaintShape& shape : layer.shapes) painter.erase_outer_band(shape, layer);
    for (const PaintShape& shape : layer.shapes) painter.fill(shape, layer);
  }
  return sets;
}

}  // namespace orthodrive
