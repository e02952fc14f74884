// SPDX-License-Identifier: Apache-2.0
#pragma once
// What a test measures, as a property of its result: `tools/measure drive-logs` reads these from googletest's JSON
// report.

#include <gtest/gtest.h>

#include <cstdarg>
#include <cstdio>
#include <string>

namespace orthodrive::test {

/// Keeps one line, as printf would write it, as measured_1, measured_2, ... of the running test.
__attribute__((format(printf, 1, 2))) inline void record_measured(const char* format, ...) {
  char line[400];
  std::va_list values;
  va_start(values, format);
  std::vsnprintf(line, sizeof line, format, values);
  va_end(values);
  const auto* result = testing::UnitTest::GetInstance()->current_test_info()->result();
  int count = 1;
  for (int i = 0; i < result->test_property_count(); ++i)
    if (std::string(result->GetTestProperty(i).key()).starts_with("measured_")) ++count;
  testing::Test::RecordProperty("measured_" + std::to_string(count), line);
}

}  // namespace orthodrive::test
