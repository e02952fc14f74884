// SPDX-License-Identifier: Apache-2.0
// OpenDRIVE, element by element. Elements are told apart by their name and their parent's. What element_table.hpp does
// not have as read is passed over with all that is in it, and noted.

#include "roadquery/opendrive/opendrive_builder.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <map>
#include <optional>
#include <stdexcept>
#include <string_view>

#include "roadquery/map/road_map.hpp"
#include "roadquery/opendrive/broken_links.hpp"
#include "roadquery/opendrive/element_table.hpp"
#include "roadquery/opendrive/finish_road.hpp"
#include "roadquery/opendrive/header_offset.hpp"
#include "roadquery/opendrive/junction_surface_text.hpp"
#include "roadquery/opendrive/note_list.hpp"
#include "roadquery/opendrive/opendrive_attributes.hpp"
#include "roadquery/opendrive/opendrive_ids.hpp"
#include "roadquery/roads/connecting_road.hpp"
#include "roadquery/surface/junction_surface.hpp"
#include "roadquery/surface/poly_curve.hpp"

namespace roadquery {
namespace {

constexpr double longest_road_m = 1e6;  // memory and time of a query grow with the length
constexpr int most_lanes = 1000;        // to a side

LaneType lane_type(std::string_view name) {
  struct Entry {
    std::string_view name;
    LaneType type;
  };
  // What is for cars that run along it is "driving"; the other types that OpenDRIVE knows are "other".
  static constexpr Entry entries[] = {
      {"none", LaneType::none},         {"driving", LaneType::driving},
      {"shoulder", LaneType::shoulder}, {"border", LaneType::border},
      {"sidewalk", LaneType::sidewalk}, {"walking", LaneType::sidewalk},
      {"curb", LaneType::border},       {"parking", LaneType::parking},
      {"biking", LaneType::biking},     {"bidirectional", LaneType::bidirectional},
      {"entry", LaneType::driving},     {"exit", LaneType::driving},
      {"mwyEntry", LaneType::driving},  {"mwyExit", LaneType::driving},
      {"onRamp", LaneType::driving},    {"offRamp", LaneType::driving},
      {"slipLane", LaneType::driving},  {"connectingRamp", LaneType::driving},
      {"bus", LaneType::bus},           {"taxi", LaneType::taxi},
      {"HOV", LaneType::driving},
  };
  const auto* found =
      std::find_if(std::begin(entries), std::end(entries), [&](const Entry& e) { return e.name == name; });
  return found != std::end(entries) ? found->type : LaneType::other;
}

Cubic cubic(const Attributes& a, std::string_view s_name = "s") {
  return {a.number(s_name), a.number("a"), a.number("b"), a.number("c"), a.number("d")};
}

/// Which prefixes stand for OpenDRIVE's own names: none, that of the root, and those of a URI that names OpenDRIVE.
class NamespacePrefixes {
 public:
  void look(std::string_view element, const char** attributes) {
    for (const char** pair = attributes; *pair != nullptr; pair += 2) {
      const std::string_view name = pair[0];
      if (name.starts_with("xmlns:")) uris_[std::string(name.substr(6))] = lowered(pair[1]);
    }
    if (!root_) root_ = prefix_of(element);
  }
  [[nodiscard]] bool are_ours(std::string_view element) const {
    const std::string prefix = prefix_of(element);
    if (prefix.empty() || !root_ || prefix == *root_) return true;
    const auto uri = uris_.find(prefix), of_root = uris_.find(*root_);
    return uri != uris_.end() && (uri->second.find("opendrive") != std::string::npos ||
                                  (of_root != uris_.end() && of_root->second == uri->second));
  }

 private:
  static std::string prefix_of(std::string_view name) {
    const std::size_t colon = name.rfind(':');
    return std::string(colon == std::string_view::npos ? std::string_view{} : name.substr(0, colon));
  }
  std::map<std::string, std::string> uris_;
  std::optional<std::string> root_;
};

/// Builds the map element by element. Members point into the item under construction through back().
class Builder {
 public:
  RoadMap map;

  NoteList notes;

  void start(std::string_view written, const Attributes& a) {
    const std::string_view parent = path_.empty() ? std::string_view{} : std::string_view{path_.back()};
    names_.look(written, a.pairs());
    const std::string_view name = local_name(written);
    if (path_.empty() && name != "OpenDRIVE") {
      throw std::runtime_error("the root element is <" + std::string(name) + ">, not <OpenDRIVE>");
    }
    if (passed_ > 0) note_within_passed(parent, name, names_.are_ours(written));
    if (passed_ == 0 && !is_read(parent, name, names_.are_ours(written), a)) passed_ = path_.size() + 1;
    if (passed_ == 0) start_read(parent, name, a);
    path_.emplace_back(name);
  }

