// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/train/disturbed_map.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "orthodrive/core/median.hpp"
#include "orthodrive/core/random.hpp"

namespace orthodrive {
namespace {

constexpr double step_px = 2.0;  // between points of a disturbed line
constexpr std::array<std::array<int, 2>, 8> ring{
    {{0, -1}, {1, -1}, {1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}}};  // clockwise from the top

/// The eight neighbours, clockwise from the one above; beyond the raster 0.
std::array<std::uint8_t, 8> neighbours(const Raster<std::uint8_t>& mask, int col, int row) {
  std::array<std::uint8_t, 8> around{};
  for (std::size_t k = 0; k < 8; ++k) {
    const int x = col + ring[k][0], y = row + ring[k][1];
    around[k] = mask.inside(x, y) ? mask.at(x, y) : 0;
  }
  return around;
}

/// How often the ring goes from 0 to 1.
int crossings(const std::array<std::uint8_t, 8>& around) {
  int count = 0;
  for (std::size_t k = 0; k < 8; ++k) count += !around[k] && around[(k + 1) % 8];
  return count;
}

struct Cell {
  int col = 0, row = 0;
};

/// Thins in place; returns what is left.
std::vector<Cell> thin(Raster<std::uint8_t>& mask) {
  std::vector<Cell> left;
  for (int row = 0; row < mask.height; ++row)
    for (int col = 0; col < mask.width; ++col)
      if (mask.at(col, row)) left.push_back({col, row});
  std::vector<Cell> gone;
  for (bool changed = true; changed;) {
    changed = false;
    for (const bool second : {false, true}) {
      gone.clear();
      for (const Cell c : left) {
        const auto n = neighbours(mask, c.col, c.row);
        int count = 0;
        for (const std::uint8_t v : n) count += v;
        if (count < 2 || count > 6 || crossings(n) != 1) continue;
        const bool first_pair = second ? n[0] && n[2] && n[6] : n[0] && n[2] && n[4],
                   other_pair = second ? n[0] && n[4] && n[6] : n[2] && n[4] && n[6];
        if (!first_pair && !other_pair) gone.push_back(c);
      }
      for (const Cell c : gone) mask.at(c.col, c.row) = 0;
      changed = changed || !gone.empty();
      if (!gone.empty()) std::erase_if(left, [&](Cell c) { return !mask.at(c.col, c.row); });
    }
  }
  return left;
}

/// Per pixel the vector to the nearest pixel outside the mask, in two sweeps (Danielsson, Euclidean distance mapping,
/// 1980). Beyond the raster nothing is outside.
Raster<Cell> nearest_outside(const Raster<std::uint8_t>& mask) {
  constexpr int far = 1 << 14;
  Raster<Cell> to(mask.width, mask.height, 1, Cell{far, far});
  for (std::size_t i = 0; i < mask.data.size(); ++i)
    if (!mask.data[i]) to.data[i] = {0, 0};
  const auto square = [](Cell c) { return c.col * c.col + c.row * c.row; };
  const auto take = [&](int col, int row, int dx, int dy) {
    if (!to.inside(col + dx, row + dy)) return;
    const Cell other = to.at(col + dx, row + dy);
    if (other.col == far) return;
    const Cell through{other.col + dx, other.row + dy};
    if (to.at(col, row).col == far || square(through) < square(to.at(col, row))) to.at(col, row) = through;
  };
  for (int row = 0; row < mask.height; ++row) {
    for (int col = 0; col < mask.width; ++col) {
      take(col, row, -1, 0), take(col, row, -1, -1), take(col, row, 0, -1), take(col, row, 1, -1);
    }
    for (int col = mask.width - 1; col >= 0; --col) take(col, row, 1, 0);
  }
  for (int row = mask.height - 1; row >= 0; --row) {
    for (int col = mask.width - 1; col >= 0; --col) {
      take(col, row, 1, 0), take(col, row, 1, 1), take(col, row, 0, 1), take(col, row, -1, 1);
    }
    for (int col = 0; col < mask.width; ++col) take(col, row, -1, 0);
  }
  return to;
}

/// Chains of a thinned mask between junctions and ends, each with the junction cells that it meets.
struct Chain {
  std::vector<Cell> cells;
  bool meets_first = false, meets_last = false;
};

class Tracer {
 public:
  Tracer(const Raster<std::uint8_t>& thinned, const std::vector<Cell>& cells)
      : cells_(cells), state_(thinned.width, thinned.height) {
    for (const Cell c : cells) state_.at(c.col, c.row) = free;
    // With the cells around it: beside a junction arms touch each other at corners.
    for (const Cell c : cells) {
      if (crossings(neighbours(thinned, c.col, c.row)) < 3) continue;
      state_.at(c.col, c.row) = junction;
      for (const auto& [dx, dy] : ring)
        if (state_.inside(c.col + dx, c.row + dy) && state_.at(c.col + dx, c.row + dy) != none)
          state_.at(c.col + dx, c.row + dy) = junction;
    }
  }

