// SPDX-License-Identifier: Apache-2.0
#pragma once
// The one walker that turns links between the ends of lines into chains of lines. A line is a way, or a piece of one.

#include <cstddef>
#include <map>
#include <type_traits>
#include <utility>
#include <vector>

namespace orthodrive {

/// Lines that run on into each other, end to end: each by the end at which it is entered, its first one where the chain
/// runs with the line, its last one where it runs against it.
template <class End>
struct WalkedChain {
  std::vector<End> entries;
  bool closed = false;  ///< the last line runs on into the first
};

/// Which end runs on into which, entered both ways round. `End` is an aggregate of the line's index and whether it is
/// the line's last end, and is ordered.
template <class End>
using EndLinks = std::map<End, End>;

template <class End>
[[nodiscard]] End other_end(End end) {
  const auto [line, at_last] = end;
  return {line, !at_last};
}

/// The chain that is entered at `entry`, until it ends or comes back to its beginning.
template <class End>
[[nodiscard]] WalkedChain<End> follow(const EndLinks<End>& links, End entry) {
  WalkedChain<End> chain{{entry}};
  for (;;) {
    const auto next = links.find(other_end(chain.entries.back()));
    if (next == links.end()) return chain;
    if (next->second == entry) {
      chain.closed = true;
      return chain;
    }
    if (chain.entries.size() > links.size()) return chain;  // links that are no pairs
    chain.entries.push_back(next->second);
  }
}

/// Where the chain of a line begins that runs along this line from its first end to its last. Closed chains begin with
/// the line itself.
template <class End>
[[nodiscard]] End begin_of_chain(const EndLinks<End>& links, End own_first) {
  End entry = own_first;
  std::size_t steps = 0;
  for (auto previous = links.find(entry); previous != links.end(); previous = links.find(entry)) {
    entry = other_end(previous->second);
    if (entry == own_first || ++steps > links.size()) break;
  }
  return entry;
}

/// Collects chains so that each of `lines` lines is in exactly one.
template <class End>
class ChainWalk {
 public:
  ChainWalk(std::size_t lines, const EndLinks<End>& links) : links_(links), used_(lines, false) {}

  /// Chains in the order of their lowest line, which they run along from its first end.
  [[nodiscard]] std::vector<WalkedChain<End>> along_lowest_lines() {
    for (std::size_t line = 0; line < used_.size(); ++line)
      if (!used_[line]) add(begin_of_chain<End>(links_, end(line, false)));
    return std::move(chains_);
  }

  /// Open chains first, each from the end of its lower outermost line. Then closed ones, from the lowest end where
  /// `may_begin` holds, and those without such an end from their lowest line.
  template <class Predicate>
  [[nodiscard]] std::vector<WalkedChain<End>> open_ones_first(const Predicate& may_begin) {
    add_where([&](End e) { return !links_.contains(e); });
    add_where(may_begin);
    add_where([](End) { return true; });
    return std::move(chains_);
  }

 private:
  [[nodiscard]] static End end(std::size_t line, bool at_last) {
    End end{};
    auto& [index, last] = end;
    index = std::remove_reference_t<decltype(index)>(line), last = at_last;
    return end;
  }
  [[nodiscard]] static std::size_t line_of(const End& end) {
    const auto& [line, last] = end;
    const auto& index = line;  // clang 14 cannot name a structured binding in a requires-expression
    if constexpr (requires { index.value(); })
      return index.value();
    else
      return index;
  }

  template <class Predicate>
  void add_where(const Predicate& begins) {
    for (std::size_t line = 0; line < used_.size(); ++line)
      for (const bool at_last : {false, true})
        if (!used_[line] && begins(end(line, at_last))) add(end(line, at_last));
  }
  void add(End entry) {
    chains_.push_back(follow<End>(links_, entry));
    for (const End& passed : chains_.back().entries) used_[line_of(passed)] = true;
  }

  const EndLinks<End>& links_;
  std::vector<bool> used_;
  std::vector<WalkedChain<End>> chains_;
};

}  // namespace orthodrive
