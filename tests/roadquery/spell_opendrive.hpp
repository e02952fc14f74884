// SPDX-License-Identifier: Apache-2.0
#pragma once
// One map in the spellings of OpenDRIVE 1.1 to 1.8, and of those who write it.

#include <string>

#include "roadquery/random_roads.hpp"
#include "roadquery/spell_xml.hpp"

namespace roadquery::test {

struct MapSpelling {
  int minor = 7;            ///< of the revision: what it has no more, or not yet, is not written
  bool plain = true;        ///< numbers and elements in one way only; else each in any that means the same
  bool text_ids = false;    ///< ids that are no numbers
  bool repeated = false;    ///< elements stand twice, the first one wrong; lists in any order
  bool has_offset = false;  ///< coordinates are less the header's <offset>
  XmlSpelling xml;
};

/// Ids of roads and junctions as written.
[[nodiscard]] std::string written_id(int id, const MapSpelling& how);

[[nodiscard]] std::string spell_opendrive(const RandomMap& map, const MapSpelling& how, unsigned seed);

}  // namespace roadquery::test
