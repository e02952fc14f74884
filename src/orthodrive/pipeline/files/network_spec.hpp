// SPDX-License-Identifier: Apache-2.0
#pragma once
// The two small files a network is described by: trunk, stride and decoder, and its class table (TOML,
// docs/segment.md).

#include <filesystem>
#include <string>
#include <string_view>

#include "orthodrive/model/rasters/class_table.hpp"

namespace orthodrive {

struct NetworkSpec {
  std::string trunk = "mobilenetv2";  ///< vgg16, googlenet, mobilenetv2
  int stride = 16;                    ///< px: of the scores that are upsampled (fcn), of the trunk's last layer (fpn2)
  std::string decoder = "fpn2";       ///< fcn: scores and deconvolutions; fpn2: features merged down to stride 2
  double gsd_m = 0.5;                 ///< input scale in m/px
  double finest_gsd_m = 0.0;          ///< finest scale it is trained on, by zooms of the training data; 0: gsd_m
  std::filesystem::path class_table_file;  ///< parse_class_table reads its text; empty: default_class_table()

  /// "vgg16-8s", "mobilenetv2-s16-fpn2": names trunk, stride and decoder in model files and for make_network.
  [[nodiscard]] std::string architecture() const;
};
/// `file` is for messages and for paths, which are relative to it. Throws InputError.
[[nodiscard]] NetworkSpec parse_network_spec(std::string_view text, const std::filesystem::path& file);

/// `name` and `[[class]]` with `name`, `color`, `role`, `cost_false_positive`, `cost_false_negative`.
[[nodiscard]] ClassTable parse_class_table(std::string_view text, const std::filesystem::path& file);

}  // namespace orthodrive
