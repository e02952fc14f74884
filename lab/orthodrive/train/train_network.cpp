// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/train/train_network.hpp"

#include <ATen/Parallel.h>
#include <ATen/core/grad_mode.h>
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <optional>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/median.hpp"
#include "orthodrive/core/parallel.hpp"
#include "orthodrive/core/random.hpp"
#include "orthodrive/nets/make_network.hpp"
#include "orthodrive/segment/segment_mosaic.hpp"
#include "orthodrive/train/alignment_loss.hpp"
#include "orthodrive/train/allowed_class_loss.hpp"
#include "orthodrive/train/padded_network.hpp"
#include "orthodrive/train/reusing_allocator.hpp"
#include "orthodrive/train/scale_start.hpp"
#include "orthodrive/train/single_threaded_blas.hpp"
#include "orthodrive/train/weight_mean.hpp"

namespace orthodrive {
namespace {

constexpr double adam_beta1 = 0.9, adam_beta2 = 0.999, adam_eps = 1e-8;  // Kingma and Ba, 2015
constexpr std::int64_t report_every = 10;

/// Share of the peak of the learning rates.
double schedule_at(const TrainOptions& options, std::int64_t step) {
  const auto t = static_cast<double>(step);
  if (step < options.warmup_steps) return (t + 1.0) / static_cast<double>(options.warmup_steps);
  if (step < options.decay_from_step) return 1.0;
  const double left = static_cast<double>(options.steps - step) /
                      static_cast<double>(std::max<std::int64_t>(1, options.steps - options.decay_from_step));
  return 0.5 * (1.0 - std::cos(std::numbers::pi * std::clamp(left, 0.0, 1.0)));
}

/// A tensor that learns, with its running moments.
struct Learned {
  std::string name;
  at::Tensor value, first_moment, second_moment;
  double peak_rate = 0.0;  ///< of learning, where the schedule is 1
  double decay = 0.0;      ///< towards zero
};

NamedTensor copy_of(const at::Tensor& tensor) {
  const at::Tensor flat = tensor.detach().to(at::kCPU).contiguous();
  const float* data = flat.data_ptr<float>();
  return {flat.sizes().vec(), std::vector<float>(data, data + flat.numel()), TensorType::f32};
}

void copy_into(at::Tensor& target, const TensorFile& file, const std::string& name, const std::string& source) {
  const auto it = file.tensors.find(name);
  if (it == file.tensors.end() || it->second.shape != target.sizes().vec()) {
    throw InputError(
        source,
        fmt::format("tensor '{}' is missing or of another shape: the checkpoint is of another experiment", name));
  }
  const at::NoGradGuard no_grad;
  target.copy_(at::from_blob(const_cast<float*>(it->second.values.data()), it->second.shape, at::kFloat));
}

struct Batch {
  std::vector<std::uint8_t> rgb;
  std::vector<ClassSet> allowed;
  std::vector<std::uint8_t> map;  ///< these two for networks that see one
  std::vector<AlignmentTruth> alignment;

  [[nodiscard]] NetworkInput input() const { return {rgb.data(), map.empty() ? nullptr : map.data()}; }
};

/// `on_map`: the classes that a map is drawn of; none: no map is drawn.
Batch draw_batch(const std::vector<TrainingScene>& scenes, const TrainOptions& options, double gsd_m, std::int64_t step,
                 const std::optional<MapClasses>& on_map) {
  const std::size_t pixels = static_cast<std::size_t>(options.crop_px) * static_cast<std::size_t>(options.crop_px);
  const auto count = static_cast<std::size_t>(options.batch);
  Batch batch{std::vector<std::uint8_t>(3 * pixels * count), std::vector<ClassSet>(pixels * count), {}, {}};
  if (on_map) {
    batch.map.resize(map_raster_channels * pixels * count);
    batch.alignment.resize(pixels * count);
  }
  parallel_for(count, options.threads, [&](std::size_t i) {
    const std::uint64_t seed = derive_seed(derive_seed(options.seed, static_cast<std::uint64_t>(step)), i);
    const TrainingScene& scene = scenes[draw_scene(scenes, step, seed)];
    const Crop crop = draw_crop(scene, {options.crop_px, gsd_m, options.augmentation}, derive_seed(seed, 1));
    std::memcpy(&batch.rgb[3 * pixels * i], crop.rgb.data.data(), 3 * pixels);
    std::memcpy(&batch.allowed[pixels * i], crop.allowed.data.data(), pixels * sizeof(ClassSet));
    if (!on_map) return;
    const DisturbedMap map = draw_map(crop.allowed, crop.map, *on_map, derive_seed(seed, 3));
    std::ranges::copy(map.map.data, &batch.map[map_raster_channels * pixels * i]);
    std::ranges::copy(map.truth.data, &batch.alignment[pixels * i]);
  });
  return batch;
}

/// The alignment's truth of the pixels that are learned from.
std::vector<AlignmentTruth> truth_of(const Batch& batch, const TrainOptions& options, CellRange labelled) {
  std::vector<AlignmentTruth> truth;
  for (int i = 0; i < options.batch; ++i)
    for (int row = labelled.first; row <= labelled.last; ++row) {
      const auto from =
          batch.alignment.begin() + (static_cast<std::ptrdiff_t>(i) * options.crop_px + row) * options.crop_px;
      truth.insert(truth.end(), from + labelled.first, from + labelled.last + 1);
    }
  return truth;
}

/// The photos of a batch as far as they have scores.
std::vector<Raster<std::uint8_t>> photos_of(const Batch& batch, const TrainOptions& options, CellRange scored) {
  std::vector<Raster<std::uint8_t>> photos;
  const auto crop = static_cast<std::size_t>(options.crop_px), size = static_cast<std::size_t>(scored.size());
  for (std::size_t i = 0; i < static_cast<std::size_t>(options.batch); ++i) {
    Raster<std::uint8_t>& photo = photos.emplace_back(scored.size(), scored.size(), 3);
    for (std::size_t row = 0; row < size; ++row) {
      const std::size_t from =
          (i * crop + row + static_cast<std::size_t>(scored.first)) * crop + static_cast<std::size_t>(scored.first);
      std::memcpy(&photo.data[3 * row * size], &batch.rgb[3 * from], 3 * size);
    }
  }
  return photos;
}

}  // namespace

struct Trainer::State {
  TrainOptions options;
  ModelMetadata metadata;
  NetworkGraph graph;
  NetworkParams params;
  std::vector<Learned> learned;
  // Relative to options.crf->start; the last is undefined where it is not learned.
  at::Tensor crf_log_appearance, crf_log_smoothness, crf_compatibility, crf_unary;
  at::Device device = at::kCPU;
  std::int64_t step = 0;
  WeightMean mean;

