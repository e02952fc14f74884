// SPDX-License-Identifier: Apache-2.0
#pragma once
// site.toml: the area, the sources and the options that differ from the defaults.

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "orthodrive/core/finding.hpp"
#include "orthodrive/model/roads/parse_driving_side.hpp"
#include "orthodrive/model/roads/road_material.hpp"
#include "orthodrive/model/site_frame.hpp"
#include "orthodrive/remote/source/fetch_source.hpp"

namespace orthodrive {

struct Site {
  std::string name;
  SiteFrame frame;
  Vec2 middle_lonlat;                         ///< of the area's bounds, degrees of WGS84
  std::vector<std::filesystem::path> photos;  ///< best first
  std::vector<std::filesystem::path> osm;
  std::vector<std::filesystem::path> gpx;             ///< tracks of GPS receivers; none needed
  std::vector<std::filesystem::path> dtm;             ///< best first
  std::vector<std::filesystem::path> buildings;       ///< maps with building=*; empty: those of `osm`
  std::vector<std::filesystem::path> trees;           ///< maps with natural=tree and tree_row; empty: those of `osm`
  std::vector<std::filesystem::path> surroundings;    ///< maps with barriers, water, railways, lamps; empty: `osm`
  std::vector<std::filesystem::path> drive_logs;      ///< CSV files and comma2k19 folders; none needed
  std::vector<std::filesystem::path> control_points;  ///< heights of roads that are known; none needed
  std::filesystem::path truth_dir;                    ///< empty: none
  std::vector<std::string> attribution;               ///< with those of fetched sources
  std::vector<remote::FetchSource> fetch;             ///< sources on servers, by the local files they become
  std::string model = "default";                      ///< name or file of the segmentation network
  bool crf = false;                                   ///< refine the labels by the model's CRF
  bool adapt = false;                                 ///< the network first learns from the site's photo and map
  std::filesystem::path refine_weights;               ///< file of `orthodrive tune`; empty: the shipped weights
  std::string country;  ///< ISO 3166-1 or -2, of the area's middle unless the file tells; empty: not known
  DrivingSide driving_side = DrivingSide::right;
  std::string dtm_sampling = "cubic";    ///< bilinear | cubic
  std::vector<std::string> crg;          ///< roads to write OpenCRG surfaces of, as CrgFilesOptions::roads; none
  std::string opendrive = "1.7";         ///< version of roads.xodr: 1.7 | 1.8
  bool junction_grids = false;           ///< surfaces of junctions as OpenDRIVE 1.8 has them, too; needs 1.8
  Weather weather = Weather::dry;        ///< of the friction that roads.xodr states
  std::vector<std::string> scene_roads;  ///< roads that are cut into the ground, as SceneFiles::chosen_roads; none: all
  std::string route = "auto";            ///< closed way to drive: its name, or "auto"
  Findings findings;                     ///< odd about the area
  /// Where the site names its files: "site.toml:12: 'sources.photo'".
  std::map<std::filesystem::path, std::string> named_at;
};

/// Reads a site file. `overrides` are "section.key=value" texts in TOML syntax (bare words are taken as strings).
/// Whatever is wrong is told in one line with its place, and with the closest known word for a key or value that is not
/// known: InputError for what stands in the file, OptionError for what stands in an override.
[[nodiscard]] Site read_site(const std::filesystem::path& path, const std::vector<std::string>& overrides = {});

/// Throws InputError for the first file that the site names and that is not there, with its place in the site file.
void require_site_files(const Site& site);

}  // namespace orthodrive
