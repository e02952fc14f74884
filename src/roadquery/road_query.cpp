#include "roadquery/road_query.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace roadquery {
namespace {

constexpr double max_piece_m = 12.0;
constexpr double max_piece_turn_rad = 0.3;  // small enough for Newton to converge from any place of the piece
constexpr double sample_m = 2.0;            // spacing of the samples that bound a piece
constexpr double box_margin_m = 0.5;  // more than the sagitta between two samples at the tightest radius of a road
constexpr double min_cell_m = 16.0;
constexpr double max_cells = 1e6;

constexpr double seam_m = 0.25;  // how far a surface goes on beyond the end of its road
constexpr double edge_rounding_m = 1e-6;
constexpr double same_level_m = 1.5;  // surfaces of one junction differ by less, the floors of a car park by more
constexpr double coherent_level_m = 1.0;
constexpr double last_step_m = 1e-4;  // the step after one this small would be below 1e-8 m
constexpr int max_steps = 12;
constexpr std::size_t max_overlaps = 64;

struct Foot {
  double s = 0.0;
  double along = 0.0;  ///< what is left of the distance along the line: not 0 only at the ends of the range
  double left = 0.0;   ///< horizontal distance, positive to the left
  PlanPoint reference;
};

/// Foot of the perpendicular from (x, y) onto the reference line, by Newton's method from s, within [s_min, s_max].
std::optional<Foot> project(const Road& road, double x, double y, double s, double s_min, double s_max) {
  double step = 0.0;
  for (int i = 0; i < max_steps; ++i) {
    s = std::clamp(s, s_min, s_max);
    PlanPoint p = reference_point(road, s);
    const double c = std::cos(p.hdg), n = std::sin(p.hdg);
    const double along = (x - p.x) * c + (y - p.y) * n;
    const double left = (y - p.y) * c - (x - p.x) * n;
    // Beyond the centre of curvature (1 - k left <= 0) the Newton step would point away from the line.
    step = along / (p.speed * std::max(1.0 - p.curvature * left, 0.2));
    const double next = s + step;
    if ((next <= s_min && s == s_min) || (next >= s_max && s == s_max)) return Foot{s, along, left, p};
    if (std::abs(step) < last_step_m) {
      p.x += step * p.speed * c, p.y += step * p.speed * n, p.hdg += step * p.speed * p.curvature;
      return Foot{next, 0.0, left, p};
    }
    // At a kink between two elements there is no foot on the outer side: the steps go to and fro around the kink.
    if (i + 1 == max_steps && std::abs(step) <= seam_m) return Foot{s, 0.0, left, p};
    s = next;
  }
  return std::nullopt;
}

int lane_at(const Road& road, double s, double t) {
  const LaneSection& section = section_at(road, s);
  double rest = t - evaluate(road.lane_offset, s);
  const std::vector<Lane>& lanes = rest > 0.0 || section.right.empty() ? section.left : section.right;
  rest = std::abs(rest);
  for (const Lane& lane : lanes) {
    rest -= lane_width(lane, s - section.s);
    if (rest <= edge_rounding_m) return lane.id;
  }
  return 0;
}

/// A surface under the point.
struct Candidate {
  int road = -1;
  Foot foot;
  double t = 0.0, z = 0.0;
  double inside_m = 0.0;  ///< distance to the nearest of the road's edges and ends
  bool on_seam = false;   ///< beyond the end of the road, or of its piece: then the neighbour piece is not
};

std::optional<Candidate> candidate_at(const Road& road, int index, const std::optional<Foot>& foot) {
  if (!foot || std::abs(foot->along) > seam_m) return std::nullopt;
  const double t = t_at(road, foot->s, foot->left);
  const Edges edges = road_edges(road, foot->s);
  if (t < edges.right_t - edge_rounding_m || t > edges.left_t + edge_rounding_m) return std::nullopt;
  const double inside_m = std::min({edges.left_t - t, t - edges.right_t, foot->s, road.length - foot->s});
  return Candidate{index,
                   *foot,
                   t,
                   surface_height(road, foot->s, t),
                   std::max(inside_m, 0.0),
                   std::abs(foot->along) > edge_rounding_m};
}

Hit to_hit(const Road& road, const Candidate& c) {
  const SurfacePoint point = surface_point(road, c.foot.s, c.t, c.foot.reference);
  return {c.road,
          c.foot.s,
          c.t,
          point.z,
          {point.normal[0], point.normal[1], point.normal[2]},
          lane_at(road, c.foot.s, c.t)};
}

/// Mean of the surfaces, weighted by how far inside each the point lies: without a step where one begins or ends.
Hit blend(const std::vector<Road>& roads, std::span<const Candidate> surfaces, const Candidate& named) {
  constexpr double border_weight_m = 1e-6;  // a point on the very borders of all has a height, too
  Hit hit = to_hit(roads[static_cast<std::size_t>(named.road)], named);
  if (surfaces.size() == 1) return hit;
  double sum_weight = 0.0, sum_z = 0.0;
  std::array<double, 3> sum_normal = {0.0, 0.0, 0.0};
  for (const Candidate& c : surfaces) {
    const SurfacePoint point = surface_point(roads[static_cast<std::size_t>(c.road)], c.foot.s, c.t, c.foot.reference);
    const double weight = c.inside_m + border_weight_m;
    sum_weight += weight, sum_z += weight * point.z;
    for (std::size_t k = 0; k < 3; ++k) sum_normal[k] += weight * point.normal[k];
  }
  const double norm = std::hypot(sum_normal[0], sum_normal[1], sum_normal[2]);
  hit.z = sum_z / sum_weight;
  for (std::size_t k = 0; k < 3; ++k) hit.normal[k] = sum_normal[k] / norm;
  return hit;
}

}  // namespace

