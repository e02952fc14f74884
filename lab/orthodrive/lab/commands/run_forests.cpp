// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/lab/commands/run_forests.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "orthodrive/core/atomic_file.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/io/raster/raster_io.hpp"
#include "orthodrive/io/support/vector_io.hpp"
#include "orthodrive/lab/training/parts.hpp"

namespace orthodrive {
namespace fs = std::filesystem;

namespace {
RoadForestSample sample_of(Photo photo, Raster<std::uint8_t> mask) {
  return {std::move(photo.rgb), photo.frame.gsd_m, std::move(mask), std::move(photo.valid)};
}

/// The photo at its own scale where the map has labels.
RoadForestSample read_label_map(const fs::path& photo_file, const fs::path& label_file, int threads) {
  const LabelMap labels = io::read_labels(label_file);
  Photo photo = io::read_photo(photo_file, {labels.crs, polygon_of(labels.frame.bounds())}, {.threads = threads});
  Raster<std::uint8_t> mask = forests_part().road_mask(labels, photo.frame);
  return sample_of(std::move(photo), std::move(mask));
}

RoadMask painted_mask(const io::Feature& feature, const fs::path& file) {
  const auto tag = feature.tags.find("class");
  if (tag == feature.tags.end()) throw InputError(file.string(), "a feature has no 'class'");
  if (tag->second == "unknown") return RoadMask::unknown;
  const auto& classes = default_class_table().classes;
  const auto known = std::ranges::find(classes, tag->second, &ClassInfo::name);
  if (known == classes.end())
    throw InputError(file.string(), fmt::format("class '{}' is none of {}", tag->second, default_class_table().name));
  return forests_part().road_mask_of(known->role);
}

/// One sample a painted piece, with a little of the photo around it. Later polygons cover earlier ones.
std::vector<RoadForestSample> read_painted(const fs::path& photo_file, const fs::path& polygon_file, int threads) {
  constexpr double surroundings_m = 10.0;  // what superpixels at the border of a piece look at
  const Crs crs = site_of_photos({photo_file}).crs;
  std::map<std::string, std::vector<io::Feature>> pieces;
  for (io::Feature& feature : io::read_features(polygon_file, crs))
    if (!feature.polygons.empty()) pieces[feature.tags["piece"]].push_back(std::move(feature));
  if (pieces.empty()) throw InputError(polygon_file.string(), "has no polygons");
  std::vector<RoadForestSample> samples;
  for (const auto& [piece, features] : pieces) {
    std::vector<Vec2> corners;
    for (const io::Feature& feature : features)
      for (const Polygon& polygon : feature.polygons)
        corners.insert(corners.end(), polygon.outer.begin(), polygon.outer.end());
    Box2 box = bounds_of(corners);
    box = {box.min_x - surroundings_m, box.min_y - surroundings_m, box.max_x + surroundings_m,
           box.max_y + surroundings_m};
    Photo photo = io::read_photo(photo_file, {crs, polygon_of(box)}, {.threads = threads});
    Raster<std::uint8_t> mask(photo.frame.width, photo.frame.height);
    for (const io::Feature& feature : features)
      for (const Polygon& polygon : feature.polygons)
        fill_polygon(mask, photo.frame, polygon, static_cast<std::uint8_t>(painted_mask(feature, polygon_file)));
    samples.push_back(sample_of(std::move(photo), std::move(mask)));
  }
  return samples;
}

bool is_painted(const fs::path& labels) {
  return labels.extension() == ".geojson" || labels.extension() == ".json" || labels.extension() == ".gpkg";
}

std::vector<RoadForestSample> read_samples(const ForestsFiles& files, const StageContext& context) {
  std::vector<RoadForestSample> samples;
  for (std::size_t i = 0; i < files.photos.size(); ++i) {
    if (is_painted(files.labels[i]))
      for (RoadForestSample& sample : read_painted(files.photos[i], files.labels[i], context.threads))
        samples.push_back(std::move(sample));
    else
      samples.push_back(read_label_map(files.photos[i], files.labels[i], context.threads));
    if (context.monitor)
      context.monitor->progress(static_cast<double>(i + 1) / static_cast<double>(files.photos.size()), "read");
  }
  return samples;
}
}  // namespace

StageOutcome run_forests(const ForestsFiles& files, const RoadForestOptions& options, StageContext& context) {
  if (files.photos.size() != files.labels.size())
    throw OptionError(fmt::format("forests: {} photos but {} labels, give one --labels for each --photo",
                                  files.photos.size(), files.labels.size()));
  const ForestsPart& part = forests_part();  // missing: said before anything is read
  const std::vector<RoadForestSample> samples = read_samples(files, context);
  RoadForestOptions training = options;
  training.threads = context.threads;
  const std::string text = part.save_road_forests(part.train_road_forests(samples, training));
  write_text_file(files.forests, text);
  return {.summary = {fmt::format("{}: learned from {} photos or pieces, {:.1f} MB", files.forests.string(),
                                  samples.size(), static_cast<double>(text.size()) / 1e6)}};
}

}  // namespace orthodrive
