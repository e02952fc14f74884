// SPDX-License-Identifier: Apache-2.0
#pragma once
// A trained network gets used to the look of a site: it learns on from the site's own photo, with the site's map as
// weak labels. docs/adapt.md

#include <string>

#include "orthodrive/core/monitor.hpp"
#include "orthodrive/model/rasters/map_alignment.hpp"
#include "orthodrive/model/rasters/photo_source.hpp"
#include "orthodrive/segment/adapted_model.hpp"
#include "orthodrive/segment/segment_model.hpp"

namespace orthodrive {

/// Throws OptionError for networks that are no mobilenetv2.
void require_adaptable(const SegmentModel& model, const std::string& source);

/// The decoder learns for some steps on the trunk's features of cells of the photo; every fifth cell is held
/// back to see whether that is a gain. `map`: the roads that the network will see, in the CRS of the photo; none for
/// one that sees none. It learns beside them as they are not: moved, or not there at all. Deterministic. `source` names
/// the model in messages. Throws as require_adaptable() and load_model().
[[nodiscard]] AdaptedModel adapt_model(const TensorFile& model, const std::string& source, const PhotoSource& photo,
                                       const WeakLabels& labels, const MapLines& map, const AdaptOptions& options = {},
                                       Monitor* monitor = nullptr);

}  // namespace orthodrive
