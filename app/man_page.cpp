// SPDX-License-Identifier: Apache-2.0
#include "man_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <utility>

#include "train_packed_usage.hpp"

namespace orthodrive::app {
namespace {

/// Text as roff takes it: quotes and minus signs as they were typed, no line that roff reads as a request.
std::string roff(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '\\':
        out += "\\e";
        break;
      case '-':
        out += "\\-";
        break;
      case '\'':
        out += "\\(aq";
        break;
      case '`':
        out += "\\(ga";
        break;
      case '^':
        out += "\\(ha";
        break;
      case '~':
        out += "\\(ti";
        break;
      case '.':
        out += out.empty() || out.back() == '\n' ? "\\&." : ".";
        break;
      default:
        out += c;
    }
  }
  return out;
}

/// In quotes, as one argument of a macro.
std::string argument(const std::string& text) {
  std::string out;
  for (const char c : roff(text)) out += c == '"' ? std::string("\\(dq") : std::string(1, c);
  return '"' + out + '"';
}

std::string upper(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::toupper(c); });
  return text;
}

/// Lines to be filled. One that ends a sentence or a list begins a new line on the page; others were broken by hand.
std::string filled(const std::string& text) {
  std::string out, before;
  for (const std::string& line : CLI::detail::split(text, '\n')) {
    if (line.empty()) {
      if (!out.empty()) out += ".PP\n";
    } else {
      if (!before.empty() && std::string(".:;").find(before.back()) != std::string::npos) out += ".br\n";
      out += roff(line) + "\n";
    }
    before = line;
  }
  return out;
}

std::string as_typed(const std::string& text) { return ".PP\n.nf\n.RS 2\n" + roff(text) + ".RE\n.fi\n"; }

/// A footer's text, and its examples: the indented lines after "Examples:".
std::pair<std::string, std::string> text_and_examples(const std::string& footer) {
  std::string text, examples;
  bool inside = false;
  for (const std::string& line : CLI::detail::split(footer, '\n')) {
    if (line == "Examples:")
      inside = true;
    else if (inside && line.starts_with("  "))
      examples += line.substr(2) + "\n";
    else
      text += line + "\n", inside = false;
  }
  while (text.ends_with('\n')) text.pop_back();
  return {text, examples};
}

std::string synopsis(const CommandText& command) {
  std::string out = fmt::format(".B {}\n[\\fIoptions\\fR]", roff(command.path));
  for (const OptionText& option : command.options) {
    if (option.positional && option.required) out += fmt::format(" \\fI{}\\fR", roff(option.names[0]));
    if (option.positional && !option.required) out += fmt::format(" [\\fI{}\\fR]", roff(option.names[0]));
    if (!option.positional && option.required)
      out += fmt::format(" \\fB{}\\fR \\fI{}\\fR", roff(option.names[0]), roff(option.value));
  }
  if (!command.commands.empty()) out += " \\fIcommand\\fR";
  return out + "\n";
}

std::string option_entry(const OptionText& option) {
  std::string heading;
  for (const std::string& name : option.names) {
    if (!heading.empty()) heading += ", ";
    heading += fmt::format("\\f{}{}\\fR", option.positional ? 'I' : 'B', roff(name));
  }
  if (!option.positional && !option.value.empty()) heading += fmt::format(" \\fI{}\\fR", roff(option.value));
  if (option.repeated) heading += " ...";
  std::string text = option.text;
  std::string facts;
  const auto add = [&](const std::string& fact) { facts += (facts.empty() ? "" : "; ") + fact; };
  if (option.required && !option.positional) add("required");
  if (!option.choices.empty()) add(fmt::format("one of {}", fmt::join(option.choices, ", ")));
  if (!option.limits.empty()) add(option.limits);
  if (!option.default_value.empty()) add("default: " + option.default_value);
  if (!facts.empty()) text += fmt::format(" ({})", facts);
  return fmt::format(".TP\n{}\n{}", heading, filled(text));
}

