// SPDX-License-Identifier: Apache-2.0
#pragma once
// The four kinds of services that hand out tiles, as a grid and the address of each tile. Internal to remote.

#include <functional>
#include <map>
#include <string>

#include "orthodrive/model/site_frame.hpp"
#include "orthodrive/remote/http/http_client.hpp"
#include "orthodrive/remote/http/secrets.hpp"
#include "orthodrive/remote/source/fetch_source.hpp"
#include "orthodrive/remote/tiles/capabilities.hpp"
#include "orthodrive/remote/tiles/tile_matrix.hpp"

namespace orthodrive::remote {

struct Service {
  TileMatrixSet set;                         ///< one matrix at least
  std::map<std::string, TileLimits> limits;  ///< by matrix; none: all of it
  std::function<std::string(const TileMatrix&, TileAddress)> url_of;
  std::string format;
  std::string identity;  ///< without keys
};

/// Web mercator's quad behind a template with {z} {x} {y}, of tms with rows from the south.
[[nodiscard]] Service template_service(const FetchSource& source, Secrets& secrets);
/// The layer in the matrix set that suits best: the one asked for, web mercator's quad, UTM, any other that is known.
[[nodiscard]] Service wmts_service(const FetchSource& source, const SiteFrame& site, HttpClient& client,
                                   Secrets& secrets);
/// Web mercator's quad where the server knows it, else a grid of 512 pixels a tile in the site's CRS.
[[nodiscard]] Service wms_service(const FetchSource& source, const SiteFrame& site, double resolution_m,
                                  HttpClient& client, Secrets& secrets);

/// The choice among a layer's matrix sets without asking anybody: for wmts_service and tests. Throws InputError.
[[nodiscard]] TileMatrixSet choose_matrix_set(const WmtsCapabilities& capabilities, const WmtsLayer& layer,
                                              const std::string& wanted, const SiteFrame& site,
                                              const std::string& name);
/// Throws InputError that names the layers there are, closest first.
[[nodiscard]] const WmtsLayer& find_layer(const WmtsCapabilities& capabilities, const std::string& wanted,
                                          const std::string& name);

}  // namespace orthodrive::remote
