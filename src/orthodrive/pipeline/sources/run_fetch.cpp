// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/pipeline/sources/run_fetch.hpp"

#include <fmt/format.h>

#include "orthodrive/core/error.hpp"
#include "orthodrive/remote/source/source_record.hpp"

namespace orthodrive {

void run_fetch(const Site& site, const remote::FetchOptions& options, Monitor* monitor) {
  if (site.fetch.empty())
    throw OptionError("the site file has no [[fetch]] table: its sources are local files, nothing to fetch");
  for (const remote::FetchSource& source : site.fetch) {
    const remote::FetchOutcome outcome = remote::fetch(source, site.frame, options, monitor);
    if (monitor) monitor->info(fmt::format("{}: {}", source.to_text, outcome.summary));
    const bool terrain = remote::is_raster(source.kind);
    const bool is_dtm = std::find(site.dtm.begin(), site.dtm.end(), source.to) != site.dtm.end();
    if (terrain && is_dtm && source.vertical_datum.empty() && monitor)
      monitor->info(fmt::format("{}: its vertical datum is not named (vertical_datum), heights are taken as they are",
                                source.to_text));
  }
}

void fetch_what_lacks(const Site& site, Monitor* monitor) {
  for (const remote::FetchSource& source : site.fetch) {
    const remote::LocalState state = remote::local_state(source, site.frame);
    if (state == remote::LocalState::complete || state == remote::LocalState::users_own) continue;
    const remote::FetchOutcome outcome = remote::fetch(source, site.frame, {}, monitor);
    if (monitor) monitor->info(fmt::format("{}: {}", source.to_text, outcome.summary));
  }
}

}  // namespace orthodrive
