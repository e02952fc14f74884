// SPDX-License-Identifier: Apache-2.0
#pragma once
// Noise as pure functions of place and seed: any pixel can be painted by any thread.

#include <cmath>
#include <cstdint>

namespace orthodrive {

/// 32 well mixed bits of a lattice point (the finaliser of MurmurHash3 over a linear combination).
[[nodiscard]] inline std::uint32_t hash_lattice(std::int32_t x, std::int32_t y, std::uint32_t seed) {
  std::uint32_t h =
      seed * 0x9e3779b9u + static_cast<std::uint32_t>(x) * 0x85ebca6bu + static_cast<std::uint32_t>(y) * 0xc2b2ae35u;
  h = (h ^ (h >> 16)) * 0x85ebca6bu;
  h = (h ^ (h >> 13)) * 0xc2b2ae35u;
  return h ^ (h >> 16);
}
/// Uniform in [-1, 1).
[[nodiscard]] inline float signed_hash(std::int32_t x, std::int32_t y, std::uint32_t seed) {
  return static_cast<float>(static_cast<std::int32_t>(hash_lattice(x, y, seed))) * (1.0f / 2147483648.0f);
}
/// Uniform in [0, 1).
[[nodiscard]] inline float unit_hash(std::int32_t x, std::int32_t y, std::uint32_t seed) {
  return static_cast<float>(hash_lattice(x, y, seed) >> 8) * (1.0f / 16777216.0f);
}

/// Value noise in [-1, 1] with lattice spacing 1, C1.
[[nodiscard]] inline float value_noise(double x, double y, std::uint32_t seed) {
  const double fx = std::floor(x), fy = std::floor(y);
  const auto ix = static_cast<std::int32_t>(fx), iy = static_cast<std::int32_t>(fy);
  const auto u = static_cast<float>(x - fx), v = static_cast<float>(y - fy);
  const float su = u * u * (3.0f - 2.0f * u), sv = v * v * (3.0f - 2.0f * v);
  const float a = signed_hash(ix, iy, seed), b = signed_hash(ix + 1, iy, seed);
  const float c = signed_hash(ix, iy + 1, seed), d = signed_hash(ix + 1, iy + 1, seed);
  return (a + su * (b - a)) * (1.0f - sv) + (c + su * (d - c)) * sv;
}

/// Two to four octaves of value noise, each of half the size and amplitude, about [-1, 1].
[[nodiscard]] inline float fractal_noise(double x, double y, std::uint32_t seed, int octaves) {
  float sum = 0.0f, amplitude = 0.6f;
  for (int i = 0; i < octaves; ++i, x *= 2.03, y *= 2.03, amplitude *= 0.5f)
    sum += amplitude * value_noise(x, y, seed + 1013u * static_cast<std::uint32_t>(i));
  return sum;
}

[[nodiscard]] inline float smoothstep(float low, float high, float x) {
  const float t = std::fmin(1.0f, std::fmax(0.0f, (x - low) / (high - low)));
  return t * t * (3.0f - 2.0f * t);
}

}  // namespace orthodrive
