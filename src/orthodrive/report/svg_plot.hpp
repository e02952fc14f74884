// SPDX-License-Identifier: Apache-2.0
#pragma once
// Plots for reports as inline SVG: no script, no style sheet, no file beside it.

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace orthodrive {

/// One line of a plot; x and y have the same length. NaN in y interrupts the line.
struct PlotSeries {
  std::string name;  ///< in the legend; empty: not listed
  std::vector<double> x, y;
  std::string color;  ///< "#rrggbb"; empty: the next of the palette
  bool dashed = false;
  bool dots = false;           ///< a ring at each point instead of the line
  double width = 1.5;          ///< of the line, px
  double dot_radius_px = 5.0;  ///< below 3 filled dots instead of rings
};

struct PlotOptions {
  std::string title, x_label, y_label;
  int width_px = 960, height_px = 260;
  bool y_from_zero = false;  ///< the y axis includes 0
  bool y_log = false;        ///< decadic; values that are not above 0 interrupt the line
};

/// Lines over a common x axis, with ticks at round numbers and a legend. Long series are thinned to the extremes of
/// each half pixel, so no peak is lost.
[[nodiscard]] std::string svg_line_plot(std::span<const PlotSeries> series, const PlotOptions& options = {});

/// A line in the plane, coloured by a value.
struct MapLine {
  std::vector<double> x_m, y_m, value;  ///< one value a point
};
struct MapPlotOptions {
  std::string title, value_label;
  int width_px = 960;
  std::string start_label;  ///< marks the line's first point; empty: no mark
};
/// The coloured line with equal scales, north up, a scale bar and a colour bar. `background` is drawn under it in grey
/// (other roads), cut to the surroundings of the line.
[[nodiscard]] std::string svg_map_plot(const MapLine& line, std::span<const PlotSeries> background,
                                       const MapPlotOptions& options = {});

/// Shares of a whole by row and column, as of a confusion matrix whose rows add up to 1.
struct SharePlotOptions {
  std::string title, row_label, column_label;
  int width_px = 960;  ///< at most, while fields keep 12 px
};
/// One field a pair, coloured by share_color, outlined on the diagonal; percentages stand in it where there is room and
/// in its tooltip. `shares` has names.size() squared values, row by row; rows of NaN (nothing to share out) stay empty.
[[nodiscard]] std::string svg_share_matrix(std::span<const std::string> names, std::span<const double> shares,
                                           const SharePlotOptions& options = {});
/// Black over purple and orange to pale yellow. It exaggerates small shares: 1 % can be told from 0, 10 % is bright
/// orange (thesis, figure 2.15).
[[nodiscard]] std::array<std::uint8_t, 3> share_color(double share);

/// At most about `count` round numbers (1, 2 or 5 times a power of ten apart) inside [low, high].
[[nodiscard]] std::vector<double> round_ticks(double low, double high, int count);

}  // namespace orthodrive
