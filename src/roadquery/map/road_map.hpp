// SPDX-License-Identifier: Apache-2.0
#pragma once
// Roads as OpenDRIVE 1.7 describes them, as plain structs of the standard library. The one surface definition: the
// network stage builds it, io writes it, the mesh, the drive and the query evaluate it with the functions in
// road_surface.hpp. Angles in rad, lengths in metres, x east, y north, z up.

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "roadquery/map/driving_side.hpp"
#include "roadquery/map/surface_class.hpp"

namespace roadquery {

// Plan view elements (OpenDRIVE 1.7, 8.2 - 8.6). Each starts at (x, y) with heading hdg.
struct Line {};
struct Arc {
  double curvature = 0.0;  ///< 1/m, positive = left turn
};
struct Spiral {
  double curvature_start = 0.0, curvature_end = 0.0;
};
/// u(p) = a + b p + c p^2 + d p^3 and v(p) likewise in the element's local frame. The element's length is that of the
/// curve: p is found from the distance along it (poly_curve.hpp).
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
  double x_offset = 0.0, y_offset = 0.0;  ///< mode "global" (1.9, 10.6.1.4): where the file's origin lies
};

/// bidirectional: cars of both directions; bus and taxi: no others.
enum class LaneType { none, driving, shoulder, border, sidewalk, parking, biking, other, bidirectional, bus, taxi };

/// Whether cars drive on lanes of this type.
[[nodiscard]] constexpr bool is_driven(LaneType type) {
  return type == LaneType::driving || type == LaneType::bidirectional;
}

/// A line of a road mark that is written out (OpenDRIVE 1.8.1, 11.9.2 and 11.9.3).
struct RoadMarkLine {
  double length = 0.0, space = 0.0;       ///< m, of its strokes and of the gaps between them; no gap: without an end
  double t_offset = 0.0, s_offset = 0.0;  ///< m, to the left of the lane's border and from the start of the mark
  double width = 0.0;                     ///< m; 0: that of the mark
  std::string color;                      ///< empty: that of the mark
  bool is_single_stroke = false;          ///< `length` long, not repeated (<explicit>)
};
struct RoadMark {
  double s_offset = 0.0;
  std::string type = "none";  ///< as OpenDRIVE names it: "solid", "broken", "solid broken", "botts dots", "none" ...
  double width = 0.12;        ///< m, of each of its lines
  std::string color = "standard";   ///< as OpenDRIVE names it; "standard" is white
  std::vector<RoadMarkLine> lines;  ///< what it consists of; empty: what its type means
};

/// What a lane is made of from s_offset on (OpenDRIVE 1.7, 11.7.2 <material>).
struct LaneMaterial {
  double s_offset = 0.0;  ///< relative to the start of the lane section
  SurfaceClass surface = SurfaceClass::asphalt;
  double friction = 1.0;   ///< largest force over load that a tyre finds, as written: of the site's weather
  double roughness = 0.0;  ///< m, root mean square of the heights over the smooth surface
};

/// Height of a lane over the road's surface (1.7, 11.7.4 <height>): linear across the lane, and linear in s from one
/// entry to the next; the first also holds before it, the last after it.
struct LaneHeight {
  double s_offset = 0.0;            ///< relative to the start of the lane section
  double inner = 0.0, outer = 0.0;  ///< m, along z, at the border to the centre and at the outer one
};

/// What may be driven from s on; s of a lane's is relative to the start of the lane section.
struct SpeedLimit {
  double s = 0.0;
  double mps = 0.0;  ///< infinity: no limit; 0: not given
};

struct Lane {
  int id = 0;  ///< > 0 left, < 0 right, 0 centre
  LaneType type = LaneType::driving;
  std::vector<Cubic> width;  ///< s relative to the start of the lane section; empty for the centre lane
  std::optional<int> predecessor, successor;
  std::vector<RoadMark> marks;
  std::vector<LaneMaterial> materials;  ///< sorted by s_offset; empty: asphalt, friction 1
  std::vector<LaneHeight> heights;      ///< sorted by s_offset; empty: on the road's surface
  std::vector<SpeedLimit> speeds;       ///< sorted by s; before them, and where they give none, the road's counts
  bool level = false;                   ///< as written; read_opendrive has put what it means into `heights`
  /// Who alone may use it (1.7, 11.7.5 <access rule="allow">: "bus", "taxi", "bicycle"); empty: as its type says.
  std::vector<std::string> allowed;
};

struct LaneSection {
  double s = 0.0;
  std::vector<Lane> left;  ///< ids 1, 2, ... outwards
  Lane center;
  std::vector<Lane> right;  ///< ids -1, -2, ... outwards
};

/// What is painted on a road or stands on it (1.7, 13): we know crosswalks, road marks, humps and barriers.
struct RoadObject {
  std::string type, subtype, name;
  double s = 0.0, t = 0.0;                     ///< middle of the box
  double hdg = 0.0;                            ///< of the box's length against the road's direction, rad
  double length = 0.0, width = 0.0;            ///< of the box, m
  double height = 0.0;                         ///< of the box over the road, m; 0: painted, or a part of the surface
  std::vector<std::array<double, 2>> outline;  ///< s and t of the corners; empty: the box
};

