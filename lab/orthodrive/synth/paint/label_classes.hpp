// SPDX-License-Identifier: Apache-2.0
#pragma once
// Labels of the 38 classes of the thesis (appendix A.1, models/classes/reference-38.toml).

#include "orthodrive/model/rasters/class_table.hpp"
#include "orthodrive/synth/paint/scene_raster.hpp"

namespace orthodrive::synth {

/// Throws OptionError that names all classes which sites show and the table lacks, as those of reference-38.toml are
/// called. The table's order and its other classes are free.
void check_synth_classes(const ClassTable& table);

/// As label_scene, with values of that table, which check_synth_classes has passed. A crown in an orchard is the
/// orchard's; crowns up to a metre of radius are shrubs.
[[nodiscard]] Raster<std::uint8_t> label_scene(const SceneSource& source, const SceneRaster& scene,
                                               const ClassTable& table, int threads);

}  // namespace orthodrive::synth
