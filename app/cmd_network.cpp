#include "commands.hpp"

namespace orthodrive::app {
void add_network(CLI::App&, Context&) {}
}  // namespace orthodrive::app
