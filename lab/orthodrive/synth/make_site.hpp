// SPDX-License-Identifier: Apache-2.0
#pragma once
// A synthetic site with exact truth: what a real site would deliver (photo, OSM, terrain models) and what no real site
// has (the roads as they are). docs/synth.md describes what is in it. Plans: plan_presets.hpp, plan_from_track.hpp.

#include <cstdint>
#include <string>
#include <vector>

#include "orthodrive/core/monitor.hpp"
#include "orthodrive/model/rasters/rasters.hpp"
#include "orthodrive/model/roads/osm_data.hpp"
#include "orthodrive/model/roads/road_network.hpp"
#include "orthodrive/synth/paint/photo_textures.hpp"
#include "orthodrive/synth/paint/world_names.hpp"

namespace orthodrive {

namespace synth {
struct SitePlan;
}

struct SynthOptions {
  double size_m = 1000.0;  ///< edge of the square site, a multiple of 10 m; of the presets, a track brings its own
  double gsd_m = 0.2;      ///< of the photo and the labels
  std::uint64_t seed = 7;
  double osm_offset_min_m = 1.4;  ///< OSM lies at least so far from the truth (in any direction) ...
  double osm_offset_max_m = 3.6;  ///< ... and at most so far; 0 and 0: OSM nodes lie on the true lines
  double dtm_1m_sigma_m = 0.05;   ///< noise of the heights
  double dtm_10m_sigma_m = 0.10;
  int threads = 0;    ///< 0 = all cores; the result does not depend on it
  std::string world;  ///< what the site looks like (synth/paint/world.hpp): a name or "random"; empty: the plain one
  const PhotoTextures* textures = nullptr;  ///< of real photos; none: surfaces as the generator paints them
  /// Of the labels, with the classes of synth/paint/label_classes.hpp; the site then shows landmarks, too. None: the
  /// default table.
  const ClassTable* classes = nullptr;
  int tile_px = 1024;  ///< edge of the tiles that a region is made of; the result does not depend on it
};
/// Throws OptionError.
void check_synth_options(const SynthOptions& options);
constexpr double dtm_margin_m = 60.0;  ///< terrain models reach beyond the site

/// True carriageway of a way.
struct SynthSurface {
  std::int64_t osm_id = 0;
  std::string highway;
  double visibility = 1.0;  ///< share of its pixels that no crown, roof or deck hides
  Polygon polygon;
};

struct SynthSite {
  std::string name;
  Crs crs;  ///< EPSG:32633
  Box2 bounds;
  Photo photo;
  LabelMap labels;                     ///< what is visible from above, on the photo's grid
  HeightGrid dtm_1m, dtm_10m;          ///< bare earth with noise; 60 m beyond the bounds
  HeightGrid true_dtm;                 ///< 1 m without noise; bare earth below bridges
  OsmData osm;                         ///< disturbed: roads, buildings, woods, water, parking
  RoadNetwork roads;                   ///< truth, a node a metre: width, z, gradient, banking, offset from the OSM line
  std::vector<SynthSurface> surfaces;  ///< one per path of `roads`
  std::string route_name;              ///< of the way to drive on: the circuit, a region's motorway; empty: none
  bool route_closed = true;
  std::vector<std::string> attribution{"Synthetic site made by orthodrive synth, no rights reserved"};
};

/// Builds, paints and measures what a plan says (its size, not the options'). Takes 11 - 14 s of one core and 0.8 GB
/// for 1 km2 at 0.2 m. Throws OptionError.
[[nodiscard]] SynthSite make_site(const synth::SitePlan& plan, const SynthOptions& options, Monitor* monitor = nullptr);

enum class Preset : std::uint8_t { village, circuit, junction, region, conurbation, grid, lanes, farmland };
/// Of two kilometres and more (make_region.hpp).
[[nodiscard]] constexpr bool made_by_tiles(Preset preset) {
  return preset == Preset::region || preset == Preset::conurbation;
}
/// A site of that kind: plan and site in one call. Throws OptionError for sizes it cannot fill, and for those
/// that are made by tiles.
[[nodiscard]] SynthSite make_preset(Preset preset, const SynthOptions& options = {}, Monitor* monitor = nullptr);

}  // namespace orthodrive
