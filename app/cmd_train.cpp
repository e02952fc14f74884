#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "orthodrive/core/aside_file.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/io/raster_io.hpp"
#include "orthodrive/io/weights_io.hpp"
#include "training_data.hpp"

namespace orthodrive::app {
namespace {
namespace fs = std::filesystem;

struct TrainCommand {
  fs::path experiment, out;
  std::string measure;  ///< a model to measure instead of training one
  bool resume = false, preview = false;
};

void write_previews(const TrainingData& data, const ClassTable& classes, const fs::path& folder) {
  for (const TrainingScene& scene : data.scenes) {
    io::write_png(folder / (scene.name + ".png"), label_preview(scene.rgb, scene.allowed, classes));
  }
  for (const ValidationScene& scene : data.validation) {
    io::write_png(folder / (scene.name + "_held_out.png"), label_preview(scene.photo.rgb, scene.allowed, classes));
  }
}

/// log.csv, a row as it happens: the file of a killed run is complete up to there.
class LogFile {
 public:
  LogFile(const fs::path& path, bool append) : stream_(path, append ? std::ios::app : std::ios::trunc) {
    if (!append) stream_ << "step,learning_rate,loss,seconds,validation,road_iou,mean_iou,pixel_accuracy\n";
  }
  void write(const TrainReport& report) {
    const auto number = [](const std::optional<double>& value) {
      return value ? fmt::format("{:.4f}", *value) : std::string();
    };
    stream_ << fmt::format("{},{:.6f},{},{:.1f},{},{},{},{}\n", report.step, report.learning_rate,
                           report.validation.empty() ? fmt::format("{:.4f}", report.loss) : "", report.seconds,
                           report.validation, number(report.road_iou), number(report.mean_iou),
                           number(report.pixel_accuracy))
            << std::flush;
  }

 private:
  std::ofstream stream_;
};

/// Scores of a model on the held-out data, as one JSON object on standard output.
void measure(const std::string& name, const std::vector<ValidationScene>& scenes, int threads) {
  const fs::path file = io::find_model(name);
  const SegmentModel model = load_model(io::read_file(file), file.string());
  const auto rounded = [](double value) { return std::round(value * 1e4) / 1e4; };  // NaN becomes null
  nlohmann::ordered_json json;
  for (const auto& [scene, score] : measure_model(model, scenes, threads)) {
    nlohmann::ordered_json& entry = json[scene];
    entry = {{"road_iou", rounded(score.iou(road_label(model.classes)))},
             {"mean_iou", rounded(score.mean_iou())},
             {"pixel_accuracy", rounded(score.pixel_accuracy())}};
    for (std::size_t c = 0; c < model.classes.classes.size(); ++c) {
      entry["iou"][model.classes.classes[c].name] = rounded(score.iou(static_cast<int>(c)));
    }
  }
  fmt::print("{}\n", json.dump(2));
}

void run(const TrainCommand& command, const Context& context) {
  const std::string text = io::read_file(command.experiment);
  Experiment experiment = parse_experiment(text, command.experiment);
  experiment.train.threads = context.threads;
  const ClassTable& classes = default_class_table();
  if (!command.measure.empty()) {
    return measure(command.measure, read_held_out_data(experiment, classes, context.threads, context.monitor),
                   context.threads);
  }
  if (command.out.empty()) throw OptionError("-o is missing: the folder to train into");
  const fs::path checkpoint = command.out / "checkpoint.safetensors";
  const bool exists = fs::exists(checkpoint);
  if (exists && !command.resume && !command.preview) {
    throw OptionError(
        fmt::format("{} holds a training run: go on with --resume or choose another folder", command.out.string()));
  }
  fs::create_directories(command.out);
  const TrainingData data = read_training_data(experiment, classes, context.threads, context.monitor);
  if (command.preview) return write_previews(data, classes, command.out);

  Trainer trainer(parse_safetensors(io::read_file(experiment.trunk), experiment.trunk.string()),
                  experiment.trunk.string(), {.classes = classes, .gsd_m = experiment.gsd_m}, experiment.train);
  if (exists) trainer.restore(parse_safetensors(io::read_file(checkpoint), checkpoint.string()), checkpoint.string());
  write_text_file(command.out / "experiment.toml", text);
  LogFile log(command.out / "log.csv", exists);
  train_network(trainer, experiment.train, data.scenes, data.validation,
                {.report = [&](const TrainReport& report) { log.write(report); },
                 .checkpoint =
                     [&](const Trainer& state) {
                       write_text_file(checkpoint, format_safetensors(state.checkpoint()));
                       write_text_file(command.out / "model.safetensors", format_safetensors(state.model_file()));
                     }},
                context.monitor);
}

}  // namespace

void add_train(CLI::App& app, Context& context) {
  auto command = std::make_shared<TrainCommand>();
  CLI::App* cmd = app.add_subcommand("train", "Trains a segmentation network on photos, maps and synthetic sites.");
  cmd->add_option("experiment", command->experiment, "what to train on and how (TOML, see docs/segmentation.md)")
      ->required();
  cmd->add_option("-o,--output", command->out, "folder for model.safetensors, checkpoint.safetensors, log.csv");
  cmd->add_flag("--resume", command->resume, "go on from the checkpoint in the folder");
  cmd->add_option("--measure", command->measure,
                  "instead of training, print the scores of this model on the held-out data as JSON");
  cmd->add_flag("--preview", command->preview,
                "only write pictures of the labels into the folder, to look at them before training");
  cmd->footer(
      "Reads the experiment and the data it names; writes into the output folder.\n"
      "The outcome repeats for the same number of threads. Needs about 4 GB; the shipped model took an hour on two "
      "cores.\n"
      "Examples:\n"
      "  orthodrive train models/default.toml -o out/train --preview\n"
      "  orthodrive train models/default.toml -o out/train --resume\n"
      "  orthodrive train models/default.toml --measure default");
  cmd->callback([command, &context] { run(*command, context); });
}

}  // namespace orthodrive::app
