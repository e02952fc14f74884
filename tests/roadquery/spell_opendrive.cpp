// SPDX-License-Identifier: Apache-2.0
#include "roadquery/spell_opendrive.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <set>

#include "roadquery/surface/poly_curve.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace roadquery::test {
namespace {

constexpr double offset_x = 4096.5, offset_y = -256.25, offset_z = 12.5, offset_hdg = 0.75;

Cubic sum_of(const Cubic& a, const Cubic& b, double factor) {
  return {a.s, a.a + factor * b.a, a.b + factor * b.b, a.c + factor * b.c, a.d + factor * b.d};
}

ShapeCubic begun_at_t(const ShapeCubic& cubic, double t) {
  const Cubic moved = begun_at({{cubic.t, cubic.a, cubic.b, cubic.c, cubic.d}}, t);
  return {cubic.s, t, moved.a, moved.b, moved.c, moved.d};
}

class Speller {
 public:
  Speller(const MapSpelling& how, Dice& dice) : how_(how), dice_(dice) {}

  XmlElement map(const RandomMap& map) {
    XmlElement root{"OpenDRIVE"};
    root.add(header());
    std::vector<const RandomRoad*> roads;
    for (const RandomRoad& made : map.roads) roads.push_back(&made);
    if (!how_.plain) dice_.shuffle(roads);
    for (const RandomRoad* made : roads) root.add(road(*made));
    for (const Junction& j : map.junctions) root.add(junction(j));
    if (!how_.plain) {
      root.add({"controller", {{"id", "1"}, {"name", "lights"}}, {{"control", {{"signalId", "1"}, {"type", "0"}}}}});
      if (how_.minor >= 4) root.add({"userData", {{"code", "tool"}, {"value", "2"}}, {{"anything"}}});
    }
    return root;
  }

 private:
  // --- words

  bool maybe(int n) { return !how_.plain && dice_.one_in(n); }
  std::string number(double v) {
    char shortest[32];
    const auto end = std::to_chars(shortest, shortest + sizeof shortest, v).ptr;
    std::string text(shortest, end);
    if (how_.plain) return text;
    char buffer[64];
    switch (dice_.below(9)) {
      case 0:
        std::snprintf(buffer, sizeof buffer, "%.17g", v);
        return buffer;
      case 1:
        std::snprintf(buffer, sizeof buffer, "%.16e", v);
        return buffer;
      case 2:
        std::snprintf(buffer, sizeof buffer, "%.16E", v);
        return buffer;
      case 3:
        return v < 0.0 ? text : "+" + text;
      case 4:
        return v < 0.0 ? "-00" + text.substr(1) : "00" + text;
      case 5:
        return text.find('e') != std::string::npos ? text : text + (text.find('.') != std::string::npos ? "000" : ".");
      case 6:
        return text.starts_with("0.") ? text.substr(1) : text;
      case 7:
        return " " + text + "\t";
      default:
        return text;
    }
  }
  std::string whole(int v) { return maybe(5) ? (v < 0 ? " " : "+") + std::to_string(v) : std::to_string(v); }
  std::string flag(bool v) { return maybe(2) ? (v ? "1" : "0") : (v ? "true" : "false"); }
  void additional(XmlElement& element) {
    if (!maybe(8) || how_.minor < 4) return;
    element.add({"userData", {{"code", "any"}, {"value", "1"}}});
    if (how_.minor >= 5) element.add({"dataQuality", {}, {{"error", {{"xyAbsolute", "0.1"}}}}});
  }

