// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/pipeline/files/read_network.hpp"

#include <algorithm>

#include "orthodrive/geo/vec.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace orthodrive {
namespace {

Vec2 place_of_note(const roadquery::RoadMap& map, const roadquery::ReadingNote& note) {
  if (map.roads.empty()) return {};
  const auto road = std::ranges::find(map.roads, note.road, &roadquery::Road::id);
  const roadquery::PlanPoint at = road != map.roads.end() ? roadquery::reference_point(*road, note.s)
                                                          : roadquery::reference_point(map.roads.front(), 0.0);
  return {at.x, at.y};
}

}  // namespace

Findings reading_findings(const roadquery::RoadMap& map) {
  Findings findings;
  for (const roadquery::ReadingNote& note : map.notes) {
    const Vec2 place = place_of_note(map, note);
    findings.push_back({note.matters ? Severity::warning : Severity::info, note.code, note.message, place.x, place.y});
  }
  return findings;
}

roadquery::RoadMap read_network(const std::filesystem::path& file, Findings& findings) {
  roadquery::RoadMap map = roadquery::read_opendrive(file.string());
  for (Finding& finding : reading_findings(map)) findings.push_back(std::move(finding));
  return map;
}

}  // namespace orthodrive
