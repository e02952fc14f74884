// SPDX-License-Identifier: Apache-2.0
#pragma once
// Packs roads, and a car if asked, into a functional mock-up unit.

#include <filesystem>

#include "orthodrive/pipeline/stages/stage_context.hpp"
#include "orthodrive/pipeline/stages/stage_outcome.hpp"

namespace orthodrive {

struct FmuFiles {
  std::filesystem::path network;  ///< OpenDRIVE; the OpenCRG files that it names are packed, too. Empty: without roads
  std::filesystem::path terrain;  ///< ESRI ASCII grid, or empty
  std::string car;                ///< a preset's name or a file; empty: the FMU of the road alone
  std::filesystem::path fmu;      ///< written
};

struct FmuOptions {
  int fmi_version = 3;  ///< 2 or 3
};

/// All that is packed is read first, so that no FMU holds files that it would refuse.
StageOutcome run_fmu(const FmuFiles& files, const FmuOptions& options, StageContext& context);

}  // namespace orthodrive
