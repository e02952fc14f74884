// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/lab/training/training_run.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <optional>

#include "orthodrive/core/atomic_file.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/io/models/safetensors_stream.hpp"
#include "orthodrive/lab/training/training_report.hpp"
#include "orthodrive/nets/make_network.hpp"

namespace orthodrive {
namespace {
namespace fs = std::filesystem;

std::string read_bytes(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(stream), {}};
  if (!stream) throw InputError(file.string(), "cannot be read");
  return bytes;
}

/// log.csv, a row as it happens: the file of a killed run is complete up to there. And its curves as a page.
class TrainingLog {
 public:
  /// Goes on with the log that is there, up to the step that is resumed from; -1: begins a new one.
  TrainingLog(const fs::path& folder, std::int64_t resumed_step) : page_(folder / "training.html"), folder_(folder) {
    const fs::path file = folder / "log.csv";
    if (resumed_step >= 0 && fs::exists(file)) rows_ = parse_training_log(read_bytes(file), file.string());
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

/// The trainings of an experiment, in order: a network and its options each.
struct Stage {
  std::string architecture;
  TrainOptions options;
};

std::vector<Stage> training_stages(const Experiment& experiment, const NetworkSpec& network) {
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

std::optional<CrfModel> first_crf(const std::vector<WeightsSource>& sources, int classes) {
  for (const WeightsSource& source : sources)
    if (std::optional<CrfModel> crf = read_crf(source.file, classes, source.name)) return crf;
  return {};
}

bool is_random(const SurgeryEntry& entry) { return entry.outcome == SurgeryEntry::Outcome::random; }

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

void train(const TrainingRun& run, Monitor* monitor) {
  const fs::path checkpoint_file = run.out / "checkpoint.safetensors", model_file = run.out / "model.safetensors",
                 best_file = run.out / "best.safetensors";
  std::vector<Stage> stages = training_stages(run.experiment, run.network);
  const int classes = static_cast<int>(run.classes.classes.size());
  for (Stage& stage : stages)
    if (stage.options.map_only) stage.options.kept_crf = first_crf(run.read_weights(), classes);
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
  if (!checkpoint) sources = run.read_weights();
  std::int64_t steps_before = 0;
  for (std::size_t i = 0; i < index; ++i) steps_before += stages[i].options.steps;
  std::optional<TrainingLog> log;  // begun when everything fits: a run that is refused changes nothing
  for (; index < stages.size(); ++index) {
    const Stage& stage = stages[index];
    const ModelMetadata metadata{stage.architecture, run.classes, run.network.gsd_m, run.network.finest_gsd_m};
    const NetworkGraph graph = make_network(stage.architecture, classes);
    StartWeights start = start_weights(graph, sources, stage.options.seed);
    Trainer trainer(start.file, "starting weights", metadata, stage.options);
    if (checkpoint) trainer.restore(*checkpoint, checkpoint_file.string());
    if (!log) {
      remove_stale_atomic_files(run.out);
      write_text_file(run.out / "experiment.toml", run.experiment_text);
      log.emplace(run.out, checkpoint ? steps_before + trainer.step() : -1);
    }
    if (!checkpoint) {
      write_text_file(run.out / fmt::format("weights_{}.txt", stage.architecture), format_report(start.report));
      if (std::ranges::any_of(start.report.layers, is_random)) trainer.scale_start(run.scenes);
    }
    start = {};
    sources.clear();
    checkpoint.reset();
    train_network(trainer, stage.options, run.scenes, run.validation, hooks_for(run.out, *log, steps_before), monitor);
    steps_before += stage.options.steps;  // also after an early stop: as a resumed run counts
    if (stage.options.early_stop_after > 0 && fs::exists(best_file)) write_text_file(model_file, read_bytes(best_file));
    if (stages.size() == 1) continue;
    // As in the thesis (table 2.1), the best snapshot of a stage is its network, and what the next one starts from.
    const bool validated = trainer.best.step >= 0;
    write_text_file(run.out / (stage.architecture + ".safetensors"),
                    validated ? read_bytes(best_file) : format_safetensors(trainer.model_file()));
    sources = {{stage.architecture, validated ? read_safetensors(best_file) : trainer.weights()}};
  }
  if (log) log->write_page();  // also where nothing was validated
}

std::string search_table(const CrfSearch& search) {
  std::string text =
      "theta_alpha_px,theta_beta,w1,theta_gamma_px,w2,iterations,vertices_per_pixel,pixel_accuracy,mean_iou\n";
  for (const CrfTrial& t : search.trials) {
    text += fmt::format("{},{},{},{},{},{},{:.3f},{:.4f},{:.4f}\n", t.widths.theta_alpha_px, t.widths.theta_beta,
                        t.appearance_weight, t.widths.theta_gamma_px, t.smoothness_weight, t.iterations,
                        t.vertices_per_pixel, t.pixel_accuracy, t.mean_iou);
  }
  return text;
}

TrainOptions crf_train_options(const Experiment& experiment) {
  const CrfExperiment& crf = experiment.crf;
  TrainOptions options = experiment.train;
  options.solver = Solver::adamw;
  options.sum_loss = false;
  options.class_weights.clear();  // pixels count alike, as in the search
  options.balance_classes = false;
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
void train_crf(const TrainingRun& run, Monitor* monitor) {
  const fs::path start_file = run.out / "model.safetensors", out = run.out / "crf",
                 checkpoint_file = out / "checkpoint.safetensors";
  if (!fs::exists(start_file)) {
    throw OptionError(
        fmt::format("{} is missing: train the network first, the same command without --crf", start_file.string()));
  }
  const TensorFile start = read_safetensors(start_file);
  ModelMetadata metadata = parse_model_metadata(start.metadata, start_file.string());
  metadata.finest_gsd_m = run.network.finest_gsd_m;
  const int classes = static_cast<int>(run.classes.classes.size());
  if (metadata.classes.classes.size() != run.classes.classes.size()) {
    throw InputError(start_file.string(), fmt::format("has the class table '{}', the experiment '{}'",
                                                      metadata.classes.name, run.classes.name));
  }
  const CrfExperiment& crf = run.experiment.crf;
  TrainOptions options = crf_train_options(run.experiment);
  fs::create_directories(out);
  std::optional<TensorFile> checkpoint;
  if (fs::exists(checkpoint_file)) {
    if (!run.resume) throw OptionError(fmt::format("{} holds a training run: go on with --resume", out.string()));
    checkpoint = read_safetensors(checkpoint_file);
    const std::optional<CrfModel> begun = read_crf(*checkpoint, classes, checkpoint_file.string());
    if (!begun) throw InputError(checkpoint_file.string(), "holds no CRF: choose another folder");
    options.crf = CrfTraining{*begun, crf.learning_rate, crf.shrinkage, crf.unary_compatibility};
  } else {
    const Trainer predictor(start, start_file.string(), metadata, options);
    if (monitor) monitor->info("searching the widths and weights of the CRF");
    CrfSearchOptions grid = crf.search;
    grid.threads = run.experiment.train.threads;
    const CrfSearch search = search_crf(predictor.crf_samples(run.scenes, crf.search_crops), classes, grid);
    if (monitor && !search.at_edges.empty())
      monitor->info(fmt::format("the CRF's search ends at the edge of its grid ({}): widen it in [crf]",
                                fmt::join(search.at_edges, ", ")));
    write_text_file(out / "search.csv", search_table(search));
    CrfModel best = search.best;
    for (std::vector<float>* weights : {&best.parameters.appearance_weight, &best.parameters.smoothness_weight})
      for (float& w : *weights) w = std::max(w, 0.05F);  // a weight of zero has no logarithm to learn
    TensorFile untrained = start;
    add_crf(untrained, search.best);
    write_text_file(out / "searched.safetensors", format_safetensors(untrained));
    options.crf = CrfTraining{best, crf.learning_rate, crf.shrinkage, crf.unary_compatibility};
  }
  Trainer trainer(start, start_file.string(), metadata, options);
  if (checkpoint) trainer.restore(*checkpoint, checkpoint_file.string());
  remove_stale_atomic_files(out);
  write_text_file(run.out / "experiment.toml", run.experiment_text);
  TrainingLog log(out, checkpoint ? trainer.step() : -1);
  train_network(trainer, options, run.scenes, run.validation, hooks_for(out, log, 0), monitor);
  log.write_page();
}

}  // namespace

void prepare_training_folder(const fs::path& out, bool resume, bool crf) {
  if (fs::exists(out / "checkpoint.safetensors") && !resume && !crf) {
    throw OptionError(
        fmt::format("{} holds a training run: go on with --resume or choose another folder", out.string()));
  }
  fs::create_directories(out);
}

void run_training(TrainingRun run, Monitor* monitor) {
  const bool apart = std::ranges::any_of(run.scenes, &TrainingScene::crf_only);
  if (apart) std::erase_if(run.scenes, [&](const TrainingScene& s) { return s.crf_only != run.crf; });
  TrainOptions& options = run.experiment.train;
  if (options.balance_classes) options.class_weights = balanced_class_weights(run.scenes, run.classes.classes.size());
  if (run.crf) return train_crf(run, monitor);
  train(run, monitor);
}

}  // namespace orthodrive
