// SPDX-License-Identifier: Apache-2.0
#include "roadquery/crg/read_crg.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <stdexcept>

#include "roadquery/crg/crg_header.hpp"
#include "roadquery/crg/crg_newlines.hpp"
#include "roadquery/text/text.hpp"

namespace roadquery {
namespace {

constexpr double missing_value = std::numeric_limits<double>::quiet_NaN();

bool is_double(CrgFormat format) { return format == CrgFormat::ldfi || format == CrgFormat::kdbi; }

double decode(const char* bytes, std::size_t width) {
  std::uint64_t bits = 0;
  for (std::size_t k = 0; k < width; ++k) bits = bits << 8 | static_cast<unsigned char>(bytes[k]);
  return width == 8 ? std::bit_cast<double>(bits) : std::bit_cast<float>(static_cast<std::uint32_t>(bits));
}

class DataReader {
 public:
  DataReader(std::string_view bytes, const std::string& file)
      : bytes_(bytes), file_(file), header_(parse_crg_header(bytes, file)), at_(header_.bytes) {}

  CrgFile read() {
    CrgFile result;
    if (!header_.format) fail("no data format (#:LRFI, LDFI, KRBI or KDBI) in $KD_DEFINITION");
    result.format = *header_.format;
    if (header_.sections < 2)
      fail(std::to_string(header_.sections) + " long sections are defined, a surface needs two");
    const double increment = header_.value("reference_line_increment", header_.virtual_u_increment.value_or(0.0));
    if (!(increment > 0.0)) fail("no positive REFERENCE_LINE_INCREMENT");
    result.surface.u_increment_m = increment;
    result.surface.u_start_m = header_.value("reference_line_start_u", header_.virtual_u_start.value_or(0.0));
    result.surface.comment = header_.comment;
    set_columns(result.surface);
    split(is_text(result.format) ? text_values(result.format) : binary_values(result), result);
    for (const std::string& name : header_.settings)
      result.notes.push_back(name + " is set in the file and not applied to its values");
    result.options = std::move(header_.options), result.modifiers = std::move(header_.modifiers);
    return result;
  }

 private:
  [[noreturn]] void fail(const std::string& what) const { fail_at_line(file_, header_.lines, what); }
  [[noreturn]] void fail_in_data(const std::string& what) const { throw std::runtime_error(file_ + ": " + what); }

  void set_columns(CrgSurface& surface) const {
    if (header_.section_v.empty()) {
      set_even_columns(surface);
    } else {
      if (header_.section_v.size() != header_.sections) fail("some long sections say their v and some do not");
      surface.v_m = header_.section_v;
    }
    for (std::size_t i = 1; i < surface.v_m.size(); ++i)
      if (!(surface.v_m[i] > surface.v_m[i - 1]))
        fail("long section " + std::to_string(i + 1) + " at v = " + to_text(surface.v_m[i]) +
             " does not lie to the left of the one before it");
  }

  void set_even_columns(CrgSurface& surface) const {
    const auto last = static_cast<double>(header_.sections - 1);
    double increment = header_.value("long_section_v_increment", 0.0);
    double right = header_.value("long_section_v_right", 0.0);
    const double said_left = header_.value("long_section_v_left", 0.0);
    const bool has_right = header_.has("long_section_v_right"), has_left = header_.has("long_section_v_left");
    if (has_right && has_left && !header_.has("long_section_v_increment")) increment = (said_left - right) / last;
    if (!has_right) right = has_left ? said_left - increment * last : -0.5 * increment * last;
    for (std::size_t i = 0; i < header_.sections; ++i)
      surface.v_m.push_back(right + increment * static_cast<double>(i));
    const double left = surface.v_m.back();
    if (has_left && !(std::abs(left - said_left) <= 0.01 * increment))
      fail(std::to_string(header_.sections) + " long sections of " + to_text(increment) + " m from " + to_text(right) +
           " m reach " + to_text(left) + " m, LONG_SECTION_V_LEFT says " + to_text(said_left) + " m");
  }

