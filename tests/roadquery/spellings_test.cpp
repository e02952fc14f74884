// SPDX-License-Identifier: Apache-2.0
// Random maps, spelt as OpenDRIVE 1.1 to 1.8 allow and as their writers do: the same surface, lanes, limits and links.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <map>
#include <string>
#include <tuple>
#include <vector>

#include "roadquery/opendrive/level_lanes.hpp"
#include "roadquery/query/road_query.hpp"
#include "roadquery/roads/road_structures.hpp"
#include "roadquery/roads/speed_limits.hpp"
#include "roadquery/spell_opendrive.hpp"
#include "sanitized.hpp"

namespace roadquery {
namespace {

using test::Encoding;
using test::MapSpelling;

std::string utf8_of_latin1(const std::string& text) {
  std::string result;
  for (const char c : text) {
    const auto code = static_cast<unsigned char>(c);
    if (code < 0x80)
      result += c;
    else
      result += static_cast<char>(0xc0u | (code >> 6)), result += static_cast<char>(0x80u | (code & 0x3fu));
  }
  return result;
}

/// As the random map should be read.
RoadMap truth_of(const test::RandomMap& random) {
  RoadMap map;
  NoteList notes;
  for (const test::RandomRoad& made : random.roads) {
    Road road = made.road;
    keep_level_lanes(road, notes);
    road.name = utf8_of_latin1(road.name);
    for (RoadObject& object : road.objects) object.name = utf8_of_latin1(object.name);
    map.roads.push_back(std::move(road));
  }
  map.junctions = random.junctions;
  for (Junction& junction : map.junctions) junction.name = utf8_of_latin1(junction.name);
  return map;
}

/// A map as it was read, beside what it should be.
class Comparison {
 public:
  Comparison(const test::RandomMap& random, const RoadMap& truth, const RoadMap& read, const MapSpelling& how)
      : random_(random), truth_(truth), read_(read) {
    for (const auto& [is_road, count] : {std::pair{true, truth.roads.size()}, {false, truth.junctions.size()}})
      for (std::size_t i = 0; i < count; ++i) {
        const int id = is_road ? truth.roads[i].id : truth.junctions[i].id;
        const std::string written = test::written_id(id, how);
        for (const Road& road : read.roads)
          if (is_road && (road.text_id.empty() ? std::to_string(road.id) : road.text_id) == written)
            road_ids_[road.id] = id;
        for (const Junction& junction : read.junctions)
          if (!is_road && junction.name == truth.junctions[i].name) junction_ids_[junction.id] = id;
      }
  }

