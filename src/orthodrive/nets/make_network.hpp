// SPDX-License-Identifier: Apache-2.0
#pragma once
// The networks this program knows.

#include <string>

#include "orthodrive/nets/network_graph.hpp"

namespace orthodrive {

/// VGG16-32s/16s/8s and GoogLeNet-32s/16s/8s layer by layer as in the thesis, appendix B; MobileNetV2 with the decoder
/// of docs/segment.md. Throws OptionError for a combination that does not exist, naming those that do.
[[nodiscard]] NetworkGraph make_network(const std::string& architecture, int class_count);
/// The architecture of the same network without the branch that reads a map; its weights are among the other's.
[[nodiscard]] std::string without_map(const std::string& architecture);

}  // namespace orthodrive
