// SPDX-License-Identifier: Apache-2.0
// What reruns a stage of `orthodrive build`, and what it says of it.

#include <fstream>
#include <functional>

#include "faults/small_site.hpp"

namespace orthodrive {
namespace {
namespace fs = std::filesystem;
using testing::HasSubstr;

/// A letter per stage in their order: t(aken over), r(uns), d(epends on what it reads).
std::string fates(const std::string& explained) {
  std::istringstream in(explained);
  std::string line, letters;
  while (std::getline(in, line)) {
    const std::string text = line.substr(10);
    if (!line.starts_with("report")) letters += text == "taken over" ? 't' : text.starts_with("runs: ") ? 'r' : 'd';
  }
  return letters;
}

TEST(Keys, each_option_and_source_reruns_what_depends_on_it) {
  const SmallBuild small;
  const auto explained = [&](const Arguments& settings) {
    Arguments more{"--explain"};
    for (const std::string& setting : settings) more.insert(more.end(), {"--set", setting});
    return small.build(more);
  };
  write_bytes(small.site() / "more.osm", "<osm version=\"0.6\"/>\n");
  write_bytes(small.site() / "log.csv", "x\n");
  fs::copy_file(small.site() / "dtm_1m.tif", small.site() / "other.tif");
  const fs::path before_map = paths::in_source("models/training/two_towns.safetensors");
  struct Change {
    Arguments settings;
    const char* expected;  // segment refine elevate network drive scene
    const char* said;
  };
  for (const Change& c : std::vector<Change>{
           {{}, "tttttt", ""},
           {{"attribution.text='another text'"}, "tttttt", ""},
           {{"segment.crf=true"}, "rddddd", "option segment.crf was false, is true"},
           {{"segment.adapt=true"}, "rddddd", "option segment.adapt"},
           {{"segment.model='" + before_map.string() + "'"}, "rddddd", "source model: two_towns.safetensors is new"},
           {{"refine.driving_side=left"}, "trrrdd", "option refine.driving_side was \"right\", is \"left\""},
           {{"refine.weights=log.csv"}, "trdddd", "source refine_weights: log.csv is new"},
           {{"sources.gpx=more.osm"}, "trdddd", "source gpx: more.osm is new"},
           {{"elevate.sampling=bilinear"}, "ttrddd", "option elevate.sampling was \"cubic\", is \"bilinear\""},
           {{"sources.dtm=['other.tif', 'dtm_1m.tif']"}, "ttrddr", "source dtm: other.tif is new"},
           {{"sources.drive_logs=log.csv"}, "ttrddd", "source drive_logs: log.csv is new"},
           {{"sources.control_points=log.csv"}, "ttrddd", "source control_points: log.csv is new"},
           {{"name=Other"}, "tttrdd", "option name was "},
           {{"network.weather=wet"}, "tttrdd", "option network.weather was \"dry\", is \"wet\""},
           {{"network.opendrive='1.8'"}, "tttrdd", "option network.opendrive was \"1.7\", is \"1.8\""},
           {{"network.opendrive='1.8'", "network.junction_grids=true"}, "tttrdd", "option network.junction_grids"},
           {{"network.crg=all"}, "tttrdd", "option network.crg"},
           {{"sources.buildings=more.osm"}, "tttttr", "source buildings: more.osm is new"},
           {{"sources.trees=more.osm"}, "tttttr", "source trees: more.osm is new"},
           {{"sources.surroundings=more.osm"}, "tttttr", "source surroundings: more.osm is new"},
           {{"drive.route=Other"}, "ttttrt", "option drive.route was \"Circuit\", is \"Other\""},
           {{"area.bounds=[460010, 5270010, 460190, 5270190]"}, "rrrddr", "option area changed"}}) {
    const auto before = snapshot(small.folder());
    const ToolRun run = explained(c.settings);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    EXPECT_EQ(run.err, "");
    EXPECT_EQ(fates(run.out), c.expected) << run.out;
    EXPECT_THAT(run.out, HasSubstr(c.said));
    EXPECT_TRUE(snapshot(small.folder()) == before) << "it writes";
  }
}

TEST(Keys, each_file_that_is_touched_reruns_what_reads_it) {
  struct Change {
    const char* file;
    std::function<void(const fs::path&)> how;
    const char* expected;
    const char* said;
  };
  const auto grow = [](const fs::path& file) { std::ofstream(file, std::ios::app) << "<!-- -->\n"; };
  const auto remove = [](const fs::path& file) { fs::remove_all(file); };
  // The date and the size stay as they were.
  const auto edit = [](const fs::path& file) {
    const auto time = fs::last_write_time(file);
    std::string bytes = bytes_of(file);
    bytes[bytes.size() / 2] ^= 1;
    write_bytes(file, bytes);
    fs::last_write_time(file, time);
  };
  const auto create = [](const fs::path& file) { write_bytes(file, "<PAMDataset/>\n"); };
  for (const Change& c : std::vector<Change>{
           {"site/roads.osm", grow, "rrrddr", "source osm: roads.osm has other content"},
           {"site/ortho.tif", edit, "rddddr", "source photo: ortho.tif has other content"},
           {"site/ortho.tif.aux.xml", create, "rddddr", "source photo: ortho.tif.aux.xml is new"},
           {"site/dtm_1m.tif", edit, "ttrddr", "source dtm: dtm_1m.tif has other content"},
           {"out/labels.tif", edit, "rddddd", "output labels.tif is not what it wrote"},
           {"out/.orthodrive/refined.gpkg", remove, "trdddd", "output .orthodrive/refined.gpkg is missing"},
           {"out/roads.gpkg", edit, "ttrddd", "output roads.gpkg is not what it wrote"},
           {"out/roads.xodr", remove, "tttrdd", "output roads.xodr is missing"},
           {"out/scene/tileset.json", grow, "tttttr", "output scene is not what it wrote"},
           {"out/drive", remove, "ttttrt", "output drive is missing"},
           {"out/report.html", remove, "tttttt", ""},
           {"out/.orthodrive/network.json", remove, "tttrdd", "it has not run here"},
           {"out/.orthodrive/scene.json", [](const fs::path& f) { truncate_to(f, 0.5); }, "tttttr", "record"},
           {"out/.orthodrive/scene.json", [](const fs::path& f) { write_bytes(f, "{\"depends\": 3}"); }, "tttttr",
            "its record is damaged"},
           {"out/.orthodrive/hashes.json", [](const fs::path& f) { write_bytes(f, "[[]]"); }, "tttttt", ""}}) {
    const SmallBuild small;
    c.how(small.folder() / c.file);
    const ToolRun run = small.build({"--explain"});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    EXPECT_EQ(fates(run.out), c.expected) << c.file << "\n" << run.out;
    EXPECT_THAT(run.out, HasSubstr(c.said)) << c.file;
  }
}

TEST(Keys, a_folder_without_a_build_runs_all) {
  const SmallBuild small;
  fs::remove_all(small.out());
  const ToolRun run = small.build({"--explain"});
  EXPECT_EQ(fates(run.out), "rrrrrr") << run.out;
  EXPECT_THAT(run.out, HasSubstr("it has not run here"));
  EXPECT_FALSE(fs::exists(small.out()));
}

TEST(Keys, what_comes_out_as_it_was_reruns_nothing_after_it) {
  const SmallBuild small;
  std::ofstream(small.site() / "roads.osm", std::ios::app) << "<!-- other content, the same roads -->\n";
  const ToolRun run = small.build({"--set", "attribution.text='Photo: somebody else'"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(small.stages_run(), (std::vector<std::string>{"segment", "refine", "elevate", "scene"}));
  EXPECT_THAT(bytes_of(small.out() / "report.html"), HasSubstr("Photo: somebody else"));
  EXPECT_THAT(bytes_of(small.out() / "run.json"), HasSubstr("Photo: somebody else"));
  small.expect_results_of_undisturbed_build("item.json");  // names the attribution
  EXPECT_EQ(fates(small.build({"--explain"}).out), "tttttt");
}

/// What a stage opens below the site, the output folder and the models while it runs has to be in its key.
TEST(Keys, stages_declare_what_they_read) {
  const SmallBuild small;
  fs::remove_all(small.out());
  const fs::path log = small.folder() / "opened.txt";
  const ToolRun run = small.build_with({"SHIM_LOG=" + log.string()}, {"--threads", "2"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  std::vector<std::string> opened;
  std::map<std::string, std::vector<std::string>> by_stage;
  std::ifstream in(log);
  bool begun = false;
  for (std::string line; std::getline(in, line);) {
    const fs::path path = fs::absolute(line.substr(2)).lexically_normal();
    begun = begun || path == small.out() / ".orthodrive/lock";  // before it sources are looked at and hashed
    if (!begun) continue;
    if (line[0] == 'r') opened.push_back(path);
    const std::string name = path.filename();
    for (const char* stage : {"segment", "refine", "elevate", "network", "scene", "drive"})
      if (line[0] == 'w' && path.parent_path() == small.out() / ".orthodrive" &&
          name.starts_with("." + std::string(stage) + ".partial-"))
        by_stage[stage] = std::exchange(opened, {});
  }
  ASSERT_EQ(by_stage.size(), 6u);
  std::size_t checked = 0;
  for (const auto& [stage, files] : by_stage) {
    const auto record = nlohmann::json::parse(bytes_of(small.out() / ".orthodrive" / (stage + ".json")));
    std::vector<std::string> declared;
    for (const auto& role : record.at("depends").at("sources"))
      for (const auto& file : role) declared.push_back(file.at("file"));
    const auto below_out = [&](const std::string& path) {
      const std::string name = fs::relative(path, small.out());
      for (const char* of : {"reads", "outputs"})
        for (const auto& item : (std::string(of) == "reads" ? record.at("depends") : record).at(of).items())
          if (name == item.key() || name.starts_with(item.key() + "/")) return true;
      return name.find(".partial-") != std::string::npos || name.ends_with(".json");  // its own, and records
    };
    for (const std::string& path : files) {
      if (fs::is_directory(path)) continue;
      if (path.starts_with(small.out().string() + "/")) {
        EXPECT_TRUE(below_out(path)) << stage << " reads " << path;
      } else if (path.starts_with(small.site().string() + "/") ||
                 path.starts_with(paths::in_source("models").string() + "/")) {
        EXPECT_THAT(declared, testing::Contains(fs::path(path).filename().string())) << stage << " reads " << path;
      } else {
        continue;
      }
      ++checked;
    }
  }
  EXPECT_GT(checked, 10u);
}

}  // namespace
}  // namespace orthodrive
