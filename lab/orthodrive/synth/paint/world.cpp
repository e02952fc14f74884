// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/synth/paint/world.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <functional>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/noise.hpp"
#include "orthodrive/core/random.hpp"
#include "orthodrive/model/roads/road_network.hpp"
#include "orthodrive/synth/paint/world_names.hpp"

namespace orthodrive::synth {
namespace {

enum Look : int {
  wheat,
  rape,
  brown_soil,
  dark_soil,
  stubble,
  maize,
  hay,
  fallow,
  rice,
  ripe_rice,
  bean,
  red_soil,
  grey_mud
};

// Colours as photos show them in the sun, by eye on the photos of Estonia, Japan, Banepa, Kvarnbyn and Pardubice.
const std::vector<Season> seasons{
    {.name = "summer",
     .grass = {0.38f, 0.44f, 0.26f},
     .dry = {0.54f, 0.50f, 0.35f},
     .foliage = {0.24f, 0.32f, 0.17f},
     .conifer = {0.19f, 0.26f, 0.18f},
     .forest_floor = {0.20f, 0.25f, 0.14f},
     .soil = {0.46f, 0.38f, 0.29f},
     .dryness = 0.15f,
     .conifers = 0.25f,
     .fields = {{wheat, 2}, {maize, 1.5}, {hay, 2}, {stubble, 1}, {brown_soil, 1}, {rape, 0.5}, {bean, 1}}},
    {.name = "dry summer",
     .grass = {0.49f, 0.45f, 0.31f},
     .dry = {0.64f, 0.57f, 0.42f},
     .foliage = {0.29f, 0.32f, 0.20f},
     .conifer = {0.24f, 0.29f, 0.20f},
     .forest_floor = {0.42f, 0.36f, 0.26f},
     .soil = {0.58f, 0.47f, 0.35f},
     .dryness = 0.5f,
     .conifers = 0.3f,
     .fields = {{stubble, 2}, {brown_soil, 1.5}, {fallow, 2}, {red_soil, 1}, {hay, 1}, {maize, 0.5}}},
    {.name = "early spring",
     .grass = {0.42f, 0.42f, 0.26f},
     .dry = {0.55f, 0.49f, 0.34f},
     .foliage = {0.46f, 0.42f, 0.34f},
     .conifer = {0.20f, 0.25f, 0.17f},
     .forest_floor = {0.42f, 0.36f, 0.27f},
     .soil = {0.44f, 0.36f, 0.27f},
     .dryness = 0.5f,
     .bare = 0.93f,
     .conifers = 0.3f,
     .fields = {{brown_soil, 2}, {dark_soil, 1}, {fallow, 3}, {wheat, 1}, {stubble, 1}}},
    {.name = "autumn",
     .grass = {0.39f, 0.40f, 0.23f},
     .dry = {0.52f, 0.44f, 0.29f},
     .foliage = {0.33f, 0.32f, 0.16f},
     .conifer = {0.20f, 0.25f, 0.17f},
     .forest_floor = {0.40f, 0.29f, 0.18f},
     .soil = {0.39f, 0.31f, 0.24f},
     .dryness = 0.35f,
     .bare = 0.25f,
     .autumn = 0.45f,
     .conifers = 0.25f,
     .fields = {{brown_soil, 2}, {dark_soil, 2}, {stubble, 2}, {wheat, 1}, {fallow, 1}, {hay, 1}}},
    {.name = "winter",
     .grass = {0.36f, 0.37f, 0.25f},
     .dry = {0.48f, 0.42f, 0.31f},
     .foliage = {0.42f, 0.38f, 0.32f},
     .conifer = {0.17f, 0.22f, 0.16f},
     .forest_floor = {0.34f, 0.28f, 0.21f},
     .soil = {0.33f, 0.27f, 0.22f},
     .dryness = 0.4f,
     .bare = 0.97f,
     .conifers = 0.3f,
     .fields = {{brown_soil, 1}, {dark_soil, 3}, {fallow, 2}, {wheat, 2}, {grey_mud, 1}}},
    {.name = "humid",
     .grass = {0.36f, 0.43f, 0.26f},
     .dry = {0.50f, 0.47f, 0.34f},
     .foliage = {0.22f, 0.31f, 0.19f},
     .conifer = {0.15f, 0.24f, 0.18f},
     .forest_floor = {0.13f, 0.18f, 0.11f},
     .soil = {0.42f, 0.36f, 0.29f},
     .dryness = 0.2f,
     .conifers = 0.45f,
     .fields = {{rice, 3}, {ripe_rice, 1.5}, {bean, 1.5}, {dark_soil, 1}, {grey_mud, 1}, {fallow, 1}, {brown_soil, 1}}},
    {.name = "humid winter",
     .grass = {0.44f, 0.42f, 0.29f},
     .dry = {0.55f, 0.49f, 0.36f},
     .foliage = {0.25f, 0.29f, 0.19f},
     .conifer = {0.17f, 0.23f, 0.17f},
     .forest_floor = {0.25f, 0.22f, 0.16f},
     .soil = {0.45f, 0.39f, 0.33f},
     .dryness = 0.45f,
     .bare = 0.4f,
     .autumn = 0.12f,
     .conifers = 0.4f,
     .fields = {{grey_mud, 2}, {stubble, 1}, {fallow, 2}, {dark_soil, 1}, {brown_soil, 1}, {bean, 1}}},
};

// Weights in the order of Pavement: plain, new asphalt, old asphalt, concrete, setts, gravel, dirt.
const std::vector<Streets> streets_table{
    {.name = "european",
     .main = {0, 4, 3, 0, 0.2f, 0, 0},
     .street = {0, 3, 4, 0.3f, 1, 0.3f, 0},
     .minor = {0, 1, 2, 0.7f, 0.5f, 3, 1.5f},
     .new_asphalt = {0.30, 0.46},
     .old_asphalt = {0.52, 0.66},
     .concrete = {0.62, 0.76},
     .gravel = {0.64f, 0.60f, 0.53f},
     .dirt = {0.55f, 0.46f, 0.35f}},
    {.name = "baltic",
     .main = {0, 2, 5, 0, 0, 0, 0},
     .street = {0, 1.5f, 4, 0.3f, 0.5f, 4, 0.7f},
     .minor = {0, 0.5f, 2, 0.5f, 0.3f, 5, 3},
     .new_asphalt = {0.38, 0.50},
     .old_asphalt = {0.54, 0.68},
     .concrete = {0.64, 0.76},
     .gravel = {0.66f, 0.62f, 0.54f},
     .dirt = {0.60f, 0.52f, 0.40f}},
    {.name = "american",
     .main = {0, 3, 3, 3, 0, 0, 0},
     .street = {0, 2, 4, 5, 0, 0, 0},
     .minor = {0, 0.5f, 2, 3, 0, 4, 1.5f},
     .new_asphalt = {0.28, 0.42},
     .old_asphalt = {0.50, 0.66},
     .concrete = {0.62, 0.80},
     .gravel = {0.66f, 0.62f, 0.56f},
     .dirt = {0.56f, 0.47f, 0.37f},
     .yellow_center = true},
    {.name = "asian",
     .main = {0, 4, 3, 0.5f, 0, 0, 0},
     .street = {0, 3, 3, 4, 0, 0, 0},
     .minor = {0, 1, 1.5f, 5, 0, 1.5f, 1},
     .new_asphalt = {0.30, 0.44},
     .old_asphalt = {0.46, 0.60},
     .concrete = {0.58, 0.78},
     .gravel = {0.58f, 0.55f, 0.49f},
     .dirt = {0.50f, 0.43f, 0.34f}},
    {.name = "unpaved",
     .main = {0, 1, 5, 0.5f, 0, 0.5f, 0},
     .street = {0, 0.5f, 2, 1, 0.3f, 3, 4},
     .minor = {0, 0, 0.5f, 0.7f, 0, 3, 6},
     .new_asphalt = {0.34, 0.48},
     .old_asphalt = {0.52, 0.68},
     .concrete = {0.64, 0.78},
     .gravel = {0.66f, 0.60f, 0.50f},
     .dirt = {0.64f, 0.50f, 0.36f}},
};

const std::vector<Light> lights{
    {.name = "noon",
     .elevation_deg = {48.0, 64.0},
     .azimuth_deg = {140.0, 220.0},
     .sky = {0.28, 0.40},
     .haze = {0.0, 0.06},
     .contrast = {0.95, 1.2},
     .gain = {0.92, 1.12},
     .blur = {0.12, 0.28},
     .noise = {0.003, 0.010}},
    {.name = "low sun",
     .elevation_deg = {20.0, 32.0},
     .azimuth_deg = {118.0, 242.0},
     .sky = {0.26, 0.40},
     .haze = {0.0, 0.06},
     .contrast = {0.90, 1.12},
     .gain = {0.95, 1.2},
     .blur = {0.10, 0.28},
     .noise = {0.003, 0.010},
     .tint = {1.02f, 1.0f, 0.97f}},
    {.name = "spring morning",
     .elevation_deg = {28.0, 40.0},
     .azimuth_deg = {125.0, 235.0},
     .sky = {0.28, 0.40},
     .haze = {0.0, 0.05},
     .contrast = {0.88, 1.08},
     .gain = {1.0, 1.15},
     .blur = {0.10, 0.22},
     .noise = {0.003, 0.009},
     .tint = {1.0f, 1.0f, 0.94f}},
    {.name = "hard",
     .elevation_deg = {35.0, 58.0},
     .azimuth_deg = {120.0, 240.0},
     .sky = {0.20, 0.32},
     .haze = {0.0, 0.03},
     .contrast = {1.0, 1.2},
     .gain = {0.9, 1.15},
     .blur = {0.08, 0.24},
     .noise = {0.004, 0.012}},
    {.name = "haze",
     .elevation_deg = {38.0, 62.0},
     .azimuth_deg = {130.0, 230.0},
     .sky = {0.36, 0.52},
     .haze = {0.06, 0.22},
     .contrast = {0.85, 1.05},
     .gain = {0.92, 1.08},
     .blur = {0.22, 0.33},
     .noise = {0.003, 0.010},
     .haze_color = {0.72f, 0.78f, 0.80f}},
    {.name = "cool film",
     .elevation_deg = {36.0, 60.0},
     .azimuth_deg = {120.0, 240.0},
     .sky = {0.26, 0.42},
     .haze = {0.02, 0.16},
     .contrast = {0.85, 1.15},
     .gain = {0.9, 1.1},
     .blur = {0.2, 0.33},
     .noise = {0.005, 0.018},
     .haze_color = {0.30f, 0.48f, 0.50f},
     .tint = {0.90f, 1.02f, 1.04f}},
    {.name = "overcast",
     .elevation_deg = {40.0, 62.0},
     .azimuth_deg = {120.0, 240.0},
     .sky = {0.68, 0.85},
     .haze = {0.02, 0.10},
     .contrast = {0.85, 1.05},
     .gain = {0.85, 1.05},
     .blur = {0.18, 0.30},
     .noise = {0.004, 0.012},
     .haze_color = {0.80f, 0.84f, 0.88f}},
};

const std::vector<Roofs> roofs_table{
    {.name = "tiles",
     .tones = {{0.62f, 0.34f, 0.26f},
               {0.55f, 0.30f, 0.24f},
               {0.68f, 0.42f, 0.32f},
               {0.46f, 0.29f, 0.24f},
               {0.40f, 0.33f, 0.30f},
               {0.36f, 0.37f, 0.39f}},
     .flat = 0.08f},
    {.name = "nordic",
     .tones = {{0.27f, 0.28f, 0.30f},
               {0.35f, 0.36f, 0.39f},
               {0.42f, 0.45f, 0.50f},
               {0.46f, 0.28f, 0.22f},
               {0.62f, 0.22f, 0.16f},
               {0.50f, 0.52f, 0.53f},
               {0.33f, 0.42f, 0.36f},
               {0.58f, 0.62f, 0.68f}},
     .flat = 0.12f},
    {.name = "slate",
     .tones = {{0.30f, 0.31f, 0.34f},
               {0.36f, 0.37f, 0.40f},
               {0.42f, 0.42f, 0.44f},
               {0.48f, 0.36f, 0.30f},
               {0.58f, 0.40f, 0.32f},
               {0.62f, 0.48f, 0.38f}},
     .flat = 0.1f},
    {.name = "shingle",
     .tones = {{0.42f, 0.40f, 0.38f},
               {0.50f, 0.48f, 0.45f},
               {0.34f, 0.33f, 0.33f},
               {0.46f, 0.40f, 0.34f},
               {0.60f, 0.58f, 0.55f},
               {0.36f, 0.30f, 0.27f},
               {0.70f, 0.69f, 0.67f}},
     .flat = 0.06f},
    {.name = "asian",
     .tones = {{0.30f, 0.31f, 0.33f},
               {0.38f, 0.39f, 0.41f},
               {0.46f, 0.47f, 0.49f},
               {0.24f, 0.25f, 0.27f},
               {0.35f, 0.44f, 0.56f},
               {0.50f, 0.31f, 0.22f},
               {0.60f, 0.60f, 0.58f},
               {0.76f, 0.76f, 0.74f},
               {0.58f, 0.66f, 0.58f},
               {0.36f, 0.27f, 0.24f}},
     .flat = 0.25f},
    {.name = "flat",
     .tones = {{0.78f, 0.76f, 0.72f},
               {0.66f, 0.63f, 0.58f},
               {0.72f, 0.66f, 0.58f},
               {0.58f, 0.56f, 0.53f},
               {0.84f, 0.83f, 0.81f},
               {0.66f, 0.46f, 0.34f},
               {0.52f, 0.53f, 0.55f}},
     .flat = 0.75f},
    {.name = "sheet metal",
     .tones = {{0.62f, 0.64f, 0.66f},
               {0.54f, 0.52f, 0.50f},
               {0.48f, 0.36f, 0.30f},
               {0.38f, 0.46f, 0.58f},
               {0.66f, 0.28f, 0.22f},
               {0.46f, 0.54f, 0.46f},
               {0.76f, 0.76f, 0.76f}},
     .flat = 0.3f},
};

struct Recipe {
  const char *name, *season, *streets, *light, *roofs;
};
constexpr std::array recipes{
    Recipe{"baltic", "early spring", "baltic", "spring morning", "nordic"},
    Recipe{"japan", "humid", "asian", "hard", "asian"},
    Recipe{"japan_winter", "humid winter", "asian", "low sun", "asian"},
    Recipe{"japan_film", "humid", "asian", "cool film", "asian"},
    Recipe{"america", "summer", "american", "hard", "shingle"},
    Recipe{"america_fall", "autumn", "american", "low sun", "shingle"},
    Recipe{"prairie", "dry summer", "american", "low sun", "shingle"},
    Recipe{"france", "summer", "european", "noon", "slate"},
    Recipe{"bohemia", "autumn", "european", "low sun", "tiles"},
    Recipe{"winter", "winter", "european", "low sun", "tiles"},
    Recipe{"south", "dry summer", "unpaved", "hard", "flat"},
    Recipe{"himalaya", "humid winter", "unpaved", "haze", "flat"},
    Recipe{"overcast", "summer", "baltic", "overcast", "sheet metal"},
};
static_assert(std::ranges::equal(recipes, world_names, std::equal_to<std::string_view>(), &Recipe::name));

template <typename T>
const T& named(const std::vector<T>& table, std::string_view name) {
  return *std::find_if(table.begin(), table.end(), [&](const T& row) { return name == row.name; });
}

Pavement draw_pavement(const PavementWeights& weights, double draw) {
  float sum = 0.0f;
  for (const float w : weights) sum += w;
  auto left = static_cast<float>(draw) * sum;
  std::size_t last = 0;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    if (weights[i] <= 0.0f) continue;
    last = i;
    left -= weights[i];
    if (left < 0.0f) break;
  }
  return static_cast<Pavement>(last);
}

Pavement pavement_of_tag(std::string_view surface) {
  if (surface == "sett") return Pavement::setts;
  if (surface == "fine_gravel" || surface == "gravel") return Pavement::gravel;
  return Pavement::old_asphalt;
}
}  // namespace

