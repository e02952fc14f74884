// SPDX-License-Identifier: Apache-2.0
#include "roadquery/crg/crg_grid.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace roadquery {
namespace {

constexpr double missing = std::numeric_limits<double>::quiet_NaN();
constexpr double farthest_node_m = 1e8;     // as for roads
constexpr double border_rounding_m = 1e-8;  // what a place may lie beyond the grid by (the C API's dMaxBorderError)
constexpr double same_spacing_m = 1e-9;
constexpr double share_rounding = 1e-7;          // of a strip: what a place may lie beyond its ends by
constexpr int most_jumps = 16, most_walks = 80;  // from strip to strip; after the jumps one by one
constexpr std::size_t index_per_column = 4;

/// Beyond a grid's border: where to look instead, with which sign of the derivative.
struct Folded {
  double at = 0.0, sign = 1.0;
  bool outside = false;  ///< modes none, zero and keep
};

Folded fold(double value, double first, double last, CrgBorder border) {
  if (value >= first && value <= last) return {value};
  if (value >= first - border_rounding_m && value <= last + border_rounding_m) return {std::clamp(value, first, last)};
  const double size = last - first;
  if (border == CrgBorder::repeat || border == CrgBorder::reflect) {
    const double period = border == CrgBorder::repeat ? size : 2.0 * size;
    double rest = std::fmod(value - first, period);
    if (rest < 0.0) rest += period;
    if (rest <= size) return {std::min(first + rest, last)};
    return {std::max(last - (rest - size), first), -1.0};
  }
  return {std::clamp(value, first, last), 0.0, true};
}

void check_range(const std::vector<double>& values, const char* what) {
  for (const double value : values)
    if (!std::isnan(value) && !(std::abs(value) <= farthest_node_m))
      throw std::runtime_error(std::string(what) + " lies beyond 1e8 m");
}

bool evenly_spaced(const std::vector<double>& v_m) {
  const double step = (v_m.back() - v_m.front()) / static_cast<double>(v_m.size() - 1);
  for (std::size_t i = 0; i < v_m.size(); ++i)
    if (std::abs(v_m[i] - (v_m.front() + step * static_cast<double>(i))) > same_spacing_m) return false;
  return true;
}

/// Of the line at right angles to the chord from (x0, y0) to (x1, y1), in a strip of direction (c, n): metres along
/// the strip per metre of v. As the reference implementation a chord against the strip counts for nothing.
double lean_of(double x0, double y0, double x1, double y1, double c, double n) {
  const double dx = x1 - x0, dy = y1 - y0, length = std::hypot(dx, dy);
  const double along = (dx * c + dy * n) / length, left = (dy * c - dx * n) / length;
  return std::abs(along) > 1e-10 ? -left / along : 0.0;
}

bool any_of_names(const std::map<std::string, double>& values, const char* begin) {
  const auto found = values.lower_bound(begin);
  return found != values.end() && found->first.starts_with(begin);
}

}  // namespace

CrgGrid::CrgGrid(const CrgFile& file) : options_(options_of(file)) {
  CrgSurface surface = file.surface;
  scale_and_fill(surface, file.modifiers);
  check_range(surface.grid_m, "a height");
  check_range(surface.v_m, "a long section");
  check_range({surface.u_start_m, surface.u_end_m()}, "u");
  u_first_m_ = surface.u_start_m, u_last_m_ = surface.u_end_m();
  step_m_ = surface.u_increment_m, per_u_ = 1.0 / step_m_;
  fades_ = options_.smooth_begin_m > 0.0 || options_.smooth_end_m > 0.0;
  v_m_ = surface.v_m;
  if (!(u_last_m_ > u_first_m_) || !(v_m_.back() - v_m_.front() > 2.0 * border_rounding_m))
    throw std::runtime_error("the grid has no area");
  if (evenly_spaced(v_m_)) {
    per_v_ = static_cast<double>(v_m_.size() - 1) / (v_m_.back() - v_m_.front());
  } else {
    bake_column_index();
  }
  bake_heights(surface);
  bake_line(surface);
  move(surface, file.modifiers);
}

void CrgGrid::bake_heights(const CrgSurface& surface) {
  check_range(surface.z_m, "the reference line");
  check_range(surface.banking, "a banking");
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const double z : surface.grid_m)
    if (!std::isnan(z)) low = std::min(low, z), high = std::max(high, z);
  middle_z_m_ = low <= high ? 0.5 * (low + high) : 0.0;
  grid_m_.reserve(surface.grid_m.size());
  for (const double z : surface.grid_m) grid_m_.push_back(static_cast<float>(z - middle_z_m_));
  heights_.clear();
  for (std::size_t i = 0; i < surface.rows(); ++i) heights_.push_back({surface.z_m[i], surface.banking[i]});
}

