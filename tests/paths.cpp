// SPDX-License-Identifier: Apache-2.0
#include "paths.hpp"

namespace orthodrive::paths {

const char* const source_dir = ORTHODRIVE_SOURCE_DIR;
const char* const tool = ORTHODRIVE_TOOL;
const char* const trainer = ORTHODRIVE_TRAINER;
const char* const test_sites = ORTHODRIVE_SITES;

}  // namespace orthodrive::paths
