// SPDX-License-Identifier: Apache-2.0
#include "completion.hpp"

#include <fmt/format.h>

#include <functional>
#include <utility>

namespace orthodrive::app {
namespace {

/// Calls visit(command) for the tool and every command below it.
void for_each_command(const CommandText& command, const std::function<void(const CommandText&)>& visit) {
  visit(command);
  for (const CommandText& inner : command.commands) for_each_command(inner, visit);
}

/// Options of a command and of those above it, which it takes as well; of two with one name the inner one. The help of
/// a command is its own.
std::vector<OptionText> options_of(const CommandText& tool, const CommandText& command) {
  std::vector<OptionText> out;
  for_each_command(tool, [&](const CommandText& above) {
    const bool own = above.path == command.path;
    if (!own && !command.path.starts_with(above.path + " ")) return;
    for (const OptionText& option : above.options) {
      const std::string& name = option.names.back();
      if (option.positional || (!own && (name == "--help" || name == "--version"))) continue;
      std::erase_if(out, [&](const OptionText& outer) { return outer.names.back() == name; });
      out.push_back(option);
    }
  });
  return out;
}

std::string replaced(const std::string& text, const std::vector<std::pair<char, std::string>>& table) {
  std::string out;
  for (const char c : text) {
    std::string word(1, c);
    for (const auto& [from, to] : table)
      if (from == c) word = to;
    out += word;
  }
  return out;
}

/// First sentence of an option's or command's text, in single quotes of a shell.
std::string first_line(const std::string& text) {
  std::string out = text.substr(0, text.find('\n'));
  return out.substr(0, out.find(". "));
}

std::string joined(const std::vector<std::string>& words) { return fmt::format("{}", fmt::join(words, " ")); }

std::vector<std::string> names_of(const std::vector<CommandText>& commands) {
  std::vector<std::string> out;
  out.reserve(commands.size());
  for (const CommandText& command : commands) out.push_back(command.name);
  return out;
}

bool takes_number(const OptionText& option) { return !option.value.empty() && option.value != "TEXT"; }

/// Cases of bash's `case "$path $before"`: "PATH OPTION", for all names of the option.
std::string bash_cases(const std::string& path, const OptionText& option) {
  std::string out;
  for (const std::string& name : option.names) out += fmt::format("{}'{} {}'", out.empty() ? "" : " | ", path, name);
  return out;
}

std::string zsh_quoted(const std::string& text) {
  return replaced(text, {{'\'', "'\\''"}, {'[', "\\["}, {']', "\\]"}, {':', "\\:"}, {'\\', "\\\\"}});
}

std::string zsh_value(const OptionText& option) {
  if (option.value.empty()) return "";
  if (!option.choices.empty()) return fmt::format(":value:({})", joined(option.choices));
  return takes_number(option) ? ":number: " : ":file:_files";
}

/// Arguments of zsh's _arguments for a command, a line each.
std::string zsh_arguments(const CommandText& tool, const CommandText& command) {
  std::string out;
  for (const OptionText& option : options_of(tool, command)) {
    const std::string rest = fmt::format("[{}]{}", zsh_quoted(first_line(option.text)), zsh_value(option));
    const std::string apart = option.repeated ? "*" : fmt::format("({})", joined(option.names));
    for (const std::string& name : option.names) out += fmt::format(" \\\n    '{}{}{}'", apart, name, rest);
  }
  return out;
}

void zsh_function(const CommandText& tool, const CommandText& command, std::string& out) {
  for (const CommandText& inner : command.commands) zsh_function(tool, inner, out);
  const std::string name = replaced("_" + command.path, {{' ', "_"}, {'-', "_"}});
  out += fmt::format("{}() {{\n", name);
  if (command.commands.empty()) {
    out += fmt::format("  _arguments{} \\\n    '*:file:_files'\n}}\n\n", zsh_arguments(tool, command));
    return;
  }
  out += fmt::format("  local state line\n  _arguments -C{} \\\n    '1:command:->command' '*::argument:->argument'\n",
                     zsh_arguments(tool, command));
  out += "  case $state in\n    command)\n      local -a commands=(\n";
  for (const CommandText& inner : command.commands)
    out += fmt::format("        '{}:{}'\n", inner.name, zsh_quoted(first_line(inner.purpose)));
  out += fmt::format(
      "      )\n      _describe command commands ;;\n    argument)\n"
      "      (( $+functions[{0}_${{line[1]//-/_}}] )) && {0}_${{line[1]//-/_}} ;;\n  esac\n}}\n\n",
      name);
}

std::string fish_quoted(const std::string& text) { return "'" + replaced(text, {{'\'', "\\'"}, {'\\', "\\\\"}}) + "'"; }

std::string fish_option(const std::string& condition, const OptionText& option) {
  std::string out = "complete -c orthodrive" + condition;
  for (const std::string& name : option.names)
    out += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
  if (!option.choices.empty())
    out += fmt::format(" -x -a {}", fish_quoted(joined(option.choices)));
  else if (takes_number(option))
    out += " -x";
  else if (!option.value.empty())
    out += " -r -F";
  return out + fmt::format(" -d {}\n", fish_quoted(first_line(option.text)));
}

}  // namespace

std::string bash_completion(const CommandText& tool) {
  std::string paths, options, values;
  for_each_command(tool, [&](const CommandText& command) {
    const std::string path = command.path.substr(tool.path.size());
    if (!path.empty()) paths += fmt::format("{}'{}'", paths.empty() ? "" : " | ", path);
    std::vector<std::string> words;
    for (const OptionText& option : options_of(tool, command)) {
      words.insert(words.end(), option.names.begin(), option.names.end());
      if (!option.choices.empty())
        values += fmt::format("    {}) words='{}' ;;\n", bash_cases(path, option), joined(option.choices));
      else if (takes_number(option))
        values += fmt::format("    {}) compopt +o default; return ;;\n", bash_cases(path, option));
      else if (!option.value.empty())
        values += fmt::format("    {}) return ;;\n", bash_cases(path, option));
    }
    options += fmt::format("    '{}') commands='{}' options='{}' ;;\n", path, joined(names_of(command.commands)),
                           joined(words));
  });
  return fmt::format(R"(# Completion of orthodrive in bash, made of the command table by `orthodrive help-files`.
# Without an answer of this function bash completes files.
_orthodrive() {{
  local current=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD - 1]}} path='' words='' commands options i
  if [[ $current == '=' ]]; then  # --option=VALUE comes as three words
    current=''
  elif [[ $before == '=' ]]; then
    before=${{COMP_WORDS[COMP_CWORD - 2]}}
  fi
  for ((i = 1; i < COMP_CWORD; ++i)); do
    case "$path ${{COMP_WORDS[i]}}" in
      {}) path+=" ${{COMP_WORDS[i]}}" ;;
    esac
  done
  case "$path" in
{}  esac
  case "$path $before" in
{}    *) if [[ $current == -* ]]; then words=$options; else words=$commands; fi ;;
  esac
  mapfile -t COMPREPLY < <(compgen -W "$words" -- "$current")
}}
complete -o default -F _orthodrive orthodrive
)",
                     paths, options, values);
}

