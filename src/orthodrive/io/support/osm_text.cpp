// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/support/osm_text.hpp"

#include <expat.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <map>
#include <memory>
#include <osmium/io/any_input.hpp>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/printable.hpp"
#include "orthodrive/io/support/osm_text_objects.hpp"

namespace orthodrive::io {
namespace {
namespace fs = std::filesystem;

constexpr std::string_view gzip_magic = "\x1f\x8b", bzip2_magic = "BZh", byte_order_mark = "\xef\xbb\xbf";

/// Unpacks a file block by block.
class TextBlocks {
 public:
  explicit TextBlocks(const fs::path& path) {
    const std::string name = path.string();
    osmium::io::file_compression compression = osmium::io::File(name).compression();
    std::string head(3, '\0');
    {
      const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(name.c_str(), "rb"), &std::fclose);
      head.resize(file ? std::fread(head.data(), 1, head.size(), file.get()) : 0);
    }
    if (head.starts_with(gzip_magic)) compression = osmium::io::file_compression::gzip;
    if (head.starts_with(bzip2_magic)) compression = osmium::io::file_compression::bzip2;
    blocks_ = osmium::io::CompressionFactory::instance().create_decompressor(
        compression, osmium::io::detail::open_for_reading(name));
  }
  ~TextBlocks() {
    try {
      blocks_->close();
    } catch (const std::exception&) {
      blocks_.reset();  // what matters was read, or is thrown already
    }
  }
  TextBlocks(const TextBlocks&) = delete;
  TextBlocks& operator=(const TextBlocks&) = delete;
  /// Empty at the end.
  [[nodiscard]] std::string next() { return blocks_->read(); }

 private:
  std::unique_ptr<osmium::io::Decompressor> blocks_;
};

/// What an XML file of another kind is, by its outermost element; and what to do.
std::string advice_for_root(std::string_view root) {
  if (root == "osmChange")
    return "is a file of changes (OsmChange), not a map; apply it to its extract: osmium apply-changes EXTRACT CHANGES "
           "-o OUT.osm.pbf";
  if (root == "gpx") return "is a GPX track, not a map; tracks are given as [sources] gpx";
  if (root == "html" || root == "HTML")
    return "is a web page, not a map: a server has sent an error instead of data; get the file again";
  return fmt::format("has the outermost element <{}>, not <osm>; export it as OSM XML (.osm)",
                     printable(std::string(root)));
}

constexpr const char* augmented_diff =
    "is an augmented diff of Overpass, not a map; ask for the map: leave out [diff:...] and [adiff:...]";

/// Tells objects out of XML. Children of objects lie at depth 2, those of members at depth 3.
class OsmXmlParser {
 public:
  OsmXmlParser(const fs::path& path, TextObjects& objects)
      : path_(path), objects_(objects), parser_(XML_ParserCreate(nullptr), &XML_ParserFree) {
    if (!parser_) throw Error("no memory for an XML parser");
    XML_SetUserData(parser_.get(), this);
    XML_SetElementHandler(
        parser_.get(),
        [](void* self, const char* name, const char** attributes) {
          static_cast<OsmXmlParser*>(self)->guarded([&](OsmXmlParser& p) { p.start(name, attributes); });
        },
        [](void* self, const char*) { static_cast<OsmXmlParser*>(self)->guarded([](OsmXmlParser& p) { p.end(); }); });
    XML_SetCharacterDataHandler(parser_.get(), [](void* self, const char* text, int size) {
      auto& p = *static_cast<OsmXmlParser*>(self);
      if (p.in_remark_ && p.remark_.size() < most_remark) p.remark_.append(text, static_cast<std::size_t>(size));
    });
    // Entities are not part of the format, and serve to exhaust memory (billion laughs).
    XML_SetEntityDeclHandler(parser_.get(), [](void* self, const char*, int, const char*, int, const char*, const char*,
                                               const char*, const char*) {
      static_cast<OsmXmlParser*>(self)->guarded(
          [](OsmXmlParser&) { throw osmium::xml_error{"XML entities are not supported"}; });
    });
  }
  void parse(const std::string& block, bool is_last) {
    if (XML_Parse(parser_.get(), block.data(), static_cast<int>(block.size()), is_last ? 1 : 0) != XML_STATUS_ERROR)
      return;
    if (failure_) std::rethrow_exception(failure_);
    throw osmium::xml_error{parser_.get()};
  }

 private:
  static constexpr std::size_t most_remark = 400;

  /// No exception may pass through C.
  template <typename F>
  void guarded(F&& call) noexcept {
    if (failure_) return;
    try {
      call(*this);
    } catch (...) {
      failure_ = std::current_exception();
      XML_StopParser(parser_.get(), XML_FALSE);
    }
  }

