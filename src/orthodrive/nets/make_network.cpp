// SPDX-License-Identifier: Apache-2.0
// VGG16: Simonyan and Zisserman, 2015, configuration D; GoogLeNet: Szegedy et al., 2015, table 1; both turned into
// fully convolutional networks by Long et al., 2015, with the layer parameters of the thesis, appendix B: only
// conv1_1 is unpadded and real pixels surround the tile, 97 px to 450 x 450 in training.
// MobileNetV2: Sandler et al., 2018, table 2. Its decoder adds the trunk's features of stride 8, 4 and 2 to the
// upsampled coarser ones (Lin et al., Feature pyramid networks, 2017), with depthwise separable convolutions between.
#include "orthodrive/nets/make_network.hpp"

#include <fmt/format.h>

#include <map>

#include "orthodrive/core/error.hpp"
#include "orthodrive/model/rasters/map_alignment.hpp"

namespace orthodrive {
namespace {

constexpr int reference_input_px = 450;  // appendix B; a multiple of 32 plus 2

/// Appends layers; every function returns the index of its last layer.
struct Builder {
  NetworkGraph graph;

  int add(Layer layer) {
    graph.layers.push_back(std::move(layer));
    return static_cast<int>(graph.layers.size()) - 1;
  }
  [[nodiscard]] int channels(int input) const {
    if (input == map_input) return graph.map_channels;
    return input == image_input ? 3 : graph.layers[static_cast<std::size_t>(input)].out;
  }
  Layer& layer(int index) { return graph.layers[static_cast<std::size_t>(index)]; }

