// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/look/surface_texture.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include "orthodrive/core/random.hpp"
#include "orthodrive/model/rasters/srgb.hpp"
#include "orthodrive/scene/look/facade_picture.hpp"
#include "orthodrive/scene/look/leaf_picture.hpp"

namespace orthodrive::scene {
namespace {

/// Cells repeat; places are at most a side of the texture off.
int wrapped(int i, int cells) { return i < 0 ? i + cells : i >= cells ? i - cells : i; }

double unit_hash(std::uint64_t seed, std::uint64_t part) {
  return static_cast<double>(derive_seed(seed, part) >> 11) * 0x1.0p-53;
}

/// The largest whole number that is not above `value`, which is of the size of an int.
int floor_of(double value) {
  const int truncated = static_cast<int>(value);
  return truncated - static_cast<int>(value < truncated);
}

/// Value noise on a torus of cells x cells: uniform values at the corners, smooth in between. Textures ask row by row:
/// what a row's places have in common is kept from one to the next, so each thread needs its own.
class ValueNoise {
 public:
  ValueNoise(int cells, std::uint64_t seed) : cells_(cells), values_(static_cast<std::size_t>(cells) * cells) {
    for (std::size_t i = 0; i < values_.size(); ++i) values_[i] = 2.0 * unit_hash(seed, i) - 1.0;
  }
  [[nodiscard]] double corner(int x, int y) const { return values_[index(x, y)]; }
  /// u and v in sides of the texture; between -1 and 1.
  [[nodiscard]] double at(double u, double v) const {
    if (v != row_.v) row_ = row_at(v);
    const double x = u * cells_;
    const int x0 = floor_of(x), left = wrapped(x0, cells_), right = wrapped(x0 + 1, cells_);
    const double wx = ease(x - x0);
    const double *above = values_.data() + row_.above, *below = values_.data() + row_.below;
    return between(between(above[left], above[right], wx), between(below[left], below[right], wx), row_.wy);
  }

 private:
  struct Row {
    double v, wy;
    std::size_t above, below;  // where the values of the rows of corners begin
  };
  [[nodiscard]] Row row_at(double v) const {
    const double y = v * cells_;
    const int y0 = floor_of(y);
    return {v, ease(y - y0), index(0, y0), index(0, y0 + 1)};
  }
  static double ease(double w) { return w * w * (3.0 - 2.0 * w); }
  static double between(double a, double b, double w) { return a + w * (b - a); }
  [[nodiscard]] std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(wrapped(y, cells_)) * static_cast<std::size_t>(cells_) +
           static_cast<std::size_t>(wrapped(x, cells_));
  }
  int cells_;
  std::vector<double> values_;
  mutable Row row_{std::numeric_limits<double>::quiet_NaN(), 0.0, 0, 0};
};

/// Sum of value noises, each of half the size and strength of the one before; between -1 and 1.
class Fractal {
 public:
  Fractal(int cells, int octaves, std::uint64_t seed) {
    for (int i = 0; i < octaves; ++i) octaves_.emplace_back(cells << i, seed + static_cast<std::uint64_t>(i));
  }
  [[nodiscard]] double at(double u, double v) const {
    double sum = 0.0, strength = 1.0, total = 0.0;
    for (const ValueNoise& octave : octaves_) {
      sum += strength * octave.at(u, v);
      total += strength;
      strength *= 0.5;
    }
    return sum / total;
  }

