// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/model/roads/road_network.hpp"

#include <algorithm>
#include <array>
#include <iterator>
#include <tuple>
#include <utility>

namespace orthodrive {
namespace {
struct HighwayClass {
  const char* value;
  int rank;
  double lane_m;      ///< width of a lane
  int lanes_two_way;  ///< lanes of an untagged two-way road
  int lanes_one_way;
  double edge_m;     ///< paved strip outside the outer lanes, both sides together
  double speed_kmh;  ///< limit where none is tagged
};
// Lane widths: German RAL 2012 / RASt 06 typical cross sections, rounded; service roads measured on the Pardubice
// photo's tags. Speeds: the limits of towns in Central Europe (50; living streets 20), motorways and trunk roads as out
// of town; slip roads, service roads and tracks at what they are built for, as no law names them.
constexpr std::array classes{
    HighwayClass{"motorway", 9, 3.75, 4, 2, 3.0, 130.0},    HighwayClass{"motorway_link", 6, 4.0, 2, 1, 1.5, 80.0},
    HighwayClass{"trunk", 8, 3.5, 4, 2, 1.5, 90.0},         HighwayClass{"trunk_link", 6, 4.0, 2, 1, 1.5, 60.0},
    HighwayClass{"primary", 7, 3.5, 2, 2, 0.5, 50.0},       HighwayClass{"primary_link", 5, 4.0, 2, 1, 1.0, 50.0},
    HighwayClass{"secondary", 6, 3.25, 2, 2, 0.5, 50.0},    HighwayClass{"secondary_link", 5, 4.0, 2, 1, 0.5, 50.0},
    HighwayClass{"tertiary", 5, 3.0, 2, 2, 0.5, 50.0},      HighwayClass{"tertiary_link", 4, 4.0, 2, 1, 0.5, 50.0},
    HighwayClass{"raceway", 4, 8.0, 1, 1, 0.0, 0.0},        HighwayClass{"unclassified", 3, 2.75, 2, 1, 0.5, 50.0},
    HighwayClass{"residential", 3, 2.75, 2, 1, 0.0, 50.0},  HighwayClass{"road", 3, 2.75, 2, 1, 0.0, 50.0},
    HighwayClass{"living_street", 2, 2.5, 2, 1, 0.0, 20.0}, HighwayClass{"service", 1, 2.0, 2, 1, 0.0, 30.0},
    HighwayClass{"track", 0, 3.0, 1, 1, 0.0, 30.0},         HighwayClass{"busway", 4, 3.25, 2, 1, 0.5, 50.0}};

const HighwayClass* find_class(const std::string& highway) {
  const auto it =
      std::find_if(classes.begin(), classes.end(), [&](const HighwayClass& c) { return highway == c.value; });
  return it == classes.end() ? nullptr : &*it;
}
}  // namespace

double default_width_m(const std::string& highway, int lanes, Oneway oneway) {
  const HighwayClass* c = find_class(highway);
  if (!c) return 4.0;
  // A narrow one-way lane still gets 3.5 m: parked cars and kerbs need it.
  const int count = lanes > 0 ? lanes : (oneway == Oneway::no ? c->lanes_two_way : c->lanes_one_way);
  return std::max(3.0, count * c->lane_m + c->edge_m) + (count == 1 && c->lane_m < 3.5 ? 0.5 : 0.0);
}

std::vector<std::string_view> lane_words(std::string_view list) {
  std::vector<std::string_view> words;
  if (list.empty()) return words;
  for (std::size_t begin = 0; begin <= list.size();) {
    const std::size_t end = std::min(list.find('|', begin), list.size());
    words.push_back(list.substr(begin, end - begin));
    begin = end + 1;
  }
  return words;
}

Box2 bounds_of_roads(const RoadNetwork& roads) {
  Ring nodes;
  for (const RoadPath& path : roads.paths)
    for (const RoadNode& node : path.nodes) nodes.push_back(node.p);
  return bounds_of(nodes);
}

std::vector<std::string_view> side_lanes_of(const RoadPath& path) {
  std::vector<std::string_view> words;
  const std::string_view text = path.side_lanes;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find(' ', begin), text.size());
    if (end > begin) words.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return words;
}

double cycle_lanes_m(const RoadPath& path) {
  constexpr double cycle_lane_m = 1.5;  // RASt 06: 1.85 m with its line, 1.5 m for lanes that cars may cross
  return cycle_lane_m * static_cast<double>(std::ranges::count_if(
                            side_lanes_of(path), [](std::string_view word) { return word.starts_with("bicycle:"); }));
}

int shared_lanes(const RoadPath& path) {
  if (path.oneway != Oneway::no || path.lanes_forward > 0 || path.lanes_backward > 0) return 0;
  return path.lanes == 1 ? 1 : path.lanes_both_ways == path.lanes ? path.lanes : 0;
}

namespace {
constexpr std::string_view sign_names[] = {
    "stop",           "give_way",        "traffic_signals", "zebra",  "signal_crossing",
    "plain_crossing", "mini_roundabout", "traffic_calming", "barrier"};
}  // namespace

