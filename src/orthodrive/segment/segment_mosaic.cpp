#include "orthodrive/segment/segment_mosaic.hpp"

#include <ATen/Parallel.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/parallel.hpp"
#include "orthodrive/segment/fcn.hpp"
#include "orthodrive/segment/ordered_delivery.hpp"
#include "orthodrive/segment/resample_photo.hpp"
#include "orthodrive/segment/reusing_allocator.hpp"
#include "orthodrive/segment/single_threaded_blas.hpp"

namespace orthodrive {
namespace {

/// How far around a core its probabilities are predicted so that the CRF's messages into the core are those of the whole
/// mosaic: mean field carries them over several widths of the kernels, ever weaker. The test compares with the whole image.
int crf_margin_px(const std::optional<CrfModel>& crf) {
  if (!crf) return 0;
  const double reach = std::max(crf->widths.theta_alpha_px, crf->widths.theta_gamma_px);
  return std::clamp(static_cast<int>(std::ceil(4.0 * reach)), 32, 256);
}

/// Windows whose largest layers take some 200 MB; at least as much core as margin would be wasteful to undercut.
int suitable_window_px(const InferenceNetwork& network, int margin_px) {
  constexpr double peak_bytes = 2.0e8;
  constexpr int least_core_px = 256;
  const int by_memory = static_cast<int>(std::sqrt(peak_bytes / peak_bytes_per_pixel(network.graph()))) / 16 * 16;
  return std::max(by_memory, 2 * margin_px + least_core_px);
}

/// The pixels a window decides: row by row, west to east.
std::vector<PixelBox> plan_cores(const GridFrame& frame, int core_px) {
  std::vector<PixelBox> cores;
  for (int row = 0; row < frame.height; row += core_px)
    for (int col = 0; col < frame.width; col += core_px)
      cores.push_back({col, row, std::min(core_px, frame.width - col), std::min(core_px, frame.height - row)});
  return cores;
}

struct Decision {
  Raster<std::uint8_t> labels, confidence;
  std::int64_t labelled_pixels = 0;
};

/// `box` is where the window and the probabilities lie, `core` the part of it to decide.
Decision decide(const PixelBox& core, const PixelBox& window_box, const PhotoWindow& window,
                const PixelBox& probability_box, const Raster<float>& probabilities) {
  Decision decision{Raster<std::uint8_t>(core.width, core.height, 1, label_nodata),
                    Raster<std::uint8_t>(core.width, core.height), 0};
  if (probabilities.empty()) return decision;
  const int window_left = static_cast<int>(core.col - window_box.col),
            window_top = static_cast<int>(core.row - window_box.row),
            left = static_cast<int>(core.col - probability_box.col),
            top = static_cast<int>(core.row - probability_box.row);
  for (int row = 0; row < core.height; ++row)
    for (int col = 0; col < core.width; ++col) {
      if (!window.valid.at(window_left + col, window_top + row)) continue;
      const float* p = &probabilities.at(left + col, top + row);
      const float* best = std::max_element(p, p + probabilities.channels);
      decision.labels.at(col, row) = static_cast<std::uint8_t>(best - p);
      decision.confidence.at(col, row) = static_cast<std::uint8_t>(std::lround(*best * 255.0F));
      ++decision.labelled_pixels;
    }
  return decision;
}

bool shows_photo(const PhotoWindow& window, const PixelBox& window_box, const PixelBox& core) {
  for (int row = 0; row < core.height; ++row) {
    const std::uint8_t* valid = &window.valid.at(static_cast<int>(core.col - window_box.col),
                                                 static_cast<int>(core.row - window_box.row) + row);
    if (std::memchr(valid, 1, static_cast<std::size_t>(core.width))) return true;
  }
  return false;
}

/// Probabilities of a box -> marginals of the CRF, in place. The photo's window may be larger.
void refine(const CrfModel& crf, const PhotoWindow& window, const PixelBox& window_box, const PixelBox& box,
            Raster<float>& probabilities) {
  constexpr float least_probability = 1e-9F;
  Raster<std::uint8_t> rgb(box.width, box.height, 3), valid(box.width, box.height);
  const int left = static_cast<int>(box.col - window_box.col), top = static_cast<int>(box.row - window_box.row);
  for (int row = 0; row < box.height; ++row) {
    std::memcpy(&rgb.at(0, row), &window.rgb.at(left, top + row), 3 * static_cast<std::size_t>(box.width));
    std::memcpy(&valid.at(0, row), &window.valid.at(left, top + row), static_cast<std::size_t>(box.width));
  }
  const DenseCrf dense({box.width, box.height, box.col, box.row, rgb.data.data(), valid.data.data()}, crf.widths);
  std::vector<float> unary(probabilities.data.size());
  for (std::size_t i = 0; i < unary.size(); ++i) unary[i] = -std::log(std::max(probabilities.data[i], least_probability));
  thread_local CrfWorkspace workspace;
  dense.infer(crf.parameters, unary, probabilities.data, &workspace);
}

Decision classify_core(const PhotoSource& photo, const InferenceNetwork& network, const std::optional<CrfModel>& crf,
                       const PixelBox& core) {
  const PixelBox predicted = core.grown(crf_margin_px(crf)), seen = predicted.grown(network.margin_px());
  const PhotoWindow window = photo.read(seen);
  if (!shows_photo(window, seen, core)) return decide(core, seen, window, predicted, {});
  Raster<float> probabilities(predicted.width, predicted.height, network.class_count());
  network.predict(window.rgb.data.data(), predicted, probabilities.data.data());
  if (crf) refine(*crf, window, seen, predicted, probabilities);
  return decide(core, seen, window, predicted, probabilities);
}

/// Runs ATen on one thread in every worker while it lives: we parallelise over windows, and sums inside a
/// convolution must not depend on the number of threads.
class SingleThreadedTorch {
 public:
  SingleThreadedTorch() : before_(at::get_num_threads()) { at::set_num_threads(1); }
  ~SingleThreadedTorch() { at::set_num_threads(before_); }
  SingleThreadedTorch(const SingleThreadedTorch&) = delete;
  SingleThreadedTorch& operator=(const SingleThreadedTorch&) = delete;

