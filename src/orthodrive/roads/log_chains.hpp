// SPDX-License-Identifier: Apache-2.0
#pragma once
// Roads as one long line each: ways that continue each other, with a coordinate along all of them.

#include <cstddef>
#include <vector>

#include "orthodrive/model/roads/road_network.hpp"

namespace orthodrive {

struct LogChain {
  struct Part {
    std::size_t path = 0;
    bool reversed = false;  ///< the path runs against the chain
    double begin_m = 0.0, length_m = 0.0;
  };
  std::vector<Part> parts;
  double length_m = 0.0;
  bool closed = false;  ///< its end continues in its begin
};

struct LogChains {
  std::vector<LogChain> chains;
  std::vector<std::size_t> chain_of, part_of;  ///< [path]

  [[nodiscard]] const LogChain::Part& part(std::size_t path) const {
    return chains[chain_of[path]].parts[part_of[path]];
  }
  [[nodiscard]] double along_m(std::size_t path, double s_m) const {
    const LogChain::Part& p = part(path);
    return p.reversed ? p.begin_m + p.length_m - s_m : p.begin_m + s_m;
  }
  /// +1 where the path runs with its chain, else -1: sign of gradients and banking.
  [[nodiscard]] double sign(std::size_t path) const { return part(path).reversed ? -1.0 : 1.0; }
};

/// Every path is in one chain (model/path_links). Ordered by first path.
[[nodiscard]] LogChains make_log_chains(const RoadNetwork& roads);

}  // namespace orthodrive