/// A part of a road.
struct RoadStretch {
  double s_start = 0.0, s_end = 0.0;
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
  DrivingSide driving_side = DrivingSide::right;
  RoadLink predecessor, successor;
  std::vector<PlanElement> plan;
  std::vector<Cubic> elevation;
  std::vector<Cubic> superelevation;  ///< positive = left side higher (rotation about the reference line, 1.7 9.3)
  std::vector<ShapeCubic> shape;      ///< sorted by s, then t; linear in s between two s, as the last one after it
  std::vector<SurfaceCrg> surface;
  std::vector<Cubic> lane_offset;
  std::vector<LaneSection> sections;
  std::vector<RoadObject> objects;
  double speed_limit_mps = 0.0;          ///< of the first <type> that gives one; 0: none given, infinity: "no limit"
  std::vector<SpeedLimit> speed_limits;  ///< of every <type>, sorted by s; empty: speed_limit_mps everywhere
  std::vector<RoadStretch> bridges, tunnels;  ///< of <objects>, sorted by s_start (road_structures.hpp)
  std::string text_id;                        ///< the id as written where it is no whole number of 32 bits; else empty
  // Our userData: where the road comes from.
  std::string osm_id, highway;
  int layer = 0;
  bool bridge = false, tunnel = false;  ///< the whole road: of our userData, or of a <bridge> or <tunnel> as long as it
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
/// The end of a road at a junction, as the junction's surface meets it: a strip that goes on straight into the junction
/// with the road's height and slope.
struct JunctionArm {
  /// Across the strip, from right to left: where it begins, its height there and its slope into the junction, linear in
  /// between and beyond.
  struct Place {
    double left_m = 0.0;       ///< of the end of the reference line, seen into the junction
    double z = 0.0;            ///< m
    double dz_dinwards = 0.0;  ///< 1
    double in_m = 0.0;         ///< of that end, into the junction: of a road with superelevation on a slope
  };
  double x = 0.0, y = 0.0;        ///< end of the reference line
  double in_x = 1.0, in_y = 0.0;  ///< unit vector into the junction
  std::vector<Place> places;      ///< at least two; left_m ascends: the road's edges and what bends between them
  double slant_m = 0.0;           ///< largest |in_m| of them
};

/// The whole paved area of a junction as one height field: what lies inside the boundary has this surface, and no
/// road's. junction_surface.hpp evaluates it.
struct JunctionSurface {
  std::vector<std::array<double, 2>> boundary;  ///< ring without its first point again, counter-clockwise, m
  /// Heights in m at (x + column spacing_m, y + row spacing_m), row by row from the south; axes of the map's CRS.
  /// At least one node beyond every cell that the boundary touches.
  double x = 0.0, y = 0.0, spacing_m = 1.0;
  int columns = 0, rows = 0;
  std::vector<double> z;
  /// Not in files: join_arms() takes them from the map's roads.
  std::vector<JunctionArm> arms;
};

struct Junction {
  int id = 0;
  std::string name;
  std::vector<Connection> connections;
  std::vector<Priority> priorities;
  std::optional<JunctionSurface> surface;  ///< none: the roads' own surfaces, blended where they overlap
};

class RoadCrgs;

/// What was odd in a file, or of which elements nothing is kept: one for each kind, with its first place.
struct ReadingNote {
  std::string code;      ///< short and stable: "opendrive.not_sorted"
  std::string message;   ///< one sentence with how often
  bool matters = false;  ///< the surface, the lanes or the limits may not be what the writer meant
  int road = -1;         ///< id of the road of the first place; -1: it is of no road
  double s = 0.0;        ///< m, on that road
};

struct RoadMap {
  std::string name;
  std::string geo_reference;  ///< PROJ string; coordinates are absolute in that CRS
  double north = 0.0, south = 0.0, east = 0.0, west = 0.0;
  /// <offset> of the header as written; read_opendrive has applied it to all coordinates as it was told.
  std::array<double, 3> header_offset_m = {0.0, 0.0, 0.0};
  double header_offset_hdg = 0.0;
  std::vector<Road> roads;          ///< sorted by id
  std::vector<Junction> junctions;  ///< sorted by id
  std::vector<ReadingNote> notes;   ///< of read_opendrive
  /// OpenCRG files laid on the roads, by their index (load_crgs of road_crgs.hpp); none: the roads as they stand.
  std::shared_ptr<const RoadCrgs> crgs;
};

/// What is done with the header's <offset>. `add` gives coordinates of the geoReference's CRS: the file's are turned by
/// its heading about their origin, then moved. `subtract` is the way back.
enum class HeaderOffset { add, ignore, subtract };

/// Reads OpenDRIVE 1.1 - 1.8 (what of it the structs above hold). Ids that are no whole numbers of 32 bits get numbers
/// that the file does not use. RoadMap::notes has what was odd, and what of the file is not kept. Throws
/// std::runtime_error "file: line: what".
[[nodiscard]] RoadMap read_opendrive(const std::string& path, HeaderOffset offset = HeaderOffset::add);

}  // namespace roadquery
