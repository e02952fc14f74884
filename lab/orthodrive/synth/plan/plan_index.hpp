// SPDX-License-Identifier: Apache-2.0
#pragma once
// What of a large plan touches a box: so that a tile of a region costs what lies in it.

#include <vector>

#include "orthodrive/geo/spatial_index.hpp"
#include "orthodrive/synth/plan/site_plan.hpp"

namespace orthodrive::synth {

class PlanIndex {
 public:
  /// Does not keep the plan.
  explicit PlanIndex(const SitePlan& plan);
  /// Roads whose surface touches the box, by road, in whole pieces of up to 64 m that do not depend on the box. Closed
  /// roads come whole.
  [[nodiscard]] std::vector<Stretch> stretches(const Box2& box) const;
  /// Areas of the plan, ascending.
  [[nodiscard]] std::vector<std::size_t> areas(const Box2& box) const;

 private:
  std::vector<Stretch> pieces_;  // by road, along it
  SpatialIndex piece_index_, area_index_;
};

}  // namespace orthodrive::synth
