// SPDX-License-Identifier: Apache-2.0
#pragma once
// The dense CRF told slowly: a permutohedral lattice in a std::map, the O(n^2) Gaussian itself, and mean field over
// either, all in double. Truth for the tests of the fast one. Written from the papers' formulas and Kraehenbuehl's
// code.

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <numeric>
#include <vector>

#include "orthodrive/core/random.hpp"
#include "orthodrive/crf/dense_crf.hpp"

namespace orthodrive {

template <int D>
using Features = std::vector<std::array<double, D>>;

template <int D>
class ScalarLattice {
 public:
  explicit ScalarLattice(const Features<D>& points) {
    for (const auto& p : points) {
      std::array<double, D + 1> elevated{}, rest{};
      for (int f = 0; f < D; ++f) {
        const double scaled = p[f] * std::sqrt(2.0 / 3.0) * (D + 1) / std::sqrt((f + 1.0) * (f + 2.0));
        for (int i = 0; i <= f; ++i) elevated[i] += scaled;
        elevated[f + 1] -= (f + 1) * scaled;
      }
      std::array<int, D + 1> zero{}, rank{};
      int sum = 0;
      for (int i = 0; i <= D; ++i) {
        zero[i] = (D + 1) * static_cast<int>(std::nearbyint(elevated[i] / (D + 1)));
        sum += zero[i] / (D + 1);
      }
      for (int i = 0; i <= D; ++i) rest[i] = elevated[i] - zero[i];
      for (int i = 0; i <= D; ++i)
        for (int j = i + 1; j <= D; ++j) ++rank[rest[i] < rest[j] ? i : j];
      for (int i = 0; i <= D; ++i) {
        rank[i] += sum;
        const int move = rank[i] < 0 ? D + 1 : rank[i] > D ? -(D + 1) : 0;
        rank[i] += move, zero[i] += move, rest[i] = elevated[i] - zero[i];
      }
      std::array<double, D + 2> weight{};
      for (int i = 0; i <= D; ++i) {
        weight[D - rank[i]] += rest[i] / (D + 1);
        weight[D - rank[i] + 1] -= rest[i] / (D + 1);
      }
      weight[0] += 1.0 + weight[D + 1];
      Corners corners;
      for (int k = 0; k <= D; ++k) {
        std::array<int, D + 1> key;
        for (int i = 0; i <= D; ++i) key[i] = zero[i] + k - (rank[i] > D - k ? D + 1 : 0);
        corners.vertex[k] = vertices_.try_emplace(key, vertices_.size()).first->second;
        corners.weight[k] = weight[k];
      }
      points_.push_back(corners);
    }
    for (int axis = 0; axis <= D; ++axis) {
      neighbours_[axis].resize(vertices_.size(), {-1, -1});
      for (const auto& [key, vertex] : vertices_)
        for (const int side : {-1, 1}) {
          auto other = key;
          for (int i = 0; i <= D; ++i) other[i] += side * (i == axis ? -D : 1);
          const auto found = vertices_.find(other);
          if (found != vertices_.end()) neighbours_[axis][vertex][side > 0] = static_cast<long>(found->second);
        }
    }
  }

  [[nodiscard]] std::size_t vertices() const { return vertices_.size(); }

  [[nodiscard]] std::vector<double> filter(const std::vector<double>& values, bool transposed = false) const {
    std::vector<double> lattice(vertices_.size()), result(values.size());
    for (std::size_t p = 0; p < points_.size(); ++p)
      for (int k = 0; k <= D; ++k) lattice[points_[p].vertex[k]] += points_[p].weight[k] * values[p];
    for (int i = 0; i <= D; ++i) {
      const std::vector<double> old = lattice;
      for (std::size_t v = 0; v < old.size(); ++v)
        for (const long other : neighbours_[transposed ? D - i : i][v])
          if (other >= 0) lattice[v] += 0.5 * old[static_cast<std::size_t>(other)];
    }
    for (std::size_t p = 0; p < points_.size(); ++p)
      for (int k = 0; k <= D; ++k) result[p] += points_[p].weight[k] * lattice[points_[p].vertex[k]];
    return result;
  }

