// SPDX-License-Identifier: Apache-2.0
#include "vehicle/parse_car.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <set>
#include <stdexcept>
#include <vector>

#include "roadquery/text/number_text.hpp"
#include "roadquery/text/text.hpp"
#include "vehicle/car_geometry.hpp"
#include "vehicle/car_table.hpp"

namespace vehicle {
namespace {

constexpr std::size_t longest_list = 200;
constexpr std::size_t longest_echo = 60;  // of text from the file in a message

/// Text of a file as it may stand in a message: one line, printable, short.
std::string shown(std::string_view text) {
  std::string out = "'";
  for (const char c : text.substr(0, longest_echo)) out += c >= ' ' && c <= '~' ? c : '?';
  return out + (text.size() > longest_echo ? "...'" : "'");
}

std::string number_text(double value) {
  std::array<char, 32> buffer{};
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr;
  return {buffer.data(), end};
}

/// The line without its comment; a # inside quotes is text.
std::string_view without_comment(std::string_view line) {
  bool in_text = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] == '"') in_text = !in_text;
    if (line[i] == '#' && !in_text) return line.substr(0, i);
  }
  return line;
}

struct Value {
  int line = 0;
  bool used = false;
  std::string_view text;
};

/// Sections and keys of a file, each with its line.
class Entries {
 public:
  Entries(std::string_view text, const std::string& file) : file_(file) {
    std::string section;
    int number = 0;
    while (!text.empty()) {
      const auto end = text.find('\n');
      const std::string_view line = roadquery::trimmed(without_comment(text.substr(0, end)));
      text = end == std::string_view::npos ? std::string_view{} : text.substr(end + 1);
      ++number;
      if (line.empty()) continue;
      if (line.front() == '[') {
        if (line.back() != ']') fail(number, "a section needs a closing ]: " + shown(line));
        section = std::string(roadquery::trimmed(line.substr(1, line.size() - 2)));
        if (!sections_.emplace(section, number).second) fail(number, "section " + shown(section) + " stands twice");
        continue;
      }
      const auto equals = line.find('=');
      if (equals == std::string_view::npos) fail(number, "neither [section] nor key = value: " + shown(line));
      const std::string key(roadquery::trimmed(line.substr(0, equals)));
      const Value value{number, false, roadquery::trimmed(line.substr(equals + 1))};
      if (!values_.emplace(std::pair(section, key), value).second) {
        fail(number, "key " + shown(key) + " stands twice in its section");
      }
    }
  }

  [[noreturn]] void fail(int line, const std::string& what) const {
    throw std::runtime_error(file_ + ":" + std::to_string(line) + ": " + what);
  }
  [[noreturn]] void fail(const std::string& what) const { throw std::runtime_error(file_ + ": " + what); }

  const Value& take(std::string_view section, std::string_view key) {
    const auto found = values_.find(std::pair(std::string(section), std::string(key)));
    if (found == values_.end()) {
      fail("no value for " + std::string(key) + " in " +
           (section.empty() ? "the first lines" : "[" + std::string(section) + "]"));
    }
    found->second.used = true;
    used_sections_.insert(std::string(section));
    return found->second;
  }
  void expect_all_used() const {
    for (const auto& [name, line] : sections_) {
      if (!used_sections_.contains(name)) fail(line, "unknown section " + shown(name));
    }
    for (const auto& [name, value] : values_) {
      if (!value.used) fail(value.line, "unknown key " + shown(name.second) + " in section " + shown(name.first));
    }
  }
  [[nodiscard]] double number(const Value& value, std::string_view text) const {
    double result = 0.0;
    const std::string_view digits = !text.empty() && text.front() == '+' ? text.substr(1) : text;
    const auto [end, error] = roadquery::number_from_text(digits, result);
    if (digits.empty() || error != std::errc{} || end != digits.data() + digits.size() || !std::isfinite(result)) {
      fail(value.line, "needs a number, got " + shown(text));
    }
    return result;
  }

 private:
  const std::string& file_;
  std::map<std::string, int> sections_;
  std::map<std::pair<std::string, std::string>, Value> values_;
  std::set<std::string> used_sections_;
};

std::string range_text(const ValueRange& range, std::string_view unit) {
  return number_text(range.least) + " to " + number_text(range.most) + (unit == "-" ? "" : " " + std::string(unit));
}

bool inside(double value, const ValueRange& range) { return value >= range.least && value <= range.most; }

/// Reads each value of the table.
struct Reader {
  Entries& entries;

