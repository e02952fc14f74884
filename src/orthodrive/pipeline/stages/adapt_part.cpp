// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/pipeline/stages/adapt_part.hpp"

#include "orthodrive/core/find_resource.hpp"
#include "orthodrive/core/load_part.hpp"

namespace orthodrive {

const AdaptPart& adapt_part() {
  static const void* table = load_part(
      {"adapting a network", "parts/train.so", "orthodrive_part_adapt", "orthodrive-parts"}, library_folders());
  return *static_cast<const AdaptPart*>(table);
}

}  // namespace orthodrive
