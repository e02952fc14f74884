// SPDX-License-Identifier: Apache-2.0
// The pull towards the start: Li et al., Explicit inductive bias for transfer learning with convolutional networks
// (L2-SP), 2018; here decoupled from Adam's steps. What the map leaves open stays as the network had it: Li and Hoiem,
// Learning without forgetting, 2016.
#include "orthodrive/train/adapt_model.hpp"

#include <ATen/core/grad_mode.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <span>
#include <vector>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/parallel.hpp"
#include "orthodrive/core/random.hpp"
#include "orthodrive/nets/make_network.hpp"
#include "orthodrive/segment/resample_photo.hpp"
#include "orthodrive/segment/segment_mosaic.hpp"
#include "orthodrive/train/disturbed_map.hpp"
#include "orthodrive/train/padded_network.hpp"
#include "orthodrive/train/padded_parts.hpp"
#include "orthodrive/train/reusing_allocator.hpp"
#include "orthodrive/train/single_threaded_blas.hpp"
#include "orthodrive/train/single_threaded_torch.hpp"

namespace orthodrive {
namespace {

constexpr double pull_to_start = 10.0;  // share of the way back to the shipped weights in a step, times the rate
constexpr double adapt_beta1 = 0.9, adapt_beta2 = 0.999, adapt_eps = 1e-8;  // Kingma and Ba, 2015
constexpr float set_weight = 0.7F;  // of pixels with several allowed classes, as the shipped model was trained
constexpr double least_probability = 1e-4;
constexpr double alignment_weight = 1.0;  // of its squared change, over 2
constexpr double least_road = 0.01;       // share of a cell that is surely road, for it to count
constexpr int fold = 5;                   // every fifth cell is held back
constexpr std::size_t least_learned = 6, least_held_back = 2;

/// The network as it will be used: with its branch for the map where there is one. The trunk stands before the first
/// layer with weights that are neither the trunk's nor the map's.
struct AdaptedNetwork {
  NetworkGraph graph;
  std::size_t decoder = 0;
  ClassSet road = unknown_class;

