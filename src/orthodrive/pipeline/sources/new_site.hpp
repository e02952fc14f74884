// SPDX-License-Identifier: Apache-2.0
#pragma once
// A site file for a place on earth, from the catalogue of open sources.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "orthodrive/core/finding.hpp"
#include "orthodrive/model/site_area.hpp"
#include "orthodrive/pipeline/sources/catalogue.hpp"

namespace orthodrive {

struct NewSiteOptions {
  std::string name;
  Polygon area;                          ///< degrees of WGS84
  std::optional<LonLatBox> box;          ///< when the area is one: the file then says so
  std::vector<std::string> photos;       ///< ids of sources, best first; none: the best for the area
  std::string terrain, osm;              ///< likewise
  std::vector<std::string> photo_files;  ///< local files in place of sources, as the site file shall name them
  std::string osm_file;
  std::vector<std::string> dtm_files;
  double finest_m = 0.2;  ///< photos are fetched at their resolution, but no finer than this, m/px
};

struct NewSite {
  std::string text;                  ///< of the site file
  std::vector<std::string> sources;  ///< ids of what was chosen
  Findings findings;                 ///< of the area and of sources that cover it in part
};

/// The best source of those that can be fetched: bare earth before surface models, then the one that covers most of the
/// area, then the finest; Overpass before extracts. Terrain that covers a part gets the world's beside it. Throws
/// OptionError for an area that is none, one larger than largest_area_m2, an unknown id (with the closest), and where
/// there is no source (with what there is).
[[nodiscard]] NewSite new_site(const Catalogue& catalogue, const NewSiteOptions& options);

/// Sources as a table, a line each: id, what, m/px, share of the area, how far it was checked, licence, name. Those
/// that do not reach the area are left out; without an area all are there.
[[nodiscard]] std::string source_table(const Catalogue& catalogue, const Polygon* lonlat);

}  // namespace orthodrive
