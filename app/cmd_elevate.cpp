#include "commands.hpp"

namespace orthodrive::app {
void add_elevate(CLI::App&, Context&) {}
}  // namespace orthodrive::app
