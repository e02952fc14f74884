// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/segment/segment_mosaic.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "orthodrive/core/byte_archive.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/core/parallel.hpp"
#include "orthodrive/core/stop.hpp"
#include "orthodrive/model/archived_fields.hpp"
#include "orthodrive/nets/class_probabilities.hpp"
#include "orthodrive/nets/inference_network.hpp"
#include "orthodrive/segment/more_looks.hpp"
#include "orthodrive/segment/ordered_delivery.hpp"
#include "orthodrive/segment/photo_look.hpp"
#include "orthodrive/segment/resample_photo.hpp"

namespace orthodrive {
namespace {

constexpr double crf_margin_widths = 3.0;

/// How far around a core its probabilities are predicted so that the CRF's messages into the core are those of the
/// whole mosaic: mean field carries them over several widths of the kernels, ever weaker. The test compares with the
/// whole image.
int crf_margin_px(const std::optional<CrfModel>& crf) {
  if (!crf) return 0;
  const double reach = std::max(crf->widths.theta_alpha_px, crf->widths.theta_gamma_px);
  return std::clamp(static_cast<int>(std::ceil(crf_margin_widths * reach)), 32, 256);
}

/// A photo fine enough to tell is classified at the fine end of what the network knows, and gets labels twice as fine
/// where they are then hardly finer than the photo.
bool is_fine(const GridFrame& photo, const SegmentModel& model) { return photo.gsd_m <= 0.6 * model.gsd_m; }
double network_gsd(const GridFrame& photo, const SegmentModel& model) {
  return is_fine(photo, model) ? model.finest_gsd_m : model.gsd_m;
}
int label_factor(const GridFrame& photo, const SegmentModel& model) {
  return is_fine(photo, model) && 0.5 * model.finest_gsd_m >= 0.7 * photo.gsd_m ? 2 : 1;
}

PixelBox scaled(const PixelBox& box, int factor) {
  return {factor * box.col, factor * box.row, factor * box.width, factor * box.height};
}

/// Edge of the largest window that takes some 500 MB: the photo and the network's layers on it and its margins, scores
/// and what the CRF holds on the label pixels it predicts. Margins are computed twice, so that large windows are fast.
int suitable_window_px(const InferenceNetwork& network, const std::optional<CrfModel>& crf, int factor,
                       double finest_scale) {
  constexpr double most_bytes = 5.0e8, crf_bytes = 200.0;
  const double photo_bytes = 4.0, map_bytes = network.sees_map() ? map_raster_channels : 0.0;
  constexpr int step_px = 32, least_px = 256, most_px = 8192;
  const double score_bytes = static_cast<double>(sizeof(float)) * network.output_channels();
  const double label_bytes =
      factor * factor * (photo_bytes + score_bytes + (crf ? crf_bytes + 2.0 * score_bytes : 0.0));
  const auto bytes = [&](double px) {
    const double predicted = px + 2.0 * crf_margin_px(crf);
    const double looked_at = predicted / finest_scale + 2.0 * network.margin_px();
    return looked_at * looked_at * (photo_bytes + map_bytes + network.peak_bytes_per_pixel()) +
           predicted * predicted * label_bytes;
  };
  int window = least_px;
  while (window < most_px && bytes(window + step_px) <= most_bytes) window += step_px;
  return window;
}

/// The pixels a window decides: row by row, west to east.
std::vector<PixelBox> plan_cores(const GridFrame& frame, int core_px) {
  std::vector<PixelBox> cores;
  for (int row = 0; row < frame.height; row += core_px)
    for (int col = 0; col < frame.width; col += core_px)
      cores.push_back({col, row, std::min(core_px, frame.width - col), std::min(core_px, frame.height - row)});
  return cores;
}

/// What is found in a window.
struct Decision {
  LabelledPixels pixels;
  std::int64_t labelled_pixels = 0;
  PhotoLook look;
  std::vector<PlaceAlignment> alignments;  ///< one per place asked for in the window
};
template <typename Archive>
void fields(Archive& archive, Decision& d) {
  archive(d.pixels.labels, d.pixels.confidence, d.pixels.road_probability, d.labelled_pixels, d.look, d.alignments);
}

/// `core` is what to decide, `seen` where `valid` and `probabilities` lie, both in label pixels.
Decision decide(const PixelBox& core, const PixelBox& seen, const Raster<std::uint8_t>& valid,
                const Raster<float>& probabilities, const std::vector<std::size_t>& road_classes) {
  const Raster<std::uint8_t> nothing(core.width, core.height);
  Decision decision{{Raster<std::uint8_t>(core.width, core.height, 1, label_nodata), nothing, nothing}, 0, {}, {}};
  if (probabilities.empty()) return decision;
  const int left = static_cast<int>(core.col - seen.col), top = static_cast<int>(core.row - seen.row);
  const auto byte_of = [](float p) { return static_cast<std::uint8_t>(std::lround(std::min(p, 1.0F) * 255.0F)); };
  for (int row = 0; row < core.height; ++row)
    for (int col = 0; col < core.width; ++col) {
      if (!valid.at(left + col, top + row)) continue;
      const float* p = &probabilities.at(left + col, top + row);
      const float* best = std::max_element(p, p + probabilities.channels);
      float road = 0.0F;
      for (const std::size_t c : road_classes) road += p[c];
      decision.pixels.labels.at(col, row) = static_cast<std::uint8_t>(best - p);
      decision.pixels.confidence.at(col, row) = byte_of(*best);
      decision.pixels.road_probability.at(col, row) = byte_of(road);
      ++decision.labelled_pixels;
    }
  return decision;
}

std::vector<std::size_t> road_classes_of(const ClassTable& table) {
  std::vector<std::size_t> classes;
  for (std::size_t c = 0; c < table.classes.size(); ++c)
    if (table.classes[c].role == Role::road) classes.push_back(c);
  return classes;
}

bool shows_photo(const Raster<std::uint8_t>& valid, const PixelBox& seen, const PixelBox& core) {
  for (int row = 0; row < core.height; ++row) {
    const std::uint8_t* line =
        &valid.at(static_cast<int>(core.col - seen.col), static_cast<int>(core.row - seen.row) + row);
    if (std::memchr(line, 1, static_cast<std::size_t>(core.width))) return true;
  }
  return false;
}

/// The part of a window that lies in `box`.
PhotoWindow part_of(const PhotoWindow& window, const PixelBox& seen, const PixelBox& box) {
  PhotoWindow part{Raster<std::uint8_t>(box.width, box.height, 3), Raster<std::uint8_t>(box.width, box.height)};
  const int left = static_cast<int>(box.col - seen.col), top = static_cast<int>(box.row - seen.row);
  for (int row = 0; row < box.height; ++row) {
    std::memcpy(&part.rgb.at(0, row), &window.rgb.at(left, top + row), 3 * static_cast<std::size_t>(box.width));
    std::memcpy(&part.valid.at(0, row), &window.valid.at(left, top + row), static_cast<std::size_t>(box.width));
  }
  return part;
}

/// What windows use one after the other: pages that the system hands out anew cost as much as what is written to them.
struct Workspace {
  CellMemory network;
  Raster<float> scores;
  std::vector<float> unary;
  CrfWorkspace crf;
};
/// Those that no window uses now. Safe from several threads.
class Workspaces {
 public:
  std::unique_ptr<Workspace> take() {
    const std::lock_guard lock(mutex_);
    if (waiting_.empty()) return std::make_unique<Workspace>();
    std::unique_ptr<Workspace> workspace = std::move(waiting_.back());
    waiting_.pop_back();
    return workspace;
  }
  void give_back(std::unique_ptr<Workspace> workspace) {
    const std::lock_guard lock(mutex_);
    waiting_.push_back(std::move(workspace));
  }

