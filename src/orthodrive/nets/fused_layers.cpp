// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/nets/fused_layers.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>

namespace orthodrive {
namespace {

constexpr int strip_cells = 128;  // so many cells of a row at once: three expanded rows fit into the cache
constexpr int depthwise_kernel = 3;

bool whole_vectors(int channels) { return channels % 8 == 0; }

/// Finds what can be fused around a depthwise convolution.
class Fusion {
 public:
  Fusion(const NetworkGraph& graph, const std::vector<LayerWeights>& folded) : graph_(graph), folded_(folded) {
    uses_.resize(graph.layers.size(), 0);
    user_.resize(graph.layers.size(), 0);
    for (std::size_t i = 0; i < graph.layers.size(); ++i)
      for (const int input : graph.layers[i].inputs)
        if (input >= 0) ++uses_[index(input)], user_[index(input)] = i;
    plan_ = no_fusion(graph);
  }

  FusionPlan run() {
    for (std::size_t i = 0; i < graph_.layers.size(); ++i) try_around(i);
    return std::move(plan_);
  }

 private:
  static std::size_t index(int layer) { return static_cast<std::size_t>(layer); }
  const Layer& layer(std::size_t i) const { return graph_.layers[i]; }
  bool used_once(std::size_t i) const { return uses_[i] == 1; }

  static bool is_convolution(const Layer& l) {
    return l.kind == LayerKind::convolution && !l.depthwise && whole_vectors(l.out);
  }
  bool is_pointwise(const Layer& l) const {
    return is_convolution(l) && l.kernel == 1 && l.stride == 1 && l.padding == 0 && whole_vectors(l.in);
  }
  static bool adds_in_place(const Layer& l) {
    return l.kind == LayerKind::add && l.shifts.size() == 2 && l.shifts[0] == 0 && l.shifts[1] == 0;
  }

  void try_around(std::size_t i) {
    const Layer& d = layer(i);
    if (d.kind != LayerKind::convolution || !d.depthwise || d.kernel != depthwise_kernel || d.padding != 1 ||
        d.stride > 2 || !whole_vectors(d.out) || d.inputs[0] < 0 || !used_once(i) || !is_pointwise(layer(user_[i]))) {
      return;
    }
    FusedLayers f;
    f.last = user_[i];
    f.projection = pack(layer(f.last), folded_[f.last]);
    f.channels = d.out;
    f.stride = d.stride;
    f.depthwise_weights = folded_[i].kernel;
    f.depthwise_bias = folded_[i].bias;
    f.depthwise_range = range_of(d.activation);
    std::vector<std::size_t> inside{i};
    find_source(index(d.inputs[0]), f, inside);
    find_residual(f, inside);
    for (const std::size_t k : inside) plan_.step[k] = FusionPlan::inside;
    plan_.step[f.last] = static_cast<int>(plan_.fused.size());
    plan_.fused.push_back(std::move(f));
  }

  void find_source(std::size_t before, FusedLayers& f, std::vector<std::size_t>& inside) const {
    const Layer& b = layer(before);
    f.source = static_cast<int>(before);
    if (!used_once(before) || plan_.step[before] != FusionPlan::plain) return;
    if (is_convolution(b) && (is_pointwise(b) || b.inputs[0] < 0)) {
      f.source = b.inputs[0];
      f.expansion = pack(b, folded_[before]);
      f.expands = true;
      inside.push_back(before);
    } else if (adds_in_place(b) && b.inputs[0] >= 0 && b.inputs[1] >= 0) {
      const std::size_t up = index(b.inputs[0]), lateral = index(b.inputs[1]);
      if (layer(up).kind != LayerKind::upsample_2x || !used_once(up) || !used_once(lateral) ||
          !is_pointwise(layer(lateral)) || layer(lateral).activation != Activation::none || layer(up).inputs[0] < 0) {
        return;
      }
      f.source = layer(lateral).inputs[0];
      f.upsampled = layer(up).inputs[0];
      f.expansion = pack(layer(lateral), folded_[lateral]);
      f.expands = true;
      inside.insert(inside.end(), {before, up, lateral});
    }
  }

  void find_residual(FusedLayers& f, std::vector<std::size_t>& inside) const {
    if (!used_once(f.last) || f.stride != 1 || f.upsampled != FusedLayers::none ||
        f.projection.range.low > std::numeric_limits<float>::lowest()) {
      return;
    }
    const Layer& a = layer(user_[f.last]);
    if (!adds_in_place(a) || a.inputs[0] != f.source || a.inputs[1] != static_cast<int>(f.last) || f.source < 0) return;
    inside.push_back(f.last);
    f.last = user_[f.last];
    f.residual = true;
  }

  const NetworkGraph& graph_;
  const std::vector<LayerWeights>& folded_;
  FusionPlan plan_;
  std::vector<int> uses_;
  std::vector<std::size_t> user_;
};

int floor_half(int a) { return a >= 0 ? a / 2 : -((1 - a) / 2); }

/// A strip of fused layers, from its top row downwards.
class Strip {
 public:
  Strip(const FusedLayers& layers, const CellView& source, const CellView& upsampled, CellRange cols)
      : f_(layers),
        source_(source),
        upsampled_(upsampled),
        cols_(cols),
        inner_{cols.first * layers.stride - 1, cols.last * layers.stride + 1} {
    const auto cells = static_cast<std::size_t>(inner_.size()), channels = static_cast<std::size_t>(f_.channels);
    if (f_.expands)
      for (std::vector<float>& row : ring_) row.resize(cells * channels);
    if (f_.upsampled != FusedLayers::none) added_.resize(cells * channels);
    if (f_.expansion.kernel > 1) patches_.resize(cells * static_cast<std::size_t>(f_.expansion.rows));
    filtered_.resize(static_cast<std::size_t>(cols.size()) * channels);
  }

