// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/nets/network_graph.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "orthodrive/core/error.hpp"
#include "orthodrive/nets/make_network.hpp"

namespace orthodrive {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

const std::vector<std::string> all_networks{"vgg16-32s",
                                            "vgg16-16s",
                                            "vgg16-8s",
                                            "googlenet-32s",
                                            "googlenet-16s",
                                            "googlenet-8s",
                                            "mobilenetv2-s16-fpn2",
                                            "mobilenetv2-s32-fpn2"};

/// Brute force along one axis: every layer cell by cell, forwards, from the definition of its operation, with the set
/// of pixels it depends on as first and last. Cells that see padding are marked.
struct Seen {
  CellRange pixels;
  bool padded = false;
};
struct SeenLine {
  int first = 0;  ///< absolute index of cells[0]
  std::vector<Seen> cells;
};

SeenLine brute_force(const NetworkGraph& graph, int size_px) {
  SeenLine image{0, {}};
  for (int i = 0; i < size_px; ++i) image.cells.push_back({{i, i}, false});
  std::vector<SeenLine> lines;
  const std::vector<CellRange> ranges = padded_ranges(graph, size_px);
  for (std::size_t l = 0; l < graph.layers.size(); ++l) {
    const Layer& layer = graph.layers[l];
    SeenLine line{ranges[l].first, std::vector<Seen>(static_cast<std::size_t>(ranges[l].size()))};
    for (int o = ranges[l].first; o <= ranges[l].last; ++o) {
      Seen& cell = line.cells[static_cast<std::size_t>(o - line.first)];
      for (std::size_t k = 0; k < layer.inputs.size(); ++k) {
        const SeenLine& in = layer.inputs[k] == image_input ? image : lines[static_cast<std::size_t>(layer.inputs[k])];
        const auto take = [&](int i) {
          const int at = i - in.first;
          if (at < 0 || at >= static_cast<int>(in.cells.size())) {
            cell.padded = true;
            return;
          }
          const Seen& seen = in.cells[static_cast<std::size_t>(at)];
          cell.pixels = hull(cell.pixels, seen.pixels);
          cell.padded = cell.padded || seen.padded;
        };
        switch (layer.kind) {
          case LayerKind::convolution:
          case LayerKind::max_pool:
            for (int t = 0; t < layer.kernel; ++t) take(o * layer.stride - layer.padding + t);
            break;
          case LayerKind::deconvolution:  // scatters: which inputs write to cell o?
            for (int i = in.first - 50; i < in.first + 50 + static_cast<int>(in.cells.size()); ++i) {
              const int t = o - (i * layer.stride - layer.padding);
              if (t >= 0 && t < layer.kernel) take(i);
            }
            break;
          case LayerKind::upsample_2x: {
            const double at = (o + 0.5) / 2.0 - 0.5;
            take(static_cast<int>(std::floor(at)));
            take(static_cast<int>(std::floor(at)) + 1);
            break;
          }
          case LayerKind::add:
            take(o + layer.shifts[k]);
            break;
          default:
            take(o);
        }
      }
    }
    lines.push_back(std::move(line));
  }
  return lines.back();
}

TEST(NetworkGraph, receptive_field_is_what_brute_force_sees) {
  for (const std::string& name : all_networks) {
    const NetworkGraph graph = make_network(name, 3);
    const int size = 1024 + graph.size_remainder;
    const SeenLine line = brute_force(graph, size);
    ReceptiveField expected;
    int compared = 0;
    for (std::size_t i = 0; i < line.cells.size(); ++i) {
      if (line.cells[i].padded) continue;
      const int px = line.first + static_cast<int>(i) + graph.output_shift;
      const CellRange seen = line.cells[i].pixels;
      EXPECT_EQ(needed_ranges(graph, {px, px}).image, seen) << name << " at " << px;
      expected.size_px = std::max(expected.size_px, seen.size());
      expected.before_px = std::max(expected.before_px, px - seen.first);
      expected.after_px = std::max(expected.after_px, seen.last - px);
      ++compared;
    }
    ASSERT_GE(compared, 2 * graph.stride_px) << name;
    const ReceptiveField field = receptive_field(graph);
    EXPECT_EQ(field.size_px, expected.size_px) << name;
    EXPECT_EQ(field.before_px, expected.before_px) << name;
    EXPECT_EQ(field.after_px, expected.after_px) << name;
  }
}

/// Sizes of the thesis, appendix B: 450 x 450 px in, scores large enough for the centre crop of 256.
TEST(NetworkGraph, sizes_of_appendix_b) {
  const auto size_of = [](const NetworkGraph& graph, const std::string& layer) {
    const std::vector<CellRange> ranges = padded_ranges(graph, 450);
    for (std::size_t i = 0; i < ranges.size(); ++i)
      if (graph.layers[i].name == layer) return ranges[i].size();
    return -1;
  };
  const NetworkGraph vgg = make_network("vgg16-8s", 38), google = make_network("googlenet-8s", 38);
  EXPECT_EQ(size_of(vgg, "conv1_1"), 448);
  EXPECT_EQ(size_of(vgg, "pool4"), 28);
  EXPECT_EQ(size_of(vgg, "fc6"), 8);
  EXPECT_EQ(size_of(vgg, "upscore_16"), 18);
  EXPECT_EQ(size_of(vgg, "upscore_8"), 38);
  EXPECT_EQ(size_of(vgg, "upsample_8"), 312);
  EXPECT_EQ(vgg.output_shift, 69);
  EXPECT_EQ(size_of(google, "pool2/3x3_s2"), 56);
  EXPECT_EQ(size_of(google, "inception_5b/output"), 14);
  EXPECT_EQ(size_of(google, "upscore_16"), 28);
  EXPECT_EQ(size_of(google, "upsample_8"), 456);
  EXPECT_EQ(google.output_shift, -3);
}

long long parameter_count(const NetworkGraph& graph) {
  long long count = 0;
  for (const Layer& layer : graph.layers) {
    if (layer.kernel_tensor.empty()) continue;
    count += static_cast<long long>(layer.kernel) * layer.kernel * layer.in * (layer.depthwise ? 1 : layer.out);
    count += layer.norm_tensors.empty() ? layer.out : 2 * layer.out;
  }
  return count;
}

/// The published networks have 138.36 and 7.0 million weights with their classifiers of 1000 classes; without those,
/// and with the scores and deconvolutions of the reference:
TEST(NetworkGraph, parameter_counts) {
  const auto vgg_trunk = 14714688LL, fc6 = 512LL * 49 * 4096 + 4096, fc7 = 4096LL * 4096 + 4096;
  const auto score = 4096LL * 38 + 38, skips = (512LL + 256) * 38 + 2 * 38;
  const auto deconvolutions = 38LL * 38 * (16 + 16 + 256) + 3 * 38;
  EXPECT_EQ(parameter_count(make_network("vgg16-8s", 38)), vgg_trunk + fc6 + fc7 + score + skips + deconvolutions);
  const auto google_trunk =
      5973536LL;  // 6998552 less the classifier's 1024 * 1000 + 1000 and 16 of rounding: counted by layer
  EXPECT_NEAR(
      static_cast<double>(parameter_count(make_network("googlenet-32s", 2)) - (1024 * 2 + 2) - (2 * 2 * 64 * 64 + 2)),
      static_cast<double>(google_trunk), 20.0);
}

TEST(NetworkGraph, crops_align_centres) {
  // Where a cell of each fused layer lies in the image, from what it sees: both inputs must agree in VGG16.
  const NetworkGraph graph = make_network("vgg16-8s", 2);
  const SeenLine line = brute_force(graph, 1026);
  for (std::size_t i = 0; i < line.cells.size(); ++i) {
    if (line.cells[i].padded) continue;
    const CellRange seen = line.cells[i].pixels;
    const double middle = 0.5 * (seen.first + seen.last), px = line.first + static_cast<double>(i) + graph.output_shift;
    EXPECT_LE(std::abs(middle - px), 17.0) << "the coarsest cell is 32 px wide";
  }
}

TEST(NetworkGraph, too_small_images_and_unknown_networks_are_refused) {
  EXPECT_THAT([] { static_cast<void>(padded_ranges(make_network("vgg16-8s", 2), 130)); },
              ThrowsMessage<OptionError>(HasSubstr("larger crop")));
  EXPECT_THAT([] { static_cast<void>(make_network("resnet-8s", 2)); },
              ThrowsMessage<OptionError>(HasSubstr("'resnet-8s' is unknown")));
}

}  // namespace
}  // namespace orthodrive
