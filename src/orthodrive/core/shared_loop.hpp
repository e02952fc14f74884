#pragma once
// Loops whose items several processes make together. Each process runs the same function on the same input; what one
// has made of an item the others take as bytes, so that all have the same results whoever made which.

#include <chrono>
#include <cstddef>
#include <functional>
#include <optional>
#include <set>
#include <string>

#include "orthodrive/core/byte_archive.hpp"
#include "orthodrive/core/parallel.hpp"

namespace orthodrive {

/// What processes that run the same loops hand each other. A block is a run of items of a loop. Called by several
/// threads at once.
class LoopExchange {
 public:
  virtual ~LoopExchange() = default;
  /// What another process has made of a block; nothing: it is not there.
  [[nodiscard]] virtual std::optional<std::string> load(const std::string& loop, std::size_t block) const = 0;
  /// Says that this process makes a block. Nothing: it is this one's. Otherwise the process that said so before; those
  /// of `lost` do not count.
  [[nodiscard]] virtual std::optional<std::string> claim(const std::string& loop, std::size_t block,
                                                         const std::set<std::string>& lost) = 0;
  /// Leaves a block to the others.
  virtual void keep(const std::string& loop, std::size_t block, const std::string& bytes) = 0;
  /// Where this process begins, as a share of the loop in [0, 1): others begin elsewhere.
  [[nodiscard]] virtual double first_share() const = 0;
  /// How long to wait for others at least, before they are taken for lost.
  [[nodiscard]] virtual std::chrono::milliseconds patience() const { return std::chrono::seconds(10); }
};

struct SharedLoop {
  std::string name;  ///< of its own within a stage; a plain word
  std::size_t count = 0;
  int threads = 0;
  std::function<void(std::size_t item)> make;
  std::function<void(ByteWriter& writer, std::size_t item)> write;
  std::function<void(ByteReader& reader, std::size_t item)> read;
  std::function<void(std::size_t done)> after_each;
};
/// Returns when all items are made, here or elsewhere. Where no block arrives for the exchange's patience and four
/// times as long as the longest block took here, the processes that are waited for are taken for lost: their blocks are
/// made again. Two may make the same one then; both are the same. Throws what `make` throws, and Stopped.
void share_loop(const SharedLoop& loop, LoopExchange& exchange);

/// parallel_for() whose items other processes make as well. `fields(archive, i)` tells all that make(i) has written,
/// for both ways (byte_archive.hpp). Without an exchange there are no others.
template <typename Fields>
void shared_for(LoopExchange* exchange, const std::string& name, std::size_t count, int threads,
                const std::function<void(std::size_t)>& make, const Fields& fields,
                const std::function<void(std::size_t)>& after_each = {}) {
  if (!exchange) return parallel_for(count, threads, make, after_each);
  share_loop({.name = name,
              .count = count,
              .threads = threads,
              .make = make,
              .write = [&](ByteWriter& writer, std::size_t i) { fields(writer, i); },
              .read = [&](ByteReader& reader, std::size_t i) { fields(reader, i); },
              .after_each = after_each},
             *exchange);
}

}  // namespace orthodrive
