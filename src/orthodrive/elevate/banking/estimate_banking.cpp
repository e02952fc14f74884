// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/elevate/banking/estimate_banking.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/parallel.hpp"
#include "orthodrive/elevate/banking/fit_banking.hpp"
#include "orthodrive/elevate/banking/shared_slopes.hpp"
#include "orthodrive/model/roads/highway_class.hpp"
#include "orthodrive/model/roads/osm_node_id.hpp"
#include "orthodrive/roads/path_junctions.hpp"

namespace orthodrive {
namespace {

constexpr double largest_raceway_slope = 0.7;  // ovals are banked by up to 35 degrees

using namespace elevate;

// Of two roads on one pavement: what the Green Book lets break between the lanes of a turning road and those of the
// main one at over 60 km/h. Roads that come apart steeper are two surfaces.
constexpr double steepest_pavement = 0.05;
constexpr double longest_overlap_m = 20.0;  // of a slip road that leaves at a narrow angle

void check_banking(const RoadNetwork& roads, std::span<const HeightGrid> dtms, const BankingOptions& options) {
  for (const HeightGrid& dtm : dtms)
    if (!(dtm.crs == roads.crs))
      throw OptionError(fmt::format("banking: roads are in {} but terrain in {}, need one CRS", roads.crs.definition,
                                    dtm.crs.definition));
  if (!(options.design_crown >= 0.0) || !(options.largest_slope > 0.0) || !(options.terrain_sigma_m > 0.0))
    throw OptionError("banking: limits and the noise of the terrain must be positive, the crown not negative");
  for (const RoadPath& path : roads.paths)
    if (path.nodes.size() < 2) throw OptionError(fmt::format("banking: way {} has fewer than two nodes", path.osm_id));
}

/// Higher ranked chains first, then longer ones: whose plane counts where chains meet.
std::vector<std::size_t> by_importance(const NetworkStations& network) {
  std::vector<std::size_t> order(network.chains.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    const StationChain &ca = network.chains[a], &cb = network.chains[b];
    return ca.rank != cb.rank ? ca.rank > cb.rank : ca.length_m > cb.length_m;
  });
  return order;
}

/// Gradient (east, north) of the plane that the profiles of a junction's roads lie in, by its osm_node. None where they
/// all run the same way.
using JunctionPlanes = std::map<std::int64_t, Vec2>;
JunctionPlanes junction_planes(const RoadNetwork& roads) {
  constexpr double least_determinant = 0.003;  // squared sine of 3 degrees
  JunctionPlanes planes;
  for (const PathJunction& junction : find_junctions(roads, link_path_ends(roads))) {
    double xx = 0.0, xy = 0.0, yy = 0.0;
    Vec2 right;
    for (const JunctionArm& arm : junction.arms) {
      const Vec2 d = arm.direction;
      xx += d.x * d.x, xy += d.x * d.y, yy += d.y * d.y;
      right = right + d * roads.paths[arm.path].nodes[arm.node].gradient;
    }
    const double determinant = xx * yy - xy * xy;
    if (determinant < least_determinant || std::isnan(right.x + right.y)) continue;
    planes[junction.osm_node] = {(yy * right.x - xy * right.y) / determinant,
                                 (xx * right.y - xy * right.x) / determinant};
  }
  return planes;
}

/// A place where a chain meets a more important one, or itself is that.
struct BankedMeeting {
  std::size_t station = 0, main_chain = 0, main_station = 0;
  std::optional<Vec2> plane;
};

std::vector<std::vector<BankedMeeting>> find_banked_meetings(const RoadNetwork& roads, const NetworkStations& network,
                                                             const std::vector<std::size_t>& order,
                                                             const JunctionPlanes& planes) {
  std::vector<std::size_t> importance(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) importance[order[k]] = k;
  std::map<std::int64_t, std::vector<StationOfNode>> at_node;
  for (std::size_t p = 0; p < roads.paths.size(); ++p)
    for (std::size_t n = 0; n < roads.paths[p].nodes.size(); ++n)
      if (const auto id = roads.paths[p].nodes[n].osm_node; is_osm_node(id))
        at_node[id].push_back(network.of_node[p][n]);
  std::vector<std::vector<BankedMeeting>> meetings(network.chains.size());
  for (const auto& [id, places] : at_node) {
    const StationOfNode main = *std::min_element(
        places.begin(), places.end(),
        [&](const StationOfNode& a, const StationOfNode& b) { return importance[a.chain] < importance[b.chain]; });
    const auto plane = planes.find(id);
    const auto gradient = plane != planes.end() ? std::optional(plane->second) : std::nullopt;
    if (gradient) meetings[main.chain].push_back({main.station, main.chain, main.station, gradient});
    for (const StationOfNode& place : places)
      if (place.chain != main.chain || (gradient && place.station != main.station))
        meetings[place.chain].push_back({place.station, main.chain, main.station, gradient});
  }
  return meetings;
}

/// The chains in parts: a chain needs the planes of those that it meets as the less important one, all in earlier
/// parts.
std::vector<std::vector<std::size_t>> generations(const std::vector<std::size_t>& order,
                                                  const std::vector<std::vector<BankedMeeting>>& meetings) {
  std::vector<std::size_t> of_chain(meetings.size());
  std::vector<std::vector<std::size_t>> result;
  for (const std::size_t c : order) {
    std::size_t generation = 0;
    for (const BankedMeeting& meeting : meetings[c])
      if (meeting.main_chain != c) generation = std::max(generation, of_chain[meeting.main_chain] + 1);
    if (generation == result.size()) result.emplace_back();
    result[generation].push_back(c);
    of_chain[c] = generation;
  }
  return result;
}

/// Both ways along the chain from a station, which is left out: visit(station, metres gone) until that is over
/// `reach_m`, the chain ends, or visit returns false.
template <typename Visit>
void walk_away(const StationChain& chain, std::size_t from, double reach_m, Visit&& visit) {
  const std::size_t n = chain.stations.size();
  for (const int way : {1, -1}) {
    double gone_m = 0.0;
    for (std::size_t i = from, count = 1; count < n; ++count) {
      if (!chain.closed && (way > 0 ? i + 1 == n : i == 0)) break;
      const std::size_t next = way > 0 ? (i + 1) % n : (i + n - 1) % n;
      gone_m += step_m(chain, way > 0 ? i : next);
      i = next;
      if (gone_m > reach_m || !visit(i, gone_m)) break;
    }
  }
}

/// Stations of the chain on the main road's carriageway lie in its plane there (the half of its roof on their side);
/// the main road itself does where a junction's plane is known.
void add_anchors(const StationChain& chain, const BankedMeeting& meeting, const StationChain& main,
                 const BankingFit& main_fit, std::vector<BankingAnchor>& anchors) {
  const Station& at = main.stations[meeting.main_station];
  const Vec2 left = left_normal(at.along);
  if (&chain == &main) {  // also where it meets itself
    if (meeting.plane)
      anchors.push_back(
          {meeting.station, dot(*meeting.plane, left_normal(chain.stations[meeting.station].along)), true});
    return;
  }
  const Vec2 plane =
      meeting.plane ? *meeting.plane : at.along * at.gradient + left * main_fit.slope[meeting.main_station];
  const auto anchor = [&](std::size_t i) {
    const double t = dot(chain.stations[i].p - chain.stations[meeting.station].p, left);
    if (std::abs(t) > at.half_width_m) return false;
    const double side = i == meeting.station ? 0.0 : std::copysign(1.0, t);
    anchors.push_back(
        {i, dot(plane - left * (side * main_fit.crown[meeting.main_station]), left_normal(chain.stations[i].along))});
    return true;
  };
  anchor(meeting.station);
  walk_away(chain, meeting.station, longest_overlap_m, [&](std::size_t i, double) { return anchor(i); });
}

/// Where no plane of a junction tells the slope.
void add_where_free(const std::vector<BankingAnchor>& shared, std::vector<BankingAnchor>& anchors) {
  std::vector<std::size_t> taken;
  taken.reserve(anchors.size());
  for (const BankingAnchor& anchor : anchors) taken.push_back(anchor.station);
  std::ranges::sort(taken);
  for (const BankingAnchor& anchor : shared)
    if (!std::ranges::binary_search(taken, anchor.station)) anchors.push_back(anchor);
}

constexpr double most_twist_1pm = 0.007;  // 5 % in 7 m

/// Largest slope at every station: the limit of the road, and no less than a junction's plane until it has run
/// out.
std::vector<double> slope_limits(const RoadNetwork& roads, const StationChain& chain, const BankingOptions& options,
                                 const std::vector<BankingAnchor>& anchors) {
  std::vector<double> limits;
  limits.reserve(chain.stations.size());
  for (const Station& station : chain.stations)
    limits.push_back(is_raceway(roads.paths[station.path].highway) ? largest_raceway_slope : options.largest_slope);
  for (const BankingAnchor& anchor : anchors) {
    limits[anchor.station] = std::max(limits[anchor.station], std::abs(anchor.slope));
    walk_away(chain, anchor.station, INFINITY, [&](std::size_t i, double gone_m) {
      const double left = std::abs(anchor.slope) - most_twist_1pm * std::max(0.0, gone_m - banking_runout_m);
      limits[i] = std::max(limits[i], left);
      return left > 0.0;
    });
  }
  return limits;
}

/// How far a road may have left the slope that it has in a junction's plane `gone_m` away. Where nothing is measured it
/// goes to its design evenly, from where it has left a road as wide as itself.
double turned_at_most(bool is_design, double to_design, double gone_m, double width_m) {
  constexpr double least_twist_1pm = 0.002;  // relative gradient of 0.65 % over half a street
  const double most = most_twist_1pm * gone_m;
  if (!is_design) return most;
  const double left_m = std::max(0.0, gone_m - width_m);
  return std::min(most,
                  std::max(least_twist_1pm * gone_m, std::min(most_twist_1pm, to_design / banking_runout_m) * left_m));
}

/// From where it lies in a junction's plane a road turns no faster than that; the main road only where nothing of it is
/// measured. Between planes that ask for more it takes their middle.
void limit_twist(const StationChain& chain, const DesignBanking& design, const std::vector<BankingAnchor>& anchors,
                 BankingFit& fit) {
  constexpr double reach_m = 150.0;  // a slope of 1
  const std::size_t n = chain.stations.size();
  std::vector<double> least(n, -INFINITY), most(n, INFINITY);
  for (const BankingAnchor& anchor : anchors) {
    const double slope = fit.slope[anchor.station], width_m = 2.0 * chain.stations[anchor.station].half_width_m;
    const auto bound = [&](std::size_t i, double gone_m) {
      const bool is_design = fit.source[i] == BankingSource::design;
      if (anchor.is_main && !is_design) return false;
      const double room = turned_at_most(is_design, std::abs(design.slope[i] - slope), gone_m, width_m);
      least[i] = std::max(least[i], slope - room), most[i] = std::min(most[i], slope + room);
      return true;
    };
    bound(anchor.station, 0.0);
    walk_away(chain, anchor.station, reach_m, bound);
  }
  for (std::size_t i = 0; i < n; ++i)
    fit.slope[i] = least[i] > most[i] ? 0.5 * (least[i] + most[i]) : std::clamp(fit.slope[i], least[i], most[i]);
}

/// Cuts slopes at the limit; one finding for every stretch that was measured notably beyond it.
void limit_slopes(const RoadNetwork& roads, const StationChain& chain, const std::vector<double>& limits,
                  BankingFit& fit, Findings& findings) {
  constexpr double notable = 0.005;  // about the standard deviation of measured slopes
  std::size_t worst = 0;
  double worst_excess = 0.0;
  const auto report = [&] {
    if (worst_excess > notable) {
      const Station& station = chain.stations[worst];
      findings.push_back(
          {Severity::warning, "elevate.banking_limit",
           fmt::format("way {}: a banking of {:.1f} % was measured, {:.1f} % are taken; is the line on the road?",
                       roads.paths[station.path].osm_id, 100.0 * (limits[worst] + worst_excess), 100.0 * limits[worst]),
           station.p.x, station.p.y});
    }
    worst_excess = 0.0;
  };
  for (std::size_t i = 0; i < chain.stations.size(); ++i) {
    const double excess = std::abs(fit.slope[i]) - limits[i];
    if (excess <= 0.0) {
      report();
      continue;
    }
    if (excess > worst_excess && fit.source[i] == BankingSource::dtm) worst = i, worst_excess = excess;
    fit.slope[i] = std::copysign(limits[i], fit.slope[i]);
  }
  report();
}

}  // namespace

