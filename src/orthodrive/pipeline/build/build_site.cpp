// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/pipeline/build/build_site.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <stdexcept>

#include "orthodrive/core/atomic_file.hpp"
#include "orthodrive/core/stop.hpp"
#include "orthodrive/io/support/vector_io.hpp"
#include "orthodrive/pipeline/build/run_report.hpp"
#include "orthodrive/pipeline/build/side_files.hpp"
#include "orthodrive/pipeline/build/site_stages.hpp"
#include "orthodrive/pipeline/files/output_lock.hpp"
#include "orthodrive/pipeline/score/score.hpp"
#include "orthodrive/pipeline/stages/cell_exchange.hpp"

namespace orthodrive {
namespace {
namespace fs = std::filesystem;

/// Everything of a site that is not a file, for run.json.
nlohmann::json options_of(const Site& site) {
  nlohmann::json options = frame_options(site.frame);
  options.update({{"name", site.name},
                  {"model", site.model},
                  {"crf", site.crf},
                  {"adapt", site.adapt},
                  {"dtm_sampling", site.dtm_sampling},
                  {"route", site.route},
                  {"attribution", site.attribution}});
  return options;
}

/// Sources that stay in memory are read without opening a file: a stage that forgets one would be taken over too often.
void require_declared(const BuildStage& stage, const std::set<std::string>& asked) {
  for (const std::string& role : asked)
    if (std::ranges::find(stage.sources, role, &SourceRole::role) == stage.sources.end())
      throw std::logic_error("stage " + stage.name + " reads the source " + role + " and does not declare it");
}

/// The temporaries of processes that were killed: in every folder that a build writes into.
void remove_leftovers(const fs::path& out_dir, const std::vector<BuildStage>& stages) {
  std::set<fs::path> folders{out_dir, out_dir / ".orthodrive"};
  for (const BuildStage& stage : stages)
    for (const std::string& output : stage.outputs)
      if (fs::is_directory(out_dir / output)) folders.insert(out_dir / output);
  for (const fs::path& folder : folders) remove_stale_atomic_files(folder);
}

/// Of the result and of the input against the site's truth; null without truth.
nlohmann::json score_build(const Site& site, const fs::path& out_dir) {
  if (site.truth_dir.empty()) return nullptr;
  return {{"result", score_site({out_dir, site.truth_dir})},
          {"input", {{"roads", score_roads({site.osm.front(), site.truth_dir})}}}};
}

nlohmann::json to_json(const StageRecord& record) {
  return {{"stage", record.stage},
          {"seconds", record.seconds},
          {"peak_memory_bytes", record.peak_memory_bytes},
          {"skipped", record.skipped},
          {"key", record.key},
          {"numbers", record.outcome.numbers},
          {"findings", record.outcome.findings.size()}};
}

/// The stages of one build with all that decides whether they run.
class StageRunner {
 public:
  StageRunner(SiteBuild& build, const WatchedSources& sources, FileHashes& hashes, std::optional<BuildShare> share)
      : build_(build), sources_(sources), hashes_(hashes), share_(share), cache_(build.out_dir, hashes) {}

  StageRecord run(const BuildStage& stage) {
    const StageDependencies now = dependencies_of(stage, sources_, made_);
    const bool unchanged = cache_.changes(stage.name, now, stage.outputs).reasons.empty();
    StageRecord record = unchanged ? take_over(stage) : make(stage, now);
    for (const auto& [name, hash] : record.outputs) made_[name] = hash;
    return record;
  }
  /// The report is not a cached stage: it shows the timings, which change. It costs a few seconds.
  StageRecord report(const std::vector<StageRecord>& records, const nlohmann::json& scores) {
    return cache_.run("report", {}, {}, [&] { return run_report(build_, records, scores); });
  }

