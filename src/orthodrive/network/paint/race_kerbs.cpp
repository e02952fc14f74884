// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/paint/race_kerbs.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <vector>

#include "orthodrive/geo/angle.hpp"
#include "orthodrive/model/roads/highway_class.hpp"
#include "orthodrive/network/junctions/roads_over.hpp"
#include "orthodrive/network/lanes/lanes.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace orthodrive::network {
namespace {

using roadquery::Lane;
using roadquery::LaneType;
using roadquery::Road;
using roadquery::RoadMap;

constexpr double kerb_step_m = 2.0, half_window_m = 20.0, shortest_bend_m = 15.0, shortest_kerb_m = 8.0;
constexpr double place_step_m = 1.0;   // between the places of widths and heights
constexpr double kerb_margin_m = 0.3;  // kept to other carriageways

bool is_track(const Road& road) { return is_raceway(road.highway) && road.junction < 0 && road.sections.size() == 1; }

/// A road of a track and where on it it begins.
struct Member {
  std::size_t road = 0;
  bool reversed = false;
  double begin_m = 0.0;
};

/// Between two places of a track.
struct Interval {
  double from_m = 0.0, to_m = 0.0;
};

/// Roads that follow each other without a junction.
struct Track {
  std::vector<Member> members;
  double length_m = 0.0;
  bool closed = false;
  std::array<std::vector<Interval>, 2> kerbs;    ///< on the left and on the right
  std::array<std::vector<Interval>, 2> blocked;  ///< there is no room

  /// Share of the whole width of a kerb.
  [[nodiscard]] double share(std::size_t side, double at_m) const {
    double share = 0.0;
    const auto for_laps = [&](const auto& use) {
      for (const double lap : {-1.0, 0.0, 1.0})
        if (closed || lap == 0.0) use(at_m + lap * length_m);
    };
    for_laps([&](double at) {
      for (const Interval& kerb : kerbs[side])
        share = std::max(share,
                         std::min({1.0, (at - kerb.from_m) / race_kerb_taper_m, (kerb.to_m - at) / race_kerb_taper_m}));
    });
    for_laps([&](double at) {
      for (const Interval& taken : blocked[side])
        share = std::min(share, std::max({0.0, taken.from_m - at, at - taken.to_m}) / race_kerb_taper_m);
    });
    return share;
  }
};

class Tracks {
 public:
  explicit Tracks(const RoadMap& map) : map_(map) {
    for (std::size_t i = 0; i < map.roads.size(); ++i) index_of_[map.roads[i].id] = i;
  }
  [[nodiscard]] std::vector<Track> find() const {
    std::vector<bool> taken(map_.roads.size(), false);
    std::vector<Track> tracks;
    for (std::size_t i = 0; i < map_.roads.size(); ++i) {
      if (taken[i] || !is_track(map_.roads[i])) continue;
      Member first{i, false};
      for (std::optional<Member> before = after({i, true}); before && before->road != i; before = after(*before))
        first = {before->road, !before->reversed};
      Track track;
      for (std::optional<Member> next = first; next; next = after(*next)) {
        if (taken[next->road]) {
          track.closed = next->road == first.road;
          break;
        }
        taken[next->road] = true;
        track.members.push_back({next->road, next->reversed, track.length_m});
        track.length_m += map_.roads[next->road].length;
      }
      tracks.push_back(std::move(track));
    }
    return tracks;
  }

 private:
  [[nodiscard]] std::optional<Member> after(const Member& member) const {
    const Road& road = map_.roads[member.road];
    const roadquery::RoadLink& link = member.reversed ? road.predecessor : road.successor;
    if (link.kind != roadquery::LinkKind::road) return std::nullopt;
    const auto next = index_of_.find(link.id);
    if (next == index_of_.end() || !is_track(map_.roads[next->second])) return std::nullopt;
    return Member{next->second, link.contact == roadquery::ContactPoint::end};
  }
  const RoadMap& map_;
  std::map<int, std::size_t> index_of_;
};

/// s on a member's road.
double s_of(const RoadMap& map, const Member& member, double at_m) {
  const double length = map.roads[member.road].length, along = std::clamp(at_m - member.begin_m, 0.0, length);
  return member.reversed ? length - along : along;
}

const Member& member_at(const Track& track, double at_m) {
  const auto after = std::upper_bound(track.members.begin() + 1, track.members.end(), at_m,
                                      [](double v, const Member& m) { return v < m.begin_m; });
  return *(after - 1);
}

/// Mean curvature over the window, at places step_m apart.
std::vector<double> curvatures(const RoadMap& map, const Track& track) {
  const auto count = static_cast<std::ptrdiff_t>(std::max(1.0, std::floor(track.length_m / kerb_step_m)));
  std::vector<double> heading;
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const double at_m = kerb_step_m * static_cast<double>(i);
    const Member& member = member_at(track, at_m);
    const double hdg = roadquery::reference_point(map.roads[member.road], s_of(map, member, at_m)).hdg +
                       (member.reversed ? std::numbers::pi : 0.0);
    heading.push_back(heading.empty() ? hdg : heading.back() + wrapped_angle(hdg - heading.back()));
  }
  const double turn = heading.back() + wrapped_angle(heading.front() - heading.back()) - heading.front();
  const auto half = static_cast<std::ptrdiff_t>(half_window_m / kerb_step_m);
  const auto at = [&](std::ptrdiff_t i) {
    const std::ptrdiff_t lap = i < 0 ? -1 : i >= count ? 1 : 0;
    return heading[static_cast<std::size_t>(i - lap * count)] + static_cast<double>(lap) * turn;
  };
  std::vector<double> curvature;
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const bool wraps = track.closed && count > 2 * half;
    const std::ptrdiff_t from = wraps ? i - half : std::max<std::ptrdiff_t>(0, i - half),
                         to = wraps ? i + half : std::min(count - 1, i + half);
    curvature.push_back(to > from ? (at(to) - at(from)) / (kerb_step_m * static_cast<double>(to - from)) : 0.0);
  }
  return curvature;
}

