#include "commands.hpp"

namespace orthodrive::app {
void add_train(CLI::App&, Context&) {}
}  // namespace orthodrive::app
