// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/refine/weight_table.hpp"

#include <array>

namespace orthodrive {
namespace {
constexpr std::array table{
    NamedWeight{"evidence", &RefineWeights::evidence},
    NamedWeight{"loss_scale", &RefineWeights::loss_scale},
    NamedWeight{"angle", &RefineWeights::angle},
    NamedWeight{"curvature", &RefineWeights::curvature},
    NamedWeight{"width", &RefineWeights::width},
    NamedWeight{"offset", &RefineWeights::offset},
    NamedWeight{"map_shift_m", &RefineWeights::map_shift_m},
    NamedWeight{"way_shift_m", &RefineWeights::way_shift_m},
    NamedWeight{"node_shift_m", &RefineWeights::node_shift_m},
    NamedWeight{"misplaced_sigmas", &RefineWeights::misplaced_sigmas},
    NamedWeight{"node_width_share", &RefineWeights::node_width_share},
    NamedWeight{"input_width", &RefineWeights::input_width},
    NamedWeight{"seen_sigma", &RefineWeights::seen_sigma},
    NamedWeight{"search_step", &RefineWeights::search_step},
    NamedWeight{"search_offset_m", &RefineWeights::search_offset_m},
    NamedWeight{"search_width_share", &RefineWeights::search_width_share},
};
static_assert(sizeof(RefineWeights) == table.size() * sizeof(double), "a member of RefineWeights is not in the table");
}  // namespace

std::span<const NamedWeight> refine_weight_table() { return table; }

}  // namespace orthodrive