/// Stations of one turn.
struct Bend {
  std::ptrdiff_t first = 0, last = 0;              ///< may lie beyond the seam of a closed track
  std::ptrdiff_t tight_first = 0, tight_last = 0;  ///< where it is at least half as tight as in its tightest place
  bool is_left = false;
};

std::vector<Bend> find_bends(const std::vector<double>& curvature, bool closed) {
  const auto count = static_cast<std::ptrdiff_t>(curvature.size());
  const auto at = [&](std::ptrdiff_t i) { return curvature[static_cast<std::size_t>(i % count)]; };
  constexpr double least = 1.0 / race_bend_radius_m;
  // Begins on a straight, if there is one, so that no bend lies on the seam.
  std::ptrdiff_t start = 0;
  while (closed && start < count && std::abs(at(start)) >= least) ++start;
  if (start == count) start = 0;
  std::vector<Bend> bends;
  for (std::ptrdiff_t i = start; i < start + count;) {
    if (std::abs(at(i)) < least) {
      ++i;
      continue;
    }
    Bend bend{i, i, i, i, at(i) > 0.0};
    double most = 0.0;
    while (bend.last + 1 < start + count && std::abs(at(bend.last + 1)) >= least &&
           (at(bend.last + 1) > 0.0) == bend.is_left)
      ++bend.last;
    for (std::ptrdiff_t k = bend.first; k <= bend.last; ++k) most = std::max(most, std::abs(at(k)));
    const auto is_tight = [&](std::ptrdiff_t k) { return std::abs(at(k)) >= 0.5 * most; };
    for (bend.tight_first = bend.first; !is_tight(bend.tight_first);) ++bend.tight_first;
    for (bend.tight_last = bend.last; !is_tight(bend.tight_last);) --bend.tight_last;
    i = bend.last + 1;
    if (kerb_step_m * static_cast<double>(bend.last - bend.first) >= shortest_bend_m) bends.push_back(bend);
  }
  return bends;
}

void find_kerbs(const RoadMap& map, Track& track) {
  const std::vector<double> curvature = curvatures(map, track);
  const auto place = [](std::ptrdiff_t i) { return kerb_step_m * static_cast<double>(i); };
  for (const Bend& bend : find_bends(curvature, track.closed)) {
    const std::size_t inner = bend.is_left ? 0 : 1, outer = 1 - inner;
    const auto add = [&](std::size_t side, Interval kerb) {
      if (!track.closed) kerb = {std::max(0.0, kerb.from_m), std::min(track.length_m, kerb.to_m)};
      if (kerb.to_m - kerb.from_m >= shortest_kerb_m) track.kerbs[side].push_back(kerb);
    };
    add(inner, {place(bend.tight_first), place(bend.tight_last)});
    const Member& member = member_at(track, std::fmod(place(bend.tight_last), track.length_m));
    const Road& road = map.roads[member.road];
    if (!lanes_of_direction(road, !member.reversed).empty())
      add(outer, {place(bend.tight_last), place(bend.last) + exit_kerb_m});
    if (!lanes_of_direction(road, member.reversed).empty())
      add(outer, {place(bend.first) - exit_kerb_m, place(bend.tight_first)});
  }
}

/// The side of a member's road.
bool is_left_of_road(const Member& member, std::size_t side) { return (side == 0) != member.reversed; }

