#pragma once
// A junction's surface as text: what stands in the userData of <junction>. Writer and reader share this one form.
//
//     junctionBoundary: "x y  dx dy  dx dy ..."       first point in m, then steps from point to point in mm
//     junctionHeights:  "x y spacing columns rows  d d d ..."   south-west node and spacing in m, then the heights, row
//     by
//                       row from the south, in 0.1 mm less their prediction: west + south - south-west neighbour
//                       (missing ones: the other one; the first node: 0). Smooth fields give numbers of one or two
//                       digits. "0*12" is twelve times 0: nodes that no place inside the boundary needs are as
//                       predicted.
//
// Heights of 1 mm would make slopes rough: two of them 0.5 m apart are 0.2 %.

#include <string>
#include <string_view>

#include "roadquery/road_map.hpp"

namespace roadquery {

constexpr const char* boundary_code = "junctionBoundary";
constexpr const char* heights_code = "junctionHeights";

/// Coordinates less (offset_x, offset_y), as all of a file's are.
[[nodiscard]] std::string boundary_text(const JunctionSurface& surface, double offset_x, double offset_y);
[[nodiscard]] std::string heights_text(const JunctionSurface& surface, double offset_x, double offset_y);

/// The other way round, coordinates as they stand. Throw std::runtime_error that says what is wrong.
void read_boundary(std::string_view text, JunctionSurface& surface);
void read_heights(std::string_view text, JunctionSurface& surface);

}  // namespace roadquery