void CrgGrid::bake_line(const CrgSurface& surface) {
  const std::vector<double>&x = surface.x_m, &y = surface.y_m;
  check_range(x, "the reference line");
  check_range(y, "the reference line");
  start_phi_rad_ = surface.phi_rad[1];
  strips_.clear();
  for (std::size_t i = 0; i + 1 < surface.rows(); ++i) {
    Strip strip{x[i], y[i], std::cos(surface.phi_rad[i + 1]), std::sin(surface.phi_rad[i + 1]), 0.0, 0.0, 0.0};
    const double dx = x[i + 1] - x[i], dy = y[i + 1] - y[i];
    strip.length_m = std::hypot(dx, dy);
    // Steps that rounding at a place far from the origin swallows keep their heading and length.
    if (strip.length_m > 1e-3 * step_m_) {
      strip.cos_phi = dx / strip.length_m, strip.sin_phi = dy / strip.length_m;
    } else {
      strip.length_m = step_m_;
    }
    if (i > 0) strip.lean_start = lean_of(x[i - 1], y[i - 1], x[i + 1], y[i + 1], strip.cos_phi, strip.sin_phi);
    if (i + 2 < surface.rows()) strip.lean_end = lean_of(x[i], y[i], x[i + 2], y[i + 2], strip.cos_phi, strip.sin_phi);
    strips_.push_back(strip);
  }
}

void CrgGrid::bake_column_index() {
  const std::size_t count = std::min(index_per_column * v_m_.size(), std::size_t{1} << 20);
  index_per_v_ = static_cast<double>(count) / (v_m_.back() - v_m_.front());
  std::size_t column = 0;
  for (std::size_t k = 0; k <= count; ++k) {
    const double v = v_m_.front() + static_cast<double>(k) / index_per_v_;
    while (column + 2 < v_m_.size() && v_m_[column + 1] <= v) ++column;
    column_index_.push_back(static_cast<std::uint32_t>(column));
  }
}

/// By the modifiers of a reference point, or else by those of offsets (OpenCRG 1.2, "Modifiers").
void CrgGrid::move(CrgSurface& surface, const std::map<std::string, double>& modifiers) {
  const auto value = [&](const char* name, double fallback) {
    const auto found = modifiers.find(name);
    return found != modifiers.end() ? found->second : fallback;
  };
  CrgMove move;
  if (any_of_names(modifiers, "refpoint_")) {
    const double u = value("refpoint_u", u_first_m_ + value("refpoint_u_fraction", 0.0) * (u_last_m_ - u_first_m_)) +
                     value("refpoint_u_offset", 0.0);
    const double v = modifiers.count("refpoint_v_fraction") != 0
                         ? v_m_.front() + value("refpoint_v_fraction", 0.0) * (v_m_.back() - v_m_.front())
                         : value("refpoint_v", 0.0);
    const double v_there = v + value("refpoint_v_offset", 0.0);
    const Cell cell = cell_at(std::clamp(u, u_first_m_, u_last_m_), v_m_.front());
    const Strip& strip = strips_[cell.row];
    const double lean = strip.lean_start + cell.p * (strip.lean_end - strip.lean_start);
    const double along = cell.p * strip.length_m + lean * v_there + (u - std::clamp(u, u_first_m_, u_last_m_));
    double z = evaluate(u, v_there, CrgPart::whole).z_m;
    if (std::isnan(z)) z = heights_[cell.row].z_m;
    move.center_x_m = strip.x_m + along * strip.cos_phi - v_there * strip.sin_phi;
    move.center_y_m = strip.y_m + along * strip.sin_phi + v_there * strip.cos_phi;
    move.phi_rad = value("refpoint_phi", 0.0) - surface.phi_rad[cell.row + 1];
    move.dx_m = value("refpoint_x", 0.0) - move.center_x_m;
    move.dy_m = value("refpoint_y", 0.0) - move.center_y_m;
    move.dz_m = value("refpoint_z", 0.0) - z;
  } else if (any_of_names(modifiers, "refline_offset_")) {
    move.center_x_m = value("refline_rotcenter_x", surface.x_m.front());
    move.center_y_m = value("refline_rotcenter_y", surface.y_m.front());
    move.phi_rad = value("refline_offset_phi", 0.0);
    move.dx_m = value("refline_offset_x", 0.0), move.dy_m = value("refline_offset_y", 0.0);
    move.dz_m = value("refline_offset_z", 0.0);
  } else {
    return;
  }
  move_reference_line(surface, move);
  check_range(surface.z_m, "the reference line");
  for (std::size_t i = 0; i < surface.rows(); ++i) heights_[i].z_m = surface.z_m[i];
  bake_line(surface);
}

