// SPDX-License-Identifier: Apache-2.0
#pragma once
// Trees of XML, and the ways in which a file may spell one.

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "roadquery/dice.hpp"

namespace roadquery::test {

struct XmlElement {
  std::string name;
  std::vector<std::pair<std::string, std::string>> attributes{};
  std::vector<XmlElement> children{};
  std::string text{};  ///< before the children

  XmlElement& add(XmlElement child) { return children.emplace_back(std::move(child)); }
  void set(std::string_view key, std::string value) { attributes.emplace_back(key, std::move(value)); }
};

enum class Encoding { utf8, utf8_with_mark, utf16_little, utf16_big, latin1, windows_1252, undeclared_1252 };

/// What a writer of XML is free in.
struct XmlSpelling {
  Encoding encoding = Encoding::utf8;
  std::string prefix;          ///< of all names; empty: none
  bool has_namespace = false;  ///< default namespace, schemaLocation
  bool any_order = false;      ///< of attributes, and of children with different names
  bool with_noise = false;     ///< comments, processing instructions, references, blanks, either quotes
};

/// The bytes of a file. Children of one name keep their order. Texts are of Latin-1.
[[nodiscard]] std::string spell_xml(XmlElement root, const XmlSpelling& how, Dice& dice);

}  // namespace roadquery::test