  void operator()(std::string_view section, std::string_view key, std::string_view unit, double& value,
                  const ValueRange& range) const {
    const Value& text = entries.take(section, key);
    value = entries.number(text, text.text);
    expect_inside(text, key, unit, value, range);
  }
  void operator()(std::string_view section, std::string_view key, std::string_view unit, std::vector<double>& values,
                  const ValueRange& range) const {
    const Value& text = entries.take(section, key);
    std::string_view rest = text.text;
    if (rest.size() < 2 || rest.front() != '[' || rest.back() != ']') {
      entries.fail(text.line, std::string(key) + " needs a list in one line, such as [1.0, 2.0]");
    }
    rest = rest.substr(1, rest.size() - 2);
    while (true) {
      const auto comma = rest.find(',');
      values.push_back(entries.number(text, roadquery::trimmed(rest.substr(0, comma))));
      expect_inside(text, key, unit, values.back(), range);
      if (values.size() > longest_list) entries.fail(text.line, std::string(key) + " has too many numbers");
      if (comma == std::string_view::npos) break;
      rest = rest.substr(comma + 1);
    }
  }
  void expect_inside(const Value& text, std::string_view key, std::string_view unit, double value,
                     const ValueRange& range) const {
    if (!inside(value, range)) {
      entries.fail(text.line, std::string(key) + " = " + number_text(value) + " is not in " + range_text(range, unit));
    }
  }
};

/// Checks each value of the table.
struct Checker {
  void operator()(std::string_view section, std::string_view key, std::string_view unit, double value,
                  const ValueRange& range) const {
    if (!inside(value, range)) {
      throw std::invalid_argument(std::string(section) + "." + std::string(key) + " = " + number_text(value) +
                                  " is not in " + range_text(range, unit));
    }
  }
  void operator()(std::string_view section, std::string_view key, std::string_view unit,
                  const std::vector<double>& values, const ValueRange& range) const {
    for (const double value : values) (*this)(section, key, unit, value, range);
  }
};

void require(bool holds, const char* what) {
  if (!holds) throw std::invalid_argument(what);
}

bool positive_definite(const Inertia& i) {
  const double minor = i.xx * i.yy - i.xy * i.xy;
  const double all =
      i.xx * (i.yy * i.zz - i.yz * i.yz) - i.xy * (i.xy * i.zz - i.yz * i.xz) + i.xz * (i.xy * i.yz - i.yy * i.xz);
  return i.xx > 0.0 && minor > 0.0 && all > 0.0;
}

void check_together(const CarParameters& car) {
  const Engine& e = car.engine;
  require(e.speed_rpm.size() == e.torque_nm.size() && e.speed_rpm.size() >= 2,
          "engine.speed_rpm and engine.torque_nm need the same number of values, at least 2");
  require(std::is_sorted(e.speed_rpm.begin(), e.speed_rpm.end(), std::less_equal<>()),
          "engine.speed_rpm has to rise from value to value");
  require(*std::max_element(e.torque_nm.begin(), e.torque_nm.end()) > 0.0, "engine.torque_nm is 0 everywhere");
  const Gearbox& g = car.gearbox;
  require(!g.ratios.empty() && g.ratios.size() <= 20, "gearbox.ratios needs 1 to 20 gears");
  require(std::is_sorted(g.ratios.begin(), g.ratios.end(), std::greater_equal<>()),
          "gearbox.ratios have to fall from gear to gear");
  require(e.limit_rpm > 1.5 * e.idle_rpm, "engine.limit_rpm has to be over 1.5 times engine.idle_rpm");
  require(g.launch_rpm > 1.3 * e.idle_rpm && g.launch_rpm < e.limit_rpm,
          "gearbox.launch_rpm has to lie between 1.3 times engine.idle_rpm and engine.limit_rpm");
  require(g.up_rpm < e.limit_rpm && g.up_rpm > g.down_rpm && g.up_calm_rpm > g.down_calm_rpm &&
              g.down_calm_rpm > e.idle_rpm,
          "gearbox: idle_rpm < down_calm_rpm < up_calm_rpm and down_rpm < up_rpm < limit_rpm have to hold");
  for (const bool front : {true, false}) {
    const Tyre& t = front ? car.front_tyre : car.rear_tyre;
    const Suspension& s = front ? car.front : car.rear;
    const double load_n = static_load_n(car, front);
    require(load_n / t.vertical_npm < 0.3 * t.radius_m, "a tyre is pressed in by over 0.3 of its radius at rest");
    require(load_n > 1.2 * s.unsprung_mass_kg * gravity_mps2, "unsprung_mass_kg takes nearly all load of a wheel");
  }
  const CarGeometry geometry = car_geometry(car);
  require(geometry.body.mass_kg > 0.0 && positive_definite(geometry.body.inertia),
          "body: the inertias are too small for the unsprung masses at their places");
}

}  // namespace

void check(const CarParameters& car) {
  for_each_value(car, Checker{});
  check_together(car);
}

CarParameters parse_car(std::string_view text, const std::string& file) {
  Entries entries(text, file);
  CarParameters car;
  const Value& name = entries.take("", "name");
  if (name.text.size() < 2 || name.text.front() != '"' || name.text.back() != '"') {
    entries.fail(name.line, "name needs a text in double quotes");
  }
  car.name = std::string(name.text.substr(1, name.text.size() - 2));
  for_each_value(car, Reader{entries});
  entries.expect_all_used();
  try {
    check_together(car);
  } catch (const std::invalid_argument& error) {
    entries.fail(error.what());
  }
  return car;
}

}  // namespace vehicle