  void end(std::string_view /*name*/) {
    const std::string name = std::move(path_.back());
    path_.pop_back();
    if (passed_ > 0) {
      if (path_.size() + 1 == passed_) passed_ = 0;
      return;
    }
    const std::string_view parent = path_.empty() ? std::string_view{} : std::string_view{path_.back()};
    if (in_geometry_ && parent == "planView" && name == "geometry") {
      if (!has_shape_) throw std::runtime_error("<geometry> without a shape");
      in_geometry_ = false;
    }
    if (in_road_ && name == "road" && path_.size() == 1) end_road();
    if (in_junction_ && name == "junction" && path_.size() == 1) end_junction();
    if (name == "lane") lane_ = nullptr;
    if (name == "object") end_object();
  }

  void text(std::string_view characters) {
    if (passed_ == 0 && !path_.empty() && path_.back() == "geoReference") map.geo_reference += characters;
  }

  /// What can only be checked with the whole file read.
  void finish(HeaderOffset offset) {
    if (map.roads.empty()) throw std::runtime_error("no <road> in the file");
    if (!has_header_)
      notes.add("opendrive.version",
                "the file has no <header>: it is read as OpenDRIVE 1.0 to 1.8 without a place on Earth", false);
    note_broken_links(map, notes);
    number_ids();
    const auto by_id = [](const auto& p, const auto& q) { return p.id < q.id; };
    std::stable_sort(map.roads.begin(), map.roads.end(), by_id);
    std::stable_sort(map.junctions.begin(), map.junctions.end(), by_id);
    const auto same_id = [](const auto& p, const auto& q) { return p.id == q.id; };
    const auto twice = std::adjacent_find(map.roads.begin(), map.roads.end(), same_id);
    if (twice != map.roads.end()) {
      throw std::runtime_error("two roads have the id " +
                               (twice->text_id.empty() ? std::to_string(twice->id) : twice->text_id));
    }
    const std::size_t begin = map.geo_reference.find_first_not_of(" \t\r\n");
    const std::size_t last = map.geo_reference.find_last_not_of(" \t\r\n");
    map.geo_reference = begin == std::string::npos ? "" : map.geo_reference.substr(begin, last - begin + 1);
    apply_header_offset(map, offset, notes);
    for (Road& road : map.roads) inherit(road);
    join_arms(map);
    map.notes = notes.take();
    // Notes were taken while ids had no numbers yet.
    for (ReadingNote& note : map.notes)
      if (note.road != -1) note.road = road_ids_.final_number(note.road);
  }

 private:
  /// Whether the element is one that is read; notes it if not.
  bool is_read(std::string_view parent, std::string_view name, bool ours, const Attributes& a) {
    const OpenDriveElement* element = ours ? find_element(parent, name) : nullptr;
    if (element != nullptr && element->use == ElementUse::read && is_known_kind(parent, name, a)) return true;
    const std::string path = (parent.empty() ? "" : std::string(parent) + "/") + std::string(name);
    if (element == nullptr) {
      notes.add_unknown(path);
    } else if (element->use != ElementUse::missed) {
      notes.add_passed(path);
    } else if (name == "elevationGrid") {
      has_grid_ = true;  // beside our userData it says the same
    } else {
      notes.add("opendrive.not_read", "<" + path + "> is not read: " + std::string(element->instead), true, here());
    }
    return false;
  }
  /// Within an object that is passed over may be a piece of surface.
  void note_within_passed(std::string_view parent, std::string_view name, bool ours) {
    const OpenDriveElement* element = ours ? find_element(parent, name) : nullptr;
    if (element == nullptr || element->use != ElementUse::missed || parent != "object") return;
    notes.add("opendrive.not_read", "<object/" + std::string(name) + "> is not read: " + std::string(element->instead),
              true, here());
  }
  /// Of objects and userData some kinds are read.
  static bool is_known_kind(std::string_view parent, std::string_view name, const Attributes& a) {
    if (name == "userData") return is_known_data(parent, a.text("code"));
    return parent != "objects" || name != "object" || is_known_object(a);
  }
  static bool is_known_object(const Attributes& a) {
    const std::string type = a.text("type");
    return type == "crosswalk" || type == "roadMark" || (type == "patch" && a.text("subtype") == "speedHump");
  }

  static bool is_known_data(std::string_view parent, std::string_view code) {
    if (parent == "junction") return code == boundary_code || code == heights_code;
    return code == "osm_id" || code == "highway" || code == "layer" || code == "bridge" || code == "tunnel";
  }

  /// Of the open element.
  [[nodiscard]] NotePlace here() const {
    if (!in_road_) return {};
    const Road& road = map.roads.back();
    return {road.id, lane_ != nullptr && !road.sections.empty() ? road.sections.back().s : 0.0};
  }

  void start_read(std::string_view parent, std::string_view name, const Attributes& a) {
    if (path_.size() == 1) {
      start_top(name, a);
    } else if (parent == "header") {
      start_header_part(name, a);
    } else if (in_road_) {
      start_road_part(parent, name, a);
    } else if (in_junction_) {
      start_junction_part(parent, name, a);
    }
  }

