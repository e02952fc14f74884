// SPDX-License-Identifier: Apache-2.0
#pragma once
// One page about the labels of a place: scores, classes, confusion, calibration, and pictures of what is wrong.

#include <functional>
#include <optional>
#include <string>

#include "orthodrive/evaluate/labels/evaluate_labels.hpp"
#include "orthodrive/report/html.hpp"

namespace orthodrive {

/// What the page shows; owns nothing but names.
struct LabelReportView {
  std::string scored, truth;  ///< names of the two maps
  /// The photo on the ground of a picture, at its scale; nothing where it does not show any of it. An empty function:
  /// there is no photo, errors stand on plain grey.
  std::function<std::optional<Photo>(const GridFrame& frame)> photo_on;
  std::string photo_name;
  const LabelComparisonView& view;
  const LabelScores& scores;
  const std::vector<PieceScores>& pieces;
  const TruthPieces& piece_map;
  const MergeTable& merge;
  PictureEncoders encoders;
};

/// The page, everything in one text. The photo is asked for only around what is shown, so memory does not grow with it.
/// Throws InputError when there is a photo that shows nothing of what is scored.
[[nodiscard]] std::string label_report_html(const LabelReportView& report);

}  // namespace orthodrive
