// SPDX-License-Identifier: Apache-2.0
#pragma once
// Classification errors counted pixel by pixel in a strip beside a road's border: the sums of eq. 3.3 of "From Aerial
// Images to Virtual Driving Environments" (2016), sec. 3.3.2.

#include <array>

#include "orthodrive/model/rasters/rasters.hpp"

namespace orthodrive::baselines {

/// c of eq. 3.3 for each label value. The entry at label_nodata also stands for pixels outside the raster.
struct LabelCosts {
  std::array<float, 256> outside;  ///< false positives: in the context strips
  std::array<float, 256> inside;   ///< false negatives: in the boundary strips
};
/// The costs of the class table, but vegetation inside a road costs 1 as in thesis table 3.2; in our default table it
/// costs 0.5. A pixel without a label costs `unlabelled_cost` (0 to 1) inside and 0 outside.
[[nodiscard]] LabelCosts label_costs(const ClassTable& classes, double unlabelled_cost);

/// A quadrilateral along a piece of a road's border, in the site CRS. It may fold over itself in a tight bend.
struct LabelStrip {
  Vec2 border_a, border_b;  ///< on the border of the road
  Vec2 far_a, far_b;        ///< `width_m` away from it
  double width_m = 1.25;
};

/// The two sums of eq. 3.3; those of several strips are added.
struct StripSum {
  double cost = 0.0;      ///< sum c d
  double weight = 0.0;    ///< sum d
  bool labelled = false;  ///< whether any of the pixels has a label
  /// 0 where there is no pixel.
  [[nodiscard]] double mean() const { return weight > 0.0 ? cost / weight : 0.0; }
};

/// Adds the pixels of the labels whose centre lies in the strip (even-odd). d rises linearly from 0 on the line through
/// the border to 1 at width_m from it (figure 3.6). The grid of the labels goes on beyond the raster. A scan over rows
/// without allocation.
void add_strip(const LabelMap& labels, const std::array<float, 256>& costs, const LabelStrip& strip, StripSum& sum);

}  // namespace orthodrive::baselines