std::size_t CrgGrid::column_at(double v_m) const {
  if (column_index_.empty()) return std::min(static_cast<std::size_t>((v_m - v_m_.front()) * per_v_), v_m_.size() - 2);
  const std::size_t k =
      std::min(static_cast<std::size_t>((v_m - v_m_.front()) * index_per_v_), column_index_.size() - 2);
  const auto begin = v_m_.begin();
  // One more to either side: v and the index are rounded.
  const std::size_t low = column_index_[k] > 0 ? column_index_[k] - 1U : 0U;
  const std::size_t high = std::min<std::size_t>(column_index_[k + 1] + 2U, v_m_.size() - 1);
  const auto after =
      std::upper_bound(begin + static_cast<std::ptrdiff_t>(low) + 1, begin + static_cast<std::ptrdiff_t>(high), v_m);
  return static_cast<std::size_t>(after - begin) - 1;
}

/// (u, v) lies within the grid.
CrgGrid::Cell CrgGrid::cell_at(double u_m, double v_m) const {
  const double row = (u_m - u_first_m_) * per_u_;
  Cell cell{std::min(static_cast<std::size_t>(row), heights_.size() - 2), column_at(v_m), 0.0, 0.0, per_v_};
  cell.p = std::min(row - static_cast<double>(cell.row), 1.0);
  if (column_index_.empty()) {
    cell.q = std::min((v_m - v_m_.front()) * per_v_ - static_cast<double>(cell.column), 1.0);
  } else {
    cell.per_v = 1.0 / (v_m_[cell.column + 1] - v_m_[cell.column]);
    cell.q = std::clamp((v_m - v_m_[cell.column]) * cell.per_v, 0.0, 1.0);
  }
  return cell;
}

CrgHeight CrgGrid::in_cell(const Cell& cell, double v_m, CrgPart part) const {
  const float* low = &grid_m_[cell.row * v_m_.size() + cell.column];
  const float* high = low + v_m_.size();
  const double z00 = low[0], along = high[0] - z00, across = low[1] - z00;
  const double twist = static_cast<double>(high[1]) - low[1] - along;
  CrgHeight height{middle_z_m_ + z00 + cell.p * along + cell.q * across + cell.p * cell.q * twist,
                   (along + cell.q * twist) * per_u_, (across + cell.p * twist) * cell.per_v};
  if (std::isnan(height.z_m)) height = with_missing(cell);
  if (part == CrgPart::grid) return height;
  const RowHeight &a = heights_[cell.row], &b = heights_[cell.row + 1];
  const double dz = b.z_m - a.z_m, db = b.banking - a.banking, banking = a.banking + cell.p * db;
  height.z_m += a.z_m + cell.p * dz + banking * v_m;
  height.dz_du += (dz + db * v_m) * per_u_;
  height.dz_dv += banking;
  return height;
}

/// A missing value does no harm on the lines where its weight is 0; the slope towards it is 0 there.
CrgHeight CrgGrid::with_missing(const Cell& cell) const {
  const float* low = &grid_m_[cell.row * v_m_.size() + cell.column];
  const float* high = low + v_m_.size();
  const auto mix = [](double from, double to, double share) {
    return share <= 0.0 ? from : share >= 1.0 ? to : from + share * (to - from);
  };
  const double z = mix(mix(low[0], low[1], cell.q), mix(high[0], high[1], cell.q), cell.p);
  if (std::isnan(z)) return {missing, missing, missing};
  const double along = mix(high[0], high[1], cell.q) - mix(low[0], low[1], cell.q);
  const double across = mix(low[1], high[1], cell.p) - mix(low[0], high[0], cell.p);
  return {middle_z_m_ + z, std::isnan(along) ? 0.0 : along * per_u_, std::isnan(across) ? 0.0 : across * cell.per_v};
}

CrgHeight CrgGrid::evaluate(double u_m, double v_m, CrgPart part) const {
  if (u_m >= u_first_m_ && u_m <= u_last_m_ && v_m >= v_m_.front() && v_m <= v_m_.back() && !fades_)
    return in_cell(cell_at(u_m, v_m), v_m, part);
  return beyond(u_m, v_m, part);
}

CrgHeight CrgGrid::beyond(double u_m, double v_m, CrgPart part) const {
  if (!std::isfinite(u_m) || !std::isfinite(v_m)) return {missing, missing, missing};
  const Folded u = fold(u_m, u_first_m_, u_last_m_, options_.border_u);
  const Folded v = fold(v_m, v_m_.front(), v_m_.back(), options_.border_v);
  if ((u.outside && options_.border_u == CrgBorder::none) || (v.outside && options_.border_v == CrgBorder::none))
    return {missing, missing, missing};
  CrgHeight height = in_cell(cell_at(u.at, v.at), v.at, part);
  height.dz_du *= u.sign, height.dz_dv *= v.sign;
  if (u.outside) {
    if (options_.border_u == CrgBorder::zero) height = {};
    height.z_m += options_.border_offset_u_m;
  }
  if (v.outside) {
    if (options_.border_v == CrgBorder::zero) height = {};
    height.z_m += options_.border_offset_v_m;
  }
  if (fades_) fade(u.outside ? u_m : u.at, part, height);
  return height;
}

