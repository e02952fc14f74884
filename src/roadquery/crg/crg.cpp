// SPDX-License-Identifier: Apache-2.0
#include "roadquery/crg/crg.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace roadquery {
namespace {

double value_of(const std::map<std::string, double>& values, const char* name, double fallback) {
  const auto found = values.find(name);
  return found != values.end() ? found->second : fallback;
}

CrgBorder border_of(const std::map<std::string, double>& options, const char* name) {
  const double mode = value_of(options, name, 2.0);
  for (const auto& [number, border] :
       {std::pair{0.0, CrgBorder::none}, std::pair{1.0, CrgBorder::zero}, std::pair{2.0, CrgBorder::keep},
        std::pair{3.0, CrgBorder::repeat}, std::pair{4.0, CrgBorder::reflect}})
    if (mode == number) return border;
  throw std::runtime_error(std::string("option ") + name + " is " + std::to_string(mode) + ", need 0, 1, 2, 3 or 4");
}

double positive(const std::map<std::string, double>& modifiers, const char* name) {
  const double scale = value_of(modifiers, name, 1.0);
  if (!(scale > 0.0)) throw std::runtime_error(std::string("modifier ") + name + " is not positive");
  return scale;
}

/// Headings change from step to step by `scale` times what they did.
void scale_curvature(CrgSurface& s, double scale) {
  double before = s.phi_rad[1], heading = before;
  for (std::size_t i = 1; i < s.rows(); ++i) {
    heading += scale * std::remainder(s.phi_rad[i] - before, 2.0 * M_PI);
    before = s.phi_rad[i];
    s.phi_rad[i] = heading;
    s.x_m[i] = s.x_m[i - 1] + s.u_increment_m * std::cos(heading);
    s.y_m[i] = s.y_m[i - 1] + s.u_increment_m * std::sin(heading);
  }
  s.phi_rad[0] = s.phi_rad[1];
}

void scale_length(CrgSurface& s, double scale) {
  s.u_increment_m *= scale;
  for (std::vector<double>* line : {&s.x_m, &s.y_m, &s.z_m}) {
    const double first = line->front();
    for (double& value : *line) value = first + scale * (value - first);
  }
}

/// Missing values of one row: between known ones on the straight line, beyond the last one as that plus `offset_m`.
/// False when the row has no value.
bool fill_row(double* row, const std::vector<double>& v_m, double offset_m) {
  const std::size_t columns = v_m.size();
  std::size_t known = columns;  // the last one before j
  for (std::size_t j = 0; j < columns; ++j) {
    if (std::isnan(row[j])) continue;
    if (known == columns) {
      std::fill(row, row + j, row[j] + offset_m);
    } else {
      for (std::size_t k = known + 1; k < j; ++k)
        row[k] = row[known] + (row[j] - row[known]) * ((v_m[k] - v_m[known]) / (v_m[j] - v_m[known]));
    }
    known = j;
  }
  if (known == columns) return false;
  std::fill(row + known + 1, row + columns, row[known] + offset_m);
  return true;
}

void fill_missing(CrgSurface& s, double offset_m) {
  const std::size_t columns = s.columns(), none = s.rows();
  std::vector<std::size_t> before(s.rows(), none), after(s.rows(), none);  // the nearest row with values
  for (std::size_t i = 0; i < s.rows(); ++i) {
    const bool filled = fill_row(&s.grid_m[i * columns], s.v_m, offset_m);
    before[i] = filled ? i : i > 0 ? before[i - 1] : none;
  }
  for (std::size_t i = s.rows(); i-- > 0;) after[i] = before[i] == i ? i : i + 1 < s.rows() ? after[i + 1] : none;
  for (std::size_t i = 0; i < s.rows(); ++i) {
    if (before[i] == i || (before[i] == none && after[i] == none)) continue;
    const bool nearer_before = after[i] == none || (before[i] != none && i - before[i] <= after[i] - i);
    const auto from = s.grid_m.begin() + static_cast<std::ptrdiff_t>((nearer_before ? before[i] : after[i]) * columns);
    std::copy_n(from, columns, s.grid_m.begin() + static_cast<std::ptrdiff_t>(i * columns));
  }
}

}  // namespace

