// SPDX-License-Identifier: Apache-2.0
#include "command_table.hpp"

#include <algorithm>

namespace orthodrive::app {
namespace {

/// "TEXT:{a,b}" -> a, b; "TEXT:value in {a->0,b->1} OR {0,1}" -> a, b.
std::vector<std::string> listed_choices(const std::string& type) {
  const auto open = type.find('{'), close = type.find('}');
  if (open == std::string::npos || close == std::string::npos) return {};
  std::vector<std::string> choices = CLI::detail::split(type.substr(open + 1, close - open - 1), ',');
  for (std::string& choice : choices) choice.resize(std::min(choice.size(), choice.find("->")));
  return choices;
}

OptionText option_text(const CLI::Option& option) {
  OptionText out;
  out.positional = option.get_positional();
  if (out.positional) {
    out.names = {option.get_name(true)};
  } else {
    for (const std::string& name : option.get_snames()) out.names.push_back("-" + name);
    for (const std::string& name : option.get_lnames()) out.names.push_back("--" + name);
  }
  if (option.get_items_expected_max() != 0) {
    const std::string type = option.get_type_name();
    out.value = type.substr(0, type.find(':'));
    out.choices = listed_choices(type);
    if (out.choices.empty() && type.find(':') != std::string::npos) out.limits = type.substr(type.find(':') + 1);
    out.default_value = option.get_default_str();
  }
  out.text = option.get_description();
  out.required = option.get_required();
  out.repeated = option.get_expected_max() > 1;
  return out;
}

CommandText command_text(const CLI::App& app, const std::string& path) {
  CommandText out{.name = app.get_name(), .path = path, .footer = app.get_footer()};
  const std::string description = app.get_description();
  const auto end = description.find('\n');
  out.purpose = description.substr(0, end);
  if (end != std::string::npos) out.details = description.substr(end + 1);
  for (const CLI::Option* option : app.get_options()) out.options.push_back(option_text(*option));
  for (const CLI::App* command : app.get_subcommands([](const CLI::App* c) { return !c->get_group().empty(); }))
    out.commands.push_back(command_text(*command, path + " " + command->get_name()));
  return out;
}

}  // namespace

CommandText command_table(const CLI::App& app) {
  CommandText table = command_text(app, "orthodrive");
  table.name = "orthodrive";
  return table;
}

}  // namespace orthodrive::app