  std::vector<Chain> run() {
    std::vector<Chain> chains;
    for (const bool ends_first : {true, false}) {  // rings have no end
      for (const Cell c : cells_) {
        if (state_.at(c.col, c.row) != free || (ends_first && count_near(c, free) > 1)) continue;
        chains.push_back(follow(c));
      }
    }
    return chains;
  }

 private:
  static constexpr std::uint8_t none = 0, free = 1, junction = 2, used = 3;

  int count_near(Cell c, std::uint8_t state) const {
    int count = 0;
    for (const auto& [dx, dy] : ring)
      count += state_.inside(c.col + dx, c.row + dy) && state_.at(c.col + dx, c.row + dy) == state;
    return count;
  }
  /// A neighbour in that state, those that share an edge first.
  bool find_near(Cell c, std::uint8_t state, Cell& found) const {
    for (const std::size_t k : {0U, 2U, 4U, 6U, 1U, 3U, 5U, 7U}) {
      const Cell next{c.col + ring[k][0], c.row + ring[k][1]};
      if (!state_.inside(next.col, next.row) || state_.at(next.col, next.row) != state) continue;
      found = next;
      return true;
    }
    return false;
  }
  Chain follow(Cell c) {
    Chain chain;
    Cell end;
    chain.meets_first = find_near(c, junction, end);
    if (chain.meets_first) chain.cells.push_back(end);
    do {
      chain.cells.push_back(c);
      state_.at(c.col, c.row) = used;
    } while (find_near(c, free, c));
    if (chain.cells.size() > (chain.meets_first ? 2U : 0U) && find_near(c, junction, end)) {
      chain.meets_last = true;
      chain.cells.push_back(end);
    }
    return chain;
  }

  const std::vector<Cell>& cells_;
  Raster<std::uint8_t> state_;
};

/// Means over a few neighbours: a thinned line has steps of a pixel.
Polyline smoothed(const std::vector<Cell>& cells) {
  constexpr std::size_t half = 5;
  Polyline line;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const std::size_t reach = std::min({half, i, cells.size() - 1 - i});
    Vec2 sum;
    for (std::size_t k = i - reach; k <= i + reach; ++k) sum = sum + Vec2{cells[k].col + 0.5, cells[k].row + 0.5};
    line.push_back(sum * (1.0 / static_cast<double>(2 * reach + 1)));
  }
  return line;
}

/// A smooth field of displacements: waves in any direction.
class SmoothField {
 public:
  explicit SmoothField(Random& random) {
    const double largest = random.uniform(0.0, 20.0);
    for (Wave& wave : waves_) {
      const double length = std::exp(random.uniform(std::log(40.0), std::log(400.0))), turn = angle(random);
      wave.frequency = Vec2{std::cos(turn), std::sin(turn)} * (2.0 * std::numbers::pi / length);
      wave.phase = angle(random);
      const double to = angle(random);
      wave.amplitude =
          Vec2{std::cos(to), std::sin(to)} * std::min(0.5 * largest * random.uniform(0.3, 1.0), length / 20.0);
    }
    if (random.uniform() < 0.25) all_ = {random.uniform(-16.0, 16.0), random.uniform(-16.0, 16.0)};
  }
  [[nodiscard]] Vec2 at(Vec2 p) const {
    Vec2 sum = all_;
    for (const Wave& wave : waves_) sum = sum + wave.amplitude * std::sin(dot(wave.frequency, p) + wave.phase);
    return sum;
  }