  /// Elements of a list; where they are repeated, wrong ones stand before some of them.
  void list(XmlElement& parent, std::vector<XmlElement> elements, const std::set<std::string>& places) {
    if (how_.repeated) dice_.shuffle(elements);
    std::vector<XmlElement> wrong;
    if (how_.repeated)
      for (const XmlElement& element : elements) {
        if (!dice_.one_in(4)) continue;
        XmlElement other = element;
        for (auto& [key, value] : other.attributes)
          if (!places.contains(key) && (value.empty() || value.find_first_of("0123456789") != std::string::npos))
            value = "0.25";
        for (XmlElement& child : other.children)
          if (child.name == "speed") child.attributes = {{"max", "7"}};
        wrong.push_back(std::move(other));
      }
    for (auto* some : {&wrong, &elements})
      for (XmlElement& element : *some) {
        additional(element);
        parent.add(std::move(element));
      }
  }
  XmlElement cubic(const char* name, const char* place, const Cubic& c) {
    return {name,
            {{place, number(c.s)}, {"a", number(c.a)}, {"b", number(c.b)}, {"c", number(c.c)}, {"d", number(c.d)}}};
  }
  void cubics(XmlElement& parent, const char* name, const char* place, std::vector<Cubic> all, double length,
              bool may_split = true) {
    if (maybe(2) && may_split && !all.empty()) {
      const double s = dice_.between(all.back().s, length);
      if (s > all.back().s + 0.01) all.push_back(begun_at(all, s));
    }
    std::vector<XmlElement> elements;
    for (const Cubic& c : all) elements.push_back(cubic(name, place, c));
    list(parent, std::move(elements), {place});
  }

  // --- the file

  XmlElement header() {
    XmlElement made{"header",
                    {{"revMajor", "1"},
                     {"revMinor", std::to_string(how_.minor)},
                     {"name", "random"},
                     {"version", "1"},
                     {"date", "2026-11-30"},
                     {"north", "0"},
                     {"south", "0"},
                     {"east", "0"},
                     {"west", "0"}}};
    if (how_.minor >= 4) made.add({"geoReference", {}, {}, "+proj=utm +zone=33 +datum=WGS84 +units=m +no_defs"});
    if (how_.has_offset) {
      XmlElement& offset = made.add({"offset"});
      offset.set("x", number(offset_x)), offset.set("y", number(offset_y)), offset.set("z", number(offset_z));
      offset.set("hdg", number(offset_hdg));
    }
    if (how_.minor >= 8) {
      made.add({"license", {{"name", "CC0"}, {"spdxid", "CC0-1.0"}}});
      made.add({"defaultRegulations", {}, {{"roadRegulations", {{"type", "town"}}}}});
    }
    return made;
  }

  XmlElement road(const RandomRoad& made) {
    const Road& road = made.road;
    XmlElement element{"road", {{"name", road.name}, {"length", number(road.length)}, {"id", id(road.id)}}};
    element.set("junction", road.junction < 0 ? "-1" : id(road.junction));
    if (road.driving_side == DrivingSide::left || (how_.minor >= 5 && !maybe(2)))
      element.set("rule", road.driving_side == DrivingSide::left ? "LHT" : "RHT");
    element.add(links(road));
    std::vector<XmlElement> types;
    for (const SpeedLimit& limit : road.speed_limits) types.push_back(type(limit));
    list(element, std::move(types), {"s"});
    element.add(plan(made));
    XmlElement profile{"elevationProfile"};
    cubics(profile, "elevation", "s", lowered(road.elevation), road.length, !made.has_level);
    element.add(std::move(profile));
    element.add(lateral(made));
    element.add(lanes(made));
    element.add(objects(road));
    if (maybe(2))
      element.add({"signals",
                   {},
                   {{"signal", {{"id", "1"}, {"s", "0"}, {"t", "0"}, {"type", "274"}}, {{"validity"}}},
                    {"signalReference", {{"id", "1"}, {"s", "1"}, {"t", "0"}}}}});
    if (!road.surface.empty()) element.add(surface(road));
    if (road.bridge && maybe(2)) element.add({"userData", {{"code", "bridge"}, {"value", flag(true)}}});
    if (maybe(6)) element.add({"railroad", {}, {{"switch", {{"id", "1"}}}}});
    additional(element);
    return element;
  }
  std::string id(int number) const { return written_id(number, how_); }
  std::vector<Cubic> lowered(std::vector<Cubic> elevation) const {
    if (how_.has_offset)
      for (Cubic& c : elevation) c.a -= offset_z;
    return elevation;
  }

