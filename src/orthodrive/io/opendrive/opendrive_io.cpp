// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/opendrive/opendrive_io.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <pugixml.hpp>
#include <string>
#include <string_view>

#include "orthodrive/core/atomic_file.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/io/opendrive/opendrive_junction.hpp"
#include "orthodrive/model/roads/highway_class.hpp"
#include "roadquery/map/lane_type_name.hpp"
#include "roadquery/opendrive/junction_surface_text.hpp"
#include "roadquery/roads/connecting_road.hpp"
#include "roadquery/surface/junction_surface.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace orthodrive::io {
namespace {

using roadquery::Cubic;
using roadquery::Lane;
using roadquery::Road;

/// "12.50000000" becomes "12.5", "-0.50" becomes "-.5", "-0.00000000" becomes "0", "1.50e-07" becomes "1.5e-7".
std::string trimmed_text(std::string text) {
  std::string exponent;
  if (const auto e = text.find('e'); e != std::string::npos) {
    exponent = fmt::format("e{}", std::stoi(text.substr(e + 1)));
    text.resize(e);
  }
  if (text.find('.') != std::string::npos) {
    while (text.back() == '0') text.pop_back();
    if (text.back() == '.') text.pop_back();
  }
  if (text == "-0" || text == "0") return "0";
  if (text.starts_with("0.")) text.erase(0, 1);
  if (text.starts_with("-0.")) text.erase(1, 1);
  return text + exponent;
}

/// Rounded to `decimals` places, in the shorter of both notations.
std::string fixed_text(double v, int decimals) {
  std::string fixed = trimmed_text(fmt::format("{:.{}f}", v, decimals));
  if (fixed == "0" || std::abs(v) >= 1e-3) return fixed;
  const int digits = decimals + static_cast<int>(std::floor(std::log10(std::abs(v))));
  const std::string scientific = trimmed_text(fmt::format("{:.{}e}", v, std::max(digits, 0)));
  return scientific.size() < fixed.size() ? scientific : fixed;
}

/// Decimal places more by which a factor of the `power` of lengths up to this one moves the product by less; one at
/// least, for the slopes of short pieces.
int more_decimals(double length_m, int power) {
  return std::max(1, static_cast<int>(std::ceil(power * std::log10(length_m) - 1e-6)));
}

constexpr int metre_decimals = 8, place_decimals = 7, height_decimals = 7, width_decimals = 10,
              superelevation_decimals = 8, heading_decimals = 7, curvature_decimals = 8,
              end_decimals = 6;  ///< the last: of the place where a curvature leads

std::string metres(double v) { return trimmed_text(fmt::format("{:.{}f}", v, metre_decimals)); }
/// Of a plan element's start.
std::string coordinate(double v) { return trimmed_text(fmt::format("{:.{}f}", v, place_decimals)); }
std::string radians(double v) { return trimmed_text(fmt::format("{:.12f}", v)); }
std::string coefficient(double v) { return v == 0.0 ? "0" : trimmed_text(fmt::format("{:.13g}", v)); }

void set_attribute(pugi::xml_node node, const char* name, const std::string& value) {
  node.append_attribute(name) = value.c_str();
}
void set_attribute(pugi::xml_node node, const char* name, int value) { node.append_attribute(name) = value; }

/// Each coefficient so exactly that it moves the value by less than the last of the value's `decimals`.
void add_cubic(pugi::xml_node parent, const char* name, const Cubic& cubic, double length_m, int decimals,
               const char* s_name = "s") {
  pugi::xml_node node = parent.append_child(name);
  set_attribute(node, s_name, metres(cubic.s));
  set_attribute(node, "a", fixed_text(cubic.a, decimals));
  set_attribute(node, "b", fixed_text(cubic.b, decimals + more_decimals(length_m, 1)));
  set_attribute(node, "c", fixed_text(cubic.c, decimals + more_decimals(length_m, 2)));
  set_attribute(node, "d", fixed_text(cubic.d, decimals + more_decimals(length_m, 3)));
}

void add_cubics(pugi::xml_node parent, const char* name, const std::vector<Cubic>& cubics, double end_s, int decimals,
                const char* s_name = "s") {
  for (std::size_t i = 0; i < cubics.size(); ++i)
    add_cubic(parent, name, cubics[i], (i + 1 < cubics.size() ? cubics[i + 1].s : end_s) - cubics[i].s, decimals,
              s_name);
}

struct AddShape {
  pugi::xml_node geometry;
  double length_m = 0.0;
  /// The end moves by less than 1e-6 m, and 1e-8 1/m is none that a wheel feels.
  [[nodiscard]] std::string curvature(double v) const {
    return fixed_text(v, std::max(curvature_decimals, end_decimals + more_decimals(length_m, 2)));
  }
  void operator()(const roadquery::Line&) { geometry.append_child("line"); }
  void operator()(const roadquery::Arc& arc) {
    set_attribute(geometry.append_child("arc"), "curvature", curvature(arc.curvature));
  }
  void operator()(const roadquery::Spiral& spiral) {
    pugi::xml_node node = geometry.append_child("spiral");
    set_attribute(node, "curvStart", curvature(spiral.curvature_start));
    set_attribute(node, "curvEnd", curvature(spiral.curvature_end));
  }
  void operator()(const roadquery::ParamPoly3& poly) {
    pugi::xml_node node = geometry.append_child("paramPoly3");
    set_attribute(node, "aU", coefficient(poly.a_u)), set_attribute(node, "bU", coefficient(poly.b_u));
    set_attribute(node, "cU", coefficient(poly.c_u)), set_attribute(node, "dU", coefficient(poly.d_u));
    set_attribute(node, "aV", coefficient(poly.a_v)), set_attribute(node, "bV", coefficient(poly.b_v));
    set_attribute(node, "cV", coefficient(poly.c_v)), set_attribute(node, "dV", coefficient(poly.d_v));
    set_attribute(node, "pRange", poly.normalized ? "normalized" : "arcLength");
  }
};

const char* contact_name(roadquery::ContactPoint contact) {
  return contact == roadquery::ContactPoint::start ? "start" : "end";
}

void add_link(pugi::xml_node parent, const char* name, const roadquery::RoadLink& link) {
  if (link.kind == roadquery::LinkKind::none) return;
  pugi::xml_node node = parent.append_child(name);
  const bool road = link.kind == roadquery::LinkKind::road;
  set_attribute(node, "elementType", road ? "road" : "junction");
  set_attribute(node, "elementId", link.id);
  if (road) set_attribute(node, "contactPoint", contact_name(link.contact));
}

/// What the header says is to be added to the file's coordinates.
struct Offset {
  double x = 0.0, y = 0.0;
};

Offset offset_of(const roadquery::RoadMap& map) {
  constexpr double step_m = 1000.0;
  return {step_m * std::round(0.5 * (map.west + map.east) / step_m),
          step_m * std::round(0.5 * (map.south + map.north) / step_m)};
}

/// OpenDRIVE's road types, coarsely: OSM does not say whether a road runs through a town.
const char* road_type(const std::string& highway) {
  if (highway.starts_with("motorway")) return "motorway";
  if (highway.starts_with("trunk") || highway.starts_with("primary")) return "rural";
  if (highway == "living_street") return "lowSpeed";
  if (is_raceway(highway) || highway == "track" || highway.empty()) return "unknown";
  return "town";
}

/// A "border" is as high as the lanes beside it, a "curb" is not (1.7, 11.7). OpenDRIVE has no type "other": on
/// "restricted" lanes no car drives.
const char* written_lane_type(const Lane& lane) {
  if (lane.type == roadquery::LaneType::border && !lane.heights.empty()) return "curb";
  return lane.type == roadquery::LaneType::other ? "restricted" : roadquery::lane_type_name(lane.type);
}

void add_speed(pugi::xml_node parent, double limit_mps) {
  pugi::xml_node speed = parent.append_child("speed");
  set_attribute(speed, "max", trimmed_text(fmt::format("{:.2f}", limit_mps * 3.6)));
  set_attribute(speed, "unit", "km/h");
}

/// A lane without marks is written without.
bool is_unmarked(const Lane& lane) {
  return std::all_of(lane.marks.begin(), lane.marks.end(),
                     [](const roadquery::RoadMark& mark) { return mark.type == "none"; });
}

/// Lanes beside the driving ones that have no width at an end lead nowhere there (1.4, 9.4: zero_width_at_start and
/// zero_width_at_end of ASAM's checker).
bool leads_on(const Lane& lane, double s_in_section) {
  constexpr double least_width_m = 1e-6;
  return lane.id == 0 || roadquery::is_driven(lane.type) || roadquery::lane_width(lane, s_in_section) > least_width_m;
}

/// `limit_mps` > 0 stands at lanes without one of their own, too: SUMO reads it there only, and only of roads outside
/// junctions.
void add_mark_line(pugi::xml_node to, const roadquery::RoadMarkLine& line, const roadquery::RoadMark& mark) {
  pugi::xml_node node = to.append_child("line");
  set_attribute(node, "length", metres(line.length));
  if (!line.is_single_stroke) set_attribute(node, "space", metres(line.space));
  set_attribute(node, "tOffset", metres(line.t_offset));
  set_attribute(node, "sOffset", metres(line.s_offset));
  set_attribute(node, "width", metres(line.width > 0.0 ? line.width : mark.width));
  if (!line.color.empty() && !line.is_single_stroke) set_attribute(node, "color", line.color);
}

void add_road_mark(pugi::xml_node lane, const roadquery::RoadMark& mark) {
  pugi::xml_node node = lane.append_child("roadMark");
  set_attribute(node, "sOffset", metres(mark.s_offset));
  set_attribute(node, "type", mark.type);
  set_attribute(node, "color", mark.color);
  set_attribute(node, "width", metres(mark.width));
  pugi::xml_node repeated, once;
  for (const roadquery::RoadMarkLine& line : mark.lines) {
    pugi::xml_node& to = line.is_single_stroke ? once : repeated;
    if (!to) to = node.append_child(line.is_single_stroke ? "explicit" : "type");
    add_mark_line(to, line, mark);
  }
  if (!repeated) return;
  set_attribute(repeated, "name", mark.type);
  set_attribute(repeated, "width", metres(mark.width));
}

void add_lane(pugi::xml_node side, const Lane& lane, const roadquery::Inherited& from, double section_length_m,
              double limit_mps = 0.0) {
  pugi::xml_node node = side.append_child("lane");
  set_attribute(node, "id", lane.id);
  set_attribute(node, "type", written_lane_type(lane));
  const bool has_predecessor = lane.predecessor && leads_on(lane, 0.0),
             has_successor = lane.successor && leads_on(lane, section_length_m);
  if (has_predecessor || has_successor) {
    pugi::xml_node link = node.append_child("link");
    if (has_predecessor) set_attribute(link.append_child("predecessor"), "id", *lane.predecessor);
    if (has_successor) set_attribute(link.append_child("successor"), "id", *lane.successor);
  }
  add_cubics(node, "width", lane.width, section_length_m, width_decimals, "sOffset");
  for (const roadquery::RoadMark& mark : is_unmarked(lane) ? std::vector<roadquery::RoadMark>{} : lane.marks) {
    add_road_mark(node, mark);
  }
  const bool inherits = roadquery::has_inherited_material(lane, from);
  for (const roadquery::LaneMaterial& material : inherits ? std::vector<roadquery::LaneMaterial>{} : lane.materials) {
    pugi::xml_node m = node.append_child("material");
    set_attribute(m, "sOffset", metres(material.s_offset));
    set_attribute(m, "surface", roadquery::to_string(material.surface));
    set_attribute(m, "friction", trimmed_text(fmt::format("{:.4f}", material.friction)));
    if (material.roughness > 0.0)
      set_attribute(m, "roughness", trimmed_text(fmt::format("{:.5f}", material.roughness)));
  }
  const bool driven = lane.id != 0 && (roadquery::is_driven(lane.type) || lane.type == roadquery::LaneType::bus ||
                                       lane.type == roadquery::LaneType::taxi);
  std::vector<roadquery::SpeedLimit> speeds = lane.speeds;
  if (driven && limit_mps > 0.0 && speeds.empty()) speeds.push_back({0.0, limit_mps});
  for (const roadquery::SpeedLimit& speed : speeds) {
    if (!(speed.mps > 0.0) || !std::isfinite(speed.mps)) continue;
    add_speed(node, speed.mps);
    node.last_child().prepend_attribute("sOffset") = metres(speed.s).c_str();
  }
  for (const std::string& who : lane.allowed) {
    pugi::xml_node access = node.append_child("access");
    set_attribute(access, "sOffset", "0");
    set_attribute(access, "rule", "allow");
    set_attribute(access, "restriction", who);
  }
  for (const roadquery::LaneHeight& height : lane.heights) {
    pugi::xml_node h = node.append_child("height");
    set_attribute(h, "sOffset", metres(height.s_offset));
    set_attribute(h, "inner", metres(height.inner));
    set_attribute(h, "outer", metres(height.outer));
  }
}

void add_lane_nodes(pugi::xml_node parent, const Road& road, const roadquery::Inherited& from) {
  const double limit_mps = road.junction < 0 ? road.speed_limit_mps : 0.0;
  pugi::xml_node lanes = parent.append_child("lanes");
  add_cubics(lanes, "laneOffset", road.lane_offset, road.length, width_decimals);
  for (std::size_t i = 0; i < road.sections.size(); ++i) {
    const roadquery::LaneSection& section = road.sections[i];
    const double length = (i + 1 < road.sections.size() ? road.sections[i + 1].s : road.length) - section.s;
    pugi::xml_node node = lanes.append_child("laneSection");
    set_attribute(node, "s", metres(section.s));
    if (!section.left.empty()) {
      pugi::xml_node left =
          node.append_child("left");  // by custom from the outside in: ids descend through the section
      for (auto lane = section.left.rbegin(); lane != section.left.rend(); ++lane)
        add_lane(left, *lane, from, length, limit_mps);
    }
    add_lane(node.append_child("center"), section.center, from, length);
    if (!section.right.empty()) {
      pugi::xml_node right = node.append_child("right");
      for (const Lane& lane : section.right) add_lane(right, lane, from, length, limit_mps);
    }
  }
}

void add_lateral_profile(pugi::xml_node road_node, const Road& road) {
  if (road.superelevation.empty() && road.shape.empty()) return;
  pugi::xml_node profile = road_node.append_child("lateralProfile");
  add_cubics(profile, "superelevation", road.superelevation, road.length, superelevation_decimals);
  for (const roadquery::ShapeCubic& shape : road.shape) {
    pugi::xml_node node = profile.append_child("shape");
    set_attribute(node, "s", metres(shape.s));
    set_attribute(node, "t", metres(shape.t));
    set_attribute(node, "a", coefficient(shape.a));
    set_attribute(node, "b", coefficient(shape.b));
    set_attribute(node, "c", coefficient(shape.c));
    set_attribute(node, "d", coefficient(shape.d));
  }
}

void add_surface(pugi::xml_node road_node, const Road& road) {
  if (road.surface.empty()) return;
  pugi::xml_node surface = road_node.append_child("surface");
  for (const roadquery::SurfaceCrg& crg : road.surface) {
    pugi::xml_node node = surface.append_child("CRG");
    set_attribute(node, "file", crg.file);
    set_attribute(node, "sStart", metres(crg.s_start));
    set_attribute(node, "sEnd", metres(crg.s_end));
    set_attribute(node, "orientation", crg.orientation);
    set_attribute(node, "mode", crg.mode);
    set_attribute(node, "purpose", crg.purpose);
    if (crg.s_offset != 0.0) set_attribute(node, "sOffset", metres(crg.s_offset));
    if (crg.t_offset != 0.0) set_attribute(node, "tOffset", metres(crg.t_offset));
    if (crg.z_offset != 0.0) set_attribute(node, "zOffset", metres(crg.z_offset));
    if (crg.z_scale != 1.0) set_attribute(node, "zScale", coefficient(crg.z_scale));
    if (crg.h_offset != 0.0) set_attribute(node, "hOffset", radians(crg.h_offset));
  }
}

void add_user_data(pugi::xml_node road, const char* code, const std::string& value) {
  pugi::xml_node node = road.append_child("userData");
  set_attribute(node, "code", code);
  set_attribute(node, "value", value);
}

void add_type(pugi::xml_node road_node, const Road& road) {
  pugi::xml_node type = road_node.append_child("type");
  set_attribute(type, "s", "0");
  set_attribute(type, "type", road_type(road.highway));
  if (road.speed_limit_mps > 0.0) add_speed(type, road.speed_limit_mps);
}

std::string centimetres(double v) { return trimmed_text(fmt::format("{:.2f}", v)); }

/// What is painted: flat, by its corners or by its box.
void add_object(pugi::xml_node objects, const roadquery::RoadObject& object, const std::string& id) {
  pugi::xml_node node = objects.append_child("object");
  set_attribute(node, "id", id);
  set_attribute(node, "type", object.type);
  if (!object.subtype.empty()) set_attribute(node, "subtype", object.subtype);
  if (!object.name.empty()) set_attribute(node, "name", object.name);
  set_attribute(node, "s", centimetres(object.s));
  set_attribute(node, "t", centimetres(object.t));
  set_attribute(node, "zOffset", "0");
  if (object.hdg != 0.0) set_attribute(node, "hdg", radians(object.hdg));
  set_attribute(node, "orientation", "none");
  set_attribute(node, "height", centimetres(object.height));
  set_attribute(node, "length", centimetres(object.length));
  set_attribute(node, "width", centimetres(object.width));
  if (object.outline.empty()) return;
  pugi::xml_node outline = node.append_child("outlines").append_child("outline");
  set_attribute(outline, "id", 0);
  set_attribute(outline, "closed", "true");
  for (const auto& [s, t] : object.outline) {
    pugi::xml_node corner = outline.append_child("cornerRoad");
    set_attribute(corner, "s", centimetres(s));
    set_attribute(corner, "t", centimetres(t));
    set_attribute(corner, "dz", "0");
    set_attribute(corner, "height", "0");
  }
}

/// What is painted, and a bridge or tunnel as an object as long as its road.
void add_objects(pugi::xml_node road_node, const Road& road) {
  if (!road.bridge && !road.tunnel && road.objects.empty()) return;
  pugi::xml_node objects = road_node.append_child("objects");
  for (std::size_t i = 0; i < road.objects.size(); ++i)
    add_object(objects, road.objects[i], fmt::format("{}_{}", road.id, i + 1));
  if (!road.bridge && !road.tunnel) return;
  pugi::xml_node node = objects.append_child(road.bridge ? "bridge" : "tunnel");
  set_attribute(node, "s", "0");
  set_attribute(node, "length", metres(road.length));
  set_attribute(node, "id", fmt::format("{}_{}", road.bridge ? "bridge" : "tunnel", road.id));
  if (!road.name.empty()) set_attribute(node, "name", road.name);
  set_attribute(node, "type", road.bridge ? "concrete" : "standard");  // OSM does not say what it is made of
}

void add_road(pugi::xml_node root, const roadquery::RoadMap& map, const Road& road, const Offset& offset) {
  pugi::xml_node node = root.append_child("road");
  if (!road.name.empty()) set_attribute(node, "name", road.name);
  set_attribute(node, "length", metres(road.length));
  set_attribute(node, "id", road.id);
  set_attribute(node, "junction", road.junction);
  if (road.driving_side == roadquery::DrivingSide::left) set_attribute(node, "rule", "LHT");  // the default is RHT
  pugi::xml_node link = node.append_child("link");
  add_link(link, "predecessor", road.predecessor);
  add_link(link, "successor", road.successor);
  // What a connecting road has from the roads that it connects is not repeated: the reader takes it from there.
  const roadquery::Inherited from = roadquery::inherited(map, road);
  if (road.junction < 0 || road.speed_limit_mps != from.speed_limit_mps) add_type(node, road);
  pugi::xml_node plan = node.append_child("planView");
  for (const roadquery::PlanElement& e : road.plan) {
    pugi::xml_node geometry = plan.append_child("geometry");
    set_attribute(geometry, "s", metres(e.s));
    set_attribute(geometry, "x", coordinate(e.x - offset.x));
    set_attribute(geometry, "y", coordinate(e.y - offset.y));
    set_attribute(geometry, "hdg", fixed_text(e.hdg, heading_decimals + more_decimals(e.length, 1)));
    set_attribute(geometry, "length", metres(e.length));
    std::visit(AddShape{geometry, e.length}, e.shape);
  }
  if (!road.elevation.empty()) {
    pugi::xml_node profile = node.append_child("elevationProfile");
    add_cubics(profile, "elevation", road.elevation, road.length, height_decimals);
  }
  add_lateral_profile(node, road);
  add_lane_nodes(node, road, from);
  add_objects(node, road);
  add_surface(node, road);
  if (!road.osm_id.empty() && road.osm_id != from.osm_id) add_user_data(node, "osm_id", road.osm_id);
  if (!road.highway.empty() && road.highway != from.highway) add_user_data(node, "highway", road.highway);
  if (road.layer != 0) add_user_data(node, "layer", std::to_string(road.layer));
  if (road.bridge) add_user_data(node, "bridge", "yes");
  if (road.tunnel) add_user_data(node, "tunnel", "yes");
}

/// Columns from west to east, each from its southern end to the north: the line runs along the southernmost nodes.
void add_elevation_grid(pugi::xml_node node, const roadquery::JunctionSurface& surface) {
  pugi::xml_node grid = node.append_child("elevationGrid");
  set_attribute(grid, "gridSpacing", metres(surface.spacing_m));
  set_attribute(grid, "sStart", "0");
  const auto height = [&](int column, int row) {
    const double z = surface.z[static_cast<std::size_t>(row) * static_cast<std::size_t>(surface.columns) +
                               static_cast<std::size_t>(column)];
    return trimmed_text(fmt::format("{:.4f}", z));
  };
  for (int column = 0; column < surface.columns; ++column) {
    pugi::xml_node elevation = grid.append_child("elevation");
    set_attribute(elevation, "center", height(column, 0));
    std::string left;
    for (int row = 1; row < surface.rows; ++row) left += (row > 1 ? " " : "") + height(column, row);
    if (!left.empty()) set_attribute(elevation, "left", left);
  }
}

/// OpenDRIVE 1.8, 12.10 and 12.11: the reference line of the grid, the boundary and the grid.
void add_junction_grid(pugi::xml_node node, const roadquery::JunctionSurface& surface, const JunctionBoundary& boundary,
                       const Offset& offset) {
  pugi::xml_node line = node.append_child("planView").append_child("geometry");
  set_attribute(line, "s", "0");
  set_attribute(line, "x", metres(surface.x - offset.x));
  set_attribute(line, "y", metres(surface.y - offset.y));
  set_attribute(line, "hdg", "0");
  set_attribute(line, "length", metres(surface.spacing_m * (surface.columns - 1)));
  line.append_child("line");
  pugi::xml_node ring = node.append_child("boundary");
  for (const BoundarySegment& segment : boundary.segments) {
    pugi::xml_node s = ring.append_child("segment");
    set_attribute(s, "type", segment.joint ? "joint" : "lane");
    set_attribute(s, "roadId", segment.road);
    if (segment.joint) {
      set_attribute(s, "contactPoint", contact_name(segment.contact));
      set_attribute(s, "transitionLength", metres(roadquery::junction_transition_m));
    } else {
      set_attribute(s, "boundaryLane", 0);
      set_attribute(s, "sStart", "start");
      set_attribute(s, "sEnd", "end");
    }
  }
  add_elevation_grid(node, surface);
}

void add_junction(pugi::xml_node root, const roadquery::Junction& junction, const JunctionBoundary& boundary,
                  const Offset& offset) {
  pugi::xml_node node = root.append_child("junction");
  if (!junction.name.empty()) set_attribute(node, "name", junction.name);
  set_attribute(node, "id", junction.id);
  for (const roadquery::Connection& connection : junction.connections) {
    pugi::xml_node c = node.append_child("connection");
    set_attribute(c, "id", connection.id);
    set_attribute(c, "incomingRoad", connection.incoming_road);
    set_attribute(c, "connectingRoad", connection.connecting_road);
    set_attribute(c, "contactPoint", contact_name(connection.contact));
    for (const roadquery::LaneLink& link : connection.lane_links) {
      pugi::xml_node l = c.append_child("laneLink");
      set_attribute(l, "from", link.from);
      set_attribute(l, "to", link.to);
    }
  }
  for (const roadquery::Priority& priority : junction.priorities) {
    pugi::xml_node p = node.append_child("priority");
    set_attribute(p, "high", priority.high);
    set_attribute(p, "low", priority.low);
  }
  if (!junction.surface) return;
  if (!boundary.segments.empty()) add_junction_grid(node, *junction.surface, boundary, offset);
  add_user_data(node, roadquery::boundary_code, roadquery::boundary_text(*junction.surface, offset.x, offset.y));
  add_user_data(node, roadquery::heights_code, roadquery::heights_text(*junction.surface, offset.x, offset.y));
}

void add_header(pugi::xml_node root, const roadquery::RoadMap& map, const Offset& offset, int minor_version) {
  pugi::xml_node header = root.append_child("header");
  set_attribute(header, "revMajor", 1);
  set_attribute(header, "revMinor", minor_version);
  set_attribute(header, "name", map.name);
  set_attribute(header, "north", metres(map.north - offset.y));
  set_attribute(header, "south", metres(map.south - offset.y));
  set_attribute(header, "east", metres(map.east - offset.x));
  set_attribute(header, "west", metres(map.west - offset.x));
  set_attribute(header, "vendor", "orthodrive");
  if (!map.geo_reference.empty())
    header.append_child("geoReference").append_child(pugi::node_cdata).set_value(map.geo_reference.c_str());
  if (offset.x == 0.0 && offset.y == 0.0) return;
  pugi::xml_node node = header.append_child("offset");
  set_attribute(node, "x", metres(offset.x));
  set_attribute(node, "y", metres(offset.y));
  set_attribute(node, "z", "0");
  set_attribute(node, "hdg", "0");
}

/// Characters of an element on one line, but for escaped ones.
std::size_t width_of(pugi::xml_node node) {
  const std::size_t name = std::char_traits<char>::length(node.name());
  std::size_t width = node.first_child() ? 2 * name + 5 : name + 3;
  for (const pugi::xml_attribute a : node.attributes())
    width += std::char_traits<char>::length(a.name()) + std::char_traits<char>::length(a.value()) + 4;
  for (const pugi::xml_node child : node.children()) width += width_of(child);
  return width;
}

/// A line for each element with all in it where that is not too long, else one for each child. No indentation: it is a
/// tenth of a file whose elements stand side by side.
void break_lines(pugi::xml_node node) {
  constexpr std::size_t longest_line = 2000;
  if (!node.first_child() || width_of(node) <= longest_line) return;
  for (pugi::xml_node child = node.first_child(); child; child = child.next_sibling()) {
    node.insert_child_before(pugi::node_pcdata, child).set_value("\n");
    break_lines(child);
  }
  node.append_child(pugi::node_pcdata).set_value("\n");
}

}  // namespace