  /// What the model file holds.
  [[nodiscard]] const NetworkParams& result() const { return mean.count() > 0 ? mean.mean() : params; }

  void collect_learned() {
    learned.clear();
    for (std::size_t i = 0; i < graph.layers.size(); ++i) {
      const Layer& layer = graph.layers[i];
      LayerParams& p = params[i];
      if (options.map_only != layer.of_map) continue;
      const double rate = options.learning_rate * (layer.pretrained ? options.trunk_rate_factor : 1.0);
      const auto add = [&](const std::string& name, at::Tensor& value, bool decays) {
        if (network_is_frozen())
          value = value.to(device);
        else
          learn(name, value, rate, decays ? options.weight_decay : 0.0);
      };
      if (!p.kernel.defined()) continue;
      add(layer.kernel_tensor, p.kernel, !layer.depthwise);
      if (p.bias.defined()) add(bias_tensor(layer), p.bias, false);
      if (!p.gamma.defined()) continue;
      add(layer.norm_tensors + "/gamma", p.gamma, false);
      add(layer.norm_tensors + "/beta", p.beta, false);
      p.mean = p.mean.to(device);
      p.variance = p.variance.to(device);
    }
    if (!options.crf) return;
    const std::int64_t n = graph.class_count;
    const double rate = options.crf->learning_rate, decay = options.crf->shrinkage;
    crf_log_appearance = at::zeros({n});
    crf_log_smoothness = at::zeros({n});
    crf_compatibility = at::zeros({n, n});
    learn("crf/log_appearance", crf_log_appearance, rate, decay);
    learn("crf/log_smoothness", crf_log_smoothness, rate, decay);
    learn("crf/compatibility_change", crf_compatibility, rate, decay);
    if (!options.crf->unary) return;
    crf_unary = at::zeros({n, n});
    learn("crf/unary_change", crf_unary, rate, decay);
  }

  /// The reference's way (sec. 2.4): the CRF alone learns, on a network that stays as it is.
  [[nodiscard]] bool network_is_frozen() const { return options.crf && options.learning_rate == 0.0; }

  void learn(const std::string& name, at::Tensor& value, double peak_rate, double decay) {
    value = value.to(device).set_requires_grad(true);
    at::Tensor second = options.solver == Solver::adamw ? at::zeros_like(value) : at::Tensor();
    learned.push_back({name, value, at::zeros_like(value), std::move(second), peak_rate, decay});
  }

  /// The CRF as learned so far.
  [[nodiscard]] CrfModel current_crf() const {
    // NOLINTNEXTLINE(bugprone-unchecked-optional-access): only who learns one asks
    CrfModel crf = options.crf->start;
    const auto scale = [](std::vector<float>& weights, const at::Tensor& log_ratio) {
      const at::Tensor ratio = log_ratio.detach().to(at::kCPU).exp().contiguous();
      for (std::size_t c = 0; c < weights.size(); ++c) weights[c] *= ratio.data_ptr<float>()[c];
    };
    scale(crf.parameters.appearance_weight, crf_log_appearance);
    scale(crf.parameters.smoothness_weight, crf_log_smoothness);
    const auto shift = [](std::vector<float>& matrix, const at::Tensor& by) {
      const at::Tensor change = by.detach().to(at::kCPU).contiguous();
      for (std::size_t i = 0; i < matrix.size(); ++i) matrix[i] += change.data_ptr<float>()[i];
    };
    shift(crf.parameters.compatibility, crf_compatibility);
    if (!crf_unary.defined()) return crf;
    if (crf.parameters.unary_compatibility.empty()) {
      const auto n = static_cast<std::size_t>(graph.class_count);
      crf.parameters.unary_compatibility.assign(n * n, 0.0F);
      for (std::size_t c = 0; c < n; ++c) crf.parameters.unary_compatibility[c * n + c] = -1.0F;
    }
    shift(crf.parameters.unary_compatibility, crf_unary);
    return crf;
  }

