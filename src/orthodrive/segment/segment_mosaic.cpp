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
#include "orthodrive/segment/resample_photo.hpp"
#include "orthodrive/segment/reusing_allocator.hpp"

namespace orthodrive {
namespace {

/// The pixels a window decides.
struct Core {
  int col = 0, row = 0, width = 0, height = 0;
};

std::vector<Core> plan_cores(int width, int height, int core_px) {
  std::vector<Core> cores;
  for (int row = 0; row < height; row += core_px) {
    for (int col = 0; col < width; col += core_px) {
      cores.push_back({col, row, std::min(core_px, width - col), std::min(core_px, height - row)});
    }
  }
  return cores;
}

bool any_photo(const Photo& photo, const Core& core) {
  for (int row = core.row; row < core.row + core.height; ++row) {
    const std::uint8_t* valid = &photo.valid.at(core.col, row);
    if (std::memchr(valid, 1, static_cast<std::size_t>(core.width))) return true;
  }
  return false;
}

/// The core with its margin. Beyond the mosaic there is no photo, whatever window looks there.
Raster<std::uint8_t> cut_window(const Photo& photo, const Core& core, int margin_px) {
  Raster<std::uint8_t> window(core.width + 2 * margin_px, core.height + 2 * margin_px, 3, no_photo_value);
  const int west = core.col - margin_px, north = core.row - margin_px;
  const int begin = std::max(0, -west), end = std::min(window.width, photo.frame.width - west);
  for (int row = 0; row < window.height; ++row) {
    if (north + row < 0 || north + row >= photo.frame.height) continue;
    std::memcpy(&window.at(begin, row), &photo.rgb.at(west + begin, north + row),
                static_cast<std::size_t>(end - begin) * 3);
  }
  return window;
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

}  // namespace

SegmentResult segment_mosaic(const Photo& source, const SegmentModel& model, const SegmentOptions& options,
                             Monitor* monitor) {
  const int margin_px = model.network->margin_px();
  if (options.window_px <= 2 * margin_px) {
    throw OptionError(fmt::format("window of {} px: must be above {}, twice the margin of {}", options.window_px,
                                  2 * margin_px, model.name));
  }
  const Photo photo = resample_photo(source, model.gsd_m, options.threads);
  const GridFrame& frame = photo.frame;
  SegmentResult result;
  result.labels = {photo.crs, frame, Raster<std::uint8_t>(frame.width, frame.height, 1, label_nodata), model.classes};
  result.confidence = {photo.crs, frame, Raster<std::uint8_t>(frame.width, frame.height, 1, 0)};
  if (source.frame.gsd_m > 1.5 * model.gsd_m) {
    const Vec2 center = frame.world_from_pixel(0.5 * frame.width, 0.5 * frame.height);
    result.findings.push_back(
        {Severity::warning, "segment.coarse_photo",
         fmt::format("the photo has {:.2f} m/px, the network was trained at {:.2f} m/px: expect ragged labels",
                     source.frame.gsd_m, model.gsd_m),
         center.x, center.y});
  }

  const std::vector<Core> cores = plan_cores(frame.width, frame.height, options.window_px - 2 * margin_px);
  const SingleThreadedTorch single_threaded;
  const ReuseTensorMemory reuse_memory;
  const auto classify = [&](std::size_t index) {
    if (monitor && monitor->cancelled()) return;
    const Core& core = cores[index];
    if (!any_photo(photo, core)) return;
    const SingleThreadedTorch single_threaded_worker;  // OpenMP keeps the number per thread
    const Raster<std::uint8_t> window = cut_window(photo, core, margin_px);
    const int classes = model.network->class_count();
    Raster<float> probabilities(core.width, core.height, classes);
    model.network->predict(window.data.data(), {core.col, core.row, core.width, core.height}, probabilities.data.data());
    for (int row = 0; row < core.height; ++row) {
      for (int col = 0; col < core.width; ++col) {
        if (!photo.valid.at(core.col + col, core.row + row)) continue;
        const float* p = &probabilities.at(col, row);
        const float* best = std::max_element(p, p + classes);
        result.labels.labels.at(core.col + col, core.row + row) = static_cast<std::uint8_t>(best - p);
        result.confidence.confidence.at(core.col + col, core.row + row) =
            static_cast<std::uint8_t>(std::lround(*best * 255.0F));
      }
    }
  };
  parallel_for(cores.size(), options.threads, classify, [&](std::size_t done) {
    if (monitor) monitor->progress(static_cast<double>(done) / static_cast<double>(cores.size()), "segment");
  });
  if (monitor && monitor->cancelled()) throw Error("segment: cancelled");
  return result;
}

}  // namespace orthodrive