  void roads(test::Dice& dice) {
    ASSERT_EQ(road_ids_.size(), truth_.roads.size());
    ASSERT_EQ(read_.roads.size(), truth_.roads.size());
    for (const Road& got : read_.roads) {
      const auto index = static_cast<std::size_t>(road_ids_.at(got.id));
      const Road& truth = truth_.roads[index];
      SCOPED_TRACE("road " + std::to_string(truth.id));
      ASSERT_EQ(truth.name, got.name);
      ASSERT_EQ(truth.length, got.length);
      ASSERT_EQ(truth.driving_side, got.driving_side);
      links(truth, got);
      objects(truth, got);
      for (int i = 0; i < 120; ++i) {
        const double s = dice.between(0.0, truth.length);
        surface(random_.roads[index], truth, got, s, dice);
        limits(truth, got, s);
        if (testing::Test::HasFatalFailure()) return;
      }
      for (int i = 0; i < 25; ++i) lanes(truth, got, dice.between(0.0, truth.length));
    }
  }
  void junctions() {
    ASSERT_EQ(junction_ids_.size(), truth_.junctions.size());
    for (const Junction& got : read_.junctions) {
      const Junction& truth = *std::find_if(truth_.junctions.begin(), truth_.junctions.end(),
                                            [&](const Junction& j) { return j.id == junction_ids_.at(got.id); });
      std::map<int, const Connection*> by_id;
      for (const Connection& c : got.connections) by_id[c.id] = &c;
      ASSERT_EQ(truth.connections.size(), by_id.size());
      for (const Connection& c : truth.connections) {
        const Connection& other = *by_id.at(c.id);
        ASSERT_EQ(c.incoming_road, road_ids_.at(other.incoming_road));
        ASSERT_EQ(c.connecting_road, road_ids_.at(other.connecting_road));
        ASSERT_EQ(c.contact, other.contact);
        ASSERT_EQ(c.lane_links.size(), other.lane_links.size());
        for (std::size_t i = 0; i < c.lane_links.size(); ++i) {
          ASSERT_EQ(c.lane_links[i].from, other.lane_links[i].from);
          ASSERT_EQ(c.lane_links[i].to, other.lane_links[i].to);
        }
      }
      ASSERT_EQ(truth.priorities.size(), got.priorities.size());
      for (std::size_t i = 0; i < truth.priorities.size(); ++i) {
        ASSERT_EQ(truth.priorities[i].high, road_ids_.at(got.priorities[i].high));
        ASSERT_EQ(truth.priorities[i].low, road_ids_.at(got.priorities[i].low));
      }
    }
  }
  /// What the tables of a query say, which are made of lists that may be cut otherwise.
  void query(const RoadQuery& truth, test::Dice& dice) const {
    constexpr double table_m = 1e-4;  // of two tables with other stations
    const RoadQuery got(read_);
    for (std::size_t i = 0; i < read_.roads.size(); ++i) {
      const auto index = static_cast<std::size_t>(road_ids_.at(read_.roads[i].id));
      for (int k = 0; k < 40; ++k) {
        const double s = dice.between(0.0, truth_.roads[index].length), t = dice.between(-8.0, 8.0);
        const auto p = truth.at(index, s, t), q = got.at(i, s, t);
        ASSERT_EQ(p.has_value(), q.has_value());
        if (!p || is_at_step(random_.roads[index], s)) continue;
        ASSERT_NEAR(p->z, q->z, random_.roads[index].has_level ? 5e-4 : table_m) << "at " << s << ", " << t;
        ASSERT_EQ(p->lane_id, q->lane_id);
        ASSERT_EQ(p->surface, q->surface) << "at " << s << ", " << t;
        ASSERT_EQ(p->friction, q->friction);
        ASSERT_EQ(p->roughness_m, q->roughness_m);
      }
    }
  }

