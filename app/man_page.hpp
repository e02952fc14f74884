// SPDX-License-Identifier: Apache-2.0
#pragma once
// Manual pages (roff with the macros of man(7)) of the tool and of its commands.

#include <string>

#include "command_table.hpp"

namespace orthodrive::app {

/// The page of `tool`: its options, and a line for each command. `version` stands at its foot.
[[nodiscard]] std::string tool_page(const CommandText& tool, const std::string& version);

/// The page of one of the commands of `tool`, with the commands below it (evaluate labels) as sections.
[[nodiscard]] std::string command_page(const CommandText& tool, const CommandText& command, const std::string& version);

}  // namespace orthodrive::app
