// SPDX-License-Identifier: Apache-2.0
// Whether somebody changed what a stage makes and forgot its version. The stages after segment run on fixed labels, and
// hashes of what they write are compared with those of tests/pipeline/stage_results.txt.
//
// ORTHODRIVE_RECORD=1 writes that file anew.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <sstream>

#include "app/run_tool.hpp"
#include "orthodrive/core/hash.hpp"
#include "orthodrive/io/models/alignment_io.hpp"
#include "orthodrive/io/raster/raster_io.hpp"
#include "orthodrive/pipeline/stages/run_drive.hpp"
#include "orthodrive/pipeline/stages/run_elevate.hpp"
#include "orthodrive/pipeline/stages/run_network.hpp"
#include "orthodrive/pipeline/stages/run_refine.hpp"
#include "orthodrive/pipeline/stages/run_scene.hpp"

extern "C" const char* GDALVersionInfo(const char*);  // io links GDAL and keeps its headers to itself

namespace orthodrive {
namespace {
namespace fs = std::filesystem;

/// Libraries round differently: hashes of another platform say nothing.
std::string platform() {
  const bool fma = __builtin_cpu_supports("fma") != 0;
  return fmt::format("g++ {} GDAL {} {}", __VERSION__, GDALVersionInfo("RELEASE_NAME"), fma ? "fma" : "no fma");
}

std::string hash_of(const fs::path& folder, const std::vector<std::string>& names) {
  std::string all;
  const auto add = [&](const fs::path& file) {  // reports hold speeds of this machine
    if (file.filename() != "report.html") all += fs::relative(file, folder).string() + hash_file(file) + "\n";
  };
  for (const std::string& name : names) {
    if (!fs::is_directory(folder / name)) {
      add(folder / name);
      continue;
    }
    for (const auto& [file, bytes] : snapshot(folder / name)) add(file);
  }
  return hash_bytes(all);
}

struct StageResult {
  int version = 0;
  std::string inputs, results;  ///< hashes
};

/// Runs the stage. Findings count as results.
StageResult run(const BuildStage& stage, const fs::path& out, const std::string& hash_of_site) {
  StageResult result{.version = stage.version, .inputs = hash_bytes(hash_of_site + hash_of(out, stage.reads))};
  const StageOutcome outcome = stage.run();
  std::string all = hash_of(out, stage.outputs);
  for (const Finding& f : outcome.findings)
    all += fmt::format("{} {} {:.3f} {:.3f}\n", f.code, f.message, f.x_m, f.y_m);
  result.results = hash_bytes(all);
  return result;
}

/// 255 where the labels have a road.
void write_road_probability(const fs::path& labels_file, const fs::path& file) {
  const LabelMap labels = io::read_labels(labels_file);
  ConfidenceMap road{labels.crs, labels.frame, labels.labels};
  for (std::uint8_t& value : road.confidence.data)
    value = value < labels.classes.classes.size() && labels.classes.classes[value].role == Role::road ? 255 : 0;
  io::write_confidence(file, road);
}

TEST(StageVersions, other_results_have_another_version) {
  const Scratch scratch;
  const fs::path folder = scratch / "site", out = scratch / "out";
  ASSERT_EQ(run_tool({"-q", "synth", "--seed", "3", "--size", "200", "--gsd", "0.5", "-o", folder}).exit_code, 0);
  const Site site = read_site(folder / "site.toml");
  fs::create_directories(out / ".orthodrive");
  fs::copy_file(folder / "truth/labels.tif", out / "labels.tif");
  write_road_probability(folder / "truth/labels.tif", out / "road_probability.tif");
  io::write_alignment(out / ".orthodrive/alignment.csv", {}, {});
  const std::string of_site = hash_of(folder, {"ortho.tif", "roads.osm", "dtm_1m.tif", "truth/labels.tif"});

  SiteBuild build{site, out, {.threads = 2}};
  std::string text =
      "# Stage, version, hashes of inputs and results on fixed labels. Written by "
      "tests/pipeline/stage_versions_test.cpp.\n" +
      platform() + "\n";
  std::map<std::string, StageResult> now;
  for (const BuildStage& stage :
       {refine_stage(build), elevate_stage(build), network_stage(build), scene_stage(build), drive_stage(build)}) {
    const StageResult& result = now[stage.name] = run(stage, out, of_site);
    text += fmt::format("{} {} {} {}\n", stage.name, result.version, result.inputs, result.results);
  }
  const fs::path file = paths::in_source("tests/pipeline/stage_results.txt");
  if (std::getenv("ORTHODRIVE_RECORD")) write_bytes(file, text);

  std::istringstream in(bytes_of(file));
  std::string line, name;
  std::getline(in, line);
  std::getline(in, line);
  if (line != platform()) GTEST_SKIP() << "recorded on '" << line << "', this is '" << platform() << "'";
  StageResult recorded;
  std::size_t compared = 0;
  const char* anew = "record anew: ORTHODRIVE_RECORD=1 test_pipeline --gtest_filter='StageVersions.*' (docs/build.md)";
  while (in >> name >> recorded.version >> recorded.inputs >> recorded.results) {
    ASSERT_TRUE(now.contains(name)) << name;
    const StageResult& result = now.at(name);
    EXPECT_EQ(result.version, recorded.version) << "stage " << name << " has a new version; " << anew;
    if (name == "refine") {
      EXPECT_EQ(result.inputs, recorded.inputs) << "the site or its labels changed; " << anew;
    }
    if (result.inputs == recorded.inputs && result.version == recorded.version) {  // else an earlier stage is told of
      EXPECT_EQ(result.results, recorded.results)
          << "stage " << name << " makes other results of the same inputs than version " << recorded.version
          << " did: raise BuildStage::version in run_" << name
          << ".cpp, so that results of earlier programs are not taken over, and " << anew;
    }
    ++compared;
  }
  EXPECT_EQ(compared, now.size());
}

}  // namespace
}  // namespace orthodrive
