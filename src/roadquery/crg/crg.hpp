// SPDX-License-Identifier: Apache-2.0
#pragma once
// A road surface as a curved regular grid (ASAM OpenCRG 1.2): heights over a reference line of equal steps.
//   z(u, v) = z of the reference line + banking(u) v + grid(u, v), bilinear between the rows u_i and the columns v_j.
// The reference line is a polyline; the (u, v) lines across it halve its bends (chapter "Evaluation": the strip between
// two rows is bounded by the lines through its two points at right angles to the chord over both neighbours).

#include <cstddef>
#include <map>
#include <string>
#include <vector>

namespace roadquery {

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

/// A file as it stands: its values, and what it asks of their evaluation.
struct CrgFile {
  CrgSurface surface;
  CrgFormat format = CrgFormat::krbi;
  std::map<std::string, double> options, modifiers;  ///< $ROAD_CRG_OPTS and _MODS, names in lower case
  std::vector<std::string> notes;                    ///< what is not applied or was mended, each one sentence
};

/// What lies beyond the grid (options BORDER_MODE_U and _V).
enum class CrgBorder { none, zero, keep, repeat, reflect };
struct CrgOptions {
  CrgBorder border_u = CrgBorder::keep, border_v = CrgBorder::keep;
  double border_offset_u_m = 0.0, border_offset_v_m = 0.0;  ///< added beyond the border in the modes zero and keep
  double smooth_begin_m = 0.0, smooth_end_m = 0.0;  ///< over which heights fade to the reference line's at its ends
};

/// The options that change heights; those of search, checks and messages are passed over. Throws std::runtime_error
/// for a border mode that is none.
[[nodiscard]] CrgOptions options_of(const CrgFile& file);

/// Applies the modifiers of scale, and fills missing values (GRID_NAN_MODE, without it 2: as the value beside it).
/// Throws std::runtime_error for a scale of length or width that is not positive and for a mode that is none.
void scale_and_fill(CrgSurface& surface, const std::map<std::string, double>& modifiers);

/// How the modifiers move the reference line: turned by `phi_rad` about (x, y), then moved by (dx, dy, dz).
struct CrgMove {
  double center_x_m = 0.0, center_y_m = 0.0, phi_rad = 0.0, dx_m = 0.0, dy_m = 0.0, dz_m = 0.0;
};
void move_reference_line(CrgSurface& surface, const CrgMove& move);

}  // namespace roadquery