  XmlElement links(const Road& road) {
    XmlElement element{"link"};
    const auto link = [&](const char* name, const RoadLink& to) {
      if (to.kind == LinkKind::none) return;
      XmlElement& made = element.add({name, {{"elementId", id(to.id)}}});
      made.set("elementType", to.kind == LinkKind::road ? "road" : "junction");
      if (to.kind == LinkKind::road) made.set("contactPoint", to.contact == ContactPoint::end ? "end" : "start");
    };
    link("predecessor", road.predecessor), link("successor", road.successor);
    if (how_.minor <= 4 && maybe(4))
      element.add({"neighbor", {{"side", "left"}, {"elementId", "1"}, {"direction", "same"}}});
    return element;
  }

  void set_speed(XmlElement& element, double mps) {
    const int unit = how_.plain ? 0 : dice_.below(how_.minor >= 4 ? 3 : 1);
    if (std::isinf(mps)) return element.set("max", "no limit");
    if (mps == 0.0) return element.set("max", "undefined");
    element.set("max", number(unit == 1 ? mps * 3.6 : unit == 2 ? mps / 0.44704 : mps));
    if (unit > 0 || maybe(2)) element.set("unit", unit == 1 ? "km/h" : unit == 2 ? "mph" : "m/s");
  }
  XmlElement type(const SpeedLimit& limit) {
    XmlElement element{"type", {{"s", number(limit.s)}, {"type", how_.minor >= 6 ? "townArterial" : "town"}}};
    if (how_.minor >= 6 && maybe(2)) element.set("country", "DE");
    if (limit.mps > 0.0 || maybe(2)) set_speed(element.add({"speed"}), limit.mps);
    return element;
  }

  // --- plan view

  XmlElement plan(const RandomRoad& made) {
    XmlElement view{"planView"};
    for (std::size_t i = 0; i < made.road.plan.size(); ++i) {
      const PlanElement& e = made.road.plan[i];
      double x = e.x, y = e.y, hdg = e.hdg;
      if (how_.has_offset) {
        const double dx = x - offset_x, dy = y - offset_y, c = std::cos(offset_hdg), n = std::sin(offset_hdg);
        x = c * dx + n * dy, y = c * dy - n * dx, hdg -= offset_hdg;
      }
      XmlElement& geometry = view.add({"geometry",
                                       {{"s", number(e.s)},
                                        {"x", number(x)},
                                        {"y", number(y)},
                                        {"hdg", number(hdg)},
                                        {"length", number(e.length)}}});
      geometry.add(curve(e, made.poly3[i]));
      additional(geometry);
    }
    if (how_.repeated) dice_.shuffle(view.children);
    return view;
  }
  XmlElement curve(const PlanElement& e, const std::optional<Cubic>& v_of_u) {
    if (const auto* poly = std::get_if<ParamPoly3>(&e.shape)) {
      if (v_of_u && how_.minor <= 5) return poly3(*v_of_u);
      return param_poly3(*poly, e.length, maybe(2));
    }
    double from = 0.0, to = 0.0;
    if (const auto* arc = std::get_if<Arc>(&e.shape)) from = to = arc->curvature;
    if (const auto* spiral = std::get_if<Spiral>(&e.shape)) from = spiral->curvature_start, to = spiral->curvature_end;
    if (from == 0.0 && to == 0.0 && !maybe(2)) return {"line"};
    if (from == 0.0 && to == 0.0 && maybe(2))
      return param_poly3({0.0, e.length, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, true}, e.length, maybe(2));
    if (from == to && !maybe(3)) return {"arc", {{"curvature", number(from)}}};
    return {"spiral", {{"curvStart", number(from)}, {"curvEnd", number(to)}}};
  }
  XmlElement poly3(const Cubic& v) {
    return {"poly3", {{"a", number(v.a)}, {"b", number(v.b)}, {"c", number(v.c)}, {"d", number(v.d)}}};
  }
  XmlElement param_poly3(const ParamPoly3& q, double length, bool by_length) {
    const double p = by_length ? 1.0 / length : 1.0;
    XmlElement made{"paramPoly3",
                    {{"aU", number(q.a_u)},
                     {"bU", number(q.b_u * p)},
                     {"cU", number(q.c_u * p * p)},
                     {"dU", number(q.d_u * p * p * p)},
                     {"aV", number(q.a_v)},
                     {"bV", number(q.b_v * p)},
                     {"cV", number(q.c_v * p * p)},
                     {"dV", number(q.d_v * p * p * p)}}};
    if (by_length || how_.minor >= 5 || !maybe(2)) made.set("pRange", by_length ? "arcLength" : "normalized");
    return made;
  }