 private:
  StageRecord take_over(const BuildStage& stage) {
    build_.context.info(fmt::format("{:<9} unchanged, taken over", stage.name));
    return cache_.load(stage.name);
  }
  StageRecord make(const BuildStage& stage, const StageDependencies& now) {
    const CellStore cells(build_.out_dir, stage.name, key_of(stage.name, now));
    std::optional<CellExchange> exchange;
    if (share_ && stage.help) {
      cells.open();
      exchange.emplace(cells, CellExchange::Role::builds, share_->first());
    } else if (!cells.empty()) {
      exchange.emplace(cells);  // of a build that was shared and did not end
    }
    build_.context.exchange = exchange ? &*exchange : nullptr;
    StageRecord record = cache_.run(stage.name, now, stage.outputs, [&] {
      (void)build_.context.sources.take_asked();
      StageOutcome outcome;
      sources_.require_unchanged(stage, [&] { outcome = stage.run(); });
      require_declared(stage, build_.context.sources.take_asked());
      return outcome;
    });
    build_.context.info(fmt::format("{:<9} {:6.1f} s  {:5.0f} MB", stage.name, record.seconds,
                                    static_cast<double>(record.peak_memory_bytes) / 1e6));
    hashes_.keep();
    build_.context.exchange = nullptr;
    CellStore::remove(build_.out_dir, stage.name);
    return record;
  }

  SiteBuild& build_;
  const WatchedSources& sources_;
  FileHashes& hashes_;
  std::optional<BuildShare> share_;
  StageCache cache_;
  OutputHashes made_;
};

}  // namespace

BuildResult build_site(const Site& site, const fs::path& out_dir, const BuildOptions& options, Monitor* monitor) {
  SiteBuild build{site, out_dir, {.threads = options.threads, .monitor = monitor}};
  const std::vector<BuildStage> stages = stages_of(build);
  WatchedSources sources(stages);
  for (const BuildStage& stage : stages) {
    throw_if_stopped();
    if (stage.check) stage.check();
  }
  FileHashes hashes(out_dir / private_folder / "hashes.json");
  sources.read(hashes);

  const OutputLock lock(out_dir / private_folder / "lock", monitor);
  if (options.share && options.share->index > 0 && !lock.is_certain())
    throw FolderInUse(fmt::format("{}: its file system has no locks; index 0 builds", out_dir.string()));
  remove_leftovers(out_dir, stages);
  StageRunner runner(build, sources, hashes, options.share);
  BuildResult result;
  const auto tell = [&](const std::string& stage) {
    throw_if_stopped();
    if (options.at_stage) options.at_stage(stage);
  };
  for (const BuildStage& stage : stages) {
    tell(stage.name);
    result.stages.push_back(runner.run(stage));
  }
  tell("report");

  Findings findings = site.findings;
  for (const StageRecord& record : result.stages) append(findings, record.outcome.findings);
  const nlohmann::json scores = score_build(site, out_dir);
  result.stages.push_back(runner.report(result.stages, scores));
  io::write_findings(out_dir / "findings.geojson", findings, site.frame.crs);

  nlohmann::json run{{"tool", "orthodrive"},    {"version", options.version},      {"site", options_of(site)},
                     {"inputs", sources.all()}, {"attribution", site.attribution}, {"stages", nlohmann::json::array()}};
  for (const StageRecord& record : result.stages) run["stages"].push_back(to_json(record));
  if (!scores.is_null()) run["scores"] = scores;
  write_text_file(out_dir / "run.json", run.dump(1) + "\n");
  write_side_files(site, out_dir, options.version);
  hashes.keep();
  CellStore::remove_all(out_dir);
  tell("");
  return result;
}

std::vector<StageForecast> explain_build(const Site& site, const fs::path& out_dir) {
  SiteBuild build{site, out_dir, {}};
  const std::vector<BuildStage> stages = stages_of(build);
  FileHashes hashes(out_dir / private_folder / "hashes.json");
  WatchedSources sources(stages);
  sources.read(hashes);
  const StageCache cache(out_dir, hashes);
  OutputHashes made;
  std::vector<StageForecast> forecasts;
  for (const BuildStage& stage : stages) {
    using Fate = StageForecast::Fate;
    StageChanges changes = cache.changes(stage.name, dependencies_of(stage, sources, made), stage.outputs);
    const Fate fate = !changes.reasons.empty()   ? Fate::runs
                      : !changes.unknown.empty() ? Fate::depends
                                                 : Fate::taken_over;
    for (const std::string& name : stage.outputs) made[name] = std::nullopt;
    if (fate == Fate::taken_over)
      for (const auto& [name, hash] : cache.load(stage.name).outputs) made[name] = hash;
    forecasts.push_back({stage.name, fate, std::move(changes)});
  }
  return forecasts;
}

}  // namespace orthodrive
