// SPDX-License-Identifier: Apache-2.0
#include "roadquery/opendrive/level_lanes.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>
#include <vector>

#include "roadquery/surface/road_surface.hpp"

namespace roadquery {
namespace {

constexpr double level_tolerance_m = 1e-4, shortest_level_m = 0.05;
constexpr double least_level_share = 1e-4;  // of a section: no more pieces than that, whatever a damaged file says

/// One side of a section from its first level lane on.
class LevelSide {
 public:
  LevelSide(const Road& road, const LaneSection& section, const std::vector<Lane>& lanes, std::size_t first, double end)
      : road_(road), section_(section), lanes_(lanes), first_(first), end_(end) {}

  /// What lies between the cross section and the level at the lanes' borders, the first lane's inner one first.
  [[nodiscard]] std::vector<double> gaps(double s) const {
    const double sign = lanes_.front().id > 0 ? 1.0 : -1.0, s_in_section = s - section_.s;
    double t = evaluate(road_.lane_offset, s);
    for (std::size_t i = 0; i < first_; ++i) t += sign * lane_width(lanes_[i], s_in_section);
    const double level = cross_height(s, t);
    std::vector<double> result = {0.0};
    for (std::size_t i = first_; i < lanes_.size(); ++i) {
      t += sign * lane_width(lanes_[i], s_in_section);
      result.push_back(level - cross_height(s, t));
    }
    return result;
  }

  /// Places between which the gaps are as good as linear.
  [[nodiscard]] std::vector<double> places() const {
    std::set<double> fixed = {section_.s, end_};
    const auto add = [&](double s) {
      if (s > section_.s && s < end_) fixed.insert(s);
    };
    for (const auto* cubics : {&road_.elevation, &road_.superelevation, &road_.lane_offset})
      for (const Cubic& c : *cubics) add(c.s);
    for (const ShapeCubic& c : road_.shape) add(c.s);
    for (const Lane& lane : lanes_) {
      for (const Cubic& c : lane.width) add(section_.s + c.s);
      for (const LaneHeight& h : lane.heights) add(section_.s + h.s_offset);
    }
    std::vector<double> result;
    for (auto at = fixed.begin(); std::next(at) != fixed.end(); ++at) {
      result.push_back(*at);
      split(*at, *std::next(at), result);
    }
    result.push_back(end_);
    return result;
  }

 private:
  /// Height of the cross section over the reference line, at right angles to that, by the cosine of its pitch: so much
  /// lies one place of it over another that is at one height with it across the road in plan.
  [[nodiscard]] double cross_height(double s, double t) const {
    const double bank = superelevation(road_, s), slope = gradient(road_, s);
    return (t * std::sin(bank) + shape(road_, s, t).h * std::cos(bank)) * std::sqrt(1.0 + slope * slope);
  }
  void split(double from, double to, std::vector<double>& result) const {
    const double middle = 0.5 * (from + to), inside = std::min(1e-9, 1e-3 * (to - from));
    if (to - from < 2.0 * std::max(shortest_level_m, least_level_share * (end_ - section_.s))) return;
    const std::vector<double> a = gaps(from), b = gaps(to - inside), m = gaps(middle);
    bool linear = true;
    for (std::size_t i = 0; i < m.size(); ++i)
      linear = linear && std::abs(0.5 * (a[i] + b[i]) - m[i]) < level_tolerance_m;
    // A cubic may cross its chord in the middle.
    const std::vector<double> q = gaps(from + 0.25 * (to - from));
    for (std::size_t i = 0; i < q.size(); ++i)
      linear = linear && std::abs(0.75 * a[i] + 0.25 * b[i] - q[i]) < level_tolerance_m;
    if (linear) return;
    split(from, middle, result);
    result.push_back(middle);
    split(middle, to, result);
  }

  const Road& road_;
  const LaneSection& section_;
  const std::vector<Lane>& lanes_;
  std::size_t first_;
  double end_;
};

void keep_level(const Road& road, const LaneSection& section, std::vector<Lane>& lanes, double end) {
  const auto level = std::find_if(lanes.begin(), lanes.end(), [](const Lane& lane) { return lane.level; });
  if (level == lanes.end() || !(end > section.s)) return;
  const auto first = static_cast<std::size_t>(level - lanes.begin());
  const LevelSide side(road, section, lanes, first, end);
  std::vector<std::vector<LaneHeight>> heights(lanes.size() - first);
  bool is_level_already = true;
  for (const double s : side.places()) {
    // At the section's end what holds before it.
    const std::vector<double> gaps = side.gaps(s < end ? s : std::max(section.s, end - 1e-9));
    for (const double gap : gaps) is_level_already = is_level_already && std::abs(gap) < 0.1 * level_tolerance_m;
    for (std::size_t i = 0; i < heights.size(); ++i) {
      const LaneHeightAt own = lane_height_at(lanes[first + i].heights, s - section.s);
      heights[i].push_back({s - section.s, own.value[0] + gaps[i], own.value[1] + gaps[i + 1]});
    }
  }
  if (is_level_already) return;
  for (std::size_t i = 0; i < heights.size(); ++i) lanes[first + i].heights = std::move(heights[i]);
}

/// A lane that is not level outside of one that is.
void note_outside_level(const Road& road, const LaneSection& section, NoteList& notes) {
  for (const auto* side : {&section.left, &section.right}) {
    const auto level = std::find_if(side->begin(), side->end(), [](const Lane& lane) { return lane.level; });
    if (std::all_of(level, side->end(), [](const Lane& lane) { return lane.level; })) continue;
    notes.add("opendrive.level", "lanes outside of one with level=\"true\" are not level: they are taken as level, too",
              true, {road.id, section.s});
  }
}

}  // namespace

void keep_level_lanes(Road& road, NoteList& notes) {
  for (const LaneSection& section : road.sections) note_outside_level(road, section, notes);
  if (road.superelevation.empty() && road.shape.empty()) return;
  for (std::size_t i = 0; i < road.sections.size(); ++i) {
    LaneSection& section = road.sections[i];
    const double end = i + 1 < road.sections.size() ? road.sections[i + 1].s : road.length;
    keep_level(road, section, section.left, end);
    keep_level(road, section, section.right, end);
  }
}

}  // namespace roadquery
