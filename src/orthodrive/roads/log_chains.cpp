// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/roads/log_chains.hpp"

#include "orthodrive/roads/path_links.hpp"

namespace orthodrive {

LogChains make_log_chains(const RoadNetwork& roads) {
  LogChains result;
  result.chain_of.resize(roads.paths.size()), result.part_of.resize(roads.paths.size());
  for (const PathChain& paths : chain_paths(roads, link_path_ends(roads))) {
    LogChain chain{.closed = paths.closed};
    for (const ChainPath& member : paths.paths) {
      result.chain_of[member.path] = result.chains.size(), result.part_of[member.path] = chain.parts.size();
      chain.parts.push_back({member.path, member.reversed, chain.length_m, roads.paths[member.path].nodes.back().s_m});
      chain.length_m += chain.parts.back().length_m;
    }
    result.chains.push_back(std::move(chain));
  }
  return result;
}

}  // namespace orthodrive
