// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/refine/photo_surface.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <vector>

namespace orthodrive {
namespace {

constexpr double least_unpaved_share = 0.6;  // of the visible samples that have to say the same
constexpr int least_seen_samples = 30;       // visible ones: some ten metres of road

enum class PixelVote : std::uint8_t { none, paved, gravel, ground };

PixelVote pixel_vote_of(const ClassInfo& info) {
  constexpr std::array<std::string_view, 3> gravel{"gravel", "macadam", "ground"};
  constexpr std::array<std::string_view, 5> ground{"dirt", "field", "grass", "grassland", "lawn"};
  if (std::find(gravel.begin(), gravel.end(), info.name) != gravel.end()) return PixelVote::gravel;
  if (std::find(ground.begin(), ground.end(), info.name) != ground.end()) return PixelVote::ground;
  return info.role == Role::road || info.role == Role::maybe_road ? PixelVote::paved : PixelVote::none;
}

/// Samples at every node: the middle and half way to both edges, where mapping and refining errors do not reach.
std::array<int, 4> count_votes(const RoadPath& path, const LabelMap& labels, const std::vector<PixelVote>& votes) {
  std::array<int, 4> count{};
  for (std::size_t i = 0; i < path.nodes.size(); ++i) {
    const RoadNode& node = path.nodes[i];
    const Vec2 along = path.nodes[std::min(i + 1, path.nodes.size() - 1)].p - path.nodes[i == 0 ? 0 : i - 1].p;
    if (length(along) == 0.0) continue;
    const Vec2 left = left_normal(normalized(along));
    for (const double share : {-0.25, 0.0, 0.25}) {
      const Vec2 q = labels.frame.pixel_from_world(node.p + left * (share * node.width_m));
      const int col = static_cast<int>(std::floor(q.x)), row = static_cast<int>(std::floor(q.y));
      if (!labels.labels.inside(col, row)) continue;
      const std::uint8_t label = labels.labels.at(col, row);
      if (label < votes.size()) ++count[static_cast<std::size_t>(votes[label])];
    }
  }
  return count;
}

}  // namespace

int classify_by_photo(RoadNetwork& roads, const LabelMap& labels) {
  std::vector<PixelVote> votes;
  votes.reserve(labels.classes.classes.size());
  for (const ClassInfo& info : labels.classes.classes) votes.push_back(pixel_vote_of(info));
  int changed = 0;
  for (RoadPath& path : roads.paths) {
    if (path.known_surface.source != SurfaceSource::highway) continue;
    if (path.highway != "track" && path.highway != "service") continue;
    const std::array<int, 4> count = count_votes(path, labels, votes);
    const int paved = count[1], gravel = count[2], ground = count[3], unpaved = gravel + ground;
    if (paved + unpaved < least_seen_samples || unpaved < least_unpaved_share * (paved + unpaved)) continue;
    const SurfaceClass seen = ground > gravel ? SurfaceClass::ground : SurfaceClass::gravel;
    changed += path.known_surface.surface == seen ? 0 : 1;
    path.known_surface = {seen, SurfaceSource::photo};
  }
  return changed;
}

}  // namespace orthodrive
