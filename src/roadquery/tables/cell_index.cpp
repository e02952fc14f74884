// SPDX-License-Identifier: Apache-2.0
#include "roadquery/tables/cell_index.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>

#include "roadquery/tables/baked_surface.hpp"
#include "roadquery/tables/junction_index.hpp"
#include "roadquery/tables/overlaps.hpp"

namespace roadquery {
namespace {

constexpr std::size_t most_entries = 60'000'000;  // 480 MB
constexpr double most_entry_turn_rad = 1.2;       // of the line within one entry
constexpr double farthest_in_entry_m = 327.0;     // of what an entry holds in cm

struct CellStation {
  std::int32_t column = 0, row = 0;
  std::uint32_t station = 0;
};

/// Whether the rectangle, grown by the margin, touches the cell: separating axes of both.
bool touches(const Station& q, const StationBox& box, double column, double row, double margin_m) {
  const double half = 0.5 * cell_m;
  const FramePoint middle = in_frame(q, (column + 0.5) * cell_m, (row + 0.5) * cell_m);
  const double spread = half * (std::abs(q.cos_hdg) + std::abs(q.sin_hdg)) + margin_m;
  return middle.along >= box.along_min - spread && middle.along <= box.along_max + spread &&
         middle.left >= box.left_min - spread && middle.left <= box.left_max + spread;
}

std::int32_t cell_of(double v) { return static_cast<std::int32_t>(std::floor(v / cell_m)); }

/// Takes from [low, high] what is not within [from, to] as slope * v + offset.
void narrow(double slope, double offset, double from, double to, double& low, double& high) {
  constexpr double least_slope = 1e-6;  // below it the whole line of cells counts as within
  if (std::abs(slope) < least_slope) return;
  const double a = (from - offset) / slope, b = (to - offset) / slope;
  low = std::max(low, std::min(a, b)), high = std::min(high, std::max(a, b));
}

/// Calls visit(column, row) for the cells that the station's box, grown by the margin, touches.
template <typename Visit>
void for_cells(const Station& q, const StationBox& box, double margin_m, const Visit& visit) {
  double west = q.x, east = q.x, south = q.y, north = q.y;
  for (const double a : {box.along_min, box.along_max}) {
    for (const double l : {box.left_min, box.left_max}) {
      const double x = q.x + a * q.cos_hdg - l * q.sin_hdg, y = q.y + a * q.sin_hdg + l * q.cos_hdg;
      west = std::min(west, x), east = std::max(east, x), south = std::min(south, y), north = std::max(north, y);
    }
  }
  const double spread = 0.5 * cell_m * (std::abs(q.cos_hdg) + std::abs(q.sin_hdg)) + margin_m;
  const std::int32_t last_row = cell_of(north + margin_m);
  for (std::int32_t row = cell_of(south - margin_m); row <= last_row; ++row) {
    // The columns that are not far from the box in this row: most of the rectangle around a slanting one are.
    const FramePoint begin = in_frame(q, 0.5 * cell_m, (row + 0.5) * cell_m);
    double low = cell_of(west - margin_m), high = cell_of(east + margin_m);
    narrow(cell_m * q.cos_hdg, begin.along, box.along_min - spread, box.along_max + spread, low, high);
    narrow(-cell_m * q.sin_hdg, begin.left, box.left_min - spread, box.left_max + spread, low, high);
    const auto last = static_cast<std::int32_t>(std::floor(high)) + 1;
    for (auto column = static_cast<std::int32_t>(std::ceil(low)) - 1; column <= last; ++column)
      if (touches(q, box, column, row, margin_m)) visit(column, row);
  }
}

double turn_of(const Station& q) { return 4.0 * std::abs(static_cast<double>(q.bend[0][1])) * q.half_m; }

struct CellRange {
  std::int32_t column = 0, row = 0;
  StationRange range;
  bool is_junction = false;  // range.first: which
};

/// The cells of a road's stations, as ranges of successive stations that turn little.
void append_ranges(const BakedRoads& roads, std::vector<CellStation>& cells, std::vector<CellRange>& ranges) {
  constexpr std::uint32_t most_in_entry = 60'000;
  std::sort(cells.begin(), cells.end(), [](const CellStation& a, const CellStation& b) {
    if (a.row != b.row) return a.row < b.row;
    return a.column != b.column ? a.column < b.column : a.station < b.station;
  });
  double turn = 0.0;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const CellStation& c = cells[i];
    turn += turn_of(roads.stations[c.station]);
    const bool goes_on = i > 0 && cells[i - 1].column == c.column && cells[i - 1].row == c.row &&
                         cells[i - 1].station + 1 == c.station && turn <= most_entry_turn_rad &&
                         c.station - ranges.back().range.first < most_in_entry;
    if (goes_on) {
      ranges.back().range.last = c.station;
    } else {
      ranges.push_back({c.column, c.row, {c.station, c.station}});
      turn = turn_of(roads.stations[c.station]);
    }
  }
  if (ranges.size() > most_entries) throw std::runtime_error("the roads cover too large an area");
}

/// Calls visit(x, y) for points of the boundary that are less than half a cell apart.
template <typename Visit>
void walk_boundary(const JunctionSurface& surface, const Visit& visit) {
  for (std::size_t i = 0, before = surface.boundary.size() - 1; i < surface.boundary.size(); before = i++) {
    const auto &a = surface.boundary[before], &b = surface.boundary[i];
    const double length = std::max(std::abs(b[0] - a[0]), std::abs(b[1] - a[1]));
    const int parts = 1 + static_cast<int>(length / (0.5 * cell_m));
    for (int k = 0; k < parts; ++k) visit(a[0] + (b[0] - a[0]) * k / parts, a[1] + (b[1] - a[1]) * k / parts);
  }
}

/// The cells that junctions' own surfaces touch, and some beside them.
void append_junction_cells(const RoadMap& map, std::vector<CellRange>& ranges) {
  std::vector<std::pair<std::int32_t, std::int32_t>> cells;  // row, column
  for (std::uint32_t i = 0; i < map.junctions.size(); ++i) {
    const JunctionSurface* surface = surface_of(map.junctions[i]);
    if (!surface) continue;
    cells.clear();
    walk_boundary(*surface, [&](double x, double y) {
      for (const double dy : {-0.5 * cell_m, 0.0, 0.5 * cell_m})
        for (const double dx : {-0.5 * cell_m, 0.0, 0.5 * cell_m}) cells.emplace_back(cell_of(y + dy), cell_of(x + dx));
      if (cells.size() > most_entries) throw std::runtime_error("the junctions cover too large an area");
    });
    std::sort(cells.begin(), cells.end());
    cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
    const std::size_t on_boundary = cells.size();
    for (std::size_t k = 0; k + 1 < on_boundary; ++k) {  // between two of a row all or none lie inside
      const auto [row, column] = cells[k];
      const auto [next_row, end] = cells[k + 1];
      if (row != next_row || end - column < 2 || !contains(*surface, (column + 1.5) * cell_m, (row + 0.5) * cell_m))
        continue;
      for (std::int32_t c = column + 1; c < end; ++c) cells.emplace_back(row, c);
      if (cells.size() > most_entries) throw std::runtime_error("the junctions cover too large an area");
    }
    for (const auto& [row, column] : cells) ranges.push_back({column, row, {i, i}, true});
    if (ranges.size() > most_entries) throw std::runtime_error("the junctions cover too large an area");
  }
}

std::int16_t to_cm(double m, bool up) {
  const double cm = up ? std::ceil(100.0 * m) : std::floor(100.0 * m);
  return static_cast<std::int16_t>(std::clamp(cm, -32767.0, 32767.0));
}

CellEntry outline_of(const BakedRoads& roads, const CellRange& r) {
  CellEntry entry;
  entry.first = r.range.first;
  entry.count = static_cast<std::uint16_t>(r.range.last - r.range.first + 1);
  entry.middle = entry.count / 2;
  const Station& middle = roads.stations[entry.first + entry.middle];
  entry.lanes = middle.lanes;
  const double from_x = middle.x - r.column * cell_m, from_y = middle.y - r.row * cell_m;
  entry.x = to_cm(from_x, false), entry.y = to_cm(from_y, false);
  if (!(std::max(std::abs(from_x), std::abs(from_y)) < farthest_in_entry_m)) {  // of a very wide road: no outline
    entry.along_min = entry.left_min = -32768, entry.along_max = entry.left_max = 32767;
    return entry;
  }
  const double x = r.column * cell_m + 0.01 * entry.x, y = r.row * cell_m + 0.01 * entry.y;
  entry.curvature = 2.0F * middle.bend[0][1] / (middle.speed * middle.speed);
  entry.cos_hdg = static_cast<std::int16_t>(std::lround(32767.0 * middle.cos_hdg));
  entry.sin_hdg = static_cast<std::int16_t>(std::lround(32767.0 * middle.sin_hdg));
  double along_min = 1e30, along_max = -1e30, left_min = 1e30, left_max = -1e30;
  const double c = entry.cos_hdg / 32767.0, n = entry.sin_hdg / 32767.0;
  for (std::uint32_t i = r.range.first; i <= r.range.last; ++i) {
    const Station& q = roads.stations[i];
    const LaneStretch& lanes = roads.stretches[q.lanes];
    for (const double part : {-1.0, 0.0, 1.0}) {
      const double u = part * q.half_m;
      const LinePolynomial line = line_at(q, u);
      const Pair edges = cubics_at(lanes.edges, q.s + u - lanes.s);
      const AheadRange ahead = ahead_range(roads, q, u);
      for (const double ahead_m : {ahead.min_m, ahead.max_m})
        for (const double t : {edges[0], 0.5 * (edges[0] + edges[1]), edges[1]}) {
          const FramePoint at = place_beside(line, {ahead_m, t});
          const double dx = q.x - x + at.along * q.cos_hdg - at.left * q.sin_hdg,
                       dy = q.y - y + at.along * q.sin_hdg + at.left * q.cos_hdg;
          const double along = dx * c + dy * n, left = dy * c - dx * n - 0.5 * entry.curvature * along * along;
          along_min = std::min(along_min, along), along_max = std::max(along_max, along);
          left_min = std::min(left_min, left), left_max = std::max(left_max, left);
        }
    }
  }
  entry.along_min = to_cm(along_min - outline_margin_m, false),
  entry.along_max = to_cm(along_max + outline_margin_m, true);
  entry.left_min = to_cm(left_min - outline_margin_m, false), entry.left_max = to_cm(left_max + outline_margin_m, true);
  return entry;
}

}  // namespace

