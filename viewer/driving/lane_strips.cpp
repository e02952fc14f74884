// SPDX-License-Identifier: Apache-2.0
#include "lane_strips.hpp"

#include <algorithm>
#include <cmath>

#include "roadquery/surface/road_surface.hpp"

namespace {
using roadquery::Lane;
using roadquery::LaneSection;
using roadquery::Road;

constexpr double tolerance_m = 0.05, min_step_m = 0.5, max_step_m = 5.0;
constexpr double min_width_m = 0.01;  // what is nowhere as wide is no lane to be seen

/// Places from s0 to s1 between which chords stay near a line that bends as the reference line does.
std::vector<double> places(const Road& road, double s0, double s1) {
  std::vector<double> result{s0};
  while (result.back() < s1) {
    const double s = result.back();
    const double bend = std::max(std::abs(roadquery::reference_point(road, s).curvature),
                                 std::abs(roadquery::reference_point(road, std::min(s + max_step_m, s1)).curvature));
    const double step =
        bend > 0.0 ? std::clamp(std::sqrt(8.0 * tolerance_m / bend), min_step_m, max_step_m) : max_step_m;
    result.push_back(s + step < s1 - 0.5 * min_step_m ? s + step : s1);
  }
  return result;
}

class StripWriter {
 public:
  StripWriter(const roadquery::RoadQuery& roads, const std::array<double, 3>& origin_m)
      : roads_(roads), origin_m_(origin_m) {}

  void add_side(const Road& road, const LaneSection& section, double end, const std::vector<Lane>& lanes, double side) {
    const std::vector<double> s = places(road, section.s, end);
    std::vector<double> inner;
    inner.reserve(s.size());
    for (const double at : s) inner.push_back(roadquery::evaluate(road.lane_offset, at));
    for (const Lane& lane : lanes) {
      std::vector<double> outer = inner;
      double widest_m = 0.0;
      for (std::size_t i = 0; i < s.size(); ++i) {
        const double width_m = std::max(0.0, roadquery::lane_width(lane, s[i] - section.s));
        outer[i] += side * width_m;
        widest_m = std::max(widest_m, width_m);
      }
      if (widest_m >= min_width_m) {
        for (const double head :
             {static_cast<double>(lane.type), static_cast<double>(road.junction), static_cast<double>(s.size())})
          values.push_back(static_cast<float>(head));
        for (std::size_t i = 0; i < s.size(); ++i) add_place(road, s[i], inner[i]), add_place(road, s[i], outer[i]);
      }
      inner = std::move(outer);
    }
  }

  std::vector<float> values;

 private:
  /// On the surface that cars drive on, where several roads meet as well.
  void add_place(const Road& road, double s, double t) {
    const roadquery::SurfacePoint p = roadquery::surface_point(road, s, t);
    roadquery::Cursor cursor;
    const double z = roads_.find_height(p.x, p.y, p.z, cursor).value_or(p.z);
    const std::array<double, 3> place{p.x, p.y, z};
    for (std::size_t k = 0; k < 3; ++k) values.push_back(static_cast<float>(place[k] - origin_m_[k]));
  }

  const roadquery::RoadQuery& roads_;
  const std::array<double, 3>& origin_m_;
};
}  // namespace

std::vector<float> lane_strips(const roadquery::RoadQuery& roads, const std::array<double, 3>& origin_m) {
  StripWriter writer(roads, origin_m);
  for (const Road& road : roads.map().roads)
    for (std::size_t k = 0; k < road.sections.size(); ++k) {
      const LaneSection& section = road.sections[k];
      const double end = k + 1 < road.sections.size() ? road.sections[k + 1].s : road.length;
      if (!(end > section.s)) continue;
      writer.add_side(road, section, end, section.left, 1.0);
      writer.add_side(road, section, end, section.right, -1.0);
    }
  return std::move(writer.values);
}
