#pragma once
// Owner of one operation of the PROJ library; for the sources of this room.

#include <proj.h>

namespace orthodrive {

/// Says nothing of its own; null until made.
struct ProjOperation {
  PJ_CONTEXT* context = proj_context_create();
  PJ* operation = nullptr;

  ProjOperation() { proj_log_level(context, PJ_LOG_NONE); }
  ProjOperation(const ProjOperation&) = delete;
  ProjOperation& operator=(const ProjOperation&) = delete;
  ~ProjOperation() {
    proj_destroy(operation);
    proj_context_destroy(context);
  }
};

}  // namespace orthodrive