  /// What refers to roads and junctions by provisional numbers gets the final ones.
  void number_ids() {
    road_ids_.finish(), junction_ids_.finish();
    const auto road_id = [&](int& id) { id = road_ids_.final_number(id); };
    const auto junction_id = [&](int& id) { id = junction_ids_.final_number(id); };
    for (Road& road : map.roads) {
      road.text_id = road_ids_.text(road.id);
      road_id(road.id);
      if (road.junction != -1) junction_id(road.junction);
      for (RoadLink* link : {&road.predecessor, &road.successor}) {
        if (link->kind == LinkKind::road) road_id(link->id);
        if (link->kind == LinkKind::junction) junction_id(link->id);
      }
    }
    for (Junction& junction : map.junctions) {
      junction_id(junction.id);
      for (Connection& connection : junction.connections)
        road_id(connection.incoming_road), road_id(connection.connecting_road);
      for (Priority& priority : junction.priorities) road_id(priority.high), road_id(priority.low);
    }
    note_numbers("road", road_ids_);
    note_numbers("junction", junction_ids_);
  }
  void note_numbers(const std::string& kind, const OpenDriveIds& ids) {
    if (ids.texts().empty()) return;
    const auto& [text, number] = *ids.texts().begin();
    notes.add("opendrive.text_ids",
              "ids of " + std::to_string(ids.texts().size()) + " " + kind +
                  "s are not whole numbers of 32 bits, they are numbered in alphabetical order: " + kind + " \"" +
                  text + "\" is " + std::to_string(number),
              false, {kind == "road" ? number : -1, 0.0});
  }

  /// What a connecting road does not say.
  void inherit(Road& road) const {
    Inherited from = inherited(map, road);
    if (road.osm_id.empty()) road.osm_id = std::move(from.osm_id);
    if (road.highway.empty()) road.highway = std::move(from.highway);
    if (road.speed_limit_mps == 0.0 && road.speed_limits.empty()) {
      if (std::isfinite(from.speed_limit_mps))
        road.speed_limit_mps = from.speed_limit_mps;
      else
        road.speed_limits = {{0.0, from.speed_limit_mps}};
    }
    if (!from.material) return;
    for (LaneSection& section : road.sections)
      for (auto* side : {&section.left, &section.right})
        for (Lane& lane : *side)
          if (is_driven(lane.type) && lane.materials.empty()) lane.materials = {*from.material};
  }

  /// 1.0 is what some write for 1.1.
  void note_version(const Attributes& a) {
    constexpr int newest_minor = 8;
    const auto number = [&](std::string_view attribute) {
      const std::string text = a.text(attribute);
      int value = -1;
      const auto [end, error] = number_from_text(trimmed(text), value);
      return error == std::errc{} ? value : -1;
    };
    const int major = number("revMajor"), minor = number("revMinor");
    if (major == 1 && minor >= 0 && minor <= newest_minor) return;
    notes.add("opendrive.version",
              "<header> has revMajor=\"" + a.text("revMajor") + "\" revMinor=\"" + a.text("revMinor") +
                  "\", known are 1.0 to 1.8: the file is read as if it were one of them",
              false);
  }

  void start_top(std::string_view name, const Attributes& a) {
    if (name == "header") {
      has_header_ = true;
      note_version(a);
      map.name = a.text("name");
      map.north = a.number("north", 0.0), map.south = a.number("south", 0.0);
      map.east = a.number("east", 0.0), map.west = a.number("west", 0.0);
    } else if (name == "road") {
      Road road;
      road.id = road_ids_.number(a.required("id"));
      road.name = a.text("name");
      road.length = a.number("length");
      const std::string junction = a.text("junction");
      road.junction = junction.empty() || junction == "-1" ? -1 : junction_ids_.number(junction);
      road.driving_side = a.text("rule") == "LHT" ? DrivingSide::left : DrivingSide::right;
      map.roads.push_back(std::move(road));
      parts_ = {}, is_single_side_ = false;
      in_road_ = true;
    } else if (name == "junction") {
      map.junctions.push_back({junction_ids_.number(a.required("id")), a.text("name"), {}, {}, {}});
      in_junction_ = true, has_grid_ = false;
    }
  }

  void start_header_part(std::string_view name, const Attributes& a) {
    if (name != "offset") return;
    map.header_offset_m = {a.number("x", 0.0), a.number("y", 0.0), a.number("z", 0.0)};
    map.header_offset_hdg = a.number("hdg", 0.0);
  }