const std::vector<FieldLook>& field_looks() {
  static const std::vector<FieldLook> looks{
      // in the order of Look
      {"wheat", {0.36f, 0.42f, 0.25f}, 1.2f, 0.03f, false},
      {"rape", {0.62f, 0.59f, 0.22f}, 1.2f, 0.02f, false},
      {"brown soil", {0.47f, 0.38f, 0.29f}, 2.4f, 0.07f, true},
      {"dark soil", {0.29f, 0.25f, 0.21f}, 1.6f, 0.06f, true},
      {"stubble", {0.64f, 0.56f, 0.40f}, 3.0f, 0.05f, true},
      {"maize", {0.29f, 0.36f, 0.21f}, 0.75f, 0.08f, false},
      {"hay", {0.38f, 0.44f, 0.25f}, 4.0f, 0.04f, false},
      {"fallow", {0.53f, 0.49f, 0.34f}, 3.5f, 0.03f, false},
      {"rice", {0.32f, 0.42f, 0.22f}, 0.6f, 0.04f, false},
      {"ripe rice", {0.56f, 0.52f, 0.27f}, 0.6f, 0.05f, false},
      {"bean", {0.26f, 0.36f, 0.20f}, 1.1f, 0.14f, false},
      {"red soil", {0.58f, 0.40f, 0.28f}, 2.0f, 0.06f, true},
      {"grey mud", {0.42f, 0.40f, 0.35f}, 1.0f, 0.06f, true},
  };
  return looks;
}

