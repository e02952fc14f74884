// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/evaluate/scenes/texture_position.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "orthodrive/core/median.hpp"

namespace orthodrive {
namespace {

constexpr double tile_m = 480.0;
constexpr int window_px = 48, windows_a_side = 4;
constexpr int samples_a_texel = 3;          // across: a texel is the mean over its square
constexpr double least_gradient = 4.0;      // of brightness a texel, root of the mean square, in the weaker direction
constexpr double least_counted = 0.5;       // of a window's texels
constexpr int whole_steps = 7, steps = 16;  // of Gauss and Newton: with all texels; in all
constexpr double found_px = 1e-3;           // the last step's length
constexpr int near_px = 2;                  // around texels that are not explained

struct Window {
  int col = 0, row = 0;  // of its north-western texel
};

/// Brightness of the photo on the texels of a window, moved by d texels (to the east and south), and on those around
/// it; row by row, window_px + 2 per side. Nothing where it shows nothing.
std::optional<std::vector<double>> photo_on(const SceneTile& tile, const Window& window, Vec2 d,
                                            const BrightnessAt& photo) {
  const double texel_m = tile_m / tile.texture_rgb.width;
  const Vec2 north_west{tile.origin.x - 0.5 * tile_m, tile.origin.y + 0.5 * tile_m};
  std::vector<double> values;
  for (int row = -1; row <= window_px; ++row) {
    for (int col = -1; col <= window_px; ++col) {
      double sum = 0.0;
      for (int j = 0; j < samples_a_texel; ++j) {
        for (int i = 0; i < samples_a_texel; ++i) {
          const Vec2 px{window.col + col + d.x + (i + 0.5) / samples_a_texel,
                        window.row + row + d.y + (j + 0.5) / samples_a_texel};
          const auto value = photo(north_west + Vec2{px.x, -px.y} * texel_m);
          if (!value) return std::nullopt;
          sum += *value;
        }
      }
      values.push_back(sum / (samples_a_texel * samples_a_texel));
    }
  }
  return values;
}

template <typename Visit>
void for_each_near(int i, int reach, const Visit& visit) {
  const int col = i % window_px, row = i / window_px;
  for (int r = std::max(0, row - reach); r <= std::min(window_px - 1, row + reach); ++r)
    for (int c = std::max(0, col - reach); c <= std::min(window_px - 1, col + reach); ++c)
      visit(static_cast<std::size_t>(r * window_px + c));
}

/// Texels of a window whose light the scene has not changed much. Where it lifts shadows places are brighter and none
/// are darker; where a picture is shifted as many are either, and all texels count.
std::vector<bool> same_light(const std::vector<double>& change) {
  constexpr double other_light = 3.0, sigmas = 3.0;
  constexpr int mean_px = 2, lift_px = 5;  // reach of the mean, which compression does not change; around lifted places
  std::vector<double> mean(change.size());
  int brighter = 0, darker = 0;
  for (int i = 0; i < window_px * window_px; ++i) {
    double& m = mean[static_cast<std::size_t>(i)];
    int count = 0;
    for_each_near(i, mean_px, [&](std::size_t k) { m += change[k], ++count; });
    m /= count;
    brighter += m > other_light ? 1 : 0, darker += m < -other_light ? 1 : 0;
  }
  std::vector<bool> same(change.size(), true);
  if (brighter - 2 * darker < sigmas * std::sqrt(brighter + darker)) return same;
  for (int i = 0; i < window_px * window_px; ++i)
    if (mean[static_cast<std::size_t>(i)] > other_light)
      for_each_near(i, lift_px, [&](std::size_t k) { same[k] = false; });
  return same;
}

/// Texels of a window that the others explain: no error is over four standard deviations (of the median) in or near
/// them. What the scene has changed, such as the light of shadows that it lifts, falls out.
std::vector<bool> explained(const std::vector<double>& errors) {
  std::vector<double> sizes;
  sizes.reserve(errors.size());
  for (const double e : errors) sizes.push_back(std::abs(e));
  constexpr double of_median = 1.4826, least_sigma = 1.0, most_sigmas = 4.0;
  const double most = most_sigmas * std::max(least_sigma, of_median * median(std::move(sizes)));
  std::vector<bool> result(errors.size(), true);
  for (int i = 0; i < window_px * window_px; ++i) {
    if (std::abs(errors[static_cast<std::size_t>(i)]) <= most) continue;
    for_each_near(i, near_px, [&](std::size_t k) { result[k] = false; });
  }
  return result;
}

/// A window as the tile's picture and as the photo show it.
struct Compared {
  const SceneTile& tile;
  const Window& window;
  std::vector<double> photo;  // as photo_on gives it

