// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/opendrive/opencrg_io.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "orthodrive/core/atomic_file.hpp"
#include "orthodrive/core/error.hpp"
#include "roadquery/crg/read_crg.hpp"

namespace orthodrive::io {
namespace {

constexpr double missing = std::numeric_limits<double>::quiet_NaN();
using roadquery::crg_record_bytes;
using roadquery::is_text;
using roadquery::value_size;

/// Right-aligned in its column, with as many decimals as there is room for; "" when there is none.
std::string formatted(double value, std::size_t width) {
  if (std::isnan(value)) return fmt::format("{:*<{}}", " *missing", width);
  for (int decimals = static_cast<int>(width) - 3; decimals >= 0; --decimals) {
    std::string text = fmt::format("{:.{}f}", value, decimals);
    if (text.size() <= width) return std::string(width - text.size(), ' ') + text;
  }
  return "";
}

void append_binary(std::string& out, double value, std::size_t width) {
  const std::uint64_t bits =
      width == 8 ? std::bit_cast<std::uint64_t>(value) : std::bit_cast<std::uint32_t>(static_cast<float>(value));
  for (std::size_t k = width; k-- > 0;) out.push_back(static_cast<char>(bits >> (8 * k) & 0xff));
}

void check(const CrgSurface& s) {
  const std::size_t rows = s.rows();
  if (rows < 2 || s.columns() < 2 || s.grid_m.size() != rows * s.columns() || s.slope.size() != rows ||
      s.banking.size() != rows || s.x_m.size() != rows || s.y_m.size() != rows || s.z_m.size() != rows)
    throw Error("a CRG surface needs two rows, two columns and a value of every channel a row");
}

bool evenly_spaced(const std::vector<double>& v, double increment) {
  for (std::size_t i = 0; i < v.size(); ++i)
    if (std::abs(v[i] - (v.front() + increment * static_cast<double>(i))) > 1e-9) return false;
  return true;
}

}  // namespace

CrgFile read_crg(const std::filesystem::path& path) {
  try {
    return roadquery::read_crg(path.string());
  } catch (const std::runtime_error& error) {
    throw InputError(path.string(), std::string(error.what()).substr(path.string().size() + 2));
  }
}

void write_crg(const std::filesystem::path& path, const CrgSurface& s, CrgFormat format) {
  check(s);
  const auto any = [](const std::vector<double>& values) {
    return std::any_of(values.begin(), values.end(), [](double v) { return v != 0.0; });
  };
  const bool with_slope = any(s.slope), with_banking = any(s.banking);
  const double v_increment = (s.v_m.back() - s.v_m.front()) / static_cast<double>(s.columns() - 1);
  const bool regular = evenly_spaced(s.v_m, v_increment);

  std::string text = "$CT\n";
  if (!s.comment.empty()) text += s.comment + "\n";
  text += "$\n$ROAD_CRG\n";
  const auto set = [&](const char* name, double value) { text += fmt::format("{:<24} = {}\n", name, value); };
  set("REFERENCE_LINE_START_U", s.u_start_m), set("REFERENCE_LINE_END_U", s.u_end_m());
  set("REFERENCE_LINE_INCREMENT", s.u_increment_m);
  set("REFERENCE_LINE_START_X", s.x_m.front()), set("REFERENCE_LINE_START_Y", s.y_m.front());
  set("REFERENCE_LINE_END_X", s.x_m.back()), set("REFERENCE_LINE_END_Y", s.y_m.back());
  set("REFERENCE_LINE_START_PHI", s.phi_rad[1]), set("REFERENCE_LINE_END_PHI", s.phi_rad.back());
  set("REFERENCE_LINE_START_Z", s.z_m.front()), set("REFERENCE_LINE_END_Z", s.z_m.back());
  set("REFERENCE_LINE_START_S", s.slope[1]), set("REFERENCE_LINE_END_S", s.slope.back());
  set("REFERENCE_LINE_START_B", s.banking.front()), set("REFERENCE_LINE_END_B", s.banking.back());
  set("LONG_SECTION_V_RIGHT", s.v_m.front()), set("LONG_SECTION_V_LEFT", s.v_m.back());
  if (regular) set("LONG_SECTION_V_INCREMENT", v_increment);
  text += fmt::format("$\n$KD_DEFINITION\n#:{}\nU:reference line u,m,{},{}\nD:reference line phi,rad\n",
                      name_of(format), s.u_start_m, s.u_increment_m);
  if (with_slope) text += "D:reference line slope,m/m\n";
  if (with_banking) text += "D:reference line banking,m/m\n";
  for (std::size_t j = 0; j < s.columns(); ++j)
    text +=
        regular ? fmt::format("D:long section {},m\n", j + 1) : fmt::format("D:long section at v = {},m\n", s.v_m[j]);
  text += "$\n" + std::string(72, '$') + "\n";

  const std::size_t width = value_size(format), data = text.size();
  std::vector<double> row;
  for (std::size_t i = 0; i < s.rows(); ++i) {
    row.clear();
    row.push_back(i == 0 ? missing : s.phi_rad[i]);
    if (with_slope) row.push_back(i == 0 ? missing : s.slope[i]);
    if (with_banking) row.push_back(s.banking[i]);
    for (std::size_t j = 0; j < s.columns(); ++j) row.push_back(s.grid(i, j));
    for (std::size_t k = 0; k < row.size(); ++k) {
      if (!is_text(format)) {
        append_binary(text, row[k], width);
        continue;
      }
      const std::string field = formatted(row[k], width);
      if (field.empty())
        throw Error(fmt::format("{}: {} at u = {} does not fit into {} characters, choose a binary format",
                                path.string(), row[k], s.u_start_m + s.u_increment_m * static_cast<double>(i), width));
      text += field;
      if ((k + 1) * width % crg_record_bytes == 0 || k + 1 == row.size()) text += '\n';
    }
  }
  if (!is_text(format))
    while ((text.size() - data) % crg_record_bytes != 0) append_binary(text, missing, width);
  write_text_file(path, text);
}

}  // namespace orthodrive::io
