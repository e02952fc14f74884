// SPDX-License-Identifier: Apache-2.0
#pragma once
// Which level a way lies on, and whether it is there at all: bridge, tunnel, covered, layer, level, indoor, area and
// the prefixes of lifecycles. https://wiki.openstreetmap.org/wiki/Key:tunnel, Key:bridge, Lifecycle_prefix, Key:level

#include <osmium/osm/tag.hpp>

#include "orthodrive/io/osm/osm_tags.hpp"

namespace orthodrive::io {

/// Whether way_attributes has anything to say of a way: it has highway, or highway with the prefix of a lifecycle.
[[nodiscard]] bool has_road_tags(const osmium::TagList& tags);

/// Sets bridge, tunnel and layer of the path, and `omitted` for ways that are left out:
/// "osm.not_built" (planned, under construction, abandoned or gone), "osm.road_area" (an area, no centre line) and
/// "osm.indoor_level" (a level of a building, whose height nothing tells), and "osm.highway_not_known" for values that
/// Key:highway does not have. path.highway is set already.
/// Passages through houses, galleries and roofs lie on the ground: layer 0, no tunnel. So do fords and boardwalks.
void read_structure_tags(const OsmTags& tags, WayAttributes& way);

}  // namespace orthodrive::io
