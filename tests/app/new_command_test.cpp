// SPDX-License-Identifier: Apache-2.0
// `orthodrive new` as people call it: one file written, or one line and nothing.

#include "app/expect_clean_failure.hpp"

namespace orthodrive {
namespace {
using testing::HasSubstr;

TEST(NewCommand, a_box_becomes_a_site_file_and_no_second_one) {
  const Scratch scratch;
  const std::string out = scratch / "prague.toml";
  const Arguments arguments{"new", "--bbox", "14.44,50.07,14.47,50.09", "-o", out};
  const ToolRun run = run_tool(arguments);
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.out, out + "\n");
  EXPECT_EQ(run.err, "");
  const std::string written = bytes_of(out);
  EXPECT_THAT(written, HasSubstr("name = \"prague\""));
  const ToolRun again = run_tool(arguments);
  EXPECT_EQ(again.exit_code, 2);
  EXPECT_THAT(again.err, HasSubstr("--force replaces it"));
  EXPECT_EQ(bytes_of(out), written);
  EXPECT_EQ(run_tool({"new", "--bbox", "14.44,50.07,14.47,50.09", "-o", out, "--force", "--name", "P"}).exit_code, 0);
  EXPECT_THAT(bytes_of(out), HasSubstr("name = \"P\""));
  // Until the sources are fetched, the build says which one is missing and where it is named.
  const ToolRun build = run_tool({"--quiet", "build", out, "-o", scratch / "built", "--explain"});  // fetches nothing
  EXPECT_EQ(build.exit_code, 1);
  EXPECT_THAT(build.err, testing::AllOf(HasSubstr("prague.toml:"), HasSubstr("orthodrive fetch")));
  EXPECT_FALSE(std::filesystem::exists(scratch / "built"));
}

TEST(NewCommand, west_of_greenwich_is_no_option) {
  const Scratch scratch;
  const ToolRun run = run_tool({"new", "--bbox", "-105.30,40.00,-105.28,40.02", "-o", scratch / "boulder.toml"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
}

TEST(NewCommand, areas_that_cannot_be_are_one_line_and_no_file) {
  const Scratch scratch;
  const std::string out = scratch / "a.toml";
  for (const std::string box : {"14.47,50.07,14.44,50.09", "179.9,0,-179.9,0.1", "15,85,15.1,85.1", "15,50,15,50",
                                "1,2,3", "1,2,3,4,5", "a,b,c,d", "0,0,0.02,0.02"}) {
    const ToolRun run = run_tool({"new", "--bbox", box, "-o", out});
    EXPECT_EQ(run.exit_code, 2) << box;
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
    EXPECT_FALSE(std::filesystem::exists(out)) << box;
  }
  EXPECT_EQ(run_tool({"new", "-o", out}).exit_code, 2);
  EXPECT_EQ(run_tool({"new", "--bbox", "14.44,50.07,14.47,50.09"}).exit_code, 2);
  EXPECT_EQ(run_tool({"new", "--relation", "7", "-o", out}).exit_code, 2);
  write_bytes(scratch / "bow.geojson",
              R"({"type":"Polygon","coordinates":[[[14,50],[14.1,50.1],[14.1,50],[14,50.1],[14,50]]]})");
  expect_clean_failure(scratch.folder(), "bow.geojson", [&] {
    return run_tool({"new", "--place", scratch / "bow.geojson", "-o", out});
  });
  expect_clean_failure(scratch.folder(), "none.osm", [&] {
    return run_tool({"new", "--relation", "7", "--osm", scratch / "none.osm", "-o", out});
  });
  expect_clean_failure(scratch.folder(), "none.tif", [&] {
    return run_tool({"new", "--bbox", "14.44,50.07,14.47,50.09", "--photo-file", scratch / "none.tif", "-o", out});
  });
}

TEST(NewCommand, the_list_needs_no_area) {
  const ToolRun all = run_tool({"new", "--list"}),
                here = run_tool({"new", "--list", "--bbox", "14.44,50.07,14.47,50.09"});
  EXPECT_EQ(all.exit_code, 0) << all.err;
  EXPECT_EQ(here.exit_code, 0) << here.err;
  EXPECT_THAT(all.out, HasSubstr("jp-gsi-photo"));
  EXPECT_THAT(here.out, HasSubstr("cz-ortofoto"));
  EXPECT_LT(here.out.size(), all.out.size());
}

}  // namespace
}  // namespace orthodrive
