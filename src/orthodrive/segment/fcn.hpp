#pragma once
// The network: a MobileNetV2 trunk to stride 16 and a light decoder to stride 2, bilinear to full size.
// Sandler et al., MobileNetV2: Inverted residuals and linear bottlenecks, 2018, table 2 (up to 14 x 14 x 96).
// The decoder adds the trunk's features of stride 8, 4 and 2 to the upsampled coarser ones (as in Lin et al., Feature
// pyramid networks, 2017), with depthwise separable 3 x 3 convolutions between.
//
// Includes ATen: for the .cpp files of this folder only.

#include <ATen/ATen.h>

#include <memory>
#include <string>
#include <vector>

#include "orthodrive/segment/pixel_box.hpp"
#include "orthodrive/segment/safetensors.hpp"

namespace orthodrive {

/// One convolution with its batch norm. Trunk names and shapes are those of Keras, so that ImageNet weights fit.
struct ConvSpec {
  std::string conv, norm;  ///< names of the tensors; norm empty: a bias instead (the last layer)
  int in = 0, out = 0, kernel = 1, stride = 1;
  bool depthwise = false, relu6 = true, trunk = true;
};

struct FcnSpec {
  static constexpr const char* architecture = "mobilenetv2-s16-fpn2";
  /// Bottlenecks in order: 17 - 4 of MobileNetV2, those up to stride 16.
  struct Bottleneck {
    std::vector<ConvSpec> convs;  ///< expand (not in the first), depthwise, project
    bool residual = false;
  };
  ConvSpec stem;
  std::vector<Bottleneck> bottlenecks;
  ConvSpec context_depthwise, context_project;  ///< at stride 16
  struct Merge {
    ConvSpec lateral, depthwise, project;
  };
  std::vector<Merge> merges;  ///< at strides 8, 4, 2
  ConvSpec head;

  [[nodiscard]] std::vector<ConvSpec> all() const;
};
[[nodiscard]] FcnSpec make_fcn_spec(int class_count);

constexpr int fcn_stride_px = 16;
/// Half of what an output pixel sees: 133 px of the trunk to stride 16, 8 for the cell, four cells of the decoder;
/// rounded up to the stride. segment_test.cpp checks it by moving pixels just inside and outside.
constexpr int fcn_margin_px = 208;

/// A convolution as it runs: kernel OIHW in channels-last, and either batch norm or bias.
struct ConvParams {
  at::Tensor kernel, gamma, beta, mean, variance, bias;
  bool depthwise = false;
};

/// Parameters in the order of FcnSpec::all().
using FcnParams = std::vector<ConvParams>;

struct ForwardMode {
  bool update_batch_statistics = false;  ///< batch norm uses and updates the batch's statistics
};

/// RGB in [-1, 1], N x 3 x H x W, H and W multiples of 16 -> class scores N x C x H/2 x W/2.
[[nodiscard]] at::Tensor forward(const FcnSpec& spec, FcnParams& params, const at::Tensor& image, ForwardMode mode);

/// Batch norm folded into kernel and bias; the same scores with fewer passes over memory.
[[nodiscard]] FcnParams fold_batch_norm(const FcnSpec& spec, const FcnParams& params);

/// Tensors by Keras names (kernels HWIO) <-> parameters. `source` names the file in messages. With `trunk_only`, layers
/// outside the trunk start from seeded He-normal values. Throws InputError for missing tensors and wrong shapes.
struct ReadParamsOptions {
  bool trunk_only = false;
  std::uint64_t seed = 1;
};
[[nodiscard]] FcnParams params_from_file(const FcnSpec& spec, const TensorFile& file, const std::string& source,
                                         const ReadParamsOptions& options = {});
/// `kernels_as`: batch norm vectors stay F32, they are few.
[[nodiscard]] TensorFile file_from_params(const FcnSpec& spec, const FcnParams& params, TensorType kernels_as);

/// The folded network for prediction. Safe from several threads.
class InferenceNetwork {
 public:
  InferenceNetwork(FcnSpec spec, const FcnParams& params);
  [[nodiscard]] int class_count() const { return spec_.head.out; }
  /// Photo needed on every side of what is predicted: what a pixel sees, and what aligning the window to the stride
  /// takes away.
  [[nodiscard]] int margin_px() const { return fcn_margin_px + fcn_stride_px - 1; }
  /// `rgb` covers `core` grown by margin_px() on every side (H x W x 3 bytes); writes class probabilities
  /// core.height x core.width x C. Any position and size of core: the network aligns itself.
  void predict(const std::uint8_t* rgb, const PixelBox& core, float* probabilities) const;

 private:
  FcnSpec spec_;
  FcnParams folded_;
};

/// RGB bytes -> channels-last tensor in [-1, 1], as the ImageNet weights expect.
[[nodiscard]] at::Tensor image_tensor(const std::uint8_t* rgb, int count, int width, int height);

}  // namespace orthodrive
