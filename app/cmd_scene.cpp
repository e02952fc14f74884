#include "commands.hpp"

namespace orthodrive::app {
void add_scene(CLI::App&, Context&) {}
}  // namespace orthodrive::app