 private:
  std::vector<ValueNoise> octaves_;
};

/// What a place of the surface is: brightness and hue as relative differences, height in m, roughness.
struct Texel {
  double shade = 0.0, warmth = 0.0, height_m = 0.0, roughness = 0.9;
};

/// Rounded stones in a bed, one per cell at a random place (Worley, A Cellular Texture Basis Function, 1996).
class Stones {
 public:
  Stones(double size_m, double contrast, double height_m, std::uint64_t seed)
      : cells_(static_cast<int>(std::lround(surface_texture_m / size_m))), contrast_(contrast), height_m_(height_m) {
    stones_.resize(static_cast<std::size_t>(cells_) * static_cast<std::size_t>(cells_));
    for (std::size_t i = 0; i < stones_.size(); ++i)
      stones_[i] = {unit_hash(seed, 3 * i), unit_hash(seed, 3 * i + 1), unit_hash(seed, 3 * i + 2)};
  }
  [[nodiscard]] Texel at(double u, double v) const {
    const double x = u * cells_, y = v * cells_;
    const int x0 = floor_of(x), y0 = floor_of(y);
    double nearest = 16.0, second = 16.0, shade = 0.0;
    for (int cy = y0 - 1; cy <= y0 + 1; ++cy) {
      for (int cx = x0 - 1; cx <= x0 + 1; ++cx) {
        const Stone& stone = stones_[index(cx, cy)];
        const double dx = cx + stone.x - x, dy = cy + stone.y - y, d = dx * dx + dy * dy;
        if (d < nearest) {
          second = nearest, nearest = d, shade = stone.shade;
        } else {
          second = std::min(second, d);
        }
      }
    }
    const double edge = std::clamp((std::sqrt(second) - std::sqrt(nearest)) / 0.35, 0.0, 1.0);
    return {.shade = contrast_ * (2.0 * shade - 1.0) - 0.6 * contrast_ * (1.0 - edge),
            .warmth = 0.15 * contrast_ * (2.0 * shade - 1.0),
            .height_m = height_m_ * edge * (0.7 + 0.3 * shade)};
  }

 private:
  struct Stone {
    double x, y, shade;
  };
  [[nodiscard]] std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(wrapped(y, cells_)) * static_cast<std::size_t>(cells_) +
           static_cast<std::size_t>(wrapped(x, cells_));
  }
  int cells_;
  double contrast_, height_m_;
  std::vector<Stone> stones_;
};

using TexelAt = std::function<Texel(double u, double v)>;

TexelAt asphalt() {
  return [aggregate = Stones(0.012, 0.26, 0.0025, 11), patches = Fractal(8, 4, 21), gloss = Fractal(16, 3, 31)](
             double u, double v) {
    Texel texel = aggregate.at(u, v);
    texel.shade += 0.05 * patches.at(u, v);
    texel.roughness = 0.88 + 0.08 * gloss.at(u, v);
    return texel;
  };
}

/// Asphalt as traffic wears it: u from the left border of a lane to the right one, v against the driving direction.
/// Tyres polish two tracks dark, oil drips between them; joints at the borders are sealed in places; two cracks and a
/// patch.
TexelAt lane_asphalt() {
  return [below = asphalt(), wear = Fractal(8, 3, 141), wobble = Fractal(16, 3, 142)](double u, double v) {
    constexpr double repeats = 4.0;  // of the grain along the lane
    Texel texel = below(u, repeats * v - std::floor(repeats * v));
    const auto ridge = [](double off, double width) { return std::exp(-0.5 * (off / width) * (off / width)); };
    const double worn = wear.at(u, v), bent = wobble.at(u, v), bent_along = wobble.at(0.5, v);
    const double tracks = ridge(u - 0.26, 0.06) + ridge(u - 0.74, 0.06);
    texel.shade -= tracks * (0.09 + 0.04 * worn) + 0.05 * ridge(u - 0.5, 0.05) * (1.0 + worn);
    texel.roughness -= 0.12 * tracks;
    const double sealed = std::clamp(0.5 + 4.0 * bent_along, 0.0, 1.0);
    if (std::min(u, 1.0 - u) < 0.006) texel.shade -= 0.3 * sealed, texel.roughness -= 0.2 * sealed;
    const auto crack = [&](double off_m, double strength) {
      if (std::abs(off_m) < 0.012) texel.shade -= 0.35 * strength, texel.height_m -= 0.002 * strength;
    };
    constexpr double width_m = 3.5;
    const double fading = std::clamp(0.7 + 2.0 * worn, 0.0, 1.0);
    crack((v - 0.18 - 0.008 * wobble.at(u, 0.3)) * lane_texture_m, fading);
    if (v > 0.3 && v < 0.52) crack((u - 0.62 - 0.03 * bent_along) * width_m, fading);
    if (u > 0.08 && u < 0.52 && v > 0.66 && v < 0.78) {
      const double edge_m =
          std::min(std::min(u - 0.08, 0.52 - u) * width_m, std::min(v - 0.66, 0.78 - v) * lane_texture_m);
      texel.shade += edge_m < 0.025 ? -0.3 : -0.08 + 0.03 * bent;
    }
    return texel;
  };
}

