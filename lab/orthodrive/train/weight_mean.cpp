// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/train/weight_mean.hpp"

#include <ATen/core/grad_mode.h>

#include <array>
#include <stdexcept>
#include <string_view>

#include "orthodrive/core/error.hpp"

namespace orthodrive {
namespace {
constexpr const char* count_key = "weights_in_mean";
constexpr std::string_view prefix = "mean/";

constexpr std::array tensors_of_layer{&LayerParams::kernel, &LayerParams::gamma,    &LayerParams::beta,
                                      &LayerParams::mean,   &LayerParams::variance, &LayerParams::bias};
}  // namespace

void WeightMean::add(const NetworkParams& params) {
  const at::NoGradGuard no_grad;
  ++count_;
  mean_.resize(params.size());
  for (std::size_t i = 0; i < params.size(); ++i) {
    for (const auto tensor : tensors_of_layer) {
      const at::Tensor& value = params[i].*tensor;
      if (!value.defined()) continue;
      at::Tensor& mean = mean_[i].*tensor;
      if (count_ == 1)
        mean = value.detach().clone();
      else
        mean.add_(value - mean, 1.0 / static_cast<double>(count_));
    }
  }
}

void WeightMean::save(TensorFile& checkpoint, const NetworkGraph& graph) const {
  if (count_ == 0) return;
  checkpoint.metadata[count_key] = std::to_string(count_);
  for (auto& [name, tensor] : file_from_params(graph, mean_, TensorType::f32).tensors)
    checkpoint.tensors.emplace(std::string(prefix) + name, std::move(tensor));
}

void WeightMean::restore(const TensorFile& checkpoint, const NetworkGraph& graph, at::Device device,
                         const std::string& source) {
  *this = {};
  const auto count = checkpoint.metadata.find(count_key);
  if (count == checkpoint.metadata.end()) return;
  TensorFile means;
  for (const auto& [name, tensor] : checkpoint.tensors)
    if (name.starts_with(prefix)) means.tensors.emplace(name.substr(prefix.size()), tensor);
  mean_ = params_from_file(graph, means, source);
  for (LayerParams& layer : mean_)
    for (const auto tensor : tensors_of_layer)
      if (at::Tensor& value = layer.*tensor; value.defined()) value = value.to(device);
  try {
    count_ = std::stoll(count->second);
  } catch (const std::logic_error&) {
    count_ = 0;
  }
  if (count_ < 1) throw InputError(source, "the number of weights in its mean is no number: the checkpoint is damaged");
}

}  // namespace orthodrive