  // --- cross section

  XmlElement lateral(const RandomRoad& made) {
    const Road& road = made.road;
    XmlElement profile{"lateralProfile"};
    cubics(profile, "superelevation", "s", road.superelevation, road.length, !made.has_level);
    if (!made.crossfall.empty() && how_.minor <= 4) {
      crossfall(profile, made.crossfall);
      return profile;
    }
    if (made.strips && how_.minor >= 8) {
      profile.add(strips(*made.strips));
      return profile;
    }
    std::vector<ShapeCubic> shapes = road.shape;
    if (!shapes.empty() && maybe(2)) shapes.push_back(begun_at_t(shapes.back(), shapes.back().t + 1.5));
    std::vector<XmlElement> elements;
    for (const ShapeCubic& q : shapes)
      elements.push_back({"shape",
                          {{"s", number(q.s)},
                           {"t", number(q.t)},
                           {"a", number(q.a)},
                           {"b", number(q.b)},
                           {"c", number(q.c)},
                           {"d", number(q.d)}}});
    list(profile, std::move(elements), {"s", "t"});
    return profile;
  }
  /// What is 0 may be left out.
  XmlElement coefficients(const char* name, const Cubic& all) {
    XmlElement element{name};
    std::vector<Cubic> cubics = {all};
    if (maybe(3)) cubics.push_back(begun_at(cubics, dice_.between(1.0, 20.0)));
    std::vector<XmlElement> made;
    for (const Cubic& c : cubics) {
      XmlElement& one = made.emplace_back(XmlElement{"coefficients", {{"s", number(c.s)}}});
      for (const auto& [key, value] : {std::pair{"a", c.a}, {"b", c.b}, {"c", c.c}, {"d", c.d}})
        if (value != 0.0 || !maybe(2)) one.set(key, number(value));
    }
    list(element, std::move(made), {"s"});
    return element;
  }
  XmlElement strips(const RandomStrips& strips) {
    XmlElement surface{"crossSectionSurface"};
    if (strips.t_offset != 0.0 || !maybe(2)) surface.add(coefficients("tOffset", {0.0, strips.t_offset}));
    XmlElement& list = surface.add({"surfaceStrips"});
    for (const RandomStrips::Strip& strip : strips.strips) {
      XmlElement& made = list.add({"strip", {{"id", whole(strip.id)}}});
      if (strip.relative || (std::abs(strip.id) == 2 && !maybe(2)))
        made.set("mode", strip.relative ? "relative" : "independent");
      if (strip.width > 0.0) made.add(coefficients("width", {0.0, strip.width}));
      const char* names[] = {"constant", "linear", "quadratic", "cubic"};
      for (std::size_t i = 0; i < 4; ++i) made.add(coefficients(names[i], strip.height[i]));
    }
    return surface;
  }
  void crossfall(XmlElement& profile, const std::vector<CrossfallStep>& steps) {
    std::vector<XmlElement> elements;
    const auto add = [&](const char* side, double s, double slope) {
      XmlElement element = cubic("crossfall", "s", {s, std::atan(slope)});
      if (side[0] != 'b' || !maybe(2)) element.attributes.insert(element.attributes.begin(), {"side", side});
      elements.push_back(std::move(element));
    };
    for (const CrossfallStep& step : steps) {
      if (step.left == step.right)
        add("both", step.s, step.left);
      else
        add("left", step.s, step.left), add("right", step.s, step.right);
    }
    if (how_.repeated) dice_.shuffle(elements);
    for (XmlElement& element : elements) profile.add(std::move(element));
  }

