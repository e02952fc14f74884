// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/models/caffe_model.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

#include "caffe_net.pb.h"
#include "orthodrive/core/error.hpp"
#include "orthodrive/io/models/safetensors.hpp"

namespace orthodrive {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;
using Shape = std::vector<std::int64_t>;

/// Values 1, 2, 3 ... times `step`.
void fill(caffe::BlobProto* blob, const Shape& shape, float step = 1.0F) {
  std::int64_t count = 1;
  for (const std::int64_t n : shape) {
    blob->mutable_shape()->add_dim(n);
    count *= n;
  }
  for (std::int64_t i = 1; i <= count; ++i) blob->add_data(step * static_cast<float>(i));
}

/// The shape as files before 2015 say it.
void fill_old(caffe::BlobProto* blob, int num, int channels, int height, int width) {
  blob->set_num(num), blob->set_channels(channels), blob->set_height(height), blob->set_width(width);
  for (int i = 1; i <= num * channels * height * width; ++i) blob->add_data(static_cast<float>(i));
}

caffe::LayerParameter* add_layer(caffe::NetParameter& net, const char* name, const char* type) {
  caffe::LayerParameter* layer = net.add_layer();
  layer->set_name(name), layer->set_type(type);
  return layer;
}

caffe::NetParameter small_net() {
  caffe::NetParameter net;
  net.set_name("small");
  add_layer(net, "data", "Input");
  auto* conv = add_layer(net, "inception_3a/3x3", "Convolution");
  fill(conv->add_blobs(), {4, 2, 3, 3});
  fill(conv->add_blobs(), {4}, 10.0F);
  add_layer(net, "relu", "ReLU");
  auto* fc = add_layer(net, "fc", "InnerProduct");
  fill(fc->add_blobs(), {2, 5});
  fill(fc->add_blobs(), {2}, -1.0F);
  return net;
}

TensorFile parse(const caffe::NetParameter& net) {
  return parse_caffe_model(net.SerializeAsString(), "net.caffemodel");
}

TEST(CaffeModel, convolution_is_transposed_and_inner_product_kept) {
  const TensorFile file = parse(small_net());
  ASSERT_EQ(file.tensors.size(), 4u);
  const NamedTensor& kernel = file.tensors.at("inception_3a/3x3/kernel");
  EXPECT_EQ(kernel.shape, (Shape{3, 3, 2, 4}));
  for (int o = 0; o < 4; ++o) {
    for (int i = 0; i < 2; ++i) {
      for (int y = 0; y < 3; ++y) {
        for (int x = 0; x < 3; ++x) {
          const auto ours = static_cast<std::size_t>(((y * 3 + x) * 2 + i) * 4 + o);
          EXPECT_EQ(kernel.values.at(ours), static_cast<float>(1 + ((o * 2 + i) * 3 + y) * 3 + x));
        }
      }
    }
  }
  EXPECT_THAT(file.tensors.at("inception_3a/3x3/bias").values, ElementsAre(10, 20, 30, 40));
  EXPECT_EQ(file.tensors.at("fc/inner_product").shape, (Shape{2, 5}));
  EXPECT_THAT(file.tensors.at("fc/inner_product").values, ElementsAre(1, 2, 3, 4, 5, 6, 7, 8, 9, 10));
  EXPECT_THAT(file.tensors.at("fc/bias").values, ElementsAre(-1, -2));
  EXPECT_EQ(file.metadata.at("inception_3a/3x3/type"), "Convolution");
  EXPECT_EQ(file.metadata.at("fc/type"), "InnerProduct");
  EXPECT_EQ(file.metadata.at("network"), "small");
  EXPECT_FALSE(file.metadata.contains("fc/group"));
  EXPECT_FALSE(file.metadata.contains("relu/type"));  // no weights
}

TEST(CaffeModel, old_layers_give_the_same_tensors) {
  caffe::NetParameter net;
  net.set_name("small");
  auto* conv = net.add_layers();
  conv->set_name("inception_3a/3x3"), conv->set_type(4);
  fill_old(conv->add_blobs(), 4, 2, 3, 3);
  fill(conv->add_blobs(), {1, 1, 1, 4}, 10.0F);
  net.add_layers()->set_type(18);  // ReLU, without a name
  auto* fc = net.add_layers();
  fc->set_name("fc"), fc->set_type(14);
  fill_old(fc->add_blobs(), 1, 1, 2, 5);
  fill(fc->add_blobs(), {1, 1, 1, 2}, -1.0F);
  EXPECT_EQ(format_safetensors(parse(net)), format_safetensors(parse(small_net())));
}

// One output of a 1 x 1 x 1 x O blob must not lose its axis: 1x1x1x1 is [1].
TEST(CaffeModel, a_single_output_keeps_its_axis) {
  caffe::NetParameter net;
  auto* conv = net.add_layers();
  conv->set_name("c"), conv->set_type(4);
  fill_old(conv->add_blobs(), 1, 1, 1, 1);
  fill_old(conv->add_blobs(), 1, 1, 1, 1);
  const TensorFile file = parse(net);
  EXPECT_EQ(file.tensors.at("c/kernel").shape, (Shape{1, 1, 1, 1}));
  EXPECT_EQ(file.tensors.at("c/bias").shape, Shape{1});
}

TEST(CaffeModel, deconvolutions_and_groups_are_marked) {
  caffe::NetParameter net;
  auto* up = add_layer(net, "up", "Deconvolution");
  fill(up->add_blobs(), {3, 1, 2, 2});  // I x O/G x H x W: bilinear, each channel for itself
  up->mutable_convolution_param()->set_group(3);
  auto* halves = add_layer(net, "conv2", "Convolution");  // as in AlexNet
  fill(halves->add_blobs(), {4, 3, 1, 1});
  halves->mutable_convolution_param()->set_group(2);
  auto* depthwise = add_layer(net, "dw", "Convolution");
  fill(depthwise->add_blobs(), {3, 1, 2, 1});
  depthwise->mutable_convolution_param()->set_group(3);
  const TensorFile file = parse(net);
  EXPECT_EQ(file.tensors.at("up/transposed_kernel").shape, (Shape{2, 2, 1, 3}));
  EXPECT_THAT(file.tensors.at("up/transposed_kernel").values, ElementsAre(1, 5, 9, 2, 6, 10, 3, 7, 11, 4, 8, 12));
  EXPECT_EQ(file.metadata.at("up/group"), "3");
  EXPECT_EQ(file.metadata.at("up/type"), "Deconvolution");
  EXPECT_EQ(file.tensors.at("conv2/kernel").shape, (Shape{1, 1, 3, 4}));
  EXPECT_EQ(file.metadata.at("conv2/group"), "2");
  EXPECT_EQ(file.tensors.at("dw/depthwise_kernel").shape, (Shape{2, 1, 3, 1}));
  EXPECT_THAT(file.tensors.at("dw/depthwise_kernel").values, ElementsAre(1, 3, 5, 2, 4, 6));
}

TEST(CaffeModel, batch_norm_is_divided_by_its_factor) {
  caffe::NetParameter net;
  auto* norm = add_layer(net, "bn", "BatchNorm");
  fill(norm->add_blobs(), {2});
  fill(norm->add_blobs(), {2}, 2.0F);
  fill(norm->add_blobs(), {1}, 4.0F);
  auto* scale = add_layer(net, "scale", "Scale");
  fill(scale->add_blobs(), {2});
  fill(scale->add_blobs(), {2}, 3.0F);
  fill(add_layer(net, "odd", "PReLU")->add_blobs(), {2, 1});
  const TensorFile file = parse(net);
  EXPECT_THAT(file.tensors.at("bn/moving_mean").values, ElementsAre(0.25F, 0.5F));
  EXPECT_THAT(file.tensors.at("bn/moving_variance").values, ElementsAre(0.5F, 1.0F));
  EXPECT_THAT(file.tensors.at("scale/gamma").values, ElementsAre(1, 2));
  EXPECT_THAT(file.tensors.at("scale/beta").values, ElementsAre(3, 6));
  EXPECT_EQ(file.tensors.at("odd/blob0").shape, (Shape{2, 1}));
}

TEST(CaffeModel, doubles_and_unknown_fields_are_read_over) {
  caffe::NetParameter net;
  auto* fc = add_layer(net, "fc", "InnerProduct")->add_blobs();
  fc->mutable_shape()->add_dim(1), fc->mutable_shape()->add_dim(2);
  fc->add_double_data(0.5), fc->add_double_data(-1.25);
  net.mutable_unknown_fields()->AddLengthDelimited(3, "input: data");  // NetParameter.input
  net.mutable_unknown_fields()->AddVarint(5, 1);                       // force_backward
  net.mutable_layer(0)->mutable_unknown_fields()->AddLengthDelimited(3, "bottom");
  EXPECT_THAT(parse(net).tensors.at("fc/inner_product").values, ElementsAre(0.5F, -1.25F));
}

// Protobuf refuses messages above 64 MB (in old versions) unless told not to; VGG16 has 553 MB, its fc6 alone 411 MB.
TEST(CaffeModel, a_layer_of_more_than_64_megabytes_is_read_from_a_stream) {
  caffe::NetParameter net;
  auto* data = add_layer(net, "fc6", "InnerProduct")->add_blobs();
  data->mutable_shape()->add_dim(17), data->mutable_shape()->add_dim(1 << 20);
  data->mutable_data()->Resize(17 << 20, 0.5F);
  data->set_data((17 << 20) - 1, 2.0F);
  std::stringstream stream;
  ASSERT_TRUE(net.SerializeToOstream(&stream));
  net.Clear();
  const TensorFile file = read_caffe_model(stream, "big");
  EXPECT_EQ(file.tensors.at("fc6/inner_product").values.size(), 17u << 20);
  EXPECT_EQ(file.tensors.at("fc6/inner_product").values.back(), 2.0F);
}

/// The end of each layer: a file cut there is a valid, shorter net, as protobuf knows no total length.
std::vector<std::size_t> layer_ends(caffe::NetParameter net) {
  std::vector<std::size_t> ends;
  while (net.layer_size() > 0) {
    ends.push_back(net.ByteSizeLong());
    net.mutable_layer()->RemoveLast();
  }
  return ends;
}

TEST(CaffeModel, truncated_inside_a_layer_is_an_input_error) {
  const std::string bytes = small_net().SerializeAsString();
  const std::vector<std::size_t> ends = layer_ends(small_net());
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    if (std::find(ends.begin(), ends.end() - 1, length) != ends.end() - 1) continue;  // with weights, see above
    std::istringstream stream(bytes.substr(0, length));
    EXPECT_THROW(static_cast<void>(parse_caffe_model(bytes.substr(0, length), "x")), InputError) << length;
    EXPECT_THROW(static_cast<void>(read_caffe_model(stream, "x")), InputError) << length;
  }
}