RoadQuery::RoadQuery(RoadMap map) : map_(std::move(map)) {
  for (std::size_t i = 0; i < map_.roads.size(); ++i) cut_into_pieces(static_cast<int>(i));
  first_piece_.push_back(pieces_.size());
  fill_grid();
  find_overlaps();
}

void RoadQuery::cut_into_pieces(int index) {
  const Road& road = map_.roads[static_cast<std::size_t>(index)];
  first_piece_.push_back(pieces_.size());
  for (std::size_t i = 0; i < road.plan.size(); ++i) {
    const PlanElement& element = road.plan[i];
    const double begin = std::max(element.s, 0.0);
    const double end = std::min(i + 1 < road.plan.size() ? road.plan[i + 1].s : road.length, road.length);
    if (end < begin || (end == begin && road.length > 0.0)) continue;
    // The turn is not monotonous in a spiral through 0 or a polynomial: sum it over samples.
    const int samples = 1 + static_cast<int>((end - begin) / sample_m);
    double turn = 0.0;
    for (int k = 0; k < samples; ++k) {
      const double step = (end - begin) / samples;
      turn += step * std::abs(evaluate(element, begin - element.s + (k + 0.5) * step).curvature);
    }
    const int count = 1 + static_cast<int>(std::max((end - begin) / max_piece_m, turn / max_piece_turn_rad));
    for (int k = 0; k < count; ++k) {
      Piece piece{index, begin + (end - begin) * k / count, begin + (end - begin) * (k + 1) / count};
      piece.min_x = piece.min_y = std::numeric_limits<double>::infinity();
      piece.max_x = piece.max_y = -std::numeric_limits<double>::infinity();
      double reach = 0.0;
      const int steps = 1 + static_cast<int>((piece.s_end - piece.s_begin) / sample_m);
      for (int j = 0; j <= steps; ++j) {
        const double s = piece.s_begin + (piece.s_end - piece.s_begin) * j / steps;
        const PlanPoint p = reference_point(road, s);
        const Edges edges = road_edges(road, s);
        reach = std::max({reach, std::abs(edges.left_t), std::abs(edges.right_t)});
        piece.min_x = std::min(piece.min_x, p.x), piece.max_x = std::max(piece.max_x, p.x);
        piece.min_y = std::min(piece.min_y, p.y), piece.max_y = std::max(piece.max_y, p.y);
      }
      piece.reach_m = reach += box_margin_m;
      piece.middle = reference_point(road, 0.5 * (piece.s_begin + piece.s_end));
      piece.cos_hdg = std::cos(piece.middle.hdg), piece.sin_hdg = std::sin(piece.middle.hdg);
      piece.min_x -= reach, piece.min_y -= reach, piece.max_x += reach, piece.max_y += reach;
      pieces_.push_back(piece);
    }
  }
}

