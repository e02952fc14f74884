// SPDX-License-Identifier: Apache-2.0
// A build without the laboratory (ORTHODRIVE_LAB=OFF).

#include "commands/commands.hpp"

namespace orthodrive::app {

void add_laboratory(CLI::App&, Context&) {}

}  // namespace orthodrive::app
