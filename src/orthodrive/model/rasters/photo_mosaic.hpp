// SPDX-License-Identifier: Apache-2.0
#pragma once
// Several photos as one, best first. Where the first shows nothing the next one is seen, and so on; seams are hidden.
//
// Each photo fades into those below it inside its own rim (feathering: weights by the distance to the rim, Szeliski,
// Image Alignment and Stitching, 2006, sec. 6.2). Before that it takes the colours of those above it: gain and offset
// of each channel bring mean and deviation of the overlap to theirs (Reinhard et al., Color Transfer between Images,
// 2001, in RGB); near the overlap the difference that is left is added, smoothed by normalised convolution (Knutsson
// and Westin, 1993), which goes to zero away from the overlap. We take no multiband blending (Burt and Adelson, 1983):
// it would mix textures of different years over wide strips.
//
// All of that is estimated once, on overviews of the photos on a fixed grid, so that a pixel is the same in every
// window.

#include <span>
#include <vector>

#include "orthodrive/model/rasters/photo_source.hpp"

namespace orthodrive {

/// The grid of the overviews: the mosaic's box and a margin in cells of 4 m, or in larger ones, so that none is finer
/// than a photo, and all photos together have no more than about two million cells.
[[nodiscard]] GridFrame mosaic_overview_frame(const GridFrame& mosaic, std::span<const double> photo_gsds_m);

struct MosaicPhoto {
  PhotoSource photo;  ///< on the grid of the mosaic
  Photo overview;     ///< on mosaic_overview_frame(), not cut at the area: its rim is the photo's own
};

/// Best first, at least one. Where one photo alone has data, and where the first has full weight, pixels are those of
/// the photo; photos below it are not read there. Reading takes little more memory than reading one photo.
[[nodiscard]] PhotoSource mosaic_of(std::vector<MosaicPhoto> photos);

}  // namespace orthodrive
