// SPDX-License-Identifier: Apache-2.0
#include "view_files.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <set>
#include <utility>

namespace orthodrive::app {
namespace {
namespace fs = std::filesystem;

constexpr std::size_t longest_path = 1024;

std::string content_type_of(const fs::path& file) {
  static constexpr std::array<std::pair<std::string_view, std::string_view>, 15> types{{
      {".html", "text/html; charset=utf-8"},
      {".js", "text/javascript; charset=utf-8"},
      {".css", "text/css; charset=utf-8"},
      {".json", "application/json"},
      {".geojson", "application/geo+json"},
      {".csv", "text/csv; charset=utf-8"},
      {".wasm", "application/wasm"},
      {".glb", "model/gltf-binary"},
      {".gltf", "model/gltf+json"},
      {".xodr", "application/xml"},
      {".xosc", "application/xml"},
      {".png", "image/png"},
      {".jpg", "image/jpeg"},
      {".svg", "image/svg+xml"},
      {".woff2", "font/woff2"},
  }};
  const std::string extension = file.extension().string();
  const auto* found =
      std::find_if(types.begin(), types.end(), [&](const auto& type) { return type.first == extension; });
  return found == types.end() ? "application/octet-stream" : std::string(found->second);
}

/// A relative path as it stands in an address: names between single slashes, none of which begins with a dot.
bool is_plain(std::string_view path) {
  if (path.empty() || path.size() > longest_path) return false;
  if (path.find('\0') != std::string_view::npos || path.find('\\') != std::string_view::npos) return false;
  for (std::size_t begin = 0; begin <= path.size();) {
    const std::size_t end = std::min(path.find('/', begin), path.size());
    if (end == begin || path[begin] == '.') return false;
    begin = end + 1;
  }
  return true;
}

enum class Rule { always, laps, never };

/// Of a file of the site.
Rule rule_of(std::string_view path) {
  static const std::set<std::string_view> named{"run.json",   "findings.geojson", "road_graph.geojson",
                                                "roads.xodr", "drive/lap.csv",    "drive/lap.xosc"};
  static const std::set<std::string> of_scene{".json", ".glb", ".gltf", ".png", ".jpg"};
  const std::string extension = fs::path(path).extension().string();
  if (named.count(path) != 0) return Rule::always;
  if (path.substr(0, 6) == "scene/" && of_scene.count(extension) != 0) return Rule::always;
  return extension == ".csv" ? Rule::laps : Rule::never;
}

/// The columns that every lap has stand in the first line.
bool is_lap(int descriptor) {
  std::array<char, 4096> head;
  const ssize_t count = pread(descriptor, head.data(), head.size(), 0);
  if (count <= 0) return false;
  std::string_view line(head.data(), static_cast<std::size_t>(count));
  line = line.substr(0, line.find_first_of("\r\n"));
  const std::string columns = fmt::format(",{},", line);
  return columns.find(",t_s,") != std::string::npos && columns.find(",x_m,") != std::string::npos &&
         columns.find(",y_m,") != std::string::npos;
}

/// Where an open file really is, relative to a folder without links. Empty: outside.
std::string place_below(const fs::path& folder, int descriptor) {
  std::error_code error;
  const std::string real = fs::read_symlink(fmt::format("/proc/self/fd/{}", descriptor), error).string();
  const std::string above = folder.string() == "/" ? "/" : folder.string() + "/";
  return error || real.compare(0, above.size(), above) != 0 ? "" : real.substr(above.size());
}

}  // namespace

ViewFiles::ViewFiles(const fs::path& site, const fs::path& viewer)
    : site_(fs::canonical(site)), viewer_(fs::canonical(viewer)) {}

std::optional<ServedFile> ViewFiles::open(std::string_view path) const {
  constexpr std::string_view of_site = "/site/";
  const bool of_viewer = path.substr(0, of_site.size()) != of_site;
  if (path == "/") path = "/index.html";
  const std::string_view wanted = path.substr(std::min(path.size(), of_viewer ? 1 : of_site.size()));
  if (path.substr(0, 1) != "/" || !is_plain(wanted) || (!of_viewer && rule_of(wanted) == Rule::never)) return {};

  const fs::path& folder = of_viewer ? viewer_ : site_;
  // A pipe would keep us waiting.
  const int opened = ::open((folder / wanted).c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
  if (opened < 0) return {};
  ServedFile file;
  file.descriptor = std::shared_ptr<const int>(new int(opened), [](const int* descriptor) {
    close(*descriptor);
    delete descriptor;
  });
  struct stat status {};
  if (fstat(opened, &status) != 0 || !S_ISREG(status.st_mode)) return {};
  // The name may lead elsewhere by a link: what counts is where the open file is.
  const std::string place = place_below(folder, opened);
  if (!is_plain(place)) return {};
  if (!of_viewer) {
    const Rule rule = rule_of(place);
    if (rule == Rule::never || (rule == Rule::laps && !is_lap(opened))) return {};
  }
  file.size = static_cast<std::size_t>(status.st_size);
  file.content_type = content_type_of(wanted);
  file.of_viewer = of_viewer;
  return file;
}

}  // namespace orthodrive::app
