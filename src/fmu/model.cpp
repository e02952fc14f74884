// SPDX-License-Identifier: Apache-2.0
#include "fmu/model.hpp"

#include <cstdint>
#include <cstdio>

namespace fmu {
namespace {

/// FNV-1a, 64 bit (Fowler, Noll, Vo), from another offset for the second half.
std::uint64_t hash_of(const ModelKind& kind, std::uint64_t hash) {
  const auto add = [&](const std::string& text) {
    for (const char c : text + ";") hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211ull;
  };
  add(kind.identifier);
  for (const Variable& v : kind.variables)
    add(v.name + "," + v.unit + "," + std::to_string(static_cast<int>(v.type)) +
        std::to_string(static_cast<int>(v.causality)));
  return hash;
}

}  // namespace

const std::vector<Unit>& units() {
  static const std::vector<Unit> all = {{.name = "m", .m = 1},
                                        {.name = "s", .s = 1},
                                        {.name = "rad", .rad = 1},
                                        {.name = "m/s", .m = 1, .s = -1},
                                        {.name = "m/s2", .m = 1, .s = -2},
                                        {.name = "rad/s", .s = -1, .rad = 1},
                                        {.name = "N", .kg = 1, .m = 1, .s = -2},
                                        {.name = "N.m", .kg = 1, .m = 2, .s = -2},
                                        {.name = "kg", .kg = 1},
                                        {.name = "rpm", .s = -1, .rad = 1, .factor = 0.10471975511965977}};
  return all;
}

std::string instantiation_token(const ModelKind& kind) {
  char text[48];
  std::snprintf(text, sizeof text, "{%016llx%016llx}",
                static_cast<unsigned long long>(hash_of(kind, 14695981039346656037ull)),
                static_cast<unsigned long long>(hash_of(kind, 1469598103934665603ull)));
  return text;
}

Values start_values(const ModelKind& kind) {
  Values values{std::vector<double>(kind.variables.size()), std::vector<std::string>(kind.variables.size())};
  for (std::size_t i = 0; i < kind.variables.size(); ++i) values.number[i] = kind.variables[i].start;
  return values;
}

}  // namespace fmu