/// Options BORDER_SMOOTH_UBEG and _UEND: from the reference line's end to the grid's own height.
void CrgGrid::fade(double u_m, CrgPart part, CrgHeight& height) const {
  const auto towards = [&](double base, double inside_m, double zone_m, double sign) {
    if (!(zone_m > 0.0) || inside_m > zone_m) return;
    const double share = std::max(inside_m, 0.0) / zone_m;
    height.dz_du = share * height.dz_du + (inside_m > 0.0 ? sign * (height.z_m - base) / zone_m : 0.0);
    height.dz_dv *= share;
    height.z_m = base + share * (height.z_m - base);
  };
  const bool whole = part == CrgPart::whole;
  towards(whole ? heights_.front().z_m : 0.0, u_m - u_first_m_, options_.smooth_begin_m, 1.0);
  towards(whole ? heights_.back().z_m : 0.0, u_last_m_ - u_m, options_.smooth_end_m, -1.0);
}

CrgGrid::StripFoot CrgGrid::foot_on(const Strip& strip, double x_m, double y_m) const {
  const double dx = x_m - strip.x_m, dy = y_m - strip.y_m;
  const double along = dx * strip.cos_phi + dy * strip.sin_phi, left = dy * strip.cos_phi - dx * strip.sin_phi;
  return {along - strip.lean_start * left, left, strip.length_m + (strip.lean_end - strip.lean_start) * left};
}

CrgPlace CrgGrid::place_of(std::size_t index, const StripFoot& foot) const {
  const Strip& strip = strips_[index];
  const double c = strip.cos_phi, n = strip.sin_phi;
  const double row_u = u_first_m_ + static_cast<double>(index) * step_m_;
  double share = foot.along_m / foot.between_m;
  if (share < 0.0 && index == 0)  // straight on before the first row
    return {row_u + foot.along_m, foot.left_m, c, n, -n, c};
  if (share > 1.0 && index + 1 == strips_.size())  // and behind the last
    return {u_last_m_ + foot.along_m - foot.between_m, foot.left_m, c, n, -n, c};
  share = std::clamp(share, 0.0, 1.0);
  const double per_along = step_m_ / foot.between_m;
  const double per_left = -per_along * (strip.lean_start + share * (strip.lean_end - strip.lean_start));
  return {row_u + share * step_m_, foot.left_m, per_along * c - per_left * n, per_along * n + per_left * c, -n, c};
}

std::optional<CrgPlace> CrgGrid::place(double x_m, double y_m, double u_hint_m) const {
  const auto last = static_cast<double>(strips_.size() - 1);
  const double guess = (u_hint_m - u_first_m_) * per_u_;
  double row = guess >= 0.0 ? std::min(std::floor(guess), last) : 0.0;  // NaN: 0
  for (int walks = 0; walks < most_walks; ++walks) {
    const auto index = static_cast<std::size_t>(row);
    const StripFoot foot = foot_on(strips_[index], x_m, y_m);
    if (!(foot.between_m > 0.0)) return std::nullopt;  // folded, or not a number
    const double share = foot.along_m / foot.between_m;
    if (share >= -share_rounding && share <= 1.0 + share_rounding) return place_of(index, foot);
    double steps = share < 0.0 ? -1.0 : 1.0;
    if (walks < most_jumps && std::abs(share) > 2.0) steps = std::trunc(share);
    const double next = std::clamp(row + steps, 0.0, last);
    if (next == row) return place_of(index, foot);  // beyond the end
    row = next;
  }
  return std::nullopt;
}

std::optional<CrgPlace> CrgGrid::place(double x_m, double y_m) const {
  std::size_t best = strips_.size();
  double nearest_m = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < strips_.size(); ++i) {
    const StripFoot foot = foot_on(strips_[i], x_m, y_m);
    const bool before = i > 0 && foot.along_m < 0.0;
    const bool behind = i + 1 < strips_.size() && foot.along_m > foot.between_m;
    if (!(foot.between_m > 0.0) || before || behind) continue;
    const double beyond_m = std::max({-foot.along_m, foot.along_m - foot.between_m, 0.0});
    const double distance_m = std::hypot(foot.left_m, beyond_m);
    if (distance_m < nearest_m) nearest_m = distance_m, best = i;
  }
  if (best == strips_.size()) return std::nullopt;
  return place_of(best, foot_on(strips_[best], x_m, y_m));
}

}  // namespace roadquery