  void read_text_record(CrgFormat format, std::size_t count, std::size_t line_number, std::vector<double>& values) {
    const std::size_t width = value_size(format);
    const auto line = next_line(bytes_, at_);
    if (!line) fail_at_line(file_, line_number, "the file ends within a row of data");
    for (std::size_t k = 0; k < count; ++k) {
      const std::string_view field = line->size() > k * width ? trimmed(line->substr(k * width, width)) : "";
      const auto parsed = field.starts_with('*') ? missing_value : crg_number(field);
      if (!parsed)
        fail_at_line(file_, line_number,
                     "'" + std::string(field) + "' in columns " + std::to_string(k * width + 1) + " to " +
                         std::to_string((k + 1) * width) + " is not a number");
      values.push_back(*parsed);
    }
  }

  std::vector<double> text_values(CrgFormat format) {
    const std::size_t per_record = crg_record_bytes / value_size(format), channels = header_.channels.size();
    std::size_t data_end = bytes_.size();  // of what is not blank
    while (data_end > at_ && trimmed(bytes_.substr(data_end - 1, 1)).empty()) --data_end;
    std::vector<double> values;
    std::size_t line_number = header_.lines;
    while (at_ < data_end) {
      for (std::size_t done = 0; done < channels; done += per_record)
        read_text_record(format, std::min(per_record, channels - done), ++line_number, values);
    }
    return values;
  }

  /// Rows by the header's end of u; 0 when it does not say.
  [[nodiscard]] std::size_t rows_of_header(const CrgSurface& surface) const {
    if (!header_.has("reference_line_end_u")) return 0;
    const double steps = (header_.value("reference_line_end_u", 0.0) - surface.u_start_m) / surface.u_increment_m;
    constexpr double most_steps = 1e9;
    if (!(std::abs(steps - std::round(steps)) < 1e-3 && steps > 0.5 && steps < most_steps))
      fail("REFERENCE_LINE_END_U lies " + to_text(steps) + " increments after the start");
    return static_cast<std::size_t>(std::round(steps)) + 1;
  }

  std::vector<double> binary_values(CrgFile& result) {
    const std::size_t width = value_size(result.format), columns = header_.channels.size();
    std::string_view data = bytes_.substr(at_);
    std::string mended;
    std::size_t rows = rows_of_header(result.surface);
    const std::size_t needed_records = (rows * columns * width + crg_record_bytes - 1) / crg_record_bytes;
    if (rows > 0 && data.size() < needed_records * crg_record_bytes) {
      mended = data;
      // Mended or not: below it is counted again.
      if (const std::size_t count = mend_newlines(mended, width, rows * columns); count > 0)
        result.notes.push_back(std::to_string(count) +
                               " bytes that a text transfer took out of the binary data (CR before LF) were put back");
      data = mended;
    }
    const std::size_t values = data.size() / width;
    if (rows > 0 && values < rows * columns)
      fail_in_data("record " + std::to_string((data.size() + crg_record_bytes - 1) / crg_record_bytes) +
                   " of the binary data is the last one, " + std::to_string(rows) + " rows of " +
                   std::to_string(columns) + " values need " + std::to_string(needed_records) +
                   "; the file is cut off, or was copied as text");
    if (rows == 0) rows = values / columns;
    std::vector<double> decoded(rows * columns);
    for (std::size_t i = 0; i < decoded.size(); ++i) {
      decoded[i] = decode(data.data() + i * width, width);
      if (std::isinf(decoded[i])) fail_in_data("row " + std::to_string(i / columns + 1) + " holds an infinite value");
    }
    if (!header_.has("reference_line_end_u")) drop_filling(decoded, columns);
    return decoded;
  }

  /// Without an end in the header, what fills the last record looks like rows.
  static void drop_filling(std::vector<double>& values, std::size_t columns) {
    const auto empty_row = [&] {
      return std::all_of(values.end() - static_cast<std::ptrdiff_t>(columns), values.end(),
                         [](double v) { return std::isnan(v); });
    };
    while (!values.empty() && empty_row()) values.resize(values.size() - columns);
  }

