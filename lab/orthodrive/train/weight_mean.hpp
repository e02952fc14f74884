// SPDX-License-Identifier: Apache-2.0
#pragma once
// The mean of a network's weights over the last steps of a training: it lies nearer to the middle of a wide minimum
// than the last weights, and holds better on other data (Izmailov et al., Averaging weights leads to wider optima and
// better generalization, 2018; here every step counts and the rate may decay). Includes ATen: for the .cpp files of
// this folder only.

#include <ATen/ATen.h>

#include <cstdint>
#include <string>

#include "orthodrive/model/rasters/tensor_file.hpp"
#include "orthodrive/train/padded_network.hpp"

namespace orthodrive {

class WeightMean {
 public:
  /// Running statistics of batch norms count like weights.
  void add(const NetworkParams& params);
  [[nodiscard]] std::int64_t count() const { return count_; }
  [[nodiscard]] const NetworkParams& mean() const { return mean_; }  ///< count() > 0

  void save(TensorFile& checkpoint, const NetworkGraph& graph) const;
  /// Begins anew when the checkpoint has no mean. Throws InputError when it is damaged.
  void restore(const TensorFile& checkpoint, const NetworkGraph& graph, at::Device device, const std::string& source);

 private:
  NetworkParams mean_;
  std::int64_t count_ = 0;
};

}  // namespace orthodrive
