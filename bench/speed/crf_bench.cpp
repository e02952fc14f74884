// SPDX-License-Identifier: Apache-2.0
// Dense CRF, megapixels a second: two windows of 1024 x 1024 px on two threads (as segment_mosaic would), lattices
// built and ten mean-field iterations with both kernels. How many lattice vertices there are depends on the photo; set
// ORTHODRIVE_BENCH_PPM to a real one (gdal_translate -of PNM -srcwin ... photo.tif photo.ppm, at least 2048 x 1024 px),
// else a painted one serves: smooth patches of colour, texture and noise.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

#include "orthodrive/core/parallel.hpp"
#include "orthodrive/core/random.hpp"
#include "orthodrive/crf/dense_crf.hpp"

namespace {

using namespace orthodrive;

constexpr int side = 1024, windows = 2;

using Window = std::vector<std::uint8_t>;  // side x side x 3

/// Bilinear value noise with the given cell size.
double noise(std::uint64_t seed, double x, double y, double cell) {
  const auto corner = [&](double cx, double cy) {
    const auto place = static_cast<std::uint64_t>(cx) * 65536 + static_cast<std::uint64_t>(cy);
    return static_cast<double>(splitmix64(seed ^ splitmix64(place)) >> 11) * 0x1p-53;
  };
  const double u = x / cell, v = y / cell, cx = std::floor(u), cy = std::floor(v), fx = u - cx, fy = v - cy;
  return (corner(cx, cy) * (1 - fx) + corner(cx + 1, cy) * fx) * (1 - fy) +
         (corner(cx, cy + 1) * (1 - fx) + corner(cx + 1, cy + 1) * fx) * fy;
}

Window paint(int number) {
  Random random(static_cast<std::uint64_t>(number));
  Window rgb;
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      const double patch = std::floor(6.0 * noise(7, x + side * number, y, 90.0));
      const double light = 40.0 * noise(8, x + side * number, y, 12.0) + 25.0 * noise(9, x + side * number, y, 3.0);
      for (int channel = 0; channel < 3; ++channel) {
        const double tint = static_cast<double>(splitmix64(static_cast<std::uint64_t>(patch) * 3 + channel) % 120);
        rgb.push_back(static_cast<std::uint8_t>(std::clamp(20.0 + tint + light + 3.0 * random.normal(), 0.0, 255.0)));
      }
    }
  return rgb;
}

std::vector<Window> read_ppm(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string magic;
  std::size_t width = 0, height = 0, top = 0;
  file >> magic >> width >> height >> top;
  file.get();
  if (!file || magic != "P6" || top != 255 || width < windows * side || height < side) return {};
  std::vector<Window> result(windows, Window(std::size_t{side} * side * 3));
  std::vector<std::uint8_t> line(width * 3);
  for (std::size_t y = 0; y < side; ++y) {
    file.read(reinterpret_cast<char*>(line.data()), static_cast<std::streamsize>(line.size()));
    for (std::size_t w = 0; w < windows; ++w)
      std::copy_n(&line[w * side * 3], std::size_t{side} * 3, &result[w][y * side * 3]);
  }
  return file ? result : std::vector<Window>{};
}

const std::vector<Window>& photo() {
  static const std::vector<Window> result = [] {
    if (const char* path = std::getenv("ORTHODRIVE_BENCH_PPM")) return read_ppm(path);
    std::vector<Window> painted;
    painted.reserve(windows);
    for (int w = 0; w < windows; ++w) painted.push_back(paint(w));
    return painted;
  }();
  return result;
}

/// A classifier that goes by colour and errs a lot.
std::vector<float> make_unary(const Window& rgb, int classes) {
  Random random(1);
  std::vector<float> unary;
  unary.reserve(rgb.size() / 3 * static_cast<std::size_t>(classes));
  for (std::size_t i = 0; i < rgb.size(); i += 3) {
    const int label = (rgb[i] / 32 + rgb[i + 1] / 64) % classes;
    const auto noise_bits = random.next();
    for (int c = 0; c < classes; ++c)
      unary.push_back((c == label ? 1.0F : 2.5F) + static_cast<float>((noise_bits >> c) & 15) * 0.1F);
  }
  return unary;
}

const CrfWidths widths_of[] = {{13.5, 11.0, 1.75}, {80.0, 13.0, 3.0}};

/// Arguments: classes, index into widths_of.
void two_windows(benchmark::State& state) {
  const auto classes = static_cast<int>(state.range(0));
  const CrfWidths& widths = widths_of[state.range(1)];
  if (photo().empty()) return state.SkipWithError("ORTHODRIVE_BENCH_PPM is not a P6 file of 2048 x 1024 px or more");
  std::vector<std::vector<float>> unary, marginals;
  for (const Window& window : photo()) {
    unary.push_back(make_unary(window, classes));
    marginals.emplace_back(unary.back().size());
  }
  const CrfParameters parameters = potts_crf(classes, 5.2F, 1.5F, 10);
  std::vector<CrfWorkspace> workspaces(windows);
  std::size_t vertices = 0;
  for (auto _ : state) {
    parallel_for(windows, windows, [&](std::size_t w) {
      const CrfImage image{side, side, static_cast<std::int64_t>(w) * side, 0, photo()[w].data(), nullptr};
      const DenseCrf crf(image, widths);
      crf.infer(parameters, unary[w], marginals[w], &workspaces[w]);
      if (w == 0) vertices = crf.appearance().vertices();
    });
  }
  state.SetItemsProcessed(state.iterations() * windows * side * side);
  state.counters["vertices_per_px"] = static_cast<double>(vertices) / (side * side);
}
BENCHMARK(two_windows)
    ->Name("dense_crf/two_windows")
    ->ArgNames({"classes", "widths"})
    ->Args({8, 0})
    ->Args({8, 1})
    ->Args({38, 0})
    ->Args({38, 1})
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

void build_lattices(benchmark::State& state) {
  if (photo().empty()) return state.SkipWithError("ORTHODRIVE_BENCH_PPM is not a P6 file of 2048 x 1024 px or more");
  const CrfImage image{side, side, 0, 0, photo()[0].data(), nullptr};
  for (auto _ : state) benchmark::DoNotOptimize(DenseCrf(image, widths_of[state.range(0)]));
  state.SetItemsProcessed(state.iterations() * side * side);
}
BENCHMARK(build_lattices)->Name("dense_crf/build")->ArgName("widths")->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);

}  // namespace