  void start_road_part(std::string_view parent, std::string_view name, const Attributes& a) {
    Road& road = map.roads.back();
    if (parent == "road" && name == "userData") {
      read_user_data(road, a);
    } else if (parent == "link" && lane_ == nullptr && (name == "predecessor" || name == "successor")) {
      (name == "predecessor" ? road.predecessor : road.successor) = read_link(a);
    } else if (parent == "road" && name == "type") {
      road.speed_limits.push_back({a.number("s", 0.0), 0.0});
    } else if (parent == "type" && name == "speed") {
      road.speed_limits.back().mps = read_speed(a);
    } else if (parent == "planView" && name == "geometry") {
      road.plan.push_back({a.number("s"), a.number("x"), a.number("y"), a.number("hdg"), a.number("length"), Line{}});
      if (road.plan.back().length < 0.0) throw std::runtime_error("<geometry> has a negative length");
      in_geometry_ = true, has_shape_ = false;
    } else if (parent == "geometry" && in_geometry_) {
      read_shape(road.plan.back(), name, a);
    } else if (parent == "elevationProfile" && name == "elevation") {
      road.elevation.push_back(cubic(a));
    } else if (parent == "lateralProfile" && name == "superelevation") {
      road.superelevation.push_back(cubic(a));
    } else if (parent == "lateralProfile" && name == "crossfall") {
      read_crossfall(a);
    } else if (parent == "lateralProfile" && name == "shape") {
      road.shape.push_back({a.number("s"), a.number("t"), a.number("a"), a.number("b"), a.number("c"), a.number("d")});
    } else if (is_surface_part(parent, name)) {
      start_surface_part(parent, name, a);
    } else if (parent == "objects" && path_.size() == 3 && name == "object") {
      start_object(road, a);
    } else if (parent == "objects" && (name == "bridge" || name == "tunnel")) {
      const double s = a.number("s", 0.0);
      (name == "bridge" ? road.bridges : road.tunnels).push_back({s, s + a.number("length", road.length - s)});
    } else if (object_ != nullptr && (parent == "object" || parent == "outlines") && name == "outline") {
      ++outlines_;
    } else if (object_ != nullptr && outlines_ == 1 && parent == "outline" && name == "cornerRoad") {
      object_->outline.push_back({a.number("s"), a.number("t")});
    } else if (parent == "surface" && path_.size() == 3 && name == "CRG") {
      read_crg(road, a);
    } else if (parent == "lanes" && name == "laneOffset") {
      road.lane_offset.push_back(cubic(a));
    } else if (parent == "lanes" && name == "laneSection") {
      lane_ = nullptr;  // would point into the old place of the sections
      road.sections.emplace_back();
      road.sections.back().s = a.number("s");
      is_single_side_ = a.flag("singleSide");
      if (is_single_side_) parts_.single_sides.push_back({road.sections.back().s});
    } else if (parent == "laneSection" && (name == "left" || name == "right")) {
      if (is_single_side_)
        (name == "left" ? parts_.single_sides.back().has_left : parts_.single_sides.back().has_right) = true;
    } else if ((parent == "left" || parent == "center" || parent == "right") && name == "lane") {
      start_lane(road, parent, a);
    } else if (lane_ != nullptr) {
      start_lane_part(parent, name, a);
    }
  }

  static bool is_surface_part(std::string_view parent, std::string_view name) {
    return name == "crossSectionSurface" || parent == "crossSectionSurface" || parent == "surfaceStrips" ||
           parent == "strip" || name == "coefficients";
  }
  void start_surface_part(std::string_view parent, std::string_view name, const Attributes& a) {
    if (name == "crossSectionSurface") {
      parts_.surface = {};
    } else if (parent == "surfaceStrips") {
      parts_.surface.strips.push_back({a.integer("id"), a.text("mode") == "relative"});
    } else if (std::vector<Cubic>* list = name == "coefficients" ? surface_list(parent) : nullptr) {
      list->push_back({a.number("s"), a.number("a", 0.0), a.number("b", 0.0), a.number("c", 0.0), a.number("d", 0.0)});
    }
  }
  /// Which of the open strip's lists, or of the surface, an element is.
  std::vector<Cubic>* surface_list(std::string_view name) {
    if (name == "tOffset") return &parts_.surface.t_offset;
    if (parts_.surface.strips.empty()) return nullptr;
    SurfaceStrip& strip = parts_.surface.strips.back();
    return name == "width"       ? &strip.width
           : name == "constant"  ? &strip.constant
           : name == "linear"    ? &strip.linear
           : name == "quadratic" ? &strip.quadratic
           : name == "cubic"     ? &strip.cubic
                                 : nullptr;
  }

  static void read_user_data(Road& road, const Attributes& a) {
    const std::string code = a.text("code"), value = a.text("value");
    const auto flag = [&] { return value == "true" || value == "yes" || value == "1"; };
    if (code == "osm_id") road.osm_id = value;
    if (code == "highway") road.highway = value;
    if (code == "layer") road.layer = a.integer("value");
    if (code == "bridge") road.bridge = flag();
    if (code == "tunnel") road.tunnel = flag();
  }

