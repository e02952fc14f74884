// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace roadquery::test {

/// How often this thread has called operator new.
[[nodiscard]] long allocations();

}  // namespace roadquery::test
