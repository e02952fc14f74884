// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/roads/tile_crossings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <optional>

#include "orthodrive/scene/plan/plan_grid.hpp"
#include "orthodrive/scene/plan/tile_address.hpp"

namespace orthodrive::scene {
namespace {

constexpr double shortest_m = 0.1;  // of pieces

/// Along one border.
class Crossing {
 public:
  Crossing(const RoadLevel& level, double tolerance_m, const std::function<Vec2(double)>& at)
      : level_(level), tolerance_m_(tolerance_m), at_(at) {}

  [[nodiscard]] std::vector<double> refined(const std::vector<double>& positions) {
    result_.clear();
    for (std::size_t i = 0; i < positions.size(); ++i) {
      if (i > 0 && level_.outline().contains(at_(middle(positions[i - 1], positions[i]))))
        split(positions[i - 1], positions[i]);
      result_.push_back(positions[i]);
    }
    return std::move(result_);
  }

 private:
  static double middle(double low, double high) { return std::round(0.5 * (low + high) / plan_grid_m) * plan_grid_m; }
  [[nodiscard]] std::optional<double> height_m(double position) const {
    const auto on = level_.sample(at_(position));
    return on ? std::optional(on->z_m) : std::nullopt;
  }
  [[nodiscard]] bool is_straight(double low, double high) const {
    const auto z_low = height_m(low), z_high = height_m(high);
    if (!z_low || !z_high) return true;
    return std::ranges::all_of(std::array{0.25, 0.5, 0.75}, [&](double share) {
      const auto z = height_m(low + share * (high - low));
      return !z || std::abs(*z - (*z_low + share * (*z_high - *z_low))) <= tolerance_m_;
    });
  }
  void split(double low, double high) {
    if (high - low < 2.0 * shortest_m || is_straight(low, high)) return;
    const double at = middle(low, high);
    split(low, at);
    result_.push_back(at);
    split(at, high);
  }

  const RoadLevel& level_;
  double tolerance_m_;
  const std::function<Vec2(double)>& at_;
  std::vector<double> result_;
};

}  // namespace

void add_road_crossings(const RoadLevel& level, double tolerance_m, std::map<int, std::vector<double>>& on_west,
                        std::map<int, std::vector<double>>& on_south) {
  for (auto& [column, positions] : on_west) {
    const std::function<Vec2(double)> at = [x = column * scene_tile_m](double y) { return Vec2{x, y}; };
    positions = Crossing(level, tolerance_m, at).refined(positions);
  }
  for (auto& [row, positions] : on_south) {
    const std::function<Vec2(double)> at = [y = row * scene_tile_m](double x) { return Vec2{x, y}; };
    positions = Crossing(level, tolerance_m, at).refined(positions);
  }
}

}  // namespace orthodrive::scene