  // --- lanes

  XmlElement lanes(const RandomRoad& made) {
    const Road& road = made.road;
    XmlElement element{"lanes"};
    cubics(element, "laneOffset", "s", road.lane_offset, road.length, !made.has_level);
    std::vector<XmlElement> sections;
    for (std::size_t i = 0; i < road.sections.size(); ++i) sections.push_back(section(made, i));
    if (how_.repeated) dice_.shuffle(sections);
    for (XmlElement& made_section : sections) element.add(std::move(made_section));
    return element;
  }
  XmlElement section(const RandomRoad& made, std::size_t index) {
    const LaneSection& section = made.road.sections[index];
    const bool is_last = index + 1 == made.road.sections.size();
    const double length = (is_last ? made.road.length : made.road.sections[index + 1].s) - section.s;
    XmlElement element{"laneSection", {{"s", number(section.s)}}};
    const bool single = made.kept_side[index] != 0 && single_sides();
    if (single)
      element.set("singleSide", flag(true));
    else if (how_.minor >= 4 && maybe(3))
      element.set("singleSide", flag(false));
    for (const int sign : {1, -1}) {
      if (single && made.kept_side[index] == sign) continue;
      const std::vector<Lane>& lanes = sign > 0 ? section.left : section.right;
      if (lanes.empty() && !single && !maybe(2)) continue;
      element.add(side(made, index, sign, length));
    }
    XmlElement center{"lane", {{"id", "0"}, {"type", "none"}, {"level", "false"}}};
    marks(center, section.center);
    element.add({"center", {}, {std::move(center)}});
    return element;
  }
  /// Lanes of that side at the end of the sections that leave it as it is.
  const std::vector<Lane>& behind(const RandomRoad& made, std::size_t index, int sign) const {
    while (single_sides() && index + 1 < made.kept_side.size() && made.kept_side[index + 1] == sign) ++index;
    const LaneSection& section = made.road.sections[index];
    return sign > 0 ? section.left : section.right;
  }
  [[nodiscard]] bool single_sides() const { return !how_.plain && how_.minor >= 4; }

  XmlElement side(const RandomRoad& made, std::size_t index, int sign, double length) {
    const LaneSection& section = made.road.sections[index];
    const std::vector<Lane>&lanes = sign > 0 ? section.left : section.right, &behind = this->behind(made, index, sign);
    XmlElement element{sign > 0 ? "left" : "right"};
    const bool borders = how_.minor >= 4 && maybe(3);
    std::vector<Cubic> border;
    for (const Cubic& c : made.road.lane_offset)
      if (c.s > section.s) border.push_back({c.s - section.s, c.a, c.b, c.c, c.d});
    Cubic first = begun_at(made.road.lane_offset, section.s);
    first.s = 0.0;
    border.insert(border.begin(), first);
    std::vector<XmlElement> elements;
    for (std::size_t i = 0; i < lanes.size(); ++i) {
      const Lane& lane = lanes[i];
      border = added(border, lane.width, sign);
      elements.push_back(this->lane(lane, behind[i].successor, length));
      if (borders)
        cubics(elements.back(), "border", "sOffset", border, length, !made.has_level);
      else
        cubics(elements.back(), "width", "sOffset", lane.width, length, !made.has_level);
    }
    if (how_.plain)
      std::reverse(elements.begin(), elements.end());
    else
      dice_.shuffle(elements);
    for (XmlElement& e : elements) element.add(std::move(e));
    return element;
  }
  static std::vector<Cubic> added(const std::vector<Cubic>& border, const std::vector<Cubic>& width, int sign) {
    std::set<double> starts;
    for (const auto* some : {&border, &width})
      for (const Cubic& c : *some) starts.insert(c.s);
    std::vector<Cubic> sum;
    for (const double s : starts) sum.push_back(sum_of(begun_at(border, s), begun_at(width, s), sign));
    return sum;
  }

