// SPDX-License-Identifier: Apache-2.0
#include "roadquery/opendrive/junction_surface_text.hpp"

#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <stdexcept>

#include "roadquery/text/number_text.hpp"

namespace roadquery {
namespace {

constexpr double mm_per_m = 1e3, height_steps_per_m = 1e4;
constexpr double largest_m = 1e8;               // of a coordinate or a height
constexpr std::int64_t most_nodes = 4'000'000;  // 2 km by 2 km at 1 m
constexpr std::size_t most_points = 1'000'000;
constexpr std::int64_t most_zeros = 96, most_nodes_a_character = 32;  // a run of zeros is up to three characters

constexpr std::string_view alphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
constexpr unsigned digit_bits = 5, more_bit = 1U << digit_bits, most_bits = 60;

std::int64_t steps(double metres, double per_m) { return std::llround(metres * per_m); }

void append_decimal(std::string& text, std::int64_t value) {
  std::array<char, 24> digits;
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
  text.append(digits.data(), end);
  text += ' ';
}
void append_metres(std::string& text, double value) {
  std::array<char, 40> digits;
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value, std::chars_format::fixed, 3).ptr;
  text.append(digits.data(), end);
  text += ' ';
}
void append_vlq(std::string& text, std::int64_t value) {
  std::uint64_t bits =
      value < 0 ? (static_cast<std::uint64_t>(-value) << 1U) | 1U : static_cast<std::uint64_t>(value) << 1U;
  do {
    const auto digit = static_cast<unsigned>(bits % more_bit);
    bits >>= digit_bits;
    text += alphabet[digit | (bits > 0 ? more_bit : 0U)];
  } while (bits > 0);
}

/// Value of each character as a digit, 255 for those that are none.
constexpr std::array<std::uint8_t, 256> digit_values = [] {
  std::array<std::uint8_t, 256> values{};
  values.fill(255);
  for (std::size_t i = 0; i < alphabet.size(); ++i)
    values[static_cast<unsigned char>(alphabet[i])] = static_cast<std::uint8_t>(i);
  return values;
}();

/// Decimal numbers between white space, then digits of base 64.
class Numbers {
 public:
  Numbers(const char* code, std::string_view text) : code_(code), text_(text) {}

  [[nodiscard]] bool more() {
    while (!text_.empty() &&
           (text_.front() == ' ' || text_.front() == '\n' || text_.front() == '\t' || text_.front() == '\r'))
      text_.remove_prefix(1);
    return !text_.empty();
  }
  template <typename T>
  [[nodiscard]] T next(double largest) {
    T value{};
    if (!more()) fail("ends too early");
    const auto [end, error] = number_from_text(text_, value);
    if (error != std::errc{} || !(std::abs(static_cast<double>(value)) <= largest)) fail_here();
    text_.remove_prefix(static_cast<std::size_t>(end - text_.data()));
    return value;
  }
  [[nodiscard]] std::int64_t next_vlq(double largest) {
    if (!more()) fail("ends too early");
    std::uint64_t bits = 0;
    for (unsigned shift = 0;; shift += digit_bits) {
      const unsigned digit = text_.empty() ? 255U : digit_values[static_cast<unsigned char>(text_.front())];
      if (digit == 255U || shift >= most_bits) fail_here();
      text_.remove_prefix(1);
      bits |= std::uint64_t{digit % more_bit} << shift;
      if (digit < more_bit) break;
    }
    const auto size = static_cast<std::int64_t>(bits >> 1U);
    if (!(static_cast<double>(size) <= largest)) fail_here();
    return bits % 2 == 1 ? -size : size;
  }
  [[noreturn]] void fail(const std::string& what) const {
    throw std::runtime_error("userData " + std::string(code_) + " " + what);
  }

 private:
  [[noreturn]] void fail_here() const {
    fail("has \"" + std::string(text_.substr(0, 20)) + "\" where a number should stand");
  }

  const char* code_;
  std::string_view text_;
};

/// Of node i from those before it.
std::int64_t prediction(const std::vector<std::int64_t>& z, std::size_t i, std::size_t columns) {
  const bool west = i % columns > 0, south = i >= columns;
  if (west && south) return z[i - 1] + z[i - columns] - z[i - columns - 1];
  return west ? z[i - 1] : south ? z[i - columns] : 0;
}

}  // namespace

