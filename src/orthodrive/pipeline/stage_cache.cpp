#include "orthodrive/pipeline/stage_cache.hpp"

#include <algorithm>
#include <chrono>
#include <fstream>

#include "orthodrive/core/atomic_file.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/core/hash.hpp"
#include "orthodrive/core/memory.hpp"

namespace orthodrive {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;

/// Hash of a file, or of the names and contents of all files in a folder.
std::string hash_path(const fs::path& path) {
  if (!fs::is_directory(path)) return hash_file(path);
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(path))
    if (entry.is_regular_file()) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  std::string all;
  for (const fs::path& file : files) all += fs::relative(file, path).string() + "\n" + hash_file(file) + "\n";
  return hash_bytes(all);
}

json to_json(const Findings& findings) {
  json list = json::array();
  for (const Finding& f : findings)
    list.push_back({{"severity", static_cast<int>(f.severity)},
                    {"code", f.code},
                    {"message", f.message},
                    {"x", f.x_m},
                    {"y", f.y_m}});
  return list;
}

Findings findings_from_json(const json& list) {
  Findings findings;
  for (const json& f : list)
    findings.push_back(
        {static_cast<Severity>(f.at("severity").get<int>()), f.at("code"), f.at("message"), f.at("x"), f.at("y")});
  return findings;
}
}  // namespace

StageCache::StageCache(fs::path out_dir) : out_dir_(std::move(out_dir)) {}

fs::path StageCache::private_file(const std::string& name) const { return out_dir_ / ".orthodrive" / name; }

bool StageCache::holds(const std::string& stage, const std::string& key) const {
  std::ifstream in(private_file(stage + ".json"));
  if (!in) return false;
  const json record = json::parse(in, nullptr, false);
  if (record.is_discarded() || record.value("key", "") != key) return false;
  for (const auto& [name, hash] : record.at("outputs").items())
    if (!fs::exists(out_dir_ / name) || hash_path(out_dir_ / name) != hash) return false;
  return true;
}

StageRecord StageCache::load(const std::string& stage) const {
  std::ifstream in(private_file(stage + ".json"));
  const json record = json::parse(in);
  return {stage,
          record.at("key"),
          {.numbers = record.at("numbers"), .findings = findings_from_json(record.at("findings"))},
          record.at("seconds"),
          record.at("peak_memory_bytes"),
          true};
}

StageRecord StageCache::run(const std::string& stage, const std::string& key, const std::vector<std::string>& outputs,
                            const std::function<StageOutcome()>& body) {
  reset_peak_memory();
  const auto start = std::chrono::steady_clock::now();
  StageRecord record{stage, key, body()};
  record.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  record.peak_memory_bytes = peak_memory_bytes();

  json file{{"key", key},
            {"numbers", record.outcome.numbers},
            {"findings", to_json(record.outcome.findings)},
            {"seconds", record.seconds},
            {"peak_memory_bytes", record.peak_memory_bytes},
            {"outputs", json::object()}};
  for (const std::string& name : outputs) file["outputs"][name] = hash_path(out_dir_ / name);
  write_text_file(private_file(stage + ".json"), file.dump(1) + "\n");
  return record;
}

}  // namespace orthodrive
