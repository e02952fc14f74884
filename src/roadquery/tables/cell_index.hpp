// SPDX-License-Identifier: Apache-2.0
#pragma once
// Which stations of baked roads lie over a place: a hash table of square cells.

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "roadquery/tables/baked_road.hpp"

namespace roadquery {

/// Distance beyond the surface of its stations that a cell still lists them for, m.
inline constexpr double cell_margin_m = 0.3;
inline constexpr double cell_m = 4.0;

/// Stations of one road over a cell, or a junction's own surface (count 0, first: index into RoadMap::junctions). Of
/// stations: the line turns by less than a right angle along them. A rough outline of their
/// surface tells most points beside it without a look at the stations: half a cache line.
struct CellEntry {
  std::uint32_t first = 0;
  std::uint16_t count = 0, middle = 0;        ///< the station `first + middle` is the outline's origin
  std::uint32_t lanes = 0;                    ///< its stretch: to be fetched beside it
  std::int16_t x = 0, y = 0;                  ///< of it, in cm from the cell's south-west corner
  float curvature = 0.0F;                     ///< of the parabola that the outline follows
  std::int16_t cos_hdg = 0, sin_hdg = 0;      ///< in 1 / 32767
  std::int16_t along_min = 0, along_max = 0;  ///< in cm
  std::int16_t left_min = 0, left_max = 0;    ///< in cm, from the parabola
};
static_assert(sizeof(CellEntry) == 32);

/// The entries of a cell, junctions last, and the point's place in it.
struct Cell {
  std::span<const CellEntry> entries;
  float x = 0.0F, y = 0.0F;

  [[nodiscard]] std::span<const CellEntry> junctions() const {
    std::size_t roads = entries.size();
    while (roads > 0 && entries[roads - 1].count == 0) --roads;
    return entries.subspan(roads);
  }
};

/// Largest offset of the outline from a sampled surface, m.
inline constexpr double outline_margin_m = 0.15;

/// The stations of the entry that may lie within reach_m of (x, y) of its cell, and the one to begin with; false when
/// none does.
inline bool may_touch(const CellEntry& entry, float x, float y, float reach_m, StationRange& range,
                      std::uint32_t& start) {
  if (entry.count == 0) return false;
  constexpr float from_int = 1.0F / 32767.0F, from_cm = 0.01F, farthest_m = 327.0F;
  const float dx = x - static_cast<float>(entry.x) * from_cm, dy = y - static_cast<float>(entry.y) * from_cm;
  const float cos_hdg = static_cast<float>(entry.cos_hdg) * from_int,
              sin_hdg = static_cast<float>(entry.sin_hdg) * from_int;
  const float along = dx * cos_hdg + dy * sin_hdg;
  const float left =
      std::clamp(dy * cos_hdg - dx * sin_hdg - 0.5F * entry.curvature * along * along, -farthest_m, farthest_m);
  const float low = static_cast<float>(entry.along_min) * from_cm, high = static_cast<float>(entry.along_max) * from_cm;
  if (std::clamp(along, -farthest_m, farthest_m) < low - reach_m ||
      std::clamp(along, -farthest_m, farthest_m) > high + reach_m ||
      left < static_cast<float>(entry.left_min) * from_cm - reach_m ||
      left > static_cast<float>(entry.left_max) * from_cm + reach_m)
    return false;
  const float steps = along * static_cast<float>(entry.count) / std::max(high - low, 0.01F);
  const int offset =
      static_cast<int>(std::clamp(static_cast<float>(entry.middle) + steps, 0.0F, static_cast<float>(entry.count - 1)));
  range = {entry.first, entry.first + entry.count - 1U};
  start = entry.first + static_cast<std::uint32_t>(offset);
  return true;
}

struct StationBox;

class CellIndex {
 public:
  CellIndex() = default;
  /// Throws std::runtime_error when the roads cover more cells than memory should be spent on.
  CellIndex(const BakedRoads& roads, const RoadMap& map);

  /// Empty where there is no road; any numbers are fine, also infinite ones.
  [[nodiscard]] Cell at(double x, double y) const;
  /// Appends the stations of all cells that the box of station `index` touches, but those around itself, each once.
  /// `seen_by` has one number a station: the index of the last station that it was appended for.
  void append_near(const Station& station, const StationBox& box, std::uint32_t index,
                   std::vector<std::uint32_t>& seen_by, std::vector<std::uint32_t>& stations) const;
  /// Appends the junctions whose own surfaces may touch the box of a station, each once.
  void append_junctions(const Station& station, const StationBox& box, std::vector<std::uint32_t>& junctions) const;

 private:
  struct Slot {
    std::int32_t column = 0, row = 0;
    std::uint32_t begin = 0, count = 0;  // count 0: an empty slot
  };
  [[nodiscard]] std::size_t slot_of(std::int32_t column, std::int32_t row) const;

  LargeVector<Slot> slots_;  // a power of two, at most half full; linear probing
  LargeVector<CellEntry> entries_;
};

}  // namespace roadquery
