// SPDX-License-Identifier: Apache-2.0
#pragma once
// Class tables as JSON, as they travel in the metadata of label maps and of the weights of a network.

#include <string>

#include "orthodrive/model/rasters/class_table.hpp"

namespace orthodrive {

/// {"name":..., "classes":[{"name","color","role","cost_false_positive","cost_false_negative"}]}
[[nodiscard]] std::string class_table_to_json(const ClassTable& table);
/// Throws Error with what is wrong: also where there are no classes, or more than labels of a byte.
[[nodiscard]] ClassTable class_table_from_json(const std::string& text);

}  // namespace orthodrive
