// orthodrive forests: the two random forests of the MRF baseline, learned from labelled photos.

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "commands.hpp"
#include "orthodrive/core/aside_file.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/io/raster_io.hpp"
#include "orthodrive/io/vector_io.hpp"
#include "orthodrive/refine/road_forest.hpp"
#include "photo_site.hpp"

namespace orthodrive::app {
namespace {
namespace fs = std::filesystem;

struct ForestsCommand {
  std::vector<fs::path> photos, labels;
  fs::path out;
  RoadForestOptions options;
};

Polygon box_polygon(const Box2& box) {
  return {{{box.min_x, box.min_y}, {box.max_x, box.min_y}, {box.max_x, box.max_y}, {box.min_x, box.max_y}}, {}};
}

RoadForestSample sample_of(Photo photo, Raster<std::uint8_t> mask) {
  return {std::move(photo.rgb), photo.frame.gsd_m, std::move(mask), std::move(photo.valid)};
}

/// The photo at its own scale where the map has labels.
RoadForestSample read_label_map(const fs::path& photo_file, const fs::path& label_file, int threads) {
  const LabelMap labels = io::read_labels(label_file);
  Photo photo = io::read_photo(photo_file, {labels.crs, box_polygon(labels.frame.bounds())}, {.threads = threads});
  Raster<std::uint8_t> mask = road_mask(labels, photo.frame);
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
  return road_mask_of(known->role);
}

/// One sample a painted piece, with a little of the photo around it. Later polygons cover earlier ones.
std::vector<RoadForestSample> read_painted(const fs::path& photo_file, const fs::path& polygon_file, int threads) {
  constexpr double surroundings_m = 10.0;  // what superpixels at the border of a piece look at
  const Crs crs = site_of_photo(photo_file).crs;
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
    Photo photo = io::read_photo(photo_file, {crs, box_polygon(box)}, {.threads = threads});
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

void run(ForestsCommand& command, const Context& context) {
  if (command.photos.size() != command.labels.size())
    throw OptionError(fmt::format("forests: {} photos but {} labels, give one --labels for each --photo",
                                  command.photos.size(), command.labels.size()));
  std::vector<RoadForestSample> samples;
  for (std::size_t i = 0; i < command.photos.size(); ++i) {
    if (is_painted(command.labels[i]))
      for (RoadForestSample& sample : read_painted(command.photos[i], command.labels[i], context.threads))
        samples.push_back(std::move(sample));
    else
      samples.push_back(read_label_map(command.photos[i], command.labels[i], context.threads));
    context.monitor->progress(static_cast<double>(i + 1) / static_cast<double>(command.photos.size()), "read");
  }
  command.options.threads = context.threads;
  const std::string text = save_road_forests(train_road_forests(samples, command.options));
  write_text_file(command.out, text);
  context.monitor->info(fmt::format("{}: learned from {} photos or pieces, {:.1f} MB", command.out.string(),
                                    samples.size(), static_cast<double>(text.size()) / 1e6));
}

}  // namespace

void add_forests(CLI::App& app, Context& context) {
  auto command = std::make_shared<ForestsCommand>();
  CLI::App* cmd =
      app.add_subcommand("forests", "Learn from labelled photos what `refine --method mrf` takes for a road.");
  cmd->add_option("--photo", command->photos, "orthophoto; once for each --labels")
      ->required()
      ->allow_extra_args(false);
  cmd->add_option("--labels", command->labels,
                  "its labels: a label map, or polygons (GeoJSON, GeoPackage) with class and piece")
      ->required()
      ->allow_extra_args(false);
  cmd->add_option("-o,--output", command->out, "the forests (YAML text)")->required();
  cmd->add_option("--trees", command->options.trees, "of each forest")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  cmd->add_option("--samples", command->options.max_samples, "superpixels of each kind to learn from, at most")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  cmd->add_option("--seed", command->options.seed, "of the random choice")->capture_default_str();
  cmd->footer(
      "Reads pairs of a photo and its labels, the first --photo with the first --labels and so on; writes one file.\n"
      "Roads are learned as road, parking not at all, every other class as beside or far from a road. Photos are read "
      "at\n"
      "their own scale, which must be near that of the photos to refine in. Memory: about 5 bytes a pixel of all "
      "photos.\n"
      "Examples:\n"
      "  orthodrive forests --photo village/ortho.tif --labels village/truth/labels.tif -o forests.yml\n"
      "  orthodrive forests --photo a.tif --labels a.geojson --photo b.tif --labels b.tif -o forests.yml");
  cmd->callback([command, &context] { run(*command, context); });
}

}  // namespace orthodrive::app
