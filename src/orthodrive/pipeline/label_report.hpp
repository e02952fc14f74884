#pragma once
// One page about the labels of a place: scores, classes, confusion, calibration, and pictures of what is wrong.

#include <filesystem>

#include "orthodrive/evaluate/evaluate_labels.hpp"

namespace orthodrive {

/// What the page shows; owns nothing but the names of files.
struct LabelReportView {
  std::filesystem::path scored, truth, photo;  ///< no photo: errors stand on plain grey
  const LabelComparisonView& view;
  const LabelScores& scores;
  const std::vector<PieceScores>& pieces;
  const TruthPieces& piece_map;
  const MergeTable& merge;
};

/// Writes the page, everything in one file. A path that does not end in .html is a folder: its labels.html. The photo
/// is read only around what is shown, at the scale of the pictures, so memory does not grow with it.
void write_label_report(const std::filesystem::path& page, const LabelReportView& report);

}  // namespace orthodrive
