// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/evaluate/roads/evaluate_roads.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "orthodrive/evaluate/labels/no_value.hpp"
#include "orthodrive/evaluate/labels/overlap.hpp"
#include "orthodrive/evaluate/roads/roads_across.hpp"

namespace orthodrive {
std::vector<Polygon> surface_polygons(const RoadNetwork& roads) {
  std::vector<Polygon> all;
  for (const RoadPath& path : roads.paths)
    for (Polygon& polygon : evaluate::carriageway_polygons(path)) all.push_back(std::move(polygon));
  return all;
}

std::vector<Polygon> surface_polygons(const RoadTruth& truth) {
  std::vector<Polygon> all;
  for (const TruthSurface& surface : truth.surfaces)
    all.insert(all.end(), surface.polygons.begin(), surface.polygons.end());
  return all;
}

SurfaceErrors surface_errors(const RoadNetwork& roads, const RoadTruth& truth, const ScoreRegion& region) {
  auto [ours, theirs] = evaluate::overlap_differences(surface_polygons(roads), surface_polygons(truth), region);
  return {std::move(ours), std::move(theirs)};
}

namespace {

constexpr double other_road_m = 15.0;  // a road further across than this is another road

/// Width of the surface across a line at p, where it is on it: between the two borders around p.
std::optional<double> width_across(const MultiPolygon& surface, Vec2 p, Vec2 direction) {
  const Vec2 left = left_normal(direction);
  std::vector<double> crossings;
  const auto add = [&](const Ring& ring) {
    for (std::size_t i = 0, j = ring.size() - 1; i < ring.size(); j = i++) {
      const double a = dot(ring[j] - p, direction), b = dot(ring[i] - p, direction);
      if ((a > 0.0) == (b > 0.0)) continue;
      crossings.push_back(dot(ring[j] - p, left) + a / (a - b) * dot(ring[i] - ring[j], left));
    }
  };
  for (const Polygon& polygon : surface) {
    if (!contains(polygon, p)) continue;
    add(polygon.outer);
    for (const Ring& hole : polygon.holes) add(hole);
    break;
  }
  std::sort(crossings.begin(), crossings.end());
  const auto above = std::upper_bound(crossings.begin(), crossings.end(), 0.0);
  if (above == crossings.begin() || above == crossings.end()) return {};
  return *above - *(above - 1);
}

class TruthWidths {
 public:
  explicit TruthWidths(const RoadTruth& truth) : truth_(truth) {
    for (const TruthSurface& surface : truth.surfaces) {
      by_id_.emplace(surface.id, &surface);
      Ring corners;
      for (const Polygon& polygon : surface.polygons)
        corners.insert(corners.end(), polygon.outer.begin(), polygon.outer.end());
      bounds_.push_back(bounds_of(corners));
    }
  }
  [[nodiscard]] std::optional<double> at(const TruthLine& line, std::size_t segment, double fraction, Vec2 p,
                                         Vec2 direction) const {
    if (!line.width_m.empty())
      return line.width_m[segment] + fraction * (line.width_m[segment + 1] - line.width_m[segment]);
    if (const auto found = by_id_.find(line.of); found != by_id_.end())
      return width_across(found->second->polygons, p, direction);
    for (std::size_t i = 0; i < bounds_.size(); ++i) {
      if (!bounds_[i].contains(p)) continue;
      if (const auto width = width_across(truth_.surfaces[i].polygons, p, direction)) return width;
    }
    return {};
  }

 private:
  const RoadTruth& truth_;
  std::map<std::string, const TruthSurface*> by_id_;
  std::vector<Box2> bounds_;  ///< of the surfaces, so that a line without a name need not try all
};

/// Counts where refinement went the wrong way.
class MoveCount {
 public:
  void add(double before_m, double after_m) {  // NaN after: out of reach
    ++places_;
    const double further_m =
        std::isnan(after_m) ? std::numeric_limits<double>::infinity() : std::abs(after_m) - std::abs(before_m);
    away_ += further_m > nothing_m ? 1 : 0;
    far_away_ += further_m > 0.3 ? 1 : 0;
  }
  [[nodiscard]] MovedAway moved_away() const {
    if (places_ == 0) return {no_value, no_value, 0};
    const auto n = static_cast<double>(places_);
    return {static_cast<double>(away_) / n, static_cast<double>(far_away_) / n, places_};
  }

