// SPDX-License-Identifier: Apache-2.0
#pragma once
// The indices that say where sheets lie. Each yields the sheets that touch the area, in its own order. Internal to
// remote. They throw InputError with one line: for what is no such index, a link that is not http(s), and more pages,
// feeds or sheets than are read.

#include <set>
#include <string>
#include <vector>

#include "orthodrive/remote/fetch_kinds.hpp"
#include "orthodrive/remote/http/link_address.hpp"
#include "orthodrive/remote/sheets/sheet_choice.hpp"

namespace orthodrive::remote {

/// A search of a STAC API, page by page: GET, and POST where the server wants that. The url is that of the API, of its
/// /search, of a collection or of its /items.
[[nodiscard]] std::vector<Sheet> stac_sheets(const FetchJob& job, const SheetArea& area);
/// A feed and those that it leads to, four levels at most.
[[nodiscard]] std::vector<Sheet> atom_sheets(const FetchJob& job, const SheetArea& area);
/// A vector file, here or on a server; one of a server lies in `folder` until the end.
[[nodiscard]] std::vector<Sheet> indexed_sheets(const FetchJob& job, const SheetArea& area,
                                                const std::filesystem::path& folder);

/// The address of a sheet with the table's keys. Throws InputError (of `page`, keys hidden) for what is not http(s).
[[nodiscard]] std::string sheet_address(const FetchJob& job, const LinkKeys& keys, const std::string& page,
                                        const std::string& link);
/// Adds it. Throws InputError beyond what a choice can be made of: 10 times most_sheets.
void add_sheet(std::vector<Sheet>& sheets, Sheet sheet, const std::string& shown);

}  // namespace orthodrive::remote