 private:
  static double angle(Random& random) { return random.uniform(0.0, 2.0 * std::numbers::pi); }
  struct Wave {
    Vec2 frequency, amplitude;
    double phase = 0.0;
  };
  std::array<Wave, 4> waves_;
  Vec2 all_;
};

Polyline resampled(const Polyline& line, double step) {
  Polyline result;
  const double whole = length_m(line);
  const int steps = std::max(1, static_cast<int>(std::ceil(whole / step)));
  for (int i = 0; i <= steps; ++i) result.push_back(point_at(line, whole * i / steps));
  return result;
}

/// A line of the map, and what is true at its points.
struct DisturbedLine {
  RoadLine drawn;
  std::vector<Vec2> to_truth;
  std::vector<double> half_width;
  bool invented = false;  ///< nothing is known of it
};

DisturbedLine disturbed(const ThinnedLine& line, const SmoothField& field, Random& random) {
  DisturbedLine result;
  Polyline moved;
  for (const Vec2 p : line.points) moved.push_back(p + field.at(p));
  if (random.uniform() < 0.5) moved = resampled(moved, random.uniform(6.0, 40.0));  // coarse nodes cut corners
  result.drawn.points = resampled(moved, step_px);
  for (const Vec2 p : result.drawn.points) {
    const LineProjection on = project_onto(line.points, p);
    result.to_truth.push_back(on.point - p);
    result.half_width.push_back(line.half_width[on.segment]);
  }
  std::vector<double> known;
  for (const double w : line.half_width)
    if (w > 0.0) known.push_back(w);
  if (known.empty()) return result;
  const double usual = median(std::move(known)), kind = random.uniform();
  result.drawn.half_width = kind < 0.15  ? 0.0
                            : kind < 0.4 ? std::array{3.5, 5.5, 6.0, 7.0}[random.below(4)]  // 3.5 to 7 m at 0.5 m/px
                                         : usual * std::exp(0.35 * random.normal());
  return result;
}

DisturbedLine invented(int size, Random& random) {
  DisturbedLine result{.invented = true};
  const SmoothField bend(random);
  const Vec2 a{random.uniform(0.0, size), random.uniform(0.0, size)};
  const double turn = random.uniform(0.0, 2.0 * std::numbers::pi), length = random.uniform(40.0, 300.0);
  const Vec2 b = a + Vec2{std::cos(turn), std::sin(turn)} * length;
  for (const Vec2 p : resampled({a, b}, step_px)) result.drawn.points.push_back(p + bend.at(p));
  result.to_truth.resize(result.drawn.points.size());
  result.half_width.assign(result.drawn.points.size(), -1.0);
  result.drawn.half_width = random.uniform(2.0, 9.0);
  return result;
}

AlignmentTruth truth_at(const DisturbedLine& line, const NearestLine& nearest) {
  const auto i = static_cast<std::size_t>(nearest.segment);
  const Vec2 normal = left_normal(normalized(line.drawn.points[i + 1] - line.drawn.points[i]));
  const Vec2 to_truth = line.to_truth[i] * (1.0 - nearest.t) + line.to_truth[i + 1] * nearest.t;
  AlignmentTruth truth{static_cast<float>(normal.x), static_cast<float>(normal.y),
                       static_cast<float>(dot(nearest.to_line + to_truth, normal))};
  // Where the nearest true place lies along the line rather than across it, a line ends there or another one begins.
  truth.known = line.half_width[i] > 0.0 && line.half_width[i + 1] > 0.0 &&
                std::abs(dot(to_truth, normal)) > 0.7 * length(to_truth) - 0.5;
  truth.half_width = static_cast<float>(line.half_width[i] * (1.0 - nearest.t) + line.half_width[i + 1] * nearest.t);
  return truth;
}

}  // namespace

std::vector<ThinnedLine> thinned_lines(const Raster<std::uint8_t>& mask, const Raster<std::uint8_t>& unknown) {
  constexpr double least_px = 12.0, least_half_width_px = 1.5;
  const Raster<Cell> outside = nearest_outside(mask);
  Raster<std::uint8_t> thinned = mask;
  const std::vector<Cell> cells = thin(thinned);
  std::vector<ThinnedLine> lines;
  for (const Chain& chain : Tracer(thinned, cells).run()) {
    ThinnedLine line;
    for (const Cell c : chain.cells) {
      const Cell to = outside.at(c.col, c.row);
      const double distance = std::hypot(to.col, to.row);
      const int edge = std::min({c.col, c.row, mask.width - 1 - c.col, mask.height - 1 - c.row});
      const bool known = distance <= edge && !unknown.at(c.col + to.col, c.row + to.row);
      line.half_width.push_back(known ? distance - 0.5 : -1.0);
    }
    const double widest = *std::max_element(line.half_width.begin(), line.half_width.end()),
                 least = std::max(least_px, 1.5 * widest);
    if (widest > 0.0 && widest < least_half_width_px) continue;
    const bool spur = !chain.meets_first || !chain.meets_last;
    if (chain.cells.size() < 2 || (spur && static_cast<double>(chain.cells.size()) < least)) continue;
    line.points = smoothed(chain.cells);
    lines.push_back(std::move(line));
  }
  return lines;
}

