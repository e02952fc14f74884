#include "orthodrive/segment/train_network.hpp"

#include <ATen/Parallel.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <numbers>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/parallel.hpp"
#include "orthodrive/core/random.hpp"
#include "orthodrive/segment/fcn.hpp"
#include "orthodrive/segment/segment_mosaic.hpp"

namespace orthodrive {
namespace {

constexpr double adam_beta1 = 0.9, adam_beta2 = 0.999, adam_eps = 1e-8;  // Kingma and Ba, 2015
constexpr std::int64_t report_every = 10;

double learning_rate_at(const TrainOptions& options, std::int64_t step) {
  const auto t = static_cast<double>(step);
  if (step < options.warmup_steps) return options.learning_rate * (t + 1.0) / static_cast<double>(options.warmup_steps);
  if (step < options.decay_from_step) return options.learning_rate;
  const double left = static_cast<double>(options.steps - step) /
                      static_cast<double>(std::max<std::int64_t>(1, options.steps - options.decay_from_step));
  return options.learning_rate * 0.5 * (1.0 - std::cos(std::numbers::pi * std::clamp(left, 0.0, 1.0)));
}

/// A tensor that learns, with its running moments.
struct Learned {
  std::string name;
  at::Tensor value, first_moment, second_moment;
  double rate_factor = 1.0;
  bool decays = false;
};

NamedTensor copy_of(const at::Tensor& tensor) {
  const at::Tensor flat = tensor.detach().contiguous();
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
};

Batch draw_batch(const std::vector<TrainingScene>& scenes, const TrainOptions& options, double gsd_m,
                 std::int64_t step) {
  const std::size_t pixels = static_cast<std::size_t>(options.crop_px) * static_cast<std::size_t>(options.crop_px);
  const auto count = static_cast<std::size_t>(options.batch);
  Batch batch{std::vector<std::uint8_t>(3 * pixels * count), std::vector<ClassSet>(pixels * count)};
  parallel_for(count, options.threads, [&](std::size_t i) {
    const std::uint64_t seed = derive_seed(derive_seed(options.seed, static_cast<std::uint64_t>(step)), i);
    const TrainingScene& scene = scenes[draw_scene(scenes, step, seed)];
    const Crop crop = draw_crop(scene, {.size_px = options.crop_px, .gsd_m = gsd_m}, derive_seed(seed, 1));
    std::memcpy(&batch.rgb[3 * pixels * i], crop.rgb.data.data(), 3 * pixels);
    std::memcpy(&batch.allowed[pixels * i], crop.allowed.data.data(), pixels);
  });
  return batch;
}

}  // namespace

struct Trainer::State {
  TrainOptions options;
  ModelMetadata metadata;
  FcnSpec spec;
  FcnParams params;
  std::vector<Learned> learned;
  std::int64_t step = 0;

  void collect_learned() {
    const std::vector<ConvSpec> convs = spec.all();
    for (std::size_t i = 0; i < convs.size(); ++i) {
      const double factor = convs[i].trunk ? options.trunk_rate_factor : 1.0;
      const auto add = [&](const std::string& name, at::Tensor& value, bool decays) {
        value.set_requires_grad(true);
        learned.push_back({name, value, at::zeros_like(value), at::zeros_like(value), factor, decays});
      };
      add(convs[i].conv, params[i].kernel, !convs[i].depthwise);
      if (params[i].bias.defined()) add(convs[i].conv + "/bias", params[i].bias, false);
      if (!params[i].gamma.defined()) continue;
      add(convs[i].norm + "/gamma", params[i].gamma, false);
      add(convs[i].norm + "/beta", params[i].beta, false);
    }
  }

