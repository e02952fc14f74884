// SPDX-License-Identifier: Apache-2.0
// `orthodrive-train` on a pack against `orthodrive train` on the files the pack was made of.
#include <algorithm>
#include <fstream>
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
theta_alpha_px = [5, 9]
theta_beta = [11]
appearance_weight = [2.5]
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
  expect_failure(run_trainer({pack, "-o", out, "--crf", "--weights", weights}), 2, "--weights changes nothing");
  EXPECT_FALSE(fs::exists(out / "model.safetensors"));
  // A folder with a training in it is not begun anew.
  fs::create_directories(out);
  std::ofstream(out / "checkpoint.safetensors") << "kept";
  expect_failure(run_trainer({pack, "-o", out, "--weights", weights}), 2, "--resume");
  EXPECT_EQ(bytes_of(out / "checkpoint.safetensors"), "kept");
}

/// A machine with libtorch alone: the bundle builds there, and its program asks for nothing else. (The libtorch of
/// Debian asks for GDAL in turn.)
TEST(TrainPackedProgram, builds_from_its_bundle_with_libtorch_alone) {
  const Scratch scratch;
  const fs::path bundle = scratch / "bundle", build = scratch / "build";
  const ToolRun collected = run_program({paths::in_source("tools/trainer/bundle"), bundle});
  ASSERT_EQ(collected.exit_code, 0) << collected.err;
  EXPECT_FALSE(fs::exists(bundle / "src/orthodrive/io/models/caffe_model.cpp"));
  const ToolRun configured = run_program(
      {"/usr/bin/cmake", "-S", bundle, "-B", build, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=None", "-DCMAKE_CXX_FLAGS=-O0"});
  ASSERT_EQ(configured.exit_code, 0) << configured.err;
  const ToolRun built = run_program({"/usr/bin/cmake", "--build", build});
  ASSERT_EQ(built.exit_code, 0) << built.out << built.err;
  const ToolRun needed = run_program({"/usr/bin/readelf", "--dynamic", "--wide", build / "orthodrive-train"});
  EXPECT_NE(needed.out.find("[libtorch_cpu"), std::string::npos) << needed.out;
  for (const char* library : {"[libgdal", "[libproj", "[libgeos", "[libprotobuf"})
    EXPECT_EQ(needed.out.find(library), std::string::npos) << needed.out;
  const ToolRun called = run_program({build / "orthodrive-train", scratch / "none.safetensors"});
  EXPECT_EQ(called.exit_code, 2);
  EXPECT_NE(called.err.find("-o is missing"), std::string::npos) << called.err;
}

}  // namespace
}  // namespace orthodrive