  AdaptedNetwork(const SegmentModel& model, bool with_map, const std::string& source)
      : graph(make_network(with_map ? model.name : without_map(model.name),
                           static_cast<int>(model.classes.classes.size()))) {
    const auto first = std::ranges::find_if(graph.layers, [](const Layer& layer) {
      return !layer.kernel_tensor.empty() && !layer.pretrained && !layer.of_map;
    });
    decoder = static_cast<std::size_t>(first - graph.layers.begin());
    const bool trunk_first =
        std::all_of(first, graph.layers.end(), [](const Layer& layer) { return !layer.pretrained; });
    if (!trunk_first || graph.layers.front().norm_tensors.empty())
      throw OptionError(fmt::format("adapt: {} is a {}; only mobilenetv2 models adapt to a site", source, model.name));
    for (std::size_t c = 0; c < model.classes.classes.size(); ++c)
      if (model.classes.classes[c].role == Role::road) road |= only(static_cast<int>(c));
  }
  /// Of what the network gives: the scores of the classes, and what follows them.
  [[nodiscard]] at::Tensor classes_of(const at::Tensor& values) const { return values.narrow(1, 0, graph.class_count); }
  [[nodiscard]] at::Tensor alignment_of(const at::Tensor& values) const {
    return values.narrow(1, graph.class_count, values.size(1) - graph.class_count);
  }
};

/// A piece of the photo, and what the map says of it.
struct AdaptCell {
  Raster<std::uint8_t> rgb;
  Raster<std::uint8_t> map;  ///< as the network sees it, moved; none
  Raster<ClassSet> allowed;
  Raster<ClassSet> with_edges;  ///< MapEdges::sharp; of cells held back
};

// ---- which pieces of the photo

struct CellBoxes {
  std::vector<PixelBox> learned, held_back;
};

GridFrame frame_of(GridFrame frame, const PixelBox& box) {
  frame.first_col += static_cast<int>(box.col), frame.first_row += static_cast<int>(box.row);
  frame.width = box.width, frame.height = box.height;
  return frame;
}

/// Evenly over the rows of cells.
std::vector<PixelBox> spread(const std::vector<PixelBox>& boxes, int most) {
  const std::size_t count = std::min(boxes.size(), static_cast<std::size_t>(most));
  std::vector<PixelBox> chosen;
  chosen.reserve(count);
  for (std::size_t i = 0; i < count; ++i) chosen.push_back(boxes[i * boxes.size() / count]);
  return chosen;
}

/// Those that the map has roads in. Every fifth one of a row is held back, two further in the next row, so that they
/// stand apart.
CellBoxes choose_cells(const GridFrame& frame, const WeakLabels& labels, ClassSet road, const AdaptOptions& options) {
  const int columns = frame.width / options.cell_px, rows = frame.height / options.cell_px;
  std::vector<PixelBox> all;
  for (int row = 0; row < rows; ++row)
    for (int col = 0; col < columns; ++col)
      all.push_back({static_cast<std::int64_t>(col) * options.cell_px, static_cast<std::int64_t>(row) * options.cell_px,
                     options.cell_px, options.cell_px});
  std::vector<std::uint8_t> has_road(all.size());
  parallel_for(all.size(), options.threads, [&](std::size_t i) {
    const Raster<ClassSet> allowed = labels(frame_of(frame, all[i]), MapEdges::vague);
    const auto sure =
        std::ranges::count_if(allowed.data, [&](ClassSet set) { return set != unknown_class && (set & ~road) == 0; });
    has_road[i] = static_cast<double>(sure) >= least_road * static_cast<double>(allowed.data.size());
  });
  CellBoxes boxes;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const int col = static_cast<int>(i) % columns, row = static_cast<int>(i) / columns;
    if (has_road[i]) ((col + 2 * row) % fold == 0 ? boxes.held_back : boxes.learned).push_back(all[i]);
  }
  boxes.held_back = spread(boxes.held_back, options.most_cells / fold);
  boxes.learned = spread(boxes.learned, options.most_cells - options.most_cells / fold);
  return boxes;
}

/// The roads in reach of a frame, moved, as the network sees them. The labels are those of the map where it lies: a
/// network that copies what it sees is wrong beside a map that is elsewhere. All of it moves by more than maps err:
/// else the copy would still be nearer to the labels than the photo's road.
Raster<std::uint8_t> moved_map(const MapLines& map, const GridFrame& frame, std::uint64_t seed) {
  constexpr double most_moved_px = 80.0, least_px = 12.0, most_px = 20.0;
  const PixelBox box{0, 0, frame.width, frame.height};
  std::vector<RoadLine> moved = move_lines(map.near(frame, box, map_reach_px + most_moved_px), seed);
  Random random(derive_seed(seed, 1));
  const double to = random.uniform(0.0, 2.0 * std::numbers::pi), by_px = random.uniform(least_px, most_px);
  for (RoadLine& line : moved)
    for (Vec2& p : line.points) p = p + Vec2{std::cos(to), std::sin(to)} * by_px;
  return map_raster(moved, nearest_lines(moved, box));
}

enum class CellUse { learned, held_back };

/// Every other cell that is learned from has no map: what the network says by the photo alone is learned, too.
std::vector<AdaptCell> read_cells(const PhotoSource& photo, const WeakLabels& labels, const MapLines& map,
                                  const std::vector<PixelBox>& boxes, CellUse use, const AdaptOptions& options) {
  const std::uint64_t seed = derive_seed(options.seed, use == CellUse::learned ? 0x6d6170 : 0x6a6467);
  std::vector<AdaptCell> cells(boxes.size());
  parallel_for(boxes.size(), options.threads, [&](std::size_t i) {
    PhotoWindow window = photo.read(boxes[i]);
    AdaptCell& cell = cells[i];
    const GridFrame frame = frame_of(photo.frame, boxes[i]);
    cell.rgb = std::move(window.rgb);
    cell.allowed = labels(frame, MapEdges::vague);
    if (use == CellUse::held_back) cell.with_edges = labels(frame, MapEdges::sharp);
    if (!map.empty() && (use == CellUse::held_back || i % 2 == 0))
      cell.map = moved_map(map, frame, derive_seed(seed, i));
    for (std::size_t p = 0; p < window.valid.data.size(); ++p) {
      if (window.valid.data[p]) continue;
      cell.allowed.data[p] = unknown_class;
      if (!cell.with_edges.empty()) cell.with_edges.data[p] = unknown_class;
      std::fill_n(cell.rgb.data.begin() + static_cast<std::ptrdiff_t>(3 * p), 3, no_photo_value);
    }
  });
  return cells;
}

// ---- the network

enum class MapUse { seen, hidden };

InputTensors input_of(const AdaptedNetwork& network, const AdaptCell& cell, MapUse map) {
  const bool seen = map == MapUse::seen && !cell.map.empty();
  return input_tensors(network.graph, {cell.rgb.data.data(), seen ? cell.map.data.data() : nullptr}, 1, cell.rgb.width,
                       cell.rgb.height);
}

struct RoadCounts {
  double hit = 0, wrong = 0, missed = 0, rest = 0;

