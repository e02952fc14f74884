// SPDX-License-Identifier: Apache-2.0
#pragma once
// The commands of the tool as plain text: what manual pages and completions are made of.

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace orthodrive::app {

struct OptionText {
  std::vector<std::string> names;    ///< "-o", "--output"; of a positional its name alone
  std::string value;                 ///< kind of value: TEXT, INT, UINT, FLOAT; empty for flags
  std::string limits;                ///< of the value, as in "INT in [0 - 1024]"; may be empty
  std::vector<std::string> choices;  ///< the values allowed, where these are listed
  std::string text;                  ///< what it does
  std::string default_value;
  bool positional = false, required = false, repeated = false;
};

struct CommandText {
  std::string name;     ///< "labels"
  std::string path;     ///< as typed: "orthodrive evaluate labels"
  std::string purpose;  ///< first line of the description
  std::string details;  ///< the lines after it
  std::string footer;   ///< what it reads and writes, then examples
  std::vector<OptionText> options;
  std::vector<CommandText> commands;
};

/// The tool `app` with all its commands, in their order, without those that help does not list.
[[nodiscard]] CommandText command_table(const CLI::App& app);

}  // namespace orthodrive::app
