// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/pipeline/build/machine_speed.hpp"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <vector>

#include "orthodrive/core/parallel.hpp"
#include "orthodrive/core/random.hpp"

namespace orthodrive {
namespace {

constexpr int tries = 3;
constexpr std::size_t tile_px = 128, tile_passes = 150;        // 64 KB: stays in the cache
constexpr std::size_t picture_px = 2048, samples = 1'000'000;  // 16 MB: does not
constexpr std::size_t numbers = 300'000;

struct Work {
  std::vector<float> picture = std::vector<float>(picture_px * picture_px);
  Work() {
    Random random(1);
    for (float& value : picture) value = static_cast<float>(random.uniform());
  }
};

/// As a layer of a network: sums of 3 x 3 neighbours with weights.
float filter_tile(const std::vector<float>& picture) {
  std::vector<float> from(picture.begin(), picture.begin() + tile_px * tile_px), to = from;
  for (std::size_t pass = 0; pass < tile_passes; ++pass) {
    for (std::size_t y = 1; y + 1 < tile_px; ++y)
      for (std::size_t x = 1; x + 1 < tile_px; ++x) {
        const float* p = &from[y * tile_px + x];
        float sum = 0.0F;
        for (const std::ptrdiff_t row : {-1, 0, 1})
          for (const std::ptrdiff_t column : {-1, 0, 1})
            sum += p[row * static_cast<std::ptrdiff_t>(tile_px) + column] * (column == 0 ? 0.14F : 0.09F);
        to[y * tile_px + x] = sum;
      }
    std::swap(from, to);
  }
  return from[tile_px * tile_px / 2];
}

/// As what looks along roads: bilinear samples all over a raster.
float sample_picture(const std::vector<float>& picture) {
  Random random(2);
  float sum = 0.0F;
  for (std::size_t i = 0; i < samples; ++i) {
    const double x = random.uniform(0.0, picture_px - 1.001), y = random.uniform(0.0, picture_px - 1.001);
    const auto column = static_cast<std::size_t>(x), row = static_cast<std::size_t>(y);
    const auto s = static_cast<float>(x - static_cast<double>(column));
    const auto t = static_cast<float>(y - static_cast<double>(row));
    const float* p = &picture[row * picture_px + column];
    sum += (1 - t) * ((1 - s) * p[0] + s * p[1]) + t * ((1 - s) * p[picture_px] + s * p[picture_px + 1]);
  }
  return sum;
}

double sort_numbers() {
  Random random(3);
  std::vector<double> values(numbers);
  for (double& value : values) value = random.uniform();
  std::sort(values.begin(), values.end());
  return values[numbers / 2];
}

/// Seconds until `count` threads have done one piece each, the least of some tries.
double seconds_of(const Work& work, int count) {
  double least_s = 0.0;
  std::vector<double> results(static_cast<std::size_t>(count));
  volatile double kept = 0.0;  // so that the work is done
  for (int i = 0; i < tries; ++i) {
    const auto start = std::chrono::steady_clock::now();
    parallel_for(results.size(), count, [&](std::size_t piece) {
      results[piece] = filter_tile(work.picture) + sample_picture(work.picture) + sort_numbers();
    });
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    for (const double result : results) kept = kept + result;
    if (i == 0 || seconds < least_s) least_s = seconds;
  }
  return least_s;
}
}  // namespace

MachineSpeed measure_machine_speed(int threads) {
  const Work work;
  const int count = worker_count(threads);
  return {.seconds_of_one = seconds_of(work, 1), .seconds_of_all = seconds_of(work, count), .threads = count};
}

}  // namespace orthodrive
