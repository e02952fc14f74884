// SPDX-License-Identifier: Apache-2.0
#pragma once
// Roads out of the elements of an OpenDRIVE file, whichever parser reads its XML.

#include <memory>
#include <string>
#include <string_view>

#include "roadquery/map/road_map.hpp"

namespace roadquery {

/// Takes the elements in the order of the file; every start() has its end(). All functions throw std::runtime_error
/// with what is wrong; after that the builder is of no use.
class OpenDriveBuilder {
 public:
  OpenDriveBuilder();
  ~OpenDriveBuilder();

  /// `attributes`: name, value, name, value, ..., nullptr.
  void start(const char* name, const char** attributes);
  void end(const char* name);
  void text(std::string_view characters);
  /// Says in the map's notes what the parser made of the file's characters.
  void note_encoding(const std::string& what);
  /// Once, behind the last element.
  [[nodiscard]] RoadMap finish(HeaderOffset offset);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace roadquery