  /// Caffe's names and defaults: bias, ReLU.
  int conv(const std::string& name, int input, int out, int kernel, int padding, bool relu = true) {
    return add({.name = name,
                .kind = LayerKind::convolution,
                .inputs = {input},
                .in = channels(input),
                .out = out,
                .kernel = kernel,
                .padding = padding,
                .kernel_tensor = name + "/kernel",
                .activation = relu ? Activation::relu : Activation::none,
                .pretrained = true});
  }
  int pool(const std::string& name, int input, int kernel, int stride, int padding = 0) {
    const int c = channels(input);
    return add({.name = name,
                .kind = LayerKind::max_pool,
                .inputs = {input},
                .in = c,
                .out = c,
                .kernel = kernel,
                .stride = stride,
                .padding = padding});
  }
  int norm(const std::string& name, int input) {
    const int c = channels(input);
    return add({.name = name, .kind = LayerKind::local_response_norm, .inputs = {input}, .in = c, .out = c});
  }
  int score(const std::string& name, int input) {
    const int index = conv(name, input, graph.class_count, 1, 0, false);
    layer(index).pretrained = false;
    layer(index).score = true;
    return index;
  }
  int deconv(const std::string& name, int input, int kernel, int stride, int padding = 0) {
    return add({.name = name,
                .kind = LayerKind::deconvolution,
                .inputs = {input},
                .in = graph.class_count,
                .out = graph.class_count,
                .kernel = kernel,
                .stride = stride,
                .padding = padding,
                .kernel_tensor = name + "/kernel",
                .score = true});
  }
  /// The second input is cropped so that their centres agree, as Caffe's Crop layer does.
  int fuse(const std::string& name, int upsampled, int skip, bool crop) {
    int shift = 0;
    if (crop) {
      const std::vector<CellRange> cells = padded_ranges(graph, reference_input_px);
      shift = (cells[static_cast<std::size_t>(skip)].size() - cells[static_cast<std::size_t>(upsampled)].size()) / 2;
    }
    return add({.name = name,
                .kind = LayerKind::add,
                .inputs = {upsampled, skip},
                .shifts = {0, shift},
                .in = graph.class_count,
                .out = graph.class_count,
                .score = true});
  }
};

/// Scores at stride 32, fused with those of finer layers down to `stride`, upsampled to full size.
/// `skips`: layers of stride 16 and 8. GoogLeNet's deconvolutions are padded so that sizes agree without cropping.
void add_fcn_decoder(Builder& b, int features, const std::array<std::pair<const char*, int>, 2>& skips, int stride,
                     bool padded) {
  int scores = b.score("score", features);
  int reached = 32;
  for (const auto& [name, skip] : skips) {
    if (reached == stride) break;
    const int up = b.deconv(fmt::format("upscore_{}", reached / 2), scores, 4, 2, padded ? 1 : 0);
    scores = b.fuse(fmt::format("fuse_{}", reached / 2), up, b.score(name, skip), !padded);
    reached /= 2;
  }
  b.deconv(fmt::format("upsample_{}", stride), scores, 2 * stride, stride);
  const std::vector<CellRange> cells = padded_ranges(b.graph, reference_input_px);
  b.graph.output_shift = (reference_input_px - cells.back().size()) / 2;  // the centre crop
  b.graph.size_remainder = reference_input_px % 32;
}

void make_vgg16(Builder& b, int stride) {
  b.graph.input = {{123.68F, 116.779F, 103.939F}, 1.0F, true};
  int x = image_input;
  std::map<int, int> pools;
  constexpr std::array widths{64, 128, 256, 512, 512};
  for (int block = 1; block <= 5; ++block) {
    for (int i = 1; i <= (block <= 2 ? 2 : 3); ++i) {
      const int padding = block == 1 && i == 1 ? 0 : 1;
      x = b.conv(fmt::format("conv{}_{}", block, i), x, widths[static_cast<std::size_t>(block - 1)], 3, padding);
    }
    x = pools[block] = b.pool(fmt::format("pool{}", block), x, 2, 2);
  }
  x = b.conv("fc6", x, 4096, 7, 0);
  b.layer(x).dropout = 0.5;
  x = b.conv("fc7", x, 4096, 1, 0);
  b.layer(x).dropout = 0.5;
  add_fcn_decoder(b, x, {{{"score_pool4", pools[4]}, {"score_pool3", pools[3]}}}, stride, false);
}

struct Inception {
  const char* name;
  int c1, c3_reduce, c3, c5_reduce, c5, proj;
};

int add_inception(Builder& b, int x, const Inception& i) {
  const std::string name = i.name;
  const int one = b.conv(name + "/1x1", x, i.c1, 1, 0);
  const int three = b.conv(name + "/3x3", b.conv(name + "/3x3_reduce", x, i.c3_reduce, 1, 0), i.c3, 3, 1);
  const int five = b.conv(name + "/5x5", b.conv(name + "/5x5_reduce", x, i.c5_reduce, 1, 0), i.c5, 5, 2);
  const int proj = b.conv(name + "/pool_proj", b.pool(name + "/pool", x, 3, 1, 1), i.proj, 1, 0);
  const int out = i.c1 + i.c3 + i.c5 + i.proj;
  return b.add(
      {.name = name + "/output", .kind = LayerKind::concat, .inputs = {one, three, five, proj}, .in = out, .out = out});
}

void make_googlenet(Builder& b, int stride) {
  b.graph.input = {{123.0F, 117.0F, 104.0F}, 1.0F, true};
  int x = b.conv("conv1/7x7_s2", image_input, 64, 7, 3);
  b.layer(x).stride = 2;
  x = b.norm("pool1/norm1", b.pool("pool1/3x3_s2", x, 3, 2));
  x = b.conv("conv2/3x3", b.conv("conv2/3x3_reduce", x, 64, 1, 0), 192, 3, 1);
  const int pool2 = x = b.pool("pool2/3x3_s2", b.norm("conv2/norm2", x), 3, 2);
  x = add_inception(b, x, {"inception_3a", 64, 96, 128, 16, 32, 32});
  x = add_inception(b, x, {"inception_3b", 128, 128, 192, 32, 96, 64});
  const int pool3 = x = b.pool("pool3/3x3_s2", x, 3, 2);
  for (const Inception& i : {Inception{"inception_4a", 192, 96, 208, 16, 48, 64},
                             {"inception_4b", 160, 112, 224, 24, 64, 64},
                             {"inception_4c", 128, 128, 256, 24, 64, 64},
                             {"inception_4d", 112, 144, 288, 32, 64, 64},
                             {"inception_4e", 256, 160, 320, 32, 128, 128}}) {
    x = add_inception(b, x, i);
  }
  x = b.pool("pool4/3x3_s2", x, 3, 2);
  x = add_inception(b, x, {"inception_5a", 256, 160, 320, 32, 128, 128});
  x = add_inception(b, x, {"inception_5b", 384, 192, 384, 48, 128, 128});
  add_fcn_decoder(b, x, {{{"score_pool3", pool3}, {"score_pool2", pool2}}}, stride, true);
}

// Names and shapes are those of Keras, so that its ImageNet weights fit. Padding is symmetric where TensorFlow's
// 'same' pads strided layers at the end only: both sample the same function, one pixel apart.
struct MobileNetBuilder : Builder {
  int keras_conv(const std::string& name, const std::string& kernel, const std::string& norm_name, int input, int out,
                 int size, int stride, bool depthwise, bool relu6, bool pretrained) {
    return add({.name = name,
                .kind = LayerKind::convolution,
                .inputs = {input},
                .in = channels(input),
                .out = out,
                .kernel = size,
                .stride = stride,
                .padding = (size - 1) / 2,
                .depthwise = depthwise,
                .kernel_tensor = kernel,
                .norm_tensors = norm_name,
                .activation = relu6 ? Activation::relu6 : Activation::none,
                .pretrained = pretrained});
  }
  int pointwise(const std::string& name, int input, int out, bool relu6, bool trunk) {
    return keras_conv(name, name + "/kernel", name + "_BN", input, out, 1, 1, false, relu6, trunk);
  }
  int depthwise(const std::string& name, int input, int stride, bool trunk) {
    return keras_conv(name, name + "/depthwise_kernel", name + "_BN", input, channels(input), 3, stride, true, true,
                      trunk);
  }
};

/// What a network says that sees the map: where the map's roads truly lie, and what their being on the map adds to the
/// scores of the classes. Both at stride 2.
struct MapBranch {
  int alignment, scores;
};
/// Two convolutions of the map, to stride 4. They come first: nothing else reads the map, so its pixels need not stay.
int add_map_features(MobileNetBuilder& b) {
  const int map_2 = b.keras_conv("map_2", "map_2/kernel", "map_2_BN", map_input, 16, 3, 2, false, true, false);
  return b.pointwise("map_4_project", b.depthwise("map_4_depthwise", map_2, 2, false), 32, true, false);
}

void mark_of_map(NetworkGraph& graph, std::size_t first) {
  for (std::size_t i = first; i < graph.layers.size(); ++i) graph.layers[i].of_map = true;
}

/// From the features of stride 4 of the photo (merged, and the trunk's own, which know edges) and of the map, with four
/// depthwise convolutions to look around. For the classes they meet the photo's features of stride 2. Nothing of it
/// goes back into the rest: without a map the classes are those of the network without this branch.
MapBranch add_map_branch(MobileNetBuilder& b, int map_4, int merged_4, int trunk_4, int merged_2) {
  const std::size_t first = b.graph.layers.size();
  const auto starting_at_zero = [&](const std::string& name, int input, int channels) {
    const int x = b.conv(name, input, channels, 1, 0, false);
    b.layer(x).pretrained = false;
    b.layer(x).starts_zero = true;
    return x;
  };
  const auto doubled = [&](const std::string& name, int input) {
    const int channels = b.channels(input);
    return b.add({.name = name, .kind = LayerKind::upsample_2x, .inputs = {input}, .in = channels, .out = channels});
  };
  const int width = b.channels(merged_4) + b.channels(trunk_4) + b.channels(map_4);
  int x = b.add({.name = "align_input",
                 .kind = LayerKind::concat,
                 .inputs = {merged_4, trunk_4, map_4},
                 .in = width,
                 .out = width});
  for (int i = 1; i <= 4; ++i) {
    const std::string name = fmt::format("align_{}", i);
    x = b.pointwise(name + "_project", b.depthwise(name + "_depthwise", x, 1, false), 64, true, false);
  }
  MapBranch branch{};
  branch.alignment = doubled("align_up", starting_at_zero("align_out", x, b.graph.alignment_channels));
  constexpr int channels = 16;
  const int up = doubled("classes_up", b.pointwise("classes_4", x, channels, false, false)),
            lateral = b.pointwise("classes_lateral", merged_2, channels, false, false);
  x = b.add({.name = "classes_add",
             .kind = LayerKind::add,
             .inputs = {up, lateral},
             .shifts = {0, 0},
             .in = channels,
             .out = channels});
  x = b.pointwise("classes_project", b.depthwise("classes_depthwise", x, 1, false), channels, true, false);
  branch.scores = starting_at_zero("classes_out", x, b.graph.class_count);
  mark_of_map(b.graph, first);
  return branch;
}

struct Trunk {
  int features;            // of the last layer
  std::vector<int> skips;  // the last features of strides 2, 4, 8 (16)
};

/// The layers of ImageNet's network up to `stride_px`.
Trunk add_mobilenet_trunk(MobileNetBuilder& b, int stride_px) {
  int x = b.keras_conv("Conv1", "Conv1/kernel", "bn_Conv1", image_input, 32, 3, 2, false, true, true);
  x = b.pointwise("expanded_conv_project", b.depthwise("expanded_conv_depthwise", x, 1, true), 16, false, true);
  struct Group {  // table 2 of the paper: channels, repeats, stride of the first; expansion 6
    int out, repeats, stride;
  };
  std::vector<int> skips;
  int block = 1;
  for (const Group group : {Group{24, 2, 2}, Group{32, 3, 2}, Group{64, 4, 2}, Group{96, 3, 1}, Group{160, 3, 2}}) {
    if (group.out == 160 && stride_px < 32) break;
    for (int i = 0; i < group.repeats; ++i, ++block) {
      const std::string prefix = fmt::format("block_{}", block);
      const int stride = i == 0 ? group.stride : 1;
      const int before = x;
      if (stride == 2) skips.push_back(before);
      x = b.pointwise(prefix + "_expand", before, 6 * b.channels(before), true, true);
      x = b.pointwise(prefix + "_project", b.depthwise(prefix + "_depthwise", x, stride, true), group.out, false, true);
      if (i == 0) continue;
      x = b.add({.name = prefix + "_add",
                 .kind = LayerKind::add,
                 .inputs = {before, x},
                 .shifts = {0, 0},
                 .in = group.out,
                 .out = group.out});
    }
  }
  return {x, std::move(skips)};
}

/// Features of strides 4 and 2 after merging.
struct Merged {
  int at_4, at_2;
};

/// Adds the trunk's features to the upsampled coarser ones, level by level.
Merged add_feature_pyramid(MobileNetBuilder& b, const Trunk& trunk, int stride_px) {
  const std::string context = stride_px == 32 ? "context_32" : "context";
  int x =
      b.pointwise(context + "_project", b.depthwise(context + "_depthwise", trunk.features, 1, false), 64, true, false);
  std::vector<int> skips = trunk.skips;
  int merged_4 = x;
  struct Level {
    const char* name;
    int in, out;
  };
  for (const Level level :
       {Level{"merge_16", 64, 64}, Level{"merge_8", 64, 48}, Level{"merge_4", 48, 32}, Level{"merge_2", 32, 32}}) {
    const std::string name = level.name;
    if (name == "merge_16" && stride_px < 32) continue;
    const int up =
        b.add({.name = name + "_up", .kind = LayerKind::upsample_2x, .inputs = {x}, .in = level.in, .out = level.in});
    const int lateral = b.pointwise(name + "_lateral", skips.back(), level.in, false, false);
    skips.pop_back();
    x = b.add({.name = name + "_add",
               .kind = LayerKind::add,
               .inputs = {up, lateral},
               .shifts = {0, 0},
               .in = level.in,
               .out = level.in});
    x = b.pointwise(name + "_project", b.depthwise(name + "_depthwise", x, 1, false), level.out, true, false);
    if (name == "merge_4") merged_4 = x;
  }
  return {merged_4, x};
}

void make_mobilenet(MobileNetBuilder& b, int stride_px, bool with_map) {
  b.graph.stride_px = stride_px;
  int map_4 = image_input;
  if (with_map) {
    b.graph.map_channels = map_raster_channels, b.graph.alignment_channels = alignment_channels;
    map_4 = add_map_features(b);
    mark_of_map(b.graph, 0);
  }
  const Trunk trunk = add_mobilenet_trunk(b, stride_px);
  const Merged merged = add_feature_pyramid(b, trunk, stride_px);
  int x = b.score("head", merged.at_2);
  if (with_map) {
    const MapBranch branch = add_map_branch(b, map_4, merged.at_4, trunk.skips[1], merged.at_2);
    const int classes = b.graph.class_count, all = b.graph.output_channels();
    x = b.add({.name = "head_with_map",
               .kind = LayerKind::add,
               .inputs = {x, branch.scores},
               .shifts = {0, 0},
               .in = classes,
               .out = classes});
    x = b.add({.name = "outputs", .kind = LayerKind::concat, .inputs = {x, branch.alignment}, .in = all, .out = all});
  }
  const int all = b.channels(x);
  b.add({.name = "upsample", .kind = LayerKind::upsample_2x, .inputs = {x}, .in = all, .out = all, .score = true});
}

constexpr std::string_view map_suffix = "-map";

}  // namespace

std::string without_map(const std::string& architecture) {
  return architecture.ends_with(map_suffix) ? architecture.substr(0, architecture.size() - map_suffix.size())
                                            : architecture;
}

NetworkGraph make_network(const std::string& architecture, int class_count) {
  MobileNetBuilder builder;
  builder.graph.architecture = architecture;
  builder.graph.class_count = class_count;
  for (const int stride : {32, 16, 8}) {
    if (architecture == fmt::format("vgg16-{}s", stride)) return make_vgg16(builder, stride), builder.graph;
    if (architecture == fmt::format("googlenet-{}s", stride)) return make_googlenet(builder, stride), builder.graph;
  }
  for (const int stride : {32, 16}) {
    for (const bool with_map : {false, true})
      if (architecture == fmt::format("mobilenetv2-s{}-fpn2{}", stride, with_map ? map_suffix : ""))
        return make_mobilenet(builder, stride, with_map), builder.graph;
  }
  throw OptionError(
      fmt::format("network '{}' is unknown: use vgg16 or googlenet with -32s, -16s or -8s (decoder fcn), or "
                  "mobilenetv2-s32-fpn2 or -s16-fpn2, with -map behind it for a network that sees the map, too",
                  architecture));
}

}  // namespace orthodrive
