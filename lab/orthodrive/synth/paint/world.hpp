// SPDX-License-Identifier: Apache-2.0
#pragma once
// What a site looks like besides its plan: season, streets, light, roofs. Domain randomisation (Tobin et al. 2017): a
// seed draws each of them on its own, or all as they come together somewhere. docs/synth_worlds.md.
// To add a world, add a row to the tables in world.cpp and its name to world_names.hpp.

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "orthodrive/synth/ground/site_objects.hpp"

namespace orthodrive::synth {

struct Range {
  double low = 0.0, high = 0.0;
};

/// What may grow or lie on a field.
struct FieldLook {
  const char* name = "";
  Rgb color{};
  float row_m = 1.2f, row_depth = 0.03f;
  bool soil = false;  ///< labelled ground, else grass
};
[[nodiscard]] const std::vector<FieldLook>& field_looks();

struct Season {
  const char* name = "";
  Rgb grass{}, dry{}, foliage{}, conifer{}, forest_floor{}, soil{};
  float dryness = 0.12f;                      ///< share of `dry` in grass
  float bare = 0.0f, autumn = 0.0f;           ///< shares of the broad-leaved trees
  float conifers = 0.2f;                      ///< share of all trees
  std::vector<std::pair<int, float>> fields;  ///< number in field_looks(), weight
};

/// Weights of the pavements of a kind of road, in the order of Pavement.
using PavementWeights = std::array<float, pavement_count>;
struct Streets {
  const char* name = "";
  PavementWeights main{}, street{}, minor{};  ///< tertiary and better; streets; service roads and tracks
  Range new_asphalt, old_asphalt, concrete;   ///< tones, 0 .. 1
  Rgb gravel{}, dirt{};
  bool yellow_center = false;
};

struct Light {
  const char* name = "";
  Range elevation_deg, azimuth_deg;  ///< the sun stands in the south: 105 .. 255
  Range sky, haze, contrast, gain, blur, noise;
  Rgb haze_color{1.0f, 1.0f, 1.0f}, tint{1.0f, 1.0f, 1.0f};
};

struct Roofs {
  const char* name = "";
  std::vector<Rgb> tones;
  float flat = 0.0f;  ///< share of the flat ones among dwellings
};

struct World {
  std::string name;
  const Season* season = nullptr;
  const Streets* streets = nullptr;
  const Light* light = nullptr;
  const Roofs* roofs = nullptr;
};

/// Of world_names, or "random": season, streets, light and roofs are drawn by seed, each on its own.
/// Throws OptionError.
[[nodiscard]] World make_world(std::string_view name, std::uint64_t seed);

/// Gives every road but those whose surface the plan says its pavement, with the tag that OSM has for it.
void pave_roads(SitePlan& plan, const World& world, std::uint64_t seed);
/// Leaves on trees, colours and shapes of roofs.
void dress_objects(SiteObjects& objects, const World& world, std::uint64_t seed);
/// What grows on a field with this number.
[[nodiscard]] const FieldLook& field_look(const World& world, std::uint16_t number);
[[nodiscard]] const char* surface_tag(Pavement pavement);

}  // namespace orthodrive::synth
