// SPDX-License-Identifier: Apache-2.0
#pragma once
// A trained CRF as part of a model file.

#include <optional>
#include <string>

#include "orthodrive/crf/dense_crf.hpp"
#include "orthodrive/model/tensor_file.hpp"

namespace orthodrive {

struct CrfModel {
  CrfWidths widths;  ///< in pixels of the model's scale
  CrfParameters parameters;
};

/// The reference's grid search: theta 13.5, 11, 1.75, w 5.2 and 1.5, 10 iterations; not trained.
[[nodiscard]] CrfModel reference_crf(int classes);

/// Adds tensors "crf/..." and the metadata item "crf".
void add_crf(TensorFile& file, const CrfModel& crf);
/// None where the file has none. Throws InputError naming `source` when it does not fit the number of classes.
[[nodiscard]] std::optional<CrfModel> read_crf(const TensorFile& file, int classes, const std::string& source);

}  // namespace orthodrive