EstimateBankingResult estimate_banking(const RoadNetwork& roads, std::span<const HeightGrid> dtms,
                                       const BankingOptions& options) {
  check_banking(roads, dtms, options);
  EstimateBankingResult result{.roads = roads};
  const NetworkStations network = make_stations(roads);
  const std::vector<std::vector<AcrossSample>> samples = gather_across_samples(network, dtms, options.coarsest_gsd_m);
  const std::vector<std::size_t> order = by_importance(network);
  const std::vector<std::vector<BankedMeeting>> meetings = find_banked_meetings(
      roads, network, order, options.in_junction_planes ? junction_planes(roads) : JunctionPlanes{});

  std::vector<BankingFit> fits(network.chains.size());
  std::vector<Findings> findings(network.chains.size());
  std::vector<std::vector<BankingAnchor>> shared(network.chains.size());
  const auto fit = [&](std::size_t c) {
    const StationChain& chain = network.chains[c];
    const DesignBanking design = design_banking(roads, chain, options.design_crown, options.driving_side);
    std::vector<BankingAnchor> anchors;
    for (const BankedMeeting& meeting : meetings[c])
      add_anchors(chain, meeting, network.chains[meeting.main_chain], fits[meeting.main_chain], anchors);
    add_where_free(shared[c], anchors);
    fits[c] = fit_banking(chain, samples[c], design, anchors, options);
    for (std::size_t i = 0; i < chain.stations.size(); ++i)
      if (fits[c].source[i] == BankingSource::design && is_raceway(roads.paths[chain.stations[i].path].highway))
        fits[c].source[i] = BankingSource::none;
    limit_twist(chain, design, anchors, fits[c]);
    findings[c].clear();
    limit_slopes(roads, chain, slope_limits(roads, chain, options, anchors), fits[c], findings[c]);
  };
  const auto fit_all = [&] {
    for (const std::vector<std::size_t>& generation : generations(order, meetings))
      parallel_for(generation.size(), options.threads, [&](std::size_t k) { fit(generation[k]); });
  };
  fit_all();
  if (options.in_junction_planes) {
    const PathLinks links = link_path_ends(roads);
    shared = share_slopes(network,
                          find_shared_pavement(roads, make_profile_chains(roads, links), find_junctions(roads, links)),
                          fits, std::min(options.largest_slope, steepest_pavement));
    if (std::ranges::any_of(shared, [](const auto& anchors) { return !anchors.empty(); })) fit_all();
  }
  for (const std::size_t c : order)
    result.findings.insert(result.findings.end(), findings[c].begin(), findings[c].end());

  std::size_t nodes = 0, measured = 0;
  for (std::size_t p = 0; p < roads.paths.size(); ++p)
    for (std::size_t n = 0; n < roads.paths[p].nodes.size(); ++n) {
      const StationOfNode& at = network.of_node[p][n];
      const BankingFit& fit = fits[at.chain];
      RoadNode& node = result.roads.paths[p].nodes[n];
      node.banking = at.sign * std::atan(fit.slope[at.station]);
      node.crown = std::atan(fit.crown[at.station]);
      node.sigma_banking = fit.sigma_slope[at.station];
      node.banking_source = fit.source[at.station];
      ++nodes;
      if (fit.source[at.station] == BankingSource::dtm) ++measured;
    }
  result.measured_share = nodes > 0 ? static_cast<double>(measured) / static_cast<double>(nodes) : 0.0;
  return result;
}

}  // namespace orthodrive
