// SPDX-License-Identifier: Apache-2.0
#pragma once
// Ids of OpenDRIVE are texts (xs:string, 1.7, 2.4): those that are whole numbers of 32 bits stand for themselves, and
// the others get numbers.

#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace roadquery {

/// Ids of one kind of element: roads, or junctions.
class OpenDriveIds {
 public:
  /// The number of an id: itself, or one to be replaced by final_number() when all ids are known.
  [[nodiscard]] int number(std::string_view text);
  /// Gives numbers to the texts, in their alphabetical order: behind the greatest number of the file.
  void finish();
  [[nodiscard]] int final_number(int number) const;
  /// As the file has it; "" for numbers that stand for themselves.
  [[nodiscard]] std::string text(int number) const;
  [[nodiscard]] const std::map<std::string, int>& texts() const { return finals_; }

 private:
  std::set<int> numbers_;
  std::map<std::string, int, std::less<>> provisional_;
  std::vector<std::string> texts_;
  std::map<std::string, int> finals_;
};

}  // namespace roadquery
