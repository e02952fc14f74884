// SPDX-License-Identifier: Apache-2.0
#pragma once
// What a layout has placed of one kind.

#include <vector>

#include "orthodrive/scene/tiles/scene_layout.hpp"

namespace orthodrive::scene {

/// Empty where the layout has no family of it.
template <typename Placed>
const std::vector<Placed>& placed(const SceneLayout& layout) {
  for (const auto& family : layout.families)
    if (const auto* of_kind = dynamic_cast<const CopiedFamily<Placed>*>(family.get())) return of_kind->placed();
  static const std::vector<Placed> none;
  return none;
}

}  // namespace orthodrive::scene