World make_world(std::string_view name, std::uint64_t seed) {
  if (name == "random") {
    Random random(derive_seed(seed, 21));
    const auto any = [&](const auto& table) { return &table[random.below(table.size())]; };
    return {"random", any(seasons), any(streets_table), any(lights), any(roofs_table)};
  }
  const auto it = std::find_if(recipes.begin(), recipes.end(), [&](const Recipe& r) { return name == r.name; });
  if (it == recipes.end())
    throw OptionError(
        fmt::format("there is no world '{}', need random or one of {}", name, fmt::join(world_names, ", ")));
  return {it->name, &named(seasons, it->season), &named(streets_table, it->streets), &named(lights, it->light),
          &named(roofs_table, it->roofs)};
}

void pave_roads(SitePlan& plan, const World& world, std::uint64_t seed) {
  Random random(derive_seed(seed, 22));
  for (PlannedRoad& road : plan.roads) {
    const int rank = road_rank(road.highway);
    const PavementWeights& weights = rank >= road_rank("tertiary")        ? world.streets->main
                                     : rank >= road_rank("living_street") ? world.streets->street
                                                                          : world.streets->minor;
    const Pavement drawn = draw_pavement(weights, random.uniform());
    if (!road.surface.empty()) {
      road.pavement = pavement_of_tag(road.surface);
    } else if (is_fast(road)) {
      road.pavement = random.uniform() < 0.5 ? Pavement::new_asphalt : Pavement::old_asphalt;
    } else {
      road.pavement = drawn;
    }
    if (road.surface.empty()) road.surface = surface_tag(road.pavement);
  }
}

