// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "io/places.hpp"
#include "io/scratch.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/io/vector/gpx_reader.hpp"

namespace orthodrive {
namespace {

using io::read_gpx;
using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;

/// A track point at a place of the test site.
std::string trace_point(double x_m, double y_m, const std::string& inside = "") {
  static const CoordinateTransform lonlat_from_site(utm33, Crs{"EPSG:4326"});
  const Vec2 p = lonlat_from_site.target_from_source(origin + Vec2{x_m, y_m});
  return fmt::format("<trkpt lat=\"{:.9f}\" lon=\"{:.9f}\">{}</trkpt>\n", p.y, p.x, inside);
}
std::string at_time(int seconds) {
  return fmt::format("<time>2016-05-01T12:{:02}:{:02}.5Z</time>", seconds / 60, seconds % 60);
}
std::string segment(const std::string& points) { return "<trkseg>" + points + "</trkseg>"; }
std::string gpx(const std::string& segments) {
  return "<?xml version=\"1.0\"?>\n<gpx version=\"1.1\" "
         "xmlns=\"http://www.topografix.com/GPX/1/1\"><trk><name>a</name>\n" +
         segments + "</trk></gpx>\n";
}

GpsTraces traces_of(const std::string& text) {
  const Scratch scratch;
  write_bytes(scratch / "a.gpx", text);
  const io::GpxTraces read = read_gpx({scratch / "a.gpx"}, site_of(1000.0));
  EXPECT_THAT(read.findings, IsEmpty());
  return read.traces;
}

TEST(Gpx, points_become_lines_in_the_site_crs) {
  const GpsTraces traces =
      traces_of(gpx(segment(trace_point(100, 200) + trace_point(120, 200) + trace_point(140, 210)) +
                    segment(trace_point(500, 500) + trace_point(500, 540))));
  EXPECT_EQ(traces.crs, utm33);
  ASSERT_EQ(traces.traces.size(), 2u);
  EXPECT_NE(traces.traces[0].recording, traces.traces[1].recording);
  ASSERT_EQ(traces.traces[0].line.size(), 3u);
  EXPECT_LT(distance(traces.traces[0].line[2], origin + Vec2{140, 210}), 1e-3);
}

TEST(Gpx, gaps_in_place_and_time_split_a_recording) {
  const std::string near = trace_point(0, 0, at_time(0)) + trace_point(50, 0, at_time(29)) +
                           trace_point(100, 0, at_time(58)),
                    far = trace_point(161, 0, at_time(60)) + trace_point(200, 0, at_time(62)),
                    late = trace_point(210, 0, at_time(93)) + trace_point(220, 0, at_time(94)),
                    untimed = trace_point(230, 0) + trace_point(240, 0);
  const GpsTraces traces = traces_of(gpx(segment(near + far + late + untimed)));
  std::vector<std::size_t> sizes;
  for (const GpsTrace& trace : traces.traces) {
    sizes.push_back(trace.line.size());
    EXPECT_EQ(trace.recording, traces.traces[0].recording);
  }
  EXPECT_THAT(sizes, testing::ElementsAre(3, 2, 4));
}

TEST(Gpx, points_without_a_fix_are_left_out) {
  const std::string bad =
      "<trkpt lat=\"NaN\" lon=\"15\"/><trkpt lon=\"15\"/><trkpt lat=\"0\" lon=\"0.0\"/>"
      "<trkpt lat=\"95\" lon=\"15\"/><trkpt lat=\"here\" lon=\"there\"/>";
  const GpsTraces traces = traces_of(gpx(segment(trace_point(0, 0) + bad + trace_point(10, 50, "<fix>none</fix>") +
                                                 trace_point(20, 0, "<fix>3d</fix>") + trace_point(20, 0))));
  ASSERT_EQ(traces.traces.size(), 1u);
  ASSERT_EQ(traces.traces[0].line.size(), 2u);  // the doubled one as well
  EXPECT_LT(distance(traces.traces[0].line[1], origin + Vec2{20, 0}), 1e-3);
}

TEST(Gpx, prefixes_of_the_namespace_do_not_matter) {
  std::string text = gpx(segment(trace_point(0, 0) + trace_point(20, 0)));
  for (const std::string name : {"gpx", "trkpt", "trkseg", "trk"})
    for (const std::string before : {"<", "</"})
      for (std::size_t k = 0; (k = text.find(before + name + (name == "trk" ? ">" : ""), k)) != std::string::npos;
           k += 8)
        text.insert(k + before.size(), "g:");
  ASSERT_THAT(text, HasSubstr("</g:trkseg></g:trk></g:gpx>"));
  EXPECT_EQ(traces_of(text).traces.size(), 1u);
}

TEST(Gpx, far_recordings_are_told) {
  const Scratch scratch;
  const std::string far = segment("<trkpt lat=\"-33.9\" lon=\"18.4\"/><trkpt lat=\"-33.9\" lon=\"18.4001\"/>");
  write_bytes(scratch / "b.gpx", gpx(far + segment(trace_point(0, 0) + trace_point(20, 0))));
  const io::GpxTraces read = read_gpx({scratch / "b.gpx"}, site_of(1000.0));
  EXPECT_EQ(read.traces.traces.size(), 1u);
  ASSERT_EQ(read.findings.size(), 1u);
  EXPECT_EQ(read.findings[0].code, "gpx.outside_area");
  EXPECT_THAT(read.findings[0].message, AllOf(HasSubstr("b.gpx"), HasSubstr("1 of 2"), HasSubstr("latitude -33.9")));
  EXPECT_TRUE(std::isfinite(read.findings[0].x_m));
}

TEST(Gpx, a_drive_through_the_area_is_cut_to_it) {
  std::string points;
  for (int x = -2000; x <= 3000; x += 40) points += trace_point(x, 500);
  const GpsTraces traces = traces_of(gpx(segment(points)));
  ASSERT_EQ(traces.traces.size(), 1u);
  EXPECT_NEAR(length_m(traces.traces[0].line), 1400.0, 100.0);  // 200 m on both sides
}

TEST(Gpx, bad_files_are_one_line_with_the_place) {
  const Scratch scratch;
  const std::string file = scratch / "bad.gpx";
  const auto message = [&](const std::string& text) {
    write_bytes(file, text);
    const std::string what = message_of<InputError>([&] { (void)read_gpx({file}, site_of(1000.0)); });
    EXPECT_THAT(what, AllOf(HasSubstr("bad.gpx"), testing::Not(HasSubstr("\n"))));
    return what;
  };
  const std::string good = gpx(segment(trace_point(0, 0) + trace_point(20, 0)));
  EXPECT_THAT(message(good.substr(0, good.size() - 30)), HasSubstr("cut off"));
  EXPECT_THAT(message("a,b\n1,2\n"), HasSubstr("no GPX"));
  EXPECT_THAT(message(""), HasSubstr("no GPX"));
  EXPECT_THAT(message("<gpx>\n<trk>\n</trkseg></gpx>"), HasSubstr("line 3"));
  EXPECT_THAT(message("<osm version=\"0.6\"/>"), AllOf(HasSubstr("<osm>"), HasSubstr("<gpx>")));
  EXPECT_THAT(message(gpx("")), HasSubstr("no track points"));
  EXPECT_THAT(message(gpx(segment("<trkpt lat=\"0\" lon=\"0\"/><trkpt/>"))),
              AllOf(HasSubstr("2 track points"), HasSubstr("fix")));
  EXPECT_THAT(message_of<InputError>([&] { (void)read_gpx({scratch / "none.gpx"}, site_of(1000.0)); }),
              HasSubstr("no such file"));
}

}  // namespace
}  // namespace orthodrive
