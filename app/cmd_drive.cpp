#include "commands.hpp"

namespace orthodrive::app {
void add_drive(CLI::App&, Context&) {}
}  // namespace orthodrive::app
