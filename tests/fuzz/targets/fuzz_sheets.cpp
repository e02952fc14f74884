// SPDX-License-Identifier: Apache-2.0
// What STAC searches and Atom feeds answer, and the addresses in them. JSON or XML: what comes first decides.

#include <stdexcept>

#include "memory_file.hpp"
#include "orthodrive/remote/http/link_address.hpp"
#include "orthodrive/remote/sheets/atom_feed.hpp"
#include "orthodrive/remote/sheets/stac_items.hpp"

namespace {
using namespace orthodrive;

void check_footprint(const MultiPolygon& footprint) {
  for (const Polygon& polygon : footprint)
    for (const Vec2 p : polygon.outer)
      if (!(p.x >= -360.0 && p.x <= 360.0 && p.y >= -90.0 && p.y <= 90.0)) std::abort();
}

void check_address(const std::string& link) {
  const std::string address = remote::absolute_address("https://me:pw@a.b/c?d=1", link);
  if (!address.empty() && !address.starts_with("http://") && !address.starts_with("https://")) std::abort();
  (void)remote::names_sheet(link);
}

void read_stac(std::string_view text) {
  const remote::StacPage page = remote::parse_stac_page(text, "a");
  if (page.next) (void)remote::merged_json("{}", page.next->body);
  for (const remote::StacItem& item : page.items) {
    check_footprint(item.footprint);
    for (const remote::StacAsset& asset : item.assets) check_address(asset.href);
    (void)remote::chosen_asset(item, "", "a");
  }
}

void read_atom(std::string_view text) {
  const remote::AtomFeed feed = remote::parse_atom_feed(text, "a");
  check_footprint(feed.footprint);
  for (const remote::AtomEntry& entry : feed.entries) {
    check_footprint(entry.footprint);
    for (const remote::AtomLink& link : entry.links) {
      check_address(link.href);
      if (const auto box = remote::box_of_link(link, entry.footprint)) check_footprint({*box});
      (void)(remote::leads_to_sheet(link) || remote::leads_to_feed(link));
    }
  }
}
}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);  // NOLINT: bytes are characters
  const bool json = text.find('{') < text.find('<');
  try {
    json ? read_stac(text) : read_atom(text);
  } catch (const std::runtime_error& error) {
    fuzz::expect_one_line(error.what());
  }
  return 0;
}