TEST(CaffeModel, other_files_are_refused_by_name) {
  const auto parsing = [](const std::string& bytes) {
    return [bytes] { static_cast<void>(parse_caffe_model(bytes, "x.caffemodel")); };
  };
  const auto message = [](const char* text) { return ThrowsMessage<InputError>(HasSubstr(text)); };
  EXPECT_THAT(parsing("\x89PNG\r\n\x1a\n and so on"), message("x.caffemodel: not a usable Caffe model"));
  EXPECT_THAT(parsing("name: \"VGG16\"\nlayer { name: \"conv1\" }\n"), message("x.caffemodel: not a usable"));
  EXPECT_THAT(parsing("<!DOCTYPE html><html>404</html>"), message("x.caffemodel: not a usable"));
  EXPECT_THAT(parsing(std::string("\x89HDF\r\n\x1a\n\0\0", 10)), message("x.caffemodel: not a usable"));
  EXPECT_THAT(parsing(""), message("no layer has weights"));
  EXPECT_THAT(parsing(std::string(100, '\xff')), message("no protobuf"));
  caffe::NetParameter empty;
  add_layer(empty, "data", "Input");
  EXPECT_THAT(parsing(empty.SerializeAsString()), message("no layer has weights"));
  caffe::NetParameter v0;
  v0.add_layers()->set_layer("V0 layer");
  EXPECT_THAT(parsing(v0.SerializeAsString()), message("upgrade_net_proto_binary"));
}

