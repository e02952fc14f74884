#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "commands.hpp"
#include "orthodrive/core/aside_file.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/io/raster_io.hpp"
#include "orthodrive/io/weights_io.hpp"
#include "orthodrive/segment/caffe_model.hpp"
#include "orthodrive/segment/packed_scenes.hpp"
#include "orthodrive/segment/safetensors_stream.hpp"
#include "training_data.hpp"
#include "training_run.hpp"

namespace orthodrive::app {
namespace {
namespace fs = std::filesystem;

struct TrainCommand {
  fs::path experiment, out;
  fs::path pack;        ///< write the data set instead of training
  std::string measure;  ///< a model to measure instead of training one
  std::vector<std::string> sets;  ///< held-out data to measure on; none: all
  bool resume = false, preview = false, crf = false, cuda = false;
};

void write_previews(const TrainingData& data, const ClassTable& classes, const fs::path& folder) {
  for (const TrainingScene& scene : data.scenes) {
    io::write_png(folder / (scene.name + ".png"), label_preview(scene.rgb, scene.allowed, classes));
  }
  for (const ValidationScene& scene : data.validation) {
    io::write_png(folder / (scene.name + "_held_out.png"), label_preview(scene.photo.rgb, scene.allowed, classes));
  }
}

/// What an experiment trains: its network with its class table.
struct Network {
  NetworkSpec spec;
  ClassTable classes;
};

Network read_network(const fs::path& file) {
  Network network{parse_network_spec(io::read_file(file), file), default_class_table()};
  const fs::path& table = network.spec.class_table_file;
  if (!table.empty()) network.classes = parse_class_table(io::read_file(table), table);
  return network;
}

void add_data(Experiment& experiment, const Experiment& other) {
  const auto append = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
  append(experiment.maps, other.maps);
  append(experiment.images, other.images);
  append(experiment.rasters, other.rasters);
  append(experiment.polygons, other.polygons);
}

/// Scores of a model on the held-out data and what they took, as one JSON object on standard output.
void measure(const TrainCommand& command, const std::vector<ValidationScene>& scenes, const ClassTable& classes,
             int threads) {
  const fs::path file = io::find_model(command.measure);
  SegmentModel model = load_model(io::read_file(file), file.string());
  if (model.classes.classes.size() != classes.classes.size())
    throw InputError(file.string(),
                     fmt::format("has the class table '{}', the experiment '{}'", model.classes.name, classes.name));
  if (!command.crf) model.crf.reset();
  if (command.crf && !model.crf) model.crf = reference_crf(static_cast<int>(classes.classes.size()));
  const auto rounded = [](double value) { return std::round(value * 1e4) / 1e4; };  // NaN becomes null
  std::map<std::string, std::vector<ValidationScene>> sets;
  for (const ValidationScene& scene : scenes) {
    if (command.sets.empty() || std::ranges::find(command.sets, scene.name) != command.sets.end())
      sets[scene.name].push_back(scene);
  }
  for (const std::string& name : command.sets)
    if (!sets.contains(name)) throw OptionError(fmt::format("--set {}: the experiment holds out no such data", name));
  nlohmann::ordered_json json;
  for (const auto& [name, set] : sets) {
    double megapixels = 0.0;
    for (const ValidationScene& scene : set) megapixels += 1e-6 * static_cast<double>(scene.allowed.data.size());
    const auto start = std::chrono::steady_clock::now();
    const LabelScore score = measure_model(model, set, threads).begin()->second;
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    nlohmann::ordered_json& entry = json[name];
    entry = {{"road_iou", rounded(score.iou(road_label(model.classes)))},
             {"mean_iou", rounded(score.mean_iou())},
             {"pixel_accuracy", rounded(score.pixel_accuracy())},
             {"megapixels", rounded(megapixels)},
             {"seconds", rounded(seconds)}};
    for (std::size_t c = 0; c < model.classes.classes.size(); ++c) {
      entry["iou"][model.classes.classes[c].name] = rounded(score.iou(static_cast<int>(c)));
    }
  }
  fmt::print("{}\n", json.dump(2));
}

bool is_caffe_model(const fs::path& file) { return file.extension() == ".caffemodel"; }

WeightsSource read_weights(const fs::path& file) {
  if (!is_caffe_model(file)) return {file.filename().string(), read_safetensors(file)};
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw InputError(file.string(), "cannot be opened: does it exist?");
  return {file.filename().string(), read_caffe_model(stream, file.string())};
}

/// The data set and all that training needs to know, for `orthodrive-train` (train_packed.cpp), which has neither GDAL
/// nor protobuf: Caffe models become safetensors beside the pack.
void pack(const TrainCommand& command, const Experiment& experiment, const std::string& experiment_text,
          const Network& network, TrainingData data, Monitor* monitor) {
  PackedScenes packed{std::move(data.scenes), std::move(data.validation),
                      format_model_metadata({network.spec.architecture(), network.classes, network.spec.gsd_m, network.spec.finest_gsd_m})};
  packed.metadata["experiment"] = experiment_text;
  packed.metadata["network"] = io::read_file(experiment.network);
  AsideFile aside(command.pack);
  std::ofstream stream(aside.path(), std::ios::binary);
  write_packed_scenes(stream, packed);
  stream.close();
  if (!stream) throw Error(fmt::format("{}: cannot be written, is the disk full?", command.pack.string()));
  aside.commit();
  for (const fs::path& file : experiment.weights) {
    fs::path portable = file;
    if (is_caffe_model(file)) {
      portable = command.pack;
      portable.replace_filename(fmt::format("{}_{}.safetensors", command.pack.stem().string(), file.stem().string()));
      write_text_file(portable, format_safetensors(read_weights(file).file));
    }
    if (monitor) monitor->info(fmt::format("carry along: {}  (--weights)", portable.string()));
  }
}

void run(const TrainCommand& command, const Context& context) {
  const std::string text = io::read_file(command.experiment);
  Experiment experiment = parse_experiment(text, command.experiment);
  if (!experiment.data_from.empty())
    add_data(experiment, parse_experiment(io::read_file(experiment.data_from), experiment.data_from));
  const Network network = read_network(experiment.network);
  experiment.train.threads = context.threads;
  experiment.train.cuda = command.cuda;
  if (!command.measure.empty()) {
    return measure(
        command,
        read_held_out_data(experiment, network.spec.gsd_m, network.classes, context.threads, context.monitor),
        network.classes, context.threads);
  }
  if (command.out.empty() && command.pack.empty()) throw OptionError("-o is missing: the folder to train into");
  if (!command.out.empty()) prepare_training_folder(command.out, command.resume || command.preview, command.crf);
  TrainingData data =
      read_training_data(experiment, network.spec.gsd_m, network.classes, context.threads, context.monitor);
  if (std::ranges::none_of(data.scenes, [](const TrainingScene& s) { return s.weight > 0.0 && s.from_step <= 0 && !s.crf_only; })) {
    throw InputError(command.experiment.string(),
                     "has nothing to train on at step 0: add [[map]], [[images]], [[raster]] or [[polygons]] that is "
                     "not held out, with a weight above 0 and from_step 0");
  }
  if (command.preview) return write_previews(data, network.classes, command.out);
  if (!command.pack.empty()) return pack(command, experiment, text, network, std::move(data), context.monitor);
  run_training({.out = command.out,
                .experiment_text = text,
                .experiment = experiment,
                .network = network.spec,
                .classes = network.classes,
                .scenes = std::move(data.scenes),
                .validation = std::move(data.validation),
                .read_weights =
                    [&experiment] {
                      std::vector<WeightsSource> sources;
                      for (const fs::path& file : experiment.weights) sources.push_back(read_weights(file));
                      return sources;
                    },
                .resume = command.resume,
                .crf = command.crf},
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
  cmd->add_flag(
      "--crf", command->crf,
      "on top of the network trained in the folder: search a CRF's widths and weights, then learn both end to end");
  cmd->add_flag("--cuda", command->cuda, "train on the GPU, where libtorch has one");
  cmd->add_option("--measure", command->measure,
                  "instead of training, print the scores of this model on the held-out data as JSON");
  cmd->add_option("--set", command->sets, "of --measure: only these of the held-out data");
  cmd->add_option(
      "--pack", command->pack,
      "instead of training, write the data set into this safetensors file, to train on a machine with nothing "
      "but libtorch (orthodrive-train, built by tools/trainer)");
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
