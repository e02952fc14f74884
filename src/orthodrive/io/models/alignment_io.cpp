// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/models/alignment_io.hpp"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>
#include <map>
#include <sstream>
#include <string>
#include <utility>

#include "orthodrive/core/atomic_file.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/io/support/read_file.hpp"

namespace orthodrive::io {
namespace {

constexpr double largest_id = 9e15, largest_part = 1e9;  // that integers hold
constexpr const char* header = "osm_id,part,s_m,east_m,north_m,sigma_m,half_width_m,sigma_half_width_m";

/// The numbers of a line, separated by commas; false unless there are exactly as many.
template <std::size_t N>
bool parse(const std::string& line, std::array<double, N>& numbers) {
  const char *at = line.data(), *end = at + line.size();
  for (std::size_t i = 0; i < N; ++i) {
    const auto [next, error] = std::from_chars(at, end, numbers[i]);
    if (error != std::errc() || !std::isfinite(numbers[i])) return false;
    if (i + 1 == N) return next == end;
    if (next == end || *next != ',') return false;
    at = next + 1;
  }
  return false;
}

}  // namespace

void write_alignment(const std::filesystem::path& path, const RoadNetwork& roads, const RoadAlignment& alignment) {
  std::string text = std::string(header) + "\n";
  for (std::size_t p = 0; p < roads.paths.size(); ++p)
    for (const AlignedPlace& place : alignment[p]) {
      const PlaceAlignment& a = place.alignment;
      if (a.sigma_m <= 0.0) continue;
      text += fmt::format("{},{},{:.3f},{:.3f},{:.3f},{:.3f},{:.3f},{:.3f}\n", roads.paths[p].osm_id,
                          roads.paths[p].part, place.s_m, a.displacement_m.x, a.displacement_m.y, a.sigma_m,
                          a.half_width_m, a.sigma_half_width_m);
    }
  write_text_file(path, text);
}

RoadAlignment read_alignment(const std::filesystem::path& path, const RoadNetwork& roads) {
  std::map<std::pair<std::int64_t, int>, std::size_t> path_of;
  for (std::size_t p = 0; p < roads.paths.size(); ++p) path_of[{roads.paths[p].osm_id, roads.paths[p].part}] = p;
  std::istringstream text(read_file(path));
  std::string line;
  if (!std::getline(text, line) || line != header)
    throw InputError(path.string(), fmt::format("line 1 must be '{}': use a file of `orthodrive segment`", header));
  RoadAlignment alignment(roads.paths.size());
  for (int number = 2; std::getline(text, line); ++number) {
    std::array<double, 8> n{};
    if (!parse(line, n) || !(n[5] > 0.0) || !(n[7] > 0.0) || std::abs(n[0]) > largest_id ||
        std::abs(n[1]) > largest_part)
      throw InputError(path.string(),
                       fmt::format("line {} does not hold eight numbers with sigmas above 0: '{}'", number, line));
    const auto found = path_of.find({static_cast<std::int64_t>(n[0]), static_cast<int>(n[1])});
    if (found != path_of.end()) alignment[found->second].push_back({n[2], {{n[3], n[4]}, n[5], n[6], n[7]}});
  }
  return alignment;
}

}  // namespace orthodrive::io
