// SPDX-License-Identifier: Apache-2.0
// OpenDRIVE, element by element. Elements are told apart by their name and their parent's; what the structs of
// road_map.hpp do not hold (signals, objects of other kinds, ...) is passed over.

#include "roadquery/opendrive_builder.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <stdexcept>
#include <string_view>

#include "roadquery/connecting_road.hpp"
#include "roadquery/junction_surface.hpp"
#include "roadquery/junction_surface_text.hpp"
#include "roadquery/number_text.hpp"
#include "roadquery/road_map.hpp"

namespace roadquery {
namespace {

constexpr double longest_road_m = 1e6;  // memory and time of a query grow with the length
constexpr int most_lanes = 1000;        // to a side

/// The attributes of one element, checked as they are read.
class Attributes {
 public:
  Attributes(std::string_view element, const char** pairs) : element_(element), pairs_(pairs) {}

  [[nodiscard]] const char* find(std::string_view name) const {
    for (const char** pair = pairs_; *pair != nullptr; pair += 2) {
      if (name == pair[0]) return pair[1];
    }
    return nullptr;
  }
  [[nodiscard]] std::string text(std::string_view name) const {
    const char* value = find(name);
    return value != nullptr ? value : "";
  }
  [[nodiscard]] double number(std::string_view name) const { return parse<double>(name, required(name)); }
  [[nodiscard]] double number(std::string_view name, double fallback) const {
    const char* value = find(name);
    return value != nullptr ? parse<double>(name, value) : fallback;
  }
  [[nodiscard]] int integer(std::string_view name) const { return parse<int>(name, required(name)); }

  template <typename T>
  [[nodiscard]] T parse(std::string_view name, std::string_view value) const {
    while (!value.empty() && std::strchr(" \t\r\n", value.front()) != nullptr) value.remove_prefix(1);
    while (!value.empty() && std::strchr(" \t\r\n", value.back()) != nullptr) value.remove_suffix(1);
    if (value.starts_with('+')) value.remove_prefix(1);
    T result{};
    const auto [end, error] = number_from_text(value, result);
    bool good = error == std::errc{} && end == value.data() + value.size();
    if constexpr (std::is_floating_point_v<T>) good = good && std::isfinite(result);
    if (!good) {
      throw std::runtime_error("<" + element_ + "> has " + std::string(name) + "=\"" + std::string(value) +
                               "\", which is not " + (std::is_integral_v<T> ? "an integer" : "a number"));
    }
    return result;
  }

 private:
  [[nodiscard]] std::string_view required(std::string_view name) const {
    const char* value = find(name);
    if (value == nullptr) throw std::runtime_error("<" + element_ + "> lacks the attribute " + std::string(name));
    return value;
  }

  std::string element_;
  const char** pairs_;
};

LaneType lane_type(std::string_view name) {
  struct Entry {
    std::string_view name;
    LaneType type;
  };
  // Everything a car may use is "driving"; the other types that OpenDRIVE knows are "other".
  static constexpr Entry entries[] = {
      {"none", LaneType::none},         {"driving", LaneType::driving},
      {"shoulder", LaneType::shoulder}, {"border", LaneType::border},
      {"sidewalk", LaneType::sidewalk}, {"walking", LaneType::sidewalk},
      {"curb", LaneType::border},       {"parking", LaneType::parking},
      {"biking", LaneType::biking},     {"bidirectional", LaneType::driving},
      {"entry", LaneType::driving},     {"exit", LaneType::driving},
      {"mwyEntry", LaneType::driving},  {"mwyExit", LaneType::driving},
      {"onRamp", LaneType::driving},    {"offRamp", LaneType::driving},
      {"slipLane", LaneType::driving},  {"connectingRamp", LaneType::driving},
      {"bus", LaneType::driving},       {"taxi", LaneType::driving},
      {"HOV", LaneType::driving},
  };
  const auto* found =
      std::find_if(std::begin(entries), std::end(entries), [&](const Entry& e) { return e.name == name; });
  return found != std::end(entries) ? found->type : LaneType::other;
}

Cubic cubic(const Attributes& a, std::string_view s_name = "s") {
  return {a.number(s_name), a.number("a"), a.number("b"), a.number("c"), a.number("d")};
}

/// Builds the map element by element. Members point into the item under construction through back().
class Builder {
 public:
  RoadMap map;

