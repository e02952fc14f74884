// SPDX-License-Identifier: Apache-2.0
#include "load_runs.hpp"

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/find_resource.hpp"
#include "orthodrive/core/load_part.hpp"
#include "processor.hpp"

namespace orthodrive::app {
namespace {
const void* load() {
  if (const std::string complaint = too_old(processor_features()); !complaint.empty()) throw Error(complaint);
  return load_part({"the library of all commands", "liborthodrive.so", "orthodrive_runs", "orthodrive"},
                   library_folders());
}
}  // namespace

const Runs& runs() {
  static const void* table = load();
  return *static_cast<const Runs*>(table);
}

}  // namespace orthodrive::app