CellIndex::CellIndex(const BakedRoads& roads, const RoadMap& map) {
  std::vector<CellRange> ranges;
  std::vector<CellStation> cells;
  for (std::size_t road = 0; road + 1 < roads.first_station.size(); ++road) {
    cells.clear();
    for (std::uint32_t i = roads.first_station[road]; i < roads.first_station[road + 1]; ++i) {
      const Station& q = roads.stations[i];
      if (q.shape_count == unusable_station) continue;
      for_cells(q, station_box(roads, q), cell_margin_m, [&](std::int32_t column, std::int32_t row) {
        if (cells.size() == most_entries) throw std::runtime_error("the roads cover too large an area");
        cells.push_back({column, row, i});
      });
    }
    append_ranges(roads, cells, ranges);
  }
  append_junction_cells(map, ranges);
  if (ranges.empty()) return;
  std::size_t capacity = 2;
  while (capacity < 2 * ranges.size()) capacity *= 2;
  slots_.resize(capacity);
  for (const CellRange& r : ranges) {
    Slot& slot = slots_[slot_of(r.column, r.row)];
    slot.column = r.column, slot.row = r.row, ++slot.count;
  }
  std::size_t used = 0;
  for (const Slot& slot : slots_) used += slot.count > 0 ? 1 : 0;
  LargeVector<Slot> all;
  all.swap(slots_);
  for (capacity = 2; capacity < 2 * used;) capacity *= 2;
  slots_.resize(capacity);
  std::uint32_t begin = 0;
  for (const Slot& slot : all) {
    if (slot.count == 0) continue;
    slots_[slot_of(slot.column, slot.row)] = {slot.column, slot.row, begin, slot.count};
    begin += slot.count;
  }
  entries_.resize(ranges.size());
  std::vector<std::uint32_t> filled(slots_.size(), 0);
  for (const CellRange& r : ranges) {
    const std::size_t slot = slot_of(r.column, r.row);
    entries_[slots_[slot].begin + filled[slot]++] =
        r.is_junction ? CellEntry{.first = r.range.first} : outline_of(roads, r);
  }
}