const char* name_of(CrgFormat format) {
  switch (format) {
    case CrgFormat::lrfi:
      return "LRFI";
    case CrgFormat::ldfi:
      return "LDFI";
    case CrgFormat::krbi:
      return "KRBI";
    case CrgFormat::kdbi:
      break;
  }
  return "KDBI";
}

void integrate_reference_line(CrgSurface& s, double x0, double y0, double z0) {
  const std::size_t rows = s.rows();
  s.x_m.assign(rows, x0), s.y_m.assign(rows, y0), s.z_m.assign(rows, z0);
  for (std::size_t i = 1; i < rows; ++i) {
    s.x_m[i] = s.x_m[i - 1] + s.u_increment_m * std::cos(s.phi_rad[i]);
    s.y_m[i] = s.y_m[i - 1] + s.u_increment_m * std::sin(s.phi_rad[i]);
    s.z_m[i] = s.z_m[i - 1] + s.u_increment_m * s.slope[i];
  }
}

CrgOptions options_of(const CrgFile& file) {
  CrgOptions options;
  options.border_u = border_of(file.options, "border_mode_u");
  options.border_v = border_of(file.options, "border_mode_v");
  options.border_offset_u_m = value_of(file.options, "border_offset_u", 0.0);
  options.border_offset_v_m = value_of(file.options, "border_offset_v", 0.0);
  options.smooth_begin_m = value_of(file.options, "border_smooth_ubeg", 0.0);
  options.smooth_end_m = value_of(file.options, "border_smooth_uend", 0.0);
  return options;
}

void scale_and_fill(CrgSurface& s, const std::map<std::string, double>& modifiers) {
  const double z_scale = value_of(modifiers, "scale_z_grid", 1.0),
               slope_scale = value_of(modifiers, "scale_slope", 1.0);
  const double banking_scale = value_of(modifiers, "scale_banking", 1.0);
  const double z0 = s.z_m.front(), width_scale = positive(modifiers, "scale_width");
  for (double& z : s.grid_m) z *= z_scale;
  for (double& slope : s.slope) slope *= slope_scale;
  for (double& z : s.z_m) z = z0 + slope_scale * (z - z0);
  for (double& banking : s.banking) banking *= banking_scale;
  for (double& v : s.v_m) v *= width_scale;
  if (const double scale = positive(modifiers, "scale_length"); scale != 1.0) scale_length(s, scale);
  if (const double scale = value_of(modifiers, "scale_curvature", 1.0); scale != 1.0) scale_curvature(s, scale);

  const double mode = value_of(modifiers, "grid_nan_mode", 2.0), offset_m = value_of(modifiers, "grid_nan_offset", 0.0);
  if (mode == 1.0) {
    std::replace_if(
        s.grid_m.begin(), s.grid_m.end(), [](double z) { return std::isnan(z); }, offset_m);
  } else if (mode == 2.0) {
    fill_missing(s, offset_m);
  } else if (mode != 0.0) {
    throw std::runtime_error("modifier grid_nan_mode is " + std::to_string(mode) + ", need 0, 1 or 2");
  }
}

void move_reference_line(CrgSurface& s, const CrgMove& move) {
  const double c = std::cos(move.phi_rad), n = std::sin(move.phi_rad);
  for (std::size_t i = 0; i < s.rows(); ++i) {
    const double dx = s.x_m[i] - move.center_x_m, dy = s.y_m[i] - move.center_y_m;
    s.x_m[i] = move.center_x_m + c * dx - n * dy + move.dx_m;
    s.y_m[i] = move.center_y_m + n * dx + c * dy + move.dy_m;
    s.z_m[i] += move.dz_m;
    s.phi_rad[i] += move.phi_rad;
  }
}

}  // namespace roadquery
