#include "commands.hpp"

namespace orthodrive::app {
void add_synth(CLI::App&, Context&) {}
}  // namespace orthodrive::app
