// SPDX-License-Identifier: Apache-2.0
#pragma once
// What was odd in a file, gathered while it is read: one note for each kind of thing, however often it comes.

#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "roadquery/map/road_map.hpp"

namespace roadquery {

/// Where something is: the road as the ids of the file's reader number it.
struct NotePlace {
  int road = -1;
  double s = 0.0;
};

class NoteList {
 public:
  /// `what`: of all things of this kind, without numbers.
  void add(std::string_view code, std::string_view what, bool matters, NotePlace place = {});
  /// An element that is passed over: what bears on neither surface nor lanes nor limits goes into one note for all.
  void add_passed(std::string_view element) { ++passed_[std::string(element)]; }
  /// An element that no version of OpenDRIVE has there: one note for all.
  void add_unknown(std::string_view path) { ++unknown_[std::string(path)]; }
  /// Sorted by code and message. Roads have the numbers that they had when they were told of.
  [[nodiscard]] std::vector<ReadingNote> take() const;

 private:
  struct Entry {
    int count = 0;
    bool matters = false;
    NotePlace first;
  };
  std::map<std::pair<std::string, std::string>, Entry> entries_;
  std::map<std::string, int> passed_, unknown_;
};

}  // namespace roadquery
