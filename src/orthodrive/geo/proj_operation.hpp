// SPDX-License-Identifier: Apache-2.0
#pragma once
// Owner of one operation of the PROJ library; for the sources of this room.

struct pj_ctx;
struct PJconsts;

namespace orthodrive {

/// Says nothing of its own.
struct ProjOperation {
  pj_ctx* context;                ///< PJ_CONTEXT
  PJconsts* operation = nullptr;  ///< PJ; null until made

  ProjOperation();
  ProjOperation(const ProjOperation&) = delete;
  ProjOperation& operator=(const ProjOperation&) = delete;
  ~ProjOperation();
};

}  // namespace orthodrive