 private:
  std::mutex mutex_;
  std::vector<std::unique_ptr<Workspace>> waiting_;
};

/// Scores of a box -> marginals of the CRF, in place. `factor`: label pixels along a pixel that the CRF's widths are
/// in.
void refine(const CrfModel& crf, const PhotoWindow& photo, const PixelBox& box, int factor, Workspace& workspace) {
  CrfWidths widths = crf.widths;
  widths.theta_alpha_px *= factor;
  widths.theta_gamma_px *= factor;
  const DenseCrf dense({box.width, box.height, box.col, box.row, photo.rgb.data.data(), photo.valid.data.data()},
                       widths);
  std::vector<float>& scores = workspace.scores.data;
  workspace.unary.resize(scores.size());  // -log p but for a constant a pixel, which cancels
  std::transform(scores.begin(), scores.end(), workspace.unary.begin(), std::negate<>());
  dense.infer(crf.parameters, workspace.unary, scores, &workspace.crf);
}

/// For each core the places in it.
std::vector<std::vector<std::size_t>> places_by_core(std::span<const Vec2> places, const GridFrame& frame, int core_px,
                                                     std::size_t cores) {
  std::vector<std::vector<std::size_t>> by_core(cores);
  const int columns = (frame.width + core_px - 1) / core_px;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Vec2 p = frame.pixel_from_world(places[i]);
    const int col = static_cast<int>(std::floor(p.x)), row = static_cast<int>(std::floor(p.y));
    if (col < 0 || row < 0 || col >= frame.width || row >= frame.height) continue;
    by_core[static_cast<std::size_t>(row / core_px * columns + col / core_px)].push_back(i);
  }
  return by_core;
}

/// The first channels of every pixel, in place.
void keep_channels(Raster<float>& raster, int channels) {
  if (raster.channels == channels) return;
  const auto kept = static_cast<std::size_t>(channels), all = static_cast<std::size_t>(raster.channels),
             pixels = raster.data.size() / all;
  for (std::size_t i = 0; i < pixels; ++i) std::copy_n(&raster.data[all * i], kept, &raster.data[kept * i]);
  raster.data.resize(kept * pixels);
  raster.channels = channels;
}

/// All that deciding a window needs. Borrows the model and the options' map and places.
class Mosaic {
 public:
  Mosaic(const PhotoSource& source, const SegmentModel& model, const SegmentOptions& options)
      : factor_(label_factor(source.frame, model)),
        with_map_(model.sees_map && options.map && !options.map->empty()),
        network_(model.sees_map && !with_map_ ? *model.without_map : *model.network),
        map_(options.map),
        places_(with_map_ ? options.places : std::span<const Vec2>{}),
        crf_(options.crf),
        road_classes_(road_classes_of(model.classes)),
        photo_(resample_source(source, network_gsd(source.frame, model))),
        label_frame_(label_frame(source.frame, model)) {
    if (is_fine(source.frame, model)) looks_ = MoreLooks(source, network_gsd(source.frame, model));
    const int window_px =
        options.window_px == 0 ? suitable_window_px(network_, crf_, factor_, looks_.finest_scale()) : options.window_px;
    if (window_px < 1) throw OptionError(fmt::format("window of {} px: take 1 or more", window_px));
    if (crf_ && crf_->parameters.classes != network_.class_count())
      throw OptionError(fmt::format("the CRF has {} classes, the network {}: take the one trained with it",
                                    crf_->parameters.classes, network_.class_count()));
    if (factor_ > 1) fine_ = resample_source(source, label_frame_);
    cores_ = plan_cores(photo_.frame, window_px);
    asked_ = places_by_core(places_, photo_.frame, window_px, cores_.size());
  }
  [[nodiscard]] std::size_t windows() const { return cores_.size(); }
  [[nodiscard]] std::size_t places() const { return places_.size(); }
  [[nodiscard]] PixelBox label_box(std::size_t window) const { return scaled(cores_[window], factor_); }
  /// The places in a window, in the order of its alignments.
  [[nodiscard]] const std::vector<std::size_t>& places_in(std::size_t window) const { return asked_[window]; }

