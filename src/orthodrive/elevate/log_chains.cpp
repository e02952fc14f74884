#include "orthodrive/elevate/log_chains.hpp"

#include <optional>

#include "orthodrive/model/path_links.hpp"

namespace orthodrive {

LogChains make_log_chains(const RoadNetwork& roads) {
  const PathLinks links = link_path_ends(roads);
  const auto next = [&](PathEnd end) -> std::optional<PathEnd> {
    const auto at = links.find(end);
    return at == links.end() ? std::nullopt : std::optional(at->second);
  };
  LogChains result;
  const std::size_t count = roads.paths.size();
  result.chain_of.assign(count, count), result.part_of.assign(count, 0);
  for (std::size_t first = 0; first < count; ++first) {
    if (result.chain_of[first] != count) continue;
    PathEnd begin{first, false};  // go back to where the chain begins, or once round
    bool closed = false;
    while (const auto before = next(begin)) {
      begin = {before->path, !before->at_back};
      if (before->path == first) {
        closed = true;
        break;
      }
    }
    if (closed) begin = {first, false};
    LogChain chain{.closed = closed};
    for (std::optional<PathEnd> entry = begin; entry && result.chain_of[entry->path] == count;) {
      const std::size_t path = entry->path;
      result.chain_of[path] = result.chains.size(), result.part_of[path] = chain.parts.size();
      chain.parts.push_back({path, entry->at_back, chain.length_m, roads.paths[path].nodes.back().s_m});
      chain.length_m += chain.parts.back().length_m;
      entry = next({path, !entry->at_back});
    }
    result.chains.push_back(std::move(chain));
  }
  return result;
}

}  // namespace orthodrive
