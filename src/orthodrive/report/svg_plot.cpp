// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/report/svg_plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>

#include "orthodrive/core/escape_xml.hpp"
#include "orthodrive/report/canvas.hpp"

namespace orthodrive {
namespace {

constexpr const char* ink = "#1f2933";
constexpr const char* faint_ink = "#66727f";
constexpr const char* grid_color = "#e4e8ec";
// Okabe and Ito's palette, which colour-blind readers can tell apart.
constexpr std::array palette = {"#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"};

struct Range {
  double low = std::numeric_limits<double>::infinity(), high = -std::numeric_limits<double>::infinity();
  void add(double v) {
    if (!std::isfinite(v)) return;
    low = std::min(low, v), high = std::max(high, v);
  }
  /// Never empty, so that it can be divided by.
  [[nodiscard]] Range usable(double padding) const {
    if (low > high) return {0.0, 1.0};
    const double least = 1e-9 + 1e-6 * std::max(std::abs(low), std::abs(high));
    const double pad = std::max(padding * (high - low), high - low < least ? least * 10.0 : 0.0);
    return {low - pad, high + pad};
  }
  [[nodiscard]] double size() const { return high - low; }
};

using Out = std::back_insert_iterator<std::string>;

/// A tick's text with as many decimals as the step needs.
std::string tick_text(double value, double step) {
  const int decimals = std::clamp(static_cast<int>(std::ceil(-std::log10(step) - 1e-9)), 0, 9);
  return fmt::format("{:.{}f}", std::abs(value) < 1e-9 * step ? 0.0 : value, decimals);
}

void text(std::string& svg, double x, double y, const char* anchor, const char* color, const std::string& content,
          const char* more = "") {
  fmt::format_to(Out(svg), R"(<text x="{:.1f}" y="{:.1f}" text-anchor="{}" fill="{}" {}>{}</text>)", x, y, anchor,
                 color, more, escape_xml(content));
}

std::string open_svg(int width_px, int height_px, const std::string& title) {
  std::string svg = fmt::format(
      R"(<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {0} {1}" width="{0}" height="{1}" role="img" )"
      R"(style="max-width:100%;height:auto" font-family="system-ui,sans-serif" font-size="12">)"
      R"(<title>{2}</title><rect width="{0}" height="{1}" fill="#fff"/>)",
      width_px, height_px, escape_xml(title));
  text(svg, 12, 20, "start", ink, title, R"(font-weight="600" font-size="14")");
  return svg;
}

/// Appends the polyline of a series; of the points in one half pixel column only the first, last, lowest and highest.
void append_thinned(std::string& points, std::span<const double> x_px, std::span<const double> y_px) {
  constexpr double column_px = 0.5;
  std::size_t i = 0;
  while (i < x_px.size()) {
    const double column = std::floor(x_px[i] / column_px);
    std::size_t end = i, low = i, high = i;
    for (; end < x_px.size() && std::floor(x_px[end] / column_px) == column; ++end) {
      if (y_px[end] < y_px[low]) low = end;
      if (y_px[end] > y_px[high]) high = end;
    }
    std::array<std::size_t, 4> keep = {i, std::min(low, high), std::max(low, high), end - 1};
    const auto last = std::unique(keep.begin(), keep.end());
    for (auto k = keep.begin(); k != last; ++k) fmt::format_to(Out(points), "{:.1f},{:.1f} ", x_px[*k], y_px[*k]);
    i = end;
  }
}

/// Round values between 10^low and 10^high: 1, 2, 5 times powers of ten, over many decades the powers alone.
std::vector<double> log_ticks(double low, double high) {
  if (high - low < 1.0) return round_ticks(std::pow(10.0, low), std::pow(10.0, high), 5);
  const double every = std::ceil((high - low) / 8.0);  // decades
  std::vector<double> ticks;
  for (double k = std::floor(low / every) * every; k <= high; k += every) {
    for (const double m : {1.0, 2.0, 5.0}) {
      if (m != 1.0 && high - low > 2.5) continue;
      const double at = k + std::log10(m);
      if (at >= low - 1e-9 && at <= high + 1e-9) ticks.push_back(m * std::pow(10.0, k));
    }
  }
  return ticks;
}

std::string hex(const std::array<std::uint8_t, 3>& c) { return fmt::format("#{:02x}{:02x}{:02x}", c[0], c[1], c[2]); }

}  // namespace

