// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/synth/paint/pavement.hpp"

#include <algorithm>
#include <cmath>

#include "orthodrive/core/noise.hpp"

namespace orthodrive::synth {
namespace {

class Paver {
 public:
  Paver(const PavedPlace& at, const Mood& mood, std::uint32_t seed) : at_(at), mood_(mood), seed_(seed + 500u) {}

  /// Fresh: dark and even, a seam between the lanes, now and then a paler stretch.
  [[nodiscard]] Rgb new_asphalt() const {
    float tone = mood_.new_asphalt + mood_.asphalt_spread * (trait(1) - 0.5f);
    tone *= 1.0f + 0.03f * fractal(11.0, 2, 3) + 0.03f * stones(0.17, 3) + wheels(0.03f, -0.02f);
    if (std::abs(at_.t_m) < 0.5 * line_m(0.12)) tone *= 0.93f;
    return {tone, tone * 1.0f, tone * 1.01f};
  }

  /// Patched, cracked and sealed; pale where wheels run.
  [[nodiscard]] Rgb old_asphalt() const {
    float tone = mood_.old_asphalt + mood_.asphalt_spread * (2.0f * trait(4) - 1.0f);
    tone +=
        0.7f * mood_.asphalt_spread * signed_hash(static_cast<int>(std::floor(at_.s_m / 90.0)), at_.road, seed_ + 5);
    tone *= 1.0f + 0.07f * fractal(8.0, 6, 4) + 0.04f * stones(0.2, 7) + wheels(0.05f, -0.06f);
    const int i = static_cast<int>(std::floor(at_.s_m / 6.0)), j = static_cast<int>(std::floor(at_.t_m / 2.4));
    const float patch = unit_hash(i, 64 * at_.road + j, seed_ + 8);
    if (patch < 0.10f) tone *= 0.72f + 2.0f * patch;  // repairs
    const float crack = std::abs(fractal(4.5, 9, 3));
    if (crack < 0.014f && noise(25.0, 10) > -0.2f) tone *= 0.72f;
    const float warm = 0.02f * trait(11);
    return {tone * (1.0f + warm), tone, tone * (1.0f - 1.6f * warm)};
  }

  /// Slabs with joints across and along, each with its own tone.
  [[nodiscard]] Rgb concrete() const {
    const double slab_m = 4.0 + 2.5 * trait(12);
    const bool two = at_.width_m > 5.0;
    const int i = static_cast<int>(std::floor(at_.s_m / slab_m)), j = two ? (at_.t_m > 0.0 ? 1 : 0) : 0;
    float tone = mood_.concrete + 0.08f * (trait(13) - 0.5f) + 0.035f * signed_hash(i, 2 * at_.road + j, seed_ + 14);
    tone *= 1.0f + 0.06f * fractal(5.0, 15, 4) + 0.025f * stones(0.3, 16) + wheels(-0.02f, -0.06f);
    const double across = std::abs(std::remainder(at_.s_m, slab_m));
    if (across < 0.5 * line_m(0.10) || (two && std::abs(at_.t_m) < 0.5 * line_m(0.10))) tone *= 0.84f;
    const float crack = std::abs(fractal(7.0, 17, 3));
    if (crack < 0.008f) tone *= 0.80f;
    return {tone, tone * 0.985f, tone * 0.95f};
  }

  /// Small stones in rows: mostly what is left of them in a photo, a speckle and stains.
  [[nodiscard]] Rgb setts() const {
    const float tone = (0.50f + 0.12f * (trait(18) - 0.5f)) *
                       (1.0f + 0.08f * stones(0.12, 19) + 0.05f * fractal(3.0, 20, 3) + 0.05f * fractal(14.0, 21, 2));
    const float red = 0.05f * trait(22);
    return {tone * (1.0f + red), tone, tone * (0.96f - red)};
  }

  [[nodiscard]] Rgb gravel() const {
    const float tone = 1.0f + 0.08f * fractal(5.0, 23, 4) + 0.06f * fractal(0.9, 24, 2) + 0.05f * stones(0.25, 25) +
                       0.10f * (trait(26) - 0.5f) + wheels(0.06f, 0.0f);
    return overgrown(scaled(mood_.gravel, tone), 0.25f * trait(27));
  }

