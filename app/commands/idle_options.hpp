// SPDX-License-Identifier: Apache-2.0
#pragma once
// Options that would change nothing are refused. tests/docs/all_options.txt has a line for every option.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <functional>
#include <ranges>
#include <string>
#include <vector>

#include "orthodrive/core/error.hpp"

namespace orthodrive::app {

/// When options of a command are read. Of an option with several rules each must hold.
class IdleOptions {
 public:
  using Options = std::vector<const CLI::Option*>;

  /// Only where `chooser` has one of `choices` (its default counts), or beside one of `others`.
  CLI::Option* read_for(CLI::Option* option, const CLI::Option* chooser, const std::vector<std::string>& choices,
                        const Options& others = {}) {
    rules_.push_back({option, [=]() -> std::string {
                        const std::vector<std::string> chosen = values_of(*chooser);
                        if (std::ranges::find_first_of(chosen, choices) != chosen.end() || any_given(others)) return "";
                        const std::string use = fmt::format("{}{}{}", fmt::join(choices, ", "),
                                                            others.empty() ? "" : " or beside ", names_of(others));
                        return chosen.empty() ? fmt::format("without {} {}", chooser->get_name(), use)
                                              : fmt::format("with {} {}: it is for {}", chooser->get_name(),
                                                            fmt::join(chosen, ","), use);
                      }});
    return option;
  }
  /// Only beside one of `others`.
  CLI::Option* needs(CLI::Option* option, const Options& others) {
    rules_.push_back({option, [=]() -> std::string { return any_given(others) ? "" : "without " + names_of(others); }});
    return option;
  }
  /// Never beside one of `others`.
  CLI::Option* excludes(CLI::Option* option, const Options& others) {
    rules_.push_back({option, [=]() -> std::string {
                        const auto other = std::ranges::find_if(others, is_given);
                        return other == others.end() ? "" : "with " + (*other)->get_name();
                      }});
    return option;
  }

  /// Throws OptionError for an option of the command line that is not read.
  void refuse() const {
    for (const auto& [option, why_idle] : rules_)
      if (is_given(option))
        if (const std::string why = why_idle(); !why.empty())
          throw OptionError(fmt::format("{} changes nothing {}", option->get_name(), why));
  }

 private:
  struct Rule {
    const CLI::Option* option;
    std::function<std::string()> why_idle;  ///< empty: it is read
  };

  static bool is_given(const CLI::Option* option) { return option->count() > 0; }
  static bool any_given(const Options& options) { return std::ranges::any_of(options, is_given); }
  static std::string names_of(const Options& options) {
    return fmt::format(
        "{}", fmt::join(options | std::views::transform([](const CLI::Option* o) { return o->get_name(); }), " or "));
  }
  static std::vector<std::string> values_of(const CLI::Option& chooser) {
    if (chooser.count() > 0) return chooser.results();
    return chooser.get_default_str().empty() ? std::vector<std::string>{} : std::vector{chooser.get_default_str()};
  }

  std::vector<Rule> rules_;
};

}  // namespace orthodrive::app