void RoadQuery::fill_grid() {
  if (pieces_.empty()) return;
  double east = -std::numeric_limits<double>::infinity(), north = east;
  west_ = south_ = std::numeric_limits<double>::infinity();
  for (const Piece& p : pieces_) {
    west_ = std::min(west_, p.min_x), south_ = std::min(south_, p.min_y);
    east = std::max(east, p.max_x), north = std::max(north, p.max_y);
  }
  cell_m_ = std::max(min_cell_m, std::sqrt((east - west_) * (north - south_) / max_cells));
  columns_ = 1 + static_cast<int>((east - west_) / cell_m_);
  rows_ = 1 + static_cast<int>((north - south_) / cell_m_);

  const auto for_cells = [&](const Piece& p, auto&& visit) {
    const int c0 = static_cast<int>((p.min_x - west_) / cell_m_), c1 = static_cast<int>((p.max_x - west_) / cell_m_);
    const int r0 = static_cast<int>((p.min_y - south_) / cell_m_), r1 = static_cast<int>((p.max_y - south_) / cell_m_);
    for (int r = r0; r <= r1; ++r) {
      for (int c = c0; c <= c1; ++c)
        visit(static_cast<std::size_t>(r) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(c));
    }
  };
  cell_begin_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_) + 1, 0);
  for (const Piece& p : pieces_) for_cells(p, [&](std::size_t cell) { ++cell_begin_[cell + 1]; });
  for (std::size_t i = 1; i < cell_begin_.size(); ++i) cell_begin_[i] += cell_begin_[i - 1];
  cell_pieces_.resize(cell_begin_.back());
  std::vector<std::uint32_t> next(cell_begin_.begin(), cell_begin_.end() - 1);
  for (std::uint32_t i = 0; i < pieces_.size(); ++i) {
    for_cells(pieces_[i], [&](std::size_t cell) { cell_pieces_[next[cell]++] = i; });
  }
}

/// A piece is alone where no other road's reference line comes nearer than both reach.
void RoadQuery::find_overlaps() {
  // Reference points of every piece, so dense that a line passes at most half their spacing from one.
  std::vector<std::vector<PlanPoint>> points(pieces_.size());
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    const Piece& p = pieces_[i];
    const int steps = 1 + static_cast<int>((p.s_end - p.s_begin) / sample_m);
    for (int k = 0; k <= steps; ++k) {
      points[i].push_back(
          reference_point(map_.roads[static_cast<std::size_t>(p.road)], p.s_begin + (p.s_end - p.s_begin) * k / steps));
    }
  }
  const auto touch = [&](std::size_t i, std::size_t j) {
    const Piece &a = pieces_[i], &b = pieces_[j];
    if (a.min_x > b.max_x || b.min_x > a.max_x || a.min_y > b.max_y || b.min_y > a.max_y) return false;
    const double near = a.reach_m + b.reach_m + sample_m;  // half a spacing of each
    return std::any_of(points[i].begin(), points[i].end(), [&](const PlanPoint& p) {
      return std::any_of(points[j].begin(), points[j].end(), [&](const PlanPoint& q) {
        return (p.x - q.x) * (p.x - q.x) + (p.y - q.y) * (p.y - q.y) < near * near;
      });
    });
  };
  for (std::size_t cell = 0; cell + 1 < cell_begin_.size(); ++cell) {
    const std::span<const std::uint32_t> here{cell_pieces_.data() + cell_begin_[cell],
                                              cell_begin_[cell + 1] - cell_begin_[cell]};
    for (const std::uint32_t i : here) {
      for (const std::uint32_t j : here) {
        if (!pieces_[i].alone) break;
        if (pieces_[i].road != pieces_[j].road && touch(i, j)) pieces_[i].alone = false;
      }
    }
  }
}

bool RoadQuery::is_alone(int road, double s) const {
  const auto begin = pieces_.begin() + static_cast<std::ptrdiff_t>(first_piece_[static_cast<std::size_t>(road)]);
  const auto end = pieces_.begin() + static_cast<std::ptrdiff_t>(first_piece_[static_cast<std::size_t>(road) + 1]);
  const auto after = std::upper_bound(begin, end, s, [](double v, const Piece& p) { return v < p.s_begin; });
  return after != begin && (after - 1)->alone;
}

