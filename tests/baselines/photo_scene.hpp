// SPDX-License-Identifier: Apache-2.0
#pragma once
// Photos of exact little scenes: every class its colour, with noise of its own roughness.

#include "orthodrive/baselines/mrf_evidence.hpp"
#include "orthodrive/baselines/road_forest.hpp"
#include "orthodrive/core/random.hpp"
#include "refine/road_scene.hpp"

namespace orthodrive::test {

inline Photo paint_photo(const LabelMap& labels, std::uint64_t seed) {
  Photo photo{labels.crs, labels.frame, Raster<std::uint8_t>(labels.frame.width, labels.frame.height, 3),
              Raster<std::uint8_t>(labels.frame.width, labels.frame.height, 1, 1)};
  Random random(seed);
  for (int y = 0; y < labels.frame.height; ++y)
    for (int x = 0; x < labels.frame.width; ++x) {
      const std::uint8_t label = labels.labels.at(x, y);
      const bool road = label == label_road, trees = label == label_vegetation;
      const int color[3] = {road ? 120 : trees ? 45 : 105, road ? 120 : trees ? 75 : 125, road ? 122 : trees ? 40 : 80};
      const double noise = (road ? 4.0 : trees ? 18.0 : 9.0) * random.normal();
      for (int k = 0; k < 3; ++k)
        photo.rgb.at(x, y, k) =
            static_cast<std::uint8_t>(std::clamp(color[k] + noise + 2.0 * random.normal(), 0.0, 255.0));
    }
  return photo;
}

inline RoadForestSample sample_of(const LabelMap& labels, const Photo& photo) {
  RoadForestSample sample{photo.rgb, photo.frame.gsd_m, Raster<std::uint8_t>(labels.frame.width, labels.frame.height),
                          photo.valid};
  for (std::size_t i = 0; i < sample.mask.data.size(); ++i)
    sample.mask.data[i] =
        static_cast<std::uint8_t>(labels.labels.data[i] == label_road ? RoadMask::road : RoadMask::context);
  return sample;
}

/// A curved road, trees and grass, at a ground sampling distance that keeps tests fast.
inline RoadScene make_photo_scene(double size_m, double gsd_m = 0.4) {
  RoadScene scene = make_scene(size_m, gsd_m);
  for (int k = 0; k < 12; ++k)
    paint_disc(scene.labels, at(size_m * (0.08 + 0.075 * k), size_m * (k % 2 == 0 ? 0.2 : 0.85)), 8.0,
               label_vegetation);
  add_truth(scene,
            trace(size_m - 20.0, [&](double s) { return at(10.0 + s, 0.5 * size_m + 12.0 * std::sin(s / 40.0)); }),
            7.0);
  return scene;
}

/// Evidence that is never wrong: road is road, and edges are where the road ends. nodata is not valid.
inline MrfEvidenceSource exact_evidence(const LabelMap& labels) {
  const int reach = static_cast<int>(2.0 / labels.frame.gsd_m);
  return {labels.crs, labels.frame, 2.0, [&labels, reach](const PixelBox& box) {
            const auto raster = [&] { return Raster<std::uint8_t>(box.width, box.height); };
            MrfEvidence evidence{raster(), raster(), raster(), raster()};
            const auto road_at = [&](int col, int row) {
              return labels.labels.inside(col, row) && labels.labels.at(col, row) == label_road;
            };
            for (int y = 0; y < box.height; ++y)
              for (int x = 0; x < box.width; ++x) {
                const int col = static_cast<int>(box.col) + x, row = static_cast<int>(box.row) + y;
                if (!labels.labels.inside(col, row) || labels.labels.at(col, row) == label_nodata) continue;
                const bool road = road_at(col, row);
                double nearest = reach;
                for (int v = -reach; v <= reach; ++v)
                  for (int u = -reach; u <= reach; ++u)
                    if (road_at(col + u, row + v) != road) nearest = std::min(nearest, std::hypot(u, v) - 0.5);
                evidence.valid.at(x, y) = 1;
                evidence.non_road.at(x, y) = road ? 0 : 255;
                evidence.road_beside.at(x, y) = road ? 255 : 0;
                evidence.edge_distance.at(x, y) = static_cast<std::uint8_t>(255.0 * nearest / reach);
              }
            return evidence;
          }};
}

}  // namespace orthodrive::test
