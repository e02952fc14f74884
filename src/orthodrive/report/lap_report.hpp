// SPDX-License-Identifier: Apache-2.0
#pragma once
// A lap for people: numbers, plots, a page.

#include <string>
#include <utility>
#include <vector>

#include "orthodrive/drive/drive_route.hpp"

namespace orthodrive {

/// The numbers of a lap for tables: label and value with unit.
[[nodiscard]] std::vector<std::pair<std::string, std::string>> lap_numbers(const DriveResult& result);
/// The plots of a lap, each an inline SVG: map by speed; speed and lateral acceleration over the distance (thesis,
/// figure 4.4); g-g diagram; pedals, gear, steering, tyre loads, accelerations, height, gradient, roll and pitch.
[[nodiscard]] std::vector<std::string> lap_plots(const roadquery::RoadMap& map, const DriveResult& result);
/// A page of its own with both.
[[nodiscard]] std::string lap_report_html(const roadquery::RoadMap& map, const DriveResult& result);

}  // namespace orthodrive
