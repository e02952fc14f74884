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
  app.footer(
      "synth, train, forests, tune, and --method of refine and elevate come with the Debian package orthodrive-lab.\n" +
      app.get_footer());
}

}  // namespace orthodrive::app