  /// Runs the CRF on the scores (N x C x H x W) of image parts, and the derivatives of the loss back through it: sets
  /// the gradients of its own parameters, returns those of the scores. Only `labelled` rows and columns have `allowed`.
  LossGradient learn_crf(const at::Tensor& scores, const std::vector<Raster<std::uint8_t>>& photos,
                         const at::Tensor& allowed, CellRange labelled, const AllowedLossOptions& loss_options) {
    const at::NoGradGuard no_grad;
    const CrfModel crf = current_crf();
    const auto count = static_cast<std::size_t>(scores.size(0));
    const at::Tensor log_p = at::log_softmax(scores.detach().to(at::kCPU), 1).permute({0, 2, 3, 1}).contiguous();
    const at::Tensor unary = -log_p;
    const std::size_t values = static_cast<std::size_t>(unary.numel()) / count;
    std::vector<std::unique_ptr<DenseCrf>> crfs(count);
    std::vector<CrfTape> tapes(count);
    at::Tensor marginals = at::empty_like(unary);
    const auto part = [values](const at::Tensor& tensor, std::size_t i) {
      return tensor.data_ptr<float>() + i * values;
    };
    parallel_for(count, options.threads, [&](std::size_t i) {
      crfs[i] = std::make_unique<DenseCrf>(
          CrfImage{.width = photos[i].width, .height = photos[i].height, .rgb = photos[i].data.data()}, crf.widths);
      tapes[i] = crfs[i]->record(crf.parameters, {part(unary, i), values});
      const auto result = tapes[i].result();
      std::copy(result.begin(), result.end(), part(marginals, i));
    });
    const at::Tensor inner = marginals.narrow(1, labelled.first, labelled.size())
                                 .narrow(2, labelled.first, labelled.size())
                                 .permute({0, 3, 1, 2});
    const LossGradient loss = expected_error(inner, allowed.to(at::kCPU), loss_options);
    at::Tensor gradient = at::zeros_like(marginals);
    gradient.narrow(1, labelled.first, labelled.size())
        .narrow(2, labelled.first, labelled.size())
        .copy_(loss.gradient.permute({0, 2, 3, 1}));
    std::vector<CrfGradients> back(count);
    parallel_for(count, options.threads, [&](std::size_t i) {
      back[i] = crfs[i]->backward(crf.parameters, tapes[i], {part(gradient, i), values});
    });
    const std::int64_t n = graph.class_count;
    at::Tensor d_appearance = at::zeros({n}), d_smoothness = at::zeros({n}), d_compatibility = at::zeros({n, n});
    at::Tensor d_unary = at::empty_like(unary), d_unary_compatibility = at::zeros({n, n});
    for (std::size_t i = 0; i < count; ++i) {
      if (crf_unary.defined()) d_unary_compatibility += at::tensor(back[i].unary_compatibility).view({n, n});
      std::copy(back[i].unary.begin(), back[i].unary.end(), part(d_unary, i));
      d_appearance += at::tensor(back[i].appearance_weight);
      d_smoothness += at::tensor(back[i].smoothness_weight);
      d_compatibility += at::tensor(back[i].compatibility).view({n, n});
    }
    // d weight / d log ratio = weight
    crf_log_appearance.mutable_grad() = (d_appearance * at::tensor(crf.parameters.appearance_weight)).to(device);
    crf_log_smoothness.mutable_grad() = (d_smoothness * at::tensor(crf.parameters.smoothness_weight)).to(device);
    crf_compatibility.mutable_grad() = d_compatibility.to(device);
    if (crf_unary.defined()) crf_unary.mutable_grad() = d_unary_compatibility.to(device);
    // unary c = -score c + log sum exp scores
    const at::Tensor d_scores = log_p.exp() * d_unary.sum(3, true) - d_unary;
    return {loss.loss, d_scores.permute({0, 3, 1, 2}).to(scores.device())};
  }

  void update_weights() {
    const at::NoGradGuard no_grad;
    const auto t = static_cast<double>(step + 1);
    const double schedule = schedule_at(options, step);
    const double correction1 = 1.0 - std::pow(adam_beta1, t), correction2 = 1.0 - std::pow(adam_beta2, t);
    for (Learned& l : learned) {
      at::Tensor& gradient = l.value.mutable_grad();
      if (!gradient.defined()) continue;
      const double own_rate = schedule * l.peak_rate;
      if (options.solver == Solver::sgd) {  // Caffe: v = m v + rate (g + decay w); w -= v
        if (l.decay > 0.0) gradient.add_(l.value, l.decay);
        l.first_moment.mul_(options.momentum).add_(gradient, own_rate);
        l.value.sub_(l.first_moment);
      } else {
        l.first_moment.mul_(adam_beta1).add_(gradient, 1.0 - adam_beta1);
        l.second_moment.mul_(adam_beta2).addcmul_(gradient, gradient, 1.0 - adam_beta2);
        if (l.decay > 0.0) l.value.mul_(1.0 - own_rate * l.decay);
        const at::Tensor scale = (l.second_moment / correction2).sqrt_().add_(adam_eps);
        l.value.addcdiv_(l.first_moment, scale, -own_rate / correction1);
      }
      gradient = at::Tensor();
    }
  }