  void start(std::string_view name, const Attributes& a) {
    const std::string_view parent = path_.empty() ? std::string_view{} : std::string_view{path_.back()};
    if (path_.empty() && name != "OpenDRIVE") {
      throw std::runtime_error("the root element is <" + std::string(name) + ">, not <OpenDRIVE>");
    }
    if (path_.size() == 1) {
      start_top(name, a);
    } else if (parent == "header") {
      start_header_part(name, a);
    } else if (in_road_) {
      start_road_part(parent, name, a);
    } else if (in_junction_) {
      start_junction_part(parent, name, a);
    }
    path_.emplace_back(name);
  }

  void end(std::string_view name) {
    path_.pop_back();
    const std::string_view parent = path_.empty() ? std::string_view{} : std::string_view{path_.back()};
    if (in_geometry_ && parent == "planView" && name == "geometry") {
      if (!has_shape_) throw std::runtime_error("<geometry> without a shape");
      in_geometry_ = false;
    }
    if (in_road_ && parent == "lanes" && name == "laneSection") finish_section();
    if (in_road_ && name == "road" && path_.size() == 1) finish_road();
    if (in_junction_ && name == "junction" && path_.size() == 1) {
      in_junction_ = false;
      check_surface(map.junctions.back());
    }
    if (name == "lane") lane_ = nullptr;
    if (name == "object") object_ = nullptr;
  }

  void text(std::string_view characters) {
    if (!path_.empty() && path_.back() == "geoReference") map.geo_reference += characters;
  }

  /// What can only be checked with the whole file read.
  void finish(HeaderOffset offset) {
    if (map.roads.empty()) throw std::runtime_error("no <road> in the file");
    const auto by_id = [](const auto& p, const auto& q) { return p.id < q.id; };
    std::stable_sort(map.roads.begin(), map.roads.end(), by_id);
    std::stable_sort(map.junctions.begin(), map.junctions.end(), by_id);
    const auto same_id = [](const auto& p, const auto& q) { return p.id == q.id; };
    const auto twice = std::adjacent_find(map.roads.begin(), map.roads.end(), same_id);
    if (twice != map.roads.end()) {
      throw std::runtime_error("two roads have the id " + std::to_string(twice->id));
    }
    const std::size_t begin = map.geo_reference.find_first_not_of(" \t\r\n");
    const std::size_t last = map.geo_reference.find_last_not_of(" \t\r\n");
    map.geo_reference = begin == std::string::npos ? "" : map.geo_reference.substr(begin, last - begin + 1);
    apply_offset(offset);
    for (Road& road : map.roads) inherit(road);
    join_arms(map);
  }

 private:
  /// What a connecting road does not say.
  void inherit(Road& road) const {
    Inherited from = inherited(map, road);
    if (road.osm_id.empty()) road.osm_id = std::move(from.osm_id);
    if (road.highway.empty()) road.highway = std::move(from.highway);
    if (road.speed_limit_mps == 0.0) road.speed_limit_mps = from.speed_limit_mps;
    if (!from.material) return;
    for (LaneSection& section : road.sections)
      for (auto* side : {&section.left, &section.right})
        for (Lane& lane : *side)
          if (lane.type == LaneType::driving && lane.materials.empty()) lane.materials = {*from.material};
  }

  void start_top(std::string_view name, const Attributes& a) {
    if (name == "header") {
      map.name = a.text("name");
      map.north = a.number("north", 0.0), map.south = a.number("south", 0.0);
      map.east = a.number("east", 0.0), map.west = a.number("west", 0.0);
    } else if (name == "road") {
      Road road;
      road.id = a.integer("id");
      road.name = a.text("name");
      road.length = a.number("length");
      road.junction = a.find("junction") != nullptr ? a.integer("junction") : -1;
      road.driving_side = a.text("rule") == "LHT" ? DrivingSide::left : DrivingSide::right;
      map.roads.push_back(std::move(road));
      in_road_ = true;
    } else if (name == "junction") {
      map.junctions.push_back({a.integer("id"), a.text("name"), {}, {}, {}});
      in_junction_ = true;
    }
  }