/// Foot on the circle of curvature in the middle of the piece, which saves Newton two steps of four.
double RoadQuery::guess_s(const Piece& piece, double x, double y) {
  const PlanPoint& m = piece.middle;
  const double dx = x - m.x, dy = y - m.y;
  const double along = dx * piece.cos_hdg + dy * piece.sin_hdg, left = dy * piece.cos_hdg - dx * piece.sin_hdg;
  const double turn = std::atan2(m.curvature * along, 1.0 - m.curvature * left);
  const double step = std::abs(m.curvature) > 1e-6 ? turn / m.curvature : along;
  return 0.5 * (piece.s_begin + piece.s_end) + step / m.speed;
}

std::optional<Hit> RoadQuery::find(double x, double y, double z_hint, Cursor& cursor) const {
  if (cursor.road >= 0 && static_cast<std::size_t>(cursor.road) < map_.roads.size()) {
    const Road& road = map_.roads[static_cast<std::size_t>(cursor.road)];
    const auto here = candidate_at(road, cursor.road, project(road, x, y, cursor.s, 0.0, road.length));
    if (here && !here->on_seam && std::abs(here->z - z_hint) <= coherent_level_m &&
        is_alone(cursor.road, here->foot.s)) {
      cursor.s = here->foot.s;
      return to_hit(road, *here);
    }
  }
  const auto hit = search(x, y, z_hint, cursor.road);
  cursor = hit ? Cursor{hit->road, hit->s} : Cursor{};
  return hit;
}

std::optional<Hit> RoadQuery::search(double x, double y, double z_hint, int preferred_road) const {
  const double column = std::floor((x - west_) / cell_m_), row = std::floor((y - south_) / cell_m_);
  if (!(column >= 0.0 && column < columns_ && row >= 0.0 && row < rows_)) return std::nullopt;
  const std::size_t cell =
      static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(column);

  std::array<Candidate, max_overlaps> found;
  std::size_t count = 0;
  for (std::uint32_t i = cell_begin_[cell]; i < cell_begin_[cell + 1] && count < found.size(); ++i) {
    const Piece& piece = pieces_[cell_pieces_[i]];
    if (x < piece.min_x || x > piece.max_x || y < piece.min_y || y > piece.max_y) continue;
    const Road& road = map_.roads[static_cast<std::size_t>(piece.road)];
    const auto foot = project(road, x, y, guess_s(piece, x, y), piece.s_begin, piece.s_end);
    const auto candidate = candidate_at(road, piece.road, foot);
    if (!candidate) continue;
    // Two pieces of a road share the foot where they meet: count it once.
    const bool again =
        count > 0 && found[count - 1].road == piece.road && std::abs(found[count - 1].foot.s - foot->s) < seam_m;
    if (again && (candidate->on_seam || !found[count - 1].on_seam)) continue;
    found[again ? count - 1 : count++] = *candidate;
  }
  if (count == 0) return std::nullopt;

  auto end = found.begin() + static_cast<std::ptrdiff_t>(count);
  const auto level_distance = [&](const Candidate& c) { return std::isnan(z_hint) ? -c.z : std::abs(c.z - z_hint); };
  const double level_z = std::min_element(found.begin(), end, [&](const Candidate& a, const Candidate& b) {
                           return level_distance(a) < level_distance(b);
                         })->z;
  end = std::remove_if(found.begin(), end, [&](const Candidate& c) { return std::abs(c.z - level_z) > same_level_m; });
  if (std::any_of(found.begin(), end, [](const Candidate& c) { return !c.on_seam; })) {
    end = std::remove_if(found.begin(), end, [](const Candidate& c) { return c.on_seam; });
  }
  const auto named = std::max_element(found.begin(), end, [&](const Candidate& a, const Candidate& b) {
    if ((a.road == preferred_road) != (b.road == preferred_road)) return b.road == preferred_road;
    return a.inside_m < b.inside_m;
  });
  return blend(map_.roads, {found.begin(), end}, *named);
}

}  // namespace roadquery