  /// m/s; infinity for "no limit", 0 for "undefined" and what is no speed.
  double read_speed(const Attributes& a) {
    constexpr double mps_per_kmh = 1.0 / 3.6, mps_per_mph = 0.44704;
    const std::string max = lowered(trimmed(a.text("max"))), unit = lowered(trimmed(a.text("unit")));
    if (max == "no limit") return std::numeric_limits<double>::infinity();
    if (max.empty() || max == "undefined") return 0.0;
    const double value = Attributes::number_of<double>(max).value_or(0.0);
    if (!(value > 0.0)) {
      notes.add("opendrive.speed", "<speed> has max=\"" + max + "\", which is no speed: it is taken as not given", true,
                here());
      return 0.0;
    }
    const bool is_kmh = unit == "km/h" || unit == "kmh" || unit == "kph", is_mph = unit == "mph";
    if (!is_kmh && !is_mph && !unit.empty() && unit != "m/s")
      notes.add("opendrive.speed", "<speed> has unit=\"" + unit + "\", need m/s, km/h or mph: it is taken as m/s", true,
                here());
    return value * (is_kmh ? mps_per_kmh : is_mph ? mps_per_mph : 1.0);
  }

  void read_crossfall(const Attributes& a) {
    const std::string side = a.text("side");
    if (side != "right") parts_.crossfall_left.push_back(cubic(a));
    if (side != "left") parts_.crossfall_right.push_back(cubic(a));
  }

  /// Writers leave links empty where there is nothing to link to; then there is no link.
  bool names_something(const Attributes& a, std::string_view attribute) {
    if (!trimmed(a.text(attribute)).empty()) return true;
    notes.add("opendrive.empty_link", "elements that link have no " + std::string(attribute) + ": they link to nothing",
              false, here());
    return false;
  }

  RoadLink read_link(const Attributes& a) {
    const bool junction = a.text("elementType") == "junction";
    if (!names_something(a, "elementId")) return {};
    const std::string_view id = a.required("elementId");
    if (trimmed(id) == "-1") return {};
    return {junction ? LinkKind::junction : LinkKind::road, (junction ? junction_ids_ : road_ids_).number(id),
            a.text("contactPoint") == "end" ? ContactPoint::end : ContactPoint::start};
  }

  void read_shape(PlanElement& element, std::string_view name, const Attributes& a) {
    if (name == "line") {
      element.shape = Line{};
    } else if (name == "arc") {
      element.shape = Arc{a.number("curvature")};
    } else if (name == "spiral") {
      element.shape = Spiral{a.number("curvStart"), a.number("curvEnd")};
    } else if (name == "paramPoly3") {
      // pRange is normalized when it is not given (1.4, 5.3.4.1.5).
      const ParamPoly3 poly{a.number("aU"), a.number("bU"), a.number("cU"),
                            a.number("dU"), a.number("aV"), a.number("bV"),
                            a.number("cV"), a.number("dV"), a.text("pRange") != "arcLength"};
      element.shape = poly;
      note_start(element, poly);
      note_length(element, poly);
    } else if (name == "poly3") {
      element.shape = from_poly3({0.0, a.number("a"), a.number("b"), a.number("c"), a.number("d")}, element.length);
    } else {
      return;
    }
    has_shape_ = true;
  }

  /// The standard wants aU, aV and bV to be 0, and bU above it (1.7, 9.3.5).
  void note_start(const PlanElement& element, const ParamPoly3& poly) {
    constexpr double place_off_m = 1e-3, heading_off_rad = 1e-3;
    if (std::hypot(poly.a_u, poly.a_v) <= place_off_m && std::abs(std::atan2(poly.b_v, poly.b_u)) <= heading_off_rad)
      return;
    notes.add(
        "opendrive.curve_start",
        "a <paramPoly3> does not begin at the place and in the direction of its <geometry>, it is taken as written",
        true, {map.roads.back().id, element.s});
  }

  /// A hundredth is more than any rounding.
  void note_length(const PlanElement& element, const ParamPoly3& poly) {
    constexpr double most_off = 0.01;
    const double length_m = curve_length(element, poly);
    if (!(element.length > 0.0) || std::abs(length_m / element.length - 1.0) <= most_off) return;
    notes.add("opendrive.curve_length",
              "the curve of a <paramPoly3> is not as long as its <geometry> says, it is stretched to that length", true,
              {map.roads.back().id, element.s});
  }

  static void read_crg(Road& road, const Attributes& a) {
    SurfaceCrg crg;
    crg.file = a.text("file");
    crg.s_start = a.number("sStart"), crg.s_end = a.number("sEnd");
    crg.orientation = a.text("orientation"), crg.mode = a.text("mode"), crg.purpose = a.text("purpose");
    if (crg.purpose.empty()) crg.purpose = "elevation";  // what it means when it is not given
    crg.s_offset = a.number("sOffset", 0.0), crg.t_offset = a.number("tOffset", 0.0);
    crg.z_offset = a.number("zOffset", 0.0), crg.z_scale = a.number("zScale", 1.0);
    crg.h_offset = a.number("hOffset", 0.0);
    crg.x_offset = a.number("xOffset", 0.0), crg.y_offset = a.number("yOffset", 0.0);
    road.surface.push_back(std::move(crg));
  }

