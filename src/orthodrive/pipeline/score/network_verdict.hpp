// SPDX-License-Identifier: Apache-2.0
#pragma once
// The verdict of judge_network as JSON, findings and layers for QGIS.

#include <filesystem>

#include "orthodrive/core/finding.hpp"
#include "orthodrive/evaluate/networks/judge_network.hpp"
#include "orthodrive/geo/crs.hpp"
#include "orthodrive/pipeline/score/score_json.hpp"

namespace orthodrive {

/// `pass`, `lanes`, `links`, `track_km`, and by kind `limit`, `worst`, `places`.
[[nodiscard]] ScoreJson to_json(const NetworkVerdict& verdict);
/// Every place that fails: kind, value, limit, x, y, road, lane, s.
[[nodiscard]] ScoreJson faults_json(const NetworkVerdict& verdict);
/// Every place that fails as a warning "verdict.KIND".
[[nodiscard]] Findings findings_of(const NetworkVerdict& verdict);
/// One line: pass, or how many places of which kind fail.
[[nodiscard]] std::string summary_of(const NetworkVerdict& verdict);
/// GeoPackage with a layer of points for every kind: value, limit, road, lane, s.
void write_verdict_layers(const std::filesystem::path& path, const NetworkVerdict& verdict, const Crs& crs);

}  // namespace orthodrive