  [[nodiscard]] Rgb dirt() const {
    const float wet = smoothstep(0.35f, 0.6f, fractal(6.0, 28, 3));  // puddles and their mud
    const float tone = 1.0f + 0.10f * fractal(4.0, 29, 4) + 0.06f * fractal(0.8, 30, 2) + 0.15f * (trait(31) - 0.5f) +
                       wheels(0.08f, -0.02f) - 0.22f * wet;
    return overgrown(scaled(mood_.dirt, tone), 0.2f + 0.7f * trait(32));
  }

 private:
  [[nodiscard]] static Rgb scaled(const Rgb& color, float k) { return {color[0] * k, color[1] * k, color[2] * k}; }
  [[nodiscard]] float trait(std::uint32_t layer) const { return unit_hash(at_.road, 78, seed_ + layer); }
  [[nodiscard]] float noise(double size_m, std::uint32_t layer) const {
    return value_noise(at_.p.x / size_m, at_.p.y / size_m, seed_ + layer);
  }
  [[nodiscard]] float fractal(double size_m, std::uint32_t layer, int octaves) const {
    return fractal_noise(at_.p.x / size_m, at_.p.y / size_m, seed_ + layer, octaves);
  }
  [[nodiscard]] float stones(double size_m, std::uint32_t layer) const {
    return signed_hash(static_cast<int>(std::floor(at_.p.x / size_m)), static_cast<int>(std::floor(at_.p.y / size_m)),
                       seed_ + layer);
  }
  /// A line is at least half a pixel wide, or it would vanish.
  [[nodiscard]] double line_m(double width_m) const { return std::max(width_m, 0.5 * at_.pixel_m); }
  /// Change of tone in the wheel tracks and between them.
  [[nodiscard]] float wheels(float track, float middle) const {
    const auto from_lane = static_cast<float>(std::abs(std::abs(at_.t_m) - at_.lane_m));
    return track * std::exp(-8.0f * (from_lane - 0.8f) * (from_lane - 0.8f)) +
           middle * std::exp(-6.0f * from_lane * from_lane);
  }
  /// Grass along the edges, and between the wheels of narrow ways.
  [[nodiscard]] Rgb overgrown(const Rgb& color, float share) const {
    const float ragged = 0.35f * fractal(1.4, 33, 3);
    float grass = smoothstep(-0.55f, 0.05f, at_.edge_m + ragged);
    if (at_.width_m < 4.3) {
      const auto off = static_cast<float>(std::abs(at_.t_m));
      grass = std::max(grass, share * smoothstep(0.55f, 0.25f, off + 0.4f * ragged) *
                                  smoothstep(-0.5f, 0.2f, noise(18.0, 34) + share - 0.3f));
    }
    Rgb out;
    const float tone = 1.0f + 0.08f * fractal(0.7, 35, 2);
    for (std::size_t i = 0; i < 3; ++i) {
      const float green = tone * (0.65f * mood_.grass[i] + 0.35f * mood_.dry[i]);
      out[i] = color[i] + 0.8f * grass * (green - color[i]);
    }
    return out;
  }

  const PavedPlace& at_;
  const Mood& mood_;
  std::uint32_t seed_;
};
}  // namespace

Rgb pavement_color(Pavement pavement, const PavedPlace& at, const Mood& mood, std::uint32_t seed) {
  const Paver paver(at, mood, seed);
  switch (pavement) {
    case Pavement::concrete:
      return paver.concrete();
    case Pavement::setts:
      return paver.setts();
    case Pavement::gravel:
      return paver.gravel();
    case Pavement::dirt:
      return paver.dirt();
    case Pavement::new_asphalt:
      return paver.new_asphalt();
    case Pavement::plain:
    case Pavement::old_asphalt:
      break;
  }
  return paver.old_asphalt();
}

}  // namespace orthodrive::synth
