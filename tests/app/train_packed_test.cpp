// SPDX-License-Identifier: Apache-2.0
// `orthodrive-train` on a pack against `orthodrive train` on the files the pack was made of.
#include <algorithm>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include "app/run_tool.hpp"
#include "paths.hpp"

namespace orthodrive {
namespace {
namespace fs = std::filesystem;

const fs::path shipped_models = paths::in_source("models");

ToolRun run_trainer(Arguments arguments) {
  arguments.insert(arguments.begin(), paths::trainer);
  return run_program(arguments);
}

/// The log without its column of seconds, which differs from run to run.
std::string log_without_seconds(const fs::path& file) {
  std::ifstream stream(file);
  std::string result, line;
  std::size_t seconds = std::string::npos;
  while (std::getline(stream, line)) {
    std::istringstream cells(line);
    std::string cell;
    for (std::size_t i = 0; std::getline(cells, cell, ','); ++i) {
      if (cell == "seconds") seconds = i;
      result += i == seconds ? "," : cell + ",";
    }
    result += '\n';
  }
  EXPECT_NE(seconds, std::string::npos) << file;
  return result;
}

/// A site of 200 m, an experiment that learns from it and is measured on it, and its pack.
class TrainPacked : public testing::Test {
 protected:
  Scratch scratch;
  const fs::path experiment = scratch / "experiment.toml", pack = scratch / "data.safetensors",
                 weights = shipped_models / "default.safetensors";