  void add(const RoadCounts& o) { hit += o.hit, wrong += o.wrong, missed += o.missed, rest += o.rest; }
  [[nodiscard]] double iou() const { return hit > 0.0 ? hit / (hit + wrong + missed) : 0.0; }
  /// Cohen, A coefficient of agreement for nominal scales, 1960.
  [[nodiscard]] double kappa() const {
    const double n = hit + wrong + missed + rest, said = hit + wrong, is = hit + missed;
    if (is <= 0.0 || is >= n) return 0.0;
    const double agreed = (hit + rest) / n, by_chance = (said * is + (n - said) * (n - is)) / (n * n);
    return (agreed - by_chance) / (1.0 - by_chance);
  }
};

/// Where the sets leave no choice between road and everything else.
RoadCounts count_road(const std::uint8_t* label, const Raster<ClassSet>& allowed, ClassSet road) {
  RoadCounts counts;
  for (const ClassSet set : allowed.data) {
    const bool said = (road >> *label++ & 1U) != 0, may = (set & road) != 0, must = may && (set & ~road) == 0;
    if (set == unknown_class || may != must) continue;
    (must ? (said ? counts.hit : counts.missed) : (said ? counts.wrong : counts.rest)) += 1;
  }
  return counts;
}

RoadAgreement measure(const AdaptedNetwork& network, const NetworkParams& params, std::span<const AdaptCell> cells,
                      MapUse map, int threads) {
  std::vector<RoadCounts> sure(cells.size()), all(cells.size());
  parallel_for(cells.size(), threads, [&](std::size_t i) {
    const SingleThreadedTorch one_thread;
    const at::NoGradGuard no_grad;
    NetworkParams own = params;
    const at::Tensor values = forward_padded(network.graph, own, input_of(network, cells[i], map), {}).values;
    const at::Tensor labels = network.classes_of(values).argmax(1).to(at::kByte).contiguous();
    sure[i] = count_road(labels.data_ptr<std::uint8_t>(), cells[i].allowed, network.road);
    all[i] = count_road(labels.data_ptr<std::uint8_t>(), cells[i].with_edges, network.road);
  });
  for (std::size_t i = 1; i < cells.size(); ++i) sure[0].add(sure[i]), all[0].add(all[i]);
  return {sure[0].iou(), sure[0].kappa(), all[0].kappa()};
}

/// Tensors of the decoder that learn. The branch for the map stays: it would learn to trust this map more than another.
std::vector<at::Tensor*> learned_of(const AdaptedNetwork& network, NetworkParams& params) {
  std::vector<at::Tensor*> learned;
  for (std::size_t l = network.decoder; l < params.size(); ++l) {
    if (network.graph.layers[l].of_map) continue;
    for (at::Tensor* tensor : {&params[l].kernel, &params[l].bias, &params[l].gamma, &params[l].beta})
      if (tensor->defined()) learned.push_back(tensor);
  }
  return learned;
}

/// Runs each cell of a batch with weights of its own, on one thread, and sums their gradients in order: the bytes do
/// not depend on the number of threads.
class DecoderTraining {
 public:
  DecoderTraining(const AdaptedNetwork& network, const NetworkParams& start, const AdaptOptions& options)
      : network_(network),
        options_(options),
        start_(start),
        params_(start),
        copies_(static_cast<std::size_t>(options.batch), start) {
    for (NetworkParams& copy : copies_) {
      leaves_.push_back(learned_of(network, copy));
      for (at::Tensor* leaf : leaves_.back()) *leaf = leaf->clone().set_requires_grad(true);
    }
    for (at::Tensor* value : learned_of(network, params_)) {
      *value = value->clone();
      learned_.push_back({*value, value->clone(), at::zeros_like(*value), at::zeros_like(*value)});
    }
  }

  void step(std::span<const AdaptCell> cells, std::int64_t step) {
    const auto batch = static_cast<std::size_t>(options_.batch);
    std::vector<const AdaptCell*> drawn;
    drawn.reserve(batch);
    for (std::size_t i = 0; i < batch; ++i)
      drawn.push_back(&cells[draw(cells.size(), static_cast<std::size_t>(step) * batch + i)]);
    const at::Tensor weights = weights_of(drawn);
    parallel_for(batch, options_.threads, [&](std::size_t i) {
      const SingleThreadedTorch one_thread;
      const std::vector<at::Tensor> features = run_trunk(*drawn[i]);
      const at::Tensor before = decode_as_shipped(features, *drawn[i]),
                       values = decode(copies_[i], features, *drawn[i]);
      values.backward(loss_gradient(values.detach(), before, *drawn[i], weights, static_cast<std::int64_t>(i)));
    });
    update(step);
  }