std::vector<double> round_ticks(double low, double high, int count) {
  if (!(high > low) || count < 1) return {};
  const double raw = (high - low) / count;
  const double power = std::pow(10.0, std::floor(std::log10(raw)));
  double step = 10.0 * power;
  for (const double m : {1.0, 2.0, 5.0}) {
    if (m * power >= raw * (1.0 - 1e-9)) {
      step = m * power;
      break;
    }
  }
  std::vector<double> ticks;
  for (double k = std::ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k += 1.0) ticks.push_back(k * step);
  return ticks;
}

namespace {

/// Where the values of a line plot lie in the picture.
struct LineAxes {
  Range x, y;  ///< y of log10 where y_log
  bool y_log = false;
  double left = 64.0, right = 0.0, top = 34.0, bottom = 0.0;

  LineAxes(std::span<const PlotSeries> series, const PlotOptions& options)
      : y_log(options.y_log), right(options.width_px - 16.0), bottom(options.height_px - 42.0) {
    for (const PlotSeries& s : series) {
      for (const double v : s.x) x.add(v);
      for (const double v : s.y) y.add(scaled(v));
    }
    if (options.y_from_zero) y.add(0.0);
    x = x.usable(0.0), y = y.usable(0.06);
  }
  [[nodiscard]] double scaled(double v) const { return y_log ? (v > 0.0 ? std::log10(v) : std::nan("")) : v; }
  [[nodiscard]] double to_x(double v) const { return left + (v - x.low) / x.size() * (right - left); }
  [[nodiscard]] double to_y(double v) const { return bottom - (scaled(v) - y.low) / y.size() * (bottom - top); }
};

void append_axes(std::string& svg, const LineAxes& axes, const PlotOptions& options) {
  const auto& [x, y, y_log, left, right, top, bottom] = axes;
  const auto x_ticks = round_ticks(x.low, x.high, 10);
  for (const double v : x_ticks) {
    fmt::format_to(Out(svg), R"(<path d="M{0:.1f} {1:.1f}V{2:.1f}" stroke="{3}"/>)", axes.to_x(v), top, bottom,
                   grid_color);
    text(svg, axes.to_x(v), bottom + 16, "middle", faint_ink,
         tick_text(v, x_ticks.size() > 1 ? x_ticks[1] - x_ticks[0] : 1.0));
  }
  const auto y_ticks = y_log ? log_ticks(y.low, y.high) : round_ticks(y.low, y.high, 5);
  for (const double v : y_ticks) {
    fmt::format_to(Out(svg), R"(<path d="M{0:.1f} {1:.1f}H{2:.1f}" stroke="{3}"/>)", left, axes.to_y(v), right,
                   v == 0.0 ? "#aab4be" : grid_color);
    text(svg, left - 8, axes.to_y(v) + 4, "end", faint_ink,
         y_log ? fmt::format("{:g}", v) : tick_text(v, y_ticks.size() > 1 ? y_ticks[1] - y_ticks[0] : 1.0));
  }
  text(svg, 0.5 * (left + right), options.height_px - 8.0, "middle", faint_ink, options.x_label);
  text(svg, 0, 0, "middle", faint_ink, options.y_label,
       fmt::format(R"x(transform="translate(16 {:.1f}) rotate(-90)")x", 0.5 * (top + bottom)).c_str());
}

/// A run of a series without gaps: its line, or a ring at each point.
void append_run(std::string& svg, const PlotSeries& series, const std::string& color, const char* dash,
                std::span<const double> x_px, std::span<const double> y_px) {
  if (x_px.empty()) return;
  if (series.dots && series.dot_radius_px < 3.0) {
    for (std::size_t k = 0; k < x_px.size(); ++k)
      fmt::format_to(Out(svg), R"(<circle cx="{:.1f}" cy="{:.1f}" r="{:g}" fill="{}"/>)", x_px[k], y_px[k],
                     series.dot_radius_px, color);
    return;
  }
  if (series.dots) {
    for (std::size_t k = 0; k < x_px.size(); ++k)
      fmt::format_to(Out(svg), R"(<circle cx="{:.1f}" cy="{:.1f}" r="{:g}" fill="#fff" stroke="{}" stroke-width="2"/>)",
                     x_px[k], y_px[k], series.dot_radius_px, color);
    return;
  }
  std::string points;
  append_thinned(points, x_px, y_px);
  points.pop_back();
  fmt::format_to(Out(svg),
                 R"(<polyline points="{}" fill="none" stroke="{}" stroke-width="{:g}" stroke-linejoin="round"{}/>)",
                 points, color, series.width, dash);
}

void append_series(std::string& svg, const PlotSeries& series, const std::string& color, const char* dash,
                   const LineAxes& axes) {
  std::vector<double> x_px, y_px;
  const auto flush = [&] {
    append_run(svg, series, color, dash, x_px, y_px);
    x_px.clear(), y_px.clear();
  };
  for (std::size_t k = 0; k < std::min(series.x.size(), series.y.size()); ++k) {
    if (std::isfinite(series.x[k]) && std::isfinite(axes.scaled(series.y[k])))
      x_px.push_back(axes.to_x(series.x[k])), y_px.push_back(axes.to_y(series.y[k]));
    else
      flush();
  }
  flush();
}

}  // namespace