void write_opendrive(const std::filesystem::path& path, const roadquery::RoadMap& map,
                     const WriteOpenDriveOptions& options) {
  if (options.minor_version != 7 && options.minor_version != 8)
    throw OptionError(fmt::format("OpenDRIVE 1.{} cannot be written, choose 1.7 or 1.8", options.minor_version));
  if (options.junction_grids && options.minor_version < 8) throw OptionError("grids of junctions need OpenDRIVE 1.8");
  if (map.roads.empty()) throw Error(path.string() + ": no road to write, OpenDRIVE needs at least one");
  AtomicFile file(path);
  std::ofstream out(file.path(), std::ios::binary);
  out << "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<OpenDRIVE>\n";
  // A tree at a time: that of a whole town would take ten times the memory of its file.
  const auto write = [&out](auto&& add) {
    pugi::xml_document document;
    add(document);
    break_lines(document.first_child());
    document.first_child().print(out, "", pugi::format_raw, pugi::encoding_utf8);
    out << '\n';
  };
  const Offset offset = options.absolute ? Offset{} : offset_of(map);
  write([&](pugi::xml_node root) { add_header(root, map, offset, options.minor_version); });
  for (const Road& road : map.roads) write([&](pugi::xml_node root) { add_road(root, map, road, offset); });
  const std::vector<JunctionBoundary> boundaries =
      options.junction_grids ? junction_boundaries(map) : std::vector<JunctionBoundary>(map.junctions.size());
  for (const JunctionBoundary& boundary : boundaries)
    for (const Road& kerb : boundary.kerbs) write([&](pugi::xml_node root) { add_road(root, map, kerb, offset); });
  for (std::size_t i = 0; i < map.junctions.size(); ++i)
    write([&](pugi::xml_node root) { add_junction(root, map.junctions[i], boundaries[i], offset); });
  out << "</OpenDRIVE>\n";
  out.close();
  if (!out) throw Error(fmt::format("{}: cannot be written, is the disk full or the folder read-only?", path.string()));
  file.commit();
}

}  // namespace orthodrive::io