  void start_object(Road& road, const Attributes& a) {
    RoadObject object{a.text("type"), a.text("subtype"), a.text("name")};
    object.s = a.number("s"), object.t = a.number("t");
    object.hdg = a.number("hdg", 0.0);
    object.length = a.number("length", 0.0), object.width = a.number("width", 0.0);
    object.height = a.number("height", 0.0);
    road.objects.push_back(std::move(object));
    object_ = &road.objects.back(), outlines_ = 0;
  }

  /// An outline has two corners at least (1.7, 13.5.2); what has neither it nor a box is nowhere.
  void end_object() {
    if (object_ == nullptr) return;
    const NotePlace place{map.roads.back().id, object_->s};
    if (object_->outline.size() == 1) {
      object_->outline.clear();
      notes.add("opendrive.object_outline", "an <outline> of <object> has a single corner: its length and width count",
                false, place);
    }
    if (object_->outline.empty() && !(object_->length > 0.0 && object_->width > 0.0))
      notes.add("opendrive.object_outline",
                "a crosswalk, road mark or hump has neither length and width nor cornerRoad: it is not drawn", false,
                place);
    object_ = nullptr;
  }

  void start_lane(Road& road, std::string_view side, const Attributes& a) {
    if (road.sections.empty()) return;  // a <lane> outside a lane section: not ours
    LaneSection& section = road.sections.back();
    Lane lane;
    lane.id = a.integer("id");
    if (std::abs(static_cast<std::int64_t>(lane.id)) > most_lanes)
      throw std::runtime_error("a lane has the id " + std::to_string(lane.id));
    lane.type = lane_type(a.text("type"));
    read_direction(lane, a);
    note_lane_attributes(a);
    lane.level = a.flag("level");
    if (side == "center" ? lane.id != 0 : (side == "left") != (lane.id > 0) || lane.id == 0) {
      throw std::runtime_error("lane " + std::to_string(lane.id) + " stands under <" + std::string(side) + ">");
    }
    if (side == "center") {
      section.center = std::move(lane);
      lane_ = &section.center;
    } else {
      std::vector<Lane>& lanes = side == "left" ? section.left : section.right;
      lanes.push_back(std::move(lane));
      lane_ = &lanes.back();
    }
  }

  /// 1.8 has it in place of the type "bidirectional".
  void read_direction(Lane& lane, const Attributes& a) {
    const std::string direction = a.text("direction");
    if (direction == "both" && lane.type == LaneType::driving) lane.type = LaneType::bidirectional;
    if (direction == "reversed" && lane.type == LaneType::driving)
      notes.add("opendrive.lane_direction",
                "driving lanes have direction=\"reversed\", which is not read: they lead as their side says", true,
                here());
  }
  /// Of 1.8, about lanes that change by the hour or that others may use.
  void note_lane_attributes(const Attributes& a) {
    for (const char* name : {"advisory", "dynamicLaneDirection", "dynamicLaneType", "roadWorks"}) {
      const std::string value = a.text(name);
      if (value.empty() || value == "none" || value == "false" || value == "0") continue;
      notes.add("opendrive.not_read",
                std::string("<lane> has ") + name + "=\"" + value + "\", which is not read: its type counts", true,
                here());
    }
  }

  void start_lane_part(std::string_view parent, std::string_view name, const Attributes& a) {
    if (parent == "lane" && name == "width" && lane_->id != 0) {
      lane_->width.push_back(cubic(a, "sOffset"));
    } else if (parent == "lane" && name == "border" && lane_->id != 0) {
      read_border(cubic(a, "sOffset"));
    } else if (parent == "lane" && name == "access" && lane_->id != 0) {
      read_access(a);
    } else if (parent == "access" && name == "restriction" && lane_->id != 0) {
      parts_.accesses.back().whom.push_back(a.text("type"));
    } else if (parent == "lane" && name == "speed" && lane_->id != 0) {
      lane_->speeds.push_back({a.number("sOffset", 0.0), read_speed(a)});
    } else if (parent == "lane" && name == "roadMark") {
      read_road_mark(a);
    } else if (name == "line" && (parent == "type" || parent == "explicit") && !lane_->marks.empty()) {
      read_mark_line(parent == "explicit", a);
    } else if (parent == "lane" && name == "material" && lane_->id != 0) {
      read_material(*lane_, a);
    } else if (parent == "lane" && name == "height" && lane_->id != 0) {
      read_height(*lane_, a);
    } else if (parent == "link" && name == "predecessor") {
      if (names_something(a, "id")) lane_->predecessor = a.integer("id");
    } else if (parent == "link" && name == "successor") {
      if (names_something(a, "id")) lane_->successor = a.integer("id");
    }
  }