namespace {

/// All lines of a map, as draw_map() says.
std::vector<DisturbedLine> disturbed_lines(const Raster<ClassSet>& allowed, const MapClasses& classes,
                                           std::uint64_t seed) {
  Random random(seed);
  std::vector<DisturbedLine> lines;
  if (random.uniform() < 0.1) return lines;
  Raster<std::uint8_t> mask(allowed.width, allowed.height), unknown = mask, parking = mask;
  for (std::size_t i = 0; i < allowed.data.size(); ++i) {
    const ClassSet set = allowed.data[i];
    mask.data[i] = set != unknown_class && (set & ~classes.road) == 0;
    unknown.data[i] = set == unknown_class || (set & classes.road) != 0;
    parking.data[i] = set != unknown_class && (set & ~classes.maybe_road) == 0;
  }
  const SmoothField field(random);
  const double left_out = random.uniform() < 0.7 ? 0.0 : random.uniform(0.0, 0.4);
  for (const ThinnedLine& line : thinned_lines(mask, unknown))
    if (random.uniform() >= left_out) lines.push_back(disturbed(line, field, random));
  if (random.uniform() < 0.5) {
    for (const ThinnedLine& line : thinned_lines(parking, unknown)) {
      DisturbedLine aisle = disturbed(line, field, random);
      aisle.invented = true;
      aisle.drawn.half_width = random.uniform(3.0, 6.0);
      lines.push_back(std::move(aisle));
    }
  }
  for (int i = static_cast<int>(random.below(6)) - 3; i > 0; --i) lines.push_back(invented(allowed.width, random));
  return lines;
}

std::vector<DisturbedLine> moved_lines(const std::vector<RoadLine>& real, std::uint64_t seed) {
  Random random(seed);
  const SmoothField field(random);
  std::vector<DisturbedLine> lines;
  for (const RoadLine& line : real) {
    DisturbedLine& moved = lines.emplace_back(DisturbedLine{.drawn = {{}, line.half_width}, .invented = true});
    for (const Vec2 p : resampled(line.points, step_px)) moved.drawn.points.push_back(p + field.at(p));
  }
  return lines;
}

std::vector<RoadLine> drawn_lines(const std::vector<DisturbedLine>& lines) {
  std::vector<RoadLine> drawn;
  drawn.reserve(lines.size());
  for (const DisturbedLine& line : lines) drawn.push_back(line.drawn);
  return drawn;
}

}  // namespace

std::vector<RoadLine> draw_lines(const Raster<ClassSet>& allowed, const MapClasses& classes, std::uint64_t seed) {
  return drawn_lines(disturbed_lines(allowed, classes, seed));
}

std::vector<RoadLine> move_lines(const std::vector<RoadLine>& real, std::uint64_t seed) {
  return drawn_lines(moved_lines(real, seed));
}

DisturbedMap draw_map(const Raster<ClassSet>& allowed, const std::vector<RoadLine>& real, const MapClasses& classes,
                      std::uint64_t seed) {
  constexpr double truth_reach_px = 12.0;
  const bool takes_real = !real.empty() && Random(derive_seed(seed, 1)).uniform() < 0.5;
  const std::vector<DisturbedLine> lines =
      takes_real ? moved_lines(real, seed) : disturbed_lines(allowed, classes, seed);
  const std::vector<RoadLine> drawn = drawn_lines(lines);
  const Raster<NearestLine> nearest = nearest_lines(drawn, {0, 0, allowed.width, allowed.height});
  DisturbedMap result{map_raster(drawn, nearest), Raster<AlignmentTruth>(allowed.width, allowed.height)};
  for (std::size_t i = 0; i < nearest.data.size(); ++i) {
    const NearestLine& n = nearest.data[i];
    if (n.line < 0 || length(n.to_line) > truth_reach_px) continue;
    const DisturbedLine& line = lines[static_cast<std::size_t>(n.line)];
    if (!line.invented) result.truth.data[i] = truth_at(line, n);
  }
  return result;
}

}  // namespace orthodrive
