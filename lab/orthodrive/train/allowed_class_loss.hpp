// SPDX-License-Identifier: Apache-2.0
#pragma once
// Loss of weak labels. Includes ATen: for the .cpp files of this folder only.

#include <ATen/ATen.h>

#include <vector>

namespace orthodrive {

/// Loss of a pixel: -log of the probability of its allowed classes together, softmax over the scores. With one allowed
/// class it is the cross entropy; with several it leaves open which of them it is; with none it is left out.
struct AllowedLossOptions {
  std::vector<float> class_weights;  ///< for pixels with one allowed class, by class
  float set_weight = 1.0F;           ///< for pixels with several
  bool sum = false;  ///< the sum over pixels (the reference's unnormalised loss) instead of the weighted mean
};
struct LossGradient {
  double loss = 0.0;
  at::Tensor gradient;  ///< of the first argument's shape
};
/// `scores`: N x C x H x W, `allowed`: N x H x W of class sets (int64), on the same device.
[[nodiscard]] LossGradient allowed_class_loss(const at::Tensor& scores, const at::Tensor& allowed,
                                              const AllowedLossOptions& options);
/// The share of pixels that is expected to be wrong: 1 - probability of the allowed classes (expected Hamming loss),
/// for marginals of a CRF, N x C x H x W. Unlike their logarithm it does not ask for doubt where the CRF is sure and
/// wrong.
[[nodiscard]] LossGradient expected_error(const at::Tensor& marginals, const at::Tensor& allowed,
                                          const AllowedLossOptions& options);
/// 1 - the soft intersection over union (Rahman and Wang 2016), averaged over the classes of the batch: what the scores
/// are measured by, where thin roads count as much as wide fields. Of class c, pixels that can only be c are the truth,
/// sets without c the rest, sets with c and others are left out. `scores` and `allowed` as above.
[[nodiscard]] LossGradient jaccard_loss(const at::Tensor& scores, const at::Tensor& allowed);

}  // namespace orthodrive