  void update_weights(double rate) {
    const at::NoGradGuard no_grad;
    const auto t = static_cast<double>(step + 1);
    const double correction1 = 1.0 - std::pow(adam_beta1, t), correction2 = 1.0 - std::pow(adam_beta2, t);
    for (Learned& l : learned) {
      at::Tensor& gradient = l.value.mutable_grad();
      if (!gradient.defined()) continue;
      l.first_moment.mul_(adam_beta1).add_(gradient, 1.0 - adam_beta1);
      l.second_moment.mul_(adam_beta2).addcmul_(gradient, gradient, 1.0 - adam_beta2);
      if (l.decays) l.value.mul_(1.0 - rate * l.rate_factor * options.weight_decay);
      const at::Tensor scale = (l.second_moment / correction2).sqrt_().add_(adam_eps);
      l.value.addcdiv_(l.first_moment, scale, -rate * l.rate_factor / correction1);
      gradient = at::Tensor();
    }
  }
};

Trainer::Trainer(const TensorFile& trunk, const std::string& source, const ModelMetadata& metadata,
                 TrainOptions options)
    : state_(std::make_unique<State>()) {
  if (options.class_weights.size() != metadata.classes.classes.size() || options.class_weights.size() > 8) {
    throw OptionError(fmt::format("{} class weights for {} classes (at most 8): give one a class",
                                  options.class_weights.size(), metadata.classes.classes.size()));
  }
  if (options.crop_px % fcn_stride_px != 0)
    throw OptionError(fmt::format("crop of {} px: must be a multiple of {}", options.crop_px, fcn_stride_px));
  state_->options = std::move(options);
  state_->metadata = metadata;
  state_->metadata.architecture = FcnSpec::architecture;
  state_->spec = make_fcn_spec(static_cast<int>(metadata.classes.classes.size()));
  state_->params = params_from_file(state_->spec, trunk, source, {.trunk_only = true, .seed = state_->options.seed});
  state_->collect_learned();
}

Trainer::~Trainer() = default;
Trainer::Trainer(Trainer&&) noexcept = default;
Trainer& Trainer::operator=(Trainer&&) noexcept = default;

std::int64_t Trainer::step() const { return state_->step; }
double Trainer::learning_rate() const { return learning_rate_at(state_->options, state_->step); }

double Trainer::advance(const std::vector<TrainingScene>& scenes) {
  State& s = *state_;
  at::set_num_threads(worker_count(s.options.threads));
  const Batch batch = draw_batch(scenes, s.options, s.metadata.gsd_m, s.step);
  const at::Tensor image = image_tensor(batch.rgb.data(), s.options.batch, s.options.crop_px, s.options.crop_px);
  const bool live = s.step < s.options.freeze_norm_from_step;
  const at::Tensor half = forward(s.spec, s.params, image, {.update_batch_statistics = live});
  const at::Tensor scores = at::upsample_bilinear2d(half, {s.options.crop_px, s.options.crop_px}, false)
                                .contiguous(at::MemoryFormat::ChannelsLast);
  at::Tensor gradient = at::empty_like(scores.detach(), at::MemoryFormat::Preserve);
  const auto count = static_cast<std::size_t>(scores.numel());
  const double loss =
      allowed_class_loss({scores.data_ptr<float>(), count}, batch.allowed,
                         {s.options.class_weights, s.options.set_weight}, {gradient.data_ptr<float>(), count});
  if (!std::isfinite(loss)) throw Error(fmt::format("training diverged at step {}: lower the learning rate", s.step));
  scores.backward(gradient);
  s.update_weights(learning_rate());
  ++s.step;
  return loss;
}

TensorFile Trainer::checkpoint() const {
  TensorFile file = file_from_params(state_->spec, state_->params, TensorType::f32);
  file.metadata = format_model_metadata(state_->metadata);
  file.metadata["step"] = std::to_string(state_->step);
  for (const Learned& l : state_->learned) {
    file.tensors.emplace(l.name + "/first_moment", copy_of(l.first_moment));
    file.tensors.emplace(l.name + "/second_moment", copy_of(l.second_moment));
  }
  return file;
}

void Trainer::restore(const TensorFile& checkpoint, const std::string& source) {
  State& s = *state_;
  const auto step = checkpoint.metadata.find("step");
  if (step == checkpoint.metadata.end()) throw InputError(source, "is not a training checkpoint");
  s.params = params_from_file(s.spec, checkpoint, source);
  s.learned.clear();
  s.collect_learned();
  for (Learned& l : s.learned) {
    copy_into(l.first_moment, checkpoint, l.name + "/first_moment", source);
    copy_into(l.second_moment, checkpoint, l.name + "/second_moment", source);
  }
  s.step = std::stoll(step->second);
}

TensorFile Trainer::model_file() const {
  TensorFile file = file_from_params(state_->spec, state_->params, TensorType::f16);
  file.metadata = format_model_metadata(state_->metadata);
  file.metadata["step"] = std::to_string(state_->step);
  return file;
}

int road_label(const ClassTable& classes) {
  const auto road = std::find_if(classes.classes.begin(), classes.classes.end(),
                                 [](const ClassInfo& c) { return c.role == Role::road; });
  if (road == classes.classes.end())
    throw OptionError(fmt::format("class table '{}' has no class of role road", classes.name));
  return static_cast<int>(road - classes.classes.begin());
}

std::map<std::string, LabelScore> measure_model(const SegmentModel& model, const std::vector<ValidationScene>& scenes,
                                                int threads) {
  std::map<std::string, LabelScore> scores;
  for (const ValidationScene& scene : scenes) {
    const SegmentResult result = segment_mosaic(scene.photo, model, {.threads = threads});
    LabelScore& score = scores.try_emplace(scene.name, static_cast<int>(model.classes.classes.size())).first->second;
    score.add(result.labels.labels.data, scene.allowed.data);
  }
  return scores;
}

void train_network(Trainer& trainer, const TrainOptions& options, const std::vector<TrainingScene>& scenes,
                   const std::vector<ValidationScene>& validation, const TrainHooks& hooks, Monitor* monitor) {
  const auto start = std::chrono::steady_clock::now();  // for the log only
  const auto seconds = [&] { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(); };
  const auto validate = [&] {
    const SegmentModel model = load_model(format_safetensors(trainer.model_file()), "network in training");
    const int road = road_label(model.classes);
    for (const auto& [name, score] : measure_model(model, validation, options.threads)) {
      hooks.report({.step = trainer.step(),
                    .learning_rate = trainer.learning_rate(),
                    .seconds = seconds(),
                    .road_iou = score.iou(road),
                    .mean_iou = score.mean_iou(),
                    .pixel_accuracy = score.pixel_accuracy(),
                    .validation = name});
    }
  };

  double loss_sum = 0.0;
  std::int64_t loss_count = 0;
  while (trainer.step() < options.steps && !(monitor && monitor->cancelled())) {
    const double rate = trainer.learning_rate();
    loss_sum += trainer.advance(scenes);
    ++loss_count;
    if (trainer.step() % report_every == 0) {
      hooks.report({.step = trainer.step(),
                    .learning_rate = rate,
                    .loss = loss_sum / static_cast<double>(loss_count),
                    .seconds = seconds()});
      loss_sum = 0.0, loss_count = 0;
      if (monitor) monitor->progress(static_cast<double>(trainer.step()) / static_cast<double>(options.steps), "train");
    }
    if (options.validate_every > 0 && trainer.step() % options.validate_every == 0 && trainer.step() < options.steps) {
      hooks.checkpoint(trainer);
      validate();
    }
  }
  hooks.checkpoint(trainer);
  validate();
}

}  // namespace orthodrive
