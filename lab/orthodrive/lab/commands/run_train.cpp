// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/lab/commands/run_train.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <map>
#include <set>
#include <utility>

#include "orthodrive/core/atomic_file.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/core/random.hpp"
#include "orthodrive/io/models/caffe_model.hpp"
#include "orthodrive/io/models/safetensors_stream.hpp"
#include "orthodrive/io/models/weights_io.hpp"
#include "orthodrive/io/raster/raster_io.hpp"
#include "orthodrive/io/support/read_file.hpp"
#include "orthodrive/lab/training/packed_scenes.hpp"
#include "orthodrive/lab/training/parts.hpp"
#include "orthodrive/lab/training/training_data.hpp"
#include "orthodrive/nets/make_network.hpp"
#include "orthodrive/pipeline/build/site_stages.hpp"
#include "orthodrive/pipeline/files/output_lock.hpp"
#include "orthodrive/train/disturbed_map.hpp"

namespace orthodrive {
namespace fs = std::filesystem;

namespace {
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

/// An experiment with the network that it trains.
struct OpenExperiment {
  std::string text;
  Experiment experiment;
  Network network;
};

OpenExperiment open_experiment(const TrainFiles& files, const StageContext& context) {
  const fs::path& file = files.experiment;
  OpenExperiment open{.text = io::read_file(file)};
  open.experiment = parse_experiment(open.text, file);
  std::set<fs::path> read{fs::weakly_canonical(file)};
  for (fs::path more = open.experiment.data_from; !more.empty();) {
    if (!read.insert(fs::weakly_canonical(more)).second)
      throw InputError(more.string(), "data_from leads back here; leave one of them out");
    const Experiment other = parse_experiment(io::read_file(more), more);
    add_data(open.experiment, other);
    more = other.data_from;
  }
  if (!files.leave_out.empty()) open.experiment.leave_out = files.leave_out;
  if (!files.weights.empty()) open.experiment.weights = files.weights;
  leave_out_data(open.experiment, file.string());
  open.network = read_network(open.experiment.network);
  open.experiment.train.threads = context.threads;
  return open;
}

TrainingData read_data(const OpenExperiment& open, const fs::path& file, const StageContext& context) {
  TrainingData data = read_training_data(open.experiment, open.network.spec.gsd_m, open.network.classes,
                                         context.threads, context.monitor);
  if (std::ranges::none_of(data.scenes,
                           [](const TrainingScene& s) { return s.weight > 0.0 && s.from_step <= 0 && !s.crf_only; })) {
    throw InputError(file.string(),
                     "has nothing to train on at step 0: add [[map]], [[images]], [[raster]] or [[polygons]] that is "
                     "not held out, with a weight above 0 and from_step 0");
  }
  std::vector<std::string> without;
  const std::vector<ClassInfo>& classes = open.network.classes.classes;
  const ClassShares shares = class_shares(data, classes.size());
  for (std::size_t c = 0; c < classes.size(); ++c)
    if (shares.training[c] == 0.0) without.push_back(classes[c].name);
  if (!without.empty()) context.info(fmt::format("no pixel to learn from is known to be {}", fmt::join(without, ", ")));
  return data;
}

bool is_caffe_model(const fs::path& file) { return file.extension() == ".caffemodel"; }

WeightsSource read_weights(const fs::path& file) {
  if (!is_caffe_model(file)) return {file.filename().string(), read_safetensors(file)};
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw InputError(file.string(), "cannot be opened: does it exist?");
  return {file.filename().string(), read_caffe_model(stream, file.string())};
}

/// For a machine without protobuf.
fs::path write_portable_weights(const fs::path& file, const fs::path& pack) {
  if (!is_caffe_model(file)) return file;
  fs::path portable = pack;
  portable.replace_filename(fmt::format("{}_{}.safetensors", pack.stem().string(), file.stem().string()));
  write_text_file(portable, format_safetensors(read_weights(file).file));
  return portable;
}
}  // namespace

void run_train(const TrainFiles& files, const RunTrainOptions& options, StageContext& context) {
  OpenExperiment open = open_experiment(files, context);
  open.experiment.train.cuda = options.cuda;
  train_part().prepare_training_folder(files.folder, options.resume, options.crf);
  const OutputLock lock(files.folder / private_folder / "lock", context.monitor);
  TrainingData data = read_data(open, files.experiment, context);
  const auto read_all_weights = [&open] {
    std::vector<WeightsSource> sources;
    sources.reserve(open.experiment.weights.size());
    for (const fs::path& file : open.experiment.weights) sources.push_back(read_weights(file));
    return sources;
  };
  train_part().run_training({.out = files.folder,
                             .experiment_text = open.text,
                             .experiment = open.experiment,
                             .network = open.network.spec,
                             .classes = open.network.classes,
                             .scenes = std::move(data.scenes),
                             .validation = std::move(data.validation),
                             .read_weights = read_all_weights,
                             .resume = options.resume,
                             .crf = options.crf},
                            context.monitor);
}

namespace {
/// Crops as a network that sees a map learns from them: the map's lines in red, what is known of the true ones in
/// green.
Raster<std::uint8_t> preview_crops(const std::vector<TrainingScene>& scenes, const TrainOptions& train, double gsd_m,
                                   const MapClasses& classes) {
  constexpr int columns = 6, rows = 4;
  const int size = train.crop_px;
  Raster<std::uint8_t> sheet(columns * size, rows * size, 3);
  for (int i = 0; i < columns * rows; ++i) {
    const std::uint64_t seed = derive_seed(train.seed, static_cast<std::uint64_t>(i));
    const Crop crop = draw_crop(scenes[draw_scene(scenes, train.steps, seed)], {size, gsd_m, train.augmentation}, seed);
    const DisturbedMap map = draw_map(crop.allowed, crop.map, classes, seed);
    Raster<std::uint8_t> picture = crop.rgb;
    const auto mark = [&](Vec2 p, int channel) {
      const int col = static_cast<int>(p.x), row = static_cast<int>(p.y);
      if (!picture.inside(col, row)) return;
      for (int c = 0; c < 3; ++c) picture.at(col, row, c) = c == channel ? 255 : 0;
    };
    for (int row = 0; row < size; ++row)
      for (int col = 0; col < size; ++col) {
        const std::uint8_t* bytes = &map.map.at(col, row);
        const AlignmentTruth& truth = map.truth.at(col, row);
        if (bytes[2] < 240) continue;  // more than a pixel and a half away
        const Vec2 pixel{col + 0.5, row + 0.5};
        mark(pixel, 0);  // the truth is told from here
        if (truth.known) mark(pixel + Vec2{truth.normal_x, truth.normal_y} * truth.offset, 1);
      }
    for (int row = 0; row < size; ++row)
      std::copy_n(&picture.at(0, row), 3 * size, &sheet.at(i % columns * size, i / columns * size + row));
  }
  return sheet;
}
}  // namespace

void preview_training(const TrainFiles& files, StageContext& context) {
  const OpenExperiment open = open_experiment(files, context);
  fs::create_directories(files.folder);
  const TrainingData data = read_data(open, files.experiment, context);
  const ClassTable& classes = open.network.classes;
  for (const TrainingScene& scene : data.scenes)
    io::write_png(files.folder / (scene.name + ".png"), label_preview(scene.rgb, scene.allowed, classes));
  for (const ValidationScene& scene : data.validation)
    io::write_png(files.folder / (scene.name + "_held_out.png"),
                  label_preview(scene.photo.rgb, scene.allowed, classes));
  const ClassShares shares = class_shares(data, classes.classes.size());
  std::string table = "class,training_percent,held_out_percent\n";
  for (std::size_t c = 0; c < classes.classes.size(); ++c)
    table += fmt::format("{},{:.3f},{:.3f}\n", classes.classes[c].name, 100.0 * shares.training[c],
                         100.0 * shares.held_out[c]);
  write_text_file(files.folder / "class_shares.csv", table);
  const NetworkSpec& spec = open.network.spec;
  if (make_network(spec.architecture(), static_cast<int>(classes.classes.size())).map_channels > 0)
    io::write_png(files.folder / "crops_with_map.png",
                  preview_crops(data.scenes, open.experiment.train, spec.gsd_m, train_part().map_classes(classes)));
}

void pack_training(const TrainFiles& files, const fs::path& pack, StageContext& context) {
  const OpenExperiment open = open_experiment(files, context);
  TrainingData data = read_data(open, files.experiment, context);
  const NetworkSpec& spec = open.network.spec;
  PackedScenes packed{
      std::move(data.scenes), std::move(data.validation),
      format_model_metadata({spec.architecture(), open.network.classes, spec.gsd_m, spec.finest_gsd_m})};
  packed.metadata["experiment"] = open.text;
  packed.metadata["network"] = io::read_file(open.experiment.network);
  AtomicFile aside(pack);
  std::ofstream stream(aside.path(), std::ios::binary);
  write_packed_scenes(stream, packed);
  stream.close();
  if (!stream) throw Error(fmt::format("{}: cannot be written, is the disk full?", pack.string()));
  aside.commit();
  for (const fs::path& file : open.experiment.weights)
    context.info(fmt::format("carry along: {}  (--weights)", write_portable_weights(file, pack).string()));
}

namespace {
SegmentModel read_measured_model(const MeasureOptions& options, const ClassTable& classes) {
  const fs::path file = io::find_model(options.model);
  SegmentModel model = load_model(io::read_weights(file), file.string());
  if (model.classes.classes.size() != classes.classes.size())
    throw InputError(file.string(),
                     fmt::format("has the class table '{}', the experiment '{}'", model.classes.name, classes.name));
  if (!options.crf) model.crf.reset();
  if (options.crf && !model.crf) model.crf = reference_crf(static_cast<int>(classes.classes.size()));
  return model;
}

using ValidationSets = std::map<std::string, std::vector<ValidationScene>>;

ValidationSets choose_sets(std::vector<ValidationScene> scenes, const std::vector<std::string>& wanted) {
  ValidationSets sets;
  for (ValidationScene& scene : scenes)
    if (wanted.empty() || std::ranges::find(wanted, scene.name) != wanted.end())
      sets[scene.name].push_back(std::move(scene));
  for (const std::string& name : wanted)
    if (!sets.contains(name)) throw OptionError(fmt::format("--set {}: the experiment holds out no such data", name));
  return sets;
}

/// Of a set, and of a model that sees a map also of the set with its map.
void measure_set(const TrainPart& part, const SegmentModel& model, const std::vector<ValidationScene>& set, int threads,
                 nlohmann::ordered_json& json) {
  const auto rounded = [](double value) { return std::round(value * 1e4) / 1e4; };  // NaN becomes null
  double megapixels = 0.0;
  for (const ValidationScene& scene : set) megapixels += 1e-6 * static_cast<double>(scene.allowed.data.size());
  const auto start = std::chrono::steady_clock::now();
  const auto scores = part.measure_model(model, set, threads);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  for (const auto& [name, of_set] : scores) {
    const LabelScore& score = of_set.labels;
    const auto said = static_cast<double>(of_set.said_road);
    nlohmann::ordered_json& entry = json[name];
    entry = {{"road_iou", rounded(of_set.roads.iou(1))},
             {"mean_iou", rounded(score.mean_iou())},
             {"pixel_accuracy", rounded(score.pixel_accuracy())},
             {"road_stated", rounded(of_set.stated_road / said)},
             {"road_right", rounded(static_cast<double>(of_set.is_road) / said)},
             {"megapixels", rounded(megapixels)},
             {"seconds", rounded(seconds / static_cast<double>(scores.size()))}};
    for (std::size_t c = 0; c < model.classes.classes.size(); ++c)
      entry["iou"][model.classes.classes[c].name] = rounded(score.iou(static_cast<int>(c)));
  }
}
}  // namespace

nlohmann::ordered_json measure_on_held_out_data(const TrainFiles& files, const MeasureOptions& options,
                                                StageContext& context) {
  const TrainPart& part = train_part();  // missing: said before the data are read
  const OpenExperiment open = open_experiment(files, context);
  std::vector<ValidationScene> scenes = read_held_out_data(open.experiment, open.network.spec.gsd_m,
                                                           open.network.classes, context.threads, context.monitor);
  const SegmentModel model = read_measured_model(options, open.network.classes);
  nlohmann::ordered_json json;
  for (const auto& [name, set] : choose_sets(std::move(scenes), options.sets))
    measure_set(part, model, set, context.threads, json);
  return json;
}

}  // namespace orthodrive
