// SPDX-License-Identifier: Apache-2.0
#pragma once
// What every unit of the pipeline hands back.

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "orthodrive/core/finding.hpp"

namespace orthodrive {

struct StageOutcome {
  nlohmann::json numbers = nlohmann::json::object();  ///< results that run.json and the report show
  Findings findings;
  std::vector<std::string> summary;  ///< lines for a person who ran this stage alone
};

inline void append(Findings& all, const Findings& more) { all.insert(all.end(), more.begin(), more.end()); }

}  // namespace orthodrive
