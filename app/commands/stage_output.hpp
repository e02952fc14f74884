// SPDX-License-Identifier: Apache-2.0
#pragma once
// How a command calls a unit of the pipeline and tells what came of it.

#include <fmt/format.h>

#include "commands.hpp"
#include "orthodrive/pipeline/stages/stage_context.hpp"
#include "orthodrive/pipeline/stages/stage_outcome.hpp"

namespace orthodrive::app {

inline StageContext stage_context(const Context& context) {
  return {.threads = context.threads, .monitor = context.monitor};
}

/// First what was odd, a line each, then the summary.
inline void print_outcome(const StageOutcome& outcome, const StageContext& context) {
  for (const Finding& finding : outcome.findings) context.info(fmt::format("{}: {}", finding.code, finding.message));
  for (const std::string& line : outcome.summary) context.info(line);
}

}  // namespace orthodrive::app
