#pragma once
// What is written of a lap.

#include <string>
#include <utility>
#include <vector>

#include "orthodrive/drive/simulate_lap.hpp"

namespace orthodrive {

/// Text of lap.csv: one row a sample, a header with the columns, numbers with fixed decimals.
[[nodiscard]] std::string lap_csv(const DriveResult& result);

/// The numbers of a lap for tables: label and value with unit.
[[nodiscard]] std::vector<std::pair<std::string, std::string>> lap_numbers(const DriveResult& result);
/// The plots of a lap, each an inline SVG: map by speed, speed, height and gradient, accelerations, banking and roll.
[[nodiscard]] std::vector<std::string> lap_plots(const roadquery::RoadMap& map, const DriveResult& result);
/// A page of its own with both.
[[nodiscard]] std::string lap_report_html(const roadquery::RoadMap& map, const DriveResult& result);

}  // namespace orthodrive
