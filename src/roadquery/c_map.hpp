// SPDX-License-Identifier: Apache-2.0
#pragma once
// What an rq_map is. For the files of the C interface alone.

#include "roadquery/query/ground_query.hpp"
#include "roadquery/roadquery.h"

struct rq_map {
  roadquery::GroundQuery ground;

  /// Index of the road with that OpenDRIVE id, or -1.
  [[nodiscard]] int road_index(int32_t id) const;
  [[nodiscard]] const roadquery::RoadMap& roads() const { return ground.roads().map(); }
};