  void read_road_mark(const Attributes& a) {
    constexpr double bold_m = 0.25;  // as esmini takes it
    const RoadMark usual;
    const std::string color = lowered(trimmed(a.text("color")));
    lane_->marks.push_back({a.number("sOffset"), lowered(trimmed(a.text("type"))),
                            a.number("width", a.text("weight") == "bold" ? bold_m : usual.width),
                            color.empty() ? usual.color : color});
    note_road_mark(lane_->marks.back());
  }
  /// Names of 1.8.1 (e_roadMarkType, e_roadMarkColor).
  void note_road_mark(const RoadMark& mark) {
    constexpr std::string_view types[] = {"botts dots", "broken", "broken broken", "broken solid",
                                          "curb",       "custom", "edge",          "grass",
                                          "none",       "solid",  "solid broken",  "solid solid"};
    constexpr std::string_view colors[] = {"black",    "blue",   "green", "orange", "red",
                                           "standard", "violet", "white", "yellow"};
    const auto has = [](const auto& names, const std::string& name) {
      return std::find(std::begin(names), std::end(names), name) != std::end(names);
    };
    if (!has(types, mark.type))
      notes.add("opendrive.road_mark", "<roadMark> has type=\"" + mark.type + "\", which nothing is painted for", false,
                here());
    if (!has(colors, mark.color))
      notes.add("opendrive.road_mark", "<roadMark> has color=\"" + mark.color + "\", it is taken as white", false,
                here());
  }
  void read_mark_line(bool is_single_stroke, const Attributes& a) {
    lane_->marks.back().lines.push_back({a.number("length", 0.0), a.number("space", 0.0), a.number("tOffset", 0.0),
                                         a.number("sOffset", 0.0), a.number("width", 0.0),
                                         lowered(trimmed(a.text("color"))), is_single_stroke});
  }

  /// Before 1.6 there was no rule: a restriction was of those whom the lane is closed to.
  void read_access(const Attributes& a) {
    RoadParts::Access access{map.roads.back().sections.size() - 1, lane_->id, a.number("sOffset", 0.0)};
    access.allows = a.text("rule") == "allow";
    if (a.find("restriction") != nullptr) access.whom.push_back(a.text("restriction"));
    parts_.accesses.push_back(std::move(access));
  }

  void read_border(const Cubic& t) {
    const std::size_t section = map.roads.back().sections.size() - 1;
    if (parts_.borders.empty() || parts_.borders.back().section != section || parts_.borders.back().lane != lane_->id)
      parts_.borders.push_back({section, lane_->id, {}});
    parts_.borders.back().t.push_back(t);
  }

  /// Texts that nobody knows are asphalt: the friction counts, and it stands beside them.
  void read_material(Lane& lane, const Attributes& a) {
    LaneMaterial material;
    material.s_offset = a.number("sOffset", 0.0);
    material.surface = surface_class_of(a.text("surface")).value_or(SurfaceClass::asphalt);
    material.friction = a.number("friction", material.friction);
    material.roughness = a.number("roughness", 0.0);
    if (material.friction < 0.0) throw std::runtime_error("<material> has a negative friction");
    if (material.roughness < 0.0) throw std::runtime_error("<material> has a negative roughness");
    if (material.friction == 0.0) {
      notes.add("opendrive.friction",
                "<material> has friction=\"0\", which writers mean as not given: it is taken as 1", true, here());
      material.friction = LaneMaterial{}.friction;
    }
    lane.materials.push_back(material);
  }

  static void read_height(Lane& lane, const Attributes& a) {
    lane.heights.push_back({a.number("sOffset"), a.number("inner", 0.0), a.number("outer", 0.0)});
  }

  void start_junction_part(std::string_view parent, std::string_view name, const Attributes& a) {
    Junction& junction = map.junctions.back();
    if (parent == "junction" && name == "connection") {
      Connection connection;
      connection.id = static_cast<int>(junction.connections.size());
      int id = 0;  // of any text: nothing refers to it
      const std::string text = a.text("id");
      if (const auto [end, error] = number_from_text(text, id);
          error == std::errc{} && end == text.data() + text.size())
        connection.id = id;
      // A virtual junction's connections (1.7) have no incoming road; a direct junction's name a linked road.
      if (a.find("incomingRoad") != nullptr) connection.incoming_road = road_ids_.number(a.required("incomingRoad"));
      connection.connecting_road =
          road_ids_.number(a.required(a.find("linkedRoad") != nullptr ? "linkedRoad" : "connectingRoad"));
      connection.contact = a.text("contactPoint") == "end" ? ContactPoint::end : ContactPoint::start;
      junction.connections.push_back(std::move(connection));
    } else if (parent == "junction" && name == "priority") {
      read_priority(junction, a);
    } else if (parent == "connection" && name == "laneLink" && !junction.connections.empty()) {
      if (names_something(a, "from") && names_something(a, "to"))
        junction.connections.back().lane_links.push_back({a.integer("from"), a.integer("to")});
    } else if (parent == "junction" && name == "userData") {
      read_junction_data(junction, a.text("code"), a.text("value"));
    }
  }

