// SPDX-License-Identifier: Apache-2.0
#include "roadquery/query/terrain_grid.hpp"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <map>
#include <sstream>
#include <stdexcept>

#include "roadquery/text/text.hpp"

namespace roadquery {
namespace {

constexpr double most_terrain_cells = 1e9, farthest_corner_m = 1e8;

/// Words of a file, with the line that the last one is on.
class Words {
 public:
  Words(std::string path, std::string text) : path_(std::move(path)), text_(std::move(text)) {}
  /// Empty at the end of the file.
  std::string_view next() {
    while (at_ < text_.size() && is_blank(text_[at_])) line_ += text_[at_++] == '\n';
    const std::size_t begin = at_;
    while (at_ < text_.size() && !is_blank(text_[at_])) ++at_;
    return std::string_view(text_).substr(begin, at_ - begin);
  }
  double number(std::string_view word, const char* what) const {
    double value = 0.0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size())
      fail(std::string(what) + (word.empty() ? " is missing" : " is not a number: " + std::string(word.substr(0, 40))));
    return value;
  }
  [[noreturn]] void fail(const std::string& what) const {
    throw std::runtime_error(path_ + ": line " + std::to_string(line_) + ": " + what);
  }
  [[nodiscard]] std::size_t size() const { return text_.size(); }

 private:
  static bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }
  std::string path_, text_;
  std::size_t at_ = 0, line_ = 1;
};

std::string read_file(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw std::runtime_error(path + ": cannot be opened: " + std::strerror(errno));
  std::ostringstream text;
  text << in.rdbuf();
  if (in.bad() || text.fail()) throw std::runtime_error(path + ": cannot be read, or is empty");
  return std::move(text).str();
}

/// The words of the header by their lower-case names; `word` becomes the first one after it.
std::map<std::string, double> read_header(Words& words, std::string_view& word) {
  std::map<std::string, double> header;
  for (word = words.next(); !word.empty() && std::isalpha(static_cast<unsigned char>(word[0])) != 0 && word != "nan";
       word = words.next()) {
    const std::string name = lowered(word.substr(0, 40));
    const double value = words.number(words.next(), name.c_str());
    if (!std::isfinite(value) && name != "nodata_value") words.fail(name + " is not finite");
    if (!header.emplace(name, value).second) words.fail(name + " stands twice");
  }
  for (const auto& [name, value] : header)
    if (name != "ncols" && name != "nrows" && name != "cellsize" && name != "nodata_value" &&
        name.substr(0, 3) != "xll" && name.substr(0, 3) != "yll")
      words.fail(name + " is not known; an ESRI ASCII grid with square cells is expected");
  return header;
}

/// Coordinate of the first height's centre.
double first_centre(const Words& words, const std::map<std::string, double>& header, const std::string& axis,
                    double spacing_m) {
  const auto corner = header.find(axis + "llcorner"), centre = header.find(axis + "llcenter");
  if (corner == header.end() && centre == header.end()) words.fail(axis + "llcorner is missing");
  return centre != header.end() ? centre->second : corner->second + 0.5 * spacing_m;
}

TerrainGrid grid_of(const Words& words, const std::map<std::string, double>& header) {
  const auto value = [&](const char* name) {
    const auto found = header.find(name);
    if (found == header.end()) words.fail(std::string(name) + " is missing");
    return found->second;
  };
  const double columns = value("ncols"), rows = value("nrows"), spacing_m = value("cellsize");
  if (!(columns >= 1.0 && rows >= 1.0 && columns * rows <= most_terrain_cells) || columns != std::floor(columns) ||
      rows != std::floor(rows))
    words.fail("ncols and nrows must be whole numbers from 1, their product at most a thousand million");
  if (!(spacing_m > 0.0)) words.fail("cellsize must be positive");
  TerrainGrid grid{first_centre(words, header, "x", spacing_m),
                   first_centre(words, header, "y", spacing_m),
                   spacing_m,
                   static_cast<int>(columns),
                   static_cast<int>(rows),
                   {}};
  if (!(std::abs(grid.west) + columns * spacing_m <= farthest_corner_m &&
        std::abs(grid.south) + rows * spacing_m <= farthest_corner_m))
    words.fail("the grid leaves the area where a CRS has coordinates");
  // Each height takes a digit and a blank at least: a header alone cannot ask for memory.
  if (columns * rows > 0.5 * static_cast<double>(words.size()) + 1.0)
    words.fail("the file is too short for ncols x nrows heights");
  return grid;
}

}  // namespace

TerrainGrid read_terrain_grid(const std::string& path) {
  Words words(path, read_file(path));
  std::string_view word;
  const std::map<std::string, double> header = read_header(words, word);
  TerrainGrid grid = grid_of(words, header);
  const auto nodata = header.find("nodata_value");
  const std::size_t columns = static_cast<std::size_t>(grid.columns), rows = static_cast<std::size_t>(grid.rows);
  grid.z.resize(columns * rows);
  for (std::size_t row = rows; row-- > 0;)
    for (std::size_t column = 0; column < columns; ++column, word = words.next()) {
      const double z = words.number(word, "a height");
      const bool known = std::isfinite(z) && (nodata == header.end() || z != nodata->second);
      grid.z[row * columns + column] = known ? static_cast<float>(z) : std::numeric_limits<float>::quiet_NaN();
    }
  if (!word.empty()) words.fail("more heights than ncols x nrows");
  return grid;
}

std::optional<TerrainPoint> evaluate(const TerrainGrid& grid, double x, double y) {
  const double u = (x - grid.west) / grid.spacing_m, v = (y - grid.south) / grid.spacing_m;
  if (!(u >= -0.5 && u <= grid.columns - 0.5 && v >= -0.5 && v <= grid.rows - 0.5)) return std::nullopt;
  // Cell between four heights; in the outer half cells both sides are the same height.
  const double u0 = std::floor(u), v0 = std::floor(v);
  const auto clamped = [](double k, int count) { return static_cast<std::size_t>(std::clamp(k, 0.0, count - 1.0)); };
  const std::size_t c0 = clamped(u0, grid.columns), c1 = clamped(u0 + 1.0, grid.columns);
  const std::size_t r0 = clamped(v0, grid.rows), r1 = clamped(v0 + 1.0, grid.rows);
  const auto at = [&](std::size_t column, std::size_t row) {
    return static_cast<double>(grid.z[row * static_cast<std::size_t>(grid.columns) + column]);
  };
  const double z00 = at(c0, r0), z10 = at(c1, r0), z01 = at(c0, r1), z11 = at(c1, r1);
  const double a = u - u0, b = v - v0;
  const double south = z00 + a * (z10 - z00), north = z01 + a * (z11 - z01);
  const TerrainPoint point{south + b * (north - south), ((1.0 - b) * (z10 - z00) + b * (z11 - z01)) / grid.spacing_m,
                           (north - south) / grid.spacing_m};
  if (std::isnan(point.z)) return std::nullopt;
  return point;
}

}  // namespace roadquery
