// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/elevate/terrain/terrain_across.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace orthodrive::elevate {
namespace {

constexpr double other_road_margin_m = 1.0;  // kerbs, gutters, rounded corners of a mouth
constexpr double abutment_m = 5.0;           // bare earth is smeared beside a bridge or portal, by a pixel or this
constexpr double same_place_m = 30.0;        // further apart along a chain it is another place: a loop over itself

/// A pixel below the carriageway of a chain or within a margin of it.
struct Footprint {
  std::uint64_t pixel = 0;
  std::uint32_t chain = 0, station = 0;
  float t_m = 0.0f, u_m = 0.0f;  ///< across and along, from the station
  bool usable = false;
};

/// Stations that are not on a bridge or in a tunnel, nor near one.
std::vector<bool> on_the_ground(const StationChain& chain, double margin_m) {
  const std::size_t n = chain.stations.size();
  std::vector<bool> ground(n, true);
  for (std::size_t i = 0; i < n; ++i) {
    const Station& station = chain.stations[i];
    if (!station.bridge && !station.tunnel) continue;
    ground[i] = false;
    for (const int way : {1, -1}) {
      std::size_t k = i;
      for (double gone_m = 0.0; gone_m < margin_m;) {
        if (!chain.closed && (way > 0 ? k + 1 == n : k == 0)) break;
        const std::size_t next = way > 0 ? (k + 1) % n : (k + n - 1) % n;
        gone_m += way > 0 ? step_m(chain, k) : step_m(chain, next);
        k = next;
        if (gone_m >= margin_m || chain.stations[k].bridge || chain.stations[k].tunnel) break;
        ground[k] = false;
      }
    }
  }
  return ground;
}

class Gatherer {
 public:
  Gatherer(const NetworkStations& network, const HeightGrid& grid) : network_(network), grid_(grid) {}

  /// Of a chain; `wanted` stations may use their pixels, all others are only in the way of other roads.
  void add(std::size_t chain_index, const std::vector<bool>& wanted) {
    const StationChain& chain = network_.chains[chain_index];
    const std::size_t n = chain.stations.size();
    for (std::size_t i = 0; i < n && n >= 2; ++i) {
      const bool has_next = i + 1 < n || chain.closed, has_previous = i > 0 || chain.closed;
      const double ahead_m = has_next ? 0.5 * step_m(chain, i) : 0.0,
                   behind_m = has_previous ? 0.5 * step_m(chain, i > 0 ? i - 1 : n - 1) : 0.0;
      if (!chain.stations[i].tunnel) add_cell(chain_index, i, ahead_m, behind_m, wanted[i]);
    }
  }

  /// Keeps the pixels that only one place claims and hands them to their chains.
  void settle(std::vector<std::vector<AcrossSample>>& samples) {
    std::sort(footprints_.begin(), footprints_.end(), [](const Footprint& a, const Footprint& b) {
      return std::tuple(a.pixel, a.chain, std::abs(a.u_m), a.station) <
             std::tuple(b.pixel, b.chain, std::abs(b.u_m), b.station);
    });
    for (std::size_t begin = 0, end = 0; begin < footprints_.size(); begin = end) {
      const Footprint& best = footprints_[begin];
      bool alone = true;
      for (end = begin; end < footprints_.size() && footprints_[end].pixel == best.pixel; ++end)
        alone = alone && footprints_[end].chain == best.chain &&
                apart_m(best.chain, best.station, footprints_[end].station) < same_place_m;
      if (!alone || !best.usable) continue;
      const Station& station = network_.chains[best.chain].stations[best.station];
      const double height_m = grid_.height_m.data[best.pixel];
      // A metre of the centre line is 1 - k t metres at the offset t.
      const double along_m = best.u_m / std::max(0.3, 1.0 - station.curvature_1pm * best.t_m);
      samples[best.chain].push_back({best.station, best.t_m,
                                     static_cast<float>(height_m - station.z_m - station.gradient * along_m),
                                     static_cast<float>(grid_.frame.gsd_m)});
    }
  }

