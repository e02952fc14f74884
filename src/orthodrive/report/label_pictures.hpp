// SPDX-License-Identifier: Apache-2.0
#pragma once
// Pictures of right and wrong labels, after figure 2.13 of the thesis: the photo in grey, colour only where it is
// wrong.

#include <string>
#include <vector>

#include "orthodrive/evaluate/labels/evaluate_labels.hpp"
#include "orthodrive/report/canvas.hpp"

namespace orthodrive {

/// A box of the truth's grid, in its CRS.
struct LabelPlace {
  std::string name;
  Box2 box;
  std::size_t pixels = 0, wrong = 0;  ///< compared pixels
  [[nodiscard]] double accuracy() const { return 1.0 - static_cast<double>(wrong) / static_cast<double>(pixels); }
};
/// Around all compared pixels; no pixels: none.
[[nodiscard]] LabelPlace whole_place(const LabelComparisonView& view);
/// Of the tiles of that size on the truth's grid those with the most wrong pixels, worst first; none without errors.
[[nodiscard]] std::vector<LabelPlace> worst_places(const LabelComparisonView& view, int tile_px, std::size_t count);
/// The boxes around the pieces that have compared pixels, least accurate first.
[[nodiscard]] std::vector<LabelPlace> piece_places(const LabelComparisonView& view, const TruthPieces& pieces);

/// Colours that stand out from grey: the class's own, or a vivid one of its own for a class that is grey itself.
[[nodiscard]] std::vector<Color> error_colors(const std::vector<ClassInfo>& classes);

/// One pixel of the picture a pixel of the truth, or more when the box has more than max_px a side.
[[nodiscard]] GridFrame picture_frame(const LabelComparisonView& view, const Box2& box, int max_px);

/// The photo (null: none, even grey) in grey; pale where nothing is compared; where the label is wrong in the error
/// colour of the predicted class. A picture pixel over many label pixels is the stronger coloured the more are wrong:
/// with the square root of their share, so that thin borders still show.
[[nodiscard]] Canvas picture_of_errors(const LabelComparisonView& view, const GridFrame& frame, const Photo* photo);
/// Class colours of the truth or the prediction where they are compared, light grey elsewhere.
enum class LabelSide { truth, prediction };
[[nodiscard]] Canvas picture_of_classes(const LabelComparisonView& view, const GridFrame& frame, LabelSide side);

}  // namespace orthodrive