/// The slot of a cell, or the empty one where it would be.
std::size_t CellIndex::slot_of(std::int32_t column, std::int32_t row) const {
  const std::size_t mask = slots_.size() - 1;
  const std::uint64_t key = (std::uint64_t{static_cast<std::uint32_t>(row)} << 32) | static_cast<std::uint32_t>(column);
  std::uint64_t mixed = key * 0x9e3779b97f4a7c15ULL;  // Fibonacci hashing (Knuth, vol. 3, 6.4)
  mixed ^= mixed >> 32;
  std::size_t slot = static_cast<std::size_t>(mixed) & mask;
  while (slots_[slot].count != 0 && (slots_[slot].column != column || slots_[slot].row != row))
    slot = (slot + 1) & mask;
  return slot;
}

Cell CellIndex::at(double x, double y) const {
  constexpr double farthest_in_entry_m = 4e9;  // more than any road has, less than an index holds
  if (slots_.empty() || !(std::abs(x) < farthest_in_entry_m && std::abs(y) < farthest_in_entry_m)) return {};
  const double column = std::floor(x * (1.0 / cell_m)), row = std::floor(y * (1.0 / cell_m));
  const Slot& slot = slots_[slot_of(static_cast<std::int32_t>(column), static_cast<std::int32_t>(row))];
  for (std::uint32_t i = 0; i < std::min(slot.count, 8U); i += 2) __builtin_prefetch(entries_.data() + slot.begin + i);
  return {{entries_.data() + slot.begin, slot.count},
          static_cast<float>(x - column * cell_m),
          static_cast<float>(y - row * cell_m)};
}

