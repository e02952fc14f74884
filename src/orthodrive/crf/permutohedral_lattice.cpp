// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/crf/permutohedral_lattice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>

#include "orthodrive/core/error.hpp"

namespace orthodrive {

namespace {

constexpr std::uint32_t none = 0xffffffffU;

/// Lattice points as integers. All D + 1 coordinates of a lattice point are congruent to its remainder k modulo D + 1
/// and their sum is 0, so D quotients and k tell them apart. k sits in the lowest bits, each quotient in a field of its
/// own, counted from the lowest one that can occur: a step along an axis is the addition of a constant.
template <int D>
struct KeyLayout {
  std::array<std::int64_t, D> lowest;
  std::array<int, D> shift;
  static constexpr int remainder_bits = std::bit_width(static_cast<unsigned>(D));

  [[nodiscard]] std::uint64_t unit(int i) const { return i < D ? std::uint64_t{1} << shift[i] : 0; }
  /// The neighbour along axis j: coordinate j falls by D, all others grow by 1.
  [[nodiscard]] std::uint64_t next(std::uint64_t key, int j) const {
    constexpr std::uint64_t mask = (1U << remainder_bits) - 1;
    if ((key & mask) < D) return key + 1 - unit(j);
    std::uint64_t all = 0;
    for (int i = 0; i < D; ++i) all += unit(i);
    return key - D + all - unit(j);
  }
};

/// Kraehenbuehl's scaling: the blur's variance of 2 / 3 (D + 1)^2 in the elevated space becomes 1, and row f of the
/// triangular basis gets unit length.
template <int D>
std::array<double, D> axis_scales() {
  std::array<double, D> scales;
  for (int f = 0; f < D; ++f) scales[f] = std::sqrt(2.0 / 3.0) * (D + 1) / std::sqrt((f + 1.0) * (f + 2.0));
  return scales;
}

template <int D>
KeyLayout<D> make_layout(const typename PermutohedralLattice<D>::Range& range) {
  const auto scales = axis_scales<D>();
  KeyLayout<D> layout;
  int bits = KeyLayout<D>::remainder_bits;
  for (int i = 0; i < D; ++i) {
    double low = 0.0, high = 0.0;  // of coordinate i, see embed
    for (int f = i; f < D; ++f) low += scales[f] * range.low[f], high += scales[f] * range.high[f];
    if (i > 0) low -= i * scales[i - 1] * range.high[i - 1], high -= i * scales[i - 1] * range.low[i - 1];
    const double lowest = std::floor(low / (D + 1)) - 2, highest = std::ceil(high / (D + 1)) + 2;
    if (!(std::abs(lowest) < 1e15 && highest - lowest < 1e15))
      throw OptionError("permutohedral lattice: features are not finite, or too large; check the kernel widths");
    layout.lowest[i] = static_cast<std::int64_t>(lowest);
    layout.shift[i] = bits;
    bits += std::bit_width(static_cast<std::uint64_t>(highest - lowest));
  }
  if (bits > 63)
    throw OptionError(
        fmt::format("permutohedral lattice: {} bits are needed to number the cells, 63 are there; use wider kernels or "
                    "smaller windows",
                    bits));
  return layout;
}

/// From keys to vertex numbers in order of first appearance. Open addressing, linear probing, at most half full.
class VertexTable {
 public:
  explicit VertexTable(std::size_t expected) { rehash(std::bit_ceil(std::max<std::size_t>(expected, 64) * 2)); }

  void reserve_more(std::size_t count) {
    while ((keys_.size() + count) * 2 > slots_.size()) rehash(slots_.size() * 2);
  }
  void prefetch(std::uint64_t key) const { __builtin_prefetch(&slots_[slot_of(key)]); }
  [[nodiscard]] std::uint32_t find(std::uint64_t key) const { return slots_[probe(key)].vertex; }
  [[nodiscard]] std::uint32_t find_or_add(std::uint64_t key) {
    Slot& slot = slots_[probe(key)];
    if (slot.vertex == none) {
      slot = {key, static_cast<std::uint32_t>(keys_.size())};
      keys_.push_back(key);
    }
    return slot.vertex;
  }
  [[nodiscard]] const std::vector<std::uint64_t>& keys() const { return keys_; }