std::string svg_line_plot(std::span<const PlotSeries> series, const PlotOptions& options) {
  const LineAxes axes(series, options);
  std::string svg = open_svg(options.width_px, options.height_px, options.title);
  append_axes(svg, axes, options);
  double legend_x = axes.right;
  for (std::size_t i = series.size(); i-- > 0;) {
    const PlotSeries& s = series[i];
    const std::string color = s.color.empty() ? palette[i % palette.size()] : s.color;
    const char* dash = s.dashed ? R"( stroke-dasharray="5 4")" : "";
    append_series(svg, s, color, dash, axes);
    if (s.name.empty()) continue;
    text(svg, legend_x, 20, "end", ink, s.name);
    legend_x -= 7.2 * static_cast<double>(s.name.size()) + 6.0;  // 7.2 px: a wide character at 12 px, lest lines touch
    fmt::format_to(Out(svg), R"(<path d="M{:.1f} 16h-20" stroke="{}" stroke-width="2.5"{}/>)", legend_x, color, dash);
    legend_x -= 34.0;
  }
  return svg + "</svg>\n";
}

namespace {

constexpr int color_steps = 48;
constexpr double highest_map_px = 640.0;

/// Where the places of a map plot lie in the picture, and its values in the colour bar.
struct MapFrame {
  Range value;
  double left = 12.0, right = 0.0, top = 34.0, bottom = 0.0;
  double px_per_m = 1.0, x_mid_m = 0.0, y_mid_m = 0.0;

