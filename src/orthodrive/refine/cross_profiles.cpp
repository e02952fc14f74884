// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/refine/cross_profiles.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace orthodrive::refine {
namespace {

constexpr double step_over_gsd = 0.5;  // two cells a pixel
// A road is there where a strip of this width has this share of road. Traces of road all over a row say nothing: an
// edge would be put where trees, which hide roads, begin.
constexpr double road_near_m = 2.0, road_near_share = 0.4;

/// Bilinear between pixel centres; pixels outside the raster are 0.
struct Corners {
  std::size_t index[4];
  float weight[4];
};

/// `pixel` counts from the centre of the first one.
Corners corners_of(const GridFrame& frame, Vec2 pixel) {
  if (pixel.x >= 0.0 && pixel.y >= 0.0 && pixel.x < frame.width - 1.0 && pixel.y < frame.height - 1.0) {
    const int left = static_cast<int>(pixel.x), top = static_cast<int>(pixel.y);  // all four inside, as nearly always
    const auto u = static_cast<float>(pixel.x - left), v = static_cast<float>(pixel.y - top);
    const auto width = static_cast<std::size_t>(frame.width),
               first = static_cast<std::size_t>(top) * width + static_cast<std::size_t>(left);
    return {{first, first + 1, first + width, first + width + 1},
            {(1.0F - u) * (1.0F - v) / 255.0F, u * (1.0F - v) / 255.0F, (1.0F - u) * v / 255.0F, u * v / 255.0F}};
  }
  const double left = std::floor(pixel.x), top = std::floor(pixel.y);
  const auto u = static_cast<float>(pixel.x - left), v = static_cast<float>(pixel.y - top);
  const float weights[4] = {(1.0F - u) * (1.0F - v), u * (1.0F - v), (1.0F - u) * v, u * v};
  Corners corners{};
  for (int k = 0; k < 4; ++k) {
    const double col = left + (k & 1), row = top + (k >> 1);
    const bool inside = col >= 0.0 && row >= 0.0 && col < frame.width && row < frame.height;
    corners.index[k] =
        inside ? static_cast<std::size_t>(row) * static_cast<std::size_t>(frame.width) + static_cast<std::size_t>(col)
               : 0;
    corners.weight[k] = inside ? weights[k] / 255.0F : 0.0F;
  }
  return corners;
}

float value_at(const Raster<std::uint8_t>& raster, const Corners& corners) {
  float sum = 0.0F;
  for (int k = 0; k < 4; ++k) sum += corners.weight[k] * static_cast<float>(raster.data[corners.index[k]]);
  return sum;
}

}  // namespace

void CrossProfiles::look_again(std::size_t row) {
  const std::span<const float> costs = positive_row(row);
  const auto window = static_cast<std::ptrdiff_t>(std::max(1.0, road_near_m / step_m));
  double sum = 0.0, most = 0.0;
  for (std::ptrdiff_t k = 0; k < std::ssize(costs); ++k) {
    sum += costs[static_cast<std::size_t>(k)];
    if (k >= window) sum -= costs[static_cast<std::size_t>(k - window)];
    most = std::max(most, sum);
  }
  road_near[row] = most >= road_near_share * static_cast<double>(window);
  evidence[row] = road_near[row] ? chain_evidence[row] : EdgeEvidence{0.0, 0.0};
}

