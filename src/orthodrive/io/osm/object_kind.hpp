// SPDX-License-Identifier: Apache-2.0
#pragma once
// Which OSM tags mean an object that stands at a point.

#include <optional>

#include "orthodrive/io/osm/osm_tags.hpp"
#include "orthodrive/model/map_surroundings.hpp"

namespace orthodrive::io {

/// Nothing for tags of anything else. `traffic_sign` may list several, with codes of countries: the first that is known
/// counts, others are a plain panel.
[[nodiscard]] std::optional<ObjectKind> object_kind(const OsmTags& tags);

}  // namespace orthodrive::io
