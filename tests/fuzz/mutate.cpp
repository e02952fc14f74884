// SPDX-License-Identifier: Apache-2.0
#include "fuzz/mutate.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>
#include <string_view>
#include <vector>

#include "orthodrive/core/random.hpp"

namespace orthodrive::fuzz {
namespace {

/// Numbers that readers trip over: of other types, too large for an int, for memory, for a double.
constexpr std::array<std::string_view, 16> odd_numbers{
    "0",      "-1",  "1e9",  "-1e9", "1e308", "-1e308", "1e999",      "nan",
    "1e-308", "inf", "0x10", "",     "1,5",   "65536",  "2147483648", "18446744073709551616"};

class Mutator {
 public:
  Mutator(std::string bytes, std::uint64_t seed) : bytes_(std::move(bytes)), random_(seed) {}

  void damage() {
    if (bytes_.empty()) return;
    switch (random_.below(12)) {
      case 0:
        bytes_[place()] ^= static_cast<char>(1U << random_.below(8));
        break;
      case 1:
        bytes_[place()] = static_cast<char>(random_.below(256));
        break;
      case 2:
        bytes_.insert(place(), 1, static_cast<char>(random_.below(256)));
        break;
      case 3:
        bytes_.erase(place(), 1 + random_.below(20));
        break;
      case 4:
        bytes_.resize(place());
        break;
      case 5: {
        const std::string piece = bytes_.substr(place(), 1 + random_.below(100));
        bytes_.insert(place(), piece);
        break;
      }
      case 6:
        replace_number();
        break;
      case 7:
        replace_number();
        break;
      case 8:
        misspell();
        break;
      case 9:
        misspell();
        break;
      case 10:
        move_line();
        break;
      default:
        write_extreme_word();
        break;
    }
  }
  [[nodiscard]] const std::string& bytes() const { return bytes_; }

 private:
  std::size_t place() { return static_cast<std::size_t>(random_.below(bytes_.size())); }

  template <typename Belongs>
  std::pair<std::size_t, std::size_t> run_after(std::size_t from, const Belongs& belongs) const {
    while (from < bytes_.size() && !belongs(bytes_[from])) ++from;
    std::size_t end = from;
    while (end < bytes_.size() && belongs(bytes_[end])) ++end;
    return {from, end};
  }

  void replace_number() {
    const auto [begin, end] = run_after(place(), [](char c) {
      return std::isdigit(static_cast<unsigned char>(c)) != 0 || c == '.' || c == '-' || c == '+';
    });
    bytes_.replace(begin, end - begin, odd_numbers[random_.below(odd_numbers.size())]);
  }

  /// Two neighbouring letters of a word change places: <planVeiw>.
  void misspell() {
    const auto [begin, end] =
        run_after(place(), [](char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0; });
    if (end - begin < 2) return;
    const std::size_t at = begin + random_.below(end - begin - 1);
    std::swap(bytes_[at], bytes_[at + 1]);
  }

  /// A line is taken out, or put in somewhere else, or both.
  void move_line() {
    const auto line_at = [this](std::size_t p) {
      const std::size_t before = p == 0 ? std::string::npos : bytes_.rfind('\n', p - 1);
      const std::size_t begin = before == std::string::npos ? 0 : before + 1;
      return std::pair{begin, std::min(bytes_.find('\n', p), bytes_.size() - 1) + 1 - begin};
    };
    const auto [begin, count] = line_at(place());
    const std::string line = bytes_.substr(begin, count);
    const std::uint64_t how = random_.below(3);
    if (how != 0) bytes_.erase(begin, count);
    if (how != 1 && !bytes_.empty()) bytes_.insert(line_at(place()).first, line);
  }

  /// 2, 4 or 8 bytes of ones or zeros, as lengths and counts of binary formats.
  void write_extreme_word() {
    const std::size_t at = place(),
                      count = std::min<std::size_t>(std::size_t{2} << random_.below(3), bytes_.size() - at);
    std::fill_n(bytes_.begin() + static_cast<std::ptrdiff_t>(at), count, random_.below(2) == 0 ? '\xff' : '\0');
    if (random_.below(2) == 0) bytes_[at + count - 1] = '\x7f';
  }

  std::string bytes_;
  Random random_;
};

}  // namespace

std::string mutate(const std::string& sample, std::uint64_t seed) {
  Mutator mutator(sample, seed);
  const std::uint64_t count = 1 + splitmix64(seed ^ 0x5eed) % 4;
  for (std::uint64_t i = 0; i < count; ++i) mutator.damage();
  return mutator.bytes();
}

}  // namespace orthodrive::fuzz
