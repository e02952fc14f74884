// SPDX-License-Identifier: Apache-2.0
// The tool starts without the libraries of its commands, and says in one line what of them is missing.

#include <gmock/gmock.h>

#include <set>
#include <sstream>

#include "app/expect_clean_failure.hpp"
#include "app/processor.hpp"

namespace orthodrive {
namespace {
namespace fs = std::filesystem;
using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::Not;

/// File names of all libraries that a run loads, at its start or later, as the loader tells them.
std::set<std::string> libraries_of(Arguments arguments) {
  const Scratch scratch;
  Arguments command{"/usr/bin/env", "LD_DEBUG=files", "LD_DEBUG_OUTPUT=" + (scratch / "log").string(), paths::tool};
  command.insert(command.end(), arguments.begin(), arguments.end());
  (void)run_program(command);
  std::set<std::string> libraries;
  for (const auto& log : fs::directory_iterator(scratch.folder())) {
    std::istringstream lines(bytes_of(log.path()));
    for (std::string line; std::getline(lines, line);)
      if (const auto at = line.find("calling init: "); at != std::string::npos)
        libraries.insert(fs::path(line.substr(at + 14)).filename());
  }
  return libraries;
}

TEST(Start, version_and_help_load_few_libraries) {
  for (const Arguments& arguments : std::vector<Arguments>{{"version"}, {"build", "--help"}, {"segment"}}) {
    SCOPED_TRACE(testing::PrintToString(arguments));
    const std::set<std::string> libraries = libraries_of(arguments);
    EXPECT_THAT(libraries, Contains("liborthodrive-core.so"));
    EXPECT_THAT(libraries, Not(Contains("liborthodrive.so")));
    EXPECT_LT(libraries.size(), 80u);
    for (const char* large : {"libgdal", "libtorch", "libopencv", "libceres", "libproj"})
      EXPECT_THAT(libraries, Not(Contains(testing::StartsWith(large))));
  }
}

TEST(Start, a_command_loads_its_library_and_no_part_that_it_does_not_need) {
  const std::set<std::string> libraries = libraries_of({"plan", "/nowhere/site.toml"});
  EXPECT_THAT(libraries, AllOf(Contains("liborthodrive.so"), Contains(testing::StartsWith("libgdal"))));
  for (const char* of_parts : {"libtorch", "libopencv"})
    EXPECT_THAT(libraries, Not(Contains(testing::StartsWith(of_parts))));
}

/// A training whose data are not there.
void write_experiment(const fs::path& file) {
  write_bytes(file, "network = \"" + paths::in_source("models/networks/mobilenetv2-fpn.toml").string() +
                        "\"\n[train]\nsteps = 3\nwarmup_steps = 1\n[[raster]]\nname = \"a\"\nfolder = \"a\"\n");
}

/// The tool with its libraries, by links, and without its parts.
class WithoutParts : public testing::Test {
 protected:
  Scratch scratch;
  const fs::path built = fs::path(paths::tool).parent_path() / "lib/orthodrive", lib = scratch / "lib/orthodrive",
                 tool = scratch / "orthodrive";