TexelAt concrete_texels() {
  return [grain = Fractal(128, 3, 41), stains = Fractal(8, 5, 42)](double u, double v) {
    const double g = grain.at(u, v);
    return Texel{.shade = 0.07 * stains.at(u, v) + 0.06 * g, .warmth = 0.01, .height_m = 0.0008 * g, .roughness = 0.85};
  };
}

/// Rows of stones of a decimetre, each row moved by half a stone (running bond).
TexelAt setts() {
  constexpr int rows = 40;
  return [shades = ValueNoise(rows, 51), hues = ValueNoise(rows, 52), wobble = Fractal(64, 2, 53),
          grain = Fractal(256, 2, 54)](double u, double v) {
    const int row = static_cast<int>(std::floor(v * rows));
    const double x = u * rows + 0.5 * (row % 2), y = v * rows;
    const int column = static_cast<int>(std::floor(x));
    const double to_edge = 0.5 - std::max(std::abs(x - column - 0.5), std::abs(y - row - 0.5)) + 0.05 * wobble.at(u, v);
    const double stone = std::clamp((to_edge - 0.05) / 0.12, 0.0, 1.0);
    return Texel{.shade = stone * (0.16 * shades.corner(column, row) + 0.06 * grain.at(u, v)) - 0.45 * (1.0 - stone),
                 .warmth = 0.03 * hues.corner(column, row),
                 .height_m = 0.012 * stone * (2.0 - stone),
                 .roughness = 0.95 - 0.2 * stone};
  };
}

TexelAt gravel() {
  return [coarse = Stones(0.025, 0.32, 0.012, 61), grit = Stones(0.01, 0.2, 0.004, 62), patches = Fractal(4, 4, 63)](
             double u, double v) {
    Texel texel = coarse.at(u, v);
    const Texel fine = grit.at(u, v);
    texel.shade += 0.5 * fine.shade + 0.08 * patches.at(u, v);
    texel.height_m += fine.height_m;
    texel.roughness = 0.97;
    return texel;
  };
}

TexelAt bare_ground() {
  return [soil = Fractal(8, 7, 71), pebbles = Stones(0.03, 0.12, 0.006, 72)](double u, double v) {
    const double s = soil.at(u, v);
    const Texel stones = pebbles.at(u, v);
    return Texel{.shade = 0.3 * s + 0.5 * stones.shade,
                 .warmth = 0.05,
                 .height_m = stones.height_m + 0.02 * s,
                 .roughness = 0.98};
  };
}

/// Soil and low grass in tufts.
TexelAt verge() {
  return [tufts = Fractal(16, 3, 81), blades = Fractal(200, 2, 82)](double u, double v) {
    const double t = tufts.at(u, v), b = blades.at(u + 0.02 * t, v);
    return Texel{
        .shade = 0.22 * t + 0.4 * b, .warmth = -0.08 * t, .height_m = 0.015 * t + 0.012 * b, .roughness = 0.99};
  };
}

/// Paint on asphalt, worn in places.
TexelAt paint() {
  return [below = asphalt(), wear = Fractal(24, 5, 91)](double u, double v) {
    const Texel road = below(u, v);
    const double worn = std::max(0.0, wear.at(u, v) - 0.25);
    return Texel{.shade = 0.15 * road.shade - 0.5 * worn, .height_m = 0.5 * road.height_m, .roughness = 0.7};
  };
}

