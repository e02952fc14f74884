#pragma once
// Scores of files against truth, as `evaluate` prints them and the report of a site with truth shows them.

#include <filesystem>

#include "orthodrive/pipeline/score_files.hpp"
#include "orthodrive/pipeline/score_json.hpp"

namespace orthodrive {

struct ScoreRequest {
  std::filesystem::path scored, truth;
  RegionFiles region;
};

[[nodiscard]] ScoreJson score_labels(const ScoreRequest& request);
[[nodiscard]] ScoreJson score_roads(const ScoreRequest& request);
[[nodiscard]] ScoreJson score_heights(const ScoreRequest& request);
[[nodiscard]] ScoreJson score_network(const ScoreRequest& request);  ///< needs no truth
/// What of a built site the truth folder knows about: labels, roads, heights, network.
[[nodiscard]] ScoreJson score_site(const ScoreRequest& request);

}  // namespace orthodrive