void dress_objects(SiteObjects& objects, const World& world, std::uint64_t seed) {
  const auto key = static_cast<std::uint32_t>(derive_seed(seed, 23));
  const Season& season = *world.season;
  for (Tree& tree : objects.trees) {
    // Woods are of a kind: what stands together is drawn from a slow noise, what differs from the tree itself.
    const float grove = 0.5f + 0.5f * value_noise(tree.center.x / 60.0, tree.center.y / 60.0, key);
    const bool conifer =
        0.6f * grove + 0.4f * unit_hash(tree.id, 1, key) < 0.2f + 0.6f * season.conifers && tree.height_m > 2.0;
    if (conifer && !tree.conifer) tree.radius_m *= 0.8;
    tree.conifer = conifer;
    const float draw = unit_hash(tree.id, 2, key);
    tree.leaves = conifer                              ? Leaves::green
                  : draw < season.bare                 ? Leaves::bare
                  : draw < season.bare + season.autumn ? Leaves::autumn
                                                       : Leaves::green;
  }
  for (House& house : objects.houses) {
    if (house.roof == RoofShape::gable && house.half_width_m > 2.5 && unit_hash(house.id, 3, key) < world.roofs->flat)
      house.roof = RoofShape::flat;
    const auto& tones = world.roofs->tones;
    house.color = tones[hash_lattice(house.id, 4, key) % tones.size()];
    const float gain = 0.85f + 0.3f * unit_hash(house.id, 5, key);
    for (std::size_t i = 0; i < 3; ++i)
      house.color[i] =
          std::min(1.0f, house.color[i] * gain + 0.02f * signed_hash(house.id, 6 + static_cast<int>(i), key));
  }
}

const FieldLook& field_look(const World& world, std::uint16_t number) {
  float sum = 0.0f;
  for (const auto& [look, weight] : world.season->fields) sum += weight;
  float left = unit_hash(number, 5, 1234) * sum;
  for (const auto& [look, weight] : world.season->fields) {
    left -= weight;
    if (left < 0.0f) return field_looks()[static_cast<std::size_t>(look)];
  }
  return field_looks()[static_cast<std::size_t>(world.season->fields.back().first)];
}

const char* surface_tag(Pavement pavement) {
  switch (pavement) {
    case Pavement::concrete:
      return "concrete";
    case Pavement::setts:
      return "sett";
    case Pavement::gravel:
      return "gravel";
    case Pavement::dirt:
      return "dirt";
    case Pavement::plain:
    case Pavement::new_asphalt:
    case Pavement::old_asphalt:
      break;
  }
  return "asphalt";
}

}  // namespace orthodrive::synth