// ---- facades: u across, v down

bool is_between(double v, double low, double high) { return v >= low && v < high; }

Texel pane(double darker, double v) {
  return {.shade = -0.95 + darker + 0.12 * (0.7 - v), .warmth = -0.06, .height_m = -0.03, .roughness = 0.08};
}

/// A window in the middle of a bay and a storey (0..1 both); nothing beside it. `kind` tells windows apart.
std::optional<Texel> window(double x, double y, double kind) {
  const double across = std::abs(x - 0.5), wide = kind < 0.35 ? 0.15 : 0.20, top = 0.22, foot = 0.71;
  if (across < wide + 0.02 && is_between(y, foot, foot + 0.03))
    return Texel{.shade = 0.25, .height_m = 0.03, .roughness = 0.6};
  if (across >= wide || !is_between(y, top, foot)) return std::nullopt;
  const double rim = 0.022;
  const bool mullion = kind < 0.35 ? false : across < 0.5 * rim;
  const bool transom = kind > 0.7 && is_between(y, top + 0.14, top + 0.16);
  if (across > wide - rim || y < top + rim || y > foot - rim || mullion || transom)
    return Texel{.shade = 0.35, .height_m = -0.01, .roughness = 0.5};
  const double blind = kind * 7.0 - std::floor(kind * 7.0);  // what hangs behind the panes
  if (blind > 0.75 && y < top + 0.6 * (foot - top)) return pane(0.75, y);
  if (is_between(blind, 0.35, 0.75) && across > wide - 0.07 - 0.05 * blind) return pane(0.5, y);
  return pane(0.15 * blind, y);
}

/// A loggia: a slab, a parapet of panels, a dark room behind it with a door and a window.
Texel loggia(double x, double y, double kind) {
  const double across = std::abs(x - 0.5);
  if (across > 0.47) return {.shade = 0.05};
  if (y > 0.94 || y < 0.02) return {.shade = 0.2, .height_m = 0.03, .roughness = 0.8};
  if (y > 0.62)
    return {.shade = (kind < 0.5 ? 0.16 : -0.18) - 0.06 * (std::fmod(x * 12.0, 1.0) < 0.08 ? 1.0 : 0.0),
            .warmth = 0.06 * (kind - 0.5),
            .height_m = 0.03,
            .roughness = 0.7};
  if (y > 0.6) return {.shade = 0.1, .height_m = 0.03, .roughness = 0.5};
  if (is_between(x, 0.15, 0.42) || (is_between(x, 0.5, 0.85) && y < 0.55)) {
    const bool frame = x < 0.17 || is_between(x, 0.4, 0.42) || is_between(x, 0.5, 0.52) || x > 0.83 || y < 0.16;
    return frame ? Texel{.shade = -0.2, .height_m = -0.03, .roughness = 0.6} : pane(kind > 0.6 ? 0.3 : 0.0, y);
  }
  return {.shade = -0.5 - 0.25 * (0.6 - y), .height_m = -0.03};
}

/// Four storeys of four bays in plaster; with_balconies: every second bay has a loggia.
TexelAt facade(bool with_balconies) {
  return [with_balconies, kinds = ValueNoise(facade_bays, 103), plaster = Fractal(64, 4, 101),
          stains = Fractal(4, 4, 102)](double u, double v) {
    const double across = u * facade_bays, down = v * facade_bays;
    const int bay = static_cast<int>(across), storey = static_cast<int>(down);
    const double kind = 0.5 + 0.499 * kinds.corner(bay, storey), x = across - bay, y = down - storey;
    if (with_balconies && bay % 2 == 1) return loggia(x, y, kind);
    if (const auto glazed = window(x, y, kind)) return *glazed;
    const double p = plaster.at(u, v), joint = with_balconies && (x < 0.01 || y > 0.985) ? -0.15 : 0.0;
    return Texel{
        .shade = 0.05 * p + 0.05 * stains.at(u, v) + joint, .warmth = 0.01, .height_m = 0.002 * p, .roughness = 0.92};
  };
}