std::string option_list(const CommandText& command) {
  std::string out;
  for (const bool positional : {true, false})
    for (const OptionText& option : command.options)
      if (option.positional == positional) out += option_entry(option);
  return out;
}

/// "All stages in order: ..." without the full stop, up to the end of the first sentence.
std::string first_sentence(const std::string& purpose) {
  std::string out = purpose.substr(0, purpose.find(". "));
  if (out.ends_with('.') && !out.ends_with("...")) out.pop_back();
  return out;
}

std::string head(const std::string& page, const std::string& purpose, const std::string& version) {
  return fmt::format(
      ".\\\" Made of the command table by `orthodrive help-files`.\n.TH {} 1 \"\" {} \"Orthodrive\"\n.SH NAME\n{} \\- "
      "{}\n",
      argument(upper(page)), argument("orthodrive " + version), roff(page), roff(first_sentence(purpose)));
}

std::string page_of(const CommandText& command) { return "orthodrive-" + command.name; }

/// What a command takes, reads, writes and how it is called: the same for a page and for a section of one.
std::string body(const CommandText& command, const char* heading) {
  const auto [text, examples] = text_and_examples(command.footer);
  std::string out =
      fmt::format("{0} SYNOPSIS\n{1}{0} DESCRIPTION\n{2}", heading, synopsis(command), filled(command.purpose));
  if (!command.details.empty()) out += ".PP\n" + filled(command.details);
  if (!text.empty()) out += ".PP\n" + filled(text);
  out += fmt::format("{} OPTIONS\n{}", heading, option_list(command));
  if (!examples.empty()) out += fmt::format("{} EXAMPLES\n{}", heading, as_typed(examples));
  return out;
}

/// A command below another, as a section of its own.
std::string inner_command(const CommandText& command) {
  const auto [text, examples] = text_and_examples(command.footer);
  std::string out =
      fmt::format(".SH {}\n{}.PP\n{}", argument(upper(command.path)), synopsis(command), filled(command.purpose));
  if (!command.details.empty()) out += ".PP\n" + filled(command.details);
  if (!text.empty()) out += ".PP\n" + filled(text);
  out += option_list(command);
  if (!examples.empty()) out += as_typed(examples);
  return out;
}

constexpr const char* environment =
    ".SH ENVIRONMENT\n"
    ".TP\n.B ORTHODRIVE_MODELS\nfolder of models to look in first\n"
    ".TP\n.B ORTHODRIVE_VIEWER_DIR\nfolder of another viewer for\n.B orthodrive view\n";

}  // namespace

std::string tool_page(const CommandText& tool, const std::string& version) {
  std::string out = head("orthodrive", tool.purpose, version) + ".SH SYNOPSIS\n" + synopsis(tool);
  out += ".SH DESCRIPTION\n" + filled(tool.purpose) + filled(tool.details) + ".SH OPTIONS\n" + option_list(tool);
  out += ".SH COMMANDS\n";
  for (const CommandText& command : tool.commands)
    out += fmt::format(".TP\n.BR {} (1)\n{}", roff(page_of(command)), filled(command.purpose));
  out += fmt::format(".SH \"EXIT STATUS\"\n{}{}", filled(tool.footer), environment);
  return out;
}

std::string command_page(const CommandText& tool, const CommandText& command, const std::string& version) {
  std::string out = head(page_of(command), command.purpose, version) + body(command, ".SH");
  for (const CommandText& inner : command.commands) out += inner_command(inner);
  if (command.name == "train") out += ".SH \"THE PROGRAM ORTHODRIVE\\-TRAIN\"\n" + as_typed(train_packed_usage);
  out += ".SH \"OPTIONS OF ALL COMMANDS\"\n";
  for (const OptionText& option : tool.options)
    if (option.names.back() != "--help" && option.names.back() != "--version") out += option_entry(option);
  out += ".SH \"EXIT STATUS\"\n" + filled(tool.footer) + ".SH \"SEE ALSO\"\n.BR orthodrive (1)\n";
  return out;
}

}  // namespace orthodrive::app
