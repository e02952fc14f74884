// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/remote/http/xml_text.hpp"

#include <cmath>
#include <cstdlib>

#include "orthodrive/core/printable.hpp"
#include "roadquery/text/text.hpp"

namespace orthodrive::remote {

std::string_view local_name(const pugi::xml_node& node) {
  const std::string_view name = node.name();
  const std::size_t colon = name.find(':');
  return colon == std::string_view::npos ? name : name.substr(colon + 1);
}

pugi::xml_node child(const pugi::xml_node& node, std::string_view name) {
  for (const pugi::xml_node& c : node.children())
    if (local_name(c) == name) return c;
  return {};
}

std::string text_of(const pugi::xml_node& node, std::string_view name) {
  return std::string(roadquery::trimmed(child(node, name).child_value()));
}

std::string attribute(const pugi::xml_node& node, std::string_view name) {
  for (const pugi::xml_attribute& a : node.attributes()) {
    const std::string_view full = a.name();
    const std::size_t colon = full.find(':');
    if ((colon == std::string_view::npos ? full : full.substr(colon + 1)) == name)
      return std::string(roadquery::trimmed(a.value()));
  }
  return {};
}

double number_of(const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  return end != text.c_str() ? value : std::nan("");
}

std::int64_t count_of(const std::string& text) {
  const double value = number_of(text);
  return value >= 0.0 && value <= 1e15 ? static_cast<std::int64_t>(value) : -1;
}

std::string glimpse(std::string_view text) {
  std::string line = printable(std::string(roadquery::trimmed(text.substr(0, 400)))).substr(0, 80);
  while (!line.empty() && (static_cast<unsigned char>(line.back()) & 0xC0) == 0x80)
    line.pop_back();  // half a character
  if (!line.empty() && (static_cast<unsigned char>(line.back()) & 0x80)) line.pop_back();
  return line;
}

bool looks_like_html(std::string_view xml) {
  const std::string start = roadquery::lowered(xml.substr(0, 500));
  return start.find("<html") != std::string::npos || start.find("<!doctype html") != std::string::npos;
}

}  // namespace orthodrive::remote
