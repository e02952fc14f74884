// SPDX-License-Identifier: Apache-2.0
#pragma once
// `orthodrive fetch`, and what `build` does before its stages.

#include "orthodrive/core/monitor.hpp"
#include "orthodrive/pipeline/sources/site.hpp"
#include "orthodrive/remote/fetch.hpp"

namespace orthodrive {

/// Fetches the sources of the site, one after the other, and says what came. Throws as remote::fetch; what came before
/// stays. Without [[fetch]] tables: OptionError.
void run_fetch(const Site& site, const remote::FetchOptions& options = {}, Monitor* monitor = nullptr);

/// Only those whose file is not there, not complete, or of another area. Asks no server where all are there.
void fetch_what_lacks(const Site& site, Monitor* monitor = nullptr);

}  // namespace orthodrive
