// SPDX-License-Identifier: Apache-2.0
#pragma once
// Indices that cannot be mixed up: a piece is not a vertex, though both are numbers.

#include <cassert>
#include <compare>
#include <cstddef>
#include <vector>

namespace orthodrive::network {

/// Place in one kind of table, or none.
template <class Tag>
class TypedIndex {
 public:
  constexpr TypedIndex() = default;
  constexpr explicit TypedIndex(std::size_t value) : value_(value) {}
  [[nodiscard]] constexpr explicit operator bool() const { return value_ != none; }
  [[nodiscard]] constexpr std::size_t value() const {
    assert(value_ != none);
    return value_;
  }
  friend constexpr auto operator<=>(const TypedIndex&, const TypedIndex&) = default;

 private:
  static constexpr std::size_t none = static_cast<std::size_t>(-1);
  std::size_t value_ = none;
};

using PieceIndex = TypedIndex<struct PieceTag>;
using VertexIndex = TypedIndex<struct VertexTag>;
using ChainIndex = TypedIndex<struct ChainTag>;

/// A vector that is read by its own kind of index.
template <class Index, class T>
class Table {
 public:
  Table() = default;
  explicit Table(std::size_t size, const T& value = {}) : items_(size, value) {}

  [[nodiscard]] decltype(auto) operator[](Index i) { return items_[i.value()]; }
  [[nodiscard]] decltype(auto) operator[](Index i) const { return items_[i.value()]; }
  [[nodiscard]] std::size_t size() const { return items_.size(); }
  [[nodiscard]] auto begin() { return items_.begin(); }
  [[nodiscard]] auto end() { return items_.end(); }
  [[nodiscard]] auto begin() const { return items_.begin(); }
  [[nodiscard]] auto end() const { return items_.end(); }
  Index push_back(T item) {
    items_.push_back(std::move(item));
    return Index(items_.size() - 1);
  }
  /// All indices in order, for loops that need them.
  [[nodiscard]] std::vector<Index> indices() const {
    std::vector<Index> all;
    all.reserve(items_.size());
    for (std::size_t i = 0; i < items_.size(); ++i) all.push_back(Index(i));
    return all;
  }

 private:
  std::vector<T> items_;
};

}  // namespace orthodrive::network
