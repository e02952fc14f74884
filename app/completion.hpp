// SPDX-License-Identifier: Apache-2.0
#pragma once
// Completion of commands, options and their values in shells, made of the command table. Values of TEXT options without
// a list of choices are completed as files.

#include <string>

#include "command_table.hpp"

namespace orthodrive::app {

[[nodiscard]] std::string bash_completion(const CommandText& tool);
[[nodiscard]] std::string zsh_completion(const CommandText& tool);
[[nodiscard]] std::string fish_completion(const CommandText& tool);

}  // namespace orthodrive::app
