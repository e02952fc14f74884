// SPDX-License-Identifier: Apache-2.0
#pragma once
// Loops whose items several processes make together. Each process runs the same function on the same input; what one
// has made of an item the others take as bytes, so that all have the same results whoever made which.

#include <cstddef>
#include <functional>
#include <optional>
#include <set>
#include <string>

#include "orthodrive/core/byte_archive.hpp"
#include "orthodrive/core/parallel.hpp"

namespace orthodrive {

/// Which of `count` items a process makes next, where several share them; nothing: none is left for it. From any
/// thread.
using NextItem = std::function<std::optional<std::size_t>(std::size_t count)>;

/// What processes that run the same loops hand each other. A block is a run of items of a loop. Called by several
/// threads at once.
class LoopExchange {
 public:
  virtual ~LoopExchange() = default;
  /// What another process has made of a block; nothing: it is not there.
  [[nodiscard]] virtual std::optional<std::string> load(const std::string& loop, std::size_t block) const = 0;
  /// Says that this process makes a block. Nothing: it is this one's. Otherwise the process that said so before.
  [[nodiscard]] virtual std::optional<std::string> claim(const std::string& loop, std::size_t block) = 0;
  /// Those of the makers that show no life any more; asked again and again while they are waited for. What they claimed
  /// counts no more, in no loop.
  [[nodiscard]] virtual std::set<std::string> lost_of(const std::set<std::string>& makers) = 0;
  /// Leaves a block to the others.
  virtual void keep(const std::string& loop, std::size_t block, const std::string& bytes) = 0;
  /// Where this process begins, as a share of the loop in [0, 1): others begin elsewhere.
  [[nodiscard]] virtual double first_share() const = 0;
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
/// Returns when all items are made, here or elsewhere. Blocks of processes that are lost are made again. Two may make
/// the same one then; both are the same. Throws what `make` and the exchange throw, and Stopped.
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