  /// Throws Error when a weight is no number or would be infinite in a model file: such a network must not replace one
  /// that works.
  void require_sound_weights() const {
    constexpr double largest_half = 65504.0;  // IEEE 754 binary16
    for (const Learned& l : learned) {
      if (l.value.detach().abs().max().item<double>() <= largest_half) continue;  // false for NaN
      throw Error(
          fmt::format("training diverged before step {}: '{}' holds values that are no numbers or above {}; the last "
                      "checkpoint is kept, go on from it with a lower learning rate",
                      step, l.name, largest_half));
    }
  }

  [[nodiscard]] std::optional<MapClasses> on_map() const {
    if (!options.map_only) return {};
    return map_classes(metadata.classes);
  }

  /// Pixels of a crop that get scores, and those in its centre that are learned from.
  [[nodiscard]] CellRange scored_range() const {
    const CellRange cells = padded_ranges(graph, options.crop_px).back();
    return {std::max(0, cells.first + graph.output_shift),
            std::min(options.crop_px - 1, cells.last + graph.output_shift)};
  }
  [[nodiscard]] CellRange label_range() const {
    const CellRange scored = scored_range();
    if (options.label_px == 0) return scored;
    const int first = (options.crop_px - options.label_px) / 2;
    const CellRange wanted{first, first + options.label_px - 1};
    if (wanted.first < scored.first || wanted.last > scored.last) {
      throw OptionError(fmt::format("label_px of {}: {} gives scores for the inner {} px of a crop of {} px only",
                                    options.label_px, graph.architecture, scored.size(), options.crop_px));
    }
    return wanted;
  }
};

Trainer::Trainer(const TensorFile& start, const std::string& source, const ModelMetadata& metadata,
                 TrainOptions options)
    : state_(std::make_unique<State>()) {
  State& s = *state_;
  s.metadata = metadata;
  const std::size_t classes = metadata.classes.classes.size();
  if (options.class_weights.empty()) options.class_weights.assign(classes, 1.0F);
  if (options.class_weights.size() != classes) {
    throw OptionError(
        fmt::format("{} class weights for {} classes: give one per class", options.class_weights.size(), classes));
  }
  s.options = std::move(options);
  s.graph = make_network(metadata.architecture, static_cast<int>(classes));
  if (s.options.crop_px % s.graph.stride_px != s.graph.size_remainder) {
    const int stride = s.graph.stride_px, rest = s.graph.size_remainder;
    const int below = (s.options.crop_px - rest) / stride * stride + rest;
    throw OptionError(fmt::format("crop_px of {}: {} needs a multiple of {} plus {}, such as {}", s.options.crop_px,
                                  metadata.architecture, stride, rest, below + stride));
  }
  static_cast<void>(s.label_range());
  if (s.options.map_only && (s.graph.map_channels == 0 || s.options.crf))
    throw OptionError(fmt::format("map_only: {} sees no map, or a CRF is to be learned", metadata.architecture));
  if (s.options.cuda) {
    if (!at::hasCUDA()) throw OptionError("this libtorch has no CUDA: train on the CPU");
    s.device = at::Device(at::kCUDA, 0);
  }
  s.params = params_from_file(s.graph, start, source);
  s.collect_learned();
}

Trainer::~Trainer() = default;
Trainer::Trainer(Trainer&&) noexcept = default;
Trainer& Trainer::operator=(Trainer&&) noexcept = default;

std::int64_t Trainer::step() const { return state_->step; }
double Trainer::learning_rate() const {
  return state_->options.learning_rate * schedule_at(state_->options, state_->step);
}
const ModelMetadata& Trainer::metadata() const { return state_->metadata; }

void Trainer::scale_start(const std::vector<TrainingScene>& scenes) {
  State& s = *state_;
  at::set_num_threads(worker_count(s.options.threads));
  const int size = s.options.crop_px;
  const Batch batch = draw_batch(scenes, s.options, s.metadata.gsd_m, s.step, s.on_map());
  scale_to_unit_output(s.graph, s.params,
                       input_tensors(s.graph, batch.input(), s.options.batch, size, size).to(s.device));
}

double Trainer::advance(const std::vector<TrainingScene>& scenes) {
  State& s = *state_;
  const TrainOptions& options = s.options;
  at::set_num_threads(worker_count(options.threads));
  at::manual_seed(derive_seed(derive_seed(options.seed, static_cast<std::uint64_t>(s.step)), 2));  // dropout
  const Batch batch = draw_batch(scenes, options, s.metadata.gsd_m, s.step, s.on_map());
  const InputTensors input =
      input_tensors(s.graph, batch.input(), options.batch, options.crop_px, options.crop_px).to(s.device);
  const Scores scores = forward_padded(s.graph, s.params, input,
                                       {.update_batch_statistics = s.step < options.freeze_norm_from_step,
                                        .dropout = true,
                                        .of_map_only = options.map_only});
  const CellRange labelled = s.label_range(), scored = s.scored_range();
  const auto part = [](const at::Tensor& values, std::int64_t dimension, CellRange has, CellRange wanted) {
    return values.narrow(dimension, wanted.first - has.first, wanted.size())
        .narrow(dimension + 1, wanted.first - has.first, wanted.size());
  };
  const at::Tensor allowed = part(at::from_blob(const_cast<ClassSet*>(batch.allowed.data()),
                                                {options.batch, options.crop_px, options.crop_px}, at::kLong),
                                  1, {0, options.crop_px - 1}, labelled)
                                 .to(s.device);
  const AllowedLossOptions loss_options{options.class_weights, options.set_weight, options.sum_loss};
  // A CRF infers on all pixels that have scores; what is not learned from is cropped only after it.
  const at::Tensor outputs = part(scores.values, 2, scores.row_px, options.crf ? scored : labelled);
  const at::Tensor values = outputs.narrow(1, 0, s.graph.class_count);
  LossGradient loss = options.crf
                          ? s.learn_crf(values, photos_of(batch, options, scored), allowed,
                                        {labelled.first - scored.first, labelled.last - scored.first}, loss_options)
                          : allowed_class_loss(values, allowed, loss_options);
  if (!options.crf && options.jaccard_weight > 0.0) {
    const LossGradient jaccard = jaccard_loss(values, allowed);
    loss.loss += options.jaccard_weight * jaccard.loss;
    loss.gradient += options.jaccard_weight * jaccard.gradient;
  }
  if (options.map_only) {
    const LossGradient alignment = alignment_loss(outputs.narrow(1, s.graph.class_count, s.graph.alignment_channels),
                                                  truth_of(batch, options, labelled));
    loss.loss += alignment.loss;
    loss.gradient = at::cat({loss.gradient, alignment.gradient}, 1);
  }
  if (!std::isfinite(loss.loss)) {
    throw Error(
        fmt::format("training diverged at step {} (the loss is no number): lower the learning rate and go on from "
                    "the last checkpoint",
                    s.step));
  }
  if (!s.network_is_frozen()) (options.map_only ? outputs : values).backward(loss.gradient);
  s.update_weights();
  if (options.average_from_step >= 0 && s.step >= options.average_from_step) s.mean.add(s.params);
  ++s.step;
  return loss.loss;
}

TensorFile Trainer::checkpoint() const {
  const State& s = *state_;
  s.require_sound_weights();
  TensorFile file = file_from_params(s.graph, s.params, TensorType::f32);
  file.metadata = format_model_metadata(s.metadata);
  file.metadata["step"] = std::to_string(s.step);
  s.mean.save(file, s.graph);
  if (s.options.crf) {
    file.tensors.emplace("crf/log_appearance", copy_of(s.crf_log_appearance));
    file.tensors.emplace("crf/log_smoothness", copy_of(s.crf_log_smoothness));
    file.tensors.emplace("crf/compatibility_change", copy_of(s.crf_compatibility));
    if (s.crf_unary.defined()) file.tensors.emplace("crf/unary_change", copy_of(s.crf_unary));
    add_crf(file, s.options.crf->start);
  }
  file.metadata["best_step"] = std::to_string(best.step);
  file.metadata["best_mean_iou"] = fmt::format("{}", best.mean_iou);
  file.metadata["validations_since_best"] = std::to_string(best.validations_since);
  for (const Learned& l : s.learned) {
    file.tensors.emplace(l.name + "/first_moment", copy_of(l.first_moment));
    if (l.second_moment.defined()) file.tensors.emplace(l.name + "/second_moment", copy_of(l.second_moment));
  }
  return file;
}

void Trainer::restore(const TensorFile& checkpoint, const std::string& source) {
  const State& old = *state_;
  const auto number = [&](const char* key) {
    const auto it = checkpoint.metadata.find(key);
    if (it == checkpoint.metadata.end()) throw InputError(source, "is not a training checkpoint");
    return it->second;
  };
  const ModelMetadata metadata = parse_model_metadata(checkpoint.metadata, source);
  if (metadata.architecture != old.metadata.architecture) {
    throw InputError(source, fmt::format("is a checkpoint of {}, this training is of {}", metadata.architecture,
                                         old.metadata.architecture));
  }
  const auto same_name = [](const ClassInfo& a, const ClassInfo& b) { return a.name == b.name; };
  if (!std::ranges::equal(metadata.classes.classes, old.metadata.classes.classes, same_name)) {
    throw InputError(source, fmt::format("is a checkpoint for the classes of '{}', this training is for those of '{}'",
                                         metadata.classes.name, old.metadata.classes.name));
  }
  auto state = std::make_unique<State>();
  state->options = old.options;
  state->metadata = old.metadata;
  state->graph = old.graph;
  state->device = old.device;
  state->params = params_from_file(state->graph, checkpoint, source);
  state->collect_learned();
  state->mean.restore(checkpoint, state->graph, state->device, source);
  if (state->options.crf) {
    copy_into(state->crf_log_appearance, checkpoint, "crf/log_appearance", source);
    copy_into(state->crf_log_smoothness, checkpoint, "crf/log_smoothness", source);
    copy_into(state->crf_compatibility, checkpoint, "crf/compatibility_change", source);
    if (state->crf_unary.defined()) copy_into(state->crf_unary, checkpoint, "crf/unary_change", source);
  }
  for (Learned& l : state->learned) {
    copy_into(l.first_moment, checkpoint, l.name + "/first_moment", source);
    if (l.second_moment.defined()) copy_into(l.second_moment, checkpoint, l.name + "/second_moment", source);
  }
  BestScore kept;
  try {
    state->step = std::stoll(number("step"));
    kept = {std::stoll(number("best_step")), std::stod(number("best_mean_iou")),
            std::stoi(number("validations_since_best"))};
  } catch (const std::logic_error&) {
    throw InputError(source, "its step is no number: the checkpoint is damaged");
  }
  state_ = std::move(state);
  best = kept;
}

TensorFile Trainer::model_file() const {
  state_->require_sound_weights();
  TensorFile file = file_from_params(state_->graph, state_->result(), TensorType::f16);
  file.metadata = format_model_metadata(state_->metadata);
  file.metadata["step"] = std::to_string(state_->step);
  if (state_->options.crf) add_crf(file, state_->current_crf());
  if (state_->options.kept_crf) add_crf(file, *state_->options.kept_crf);
  return file;
}

std::optional<CrfModel> Trainer::crf() const {
  if (!state_->options.crf) return {};
  return state_->current_crf();
}

std::vector<CrfSample> Trainer::crf_samples(const std::vector<TrainingScene>& scenes, int count) const {
  const State& s = *state_;
  const at::NoGradGuard no_grad;
  NetworkParams params = s.params;  // handles only
  TrainOptions options = s.options;
  options.batch = 1;
  const CellRange scored = s.scored_range();
  std::vector<CrfSample> samples;
  for (int i = 0; i < count; ++i) {
    const Batch batch = draw_batch(scenes, options, s.metadata.gsd_m, options.steps + i,
                                   s.on_map());  // other crops than those learned from
    const InputTensors input = input_tensors(s.graph, batch.input(), 1, options.crop_px, options.crop_px).to(s.device);
    const Scores scores = forward_padded(s.graph, params, input, {});
    const at::Tensor unary = (-at::log_softmax(scores.values.narrow(1, 0, s.graph.class_count)
                                                   .narrow(2, scored.first - scores.row_px.first, scored.size())
                                                   .narrow(3, scored.first - scores.col_px.first, scored.size()),
                                               1))
                                 .permute({0, 2, 3, 1})
                                 .to(at::kCPU)
                                 .contiguous();
    const float* values = unary.data_ptr<float>();
    CrfSample sample{photos_of(batch, options, scored).front(),
                     Raster<ClassSet>(scored.size(), scored.size()),
                     {values, values + unary.numel()}};
    for (int row = 0; row < scored.size(); ++row)
      for (int col = 0; col < scored.size(); ++col)
        sample.allowed.at(col, row) =
            batch.allowed[static_cast<std::size_t>((row + scored.first) * options.crop_px + col + scored.first)];
    samples.push_back(std::move(sample));
  }
  return samples;
}

TensorFile Trainer::weights() const { return file_from_params(state_->graph, state_->result(), TensorType::f32); }

std::vector<float> balanced_class_weights(const std::vector<TrainingScene>& scenes, std::size_t classes) {
  constexpr float most = 8.0F;  // a class of a few pixels must not rule the training
  std::vector<double> share(classes, 0.0);
  for (const TrainingScene& scene : scenes) {
    std::vector<std::size_t> count(classes, 0);
    std::size_t known = 0;
    for (const ClassSet set : scene.allowed.data) {
      if (!std::has_single_bit(set)) continue;
      ++count[static_cast<std::size_t>(std::countr_zero(set))];
      ++known;
    }
    for (std::size_t c = 0; c < classes && known > 0; ++c)
      share[c] += scene.weight * static_cast<double>(count[c]) / static_cast<double>(known);
  }
  std::vector<double> present;
  for (const double s : share)
    if (s > 0.0) present.push_back(s);
  if (present.empty()) throw OptionError("balance_classes: no pixel has one known class");
  const double usual = median(std::move(present));
  std::vector<float> weights;
  weights.reserve(share.size());
  for (const double s : share)
    weights.push_back(s > 0.0 ? std::clamp(static_cast<float>(usual / s), 1.0F / most, most) : 1.0F);
  return weights;
}

ClassSet road_classes(const ClassTable& classes) {
  ClassSet roads = unknown_class;
  for (std::size_t label = 0; label < classes.classes.size(); ++label)
    if (classes.classes[label].role == Role::road) roads |= only(static_cast<int>(label));
  if (roads == unknown_class)
    throw OptionError(fmt::format("class table '{}' has no class of role road", classes.name));
  return roads;
}

MapClasses map_classes(const ClassTable& classes) {
  MapClasses on_map{.road = road_classes(classes)};
  for (std::size_t label = 0; label < classes.classes.size(); ++label)
    if (classes.classes[label].role == Role::maybe_road)
      on_map.maybe_road = static_cast<ClassSet>(on_map.maybe_road | only(static_cast<int>(label)));
  return on_map;
}

namespace {
/// The truth at the centres of a label grid's pixels.
std::vector<ClassSet> truth_on(const GridFrame& labels, const ValidationScene& scene) {
  if (labels == scene.photo.frame) return scene.allowed.data;
  std::vector<ClassSet> truth;
  truth.reserve(static_cast<std::size_t>(labels.width) * static_cast<std::size_t>(labels.height));
  for (int row = 0; row < labels.height; ++row) {
    for (int col = 0; col < labels.width; ++col) {
      const Vec2 p = scene.photo.frame.pixel_from_world(labels.center_of(col, row));
      const int x = static_cast<int>(std::floor(p.x)), y = static_cast<int>(std::floor(p.y));
      truth.push_back(scene.allowed.inside(x, y) ? scene.allowed.at(x, y) : unknown_class);
    }
  }
  return truth;
}

MapLines in_world(std::vector<RoadLine> lines, const GridFrame& frame) {
  for (RoadLine& line : lines) {
    for (Vec2& p : line.points) p = frame.world_from_pixel(p.x, p.y);
    line.half_width *= frame.gsd_m;
  }
  return MapLines(std::move(lines));
}

/// The map of a scene, or one as training draws it.
MapLines map_of(const ValidationScene& scene, const ClassTable& classes, double gsd_m, std::uint64_t seed) {
  if (scene.map) return in_world(*scene.map, scene.photo.frame);
  // Lines are disturbed in the pixels of the network.
  const GridFrame& frame = scene.photo.frame;
  const double scale = frame.gsd_m / gsd_m;
  const auto size = [&](int px) { return std::max(1, static_cast<int>(px * scale)); };
  Raster<ClassSet> truth(size(scene.allowed.width), size(scene.allowed.height));
  for (int row = 0; row < truth.height; ++row)
    for (int col = 0; col < truth.width; ++col)
      truth.at(col, row) = scene.allowed.at(std::min(static_cast<int>((col + 0.5) / scale), scene.allowed.width - 1),
                                            std::min(static_cast<int>((row + 0.5) / scale), scene.allowed.height - 1));
  std::vector<RoadLine> lines = draw_lines(truth, map_classes(classes), seed);
  for (RoadLine& line : lines) {
    for (Vec2& p : line.points) p = p * (1.0 / scale);
    line.half_width /= scale;
  }
  return in_world(std::move(lines), frame);
}
}  // namespace

std::map<std::string, HeldOutScore> measure_model(const SegmentModel& model, const std::vector<ValidationScene>& scenes,
                                                  int threads) {
  std::map<std::string, HeldOutScore> scores;
  const ClassSet roads = road_classes(model.classes);
  const auto measure = [&](const std::string& name, const ValidationScene& scene, const MapLines* map) {
    const SegmentResult result = segment_mosaic(scene.photo, model, {.threads = threads, .map = map, .crf = model.crf});
    HeldOutScore& score = scores.try_emplace(name, static_cast<int>(model.classes.classes.size())).first->second;
    const std::vector<std::uint8_t>& labels = result.labels.labels.data;
    const std::vector<ClassSet> truth = truth_on(result.labels.frame, scene);
    score.labels.add(labels, truth);
    std::vector<std::uint8_t> says_road(labels.size(), label_nodata);
    std::vector<ClassSet> may_be_road(labels.size(), unknown_class);
    for (std::size_t i = 0; i < labels.size(); ++i) {
      const bool said = labels[i] < max_classes && (roads & only(labels[i])) != 0;
      const bool may_be = (truth[i] & roads) != 0, must_be = may_be && (truth[i] & ~roads) == 0;
      if (labels[i] != label_nodata) says_road[i] = said ? 1 : 0;
      if (truth[i] != unknown_class) may_be_road[i] = must_be ? only(1) : may_be ? only(0) | only(1) : only(0);
      if (!said || truth[i] == unknown_class || may_be != must_be) continue;
      ++score.said_road;
      score.is_road += must_be;
      score.stated_road += result.road_probability.confidence.data[i] / 255.0;
    }
    score.roads.add(says_road, may_be_road);
  };
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const ValidationScene& scene = scenes[i];
    measure(scene.name, scene, nullptr);
    if (!model.sees_map) continue;
    const MapLines map = map_of(scene, model.classes, model.gsd_m, derive_seed(1, i));
    measure(scene.name + " with map", scene, &map);
  }
  return scores;
}

