// SPDX-License-Identifier: Apache-2.0
#pragma once
// The log of a training: its rows as CSV, back again, and as a page with curves.

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "orthodrive/train/train_network.hpp"

namespace orthodrive {

/// The first line of log.csv and a row of it, both with their line end. Loss stands in rows without a validation only.
[[nodiscard]] std::string format_log_header();
[[nodiscard]] std::string format_log_row(const TrainReport& row);

/// Rows of log.csv. Columns go by their name in the first line; unknown ones are ignored, missing ones stay empty.
/// A last line without line end is what a killed run was writing: left out. Where the step goes back, the run was
/// resumed from a checkpoint, and the earlier rows from that step on are left out: they were trained anew.
/// Throws InputError with the line for what is no number.
[[nodiscard]] std::vector<TrainReport> parse_training_log(std::string_view csv, const std::string& source);

struct TrainingReportOptions {
  std::string title = "Training";
};
/// One HTML page (well-formed XML but for its first line), nothing beside it: loss on a log scale, raw and smoothed
/// (geometric mean over about a twentieth of the rows), learning rate, and mean IoU, road IoU and pixel accuracy of
/// each validation with the step of its best mean IoU ringed; a table of best and last. `rows` in the order of their
/// steps.
[[nodiscard]] std::string format_training_report(std::span<const TrainReport> rows,
                                                 const TrainingReportOptions& options = {});

}  // namespace orthodrive