 private:
  [[nodiscard]] double apart_m(std::size_t chain_index, std::size_t a, std::size_t b) const {
    const StationChain& chain = network_.chains[chain_index];
    const double d = std::abs(chain.stations[a].s_m - chain.stations[b].s_m);
    return chain.closed ? std::min(d, chain.length_m - d) : d;
  }

  void add_cell(std::size_t chain_index, std::size_t i, double ahead_m, double behind_m, bool wanted) {
    const Station& station = network_.chains[chain_index].stations[i];
    const GridFrame& frame = grid_.frame;
    const double reach_m = station.half_width_m + 0.5 * frame.gsd_m + other_road_margin_m;
    // On the outside of a bend cells gape: they overlap instead, and the nearest station takes the pixel.
    const double stretch = 1.05 + std::abs(station.curvature_1pm) * reach_m;
    const double radius_m = std::hypot(reach_m, stretch * std::max(ahead_m, behind_m));
    const Vec2 centre = frame.pixel_from_world(station.p);
    const double radius_px = radius_m / frame.gsd_m;
    const int first_col = std::max(0, static_cast<int>(std::floor(std::max(-1.0, centre.x - radius_px)))),
              last_col = static_cast<int>(std::floor(std::min(frame.width - 1.0, centre.x + radius_px)));
    const int first_row = std::max(0, static_cast<int>(std::floor(std::max(-1.0, centre.y - radius_px)))),
              last_row = static_cast<int>(std::floor(std::min(frame.height - 1.0, centre.y + radius_px)));
    for (int row = first_row; row <= last_row; ++row)
      for (int col = first_col; col <= last_col; ++col) {
        const Vec2 d = frame.center_of(col, row) - station.p;
        const double u = dot(d, station.along), t = cross(station.along, d);
        if (std::abs(t) > reach_m || u > stretch * ahead_m || u < -stretch * behind_m) continue;
        const std::size_t pixel = grid_.height_m.index(col, row);
        if (std::isnan(grid_.height_m.data[pixel])) continue;
        footprints_.push_back({pixel, static_cast<std::uint32_t>(chain_index), static_cast<std::uint32_t>(i),
                               static_cast<float>(t), static_cast<float>(u),
                               wanted && std::abs(t) <= station.half_width_m && !std::isnan(station.z_m)});
      }
  }

  const NetworkStations& network_;
  const HeightGrid& grid_;
  std::vector<Footprint> footprints_;
};

}  // namespace

std::vector<std::vector<AcrossSample>> gather_across_samples(const NetworkStations& network,
                                                             std::span<const HeightGrid> dtms, double coarsest_gsd_m) {
  std::vector<std::vector<AcrossSample>> samples(network.chains.size());
  std::vector<std::vector<bool>> seen(network.chains.size());  // stations that a better model has measured
  for (std::size_t c = 0; c < network.chains.size(); ++c) seen[c].resize(network.chains[c].stations.size(), false);
  for (const HeightGrid& dtm : dtms) {
    if (dtm.frame.gsd_m > coarsest_gsd_m || dtm.height_m.empty()) continue;
    Gatherer gatherer(network, dtm);
    for (std::size_t c = 0; c < network.chains.size(); ++c) {
      std::vector<bool> wanted = on_the_ground(network.chains[c], std::max(abutment_m, dtm.frame.gsd_m));
      for (std::size_t i = 0; i < wanted.size(); ++i) wanted[i] = wanted[i] && !seen[c][i];
      gatherer.add(c, wanted);
    }
    gatherer.settle(samples);
    for (std::size_t c = 0; c < network.chains.size(); ++c)
      for (const AcrossSample& sample : samples[c]) seen[c][sample.station] = true;
  }
  for (auto& of_chain : samples)
    std::stable_sort(of_chain.begin(), of_chain.end(),
                     [](const AcrossSample& a, const AcrossSample& b) { return a.station < b.station; });
  return samples;
}

}  // namespace orthodrive::elevate
