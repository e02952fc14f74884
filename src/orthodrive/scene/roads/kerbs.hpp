// SPDX-License-Identifier: Apache-2.0
#pragma once
// Lanes that lie higher than the road: sidewalks with their kerbs, kerbs of race tracks.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "orthodrive/model/scene.hpp"
#include "roadquery/map/road_map.hpp"

namespace orthodrive::scene {

/// What a piece of a raised lane is made of.
enum class KerbLook : std::uint8_t { slabs, stone, red, white };

/// A piece of a raised lane. Edge i runs from corner i to the next.
struct KerbPiece {
  std::array<Vec2, 4> corners;      ///< plan, counter-clockwise; 0 and 3 at the lower s
  std::array<double, 4> lift_m{};   ///< over the road
  std::array<bool, 4> is_border{};  ///< where the lane steps down to what lies beside it
  KerbLook look = KerbLook::slabs;  ///< the walk, the stone along the carriageway, a block of a race track's kerb
};

/// Width of the stone along the carriageway, m (DIN EN 1340: 0.12 to 0.18).
inline constexpr double kerb_stone_m = 0.15;
/// Kerbs of race tracks (borders with heights) are red and white in blocks so long, m.
inline constexpr double race_block_m = 1.5;

/// Pieces of all lanes of a road that have heights, where they have any. At most 5 m long, chords within 1 cm.
[[nodiscard]] std::vector<KerbPiece> kerb_pieces(const roadquery::Road& road);

/// The pieces (in the frame of the mesh) laid over the road's triangles from first_index on, with vertical faces at
/// their borders: they follow the mesh as paint does, and end with it at tile borders.
void add_kerbs(const TriMesh& road, std::size_t first_index, std::span<const KerbPiece> pieces, TriMesh& kerbs);

}  // namespace orthodrive::scene