  XmlElement lane(const Lane& lane, std::optional<int> successor, double length) {
    XmlElement element{"lane", {{"id", whole(lane.id)}}};
    use(element, lane, length);
    if (lane.level || !maybe(2)) element.set("level", flag(lane.level));
    XmlElement link{"link"};
    if (lane.predecessor) link.add({"predecessor", {{"id", whole(*lane.predecessor)}}});
    if (successor) link.add({"successor", {{"id", whole(*successor)}}});
    if (!link.children.empty() || !maybe(2)) element.add(std::move(link));
    marks(element, lane);
    materials(element, lane);
    std::vector<XmlElement> heights, speeds;
    for (const LaneHeight& h : lane.heights)
      heights.push_back(
          {"height", {{"sOffset", number(h.s_offset)}, {"inner", number(h.inner)}, {"outer", number(h.outer)}}});
    list(element, std::move(heights), {"sOffset"});
    for (const SpeedLimit& limit : lane.speeds) {
      XmlElement& speed = speeds.emplace_back(XmlElement{"speed", {{"sOffset", number(limit.s)}}});
      set_speed(speed, limit.mps);
    }
    list(element, std::move(speeds), {"sOffset"});
    if (maybe(5)) element.add({"rule", {{"sOffset", "0"}, {"value", "no stopping at any time"}}});
    if (how_.minor <= 4 && maybe(5)) element.add({"visibility", {{"sOffset", "0"}, {"forward", "9"}}});
    return element;
  }

