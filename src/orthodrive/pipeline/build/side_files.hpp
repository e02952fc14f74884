// SPDX-License-Identifier: Apache-2.0
#pragma once
// What a build writes beside its results for other programs: styles for QGIS, and an item for STAC catalogues.

#include <filesystem>
#include <string>

#include "orthodrive/pipeline/sources/site.hpp"

namespace orthodrive {

/// Writes labels.qml, findings.qml, road_graph.qml and item.json into the folder of a finished build. `version` is that
/// of the tool.
void write_side_files(const Site& site, const std::filesystem::path& out_dir, const std::string& version);

/// A STAC 1.0.0 item: the outputs that are in the folder as assets, the area as geometry, the CRS by the projection
/// extension. The time is that of the photo (its TIFF tag DateTime); unknown, it is null between 1970 and 2100.
[[nodiscard]] std::string stac_item(const Site& site, const std::filesystem::path& out_dir, const std::string& version);

}  // namespace orthodrive
