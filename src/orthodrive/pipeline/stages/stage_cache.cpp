// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/pipeline/stages/stage_cache.hpp"

#include <fmt/format.h>

#include <chrono>
#include <fstream>
#include <set>

#include "orthodrive/core/atomic_file.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/core/hash.hpp"
#include "orthodrive/core/memory.hpp"
#include "orthodrive/core/stop.hpp"

namespace orthodrive {
namespace {
namespace fs = std::filesystem;

nlohmann::json to_json(const Findings& findings) {
  nlohmann::json list = nlohmann::json::array();
  for (const Finding& f : findings)
    list.push_back({{"severity", static_cast<int>(f.severity)},
                    {"code", f.code},
                    {"message", f.message},
                    {"x", f.x_m},
                    {"y", f.y_m}});
  return list;
}

Findings findings_from_json(const nlohmann::json& list) {
  Findings findings;
  for (const nlohmann::json& f : list)
    findings.push_back(
        {static_cast<Severity>(f.at("severity").get<int>()), f.at("code"), f.at("message"), f.at("x"), f.at("y")});
  return findings;
}

nlohmann::json to_json(const StageDependencies& now) {
  nlohmann::json reads = nlohmann::json::object();
  for (const auto& [name, hash] : now.reads) reads[name] = hash ? nlohmann::json(*hash) : nlohmann::json();
  return {{"version", now.version}, {"options", now.options}, {"sources", now.sources}, {"reads", reads}};
}

/// What of two objects differs, by name.
std::set<std::string> different_names(const nlohmann::json& before, const nlohmann::json& now) {
  std::set<std::string> names;
  for (const auto& [name, value] : before.items())
    if (!now.contains(name) || now.at(name) != value) names.insert(name);
  for (const auto& [name, value] : now.items())
    if (!before.contains(name)) names.insert(name);
  return names;
}

std::string option_reason(const std::string& name, const nlohmann::json& before, const nlohmann::json& now) {
  constexpr std::size_t most = 60;  // longer ones are lists and hashes, which say nothing to a person
  const std::string from = before.contains(name) ? before.at(name).dump() : "unset",
                    to = now.contains(name) ? now.at(name).dump() : "unset";
  if (from.size() + to.size() > most) return "option " + name + " changed";
  return fmt::format("option {} was {}, is {}", name, from, to);
}

std::string source_reason(const std::string& role, const nlohmann::json& before, const nlohmann::json& now) {
  const nlohmann::json none = nlohmann::json::array();
  const nlohmann::json &was = before.contains(role) ? before.at(role) : none,
                       &is = now.contains(role) ? now.at(role) : none;
  std::map<std::string, std::string> hashes;
  for (const nlohmann::json& file : was) hashes[file.at("file")] = file.at("hash");
  for (const nlohmann::json& file : is) {
    const auto found = hashes.find(file.at("file"));
    if (found == hashes.end()) return fmt::format("source {}: {} is new", role, file.at("file").get<std::string>());
    if (found->second != file.at("hash").get<std::string>())
      return fmt::format("source {}: {} has other content", role, file.at("file").get<std::string>());
  }
  if (is.size() < was.size()) return fmt::format("source {}: {} of {} files are left", role, is.size(), was.size());
  return fmt::format("source {}: other files or another order", role);
}

/// Reasons by comparing what a record says with what counts now.
StageChanges compare(const nlohmann::json& before, const nlohmann::json& now) {
  StageChanges changes;
  if (before.at("version") != now.at("version"))
    changes.reasons.push_back(
        fmt::format("version was {}, is {}", before.at("version").dump(), now.at("version").dump()));
  for (const std::string& name : different_names(before.at("options"), now.at("options")))
    changes.reasons.push_back(option_reason(name, before.at("options"), now.at("options")));
  for (const std::string& role : different_names(before.at("sources"), now.at("sources")))
    changes.reasons.push_back(source_reason(role, before.at("sources"), now.at("sources")));
  for (const std::string& name : different_names(before.at("reads"), now.at("reads"))) {
    if (!now.at("reads").contains(name))
      changes.reasons.push_back("it does not read " + name + " any more");
    else if (now.at("reads").at(name).is_null())
      changes.unknown.push_back(name);
    else
      changes.reasons.push_back(fmt::format("{} has other content than when it was read", name));
  }
  return changes;
}
}  // namespace

std::string key_of(const std::string& stage, const StageDependencies& dependencies) {
  return hash_bytes(stage + to_json(dependencies).dump());
}

StageCache::StageCache(fs::path out_dir, FileHashes& hashes) : out_dir_(std::move(out_dir)), hashes_(hashes) {}

fs::path StageCache::private_file(const std::string& name) const { return out_dir_ / ".orthodrive" / name; }

StageChanges StageCache::changes(const std::string& stage, const StageDependencies& now,
                                 const std::vector<std::string>& outputs) const {
  const fs::path file = private_file(stage + ".json");
  std::ifstream in(file);
  if (!in) return {.reasons = {fs::exists(file) ? "its record cannot be read" : "it has not run here"}};
  const nlohmann::json record = nlohmann::json::parse(in, nullptr, false);
  try {
    if (!record.is_object() || !record.contains("depends")) return {.reasons = {"no record of it can be used"}};
    StageChanges changes = compare(record.at("depends"), to_json(now));
    for (const std::string& name : outputs) {
      const std::string hash = record.at("outputs").value(name, "");
      if (!fs::exists(out_dir_ / name))
        changes.reasons.push_back("output " + name + " is missing");
      else if (hashes_.hash(out_dir_ / name) != hash)
        changes.reasons.push_back("output " + name + " is not what it wrote");
    }
    (void)load(stage);
    return changes;
  } catch (const nlohmann::json::exception&) {
    return {.reasons = {"its record is damaged"}};
  }
}

StageRecord StageCache::load(const std::string& stage) const {
  std::ifstream in(private_file(stage + ".json"));
  const nlohmann::json record = nlohmann::json::parse(in);
  return {.stage = stage,
          .key = record.at("key"),
          .outcome = {.numbers = record.at("numbers"), .findings = findings_from_json(record.at("findings"))},
          .seconds = record.at("seconds"),
          .peak_memory_bytes = record.at("peak_memory_bytes"),
          .skipped = true,
          .outputs = record.at("outputs").get<std::map<std::string, std::string>>()};
}

StageRecord StageCache::run(const std::string& stage, const StageDependencies& now,
                            const std::vector<std::string>& outputs, const std::function<StageOutcome()>& body) {
  throw_if_stopped();
  reset_peak_memory();
  const nlohmann::json depends = to_json(now);
  const auto start = std::chrono::steady_clock::now();
  StageRecord record{.stage = stage, .key = key_of(stage, now), .outcome = body()};
  record.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  record.peak_memory_bytes = peak_memory_bytes();
  for (const std::string& name : outputs) record.outputs[name] = hashes_.hash(out_dir_ / name);

  const nlohmann::json file{{"key", record.key},
                            {"depends", depends},
                            {"numbers", record.outcome.numbers},
                            {"findings", to_json(record.outcome.findings)},
                            {"seconds", record.seconds},
                            {"peak_memory_bytes", record.peak_memory_bytes},
                            {"outputs", record.outputs}};
  write_text_file(private_file(stage + ".json"), file.dump(1) + "\n");
  return record;
}

}  // namespace orthodrive
