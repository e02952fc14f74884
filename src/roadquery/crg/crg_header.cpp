// SPDX-License-Identifier: Apache-2.0
#include "roadquery/crg/crg_header.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <stdexcept>

#include "roadquery/text/text.hpp"

namespace roadquery {
namespace {

/// Settings as C's strtod reads them: what follows the number is passed over ("2.000000000+e00" is 2).
std::optional<double> leading_number(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || !std::isfinite(value)) return std::nullopt;
  return value;
}

class HeaderParser {
 public:
  HeaderParser(std::string_view bytes, const std::string& file) : bytes_(bytes), file_(file) {}

  CrgHeader parse() {
    for (;;) {
      const auto next = next_line(bytes_, at_);
      ++header_.lines;
      if (!next) fail("the file ends before its data ($$$$); is it an OpenCRG file?");
      if (next->starts_with("$$$$")) break;
      if (next->starts_with('$')) {
        section_ = lowered(trimmed(next->substr(0, next->find_first_of(" \t!*"))));
        if (section_ == "$road_crg_file")
          fail("data in another file ($ROAD_CRG_FILE) is not supported, put it into this one");
      } else {
        parse_line(*next);
      }
    }
    header_.bytes = std::min(at_, bytes_.size());
    return std::move(header_);
  }

 private:
  [[noreturn]] void fail(const std::string& what) const { fail_at_line(file_, header_.lines, what); }

  void parse_line(std::string_view line) {
    if (section_ == "$ct") {
      if (!header_.comment.empty()) header_.comment += '\n';
      header_.comment += trimmed(line);
      return;
    }
    if (line.starts_with('*')) return;
    line = trimmed(line.substr(0, line.find('!')));
    if (line.empty()) return;
    if (section_ == "$kd_definition") {
      parse_definition(line);
    } else if (section_ == "$road_crg") {
      const auto [key, text] = assignment(line);
      const auto parsed = crg_number(text);
      if (!parsed) fail("'" + std::string(text) + "' of " + std::string(key) + " is not a number");
      header_.road[lowered(key)] = *parsed;
    } else if (section_.starts_with("$road_crg_")) {
      parse_setting(line);
    }
  }

  void parse_setting(std::string_view line) {
    const auto [key, text] = assignment(line);
    header_.settings.push_back(section_ + " " + lowered(key));
    const bool option = section_ == "$road_crg_opts";
    if (!option && section_ != "$road_crg_mods") return;
    const auto parsed = leading_number(text);
    if (!parsed) fail("'" + std::string(text) + "' of " + std::string(key) + " is not a number");
    (option ? header_.options : header_.modifiers)[lowered(key)] = *parsed;
  }

  [[nodiscard]] std::pair<std::string_view, std::string_view> assignment(std::string_view line) const {
    const std::size_t equals = line.find('=');
    if (equals == std::string_view::npos) fail("'" + std::string(line) + "' is not of the form NAME = VALUE");
    return {trimmed(line.substr(0, equals)), trimmed(line.substr(equals + 1))};
  }

  void parse_format(std::string_view name) {
    for (const CrgFormat format : {CrgFormat::lrfi, CrgFormat::ldfi, CrgFormat::krbi, CrgFormat::kdbi})
      if (lowered(name) == lowered(name_of(format))) header_.format = format;
    if (!header_.format) fail("data format '" + std::string(name) + "' is not one of LRFI, LDFI, KRBI, KDBI");
  }

  void parse_definition(std::string_view line) {
    if (line.starts_with("#:")) return parse_format(trimmed(line.substr(2)));
    std::vector<std::string_view> parts;  // name, unit, ...
    for (std::string_view rest = line.substr(std::min<std::size_t>(2, line.size()));;) {
      const std::size_t comma = rest.find(',');
      parts.push_back(trimmed(rest.substr(0, comma)));
      if (comma == std::string_view::npos) break;
      rest.remove_prefix(comma + 1);
    }
    const std::string name = lowered(parts.front()), unit = parts.size() > 1 ? lowered(parts[1]) : "";
    if (line.starts_with("U:")) {
      if (name == "reference line u" && parts.size() > 3)
        header_.virtual_u_start = crg_number(parts[2]), header_.virtual_u_increment = crg_number(parts[3]);
      return;
    }
    if (!line.starts_with("D:")) fail("'" + std::string(line) + "' is no definition of data (#:, U: or D:)");
    add_channel(name, unit);
  }

  void add_channel(const std::string& name, const std::string& unit) {
    const auto add = [&](CrgChannel channel, const char* need) {
      if (unit != need) fail("'" + name + "' has the unit '" + unit + "', need " + need);
      header_.channels.push_back(channel);
    };
    if (name == "reference line phi") return add(CrgChannel::phi, "rad");
    if (name == "reference line slope") return add(CrgChannel::slope, "m/m");
    if (name == "reference line banking") return add(CrgChannel::banking, "m/m");
    if (!name.starts_with("long section")) {
      header_.channels.push_back(CrgChannel::other);  // x and y of the reference line: phi says the same
      return;
    }
    add(CrgChannel::section, "m");
    ++header_.sections;
    if (const std::size_t v = name.find("v ="); v != std::string::npos) {
      const auto parsed = crg_number(std::string_view(name).substr(v + 3));
      if (!parsed) fail("'" + name + "' does not say at which v");
      header_.section_v.push_back(*parsed);
    }
  }

  std::string_view bytes_;
  const std::string& file_;
  std::size_t at_ = 0;
  std::string section_;
  CrgHeader header_;
};

}  // namespace

double CrgHeader::value(const char* name, double fallback) const {
  const auto found = road.find(name);
  return found != road.end() ? found->second : fallback;
}

CrgHeader parse_crg_header(std::string_view bytes, const std::string& file) {
  return HeaderParser(bytes, file).parse();
}

void fail_at_line(const std::string& file, std::size_t line, const std::string& what) {
  throw std::runtime_error(file + ": line " + std::to_string(line) + ": " + what);
}

std::optional<double> crg_number(std::string_view text) {
  text = trimmed(text);
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

std::optional<std::string_view> next_line(std::string_view bytes, std::size_t& at) {
  if (at >= bytes.size()) return std::nullopt;
  const std::size_t end = std::min(bytes.find('\n', at), bytes.size());
  std::string_view line = bytes.substr(at, end - at);
  at = end + 1;
  if (line.ends_with('\r')) line.remove_suffix(1);
  return line;
}

std::string to_text(double value) {
  std::array<char, 32> text{};
  const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} ? std::string(text.data(), end) : "a number";
}

}  // namespace roadquery
