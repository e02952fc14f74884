// SPDX-License-Identifier: Apache-2.0
#pragma once
// --driving-side of every command that asks for it.

#include <CLI/CLI.hpp>
#include <string>

#include "orthodrive/model/driving_side.hpp"

namespace orthodrive::app {

inline CLI::Option* add_driving_side(CLI::App* cmd, DrivingSide& side, const std::string& what_for) {
  return cmd
      ->add_option_function<std::string>(
          "--driving-side", [&side](const std::string& text) { side = driving_side_of(text); }, what_for)
      ->check(CLI::IsMember({"right", "left"}))
      ->default_str(to_string(side));
}

}  // namespace orthodrive::app
