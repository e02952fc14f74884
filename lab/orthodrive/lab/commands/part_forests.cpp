// SPDX-License-Identifier: Apache-2.0
// What the part "forests" gives out.

#include "orthodrive/lab/training/parts.hpp"

extern "C" const orthodrive::ForestsPart* orthodrive_part_forests() {
  static constexpr orthodrive::ForestsPart functions{
      .road_mask_of = orthodrive::road_mask_of,
      .road_mask = orthodrive::road_mask,
      .train_road_forests = orthodrive::train_road_forests,
      .save_road_forests = orthodrive::save_road_forests,
      .load_road_forests = orthodrive::load_road_forests,
      .mrf_photo_evidence = orthodrive::mrf_photo_evidence,
      .refine_roads_mrf = orthodrive::refine_roads_mrf,
  };
  return &functions;
}
