// SPDX-License-Identifier: Apache-2.0
#pragma once
// Which elements of OpenDRIVE 1.1 to 1.8.1 are read, and what becomes of the others. docs/opendrive_elements.md is the
// same for people; tests/roadquery/elements_test.cpp compares the two, and both with ASAM's schemas.

#include <span>
#include <string_view>

namespace roadquery {

enum class ElementUse {
  read,    ///< what of it road_map.hpp has a place for
  passed,  ///< with all that is in it: it bears on neither surface nor lanes nor limits
  missed   ///< with all that is in it, though it bears on one of them
};

struct OpenDriveElement {
  std::string_view name, parent;  ///< parent "*": whatever it is
  ElementUse use = ElementUse::read;
  std::string_view instead;  ///< of what is missed: what that means, what to do
};

/// Sorted by name, then parent.
[[nodiscard]] std::span<const OpenDriveElement> opendrive_elements();

/// nullptr for what no version of OpenDRIVE has there.
[[nodiscard]] const OpenDriveElement* find_element(std::string_view parent, std::string_view name);

}  // namespace roadquery
