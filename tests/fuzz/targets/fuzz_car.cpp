// SPDX-License-Identifier: Apache-2.0
// Parameter files of cars: read, checked, made into a car that takes a few steps.

#include <stdexcept>
#include <string_view>

#include "memory_file.hpp"
#include "vehicle/read_car.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const vehicle::CarParameters car =
        vehicle::parse_car({reinterpret_cast<const char*>(data), size}, "a.car");  // NOLINT: bytes are characters
    vehicle::check(car);
  } catch (const std::runtime_error& error) {
    fuzz::expect_one_line(error.what());
  } catch (const std::invalid_argument& error) {
    fuzz::expect_one_line(error.what());
  }
  return 0;
}