void CellIndex::append_junctions(const Station& q, const StationBox& box, std::vector<std::uint32_t>& junctions) const {
  const std::size_t before = junctions.size();
  for_cells(q, box, 0.0, [&](std::int32_t column, std::int32_t row) {
    const Slot& slot = slots_[slot_of(column, row)];
    for (const CellEntry& entry : Cell{{entries_.data() + slot.begin, slot.count}}.junctions())
      if (std::find(junctions.begin() + static_cast<std::ptrdiff_t>(before), junctions.end(), entry.first) ==
          junctions.end())
        junctions.push_back(entry.first);
  });
}

void CellIndex::append_near(const Station& q, const StationBox& box, std::uint32_t index,
                            std::vector<std::uint32_t>& seen_by, std::vector<std::uint32_t>& stations) const {
  for_cells(q, box, 0.0, [&](std::int32_t column, std::int32_t row) {
    const Slot& slot = slots_[slot_of(column, row)];
    for (std::uint32_t e = slot.begin; e < slot.begin + slot.count; ++e) {
      const CellEntry& entry = entries_[e];
      if (index - entry.first < entry.count) continue;  // its own part of its own road
      for (std::uint32_t k = entry.first; k < entry.first + entry.count; ++k) {
        if (seen_by[k] == index) continue;
        seen_by[k] = index;
        stations.push_back(k);
      }
    }
  });
}

}  // namespace roadquery
