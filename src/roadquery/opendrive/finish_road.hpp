// SPDX-License-Identifier: Apache-2.0
#pragma once
// A road whose elements have all been read, brought into the form that road_map.hpp describes: in order, its lanes by
// their widths, its cross section by <shape>.

#include <cstddef>
#include <string>
#include <vector>

#include "roadquery/map/road_map.hpp"
#include "roadquery/opendrive/cross_section_surface.hpp"
#include "roadquery/opendrive/note_list.hpp"

namespace roadquery {

/// What a file may say of a road in place of what the structs hold.
struct RoadParts {
  /// <border> (1.4 - 1.8, 11.6.2): t of a lane's outer border, in place of <width>.
  struct Border {
    std::size_t section = 0;  ///< in the order of the file
    int lane = 0;
    std::vector<Cubic> t;  ///< s relative to the start of the section
  };
  std::vector<Border> borders;
  /// <access> (1.4 - 1.8, 11.8.3): for whom a lane is open or closed; entries of one place belong together.
  struct Access {
    std::size_t section = 0;
    int lane = 0;
    double s = 0.0;  ///< relative to the start of the section
    bool allows = false;
    std::vector<std::string> whom;
  };
  std::vector<Access> accesses;
  /// <crossfall> (1.2 - 1.4, 5.3.6.2): by which angle a half falls outwards.
  std::vector<Cubic> crossfall_left, crossfall_right;
  /// <crossSectionSurface>; no strips: the road has none.
  CrossSectionSurface surface;
  /// A section with singleSide="true", and of which sides it has an element.
  struct SingleSide {
    double s = 0.0;
    bool has_left = false, has_right = false;
  };
  std::vector<SingleSide> single_sides;
};

/// Sorts all that goes along the road; of two that stand at one place the later one counts. Then turns borders into
/// widths, crossfall and strips into shapes, and what `level` means into heights of lanes, and looks how far the
/// elements go (road_extent.hpp). Sections of a single side get the other one. Driving lanes that no car may use are of
/// another type. Notes say what was odd.
void finish_road(Road& road, RoadParts parts, NoteList& notes);

}  // namespace roadquery
