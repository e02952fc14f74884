// SPDX-License-Identifier: Apache-2.0
// `orthodrive train` as a user meets it: what a run leaves in its folder, going on after a kill, stages, the CRF, and
// whatever may be wrong with data, weights and checkpoints. Networks learn next to nothing in the few steps here;
// whether they learn is tested in tests/segment.

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/file.h>
#include <unistd.h>

#include <chrono>
#include <cstring>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "app/expect_clean_failure.hpp"
#include "orthodrive/io/raster/raster_io.hpp"
#include "paths.hpp"

namespace orthodrive {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

const std::string models = paths::in_source("models").string();
const std::string shipped_network = models + "/networks/mobilenetv2-fpn.toml";
const std::string shipped_weights = models + "/default.safetensors";

/// Header of a safetensors file: 8 bytes of length, that many bytes of JSON, the data.
struct Safetensors {
  explicit Safetensors(const fs::path& file) : bytes(bytes_of(file)) {
    std::uint64_t length = 0;
    if (bytes.size() >= sizeof(length)) std::memcpy(&length, bytes.data(), sizeof(length));
    if (length == 0 || bytes.size() < sizeof(length) + length) {
      ADD_FAILURE() << file << " is no safetensors file";
      return;
    }
    header = nlohmann::json::parse(bytes.substr(sizeof(length), length));
    data_begin = sizeof(length) + length;
  }
  [[nodiscard]] std::string metadata(const std::string& key) const {
    return header.at("__metadata__").at(key).get<std::string>();
  }
  /// Where the data of a tensor begins in `bytes`, and how long it is.
  [[nodiscard]] std::pair<std::size_t, std::size_t> place(const std::string& tensor) const {
    const auto& offsets = header.at(tensor).at("data_offsets");
    const auto begin = offsets[0].get<std::size_t>();
    return {data_begin + begin, offsets[1].get<std::size_t>() - begin};
  }
  [[nodiscard]] std::string data(const std::string& tensor) const {
    const auto [begin, size] = place(tensor);
    return bytes.substr(begin, size);
  }
  std::string bytes;
  nlohmann::json header;
  std::size_t data_begin = 0;
};

/// A folder with a photo of 96 px, its labels (road in the left third, grass beside it), and experiments.
class Workshop {
 public:
  static constexpr int size = 96;
  const Scratch scratch;
  const fs::path images = scratch / "images", labels = scratch / "labels", out = scratch / "out";

