// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/osm/object_kind.hpp"

#include <array>
#include <string>
#include <string_view>

namespace orthodrive::io {
namespace {

struct Meaning {
  std::string_view key, value;
  ObjectKind kind;
};

constexpr std::array<Meaning, 24> meanings = {{
    {"highway", "traffic_signals", ObjectKind::traffic_signals},
    {"highway", "stop", ObjectKind::stop_sign},
    {"highway", "give_way", ObjectKind::give_way_sign},
    {"highway", "bus_stop", ObjectKind::bus_stop},
    {"power", "tower", ObjectKind::power_tower},
    {"power", "pole", ObjectKind::power_pole},
    {"amenity", "bench", ObjectKind::bench},
    {"amenity", "waste_basket", ObjectKind::waste_basket},
    {"amenity", "post_box", ObjectKind::post_box},
    {"amenity", "telephone", ObjectKind::telephone},
    {"amenity", "recycling", ObjectKind::recycling},
    {"barrier", "bollard", ObjectKind::bollard},
    {"barrier", "gate", ObjectKind::gate},
    {"barrier", "lift_gate", ObjectKind::lift_gate},
    {"emergency", "fire_hydrant", ObjectKind::fire_hydrant},
    {"man_made", "tower", ObjectKind::tower},
    {"man_made", "water_tower", ObjectKind::tower},
    {"man_made", "communications_tower", ObjectKind::tower},
    {"man_made", "mast", ObjectKind::mast},
    {"man_made", "chimney", ObjectKind::chimney},
    {"man_made", "storage_tank", ObjectKind::storage_tank},
    {"man_made", "silo", ObjectKind::storage_tank},
    {"man_made", "gasometer", ObjectKind::storage_tank},
    {"traffic_sign", "", ObjectKind::other_sign},
}};

/// Human-readable values, and the numbers of the German sign catalogue (VzKat), which others resemble little.
struct SignMeaning {
  std::string_view part;
  ObjectKind kind;
};
constexpr std::array<SignMeaning, 10> signs = {{
    {"stop", ObjectKind::stop_sign},
    {"DE:206", ObjectKind::stop_sign},
    {"give_way", ObjectKind::give_way_sign},
    {"DE:205", ObjectKind::give_way_sign},
    {"maxspeed", ObjectKind::speed_sign},
    {"DE:274", ObjectKind::speed_sign},
    {"hazard", ObjectKind::warning_sign},
    {"DE:101", ObjectKind::warning_sign},
    {"city_limit", ObjectKind::city_sign},
    {"DE:310", ObjectKind::city_sign},
}};

ObjectKind sign_kind(std::string_view sign) {
  for (const SignMeaning& meaning : signs)
    if (sign.starts_with(meaning.part)) return meaning.kind;
  return ObjectKind::other_sign;
}

}  // namespace

std::optional<ObjectKind> object_kind(const OsmTags& tags) {
  for (const Meaning& meaning : meanings) {
    const std::string_view value = tag_value(tags, std::string(meaning.key));
    if (value.empty() || value == "no" || (!meaning.value.empty() && value != meaning.value)) continue;
    if (meaning.kind == ObjectKind::other_sign) return sign_kind(value);
    if (meaning.kind == ObjectKind::bus_stop && tag_value(tags, "shelter") == "yes") return ObjectKind::bus_shelter;
    return meaning.kind;
  }
  return std::nullopt;
}

}  // namespace orthodrive::io