 private:
  struct Slot {
    std::uint64_t key = 0;
    std::uint32_t vertex = none;
  };
  [[nodiscard]] std::size_t slot_of(std::uint64_t key) const { return (key * 0x9e3779b97f4a7c15ULL) >> shift_; }
  [[nodiscard]] std::size_t probe(std::uint64_t key) const {
    std::size_t i = slot_of(key);
    while (slots_[i].vertex != none && slots_[i].key != key) i = (i + 1) & (slots_.size() - 1);
    return i;
  }
  void rehash(std::size_t size) {
    slots_.assign(size, {});
    shift_ = 64 - std::countr_zero(size);
    for (std::size_t v = 0; v < keys_.size(); ++v) slots_[probe(keys_[v])] = {keys_[v], static_cast<std::uint32_t>(v)};
  }
  std::vector<Slot> slots_;
  std::vector<std::uint64_t> keys_;
  int shift_ = 0;
};

/// Lane-wise results of embedding a block of points.
template <int D>
struct Embedding {
  static constexpr std::size_t lanes = PermutohedralLattice<D>::block;
  alignas(64) double feature[D][lanes];
  alignas(64) double rest[D + 1][lanes];      ///< coordinate minus that of the nearest point of remainder 0
  alignas(64) double quotient[D + 1][lanes];  ///< that point, divided by D + 1
  alignas(64) double rank[D + 1][lanes];      ///< of the coordinate's rest among all, 0 is the largest
};

/// Adams et al. 2010, sec. 3.1. In double throughout, so that a pixel of a large mosaic gets the same simplex in any
/// window.
template <int D>
void embed(Embedding<D>& e) {
  constexpr std::size_t lanes = Embedding<D>::lanes;
  constexpr double round = 0x1.8p52;  // adding and subtracting it rounds to an integer
  const auto scales = axis_scales<D>();
  alignas(64) double sum[lanes] = {}, excess[lanes] = {};
  for (int i = D; i >= 0; --i) {  // coordinate i: sum of the scaled features from i on, minus i times feature i - 1
    for (std::size_t l = 0; l < lanes; ++l) {
      const double scaled = i > 0 ? e.feature[i > 0 ? i - 1 : 0][l] * scales[i > 0 ? i - 1 : 0] : 0.0;
      const double coordinate = sum[l] - i * scaled;
      sum[l] += scaled;
      const double quotient = (coordinate * (1.0 / (D + 1)) + round) - round;
      e.quotient[i][l] = quotient;
      e.rest[i][l] = coordinate - quotient * (D + 1);
      excess[l] += quotient;
      e.rank[i][l] = 0.0;
    }
  }
  for (int i = 0; i < D; ++i)
    for (int j = i + 1; j <= D; ++j)
      for (std::size_t l = 0; l < lanes; ++l) {
        const double below = e.rest[i][l] < e.rest[j][l] ? 1.0 : 0.0;
        e.rank[i][l] += below;
        e.rank[j][l] += 1.0 - below;
      }
  // Rounding may have left the plane of sum 0: move the coordinates with the largest rounding errors back.
  for (int i = 0; i <= D; ++i)
    for (std::size_t l = 0; l < lanes; ++l) {
      const double rank = e.rank[i][l] + excess[l];
      const double step = rank < 0.0 ? 1.0 : rank > D ? -1.0 : 0.0;
      e.rank[i][l] = rank + step * (D + 1);
      e.quotient[i][l] += step;
      e.rest[i][l] -= step * (D + 1);
    }
}

template <int D>
BlurAxis link_axis(const VertexTable& table, const KeyLayout<D>& layout, int axis) {
  const std::vector<std::uint64_t>& keys = table.keys();
  constexpr std::size_t ahead = 16;
  std::vector<std::uint32_t> next(keys.size());
  std::vector<bool> has_previous(keys.size());
  for (std::size_t v = 0; v < std::min(ahead, keys.size()); ++v) table.prefetch(layout.next(keys[v], axis));
  for (std::size_t v = 0; v < keys.size(); ++v) {
    if (v + ahead < keys.size()) table.prefetch(layout.next(keys[v + ahead], axis));
    next[v] = table.find(layout.next(keys[v], axis));
    if (next[v] != none) has_previous[next[v]] = true;
  }
  BlurAxis result;
  for (std::size_t v = 0; v < keys.size(); ++v) {
    if (has_previous[v] || next[v] == none) continue;
    const std::uint32_t second = next[v];
    if (next[second] == none) {
      result.pairs.insert(result.pairs.end(), {static_cast<std::uint32_t>(v), second});
      continue;
    }
    const std::size_t length_at = result.chains.size();
    result.chains.push_back(0);
    for (auto u = static_cast<std::uint32_t>(v); u != none; u = next[u]) result.chains.push_back(u);
    result.chains[length_at] = static_cast<std::uint32_t>(result.chains.size() - length_at - 1);
  }
  return result;
}

void blur_axis(const BlurAxis& axis, std::vector<float>& values) {
  for (std::size_t i = 0; i < axis.pairs.size(); i += 2) {
    float &a = values[axis.pairs[i]], &b = values[axis.pairs[i + 1]];
    const float old = a;
    a += 0.5F * b;
    b += 0.5F * old;
  }
  for (std::size_t i = 0; i < axis.chains.size();) {
    const std::size_t end = i + 1 + axis.chains[i];
    float previous = 0.0F;
    for (++i; i < end; ++i) {
      float& value = values[axis.chains[i]];
      const float old = value, next = i + 1 < end ? values[axis.chains[i + 1]] : 0.0F;
      value += 0.5F * (previous + next);
      previous = old;
    }
  }
}

}  // namespace

template <int D>
PermutohedralLattice<D>::PermutohedralLattice(std::size_t points, const Range& range, const FeatureSource& source)
    : points_(points) {
  const KeyLayout<D> layout = make_layout<D>(range);
  VertexTable table(points / 2);  // a natural photo at the usual widths has up to 0.4 per pixel
  Embedding<D> e{};
  std::uint64_t keys[block][D + 1];
  for (std::size_t first = 0; first < points; first += block) {
    const std::size_t count = std::min(block, points - first);
    source(first, count, &e.feature[0][0]);
    embed(e);
    table.reserve_more(block * (D + 1));
    for (std::size_t l = 0; l < count; ++l) {
      std::uint64_t key = 0, unit_of_rank[D + 1];
      double rest_of_rank[D + 1];
      for (int i = 0; i <= D; ++i) {
        const int rank = static_cast<int>(e.rank[i][l]);
        rest_of_rank[rank] = e.rest[i][l] * (1.0 / (D + 1));
        unit_of_rank[rank] = layout.unit(i);
        if (i < D) {
          assert(e.feature[i][l] >= range.low[i] && e.feature[i][l] <= range.high[i]);
          key += static_cast<std::uint64_t>(static_cast<std::int64_t>(e.quotient[i][l]) - layout.lowest[i])
                 << layout.shift[i];
        }
      }
      // Corner k + 1 differs from corner k by 1 everywhere but for -D at the coordinate of rank D - k.
      LatticePoint<D>& point = points_[first + l];
      for (int k = 0; k <= D; ++k) {
        keys[l][k] = key;
        table.prefetch(key);
        key += 1 - unit_of_rank[D - k];
        point.weight[k] = static_cast<float>(k == 0 ? 1.0 + rest_of_rank[D] - rest_of_rank[0]
                                                    : rest_of_rank[D - k] - rest_of_rank[D - k + 1]);
      }
    }
    for (std::size_t l = 0; l < count; ++l)
      for (int k = 0; k <= D; ++k) points_[first + l].vertex[k] = table.find_or_add(keys[l][k]);
  }
  vertices_ = table.keys().size();
  for (int axis = 0; axis <= D; ++axis) axes_[axis] = link_axis<D>(table, layout, axis);
}

template <int D>
void PermutohedralLattice<D>::scale(std::span<const float> factors) {
  assert(factors.size() == points_.size());
  for (std::size_t p = 0; p < points_.size(); ++p)
    for (float& weight : points_[p].weight) weight *= factors[p];
}

template <int D>
std::vector<float> PermutohedralLattice<D>::filter(std::span<const float> values, BlurOrder order) const {
  assert(values.size() == points_.size());
  std::vector<float> lattice(vertices_), result(points_.size());
  for (std::size_t p = 0; p < points_.size(); ++p)
    for (int k = 0; k <= D; ++k) lattice[points_[p].vertex[k]] += points_[p].weight[k] * values[p];
  for (int axis = 0; axis <= D; ++axis) blur_axis(axes_[order == BlurOrder::forward ? axis : D - axis], lattice);
  for (std::size_t p = 0; p < points_.size(); ++p)
    for (int k = 0; k <= D; ++k) result[p] += points_[p].weight[k] * lattice[points_[p].vertex[k]];
  return result;
}

template class PermutohedralLattice<2>;
template class PermutohedralLattice<5>;

}  // namespace orthodrive
