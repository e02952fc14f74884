// SPDX-License-Identifier: Apache-2.0
// orthodrive version: what this program was built of.

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "build_info.hpp"
#include "commands.hpp"
#include "orthodrive/core/find_resource.hpp"

namespace orthodrive::app {

namespace {
std::string parts_beside_the_program() {
  std::string parts;
  for (const char* part : {"forests", "train"})
    for (const std::filesystem::path& folder : library_folders())
      if (std::filesystem::exists(folder / "parts" / fmt::format("{}.so", part))) {
        parts += (parts.empty() ? "" : " ") + std::string(part);
        break;
      }
  return parts.empty() ? "none (Debian package orthodrive-parts)" : parts;
}
}  // namespace

void add_version(CLI::App& app, Context&) {
  auto as_json = std::make_shared<bool>(false);
  CLI::App* cmd = app.add_subcommand("version", "Print version, commit, compiler and libraries of this program.");
  cmd->add_flag("--json", *as_json, "one JSON object");
  cmd->footer(
      "Libraries are those that it was built with; parts (docs/packaging.md) those that are installed. `orthodrive\n"
      "--version` prints the version alone.\n"
      "Examples:\n"
      "  orthodrive version\n"
      "  orthodrive version --json");
  cmd->callback([as_json] {
    nlohmann::ordered_json facts;
    for (const BuildFact& fact : build_facts()) facts[fact.name] = fact.value;
    facts["parts"] = parts_beside_the_program();
    if (*as_json) {
      fmt::print("{}\n", facts.dump(2));
      return;
    }
    for (const auto& [name, value] : facts.items()) fmt::print("{:<11} {}\n", name, value.get<std::string>());
  });
}

}  // namespace orthodrive::app
