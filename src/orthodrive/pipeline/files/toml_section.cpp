// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/pipeline/files/toml_section.hpp"

#include <algorithm>
#include <charconv>

#include "orthodrive/core/closest_word.hpp"
#include "orthodrive/core/printable.hpp"

namespace orthodrive {
namespace {

constexpr std::string_view override_mark = "--set ";  // begins the source path of what is not in the file

bool is_override(const toml::node& node) {
  return node.source().path && node.source().path->starts_with(override_mark);
}

}  // namespace

toml::table parse_toml(std::string_view text, const std::filesystem::path& file) {
  try {
    return toml::parse(text);
  } catch (const toml::parse_error& error) {
    throw InputError(fmt::format("{}:{}", file.string(), error.source().begin.line),
                     printable(std::string(error.description())));
  }
}

void override_toml(toml::table& table, const std::string& text) {
  const auto equals = text.find('='), dot = text.find('.');
  const bool top_level = dot == std::string::npos || dot > equals;
  const std::string quoted = std::string(override_mark) + text;
  if (equals == std::string::npos || equals == 0) throw OptionError(quoted + ": expected section.key=value");
  const std::string section = top_level ? "" : text.substr(0, dot);
  const std::string key = top_level ? text.substr(0, equals) : text.substr(dot + 1, equals - dot - 1);
  const std::string value = text.substr(equals + 1);
  toml::table parsed;
  try {
    parsed = toml::parse(fmt::format("{} = {}", key, value), std::string_view(quoted));
  } catch (const toml::parse_error&) {  // a bare word: drive.route=Circuit
    std::string escaped;
    for (const char c : printable(value)) escaped += c == '"' || c == '\\' ? std::string{'\\', c} : std::string{c};
    try {
      parsed = toml::parse(fmt::format("{} = \"{}\"", key, escaped), std::string_view(quoted));
    } catch (const toml::parse_error&) {
      throw OptionError(quoted + ": expected section.key=value");
    }
  }
  if (!section.empty() && !table.contains(section)) table.insert(section, toml::table{});
  toml::table* target = section.empty() ? &table : table[section].as_table();
  if (!target) throw OptionError(fmt::format("{}: '{}' is not a section", quoted, section));
  for (auto&& [k, v] : parsed)
    v.visit([&, &name = k](auto& node) { target->insert_or_assign(name, std::move(node)); });  // for clang 14, too
}

std::string TomlSection::place_of(const toml::node& node) const {
  if (is_override(node)) return *node.source().path;
  const auto line = node.source().begin.line;
  return line == 0 ? file_.string() : fmt::format("{}:{}", file_.string(), line);
}

std::string TomlSection::place_of(const char* key) const {
  const toml::node* node = table_.get(key);
  return place_of(node ? *node : table_);
}

void TomlSection::fail(const toml::node& node, const std::string& what) const {
  if (is_override(node)) throw OptionError(fmt::format("{}: {}", place_of(node), what));
  throw InputError(place_of(node), what);
}

void TomlSection::fail_at(const char* key, const std::string& what) const {
  const toml::node* node = table_.get(key);
  fail(node ? *node : table_, fmt::format("{}{}{}", called(key), what.empty() ? "" : " ", what));
}

void TomlSection::at(const char* key, const std::function<void()>& body) const {
  try {
    body();
  } catch (const Error& error) {
    const toml::node* node = table_.get(key);
    fail(node ? *node : table_, fmt::format("{}: {}", called(key), error.what()));
  }
}

void TomlSection::read_texts(const char* key, std::vector<std::string>& values) {
  const toml::node* node = find(key);
  if (!node) return;
  if (const auto one = node->value<std::string>())
    values = {*one};
  else if (node->is_array())
    read(key, values);
  else
    fail(*node, fmt::format("{} must be a text or a list of texts", called(key)));
}

void TomlSection::read_color(const char* key, std::array<std::uint8_t, 3>& color) {
  require(key);
  const toml::node& node = *find(key);
  std::vector<int> values;
  if (const auto text = node.value<std::string>()) {
    unsigned number = 0;
    const char *begin = text->data() + 1, *end = text->data() + text->size();
    if (text->size() == 7 && text->front() == '#')
      if (const auto read = std::from_chars(begin, end, number, 16); read.ec == std::errc{} && read.ptr == end)
        for (const int shift : {16, 8, 0}) values.push_back(static_cast<int>(number >> shift & 255U));
  } else if (node.is_array()) {
    read(key, values);
  }
  if (values.size() != 3 || std::ranges::any_of(values, [](int v) { return v < 0 || v > 255; }))
    fail(node, fmt::format("{} must be [r, g, b], each 0 to 255, or \"#RRGGBB\"", called(key)));
  std::ranges::transform(values, color.begin(), [](int v) { return static_cast<std::uint8_t>(v); });
}

void TomlSection::read_choice(const char* key, std::string& value, const std::vector<std::string>& choices) {
  const toml::node* node = find(key);
  if (!node) return;
  const auto text = node->value<std::string>();
  const std::string given = text ? printable(*text) : "no text";
  if (!text || std::find(choices.begin(), choices.end(), *text) == choices.end()) {
    const auto closest = closest_word(given, choices);
    fail(*node,
         fmt::format("{} must be {}, not {}{}", called(key), fmt::join(choices, " or "),
                     text ? "'" + given + "'" : given, closest ? fmt::format("; did you mean '{}'?", *closest) : ""));
  }
  value = *text;
}

const toml::table* TomlSection::find_table(const char* key) {
  const toml::node* node = find(key);
  if (node && !node->is_table()) fail(*node, fmt::format("{} must be a section: [{}]", called(key), key));
  return node ? node->as_table() : nullptr;
}

TomlSection TomlSection::section(const char* key) {
  static const toml::table none;
  const toml::table* table = find_table(key);
  return {table ? *table : none, file_, name_.empty() ? std::string(key) : name_ + "." + key};
}

void TomlSection::finish() const {
  for (const auto& [key, node] : table_)
    if (const std::string name = printable(std::string(key.str())); !used_.contains(std::string(key.str())))
      fail(node, fmt::format("{} is not known here{}", called(name), suggestion(name, {used_.begin(), used_.end()})));
}

}  // namespace orthodrive
