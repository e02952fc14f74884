// SPDX-License-Identifier: Apache-2.0
// The MRF baseline from the command line: learn forests from a labelled photo, refine roads with them.

#include <nlohmann/json.hpp>

#include "app/expect_clean_failure.hpp"

namespace orthodrive {
namespace {

namespace fs = std::filesystem;

fs::path make_site(const Scratch& scratch, const std::string& seed) {
  const fs::path site = scratch / ("site" + seed);
  const ToolRun made = run_tool({"--quiet", "synth", "--seed", seed, "--size", "300", "--gsd", "0.5", "-o", site});
  EXPECT_EQ(made.exit_code, 0) << made.err;
  return site;
}

double iou_of(const fs::path& roads, const fs::path& site) {
  const ToolRun run = run_tool({"--quiet", "evaluate", "roads", roads, site / "truth/roads.gpkg", "--json"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  return nlohmann::json::parse(run.out)["surface_iou"].get<double>();
}

TEST(Forests, from_labelled_photos_to_better_roads) {
  const Scratch scratch;
  const fs::path learned = make_site(scratch, "5"), seen = make_site(scratch, "6");
  const std::string forests = scratch / "forests.yml";
  const ToolRun trained =
      run_tool({"--quiet", "forests", "--photo", learned / "ortho.tif", "--labels", learned / "truth/labels.tif",
                "--photo", seen / "ortho.tif", "--labels", seen / "truth/labels.tif", "--trees", "20", "-o", forests});
  ASSERT_EQ(trained.exit_code, 0) << trained.err;
  const double before = iou_of(seen / "roads.osm", seen);
  for (const std::string polygons : {"dp", "smooth"}) {
    const fs::path roads = scratch / (polygons + ".gpkg");
    const ToolRun run = run_tool({"--quiet", "refine", "--method", "mrf", "--osm", seen / "roads.osm", "--photo",
                                  seen / "ortho.tif", "--forests", forests, "--polygons", polygons, "-o", roads});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    const double after = iou_of(roads, seen);
    std::printf("%s: surface IoU %.3f -> %.3f\n", polygons.c_str(), before, after);
    EXPECT_GT(after, before + 0.1);
  }
}

TEST(Forests, what_cannot_be_read_is_one_line_and_writes_nothing) {
  const Scratch scratch;
  const fs::path site = make_site(scratch, "5");
  const std::string forests = scratch / "forests.yml", out = scratch / "out.gpkg",
                    polygons = scratch / "painted.geojson";
  const Arguments refine{"--quiet", "refine",           "--method",  "mrf",   "--osm", site / "roads.osm",
                         "--photo", site / "ortho.tif", "--forests", forests, "-o",    out};
  for (const std::string text : {"", "<html>404</html>", "%YAML:1.0\n---\northodrive_road_forests: 1\n"}) {
    write_bytes(forests, text);
    expect_clean_failure(scratch.folder(), forests, [&] { return run_tool(refine); });
  }
  write_bytes(
      polygons,
      R"({"type":"FeatureCollection","features":[{"type":"Feature","properties":{"class":"lava"},"geometry":)"
      R"({"type":"Polygon","coordinates":[[[14.47,47.583],[14.471,47.583],[14.471,47.584],[14.47,47.583]]]}}]})");
  expect_clean_failure(scratch.folder(), polygons, [&] {
    return run_tool({"--quiet", "forests", "--photo", site / "ortho.tif", "--labels", polygons, "-o", forests});
  });
}

TEST(Forests, options_that_do_not_go_together_are_usage_errors) {
  for (const Arguments& arguments : std::vector<Arguments>{
           {"forests", "--photo", "a.tif", "--photo", "b.tif", "--labels", "a.tif", "-o", "f.yml"},
           {"refine", "--method", "mrf", "--osm", "r.osm", "--photo", "a.tif", "-o", "r.gpkg"},
           {"refine", "--method", "mrf", "--osm", "r.osm", "--photo", "a.tif", "--forests", "f.yml", "--labels",
            "l.tif", "-o", "r.gpkg"},
           {"refine", "--osm", "r.osm", "-o", "r.gpkg"},
           {"refine", "--osm", "r.osm", "--labels", "l.tif", "--forests", "f.yml", "-o", "r.gpkg"}}) {
    SCOPED_TRACE(testing::PrintToString(arguments));
    const ToolRun run = run_tool(arguments);
    EXPECT_EQ(run.exit_code, 2);
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
  }
}

}  // namespace
}  // namespace orthodrive