  void SetUp() override {
    fs::create_directories(lib / "parts");
    fs::copy_file(paths::tool, tool);
    for (const char* file : {"liborthodrive.so", "liborthodrive-core.so", "liborthodrive-lab.so"})
      fs::create_symlink(built / file, lib / file);
    write_experiment(scratch / "experiment.toml");
  }
  void expect_line(const Arguments& arguments, const std::string& part, const std::string& package,
                   const std::string& text) {
    Arguments command{tool, "--quiet"};
    command.insert(command.end(), arguments.begin(), arguments.end());
    SCOPED_TRACE(testing::PrintToString(command));
    const ToolRun run = run_program(command);
    EXPECT_EQ(run.exit_code, 1);
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
    EXPECT_THAT(run.err, AllOf(testing::StartsWith("orthodrive: "), HasSubstr((lib / part).string()), HasSubstr(text),
                               testing::ContainsRegex("Debian package " + package + "( |\n)")));
  }
  const Arguments train{"train", scratch / "experiment.toml", "-o", scratch / "out"},
      measure{"train", scratch / "experiment.toml", "--measure", "default"},
      forests{"forests", "--photo", "p.tif", "--labels", "l.tif", "-o", scratch / "forests.yml"};
};

TEST_F(WithoutParts, a_missing_part_is_named_with_its_package) {
  expect_line(train, "parts/train.so", "orthodrive-parts", "there is no");
  expect_line(measure, "parts/train.so", "orthodrive-parts", "there is no");
  expect_line(forests, "parts/forests.so", "orthodrive-parts", "there is no");
  const ToolRun version = run_program({tool, "version"});
  EXPECT_EQ(version.exit_code, 0) << version.err;
  EXPECT_THAT(version.out, HasSubstr("none (Debian package orthodrive-parts)"));
}

TEST_F(WithoutParts, the_laboratory_is_named_with_its_package_and_the_product_does_without) {
  fs::remove(lib / "liborthodrive-lab.so");
  for (const Arguments& command : {Arguments{"synth", "-o", scratch / "site"}, train, forests})
    expect_line(command, "liborthodrive-lab.so", "orthodrive-lab", "there is no");
  expect_line({"refine", "--method", "none", "--osm", "a.osm", "--labels", "l.tif", "-o", "r.gpkg"},
              "liborthodrive-lab.so", "orthodrive-lab", "there is no");
  const ToolRun refine =
      run_program({tool, "--quiet", "refine", "--osm", "a.osm", "--labels", "l.tif", "-o", "r.gpkg"});
  EXPECT_THAT(refine.err, AllOf(HasSubstr("l.tif"), Not(HasSubstr("laboratory"))));
}

TEST_F(WithoutParts, a_part_of_another_version_is_not_loaded) {
  for (const char* part : {"parts/train.so", "parts/forests.so"})
    write_bytes(lib / part, "|orthodrive-build|99.0.0 (interface 00000000)|");
  expect_line(train, "parts/train.so", "orthodrive-parts", "is of 99.0.0 (interface 00000000), the program of ");
  expect_line(forests, "parts/forests.so", "orthodrive-parts", "is of 99.0.0 (interface 00000000), the program of ");
}

TEST_F(WithoutParts, a_part_whose_libraries_are_missing_says_which) {
  if (!paths::has_part("forests")) GTEST_SKIP() << "SKIPPED: the part forests is not built (tools/setup --parts)";
  std::string part = bytes_of(built / "parts/forests.so");
  const std::string needed = "libopencv_core.so";
  for (auto at = part.find(needed); at != std::string::npos; at = part.find(needed, at)) part.replace(at, 6, "libno_");
  write_bytes(lib / "parts/forests.so", part);
  expect_line(forests, "parts/forests.so", "orthodrive-parts", "libno_ncv_core.so");
}

TEST_F(WithoutParts, the_library_itself_is_looked_for_like_a_part) {
  fs::remove(lib / "liborthodrive.so");
  expect_line({"plan", "site.toml"}, "liborthodrive.so", "orthodrive", "there is no");
  EXPECT_EQ(run_program({tool, "build", "--help"}).exit_code, 0);
}

TEST(Border, errors_that_a_library_throws_keep_their_kind) {
  const Scratch scratch;
  const ToolRun usage = run_tool({"refine", "--osm", scratch / "a.osm", "-o", scratch / "a.gpkg"});
  EXPECT_EQ(usage.exit_code, 2);
  EXPECT_THAT(usage.err, HasSubstr("needs --labels"));
  EXPECT_EQ(run_tool({"plan", scratch / "none.toml"}).exit_code, 1);
  if (!paths::has_part("train")) return;
  fs::create_directories(scratch / "out");
  write_bytes(scratch / "out/checkpoint.safetensors", "kept");
  write_experiment(scratch / "e.toml");
  const ToolRun of_part = run_tool({"train", scratch / "e.toml", "-o", scratch / "out"});
  EXPECT_EQ(of_part.exit_code, 2);
  EXPECT_THAT(of_part.err, HasSubstr("--resume"));
}

TEST(Processor, an_old_one_is_told_what_it_lacks) {
  using app::too_old;
  EXPECT_EQ(too_old({.avx2 = true, .fma = true}), "");
  EXPECT_EQ(too_old({}),
            "this processor is too old: it has no AVX2 and FMA; orthodrive needs x86-64-v3 "
            "(Intel since 2013, AMD since 2015)");
  EXPECT_THAT(too_old({.avx2 = true}), HasSubstr("it has no FMA;"));
  EXPECT_THAT(too_old({.fma = true}), HasSubstr("it has no AVX2;"));
  EXPECT_EQ(too_old(app::processor_features()), "");  // of the machine that runs the tests
}

}  // namespace
}  // namespace orthodrive
