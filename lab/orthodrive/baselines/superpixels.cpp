// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/baselines/superpixels.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <opencv2/ximgproc/slic.hpp>

#include "orthodrive/baselines/one_cv_thread.hpp"

namespace orthodrive {
namespace {

using namespace baselines;

constexpr int min_superpixel_px = 6;
constexpr int min_element_percent = 25;  // smaller pieces join a neighbour; OpenCV's default

/// Replaces invalid pixels by the mean of the valid ones, so that an edge of nodata is no texture.
cv::Mat filled(const Raster<std::uint8_t>& rgb, const Raster<std::uint8_t>& valid) {
  const cv::Mat view(rgb.height, rgb.width, CV_8UC3, const_cast<std::uint8_t*>(rgb.data.data()));
  cv::Mat image = view.clone();
  if (valid.empty()) return image;
  const cv::Mat mask(valid.height, valid.width, CV_8UC1, const_cast<std::uint8_t*>(valid.data.data()));
  image.setTo(cv::mean(view, mask), mask == 0);
  return image;
}

/// The quantities whose means over a superpixel are features or parts of them.
enum Channel { lightness, a, b, gradient, fine, coarse_mean, coarse_spread, coarse_gradient, greenness, channels };

/// Channels as float images. Lab is perceptual: equal distances look alike, and lightness is apart from hue, which
/// shadow leaves nearly alone. Asphalt is grey (a, b near 0), smooth (low gradient, low Laplacian) and so over several
/// metres; vegetation is green and rough; roofs are coloured or have strong straight edges close by.
std::array<cv::Mat, channels> make_channels(const cv::Mat& rgb, double gsd_m, double texture_m) {
  std::array<cv::Mat, channels> image;
  cv::Mat lab, as_float;
  cv::cvtColor(rgb, lab, cv::COLOR_RGB2Lab);
  lab.convertTo(as_float, CV_32F);
  for (int k = 0; k < 3; ++k) cv::extractChannel(as_float, image[lightness + k], k);
  cv::Mat dx, dy;
  cv::Scharr(image[lightness], dx, CV_32F, 1, 0, 1.0 / 32.0);
  cv::Scharr(image[lightness], dy, CV_32F, 0, 1, 1.0 / 32.0);
  cv::magnitude(dx, dy, image[gradient]);
  cv::Laplacian(image[lightness], image[fine], CV_32F);
  image[fine] = cv::abs(image[fine]);

  const int window_px = std::max(3, 2 * static_cast<int>(0.5 * texture_m / gsd_m) + 1);
  const cv::Size window(window_px, window_px);
  cv::Mat squares;
  cv::blur(image[lightness], image[coarse_mean], window);
  cv::sqrBoxFilter(image[lightness], squares, CV_32F, window);
  cv::Mat variance = squares - image[coarse_mean].mul(image[coarse_mean]);
  cv::sqrt(cv::max(variance, 0.0), image[coarse_spread]);
  cv::blur(image[gradient], image[coarse_gradient], window);

  image[greenness].create(rgb.size(), CV_32F);
  for (int y = 0; y < rgb.rows; ++y)
    for (int x = 0; x < rgb.cols; ++x) {
      const cv::Vec3b& c = rgb.at<cv::Vec3b>(y, x);
      image[greenness].at<float>(y, x) =
          static_cast<float>(2 * c[1] - c[0] - c[2]) / static_cast<float>(c[0] + c[1] + c[2] + 1);
    }
  return image;
}

Raster<std::int32_t> cluster(const cv::Mat& rgb, int size_px, const SuperpixelOptions& options, int& count) {
  Raster<std::int32_t> labels(rgb.cols, rgb.rows);
  count = 1;
  if (rgb.cols < 2 * size_px || rgb.rows < 2 * size_px) return labels;  // too small to cut
  cv::Mat lab;
  cv::cvtColor(rgb, lab, cv::COLOR_RGB2Lab);
  cv::GaussianBlur(lab, lab, {3, 3}, 0.0);  // as the reference implementation advises
  const auto slic =
      cv::ximgproc::createSuperpixelSLIC(lab, cv::ximgproc::SLIC, size_px, static_cast<float>(options.ruler));
  slic->iterate(options.iterations);
  slic->enforceLabelConnectivity(min_element_percent);
  cv::Mat found;
  slic->getLabels(found);
  count = slic->getNumberOfSuperpixels();
  for (int y = 0; y < rgb.rows; ++y) std::copy_n(found.ptr<int>(y), rgb.cols, &labels.at(0, y));
  return labels;
}

/// Sums over the valid pixels of one superpixel.
struct Sums {
  std::array<double, channels> sum{};
  std::array<double, 4> squares{};  // of lightness, a, b, gradient
  int count = 0;