  void start_header_part(std::string_view name, const Attributes& a) {
    if (name != "offset") return;
    map.header_offset_m = {a.number("x"), a.number("y"), a.number("z")};
    map.header_offset_hdg = a.number("hdg", 0.0);
  }

  void start_road_part(std::string_view parent, std::string_view name, const Attributes& a) {
    Road& road = map.roads.back();
    if (parent == "road" && name == "userData") {
      read_user_data(road, a);
    } else if (parent == "link" && lane_ == nullptr && (name == "predecessor" || name == "successor")) {
      (name == "predecessor" ? road.predecessor : road.successor) = read_link(a);
    } else if (parent == "type" && name == "speed" && road.speed_limit_mps == 0.0) {
      road.speed_limit_mps = read_speed(a);
    } else if (parent == "planView" && name == "geometry") {
      road.plan.push_back({a.number("s"), a.number("x"), a.number("y"), a.number("hdg"), a.number("length"), Line{}});
      if (road.plan.back().length < 0.0) throw std::runtime_error("<geometry> has a negative length");
      if (road.plan.size() > 1 && road.plan.back().s < road.plan[road.plan.size() - 2].s) {
        throw std::runtime_error("<geometry> elements are not sorted by s");
      }
      in_geometry_ = true, has_shape_ = false;
    } else if (parent == "geometry" && in_geometry_) {
      read_shape(road.plan.back(), name, a);
    } else if (parent == "elevationProfile" && name == "elevation") {
      append(road.elevation, cubic(a));
    } else if (parent == "lateralProfile" && name == "superelevation") {
      append(road.superelevation, cubic(a));
    } else if (parent == "lateralProfile" && name == "shape") {
      read_lateral_shape(road, a);
    } else if (parent == "objects" && path_.size() == 3 && name == "object") {
      start_object(road, a);
    } else if (object_ != nullptr && (parent == "object" || parent == "outlines") && name == "outline") {
      ++outlines_;
    } else if (object_ != nullptr && outlines_ == 1 && parent == "outline" && name == "cornerRoad") {
      object_->outline.push_back({a.number("s"), a.number("t")});
    } else if (parent == "surface" && path_.size() == 3 && name == "CRG") {
      read_crg(road, a);
    } else if (parent == "lanes" && name == "laneOffset") {
      append(road.lane_offset, cubic(a));
    } else if (parent == "lanes" && name == "laneSection") {
      lane_ = nullptr;  // would point into the old place of the sections
      road.sections.emplace_back();
      road.sections.back().s = a.number("s");
    } else if ((parent == "left" || parent == "center" || parent == "right") && name == "lane") {
      start_lane(road, parent, a);
    } else if (lane_ != nullptr) {
      start_lane_part(parent, name, a);
    }
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

  /// m/s; 0 for "no limit" and "undefined".
  static double read_speed(const Attributes& a) {
    constexpr double mps_per_kmh = 1.0 / 3.6, mps_per_mph = 0.44704;
    const std::string max = a.text("max"), unit = a.text("unit");
    if (max.empty() || max == "no limit" || max == "undefined") return 0.0;
    return a.number("max") * (unit == "km/h" ? mps_per_kmh : unit == "mph" ? mps_per_mph : 1.0);
  }

  static RoadLink read_link(const Attributes& a) {
    const bool junction = a.text("elementType") == "junction";
    return {junction ? LinkKind::junction : LinkKind::road, a.integer("elementId"),
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
      element.shape = ParamPoly3{a.number("aU"), a.number("bU"), a.number("cU"),
                                 a.number("dU"), a.number("aV"), a.number("bV"),
                                 a.number("cV"), a.number("dV"), a.text("pRange") != "arcLength"};
    } else if (name == "poly3") {
      throw std::runtime_error("<poly3> geometry (deprecated since 1.6) is not supported, convert it to paramPoly3");
    } else {
      return;
    }
    has_shape_ = true;
  }

  static void read_lateral_shape(Road& road, const Attributes& a) {
    const ShapeCubic next{a.number("s"), a.number("t"), a.number("a"), a.number("b"), a.number("c"), a.number("d")};
    if (!road.shape.empty() &&
        (next.s < road.shape.back().s || (next.s == road.shape.back().s && next.t <= road.shape.back().t))) {
      throw std::runtime_error("<shape> elements are not sorted by s and t");
    }
    road.shape.push_back(next);
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
    if (object.type != "crosswalk" && object.type != "roadMark") return;
    object.s = a.number("s"), object.t = a.number("t");
    object.hdg = a.number("hdg", 0.0);
    object.length = a.number("length", 0.0), object.width = a.number("width", 0.0);
    road.objects.push_back(std::move(object));
    object_ = &road.objects.back(), outlines_ = 0;
  }

  static void append(std::vector<Cubic>& cubics, const Cubic& next) {
    if (!cubics.empty() && next.s < cubics.back().s) throw std::runtime_error("cubics are not sorted by s");
    cubics.push_back(next);
  }

  void start_lane(Road& road, std::string_view side, const Attributes& a) {
    if (road.sections.empty()) return;  // a <lane> outside a lane section: not ours
    LaneSection& section = road.sections.back();
    Lane lane;
    lane.id = a.integer("id");
    if (std::abs(static_cast<std::int64_t>(lane.id)) > most_lanes)
      throw std::runtime_error("a lane has the id " + std::to_string(lane.id));
    lane.type = lane_type(a.text("type"));
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

  void start_lane_part(std::string_view parent, std::string_view name, const Attributes& a) {
    if (parent == "lane" && name == "width" && lane_->id != 0) {
      append(lane_->width, cubic(a, "sOffset"));
    } else if (parent == "lane" && name == "border") {
      throw std::runtime_error("lanes given by <border> are not supported, convert them to <width>");
    } else if (parent == "lane" && name == "roadMark") {
      lane_->marks.push_back({a.number("sOffset"), a.text("type"), a.number("width", 0.12)});
    } else if (parent == "lane" && name == "material" && lane_->id != 0) {
      read_material(*lane_, a);
    } else if (parent == "lane" && name == "height" && lane_->id != 0) {
      read_height(*lane_, a);
    } else if (parent == "link" && name == "predecessor") {
      lane_->predecessor = a.integer("id");
    } else if (parent == "link" && name == "successor") {
      lane_->successor = a.integer("id");
    }
  }

  /// Texts that nobody knows are asphalt: the friction counts, and it stands beside them.
  static void read_material(Lane& lane, const Attributes& a) {
    LaneMaterial material;
    material.s_offset = a.number("sOffset", 0.0);
    material.surface = surface_class_of(a.text("surface")).value_or(SurfaceClass::asphalt);
    material.friction = a.number("friction", material.friction);
    material.roughness = a.number("roughness", 0.0);
    if (material.friction < 0.0) throw std::runtime_error("<material> has a negative friction");
    if (material.roughness < 0.0) throw std::runtime_error("<material> has a negative roughness");
    if (!lane.materials.empty() && material.s_offset < lane.materials.back().s_offset)
      throw std::runtime_error("<material> elements are not sorted by sOffset");
    lane.materials.push_back(material);
  }

  static void read_height(Lane& lane, const Attributes& a) {
    const LaneHeight height{a.number("sOffset"), a.number("inner", 0.0), a.number("outer", 0.0)};
    if (!lane.heights.empty() && height.s_offset <= lane.heights.back().s_offset)
      throw std::runtime_error("<height> elements are not sorted by sOffset");
    lane.heights.push_back(height);
  }

  void start_junction_part(std::string_view parent, std::string_view name, const Attributes& a) {
    Junction& junction = map.junctions.back();
    if (parent == "junction" && name == "connection") {
      Connection connection;
      connection.id = a.integer("id");
      // A virtual junction's connections (1.7) have no incoming road; a direct junction's name a linked road.
      if (a.find("incomingRoad") != nullptr) connection.incoming_road = a.integer("incomingRoad");
      connection.connecting_road =
          a.find("linkedRoad") != nullptr ? a.integer("linkedRoad") : a.integer("connectingRoad");
      connection.contact = a.text("contactPoint") == "end" ? ContactPoint::end : ContactPoint::start;
      junction.connections.push_back(std::move(connection));
    } else if (parent == "junction" && name == "priority") {
      if (a.find("high") && a.find("low")) junction.priorities.push_back({a.integer("high"), a.integer("low")});
    } else if (parent == "connection" && name == "laneLink" && !junction.connections.empty()) {
      junction.connections.back().lane_links.push_back({a.integer("from"), a.integer("to")});
    } else if (parent == "junction" && name == "userData") {
      read_junction_data(junction, a.text("code"), a.text("value"));
    }
  }

  static void read_junction_data(Junction& junction, const std::string& code, const std::string& value) {
    if (code != boundary_code && code != heights_code) return;
    if (!junction.surface) junction.surface.emplace();
    if (code == boundary_code) read_boundary(value, *junction.surface);
    if (code == heights_code) read_heights(value, *junction.surface);
  }

  static void check_surface(const Junction& junction) {
    if (!junction.surface || (!junction.surface->boundary.empty() && !junction.surface->z.empty())) return;
    throw std::runtime_error("junction " + std::to_string(junction.id) + " has only one of the userData " +
                             boundary_code + " and " + heights_code);
  }

  void finish_section() {
    LaneSection& section = map.roads.back().sections.back();
    const auto outwards = [](const Lane& p, const Lane& q) { return std::abs(p.id) < std::abs(q.id); };
    std::sort(section.left.begin(), section.left.end(), outwards);
    std::sort(section.right.begin(), section.right.end(), outwards);
  }

  void finish_road() {
    in_road_ = false;
    const Road& road = map.roads.back();
    const std::string who = "road " + std::to_string(road.id);
    if (road.plan.empty()) throw std::runtime_error(who + " has no <geometry> in a <planView>");
    if (road.sections.empty()) throw std::runtime_error(who + " has no <laneSection>");
    if (road.length < 0.0) throw std::runtime_error(who + " has a negative length");
    if (road.length > longest_road_m)
      throw std::runtime_error(who + " is longer than 1000 km: is its length in metres?");
    const auto by_s = [](const LaneSection& p, const LaneSection& q) { return p.s < q.s; };
    if (!std::is_sorted(road.sections.begin(), road.sections.end(), by_s)) {
      throw std::runtime_error(who + " has lane sections that are not sorted by s");
    }
    if (is_boundary_alone(road)) map.roads.pop_back();
  }

  /// Of a junction and without lanes: part of its <boundary> (1.8, 12.10), no surface.
  static bool is_boundary_alone(const Road& road) {
    return road.junction >= 0 &&
           std::all_of(road.sections.begin(), road.sections.end(),
                       [](const LaneSection& section) { return section.left.empty() && section.right.empty(); });
  }

  /// <offset> (1.5+) moves the coordinates of the file into the CRS of geoReference.
  void apply_offset(HeaderOffset how) {
    if (how == HeaderOffset::ignore) return;
    if (map.header_offset_hdg != 0.0)
      throw std::runtime_error("<offset> with a heading is not supported: it can only be ignored");
    const double sign = how == HeaderOffset::add ? 1.0 : -1.0;
    const double x = sign * map.header_offset_m[0], y = sign * map.header_offset_m[1],
                 z = sign * map.header_offset_m[2];
    if (x == 0.0 && y == 0.0 && z == 0.0) return;
    map.north += y, map.south += y, map.east += x, map.west += x;
    for (Road& road : map.roads) {
      for (PlanElement& element : road.plan) element.x += x, element.y += y;
      if (road.elevation.empty()) road.elevation.emplace_back();
      for (Cubic& elevation : road.elevation) elevation.a += z;
      for (SurfaceCrg& crg : road.surface) {
        crg.x_offset += x, crg.y_offset += y;
        if (crg.mode != "attached" && crg.purpose == "elevation") crg.z_offset += z;
      }
    }
    for (Junction& junction : map.junctions) {
      if (!junction.surface) continue;
      for (auto& [border_x, border_y] : junction.surface->boundary) border_x += x, border_y += y;
      junction.surface->x += x, junction.surface->y += y;
      for (double& height : junction.surface->z) height += z;
    }
  }

  std::vector<std::string> path_;  ///< names of the open elements
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
RoadMap OpenDriveBuilder::finish(HeaderOffset offset) {
  state_->builder.finish(offset);
  return std::move(state_->builder.map);
}

}  // namespace roadquery
