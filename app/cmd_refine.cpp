#include "commands.hpp"

namespace orthodrive::app {
void add_refine(CLI::App&, Context&) {}
}  // namespace orthodrive::app
