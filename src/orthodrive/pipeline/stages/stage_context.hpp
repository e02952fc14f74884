// SPDX-License-Identifier: Apache-2.0
#pragma once
// What every unit of the pipeline gets beside its files and options.

#include "orthodrive/pipeline/sources/sources.hpp"
#include "orthodrive/pipeline/stages/cell_exchange.hpp"

namespace orthodrive {

struct StageContext {
  int threads = 0;                   ///< 0 = all cores; the result does not depend on it
  Monitor* monitor = nullptr;        ///< may be null
  CellExchange* exchange = nullptr;  ///< with processes that make the same stage (docs/cells.md); null: there are none
  Sources sources;                   ///< what earlier stages of the same run have read already

  void info(std::string_view message) const {
    if (monitor) monitor->info(message);
  }
};

}  // namespace orthodrive
