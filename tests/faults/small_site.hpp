// SPDX-License-Identifier: Apache-2.0
#pragma once
// The small site and copies of its build.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/run_tool.hpp"

namespace orthodrive {

/// A copy of the small site and of its build, to be spoiled.
class SmallBuild {
 public:
  SmallBuild() {
    namespace fs = std::filesystem;
    const fs::path sites = paths::test_sites;
    fs::copy(sites / "small_site", site(), fs::copy_options::recursive);
    fs::copy(sites / "small", out(), fs::copy_options::recursive);
  }
  [[nodiscard]] std::filesystem::path site() const { return scratch_ / "site"; }
  [[nodiscard]] std::filesystem::path out() const { return scratch_ / "out"; }
  [[nodiscard]] std::filesystem::path folder() const { return scratch_.folder(); }

  [[nodiscard]] Arguments command(Arguments more = {}) const {
    Arguments words{paths::tool, "build", site() / "site.toml", "-o", out()};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
  [[nodiscard]] ToolRun build(Arguments more = {}) const { return run_program(command(std::move(more))); }
  /// With faults of the shim: "SHIM_CALL=write".
  [[nodiscard]] ToolRun build_with(Arguments settings, Arguments more = {}) const {
    Arguments words{"/usr/bin/env", std::string("LD_PRELOAD=") + FAULT_SHIM};
    words.insert(words.end(), settings.begin(), settings.end());
    const Arguments tool = command(std::move(more));
    words.insert(words.end(), tool.begin(), tool.end());
    return run_program(words);
  }
  [[nodiscard]] std::vector<std::string> stages_run() const {
    std::vector<std::string> names;
    const auto run = nlohmann::json::parse(bytes_of(out() / "run.json"));
    for (const auto& stage : run.at("stages"))
      if (!stage.at("skipped").get<bool>() && stage.at("stage") != "report") names.push_back(stage.at("stage"));
    return names;
  }
  /// Forgets that the stage and those after it have run, and what they left, as if the build had come to it.
  void forget_from(const std::string& stage) const {
    namespace fs = std::filesystem;
    static const std::vector<std::string> order{"segment", "refine", "elevate", "network", "scene", "drive"};
    for (auto name = std::ranges::find(order, stage); name != order.end(); ++name) {
      const fs::path file = out() / ".orthodrive" / (*name + ".json");
      if (!fs::exists(file)) continue;  // it did not come so far
      const auto record = nlohmann::json::parse(bytes_of(file));
      for (const auto& output : record.at("outputs").items()) fs::remove_all(out() / output.key());
      fs::remove(file);
    }
  }
  /// The results by their name; what holds times is left out.
  [[nodiscard]] static std::map<std::string, std::string> results(const std::filesystem::path& out) {
    std::map<std::string, std::string> files;
    for (const auto& [path, bytes] : snapshot(out)) {
      const std::string name = std::filesystem::relative(path, out).string();
      const bool record = name.starts_with(".orthodrive/") && name.ends_with(".json");
      if (!record && name != "run.json" && name.find("report.html") == std::string::npos) files[name] = bytes;
    }
    return files;
  }
  /// `but`: a file that may differ.
  void expect_results_of_undisturbed_build(const std::string& but = "") const {
    auto ours = results(out()), theirs = results(std::filesystem::path(paths::test_sites) / "small");
    ours.erase(but), theirs.erase(but);
    for (const auto& [name, bytes] : theirs) {
      const auto found = ours.find(name);
      if (found == ours.end())
        ADD_FAILURE() << "missing: " << name;
      else
        EXPECT_TRUE(found->second == bytes) << name;
    }
    for (const auto& [name, bytes] : ours) EXPECT_TRUE(theirs.contains(name)) << "left behind: " << name;
  }

 private:
  Scratch scratch_;
};

inline std::size_t lines_of(const std::string& text) {
  return static_cast<std::size_t>(std::ranges::count(text, '\n'));
}

}  // namespace orthodrive
