// SPDX-License-Identifier: Apache-2.0
#pragma once
// Classes taken together for a score, as the thesis (sec. 2.4) merges 38 classes into 32.

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "orthodrive/model/rasters/class_table.hpp"

namespace orthodrive {

/// Old class name -> name of the class that takes it in, which may be a new one.
using MergeTable = std::map<std::string, std::string>;

struct MergedClasses {
  std::vector<ClassInfo> classes;       ///< without the old ones; a new class stands where its first old one stood
  std::vector<std::uint16_t> from_old;  ///< index into `classes` of each class before
};

/// A new class takes colour, role and costs of its first old class. Throws OptionError when the table names an old
/// class that `classes` has not, or when an old class is merged into a class that is itself merged away.
[[nodiscard]] MergedClasses merge_classes(const std::vector<ClassInfo>& classes, const MergeTable& table);

}  // namespace orthodrive
