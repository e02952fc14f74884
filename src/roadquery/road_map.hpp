#pragma once
// Roads as OpenDRIVE 1.7 describes them, as plain structs of the standard library. The one surface definition: the
// network stage builds it, io writes it, the mesh, the drive and the query evaluate it with the functions in
// road_surface.hpp. Angles in rad, lengths in metres, x east, y north, z up.

#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace roadquery {

// Plan view elements (OpenDRIVE 1.7, 8.2 - 8.6). Each starts at (x, y) with heading hdg.
struct Line {};
struct Arc {
  double curvature = 0.0;  ///< 1/m, positive = left turn
};
struct Spiral {
  double curvature_start = 0.0, curvature_end = 0.0;
};
/// u(p) = a + b p + c p^2 + d p^3 and v(p) likewise in the element's local frame.
struct ParamPoly3 {
  double a_u = 0.0, b_u = 0.0, c_u = 0.0, d_u = 0.0, a_v = 0.0, b_v = 0.0, c_v = 0.0, d_v = 0.0;
  bool normalized = false;  ///< p in [0,1] ("normalized") instead of [0,length] ("arcLength")
};
using PlanShape = std::variant<Line, Arc, Spiral, ParamPoly3>;

struct PlanElement {
  double s = 0.0, x = 0.0, y = 0.0, hdg = 0.0, length = 0.0;
  PlanShape shape;
};

/// value(s) = a + b ds + c ds^2 + d ds^3 with ds = s - this->s, valid until the next one starts.
struct Cubic {
  double s = 0.0, a = 0.0, b = 0.0, c = 0.0, d = 0.0;
};

/// Lateral profile (1.7, 9.4.3): height over the superelevated plane, a + b dt + c dt^2 + d dt^3 with dt = t - this->t,
/// valid until the next t of the same s; the first one of an s also holds to its right.
struct ShapeCubic {
  double s = 0.0, t = 0.0, a = 0.0, b = 0.0, c = 0.0, d = 0.0;
};

/// A reference to an OpenCRG file (1.7, 10.6; schema type t_road_surface_CRG).
struct SurfaceCrg {
  std::string file;  ///< as written: relative to the OpenDRIVE file
  double s_start = 0.0, s_end = 0.0;
  std::string orientation = "same", mode = "genuine", purpose = "elevation";
  double s_offset = 0.0, t_offset = 0.0, z_offset = 0.0, z_scale = 1.0, h_offset = 0.0;
};

enum class LaneType { none, driving, shoulder, border, sidewalk, parking, biking, other };

struct RoadMark {
  double s_offset = 0.0;
  std::string type = "none";  ///< "solid", "broken", "none"
  double width = 0.12;
};

struct Lane {
  int id = 0;  ///< > 0 left, < 0 right, 0 centre
  LaneType type = LaneType::driving;
  std::vector<Cubic> width;  ///< s relative to the start of the lane section; empty for the centre lane
  std::optional<int> predecessor, successor;
  std::vector<RoadMark> marks;
};

struct LaneSection {
  double s = 0.0;
  std::vector<Lane> left;  ///< ids 1, 2, ... outwards
  Lane center;
  std::vector<Lane> right;  ///< ids -1, -2, ... outwards
};

enum class ContactPoint { start, end };
enum class LinkKind { none, road, junction };

struct RoadLink {
  LinkKind kind = LinkKind::none;
  int id = 0;
  ContactPoint contact = ContactPoint::start;  ///< for kind road
};

struct Road {
  int id = 0;
  std::string name;
  double length = 0.0;
  int junction = -1;  ///< id of the junction this is a connecting road of, or -1
  bool left_hand_traffic = false;
  RoadLink predecessor, successor;
  std::vector<PlanElement> plan;
  std::vector<Cubic> elevation;
  std::vector<Cubic> superelevation;  ///< positive = left side higher (rotation about the reference line, 1.7 9.3)
  std::vector<ShapeCubic> shape;      ///< sorted by s, then t; linear in s between two s, as the last one after it
  std::vector<SurfaceCrg> surface;
  std::vector<Cubic> lane_offset;
  std::vector<LaneSection> sections;
  double speed_limit_mps = 0.0;  ///< of the first <type>; 0: none given
  // Our userData: where the road comes from.
  std::string osm_id, highway;
  int layer = 0;
  bool bridge = false, tunnel = false;
};

struct LaneLink {
  int from = 0, to = 0;
};
struct Connection {
  int id = 0, incoming_road = 0, connecting_road = 0;
  ContactPoint contact = ContactPoint::start;
  std::vector<LaneLink> lane_links;
};
/// Of two connecting roads: who is on `high` goes first.
struct Priority {
  int high = 0, low = 0;
};
struct Junction {
  int id = 0;
  std::string name;
  std::vector<Connection> connections;
  std::vector<Priority> priorities;
};

struct RoadMap {
  std::string name;
  std::string geo_reference;  ///< PROJ string; coordinates are absolute in that CRS
  double north = 0.0, south = 0.0, east = 0.0, west = 0.0;
  std::vector<Road> roads;          ///< sorted by id
  std::vector<Junction> junctions;  ///< sorted by id
};

/// Reads OpenDRIVE 1.4 - 1.8 (what of it the structs above hold). Throws std::runtime_error "file: line: what".
[[nodiscard]] RoadMap read_opendrive(const std::string& path);

}  // namespace roadquery
