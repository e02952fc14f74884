// SPDX-License-Identifier: Apache-2.0
#pragma once
// The offset of one node by GPS traces.

namespace orthodrive::refine {

struct TraceOffset {
  double offset_m = 0.0;  ///< of the middle of the road along the node's normal
  /// sqrt(gps^2 / recordings + lane^2). The error is nearly the same at nodes nearby: receivers err slowly.
  double sigma_m = 0.0;
  double recordings = 0.0;  ///< number after outlier rejection; 0: nothing is known here
};

}  // namespace orthodrive::refine
