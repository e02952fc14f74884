// SPDX-License-Identifier: Apache-2.0
#pragma once
// The clear-text part of an OpenCRG file, up to the line $$$$.

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "roadquery/crg/crg.hpp"

namespace roadquery {

enum class CrgChannel { phi, slope, banking, section, other };

struct CrgHeader {
  std::string comment;
  std::map<std::string, double> road;                ///< $ROAD_CRG, keys in lower case
  std::map<std::string, double> options, modifiers;  ///< $ROAD_CRG_OPTS, $ROAD_CRG_MODS, keys in lower case
  std::vector<std::string> settings;                 ///< "$road_crg_opts border_mode_u" and so on, as they come
  std::optional<CrgFormat> format;
  std::vector<CrgChannel> channels;
  std::vector<double> section_v;  ///< of sections "at v = ..."
  std::size_t sections = 0;
  std::optional<double> virtual_u_start, virtual_u_increment;
  std::size_t lines = 0;  ///< up to and with the line $$$$
  std::size_t bytes = 0;  ///< likewise

  [[nodiscard]] bool has(const char* name) const { return road.count(name) != 0; }
  [[nodiscard]] double value(const char* name, double fallback) const;
};

/// Throws std::runtime_error "file: line 7: what".
[[nodiscard]] CrgHeader parse_crg_header(std::string_view bytes, const std::string& file);

/// "line 7: what" after the file's name, as every reader of a CRG file fails.
[[noreturn]] void fail_at_line(const std::string& file, std::size_t line, const std::string& what);
/// A whole field as a finite number.
[[nodiscard]] std::optional<double> crg_number(std::string_view text);
/// The line that begins at `at` without its end, and `at` moved behind it; nothing at the end.
[[nodiscard]] std::optional<std::string_view> next_line(std::string_view bytes, std::size_t& at);
/// The shortest text that reads back as the number.
[[nodiscard]] std::string to_text(double value);

}  // namespace roadquery
