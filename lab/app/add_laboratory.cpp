// SPDX-License-Identifier: Apache-2.0
#include "lab_commands.hpp"

namespace orthodrive::app {

void add_laboratory(CLI::App& app, Context& context) {
  add_refine_methods(app, context);
  add_elevate_methods(app, context);
  add_synth(app, context);
  add_train(app, context);
  add_forests(app, context);
  add_tune(app, context);
  for (const char* name : {"synth", "train", "forests", "tune"}) app.get_subcommand(name)->group(lab_group);
}

}  // namespace orthodrive::app
