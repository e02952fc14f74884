// SPDX-License-Identifier: Apache-2.0
// orthodrive version: what this program was built of.

#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "build_info.hpp"
#include "commands.hpp"

namespace orthodrive::app {

void add_version(CLI::App& app, Context&) {
  auto as_json = std::make_shared<bool>(false);
  CLI::App* cmd = app.add_subcommand("version", "Print version, commit, compiler and libraries of this program.");
  cmd->add_flag("--json", *as_json, "one JSON object");
  cmd->footer(
      "Libraries are those that it was built with. `orthodrive --version` prints the version alone.\n"
      "Examples:\n"
      "  orthodrive version\n"
      "  orthodrive version --json");
  cmd->callback([as_json] {
    nlohmann::ordered_json facts;
    for (const BuildFact& fact : build_facts()) facts[fact.name] = fact.value;
    if (*as_json) {
      fmt::print("{}\n", facts.dump(2));
      return;
    }
    for (const BuildFact& fact : build_facts()) fmt::print("{:<11} {}\n", fact.name, fact.value);
  });
}

}  // namespace orthodrive::app
