// SPDX-License-Identifier: Apache-2.0
#pragma once
// What is asked of XML documents of servers, whose namespaces have any prefix. Internal to remote.

#include <cstdint>
#include <pugixml.hpp>
#include <string>
#include <string_view>

namespace orthodrive::remote {

/// Without the prefix of its namespace: services choose those freely.
[[nodiscard]] std::string_view local_name(const pugi::xml_node& node);
/// The first child of that local name, or none.
[[nodiscard]] pugi::xml_node child(const pugi::xml_node& node, std::string_view name);

template <typename Visit>
void for_children(const pugi::xml_node& node, std::string_view name, const Visit& visit) {
  for (const pugi::xml_node& c : node.children())
    if (local_name(c) == name) visit(c);
}

/// Of the first child of that local name, without blanks at the ends.
[[nodiscard]] std::string text_of(const pugi::xml_node& node, std::string_view name);
/// Of that local name, without blanks at the ends; empty where it is not there.
[[nodiscard]] std::string attribute(const pugi::xml_node& node, std::string_view name);
/// NaN for what is no number.
[[nodiscard]] double number_of(const std::string& text);
/// -1 for what is no count.
[[nodiscard]] std::int64_t count_of(const std::string& text);

/// The first words of a document that is something else, for a message.
[[nodiscard]] std::string glimpse(std::string_view text);
[[nodiscard]] bool looks_like_html(std::string_view text);

}  // namespace orthodrive::remote
