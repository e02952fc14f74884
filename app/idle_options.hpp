// SPDX-License-Identifier: Apache-2.0
#pragma once
// Options that would change nothing are refused.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <string>
#include <vector>

#include "orthodrive/core/error.hpp"

namespace orthodrive::app {

/// Options of a command that only some choices of another option read ("--search-radius" of "--method default").
class OptionsOfChoices {
 public:
  using Choices = std::vector<std::string>;
  /// chooser: the name of the other option.
  explicit OptionsOfChoices(std::string chooser) : chooser_(std::move(chooser)) {}

  CLI::Option* add(CLI::Option* option, Choices choices) {
    options_.push_back({option, std::move(choices)});
    return option;
  }
  /// Throws OptionError for an option of the command line that this choice does not read.
  void refuse_idle(const std::string& choice) const {
    for (const auto& [option, choices] : options_)
      if (option->count() > 0 && std::ranges::find(choices, choice) == choices.end())
        throw OptionError(fmt::format("{} changes nothing with {} {}: it is for {}", option->get_name(), chooser_,
                                      choice, fmt::join(choices, ", ")));
  }

 private:
  struct Entry {
    CLI::Option* option;
    Choices choices;
  };
  std::string chooser_;
  std::vector<Entry> options_;
};

}  // namespace orthodrive::app