  void SetUp() override {
    expect_done(run_tool({"-q", "synth", "-o", scratch / "site", "--size", "200", "--gsd", "0.5", "--seed", "3"}));
    write_bytes(experiment, "network = \"" + (shipped_models / "networks" / "mobilenetv2-fpn.toml").string() +
                                "\"\nweights = [\"" + weights.string() + R"("]
[train]
steps = 3
warmup_steps = 1
batch = 1
crop_px = 128
balance_classes = true
validate_every = 2
[crf]
steps = 1
batch = 1
search_crops = 1
iterations = 1
[[raster]]
name = "learned"
folder = "site"
weight = 0.3
[[raster]]
name = "measured"
folder = "site"
held_out = true
)");
    expect_done(run_tool({"-q", "train", experiment, "--pack", pack}));
  }
  static void expect_done(const ToolRun& run) {
    EXPECT_EQ(run.exit_code, 0);
    EXPECT_EQ(run.err, "");
  }
  void expect_same_files(const char* file) const {
    EXPECT_EQ(bytes_of(scratch / "a" / "run" / file), bytes_of(scratch / "b" / "run" / file)) << file;
    EXPECT_NE(bytes_of(scratch / "b" / "run" / file), "") << file;
  }
};

TEST_F(TrainPacked, writes_what_the_tool_writes) {
  const Arguments common{"--threads", "1", "-q"};
  const auto with = [&](Arguments arguments) {
    arguments.insert(arguments.end(), common.begin(), common.end());
    return arguments;
  };
  expect_done(run_tool(with({"train", experiment, "-o", scratch / "a" / "run"})));
  fs::rename(scratch / "site", scratch / "away");  // the pack is all there is
  expect_done(run_trainer(with({pack, "-o", scratch / "b" / "run", "--weights", weights})));
  for (const char* file : {"model.safetensors", "checkpoint.safetensors", "best.safetensors", "experiment.toml",
                           "weights_mobilenetv2-s32-fpn2.txt"})
    expect_same_files(file);
  EXPECT_EQ(log_without_seconds(scratch / "a" / "run" / "log.csv"),
            log_without_seconds(scratch / "b" / "run" / "log.csv"));
  EXPECT_TRUE(fs::exists(scratch / "b" / "run" / "training.html"));

  fs::rename(scratch / "away", scratch / "site");
  expect_done(run_tool(with({"train", experiment, "-o", scratch / "a" / "run", "--crf"})));
  expect_done(
      run_trainer(with({pack, "-o", scratch / "b" / "run", "--crf"})));  // no weights: it goes on from the model
  for (const char* file : {"crf/model.safetensors", "crf/search.csv"}) expect_same_files(file);
}

TEST_F(TrainPacked, wrong_input_is_named) {
  const fs::path out = scratch / "out";
  const auto expect_failure = [](const ToolRun& run, int exit_code, const std::string& message) {
    EXPECT_EQ(run.exit_code, exit_code);
    EXPECT_NE(run.err.find(message), std::string::npos) << run.err;
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
  };
  expect_failure(run_trainer({pack, "-o", out}), 2, "--weights default.safetensors");
  expect_failure(run_trainer({pack, "-o", out, "--weights", scratch / "none.safetensors"}), 1, "none.safetensors");
  expect_failure(run_trainer({pack, "-o", out, "--weights", "vgg.caffemodel"}), 2, "vgg.caffemodel");
  expect_failure(run_trainer({weights, "-o", out}), 1, "default.safetensors: is no packed training data");
  expect_failure(run_trainer({pack}), 2, "-o is missing");
  expect_failure(run_trainer({pack, "-o", out, "--threads", "two"}), 2, "--threads two");
  expect_failure(run_trainer({pack, "-o", out, "--crf"}), 2, "model.safetensors is missing");
  EXPECT_FALSE(fs::exists(out / "model.safetensors"));
  // A folder with a training in it is not begun anew.
  fs::create_directories(out);
  std::ofstream(out / "checkpoint.safetensors") << "kept";
  expect_failure(run_trainer({pack, "-o", out, "--weights", weights}), 2, "--resume");
  EXPECT_EQ(bytes_of(out / "checkpoint.safetensors"), "kept");
}

/// What it asks for itself: the libtorch of Debian asks for GDAL in turn.
TEST(TrainPackedProgram, needs_neither_gdal_nor_proj) {
  const ToolRun run = run_program({"/usr/bin/readelf", "--dynamic", "--wide", paths::trainer});
  EXPECT_NE(run.out.find("[libtorch_cpu"), std::string::npos) << run.out;
  for (const char* library : {"[libgdal", "[libproj", "[libgeos", "[libprotobuf"})
    EXPECT_EQ(run.out.find(library), std::string::npos) << run.out;
}

/// Fails when a source of the program begins to include what a machine with libtorch alone has not.
TEST(TrainPackedProgram, its_sources_are_complete_without_other_libraries) {
  const Scratch scratch;
  const ToolRun run = run_program({paths::in_source("tools/trainer/bundle"), scratch / "bundle"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  for (const char* file : {"CMakeLists.txt", "app/train_packed.cpp", "src/orthodrive/train/train_network.cpp",
                           "src/orthodrive/crf/crf_kernels_avx512.cpp", "third_party/fmt/format-inl.h"})
    EXPECT_TRUE(fs::exists(scratch / "bundle" / file)) << file;
  EXPECT_FALSE(fs::exists(scratch / "bundle" / "src/orthodrive/io/caffe_model.cpp"));
}

/// Names of functions and data in our namespace, as `nm` lists them with one letter for their kind.
void add_symbols(const fs::path& object, std::set<std::string>& defined, std::map<std::string, std::string>& wanted) {
  const ToolRun run = run_program({"/usr/bin/nm", object});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  std::istringstream lines(run.out);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t at = line.find("10orthodrive");  // a namespace is mangled as its length and its name
    if (at == std::string::npos) continue;
    const std::size_t space = line.rfind(' ');
    const std::string name = line.substr(space + 1);
    if (line[space - 1] == 'U')
      wanted[name] = object.filename();
    else
      defined.insert(name);
  }
}

/// Fails when a source of the program calls what lies in a file that the bundle leaves out: it would not link there.
TEST(TrainPackedProgram, its_sources_call_nothing_that_the_bundle_leaves_out) {
  const Scratch scratch;
  ASSERT_EQ(run_program({paths::in_source("tools/trainer/bundle"), scratch / "bundle"}).exit_code, 0);
  const fs::path build = fs::path(paths::trainer).parent_path();
  std::set<std::string> defined;
  std::map<std::string, std::string> wanted;  // the name, and who wants it
  int sources = 0;
  for (const auto& entry : fs::recursive_directory_iterator(scratch / "bundle" / "src")) {
    if (entry.path().extension() != ".cpp") continue;
    ++sources;
    const std::string room = entry.path().parent_path().filename();
    const std::string file = entry.path().filename().string() + ".o";
    const fs::path rooms = build / "src/orthodrive";
    const fs::path of_part = rooms / "CMakeFiles/orthodrive_part_train.dir" / room / file;
    add_symbols(fs::exists(of_part) ? of_part : rooms / room / "CMakeFiles" / ("orthodrive_" + room + ".dir") / file,
                defined, wanted);
  }
  EXPECT_GT(sources, 50);
  add_symbols(build / "app/CMakeFiles/orthodrive-train.dir/train_packed.cpp.o", defined, wanted);
  add_symbols(build / "app/CMakeFiles/orthodrive_terminal.dir/terminal_monitor.cpp.o", defined, wanted);
  for (const auto& [name, object] : wanted) EXPECT_TRUE(defined.contains(name)) << object << " wants " << name;
}

}  // namespace
}  // namespace orthodrive