  [[nodiscard]] double mean(int k) const { return sum[static_cast<std::size_t>(k)] / std::max(1, count); }
  [[nodiscard]] double spread(int k) const {
    const double m = mean(k);
    return std::sqrt(std::max(0.0, squares[static_cast<std::size_t>(k)] / std::max(1, count) - m * m));
  }
};

std::vector<Sums> sum_channels(const Superpixels& superpixels, const std::array<cv::Mat, channels>& channel,
                               const Raster<std::uint8_t>& valid) {
  std::vector<Sums> sums(static_cast<std::size_t>(superpixels.count));
  for (int y = 0; y < superpixels.labels.height; ++y)
    for (int x = 0; x < superpixels.labels.width; ++x) {
      if (!valid.empty() && valid.at(x, y) == 0) continue;
      Sums& s = sums[static_cast<std::size_t>(superpixels.labels.at(x, y))];
      ++s.count;
      for (int k = 0; k < channels; ++k) {
        const double value = channel[static_cast<std::size_t>(k)].at<float>(y, x);
        s.sum[static_cast<std::size_t>(k)] += value;
        if (k < 4) s.squares[static_cast<std::size_t>(k)] += value * value;
      }
    }
  return sums;
}

/// How a superpixel differs from its neighbours; each pair of pixels across a common border counts once.
struct Contrast {
  std::array<double, 3> sum{};  // neighbour - own, in L, a, b
  double distance = 0.0;        // length of the difference
  float lightest = 0.0F, darkest = 0.0F;
  int count = 0;

  void add(const Sums& own, const Sums& other) {
    if (own.count == 0 || other.count == 0) return;
    std::array<double, 3> d{};
    for (int k = 0; k < 3; ++k)
      sum[static_cast<std::size_t>(k)] += d[static_cast<std::size_t>(k)] = other.mean(k) - own.mean(k);
    distance += std::hypot(d[0], d[1], d[2]);
    lightest = std::max(lightest, static_cast<float>(d[0]));
    darkest = std::min(darkest, static_cast<float>(d[0]));
    ++count;
  }
};

std::vector<Contrast> contrasts_of(const Raster<std::int32_t>& labels, const std::vector<Sums>& sums) {
  std::vector<Contrast> contrasts(sums.size());
  for (int y = 0; y < labels.height; ++y)
    for (int x = 0; x < labels.width; ++x) {
      const auto own = static_cast<std::size_t>(labels.at(x, y));
      for (const auto [u, v] : {std::array{x + 1, y}, std::array{x, y + 1}}) {
        if (!labels.inside(u, v)) continue;
        const auto other = static_cast<std::size_t>(labels.at(u, v));
        if (own == other) continue;
        contrasts[own].add(sums[own], sums[other]);
        contrasts[other].add(sums[other], sums[own]);
      }
    }
  return contrasts;
}

std::array<double, superpixel_features> features_of(const Sums& s, const Contrast& c) {
  const double borders = std::max(1, c.count);
  return {// colour
          s.mean(lightness), s.mean(a), s.mean(b), s.mean(greenness),
          // its spread
          s.spread(lightness), s.spread(a), s.spread(b),
          // chroma
          std::hypot(s.mean(a) - 128.0, s.mean(b) - 128.0),
          // fine texture
          s.mean(gradient), s.spread(gradient), s.mean(fine),
          // texture over metres
          s.mean(coarse_mean), s.mean(coarse_spread), s.mean(coarse_gradient),
          // stands out from it
          s.mean(lightness) - s.mean(coarse_mean),
          // neighbours
          c.sum[0] / borders, c.sum[1] / borders, c.sum[2] / borders, c.distance / borders, c.lightest, c.darkest};
}

}  // namespace

int superpixel_px(const SuperpixelOptions& options, double gsd_m) {
  return std::max(min_superpixel_px, static_cast<int>(std::lround(options.size_m / gsd_m)));
}

Superpixels make_superpixels(const Raster<std::uint8_t>& rgb, const Raster<std::uint8_t>& valid, double gsd_m,
                             const SuperpixelOptions& options) {
  const OneCvThread guard;
  Superpixels result;
  if (rgb.empty()) return result;
  const cv::Mat image = filled(rgb, valid);
  result.labels = cluster(image, superpixel_px(options, gsd_m), options, result.count);
  const std::vector<Sums> sums = sum_channels(result, make_channels(image, gsd_m, options.texture_m), valid);
  const std::vector<Contrast> contrasts = contrasts_of(result.labels, sums);
  result.features.reserve(sums.size() * superpixel_features);
  for (std::size_t i = 0; i < sums.size(); ++i) {
    result.pixels.push_back(sums[i].count);
    for (const double value : features_of(sums[i], contrasts[i])) result.features.push_back(static_cast<float>(value));
  }
  return result;
}

}  // namespace orthodrive