 private:
  void links(const Road& truth, const Road& got) {
    ASSERT_EQ(truth.junction, got.junction < 0 ? -1 : junction_ids_.at(got.junction));
    for (const auto member : {&Road::predecessor, &Road::successor}) {
      const RoadLink &p = truth.*member, &q = got.*member;
      ASSERT_EQ(p.kind, q.kind);
      ASSERT_EQ(p.contact, q.contact);
      if (p.kind == LinkKind::road) ASSERT_EQ(p.id, road_ids_.at(q.id));
      if (p.kind == LinkKind::junction) ASSERT_EQ(p.id, junction_ids_.at(q.id));
    }
  }
  void objects(const Road& truth, const Road& got) {
    ASSERT_EQ(truth.objects.size(), got.objects.size());
    for (std::size_t i = 0; i < truth.objects.size(); ++i) {
      const RoadObject &p = truth.objects[i], &q = got.objects[i];
      ASSERT_EQ(std::tie(p.type, p.subtype, p.name, p.s, p.t, p.hdg, p.length, p.width, p.outline),
                std::tie(q.type, q.subtype, q.name, q.s, q.t, q.hdg, q.length, q.width, q.outline));
    }
    ASSERT_EQ(truth.surface.size(), got.surface.size());
    for (std::size_t i = 0; i < truth.surface.size(); ++i) {
      const SurfaceCrg &p = truth.surface[i], &q = got.surface[i];
      ASSERT_EQ(std::tie(p.file, p.s_start, p.s_end, p.orientation, p.mode, p.purpose, p.s_offset, p.t_offset,
                         p.z_offset, p.z_scale, p.h_offset),
                std::tie(q.file, q.s_start, q.s_end, q.orientation, q.mode, q.purpose, q.s_offset, q.t_offset,
                         q.z_offset, q.z_scale, q.h_offset));
    }
    ASSERT_EQ(truth.bridge, got.bridge);
    ASSERT_EQ(truth.tunnel, got.tunnel);
    for (double s = 0.1; s < truth.length; s += 0.7) ASSERT_EQ(is_on_structure(truth, s), is_on_structure(got, s));
  }
  /// Between the two slopes of a crossfall that changes at once rounding counts a hundredfold.
  static bool is_at_step(const test::RandomRoad& random, double s) {
    return std::any_of(random.crossfall.begin(), random.crossfall.end(),
                       [s](const test::CrossfallStep& step) { return std::abs(s - step.s) < 0.02; });
  }
  static void surface(const test::RandomRoad& random, const Road& truth, const Road& got, double s, test::Dice& dice) {
    if (is_at_step(random, s)) return;
    constexpr double exact_m = 1e-9, level_m = 5e-4;
    for (int i = 0; i < 5; ++i) {
      const double t = dice.between(-9.0, 9.0);
      const SurfacePoint p = surface_point(truth, s, t), q = surface_point(got, s, t);
      ASSERT_NEAR(p.x, q.x, exact_m) << "at " << s << ", " << t;
      ASSERT_NEAR(p.y, q.y, exact_m) << "at " << s << ", " << t;
      ASSERT_NEAR(p.z, q.z, random.has_level ? level_m : exact_m) << "at " << s << ", " << t;
      for (int axis = 0; axis < 3 && !random.has_level; ++axis) ASSERT_NEAR(p.normal[axis], q.normal[axis], exact_m);
      ASSERT_EQ(lane_id_at(truth, s, t), lane_id_at(got, s, t)) << "at " << s << ", " << t;
    }
  }
  static void limits(const Road& truth, const Road& got, double s) {
    for (const int lane : {0, 1, -1, 2, -2, -3}) {
      const double p = lane_limit_mps(truth, lane, s), q = lane_limit_mps(got, lane, s);
      if (std::isfinite(p))
        ASSERT_NEAR(p, q, 1e-9) << "of lane " << lane << " at " << s;
      else
        ASSERT_EQ(p, q) << "of lane " << lane << " at " << s;
    }
  }
  static void lanes(const Road& truth, const Road& got, double s) {
    const LaneSection &p = section_at(truth, s), &q = section_at(got, s);
    ASSERT_EQ(p.s, q.s);
    marks(p.center, q.center, s - p.s);
    for (const auto side : {&LaneSection::left, &LaneSection::right}) {
      ASSERT_EQ((p.*side).size(), (q.*side).size()) << "at " << s;
      for (std::size_t i = 0; i < (p.*side).size(); ++i) lane((p.*side)[i], (q.*side)[i], s - p.s);
    }
  }
  static void lane(const Lane& p, const Lane& q, double s) {
    SCOPED_TRACE("lane " + std::to_string(p.id));
    ASSERT_EQ(p.id, q.id);
    ASSERT_EQ(p.type, q.type);
    ASSERT_EQ(p.level, q.level);
    ASSERT_EQ(p.predecessor, q.predecessor);
    ASSERT_EQ(p.successor, q.successor);
    ASSERT_EQ(allowed(p), allowed(q));
    ASSERT_NEAR(lane_width(p, s), lane_width(q, s), 1e-9);
    marks(p, q, s);
  }
  static void marks(const Lane& p, const Lane& q, double s) {
    const auto mark_at = [s](const Lane& lane) {
      RoadMark found;
      for (const RoadMark& mark : lane.marks)
        if (mark.s_offset <= s) found = mark;
      return std::pair(found.type, found.width);
    };
    ASSERT_EQ(mark_at(p), mark_at(q));
  }
  static std::vector<std::string> allowed(const Lane& lane) {
    std::vector<std::string> who = lane.allowed;
    if (who.empty() && lane.type == LaneType::bus) who = {"bus"};
    if (who.empty() && lane.type == LaneType::taxi) who = {"taxi"};
    std::sort(who.begin(), who.end());
    return who;
  }