 private:
  static constexpr double nothing_m = 1e-3;
  std::size_t places_ = 0, away_ = 0, far_away_ = 0;
};

double length_inside_m(const Polyline& line, const ScoreRegion& region) {
  double length = 0.0;
  for (std::size_t i = 0; i + 1 < line.size(); ++i)
    if (region.contains(0.5 * (line[i] + line[i + 1]))) length += distance(line[i], line[i + 1]);
  return length;
}

/// Our ways that run along truth lines before they are refined, by at least half of what lies in the region.
RoadNetwork known_ways(const RoadNetwork& roads, const RoadNetwork& before, const RoadTruth& truth,
                       const ScoreRegion& region) {
  constexpr double reach_m = 6.0, step_m = 2.0;
  RoadNetwork lines;
  for (const TruthLine& line : truth.lines) {
    RoadPath& path = lines.paths.emplace_back();
    for (const Vec2 p : line.line) path.nodes.push_back({.p = p});
  }
  const evaluate::RoadsAcross index(lines);
  std::map<std::pair<std::int64_t, int>, std::pair<std::size_t, std::size_t>>
      counts;  // places inside, places along a line
  for (const RoadPath& way : before.paths) {
    auto& [inside, along] = counts[{way.osm_id, way.part}];
    const Polyline line = centerline(way);
    const std::vector<double> s = arc_lengths_m(line);
    for (std::size_t i = 0; i + 1 < line.size(); ++i)
      for (double at = 0.5 * step_m; at < s[i + 1] - s[i]; at += step_m) {
        const Vec2 direction = normalized(line[i + 1] - line[i]), p = line[i] + at * direction;
        if (!region.contains(p)) continue;
        ++inside;
        along += index.find({.p = p, .direction = direction, .reach_m = reach_m}) ? 1 : 0;
      }
  }
  RoadNetwork known{.crs = roads.crs, .paths = {}};
  for (const RoadPath& path : roads.paths) {
    const auto found = counts.find({path.osm_id, path.part});
    if (found == counts.end() || 2 * found->second.second >= found->second.first) known.paths.push_back(path);
  }
  return known;
}
}  // namespace

RoadTruth road_truth(const RoadNetwork& roads, const Crs& crs) {
  RoadNetwork moved = roads;
  if (roads.crs != crs) {
    const CoordinateTransform there(roads.crs, crs);
    for (RoadPath& path : moved.paths)
      for (RoadNode& node : path.nodes) node.p = there.target_from_source(node.p);
  }
  RoadTruth truth;
  for (const RoadPath& path : moved.paths) {
    truth.surfaces.push_back({.polygons = evaluate::carriageway_polygons(path)});
    TruthLine& line = truth.lines.emplace_back(TruthLine{.line = centerline(path)});
    for (const RoadNode& node : path.nodes) line.width_m.push_back(node.width_m);
  }
  return truth;
}

namespace {
/// A place every step along a truth line.
struct TruthPlace {
  std::size_t segment = 0;
  double fraction = 0.0;  ///< of the segment
  Vec2 p, direction;
};

template <typename Visit>
void for_places(const Polyline& line, double step_m, const Visit& visit) {
  const std::vector<double> s = arc_lengths_m(line);
  std::size_t segment = 0;
  for (int k = 0; !s.empty() && (k + 0.5) * step_m < s.back(); ++k) {
    const double at = (k + 0.5) * step_m;
    while (s[segment + 1] <= at) ++segment;
    const double fraction = (at - s[segment]) / (s[segment + 1] - s[segment]);
    visit(TruthPlace{segment, fraction, line[segment] + fraction * (line[segment + 1] - line[segment]),
                     normalized(line[segment + 1] - line[segment])});
  }
}

/// Asks at every place of the truth lines for the road there, and sums up what it finds.
class LineScores {
 public:
  LineScores(const RoadNetwork& roads, const RoadTruth& truth, const EvaluateRoadsOptions& options)
      : roads_(roads), truth_(truth), options_(options), index_(roads), widths_(truth) {
    if (options.before) index_before_.emplace(*options.before);
  }