namespace {
/// One call of train_network.
class TrainingLoop {
 public:
  TrainingLoop(Trainer& trainer, const TrainOptions& options, const std::vector<TrainingScene>& scenes,
               const std::vector<ValidationScene>& validation, const TrainHooks& hooks, Monitor* monitor)
      : trainer_(trainer),
        options_(options),
        scenes_(scenes),
        validation_(validation),
        hooks_(hooks),
        monitor_(monitor) {}

  void run() {
    saved_at_s_ = seconds();
    while (trainer_.step() < options_.steps && !stop_early() && !cancelled()) {
      advance();
      const bool round = options_.validate_every > 0 && trainer_.step() % options_.validate_every == 0;
      if (round && trainer_.step() < options_.steps) {
        validate();
        save();
      } else if (seconds() - saved_at_s_ > checkpoint_seconds) {
        save();
        if (monitor_)
          monitor_->info(fmt::format("{}, step {} of {}: loss {:.4g}", trainer_.metadata().architecture,
                                     trainer_.step(), options_.steps, last_loss_));
      }
    }
    save();  // before a validation that a second signal may end
    if (cancelled()) return;
    validate();
    hooks_.checkpoint(trainer_);  // knows the best validation
  }

 private:
  static constexpr double checkpoint_seconds = 120.0;  // the most work that a kill may cost

