// SPDX-License-Identifier: Apache-2.0
#pragma once
// OSM as text: XML (API 0.6, JOSM, Overpass) and the JSON of Overpass. libosmium's own parser refuses what editors and
// servers add to the format: odd user names and numbers, <center>, a missing version; and it knows no deleted objects
// of JOSM. https://wiki.openstreetmap.org/wiki/JOSM_file_format, .../wiki/Overpass_API/Overpass_QL#Output_Format

#include <cstdint>
#include <filesystem>
#include <functional>
#include <osmium/memory/buffer.hpp>
#include <osmium/osm/entity_bits.hpp>

namespace orthodrive::io {

enum class OsmSyntax : std::uint8_t { binary, xml, json };  ///< binary: whatever libosmium knows

/// What the first bytes of a file look like, packed (gzip, bzip2) or not; its name counts where they tell nothing.
[[nodiscard]] OsmSyntax osm_syntax(const std::filesystem::path& path);

using UseOsmBuffer = std::function<void(osmium::memory::Buffer&)>;

/// Objects of a file in text, in its order. Deleted ones (action="delete", visible="false") are not there. Nodes of
/// ways have places where the file puts them there (`out geom`); ways that only members of relations draw come last.
/// Who edited when is not read. Throws InputError for files of changes, for results that Overpass did not finish and
/// for other formats, with what to do; osmium::io_error for text that is no XML.
void read_osm_text(const std::filesystem::path& path, OsmSyntax syntax, osmium::osm_entity_bits::type entities,
                   const UseOsmBuffer& use);

}  // namespace orthodrive::io