 private:
  struct Corners {
    std::array<std::size_t, D + 1> vertex;
    std::array<double, D + 1> weight;
  };
  std::map<std::array<int, D + 1>, std::size_t> vertices_;
  std::vector<Corners> points_;
  std::array<std::vector<std::array<long, 2>>, D + 1> neighbours_;
};

using Filter = std::function<std::vector<double>(const std::vector<double>&)>;

template <int D>
Filter gaussian_filter(const Features<D>& points) {
  std::vector<double> kernel;
  for (const auto& a : points)
    for (const auto& b : points) {
      double square = 0.0;
      for (int f = 0; f < D; ++f) square += (a[f] - b[f]) * (a[f] - b[f]);
      kernel.push_back(std::exp(-0.5 * square));
    }
  return [kernel](const std::vector<double>& values) {
    std::vector<double> result(values.size());
    for (std::size_t i = 0; i < values.size(); ++i)
      result[i] = std::inner_product(values.begin(), values.end(), &kernel[i * values.size()], 0.0);
    return result;
  };
}

/// F filter(F values) with F = 1 / sqrt(filter(1)).
inline Filter normalised(const Filter& filter, std::size_t points) {
  std::vector<double> factors = filter(std::vector<double>(points, 1.0));
  for (double& f : factors) f = 1.0 / std::sqrt(f);
  return [filter, factors](std::vector<double> values) {
    for (std::size_t i = 0; i < values.size(); ++i) values[i] *= factors[i];
    values = filter(values);
    for (std::size_t i = 0; i < values.size(); ++i) values[i] *= factors[i];
    return values;
  };
}

/// A photo to test with: cells of one colour each, noise, and a hard-to-see edge.
struct TestPhoto {
  int width, height;
  std::vector<std::uint8_t> rgb, valid;
  std::vector<int> labels;
  [[nodiscard]] CrfImage view(std::int64_t col = 0, std::int64_t row = 0) const {
    return {width, height, col, row, rgb.data(), valid.empty() ? nullptr : valid.data()};
  }
  [[nodiscard]] std::size_t pixels() const { return labels.size(); }
};

inline TestPhoto make_photo(int width, int height, int classes, std::uint64_t seed) {
  Random random(seed);
  TestPhoto photo{.width = width, .height = height};
  std::vector<std::array<double, 5>> cells;  // x, y, colour
  cells.reserve(2 * static_cast<std::size_t>(classes));
  for (int c = 0; c < 2 * classes; ++c)
    cells.push_back({random.uniform(0, width), random.uniform(0, height), random.uniform(30, 220),
                     random.uniform(30, 220), random.uniform(30, 220)});
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const auto distance = [&](const auto& c) { return std::hypot(c[0] - x, c[1] - y); };
      const auto nearest = std::min_element(cells.begin(), cells.end(),
                                            [&](const auto& a, const auto& b) { return distance(a) < distance(b); });
      for (int channel = 0; channel < 3; ++channel)
        photo.rgb.push_back(
            static_cast<std::uint8_t>(std::clamp((*nearest)[2 + channel] + 6.0 * random.normal(), 0.0, 255.0)));
      photo.labels.push_back(static_cast<int>(nearest - cells.begin()) % classes);
    }
  return photo;
}

/// -log p of a mediocre classifier: the true class is a little likelier on average.
inline std::vector<float> make_unary(const TestPhoto& photo, int classes, std::uint64_t seed) {
  Random random(seed);
  std::vector<float> unary;
  for (const int label : photo.labels) {
    std::vector<double> score(static_cast<std::size_t>(classes));
    for (int c = 0; c < classes; ++c) score[static_cast<std::size_t>(c)] = random.normal() + (c == label ? 1.5 : 0.0);
    double sum = 0.0;
    for (const double s : score) sum += std::exp(s);
    for (const double s : score) unary.push_back(static_cast<float>(std::log(sum) - s));
  }
  return unary;
}

/// Mean field in double over any two filters of the valid pixels.
struct ScalarCrf {
  std::size_t pixels;
  std::vector<std::size_t> valid;
  Filter appearance, smoothness;

