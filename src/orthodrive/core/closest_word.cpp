// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/core/closest_word.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

namespace orthodrive {
namespace {

constexpr std::size_t longest_word = 64;  // the table below is the square of it

char folded(char c) { return c == '-' ? '_' : static_cast<char>(std::tolower(static_cast<unsigned char>(c))); }

}  // namespace

int edit_distance(std::string_view a, std::string_view b) {
  const auto rows = static_cast<std::ptrdiff_t>(a.size()) + 1, cols = static_cast<std::ptrdiff_t>(b.size()) + 1;
  std::vector<int> table(static_cast<std::size_t>(rows * cols));
  const auto at = [&](std::ptrdiff_t i, std::ptrdiff_t j) -> int& {
    return table[static_cast<std::size_t>(i * cols + j)];
  };
  const auto letter = [](std::string_view text, std::ptrdiff_t i) {
    return folded(text[static_cast<std::size_t>(i - 1)]);
  };
  for (std::ptrdiff_t i = 0; i < rows; ++i) at(i, 0) = static_cast<int>(i);
  for (std::ptrdiff_t j = 0; j < cols; ++j) at(0, j) = static_cast<int>(j);
  for (std::ptrdiff_t i = 1; i < rows; ++i)
    for (std::ptrdiff_t j = 1; j < cols; ++j) {
      const int change = letter(a, i) == letter(b, j) ? 0 : 1;
      at(i, j) = std::min({at(i - 1, j) + 1, at(i, j - 1) + 1, at(i - 1, j - 1) + change});
      const bool swapped = i > 1 && j > 1 && letter(a, i) == letter(b, j - 1) && letter(a, i - 1) == letter(b, j);
      if (swapped) at(i, j) = std::min(at(i, j), at(i - 2, j - 2) + 1);
    }
  return at(rows - 1, cols - 1);
}

std::optional<std::string> closest_word(std::string_view word, const std::vector<std::string>& known) {
  if (word.empty() || word.size() > longest_word) return std::nullopt;
  std::optional<std::string> closest;
  int least = 0;
  for (const std::string& candidate : known) {
    if (candidate.size() > longest_word) continue;
    const int distance = edit_distance(word, candidate);
    const int most = std::max(1, 2 * static_cast<int>(std::max(word.size(), candidate.size())) / 5);
    if (distance > most || (closest && distance >= least)) continue;
    closest = candidate;
    least = distance;
  }
  return closest;
}

std::string suggestion(std::string_view word, const std::vector<std::string>& known) {
  if (const auto closest = closest_word(word, known)) return fmt::format("; did you mean '{}'?", *closest);
  return known.empty() ? std::string() : fmt::format("; known are: {}", fmt::join(known, ", "));
}

}  // namespace orthodrive
