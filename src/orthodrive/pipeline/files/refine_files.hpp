// SPDX-License-Identifier: Apache-2.0
#pragma once
// What `refine`, `build` and `tune` read and write around the refinement of roads.

#include <filesystem>
#include <string>

#include "orthodrive/model/rasters/rasters.hpp"
#include "orthodrive/model/site_frame.hpp"
#include "orthodrive/refine/refine_roads.hpp"

namespace orthodrive {

/// The hull of the labels that are not nodata: where there is a photo. `file` is what an error names.
[[nodiscard]] SiteFrame labelled_site(const std::filesystem::path& file, const LabelMap& map);

/// Of the labels, with the probability of road on their grid where a file is given (empty path: labels taken for sure).
[[nodiscard]] RoadEvidence read_evidence(const LabelMap& labels, const std::filesystem::path& road_probability);

/// A TOML file of lines `name = number`; names are the members of RefineWeights, which keep the shipped value where the
/// file says nothing. Throws InputError with the line for unknown names and for what is not a number above 0.
[[nodiscard]] RefineWeights read_refine_weights(const std::filesystem::path& path);
/// As read_refine_weights reads it, all weights, with all their digits.
[[nodiscard]] std::string refine_weights_toml(const RefineWeights& weights);

}  // namespace orthodrive
