// SPDX-License-Identifier: Apache-2.0
#pragma once
// An OpenCRG file made ready to be asked thousands of times a second: modifiers applied, heights in one table, the
// reference line as strips. The definition it must agree with is orthodrive/model/roads/crg_geometry.hpp.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "roadquery/crg/crg.hpp"

namespace roadquery {

/// Height at a place of the grid and its derivatives; z is NaN where the file defines none.
struct CrgHeight {
  double z_m = 0.0, dz_du = 0.0, dz_dv = 0.0;
};

/// Which part of a file's height: the grid alone, or with the reference line's height and the banking.
enum class CrgPart { grid, whole };

/// A place of the plane in the file's own (u, v), and how they change with x and y.
struct CrgPlace {
  double u_m = 0.0, v_m = 0.0;
  double du_dx = 0.0, du_dy = 0.0, dv_dx = 0.0, dv_dy = 0.0;
};

/// Heights are kept as 4-byte floats about their middle: 1e-7 of the grid's range. Everything is const, allocates
/// nothing after construction and may be called from many threads.
class CrgGrid {
 public:
  /// Applies the modifiers: scale, missing values (without a modifier as the nearest value of the row, as OpenCRG's
  /// tools do), then the move by a reference point or by offsets; a file without modifiers stays where it is. Throws
  /// std::runtime_error for modifiers and options out of range, and for heights and places beyond 1e8 m.
  explicit CrgGrid(const CrgFile& file);

  /// Bilinear in the cell of (u, v); beyond the grid and near its ends as the file's options say.
  [[nodiscard]] CrgHeight evaluate(double u_m, double v_m, CrgPart part) const;

  /// (u, v) of a place in the file's own coordinates. The search walks along the reference line from u_hint: one or
  /// two steps where the hint is good. Beyond its ends the line goes on straight. Nothing where the strips across
  /// the line fold over each other, far inside a bend.
  [[nodiscard]] std::optional<CrgPlace> place(double x_m, double y_m, double u_hint_m) const;
  /// The same without a hint: the strip whose reference line is nearest. Linear in the rows.
  [[nodiscard]] std::optional<CrgPlace> place(double x_m, double y_m) const;

  [[nodiscard]] double u_first_m() const { return u_first_m_; }
  [[nodiscard]] double u_last_m() const { return u_last_m_; }
  [[nodiscard]] double v_first_m() const { return v_m_.front(); }
  [[nodiscard]] double v_last_m() const { return v_m_.back(); }
  /// Where the reference line starts, and the heading of its first step.
  [[nodiscard]] double start_x_m() const { return strips_.front().x_m; }
  [[nodiscard]] double start_y_m() const { return strips_.front().y_m; }
  [[nodiscard]] double start_phi_rad() const { return start_phi_rad_; }
  [[nodiscard]] std::size_t rows() const { return heights_.size(); }
  [[nodiscard]] std::size_t columns() const { return v_m_.size(); }

 private:
  /// Between two rows. The lines across it at its start and end lean by `lean` metres along it per metre of v.
  struct Strip {
    double x_m, y_m, cos_phi, sin_phi, length_m, lean_start, lean_end;
  };
  struct RowHeight {
    double z_m, banking;  ///< of the reference line
  };
  struct Cell {
    std::size_t row, column;
    double p, q;  ///< shares of the way to the next row and column
    double per_v;
  };
  struct StripFoot {
    double along_m, left_m, between_m;  ///< between: length of the strip at this v; negative where folded
  };

  void bake_heights(const CrgSurface& surface);
  void bake_line(const CrgSurface& surface);
  void bake_column_index();
  void move(CrgSurface& surface, const std::map<std::string, double>& modifiers);
  [[nodiscard]] std::size_t column_at(double v_m) const;
  [[nodiscard]] Cell cell_at(double u_m, double v_m) const;
  [[nodiscard]] CrgHeight in_cell(const Cell& cell, double v_m, CrgPart part) const;
  [[nodiscard]] CrgHeight with_missing(const Cell& cell) const;
  [[nodiscard]] CrgHeight beyond(double u_m, double v_m, CrgPart part) const;
  void fade(double u_m, CrgPart part, CrgHeight& height) const;
  [[nodiscard]] StripFoot foot_on(const Strip& strip, double x_m, double y_m) const;
  [[nodiscard]] CrgPlace place_of(std::size_t strip, const StripFoot& foot) const;

  CrgOptions options_;
  double u_first_m_ = 0.0, u_last_m_ = 0.0, step_m_ = 1.0, per_u_ = 1.0, start_phi_rad_ = 0.0;
  bool fades_ = false;
  std::vector<double> v_m_;
  double per_v_ = 0.0;        ///< of evenly spaced columns; else 0
  double index_per_v_ = 0.0;  ///< of column_index_
  std::vector<std::uint32_t>
      column_index_;  ///< for columns at uneven distances: the column at or right of each of many v
  double middle_z_m_ = 0.0;
  std::vector<float> grid_m_;       ///< rows x columns, less middle_z_m_
  std::vector<RowHeight> heights_;  ///< a row
  std::vector<Strip> strips_;       ///< rows - 1
};

}  // namespace roadquery
