// SPDX-License-Identifier: Apache-2.0
// Random streets with random tags, spelled in several ways: whatever the order of the objects, their ids and the
// dialect, the network is the same.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <functional>
#include <random>
#include <set>

#include "io/places.hpp"
#include "io/scratch.hpp"
#include "orthodrive/io/support/vector_io.hpp"
#include "orthodrive/network/build_network.hpp"
#include "roadquery/surface/road_surface.hpp"
#include "sanitized.hpp"

namespace orthodrive {
namespace {
namespace fs = std::filesystem;
using Tags = std::vector<std::pair<std::string, std::string>>;

struct RandomNode {
  std::int64_t id = 0;
  double x = 0.0, y = 0.0;
  Tags tags;
};
struct RandomWay {
  std::int64_t id = 0;
  std::vector<std::int64_t> nodes;
  Tags tags;
};
struct RandomMap {
  std::vector<RandomNode> nodes;
  std::vector<RandomWay> ways;
};

/// Values of the wiki's lists, some of them at odds with each other.
class RandomTags {
 public:
  explicit RandomTags(unsigned seed) : random_(seed) {}
  bool one_in(int n) { return std::uniform_int_distribution<int>(1, n)(random_) == 1; }
  double between(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  std::string one_of(const std::vector<std::string>& values) {
    return values[std::uniform_int_distribution<std::size_t>(0, values.size() - 1)(random_)];
  }
  Tags of_way() {
    Tags tags{{"highway", one_of({"primary", "secondary", "tertiary", "residential", "unclassified", "service",
                                  "living_street", "trunk", "track"})}};
    const auto sometimes = [&](int n, const char* key, const std::vector<std::string>& values) {
      if (one_in(n)) tags.emplace_back(key, one_of(values));
    };
    sometimes(3, "lanes", {"1", "2", "3", "4", "2.5"});
    sometimes(5, "oneway", {"yes", "no", "-1", "1", "reversible"});
    sometimes(4, "maxspeed", {"50", "30 mph", "DE:rural", "walk", "signals", "fast"});
    sometimes(8, "maxspeed:forward", {"70", "GB:nsl_single"});
    sometimes(6, "width", {"6", "7.5 m", "20'", "wide"});
    sometimes(6, "sidewalk", {"both", "left", "right", "no", "separate"});
    sometimes(8, "cycleway", {"lane", "opposite_lane", "track"});
    sometimes(8, "busway", {"lane", "opposite_lane"});
    sometimes(8, "turn:lanes", {"left|through", "left|through;right", "left||right"});
    sometimes(10, "placement", {"right_of:1", "middle_of:1", "left_of:2", "transition"});
    sometimes(10, "surface", {"asphalt", "sett", "gravel", "moon"});
    sometimes(15, "bridge", {"yes", "no"});
    sometimes(15, "layer", {"1", "-1"});
    return tags;
  }
  Tags of_node() {
    if (!one_in(6)) return {};
    return {{"highway", one_of({"stop", "give_way", "traffic_signals", "crossing", "turning_circle"})}};
  }
  std::mt19937& generator() { return random_; }

 private:
  std::mt19937 random_;
};

/// Crossings of a bent grid of 5 by 5; streets of some of its edges, now and then two edges long.
RandomMap random_map(unsigned seed) {
  constexpr int edge = 5;
  RandomTags random(seed);
  RandomMap map;
  for (int i = 0; i < edge * edge; ++i)
    map.nodes.push_back({i + 1, 60.0 + 85.0 * (i % edge) + random.between(-12, 12),
                         60.0 + 85.0 * ((i - i % edge) / static_cast<double>(edge)) + random.between(-12, 12),
                         random.of_node()});
  const auto add = [&](std::vector<std::int64_t> nodes) {
    if (random.one_in(2)) std::ranges::reverse(nodes);
    map.ways.push_back({static_cast<std::int64_t>(1000 + map.ways.size()), std::move(nodes), random.of_way()});
  };
  for (int line = 0; line < edge; ++line)
    for (const int step : {1, edge}) {
      const int first = step == 1 ? edge * line + 1 : line + 1;
      for (int k = 0; k + 1 < edge; ++k) {
        if (random.one_in(4)) continue;
        const bool is_long = k + 2 < edge && random.one_in(3);
        std::vector<std::int64_t> nodes{first + k * step, first + (k + 1) * step};
        if (is_long) nodes.push_back(first + (++k + 1) * step);
        add(std::move(nodes));
      }
    }
  std::set<std::int64_t> used;
  for (const RandomWay& way : map.ways) used.insert(way.nodes.begin(), way.nodes.end());
  std::erase_if(map.nodes, [&](const RandomNode& node) { return !used.contains(node.id); });
  return map;
}

struct Place {
  std::string lon, lat;
};
Place place_of(const RandomNode& node) {
  static const CoordinateTransform lonlat_from_site(utm33, Crs{"EPSG:4326"});
  const Vec2 p = lonlat_from_site.target_from_source(origin + Vec2{node.x, node.y});
  return {fmt::format("{:.7f}", p.x), fmt::format("{:.7f}", p.y)};
}

std::string tags_xml(const Tags& tags) {
  std::string xml;
  for (const auto& [key, value] : tags) {
    std::string escaped = value;
    for (std::size_t at = 0; (at = escaped.find('\'', at)) != escaped.npos;) escaped.replace(at, 1, "&apos;");
    xml += fmt::format("<tag k='{}' v='{}'/>", key, escaped);
  }
  return xml;
}

std::vector<std::string> objects_of(const RandomMap& map, bool with_places = false) {
  std::vector<std::string> objects;
  if (!with_places)
    for (const RandomNode& node : map.nodes) {
      const Place p = place_of(node);
      objects.push_back(
          fmt::format("<node id='{}' lon='{}' lat='{}'>{}</node>\n", node.id, p.lon, p.lat, tags_xml(node.tags)));
    }
  for (const RandomWay& way : map.ways) {
    std::string xml = fmt::format("<way id='{}'>", way.id);
    for (const std::int64_t id : way.nodes) {
      const Place p = place_of(*std::ranges::find(map.nodes, id, &RandomNode::id));
      xml += with_places ? fmt::format("<nd ref='{}' lon='{}' lat='{}'/>", id, p.lon, p.lat)
                         : fmt::format("<nd ref='{}'/>", id);
    }
    objects.push_back(xml + tags_xml(way.tags) + "</way>\n");
  }
  return objects;
}

std::string osm_of(const std::vector<std::string>& objects) {
  return fmt::format("<?xml version='1.0' encoding='UTF-8'?>\n<osm version='0.6'>\n{}</osm>\n", fmt::join(objects, ""));
}

std::string overpass_of(const RandomMap& map) {
  const auto tags_json = [](const Tags& tags) {
    std::string json;
    for (const auto& [key, value] : tags) json += fmt::format("{}\"{}\":\"{}\"", json.empty() ? "" : ",", key, value);
    return json;
  };
  std::vector<std::string> elements;
  for (const RandomWay& way : map.ways)
    elements.push_back(fmt::format(R"({{"type":"way","id":{},"nodes":[{}],"tags":{{{}}}}})", way.id,
                                   fmt::join(way.nodes, ","), tags_json(way.tags)));
  for (const RandomNode& node : map.nodes) {
    const Place p = place_of(node);
    elements.push_back(fmt::format(R"({{"type":"node","id":{},"lat":{},"lon":{},"tags":{{{}}}}})", node.id, p.lat,
                                   p.lon, tags_json(node.tags)));
  }
  return fmt::format(R"({{"version":0.6,"elements":[{}]}})", fmt::join(elements, ","));
}

/// The same map, its objects numbered anew by a function of the old number.
RandomMap renumbered(RandomMap map, const std::function<std::int64_t(std::int64_t)>& number) {
  for (RandomNode& node : map.nodes) node.id = number(node.id);
  for (RandomWay& way : map.ways) {
    way.id = number(way.id);
    for (std::int64_t& node : way.nodes) node = number(node);
  }
  return map;
}

/// A network as text without ids: how many junctions, and every road by its two ends, its length, lanes and limits.
std::string told(const roadquery::RoadMap& map) {
  std::vector<std::string> lines;
  const auto place = [](const roadquery::Road& road, double s) {
    const auto q = roadquery::reference_point(road, s);
    return fmt::format("{:.3f},{:.3f}", q.x, q.y);
  };
  for (const roadquery::Road& road : map.roads) {
    std::string line = fmt::format("{} {} {} {:.3f} {:.1f}", road.junction >= 0 ? "connecting" : road.highway,
                                   place(road, 0.0), place(road, road.length), road.length, road.speed_limit_mps);
    for (const roadquery::LaneSection& section : road.sections)
      for (const auto* side : {&section.left, &section.right})
        for (const roadquery::Lane& lane : *side)
          line += fmt::format(" {}:{}:{:.1f}", lane.id, static_cast<int>(lane.type),
                              lane.speeds.empty() ? 0.0 : lane.speeds[0].mps);
    lines.push_back(line);
  }
  std::ranges::sort(lines);
  return fmt::format("{} junctions\n{}", map.junctions.size(), fmt::join(lines, "\n"));
}

class RandomMaps : public testing::TestWithParam<unsigned> {
 protected:
  std::string network_of(const std::vector<std::string>& texts) {
    std::vector<fs::path> files;
    for (std::size_t i = 0; i < texts.size(); ++i) {
      files.push_back(scratch_ / fmt::format("{}.osm", i));
      std::ofstream(files.back()) << texts[i];
    }
    return told(build_network(io::read_osm_roads(files, site_of(500))).map);
  }
  Scratch scratch_;
};

/// The first line in which two texts differ, with those around it in the other.
void expect_same(const std::string& expected, const std::string& found, const char* what) {
  if (expected == found) return;
  const auto lines_of = [](const std::string& text) {
    std::set<std::string> lines;
    for (std::size_t begin = 0; begin < text.size();) {
      const std::size_t end = std::min(text.find('\n', begin), text.size());
      lines.insert(text.substr(begin, end - begin));
      begin = end + 1;
    }
    return lines;
  };
  const std::set<std::string> a = lines_of(expected), b = lines_of(found);
  std::vector<std::string> lost, new_ones;
  std::ranges::set_difference(a, b, std::back_inserter(lost));
  std::ranges::set_difference(b, a, std::back_inserter(new_ones));
  ADD_FAILURE() << what << ": " << lost.size() << " lines of " << a.size() << " are others\n-"
                << fmt::format("{}", fmt::join(lost, "\n-")) << "\n+" << fmt::format("{}", fmt::join(new_ones, "\n+"));
}

TEST_P(RandomMaps, have_one_network_in_every_spelling) {
  const RandomMap map = random_map(GetParam());
  std::vector<std::string> objects = objects_of(map);
  const std::string expected = network_of({osm_of(objects)});
  EXPECT_GT(std::ranges::count(expected, '\n'), 10);

  std::mt19937 random(GetParam());
  std::ranges::shuffle(objects, random);
  expect_same(expected, network_of({osm_of(objects)}), "in another order");
  std::vector<std::string> half(objects.begin(), objects.begin() + static_cast<std::ptrdiff_t>(objects.size() / 2));
  expect_same(expected, network_of({osm_of(half), osm_of(objects)}), "in two extracts");
  expect_same(expected, network_of({overpass_of(map)}), "JSON of Overpass");
  const auto negative = [](std::int64_t id) { return -id; };
  expect_same(expected, network_of({osm_of(objects_of(renumbered(map, negative)))}), "negative ids");
  const auto large = [](std::int64_t id) { return id * 7919 % 100003 + 9'000'000'000; };
  expect_same(expected, network_of({osm_of(objects_of(renumbered(map, large)))}), "large ids in another order");
  RandomMap without_tags = map;
  for (RandomNode& node : without_tags.nodes) node.tags.clear();
  expect_same(network_of({osm_of(objects_of(without_tags))}), network_of({osm_of(objects_of(without_tags, true))}),
              "places in the ways");
}

INSTANTIATE_TEST_SUITE_P(Seeds, RandomMaps, testing::Range(1U, sanitized ? 4U : 13U));

}  // namespace
}  // namespace orthodrive