  const test::RandomMap& random_;
  const RoadMap &truth_, &read_;
  std::map<int, int> road_ids_, junction_ids_;  ///< as numbered by the reader: as in the truth
};

MapSpelling random_spelling(int minor, test::Dice& dice) {
  MapSpelling how{minor, false, dice.one_in(2), dice.one_in(2), dice.one_in(2), {}};
  how.xml.encoding = static_cast<Encoding>(dice.below(7));
  if (minor >= 6 && dice.one_in(3)) how.xml.prefix = "odr";
  how.xml.has_namespace = minor >= 6 && dice.one_in(2);
  how.xml.any_order = dice.one_in(2);
  how.xml.with_noise = dice.one_in(2);
  return how;
}

class Spellings : public testing::TestWithParam<unsigned> {};

TEST_P(Spellings, of_one_map_read_to_one_surface) {
  const unsigned seed = GetParam();
  const char* kept = std::getenv("ORTHODRIVE_SPELT");  // a folder for the files, to look at
  const test::RandomMap random = test::random_map(seed, 6);
  const RoadMap truth = truth_of(random);
  const RoadQuery truth_query(truth);
  test::Dice dice(seed + 7);
  int count = 0;
  for (const int minor : {0, 1, 2, 3, 4, 5, 6, 7, 8, 8, 6, 4}) {
    const std::string file = (kept != nullptr ? kept : testing::TempDir()) + "/spelt_" + std::to_string(seed) + "_" +
                             std::to_string(count++) + ".xodr";
    const MapSpelling how = minor == 0 ? MapSpelling{} : random_spelling(minor, dice);
    const unsigned spelling_seed = seed * 100 + static_cast<unsigned>(dice.below(100));
    std::ofstream(file, std::ios::binary) << test::spell_opendrive(random, how, spelling_seed);
    SCOPED_TRACE("1." + std::to_string(how.minor) + (how.plain ? " plain" : "") + ", " + file);
    const RoadMap read = read_opendrive(file);
    for (const ReadingNote& note : read.notes)
      ASSERT_TRUE(note.code != "opendrive.unknown_element" && note.code != "opendrive.not_read") << note.message;
    Comparison comparison(random, truth, read, how);
    comparison.roads(dice);
    if (HasFatalFailure()) return;
    comparison.junctions();
    if (HasFatalFailure()) return;
    comparison.query(truth_query, dice);
    if (HasFatalFailure()) return;
  }
}

TEST_P(Spellings, cut_at_structures_are_one_surface) {
  const RoadMap whole = truth_of(test::random_map(GetParam(), 12)), cut = cut_at_structures(whole);
  test::Dice dice(GetParam());
  const auto road_of = [&](int id) {
    return &*std::find_if(cut.roads.begin(), cut.roads.end(), [id](const Road& road) { return road.id == id; });
  };
  for (const Road& road : whole.roads) {
    SCOPED_TRACE("road " + std::to_string(road.id));
    const Road* piece = road_of(road.id);
    for (double begin = 0.0; begin < road.length - 1e-6; piece = road_of(piece->successor.id)) {
      for (int i = 0; i < 60; ++i) {
        const double in_piece = dice.between(0.0, piece->length), s = begin + in_piece, t = dice.between(-9.0, 9.0);
        const SurfacePoint p = surface_point(road, s, t), q = surface_point(*piece, in_piece, t);
        ASSERT_NEAR(p.x, q.x, 1e-9);
        ASSERT_NEAR(p.y, q.y, 1e-9);
        ASSERT_NEAR(p.z, q.z, 1e-9) << "at " << s << ", " << t;
        ASSERT_EQ(lane_id_at(road, s, t), lane_id_at(*piece, in_piece, t)) << "at " << s << ", " << t;
        for (const int lane : {-1, 1, -2})
          ASSERT_EQ(lane_limit_mps(road, lane, s), lane_limit_mps(*piece, lane, in_piece));
        if (is_on_structure(road, s - 0.5) == is_on_structure(road, s + 0.5))  // ends are rounded to that
          ASSERT_EQ(is_on_structure(road, s), is_on_structure(*piece, in_piece));
      }
      begin += piece->length;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Maps, Spellings,
                         testing::ValuesIn(orthodrive::unless_sanitized(
                             [] {
                               std::vector<unsigned> seeds(16);
                               for (unsigned i = 0; i < seeds.size(); ++i) seeds[i] = i + 1;
                               return seeds;
                             }(),
                             6)));

}  // namespace
}  // namespace roadquery
