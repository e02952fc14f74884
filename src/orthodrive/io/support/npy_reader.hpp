// SPDX-License-Identifier: Apache-2.0
#pragma once
// NumPy's .npy files, as far as measurements need them.

#include <cstddef>
#include <filesystem>
#include <vector>

namespace orthodrive::io {

struct NpyTable {
  std::size_t rows = 0, columns = 1;  ///< a 1-D array is one column
  std::vector<double> values;         ///< row by row

  [[nodiscard]] double at(std::size_t row, std::size_t column = 0) const { return values[row * columns + column]; }
};

/// A 1-D or 2-D array of little-endian float32, float64, (u)int8 ... (u)int64, in C or Fortran order, format 1.0 to 3.0
/// (numpy/lib/format.py). Throws InputError for a missing file, other contents and one that is cut off.
[[nodiscard]] NpyTable read_npy(const std::filesystem::path& file);

}  // namespace orthodrive::io
