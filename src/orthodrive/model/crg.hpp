#pragma once
// A road surface as a curved regular grid (ASAM OpenCRG 1.2): heights over a reference line of equal steps.
//   z(u, v) = z of the reference line + banking(u) v + grid(u, v), bilinear between the rows u_i and the columns v_j.
// The reference line is a polyline; the (u, v) lines across it halve its bends (chapter "Evaluation": the strip between
// two rows is bounded by the lines through its two points at right angles to the chord over both neighbours).

#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "orthodrive/geo/vec.hpp"

namespace orthodrive {

/// How values are stored: L = formatted text (R 10, D 20 characters a value), K = binary, big-endian (R 4, D 8 bytes).
enum class CrgFormat { lrfi, ldfi, krbi, kdbi };
[[nodiscard]] const char* name_of(CrgFormat format);

struct CrgSurface {
  std::string comment;  ///< free text, lines apart by '\n'
  double u_start_m = 0.0, u_increment_m = 1.0;
  // One value a row. phi and slope hold for the step that ends at the row; those of row 0 repeat row 1's.
  std::vector<double> phi_rad, slope;
  std::vector<double> banking;        ///< dz/dv at the row
  std::vector<double> x_m, y_m, z_m;  ///< reference line; integrate_reference_line() makes them of the above
  std::vector<double> v_m;            ///< of the columns, strictly ascending: right (negative) to left
  std::vector<double> grid_m;         ///< rows x columns; NaN: missing

  [[nodiscard]] std::size_t rows() const { return phi_rad.size(); }
  [[nodiscard]] std::size_t columns() const { return v_m.size(); }
  [[nodiscard]] double grid(std::size_t row, std::size_t column) const { return grid_m[row * columns() + column]; }
  [[nodiscard]] double u_end_m() const { return u_start_m + u_increment_m * (static_cast<double>(rows()) - 1.0); }
};

/// x, y, z of the reference line by steps of u_increment_m from (x0, y0, z0).
void integrate_reference_line(CrgSurface& surface, double x0, double y0, double z0);

struct CrgUv {
  double u_m = 0.0, v_m = 0.0;
};

/// Place of (u, v) in the plane; beyond the first and the last row straight on.
[[nodiscard]] Vec2 crg_xy(const CrgSurface& surface, CrgUv uv);
/// The inverse, nearest to the reference line where several are. Nothing beside the rows' range. With a hint u the
/// search walks from there; without one it looks at all rows.
[[nodiscard]] std::optional<CrgUv> crg_uv(const CrgSurface& surface, Vec2 xy,
                                          double u_hint_m = std::numeric_limits<double>::quiet_NaN());
/// Height at (u, v); NaN outside the grid and where a value it depends on is missing.
[[nodiscard]] double crg_height(const CrgSurface& surface, CrgUv uv);

}  // namespace orthodrive
