// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "load_runs.hpp"

namespace orthodrive::app {
namespace {
void print_json(const SiteSize& size, const BuildEstimate& all) {
  nlohmann::ordered_json out{{"area_km2", size.area_km2},
                             {"megapixels", size.megapixels},
                             {"road_km", size.road_km},
                             {"machine", runs().machine_of_costs()},
                             {"speed", all.speed},
                             {"seconds", all.seconds},
                             {"memory_mb", all.memory_mb},
                             {"disk_mb", all.disk_mb},
                             {"stages", nlohmann::ordered_json::array()}};
  for (const StageEstimate& s : all.stages)
    out["stages"].push_back(
        {{"stage", s.stage}, {"seconds", s.seconds}, {"memory_mb", s.memory_mb}, {"disk_mb", s.disk_mb}});
  fmt::print("{}\n", out.dump(1));
}

void print_table(const SiteSize& size, const BuildEstimate& all) {
  fmt::print("{:.2f} km2, {:.1f} million pixels, {:.1f} km of road\n", size.area_km2, size.megapixels, size.road_km);
  fmt::print("{:<9} {:>9} {:>10} {:>9}\n", "stage", "time (s)", "memory", "disk");
  const auto line = [](const std::string& name, double seconds, double memory_mb, double disk_mb) {
    fmt::print("{:<9} {:>9.1f} {:>7.0f} MB {:>6.0f} MB\n", name, seconds, memory_mb, disk_mb);
  };
  for (const StageEstimate& s : all.stages) line(s.stage, s.seconds, s.memory_mb, s.disk_mb);
  line("all", all.seconds, all.memory_mb, all.disk_mb);
  fmt::print("Estimated from builds on {}; this machine, as busy as it is now, has {:.2f} of its speed.\n",
             runs().machine_of_costs(), all.speed);
}
}  // namespace

void add_plan(CLI::App& app, Context& context) {
  struct Arguments {
    std::filesystem::path site;
    std::vector<std::string> overrides;
    bool json = false;
  };
  auto args = std::make_shared<Arguments>();
  CLI::App* cmd =
      app.add_subcommand("plan", "Estimates time, memory and disk of a build, stage by stage; builds nothing.");
  cmd->add_option("site", args->site, "site file (TOML) as for `orthodrive build`")->required();
  cmd->add_option("--set", args->overrides, "override of the site file, section.key=value; may be repeated");
  cmd->add_flag("--json", args->json, "JSON on standard output");
  cmd->footer(
      "Reads the site file, the header of its photo and its map, and tries for half a second how fast the machine is.\n"
      "Estimates are good to a factor of two for a build from nothing;\n"
      "segment.adapt and segment.crf are not in them.\n\n"
      "Examples:\n"
      "  orthodrive plan sites/kvarnbyn.toml\n"
      "  orthodrive --threads 8 plan site.toml --json");
  cmd->callback([args, &context] {
    const SiteSize size = runs().size_of(runs().read_site(args->site, args->overrides));
    const BuildEstimate all = runs().estimate_build(size, runs().measure_machine_speed(context.threads));
    args->json ? print_json(size, all) : print_table(size, all);
  });
}

}  // namespace orthodrive::app