  [[nodiscard]] static double row_of(const TestPhoto& photo, std::size_t pixel) {
    const std::size_t row = pixel / static_cast<std::size_t>(photo.width);
    return static_cast<double>(row);
  }
  [[nodiscard]] static Features<5> appearance_features(const TestPhoto& photo, const CrfWidths& widths, double col,
                                                       double row) {
    Features<5> features;
    for (std::size_t i = 0; i < photo.pixels(); ++i)
      if (photo.valid.empty() || photo.valid[i] != 0)
        features.push_back({(col + static_cast<double>(i % photo.width)) / widths.theta_alpha_px,
                            (row + row_of(photo, i)) / widths.theta_alpha_px, photo.rgb[3 * i] / widths.theta_beta,
                            photo.rgb[3 * i + 1] / widths.theta_beta, photo.rgb[3 * i + 2] / widths.theta_beta});
    return features;
  }
  [[nodiscard]] static Features<2> smoothness_features(const TestPhoto& photo, const CrfWidths& widths, double col,
                                                       double row) {
    Features<2> features;
    for (std::size_t i = 0; i < photo.pixels(); ++i)
      if (photo.valid.empty() || photo.valid[i] != 0)
        features.push_back({(col + static_cast<double>(i % photo.width)) / widths.theta_gamma_px,
                            (row + row_of(photo, i)) / widths.theta_gamma_px});
    return features;
  }

  /// `exact`: the Gaussians themselves, else the lattice.
  ScalarCrf(const TestPhoto& photo, const CrfWidths& widths, bool exact, double col = 0.0, double row = 0.0)
      : pixels(photo.pixels()) {
    for (std::size_t i = 0; i < pixels; ++i)
      if (photo.valid.empty() || photo.valid[i] != 0) valid.push_back(i);
    const Features<5> far = appearance_features(photo, widths, col, row);
    const Features<2> near = smoothness_features(photo, widths, col, row);
    const ScalarLattice<5> lattice5(exact ? Features<5>{} : far);
    const ScalarLattice<2> lattice2(exact ? Features<2>{} : near);
    appearance = exact ? gaussian_filter<5>(far) : [lattice5](const auto& values) { return lattice5.filter(values); };
    smoothness = exact ? gaussian_filter<2>(near) : [lattice2](const auto& values) { return lattice2.filter(values); };
    appearance = normalised(appearance, valid.size());
    smoothness = normalised(smoothness, valid.size());
  }

  [[nodiscard]] std::vector<double> infer(const CrfParameters& p, const std::vector<double>& unary) const {
    const auto classes = static_cast<std::size_t>(p.classes);
    std::vector<double> q(unary.size()), scores(unary.size());
    for (std::size_t i = 0; i < unary.size(); ++i) scores[i] = -unary[i];
    const auto softmax = [&] {
      for (std::size_t i = 0; i < pixels; ++i) {
        double sum = 0.0;
        const double top = *std::max_element(&scores[i * classes], &scores[i * classes] + classes);
        for (std::size_t c = 0; c < classes; ++c) sum += q[i * classes + c] = std::exp(scores[i * classes + c] - top);
        for (std::size_t c = 0; c < classes; ++c) q[i * classes + c] /= sum;
      }
    };
    softmax();
    for (int step = 0; step < p.iterations; ++step) {
      for (std::size_t i = 0; i < unary.size(); ++i) scores[i] = -unary[i];
      for (std::size_t c = 0; c < classes; ++c) {
        std::vector<double> of_class;
        of_class.reserve(valid.size());
        for (const std::size_t i : valid) of_class.push_back(q[i * classes + c]);
        const std::vector<double> far = appearance(of_class), near = smoothness(of_class);
        for (std::size_t v = 0; v < valid.size(); ++v)
          for (std::size_t r = 0; r < classes; ++r)
            scores[valid[v] * classes + r] -= static_cast<double>(p.compatibility[r * classes + c]) *
                                              (static_cast<double>(p.appearance_weight[c]) * far[v] +
                                               static_cast<double>(p.smoothness_weight[c]) * near[v]);
      }
      softmax();
    }
    return q;
  }
};

}  // namespace orthodrive
