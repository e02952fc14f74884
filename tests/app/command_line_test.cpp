// SPDX-License-Identifier: Apache-2.0
// What holds for every sub-command: help, exit codes, missing files.

#include "app/expect_clean_failure.hpp"

namespace orthodrive {
namespace {

using testing::HasSubstr;

const std::vector<std::string> commands{"new",     "build",    "plan",    "synth",   "train", "segment",
                                        "forests", "refine",   "elevate", "network", "scene", "drive",
                                        "view",    "evaluate", "tune",    "export"};

TEST(CommandLine, help_lists_all_commands) {
  const ToolRun run = run_tool({"--help"});
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_EQ(run.err, "");
  for (const std::string& command : commands) EXPECT_THAT(run.out, HasSubstr("  " + command));
}

TEST(CommandLine, version_is_one_line) {
  const ToolRun run = run_tool({"--version"});
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_THAT(run.out, testing::MatchesRegex("[0-9]+\\.[0-9]+\\.[0-9]+\n"));
}

TEST(CommandLine, each_command_has_help_with_examples_of_itself) {
  for (const std::string& command : commands) {
    SCOPED_TRACE(command);
    const ToolRun run = run_tool({command, "--help"});
    EXPECT_EQ(run.exit_code, 0);
    EXPECT_EQ(run.err, "");
    const auto examples = run.out.find("Examples");
    ASSERT_NE(examples, std::string::npos) << run.out;
    EXPECT_THAT(run.out.substr(examples), HasSubstr("orthodrive " + command + " "));
  }
}

TEST(CommandLine, usage_errors_have_exit_code_2) {
  for (const Arguments& arguments : std::vector<Arguments>{{}, {"no-such-command"}, {"--no-such-option"}}) {
    const ToolRun run = run_tool(arguments);
    EXPECT_EQ(run.exit_code, 2);
    EXPECT_EQ(run.out, "");
    EXPECT_NE(run.err, "");
  }
  for (const std::string& command : commands) {
    SCOPED_TRACE(command);
    const ToolRun unknown = run_tool({command, "--no-such-option"});
    EXPECT_EQ(unknown.exit_code, 2);
    EXPECT_EQ(unknown.out, "");
    EXPECT_NE(unknown.err, "");
    EXPECT_EQ(run_tool({command}).exit_code, 2) << "every command needs an argument";
  }
}

TEST(CommandLine, numbers_out_of_range_are_usage_errors) {
  for (const Arguments& arguments : std::vector<Arguments>{{"view", "DIR", "--port", "70000"},
                                                           {"view", "DIR", "--port", "http"},
                                                           {"synth", "-o", "DIR", "--preset", "metropolis"},
                                                           {"view", "DIR", "--threads", "-1"}}) {
    SCOPED_TRACE(arguments[2]);
    EXPECT_EQ(run_tool(arguments).exit_code, 2);
  }
}

TEST(CommandLine, class_table_that_lacks_classes_of_sites_is_named_and_nothing_is_written) {
  const Scratch scratch;
  const std::string table = paths::in_source("models/classes/mumbai.toml");
  const ToolRun run = run_tool({"-q", "synth", "--size", "200", "--classes", table, "-o", scratch / "site"});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.err, testing::HasSubstr(table + ": the class table"));
  EXPECT_THAT(run.err, testing::HasSubstr("classes that synthetic sites show: snow, "));
  EXPECT_FALSE(std::filesystem::exists(scratch / "site"));
}

TEST(CommandLine, options_of_a_crf_need_one) {
  const Scratch scratch;
  for (const Arguments& option : {Arguments{"--crf-set", "zheng"}, Arguments{"--crf-iterations", "3"}}) {
    Arguments arguments{"segment", scratch / "missing.tif", "-o", scratch / "out.tif"};
    arguments.insert(arguments.end(), option.begin(), option.end());
    const ToolRun run = run_tool(arguments);
    EXPECT_EQ(run.exit_code, 2);
    EXPECT_THAT(run.err, testing::HasSubstr(option.front() + " changes nothing without --crf"));
  }
}

TEST(CommandLine, options_of_refine_that_would_change_nothing_are_refused) {
  const Scratch scratch;
  const std::string missing = scratch / "missing";
  const auto refuses = [&](const std::string& named, const Arguments& options) {
    Arguments arguments{"refine", "--osm", missing, "-o", scratch / "out.gpkg"};
    arguments.insert(arguments.end(), options.begin(), options.end());
    SCOPED_TRACE(testing::PrintToString(options));
    const ToolRun run = run_tool(arguments);
    EXPECT_EQ(run.exit_code, 2);
    EXPECT_THAT(run.err, testing::HasSubstr(named));
  };
  const Arguments none{"--method", "none"}, nlo{"--method", "nlo"}, mrf{"--method", "mrf"}, standard{};
  struct Idle {
    Arguments option;
    std::vector<Arguments> methods;  ///< that do not read it
  };
  const std::vector<Idle> idle{{{"--labels", missing}, {mrf}},
                               {{"--road-probability", missing}, {nlo, mrf, none}},
                               {{"--alignment", missing}, {nlo, mrf, none}},
                               {{"--weights-file", missing}, {nlo, mrf, none}},
                               {{"--gpx", missing}, {nlo, mrf, none}},
                               {{"--search-radius", "3"}, {none}},
                               {{"--iterations", "3"}, {mrf, none}},
                               {{"--weights", "1"}, {standard, mrf, none}},
                               {{"--width-factors", "0.5", "2"}, {standard, mrf, none}},
                               {{"--strip", "1"}, {standard, mrf, none}},
                               {{"--spacing", "1"}, {standard, mrf, none}},
                               {{"--unlabelled-cost", "1"}, {standard, mrf, none}},
                               {{"--filter-and-join"}, {standard, mrf, none}},
                               {{"--photo", missing}, {standard, nlo, none}},
                               {{"--forests", missing}, {standard, nlo, none}},
                               {{"--polygons", "dp"}, {standard, nlo, none}}};
  for (const Idle& i : idle)
    for (Arguments method : i.methods) {
      method.insert(method.end(), i.option.begin(), i.option.end());
      refuses(i.option.front() + " changes nothing with --method", method);
    }
  refuses("--gpx", {"--driving-side", "left"});
  for (const char* weights : {"3", "1+", "10,1,0.2", "10,1,0.2,x", "10,1,0.2,inf"})
    refuses("--weights " + std::string(weights), {"--method", "nlo", "--weights", weights});
}

TEST(CommandLine, missing_input_is_one_line_naming_the_file_and_writes_nothing) {
  const Scratch scratch;
  write_bytes(scratch / "earlier.tif", "an earlier output");
  const std::string out = scratch / "earlier.tif", missing = scratch / "missing";
  const std::vector<Arguments> cases{
      {"build", missing + ".toml", "-o", out + ".d"},
      {"train", missing + ".toml", "-o", out + ".d"},
      {"segment", missing + ".tif", "-o", out},
      {"refine", "--osm", missing + ".osm", "--labels", missing + ".tif", "-o", out},
      {"tune", missing + ".toml", "-o", out + ".d"},
      {"refine", "--method", "mrf", "--osm", missing + ".osm", "--photo", missing + ".tif", "--forests",
       missing + ".yml", "-o", out},
      {"forests", "--photo", missing + ".tif", "--labels", missing + ".tif", "-o", out},
      {"elevate", "--roads", missing + ".gpkg", "--dtm", missing + ".tif", "-o", out},
      {"network", "--roads", missing + ".gpkg", "-o", out},
      {"scene", "--network", missing + ".xodr", "--labels", missing + ".tif", "--photo", missing + ".tif", "--dtm",
       missing + ".tif", "-o", out + ".d"},
      {"export", "--network", missing + ".xodr", "--photo", missing + ".tif", "--dtm", missing + ".tif", "--glb", out},
      {"drive", "--network", missing + ".xodr", "-o", out + ".d"},
      {"view", missing},
      {"evaluate", "labels", missing + ".tif", missing + "2.tif"},
      {"evaluate", "roads", missing + ".gpkg", missing + ".geojson"},
      {"evaluate", "heights", missing + ".gpkg", missing + ".tif"},
      {"evaluate", "network", missing + ".xodr"},
      {"evaluate", "site", missing, "--truth", missing},
  };
  for (Arguments arguments : cases) {
    SCOPED_TRACE(testing::PrintToString(arguments));
    arguments.push_back("--quiet");
    expect_clean_failure(scratch.folder(), missing, [&] { return run_tool(arguments); });
  }
}

TEST(CommandLine, missing_model_names_where_it_was_looked_for) {
  const Scratch scratch;
  write_bytes(scratch / "photo.ppm", "P6\n1 1\n255\nrgb");
  expect_clean_failure(scratch.folder(), "no-such-model", [&] {
    return run_tool(
        {"--quiet", "segment", scratch / "photo.ppm", "-o", scratch / "labels.tif", "--model", "no-such-model"});
  });
}

}  // namespace
}  // namespace orthodrive