  [[nodiscard]] const NetworkParams& params() const { return params_; }

 private:
  struct Learned {
    at::Tensor value, start, first_moment, second_moment;
  };

  /// Every cell comes once before any comes again.
  [[nodiscard]] std::size_t draw(std::size_t count, std::size_t i) const {
    std::vector<std::size_t> order(count);
    std::iota(order.begin(), order.end(), std::size_t{0});
    Random random(derive_seed(options_.seed, i / count));
    for (std::size_t k = count; k > 1; --k) std::swap(order[k - 1], order[random.below(k)]);
    return order[i % count];
  }

  /// Once for each time that a cell is drawn: what the trunk gives of all cells would fill half a gigabyte.
  [[nodiscard]] std::vector<at::Tensor> run_trunk(const AdaptCell& cell) const {
    const at::NoGradGuard no_grad;
    NetworkParams start = start_;  // handles only
    return forward_padded_before(network_.graph, start, input_of(network_, cell, MapUse::seen), network_.decoder);
  }

  [[nodiscard]] at::Tensor decode(NetworkParams& params, const std::vector<at::Tensor>& features,
                                  const AdaptCell& cell) const {
    return forward_padded_from(network_.graph, params, features, network_.decoder, cell.rgb.width).values;
  }

  [[nodiscard]] at::Tensor decode_as_shipped(const std::vector<at::Tensor>& features, const AdaptCell& cell) const {
    const at::NoGradGuard no_grad;
    NetworkParams start = start_;
    return decode(start, features, cell);
  }

  /// 1 where a pixel may have a class, one after the other.
  [[nodiscard]] at::Tensor mask_of(const AdaptCell& cell) const {
    const Raster<ClassSet>& sets = cell.allowed;
    const at::Tensor allowed =
        at::from_blob(const_cast<ClassSet*>(sets.data.data()), {1, 1, sets.height, sets.width}, at::kLong);
    const at::Tensor bits = at::arange(network_.graph.class_count, at::kLong).view({1, -1, 1, 1});
    return at::bitwise_and(at::bitwise_right_shift(allowed, bits), 1).to(at::kFloat);
  }

  /// Of the pixels of a batch: cross entropy is over all of it, because a cell may have few roads.
  [[nodiscard]] at::Tensor weights_of(const std::vector<const AdaptCell*>& cells) const {
    std::vector<at::Tensor> counts;
    counts.reserve(cells.size());
    for (const AdaptCell* cell : cells) counts.push_back(mask_of(*cell).sum(1, true));
    const at::Tensor count = at::cat(counts, 0);
    at::Tensor weights = at::where(count == 1, at::ones_like(count), at::full_like(count, set_weight));
    weights.masked_fill_(count == 0, 0.0);
    return weights / weights.sum().clamp_min(1.0);
  }

  /// By what a cell gives. Where the map leaves a choice, the network as it was makes it: `before` is what that gives.
  /// So does it for the alignment, of which the map's place says nothing. `weights`: of the batch, of which this is
  /// cell `i`.
  [[nodiscard]] at::Tensor loss_gradient(const at::Tensor& given, const at::Tensor& before, const AdaptCell& cell,
                                         const at::Tensor& weights, std::int64_t i) const {
    const at::Tensor mask = mask_of(cell);
    const at::Tensor chosen = (at::softmax(network_.classes_of(before), 1) + least_probability) * mask;
    const at::Tensor target = chosen / chosen.sum(1, true).clamp_min(least_probability);
    const at::Tensor of_classes =
        (at::softmax(network_.classes_of(given).contiguous(), 1) - target) * weights.narrow(0, i, 1);
    const at::Tensor moved = network_.alignment_of(given) - network_.alignment_of(before);
    return at::cat({of_classes, moved * (alignment_weight / static_cast<double>(weights.numel()))}, 1);
  }

  [[nodiscard]] double rate_at(std::int64_t step) const {
    const double t = static_cast<double>(step), end = static_cast<double>(options_.steps),
                 warm = std::max(1.0, end / 20.0);
    if (t < warm) return options_.learning_rate * (t + 1.0) / warm;
    return options_.learning_rate * 0.5 * (1.0 + std::cos(std::numbers::pi * (t - warm) / (end - warm)));
  }

