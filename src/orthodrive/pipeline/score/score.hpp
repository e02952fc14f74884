// SPDX-License-Identifier: Apache-2.0
#pragma once
// Scores of files against truth, as `evaluate` prints them and the report of a site with truth shows them.

#include <filesystem>

#include "orthodrive/pipeline/score/score_files.hpp"
#include "orthodrive/pipeline/score/score_json.hpp"

namespace orthodrive {

struct ScoreRequest {
  std::filesystem::path scored, truth;
  RegionFiles region;
};

/// What else a score of labels takes in and puts out; empty paths: nothing of it.
struct LabelScoreOptions {
  std::filesystem::path merge;       ///< TOML table of classes taken together
  std::filesystem::path confidence;  ///< raster beside the label map: adds the calibration
  std::filesystem::path page;        ///< HTML page, or the folder for labels.html
  std::filesystem::path photo;       ///< under the error pictures of the page
};
/// What else a score of roads takes in and puts out; empty paths: nothing of it.
struct RoadScoreOptions {
  std::filesystem::path before;   ///< the roads before refinement: adds moved_away
  std::filesystem::path overlay;  ///< PNG of right and wrong surface
  std::filesystem::path photo;    ///< under the overlay
  std::filesystem::path layers;   ///< GeoPackage: false_positive, false_negative, truth_lines, truth_samples
};
/// Throws OptionError when an option needs classes and the truth has none.
[[nodiscard]] ScoreJson score_labels(const ScoreRequest& request, const LabelScoreOptions& options);
[[nodiscard]] ScoreJson score_labels(const ScoreRequest& request);
[[nodiscard]] ScoreJson score_roads(const ScoreRequest& request, const RoadScoreOptions& options);
[[nodiscard]] ScoreJson score_roads(const ScoreRequest& request);
[[nodiscard]] ScoreJson score_heights(const ScoreRequest& request);
/// What else a score of a network puts out; empty paths: nothing of it.
struct NetworkScoreOptions {
  std::filesystem::path findings;  ///< GeoJSON points of the places that fail
  std::filesystem::path layers;    ///< GeoPackage, a layer a kind of fault
  int threads = 0;
};
[[nodiscard]] ScoreJson score_network(const ScoreRequest& request, const NetworkScoreOptions& options);
[[nodiscard]] ScoreJson score_network(const ScoreRequest& request);  ///< needs no truth
/// What else a score of a scene takes in; an empty path: nothing of it.
struct SceneScoreOptions {
  std::filesystem::path photo;  ///< that the tiles show, with its own pixels: adds the place of their pictures
};
/// Of the tiles in a folder; `truth` is the OpenDRIVE file that they were made of.
[[nodiscard]] ScoreJson score_scene(const ScoreRequest& request, const SceneScoreOptions& options);
[[nodiscard]] ScoreJson score_scene(const ScoreRequest& request);
/// What of a built site the truth folder knows about: labels, roads, heights, network.
[[nodiscard]] ScoreJson score_site(const ScoreRequest& request);

}  // namespace orthodrive
