// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/support/npy_reader.hpp"

#include <fmt/format.h>

#include <bit>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/printable.hpp"

namespace orthodrive::io {
namespace fs = std::filesystem;

namespace {

static_assert(std::endian::native == std::endian::little, "values are copied as they lie in the file");

/// The text after `'key':` of the header, a Python dictionary as numpy writes it.
std::string_view value_of(std::string_view header, std::string_view key) {
  const auto at = header.find(fmt::format("'{}':", key));
  if (at == std::string_view::npos) return {};
  header.remove_prefix(at + key.size() + 3);
  const auto begin = header.find_first_not_of(' ');
  return begin == std::string_view::npos ? std::string_view{} : header.substr(begin);
}

std::vector<std::size_t> shape_of(std::string_view text, const std::string& file) {
  const auto end = text.find(')');
  if (text.empty() || text.front() != '(' || end == std::string_view::npos)
    throw InputError(file, "its header has no shape; save the array again with numpy.save");
  std::vector<std::size_t> shape;
  const char *at = text.data() + 1, *last = text.data() + end;
  while (at < last) {
    std::size_t n = 0;
    const auto [next, error] = std::from_chars(at, last, n);
    if (error == std::errc{}) shape.push_back(n);
    at = error == std::errc{} ? next : at + 1;
  }
  return shape;
}

template <typename T>
double load(const char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  return static_cast<double>(value);
}

struct ValueType {
  std::string_view name;
  std::size_t bytes;
  double (*load)(const char*);
};
constexpr ValueType value_types[] = {
    {"<f8", 8, load<double>},        {"<f4", 4, load<float>},         {"<i8", 8, load<std::int64_t>},
    {"<i4", 4, load<std::int32_t>},  {"<i2", 2, load<std::int16_t>},  {"|i1", 1, load<std::int8_t>},
    {"<u8", 8, load<std::uint64_t>}, {"<u4", 4, load<std::uint32_t>}, {"<u2", 2, load<std::uint16_t>},
    {"|u1", 1, load<std::uint8_t>},  {"|b1", 1, load<std::uint8_t>}};

}  // namespace

NpyTable read_npy(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in || !fs::is_regular_file(file)) throw InputError(file.string(), "no such file");
  const std::string bytes{std::istreambuf_iterator<char>(in), {}};
  constexpr std::string_view magic = "\x93NUMPY";
  if (!bytes.starts_with(magic) || bytes.size() < 12)
    throw InputError(file.string(), "is no .npy file; save the array with numpy.save");
  const bool long_header = bytes[6] > 1;
  const std::size_t start = long_header ? 12 : 10;
  const std::size_t length = static_cast<std::size_t>(long_header ? load<std::uint32_t>(bytes.data() + 8)
                                                                  : load<std::uint16_t>(bytes.data() + 8));
  if (bytes.size() < start + length) throw InputError(file.string(), "is cut off in its header; get the file again");
  const std::string_view header = std::string_view(bytes).substr(start, length);

  const std::string_view type_text = value_of(header, "descr");
  const ValueType* type = nullptr;
  for (const ValueType& known : value_types)
    if (type_text.size() > known.name.size() && type_text.substr(1, known.name.size()) == known.name) type = &known;
  if (!type)
    throw InputError(file.string(), fmt::format("holds values of type {}, need little-endian numbers; save "
                                                "array.astype('<f8')",
                                                printable(std::string(type_text.substr(0, type_text.find(','))))));
  const std::vector<std::size_t> shape = shape_of(value_of(header, "shape"), file.string());
  if (shape.empty() || shape.size() > 2)
    throw InputError(file.string(), fmt::format("has {} dimensions, need one or two", shape.size()));
  NpyTable table{shape[0], shape.size() > 1 ? shape[1] : 1, {}};
  const std::size_t available = (bytes.size() - start - length) / type->bytes;
  if (table.columns == 0 || table.rows > available / table.columns)
    throw InputError(file.string(), fmt::format("is cut off: {} x {} values are announced, {} are there; get the file "
                                                "again",
                                                table.rows, table.columns, available));
  const bool fortran = value_of(header, "fortran_order").starts_with("True");
  table.values.resize(table.rows * table.columns);
  for (std::size_t row = 0; row < table.rows; ++row)
    for (std::size_t column = 0; column < table.columns; ++column) {
      const std::size_t at = fortran ? column * table.rows + row : row * table.columns + column;
      table.values[row * table.columns + column] = type->load(bytes.data() + start + length + at * type->bytes);
    }
  return table;
}

}  // namespace orthodrive::io
