// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/pipeline/build/work_on_site.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <set>
#include <thread>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/stop.hpp"
#include "orthodrive/pipeline/build/site_stages.hpp"
#include "orthodrive/pipeline/files/output_lock.hpp"

namespace orthodrive {
namespace {
namespace fs = std::filesystem;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr auto before_looking_for_a_builder = 10s;
constexpr auto before_giving_up = 15min;  // where the file system cannot tell whether somebody builds
constexpr auto shortest_pause = 50ms, longest_pause = 300ms;

/// A build as one sees it that runs none of its stages.
class Helper {
 public:
  Helper(const Site& site, const fs::path& out_dir, const BuildOptions& options, Monitor* monitor)
      : build_{site, out_dir, {.threads = options.threads, .monitor = monitor}},
        stages_(stages_of(build_)),
        sources_(stages_),
        hashes_(out_dir / private_folder / "hashes.json"),
        cache_(out_dir, hashes_) {
    sources_.read(hashes_);
  }

  /// What there is to do, as the files are now.
  struct Outlook {
    const BuildStage* stage = nullptr;  ///< to help with
    StageDependencies now;
    std::vector<std::string> missing;  ///< stages; "report"
  };
  [[nodiscard]] Outlook look() const {
    Outlook outlook;
    OutputHashes made;
    for (const BuildStage& stage : stages_) {
      StageDependencies now = dependencies_of(stage, sources_, made);
      const bool is_open = std::ranges::all_of(now.reads, [](const auto& read) { return read.second.has_value(); });
      if (is_open && is_made(stage, now)) {
        for (const auto& [name, hash] : cache_.load(stage.name).outputs) made[name] = hash;
        continue;
      }
      outlook.missing.push_back(stage.name);
      for (const std::string& name : stage.outputs) made[name] = std::nullopt;
      if (!outlook.stage && is_open && stage.help && !helped_.contains(key_of(stage.name, now)))
        outlook.stage = &stage, outlook.now = std::move(now);
    }
    if (!outlook.missing.empty() || !is_reported(build_.out_dir, stages_, cache_)) outlook.missing.push_back("report");
    return outlook;
  }

  void help(const Outlook& outlook, const BuildShare& share) {
    const BuildStage& stage = *outlook.stage;
    const std::string key = key_of(stage.name, outlook.now);
    const CellStore store(build_.out_dir, stage.name, key);
    store.open();
    // The cells go after the record is written: from here on they stay until it is.
    if (!is_made(stage, outlook.now)) {
      CellExchange exchange(store, CellExchange::Role::helps, share.first());
      build_.context.exchange = &exchange;
      sources_.require_unchanged(stage, [&] {
        try {
          stage.help();
        } catch (const StageIsMade&) {  // NOLINT(bugprone-empty-catch): nothing is left to help with
        }
      });
      build_.context.exchange = nullptr;
    }
    helped_.insert(key);
    if (is_made(stage, outlook.now)) CellStore::remove(build_.out_dir, stage.name);
  }

 private:
  [[nodiscard]] bool is_made(const BuildStage& stage, const StageDependencies& now) const {
    return cache_.changes(stage.name, now, stage.outputs).reasons.empty();
  }

  SiteBuild build_;
  std::vector<BuildStage> stages_;
  WatchedSources sources_;
  FileHashes hashes_;
  StageCache cache_;
  std::set<std::string> helped_;  // keys of stages
};

/// Until the build is complete: true. False: nobody builds.
bool help_build(const Site& site, const fs::path& out_dir, const BuildShare& share, const BuildOptions& options,
                Monitor* monitor) {
  Helper helper(site, out_dir, options, monitor);
  std::chrono::milliseconds pause = shortest_pause;
  Clock::time_point idle_since = Clock::now();
  std::size_t missing_before = 0;
  while (true) {
    throw_if_stopped();
    const Helper::Outlook outlook = helper.look();
    if (outlook.missing.empty()) return true;
    if (outlook.stage) {
      if (options.at_stage) options.at_stage(outlook.stage->name);
      helper.help(outlook, share);
    }
    if (outlook.stage || outlook.missing.size() != missing_before) {
      missing_before = outlook.missing.size();
      idle_since = Clock::now(), pause = shortest_pause;
      continue;
    }
    const auto idle = Clock::now() - idle_since;
    if (idle > before_looking_for_a_builder) {
      const std::optional<bool> held = OutputLock::is_held(out_dir / private_folder / "lock");
      if (held == false) return false;
      if (!held && idle > before_giving_up)
        throw Error(fmt::format("{}: nothing has changed for {} minutes; start index 0 again", out_dir.string(),
                                before_giving_up.count()));
    }
    std::this_thread::sleep_for(pause);
    pause = std::min<std::chrono::milliseconds>(pause * 2, longest_pause);
  }
}
}  // namespace

void work_on_site(const Site& site, const fs::path& out_dir, const BuildShare& share, const BuildOptions& options,
                  Monitor* monitor) {
  BuildOptions shared = options;
  shared.share = share;
  for (bool build = share.index == 0;; build = true) {
    if (build) {
      try {
        (void)build_site(site, out_dir, shared, monitor);
        return;
      } catch (const FolderInUse&) {  // NOLINT(bugprone-empty-catch): who builds it can be helped
      }
    }
    if (help_build(site, out_dir, share, options, monitor)) return;
  }
}

std::vector<std::string> missing_stages(const Site& site, const fs::path& out_dir) {
  return Helper(site, out_dir, {}, nullptr).look().missing;
}

}  // namespace orthodrive
