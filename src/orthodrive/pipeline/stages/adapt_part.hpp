// SPDX-License-Identifier: Apache-2.0
#pragma once
// What adapts a network to a site. It needs libtorch, so it lies in a part that the first call loads
// (lib/orthodrive/parts/train.so, of the package orthodrive-parts).

#include <string>

#include "orthodrive/core/monitor.hpp"
#include "orthodrive/model/rasters/map_alignment.hpp"
#include "orthodrive/model/rasters/photo_source.hpp"
#include "orthodrive/segment/adapted_model.hpp"
#include "orthodrive/segment/segment_model.hpp"

namespace orthodrive {

struct AdaptPart {
  /// Throws OptionError for networks that cannot adapt. `source` names the model in messages.
  void (*require_adaptable)(const SegmentModel& model, const std::string& source);
  /// `labels` in the CRS of the photo; `map`: the roads that the network will see. Throws as require_adaptable().
  AdaptedModel (*adapt_model)(const TensorFile& model, const std::string& source, const PhotoSource& photo,
                              const WeakLabels& labels, const MapLines& map, const AdaptOptions& options,
                              Monitor* monitor);
};

/// Throws as load_part() does (core/load_part.hpp).
[[nodiscard]] const AdaptPart& adapt_part();

}  // namespace orthodrive
