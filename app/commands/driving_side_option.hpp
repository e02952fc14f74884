// SPDX-License-Identifier: Apache-2.0
#pragma once
// --driving-side of every command that asks for it.

#include "choice_option.hpp"
#include "orthodrive/model/roads/parse_driving_side.hpp"

namespace orthodrive::app {

inline CLI::Option* add_driving_side(CLI::App* cmd, DrivingSide& side, const std::string& what_for) {
  return add_choice<DrivingSide>(*cmd, "--driving-side", side,
                                 {{"right", DrivingSide::right}, {"left", DrivingSide::left}}, what_for);
}

}  // namespace orthodrive::app
