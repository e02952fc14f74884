#include "orthodrive/segment/fcn.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/random.hpp"
#include "orthodrive/segment/allowed_class_loss.hpp"
#include "orthodrive/segment/allowed_classes.hpp"
#include "orthodrive/segment/class_probabilities.hpp"
#include "orthodrive/segment/make_network.hpp"
#include "orthodrive/segment/net_surgery.hpp"
#include "segment/shipped_model.hpp"

namespace orthodrive {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

std::vector<std::uint8_t> random_image(int width, int height, std::uint64_t seed) {
  Random random(seed);
  std::vector<std::uint8_t> rgb(static_cast<std::size_t>(3 * width * height));
  for (std::uint8_t& v : rgb) v = static_cast<std::uint8_t>(255.0 * random.uniform());
  return rgb;
}

NetworkParams random_params(const NetworkGraph& graph) {
  TensorFile file = start_weights(graph, {}, 3).file;
  Random random(4);
  for (auto& [name, tensor] : file.tensors)  // scores start at zero: give them something to say
    if (name.starts_with("score") || name.starts_with("head"))
      for (float& v : tensor.values) v = static_cast<float>(0.05 * random.normal());
  return params_from_file(graph, file, "random");
}

/// Padded at a border far away, a window without any padding sees the same: GoogLeNet has every kind of layer.
TEST(Forward, without_padding_equals_the_inside_of_a_padded_image) {
  for (const char* name : {"googlenet-8s", "mobilenetv2-s16-fpn2", "mobilenetv2-s32-fpn2"}) {
    const NetworkGraph graph = make_network(name, 4);
    NetworkParams params = random_params(graph);
    const int margin = receptive_field(graph).margin_px(), size = 32 * ((2 * margin + 64) / 32 + 1) + graph.size_remainder;
    const std::vector<std::uint8_t> rgb = random_image(size, size, 1);
    const at::Tensor image = image_tensor(graph.input, rgb.data(), 1, size, size);
    const at::NoGradGuard no_grad;
    const Scores padded = forward_padded(graph, params, image, {});
    const CellRange rows{margin + 3, margin + 40}, cols{margin + 8, margin + 21};
    const at::Tensor exact = forward_exact(graph, params, image, {{0, size - 1}, {0, size - 1}, rows, cols});
    const at::Tensor expected = padded.values.narrow(2, rows.first - padded.row_px.first, rows.size())
                                    .narrow(3, cols.first - padded.col_px.first, cols.size());
    EXPECT_LT((exact - expected).abs().max().item<double>(), 1e-4 * expected.abs().max().item<double>()) << name;
    EXPECT_GT(expected.std().item<double>(), 0.0) << name;
  }
}

TEST(InferenceNetwork, a_core_is_the_same_wherever_it_is_cut_from) {
  const NetworkGraph graph = make_network("googlenet-8s", 4);
  const InferenceNetwork network(graph, random_params(graph));
  const int margin = network.margin_px();
  const auto part = [&](std::int64_t col, std::int64_t row, int width, int height) {
    std::vector<std::uint8_t> rgb;  // a mosaic without end: every pixel from its own seed
    for (std::int64_t y = row - margin; y < row + height + margin; ++y)
      for (std::int64_t x = col - margin; x < col + width + margin; ++x)
        for (int c = 0; c < 3; ++c)
          rgb.push_back(static_cast<std::uint8_t>(derive_seed(derive_seed(static_cast<std::uint64_t>(y + 10000), static_cast<std::uint64_t>(x + 10000)), static_cast<std::uint64_t>(c)) >> 56));
    std::vector<float> scores(static_cast<std::size_t>(width * height * 4));
    network.predict(rgb.data(), {col, row, width, height}, 1, scores.data());
    return scores;
  };
  const std::vector<float> whole = part(-5, 100001, 40, 30), inner = part(12, 100010, 9, 7);
  double largest = 0.0;
  for (int y = 0; y < 7; ++y)
    for (int x = 0; x < 9; ++x)
      for (int c = 0; c < 4; ++c)
        largest = std::max(largest, std::abs(static_cast<double>(whole[static_cast<std::size_t>(((y + 9) * 40 + x + 17) * 4 + c)]) -
                                             inner[static_cast<std::size_t>((y * 9 + x) * 4 + c)]));
  EXPECT_LT(largest, 1e-4);
}

/// Pixels beyond the margin change nothing, those within it do.
TEST(InferenceNetwork, shipped_model_sees_as_far_as_its_margin) {
  const TensorFile file = shipped_tensors();
  const NetworkGraph graph = make_network("mobilenetv2-s32-fpn2", 8);
  const InferenceNetwork network(graph, params_from_file(graph, file, "default"));
  const int margin = network.margin_px(), size = 16 + 2 * margin;
  const PixelBox core{1600, 3200, 16, 16};
  std::vector<std::uint8_t> rgb = random_image(size, size, 2);
  const auto predict = [&] {
    std::vector<float> p(16 * 16 * 8);
    network.predict(rgb.data(), core, 1, p.data());
    return p;
  };
  const std::vector<float> before = predict();
  const auto disturb = [&](int ring) {  // the square ring that far outside the core
    for (int y = 0; y < size; ++y)
      for (int x = 0; x < size; ++x) {
        const int outside = std::max({margin - x, margin - y, x - margin - 15, y - margin - 15});
        if (outside == ring)
          for (int c = 0; c < 3; ++c) rgb[static_cast<std::size_t>(3 * (y * size + x) + c)] ^= 0xFF;
      }
  };
  for (int ring = 40; ring <= 60; ++ring) disturb(ring);
  EXPECT_NE(predict(), before);
}

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
  EXPECT_THAT([&] { static_cast<void>(start_weights(graph, wrong, 1)); }, ThrowsMessage<InputError>(HasSubstr("needs [3,3,3,64]")));
  EXPECT_THAT([&] { static_cast<void>(start_weights(graph, strangers, 1)); }, ThrowsMessage<InputError>(HasSubstr("none of its tensors fits")));
}

