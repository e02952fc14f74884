#include "commands.hpp"

namespace orthodrive::app {
void add_build(CLI::App&, Context&) {}
}  // namespace orthodrive::app
