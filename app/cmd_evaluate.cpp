#include "commands.hpp"

namespace orthodrive::app {
void add_evaluate(CLI::App&, Context&) {}
}  // namespace orthodrive::app
