// SPDX-License-Identifier: Apache-2.0
#pragma once
// The one rule that says which road runs on into which where several meet. All that is called one road follows from it:
// the chains of whole ways (path_links.hpp) that refine, elevate and the drive logs work on, and the chains of pieces
// of way (network/topology/topology.hpp) from which the network stage cuts its roads.

#include <numbers>
#include <optional>
#include <span>
#include <vector>

#include "orthodrive/geo/polyline.hpp"
#include "orthodrive/model/roads/road_network.hpp"

namespace orthodrive {

struct ContinuationRule {
  /// The direction of an end is that from its node to the point so far along its line: the last node may jitter.
  double look_ahead_m = 10.0;
  double look_ahead_share = 1.0;  ///< but at most this share of the line's length
  /// Two ends run on into each other where the road bends by less than this.
  double max_bend_rad = 0.0;
  /// The same for two ends at a node where nothing else arrives: a road may bend sharply between two junctions.
  double max_bend_alone_rad = 0.0;
  /// The same for two one-way roads alone that both leave the node, or both end there: nobody drives from one into the
  /// other.
  double max_bend_apart_rad = 0.0;
  /// The same for two ends of one roundabout, which go before all others: small rings are drawn with few nodes.
  double max_bend_on_ring_rad = 0.0;
  /// Of several candidates the pair that bends least is taken first. A change of class or name counts as such a bend.
  double other_class_rad = 0.0, other_name_rad = 0.0;
  bool same_way_first = false;  ///< pairs of one way go before pairs of two ways, whatever they bend
};

constexpr double continuation_degree = std::numbers::pi / 180.0;

/// Whole ways. OSM cuts ways at junctions and where a tag changes: the same road goes on where it keeps its class and
/// name, and a bend of 50 degrees is still one road to smooth or to give one profile. Beyond 100 degrees two ways that
/// share an end are two roads that meet in a point. A ring is one road, closed in itself.
constexpr ContinuationRule way_continuation{.look_ahead_m = 10.0,
                                            .look_ahead_share = 1.0,
                                            .max_bend_rad = 50.0 * continuation_degree,
                                            .max_bend_alone_rad = 100.0 * continuation_degree,
                                            .max_bend_apart_rad = 100.0 * continuation_degree,
                                            .max_bend_on_ring_rad = 100.0 * continuation_degree,
                                            .other_class_rad = 30.0 * continuation_degree,
                                            .other_name_rad = 15.0 * continuation_degree,
                                            .same_way_first = false};

/// Pieces of way between vertices, for OpenDRIVE's reference lines. A way runs on through its own junctions before any
/// other. The bound is tighter than that of whole ways: a line that bends more than 40 degrees inside a junction
/// becomes a reference line with a corner, while a connecting road takes the turn at a radius that can be driven. Two
/// ends alone run on unless the road turns back beside itself: then their node is a junction whose connecting road
/// turns (network/topology/road_pieces.hpp). Pieces may be short, so only their nearer half counts for the direction.
constexpr ContinuationRule piece_continuation{.look_ahead_m = 8.0,
                                              .look_ahead_share = 0.5,
                                              .max_bend_rad = 40.0 * continuation_degree,
                                              .max_bend_alone_rad = 150.0 * continuation_degree,
                                              .max_bend_apart_rad = 40.0 * continuation_degree,
                                              .max_bend_on_ring_rad = 90.0 * continuation_degree,
                                              .other_class_rad = 0.0,
                                              .other_name_rad = 0.0,
                                              .same_way_first = true};

/// One of the ends that meet in a place.
struct MeetingEnd {
  Vec2 direction;                  ///< unit vector from the place into the road
  const RoadPath* path = nullptr;  ///< whose end or piece it is
  int ring = -1;                   ///< roundabout that it is part of, -1 for none
  bool at_last = false;            ///< the road's last end, else its first: of a one-way road one arrives at the place
};

/// How much a road bends that comes out of one end and goes on into the other, 0 (straight on) .. pi.
[[nodiscard]] double bend_rad(const MeetingEnd& from, const MeetingEnd& to);

/// Direction of an end: `line` begins at it.
[[nodiscard]] Vec2 direction_into(std::span<const Vec2> line, const ContinuationRule& rule);

/// For every end of one place the index of the end that its road runs on into. `alone`: nothing else arrives here, not
/// even a road that passes. Ties go to the pair with the lower indices.
[[nodiscard]] std::vector<std::optional<std::size_t>> pair_ends(std::span<const MeetingEnd> ends, bool alone,
                                                                const ContinuationRule& rule);

}  // namespace orthodrive
