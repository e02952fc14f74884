#pragma once
// Junctions with a surface of their own.

#include <cstdint>
#include <vector>

#include "roadquery/boundary_strips.hpp"
#include "roadquery/cell_index.hpp"
#include "roadquery/junction_surface.hpp"

namespace roadquery {

/// A junction's own surface under a point.
struct JunctionOver {
  std::uint32_t junction = no_index;  ///< index into RoadMap::junctions; no_index: none
  JunctionHeight at;
};

class JunctionIndex {
 public:
  JunctionIndex() = default;
  /// Throws std::runtime_error for a junction wider than 5 km.
  explicit JunctionIndex(const RoadMap& map);

  [[nodiscard]] bool empty() const { return boundaries_.empty(); }
  /// Of the surfaces over (x, y), a point of the cell, the one nearest to z_hint (NaN: the highest).
  [[nodiscard]] JunctionOver over(const RoadMap& map, const Cell& cell, double x, double y, double z_hint) const;
  /// Indices of the connecting roads of a junction.
  [[nodiscard]] const std::vector<std::uint32_t>& roads(std::uint32_t junction) const { return roads_[junction]; }

 private:
  std::vector<BoundaryStrips> boundaries_;  // of each junction; empty when none has a surface
  std::vector<std::vector<std::uint32_t>> roads_;
};

}  // namespace roadquery
