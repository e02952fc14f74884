#pragma once
// The networks this program knows, described by trunk, stride and decoder.

#include <filesystem>
#include <string>
#include <string_view>

#include "orthodrive/model/class_table.hpp"
#include "orthodrive/segment/allowed_classes.hpp"
#include "orthodrive/segment/network_graph.hpp"

namespace orthodrive {

/// What a network description file says (TOML, docs/segmentation.md).
struct NetworkSpec {
  std::string trunk = "mobilenetv2";  ///< vgg16, googlenet, mobilenetv2
  int stride = 16;                    ///< px: of the scores that are upsampled (fcn), of the trunk's last layer (fpn2)
  std::string decoder = "fpn2";       ///< fcn: scores and deconvolutions; fpn2: features merged down to stride 2
  double gsd_m = 0.5;                 ///< input scale in m/px
  double finest_gsd_m = 0.0;          ///< finest scale it is trained on, by zooms of the training data; 0: gsd_m
  std::filesystem::path class_table_file;  ///< parse_class_table reads it; empty: default_class_table()

  /// "vgg16-8s", "mobilenetv2-s16-fpn2": names trunk, stride and decoder in model files.
  [[nodiscard]] std::string architecture() const;
};
/// `file` for messages and for paths, which are relative to it. Throws InputError.
[[nodiscard]] NetworkSpec parse_network_spec(std::string_view text, const std::filesystem::path& file);

/// TOML: `name` and `[[class]]` with `name`, `color`, `role`, `cost_false_positive`, `cost_false_negative`.
[[nodiscard]] ClassTable parse_class_table(std::string_view text, const std::filesystem::path& file);

/// VGG16-32s/16s/8s and GoogLeNet-32s/16s/8s layer by layer as in the thesis, appendix B; MobileNetV2 with the decoder
/// of docs/segmentation.md. Throws OptionError for a combination that does not exist, naming those that do.
[[nodiscard]] NetworkGraph make_network(const std::string& architecture, int class_count);

}  // namespace orthodrive
