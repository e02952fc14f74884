// SPDX-License-Identifier: Apache-2.0
#include "load_lab.hpp"

#include "load_runs.hpp"
#include "orthodrive/core/find_resource.hpp"
#include "orthodrive/core/load_part.hpp"

namespace orthodrive::app {

const LabRuns& lab_runs() {
  static const void* table = [] {
    (void)runs();  // tells of a processor that is too old
    return load_part({"the laboratory (synthetic sites, training, baselines)", "liborthodrive-lab.so",
                      "orthodrive_lab_runs", "orthodrive-lab"},
                     library_folders());
  }();
  return *static_cast<const LabRuns*>(table);
}

}  // namespace orthodrive::app