 private:
  int before_;
};

Findings find_oddities(const GridFrame& photo, const SegmentModel& model, std::int64_t labelled_pixels) {
  Findings findings;
  const Vec2 center = photo.world_from_pixel(0.5 * photo.width, 0.5 * photo.height);
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

GridFrame label_frame(const GridFrame& photo, const SegmentModel& model) { return resampled_frame(photo, model.gsd_m); }

SegmentSummary segment_mosaic(const PhotoSource& source, const SegmentModel& model, const LabelSink& sink,
                              const SegmentOptions& options, Monitor* monitor) {
  const int margin_px = model.network->margin_px() + crf_margin_px(options.crf);
  const int window_px = options.window_px == 0 ? suitable_window_px(*model.network, margin_px) : options.window_px;
  if (window_px <= 2 * margin_px)
    throw OptionError(fmt::format("window of {} px: the network needs {} px around what it decides, take more than {}",
                                  window_px, margin_px, 2 * margin_px));
  const PhotoSource photo = resample_source(source, model.gsd_m);
  const std::vector<PixelBox> cores = plan_cores(photo.frame, window_px - 2 * margin_px);
  SegmentSummary summary{.frame = photo.frame};
  if (options.crf && options.crf->parameters.classes != model.network->class_count()) {
    throw OptionError(fmt::format("the CRF has {} classes, the network {}: take the one trained with it",
                                  options.crf->parameters.classes, model.network->class_count()));
  }
  const SingleThreadedTorch single_threaded;
  const SingleThreadedBlas single_threaded_blas;
  const ReuseTensorMemory reuse_memory;
  // A window without photo takes no time: its worker may run ahead of the others by this many.
  const std::size_t ahead = 4 * static_cast<std::size_t>(worker_count(options.threads));
  OrderedDelivery<Decision> delivery(ahead, [&](std::size_t index, const Decision& decision) {
    summary.labelled_pixels += decision.labelled_pixels;
    sink(cores[index], decision.labels, decision.confidence);
  });
  const auto classify = [&](std::size_t index) {
    if (monitor && monitor->cancelled()) delivery.stop();
    if (!delivery.wait_for_room(index)) return;
    try {
      const SingleThreadedTorch single_threaded_worker;  // OpenMP keeps the number per thread
      delivery.hand_over(index, classify_core(photo, *model.network, options.crf, cores[index]));
    } catch (...) {
      delivery.stop();
      throw;
    }
  };
  parallel_for(cores.size(), options.threads, classify, [&](std::size_t done) {
    if (monitor) monitor->progress(static_cast<double>(done) / static_cast<double>(cores.size()), "segment");
  });
  if (monitor && monitor->cancelled()) throw Error("segment: cancelled");
  summary.findings = find_oddities(source.frame, model, summary.labelled_pixels);
  return summary;
}

SegmentResult segment_mosaic(const Photo& photo, const SegmentModel& model, const SegmentOptions& options,
                             Monitor* monitor) {
  const GridFrame frame = label_frame(photo.frame, model);
  SegmentResult result{
      .labels = {photo.crs, frame, Raster<std::uint8_t>(frame.width, frame.height, 1, label_nodata), model.classes},
      .confidence = {photo.crs, frame, Raster<std::uint8_t>(frame.width, frame.height)}};
  const auto keep = [](Raster<std::uint8_t>& whole, const PixelBox& box, const Raster<std::uint8_t>& part) {
    for (int row = 0; row < box.height; ++row)
      std::memcpy(&whole.at(static_cast<int>(box.col), static_cast<int>(box.row) + row), &part.at(0, row),
                  static_cast<std::size_t>(box.width));
  };
  const SegmentSummary summary = segment_mosaic(
      source_of(photo), model,
      [&](const PixelBox& box, const Raster<std::uint8_t>& labels, const Raster<std::uint8_t>& confidence) {
        keep(result.labels.labels, box, labels);
        keep(result.confidence.confidence, box, confidence);
      },
      options, monitor);
  result.findings = summary.findings;
  return result;
}

}  // namespace orthodrive
