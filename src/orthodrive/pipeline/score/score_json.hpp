// SPDX-License-Identifier: Apache-2.0
#pragma once
// Scores as one JSON object (docs/evaluate.md lists the keys) and as a table for people.

#include <nlohmann/json.hpp>
#include <string>

#include "orthodrive/evaluate/labels/evaluate_labels.hpp"
#include "orthodrive/evaluate/networks/evaluate_network.hpp"
#include "orthodrive/evaluate/roads/evaluate_heights.hpp"
#include "orthodrive/evaluate/roads/evaluate_roads.hpp"
#include "orthodrive/evaluate/scenes/evaluate_scene.hpp"

namespace orthodrive {

using ScoreJson = nlohmann::ordered_json;

/// Numbers that do not exist (NaN) become null.
/// `confusion` has the rows of the truth; `absent` says which classes truth, prediction or both have not.
[[nodiscard]] ScoreJson to_json(const LabelScores& scores);
/// Adds `pieces` by name, and `pieces_elsewhere`: those without a pixel that could be compared.
void add_pieces(ScoreJson& json, const std::vector<PieceScores>& pieces);
[[nodiscard]] ScoreJson to_json(const RoadRoleScores& scores);
[[nodiscard]] ScoreJson to_json(const RoadScores& scores);
[[nodiscard]] ScoreJson to_json(const HeightScores& scores);
[[nodiscard]] ScoreJson to_json(const NetworkScores& scores);
[[nodiscard]] ScoreJson to_json(const SceneScores& scores);

[[nodiscard]] std::string to_table(const ScoreJson& scores);

}  // namespace orthodrive
