#pragma once
// Which junctions with a surface of their own lie over a place.

#include <cstdint>
#include <vector>

#include "roadquery/baked_road.hpp"
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
  /// Stations near a junction's surface lose their free width: the junction must be asked there.
  JunctionIndex(const RoadMap& map, BakedRoads& roads);

  [[nodiscard]] bool empty() const { return cells_.empty(); }
  /// Of the surfaces over (x, y) the one nearest to z_hint (NaN: the highest).
  [[nodiscard]] JunctionOver over(const RoadMap& map, double x, double y, double z_hint) const;
  /// Indices of the connecting roads of a junction.
  [[nodiscard]] const std::vector<std::uint32_t>& roads(std::uint32_t junction) const { return roads_[junction]; }

 private:
  struct CellJunction {
    std::int32_t row = 0, column = 0;
    std::uint32_t junction = 0;
    friend bool operator<(const CellJunction& a, const CellJunction& b) {
      if (a.row != b.row) return a.row < b.row;
      return a.column != b.column ? a.column < b.column : a.junction < b.junction;
    }
  };
  [[nodiscard]] std::vector<CellJunction>::const_iterator first_at(std::int32_t row, std::int32_t column) const;

  std::vector<CellJunction> cells_;  // sorted
  std::vector<std::vector<std::uint32_t>> roads_;
};

}  // namespace roadquery