  Workshop() {
    fs::create_directories(images), fs::create_directories(labels);
    io::write_png(images / "a.png", made_photo());
    io::write_png(labels / "a.png", painted_labels());
  }
  /// Writes an experiment: what every one here has, then the keys of [train], the rest of the file before and after it.
  [[nodiscard]] std::string experiment(const std::string& train, const std::string& data,
                                       const std::string& before = start_from_shipped()) const {
    const std::string file = scratch / fmt::format("experiment-{}.toml", ++experiments_);
    write_bytes(file, fmt::format("{}\n[train]\n{}\n{}\n", before, train, data));
    return file;
  }
  [[nodiscard]] static std::string start_from_shipped() {
    return fmt::format("network = \"{}\"\nweights = [\"{}\"]", shipped_network, shipped_weights);
  }
  [[nodiscard]] std::string pictures(const std::string& more = "") const {
    return fmt::format(
        "[[images]]\nname = \"pictures\"\nimages = \"images\"\nlabels = \"labels\"\n{}\n"
        "palette = [{{color = [255, 0, 0], classes = [\"road\"]}}, {{color = [0, 255, 0], classes = [\"grass\"]}}]",
        more);
  }
  /// The same pictures once to learn from and once to measure on.
  [[nodiscard]] std::string pictures_and_held_out() const { return pictures() + "\n" + pictures("held_out = [\"*\"]"); }
  [[nodiscard]] Arguments command(const std::string& experiment, Arguments more = {}) const {
    Arguments arguments{"--quiet", "--threads", "1", "train", experiment, "-o", out};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
  void run(const std::string& experiment, const Arguments& more = {}) const {
    const ToolRun result = run_tool(command(experiment, more));
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(result.err, "");
  }
  /// Bad data: exit code 1, one line naming the file, nothing changed.
  void expect_failure(const std::string& named, const std::string& experiment, const Arguments& more = {}) const {
    SCOPED_TRACE(bytes_of(experiment));
    expect_clean_failure(scratch.folder(), named, [&] { return run_tool(command(experiment, more)); });
  }
  /// Options that cannot be: exit code 2, one line that says which, nothing changed.
  void expect_usage_error(const std::string& named, const std::string& experiment, const Arguments& more = {}) const {
    SCOPED_TRACE(bytes_of(experiment));
    expect_clean_failure(scratch.folder(), named, [&] {
      ToolRun result = run_tool(command(experiment, more));
      EXPECT_EQ(result.exit_code, 2);
      result.exit_code = 1;  // the rest is alike
      return result;
    });
  }
  [[nodiscard]] static Raster<std::uint8_t> painted_labels() {
    Raster<std::uint8_t> image(size, size, 3, 0);
    for (int row = 0; row < size; ++row)
      for (int col = 0; col < size; ++col) image.at(col, row, col < size / 3 ? 0 : 1) = 255;
    return image;
  }

 private:
  [[nodiscard]] static Raster<std::uint8_t> made_photo() {
    Raster<std::uint8_t> image(size, size, 3);
    for (std::size_t i = 0; i < image.data.size(); ++i)
      image.data[i] = static_cast<std::uint8_t>(i / 3 % size < size / 3 ? 120 + i % 7 : 60 + i % 11);
    return image;
  }
  mutable int experiments_ = 0;
};

/// Keys of [train] for a run of almost no time.
std::string few_steps(int steps, const std::string& more = "") {
  return fmt::format("steps = {0}\nwarmup_steps = 0\ndecay_from_step = {0}\nbatch = 1\ncrop_px = 64\n{1}", steps, more);
}

/// Column `column` of a comma-separated file, without its title.
std::vector<std::string> column_of(const fs::path& file, const std::string& column) {
  const auto split = [](const std::string& text, char at) {
    std::istringstream stream(text);
    std::vector<std::string> parts;
    for (std::string part; std::getline(stream, part, at);) parts.push_back(part);
    return parts;
  };
  const std::vector<std::string> lines = split(bytes_of(file), '\n');
  std::vector<std::string> values;
  if (lines.empty()) return values;
  const std::vector<std::string> titles = split(lines.front(), ',');
  const auto index = static_cast<std::size_t>(std::find(titles.begin(), titles.end(), column) - titles.begin());
  for (std::size_t i = 1; i < lines.size(); ++i) values.push_back(split(lines[i], ',').at(index));
  return values;
}

/// The smallest synthetic site, in the folder "site".
/// Of the search of a CRF.
const std::string small_grid =
    "theta_alpha_px = [5, 9]\ntheta_beta = [11]\nappearance_weight = [2.5]\ntheta_gamma_px = [1]\n"
    "smoothness_weight = [0.5, 1.5]\nfewer_iterations = []\n";

void make_site(const Workshop& shop) {
  const ToolRun made = run_tool({"--quiet", "--threads", "1", "synth", "--preset", "village", "--seed", "5", "--size",
                                 "200", "--gsd", "0.5", "-o", shop.scratch / "site"});
  EXPECT_EQ(made.exit_code, 0) << made.err;
}

TEST(Train, leaves_a_model_that_segments_then_learns_a_crf_and_packs_its_data) {
  const Workshop shop;
  make_site(shop);
  const std::string site = "[[raster]]\nname = \"site\"\nfolder = \"site\"";
  const std::string experiment =
      shop.experiment(few_steps(10), site + "\n[[raster]]\nname = \"held-out\"\nfolder = \"site\"\nheld_out = true\n" +
                                         "[crf]\nsteps = 2\nbatch = 1\nsearch_crops = 1\niterations = "
                                         "2\nvalidate_every = 0\nunary_compatibility = true\n" +
                                         small_grid);
  const auto segment = [&](const fs::path& model, const Arguments& more) {
    Arguments arguments{"--threads", "1",  "segment", shop.scratch / "site/ortho.tif", "-o", shop.scratch / "l.tif",
                        "--model",   model};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ToolRun result = run_tool(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_THAT(result.err, Not(HasSubstr("no trained CRF")));
    return bytes_of(shop.scratch / "l.tif");
  };

  shop.run(experiment);
  for (const char* file : {"model", "checkpoint", "best"}) {
    const Safetensors weights(shop.out / (std::string(file) + ".safetensors"));
    EXPECT_EQ(weights.metadata("architecture"), "mobilenetv2-s32-fpn2") << file;
    EXPECT_EQ(weights.metadata("step"), "10") << file;
  }
  EXPECT_EQ(column_of(shop.out / "log.csv", "step"), (std::vector<std::string>{"10", "10", "10"}));
  EXPECT_EQ(column_of(shop.out / "log.csv", "validation"), (std::vector<std::string>{"", "held-out", "mean"}));
  EXPECT_GT(std::stod(column_of(shop.out / "log.csv", "mean_iou")[2]), 0.3) << "the shipped weights know such sites";
  EXPECT_THAT(bytes_of(shop.out / "training.html"), HasSubstr("</html>"));
  EXPECT_THAT(bytes_of(shop.out / "weights_mobilenetv2-s32-fpn2.txt"), HasSubstr("taken"));
  EXPECT_EQ(bytes_of(shop.out / "experiment.toml"), bytes_of(experiment));
  const std::string plain = segment(shop.out / "model.safetensors", {});

  shop.run(experiment, {"--crf"});
  const fs::path crf = shop.out / "crf";
  EXPECT_EQ(column_of(crf / "search.csv", "theta_alpha_px").size(), 5u)
      << "none, two widths, two weights of smoothness";
  EXPECT_EQ(column_of(crf / "log.csv", "step").back(), "2");
  EXPECT_FALSE(bytes_of(crf / "searched.safetensors") == bytes_of(crf / "model.safetensors"));
  EXPECT_TRUE(Safetensors(crf / "model.safetensors").header.contains("crf/unary_compatibility"));
  EXPECT_TRUE(Safetensors(crf / "checkpoint.safetensors").header.contains("crf/unary_change/first_moment"));
  EXPECT_FALSE(segment(crf / "model.safetensors", {"--crf"}) == plain);
  shop.expect_usage_error("--resume", experiment, {"--crf"});

  // The pack, read here by its description (packed_scenes.hpp).
  const std::string pack = shop.scratch / "data.safetensors";
  const ToolRun packed = run_tool({"-q", "--threads", "1", "train", experiment, "--pack", pack});
  EXPECT_EQ(packed.exit_code, 0) << packed.err;
  const Safetensors data(pack);
  EXPECT_EQ(data.metadata("experiment"), bytes_of(experiment));
  const auto scenes = nlohmann::json::parse(data.metadata("scenes"));
  const LabelMap truth = io::read_labels(shop.scratch / "site/truth/labels.tif");
  const std::string rgb = data.data("scene/0/rgb"), allowed = data.data("scene/0/allowed"),
                    sets = data.data("scene/0/sets");
  ASSERT_EQ(allowed.size(), truth.labels.data.size());
  EXPECT_EQ(rgb.size(), 3 * allowed.size());
  EXPECT_TRUE(data.header.contains("scene/1/valid")) << "the held-out scene";
  EXPECT_EQ(scenes.size(), 2u);
  for (std::size_t i = 0; i < allowed.size(); i += 97) {
    std::uint64_t set = 0;
    std::memcpy(&set, &sets[8 * static_cast<unsigned char>(allowed[i])], sizeof(set));
    ASSERT_EQ(set, std::uint64_t{1} << truth.labels.data[i]) << i;
  }
}

TEST(Train, killed_and_resumed_gives_the_bytes_of_a_straight_run) {
  const Workshop shop;
  constexpr int steps = 24;
  const std::string experiment = shop.experiment(few_steps(steps, "validate_every = 1"), shop.pictures());
  shop.run(experiment);
  const auto straight = snapshot(shop.out);
  fs::remove_all(shop.out);

  Arguments command = shop.command(experiment);
  command.insert(command.begin(), paths::tool);
  const pid_t child = start_program(command, shop.scratch / "stdout", shop.scratch / "stderr");
  const fs::path model = shop.out / "model.safetensors";
  for (int i = 0; i < 60000 && !fs::exists(model); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(2));
  kill(child, SIGKILL);
  EXPECT_EQ(wait_for(child), 128 + SIGKILL) << "it ended before it could be killed: take more steps";
  EXPECT_LT(std::stoi(Safetensors(shop.out / "checkpoint.safetensors").metadata("step")), steps);
  // What a write that was cut off leaves behind.
  write_bytes(shop.out / (".checkpoint.partial-" + std::to_string(child) + ".safetensors"), "half a checkpoint");

  shop.expect_usage_error("--resume", experiment);
  shop.run(experiment, {"--resume"});
  const auto resumed = snapshot(shop.out);
  for (const auto& [file, content] : straight) {
    ASSERT_TRUE(resumed.contains(file)) << file;
    if (fs::path(file).extension() != ".safetensors") continue;  // times are in the log
    EXPECT_TRUE(resumed.at(file) == content) << file;
  }
  EXPECT_EQ(resumed.size(), straight.size()) << "nothing is left of the killed run";
  EXPECT_EQ(column_of(shop.out / "log.csv", "step"), (std::vector<std::string>{"10", "20"}));
}

TEST(Train, stages_hand_their_weights_on_and_can_be_added) {
  const Workshop shop;
  const auto experiment = [&](const std::string& stages) {
    return shop.experiment("preset = \"reference\"\ncrop_px = 130\nlabel_px = 0", shop.pictures() + "\n" + stages,
                           fmt::format("network = \"{}/networks/googlenet-8s.toml\"", models));
  };
  const auto stage = [](int stride) { return fmt::format("[[stage]]\nstride = {}\nsteps = 1\n", stride); };
  shop.run(experiment(stage(32) + stage(16)));
  const std::string first = bytes_of(shop.out / "weights_googlenet-32s.txt"),
                    second = bytes_of(shop.out / "weights_googlenet-16s.txt");
  EXPECT_THAT(first, HasSubstr("random"));
  EXPECT_THAT(first, Not(HasSubstr("taken")));
  EXPECT_THAT(second, HasSubstr("googlenet-32s: inception_5b/1x1"));
  EXPECT_THAT(second, HasSubstr("googlenet-32s: score"));
  EXPECT_THAT(second, HasSubstr("bilinear"));
  EXPECT_THAT(second, Not(HasSubstr("random")));
  EXPECT_EQ(Safetensors(shop.out / "model.safetensors").metadata("architecture"), "googlenet-16s");
  EXPECT_THAT(bytes_of(shop.out / "training.html"), HasSubstr("</html>")) << "also where nothing is held out";

  // A stride that does not exist is refused before anything is trained, not after the stages before it.
  shop.expect_usage_error("googlenet-4s", experiment(stage(32) + stage(16) + stage(4)), {"--resume"});
  shop.run(experiment(stage(32) + stage(16) + stage(8)), {"--resume"});
  EXPECT_THAT(bytes_of(shop.out / "weights_googlenet-8s.txt"), HasSubstr("googlenet-16s: score_pool3"));
  const std::string resumed = bytes_of(shop.out / "model.safetensors");
  fs::remove_all(shop.out);
  shop.run(experiment(stage(32) + stage(16) + stage(8)));
  EXPECT_TRUE(bytes_of(shop.out / "model.safetensors") == resumed) << "going on differs from a straight run";
  EXPECT_EQ(bytes_of(shop.out / "weights_googlenet-16s.txt"), second);
}

TEST(Train, preview_shows_labels_and_the_shares_of_classes) {
  const Workshop shop;
  const std::string experiment = shop.experiment(few_steps(1), shop.pictures_and_held_out());
  const ToolRun run = run_tool({"--threads", "1", "train", experiment, "-o", shop.out, "--preview"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr("no pixel to learn from is known to be ground, parking, building, vegetation, water"));
  EXPECT_EQ(column_of(shop.out / "class_shares.csv", "class")[1], "road");
  EXPECT_EQ(column_of(shop.out / "class_shares.csv", "training_percent"),
            (std::vector<std::string>{"0.000", "33.333", "0.000", "0.000", "0.000", "66.667", "0.000", "0.000"}));
  EXPECT_EQ(column_of(shop.out / "class_shares.csv", "held_out_percent")[5], "66.667");
  EXPECT_TRUE(fs::exists(shop.out / "pictures_held_out.png"));
}

TEST(Train, stage_starts_from_the_best_snapshot_of_the_one_before) {
  const Workshop shop;
  const auto experiment = [&](int steps, const std::string& more) {
    const std::string train = fmt::format(
        "steps = {}\nwarmup_steps = 1\nlearning_rate = 3e-3\nbatch = 1\ncrop_px = 130\nvalidate_every = 1", steps);
    return shop.experiment(train, shop.pictures_and_held_out() + "\n" + more,
                           fmt::format("network = \"{}/networks/googlenet-8s.toml\"", models));
  };
  const auto stage = [](int stride, int steps) {
    return fmt::format("[[stage]]\nstride = {}\nsteps = {}\n", stride, steps);
  };
  shop.run(experiment(4, stage(32, 4)));
  const std::string best = bytes_of(shop.out / "best.safetensors");
  shop.run(experiment(4, stage(32, 4) + stage(16, 1)), {"--resume"});
  EXPECT_TRUE(bytes_of(shop.out / "googlenet-32s.safetensors") == best);
  EXPECT_EQ(Safetensors(shop.out / "googlenet-16s.safetensors").metadata("architecture"), "googlenet-16s");
  const std::string second = bytes_of(shop.out / "checkpoint.safetensors");

  // The same as a training of its own that is given the snapshot.
  write_bytes(shop.scratch / "best.safetensors", best);
  fs::remove_all(shop.out);
  shop.run(experiment(4, stage(16, 1)), {"--weights", shop.scratch / "best.safetensors"});
  EXPECT_TRUE(bytes_of(shop.out / "checkpoint.safetensors") == second);
}

TEST(Train, reference_preset_runs) {
  const Workshop shop;
  shop.run(shop.experiment("preset = \"reference\"\nsteps = 1", shop.pictures(),
                           fmt::format("network = \"{}/networks/googlenet-32s.toml\"", models)));
  const Safetensors checkpoint(shop.out / "checkpoint.safetensors");
  EXPECT_TRUE(checkpoint.header.contains("score/kernel/first_moment"));
  EXPECT_FALSE(checkpoint.header.contains("score/kernel/second_moment")) << "it is SGD";
}

TEST(Train, stops_early_and_keeps_the_best) {
  const Workshop shop;
  // Nothing is learned, so no validation is better than the first.
  const std::string experiment = shop.experiment(
      few_steps(50, "learning_rate = 0.0\nfreeze_norm_from_step = 0\nvalidate_every = 1\nearly_stop_after = 2"),
      shop.pictures_and_held_out());
  shop.run(experiment);
  EXPECT_EQ(column_of(shop.out / "log.csv", "step"), (std::vector<std::string>{"1", "1", "2", "2", "3", "3"}));
  EXPECT_EQ(Safetensors(shop.out / "checkpoint.safetensors").metadata("step"), "3");
  EXPECT_EQ(Safetensors(shop.out / "checkpoint.safetensors").metadata("best_step"), "1");
  EXPECT_TRUE(bytes_of(shop.out / "model.safetensors") == bytes_of(shop.out / "best.safetensors"));
  EXPECT_EQ(Safetensors(shop.out / "model.safetensors").metadata("step"), "1");
}

TEST(Train, takes_data_from_another_experiment_and_balances_classes) {
  const Workshop shop;
  const std::string own = shop.experiment(few_steps(2), shop.pictures());
  const auto weights_after = [&](const std::string& experiment) {
    fs::remove_all(shop.out);
    shop.run(experiment);
    return bytes_of(shop.out / "model.safetensors");
  };
  const std::string plain = weights_after(own);
  const std::string borrowed = weights_after(
      shop.experiment(few_steps(2), "", fmt::format("data_from = \"{}\"\n", own) + Workshop::start_from_shipped()));
  EXPECT_TRUE(borrowed == plain);
  // One third road, two thirds grass: medians weigh road twice.
  const std::string balanced = weights_after(shop.experiment(few_steps(2, "balance_classes = true"), shop.pictures()));
  EXPECT_FALSE(balanced == plain);
  const std::string by_hand = weights_after(
      shop.experiment(few_steps(2, "class_weights = [1.0, 2.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0]"), shop.pictures()));
  EXPECT_TRUE(balanced == by_hand);
}

TEST(Train, the_command_line_names_other_weights_and_what_is_left_out) {
  const Workshop shop;
  const auto bytes_after = [&](const std::string& experiment, const Arguments& more) {
    fs::remove_all(shop.out);
    shop.run(experiment, more);
    return bytes_of(shop.out / "model.safetensors");
  };
  const std::string random =
      shop.experiment(few_steps(2), shop.pictures(), fmt::format("network = \"{}\"", shipped_network));
  const std::string shipped = bytes_after(shop.experiment(few_steps(2), shop.pictures()), {});
  EXPECT_FALSE(bytes_after(random, {}) == shipped);
  EXPECT_TRUE(bytes_after(random, {"--weights", shipped_weights}) == shipped);
  fs::remove_all(shop.out);
  shop.expect_failure("leave_out names 'pictues'", random, {"--leave-out", "pictues"});
  fs::remove_all(shop.out);  // the folder is made before the data are read
  shop.expect_failure("has nothing to train on", random, {"--leave-out", "pictures"});
  const ToolRun measured =
      run_tool({"-q", "train", random, "--measure", shipped_weights, "--leave-out", "pictures", "--set", "pictures"});
  EXPECT_EQ(measured.exit_code, 0) << measured.err;
  EXPECT_TRUE(nlohmann::json::parse(measured.out).contains("pictures"));
}

TEST(Train, keeps_data_for_the_crf_from_the_network_and_the_crf_from_everything_else) {
  const Workshop shop;
  make_site(shop);
  const std::string for_the_crf = "\n[[raster]]\nname = \"site\"\nfolder = \"site\"\ncrf_only = true\n",
                    crf = "[crf]\nsteps = 1\nbatch = 1\nsearch_crops = 1\niterations = 2\nvalidate_every = -1\n" +
                          small_grid;
  const std::string train = few_steps(3, "validate_every = -1"),
                    with = shop.experiment(train, shop.pictures() + for_the_crf + crf);
  shop.run(shop.experiment(train, shop.pictures()));
  const std::string alone = bytes_of(shop.out / "model.safetensors");
  fs::remove_all(shop.out);
  shop.run(with);
  EXPECT_TRUE(bytes_of(shop.out / "model.safetensors") == alone) << "the network has learned from data of the CRF";

  shop.run(with, {"--crf"});
  const std::string search = bytes_of(shop.out / "crf/search.csv");
  fs::remove_all(shop.out / "crf");
  shop.run(shop.experiment(train, shop.pictures("max_zoom = 4.0\nweight = 50.0") + for_the_crf + crf), {"--crf"});
  EXPECT_EQ(bytes_of(shop.out / "crf/search.csv"), search) << "the CRF has learned from data of the network";
  fs::remove_all(shop.out / "crf");
  shop.run(shop.experiment(train, shop.pictures() + "\n" + crf), {"--crf"});
  EXPECT_NE(bytes_of(shop.out / "crf/search.csv"), search) << "without data of its own it takes the network's";
}

TEST(Train, measures_the_sets_that_are_named) {
  const Workshop shop;
  const std::string experiment =
      shop.experiment(few_steps(1), shop.pictures() + "\n" + shop.pictures("held_out = [\"*\"]") +
                                        "\n[[raster]]\nname = \"other\"\nfolder = \"site\"\nheld_out = true\n");
  make_site(shop);
  const auto measured = [&](Arguments sets) {
    Arguments arguments{"-q", "--threads", "1", "train", experiment, "--measure", shipped_weights};
    arguments.insert(arguments.end(), sets.begin(), sets.end());
    const ToolRun result = run_tool(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return nlohmann::json::parse(result.out);
  };
  const nlohmann::json all = measured({}), one = measured({"--set", "other"});
  ASSERT_TRUE(all.contains("pictures") && all.contains("other"));
  ASSERT_TRUE(one.contains("other"));
  EXPECT_FALSE(one.contains("pictures"));
  EXPECT_EQ(one["other"]["mean_iou"], all["other"]["mean_iou"]);
  const ToolRun wrong = run_tool({"-q", "train", experiment, "--measure", shipped_weights, "--set", "others"});
  EXPECT_EQ(wrong.exit_code, 2);
  EXPECT_THAT(wrong.err, HasSubstr("others"));
}

TEST(TrainBadInput, labels_and_images) {
  const Workshop shop;
  const std::string experiment = shop.experiment(few_steps(1), shop.pictures());
  Raster<std::uint8_t> odd = Workshop::painted_labels();
  odd.at(40, 7, 2) = 1;
  io::write_png(shop.labels / "a.png", odd);
  shop.expect_failure("labels/a.png: colour [0, 255, 1] at pixel (40, 7)", experiment);
  io::write_png(shop.labels / "a.png", Raster<std::uint8_t>(95, 96, 3, 255));
  shop.expect_failure("labels/a.png: has 95 x 96 px, its image 96 x 96", experiment);
  fs::remove(shop.labels / "a.png");
  shop.expect_failure("labels/a.png", experiment);
  io::write_png(shop.labels / "a.png", Workshop::painted_labels());

  truncate_to(shop.images / "a.png", 0.5);
  shop.expect_failure("images/a.png", experiment);
  fs::remove(shop.images / "a.png");
  const std::size_t samples = std::size_t{Workshop::size} * Workshop::size;
  write_bytes(shop.images / "a.pgm", "P5\n96 96\n65535\n" + std::string(2 * samples, '\x21'));
  shop.expect_failure("images/a.pgm: has UInt16 samples, need 8 bit", experiment);
  // One band is grey: the same as three equal ones.
  write_bytes(shop.images / "a.pgm", "P5\n96 96\n255\n" + std::string(samples, '\x60'));
  shop.run(experiment);
  const std::string grey = bytes_of(shop.out / "model.safetensors");
  fs::remove_all(shop.out);
  write_bytes(shop.images / "a.pgm", "P6\n96 96\n255\n" + std::string(3 * samples, '\x60'));
  shop.run(experiment);
  EXPECT_TRUE(bytes_of(shop.out / "model.safetensors") == grey);
}

TEST(TrainBadInput, experiments_and_what_they_name) {
  const Workshop shop;
  const auto data = [&](const std::string& text) { return shop.experiment(few_steps(1), text); };
  const auto with_colour = [&](const std::string& entry) {
    return data("[[images]]\nname = \"p\"\nimages = \"images\"\nlabels = \"labels\"\npalette = [" + entry + "]");
  };
  shop.expect_failure("experiment-1.toml:", with_colour("{color = [511, 0, 0], classes = [\"road\"]}"));
  shop.expect_failure(".toml:14: an entry of 'color' is 5.04e+78: out of range",
                      with_colour("{color = [5.04e78, 0, 0], classes = [\"road\"]}"));
  shop.expect_failure("an entry of 'color' is 2.5: must be a whole number",
                      with_colour("{color = [2.5, 0, 0], classes = [\"road\"]}"));
  shop.expect_failure("class 'rode' is not in the table 'orthodrive-8', which has ground, road",
                      with_colour("{color = [255, 0, 0], classes = [\"rode\"]}"));
  shop.expect_failure("classes 'rode', 'gras' are not in the table 'orthodrive-8', which has ground, road",
                      with_colour("{color = [255, 0, 0], classes = [\"rode\", \"road\", \"gras\"]}"));
  shop.expect_failure("nothing to train on", data(shop.pictures("held_out = [\"*\"]")));
  shop.expect_failure(
      "elsewhere",
      data("[[images]]\nname = \"p\"\nimages = \"elsewhere\"\nlabels = \"l\"\npalette = [{color = [0, 0, 0]}]"));
  shop.expect_failure("nowhere/ortho.tif", data("[[raster]]\nname = \"p\"\nfolder = \"nowhere\""));
  shop.expect_failure("'crop' is not known", shop.experiment(few_steps(1, "crop = 64"), shop.pictures()));
  for (const char* before : {"network = \"no.toml\"", "data_from = \"no.toml\"\n"})
    shop.expect_failure("no.toml",
                        shop.experiment(few_steps(1), shop.pictures(),
                                        before[0] == 'n' ? before : before + Workshop::start_from_shipped()));
  shop.expect_failure("no.safetensors", shop.experiment(few_steps(1), shop.pictures(),
                                                        fmt::format("network = \"{}\"\nweights = [\"no.safetensors\"]",
                                                                    shipped_network)));
  write_bytes(shop.scratch / "vgg19.toml", "trunk = \"vgg19\"\nstride = 8\ndecoder = \"fcn\"\ngsd_m = 0.5\n");
  shop.expect_failure("vgg19.toml: network 'vgg19-8s' is unknown: use",
                      shop.experiment(few_steps(1), shop.pictures(), "network = \"vgg19.toml\""));

  shop.expect_usage_error("multiple of 32 plus 0, such as 128",
                          shop.experiment("steps = 1\nbatch = 1\ncrop_px = 100", shop.pictures()));
  shop.expect_usage_error("label_px", shop.experiment(few_steps(1, "label_px = 80"), shop.pictures()));
  shop.expect_usage_error("2 class weights for 8",
                          shop.experiment(few_steps(1, "class_weights = [1.0, 2.0]"), shop.pictures()));
}

TEST(TrainBadInput, polygons_and_mappings) {
  const Workshop shop;
  make_site(shop);
  const Box2 box = bounds_of(io::raster_info(shop.scratch / "site/ortho.tif").outline_lonlat.outer);
  const double lon = 0.5 * (box.min_x + box.max_x), lat = 0.5 * (box.min_y + box.max_y), e = 1e-4;
  const auto feature = [](const std::string& properties, const std::string& geometry) {
    return fmt::format("{{\"type\": \"Feature\", \"properties\": {{{}}}, \"geometry\": {{{}}}}}", properties, geometry);
  };
  const std::string square = fmt::format(
      "\"type\": \"Polygon\", \"coordinates\": [[[{0}, {1}], [{2}, {1}], [{2}, {3}], [{0}, {3}], [{0}, {1}]]]", lon,
      lat, lon + e, lat + e);
  const std::string point = fmt::format("\"type\": \"Point\", \"coordinates\": [{}, {}]", lon, lat);
  const auto write = [&](const std::vector<std::string>& features) {
    write_bytes(shop.scratch / "hand.geojson",
                fmt::format("{{\"type\": \"FeatureCollection\", \"features\": [{}]}}", fmt::join(features, ",")));
  };
  const std::string hand = "[[polygons]]\nname = \"hand\"\nphoto = \"site/ortho.tif\"\npolygons = \"hand.geojson\"";
  const std::string experiment = shop.experiment(few_steps(1), hand);
  const auto good = feature(R"("piece": "a", "class": "road")", square);
  write({good, feature(R"("piece": "b")", square)});
  shop.expect_failure("hand.geojson: piece 'b': a feature has no 'class'", experiment);
  write({good, feature(R"("piece": "b", "class": "rode")", square)});
  shop.expect_failure("hand.geojson: class 'rode' is not in the table", experiment);
  write({feature(R"("piece": "b", "class": "road")", point)});
  shop.expect_failure("hand.geojson: piece 'b': a feature is no polygon", experiment);
  write({});
  shop.expect_failure("hand.geojson: has no polygons", experiment);
  write({good});
  shop.expect_failure("hand.geojson: has no piece 'z'", shop.experiment(few_steps(1), hand + "\npieces = [\"z\"]"));
  shop.run(experiment);
  fs::remove_all(shop.out);

  const std::string site = "[[raster]]\nname = \"village\"\nfolder = \"site\"\nmapping = ";
  shop.expect_failure("labels.tif: has no class 'rode', which the mapping of 'village' names",
                      shop.experiment(few_steps(1), site + "{rode = [\"road\"]}"));
  shop.expect_failure("mapping of 'village': class 'rode' is not in the table",
                      shop.experiment(few_steps(1), site + "{road = [\"rode\"]}"));
}

TEST(TrainBadInput, a_folder_in_which_another_training_works) {
  const Workshop shop;
  const std::string experiment = shop.experiment(few_steps(2), shop.pictures());
  shop.run(experiment);
  const auto before = snapshot(shop.out);
  const fs::path lock = shop.out / ".orthodrive" / "lock";
  fs::create_directories(lock.parent_path());
  const int other = open(lock.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  ASSERT_EQ(flock(other, LOCK_EX), 0);
  shop.expect_failure("another process works in this folder", shop.experiment(few_steps(4), shop.pictures()),
                      {"--resume"});
  close(other);
  fs::remove(lock);
  EXPECT_EQ(snapshot(shop.out), before);
}

TEST(TrainBadInput, checkpoints_that_are_damaged_or_of_another_network_stay_as_they_are) {
  const Workshop shop;
  const std::string experiment = shop.experiment(few_steps(2), shop.pictures());
  shop.run(experiment);
  const fs::path file = shop.out / "checkpoint.safetensors";
  const std::string good = bytes_of(file);
  const auto expect_refused = [&](const std::string& what, const std::string& bytes) {
    write_bytes(file, bytes);
    shop.expect_failure("checkpoint.safetensors: " + what, shop.experiment(few_steps(4), shop.pictures()),
                        {"--resume"});
  };
  expect_refused("not a complete safetensors file", good.substr(0, good.size() / 2));
  expect_refused("not a safetensors file", "garbage, and more of it");
  expect_refused("not a safetensors file", "");
  expect_refused("tensor 'Conv1/kernel/first_moment' is missing", bytes_of(shop.out / "model.safetensors"));
  write_bytes(file, good);
  shop.expect_failure("checkpoint.safetensors: is of mobilenetv2-s32-fpn2, which the experiment does not train",
                      shop.experiment("steps = 1\nbatch = 1\ncrop_px = 130", shop.pictures(),
                                      fmt::format("network = \"{}/networks/googlenet-32s.toml\"", models)),
                      {"--resume"});
  shop.run(shop.experiment(few_steps(3), shop.pictures()), {"--resume"});
  EXPECT_EQ(Safetensors(file).metadata("step"), "3");
}

TEST(TrainBadInput, class_tables_that_do_not_fit_the_weights) {
  const Workshop shop;
  const auto table = [&](const std::string& name, const std::vector<std::string>& classes) {
    std::string text = "name = \"" + name + "\"\n";
    for (const std::string& c : classes)
      text +=
          fmt::format("[[class]]\nname = \"{}\"\ncolor = [1, 2, 3]\nrole = \"{}\"\n", c, c == "road" ? c : "ground");
    write_bytes(shop.scratch / (name + "-classes.toml"), text);
    const std::string network = shop.scratch / (name + ".toml");
    write_bytes(network, "trunk = \"mobilenetv2\"\nstride = 16\ndecoder = \"fpn2\"\ngsd_m = 0.5\nclasses = \"" + name +
                             "-classes.toml\"\n");
    return shop.experiment(few_steps(1), shop.pictures(),
                           fmt::format("network = \"{}\"\nweights = [\"{}\"]", network, shipped_weights));
  };
  // Weights of another table are a start: all but the scores.
  const std::string two = table("two", {"road", "grass"});
  shop.run(two);
  EXPECT_THAT(bytes_of(shop.out / "weights_mobilenetv2-s16-fpn2.txt"), HasSubstr("another class table"));
  EXPECT_THAT(Safetensors(shop.out / "model.safetensors").metadata("classes"), HasSubstr("grass"));
  // A checkpoint of another table is not.
  const std::string other = table("other", {"grass", "road"}), three = table("three", {"road", "grass", "water"});
  shop.expect_failure("checkpoint.safetensors: is a checkpoint for the classes of 'two'", other, {"--resume"});
  shop.expect_failure("checkpoint.safetensors: is a checkpoint for the classes of 'two'", three, {"--resume"});
  shop.expect_failure("model.safetensors: has the class table 'two'", three, {"--crf"});
  expect_clean_failure(shop.scratch.folder(), "default.safetensors: has the class table 'orthodrive-8'", [&] {
    return run_tool({"-q", "train", two, "--measure", "default"});
  });
}

TEST(TrainBadInput, numbers_that_are_none_never_replace_a_checkpoint) {
  const Workshop shop;
  // A weight that is NaN: F16 and F32 have it at all ones.
  Safetensors weights(shipped_weights);
  const auto [begin, size] = weights.place("Conv1/kernel");
  ASSERT_GE(size, 4u);
  weights.bytes.replace(begin, 4, "\xff\xff\xff\xff");
  write_bytes(shop.scratch / "nan.safetensors", weights.bytes);
  shop.expect_failure(
      "nan.safetensors: tensor 'Conv1/kernel' holds values that are no numbers",
      shop.experiment(few_steps(1), shop.pictures(),
                      fmt::format("network = \"{}\"\nweights = [\"nan.safetensors\"]", shipped_network)));

  const std::string good = shop.experiment(few_steps(2), shop.pictures_and_held_out());
  shop.run(good);
  const auto before = snapshot(shop.out);
  // The first step of such a rate leaves weights of 1e30, the second would find a loss that is no number: either way
  // what was good stays.
  for (const char* validate : {"validate_every = 1", "validate_every = 0"}) {
    SCOPED_TRACE(validate);
    const ToolRun diverged = run_tool(shop.command(
        shop.experiment(few_steps(6, fmt::format("learning_rate = 1e30\n{}", validate)), shop.pictures_and_held_out()),
        {"--resume"}));
    EXPECT_EQ(diverged.exit_code, 1);
    EXPECT_THAT(diverged.err, HasSubstr("training diverged"));
    EXPECT_THAT(diverged.err, HasSubstr("learning rate"));
    EXPECT_EQ(std::count(diverged.err.begin(), diverged.err.end(), '\n'), 1) << diverged.err;
    const auto after = snapshot(shop.out);
    for (const char* file : {"checkpoint", "model", "best"}) {
      const std::string path = shop.out / (std::string(file) + ".safetensors");
      EXPECT_TRUE(after.at(path) == before.at(path)) << file;
    }
  }
  shop.run(shop.experiment(few_steps(3), shop.pictures_and_held_out()), {"--resume"});
  EXPECT_EQ(Safetensors(shop.out / "checkpoint.safetensors").metadata("step"), "3");
}

}  // namespace
}  // namespace orthodrive
