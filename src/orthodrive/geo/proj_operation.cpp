// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/geo/proj_operation.hpp"

#include <proj.h>

namespace orthodrive {

ProjOperation::ProjOperation() : context(proj_context_create()) { proj_log_level(context, PJ_LOG_NONE); }
ProjOperation::~ProjOperation() {
  proj_destroy(operation);
  proj_context_destroy(context);
}

}  // namespace orthodrive