  [[nodiscard]] Decision decide_window(std::size_t window) const;

 private:
  [[nodiscard]] std::vector<PlaceAlignment> alignments_in(std::size_t window, const Raster<float>& scores,
                                                          const Raster<std::uint8_t>& valid,
                                                          const PixelBox& fine_box) const;

  int factor_ = 1;  ///< label pixels along one of the network's
  bool with_map_ = false;
  const InferenceNetwork& network_;
  const MapLines* map_ = nullptr;
  std::span<const Vec2> places_;
  std::optional<CrfModel> crf_;
  std::vector<std::size_t> road_classes_;
  PhotoSource photo_;  ///< at the network's scale
  GridFrame label_frame_;
  std::optional<PhotoSource> fine_;  ///< where labels are finer, at theirs
  MoreLooks looks_;                  ///< of a photo fine enough
  std::vector<PixelBox> cores_;
  std::vector<std::vector<std::size_t>> asked_;
  mutable Workspaces workspaces_;
};

std::vector<PlaceAlignment> Mosaic::alignments_in(std::size_t window, const Raster<float>& scores,
                                                  const Raster<std::uint8_t>& valid, const PixelBox& fine_box) const {
  const GridFrame& frame = photo_.frame;
  std::vector<PlaceAlignment> alignments;
  for (const std::size_t i : asked_[window]) {
    const Vec2 p = frame.pixel_from_world(places_[i]);
    const Vec2 pixel{std::floor(factor_ * p.x), std::floor(factor_ * p.y)};
    const int col = static_cast<int>(pixel.x - static_cast<double>(fine_box.col)),
              row = static_cast<int>(pixel.y - static_cast<double>(fine_box.row));
    const Vec2 from_center = p - (pixel + Vec2{0.5, 0.5}) * (1.0 / factor_);
    alignments.push_back(valid.at(col, row)
                             ? place_alignment(&scores.at(col, row, network_.class_count()), from_center, frame.gsd_m)
                             : PlaceAlignment{});
  }
  return alignments;
}

Decision Mosaic::decide_window(std::size_t window) const {
  const PixelBox& core = cores_[window];
  const PixelBox predicted = intersection(core.grown(crf_margin_px(crf_)), pixels_of(photo_.frame)),
                 seen = predicted.grown(network_.margin_px()), inside = intersection(seen, pixels_of(photo_.frame));
  PhotoWindow photo = photo_.read(inside);
  const PixelBox fine_core = scaled(core, factor_), fine_box = scaled(predicted, factor_);
  const PhotoWindow fine = fine_ ? fine_->read(fine_box) : part_of(photo, inside, predicted);
  if (!shows_photo(fine.valid, fine_box, fine_core)) {
    Decision nothing = decide(fine_core, fine_box, fine.valid, {}, road_classes_);
    nothing.alignments.resize(asked_[window].size());
    return nothing;
  }
  std::unique_ptr<Workspace> workspace = workspaces_.take();
  Raster<float>& scores = workspace->scores;
  scores.width = fine_box.width, scores.height = fine_box.height, scores.channels = network_.output_channels();
  scores.data.resize(static_cast<std::size_t>(scores.width) * static_cast<std::size_t>(scores.height) *
                     static_cast<std::size_t>(scores.channels));
  network_.predict(network_window(network_, map_, photo_.frame, seen, std::move(photo.rgb)).input(), predicted, factor_,
                   scores.data.data(), workspace->network);
  std::vector<PlaceAlignment> alignments = alignments_in(window, scores, fine.valid, fine_box);
  keep_channels(scores, network_.class_count());
  looks_.average(network_, map_, label_frame_, fine_box, scores, workspace->network);
  if (crf_) {
    refine(*crf_, fine, fine_box, factor_, *workspace);
  } else {
    softmax_of_scores(scores.data.data(), scores.data.size() / static_cast<std::size_t>(scores.channels),
                      scores.channels);
  }
  Decision decision = decide(fine_core, fine_box, fine.valid, scores, road_classes_);
  decision.look = look_of(fine.rgb, fine.valid, static_cast<int>(fine_core.col - fine_box.col),
                          static_cast<int>(fine_core.row - fine_box.row), fine_core.width, fine_core.height);
  decision.alignments = std::move(alignments);
  workspaces_.give_back(std::move(workspace));
  return decision;
}

/// Of bytes that segment_windows() made.
Decision decision_of(const std::string& bytes, const Mosaic& mosaic, std::size_t window) {
  Decision decision;
  ByteReader reader(bytes, fmt::format("window {}", window));
  reader(decision);
  reader.finish();
  const PixelBox box = mosaic.label_box(window);
  for (const Raster<std::uint8_t>* raster :
       {&decision.pixels.labels, &decision.pixels.confidence, &decision.pixels.road_probability})
    if (raster->width != box.width || raster->height != box.height || raster->channels != 1 ||
        raster->data.size() != static_cast<std::size_t>(box.width) * static_cast<std::size_t>(box.height))
      throw InputError(fmt::format("window {}", window), "is a window of another photo; remove it and run again");
  if (decision.alignments.size() != mosaic.places_in(window).size())
    throw InputError(fmt::format("window {}", window), "is a window of another map; remove it and run again");
  return decision;
}

Findings find_oddities(const GridFrame& photo, const SegmentModel& model, std::int64_t labelled_pixels,
                       const PhotoLook& look) {
  const Vec2 center = photo.world_from_pixel(0.5 * photo.width, 0.5 * photo.height);
  Findings findings = judge_look(look, center);
  if (photo.gsd_m > 1.5 * model.gsd_m)
    findings.push_back(
        {Severity::warning, "segment.coarse_photo",
         fmt::format("the photo has {:.2f} m/px, the network was trained at {:.2f} m/px: expect ragged labels",
                     photo.gsd_m, model.gsd_m),
         center.x, center.y});
  if (labelled_pixels == 0)
    findings.push_back({Severity::warning, "segment.no_photo",
                        "the photo has no data anywhere (nodata, alpha or mask): no pixel got a label", center.x,
                        center.y});
  return findings;
}

}  // namespace

