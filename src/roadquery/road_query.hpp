#pragma once
// Which road, and how high, is under a point? Made for tyre contact points that ask 1000 times a second.

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "roadquery/road_surface.hpp"

namespace roadquery {

/// A point of a road's surface.
struct Hit {
  int road = -1;  ///< index into RoadQuery::map().roads
  double s = 0.0, t = 0.0;
  double z = 0.0;                                  ///< of the blended surface where roads of one level overlap
  std::array<double, 3> normal = {0.0, 0.0, 1.0};  ///< unit, upwards
  int lane_id = 0;                                 ///< 0 when exactly on the edge of a road without lanes there
};

/// Remembers where the last query of one moving point ended, so that the next one begins there. One a point; start with
/// Cursor{}.
struct Cursor {
  int road = -1;
  double s = 0.0;
};

/// Finds the road under a point: a grid over short pieces of the reference lines, then Newton's method on the reference
/// line. find() is const, does not allocate and may be called from many threads, each with its own cursors.
///
/// Where surfaces lie one above the other the one nearest to z_hint wins (NaN: the highest). Surfaces within 1.5 m of
/// that one are the same level (overlapping roads of a junction): z and normal are their mean, weighted by the distance
/// of the point to each road's own edges and ends, so that there is no step where another road begins. The scene stage
/// blends alike. The hit names the cursor's road while the point is inside its edges, else the one it lies deepest in.
/// Up to 0.25 m beyond the end of a road its surface goes on where nothing else is: that closes the wedge between two
/// roads that meet at a slight angle.
class RoadQuery {
 public:
  explicit RoadQuery(RoadMap map);

  [[nodiscard]] const RoadMap& map() const { return map_; }
  /// Nothing when no road is under (x, y). A cursor whose surface lies within 1 m of z_hint makes the query coherent:
  /// one road is looked at instead of all nearby.
  [[nodiscard]] std::optional<Hit> find(double x, double y, double z_hint, Cursor& cursor) const;

 private:
  /// A piece of a reference line and a box around its surface.
  struct Piece {
    int road = 0;
    double s_begin = 0.0, s_end = 0.0;
    double min_x = 0.0, min_y = 0.0, max_x = 0.0, max_y = 0.0;
    PlanPoint middle;
    double cos_hdg = 1.0, sin_hdg = 0.0;  ///< of the middle
    double reach_m = 0.0;                 ///< largest distance of the surface from the reference line
    bool alone = true;                    ///< no other road overlaps it
  };
  void cut_into_pieces(int road);
  void fill_grid();
  void find_overlaps();
  [[nodiscard]] static double guess_s(const Piece& piece, double x, double y);
  [[nodiscard]] bool is_alone(int road, double s) const;
  [[nodiscard]] std::optional<Hit> search(double x, double y, double z_hint, int preferred_road) const;

  RoadMap map_;
  std::vector<Piece> pieces_;             // by road, then by s
  std::vector<std::size_t> first_piece_;  // of each road, and the count of all
  // The grid: pieces that touch cell (column, row) are cell_pieces_[cell_begin_[i] .. cell_begin_[i + 1]).
  double west_ = 0.0, south_ = 0.0, cell_m_ = 1.0;
  int columns_ = 0, rows_ = 0;
  std::vector<std::uint32_t> cell_begin_, cell_pieces_;
};

}  // namespace roadquery
