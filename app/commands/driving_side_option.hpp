// SPDX-License-Identifier: Apache-2.0
#pragma once
// --driving-side of every command that asks for it.

#include <CLI/CLI.hpp>
#include <optional>
#include <string>

#include "orthodrive/model/roads/parse_driving_side.hpp"

namespace orthodrive::app {

/// `side` stays empty where the option is not given: then the country tells.
inline CLI::Option* add_driving_side(CLI::App* cmd, std::optional<DrivingSide>& side, const std::string& what_for) {
  return cmd
      ->add_option_function<std::string>(
          "--driving-side", [&side](const std::string& word) { side = driving_side_of(word); },
          what_for + "; default: that of the country")
      ->check(CLI::IsMember({"right", "left"}));
}

}  // namespace orthodrive::app