  /// Channels of all rows into the surface, with what is constant for the whole file.
  void split(const std::vector<double>& values, CrgFile& result) {
    CrgSurface& surface = result.surface;
    const std::size_t columns = header_.channels.size(), rows = values.size() / columns;
    if (rows < 2) fail("fewer than two rows of data follow");
    if (const std::size_t expected = rows_of_header(surface); expected != 0 && expected != rows)
      fail_in_data(std::to_string(rows) + " rows of data, REFERENCE_LINE_END_U asks for " + std::to_string(expected));
    surface.phi_rad.assign(rows, header_.value("reference_line_start_phi", 0.0));
    surface.slope.assign(rows, header_.value("reference_line_start_s", 0.0));
    surface.banking.assign(rows, header_.value("reference_line_start_b", 0.0));
    surface.grid_m.reserve(rows * header_.sections);
    for (std::size_t i = 0; i < rows; ++i) split_row(&values[i * columns], i, surface);
    // A step ends at a row: what stands at the first one belongs to none.
    surface.phi_rad[0] = surface.phi_rad[1], surface.slope[0] = surface.slope[1];
    if (std::count(header_.channels.begin(), header_.channels.end(), CrgChannel::other) > 0)
      result.notes.emplace_back("channels other than phi, slope, banking and long sections are not read");
    integrate_reference_line(surface, header_.value("reference_line_start_x", 0.0),
                             header_.value("reference_line_start_y", 0.0),
                             header_.value("reference_line_start_z", 0.0));
    close(surface, result.notes);
  }

  void split_row(const double* values, std::size_t i, CrgSurface& surface) const {
    for (std::size_t k = 0; k < header_.channels.size(); ++k) {
      const double v = values[k];
      const auto need = [&](const char* name) {
        if (std::isnan(v)) fail_in_data("row " + std::to_string(i + 1) + " of the data has no " + name);
        return v;
      };
      switch (header_.channels[k]) {
        case CrgChannel::phi:
          if (i > 0) surface.phi_rad[i] = need("phi");
          break;
        case CrgChannel::slope:
          if (i > 0) surface.slope[i] = need("slope");
          break;
        case CrgChannel::banking:
          surface.banking[i] = need("banking");
          break;
        case CrgChannel::section:
          surface.grid_m.push_back(v);
          break;
        case CrgChannel::other:
          break;
      }
    }
  }

  /// Spreads what the integrated line misses the end in the header by, as the reference implementation does (weights
  /// that grow with u between the integrations from both ends). Misses come of single precision.
  void close(CrgSurface& surface, std::vector<std::string>& notes) const {
    const auto spread = [&](std::vector<double>& values, double end) {
      const double miss = end - values.back();
      for (std::size_t i = 0; i < values.size(); ++i)
        values[i] += miss * static_cast<double>(i) / static_cast<double>(values.size() - 1);
      if (!(std::abs(miss) > 1e-3)) return;  // a surface's own accuracy
      std::array<char, 400> text{};          // of the longest double
      std::snprintf(text.data(), text.size(), "%.4f", miss);
      notes.push_back(std::string("the reference line missed the end that the header states by ") + text.data() + " m");
    };
    if (header_.has("reference_line_end_x") && header_.has("reference_line_end_y")) {
      spread(surface.x_m, header_.value("reference_line_end_x", 0.0));
      spread(surface.y_m, header_.value("reference_line_end_y", 0.0));
    }
    if (header_.has("reference_line_end_z")) spread(surface.z_m, header_.value("reference_line_end_z", 0.0));
  }

  std::string_view bytes_;
  const std::string& file_;
  CrgHeader header_;
  std::size_t at_ = 0;
};

}  // namespace

bool is_text(CrgFormat format) { return format == CrgFormat::lrfi || format == CrgFormat::ldfi; }

std::size_t value_size(CrgFormat format) {
  return is_text(format) ? (is_double(format) ? 20 : 10) : (is_double(format) ? 8 : 4);
}

CrgFile parse_crg(std::string_view bytes, const std::string& name) { return DataReader(bytes, name).read(); }

CrgFile read_crg(const std::string& path) {
  // OpenDRIVE files name them: a device or a pipe would never end.
  if (std::error_code unknown; std::filesystem::is_other(path, unknown))
    throw std::runtime_error(path + ": is no file");
  std::ifstream in(path, std::ios::binary);
  if (!in) throw std::runtime_error(path + ": cannot be opened: " + std::strerror(errno));
  const std::string bytes{std::istreambuf_iterator<char>(in), {}};
  if (in.bad()) throw std::runtime_error(path + ": cannot be read: " + std::strerror(errno));
  return parse_crg(bytes, path);
}

}  // namespace roadquery