  void read_priority(Junction& junction, const Attributes& a) {
    if (!trimmed(a.text("high")).empty() && !trimmed(a.text("low")).empty()) {
      junction.priorities.push_back({road_ids_.number(a.required("high")), road_ids_.number(a.required("low"))});
      return;
    }
    notes.add("opendrive.priority", "<priority> of junctions lacks high or low: who goes first there is not told", true,
              connecting_road(junction));
  }
  /// A place of a junction: on the first of its roads.
  static NotePlace connecting_road(const Junction& junction) {
    if (junction.connections.empty()) return {};
    return {junction.connections.front().connecting_road, 0.0};
  }

  static void read_junction_data(Junction& junction, const std::string& code, const std::string& value) {
    if (code != boundary_code && code != heights_code) return;
    if (!junction.surface) junction.surface.emplace();
    if (code == boundary_code) read_boundary(value, *junction.surface);
    if (code == heights_code) read_heights(value, *junction.surface);
  }

  void end_junction() {
    in_junction_ = false;
    const Junction& junction = map.junctions.back();
    check_surface(junction);
    if (has_grid_ && !junction.surface)
      notes.add(
          "opendrive.not_read",
          "<junction/elevationGrid> is not read: " + std::string(find_element("junction", "elevationGrid")->instead),
          true);
  }

  void check_surface(const Junction& junction) const {
    if (!junction.surface || (!junction.surface->boundary.empty() && !junction.surface->z.empty())) return;
    const std::string id = junction_ids_.text(junction.id);
    throw std::runtime_error("junction " + (id.empty() ? std::to_string(junction.id) : id) +
                             " has only one of the userData " + boundary_code + " and " + heights_code);
  }

  void end_road() {
    in_road_ = false;
    Road& road = map.roads.back();
    const std::string id = road_ids_.text(road.id), who = "road " + (id.empty() ? std::to_string(road.id) : id);
    if (road.plan.empty()) throw std::runtime_error(who + " has no <geometry> in a <planView>");
    if (road.sections.empty()) throw std::runtime_error(who + " has no <laneSection>");
    if (road.length < 0.0) throw std::runtime_error(who + " has a negative length");
    if (road.length > longest_road_m)
      throw std::runtime_error(who + " is longer than 1000 km: is its length in metres?");
    finish_road(road, std::move(parts_), notes);
    if (is_boundary_alone(road)) map.roads.pop_back();
  }

  /// Of a junction and without lanes: part of its <boundary> (1.8, 12.10), no surface.
  static bool is_boundary_alone(const Road& road) {
    return road.junction >= 0 &&
           std::all_of(road.sections.begin(), road.sections.end(),
                       [](const LaneSection& section) { return section.left.empty() && section.right.empty(); });
  }

  std::vector<std::string> path_;  ///< names of the open elements, without prefixes
  std::size_t passed_ = 0;         ///< depth of the element that is passed over with all that is in it; 0: none
  NamespacePrefixes names_;
  OpenDriveIds road_ids_, junction_ids_;
  RoadParts parts_;              ///< of the open <road>
  bool is_single_side_ = false;  ///< the open <laneSection>
  bool has_grid_ = false;        ///< the open <junction> has an <elevationGrid>
  bool has_header_ = false;
  bool in_road_ = false, in_junction_ = false;
  bool in_geometry_ = false;      ///< of the plan view
  bool has_shape_ = false;        ///< of that <geometry>
  Lane* lane_ = nullptr;          ///< the open <lane>
  RoadObject* object_ = nullptr;  ///< the open <object>
  int outlines_ = 0;              ///< of it, as yet
};

}  // namespace

struct OpenDriveBuilder::State {
  Builder builder;
};

OpenDriveBuilder::OpenDriveBuilder() : state_(std::make_unique<State>()) {}
OpenDriveBuilder::~OpenDriveBuilder() = default;
void OpenDriveBuilder::start(const char* name, const char** attributes) {
  state_->builder.start(name, Attributes(name, attributes));
}
void OpenDriveBuilder::end(const char* name) { state_->builder.end(name); }
void OpenDriveBuilder::text(std::string_view characters) { state_->builder.text(characters); }
void OpenDriveBuilder::note_encoding(const std::string& what) {
  state_->builder.notes.add("opendrive.encoding", what, false);
}
RoadMap OpenDriveBuilder::finish(HeaderOffset offset) {
  state_->builder.finish(offset);
  return std::move(state_->builder.map);
}

}  // namespace roadquery
