#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "commands.hpp"
#include "orthodrive/core/aside_file.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/io/raster_io.hpp"
#include "orthodrive/io/weights_io.hpp"
#include "orthodrive/segment/caffe_model.hpp"
#include "orthodrive/segment/make_network.hpp"
#include "orthodrive/segment/net_surgery.hpp"
#include "orthodrive/segment/packed_scenes.hpp"
#include "orthodrive/segment/safetensors_stream.hpp"
#include "orthodrive/segment/training_report.hpp"
#include "training_data.hpp"

namespace orthodrive::app {
namespace {
namespace fs = std::filesystem;

struct TrainCommand {
  fs::path experiment, out;
  fs::path pack;        ///< write the data set instead of training
  std::string measure;  ///< a model to measure instead of training one
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

/// log.csv, a row as it happens: the file of a killed run is complete up to there. And its curves as a page.
class TrainingLog {
 public:
  /// Goes on with the log that is there, up to the step that is resumed from; -1: begins a new one.
  TrainingLog(const fs::path& folder, std::int64_t resumed_step) : page_(folder / "training.html"), folder_(folder) {
    const fs::path file = folder / "log.csv";
    if (resumed_step >= 0 && fs::exists(file)) rows_ = parse_training_log(io::read_file(file), file.string());
    std::erase_if(rows_, [&](const TrainReport& row) { return row.step > resumed_step; });
    std::string text = format_log_header();
    for (const TrainReport& row : rows_) text += format_log_row(row);
    seconds_before_ = rows_.empty() ? 0.0 : rows_.back().seconds;
    write_text_file(file, text);
    stream_.open(file, std::ios::app);
  }
  void write(TrainReport row) {
    row.seconds += seconds_before_;
    rows_.push_back(row);
    stream_ << format_log_row(row) << std::flush;
    if (row.validation == "mean") write_page();
  }
  void write_page() const {
    write_text_file(page_, format_training_report(rows_, {.title = "Training " + folder_.filename().string()}));
  }