/// A classifier's fully connected layer, run at one place, and the convolution made of it agree.
TEST(NetSurgery, fully_connected_becomes_convolution) {
  NetworkGraph graph;
  graph.class_count = 2;
  graph.layers = {{.name = "fc6", .inputs = {image_input}, .in = 3, .out = 2, .kernel = 4, .kernel_tensor = "fc6/kernel"}};
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
  const at::Tensor scores = forward_padded(graph, params, image, {}).values;
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

// --- the loss

constexpr std::int64_t classes = 5;

at::Tensor random_scores(std::int64_t pixels, std::uint64_t seed) {
  Random random(seed);
  at::Tensor scores = at::empty({1, classes, 1, pixels});
  for (std::int64_t i = 0; i < scores.numel(); ++i) scores.data_ptr<float>()[i] = static_cast<float>(2.0 * random.normal());
  return scores;
}

at::Tensor sets(const std::vector<std::int64_t>& allowed) {
  return at::tensor(allowed).view({1, 1, static_cast<std::int64_t>(allowed.size())});
}

std::int64_t single(int label) { return static_cast<std::int64_t>(only(label)); }

TEST(AllowedClassLoss, single_classes_give_weighted_cross_entropy) {
  const at::Tensor scores = random_scores(4, 1);
  const std::vector<float> weights{1.0F, 2.0F, 0.5F, 1.0F, 3.0F};
  const std::vector<int> labels{1, 0, 4, 2};
  double expected = 0.0, total = 0.0;
  std::vector<std::int64_t> allowed;
  for (std::int64_t i = 0; i < 4; ++i) {
    const int label = labels[static_cast<std::size_t>(i)];
    const float weight = weights[static_cast<std::size_t>(label)];
    double sum = 0.0;
    for (std::int64_t c = 0; c < classes; ++c) sum += std::exp(scores[0][c][0][i].item<double>());
    expected += weight * (std::log(sum) - scores[0][label][0][i].item<double>());
    total += weight;
    allowed.push_back(single(label));
  }
  EXPECT_NEAR(allowed_class_loss(scores, sets(allowed), {weights}).loss, expected / total, 1e-6);
  EXPECT_NEAR(allowed_class_loss(scores, sets(allowed), {weights, 1.0F, true}).loss, expected, 1e-5);
  const at::Tensor p = at::softmax(scores, 1);
  double wrong = 0.0;
  for (std::size_t i = 0; i < allowed.size(); ++i) {
    const auto label = static_cast<std::int64_t>(std::countr_zero(static_cast<std::uint64_t>(allowed[i])));
    wrong += weights[static_cast<std::size_t>(label)] * (1.0 - p[0][label][0][static_cast<std::int64_t>(i)].item<double>());
  }
  EXPECT_NEAR(expected_error(p, sets(allowed), {weights}).loss, wrong / total, 1e-6);
}

TEST(AllowedClassLoss, everything_allowed_costs_nothing_and_unknown_does_not_count) {
  const at::Tensor scores = random_scores(3, 2);
  const std::vector<float> weights(classes, 1.0F);
  const std::int64_t all = (1 << classes) - 1;
  EXPECT_NEAR(allowed_class_loss(scores, sets({all, all, all}), {weights}).loss, 0.0, 1e-6);
  const LossGradient nothing = allowed_class_loss(scores, sets({0, 0, 0}), {weights});
  EXPECT_EQ(nothing.loss, 0.0);
  EXPECT_EQ(nothing.gradient.abs().max().item<float>(), 0.0F);
  const double one = allowed_class_loss(scores.narrow(3, 0, 1), sets({single(2)}), {weights}).loss;
  EXPECT_NEAR(allowed_class_loss(scores, sets({single(2), 0, 0}), {weights}).loss, one, 1e-6);
}

TEST(AllowedClassLoss, gradients_are_the_derivatives) {
  const at::Tensor scores = random_scores(6, 3);
  const at::Tensor allowed = sets({single(0), 0b01010, 0b10011, 0, single(4), 0b11110});
  const AllowedLossOptions options{{1.0F, 2.0F, 0.5F, 1.0F, 3.0F}, 0.7F};
  const at::Tensor gradient = allowed_class_loss(scores, allowed, options).gradient;
  at::Tensor probabilities = at::softmax(scores, 1).contiguous();
  const at::Tensor of_probabilities = expected_error(probabilities, allowed, options).gradient.contiguous();
  const auto slope = [](at::Tensor x, std::int64_t i, float step, const auto& loss) {
    float* value = x.data_ptr<float>() + i;
    const float before = *value;
    *value = before + step;
    const double above = loss();
    *value = before - step;
    const double below = loss();
    *value = before;
    return (above - below) / (2.0 * step);
  };
  for (std::int64_t i = 0; i < scores.numel(); ++i) {
    EXPECT_NEAR(gradient.flatten()[i].item<double>(),
                slope(scores, i, 1e-2F, [&] { return allowed_class_loss(scores, allowed, options).loss; }), 3e-5);
    const double p = probabilities.flatten()[i].item<double>(), expected = of_probabilities.flatten()[i].item<double>();
    const double measured = slope(probabilities, i, static_cast<float>(1e-2 * p), [&] {
      return expected_error(probabilities, allowed, options).loss;
    });
    EXPECT_NEAR(expected * p, measured * p, 3e-5);
  }
}

TEST(JaccardLoss, is_one_minus_the_mean_soft_iou_and_its_gradient_the_derivative) {
  const at::Tensor scores = random_scores(6, 5), allowed = sets({single(0), single(0), single(3), 0b01010, 0b00110, 0});
  const at::Tensor p = at::softmax(scores, 1);
  const auto of = [&](std::int64_t c, std::int64_t i) { return p[0][c][0][i].item<double>(); };
  // Class 0: pixels 0 and 1; the others are known not to be it, but for the unknown one. Class 3: pixel 2; pixel 3 may be.
  const double iou0 = (of(0, 0) + of(0, 1)) / (2.0 + of(0, 2) + of(0, 3) + of(0, 4));
  const double iou3 = of(3, 2) / (1.0 + of(3, 0) + of(3, 1) + of(3, 4));
  const LossGradient result = jaccard_loss(scores, allowed);
  EXPECT_NEAR(result.loss, 1.0 - 0.5 * (iou0 + iou3), 1e-6);
  for (std::int64_t i = 0; i < scores.numel(); ++i) {
    at::Tensor above = scores.clone(), below = scores.clone();
    above.data_ptr<float>()[i] += 1e-2F;
    below.data_ptr<float>()[i] -= 1e-2F;
    const double slope = (jaccard_loss(above, allowed).loss - jaccard_loss(below, allowed).loss) / 2e-2;
    EXPECT_NEAR(result.gradient.flatten()[i].item<double>(), slope, 3e-5);
  }
}

TEST(JaccardLoss, is_nought_for_sure_and_right_scores_and_for_sets_alone) {
  const at::Tensor sure = 50.0 * at::one_hot(at::tensor({0, 3, 1}, at::kLong), classes).t().reshape({1, classes, 1, 3}).to(at::kFloat);
  EXPECT_NEAR(jaccard_loss(sure, sets({single(0), single(3), single(1)})).loss, 0.0, 1e-6);
  const LossGradient nothing = jaccard_loss(random_scores(2, 6), sets({0b11000, 0}));
  EXPECT_EQ(nothing.loss, 0.0);
  EXPECT_EQ(nothing.gradient.abs().max().item<float>(), 0.0F);
}

TEST(AllowedClassLoss, scores_far_apart_stay_finite) {
  const at::Tensor scores = at::tensor({1000.0F, -1000.0F, 0.0F, 0.0F, 0.0F}).view({1, classes, 1, 1});
  const LossGradient result = allowed_class_loss(scores, sets({single(1)}), {std::vector<float>(classes, 1.0F)});
  EXPECT_NEAR(result.loss, 2000.0, 1.0);
  EXPECT_NEAR(result.gradient.flatten()[0].item<double>(), 1.0, 1e-6);
  EXPECT_NEAR(result.gradient.flatten()[1].item<double>(), -1.0, 1e-6);
}

TEST(ClassProbabilities, upsampling_and_softmax_agree_with_torch) {
  const at::Tensor cells = 4.0 * at::randn({1, 3, 9, 7}), memory = cells.permute({0, 2, 3, 1}).contiguous();
  for (const int factor : {1, 2, 4}) {
    const at::Tensor expected = at::softmax(at::upsample_bilinear2d(cells, {9 * factor, 7 * factor}, false), 1);
    // A part in the middle; the cells given begin at row 0, column 0.
    const int top = 2 * factor - 1, left = factor, rows = 5 * factor, cols = 4 * factor + 1;
    std::vector<float> result(static_cast<std::size_t>(rows * cols * 3));
    upsample_scores({memory.data_ptr<float>(), 7, 9, 3}, {top, 0, rows, factor}, {left, 0, cols, factor}, result.data());
    softmax_of_scores({result.data(), cols, rows, 3}, result.data());
    for (int y = 0; y < rows; ++y)
      for (int x = 0; x < cols; ++x)
        for (int c = 0; c < 3; ++c)
          EXPECT_NEAR(result[static_cast<std::size_t>((y * cols + x) * 3 + c)], expected[0][c][y + top][x + left].item<float>(), 2e-6);
  }
}

/// At twice the resolution a network of either kind gives its scores in between.
TEST(InferenceNetwork, finer_scores_are_interpolated) {
  for (const char* name : {"googlenet-8s", "mobilenetv2-s16-fpn2", "mobilenetv2-s32-fpn2"}) {
    const NetworkGraph graph = make_network(name, 4);
    const InferenceNetwork network(graph, random_params(graph));
    const int margin = network.margin_px(), rows = 7, cols = 12;
    const PixelBox core{33, 18, cols, rows}, around = core.grown(1);
    const int width = cols + 2 + 2 * margin, height = rows + 2 + 2 * margin;
    const std::vector<std::uint8_t> rgb = random_image(width, height, 5);
    std::vector<std::uint8_t> inner;
    for (int y = 1; y < height - 1; ++y)
      inner.insert(inner.end(), rgb.begin() + 3 * (y * width + 1), rgb.begin() + 3 * ((y + 1) * width - 1));
    std::vector<float> coarse(static_cast<std::size_t>(around.width * around.height * 4)), fine(static_cast<std::size_t>(4 * rows * cols * 4));
    network.predict(rgb.data(), around, 1, coarse.data());
    network.predict(inner.data(), core, 2, fine.data());
    double mean = 0.0;  // four fine pixels around a coarse one average to nearly it, whatever is interpolated
    for (int y = 0; y < 2 * rows; ++y)
      for (int x = 0; x < 2 * cols; ++x)
        for (int c = 0; c < 4; ++c) {
          const auto at = [&](int row, int col) { return coarse[static_cast<std::size_t>((row * around.width + col) * 4 + c)]; };
          const int row = (y + 1) / 2, col = (x + 1) / 2;  // the coarse pixel before, with the ring
          const float vertical = y % 2 == 0 ? 0.75F : 0.25F, horizontal = x % 2 == 0 ? 0.75F : 0.25F;
          const float upper = at(row, col) + horizontal * (at(row, col + 1) - at(row, col)),
                      lower = at(row + 1, col) + horizontal * (at(row + 1, col + 1) - at(row + 1, col));
          const float difference = fine[static_cast<std::size_t>((y * 2 * cols + x) * 4 + c)] - (upper + vertical * (lower - upper));
          if (std::string(name) == "googlenet-8s") {
            EXPECT_NEAR(difference, 0.0, 1e-4);
          }
          mean += std::abs(difference);
        }
    float largest = 0.0F;
    for (const float v : coarse) largest = std::max(largest, std::abs(v));
    EXPECT_LT(mean / static_cast<double>(fine.size()), 0.05 * largest) << name;
  }
}

}  // namespace
}  // namespace orthodrive
