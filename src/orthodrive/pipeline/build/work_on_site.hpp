// SPDX-License-Identifier: Apache-2.0
#pragma once
// A build by any number of processes on any number of machines that see one folder.

#include <filesystem>
#include <string>
#include <vector>

#include "orthodrive/pipeline/build/build_site.hpp"

namespace orthodrive {

/// Works on the build of a site together with all others that do so, until it is complete: one process builds, the
/// others make cells and blocks of loops for it. Who comes first builds; when it is lost, another one goes on. Where
/// the file system knows no flock only index 0 builds. The bytes are those of build_site(), which see for what it
/// throws.
void work_on_site(const Site& site, const std::filesystem::path& out_dir, const BuildShare& share,
                  const BuildOptions& options = {}, Monitor* monitor = nullptr);

/// The stages that a build would run, and "report" where it is not written; none: it is complete. Writes nothing.
[[nodiscard]] std::vector<std::string> missing_stages(const Site& site, const std::filesystem::path& out_dir);

}  // namespace orthodrive
