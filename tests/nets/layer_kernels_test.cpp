// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/nets/layer_kernels.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "orthodrive/core/random.hpp"

namespace orthodrive {
namespace {

std::vector<float> random_values(std::size_t count, Random& random) {
  std::vector<float> values(count);
  for (float& v : values) v = static_cast<float>(random.normal());
  return values;
}

/// A sum in double precision, for every family of processors that this one can run.
TEST(LayerKernels, multiply_as_written) {
  Random random(2);
  for (const KernelFamily family : supported_kernel_families())
    for (const int out : {8, 16, 24, 32, 48, 56, 144})
      for (const std::size_t rows : {1U, 3U, 8U, 13U}) {
        const int in = 27;
        const std::size_t value_stride = 31, result_stride = static_cast<std::size_t>(out) + 8;
        const std::vector<float> values = random_values(rows * value_stride, random),
                                 matrix = random_values(static_cast<std::size_t>(in * out), random),
                                 bias = random_values(static_cast<std::size_t>(out), random),
                                 add = random_values(rows * static_cast<std::size_t>(out), random);
        std::vector<float> packed;
        for (int first = 0; first < out; first += 16)
          for (int i = 0; i < in; ++i)
            for (int k = first; k < std::min(first + 16, out); ++k)
              packed.push_back(matrix[static_cast<std::size_t>(i * out + k)]);
        std::vector<float> result(rows * result_stride, 99.0F);
        layer_kernels(family).product({rows,
                                       in,
                                       out,
                                       values.data(),
                                       value_stride,
                                       packed.data(),
                                       bias.data(),
                                       add.data(),
                                       static_cast<std::size_t>(out),
                                       {-3.0F, 4.0F},
                                       result.data(),
                                       result_stride});
        for (std::size_t r = 0; r < rows; ++r)
          for (std::size_t k = 0; k < result_stride; ++k) {
            if (k >= static_cast<std::size_t>(out)) {
              EXPECT_EQ(result[r * result_stride + k], 99.0F);
              continue;
            }
            double sum = bias[k] + add[r * static_cast<std::size_t>(out) + k];
            for (int i = 0; i < in; ++i)
              sum += static_cast<double>(values[r * value_stride + static_cast<std::size_t>(i)]) *
                     matrix[static_cast<std::size_t>(i) * static_cast<std::size_t>(out) + k];
            EXPECT_NEAR(result[r * result_stride + k], std::clamp(sum, -3.0, 4.0), 1e-5);
          }
      }
}

TEST(LayerKernels, filter_each_channel_by_itself) {
  Random random(2);
  for (const KernelFamily family : supported_kernel_families())
    for (const int channels : {8, 16, 24, 96})
      for (const int stride : {1, 2}) {
        constexpr std::size_t cells = 5;
        const auto n = static_cast<std::size_t>(channels);
        const std::size_t width = cells * static_cast<std::size_t>(stride) + 2;
        const std::vector<float> values = random_values(3 * width * n, random), weights = random_values(9 * n, random),
                                 bias = random_values(n, random);
        std::vector<float> result(cells * n);
        layer_kernels(family).depthwise({cells,
                                         channels,
                                         stride,
                                         {values.data(), &values[width * n], &values[2 * width * n]},
                                         weights.data(),
                                         bias.data(),
                                         {0.0F, 6.0F},
                                         result.data()});
        for (std::size_t o = 0; o < cells; ++o)
          for (std::size_t c = 0; c < n; ++c) {
            double sum = bias[c];
            for (std::size_t i = 0; i < 3; ++i)
              for (std::size_t j = 0; j < 3; ++j)
                sum += static_cast<double>(weights[(3 * i + j) * n + c]) *
                       values[(i * width + o * static_cast<std::size_t>(stride) + j) * n + c];
            EXPECT_NEAR(result[o * n + c], std::clamp(sum, 0.0, 6.0), 1e-5);
          }
      }
}

/// Everything a kernel gives, from values that a seed gives.
std::vector<float> results_of(const LayerKernels& kernels) {
  Random random(7);
  constexpr std::size_t rows = 13, in = 43, out = 56, cells = 5, channels = 24, classes = 11;
  std::vector<float> product(rows * out), filtered(cells * channels), mixed(53), along(7 * classes),
      softmax = random_values(cells * classes, random);
  const std::vector<float> values = random_values(rows * in, random), weights = random_values(in * out, random),
                           bias = random_values(out, random), add = random_values(rows * out, random);
  kernels.product({rows,
                   in,
                   out,
                   values.data(),
                   in,
                   weights.data(),
                   bias.data(),
                   add.data(),
                   out,
                   {-9.0F, 9.0F},
                   product.data(),
                   out});
  const std::vector<float> lines = random_values(3 * 12 * channels, random),
                           filter = random_values(9 * channels, random);
  kernels.depthwise({cells,
                     channels,
                     2,
                     {lines.data(), &lines[12 * channels], &lines[24 * channels]},
                     filter.data(),
                     bias.data(),
                     {0.0F, 6.0F},
                     filtered.data()});
  kernels.mix(values.data(), add.data(), 0.3F, mixed.size(), mixed.data());
  std::vector<MixTap> taps;
  for (std::size_t i = 0; i < 7; ++i) taps.push_back({i / 2, 0.1F + 0.13F * static_cast<float>(i)});
  kernels.mix_along(values.data(), taps.data(), taps.size(), 16, classes, along.data());
  kernels.softmax(softmax.data(), cells, classes, softmax.data());
  for (const std::vector<float>* more : {&filtered, &mixed, &along, &softmax})
    product.insert(product.end(), more->begin(), more->end());
  return product;
}

TEST(LayerKernels, give_the_same_bits_on_every_processor) {
  const std::vector<float> plain = results_of(layer_kernels(KernelFamily::plain));
  for (const KernelFamily family : supported_kernel_families())
    EXPECT_EQ(results_of(layer_kernels(family)), plain) << to_string(family);
}

}  // namespace
}  // namespace orthodrive
