#include "orthodrive/io/opencrg_io.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>
#include <string_view>

#include "orthodrive/core/aside_file.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/io/crg_newlines.hpp"

namespace orthodrive::io {
namespace {

constexpr double missing = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t record_bytes = 80;

bool is_double(CrgFormat format) { return format == CrgFormat::ldfi || format == CrgFormat::kdbi; }
bool is_text(CrgFormat format) { return format == CrgFormat::lrfi || format == CrgFormat::ldfi; }
/// Characters (text) or bytes (binary) of a value.
std::size_t value_size(CrgFormat format) {
  return is_text(format) ? (is_double(format) ? 20 : 10) : (is_double(format) ? 8 : 4);
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.front()))) text.remove_prefix(1);
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back()))) text.remove_suffix(1);
  return text;
}
std::string lower(std::string_view text) {
  std::string result(text);
  for (char& c : result) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return result;
}
std::optional<double> number(std::string_view text) {
  text = trimmed(text);
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

// ---- reading ----------------------------------------------------------------------------------------------------

enum class Channel { phi, slope, banking, section, other };

struct Header {
  std::string comment;
  std::map<std::string, double> road;  ///< $ROAD_CRG, keys in lower case
  std::vector<std::string> settings;   ///< names of set options and modifiers
  std::optional<CrgFormat> format;
  std::vector<Channel> channels;
  std::vector<double> section_v;  ///< of sections "at v = ..."
  std::size_t sections = 0;
  std::optional<double> virtual_u_start, virtual_u_increment;
  std::size_t lines = 0;  ///< up to and with the line $$$$
};

class Reader {
 public:
  explicit Reader(const std::filesystem::path& path) : file_(path.string()) {
    std::ifstream in(path, std::ios::binary);
    if (!in) throw InputError(file_, "cannot be opened");
    bytes_.assign(std::istreambuf_iterator<char>(in), {});
  }

  CrgFile read() {
    read_header();
    CrgFile result;
    if (!header_.format) fail(header_.lines, "no data format (#:LRFI, LDFI, KRBI or KDBI) in $KD_DEFINITION");
    result.format = *header_.format;
    if (header_.sections < 2)
      fail(header_.lines, fmt::format("{} long sections are defined, a surface needs two", header_.sections));
    const double increment = value("reference_line_increment", header_.virtual_u_increment.value_or(0.0));
    if (!(increment > 0.0)) fail(header_.lines, "no positive REFERENCE_LINE_INCREMENT");
    result.surface.u_increment_m = increment;
    result.surface.u_start_m = value("reference_line_start_u", header_.virtual_u_start.value_or(0.0));
    result.surface.comment = header_.comment;
    set_columns(result.surface);
    const std::vector<double> values = is_text(result.format) ? text_values(result.format) : binary_values(result);
    split(values, result);
    for (const std::string& name : header_.settings)
      result.notes.push_back(fmt::format("{} is set in the file and not applied", name));
    return result;
  }

 private:
  [[noreturn]] void fail(std::size_t line, const std::string& what) const {
    throw InputError(file_, fmt::format("line {}: {}", line, what));
  }
  [[nodiscard]] bool has(const char* name) const { return header_.road.count(name) != 0; }
  [[nodiscard]] double value(const char* name, double fallback) const {
    const auto found = header_.road.find(name);
    return found != header_.road.end() ? found->second : fallback;
  }

  /// The next line without its end; nothing at the end of the file.
  std::optional<std::string_view> next_line() {
    if (at_ >= bytes_.size()) return std::nullopt;
    const std::size_t end = std::min(bytes_.find('\n', at_), bytes_.size());
    std::string_view line(bytes_.data() + at_, end - at_);
    at_ = end + 1;
    if (line.ends_with('\r')) line.remove_suffix(1);
    return line;
  }

  void read_header() {
    std::string section;
    for (;;) {
      const auto next = next_line();
      ++header_.lines;
      if (!next) fail(header_.lines, "the file ends before its data ($$$$); is it an OpenCRG file?");
      std::string_view line = *next;
      if (line.starts_with("$$$$")) return;
      if (line.starts_with('$')) {
        const std::string_view name = trimmed(line.substr(0, line.find_first_of(" \t!*")));
        section = lower(name);
        if (section == "$road_crg_file")
          fail(header_.lines, "data in another file ($ROAD_CRG_FILE) is not supported, put it into this one");
        continue;
      }
      if (section == "$ct") {
        header_.comment += (header_.comment.empty() ? "" : "\n") + std::string(trimmed(line));
        continue;
      }
      if (line.starts_with('*')) continue;
      line = trimmed(line.substr(0, line.find('!')));
      if (line.empty()) continue;
      if (section == "$kd_definition") {
        read_definition(line);
      } else if (section == "$road_crg") {
        const auto [key, text] = assignment(line);
        const auto parsed = number(text);
        if (!parsed) fail(header_.lines, fmt::format("'{}' of {} is not a number", text, key));
        header_.road[lower(key)] = *parsed;
      } else if (section.starts_with("$road_crg_")) {
        header_.settings.push_back(fmt::format("{} {}", section, lower(assignment(line).first)));
      }
    }
  }

  std::pair<std::string_view, std::string_view> assignment(std::string_view line) const {
    const std::size_t equals = line.find('=');
    if (equals == std::string_view::npos)
      fail(header_.lines, fmt::format("'{}' is not of the form NAME = VALUE", line));
    return {trimmed(line.substr(0, equals)), trimmed(line.substr(equals + 1))};
  }

  void read_definition(std::string_view line) {
    if (line.starts_with("#:")) {
      const std::string_view name = trimmed(line.substr(2));
      for (const CrgFormat format : {CrgFormat::lrfi, CrgFormat::ldfi, CrgFormat::krbi, CrgFormat::kdbi})
        if (lower(name) == lower(name_of(format))) header_.format = format;
      if (!header_.format)
        fail(header_.lines, fmt::format("data format '{}' is not one of LRFI, LDFI, KRBI, KDBI", name));
      return;
    }
    std::vector<std::string_view> parts;  // name, unit, ...
    for (std::string_view rest = line.substr(std::min<std::size_t>(2, line.size()));;) {
      const std::size_t comma = rest.find(',');
      parts.push_back(trimmed(rest.substr(0, comma)));
      if (comma == std::string_view::npos) break;
      rest.remove_prefix(comma + 1);
    }
    const std::string name = lower(parts.front()), unit = parts.size() > 1 ? lower(parts[1]) : "";
    if (line.starts_with("U:")) {
      if (name == "reference line u" && parts.size() > 3)
        header_.virtual_u_start = number(parts[2]), header_.virtual_u_increment = number(parts[3]);
      return;
    }
    if (!line.starts_with("D:")) fail(header_.lines, fmt::format("'{}' is no definition of data (#:, U: or D:)", line));
    const auto add = [&](Channel channel, const char* need) {
      if (unit != need) fail(header_.lines, fmt::format("'{}' has the unit '{}', need {}", name, unit, need));
      header_.channels.push_back(channel);
    };
    if (name == "reference line phi") return add(Channel::phi, "rad");
    if (name == "reference line slope") return add(Channel::slope, "m/m");
    if (name == "reference line banking") return add(Channel::banking, "m/m");
    if (!name.starts_with("long section")) {
      header_.channels.push_back(Channel::other);  // x and y of the reference line: phi says the same
      return;
    }
    add(Channel::section, "m");
    ++header_.sections;
    if (const std::size_t v = name.find("v ="); v != std::string::npos) {
      const auto parsed = number(std::string_view(name).substr(v + 3));
      if (!parsed) fail(header_.lines, fmt::format("'{}' does not say at which v", name));
      header_.section_v.push_back(*parsed);
    }
  }

  void set_columns(CrgSurface& surface) const {
    const auto count = static_cast<double>(header_.sections);
    if (!header_.section_v.empty()) {
      if (header_.section_v.size() != header_.sections)
        fail(header_.lines, "some long sections say their v and some do not");
      surface.v_m = header_.section_v;
    } else {
      double increment = value("long_section_v_increment", 0.0), right = value("long_section_v_right", 0.0);
      if (has("long_section_v_right") && has("long_section_v_left") && !has("long_section_v_increment"))
        increment = (value("long_section_v_left", 0.0) - right) / (count - 1.0);
      if (!has("long_section_v_right"))
        right = has("long_section_v_left") ? value("long_section_v_left", 0.0) - increment * (count - 1.0)
                                           : -0.5 * increment * (count - 1.0);
      for (std::size_t i = 0; i < header_.sections; ++i)
        surface.v_m.push_back(right + increment * static_cast<double>(i));
      const double left = surface.v_m.back(), want = value("long_section_v_left", left);
      if (std::abs(left - want) > 0.01 * increment)
        fail(header_.lines, fmt::format("{} long sections of {} m from {} m reach {} m, LONG_SECTION_V_LEFT says {} m",
                                        header_.sections, increment, right, left, want));
    }
    for (std::size_t i = 1; i < surface.v_m.size(); ++i)
      if (!(surface.v_m[i] > surface.v_m[i - 1]))
        fail(header_.lines, fmt::format("long section {} at v = {} does not lie to the left of the one before it",
                                        i + 1, surface.v_m[i]));
  }

  std::vector<double> text_values(CrgFormat format) {
    const std::size_t width = value_size(format), per_record = record_bytes / width;
    std::vector<double> values;
    std::size_t line_number = header_.lines;
    const auto rest_is_blank = [&] {
      return trimmed(std::string_view(bytes_).substr(std::min(at_, bytes_.size()))).empty();
    };
    while (!rest_is_blank()) {
      for (std::size_t done = 0; done < header_.channels.size();) {
        const auto line = next_line();
        ++line_number;
        if (!line) fail(line_number, "the file ends within a row of data");
        const std::size_t count = std::min(per_record, header_.channels.size() - done);
        for (std::size_t k = 0; k < count; ++k) {
          const std::string_view field = line->size() > k * width ? trimmed(line->substr(k * width, width)) : "";
          const auto parsed = field.starts_with('*') ? missing : number(field);
          if (!parsed)
            fail(line_number,
                 fmt::format("'{}' in columns {} to {} is not a number", field, k * width + 1, (k + 1) * width));
          values.push_back(*parsed);
        }
        done += count;
      }
    }
    return values;
  }

  /// Rows by the header's end of u; 0 when it does not say.
  std::size_t rows_of_header(const CrgSurface& surface) const {
    if (!has("reference_line_end_u")) return 0;
    const double steps = (value("reference_line_end_u", 0.0) - surface.u_start_m) / surface.u_increment_m;
    if (!(std::abs(steps - std::round(steps)) < 1e-3 && steps > 0.5))
      fail(header_.lines, fmt::format("REFERENCE_LINE_END_U lies {} increments after the start", steps));
    return static_cast<std::size_t>(std::round(steps)) + 1;
  }

  std::vector<double> binary_values(CrgFile& result) {
    const std::size_t width = value_size(result.format), columns = header_.channels.size();
    std::string data = at_ < bytes_.size() ? bytes_.substr(at_) : std::string();
    std::size_t rows = rows_of_header(result.surface);
    if (rows > 0 && data.size() < (rows * columns * width + record_bytes - 1) / record_bytes * record_bytes) {
      // Mended or not: below it is counted again.
      if (const std::size_t mended = mend_newlines(data, width, rows * columns); mended > 0)
        result.notes.push_back(fmt::format(
            "{} bytes that a text transfer took out of the binary data (CR before LF) were put back", mended));
    }
    const std::size_t values = data.size() / width;
    if (rows > 0 && values < rows * columns)
      throw InputError(
          file_, fmt::format("record {} of the binary data is the last one, {} rows of {} values need {}; the file "
                             "is cut off, or was copied as text",
                             (data.size() + record_bytes - 1) / record_bytes, rows, columns,
                             (rows * columns * width + record_bytes - 1) / record_bytes));
    if (rows == 0) rows = values / columns;
    std::vector<double> decoded(rows * columns);
    for (std::size_t i = 0; i < decoded.size(); ++i) decoded[i] = decode(data.data() + i * width, width);
    // Without an end in the header, what fills the last record looks like rows.
    const auto empty_row = [&] {
      return std::all_of(decoded.end() - static_cast<std::ptrdiff_t>(columns), decoded.end(),
                         [](double v) { return std::isnan(v); });
    };
    if (!has("reference_line_end_u"))
      while (!decoded.empty() && empty_row()) decoded.resize(decoded.size() - columns);
    return decoded;
  }

  static double decode(const char* bytes, std::size_t width) {
    std::uint64_t bits = 0;
    for (std::size_t k = 0; k < width; ++k) bits = bits << 8 | static_cast<unsigned char>(bytes[k]);
    return width == 8 ? std::bit_cast<double>(bits) : std::bit_cast<float>(static_cast<std::uint32_t>(bits));
  }

  /// Channels of all rows into the surface, with what is constant for the whole file.
  void split(const std::vector<double>& values, CrgFile& result) {
    CrgSurface& surface = result.surface;
    const std::size_t columns = header_.channels.size(), rows = values.size() / columns;
    if (rows < 2) fail(header_.lines, "fewer than two rows of data follow");
    if (const std::size_t expected = rows_of_header(surface); expected != 0 && expected != rows)
      throw InputError(file_, fmt::format("{} rows of data, REFERENCE_LINE_END_U asks for {}", rows, expected));
    surface.phi_rad.assign(rows, value("reference_line_start_phi", 0.0));
    surface.slope.assign(rows, value("reference_line_start_s", 0.0));
    surface.banking.assign(rows, value("reference_line_start_b", 0.0));
    surface.grid_m.reserve(rows * header_.sections);
    for (std::size_t i = 0; i < rows; ++i)
      for (std::size_t k = 0; k < columns; ++k) {
        const double v = values[i * columns + k];
        const auto need = [&](const char* name) {
          if (std::isnan(v)) throw InputError(file_, fmt::format("row {} of the data has no {}", i + 1, name));
          return v;
        };
        switch (header_.channels[k]) {
          case Channel::phi:
            if (i > 0) surface.phi_rad[i] = need("phi");
            break;
          case Channel::slope:
            if (i > 0) surface.slope[i] = need("slope");
            break;
          case Channel::banking:
            surface.banking[i] = need("banking");
            break;
          case Channel::section:
            surface.grid_m.push_back(v);
            break;
          case Channel::other:
            break;
        }
      }
    // A step ends at a row: what stands at the first one belongs to none.
    surface.phi_rad[0] = surface.phi_rad[1], surface.slope[0] = surface.slope[1];
    if (std::any_of(header_.channels.begin(), header_.channels.end(), [](Channel c) { return c == Channel::other; }))
      result.notes.push_back("channels other than phi, slope, banking and long sections are not read");
    integrate_reference_line(surface, value("reference_line_start_x", 0.0), value("reference_line_start_y", 0.0),
                             value("reference_line_start_z", 0.0));
    close(surface, result.notes);
  }

  /// Spreads what the integrated line misses the end in the header by, as the reference implementation does (weights
  /// that grow with u between the integrations from both ends). Misses come of single precision.
  void close(CrgSurface& surface, std::vector<std::string>& notes) const {
    const auto spread = [&](std::vector<double>& values, double end) {
      const double miss = end - values.back();
      for (std::size_t i = 0; i < values.size(); ++i)
        values[i] += miss * static_cast<double>(i) / static_cast<double>(values.size() - 1);
      if (std::abs(miss) > 1e-3)  // a surface's own accuracy
        notes.push_back(fmt::format("the reference line missed the end that the header states by {:.4f} m", miss));
    };
    if (has("reference_line_end_x") && has("reference_line_end_y")) {
      spread(surface.x_m, value("reference_line_end_x", 0.0));
      spread(surface.y_m, value("reference_line_end_y", 0.0));
    }
    if (has("reference_line_end_z")) spread(surface.z_m, value("reference_line_end_z", 0.0));
  }

  std::string file_, bytes_;
  std::size_t at_ = 0;
  Header header_;
};

// ---- writing ----------------------------------------------------------------------------------------------------

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

CrgFile read_crg(const std::filesystem::path& path) { return Reader(path).read(); }

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
      if ((k + 1) * width % record_bytes == 0 || k + 1 == row.size()) text += '\n';
    }
  }
  if (!is_text(format))
    while ((text.size() - data) % record_bytes != 0) append_binary(text, missing, width);
  write_text_file(path, text);
}

}  // namespace orthodrive::io