std::string boundary_text(const JunctionSurface& surface, double offset_x, double offset_y) {
  std::string text;
  std::int64_t x = 0, y = 0;
  for (std::size_t i = 0; i < surface.boundary.size(); ++i) {
    const double px = surface.boundary[i][0] - offset_x, py = surface.boundary[i][1] - offset_y;
    const std::int64_t at_x = steps(px, mm_per_m), at_y = steps(py, mm_per_m);
    if (i == 0) {
      append_metres(text, px), append_metres(text, py);
    } else {
      append_vlq(text, at_x - x), append_vlq(text, at_y - y);
    }
    x = at_x, y = at_y;
  }
  return text;
}

std::string heights_text(const JunctionSurface& surface, double offset_x, double offset_y) {
  std::string text;
  append_metres(text, surface.x - offset_x), append_metres(text, surface.y - offset_y);
  append_metres(text, surface.spacing_m);
  append_decimal(text, surface.columns), append_decimal(text, surface.rows);
  std::vector<std::int64_t> z;
  z.reserve(surface.z.size());
  for (const double height : surface.z) z.push_back(steps(height, height_steps_per_m));
  std::int64_t zeros = 0;
  const auto write_zeros = [&] {
    if (zeros > 0) append_vlq(text, 0), append_vlq(text, zeros - 1);
    zeros = 0;
  };
  for (std::size_t i = 0; i < z.size(); ++i) {
    const std::int64_t off = z[i] - prediction(z, i, static_cast<std::size_t>(surface.columns));
    if (off != 0 || zeros == most_zeros) write_zeros();
    if (off == 0)
      ++zeros;
    else
      append_vlq(text, off);
  }
  write_zeros();
  return text;
}

void read_boundary(std::string_view text, JunctionSurface& surface) {
  Numbers numbers(boundary_code, text);
  surface.boundary.clear();
  const std::int64_t x0 = steps(numbers.next<double>(largest_m), mm_per_m);
  const std::int64_t y0 = steps(numbers.next<double>(largest_m), mm_per_m);
  std::int64_t x = x0, y = y0;
  const double largest = largest_m * mm_per_m;
  const auto add = [&] {
    if (std::abs(static_cast<double>(x)) > largest || std::abs(static_cast<double>(y)) > largest)
      numbers.fail("leads further than " + std::to_string(static_cast<long>(largest_m / 1e3)) + " km away");
    if (surface.boundary.size() >= most_points) numbers.fail("has over a million points");
    surface.boundary.push_back({static_cast<double>(x) / mm_per_m, static_cast<double>(y) / mm_per_m});
  };
  add();
  while (numbers.more()) {
    x += numbers.next_vlq(largest);
    y += numbers.next_vlq(largest);
    add();
  }
  if (surface.boundary.size() < 3) numbers.fail("has fewer than three points");
}

void read_heights(std::string_view text, JunctionSurface& surface) {
  Numbers numbers(heights_code, text);
  surface.x = numbers.next<double>(largest_m), surface.y = numbers.next<double>(largest_m);
  surface.spacing_m = numbers.next<double>(largest_m);
  if (!(surface.spacing_m >= 1e-3)) numbers.fail("has a spacing below 1 mm");
  surface.columns = numbers.next<int>(1e6), surface.rows = numbers.next<int>(1e6);
  const std::int64_t count = std::int64_t{surface.columns} * surface.rows;
  if (surface.columns < 1 || surface.rows < 1 || count > most_nodes) numbers.fail("has a grid of an impossible size");
  // A short text cannot ask for much memory.
  if (count > most_nodes_a_character * static_cast<std::int64_t>(text.size())) numbers.fail("ends too early");
  const double largest = largest_m * height_steps_per_m;
  std::vector<std::int64_t> z;
  z.reserve(static_cast<std::size_t>(count));
  surface.z.clear();
  for (std::int64_t off = 0, zeros = 0; z.size() < static_cast<std::size_t>(count); --zeros) {
    if (zeros <= 0) {
      off = numbers.next_vlq(largest);
      zeros = off == 0 ? 1 + numbers.next_vlq(static_cast<double>(most_zeros - 1)) : 1;
      if (zeros < 1) numbers.fail("has a run of fewer than one zero");
    }
    z.push_back(prediction(z, z.size(), static_cast<std::size_t>(surface.columns)) + off);
    if (std::abs(static_cast<double>(z.back())) > largest) numbers.fail("has heights beyond all bounds");
    surface.z.push_back(static_cast<double>(z.back()) / height_steps_per_m);
  }
  if (numbers.more()) numbers.fail("has more heights than nodes");
}

}  // namespace roadquery
