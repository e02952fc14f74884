// SPDX-License-Identifier: Apache-2.0
// A road may share pavement with several others. Each pair is a projection onto the slopes that fit it, the least
// change of both; a road takes the mean of what its pairs ask for, again and again (Cimmino's method). So nothing
// depends on the order of pairs.
#include "orthodrive/elevate/banking/shared_slopes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

namespace orthodrive::elevate {
namespace {

constexpr double free_sigma = 0.02, measured_sigma = 1e-4;  // how readily a slope changes
constexpr double flush_sigma_m = 0.005;                     // lower steps are none
constexpr double free_gap_m = 3.0;                          // between carriageways: what lies further apart is free
constexpr double notable_change = 0.002;
constexpr int rounds = 20;

using SlopeKey = std::pair<std::size_t, std::size_t>;  // chain, station

/// One of two roads; across is measured in the frame of the main road's chain, positive to its left.
struct SharingRoad {
  SlopeKey key;
  double sign = 1.0;  ///< of its own slopes in that frame
  double t_m = 0.0;   ///< of the middle of the shared strip, from its line
  double z_m = 0.0;   ///< of its line, abeam of the main road's station
  double roof = 0.0;  ///< slope of its crown on the side of the strip
  bool is_free = false;
};

struct SharingPair {
  std::array<SharingRoad, 2> roads;
  double overlap_m = 0.0;  ///< of the carriageways; negative: a gap
};

using Slopes = std::map<SlopeKey, double>;

/// Slopes of both roads that fit, as near as may be to those they have.
std::array<double, 2> fitting_slopes(const SharingPair& pair, const Slopes& slopes) {
  const auto& [a, b] = pair.roads;
  const double gap_m = std::max(0.0, -pair.overlap_m), near = std::max(1e-3, 1.0 - gap_m / free_gap_m);
  const double height_weight = std::pow(near / flush_sigma_m, 2);
  const double slope_weight = std::pow(0.5 * std::max(0.0, pair.overlap_m) / flush_sigma_m, 2);
  std::array<double, 2> own{a.sign * slopes.at(a.key), b.sign * slopes.at(b.key)}, weight{};
  for (std::size_t k : {0U, 1U}) weight[k] = std::pow(pair.roads[k].is_free ? free_sigma : measured_sigma, -2);
  // Unknown: changes x and y. Height: step + x ta - y tb = 0; slope: turn + x - y = 0.
  const double step_m = a.z_m + (own[0] + a.roof) * a.t_m - b.z_m - (own[1] + b.roof) * b.t_m;
  const double turn = own[0] + a.roof - own[1] - b.roof;
  const double xx = weight[0] + height_weight * a.t_m * a.t_m + slope_weight;
  const double yy = weight[1] + height_weight * b.t_m * b.t_m + slope_weight;
  const double xy = -height_weight * a.t_m * b.t_m - slope_weight;
  const double x0 = -height_weight * step_m * a.t_m - slope_weight * turn;
  const double y0 = height_weight * step_m * b.t_m + slope_weight * turn;
  const double determinant = xx * yy - xy * xy;
  return {a.sign * (own[0] + (yy * x0 - xy * y0) / determinant), b.sign * (own[1] + (xx * y0 - xy * x0) / determinant)};
}

SharingPair make_pair(const NetworkStations& network, const SharedPavement& place,
                      const std::vector<BankingFit>& fits) {
  const StationOfNode at = network.of_node[place.main_path][place.main_node],
                      beside = network.of_node[place.other_path][place.other_node];
  const Station &main = network.chains[at.chain].stations[at.station],
                &other = network.chains[beside.chain].stations[beside.station];
  const double along_m = dot(main.p - other.p, other.along);
  const Vec2 foot = other.p + other.along * along_m;
  const double left_m = cross(main.along, foot - main.p), side = left_m < 0.0 ? -1.0 : 1.0;
  const double middle_m = 0.5 * (left_m + side * (main.half_width_m - other.half_width_m));
  const double other_sign = dot(main.along, other.along) < 0.0 ? -1.0 : 1.0;
  const auto is_free = [&](const StationOfNode& of) {
    return fits[of.chain].source[of.station] == BankingSource::design;
  };
  const auto roof = [&](const StationOfNode& of, double t_m) {
    return (t_m < 0.0 ? 1.0 : -1.0) * fits[of.chain].crown[of.station];
  };
  const SharingRoad a{{at.chain, at.station}, 1.0, middle_m, main.z_m, roof(at, middle_m), is_free(at)};
  const SharingRoad b{
      {beside.chain, beside.station},  other_sign,     middle_m - left_m, other.z_m + other.gradient * along_m,
      roof(beside, middle_m - left_m), is_free(beside)};
  return {{a, b}, main.half_width_m + other.half_width_m - std::abs(left_m)};
}

/// Of decks and in tunnels nothing tells a height to within what slopes would have to follow.
bool is_structure(const NetworkStations& network, const SlopeKey& key) {
  const Station& station = network.chains[key.first].stations[key.second];
  return station.bridge || station.tunnel;
}

std::vector<SharingPair> make_pairs(const NetworkStations& network, const std::vector<SharedPavement>& shared,
                                    const std::vector<BankingFit>& fits, double largest_slope) {
  std::vector<SharingPair> pairs;
  for (const SharedPavement& place : shared) {
    const SharingPair pair = make_pair(network, place, fits);
    const auto& [a, b] = pair.roads;
    if (is_structure(network, a.key) || is_structure(network, b.key)) continue;
    const double step_m = std::abs(a.z_m - b.z_m);
    if (a.key == b.key || !(a.is_free || b.is_free) || std::isnan(step_m)) continue;
    if (step_m <= flush_sigma_m + largest_slope * std::abs(a.t_m - b.t_m)) pairs.push_back(pair);
  }
  return pairs;
}

}  // namespace

std::vector<std::vector<BankingAnchor>> share_slopes(const NetworkStations& network,
                                                     const std::vector<SharedPavement>& shared,
                                                     const std::vector<BankingFit>& fits, double largest_slope) {
  const std::vector<SharingPair> pairs = make_pairs(network, shared, fits, largest_slope);
  Slopes slopes;
  for (const SharingPair& pair : pairs)
    for (const SharingRoad& road : pair.roads) slopes[road.key] = fits[road.key.first].slope[road.key.second];
  for (int round = 0; round < rounds; ++round) {
    std::map<SlopeKey, std::pair<double, int>> wanted;
    for (const SharingPair& pair : pairs) {
      const std::array<double, 2> fitting = fitting_slopes(pair, slopes);
      for (std::size_t k : {0U, 1U})
        if (pair.roads[k].is_free) wanted[pair.roads[k].key].first += fitting[k], ++wanted[pair.roads[k].key].second;
    }
    for (const auto& [key, sum] : wanted)
      slopes[key] = std::clamp(sum.first / sum.second, -largest_slope, largest_slope);
  }
  std::vector<std::vector<BankingAnchor>> anchors(network.chains.size());
  std::vector<bool> is_notable(network.chains.size(), false);
  for (const auto& [key, slope] : slopes) {
    const auto [chain, station] = key;
    if (fits[chain].source[station] != BankingSource::design) continue;
    anchors[chain].push_back({station, slope, true});
    if (std::abs(slope - fits[chain].slope[station]) > notable_change) is_notable[chain] = true;
  }
  for (std::size_t c = 0; c < anchors.size(); ++c)
    if (!is_notable[c]) anchors[c].clear();
  return anchors;
}

}  // namespace orthodrive::elevate