GridFrame network_frame(const GridFrame& photo, const SegmentModel& model) {
  return resampled_frame(photo, network_gsd(photo, model));
}

GridFrame label_frame(const GridFrame& photo, const SegmentModel& model) {
  GridFrame frame = network_frame(photo, model);
  const int factor = label_factor(photo, model);
  frame.gsd_m /= factor;
  frame.width *= factor;
  frame.height *= factor;
  return frame;
}

void segment_windows(const PhotoSource& photo, const SegmentModel& model, const NextItem& next,
                     const std::function<void(std::size_t, const std::string&)>& keep, const SegmentOptions& options,
                     Monitor* monitor) {
  const Mosaic mosaic(photo, model, options);
  const auto is_cancelled = [&] { return monitor && monitor->cancelled(); };
  const auto work = [&](std::size_t) {
    while (const std::optional<std::size_t> window = next(mosaic.windows())) {
      throw_if_stopped();
      if (is_cancelled()) return;
      ByteWriter writer;
      writer(mosaic.decide_window(*window));
      keep(*window, writer.take());
    }
  };
  parallel_for(static_cast<std::size_t>(worker_count(options.threads)), options.threads, work);
  if (is_cancelled()) throw Error("segment: cancelled");
}

SegmentSummary segment_mosaic(const PhotoSource& source, const SegmentModel& model, const LabelSink& sink,
                              const SegmentOptions& options, Monitor* monitor) {
  const Mosaic mosaic(source, model, options);
  SegmentSummary summary{.frame = label_frame(source.frame, model)};
  summary.alignments.resize(mosaic.places());
  // A window without photo takes no time: its worker may run ahead of the others by this many.
  const std::size_t ahead = 4 * static_cast<std::size_t>(worker_count(options.threads));
  PhotoLook look;
  OrderedDelivery<Decision> delivery(ahead, [&](std::size_t window, const Decision& decision) {
    look += decision.look;
    summary.labelled_pixels += decision.labelled_pixels;
    const std::vector<std::size_t>& places = mosaic.places_in(window);
    for (std::size_t i = 0; i < places.size(); ++i) summary.alignments[places[i]] = decision.alignments[i];
    sink(mosaic.label_box(window), decision.pixels);
  });
  const auto decide_window = [&](std::size_t window) {
    if (options.made)
      if (const std::optional<std::string> bytes = options.made(window)) return decision_of(*bytes, mosaic, window);
    return mosaic.decide_window(window);
  };
  const auto classify = [&](std::size_t window) {
    if (monitor && monitor->cancelled()) delivery.stop();
    if (!delivery.wait_for_room(window)) return;
    try {
      delivery.hand_over(window, decide_window(window));
    } catch (...) {
      delivery.stop();
      throw;
    }
  };
  parallel_for(mosaic.windows(), options.threads, classify, [&](std::size_t done) {
    if (monitor) monitor->progress(static_cast<double>(done) / static_cast<double>(mosaic.windows()), "segment");
  });
  if (monitor && monitor->cancelled()) throw Error("segment: cancelled");
  summary.findings = find_oddities(source.frame, model, summary.labelled_pixels, look);
  return summary;
}

