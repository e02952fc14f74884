// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/baselines/edge_distance.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "orthodrive/baselines/one_cv_thread.hpp"
#include "orthodrive/baselines/tile_grid.hpp"
#include "orthodrive/core/error.hpp"

namespace orthodrive {
namespace {

constexpr double canny_blur_m = 0.15;  // sigma of the Gaussian before Canny; at least 0.8 pixels

using namespace baselines;

constexpr double lower_over_upper = 0.5;
constexpr int hysteresis_px =
    16;  // of the margin of a tile, so that weak edges can hang on strong ones beyond its border

void check_distances(const EdgeDistanceOptions& options) {
  if (options.thresholds.empty() || !(options.cap_m > 0.0))
    throw OptionError("edge distance: needs at least one threshold and a positive cap");
}

}  // namespace

Raster<std::uint8_t> edge_distance(const Raster<std::uint8_t>& rgb, const Raster<std::uint8_t>& valid, double gsd_m,
                                   const EdgeDistanceOptions& options) {
  check_distances(options);
  const OneCvThread guard;
  Raster<std::uint8_t> result(rgb.width, rgb.height, 1, 255);
  if (rgb.empty()) return result;
  cv::Mat grey;
  cv::cvtColor(cv::Mat(rgb.height, rgb.width, CV_8UC3, const_cast<std::uint8_t*>(rgb.data.data())), grey,
               cv::COLOR_RGB2GRAY);
  cv::GaussianBlur(grey, grey, {}, std::max(0.8, canny_blur_m / gsd_m));
  cv::Mat hidden;  // pixels that cannot be edges: the border of nodata is none
  if (!valid.empty()) {
    const cv::Mat mask(valid.height, valid.width, CV_8UC1, const_cast<std::uint8_t*>(valid.data.data()));
    const int reach = 2 + static_cast<int>(std::ceil(3.0 * std::max(0.8, canny_blur_m / gsd_m)));
    cv::dilate(mask == 0, hidden, cv::getStructuringElement(cv::MORPH_RECT, {2 * reach + 1, 2 * reach + 1}));
  }

  const double cap_px = options.cap_m / gsd_m;
  cv::Mat sum(grey.size(), CV_32F, cv::Scalar(0.0));
  for (const double upper : options.thresholds) {
    cv::Mat edges, distance;
    cv::Canny(grey, edges, lower_over_upper * upper, upper, 3, true);
    if (!hidden.empty()) edges.setTo(0, hidden);
    if (cv::countNonZero(edges) == 0)
      distance = cv::Mat(grey.size(), CV_32F, cv::Scalar(cap_px));
    else
      cv::distanceTransform(edges == 0, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE);
    sum += cv::min(distance, cap_px);
  }
  const double scale = 255.0 / (cap_px * static_cast<double>(options.thresholds.size()));
  for (int y = 0; y < rgb.height; ++y)
    for (int x = 0; x < rgb.width; ++x)
      result.at(x, y) = static_cast<std::uint8_t>(std::lround(scale * sum.at<float>(y, x)));
  return result;
}

Raster<std::uint8_t> edge_distance(const PhotoSource& photo, const PixelBox& box, const EdgeDistanceOptions& options) {
  check_distances(options);
  Raster<std::uint8_t> result(box.width, box.height, 1, 255);
  const int margin = hysteresis_px + static_cast<int>(std::ceil(options.cap_m / photo.frame.gsd_m));
  for (const PixelBox& tile : tiles_of(box)) {
    const PixelBox core = intersection(tile, box), window = tile.grown(margin);
    if (intersection(tile, pixels_of(photo.frame)).empty()) continue;
    const PhotoWindow pixels = photo.read(window);
    const Raster<std::uint8_t> distance = edge_distance(pixels.rgb, pixels.valid, photo.frame.gsd_m, options);
    for (std::int64_t row = core.row; row < core.end_row(); ++row)
      std::copy_n(&distance.at(static_cast<int>(core.col - window.col), static_cast<int>(row - window.row)), core.width,
                  &result.at(static_cast<int>(core.col - box.col), static_cast<int>(row - box.row)));
  }
  return result;
}

}  // namespace orthodrive