 private:
  fs::path page_, folder_;
  std::vector<TrainReport> rows_;
  std::ofstream stream_;
  double seconds_before_ = 0.0;
};

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
  for (const ValidationScene& scene : scenes) sets[scene.name].push_back(scene);
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

WeightsSource read_weights(const fs::path& file) {
  if (file.extension() != ".caffemodel") return {file.filename().string(), read_safetensors(file)};
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw InputError(file.string(), "cannot be opened: does it exist?");
  return {file.filename().string(), read_caffe_model(stream, file.string())};
}

/// The trainings of an experiment, in order: a network and its options each.
struct Stage {
  std::string architecture;
  TrainOptions options;
};

std::vector<Stage> stages_of(const Experiment& experiment, const NetworkSpec& network) {
  if (experiment.stages.empty()) return {{network.architecture(), experiment.train}};
  std::vector<Stage> stages;
  for (const StageOptions& stage : experiment.stages) {
    NetworkSpec spec = network;
    spec.stride = stage.stride;
    TrainOptions options = experiment.train;
    options.decay_from_step = options.decay_from_step * stage.steps / options.steps;  // the same share of the stage
    options.steps = stage.steps;
    stages.push_back({spec.architecture(), options});
  }
  return stages;
}

/// `steps_before`: of the stages before, so that steps of the log go on.
TrainHooks hooks_for(const fs::path& out, TrainingLog& log, std::int64_t steps_before) {
  return {.report =
              [&log, steps_before](TrainReport report) {
                report.step += steps_before;
                log.write(report);
              },
          .checkpoint =
              [out](const Trainer& state) {
                write_text_file(out / "checkpoint.safetensors", format_safetensors(state.checkpoint()));
                write_text_file(out / "model.safetensors", format_safetensors(state.model_file()));
              },
          .best =
              [out](const Trainer& state) {
                write_text_file(out / "best.safetensors", format_safetensors(state.model_file()));
              }};
}

void train(const TrainCommand& command, const Experiment& experiment, const std::string& text, const Network& network,
           const TrainingData& data, const Context& context) {
  const fs::path checkpoint_file = command.out / "checkpoint.safetensors",
                 model_file = command.out / "model.safetensors", best_file = command.out / "best.safetensors";
  const std::vector<Stage> stages = stages_of(experiment, network.spec);
  const int classes = static_cast<int>(network.classes.classes.size());
  for (const Stage& stage : stages) static_cast<void>(make_network(stage.architecture, classes));  // now, not in hours
  std::size_t index = 0;
  std::optional<TensorFile> checkpoint;
  if (fs::exists(checkpoint_file)) {
    checkpoint = read_safetensors(checkpoint_file);
    const std::string architecture = parse_model_metadata(checkpoint->metadata, checkpoint_file.string()).architecture;
    while (index < stages.size() && stages[index].architecture != architecture) ++index;
    if (index == stages.size()) {
      throw InputError(
          checkpoint_file.string(),
          fmt::format("is of {}, which the experiment does not train: choose another folder", architecture));
    }
  }
  std::vector<WeightsSource> sources;
  if (!checkpoint)
    for (const fs::path& file : experiment.weights) sources.push_back(read_weights(file));
  std::int64_t steps_before = 0;
  for (std::size_t i = 0; i < index; ++i) steps_before += stages[i].options.steps;
  std::optional<TrainingLog> log;  // begun when everything fits: a run that is refused changes nothing
  for (; index < stages.size(); ++index) {
    const Stage& stage = stages[index];
    const ModelMetadata metadata{stage.architecture, network.classes, network.spec.gsd_m};
    const NetworkGraph graph = make_network(stage.architecture, classes);
    StartWeights start = start_weights(graph, sources, stage.options.seed);
    Trainer trainer(start.file, "starting weights", metadata, stage.options);
    if (checkpoint) trainer.restore(*checkpoint, checkpoint_file.string());
    if (!log) {
      remove_stale_asides(command.out);
      write_text_file(command.out / "experiment.toml", text);
      log.emplace(command.out, checkpoint ? steps_before + trainer.step() : -1);
    }
    if (!checkpoint)
      write_text_file(command.out / fmt::format("weights_{}.txt", stage.architecture), format_report(start.report));
    start = {};
    sources.clear();
    checkpoint.reset();
    train_network(trainer, stage.options, data.scenes, data.validation, hooks_for(command.out, *log, steps_before),
                  context.monitor);
    steps_before += stage.options.steps;  // also after an early stop: as a resumed run counts
    if (stage.options.early_stop_after > 0 && fs::exists(best_file))
      write_text_file(model_file, io::read_file(best_file));
    if (index + 1 < stages.size()) sources = {{stage.architecture, trainer.weights()}};
  }
  log->write_page();  // also where nothing was validated
}

std::string search_table(const CrfSearch& search) {
  std::string text = "theta_alpha_px,theta_beta,w1,theta_gamma_px,w2,pixel_accuracy,mean_iou\n";
  for (const CrfTrial& t : search.trials) {
    text +=
        fmt::format("{},{},{},{},{},{:.4f},{:.4f}\n", t.widths.theta_alpha_px, t.widths.theta_beta, t.appearance_weight,
                    t.widths.theta_gamma_px, t.smoothness_weight, t.pixel_accuracy, t.mean_iou);
  }
  return text;
}

TrainOptions crf_train_options(const Experiment& experiment) {
  const CrfExperiment& crf = experiment.crf;
  TrainOptions options = experiment.train;
  options.solver = Solver::adamw;
  options.sum_loss = false;
  options.learning_rate = crf.network_learning_rate;
  options.steps = crf.steps;
  options.warmup_steps = std::min<std::int64_t>(10, crf.steps);
  options.decay_from_step = crf.steps / 2;
  options.freeze_norm_from_step = 0;
  options.batch = crf.batch;
  options.validate_every = crf.validate_every;
  if (crf.label_px > 0) options.label_px = crf.label_px;
  return options;
}

/// On top of the network trained in the folder: searches the CRF's widths and weights, then learns all of it. Writes
/// into the sub-folder crf.
void train_crf(const TrainCommand& command, const Experiment& experiment, const std::string& text,
               const Network& network, const TrainingData& data, const Context& context) {
  const fs::path start_file = command.out / "model.safetensors", out = command.out / "crf",
                 checkpoint_file = out / "checkpoint.safetensors";
  if (!fs::exists(start_file)) {
    throw OptionError(
        fmt::format("{} is missing: train the network first, the same command without --crf", start_file.string()));
  }
  const TensorFile start = read_safetensors(start_file);
  const ModelMetadata metadata = parse_model_metadata(start.metadata, start_file.string());
  const int classes = static_cast<int>(network.classes.classes.size());
  if (metadata.classes.classes.size() != network.classes.classes.size()) {
    throw InputError(start_file.string(), fmt::format("has the class table '{}', the experiment '{}'",
                                                      metadata.classes.name, network.classes.name));
  }
  const CrfExperiment& crf = experiment.crf;
  TrainOptions options = crf_train_options(experiment);
  fs::create_directories(out);
  std::optional<TensorFile> checkpoint;
  if (fs::exists(checkpoint_file)) {
    if (!command.resume) throw OptionError(fmt::format("{} holds a training run: go on with --resume", out.string()));
    checkpoint = read_safetensors(checkpoint_file);
    const std::optional<CrfModel> begun = read_crf(*checkpoint, classes, checkpoint_file.string());
    if (!begun) throw InputError(checkpoint_file.string(), "holds no CRF: choose another folder");
    options.crf = CrfTraining{*begun, crf.learning_rate, crf.shrinkage};
  } else {
    const Trainer predictor(start, start_file.string(), metadata, options);
    if (context.monitor) context.monitor->info("searching the widths and weights of the CRF");
    const CrfSearch search = search_crf(predictor.crf_samples(data.scenes, crf.search_crops), classes,
                                        {.iterations = crf.iterations, .threads = context.threads});
    write_text_file(out / "search.csv", search_table(search));
    CrfModel best = search.best;
    for (std::vector<float>* weights : {&best.parameters.appearance_weight, &best.parameters.smoothness_weight})
      for (float& w : *weights) w = std::max(w, 0.05F);  // a weight of zero has no logarithm to learn
    TensorFile untrained = start;
    add_crf(untrained, search.best);
    write_text_file(out / "searched.safetensors", format_safetensors(untrained));
    options.crf = CrfTraining{best, crf.learning_rate, crf.shrinkage};
  }
  Trainer trainer(start, start_file.string(), metadata, options);
  if (checkpoint) trainer.restore(*checkpoint, checkpoint_file.string());
  remove_stale_asides(out);
  write_text_file(command.out / "experiment.toml", text);
  TrainingLog log(out, checkpoint ? trainer.step() : -1);
  train_network(trainer, options, data.scenes, data.validation, hooks_for(out, log, 0), context.monitor);
  log.write_page();
}

/// The data set and all that training needs to know, for the program that needs nothing but libtorch.
void pack(const TrainCommand& command, TrainingData data, const ClassTable& classes, const std::string& experiment) {
  PackedScenes packed{std::move(data.scenes),
                      std::move(data.validation),
                      {{"experiment", experiment}, {"classes", io::class_table_to_json(classes)}}};
  AsideFile aside(command.pack);
  std::ofstream stream(aside.path(), std::ios::binary);
  write_packed_scenes(stream, packed);
  stream.close();
  aside.commit();
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
        command, read_held_out_data(experiment, network.spec.gsd_m, network.classes, context.threads, context.monitor),
        network.classes, context.threads);
  }
  if (command.out.empty() && command.pack.empty()) throw OptionError("-o is missing: the folder to train into");
  if (fs::exists(command.out / "checkpoint.safetensors") && !command.resume && !command.preview && !command.crf) {
    throw OptionError(
        fmt::format("{} holds a training run: go on with --resume or choose another folder", command.out.string()));
  }
  if (!command.out.empty()) fs::create_directories(command.out);
  TrainingData data =
      read_training_data(experiment, network.spec.gsd_m, network.classes, context.threads, context.monitor);
  if (std::ranges::none_of(data.scenes, [](const TrainingScene& s) { return s.weight > 0.0 && s.from_step <= 0; })) {
    throw InputError(command.experiment.string(),
                     "has nothing to train on at step 0: add [[map]], [[images]], [[raster]] or [[polygons]] that is "
                     "not held out, with a weight above 0 and from_step 0");
  }
  if (command.preview) return write_previews(data, network.classes, command.out);
  if (!command.pack.empty()) return pack(command, data, network.classes, text);
  if (experiment.train.balance_classes)
    experiment.train.class_weights = balanced_class_weights(data.scenes, network.classes.classes.size());
  if (command.crf) return train_crf(command, experiment, text, network, data, context);
  train(command, experiment, text, network, data, context);
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
  cmd->add_option(
      "--pack", command->pack,
      "instead of training, write the data set into this safetensors file, to train on a machine with nothing "
      "but libtorch (tools/trainer)");
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
