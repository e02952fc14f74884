// SPDX-License-Identifier: Apache-2.0
// An index of sheets as a vector file: a footprint and an address each.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <map>

#include "orthodrive/core/closest_word.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/core/printable.hpp"
#include "orthodrive/io/vector/sheet_index_reader.hpp"
#include "orthodrive/remote/http/url_template.hpp"
#include "orthodrive/remote/sheet_indices.hpp"

namespace orthodrive::remote {
namespace {
namespace fs = std::filesystem;
constexpr std::int64_t most_index_bytes = std::int64_t{2} << 30;

/// "2021-05-03" of a text that begins so, with - or /; empty for another.
std::string date_in(const std::string& text) {
  if (text.size() < 10) return {};
  for (std::size_t i = 0; i < 10; ++i)
    if (i == 4 || i == 7 ? text[i] != '-' && text[i] != '/' : !std::isdigit(static_cast<unsigned char>(text[i])))
      return {};
  return text.substr(0, 4) + "-" + text.substr(5, 2) + "-" + text.substr(8, 2);
}

/// A value in a pattern may be a path.
std::string encoded_path(const std::string& value) {
  std::string result;
  for (const char c : value) result += c == '/' ? "/" : percent_encoded({&c, 1});
  return result;
}

class SheetIndex {
 public:
  SheetIndex(const FetchJob& job, const SheetArea& area, std::string url)
      : job_(job),
        area_(area),
        url_(is_http(url) ? std::move(url) : std::string()),
        shown_(job.secrets.hide(job.source.url)),
        keys_(job.source.url, url_),
        property_(job.source.layer) {}

  std::vector<Sheet> read(const fs::path& file) {
    io::visit_sheet_index(file, shown_, area_.box(), [&](io::IndexedSheet&& sheet) { take(std::move(sheet)); });
    if (sheets_.empty() && without_address_ > 0) throw InputError(shown_, no_address());
    return std::move(sheets_);
  }

 private:
  void take(io::IndexedSheet&& sheet) {
    if (!area_.touches(sheet.footprint)) return;
    const std::string address = address_of(sheet);
    if (address.empty()) {
      ++without_address_;
      for (const auto& [name, value] : sheet.attributes)
        if (names_.size() < 100) names_.insert(printable(name).substr(0, 40));
      return;
    }
    std::string date;
    for (const auto& [name, value] : sheet.attributes) date = std::max(date, date_in(value));
    if (url_.empty() && !is_http(address))
      throw InputError(shown_, fmt::format("'{}' is no address of http or https, and a file of this machine is no page "
                                           "that it could be relative to; give the index by its url",
                                           printable(address).substr(0, 80)));
    add_sheet(sheets_, {sheet_address(job_, keys_, url_, address), std::move(sheet.footprint), "", "", date, 0},
              shown_);
  }

  /// `layer` with {names} is a pattern of addresses, else it is the property that holds them.
  std::string address_of(const io::IndexedSheet& sheet) {
    if (!names_in(property_).empty()) {
      std::map<std::string, std::string> values;
      for (const auto& [name, value] : sheet.attributes) values.emplace(name, encoded_path(value));
      const std::string address = filled(job_.secrets.resolve(property_), values);
      return names_in(address).empty() ? address : std::string();
    }
    for (const auto& [name, value] : sheet.attributes) {
      if (property_.empty() && (is_http(value) || value.find('/') != std::string::npos) && names_sheet(value))
        property_ = name;  // of all sheets from now on
      if (!property_.empty() && name == property_) return value;
    }
    return {};
  }

  [[nodiscard]] std::string no_address() const {
    const std::vector<std::string> names(names_.begin(), names_.end());
    if (job_.source.layer.empty())
      return fmt::format("no property of its sheets is the address of a file; say which with layer, there are: {}",
                         fmt::join(names, ", "));
    return fmt::format("its sheets of the area have no '{}'{}", job_.source.layer,
                       suggestion(job_.source.layer, names));
  }

  const FetchJob& job_;
  const SheetArea& area_;
  std::string url_, shown_;
  LinkKeys keys_;
  std::string property_;
  std::vector<Sheet> sheets_;
  std::set<std::string> names_;
  std::size_t without_address_ = 0;
};
}  // namespace

std::string sheet_address(const FetchJob& job, const LinkKeys& keys, const std::string& page, const std::string& link) {
  const std::string address = absolute_address(page, link);
  if (address.empty())
    throw InputError(job.secrets.hide(page), fmt::format("a sheet of the area is '{}', which is no address of http or "
                                                         "https",
                                                         printable(job.secrets.hide(link)).substr(0, 80)));
  return keys.with(address);
}

void add_sheet(std::vector<Sheet>& sheets, Sheet sheet, const std::string& shown) {
  constexpr std::size_t most = 10 * most_sheets;
  if (sheets.size() >= most)
    throw InputError(shown, fmt::format("more than {} files touch the area; take a smaller area", most));
  sheets.push_back(std::move(sheet));
}

std::vector<Sheet> indexed_sheets(const FetchJob& job, const SheetArea& area, const fs::path& folder) {
  const std::string url = job.secrets.resolve(job.source.url);
  if (!is_http(url)) {
    const fs::path file = (job.source.folder / url).lexically_normal();
    if (!fs::is_regular_file(file)) throw InputError(job.source.url, "no such file; it is the index of the sheets");
    return SheetIndex(job, area, url).read(file);
  }
  const fs::path file = folder / store_name(job.secrets.hide(url), "index.geojson");
  (void)job.client.download(url, file, true, most_index_bytes);
  std::vector<Sheet> sheets = SheetIndex(job, area, url).read(file);
  if (job.options.dry_run) {  // nothing stays
    std::error_code ignored;
    fs::path version = file;
    version += ".json";
    fs::remove(file, ignored), fs::remove(version, ignored);
  }
  return sheets;
}

}  // namespace orthodrive::remote