  [[nodiscard]] double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }
  [[nodiscard]] bool cancelled() const { return monitor_ && monitor_->cancelled(); }
  [[nodiscard]] bool stop_early() const {
    return options_.early_stop_after > 0 && trainer_.best.validations_since >= options_.early_stop_after;
  }
  void save() {
    hooks_.checkpoint(trainer_);
    saved_at_s_ = seconds();
  }
  [[nodiscard]] TrainReport row(double learning_rate) const {
    return {.step = trainer_.step(),
            .learning_rate = learning_rate,
            .seconds = seconds(),
            .stage = trainer_.metadata().architecture};
  }

  /// One step, and its row of the log when one is due.
  void advance() {
    const double rate = trainer_.learning_rate();
    loss_sum_ += trainer_.advance(scenes_);
    ++loss_count_;
    if (trainer_.step() % report_every != 0) return;
    TrainReport report = row(rate);
    report.loss = last_loss_ = loss_sum_ / static_cast<double>(loss_count_);
    hooks_.report(report);
    loss_sum_ = 0.0, loss_count_ = 0;
    if (monitor_)
      monitor_->progress(static_cast<double>(trainer_.step()) / static_cast<double>(options_.steps), "train");
  }

  /// Measures the network as it stands, set by set and in the mean, and keeps the best. Not twice at one step: an early
  /// stop ends where it validated.
  void validate() {
    if (options_.validate_every < 0 || validation_.empty() || trainer_.step() == validated_step_) return;
    validated_step_ = trainer_.step();
    const SegmentModel model = load_model(rounded_as_stored(trainer_.model_file()), "network in training");
    double road_sum = 0.0, iou_sum = 0.0, accuracy_sum = 0.0;
    const auto scores = measure_model(model, validation_, options_.threads);
    const auto report = [&](const std::string& name, double road_iou, double mean_iou, double pixel_accuracy) {
      TrainReport of_set = row(trainer_.learning_rate());
      of_set.validation = name;
      of_set.road_iou = road_iou, of_set.mean_iou = mean_iou, of_set.pixel_accuracy = pixel_accuracy;
      hooks_.report(of_set);
    };
    for (const auto& [name, of_set] : scores) {
      const LabelScore& score = of_set.labels;
      report(name, of_set.roads.iou(1), score.mean_iou(), score.pixel_accuracy());
      road_sum += of_set.roads.iou(1), iou_sum += score.mean_iou(), accuracy_sum += score.pixel_accuracy();
    }
    const auto sets = static_cast<double>(scores.size());
    const double mean_iou = iou_sum / sets;
    report("mean", road_sum / sets, mean_iou, accuracy_sum / sets);
    if (monitor_)
      monitor_->info(fmt::format("{}, step {} of {}: held-out accuracy {:.4f}, mean IoU {:.4f}, road IoU {:.4f}",
                                 trainer_.metadata().architecture, trainer_.step(), options_.steps, accuracy_sum / sets,
                                 mean_iou, road_sum / sets));
    if (mean_iou > trainer_.best.mean_iou) {
      trainer_.best = {trainer_.step(), mean_iou, 0};
      if (hooks_.best) hooks_.best(trainer_);
    } else {
      ++trainer_.best.validations_since;
    }
  }

  Trainer& trainer_;
  const TrainOptions& options_;
  const std::vector<TrainingScene>& scenes_;
  const std::vector<ValidationScene>& validation_;
  const TrainHooks& hooks_;
  Monitor* monitor_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();  // for the log only
  double saved_at_s_ = 0.0, loss_sum_ = 0.0, last_loss_ = std::numeric_limits<double>::quiet_NaN();
  std::int64_t loss_count_ = 0, validated_step_ = -1;
};
}  // namespace

void train_network(Trainer& trainer, const TrainOptions& options, const std::vector<TrainingScene>& scenes,
                   const std::vector<ValidationScene>& validation, const TrainHooks& hooks, Monitor* monitor) {
  const ReuseTensorMemory reuse_memory;
  if (const auto setting = faster_blas(); setting && monitor)
    monitor->info(
        fmt::format("OpenBLAS does not know this CPU: with {} in the environment training is faster", *setting));
  TrainingLoop(trainer, options, scenes, validation, hooks, monitor).run();
}

}  // namespace orthodrive
