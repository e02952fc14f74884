// SPDX-License-Identifier: Apache-2.0
#pragma once
// A trained CRF as part of a model file.

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "orthodrive/crf/dense_crf.hpp"
#include "orthodrive/model/rasters/tensor_file.hpp"

namespace orthodrive {

struct CrfModel {
  CrfWidths widths;  ///< in pixels of the model's scale
  CrfParameters parameters;
};

/// Widths and weights of a CRF that is not trained, as in table 2.2 of the thesis: w1 and its widths of the appearance
/// kernel, w2 and its width of the smoothness kernel.
struct CrfSet {
  std::string_view name;
  float w1 = 0.0F;
  double theta_alpha_px = 0.0, theta_beta = 0.0;
  float w2 = 0.0F;
  double theta_gamma_px = 0.0;
};
/// Of table 2.2, accuracies there 88.73, 90.51 and 90.51 %: the examples of Kraehenbuehl and Koltun (2012), Zheng et
/// al. (2015), the thesis' own grid search.
inline constexpr std::array crf_sets{CrfSet{"kraehenbuehl", 10.0F, 80.0, 13.0, 3.0F, 3.0},
                                     CrfSet{"zheng", 5.0F, 160.0, 3.0, 3.0F, 3.0},
                                     CrfSet{"thesis", 5.2F, 13.5, 11.0, 1.5F, 1.75}};
/// A name of crf_sets, or "w1,theta_alpha,theta_beta,w2,theta_gamma". Throws OptionError, also for weights below 0 or
/// above 1000, and widths that are not from 0.1 to 1000.
[[nodiscard]] CrfSet parse_crf_set(std::string_view text);

/// Potts; 10 iterations.
[[nodiscard]] CrfModel crf_of(const CrfSet& set, int classes);
/// The thesis' own set.
[[nodiscard]] CrfModel reference_crf(int classes);

/// Adds tensors "crf/..." and the metadata item "crf".
void add_crf(TensorFile& file, const CrfModel& crf);
/// None where the file has none. Throws InputError naming `source` when it does not fit the number of classes.
[[nodiscard]] std::optional<CrfModel> read_crf(const TensorFile& file, int classes, const std::string& source);

}  // namespace orthodrive
