// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/pipeline/files/refine_files.hpp"

#include <algorithm>
#include <cmath>

#include "orthodrive/io/raster/raster_io.hpp"
#include "orthodrive/io/support/read_file.hpp"
#include "orthodrive/pipeline/files/toml_section.hpp"
#include "orthodrive/refine/weight_table.hpp"

namespace orthodrive {
namespace fs = std::filesystem;

SiteFrame labelled_site(const fs::path& file, const LabelMap& map) {
  std::vector<Vec2> outline;
  for (int row = 0; row < map.frame.height; ++row) {
    int first = map.frame.width, last = -1;
    for (int col = 0; col < map.frame.width; ++col)
      if (map.labels.at(col, row) != label_nodata) first = std::min(first, col), last = col;
    for (const int y : {row, row + 1})
      if (last >= 0)
        outline.push_back(map.frame.world_from_pixel(first, y)),
            outline.push_back(map.frame.world_from_pixel(last + 1, y));
  }
  if (outline.empty()) throw InputError(file.string(), "has no label but nodata; segment a photo of the area");
  return {map.crs, {convex_hull(std::move(outline)), {}}};
}

RoadEvidence read_evidence(const LabelMap& labels, const fs::path& road_probability) {
  return road_probability.empty() ? road_evidence(labels)
                                  : road_evidence(labels, io::read_confidence(road_probability));
}

RefineWeights read_refine_weights(const fs::path& path) {
  if (!fs::is_regular_file(path))
    throw InputError(path.string(), "no such file; `orthodrive tune` writes one as weights.toml");
  const toml::table table = parse_toml(io::read_file(path), path);
  TomlSection section(table, path);
  RefineWeights weights;
  for (const NamedWeight& weight : refine_weight_table()) {
    const std::string name(weight.name);
    double& value = weights.*weight.value;
    section.read(name.c_str(), value);
    if (!(value > 0.0 && std::isfinite(value)))
      section.fail(*table.get(name), fmt::format("'{}' must be a number above 0", name));
  }
  section.finish();
  return weights;
}

std::string refine_weights_toml(const RefineWeights& weights) {
  std::string text;
  for (const NamedWeight& weight : refine_weight_table())
    text += fmt::format("{} = {}\n", weight.name, weights.*weight.value);
  return text;
}

}  // namespace orthodrive
