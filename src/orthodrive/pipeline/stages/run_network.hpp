// SPDX-License-Identifier: Apache-2.0
#pragma once
// Stage "network": roads with widths and heights -> OpenDRIVE and OpenCRG.

#include "orthodrive/network/build_network.hpp"
#include "orthodrive/pipeline/stages/build_stage.hpp"
#include "orthodrive/pipeline/stages/crg_files.hpp"

namespace orthodrive {

struct NetworkFiles {
  std::filesystem::path roads;            ///< of elevate
  std::filesystem::path network;          ///< OpenDRIVE, written; OpenCRG goes into NAME_crg/ beside it
  std::filesystem::path findings;         ///< written unless empty
  std::filesystem::path layers, geojson;  ///< reference lines, lanes, junctions; written unless empty
};

/// What becomes of OpenCRG surfaces of an earlier run when none are asked for.
enum class OldSurfaces { keep, remove };

struct RunNetworkOptions {
  BuildNetworkOptions network;  ///< without a name: that of the OpenDRIVE file; its driving side and speed laws are set
                                ///< here
  std::optional<DrivingSide> driving_side;  ///< none: that of the country in which the roads lie
  std::string country;  ///< whose law gives limits, ISO 3166-1 or -2; empty: that in which the roads lie
  CrgFilesOptions crg;  ///< its relief is set here, from the roughness of the roads
  OldSurfaces old_surfaces = OldSurfaces::keep;
  int opendrive_minor_version = 7;
  bool absolute = false, junction_grids = false;  ///< as WriteOpenDriveOptions
  bool judge = false;  ///< follow every lane and say whether it can be driven: `verdict` and its findings
  bool check = false;  ///< read the file back: Error when its surface is not the same within 1 mm
};

StageOutcome run_network(const NetworkFiles& files, const RunNetworkOptions& options, StageContext& context);

/// Does with others what run_network() does, and writes nothing but blocks of its loops.
void help_network(const NetworkFiles& files, const RunNetworkOptions& options, StageContext& context);

[[nodiscard]] BuildStage network_stage(SiteBuild& build);

}  // namespace orthodrive