  /// Type, direction and access.
  void use(XmlElement& element, const Lane& lane, double length) {
    const bool by_access = how_.minor >= 6 && maybe(2);
    std::string type = type_name(lane.type);
    const bool closed = lane.type == LaneType::bus || lane.type == LaneType::taxi || lane.type == LaneType::other;
    const bool needs_access = lane.type == LaneType::driving || lane.allowed.size() > 1 || lane.type == LaneType::other;
    if (closed && by_access) type = "driving";
    if (lane.type == LaneType::bidirectional && how_.minor >= 8 && maybe(2)) {
      type = "driving";
      element.set("direction", "both");
    } else if (how_.minor >= 8 && maybe(4)) {
      element.set("direction", "standard");
    }
    element.set("type", type);
    if (how_.minor >= 8 && maybe(5)) element.set("roadWorks", "false");
    if (!lane.allowed.empty() && (by_access || needs_access)) return access(element, "allow", lane.allowed, length);
    if (closed && by_access) access(element, "deny", {"passengerCar"}, length);
  }
  void access(XmlElement& element, const char* rule, const std::vector<std::string>& whom, double length) {
    const std::string s = number(maybe(3) ? 0.01 * length : 0.0);
    if (how_.minor >= 8) {
      XmlElement& made = element.add({"access", {{"sOffset", s}, {"rule", rule}}});
      for (const std::string& who : whom) made.add({"restriction", {{"type", who}}});
      return;
    }
    for (const std::string& who : whom) element.add({"access", {{"sOffset", s}, {"rule", rule}, {"restriction", who}}});
  }
  std::string type_name(LaneType type) {
    const bool v8 = how_.minor >= 8, v6 = how_.minor >= 6;
    using Names = std::vector<const char*>;
    Names names;
    switch (type) {
      case LaneType::none:
        names = {"none"};
        break;
      case LaneType::driving:
        names = v8   ? Names{"driving", "entry", "exit", "onRamp", "offRamp", "connectingRamp", "slipLane", "HOV"}
                : v6 ? Names{"driving", "entry", "exit", "onRamp", "offRamp", "connectingRamp"}
                     : Names{"driving", "mwyEntry", "mwyExit"};
        break;
      case LaneType::shoulder:
        names = {"shoulder"};
        break;
      case LaneType::border:
        names = v6 ? Names{"border", "curb"} : Names{"border"};
        break;
      case LaneType::sidewalk:
        names = v8 ? Names{"walking", "sidewalk"} : Names{"sidewalk"};
        break;
      case LaneType::parking:
        names = {"parking"};
        break;
      case LaneType::biking:
        names = {"biking"};
        break;
      case LaneType::bidirectional:
        names = {"bidirectional"};
        break;
      case LaneType::bus:
        names = {"bus"};
        break;
      case LaneType::taxi:
        names = {"taxi"};
        break;
      case LaneType::other:
        names = v8 ? Names{"restricted", "median", "stop", "tram", "rail", "shared"}
                   : Names{"restricted", "median", "stop", "tram", "rail", "special1", "roadWorks"};
        break;
    }
    return names[how_.plain ? 0 : static_cast<std::size_t>(dice_.below(static_cast<int>(names.size())))];
  }
  void marks(XmlElement& element, const Lane& lane) {
    std::vector<XmlElement> made;
    for (const RoadMark& mark : lane.marks) {
      XmlElement& m =
          made.emplace_back(XmlElement{"roadMark", {{"sOffset", number(mark.s_offset)}, {"type", mark.type}}});
      if (mark.width != 0.12 || !maybe(2)) m.set("width", number(mark.width));
      if (!maybe(2)) m.set("color", "standard"), m.set("weight", "standard");
      if (how_.minor >= 4 && maybe(2)) m.set("laneChange", "both"), m.set("material", "standard");
      if (maybe(4))
        m.add({"type",
               {{"name", "x"}, {"width", "0.3"}},
               {{"line", {{"length", "3"}, {"space", "3"}, {"tOffset", "0"}, {"sOffset", "0"}}}}});
      if (how_.minor >= 5 && maybe(4)) m.add({"sway", {{"ds", "0"}, {"a", "0.1"}}});
    }
    list(element, std::move(made), {"sOffset", "type"});
  }
  void materials(XmlElement& element, const Lane& lane) {
    using Names = std::vector<const char*>;
    static const Names names[] = {{"asphalt", "bitumen", "Tarmac"},
                                  {"concrete", "cement"},
                                  {"setts", "cobblestone"},
                                  {"gravel", "macadam"},
                                  {"ground", "grass"}};
    std::vector<XmlElement> made;
    for (const LaneMaterial& material : lane.materials) {
      const Names& some = names[static_cast<std::size_t>(material.surface)];
      XmlElement& m = made.emplace_back(XmlElement{"material", {{"sOffset", number(material.s_offset)}}});
      m.set("surface", some[how_.plain ? 0 : static_cast<std::size_t>(dice_.below(static_cast<int>(some.size())))]);
      if (material.friction != 1.0 || !maybe(2)) m.set("friction", number(material.friction));
      if (material.roughness != 0.0 || maybe(2)) m.set("roughness", number(material.roughness));
    }
    list(element, std::move(made), {"sOffset", "surface"});
  }

  // --- beside the lanes

