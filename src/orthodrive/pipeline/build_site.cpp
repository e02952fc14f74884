#include "orthodrive/pipeline/build_site.hpp"

#include <fmt/format.h>

#include "orthodrive/core/atomic_file.hpp"
#include "orthodrive/core/hash.hpp"
#include "orthodrive/io/raster_io.hpp"
#include "orthodrive/io/vector_io.hpp"
#include "orthodrive/pipeline/run_drive.hpp"
#include "orthodrive/pipeline/run_elevate.hpp"
#include "orthodrive/pipeline/run_network.hpp"
#include "orthodrive/pipeline/run_refine.hpp"
#include "orthodrive/pipeline/run_report.hpp"
#include "orthodrive/pipeline/run_scene.hpp"
#include "orthodrive/pipeline/run_segment.hpp"
#include "orthodrive/pipeline/score.hpp"

namespace orthodrive {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;

/// All stages in their order.
std::vector<BuildStage> stages_of(SiteBuild& build) {
  return {segment_stage(build), refine_stage(build), elevate_stage(build),
          network_stage(build), scene_stage(build),  drive_stage(build)};
}

json hash_source(const fs::path& file, SourceRole::Kind kind) {
  json source{{"file", file.filename().string()}, {"hash", hash_file(file)}};
  if (kind == SourceRole::Kind::raster) {  // it may have its place in a file beside it, which counts as well
    json outline = json::array();
    for (const Vec2 p : io::raster_info(file).outline_lonlat.outer) outline.push_back({p.x, p.y});
    source["outline_hash"] = hash_bytes(outline.dump());
  }
  return source;
}

/// By role; roles without a file are left out.
json hash_sources(const std::vector<BuildStage>& stages) {
  json hashes = json::object();
  for (const BuildStage& stage : stages)
    for (const SourceRole& source : stage.sources) {
      if (hashes.contains(source.role)) continue;  // several stages read it
      for (const fs::path& file : source.files) hashes[source.role].push_back(hash_source(file, source.kind));
    }
  return hashes;
}

/// Everything of a site that is not a file and changes results.
json options_of(const Site& site) {
  json ring = json::array();
  for (const Vec2 p : site.frame.area.outer) ring.push_back({p.x, p.y});
  return {{"name", site.name},
          {"crs", site.frame.crs.definition},
          {"area", hash_bytes(ring.dump())},
          {"model", site.model},
          {"crf", site.crf},
          {"adapt", site.adapt},
          {"dtm_sampling", site.dtm_sampling},
          {"route", site.route},
          {"attribution", site.attribution}};
}

/// A key stands for the tool, the options and the sources of a stage and of all before it: one change runs what follows
/// again.
class KeyChain {
 public:
  KeyChain(const json& site_options, const json& hashes)
      : hashes_(hashes),
        key_(hash_bytes(hash_file("/proc/self/exe") + site_options.at("crs").dump() + site_options.at("area").dump())) {
  }
  std::string next(const BuildStage& stage) {
    json depends_on = json::array({stage.options});
    for (const SourceRole& source : stage.sources)
      depends_on.push_back(source.files.empty() ? json() : hashes_.value(source.role, json()));
    return key_ = hash_bytes(key_ + stage.name + depends_on.dump());
  }
  [[nodiscard]] const std::string& last() const { return key_; }

 private:
  const json& hashes_;
  std::string key_;
};

StageRecord run_stage(const BuildStage& stage, const std::string& key, StageCache& cache, StageContext& context) {
  if (cache.holds(stage.name, key)) {
    context.info(fmt::format("{:<9} unchanged, taken over", stage.name));
    return cache.load(stage.name);
  }
  StageRecord record = cache.run(stage.name, key, stage.outputs, stage.run);
  context.info(fmt::format("{:<9} {:6.1f} s  {:5.0f} MB", stage.name, record.seconds,
                           static_cast<double>(record.peak_memory_bytes) / 1e6));
  return record;
}

/// Of the result and of the input against the site's truth; null without truth.
json score_build(const Site& site, const fs::path& out_dir) {
  if (site.truth_dir.empty()) return nullptr;
  return {{"result", score_site({out_dir, site.truth_dir})},
          {"input", {{"roads", score_roads({site.osm.front(), site.truth_dir})}}}};
}

json to_json(const StageRecord& record) {
  return {{"stage", record.stage},
          {"seconds", record.seconds},
          {"peak_memory_bytes", record.peak_memory_bytes},
          {"skipped", record.skipped},
          {"key", record.key},
          {"numbers", record.outcome.numbers},
          {"findings", record.outcome.findings.size()}};
}
}  // namespace

BuildResult build_site(const Site& site, const fs::path& out_dir, const BuildOptions& options, Monitor* monitor) {
  SiteBuild build{site, out_dir, {.threads = options.threads, .monitor = monitor}};
  const std::vector<BuildStage> stages = stages_of(build);
  for (const BuildStage& stage : stages)
    if (stage.check) stage.check();
  const json hashes = hash_sources(stages), site_options = options_of(site);

  remove_stale_atomic_files(out_dir);
  StageCache cache(out_dir);
  KeyChain keys(site_options, hashes);
  BuildResult result;
  for (const BuildStage& stage : stages)
    result.stages.push_back(run_stage(stage, keys.next(stage), cache, build.context));

  Findings findings;
  for (const StageRecord& record : result.stages) append(findings, record.outcome.findings);
  const json scores = score_build(site, out_dir);
  // The report is not a cached stage: it shows the timings, which change. It costs a few seconds.
  result.stages.push_back(
      cache.run("report", keys.last(), {}, [&] { return run_report(build, result.stages, scores); }));
  io::write_findings(out_dir / "findings.geojson", findings, site.frame.crs);

  json run{{"tool", "orthodrive"}, {"version", options.version},      {"site", site_options},
           {"inputs", hashes},     {"attribution", site.attribution}, {"stages", json::array()}};
  for (const StageRecord& record : result.stages) run["stages"].push_back(to_json(record));
  if (!scores.is_null()) run["scores"] = scores;
  write_text_file(out_dir / "run.json", run.dump(1) + "\n");
  return result;
}

}  // namespace orthodrive