bool sign_before(const NodeSign& a, const NodeSign& b) {
  return std::tie(a.osm_node, a.kind, a.value, a.direction) < std::tie(b.osm_node, b.kind, b.value, b.direction);
}

const char* to_string(NodeSignKind kind) { return sign_names[static_cast<std::size_t>(kind)].data(); }

std::optional<NodeSignKind> node_sign_kind_of(std::string_view text) {
  const auto found = std::find(std::begin(sign_names), std::end(sign_names), text);
  if (found == std::end(sign_names)) return std::nullopt;
  return static_cast<NodeSignKind>(found - std::begin(sign_names));
}

int road_rank(const std::string& highway) {
  const HighwayClass* c = find_class(highway);
  return c ? c->rank : 1;
}

double default_speed_limit_kmh(const std::string& highway) {
  const HighwayClass* c = find_class(highway);
  return c ? c->speed_kmh : 30.0;
}

bool is_drivable(const std::string& highway) { return find_class(highway) != nullptr; }

void measure_path(RoadPath& path) {
  for (std::size_t i = 0; i < path.nodes.size(); ++i)
    path.nodes[i].s_m = i == 0 ? 0.0 : path.nodes[i - 1].s_m + distance(path.nodes[i - 1].p, path.nodes[i].p);
}

Polyline centerline(const RoadPath& path) {
  Polyline line;
  line.reserve(path.nodes.size());
  for (const RoadNode& node : path.nodes) line.push_back(node.p);
  return line;
}

Ring surface_ring(const RoadPath& path) {
  std::vector<double> half;
  half.reserve(path.nodes.size());
  for (const RoadNode& node : path.nodes) half.push_back(0.5 * node.width_m);
  return strip_ring(centerline(path), half, half);
}

std::vector<Ring> surface_cells(const RoadPath& path) {
  const Ring ring = surface_ring(path);  // right side forwards, then left side backwards
  std::vector<Ring> cells;
  for (std::size_t i = 0; i + 1 < path.nodes.size(); ++i) {
    Ring cell = convex_hull({ring[i], ring[i + 1], ring[ring.size() - 2 - i], ring[ring.size() - 1 - i]});
    if (cell.size() >= 3) cells.push_back(std::move(cell));
  }
  return cells;
}

namespace {
constexpr std::array<std::pair<BankingSource, const char*>, 7> banking_source_names{
    {{BankingSource::unset, ""},
     {BankingSource::none, "none"},
     {BankingSource::dtm, "dtm"},
     {BankingSource::log, "log"},
     {BankingSource::interpolated, "interpolated"},
     {BankingSource::design, "design"},
     {BankingSource::truth, "truth"}}};
}  // namespace

const char* to_string(BankingSource source) {
  for (const auto& [value, name] : banking_source_names)
    if (value == source) return name;
  return "";
}

BankingSource banking_source_of(std::string_view text) {
  for (const auto& [value, name] : banking_source_names)
    if (text == name) return value;
  return BankingSource::unset;
}

namespace {
/// A list of lanes from right to left.
std::string turned_list(const std::string& list) {
  const std::vector<std::string_view> words = lane_words(list);
  std::string turned;
  for (std::size_t i = words.size(); i-- > 0;) {
    turned += words[i];
    if (i > 0) turned += '|';
  }
  return turned;
}
}  // namespace

void turn_round(RoadPath& path) {
  const double length = path.nodes.back().s_m;
  std::reverse(path.nodes.begin(), path.nodes.end());
  for (RoadNode& node : path.nodes) {
    node.s_m = length - node.s_m;
    node.offset_m = -node.offset_m, node.gradient = -node.gradient, node.banking = -node.banking;
  }
  const auto mirrored = [](Sides s) { return s == Sides::left ? Sides::right : s == Sides::right ? Sides::left : s; };
  path.sidewalk = mirrored(path.sidewalk), path.shoulder = mirrored(path.shoulder);
  std::swap(path.turn_forward, path.turn_backward);
  std::swap(path.use_forward, path.use_backward);
  std::swap(path.speeds_forward, path.speeds_backward);
  std::swap(path.widths_forward, path.widths_backward);
  path.widths_both_ways = turned_list(path.widths_both_ways);
  if (path.oneway == Oneway::no) std::swap(path.lanes_forward, path.lanes_backward);
  std::swap(path.placement.start, path.placement.end);
  path.placement.backward = !path.placement.backward;
  std::string turned;
  for (const std::string_view word : side_lanes_of(path)) {
    const auto colon = word.find(':');
    const std::string_view side = word.substr(std::min(colon, word.size() - 1) + 1);
    turned += turned.empty() ? "" : " ";
    turned += word.substr(0, colon + 1);
    turned += side == "left" ? "right" : side == "right" ? "left" : side == "along" ? "against" : "along";
  }
  path.side_lanes = turned;
}

}  // namespace orthodrive
