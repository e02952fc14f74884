// SPDX-License-Identifier: Apache-2.0
#pragma once
// Seeded damage to a small valid file: what transfers, editors and other people's writers do to files, and worse.

#include <cstdint>
#include <string>

namespace orthodrive::fuzz {

/// The sample with one to four pieces of damage; the same seed gives the same bytes.
[[nodiscard]] std::string mutate(const std::string& sample, std::uint64_t seed);

}  // namespace orthodrive::fuzz
