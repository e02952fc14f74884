// SPDX-License-Identifier: Apache-2.0
#pragma once
// Which files of a built site and of the viewer a browser gets from `orthodrive view`.

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace orthodrive::app {

/// A file that is open for reading.
struct ServedFile {
  std::shared_ptr<const int> descriptor;  ///< closed with the last copy
  std::size_t size = 0;                   ///< bytes, when it was opened
  std::string content_type;
  bool of_viewer = false;  ///< the viewer's own code; of the site otherwise
};

/// A file below the folder of the viewer, or one of those of a site that the viewer reads: `scene/` (tiles and
/// pictures), run.json, findings.geojson, road_graph.geojson, roads.xodr, drive/lap.xosc, and laps: any .csv file with
/// their columns. Nothing in or behind a name that begins with a dot, nothing outside both folders, whatever links say.
class ViewFiles {
 public:
  /// Both folders exist. A link as the folder itself is followed, once.
  ViewFiles(const std::filesystem::path& site, const std::filesystem::path& viewer);

  /// `path`: of an address, decoded: "/" and what follows for the viewer, "/site/" for the site. Empty: nothing to give
  /// out.
  [[nodiscard]] std::optional<ServedFile> open(std::string_view path) const;

 private:
  std::filesystem::path site_, viewer_;
};

}  // namespace orthodrive::app