  void measure(RoadScores& scores) {
    for (std::size_t l = 0; l < truth_.lines.size(); ++l)
      for_places(truth_.lines[l].line, options_.step_m, [&](const TruthPlace& at) {
        if (options_.region.contains(at.p)) scores.places.push_back(measure_place(l, at));
      });
    scores.samples = scores.places.size();
    scores.offset_m = summarize(offsets_);
    scores.width_m = summarize(width_errors_);
    scores.edge_m = summarize(edge_errors_);
    scores.offset_sigma = offset_sigma_.coverage();
    scores.width_sigma = width_sigma_.coverage();
    scores.matched_share =
        scores.samples == 0 ? no_value : static_cast<double>(offsets_.size()) / static_cast<double>(scores.samples);
    if (options_.before) scores.moved_away = moves_.moved_away();
  }

 private:
  RoadPlace measure_place(std::size_t line, const TruthPlace& at) {
    const evaluate::RoadsAcross::Query query{.p = at.p, .direction = at.direction, .reach_m = other_road_m};
    RoadPlace place{line, at.p, no_value, no_value, no_value, no_value, no_value};
    const auto road = index_.find(query);
    if (road) place.offset_m = road->offset_m;
    if (const auto was = index_before_ ? index_before_->find(query) : std::nullopt) {
      place.offset_before_m = was->offset_m;
      moves_.add(was->offset_m, place.offset_m);
    }
    if (!road) return place;
    const RoadNode& nearest = roads_.paths[road->path].nodes[road->segment + (road->fraction < 0.5 ? 0 : 1)];
    place.sigma_offset_m = nearest.sigma_offset_m, place.sigma_width_m = nearest.sigma_width_m;
    offsets_.push_back(road->offset_m);
    offset_sigma_.add(road->offset_m, nearest.sigma_offset_m);
    const auto width = widths_.at(truth_.lines[line], at.segment, at.fraction, at.p, at.direction);
    if (!width) return place;
    place.width_error_m = evaluate::interpolate(roads_, *road, &RoadNode::width_m) - *width;
    width_errors_.push_back(place.width_error_m);
    for (const double side : {0.5, -0.5}) edge_errors_.push_back(road->offset_m + side * place.width_error_m);
    width_sigma_.add(place.width_error_m, nearest.sigma_width_m);
    return place;
  }

  const RoadNetwork& roads_;
  const RoadTruth& truth_;
  const EvaluateRoadsOptions& options_;
  evaluate::RoadsAcross index_;
  std::optional<evaluate::RoadsAcross> index_before_;
  TruthWidths widths_;
  MoveCount moves_;
  std::vector<double> offsets_, width_errors_, edge_errors_;
  SigmaCount offset_sigma_, width_sigma_;
};

double surface_iou(const RoadNetwork& roads, const RoadTruth& truth, const ScoreRegion& region) {
  if (truth.surfaces.empty()) return no_value;
  return evaluate::overlap_areas(surface_polygons(roads), surface_polygons(truth), region).iou();
}
}  // namespace

RoadScores evaluate_roads(const RoadNetwork& roads, const RoadTruth& truth, const EvaluateRoadsOptions& options) {
  RoadScores scores;
  LineScores(roads, truth, options).measure(scores);
  scores.surface_iou = surface_iou(roads, truth, options.region);
  scores.surface_iou_of_known_ways =
      options.before ? surface_iou(known_ways(roads, *options.before, truth, options.region), truth, options.region)
                     : no_value;
  for (const RoadPath& path : roads.paths) scores.length_m += length_inside_m(centerline(path), options.region);
  for (const TruthLine& line : truth.lines) scores.truth_length_m += length_inside_m(line.line, options.region);
  scores.width_variance_m2 = evaluate::width_variance_m2(roads, options.region);
  scores.curvature_jump = evaluate::largest_curvature_jump(roads, options.region, options.step_m);
  return scores;
}

}  // namespace orthodrive