TEST(CaffeModel, blobs_that_do_not_fit_name_their_layer) {
  const auto refused = [](const char* type, const std::vector<Shape>& shapes, const char* text, int group = 1) {
    caffe::NetParameter net;
    auto* layer = add_layer(net, "conv5", type);
    for (const Shape& shape : shapes) fill(layer->add_blobs(), shape);
    if (group != 1) layer->mutable_convolution_param()->set_group(static_cast<std::uint32_t>(group));
    EXPECT_THAT([&] { static_cast<void>(parse(net)); }, ThrowsMessage<InputError>(HasSubstr(text))) << text;
    EXPECT_THAT([&] { static_cast<void>(parse(net)); }, ThrowsMessage<InputError>(HasSubstr("'conv5'"))) << text;
  };
  refused("Convolution", {{2, 2, 3}}, "3 axes where 4");
  refused("InnerProduct", {{2, 1, 2}}, "3 axes where 2");
  refused("Convolution", {{2, 1, 1, 1}, {2, 1}}, "2 axes where 1");
  refused("Convolution", {{3, 1, 1, 1}}, "2 groups", 2);
  refused("Convolution", {{3, 1, 1, 1}}, "0 groups", 0);
  refused("BatchNorm", {{2}, {2}}, "factor");
  refused("InnerProduct", {{1, 1}, {1}, {1}}, "more than two blobs");

  caffe::NetParameter short_data = small_net();
  short_data.mutable_layer(1)->mutable_blobs(0)->mutable_data()->RemoveLast();
  EXPECT_THAT([&] { static_cast<void>(parse(short_data)); },
              ThrowsMessage<InputError>(HasSubstr("'inception_3a/3x3': a blob of 72 numbers holds 71")));
  caffe::NetParameter huge = small_net();  // 2^31 * 2^31 ... wraps around to the right number of values
  for (auto& dim : *huge.mutable_layer(1)->mutable_blobs(0)->mutable_shape()->mutable_dim()) dim = 1LL << 31;
  EXPECT_THAT([&] { static_cast<void>(parse(huge)); }, ThrowsMessage<InputError>(HasSubstr("impossible shape")));
  caffe::NetParameter twice = small_net();
  twice.mutable_layer(1)->set_name("fc"), twice.mutable_layer(1)->set_type("InnerProduct");
  twice.mutable_layer(1)->mutable_blobs(0)->mutable_shape()->Clear();
  twice.mutable_layer(1)->mutable_blobs(0)->mutable_shape()->add_dim(8);
  twice.mutable_layer(1)->mutable_blobs(0)->mutable_shape()->add_dim(9);
  EXPECT_THAT([&] { static_cast<void>(parse(twice)); }, ThrowsMessage<InputError>(HasSubstr("there twice")));
}

}  // namespace
}  // namespace orthodrive
