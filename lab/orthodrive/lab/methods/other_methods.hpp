// SPDX-License-Identifier: Apache-2.0
#pragma once
// The baselines as methods of the stages "refine" and "elevate", to compare their own with.

#include "orthodrive/baselines/mrf_roads.hpp"
#include "orthodrive/baselines/nlo_roads.hpp"
#include "orthodrive/baselines/reference_heights.hpp"
#include "orthodrive/pipeline/stages/run_elevate.hpp"
#include "orthodrive/pipeline/stages/run_refine.hpp"

namespace orthodrive {

enum class RefineMethod { nlo, mrf, none };

struct OtherRefineOptions {
  RefineMethod method = RefineMethod::none;
  NloRoadsOptions nlo;
  MrfRoadsOptions mrf;
  std::filesystem::path photo, forests;  ///< of mrf
};

/// `run.other` is set here; of mrf `run.site`, too: where the photo is. Throws OptionError where a file that the method
/// needs is not named.
StageOutcome run_refine_by(const OtherRefineOptions& other, const RefineFiles& files, RunRefineOptions run,
                           StageContext& context);

enum class HeightMethod {
  reference,       ///< sec. 3.4.2 as published: way by way, w_g 1.2, w_v 12, w_e 0.2, Cauchy loss
  moving_average,  ///< way by way over `window` samples, as the reference's table 3.6; 1 is the terrain as sampled
};

struct OtherHeightOptions {
  HeightMethod method = HeightMethod::reference;
  ReferenceHeightsOptions reference;
  int window = 35;  ///< samples of the moving average, odd
};

/// `run.elevate.heights.instead` is set here.
StageOutcome run_elevate_by(const OtherHeightOptions& other, const ElevateFiles& files, RunElevateOptions run,
                            StageContext& context);

}  // namespace orthodrive
