// SPDX-License-Identifier: Apache-2.0
#pragma once
// Functional mock-up units: the archive that a simulator loads.

#include <filesystem>
#include <string>
#include <vector>

#include "fmu/model.hpp"

namespace orthodrive::io {

/// Text of the modelDescription.xml for co-simulation. FMI version 2 or 3.
[[nodiscard]] std::string model_description(const fmu::ModelKind& kind, int fmi_version);

struct FmuResource {
  std::string name;  ///< below resources/
  std::filesystem::path file;
};

/// Packs description, shared library (x86-64 Linux) and resources. Throws InputError for files that cannot be read.
void write_fmu(const std::filesystem::path& path, const fmu::ModelKind& kind, int fmi_version,
               const std::filesystem::path& shared_library, const std::vector<FmuResource>& resources);

}  // namespace orthodrive::io