  MapFrame(const MapLine& line, const MapPlotOptions& options) : right(options.width_px - 96.0) {
    Range x, y;
    for (const double v : line.x_m) x.add(v);
    for (const double v : line.y_m) y.add(v);
    for (const double v : line.value) value.add(v);
    const double margin_m = 0.05 * std::max(x.usable(0.0).size(), y.usable(0.0).size()) + 5.0;
    x = x.usable(0.0), y = y.usable(0.0), value = value.usable(0.0);
    x.low -= margin_m, x.high += margin_m, y.low -= margin_m, y.high += margin_m;
    px_per_m = std::min((right - left) / x.size(), (highest_map_px - top - 12.0) / y.size());
    bottom = top + std::max(px_per_m * y.size(), 160.0);
    x_mid_m = 0.5 * (x.low + x.high), y_mid_m = 0.5 * (y.low + y.high);
  }
  [[nodiscard]] double to_x(double v) const { return 0.5 * (left + right) + (v - x_mid_m) * px_per_m; }
  [[nodiscard]] double to_y(double v) const { return 0.5 * (top + bottom) - (v - y_mid_m) * px_per_m; }
  [[nodiscard]] int color_step(double v) const {
    return static_cast<int>(std::floor(std::clamp((v - value.low) / value.size(), 0.0, 1.0) * (color_steps - 1) + 0.5));
  }
};

std::string step_color(int step) { return hex(viridis(step / (color_steps - 1.0))); }

/// The series that come into the frame.
void append_background(std::string& svg, std::span<const PlotSeries> background, const MapFrame& frame) {
  for (const PlotSeries& s : background) {
    std::string points;
    bool near = false;
    for (std::size_t k = 0; k < s.x.size(); ++k) {
      const double px = frame.to_x(s.x[k]), py = frame.to_y(s.y[k]);
      near = near || (px >= frame.left && px <= frame.right && py >= frame.top && py <= frame.bottom);
      fmt::format_to(Out(points), "{:.1f},{:.1f} ", px, py);
    }
    if (!near) continue;
    points.pop_back();
    fmt::format_to(Out(svg),
                   R"(<polyline points="{}" fill="none" stroke="{}" stroke-width="2" stroke-linejoin="round"/>)",
                   points, s.color.empty() ? "#cdd4db" : s.color);
  }
}

/// Pieces of one colour step, each joined to the next by a shared point.
void append_colored_line(std::string& svg, const MapLine& line, const MapFrame& frame) {
  for (std::size_t k = 0; k + 1 < line.x_m.size();) {
    const int step = frame.color_step(line.value[k]);
    std::string points = fmt::format("{:.1f},{:.1f}", frame.to_x(line.x_m[k]), frame.to_y(line.y_m[k]));
    double last_x = frame.to_x(line.x_m[k]), last_y = frame.to_y(line.y_m[k]);
    do {
      ++k;
      const double px = frame.to_x(line.x_m[k]), py = frame.to_y(line.y_m[k]);
      const bool end = k + 1 == line.x_m.size() || frame.color_step(line.value[k]) != step;
      if (!end && std::hypot(px - last_x, py - last_y) < 1.0) continue;  // finer than the eye sees
      fmt::format_to(Out(points), " {:.1f},{:.1f}", px, py);
      last_x = px, last_y = py;
    } while (k + 1 < line.x_m.size() && frame.color_step(line.value[k]) == step);
    fmt::format_to(Out(svg),
                   R"(<polyline points="{}" fill="none" stroke="{}" stroke-width="4" stroke-linecap="round"/>)", points,
                   step_color(step));
  }
}

void append_start(std::string& svg, double px, double py, const std::string& label) {
  fmt::format_to(Out(svg), R"(<circle cx="{:.1f}" cy="{:.1f}" r="6" fill="#fff" stroke="{}" stroke-width="2.5"/>)", px,
                 py, ink);
  text(svg, px + 10, py - 8, "start", ink, label,
       R"(font-weight="600" stroke="#fff" stroke-width="3" paint-order="stroke")");
}

void append_scale_bar(std::string& svg, const MapFrame& frame) {
  const auto bars = round_ticks(0.0, 0.25 * (frame.right - frame.left) / frame.px_per_m, 2);
  const double bar_m = bars.empty() ? 1.0 : bars.back(), bar_px = bar_m * frame.px_per_m;
  fmt::format_to(Out(svg), R"(<path d="M{:.1f} {:.1f}v6h{:.1f}v-6" fill="none" stroke="{}" stroke-width="1.5"/>)",
                 frame.left + 12, frame.bottom - 18, bar_px, ink);
  text(svg, frame.left + 12 + 0.5 * bar_px, frame.bottom - 20, "middle", ink, fmt::format("{:g} m", bar_m));
}

void append_color_bar(std::string& svg, const MapFrame& frame, const std::string& label) {
  const double left = frame.right + 18, step_px = (frame.bottom - frame.top - 24) / color_steps;
  text(svg, left, frame.top + 10, "start", faint_ink, label);
  for (int i = 0; i < color_steps; ++i)
    fmt::format_to(Out(svg), R"(<rect x="{:.1f}" y="{:.1f}" width="16" height="{:.2f}" fill="{}"/>)", left,
                   frame.bottom - (i + 1) * step_px, step_px + 0.3, step_color(i));
  const auto ticks = round_ticks(frame.value.low, frame.value.high, 5);
  for (const double v : ticks)
    text(svg, left + 22, frame.bottom - (v - frame.value.low) / frame.value.size() * step_px * color_steps + 4, "start",
         faint_ink, tick_text(v, ticks.size() > 1 ? ticks[1] - ticks[0] : 1.0));
}

}  // namespace

std::string svg_map_plot(const MapLine& line, std::span<const PlotSeries> background, const MapPlotOptions& options) {
  const MapFrame frame(line, options);
  std::string svg = open_svg(options.width_px, static_cast<int>(frame.bottom + 12.0), options.title);
  fmt::format_to(Out(svg),
                 R"(<svg x="{0}" y="{1}" width="{2:.1f}" height="{3:.1f}" viewBox="{0} {1} {2:.1f} {3:.1f}">)"
                 R"(<rect x="{0}" y="{1}" width="100%" height="100%" fill="#f4f6f8"/>)",
                 frame.left, frame.top, frame.right - frame.left, frame.bottom - frame.top);
  append_background(svg, background, frame);
  append_colored_line(svg, line, frame);
  if (!options.start_label.empty() && !line.x_m.empty())
    append_start(svg, frame.to_x(line.x_m.front()), frame.to_y(line.y_m.front()), options.start_label);
  append_scale_bar(svg, frame);
  svg += "</svg>";
  append_color_bar(svg, frame, options.value_label);
  return svg + "</svg>\n";
}

std::array<std::uint8_t, 3> share_color(double share) {
  // Inferno (Smith, van der Walt 2015) at 9 places, linear between them. Up to a share of 10 % it runs with the square
  // root through three quarters of the ramp, then evenly through the rest.
  static constexpr std::array<std::array<double, 3>, 9> stops = {{{0, 0, 4},
                                                                  {31, 12, 72},
                                                                  {87, 16, 110},
                                                                  {138, 34, 106},
                                                                  {188, 55, 84},
                                                                  {227, 89, 51},
                                                                  {249, 142, 9},
                                                                  {249, 203, 53},
                                                                  {252, 255, 164}}};
  constexpr double small = 0.1, at_small = 0.75;
  const double p = std::clamp(share, 0.0, 1.0);
  const double f =
      p < small ? at_small * std::sqrt(p / small) : at_small + (1.0 - at_small) * (p - small) / (1.0 - small);
  const double at = f * (stops.size() - 1);
  const std::size_t i = std::min(static_cast<std::size_t>(at), stops.size() - 2);
  const double w = at - static_cast<double>(i);
  std::array<std::uint8_t, 3> color{};
  for (std::size_t k = 0; k < 3; ++k)
    color[k] = static_cast<std::uint8_t>(std::lround((1.0 - w) * stops[i][k] + w * stops[i + 1][k]));
  return color;
}

namespace {
/// 0.034 -> "3.4"; what rounds to nothing stays empty.
std::string bare_percent(double share) { return share < 0.0005 ? "" : fmt::format("{:.1f}", 100.0 * share); }

void append_share_bar(std::string& svg, double left, double top, double width) {
  constexpr int steps = 100;
  for (int i = 0; i < steps; ++i)  // the bar is as uneven as the colours: its middle is a share of 10 %
    fmt::format_to(Out(svg), R"(<rect x="{:.1f}" y="{:.1f}" width="{:.2f}" height="12" fill="{}"/>)",
                   left + width * i / steps, top, width / steps + 0.3,
                   hex(share_color(i < 50 ? 0.1 * i / 50 : 0.1 + 0.9 * (i - 50) / 50)));
  for (const auto& [at, label] :
       {std::pair{0.0, "0"}, {0.05, "1"}, {0.25, "5"}, {0.5, "10"}, {0.722, "50"}, {1.0, "100 %"}})
    text(svg, left + width * at, top + 26, "middle", faint_ink, label);
}
}  // namespace

std::string svg_share_matrix(std::span<const std::string> names, std::span<const double> shares,
                             const SharePlotOptions& options) {
  const std::size_t n = names.size();
  std::size_t longest = 4;
  for (const std::string& name : names) longest = std::max(longest, name.size());
  const double label_px = 6.6 * static_cast<double>(longest) + 8.0;  // 6.6 px: a wide character at 12 px
  const double left = 28.0 + label_px, top = 40.0 + 0.75 * label_px;
  const double cell = std::clamp(
      (options.width_px - left - 0.75 * label_px) / std::max<double>(1.0, static_cast<double>(n)), 12.0, 62.0);
  const double side = cell * static_cast<double>(n), bottom = top + side;
  const bool has_room = cell >= 34.0;

  // Wide enough for the last slanted name, the title and the bar.
  std::string svg = open_svg(std::max(480, static_cast<int>(left + side + 0.75 * label_px)),
                             static_cast<int>(bottom + 80.0), options.title);
  for (std::size_t i = 0; i < n; ++i) {
    const double middle = (static_cast<double>(i) + 0.5) * cell;
    text(svg, left - 6, top + middle + 4, "end", ink, names[i]);
    text(svg, 0, 0, "start", ink, names[i],
         fmt::format(R"x(transform="translate({:.1f} {:.1f}) rotate(-45)")x", left + middle + 3, top - 6).c_str());
  }
  for (std::size_t row = 0; row < n; ++row)
    for (std::size_t col = 0; col < n; ++col) {
      const double share = shares[row * n + col], x = left + static_cast<double>(col) * cell,
                   y = top + static_cast<double>(row) * cell;
      const bool empty = std::isnan(share);
      const auto color = share_color(empty ? 0.0 : share);
      fmt::format_to(Out(svg),
                     R"(<rect x="{:.1f}" y="{:.1f}" width="{:.1f}" height="{:.1f}" fill="{}" stroke="{}"><title>)", x,
                     y, cell, cell, empty ? "#e4e8ec" : hex(color), "#ffffff22");
      svg += escape_xml(empty ? fmt::format("{}: does not occur", names[row])
                              : fmt::format("{} -> {}: {:.2f} %", names[row], names[col], 100.0 * share));
      svg += "</title></rect>";
      const bool dark = 2 * color[0] + 3 * color[1] + color[2] < 800;
      if (has_room && !empty && !bare_percent(share).empty())
        text(svg, x + 0.5 * cell, y + 0.5 * cell + 4, "middle", dark ? "#fff" : ink, bare_percent(share));
    }
  for (std::size_t i = 0; i < n; ++i)
    fmt::format_to(
        Out(svg),
        R"(<rect x="{0:.1f}" y="{1:.1f}" width="{2:.1f}" height="{2:.1f}" fill="none" stroke="#56b4e9" stroke-width="1.5"/>)",
        left + static_cast<double>(i) * cell, top + static_cast<double>(i) * cell, cell);
  text(svg, 0, 0, "middle", faint_ink, options.row_label,
       fmt::format(R"x(transform="translate(16 {:.1f}) rotate(-90)")x", top + 0.5 * side).c_str());
  text(svg, left + 0.5 * side, bottom + 18, "middle", faint_ink, options.column_label);
  append_share_bar(svg, left, bottom + 34, std::min(side, 420.0));
  return svg + "</svg>\n";
}

}  // namespace orthodrive