/// Sheets with ribs of 0.25 m, joined every 2 m.
TexelAt cladding() {
  constexpr double ribs = 16.0, rows = 2.0;
  return [dirt = Fractal(8, 4, 141), grain = Fractal(64, 2, 142)](double u, double v) {
    const double x = u * ribs - std::floor(u * ribs), y = v * rows - std::floor(v * rows);
    const double rib = std::clamp(4.0 * (0.35 - std::abs(x - 0.5)), 0.0, 1.0);
    const double joint = y < 0.006 ? 1.0 : 0.0;
    return Texel{.shade = 0.05 * rib - 0.12 * (x < 0.06 ? 1.0 : 0.0) - 0.2 * joint + 0.05 * dirt.at(u, v),
                 .height_m = 0.02 * rib + 0.0005 * grain.at(u, v),
                 .roughness = 0.55};
  };
}

/// What doors, gates and frames are: bright, because the mesh's colours are their paint.
Texel painted(double shade, double height_m = 0.0) {
  return {.shade = 0.55 + shade, .height_m = height_m, .roughness = 0.55};
}

Texel ribbon(double x, double y) {
  const bool frame = std::abs(x - 0.5) > 0.47 || y < 0.07 || y > 0.93;
  return frame ? painted(0.0) : pane(0.1 * (x > 0.5 ? 1.0 : 0.0), y);
}

Texel shop_front(double x, double y) {
  if (y < 0.17) return painted(y > 0.15 ? -0.4 : -0.1, 0.01);
  if (y > 0.88) return painted(-0.5);
  if (std::abs(x - 0.5) > 0.475) return painted(0.0, 0.01);
  if (is_between(y, 0.30, 0.315)) return painted(0.0, 0.01);
  return pane(0.25 * std::max(0.0, y - 0.5), y);
}

Texel garage_gate(double x, double y) {
  if (std::abs(x - 0.5) > 0.455 || y < 0.05) return painted(-0.35, 0.02);
  const double panel = y * 5.0 - std::floor(y * 5.0);
  return painted(panel < 0.06 ? -0.3 : 0.02 * panel, panel < 0.06 ? -0.01 : 0.0);
}

Texel hall_gate(double x, double y) {
  if (std::abs(x - 0.5) > 0.46 || y < 0.04) return painted(-0.4, 0.02);
  if (is_between(y, 0.42, 0.5) && std::abs(x - 0.5) < 0.38 && std::fmod(x * 8.0, 1.0) > 0.12) return pane(0.1, y);
  const double slat = y * 12.0 - std::floor(y * 12.0);
  return painted(slat < 0.1 ? -0.25 : 0.0, slat < 0.1 ? -0.01 : 0.0);
}

Texel house_door(double x, double y, bool has_pane_beside) {
  if (x < 0.06 || x > 0.94 || y < 0.05) return painted(0.05, 0.01);
  if (y > 0.96) return painted(-0.6);  // the step
  if (has_pane_beside && x > 0.66) return x < 0.70 ? painted(0.05, 0.01) : pane(0.1, y);
  const double middle = has_pane_beside ? 0.36 : 0.5, half = has_pane_beside ? 0.3 : 0.42;
  const double across = (x - middle) / half;
  if (is_between(y, 0.12, 0.42) && std::abs(across) < 0.45) return pane(0.1, y);
  if (is_between(y, 0.52, 0.56) && across > 0.7) return painted(-0.7, 0.01);
  const bool groove = is_between(y, 0.6, 0.61) || std::abs(std::abs(across) - 0.97) < 0.03;
  return painted(groove ? -0.4 : -0.12);
}

