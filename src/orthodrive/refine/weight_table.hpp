// SPDX-License-Identifier: Apache-2.0
#pragma once
// The members of RefineWeights by name. Searching, printing and reading them from a file all use this table, so that a
// new weight is named once.

#include <span>
#include <string_view>

#include "orthodrive/refine/refine_roads.hpp"

namespace orthodrive {

struct NamedWeight {
  std::string_view name;  ///< of the member
  double RefineWeights::*value;
};
/// All weights in the order of their declaration.
[[nodiscard]] std::span<const NamedWeight> refine_weight_table();

}  // namespace orthodrive
