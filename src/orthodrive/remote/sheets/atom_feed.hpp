// SPDX-License-Identifier: Apache-2.0
#pragma once
// Atom feeds (RFC 4287) with places (GeoRSS simple and GML), as INSPIRE download services hand out datasets (Technical
// Guidance for INSPIRE Download Services, chapter 5). Nothing is looked up, so that any bytes may be given.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "orthodrive/geo/polygon.hpp"

namespace orthodrive::remote {

struct AtomLink {
  std::string href, rel, type, title;         ///< rel is "alternate" where the feed says nothing
  std::optional<std::array<double, 4>> bbox;  ///< degrees in the order of the feed, which differs: see box_of_link
  std::int64_t bytes = 0;                     ///< 0: not said
};

struct AtomEntry {
  std::string title, id, updated;
  std::string code;        ///< spatial_dataset_identifier_code of INSPIRE
  std::string crs;         ///< "EPSG:n" of a category; empty: not said
  MultiPolygon footprint;  ///< degrees; empty: not said
  std::vector<AtomLink> links;
};

struct AtomFeed {
  std::string title;
  MultiPolygon footprint;
  std::vector<AtomLink> links;  ///< of the feed itself
  std::vector<AtomEntry> entries;
};

/// Documents of up to 64 MB, 200 000 entries and 500 000 links; entities of a DTD are not expanded. Throws InputError
/// that begins with `name` (an address) for what is no feed: a page of HTML, an exception of a service (with its
/// text), truncated XML.
[[nodiscard]] AtomFeed parse_atom_feed(std::string_view xml, const std::string& name);

/// A file with a raster, or an archive that may hold one.
[[nodiscard]] bool leads_to_sheet(const AtomLink& link);
/// Another feed that describes what the entry offers.
[[nodiscard]] bool leads_to_feed(const AtomLink& link);

/// The bbox of a link. Providers write west, south, east, north or south, west, north, east; what meets `around` (the
/// place of the entry or the feed; empty: not known) is what is meant, the first of both otherwise.
[[nodiscard]] std::optional<Polygon> box_of_link(const AtomLink& link, const MultiPolygon& around);

}  // namespace orthodrive::remote
