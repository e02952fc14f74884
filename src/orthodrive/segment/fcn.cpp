#include "orthodrive/segment/fcn.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstring>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/random.hpp"

namespace orthodrive {
namespace {

constexpr double batch_norm_eps = 1e-3;       // of the Keras weights
constexpr double batch_norm_momentum = 0.02;  // share of the newest batch in the running statistics

ConvSpec trunk_conv(const std::string& prefix, const std::string& part, int in, int out, bool relu6) {
  return {.conv = prefix + "_" + part + "/kernel",
          .norm = prefix + "_" + part + "_BN",
          .in = in,
          .out = out,
          .relu6 = relu6};
}

ConvSpec trunk_depthwise(const std::string& prefix, int channels, int stride) {
  return {.conv = prefix + "_depthwise/depthwise_kernel",
          .norm = prefix + "_depthwise_BN",
          .in = channels,
          .out = channels,
          .kernel = 3,
          .stride = stride,
          .depthwise = true};
}

ConvSpec decoder_conv(const std::string& name, int in, int out, bool depthwise, bool relu6) {
  return {.conv = name + (depthwise ? "/depthwise_kernel" : "/kernel"),
          .norm = name + "_BN",
          .in = in,
          .out = out,
          .kernel = depthwise ? 3 : 1,
          .depthwise = depthwise,
          .relu6 = relu6,
          .trunk = false};
}

/// Padding is symmetric where TensorFlow's 'same' pads strided layers at the end only. Both sample the same function,
/// one pixel apart, so the ImageNet weights fit either way and this way costs no extra copy.
at::Tensor convolve(const ConvSpec& spec, ConvParams& params, const at::Tensor& x, ForwardMode mode) {
  const std::int64_t padding = (spec.kernel - 1) / 2, groups = spec.depthwise ? spec.in : 1;
  at::Tensor y = at::conv2d(x, params.kernel, params.bias, spec.stride, padding, 1, groups);
  if (params.gamma.defined()) {
    y = at::batch_norm(y, params.gamma, params.beta, params.mean, params.variance, mode.update_batch_statistics,
                       batch_norm_momentum, batch_norm_eps, false);
  }
  if (!spec.relu6) return y;
  return y.requires_grad() ? at::clamp(y, 0.0, 6.0) : y.clamp_(0.0, 6.0);
}

at::Tensor twice_as_large(const at::Tensor& x) {
  return at::upsample_bilinear2d(x, {2 * x.size(2), 2 * x.size(3)}, false);
}

at::Tensor tensor_from(const NamedTensor& named) {
  return at::from_blob(const_cast<float*>(named.values.data()), named.shape, at::kFloat).clone();
}

NamedTensor named_from(const at::Tensor& tensor, TensorType stored_as) {
  const at::Tensor flat = tensor.detach().contiguous();
  const float* data = flat.data_ptr<float>();
  return {flat.sizes().vec(), std::vector<float>(data, data + flat.numel()), stored_as};
}

/// Keras stores kernels as height, width, in, out; depthwise ones as height, width, channel, 1.
std::vector<std::int64_t> file_shape(const ConvSpec& spec) {
  if (spec.depthwise) return {spec.kernel, spec.kernel, spec.in, 1};
  return {spec.kernel, spec.kernel, spec.in, spec.out};
}

at::Tensor kernel_from_hwio(const ConvSpec& spec, const at::Tensor& hwio) {
  const at::Tensor oihw = spec.depthwise ? hwio.permute({2, 3, 0, 1}) : hwio.permute({3, 2, 0, 1});
  return oihw.contiguous(at::MemoryFormat::ChannelsLast);
}

at::Tensor hwio_from_kernel(const ConvSpec& spec, const at::Tensor& kernel) {
  return spec.depthwise ? kernel.permute({2, 3, 0, 1}) : kernel.permute({2, 3, 1, 0});
}

/// He et al., Delving deep into rectifiers, 2015: keeps the variance through ReLU layers.
at::Tensor he_normal(const ConvSpec& spec, std::uint64_t seed) {
  const at::Tensor hwio = at::empty(file_shape(spec), at::kFloat);
  const double fan_in = spec.kernel * spec.kernel * (spec.depthwise ? 1 : spec.in);
  Random random(seed);
  float* data = hwio.data_ptr<float>();
  for (std::int64_t i = 0; i < hwio.numel(); ++i)
    data[i] = static_cast<float>(random.normal() * std::sqrt(2.0 / fan_in));
  return kernel_from_hwio(spec, hwio);
}

ConvParams fresh_params(const ConvSpec& spec, std::uint64_t seed) {
  ConvParams params{.kernel = he_normal(spec, seed), .depthwise = spec.depthwise};
  if (spec.norm.empty()) {
    params.bias = at::zeros({spec.out}, at::kFloat);
  } else {
    params.gamma = at::ones({spec.out}, at::kFloat);
    params.beta = at::zeros({spec.out}, at::kFloat);
    params.mean = at::zeros({spec.out}, at::kFloat);
    params.variance = at::ones({spec.out}, at::kFloat);
  }
  return params;
}

at::Tensor find_tensor(const TensorFile& file, const std::string& source, const std::string& name,
                       const std::vector<std::int64_t>& shape) {
  const auto it = file.tensors.find(name);
  if (it == file.tensors.end())
    throw InputError(source, fmt::format("tensor '{}' is missing, it is no {} model", name, FcnSpec::architecture));
  if (it->second.shape != shape) {
    throw InputError(source, fmt::format("tensor '{}' has shape [{}], need [{}]", name,
                                         fmt::join(it->second.shape, ","), fmt::join(shape, ",")));
  }
  return tensor_from(it->second);
}

std::string bias_name(const ConvSpec& spec) { return spec.conv.substr(0, spec.conv.find('/')) + "/bias"; }

}  // namespace

FcnSpec make_fcn_spec(int class_count) {
  FcnSpec spec;
  spec.stem = {.conv = "Conv1/kernel", .norm = "bn_Conv1", .in = 3, .out = 32, .kernel = 3, .stride = 2};
  spec.bottlenecks.push_back(
      {{trunk_depthwise("expanded_conv", 32, 1), trunk_conv("expanded_conv", "project", 32, 16, false)}});
  // Table 2 of the paper: out channels, repeats, stride of the first; expansion 6.
  struct Group {
    int out, repeats, stride;
  };
  int in = 16, block = 1;
  for (const Group group : {Group{24, 2, 2}, Group{32, 3, 2}, Group{64, 4, 2}, Group{96, 3, 1}}) {
    for (int i = 0; i < group.repeats; ++i, ++block) {
      const std::string prefix = fmt::format("block_{}", block);
      spec.bottlenecks.push_back(
          {{trunk_conv(prefix, "expand", in, 6 * in, true), trunk_depthwise(prefix, 6 * in, i == 0 ? group.stride : 1),
            trunk_conv(prefix, "project", 6 * in, group.out, false)},
           i > 0});
      in = group.out;
    }
  }
  spec.context_depthwise = decoder_conv("context_depthwise", 96, 96, true, true);
  spec.context_project = decoder_conv("context_project", 96, 64, false, true);
  struct Level {
    const char* name;
    int skip, in, out;
  };
  for (const Level level : {Level{"merge_8", 32, 64, 48}, Level{"merge_4", 24, 48, 32}, Level{"merge_2", 16, 32, 32}}) {
    const std::string name = level.name;
    spec.merges.push_back({decoder_conv(name + "_lateral", level.skip, level.in, false, false),
                           decoder_conv(name + "_depthwise", level.in, level.in, true, true),
                           decoder_conv(name + "_project", level.in, level.out, false, true)});
  }
  spec.head = {.conv = "head/kernel", .norm = "", .in = 32, .out = class_count, .relu6 = false, .trunk = false};
  return spec;
}

std::vector<ConvSpec> FcnSpec::all() const {
  std::vector<ConvSpec> convs{stem};
  for (const Bottleneck& bottleneck : bottlenecks)
    convs.insert(convs.end(), bottleneck.convs.begin(), bottleneck.convs.end());
  convs.push_back(context_depthwise);
  convs.push_back(context_project);
  for (const Merge& merge : merges) {
    convs.push_back(merge.lateral);
    convs.push_back(merge.depthwise);
    convs.push_back(merge.project);
  }
  convs.push_back(head);
  return convs;
}

at::Tensor forward(const FcnSpec& spec, FcnParams& params, const at::Tensor& image, ForwardMode mode) {
  auto next = params.begin();
  const auto run = [&](const ConvSpec& conv, const at::Tensor& x) { return convolve(conv, *next++, x, mode); };
  at::Tensor x = run(spec.stem, image);
  std::vector<at::Tensor> skips;  // the last features of strides 2, 4, 8
  for (const FcnSpec::Bottleneck& bottleneck : spec.bottlenecks) {
    const at::Tensor input = x;
    for (const ConvSpec& conv : bottleneck.convs) {
      if (conv.stride == 2) skips.push_back(input);
      x = run(conv, x);
    }
    if (bottleneck.residual) x = input + x;
  }
  x = run(spec.context_project, run(spec.context_depthwise, x));
  for (const FcnSpec::Merge& merge : spec.merges) {
    x = twice_as_large(x) + run(merge.lateral, skips.back());
    skips.pop_back();
    x = run(merge.depthwise, x);
    x = run(merge.project, x);
  }
  return run(spec.head, x);
}

FcnParams fold_batch_norm(const FcnSpec& spec, const FcnParams& params) {
  FcnParams folded;
  const at::NoGradGuard no_grad;
  const std::vector<ConvSpec> convs = spec.all();
  for (std::size_t i = 0; i < convs.size(); ++i) {
    const ConvParams& p = params[i];
    ConvParams f{.kernel = p.kernel.detach().clone(), .depthwise = p.depthwise};
    if (p.gamma.defined()) {
      const at::Tensor scale = p.gamma.detach() / at::sqrt(p.variance + batch_norm_eps);
      f.kernel = (f.kernel * scale.view({-1, 1, 1, 1})).contiguous(at::MemoryFormat::ChannelsLast);
      f.bias = p.beta.detach() - p.mean * scale;
    } else {
      f.bias = p.bias.detach().clone();
    }
    folded.push_back(std::move(f));
  }
  return folded;
}

FcnParams params_from_file(const FcnSpec& spec, const TensorFile& file, const std::string& source,
                           const ReadParamsOptions& options) {
  FcnParams params;
  for (const ConvSpec& conv : spec.all()) {
    if (options.trunk_only && !conv.trunk) {
      params.push_back(fresh_params(conv, derive_seed(options.seed, params.size())));
      continue;
    }
    ConvParams p{.kernel = kernel_from_hwio(conv, find_tensor(file, source, conv.conv, file_shape(conv))),
                 .depthwise = conv.depthwise};
    const std::vector<std::int64_t> channels{conv.out};
    if (conv.norm.empty()) {
      p.bias = find_tensor(file, source, bias_name(conv), channels);
    } else {
      p.gamma = find_tensor(file, source, conv.norm + "/gamma", channels);
      p.beta = find_tensor(file, source, conv.norm + "/beta", channels);
      p.mean = find_tensor(file, source, conv.norm + "/moving_mean", channels);
      p.variance = find_tensor(file, source, conv.norm + "/moving_variance", channels);
    }
    params.push_back(std::move(p));
  }
  return params;
}

TensorFile file_from_params(const FcnSpec& spec, const FcnParams& params, TensorType kernels_as) {
  TensorFile file;
  const std::vector<ConvSpec> convs = spec.all();
  for (std::size_t i = 0; i < convs.size(); ++i) {
    const ConvSpec& conv = convs[i];
    const ConvParams& p = params[i];
    file.tensors.emplace(conv.conv, named_from(hwio_from_kernel(conv, p.kernel.detach()), kernels_as));
    if (p.bias.defined()) file.tensors.emplace(bias_name(conv), named_from(p.bias, TensorType::f32));
    if (!p.gamma.defined()) continue;
    file.tensors.emplace(conv.norm + "/gamma", named_from(p.gamma, TensorType::f32));
    file.tensors.emplace(conv.norm + "/beta", named_from(p.beta, TensorType::f32));
    file.tensors.emplace(conv.norm + "/moving_mean", named_from(p.mean, TensorType::f32));
    file.tensors.emplace(conv.norm + "/moving_variance", named_from(p.variance, TensorType::f32));
  }
  return file;
}

at::Tensor image_tensor(const std::uint8_t* rgb, int count, int width, int height) {
  const at::Tensor bytes = at::from_blob(const_cast<std::uint8_t*>(rgb), {count, height, width, 3}, at::kByte);
  return bytes.to(at::kFloat).div_(127.5).sub_(1.0).permute({0, 3, 1, 2});  // a view that is channels-last
}

InferenceNetwork::InferenceNetwork(FcnSpec spec, const FcnParams& params)
    : spec_(std::move(spec)), folded_(fold_batch_norm(spec_, params)) {}

void InferenceNetwork::predict(const std::uint8_t* rgb, const PixelBox& core, float* probabilities) const {
  const c10::InferenceMode inference;
  const PixelBox given = core.grown(margin_px());
  // The window starts at an absolute multiple of the stride, whatever the core: same sums for a pixel in any window.
  constexpr std::int64_t stride = fcn_stride_px;
  const auto up = [](std::int64_t px) { return (px + (px < 0 ? 0 : stride - 1)) / stride * stride; };
  const std::int64_t west = up(given.col), north = up(given.row);
  const std::int64_t width = up(core.end_col() + fcn_margin_px) - west,
                     height = up(core.end_row() + fcn_margin_px) - north;
  const at::Tensor bytes = at::from_blob(const_cast<std::uint8_t*>(rgb), {given.height, given.width, 3}, at::kByte)
                               .slice(0, north - given.row, north - given.row + height)
                               .slice(1, west - given.col, west - given.col + width)
                               .contiguous();
  FcnParams params = folded_;  // handles only
  const at::Tensor scores = forward(
      spec_, params,
      image_tensor(bytes.data_ptr<std::uint8_t>(), 1, static_cast<int>(width), static_cast<int>(height)), {});
  const at::Tensor result = at::softmax(twice_as_large(scores)
                                            .slice(2, core.row - north, core.end_row() - north)
                                            .slice(3, core.col - west, core.end_col() - west)
                                            .permute({0, 2, 3, 1}),
                                        -1)
                                .contiguous();
  std::memcpy(probabilities, result.data_ptr<float>(), static_cast<std::size_t>(result.numel()) * sizeof(float));
}

}  // namespace orthodrive
