// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace roadquery {

/// The cubic p(x) in powers of x - by.
inline void shift_cubic(const double (&p)[4], double by, double (&shifted)[4]) {
  shifted[0] = p[0] + by * (p[1] + by * (p[2] + by * p[3]));
  shifted[1] = p[1] + by * (2.0 * p[2] + by * 3.0 * p[3]);
  shifted[2] = p[2] + by * 3.0 * p[3];
  shifted[3] = p[3];
}

}  // namespace roadquery