CrossProfiles sample_cross_profiles(const RoadChain& chain, const RoadEvidence& evidence, double half_m) {
  const GridFrame& frame = evidence.frame;
  CrossProfiles profiles;
  profiles.step_m = frame.gsd_m * step_over_gsd;
  profiles.cells = 2 * static_cast<int>(std::ceil(half_m / profiles.step_m));
  profiles.half_m = 0.5 * profiles.cells * profiles.step_m;
  const std::size_t rows = (chain.nodes.size() - 1) * rows_per_segment,
                    cells = static_cast<std::size_t>(profiles.cells);
  profiles.false_positive.assign(rows * cells, 0.0F);
  profiles.false_negative.assign(rows * cells, 0.0F);
  profiles.chain_evidence.assign(rows, {0.0, 0.0});
  profiles.evidence.assign(rows, {0.0, 0.0});
  profiles.road_near.assign(rows, false);

  constexpr int samples = 2;  // along each row's half segment: 0.5 m apart at a spacing of 2 m
  for (std::size_t row = 0; row < rows; ++row) {
    const ChainNode &a = chain.nodes[row / rows_per_segment], &b = chain.nodes[row / rows_per_segment + 1];
    float* const positive = &profiles.false_positive[row * cells];
    float* const negative = &profiles.false_negative[row * cells];
    for (int sample = 0; sample < samples; ++sample) {
      const double f = (static_cast<double>(row % rows_per_segment) + (sample + 0.5) / samples) / rows_per_segment;
      const Vec2 base = frame.pixel_from_world(a.base + (b.base - a.base) * f) - Vec2{0.5, 0.5};
      const Vec2 normal = normalized(a.normal + (b.normal - a.normal) * f);
      const Vec2 px_per_m{normal.x / frame.gsd_m, -normal.y / frame.gsd_m};
      for (std::size_t k = 0; k < cells; ++k) {
        const double t = (static_cast<double>(k) + 0.5) * profiles.step_m - profiles.half_m;
        const Corners corners = corners_of(frame, base + px_per_m * t);
        positive[k] += value_at(evidence.outside, corners) / samples;
        negative[k] += value_at(evidence.inside, corners) / samples;
      }
    }
    profiles.chain_evidence[row] = a.evidence;
    profiles.look_again(row);
  }
  return profiles;
}

StripCosts::StripCosts(const CrossProfiles& profiles, double strip_m)
    : steps_per_m_(1.0 / profiles.step_m), half_m_(profiles.half_m), knots_(profiles.cells + 1) {
  const int cells = std::max(1, static_cast<int>(std::lround(strip_m / profiles.step_m)));
  // The reference lets errors count more with their distance from the edge. From a half at the edge to one: an edge
  // that is off by little must still feel a force, as its least-squares form would otherwise be flat (fourth power)
  // there.
  std::vector<float> weight(static_cast<std::size_t>(cells));
  for (int j = 0; j < cells; ++j) weight[j] = static_cast<float>(0.5 + 0.5 * (j + 0.5) / cells);
  const float sum = std::accumulate(weight.begin(), weight.end(), 0.0F);
  for (float& w : weight) w /= sum;

  const std::size_t rows = profiles.evidence.size(), knots = static_cast<std::size_t>(knots_);
  for (auto& of_edge : knots_of_edge_) of_edge.resize(rows * knots);
  for (std::size_t row = 0; row < rows; ++row) {
    const auto positive = profiles.positive_row(row), negative = profiles.negative_row(row);
    const auto sum_of = [&](std::span<const float> costs, int knot, int direction) {
      float total = 0.0F;
      for (int j = 0; j < cells; ++j) {
        const int cell = direction > 0 ? knot + j : knot - 1 - j;
        if (cell >= 0 && cell < profiles.cells) total += weight[j] * costs[static_cast<std::size_t>(cell)];
      }
      return total;
    };
    for (int knot = 0; knot < knots_; ++knot) {
      const std::size_t i = row * knots + static_cast<std::size_t>(knot);
      knots_of_edge_[static_cast<int>(Edge::left)][i] = {sum_of(positive, knot, +1), sum_of(negative, knot, -1)};
      knots_of_edge_[static_cast<int>(Edge::right)][i] = {sum_of(positive, knot, -1), sum_of(negative, knot, +1)};
    }
  }
}

StripCosts::Values StripCosts::at(Edge edge, std::size_t row, double t_m) const {
  const double x = std::clamp((t_m + half_m_) * steps_per_m_, 1.0, knots_ - 2.0 - 1e-9);
  const int i = static_cast<int>(x);
  const double u = x - i;
  const Knot* const f =
      &knots_of_edge_[static_cast<int>(edge)][row * static_cast<std::size_t>(knots_) + static_cast<std::size_t>(i)];
  // Catmull-Rom: a continuous derivative, which Levenberg-Marquardt needs to converge.
  const auto value = [&](double f0, double f1, double f2, double f3) -> Value {
    const double c1 = 0.5 * (f2 - f0), c2 = f0 - 2.5 * f1 + 2.0 * f2 - 0.5 * f3, c3 = 0.5 * (f3 - f0) + 1.5 * (f1 - f2);
    return {f1 + u * (c1 + u * (c2 + u * c3)), (c1 + u * (2.0 * c2 + u * 3.0 * c3)) * steps_per_m_};
  };
  return {value(f[-1].context, f[0].context, f[1].context, f[2].context),
          value(f[-1].boundary, f[0].boundary, f[1].boundary, f[2].boundary)};
}

}  // namespace orthodrive::refine
