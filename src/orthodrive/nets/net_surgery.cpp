// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/nets/net_surgery.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/random.hpp"
#include "orthodrive/nets/layer_weights.hpp"

namespace orthodrive {
namespace {

using Outcome = SurgeryEntry::Outcome;

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

/// Names under which others publish the same layer: our own (those of Caffe's BVLC models), Keras, the thesis.
std::vector<std::string> published_names(const std::string& layer) {
  std::vector<std::string> names{layer};
  if (layer.starts_with("conv") && layer.size() == 7 && layer[5] == '_')
    names.push_back(fmt::format("block{}_conv{}", layer[4], layer[6]));
  std::string thesis = replaced(replaced(replaced(layer, "inception_", "i"), "_reduce", "_red"), "pool_proj", "proj");
  for (const char* stem : {"conv1/", "conv2/"}) {
    if (layer.starts_with(stem)) thesis = std::string("c") + thesis.substr(4);
  }
  if (thesis != layer) names.push_back(thesis);
  if (layer == "fc6" || layer == "fc7") names.push_back(layer + "-conv");
  if (layer == "score") names.push_back("score37");
  return names;
}

NamedTensor filled(std::vector<std::int64_t> shape, float value) {
  std::int64_t count = 1;
  for (const std::int64_t n : shape) count *= n;
  return {std::move(shape), std::vector<float>(static_cast<std::size_t>(count), value), TensorType::f32};
}

bool starts_zero(const Layer& layer) { return layer.score || layer.starts_zero; }

NamedTensor he_normal(const Layer& layer, std::uint64_t seed) {
  NamedTensor tensor = filled(kernel_file_shape(layer), 0.0F);
  const double fan_in = layer.kernel * layer.kernel * (layer.depthwise ? 1 : layer.in);
  Random random(seed);
  for (float& value : tensor.values) value = static_cast<float>(random.normal() * std::sqrt(2.0 / fan_in));
  return tensor;
}

/// Each class interpolates its own scores.
NamedTensor bilinear(const Layer& layer) {
  NamedTensor tensor = filled(kernel_file_shape(layer), 0.0F);
  const int k = layer.kernel;
  const int half = (k + 1) / 2;
  const double factor = half, center = k % 2 == 1 ? factor - 1.0 : factor - 0.5;
  for (int y = 0; y < k; ++y) {
    for (int x = 0; x < k; ++x) {
      const double value = (1.0 - std::abs(y - center) / factor) * (1.0 - std::abs(x - center) / factor);
      for (int c = 0; c < layer.in; ++c) {
        const auto at = static_cast<std::size_t>(((y * k + x) * layer.in + c) * layer.out + c);
        tensor.values[at] = static_cast<float>(value);
      }
    }
  }
  return tensor;
}

/// A fully connected layer sees its input as channel, row, column (Caffe): O x (I * k * k) -> k x k x I x O.
NamedTensor convolution_from_inner_product(const Layer& layer, const NamedTensor& matrix) {
  NamedTensor kernel = filled(kernel_file_shape(layer), 0.0F);
  const auto k2 = static_cast<std::size_t>(layer.kernel * layer.kernel);
  const auto in = static_cast<std::size_t>(layer.in), out = static_cast<std::size_t>(layer.out);
  for (std::size_t o = 0; o < out; ++o)
    for (std::size_t i = 0; i < in; ++i)
      for (std::size_t p = 0; p < k2; ++p) kernel.values[(p * in + i) * out + o] = matrix.values[(o * in + i) * k2 + p];
  return kernel;
}

void require_numbers(const WeightsSource& source) {
  for (const auto& [name, tensor] : source.file.tensors) {
    if (!std::all_of(tensor.values.begin(), tensor.values.end(), [](float value) { return std::isfinite(value); }))
      throw InputError(source.name,
                       fmt::format("tensor '{}' holds values that are no numbers: use other weights", name));
  }
}

/// Fills one layer; remembers which tensors of the sources were used.
class Surgeon {
 public:
  Surgeon(std::span<const WeightsSource> sources, StartWeights& result) : sources_(sources), result_(result) {}

