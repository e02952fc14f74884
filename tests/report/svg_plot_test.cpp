// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/report/svg_plot.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace orthodrive {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

std::size_t count(const std::string& text, const std::string& what) {
  std::size_t n = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++n;
  return n;
}

TEST(SvgPlot, ticks_are_round_and_inside) {
  EXPECT_THAT(round_ticks(0.0, 10.0, 5), ElementsAre(0.0, 2.0, 4.0, 6.0, 8.0, 10.0));
  EXPECT_THAT(round_ticks(-0.13, 0.12, 5), ElementsAre(-0.1, -0.05, 0.0, 0.05, 0.1));
  EXPECT_THAT(round_ticks(213.2, 214.1, 2), ElementsAre(213.5, 214.0));
  EXPECT_TRUE(round_ticks(1.0, 1.0, 5).empty());
  EXPECT_TRUE(round_ticks(std::nan(""), 1.0, 5).empty());
}

TEST(SvgPlot, long_series_are_thinned_but_keep_their_peak) {
  PlotSeries series{"noise", {}, {}, "#123456", false};
  for (int i = 0; i < 200000; ++i) {
    series.x.push_back(i), series.y.push_back(i == 123456 ? 100.0 : i % 7);
  }
  const PlotOptions options{.title = "T", .height_px = 260};
  const std::string svg = svg_line_plot(std::vector{series}, options);
  EXPECT_LT(svg.size(), 200000u);
  // The peak is the top of the range: 6 % below the upper end of the plot area (34 .. 218 px).
  const double top = 218.0 - (1.06 / 1.12) * 184.0;
  char text[16];
  std::snprintf(text, sizeof text, ",%.1f ", top);
  EXPECT_THAT(svg, HasSubstr(text));
}

TEST(SvgPlot, gaps_interrupt_the_line_and_names_are_escaped) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::string svg =
      svg_line_plot(std::vector{PlotSeries{"a<b", {0, 1, 2, 3, 4}, {1, 2, nan, 2, 1}, "", false}}, {.title = "R&D"});
  EXPECT_EQ(count(svg, "<polyline"), 2u);
  EXPECT_THAT(svg, HasSubstr("a&lt;b"));
  EXPECT_THAT(svg, HasSubstr("R&amp;D"));
  EXPECT_THAT(svg, Not(HasSubstr("nan")));
}

TEST(SvgPlot, log_axis_puts_decades_at_equal_distance) {
  PlotSeries series{.name = "loss", .x = {0, 1, 2, 3}, .y = {1.0, 0.1, 0.01, 0.0}};
  const std::string svg = svg_line_plot(std::vector{series}, {.height_px = 260, .y_log = true});
  // 6 % of padding to both sides of 34 .. 218 px; zero has no place and ends the line.
  EXPECT_THAT(svg, HasSubstr(",43.9 "));
  EXPECT_THAT(svg, HasSubstr(",126.0 "));
  EXPECT_THAT(svg, HasSubstr(",208.1\""));
  for (const char* tick : {">1<", ">0.1<", ">0.01<", ">0.05<"}) EXPECT_THAT(svg, HasSubstr(tick));
  EXPECT_THAT(svg, Not(HasSubstr("nan")));
  EXPECT_THAT(svg, Not(HasSubstr("inf")));
  series.y = {-1.0, 0.0, -1.0, 0.0};
  EXPECT_THAT(svg_line_plot(std::vector{series}, {.y_log = true}), Not(HasSubstr("<polyline")));
}

TEST(SvgPlot, dots_ring_their_points) {
  const std::string svg =
      svg_line_plot(std::vector{PlotSeries{.x = {1, 2}, .y = {1, 2}, .color = "#123456", .dots = true}});
  EXPECT_EQ(count(svg, "<circle"), 2u);
  EXPECT_EQ(count(svg, "<polyline"), 0u);
}

TEST(SvgPlot, empty_and_constant_data_are_drawn) {
  EXPECT_THAT(svg_line_plot({}, {}), HasSubstr("</svg>"));
  const std::string flat = svg_line_plot(std::vector{PlotSeries{"", {0.0, 1.0}, {5.0, 5.0}, "", false}}, {});
  EXPECT_THAT(flat, Not(HasSubstr("nan")));
  EXPECT_THAT(flat, Not(HasSubstr("inf")));
  EXPECT_THAT(svg_map_plot({}, {}, {}), HasSubstr("</svg>"));
}

TEST(SvgPlot, map_leaves_out_what_is_far_away) {
  const MapLine line{{0.0, 100.0}, {0.0, 50.0}, {1.0, 2.0}};
  const std::vector<PlotSeries> roads = {{"", {50.0, 60.0}, {20.0, 30.0}, "", false},
                                         {"", {5000.0, 6000.0}, {0.0, 0.0}, "", false}};
  const std::string with = svg_map_plot(line, roads, {}), without = svg_map_plot(line, {}, {});
  EXPECT_EQ(count(with, "<polyline"), count(without, "<polyline") + 1);
}

}  // namespace
}  // namespace orthodrive
