// SPDX-License-Identifier: Apache-2.0
#pragma once
// A junction's surface as text: what stands in the userData of <junction>. Writer and reader share this one form.
//
//     junctionBoundary: "x y STEPS"      first point in m, then dx dy dx dy ... from point to point in mm
//     junctionHeights:  "x y spacing columns rows HEIGHTS"   south-west node and spacing in m, then the heights, row by
//                       row from the south, in 0.1 mm less their prediction: west + south - south-west neighbour
//                       (missing ones: the other one; the first node: 0). A zero is followed by the number of zeros
//                       after it: nodes that no place inside the boundary needs are as predicted.
//
// STEPS and HEIGHTS are whole numbers without a space between them, each as the Base64 VLQ of source maps (ECMA-426,
// 4.1): digits A-Z a-z 0-9 + / of five bits, lowest first, 32 more says that another one follows; the lowest bit is the
// sign. Up to 15 that is one character; in decimals with their spaces the same numbers take twice as much.
//
// Heights of 1 mm would make slopes rough: two of them 0.5 m apart are 0.2 %.

#include <string>
#include <string_view>

#include "roadquery/map/road_map.hpp"

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
