// SPDX-License-Identifier: Apache-2.0
#pragma once
// As commands/commands.hpp, for the laboratory.

#include "commands/commands.hpp"

namespace orthodrive::app {

void add_synth(CLI::App& app, Context& context);
void add_train(CLI::App& app, Context& context);
void add_forests(CLI::App& app, Context& context);
void add_tune(CLI::App& app, Context& context);
/// `--method` of commands that are there already, and what it reads.
void add_refine_methods(CLI::App& app, Context& context);
void add_elevate_methods(CLI::App& app, Context& context);

}  // namespace orthodrive::app