  void fill(const Layer& layer, std::uint64_t seed) {
    SurgeryEntry entry{.layer = layer.name};
    NamedTensor kernel = layer.kind == LayerKind::deconvolution ? bilinear(layer)
                         : starts_zero(layer)                   ? filled(kernel_file_shape(layer), 0.0F)
                                                                : he_normal(layer, seed);
    entry.outcome = layer.kind == LayerKind::deconvolution ? Outcome::bilinear
                    : starts_zero(layer)                   ? Outcome::zero
                                                           : Outcome::random;
    const WeightsSource* from = nullptr;
    std::string published;  // prefix of the bias that goes with the kernel
    for (const WeightsSource& source : sources_) {
      if (from) break;
      for (const std::string& name : published_names(layer.name)) {
        const std::string tensor =
            name == layer.name ? layer.kernel_tensor : name + layer.kernel_tensor.substr(layer.name.size());
        if (const NamedTensor* found = find(source, tensor)) {
          if (found->shape != kernel_file_shape(layer)) {
            refuse(layer, source, tensor, found->shape, entry);
            continue;
          }
          kernel = *found;
          entry.outcome = Outcome::taken;
        } else if (const NamedTensor* matrix = find(source, name + "/inner_product");
                   matrix && matrix->values.size() == kernel.values.size() && !layer.depthwise) {
          kernel = convolution_from_inner_product(layer, *matrix);
          entry.outcome = Outcome::converted;
          used_.insert(source.name + '\n' + name + "/inner_product");
        } else {
          continue;
        }
        from = &source;
        published = name;
        entry.from = source.name + ": " + name;
        used_.insert(source.name + '\n' + tensor);
        break;
      }
    }
    auto& tensors = result_.file.tensors;
    kernel.stored_as = TensorType::f32;
    tensors.emplace(layer.kernel_tensor, std::move(kernel));
    if (layer.norm_tensors.empty()) {
      tensors.emplace(bias_tensor(layer), vector_of(layer, from, published + "/bias", 0.0F));
    } else {
      for (const auto& [part, value] :
           {std::pair{"/gamma", 1.0F}, {"/beta", 0.0F}, {"/moving_mean", 0.0F}, {"/moving_variance", 1.0F}})
        tensors.emplace(layer.norm_tensors + part, vector_of(layer, from, layer.norm_tensors + part, value));
    }
    result_.report.layers.push_back(std::move(entry));
  }

  void finish() {
    for (const WeightsSource& source : sources_) {
      bool any = false;
      for (const auto& [name, tensor] : source.file.tensors) {
        if (used_.contains(source.name + '\n' + name)) {
          any = true;
        } else {
          result_.report.unused.push_back(source.name + ": " + name);
        }
      }
      if (!any)
        throw InputError(source.name, "none of its tensors fits the network: wrong weights, or layers of other names");
    }
  }

 private:
  static const NamedTensor* find(const WeightsSource& source, const std::string& name) {
    const auto it = source.file.tensors.find(name);
    return it == source.file.tensors.end() ? nullptr : &it->second;
  }

  static void refuse(const Layer& layer, const WeightsSource& source, const std::string& tensor,
                     const std::vector<std::int64_t>& shape, SurgeryEntry& entry) {
    const std::string what = fmt::format("tensor '{}' has shape [{}], layer '{}' needs [{}]", tensor,
                                         fmt::join(shape, ","), layer.name, fmt::join(kernel_file_shape(layer), ","));
    if (!layer.score) throw InputError(source.name, what);
    entry.note = what + ": another class table or stride";
  }

  NamedTensor vector_of(const Layer& layer, const WeightsSource* from, const std::string& name, float fallback) {
    const std::vector<std::int64_t> shape{layer.out};
    if (!from) return filled(shape, fallback);
    const NamedTensor* found = find(*from, name);
    if (!found && layer.norm_tensors.empty()) return filled(shape, fallback);  // Caffe: bias_term: false
    if (!found || found->shape != shape)
      throw InputError(from->name,
                       fmt::format("tensor '{}' is missing or not of {} values, its kernel is there", name, layer.out));
    used_.insert(from->name + '\n' + name);
    return {shape, found->values, TensorType::f32};
  }

  std::span<const WeightsSource> sources_;
  StartWeights& result_;
  std::set<std::string> used_;
};

}  // namespace

const char* to_string(SurgeryEntry::Outcome outcome) {
  switch (outcome) {
    case Outcome::taken:
      return "taken";
    case Outcome::converted:
      return "converted";
    case Outcome::bilinear:
      return "bilinear";
    case Outcome::zero:
      return "zero";
    case Outcome::random:
      break;
  }
  return "random";
}

std::string format_report(const SurgeryReport& report) {
  std::string text;
  for (const SurgeryEntry& entry : report.layers) {
    text += fmt::format("{:<28} {:<10} {}{}\n", entry.layer, to_string(entry.outcome), entry.from,
                        entry.note.empty() ? "" : (entry.from.empty() ? "" : "; ") + entry.note);
  }
  for (const std::string& name : report.unused) text += fmt::format("unused: {}\n", name);
  return text;
}

StartWeights start_weights(const NetworkGraph& graph, std::span<const WeightsSource> sources, std::uint64_t seed) {
  StartWeights result;
  for (const WeightsSource& source : sources) require_numbers(source);
  Surgeon surgeon(sources, result);
  for (std::size_t i = 0; i < graph.layers.size(); ++i) {
    if (!graph.layers[i].kernel_tensor.empty()) surgeon.fill(graph.layers[i], derive_seed(seed, i));
  }
  surgeon.finish();
  return result;
}

}  // namespace orthodrive
