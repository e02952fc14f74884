// SPDX-License-Identifier: Apache-2.0
#include "roadquery/spell_xml.hpp"

#include <map>

namespace roadquery::test {
namespace {

constexpr const char* opendrive_uri = "http://code.asam.net/simulation/standard/opendrive_schema";

/// Children of one name in their order, the names in any.
void mix_children(XmlElement& element, Dice& dice) {
  std::vector<std::string> names;
  std::map<std::string, std::vector<XmlElement>> by_name;
  for (XmlElement& child : element.children) {
    names.push_back(child.name);
    by_name[child.name].push_back(std::move(child));
  }
  dice.shuffle(names);
  std::map<std::string, std::size_t> used;
  element.children.clear();
  for (const std::string& name : names) element.children.push_back(std::move(by_name[name][used[name]++]));
}

class XmlWriter {
 public:
  XmlWriter(const XmlSpelling& how, Dice& dice) : how_(how), dice_(dice) {}

  void write(const XmlElement& element, int depth) {
    const std::string name = (how_.prefix.empty() ? "" : how_.prefix + ":") + element.name;
    text_ += "<" + name;
    for (const auto& [key, value] : element.attributes) {
      const char quote = how_.with_noise && dice_.one_in(2) ? '\'' : '"';
      text_ +=
          blank() + key + (how_.with_noise && dice_.one_in(9) ? " = " : "=") + quote + escaped(value, quote) + quote;
    }
    if (element.children.empty() && element.text.empty() && !(how_.with_noise && dice_.one_in(4))) {
      text_ += how_.with_noise && dice_.one_in(3) ? " />" : "/>";
      return;
    }
    text_ += '>';
    if (!element.text.empty())
      text_ += how_.with_noise && dice_.one_in(2) ? "<![CDATA[" + element.text + "]]>" : escaped(element.text, '"');
    for (const XmlElement& child : element.children) {
      text_ += line_end() + std::string(static_cast<std::size_t>(depth), ' ') + noise();
      write(child, depth + 1);
    }
    text_ += (element.children.empty() ? "" : line_end()) + "</" + name + (how_.with_noise ? blank() : "") + ">";
  }
  std::string text_;

 private:
  std::string line_end() { return how_.with_noise && dice_.one_in(2) ? "\r\n" : "\n"; }
  std::string blank() { return how_.with_noise ? dice_.one_of<const char*>({" ", "  ", "\n   ", "\t", "\r\n"}) : " "; }
  std::string noise() {
    if (!how_.with_noise || !dice_.one_in(6)) return "";
    return dice_.one_of<const char*>({"<!-- <road id=\"1\"/> & -->", "<?editor fold?>", "<!---->", " \t "});
  }
  std::string escaped(const std::string& value, char quote) {
    std::string result;
    for (const char c : value) {
      if (c == '&' || c == '<' || c == '>' || c == quote) {
        result += c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '"' ? "&quot;" : "&#x27;";
      } else if (how_.with_noise && dice_.one_in(60)) {
        result += "&#" + std::to_string(static_cast<int>(static_cast<unsigned char>(c))) + ";";
      } else {
        result += c;
      }
    }
    return result;
  }

  const XmlSpelling& how_;
  Dice& dice_;
};

void mix(XmlElement& element, Dice& dice) {
  dice.shuffle(element.attributes);
  mix_children(element, dice);
  for (XmlElement& child : element.children) mix(child, dice);
}

/// Of text in Latin-1.
std::string encoded(const std::string& text, Encoding encoding) {
  std::string bytes = encoding == Encoding::utf8_with_mark ? "\xef\xbb\xbf"
                      : encoding == Encoding::utf16_little ? "\xff\xfe"
                      : encoding == Encoding::utf16_big    ? "\xfe\xff"
                                                           : "";
  for (const char c : text) {
    const auto code = static_cast<unsigned char>(c);
    if (encoding == Encoding::utf16_little) {
      bytes += c, bytes += '\0';
    } else if (encoding == Encoding::utf16_big) {
      bytes += '\0', bytes += c;
    } else if (code >= 0x80 && (encoding == Encoding::utf8 || encoding == Encoding::utf8_with_mark)) {
      bytes += static_cast<char>(0xc0u | (code >> 6)), bytes += static_cast<char>(0x80u | (code & 0x3fu));
    } else {
      bytes += c;
    }
  }
  return bytes;
}

const char* declared(Encoding encoding) {
  switch (encoding) {
    case Encoding::utf16_little:
    case Encoding::utf16_big:
      return "UTF-16";
    case Encoding::latin1:
      return "ISO-8859-1";
    case Encoding::windows_1252:
      return "windows-1252";
    default:
      return "UTF-8";
  }
}

}  // namespace

std::string spell_xml(XmlElement root, const XmlSpelling& how, Dice& dice) {
  if (how.any_order) mix(root, dice);
  if (!how.prefix.empty()) root.set("xmlns:" + how.prefix, opendrive_uri);
  if (how.has_namespace) {
    if (how.prefix.empty()) root.set("xmlns", opendrive_uri);
    root.set("xmlns:xsi", "http://www.w3.org/2001/XMLSchema-instance");
    root.set("xsi:schemaLocation", std::string(opendrive_uri) + " opendrive_18_core.xsd");
  }
  XmlWriter writer(how, dice);
  writer.write(root, 1);
  std::string head;
  if (how.encoding != Encoding::undeclared_1252 || dice.one_in(2))
    head = std::string("<?xml version=\"1.0\" encoding=\"") + declared(how.encoding) + "\"" +
           (dice.one_in(2) ? " standalone=\"yes\"" : "") + "?>\n";
  if (how.with_noise) head += "<!-- made by a test -->\n<!DOCTYPE OpenDRIVE [<!ENTITY unused \"x\">]>\n";
  return encoded(head + writer.text_ + "\n", how.encoding);
}

}  // namespace roadquery::test
