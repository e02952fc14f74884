// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/synth/paint/mood.hpp"

#include <algorithm>
#include <array>
#include <numbers>

#include "orthodrive/core/random.hpp"

namespace orthodrive::synth {
namespace {
constexpr double degree = std::numbers::pi / 180.0;

Mood plain_mood(std::uint64_t seed) {
  Random random(derive_seed(seed, 4));
  const auto in = [&](double low, double high) { return static_cast<float>(random.uniform(low, high)); };
  Mood mood{};
  mood.sun_azimuth_rad = random.uniform(142.0, 218.0) * degree;
  mood.sun_elevation_rad = random.uniform(36.0, 60.0) * degree;
  const float sky = in(0.26, 0.40);
  mood.ambient = {sky * 0.92f, sky * 0.98f, sky * 1.10f};
  mood.direct = {1.03f - sky, 1.0f - sky, 0.95f - sky};
  mood.grass = {in(0.33, 0.43), in(0.41, 0.47), in(0.23, 0.29)};
  mood.foliage = {in(0.20, 0.30), in(0.29, 0.36), in(0.14, 0.20)};
  mood.asphalt = in(0.44, 0.60);
  mood.asphalt_spread = in(0.04, 0.09);
  mood.haze = in(0.0, 0.05);
  mood.contrast = in(0.95, 1.2);
  mood.gain = in(0.92, 1.12);
  mood.noise_sigma = in(0.004, 0.010);
  mood.tint = {in(0.97, 1.03), in(0.98, 1.02), in(0.95, 1.04)};
  mood.conifer = {mood.foliage[0] * 0.75f, mood.foliage[1] * 0.82f, mood.foliage[2] * 0.95f};
  mood.forest_floor = mood.foliage;
  mood.dry = {0.54f, 0.50f, 0.35f};
  mood.soil = {0.40f, 0.32f, 0.25f};
  mood.water = {0.14f, 0.20f, 0.20f};
  return mood;
}

// By eye: deep lakes, the sea, ponds with algae, rivers with mud, shallow clear water.
constexpr std::array<Rgb, 7> waters{{{0.07f, 0.11f, 0.11f},
                                     {0.06f, 0.12f, 0.17f},
                                     {0.16f, 0.21f, 0.13f},
                                     {0.34f, 0.30f, 0.22f},
                                     {0.22f, 0.32f, 0.34f},
                                     {0.12f, 0.17f, 0.12f},
                                     {0.27f, 0.29f, 0.26f}}};
}  // namespace

Mood make_mood(std::uint64_t seed, const World* world) {
  if (world == nullptr) return plain_mood(seed);
  const Season& season = *world->season;
  const Streets& streets = *world->streets;
  const Light& light = *world->light;
  Random random(derive_seed(seed, 24));
  const auto in = [&](Range range) { return static_cast<float>(random.uniform(range.low, range.high)); };
  // Each colour a little lighter or darker than its season's, and of another hue.
  const auto near = [&](const Rgb& color, double spread) {
    const auto gain = static_cast<float>(random.uniform(1.0 - spread, 1.0 + spread));
    Rgb out;
    for (std::size_t i = 0; i < 3; ++i)
      out[i] = color[i] * gain * static_cast<float>(random.uniform(1.0 - 0.4 * spread, 1.0 + 0.4 * spread));
    return out;
  };
  Mood mood{};
  mood.sun_azimuth_rad = random.uniform(light.azimuth_deg.low, light.azimuth_deg.high) * degree;
  mood.sun_elevation_rad = random.uniform(light.elevation_deg.low, light.elevation_deg.high) * degree;
  const float sky = in(light.sky), blue = in({0.02, 0.16});
  mood.ambient = {sky * (1.0f - blue), sky * (1.0f - 0.25f * blue), sky * (1.0f + 1.2f * blue)};
  mood.direct = {1.03f - sky, 1.0f - sky, 0.95f - sky};
  mood.grass = near(season.grass, 0.12);
  mood.dry = near(season.dry, 0.10);
  mood.foliage = near(season.foliage, 0.20);
  mood.conifer = near(season.conifer, 0.20);
  mood.forest_floor = near(season.forest_floor, 0.15);
  mood.soil = near(season.soil, 0.12);
  mood.water = near(waters[random.below(waters.size())], 0.15);
  mood.dryness = std::clamp(season.dryness + in({-0.12, 0.15}), 0.0f, 0.8f);
  mood.new_asphalt = in(streets.new_asphalt);
  mood.old_asphalt = in(streets.old_asphalt);
  mood.concrete = in(streets.concrete);
  mood.asphalt = 0.5f * (mood.new_asphalt + mood.old_asphalt);
  mood.asphalt_spread = in({0.03, 0.08});
  mood.gravel = near(streets.gravel, 0.10);
  mood.dirt = near(streets.dirt, 0.14);
  mood.yellow_center = streets.yellow_center;
  mood.paint = in({0.35, 1.0});
  mood.haze = in(light.haze);
  mood.contrast = in(light.contrast);
  mood.gain = in(light.gain);
  mood.blur = in(light.blur);
  mood.noise_sigma = in(light.noise);
  mood.haze_color = light.haze_color;
  for (std::size_t i = 0; i < 3; ++i) mood.tint[i] = light.tint[i] * in({0.97, 1.03});
  return mood;
}

}  // namespace orthodrive::synth