  void start(std::string_view name, const char** attributes) {
    const int depth = depth_++;
    if (depth == 0) return start_root(name, attributes);
    if (depth == 1) return start_object(name, attributes);
    if (!in_object_) return;
    if (depth == 2 && name == "tag") object_.tags.emplace_back(value(attributes, "k"), value(attributes, "v"));
    if (depth == 2 && name == "nd" && object_.type == osmium::item_type::way) start_nd(attributes);
    if (depth == 2 && name == "member" && object_.type == osmium::item_type::relation) start_member(attributes);
    if (depth == 3 && name == "nd" && !object_.members.empty())
      object_.members.back().line.push_back(place(attributes));
  }
  void start_root(std::string_view name, const char** attributes) {
    if (name != "osm") throw InputError(path_.string(), advice_for_root(name));
    const std::string version = value(attributes, "version");
    if (!version.empty() && version != "0.6") throw osmium::format_version_error{version.c_str()};
  }
  void start_object(std::string_view name, const char** attributes) {
    in_remark_ = name == "remark";
    if (name == "action") throw InputError(path_.string(), augmented_diff);
    const osmium::item_type type = name == "node"       ? osmium::item_type::node
                                   : name == "way"      ? osmium::item_type::way
                                   : name == "relation" ? osmium::item_type::relation
                                                        : osmium::item_type::undefined;
    in_object_ = type != osmium::item_type::undefined;
    if (!in_object_) return;
    object_ = {};
    object_.type = type;
    object_.id = number(attributes, "id", name);
    object_.version = version_of(value(attributes, "version"));
    object_.is_deleted = value(attributes, "action") == "delete" || value(attributes, "visible") == "false";
    if (type == osmium::item_type::node) object_.place = place(attributes);
  }
  void start_nd(const char** attributes) {
    const osmium::Location at = place(attributes);
    const bool is_place_only = at.valid() && value(attributes, "ref").empty();
    object_.nodes.emplace_back(is_place_only ? no_ref : number(attributes, "ref", "nd"), at);
  }
  void start_member(const char** attributes) {
    const std::string type = value(attributes, "type");
    object_.members.push_back({member_type(type), number(attributes, "ref", "member"), value(attributes, "role"), {}});
  }
  void end() {
    if (--depth_ != 1) return;
    if (in_object_) objects_.add(object_);
    if (in_remark_) check_remark(path_, remark_);
    in_object_ = in_remark_ = false;
  }

  static std::string value(const char** attributes, std::string_view name) {
    for (; *attributes; attributes += 2)
      if (name == attributes[0]) return attributes[1];
    return {};
  }
  std::int64_t number(const char** attributes, std::string_view name, std::string_view element) const {
    const std::string text = value(attributes, name);
    if (text.empty())
      throw osmium::xml_error{
          fmt::format("a <{}> without {} in line {}", element, name, XML_GetCurrentLineNumber(parser_.get()))};
    return osmium::string_to_object_id(text.c_str());
  }
  static osmium::Location place(const char** attributes) {
    return place_of(value(attributes, "lon"), value(attributes, "lat"));
  }

  const fs::path& path_;
  TextObjects& objects_;
  std::unique_ptr<XML_ParserStruct, void (*)(XML_Parser)> parser_;
  std::exception_ptr failure_;
  TextObject object_;
  int depth_ = 0;
  bool in_object_ = false, in_remark_ = false;
  std::string remark_;
};

}  // namespace

OsmSyntax osm_syntax(const fs::path& path) {
  const bool is_named_xml = osmium::io::File(path.string()).format() == osmium::io::file_format::xml;
  std::string head = TextBlocks(path).next();
  std::string_view text = head;
  if (text.starts_with(byte_order_mark)) text.remove_prefix(byte_order_mark.size());
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  // UTF-16 begins with a mark of its own, and Expat reads it.
  const bool is_utf16 = text.starts_with("\xff\xfe") || text.starts_with("\xfe\xff");
  if (first != text.npos && text[first] == '{') return OsmSyntax::json;
  if (is_utf16 || (first != text.npos && text[first] == '<') || is_named_xml) return OsmSyntax::xml;
  return OsmSyntax::binary;
}

void read_osm_text(const fs::path& path, OsmSyntax syntax, osmium::osm_entity_bits::type entities,
                   const UseOsmBuffer& use) {
  TextObjects objects(entities, use);
  TextBlocks blocks(path);
  if (syntax == OsmSyntax::json) {
    std::string text;
    for (std::string block = blocks.next(); !block.empty(); block = blocks.next()) {
      text += block;
      if (text.size() > most_osm_json_bytes)
        throw InputError(path.string(), "is JSON of more than 256 MB; ask Overpass for XML ([out:xml])");
    }
    add_osm_json(path, text, objects);
  } else {
    OsmXmlParser parser(path, objects);
    for (std::string block = blocks.next(); !block.empty(); block = blocks.next()) parser.parse(block, false);
    parser.parse({}, true);
  }
  objects.finish();
}

}  // namespace orthodrive::io
