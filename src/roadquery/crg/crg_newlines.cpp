// SPDX-License-Identifier: Apache-2.0
#include "roadquery/crg/crg_newlines.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

namespace roadquery {
namespace {

constexpr std::size_t max_lost = 60;
constexpr std::size_t most_choices = 1U << 28;  // bytes of memory
constexpr double infinite = std::numeric_limits<double>::infinity();
const double lost_cost = std::log(65536.0);  // one pair of bytes out of all

unsigned upper_bits(unsigned char first, unsigned char second) { return static_cast<unsigned>(first) << 8 | second; }

/// -log of the share of every pattern of the upper 16 bits, over all places of the block. Three (seven) of four (eight)
/// places are no start of a value, but spread over many patterns, where signs and exponents of heights are few.
std::vector<double> pattern_costs(const std::string& data) {
  std::vector<double> count(65536, 0.5);
  for (std::size_t i = 0; i + 1 < data.size(); ++i)
    ++count[upper_bits(static_cast<unsigned char>(data[i]), static_cast<unsigned char>(data[i + 1]))];
  const double total = static_cast<double>(data.size()) + 0.5 * 65536.0;
  for (double& c : count) c = -std::log(c / total);
  return count;
}

}  // namespace

std::size_t mend_newlines(std::string& data, std::size_t width, std::size_t values) {
  if (data.find("\r\n") != std::string::npos || data.size() < width) return 0;
  const std::size_t needed = values * width;
  // A newline after the last record makes one byte less look missing.
  const std::size_t missing = needed + 80 > data.size() ? needed + 80 - data.size() : 0;
  if (missing == 0 || missing > max_lost + 80) return 0;
  const std::size_t states = std::min(missing, max_lost) + 1;
  if (values > most_choices / states) return 0;
  const std::vector<double> pattern = pattern_costs(data);

  // choice: 0 = the value as it stands, 1 + i = a CR goes before its byte i.
  std::vector<std::uint8_t> choice(values * states, 0);
  std::vector<double> cost(states, infinite), next(states);
  cost[0] = 0.0;
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(data[i]); };
  for (std::size_t n = 0; n < values; ++n) {
    next.assign(states, infinite);
    for (std::size_t lost = 0; lost < states && lost <= n * width; ++lost) {
      if (cost[lost] == infinite) continue;
      const std::size_t at = n * width - lost;
      if (at + width <= data.size()) {
        const double c = cost[lost] + pattern[upper_bits(byte(at), byte(at + 1))];
        if (c < next[lost]) next[lost] = c, choice[n * states + lost] = 0;
      }
      for (std::size_t i = 0; i < width && lost + 1 < states && at + i < data.size(); ++i) {
        if (data[at + i] != '\n') continue;
        const unsigned char first = i == 0 ? '\r' : byte(at), second = i == 0 ? '\n' : i == 1 ? '\r' : byte(at + 1);
        const double c = cost[lost] + lost_cost + pattern[upper_bits(first, second)];
        if (c < next[lost + 1]) next[lost + 1] = c, choice[n * states + lost + 1] = static_cast<std::uint8_t>(1 + i);
      }
    }
    cost.swap(next);
  }

  std::size_t lost = 0;
  for (std::size_t k = 1; k < states; ++k)
    if (cost[k] < cost[lost]) lost = k;
  const std::size_t put_back = lost;
  std::string mended;
  mended.reserve(needed);
  std::vector<std::size_t> places;  // in the data, from the back
  for (std::size_t n = values; n-- > 0;) {
    const std::uint8_t c = choice[n * states + lost];
    if (c == 0) continue;
    --lost;
    places.push_back(n * width - lost + c - 1);
  }
  std::size_t from = 0;
  for (auto place = places.rbegin(); place != places.rend(); ++place) {
    mended.append(data, from, *place - from).push_back('\r');
    from = *place;
  }
  mended.append(data, from);
  data.swap(mended);
  return put_back;
}

}  // namespace roadquery
