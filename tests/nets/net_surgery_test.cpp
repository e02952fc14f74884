// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/nets/net_surgery.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/random.hpp"
#include "orthodrive/nets/fcn.hpp"
#include "orthodrive/nets/make_network.hpp"

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
  NetworkParams params = params_from_file(graph, start.file, "caffe");
  const at::Tensor image = at::rand({1, 3, 4, 4});
  const at::Tensor scores = forward_padded(graph, params, {image, {}}, {}).values;
  const float* pixels = image.data_ptr<float>();  // channel, row, column: Caffe's order
  for (int o = 0; o < 2; ++o) {
    double expected = o == 0 ? 0.5 : -0.5;
    for (int i = 0; i < 48; ++i) expected += matrix.values[static_cast<std::size_t>(o * 48 + i)] * pixels[i];
    EXPECT_NEAR(scores.flatten()[o].item<double>(), expected, 1e-4);
  }
}

TEST(NetSurgery, deconvolutions_start_as_interpolation) {
  const NetworkGraph graph = make_network("googlenet-16s", 2);
  NetworkParams params = params_from_file(graph, start_weights(graph, {}, 1).file, "start");
  const at::Tensor ramp = at::arange(8, at::kFloat).view({1, 1, 1, 8}).expand({1, 2, 8, 8}).contiguous();
  const at::Tensor up = at::conv_transpose2d(ramp, params.back().kernel, params.back().bias, 16);
  // Inside, twice the stride of taps: the ramp goes on with 1/16 a pixel, and classes do not mix.
  const at::Tensor row = up[0][1][64];
  for (int x = 40; x < 90; ++x) EXPECT_NEAR((row[x + 1] - row[x]).item<double>(), 1.0 / 16.0, 1e-5);
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
