// SPDX-License-Identifier: Apache-2.0
// Kills, stops, full disks, folders without permission, sources that change: the same bytes in the end, or one clear
// line and nothing lost.

#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>

#include <chrono>
#include <ctime>
#include <fstream>
#include <thread>

#include "faults/small_site.hpp"

namespace orthodrive {
namespace {
namespace fs = std::filesystem;
using namespace std::chrono_literals;
using testing::HasSubstr;
std::vector<std::string> temporaries_in(const fs::path& folder) {
  std::vector<std::string> found;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.path().filename().string().find(".partial-") != std::string::npos) found.push_back(entry.path());
  return found;
}

/// Time of the processor that children which have ended took, s.
double cpu_seconds_of_children() {
  rusage usage{};
  getrusage(RUSAGE_CHILDREN, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

/// The same of a child that runs.
double cpu_seconds_of(pid_t child) {
  clockid_t clock{};
  timespec t{};
  if (clock_getcpuclockid(child, &clock) != 0 || clock_gettime(clock, &t) != 0) return 0.0;
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// A build that gets a signal once it has written a file, however fast the machine is. The processor's time is what it
/// takes from the signal to its end.
struct Interrupted {
  int exit_code = 0;
  double cpu_seconds_to_end = 0.0;
  std::string err;
};
Interrupted interrupt(const SmallBuild& small, int signal, const char* once_written) {
  const fs::path out = small.folder() / "stdout", err = small.folder() / "stderr";
  const pid_t child = start_program(small.command({"--threads", "2"}), out, err);
  const double before = cpu_seconds_of_children();
  while (!fs::exists(small.out() / ".orthodrive" / once_written)) std::this_thread::sleep_for(1ms);
  const double at_signal = cpu_seconds_of(child);
  kill(child, signal);
  Interrupted result{.exit_code = wait_for(child)};
  result.cpu_seconds_to_end = cpu_seconds_of_children() - before - at_signal;
  result.err = bytes_of(err);
  return result;
}

TEST(Faults, ctrl_c_ends_soon_and_cleanly_and_the_next_build_goes_on) {
  const SmallBuild small;
  for (const auto& [signal, once_written] :
       {std::pair{SIGINT, "lock"}, {SIGTERM, "segment.json"}, {SIGINT, "refine.json"}}) {
    fs::remove_all(small.out());
    const Interrupted run = interrupt(small, signal, once_written);
    EXPECT_EQ(run.exit_code, 128 + signal) << run.err;
    EXPECT_LT(run.cpu_seconds_to_end, 10.0) << "2 s of two threads";
    EXPECT_TRUE(run.err.ends_with("orthodrive: stopped; run again to go on\n")) << run.err;
    EXPECT_THAT(temporaries_in(small.out()), testing::IsEmpty());
    ASSERT_EQ(small.build().exit_code, 0);
    small.expect_results_of_undisturbed_build();
  }
}

TEST(Faults, a_killed_build_goes_on_to_the_same_bytes) {
  const SmallBuild small;
  fs::remove_all(small.out());
  for (const char* once_written : {"lock", "lock", "segment.json", "elevate.json"})
    EXPECT_EQ(interrupt(small, SIGKILL, once_written).exit_code, 128 + SIGKILL);
  ASSERT_EQ(small.build().exit_code, 0);
  EXPECT_THAT(temporaries_in(small.out()), testing::IsEmpty());
  small.expect_results_of_undisturbed_build();
}

/// One line on standard error that names the file, exit code 1, no temporary; then the same command finishes.
void expect_one_line(const SmallBuild& small, const ToolRun& run, const std::string& named, const std::string& what) {
  EXPECT_EQ(run.exit_code, 1) << what << "\n" << run.err;
  EXPECT_EQ(lines_of(run.err), 1u) << what << "\n" << run.err;
  EXPECT_THAT(run.err, testing::StartsWith("orthodrive: ")) << what;
  EXPECT_THAT(run.err, HasSubstr(named)) << what;
  EXPECT_THAT(temporaries_in(small.out()), testing::IsEmpty()) << what;
}

struct Output {
  const char* stage;  ///< that writes it
  const char* file;   ///< part of the names of the file and of its temporary
  const char* named;  ///< in the message
};
const Output outputs[] = {
    {"segment", "labels.", "labels.tif"},
    {"segment", "alignment.", "alignment.csv"},
    {"refine", "refined.", "refined.gpkg"},
    {"elevate", "out/.roads.", "roads.gpkg"},
    {"elevate", "road_graph.", "road_graph.geojson"},
    {"network", ".xodr", "roads.xodr"},
    {"scene", ".glb", ".glb"},
    {"scene", "tileset.", "tileset"},
    {"drive", "lap.", "drive/lap.csv"},
    {"", "report.partial", "report.html"},
    {"", "findings.", "findings.geojson"},
    {"", "run.partial", "run.json"},
    {"", "item.partial", "item.json"},
};

struct Fault {
  const char* what;
  Arguments settings;
};

/// One fault after the other; together they take a build and a half.
void spoil_outputs(const std::vector<Fault>& faults, std::size_t first = 0, std::size_t step = 1) {
  const SmallBuild small;
  for (std::size_t i = first; i < std::size(outputs); i += step) {
    const Output& output = outputs[i];
    const Fault& fault = faults[i / step % faults.size()];
    if (output.stage[0] != '\0') small.forget_from(output.stage);
    Arguments settings = fault.settings;
    settings.push_back(std::string("SHIM_FILE=") + output.file);
    const ToolRun run = small.build_with(settings, {"--quiet"});
    expect_one_line(small, run, output.named, std::string(fault.what) + " at " + output.file);
  }
  ASSERT_EQ(small.build().exit_code, 0);
  small.expect_results_of_undisturbed_build();
}

TEST(Faults, a_full_disk_is_one_line_wherever_it_strikes) {
  spoil_outputs({{"no room", {"SHIM_CALL=write"}}, {"room for 600 bytes", {"SHIM_CALL=write", "SHIM_BYTES=600"}}});
}

TEST(Faults, a_file_that_may_not_be_made_or_take_its_place_is_one_line) {
  spoil_outputs({{"no permission", {"SHIM_CALL=open", "SHIM_ERRNO=" + std::to_string(EACCES)}},
                 {"read-only", {"SHIM_CALL=rename", "SHIM_ERRNO=" + std::to_string(EROFS)}}},
                1, 2);
}

/// Those of GDAL are read back to their end instead: its version 3.6 does not tell.
TEST(Faults, what_fails_as_a_file_is_closed_is_noticed) {
  const SmallBuild small;
  for (const Output& output : outputs) {
    const std::string named = output.named;
    if (named != "roads.xodr" && named != ".glb" && named != "drive/lap.csv" && named != "run.json") continue;
    if (output.stage[0] != '\0') small.forget_from(output.stage);
    const ToolRun run = small.build_with({"SHIM_CALL=close", std::string("SHIM_FILE=") + output.file}, {"--quiet"});
    expect_one_line(small, run, output.named, std::string("close of ") + output.file);
  }
}

TEST(Faults, a_read_only_folder_is_one_line_and_keeps_what_it_holds) {
  const SmallBuild small;
  const auto before = snapshot(small.out());
  const ToolRun run = small.build_with(
      {"SHIM_CALL=open", "SHIM_ERRNO=" + std::to_string(EROFS), "SHIM_FILE=" + small.out().string()}, {"--quiet"});
  expect_one_line(small, run, ".orthodrive/lock", "read-only");
  EXPECT_TRUE(snapshot(small.out()) == before);
}

/// The file grows while the network looks at the photo.
TEST(Faults, a_source_that_changes_under_way_is_one_line_and_the_stage_does_not_count) {
  const SmallBuild small;
  fs::remove_all(small.out());
  const fs::path err = small.folder() / "stderr";
  const pid_t child = start_program(small.command({"--quiet"}), small.folder() / "stdout", err);
  while (!fs::exists(small.out() / ".orthodrive/lock")) std::this_thread::sleep_for(1ms);
  std::ofstream(small.site() / "roads.osm", std::ios::app) << "<!-- -->\n";
  EXPECT_EQ(wait_for(child), 1);
  EXPECT_EQ(lines_of(bytes_of(err)), 1u) << bytes_of(err);
  EXPECT_THAT(bytes_of(err), HasSubstr("roads.osm: changed while stage segment read it"));
  EXPECT_FALSE(fs::exists(small.out() / ".orthodrive/segment.json"));
  ASSERT_EQ(small.build().exit_code, 0);
  small.expect_results_of_undisturbed_build();
}

/// Another program writes the photo anew while the network looks for it: the reader meets a file without a header.
TEST(Faults, a_source_that_is_half_written_under_way_has_changed) {
  const SmallBuild small;
  fs::remove_all(small.out());
  const fs::path photo = small.site() / "ortho.tif", err = small.folder() / "stderr";
  const std::string bytes = bytes_of(photo);
  const pid_t child = start_program(small.command({"--quiet"}), small.folder() / "stdout", err);
  while (!fs::exists(small.out() / ".orthodrive/lock")) std::this_thread::sleep_for(1ms);
  std::ofstream(photo).close();
  EXPECT_EQ(wait_for(child), 1);
  EXPECT_EQ(lines_of(bytes_of(err)), 1u) << bytes_of(err);
  EXPECT_THAT(bytes_of(err), HasSubstr("ortho.tif: changed while stage segment read it"));
  std::ofstream(photo, std::ios::binary) << bytes;
  ASSERT_EQ(small.build().exit_code, 0);
  small.expect_results_of_undisturbed_build();
}

TEST(Faults, a_second_build_into_the_folder_is_refused_with_the_name_of_the_first) {
  const SmallBuild small;
  for (const std::string lock : {"SHIM_OTHER=1", "SHIM_NO_FLOCK=1"}) {
    small.forget_from("segment");
    const fs::path err = small.folder() / "stderr";
    Arguments first{"/usr/bin/env", std::string("LD_PRELOAD=") + FAULT_SHIM, lock};
    const Arguments tool = small.command({"--quiet"});
    first.insert(first.end(), tool.begin(), tool.end());
    const pid_t child = start_program(first, small.folder() / "stdout", err);
    while (bytes_of(small.out() / ".orthodrive/lock").find('\n') == std::string::npos) std::this_thread::sleep_for(1ms);
    const ToolRun second = small.build_with({lock}, {"--quiet"});
    EXPECT_EQ(second.exit_code, 1) << lock;
    EXPECT_EQ(lines_of(second.err), 1u) << second.err;
    std::array<char, 256> host{};
    gethostname(host.data(), host.size() - 1);
    EXPECT_THAT(second.err, HasSubstr("process " + std::to_string(child) + " on " + host.data())) << lock;
    EXPECT_EQ(small.build({"--explain"}).exit_code, 0) << "looking is allowed";
    EXPECT_EQ(wait_for(child), 0) << bytes_of(err);
    small.expect_results_of_undisturbed_build();
    EXPECT_FALSE(fs::exists(small.out() / ".orthodrive/lock"));
  }
}

/// What a killed process on another host left does not stop anybody.
TEST(Faults, a_lock_of_a_process_that_is_gone_is_none) {
  const SmallBuild small;
  write_bytes(small.out() / ".orthodrive/lock", "elsewhere 4711\n");
  EXPECT_EQ(small.build({"--quiet"}).exit_code, 0);
  write_bytes(small.out() / ".orthodrive/lock", "elsewhere 4711\n");
  const ToolRun run = small.build_with({"SHIM_NO_FLOCK=1"});
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_THAT(run.err, HasSubstr("process 4711 on elsewhere"));
}

TEST(Faults, clocks_that_jump_change_nothing) {
  const SmallBuild small;
  // Everything from a day that is yet to come: nothing is trusted, nothing is wrong.
  for (const auto& entry : fs::recursive_directory_iterator(small.folder()))
    if (entry.is_regular_file()) fs::last_write_time(entry.path(), fs::file_time_type::clock::now() + 48h);
  ASSERT_EQ(small.build({"--quiet"}).exit_code, 0);
  EXPECT_EQ(small.stages_run(), std::vector<std::string>{});
  for (const auto& entry : fs::recursive_directory_iterator(small.folder()))
    if (entry.is_regular_file()) fs::last_write_time(entry.path(), fs::file_time_type{} + 1h);
  ASSERT_EQ(small.build({"--quiet"}).exit_code, 0);
  EXPECT_EQ(small.stages_run(), std::vector<std::string>{});
}

}  // namespace
}  // namespace orthodrive
