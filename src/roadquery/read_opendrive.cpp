// SPDX-License-Identifier: Apache-2.0
// OpenDRIVE files, read with expat.

#include <expat.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>

#include "roadquery/opendrive_builder.hpp"
#include "roadquery/road_map.hpp"

namespace roadquery {
namespace {

/// One expat parse. Exceptions must not pass through expat's C frames: they are kept as text and stop the parser.
struct Parse {
  OpenDriveBuilder builder;
  XML_Parser parser = nullptr;
  std::string problem;

  template <typename Step>
  void guarded(Step&& step) {
    if (!problem.empty()) return;
    try {
      step();
    } catch (const std::exception& error) {
      problem = error.what();
      XML_StopParser(parser, XML_FALSE);
    }
  }
};

void XMLCALL on_start(void* data, const char* name, const char** attributes) {
  auto& parse = *static_cast<Parse*>(data);
  parse.guarded([&] { parse.builder.start(name, attributes); });
}
void XMLCALL on_end(void* data, const char* name) {
  auto& parse = *static_cast<Parse*>(data);
  parse.guarded([&] { parse.builder.end(name); });
}
void XMLCALL on_text(void* data, const char* characters, int count) {
  auto& parse = *static_cast<Parse*>(data);
  parse.guarded([&] { parse.builder.text({characters, static_cast<std::size_t>(count)}); });
}

}  // namespace

RoadMap read_opendrive(const std::string& path, HeaderOffset offset) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw std::runtime_error(path + ": cannot be opened: " + std::strerror(errno));

  Parse parse;
  const std::unique_ptr<XML_ParserStruct, void (*)(XML_Parser)> parser(XML_ParserCreate(nullptr), XML_ParserFree);
  parse.parser = parser.get();
  XML_SetUserData(parser.get(), &parse);
  XML_SetElementHandler(parser.get(), on_start, on_end);
  XML_SetCharacterDataHandler(parser.get(), on_text);

  constexpr int chunk_bytes = 1 << 16;
  for (bool last = false; !last;) {
    void* buffer = XML_GetBuffer(parser.get(), chunk_bytes);
    if (buffer == nullptr) throw std::bad_alloc();
    in.read(static_cast<char*>(buffer), chunk_bytes);
    if (in.bad()) throw std::runtime_error(path + ": cannot be read: " + std::strerror(errno));
    last = in.eof();
    if (XML_ParseBuffer(parser.get(), static_cast<int>(in.gcount()), last ? 1 : 0) != XML_STATUS_OK) {
      const std::string what = parse.problem.empty() ? XML_ErrorString(XML_GetErrorCode(parser.get())) : parse.problem;
      throw std::runtime_error(path + ": line " + std::to_string(XML_GetCurrentLineNumber(parser.get())) + ": " + what);
    }
  }
  try {
    return parse.builder.finish(offset);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(path + ": " + error.what());
  }
}

}  // namespace roadquery
