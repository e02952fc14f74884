// SPDX-License-Identifier: Apache-2.0
#include "roadquery/opendrive/opendrive_ids.hpp"

#include <algorithm>
#include <limits>

#include "roadquery/text/number_text.hpp"
#include "roadquery/text/text.hpp"

namespace roadquery {
namespace {

constexpr int least_number = -1'000'000'000;  // below it stand the numbers of texts until all are known
constexpr int first_provisional = std::numeric_limits<int>::min();

/// As a program would write it: "7" and "-7", neither "07" nor "7.0".
bool plain_number(std::string_view text, int& number) {
  const std::string_view digits = text.starts_with('-') ? text.substr(1) : text;
  if (digits.empty() || (digits.size() > 1 && digits.front() == '0')) return false;
  const auto [end, error] = number_from_text(text, number);
  return error == std::errc{} && end == text.data() + text.size() && number >= least_number;
}

}  // namespace

int OpenDriveIds::number(std::string_view text) {
  text = trimmed(text);
  int number = 0;
  if (plain_number(text, number)) {
    numbers_.insert(number);
    return number;
  }
  const auto found = provisional_.find(text);
  if (found != provisional_.end()) return found->second;
  number = first_provisional + static_cast<int>(texts_.size());
  texts_.emplace_back(text);
  provisional_.emplace(text, number);
  return number;
}

void OpenDriveIds::finish() {
  constexpr int most = std::numeric_limits<int>::max();
  int next = numbers_.empty() ? 0 : std::max(*numbers_.rbegin(), -1);
  if (!numbers_.empty()) next = next < most - static_cast<int>(texts_.size()) ? next + 1 : 0;
  for (const auto& [text, number] : provisional_) {
    while (numbers_.contains(next)) ++next;
    finals_.emplace(text, next++);
  }
}

int OpenDriveIds::final_number(int number) const { return number >= least_number ? number : finals_.at(text(number)); }

std::string OpenDriveIds::text(int number) const {
  return number >= least_number ? "" : texts_[static_cast<std::size_t>(number - first_provisional)];
}

}  // namespace roadquery
