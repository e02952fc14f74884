// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/support/map_color.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <string>

#include "orthodrive/model/rasters/srgb.hpp"

namespace orthodrive::io {
namespace {

struct NamedColor {
  std::string_view name;
  unsigned rgb;  ///< sRGB
};

/// Of CSS (Color Module Level 4, 6.1): the basic ones and those that buildings have.
constexpr std::array<NamedColor, 38> css_colors = {{
    {"black", 0x000000},     {"silver", 0xc0c0c0},    {"gray", 0x808080},       {"grey", 0x808080},
    {"white", 0xffffff},     {"maroon", 0x800000},    {"red", 0xff0000},        {"purple", 0x800080},
    {"fuchsia", 0xff00ff},   {"green", 0x008000},     {"lime", 0x00ff00},       {"olive", 0x808000},
    {"yellow", 0xffff00},    {"navy", 0x000080},      {"blue", 0x0000ff},       {"teal", 0x008080},
    {"aqua", 0x00ffff},      {"orange", 0xffa500},    {"beige", 0xf5f5dc},      {"brown", 0xa52a2a},
    {"cream", 0xfffdd0},     {"darkgray", 0xa9a9a9},  {"darkgrey", 0xa9a9a9},   {"lightgray", 0xd3d3d3},
    {"lightgrey", 0xd3d3d3}, {"darkgreen", 0x006400}, {"lightgreen", 0x90ee90}, {"darkred", 0x8b0000},
    {"firebrick", 0xb22222}, {"indianred", 0xcd5c5c}, {"lightblue", 0xadd8e6},  {"lightyellow", 0xffffe0},
    {"pink", 0xffc0cb},      {"salmon", 0xfa8072},    {"sandybrown", 0xf4a460}, {"tan", 0xd2b48c},
    {"wheat", 0xf5deb3},     {"ivory", 0xfffff0},
}};

constexpr std::array<NamedColor, 19> materials = {{
    {"brick", 0xa0583f},       {"bricks", 0xa0583f},    {"cement_block", 0x9c9a94}, {"concrete", 0x9c9a94},
    {"copper", 0x6fa08a},      {"eternit", 0x7d7f7e},   {"glass", 0x9fb4bd},        {"metal", 0x9aa0a3},
    {"metal_sheet", 0x9aa0a3}, {"sandstone", 0xc9ac7d}, {"slate", 0x4d5257},        {"steel", 0x9aa0a3},
    {"stone", 0x9b9486},       {"tar_paper", 0x45423f}, {"thatch", 0x8d7a52},       {"timber_framing", 0xcdbfa6},
    {"tin", 0xa6abad},         {"wood", 0x8a5f3c},      {"zinc", 0x8e979c},
}};

std::array<float, 3> linear(unsigned rgb) {
  const auto part = [&](unsigned shift) { return linear_values()[(rgb >> shift) & 255U]; };
  return {part(16), part(8), part(0)};
}

template <std::size_t N>
std::optional<std::array<float, 3>> named(const std::array<NamedColor, N>& colors, std::string_view name) {
  const auto found = std::ranges::find(colors, name, &NamedColor::name);
  return found == colors.end() ? std::nullopt : std::optional(linear(found->rgb));
}

}  // namespace

std::optional<std::array<float, 3>> map_color(std::string_view text) {
  std::string name;
  for (const char c : text)
    if (c != ' ' && c != '_') name.push_back(static_cast<char>(std::tolower(static_cast<unsigned char>(c))));
  if (!name.starts_with('#')) return named(css_colors, name);
  if (name.size() == 4) name = {'#', name[1], name[1], name[2], name[2], name[3], name[3]};
  unsigned rgb = 0;
  const char *first = name.data() + 1, *last = name.data() + name.size();
  const auto [end, error] = std::from_chars(first, last, rgb, 16);
  return name.size() == 7 && error == std::errc{} && end == last ? std::optional(linear(rgb)) : std::nullopt;
}

std::optional<std::array<float, 3>> material_color(std::string_view material) { return named(materials, material); }

}  // namespace orthodrive::io