  void compute(int row, float* result) {
    DepthwiseRow d;
    for (int k = 0; k < depthwise_kernel; ++k) d.rows[k] = inner_row(row * f_.stride - 1 + k);
    d.cells = static_cast<std::size_t>(cols_.size());
    d.channels = f_.channels;
    d.stride = f_.stride;
    d.weights = f_.depthwise_weights.data();
    d.bias = f_.depthwise_bias.data();
    d.range = f_.depthwise_range;
    d.result = filtered_.data();
    kernels_.depthwise(d);
    ProductPlace p = place_of(f_.projection, d.cells, filtered_.data(), static_cast<std::size_t>(f_.channels), result);
    if (f_.residual) {
      p.add = source_.at(row, cols_.first);
      p.add_stride = source_.cell_stride;
    }
    multiply(kernels_, f_.projection, p);
  }

 private:
  static ProductPlace place_of(const PackedConvolution& c, std::size_t count, const float* values, std::size_t stride,
                               float* result) {
    return {.count = count,
            .values = values,
            .value_stride = stride,
            .result = result,
            .result_stride = static_cast<std::size_t>(c.padded_out)};
  }

  /// A row that the depthwise convolution reads; the last three are kept.
  const float* inner_row(int row) {
    if (!f_.expands) return source_.at(row, inner_.first);
    const auto slot = static_cast<std::size_t>(((row % depthwise_kernel) + depthwise_kernel) % depthwise_kernel);
    float* values = ring_[slot].data();
    if (row > newest_) {
      expand(row, values);
      newest_ = row;
    }
    return values;
  }

  void expand(int row, float* result) {
    const auto cells = static_cast<std::size_t>(inner_.size());
    if (f_.expansion.kernel > 1) {
      gather_patches(f_.expansion, source_, row, inner_, patches_.data());
      const auto size = static_cast<std::size_t>(f_.expansion.rows);
      return multiply(kernels_, f_.expansion, place_of(f_.expansion, cells, patches_.data(), size, result));
    }
    ProductPlace p = place_of(f_.expansion, cells, source_.at(row, inner_.first), source_.cell_stride, result);
    if (f_.upsampled != FusedLayers::none) {
      upsample_row(kernels_, upsampled_, row, inner_, coarse_, added_.data());
      p.add = added_.data();
      p.add_stride = static_cast<std::size_t>(f_.channels);
    }
    multiply(kernels_, f_.expansion, p);
  }

  const FusedLayers& f_;
  const CellView& source_;
  const CellView& upsampled_;
  const LayerKernels& kernels_ = layer_kernels();
  CellRange cols_, inner_;
  std::array<std::vector<float>, depthwise_kernel> ring_;
  std::vector<float> added_, coarse_, patches_, filtered_;
  int newest_ = std::numeric_limits<int>::min();
};

}  // namespace

FusionPlan no_fusion(const NetworkGraph& graph) {
  return {{}, std::vector<int>(graph.layers.size(), FusionPlan::plain)};
}

FusionPlan fuse_layers(const NetworkGraph& graph, const std::vector<LayerWeights>& folded) {
  return Fusion(graph, folded).run();
}

/// Cell o of twice the resolution lies at (2 o - 1) / 4, between two cells.
void upsample_row(const LayerKernels& kernels, const CellView& coarse, int row, CellRange cols,
                  std::vector<float>& scratch, float* result) {
  const auto share = [](int o) { return o % 2 == 0 ? 0.75F : 0.25F; };
  const CellRange cells{floor_half(cols.first - 1), floor_half(cols.last - 1) + 1};
  scratch.resize(static_cast<std::size_t>(cells.size()) * coarse.cell_stride);
  const int upper = floor_half(row - 1);
  kernels.mix(coarse.at(upper, cells.first), coarse.at(upper + 1, cells.first), share(row), scratch.size(),
              scratch.data());
  for (int col = cols.first; col <= cols.last; ++col, result += coarse.cell_stride) {
    const float* left =
        scratch.data() + static_cast<std::size_t>(floor_half(col - 1) - cells.first) * coarse.cell_stride;
    kernels.mix(left, left + coarse.cell_stride, share(col), coarse.channels, result);
  }
}

void run_fused(const FusedLayers& layers, const CellView& source, const CellView& upsampled, CellRange rows,
               CellRange cols, float* result) {
  const auto channels = static_cast<std::size_t>(layers.projection.out);
  const std::size_t row_stride = static_cast<std::size_t>(cols.size()) * channels;
  for (int first = cols.first; first <= cols.last; first += strip_cells) {
    Strip strip(layers, source, upsampled, {first, std::min(first + strip_cells - 1, cols.last)});
    float* out = result + static_cast<std::size_t>(first - cols.first) * channels;
    for (int row = rows.first; row <= rows.last; ++row, out += row_stride) strip.compute(row, out);
  }
}

}  // namespace orthodrive
