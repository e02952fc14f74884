// SPDX-License-Identifier: Apache-2.0
#pragma once
// Why closed ways and multipolygons of OSM have no area, and where they lie.

#include <limits>
#include <map>
#include <osmium/area/problem_reporter.hpp>
#include <osmium/osm/area.hpp>
#include <osmium/osm/node_ref.hpp>
#include <osmium/osm/way.hpp>
#include <string>
#include <utility>

#include "orthodrive/geo/polygon.hpp"
#include "orthodrive/io/support/osm_support.hpp"
#include "orthodrive/io/support/vector_io.hpp"

namespace orthodrive::io {

/// Hears of what libosmium cannot assemble.
class AreaProblems : public osmium::area::ProblemReporter {
 public:
  void report_ring_not_closed(const osmium::NodeRef& /*end*/, const osmium::Way* /*way*/) override {
    known().is_open = true;
  }
  void report_way(const osmium::Way& way) override {
    Ring& places = known().lonlat;
    for (const osmium::NodeRef& node : way.nodes())
      if (node.location().valid()) places.push_back(lonlat_of(node.location()));
  }

  /// Of an area that has no polygon.
  [[nodiscard]] MissingArea missing(const osmium::Area& area, const CoordinateTransform& target_from_lonlat) const {
    const auto type = area.from_way() ? osmium::item_type::way : osmium::item_type::relation;
    const auto found = problems_.find({type, area.orig_id()});
    if (found == problems_.end()) return {"its outline cannot be closed", box_of({}, target_from_lonlat)};
    return {found->second.is_open ? "its outline is not closed" : "its outline crosses itself",
            box_of(found->second.lonlat, target_from_lonlat)};
  }

  /// Around places in degrees; overlaps nothing where there is none.
  [[nodiscard]] static Box2 box_of(const Ring& lonlat, const CoordinateTransform& target_from_lonlat) {
    Ring places;
    for (const Vec2 p : lonlat) places.push_back(target_from_lonlat.target_from_source(p));
    constexpr double far = std::numeric_limits<double>::infinity();
    return places.empty() ? Box2{far, far, -far, -far} : bounds_of(places);
  }

 private:
  struct Problem {
    bool is_open = false;
    Ring lonlat;
  };
  Problem& known() { return problems_[{m_object_type, m_object_id}]; }
  std::map<std::pair<osmium::item_type, osmium::object_id_type>, Problem> problems_;
};

}  // namespace orthodrive::io