SegmentResult segment_mosaic(const Photo& photo, const SegmentModel& model, const SegmentOptions& options,
                             Monitor* monitor) {
  const GridFrame frame = label_frame(photo.frame, model);
  SegmentResult result{
      .labels = {photo.crs, frame, Raster<std::uint8_t>(frame.width, frame.height, 1, label_nodata), model.classes},
      .confidence = {photo.crs, frame, Raster<std::uint8_t>(frame.width, frame.height)},
      .road_probability = {photo.crs, frame, Raster<std::uint8_t>(frame.width, frame.height)}};
  const auto keep = [](Raster<std::uint8_t>& whole, const PixelBox& box, const Raster<std::uint8_t>& part) {
    for (int row = 0; row < box.height; ++row)
      std::memcpy(&whole.at(static_cast<int>(box.col), static_cast<int>(box.row) + row), &part.at(0, row),
                  static_cast<std::size_t>(box.width));
  };
  const SegmentSummary summary = segment_mosaic(
      source_of(photo), model,
      [&](const PixelBox& box, const LabelledPixels& pixels) {
        keep(result.labels.labels, box, pixels.labels);
        keep(result.confidence.confidence, box, pixels.confidence);
        keep(result.road_probability.confidence, box, pixels.road_probability);
      },
      options, monitor);
  result.findings = summary.findings;
  return result;
}

}  // namespace orthodrive