std::string zsh_completion(const CommandText& tool) {
  std::string functions;
  zsh_function(tool, tool, functions);
  return "#compdef orthodrive\n# Made of the command table by `orthodrive help-files`.\n\n" + functions +
         "_orthodrive \"$@\"\n";
}

std::string fish_completion(const CommandText& tool) {
  std::string out = "# Made of the command table by `orthodrive help-files`.\n";
  for (const CommandText& command : tool.commands) {
    out += fmt::format("complete -c orthodrive -n __fish_use_subcommand -f -a {} -d {}\n", command.name,
                       fish_quoted(first_line(command.purpose)));
  }
  for (const OptionText& option : tool.options)
    if (!option.positional) out += fish_option(" -n __fish_use_subcommand", option);
  for_each_command(tool, [&](const CommandText& command) {
    if (command.path == tool.path) return;
    std::string condition = "true";  // all words of the path were typed
    for (const std::string& word : CLI::detail::split(command.path.substr(tool.path.size() + 1), ' '))
      condition += "; and __fish_seen_subcommand_from " + word;
    for (const CommandText& inner : command.commands) {
      out += fmt::format("complete -c orthodrive -n '{}; and not __fish_seen_subcommand_from {}' -f -a {} -d {}\n",
                         condition, joined(names_of(command.commands)), inner.name,
                         fish_quoted(first_line(inner.purpose)));
    }
    for (const OptionText& option : options_of(tool, command))
      out += fish_option(fmt::format(" -n '{}'", condition), option);
  });
  return out;
}

}  // namespace orthodrive::app