  XmlElement objects(const Road& road) {
    XmlElement element{"objects"};
    const auto stretch = [&](const char* name, double s, double end) {
      element.add({name, {{"s", number(s)}, {"length", number(end - s)}, {"id", "b1"}, {"type", "concrete"}}});
    };
    for (const RoadStretch& b : road.bridges) stretch("bridge", b.s_start, b.s_end);
    for (const RoadStretch& b : road.tunnels) stretch("tunnel", b.s_start, b.s_end);
    if (road.bridge) stretch("bridge", 0.0, road.length);
    if (road.tunnel) stretch("tunnel", 0.0, road.length);
    for (const RoadObject& object : road.objects) {
      XmlElement& made = element.add({"object",
                                      {{"id", "o1"},
                                       {"type", object.type},
                                       {"subtype", object.subtype},
                                       {"name", object.name},
                                       {"s", number(object.s)},
                                       {"t", number(object.t)},
                                       {"hdg", number(object.hdg)},
                                       {"length", number(object.length)},
                                       {"width", number(object.width)},
                                       {"orientation", "none"},
                                       {"zOffset", "0"}}});
      if (object.outline.empty()) continue;
      XmlElement outline{"outline"};
      for (const auto& corner : object.outline)
        outline.add({"cornerRoad", {{"s", number(corner[0])}, {"t", number(corner[1])}, {"dz", "0"}, {"height", "0"}}});
      if (how_.minor >= 5)
        made.add({"outlines", {}, {std::move(outline)}});
      else
        made.add(std::move(outline));
    }
    if (maybe(3)) {
      element.add({"object", {{"id", "o2"}, {"type", "tree"}, {"s", "1"}, {"t", "9"}}, {{"repeat", {{"s", "1"}}}}});
      element.add({"objectReference", {{"id", "o1"}, {"s", "2"}, {"t", "0"}}});
    }
    return element;
  }
  XmlElement surface(const Road& road) {
    XmlElement element{"surface"};
    for (const SurfaceCrg& crg : road.surface) {
      XmlElement& made = element.add({"CRG",
                                      {{"file", crg.file},
                                       {"sStart", number(crg.s_start)},
                                       {"sEnd", number(crg.s_end)},
                                       {"orientation", crg.orientation},
                                       {"mode", crg.mode},
                                       {"sOffset", number(crg.s_offset)},
                                       {"tOffset", number(crg.t_offset)},
                                       {"zOffset", number(crg.z_offset)},
                                       {"zScale", number(crg.z_scale)}}});
      if (!maybe(2)) made.set("purpose", crg.purpose);
      if (maybe(2)) made.set("hOffset", number(crg.h_offset));
    }
    return element;
  }

  XmlElement junction(const Junction& junction) {
    XmlElement element{"junction", {{"id", id(junction.id)}, {"name", junction.name}}};
    if (how_.minor >= 6 && maybe(2)) element.set("type", "default");
    std::vector<XmlElement> connections;
    for (const Connection& c : junction.connections) {
      XmlElement& made =
          connections.emplace_back(XmlElement{"connection",
                                              {{"id", std::to_string(c.id)},
                                               {"incomingRoad", id(c.incoming_road)},
                                               {"connectingRoad", id(c.connecting_road)},
                                               {"contactPoint", c.contact == ContactPoint::end ? "end" : "start"}}});
      for (const LaneLink& link : c.lane_links)
        made.add({"laneLink", {{"from", whole(link.from)}, {"to", whole(link.to)}}});
    }
    if (!how_.plain) dice_.shuffle(connections);
    for (XmlElement& connection : connections) element.add(std::move(connection));
    for (const Priority& p : junction.priorities) element.add({"priority", {{"high", id(p.high)}, {"low", id(p.low)}}});
    if (maybe(2)) element.add({"controller", {{"id", "1"}, {"type", "0"}}});
    return element;
  }

  const MapSpelling& how_;
  Dice& dice_;
};

}  // namespace

std::string written_id(int id, const MapSpelling& how) {
  if (!how.text_ids) return std::to_string(id);
  switch (id % 4) {
    case 0:
      return "{7a1d-" + std::to_string(id) + "}";
    case 1:
      return std::to_string(4294967296LL + id);
    case 2:
      return "00" + std::to_string(id);
    default:
      return std::to_string(id);
  }
}

std::string spell_opendrive(const RandomMap& map, const MapSpelling& how, unsigned seed) {
  Dice dice(seed);
  return spell_xml(Speller(how, dice).map(map), how.xml, dice);
}

}  // namespace roadquery::test