  [[nodiscard]] double drawn(int col, int row) const {
    double sum = 0.0;
    for (int channel = 0; channel < 3; ++channel)
      sum += tile.texture_rgb.at(window.col + col, window.row + row, channel);
    return sum / 3.0;
  }
  [[nodiscard]] double value(int col, int row) const {
    return photo[static_cast<std::size_t>((row + 1) * (window_px + 2) + col + 1)];
  }
};

std::vector<double> change_of_light(const Compared& w) {
  std::vector<double> change;
  change.reserve(std::size_t{window_px} * window_px);
  for (int row = 0; row < window_px; ++row)
    for (int col = 0; col < window_px; ++col) change.push_back(w.drawn(col, row) - w.value(col, row));
  return change;
}

using Normal = std::array<std::array<double, 5>, 4>;

/// Least squares for T - R = gain R + offset - g . d: T is drawn, R the photo, g its gradient.
Normal normal_equations(const Compared& w, const std::vector<bool>& counts) {
  Normal normal{};
  for (int row = 0; row < window_px; ++row) {
    for (int col = 0; col < window_px; ++col) {
      if (!counts[static_cast<std::size_t>(row * window_px + col)]) continue;
      const double r = w.value(col, row);
      const std::array<double, 4> terms = {-0.5 * (w.value(col + 1, row) - w.value(col - 1, row)),
                                           -0.5 * (w.value(col, row + 1) - w.value(col, row - 1)), r / 255.0, 1.0};
      const double left = w.drawn(col, row) - r;
      for (std::size_t i = 0; i < 4; ++i) {
        for (std::size_t k = 0; k < 4; ++k) normal[i][k] += terms[i] * terms[k];
        normal[i][4] += terms[i] * left;
      }
    }
  }
  return normal;
}

/// Whether the window shows enough to say where it lies.
bool shows_enough(const Normal& normal, const std::vector<bool>& counts) {
  const double a = normal[0][0], b = normal[0][1], c = normal[1][1];
  const double weaker = 0.5 * (a + c) - std::sqrt(0.25 * (a - c) * (a - c) + b * b);
  const auto counted = static_cast<double>(std::ranges::count(counts, true));
  return counted >= least_counted * window_px * window_px && weaker >= least_gradient * least_gradient * counted;
}

/// By Gauss' elimination; nothing where it is singular.
std::optional<std::array<double, 4>> solve(Normal normal) {
  for (std::size_t i = 0; i < 4; ++i) {
    if (!(normal[i][i] > 1e-9)) return std::nullopt;
    for (std::size_t k = i + 1; k < 4; ++k) {
      const double factor = normal[k][i] / normal[i][i];
      for (std::size_t m = i; m < 5; ++m) normal[k][m] -= factor * normal[i][m];
    }
  }
  std::array<double, 4> x{};
  for (std::size_t i = 4; i-- > 0;) {
    double rest = normal[i][4];
    for (std::size_t k = i + 1; k < 4; ++k) rest -= normal[i][k] * x[k];
    x[i] = rest / normal[i][i];
  }
  return x;
}

std::vector<double> errors_of(const Compared& w, const std::array<double, 4>& x) {
  std::vector<double> errors;
  errors.reserve(std::size_t{window_px} * window_px);
  for (int row = 0; row < window_px; ++row) {
    for (int col = 0; col < window_px; ++col) {
      const double r = w.value(col, row);
      errors.push_back(w.drawn(col, row) - r + 0.5 * x[0] * (w.value(col + 1, row) - w.value(col - 1, row)) +
                       0.5 * x[1] * (w.value(col, row + 1) - w.value(col, row - 1)) - x[2] * r / 255.0 - x[3]);
    }
  }
  return errors;
}

/// Where the tile's picture lies from the photo, in texels to the east and south. Nothing where a window shows too
/// little, or no shift is found.
std::optional<Vec2> shift_of(const SceneTile& tile, const Window& window, const BrightnessAt& photo) {
  Vec2 d;                                  // the picture at p shows what the photo has at p - d
  std::vector<bool> light_counts, counts;  // by texel
  for (int step = 0; step < steps; ++step) {
    auto values = photo_on(tile, window, d * -1.0, photo);
    if (!values) return std::nullopt;
    const Compared compared{tile, window, *std::move(values)};
    if (light_counts.empty()) light_counts = counts = same_light(change_of_light(compared));
    const Normal normal = normal_equations(compared, counts);
    if (!shows_enough(normal, counts)) return std::nullopt;
    const auto x = solve(normal);
    if (!x) return std::nullopt;
    const Vec2 moved{(*x)[0], (*x)[1]};
    d = d + moved;
    if (std::hypot(d.x, d.y) > 0.5 * window_px) return std::nullopt;
    const bool is_found = std::hypot(moved.x, moved.y) < found_px;
    if (is_found && step > whole_steps) return d;
    if (step < whole_steps && !is_found) continue;
    step = std::max(step, whole_steps);
    counts = explained(errors_of(compared, *x));
    for (std::size_t i = 0; i < counts.size(); ++i) counts[i] = counts[i] && light_counts[i];
  }
  return d;
}

double error_of_coordinates_px(const SceneTile& tile) {
  double worst = 0.0;
  for (const TriMesh& mesh : tile.meshes) {
    if (mesh.kind != MeshKind::terrain) continue;
    for (std::size_t i = 0; i < std::min(mesh.uv.size(), mesh.positions.size()); ++i) {
      const double u = static_cast<double>(mesh.positions[i][0]) / tile_m + 0.5,
                   v = 0.5 - static_cast<double>(mesh.positions[i][1]) / tile_m;
      worst = std::max(worst, tile.texture_rgb.width * std::hypot(static_cast<double>(mesh.uv[i][0]) - u,
                                                                  static_cast<double>(mesh.uv[i][1]) - v));
    }
  }
  return worst;
}

}  // namespace

TexturePosition texture_position(const SceneTile& tile, const BrightnessAt& photo) {
  TexturePosition position;
  const int size = tile.texture_rgb.width;
  if (tile.level != 0 || size < windows_a_side * (window_px + 2) || tile.texture_rgb.height != size) return position;
  const double of_coordinates = error_of_coordinates_px(tile);
  const double texel_m = tile_m / size;
  for (int k = 0; k < windows_a_side * windows_a_side; ++k) {
    const auto first = [&](int part) { return (2 * part + 1) * size / (2 * windows_a_side) - window_px / 2; };
    const Window window{first(k % windows_a_side), first(k / windows_a_side)};
    const auto shift = shift_of(tile, window, photo);
    if (!shift) continue;
    ++position.windows;
    const double error = std::hypot(shift->x, shift->y) + of_coordinates;
    if (error <= position.error_px) continue;
    position.error_px = error;
    position.at = Vec2{tile.origin.x - 0.5 * tile_m, tile.origin.y + 0.5 * tile_m} +
                  Vec2{window.col + 0.5 * window_px, -(window.row + 0.5 * window_px)} * texel_m;
  }
  return position;
}

}  // namespace orthodrive
