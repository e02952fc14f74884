#include "commands.hpp"

namespace orthodrive::app {
void add_view(CLI::App&, Context&) {}
}  // namespace orthodrive::app
