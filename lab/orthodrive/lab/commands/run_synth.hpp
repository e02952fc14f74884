// SPDX-License-Identifier: Apache-2.0
#pragma once
// `orthodrive synth`: a plan -> a synthetic site with exact truth, as files.

#include "orthodrive/pipeline/stages/stage_context.hpp"
#include "orthodrive/pipeline/stages/stage_outcome.hpp"
#include "orthodrive/synth/make_site.hpp"

namespace orthodrive {

struct SynthFiles {
  std::filesystem::path track;          ///< CSV of a real closed track; empty: a preset
  std::filesystem::path track_osm;      ///< its OSM ways; empty: the truth, disturbed
  std::filesystem::path track_heights;  ///< CSV of heights along it; empty: made-up hills
  double track_size_m = 0.0;            ///< edge of the site round the track; 0: as small as can be
  std::filesystem::path textures;       ///< folder that `tools/paint quilt` wrote; empty: none
  std::filesystem::path classes;        ///< class table of the labels (TOML); empty: the default one
  std::filesystem::path folder;         ///< written: site.toml (last), its sources, and the truth in truth/
};

/// `preset` counts where there is no track.
StageOutcome run_synth(const SynthFiles& files, Preset preset, const SynthOptions& options, StageContext& context);

}  // namespace orthodrive
