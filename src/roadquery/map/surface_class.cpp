// SPDX-License-Identifier: Apache-2.0
#include "roadquery/map/surface_class.hpp"

#include <algorithm>
#include <array>
#include <string>

#include "roadquery/text/text.hpp"

namespace roadquery {
namespace {

constexpr std::array class_names{"asphalt", "concrete", "setts", "gravel", "ground"};

struct SurfaceName {
  std::string_view text;
  SurfaceClass surface;
};
// OSM's values by use, then what other programs write into <material surface>. docs/network.md repeats the table.
constexpr SurfaceName names[] = {
    {"asphalt", SurfaceClass::asphalt},
    {"chipseal", SurfaceClass::asphalt},
    {"paved", SurfaceClass::asphalt},
    {"bitumen", SurfaceClass::asphalt},
    {"bitmac", SurfaceClass::asphalt},
    {"tarmac", SurfaceClass::asphalt},
    {"tartan", SurfaceClass::asphalt},
    {"rubber", SurfaceClass::asphalt},
    {"concrete", SurfaceClass::concrete},
    {"cement", SurfaceClass::concrete},
    {"metal", SurfaceClass::concrete},  // gratings and plates of bridges: grip of neither asphalt nor gravel
    {"metal_grid", SurfaceClass::concrete},
    {"sett", SurfaceClass::setts},
    {"setts", SurfaceClass::setts},
    {"cobblestone", SurfaceClass::setts},
    {"cobble", SurfaceClass::setts},
    {"unhewn_cobblestone", SurfaceClass::setts},
    {"paving_stones", SurfaceClass::setts},
    {"grass_paver", SurfaceClass::setts},
    {"brick", SurfaceClass::setts},
    {"bricks", SurfaceClass::setts},
    {"stone", SurfaceClass::setts},
    {"wood", SurfaceClass::setts},  // planks: as uneven, and as slippery when wet
    {"compacted", SurfaceClass::gravel},
    {"fine_gravel", SurfaceClass::gravel},
    {"gravel", SurfaceClass::gravel},
    {"pebblestone", SurfaceClass::gravel},
    {"unpaved", SurfaceClass::gravel},
    {"rock", SurfaceClass::gravel},
    {"macadam", SurfaceClass::gravel},
    {"ground", SurfaceClass::ground},
    {"dirt", SurfaceClass::ground},
    {"earth", SurfaceClass::ground},
    {"soil", SurfaceClass::ground},
    {"clay", SurfaceClass::ground},
    {"grass", SurfaceClass::ground},
    {"mud", SurfaceClass::ground},
    {"sand", SurfaceClass::ground},
    {"woodchips", SurfaceClass::ground},
};

std::string_view without_spaces(std::string_view text) {
  constexpr std::string_view space = " \t\r\n";
  const std::size_t begin = text.find_first_not_of(space);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(space) - begin + 1);
}

std::optional<SurfaceClass> class_of_one(std::string_view text) {
  const auto known =
      std::find_if(std::begin(names), std::end(names), [&](const SurfaceName& n) { return n.text == text; });
  if (known != std::end(names)) return known->surface;
  const std::size_t colon = text.find(':');
  return colon == std::string_view::npos ? std::nullopt : class_of_one(text.substr(0, colon));
}

}  // namespace

const char* to_string(SurfaceClass surface) { return class_names.at(static_cast<std::size_t>(surface)); }

std::optional<SurfaceClass> surface_class_of(std::string_view text) {
  const std::string all = lowered(text);
  for (std::size_t begin = 0; begin <= all.size();) {
    const std::size_t end = std::min(all.find(';', begin), all.size());
    if (const auto surface = class_of_one(without_spaces(std::string_view(all).substr(begin, end - begin))))
      return surface;
    begin = end + 1;
  }
  return std::nullopt;
}

}  // namespace roadquery