  void update(std::int64_t step) {
    const at::NoGradGuard no_grad;
    const double rate = rate_at(step), t = static_cast<double>(step + 1);
    const double correction1 = 1.0 - std::pow(adapt_beta1, t), correction2 = 1.0 - std::pow(adapt_beta2, t);
    for (std::size_t k = 0; k < learned_.size(); ++k) {
      Learned& l = learned_[k];
      at::Tensor gradient = leaves_[0][k]->grad();
      for (std::size_t i = 1; i < leaves_.size(); ++i) gradient = gradient + leaves_[i][k]->grad();
      l.first_moment.mul_(adapt_beta1).add_(gradient, 1.0 - adapt_beta1);
      l.second_moment.mul_(adapt_beta2).addcmul_(gradient, gradient, 1.0 - adapt_beta2);
      l.value.lerp_(l.start, std::min(1.0, rate * pull_to_start));
      l.value.addcdiv_(l.first_moment, (l.second_moment / correction2).sqrt_().add_(adapt_eps), -rate / correction1);
      for (const std::vector<at::Tensor*>& copy : leaves_) {
        copy[k]->mutable_grad() = at::Tensor();
        copy[k]->copy_(l.value);
      }
    }
  }

  const AdaptedNetwork& network_;
  AdaptOptions options_;
  NetworkParams start_, params_;
  std::vector<NetworkParams> copies_;
  std::vector<std::vector<at::Tensor*>> leaves_;  ///< for each copy what learns
  std::vector<Learned> learned_;
};

std::string judge(const AdaptReport& report, const AdaptOptions& options) {
  if (report.alone.kappa < options.least_kappa)
    return fmt::format("the photo and the map do not agree (kappa {:.2f}, need {:.2f}): is it the map of this place?",
                       report.alone.kappa, options.least_kappa);
  if (report.after.kappa < report.before.kappa + options.least_gain)
    return fmt::format("no gain on the cells held back (kappa {:.3f} -> {:.3f})", report.before.kappa,
                       report.after.kappa);
  if (report.after.kappa_with_edges < report.before.kappa_with_edges)
    return fmt::format("roads are found better, but their edges worse (kappa with edges {:.3f} -> {:.3f})",
                       report.before.kappa_with_edges, report.after.kappa_with_edges);
  return {};
}

}  // namespace

void require_adaptable(const SegmentModel& model, const std::string& source) {
  static_cast<void>(AdaptedNetwork(model, false, source));
}

AdaptedModel adapt_model(const TensorFile& model, const std::string& source, const PhotoSource& photo,
                         const WeakLabels& labels, const MapLines& map, const AdaptOptions& options, Monitor* monitor) {
  const SegmentModel shipped = load_model(model, source);
  const AdaptedNetwork network(shipped, shipped.sees_map && !map.empty(), source);
  const PhotoSource scaled = resample_source(photo, network_frame(photo.frame, shipped));
  const CellBoxes boxes = choose_cells(scaled.frame, labels, network.road, options);
  AdaptedModel result{model, {}};
  AdaptReport& report = result.report;
  report.learned_cells = static_cast<int>(boxes.learned.size());
  report.held_back_cells = static_cast<int>(boxes.held_back.size());
  if (boxes.learned.size() < least_learned || boxes.held_back.size() < least_held_back) {
    report.why_not = fmt::format("{} cells with roads to learn from and {} to judge by, need {} and {}",
                                 report.learned_cells, report.held_back_cells, least_learned, least_held_back);
    return result;
  }
  const std::vector<AdaptCell> learned = read_cells(scaled, labels, map, boxes.learned, CellUse::learned, options),
                               held_back =
                                   read_cells(scaled, labels, map, boxes.held_back, CellUse::held_back, options);
  const SingleThreadedTorch one_thread;
  const SingleThreadedBlas one_thread_blas;
  const ReuseTensorMemory reuse_memory;

  const NetworkParams start = params_from_file(network.graph, model, source);
  report.before = measure(network, start, held_back, MapUse::seen, options.threads);
  DecoderTraining training(network, start, options);
  for (std::int64_t step = 0; step < options.steps; ++step) {
    if (monitor && monitor->cancelled()) throw Error("adapt: cancelled");
    training.step(learned, step);
    if (monitor) monitor->progress(static_cast<double>(step + 1) / static_cast<double>(options.steps), "adapt");
  }
  report.after = measure(network, training.params(), held_back, MapUse::seen, options.threads);
  report.alone = measure(network, training.params(), held_back, MapUse::hidden, options.threads);
  report.why_not = judge(report, options);
  report.kept = report.why_not.empty();
  if (report.kept)
    for (auto& [name, tensor] : file_from_params(network.graph, training.params(), TensorType::f32).tensors)
      result.file.tensors[name] = std::move(tensor);
  return result;
}

}  // namespace orthodrive
