// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/lab/commands/run_tune.hpp"

#include <fmt/format.h>

#include <system_error>

#include "orthodrive/core/atomic_file.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/lab/tuning/tune_refine.hpp"

namespace orthodrive {

StageOutcome run_tune(const TuneFiles& files, const SearchWeightsOptions& options, StageContext& context) {
  SearchWeightsOptions search = options;
  search.threads = context.threads;
  const TuneSites sites = read_tune_sites(files.sites, context.monitor);
  std::error_code failed;  // told before the search, which takes minutes
  std::filesystem::create_directories(files.folder, failed);
  if (!std::filesystem::is_directory(files.folder))
    throw OptionError(fmt::format("{}: cannot make this folder; give another -o", files.folder.string()));
  const TuneResult result = tune_refine(sites, search, context.monitor);
  write_text_file(files.folder / "weights.toml", to_weights_file(result));
  write_text_file(files.folder / "report.json", to_json(result).dump(1) + "\n");
  return {.summary = {to_table(result)}};
}

}  // namespace orthodrive
