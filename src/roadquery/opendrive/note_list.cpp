// SPDX-License-Identifier: Apache-2.0
#include "roadquery/opendrive/note_list.hpp"

#include <algorithm>

namespace roadquery {
namespace {

/// "<signal> (3), <station> (1)"; what comes after ten kinds is a number.
std::string list_of(const std::map<std::string, int>& elements) {
  constexpr std::size_t most = 10;
  std::string text;
  std::size_t told = 0;
  for (const auto& [name, count] : elements) {
    if (told == most) return text + " and " + std::to_string(elements.size() - most) + " kinds more";
    text += (told++ > 0 ? ", <" : "<") + name + "> (" + std::to_string(count) + ")";
  }
  return text;
}

}  // namespace

void NoteList::add(std::string_view code, std::string_view what, bool matters, NotePlace place) {
  constexpr std::size_t most_kinds = 200, longest = 400;  // a damaged file may say anything
  std::string text(what.substr(0, longest));
  if (text.size() < what.size()) {  // never half of a character of UTF-8
    while (!text.empty() && (static_cast<unsigned char>(text.back()) & 0xc0u) == 0x80u) text.pop_back();
    if (!text.empty()) text.pop_back();
  }
  for (char& c : text)
    if (static_cast<unsigned char>(c) < ' ') c = ' ';
  std::pair<std::string, std::string> key{code, std::move(text)};
  if (entries_.size() >= most_kinds && !entries_.contains(key)) key.second = "and more of this kind";
  Entry& entry = entries_[std::move(key)];
  if (entry.count++ == 0) entry.first = place;
  entry.matters = entry.matters || matters;
}

std::vector<ReadingNote> NoteList::take() const {
  std::vector<ReadingNote> notes;
  for (const auto& [key, entry] : entries_) {
    const std::string often = entry.count > 1 ? " (" + std::to_string(entry.count) + " times, here first)" : "";
    notes.push_back({key.first, key.second + often, entry.matters, entry.first.road, entry.first.s});
  }
  if (!passed_.empty())
    notes.push_back({"opendrive.passed_over",
                     "passed over, as they bear on neither surface nor lanes nor limits: " + list_of(passed_)});
  if (!unknown_.empty())
    notes.push_back(
        {"opendrive.unknown_element",
         "passed over, as OpenDRIVE has no such elements there, look for misspelt names: " + list_of(unknown_)});
  std::stable_sort(notes.begin(), notes.end(),
                   [](const ReadingNote& a, const ReadingNote& b) { return a.code < b.code; });
  return notes;
}

}  // namespace roadquery
