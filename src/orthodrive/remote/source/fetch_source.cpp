// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/remote/source/fetch_source.hpp"

#include <fmt/format.h>

#include <array>
#include <utility>

#include "orthodrive/core/error.hpp"

namespace orthodrive::remote {
namespace {
constexpr std::array<std::pair<FetchKind, const char*>, 11> kinds = {{{FetchKind::wmts, "wmts"},
                                                                      {FetchKind::xyz, "xyz"},
                                                                      {FetchKind::tms, "tms"},
                                                                      {FetchKind::wms, "wms"},
                                                                      {FetchKind::cog, "cog"},
                                                                      {FetchKind::overpass, "overpass"},
                                                                      {FetchKind::osm_extract, "osm_extract"},
                                                                      {FetchKind::raster, "raster"},
                                                                      {FetchKind::stac, "stac"},
                                                                      {FetchKind::atom, "atom"},
                                                                      {FetchKind::sheets, "sheets"}}};
}  // namespace

FetchKind fetch_kind_of(const std::string& name) {
  std::string known;
  for (const auto& [kind, text] : kinds) {
    if (name == text) return kind;
    known += (known.empty() ? "" : ", ") + std::string(text);
  }
  throw OptionError(fmt::format("unknown kind '{}', expected one of: {}", name, known));
}

const char* name_of(FetchKind kind) {
  for (const auto& [known, text] : kinds)
    if (known == kind) return text;
  return "";
}

bool is_tiled(FetchKind kind) {
  return kind == FetchKind::wmts || kind == FetchKind::xyz || kind == FetchKind::tms || kind == FetchKind::wms;
}

bool is_in_sheets(FetchKind kind) {
  return kind == FetchKind::stac || kind == FetchKind::atom || kind == FetchKind::sheets;
}

bool is_raster(FetchKind kind) { return kind == FetchKind::raster || kind == FetchKind::cog || is_in_sheets(kind); }

}  // namespace orthodrive::remote
