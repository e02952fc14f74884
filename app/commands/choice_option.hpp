// SPDX-License-Identifier: Apache-2.0
#pragma once
// Options whose value is one of a few words.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <string>
#include <utility>
#include <vector>

namespace orthodrive::app {

/// `value` has its default, which is one of `choices`, and outlives `cmd`.
template <typename Value>
CLI::Option* add_choice(CLI::App& cmd, const std::string& name, Value& value,
                        std::vector<std::pair<std::string, Value>> choices, const std::string& text) {
  std::vector<std::string> words;
  words.reserve(choices.size());
  for (const auto& [word, of_word] : choices) words.push_back(word);
  const std::string default_word = std::ranges::find(choices, value, &std::pair<std::string, Value>::second)->first;
  return cmd
      .add_option_function<std::string>(
          name,
          [&value, choices = std::move(choices)](const std::string& word) {
            value = std::ranges::find(choices, word, &std::pair<std::string, Value>::first)->second;
          },
          text)
      ->check(CLI::IsMember(words))
      ->default_str(default_word);
}

}  // namespace orthodrive::app
