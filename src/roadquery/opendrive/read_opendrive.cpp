// SPDX-License-Identifier: Apache-2.0
// OpenDRIVE files, read with expat.

#include <expat.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>

#include "roadquery/map/road_map.hpp"
#include "roadquery/opendrive/opendrive_builder.hpp"
#include "roadquery/text/text.hpp"

namespace roadquery {
namespace {

/// One expat parse. Exceptions must not pass through expat's C frames: they are kept as text and stop the parser.
struct Parse {
  OpenDriveBuilder builder;
  XML_Parser parser = nullptr;
  std::string problem;
  std::string misread_encoding;  ///< one that is read as another

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

/// Encodings with a byte for every character: expat knows UTF-8, UTF-16, ISO-8859-1 and ASCII itself.
constexpr int windows_1252_above_7f[32] = {0x20ac, 0x81,   0x201a, 0x192,  0x201e, 0x2026, 0x2020, 0x2021,
                                           0x2c6,  0x2030, 0x160,  0x2039, 0x152,  0x8d,   0x17d,  0x8f,
                                           0x90,   0x2018, 0x2019, 0x201c, 0x201d, 0x2022, 0x2013, 0x2014,
                                           0x2dc,  0x2122, 0x161,  0x203a, 0x153,  0x9d,   0x17e,  0x178};

/// Of an encoding that expat does not know: windows-1252, and as that every other one whose first half is ASCII and
/// whose other bytes are no ASCII (all of the ISO-8859 and windows families; of GBK, Big5 and Shift-JIS the second byte
/// may be a letter, never one of XML's own characters). Only names are spelt wrong.
int XMLCALL on_encoding(void* data, const char* name, XML_Encoding* encoding) {
  const std::string known = lowered(name);
  for (const char* other : {"utf-32", "ucs-4", "iso-10646-ucs", "ebcdic", "cp037", "cp500", "utf-7"})
    if (known.find(other) != std::string::npos) return XML_STATUS_ERROR;
  for (int i = 0; i < 256; ++i) encoding->map[i] = i < 0x80 || i >= 0xa0 ? i : windows_1252_above_7f[i - 0x80];
  encoding->data = nullptr, encoding->convert = nullptr, encoding->release = nullptr;
  if (known != "windows-1252" && known != "cp1252") static_cast<Parse*>(data)->misread_encoding = name;
  return XML_STATUS_OK;
}

bool is_utf8(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  int rest = 0;  // bytes that are missing of a character
  for (std::istreambuf_iterator<char> at(in), end; at != end; ++at) {
    const auto byte = static_cast<unsigned char>(*at);
    if (rest > 0) {
      if ((byte & 0xc0u) != 0x80u) return false;
      --rest;
    } else if (byte >= 0x80u) {
      rest = byte >= 0xc2u && byte < 0xe0u   ? 1
             : byte >= 0xe0u && byte < 0xf0u ? 2
             : byte >= 0xf0u && byte < 0xf5u ? 3
                                             : 0;
      if (rest == 0) return false;
    }
  }
  return rest == 0;
}

/// What expat says, and what to do.
std::string wrong_xml(XML_Error error) {
  std::string said = XML_ErrorString(error);
  switch (error) {
    case XML_ERROR_NO_ELEMENTS:
    case XML_ERROR_UNCLOSED_TOKEN:
    case XML_ERROR_PARTIAL_CHAR:
    case XML_ERROR_UNCLOSED_CDATA_SECTION:
      return said + ", the file ends too early: get it whole";
    case XML_ERROR_SYNTAX:
    case XML_ERROR_INVALID_TOKEN:
    case XML_ERROR_TAG_MISMATCH:
    case XML_ERROR_DUPLICATE_ATTRIBUTE:
    case XML_ERROR_JUNK_AFTER_DOC_ELEMENT:
    case XML_ERROR_UNDEFINED_ENTITY:
      return said + ", this is no XML: mend the file there";
    default:
      return said;
  }
}

/// `encoding`: instead of what the file says; nullptr: as it says. False where the bytes are not of that encoding.
bool parse_file(const std::string& path, const char* encoding, Parse& parse) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw std::runtime_error(path + ": cannot be opened: " + std::strerror(errno));
  const std::unique_ptr<XML_ParserStruct, void (*)(XML_Parser)> parser(XML_ParserCreate(encoding), XML_ParserFree);
  parse.parser = parser.get();
  XML_SetUserData(parser.get(), &parse);
  XML_SetElementHandler(parser.get(), on_start, on_end);
  XML_SetCharacterDataHandler(parser.get(), on_text);
  XML_SetUnknownEncodingHandler(parser.get(), on_encoding, &parse);

  constexpr int chunk_bytes = 1 << 16;
  for (bool last = false; !last;) {
    void* buffer = XML_GetBuffer(parser.get(), chunk_bytes);
    if (buffer == nullptr) throw std::bad_alloc();
    in.read(static_cast<char*>(buffer), chunk_bytes);
    if (in.bad()) throw std::runtime_error(path + ": cannot be read: " + std::strerror(errno));
    last = in.eof();
    if (XML_ParseBuffer(parser.get(), static_cast<int>(in.gcount()), last ? 1 : 0) == XML_STATUS_OK) continue;
    const XML_Error error = XML_GetErrorCode(parser.get());
    if (encoding == nullptr && parse.problem.empty() && error == XML_ERROR_INVALID_TOKEN && !is_utf8(path))
      return false;
    const std::string what = parse.problem.empty() ? wrong_xml(error) : parse.problem;
    throw std::runtime_error(path + ": line " + std::to_string(XML_GetCurrentLineNumber(parser.get())) + ": " + what);
  }
  return true;
}

}  // namespace

RoadMap read_opendrive(const std::string& path, HeaderOffset offset) {
  Parse parse;
  const bool as_written = parse_file(path, nullptr, parse);
  Parse again;
  if (!as_written) parse_file(path, "windows-1252", again);
  Parse& done = as_written ? parse : again;
  if (!as_written)
    done.builder.note_encoding("the file's bytes are not of its encoding, they are read as windows-1252");
  if (!done.misread_encoding.empty())
    done.builder.note_encoding("the encoding " + done.misread_encoding +
                               " is not known, names beyond ASCII are read as windows-1252; write the file in UTF-8");
  try {
    return done.builder.finish(offset);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(path + ": " + error.what());
  }
}

}  // namespace roadquery