Texel entrance(double x, double y) {
  if (y < 0.12) return painted(-0.25, 0.03);  // the canopy
  if (std::abs(x - 0.5) > 0.46 || std::abs(x - 0.5) < 0.025 || y < 0.17 || y > 0.95 || is_between(y, 0.34, 0.36))
    return painted(0.0, 0.01);
  return pane(0.12, y);
}

Texel church_window(double x, double y) {
  const double across = std::abs(x - 0.5), arch = 0.28;  // of the height
  const double dy = y < arch ? (arch - y) / arch : 0.0, reach = std::hypot(across / 0.5, dy);
  if (reach > 1.0) return painted(-0.1);
  if (reach > 0.8 || y > 0.96) return painted(0.05, 0.02);
  const bool bars = across < 0.02 || std::fmod(y * 8.0, 1.0) < 0.08;
  return bars ? painted(-0.6) : pane(0.12, y);
}

/// The strips and cells of scene/look/facade_picture.
TexelAt openings() {
  return [grain = Fractal(64, 3, 151)](double u, double v) {
    const int strip = static_cast<int>(v / opening_strip);
    const double y = std::clamp(
        (v / opening_strip - strip - opening_rim / opening_strip) / (1.0 - 2.0 * opening_rim / opening_strip), 0.0,
        0.9999);
    const auto part = [&](double count) { return u * count - std::floor(u * count); };
    Texel texel;
    if (strip == 0) {
      texel = ribbon(part(8.0), y);
    } else if (strip == 1) {
      texel = shop_front(part(4.0), y);
    } else if (strip == 2) {
      texel = garage_gate(part(4.0), y);
    } else {
      const int cell = static_cast<int>(u * opening_cells);
      const double x = std::clamp((u * opening_cells - cell - 0.04) / 0.92, 0.0, 0.9999);
      texel = cell < 2    ? house_door(x, y, cell == 1)
              : cell == 2 ? entrance(x, y)
              : cell == 3 ? hall_gate(x, y)
              : cell == 4 ? church_window(x, y)
                          : painted(0.0);
    }
    texel.shade += 0.03 * grain.at(u, v);
    return texel;
  };
}

/// Rows of tiles of 0.33 m over each other, 0.25 m wide.
TexelAt roof_tiles() {
  constexpr int rows = 12, columns = 16;
  return [shades = ValueNoise(48, 111), dirt = Fractal(8, 5, 112)](double u, double v) {
    const double x = u * columns, y = v * rows;
    const int column = static_cast<int>(std::floor(x)), row = static_cast<int>(std::floor(y));
    const double across = std::abs(x - column - 0.5), down = y - row;
    const double edge = down > 0.93 || across > 0.46 ? 1.0 : 0.0;
    return Texel{.shade = 0.12 * shades.corner(column, row) + 0.1 * dirt.at(u, v) - 0.35 * edge,
                 .warmth = 0.02 * shades.corner(row, column),
                 .height_m = 0.012 * down + 0.02 * (1.0 - 4.0 * across * across),
                 .roughness = 0.85};
  };
}

/// Leaves over darker gaps.
TexelAt foliage() {
  return [leaves = Fractal(64, 3, 121), clumps = Fractal(8, 4, 122), hues = ValueNoise(32, 123)](double u, double v) {
    const double leaf = leaves.at(u, v), clump = clumps.at(u, v);
    const double gap = std::min(0.0, clump + 0.1);  // deep between the clumps it is dark
    return Texel{.shade = 0.5 * leaf + 0.25 * clump + 0.9 * gap,
                 .warmth = 0.08 * hues.at(u, v),
                 .height_m = 0.03 * leaf + 0.08 * clump,
                 .roughness = 0.95};
  };
}

/// Ripples of a decimetre and longer ones.
TexelAt water() {
  return [ripples = Fractal(24, 3, 131), waves = Fractal(6, 2, 132)](double u, double v) {
    const double r = ripples.at(u, v);
    return Texel{.shade = 0.06 * r, .height_m = 0.006 * r + 0.015 * waves.at(u, v), .roughness = 0.12};
  };
}

