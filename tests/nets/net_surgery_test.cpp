// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/nets/net_surgery.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/random.hpp"
#include "orthodrive/nets/make_network.hpp"
#include "orthodrive/nets/plain_layers.hpp"

namespace orthodrive {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

TEST(NetSurgery, takes_keras_and_thesis_names_and_reports_the_rest) {
  const NetworkGraph graph = make_network("vgg16-32s", 3);
  WeightsSource keras{"keras", {}};
  const auto put = [&](const std::string& name, std::vector<std::int64_t> shape) {
    std::int64_t count = 1;
    for (const auto n : shape) count *= n;
    keras.file.tensors[name] = {std::move(shape), std::vector<float>(static_cast<std::size_t>(count), 0.25F)};
  };
  put("block1_conv1/kernel", {3, 3, 3, 64});
  put("block1_conv1/bias", {64});
  put("score37/kernel", {1, 1, 4096, 38});
  put("score37/bias", {38});
  put("stranger/kernel", {1, 1, 1, 1});
  const std::vector<WeightsSource> sources{keras};
  const StartWeights start = start_weights(graph, sources, 1);
  const auto outcome = [&](const std::string& layer) {
    for (const SurgeryEntry& e : start.report.layers)
      if (e.layer == layer) return std::string(to_string(e.outcome));
    return std::string("absent");
  };
  EXPECT_EQ(outcome("conv1_1"), "taken");
  EXPECT_EQ(outcome("conv1_2"), "random");
  EXPECT_EQ(outcome("score"), "zero") << "38 classes there, 3 here";
  EXPECT_EQ(outcome("upsample_32"), "bilinear");
  EXPECT_FLOAT_EQ(start.file.tensors.at("conv1_1/kernel").values[5], 0.25F);
  const std::string report = format_report(start.report);
  EXPECT_THAT(report, HasSubstr("keras: block1_conv1"));
  EXPECT_THAT(report, HasSubstr("unused: keras: stranger/kernel"));
  put("block1_conv1/kernel", {3, 3, 3, 32});
  const std::vector<WeightsSource> wrong{keras}, strangers{{"s", {{}, {{"x/kernel", {{1}, {1.0F}}}}}}};
  EXPECT_THAT([&] { static_cast<void>(start_weights(graph, wrong, 1)); },
              ThrowsMessage<InputError>(HasSubstr("needs [3,3,3,64]")));
  EXPECT_THAT([&] { static_cast<void>(start_weights(graph, strangers, 1)); },
              ThrowsMessage<InputError>(HasSubstr("none of its tensors fits")));
}

/// A classifier's fully connected layer, run at one place, and the convolution made of it agree.
TEST(NetSurgery, fully_connected_becomes_convolution) {
  NetworkGraph graph;
  graph.class_count = 2;
  graph.layers = {
      {.name = "fc6", .inputs = {image_input}, .in = 3, .out = 2, .kernel = 4, .kernel_tensor = "fc6/kernel"}};
  WeightsSource caffe{"caffe", {}};
  Random random(7);
  NamedTensor matrix{{2, 48}, std::vector<float>(96)};
  for (float& v : matrix.values) v = static_cast<float>(random.normal());
  caffe.file.tensors["fc6/inner_product"] = matrix;
  caffe.file.tensors["fc6/bias"] = {{2}, {0.5F, -0.5F}};
  const std::vector<WeightsSource> sources{caffe};
  const StartWeights start = start_weights(graph, sources, 1);
  EXPECT_EQ(start.report.layers.at(0).outcome, SurgeryEntry::Outcome::converted);
  const std::vector<float>& kernel = start.file.tensors.at("fc6/kernel").values;  // row, column, channel, output
  for (int o = 0; o < 2; ++o)
    for (int channel = 0; channel < 3; ++channel)
      for (int pixel = 0; pixel < 16; ++pixel)  // Caffe's order: channel, row, column
        EXPECT_EQ(kernel[static_cast<std::size_t>((pixel * 3 + channel) * 2 + o)],
                  matrix.values[static_cast<std::size_t>(o * 48 + channel * 16 + pixel)]);
  EXPECT_EQ(start.file.tensors.at("fc6/bias").values, (std::vector<float>{0.5F, -0.5F}));
}

/// Inside, twice the stride of taps: a ramp goes on with 1/16 per pixel, and classes do not mix.
TEST(NetSurgery, deconvolutions_start_as_interpolation) {
  const NetworkGraph graph = make_network("googlenet-16s", 2);
  const TensorFile start = start_weights(graph, {}, 1).file;
  const Layer& layer = graph.layers.back();
  const PlainLayer made = make_plain_layer(
      layer, {start.tensors.at(layer.kernel_tensor).values, start.tensors.at(bias_tensor(layer)).values});
  std::vector<float> ramp;
  for (int i = 0; i < 64; ++i)
    for (int c = 0; c < cell_stride_of(2); ++c) ramp.push_back(c == 1 ? static_cast<float>(i % 8) : 0.0F);
  const CellRange eight{0, 7}, pixels{40, 90};
  const auto stride = static_cast<std::size_t>(cell_stride_of(2));
  Cells up{FloatBlock(51 * 51 * stride), pixels, pixels, 2, cell_stride_of(2)};
  run_plain(layer, made, {{ramp.data(), eight, eight, 2, stride, 8 * stride}}, up);
  const float* row = up.row(64);
  for (std::size_t x = 0; x < 50; ++x) {
    EXPECT_NEAR(row[(x + 1) * stride + 1] - row[x * stride + 1], 1.0 / 16.0, 1e-5);
    EXPECT_EQ(row[x * stride], 0.0F);
  }
}

TEST(NetSurgery, stages_hand_their_weights_on) {
  const NetworkGraph coarse = make_network("googlenet-32s", 2), fine = make_network("googlenet-16s", 2);
  const std::vector<WeightsSource> sources{{"googlenet-32s", start_weights(coarse, {}, 5).file}};
  const StartWeights start = start_weights(fine, sources, 6);
  int taken = 0, others = 0;
  for (const SurgeryEntry& e : start.report.layers) (e.outcome == SurgeryEntry::Outcome::taken ? taken : others)++;
  EXPECT_EQ(others, 3) << "upscore_16, score_pool3, upsample_16";
  EXPECT_EQ(taken, 58) << "57 convolutions and the score layer";
}

}  // namespace
}  // namespace orthodrive