void find_blocked(const RoadsOver& roads, const RoadMap& map, Track& track) {
  for (const Member& member : track.members) {
    const Road& road = map.roads[member.road];
    const int steps = std::max(1, static_cast<int>(std::ceil(road.length / place_step_m)));
    for (int i = 0; i <= steps; ++i) {
      const double at_m = member.begin_m + road.length * i / steps, s = s_of(map, member, at_m);
      const roadquery::Edges edges = roadquery::road_edges(road, s);
      for (const std::size_t side : {std::size_t{0}, std::size_t{1}}) {
        if (track.share(side, at_m) <= 0.0) continue;
        const bool left = is_left_of_road(member, side);
        const auto is_taken = [&](double off_m) {
          const auto p = roadquery::surface_point(road, s, left ? edges.left_t + off_m : edges.right_t - off_m);
          return roads.is_carriageway(p, member.road) || roads.is_junction(p);
        };
        if (is_taken(kerb_margin_m) || is_taken(0.5 * race_kerb_m) || is_taken(race_kerb_m + kerb_margin_m))
          track.blocked[side].push_back({at_m - place_step_m, at_m + place_step_m});
      }
    }
  }
}

/// Values at places of a road, straight between them.
struct Shares {
  double apart_m = 0.0;
  std::vector<double> at;
  /// Calls use(index of the place) where the slope changes.
  template <typename Use>
  void for_bends(const Use& use) const {
    constexpr double same = 1e-9;
    for (std::size_t i = 0; i < at.size(); ++i)
      if (i == 0 || i + 1 == at.size() || std::abs(at[i + 1] - 2.0 * at[i] + at[i - 1]) > same) use(i);
  }
};

Shares shares_of(const RoadMap& map, const Track& track, const Member& member, std::size_t side) {
  const double length = map.roads[member.road].length;
  const int steps = std::max(1, static_cast<int>(std::ceil(length / place_step_m)));
  Shares shares{length / steps, {}};
  for (int i = 0; i <= steps; ++i) {
    const double along = length * i / steps;
    shares.at.push_back(track.share(side, member.begin_m + (member.reversed ? length - along : along)));
  }
  return shares;
}

void add_lane(const Shares& shares, bool left, Weather weather, Road& road) {
  std::vector<Lane>& lanes = left ? road.sections.front().left : road.sections.front().right;
  const int number = static_cast<int>(lanes.size()) + 1;
  Lane lane{.id = left ? number : -number, .type = LaneType::border};
  shares.for_bends([&](std::size_t i) {
    const double s = shares.apart_m * static_cast<double>(i);
    lane.heights.push_back({s, 0.0, race_kerb_rise_m * shares.at[i]});
    if (i + 1 < shares.at.size())
      lane.width.push_back(
          {s, race_kerb_m * shares.at[i], race_kerb_m * (shares.at[i + 1] - shares.at[i]) / shares.apart_m, 0.0, 0.0});
  });
  lane.materials = {lane_material(SurfaceClass::concrete, weather)};
  lane.marks.push_back({0.0, "none", 0.0});
  lanes.push_back(std::move(lane));
}

Lane* kerb_of(Road& road, bool left) {
  for (Lane& lane : left ? road.sections.front().left : road.sections.front().right)
    if (lane.type == LaneType::border) return &lane;
  return nullptr;
}

void link_lanes(const Track& track, RoadMap& map) {
  const std::size_t joints = track.members.size() - (track.closed ? 0 : 1);
  for (std::size_t i = 0; i < joints; ++i) {
    const Member &from = track.members[i], &to = track.members[(i + 1) % track.members.size()];
    for (const std::size_t side : {std::size_t{0}, std::size_t{1}}) {
      Lane* a = kerb_of(map.roads[from.road], is_left_of_road(from, side));
      Lane* b = kerb_of(map.roads[to.road], is_left_of_road(to, side));
      if (a == nullptr || b == nullptr) continue;
      (from.reversed ? a->predecessor : a->successor) = b->id;
      (to.reversed ? b->successor : b->predecessor) = a->id;
    }
  }
}

}  // namespace

void add_race_kerbs(RoadMap& map, Weather weather) {
  std::vector<Track> tracks = Tracks(map).find();
  if (tracks.empty()) return;
  for (Track& track : tracks) find_kerbs(map, track);
  {
    const RoadsOver roads(map);
    for (Track& track : tracks) find_blocked(roads, map, track);
  }
  for (const Track& track : tracks) {
    for (const Member& member : track.members)
      for (const std::size_t side : {std::size_t{0}, std::size_t{1}}) {
        const Shares shares = shares_of(map, track, member, side);
        if (std::ranges::any_of(shares.at, [](double share) { return share > 0.0; }))
          add_lane(shares, is_left_of_road(member, side), weather, map.roads[member.road]);
      }
    link_lanes(track, map);
  }
}

}  // namespace orthodrive::network