TexelAt texels_of(SurfaceMaterial material) {
  switch (material) {
    case SurfaceMaterial::concrete:
      return concrete_texels();
    case SurfaceMaterial::setts:
      return setts();
    case SurfaceMaterial::gravel:
      return gravel();
    case SurfaceMaterial::ground:
      return bare_ground();
    case SurfaceMaterial::verge:
      return verge();
    case SurfaceMaterial::paint:
      return paint();
    case SurfaceMaterial::facade:
      return facade(false);
    case SurfaceMaterial::balconies:
      return facade(true);
    case SurfaceMaterial::cladding:
      return cladding();
    case SurfaceMaterial::openings:
      return openings();
    case SurfaceMaterial::roof_tiles:
      return roof_tiles();
    case SurfaceMaterial::foliage:
      return foliage();
    case SurfaceMaterial::water:
      return water();
    case SurfaceMaterial::lane:
      return lane_asphalt();
    case SurfaceMaterial::photo:
    case SurfaceMaterial::leaves:
    case SurfaceMaterial::asphalt:
      break;
  }
  return asphalt();
}

std::uint8_t byte_of(double unit) {
  // NOLINTNEXTLINE(bugprone-incorrect-roundings): never negative, and asked for every pixel
  return static_cast<std::uint8_t>(255.0 * std::clamp(unit, 0.0, 1.0) + 0.5);
}

}  // namespace

SurfaceTexture make_surface_texture(SurfaceMaterial material, int size_px) {
  assert(material != SurfaceMaterial::photo && size_px >= 64);
  if (material == SurfaceMaterial::leaves) return {leaf_picture(size_px / 2), {}, {}};
  const TexelAt texel_at = texels_of(material);
  Raster<Texel> texels(size_px, size_px);
  double sum = 0.0;
  for (int row = 0; row < size_px; ++row) {
    for (int col = 0; col < size_px; ++col) {
      texels.at(col, row) = texel_at((col + 0.5) / size_px, (row + 0.5) / size_px);
      sum += texels.at(col, row).shade;
    }
  }
  const double mean = sum / (static_cast<double>(size_px) * size_px);
  SurfaceTexture texture{Raster<std::uint8_t>(size_px, size_px, 3), Raster<std::uint8_t>(size_px, size_px, 3),
                         Raster<std::uint8_t>(size_px, size_px, 3)};
  const double step_m = 2.0 * surface_texture_m / size_px;
  const double along_m = material == SurfaceMaterial::lane ? 2.0 * lane_texture_m / size_px : step_m;
  const auto height_m = [&](int col, int row) {
    return texels.at(wrapped(col, size_px), wrapped(row, size_px)).height_m;
  };
  for (int row = 0; row < size_px; ++row) {
    for (int col = 0; col < size_px; ++col) {
      const Texel& texel = texels.at(col, row);
      const double value = surface_texture_mean * (1.0 + texel.shade - mean);
      for (int channel = 0; channel < 3; ++channel) {
        const double hue = 1.0 + (1 - channel) * texel.warmth;
        texture.color.at(col, row, channel) = srgb_byte(value * hue);
      }
      const double slope_x = (height_m(col + 1, row) - height_m(col - 1, row)) / step_m;
      const double slope_y = (height_m(col, row - 1) - height_m(col, row + 1)) / along_m;
      const double n = 1.0 / std::sqrt(1.0 + slope_x * slope_x + slope_y * slope_y);
      texture.normal_rgb.at(col, row, 0) = byte_of(0.5 * (1.0 - slope_x * n));
      texture.normal_rgb.at(col, row, 1) = byte_of(0.5 * (1.0 - slope_y * n));
      texture.normal_rgb.at(col, row, 2) = byte_of(0.5 * (1.0 + n));
      texture.roughness.at(col, row, 1) = byte_of(texel.roughness);
    }
  }
  return texture;
}

}  // namespace orthodrive::scene
