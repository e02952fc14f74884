#include "commands.hpp"

namespace orthodrive::app {
void add_segment(CLI::App&, Context&) {}
}  // namespace orthodrive::app
