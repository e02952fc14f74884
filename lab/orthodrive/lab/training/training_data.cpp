// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/lab/training/training_data.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <filesystem>
#include <functional>
#include <numeric>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/parallel.hpp"
#include "orthodrive/io/raster/raster_io.hpp"
#include "orthodrive/io/support/vector_io.hpp"
#include "orthodrive/model/roads/map_lines.hpp"
#include "orthodrive/segment/paint_labels.hpp"
#include "orthodrive/segment/resample_photo.hpp"

namespace orthodrive {
namespace {
namespace fs = std::filesystem;

SiteFrame site_of(const Box2& lonlat) {
  constexpr int steps = 16;  // a side: its edges bend in UTM
  SiteFrame site{utm_crs(0.5 * (lonlat.min_x + lonlat.max_x), 0.5 * (lonlat.min_y + lonlat.max_y)), {}};
  const CoordinateTransform transform({"EPSG:4326"}, site.crs);
  const Vec2 corners[] = {{lonlat.min_x, lonlat.min_y},
                          {lonlat.max_x, lonlat.min_y},
                          {lonlat.max_x, lonlat.max_y},
                          {lonlat.min_x, lonlat.max_y}};
  for (int side = 0; side < 4; ++side) {
    const Vec2 from = corners[side], to = corners[(side + 1) % 4];
    for (int i = 0; i < steps; ++i)
      site.area.outer.push_back(transform.target_from_source(from + (to - from) * (static_cast<double>(i) / steps)));
  }
  return site;
}

bool matches(const PaintRule& rule, const std::map<std::string, std::string>& tags) {
  return std::all_of(rule.where.begin(), rule.where.end(), [&](const auto& condition) {
    const auto tag = tags.find(condition.first);
    return tag != tags.end() &&
           std::find(condition.second.begin(), condition.second.end(), tag->second) != condition.second.end();
  });
}

std::vector<PaintShape> read_road_shapes(const PaintRule& rule, const SiteFrame& site) {
  std::vector<PaintShape> shapes;
  for (const RoadPath& path : io::read_osm_roads(rule.file, site).paths) {
    if (std::find(rule.highways.begin(), rule.highways.end(), path.highway) == rule.highways.end()) continue;
    shapes.push_back({.line = centerline(path), .width_m = path.nodes.front().width_m});
  }
  return shapes;
}

std::vector<PaintShape> read_feature_shapes(const PaintRule& rule, const SiteFrame& site) {
  std::vector<PaintShape> shapes;
  for (const io::Feature& feature : io::read_features(rule.file, site.crs)) {
    if (!matches(rule, feature.tags)) continue;
    if (!feature.polygons.empty()) shapes.push_back({.polygons = feature.polygons});
    for (const Polyline& line : feature.lines) shapes.push_back({.line = line, .width_m = rule.line_width_m});
    for (const Vec2 point : feature.points) shapes.push_back({.line = {point}, .width_m = rule.line_width_m});
  }
  return shapes;
}

void forget_missing_photo(const Photo& photo, Raster<ClassSet>& allowed) {
  for (std::size_t i = 0; i < photo.valid.data.size(); ++i) {
    if (!photo.valid.data[i]) allowed.data[i] = unknown_class;
  }
}

struct LabelledPhoto {
  Photo photo;  ///< at the model's scale
  Raster<ClassSet> allowed;
  std::optional<std::vector<RoadLine>> map;  ///< in pixels of the photo
};

/// Lines near a photo, in its pixels.
std::vector<RoadLine> lines_on(const GridFrame& frame, const std::vector<RoadLine>& lines_m) {
  const Box2 near = frame.bounds().grown((map_reach_px + 1.0) * frame.gsd_m);
  std::vector<RoadLine> lines;
  for (const RoadLine& line : lines_m) {
    if (!bounds_of(line.points).overlaps(near)) continue;
    RoadLine& on = lines.emplace_back(RoadLine{{}, line.half_width / frame.gsd_m});
    for (const Vec2 p : line.points) on.points.push_back(frame.pixel_from_world(p));
  }
  return lines;
}

LabelledPhoto read_map_data(const MapData& data, const Box2& lonlat, double gsd_m, const ClassTable& classes,
                            int threads) {
  const SiteFrame site = site_of(lonlat);
  LabelledPhoto result;
  // Through the photo's own scale, as prediction comes to it.
  result.photo = resample_photo(io::read_photo(data.photo, site, {.threads = threads}), gsd_m, threads);
  std::vector<PaintLayer> layers;
  layers.reserve(data.rules.size());
  for (const PaintRule& rule : data.rules) {
    layers.push_back({.shapes = rule.highways.empty() ? read_feature_shapes(rule, site) : read_road_shapes(rule, site),
                      .classes = class_set(rule.classes, classes, data.name),
                      .merge_over = class_set(rule.merge_over, classes, data.name),
                      .unknown_inside_m = rule.unknown_inside_m,
                      .unknown_outside_m = rule.unknown_outside_m});
  }
  result.allowed = paint_labels(result.photo.frame, class_set(data.background, classes, data.name), layers);
  forget_missing_photo(result.photo, result.allowed);
  return result;
}

LabelledPhoto read_raster_data(const RasterData& data, double gsd_m, const ClassTable& classes, int threads) {
  LabelledPhoto result{resample_photo(io::read_photo_native(data.photo), gsd_m, threads), {}, {}};
  const LabelMap labels = io::read_labels(data.labels);
  for (const auto& [name, ours] : data.mapping) {
    if (std::none_of(labels.classes.classes.begin(), labels.classes.classes.end(),
                     [&, &theirs = name](const ClassInfo& c) { return c.name == theirs; }))
      throw InputError(data.labels.string(),
                       fmt::format("has no class '{}', which the mapping of '{}' names", name, data.name));
  }
  std::vector<std::string> by_name;
  for (const ClassInfo& info : labels.classes.classes)
    if (!data.mapping.contains(info.name)) by_name.push_back(info.name);
  (void)class_set(by_name, classes, data.labels.string());  // all that the table lacks is said at once
  std::vector<ClassSet> set_of_label(256, unknown_class);
  for (std::size_t i = 0; i < labels.classes.classes.size(); ++i) {
    const std::string& name = labels.classes.classes[i].name;
    const auto mapped = data.mapping.find(name);
    set_of_label[i] = mapped == data.mapping.end()
                          ? class_set({name}, classes, data.labels.string())
                          : class_set(mapped->second, classes, fmt::format("mapping of '{}'", data.name));
  }
  const GridFrame& frame = result.photo.frame;
  result.allowed = Raster<ClassSet>(frame.width, frame.height, 1, unknown_class);
  for (int row = 0; row < frame.height; ++row) {
    for (int col = 0; col < frame.width; ++col) {
      const Vec2 p = labels.frame.pixel_from_world(frame.center_of(col, row));
      const int label_col = static_cast<int>(std::floor(p.x)), label_row = static_cast<int>(std::floor(p.y));
      if (labels.labels.inside(label_col, label_row))
        result.allowed.at(col, row) = set_of_label[labels.labels.at(label_col, label_row)];
    }
  }
  forget_missing_photo(result.photo, result.allowed);
  return result;
}

Raster<ClassSet> sets_from_colors(const Raster<std::uint8_t>& image, const fs::path& file, const ImageData& data,
                                  const ClassTable& classes) {
  std::map<std::array<std::uint8_t, 3>, ClassSet> palette;
  for (const auto& [color, names] : data.palette) palette[color] = class_set(names, classes, data.name);
  Raster<ClassSet> sets(image.width, image.height, 1, unknown_class);
  for (std::size_t i = 0; i < sets.data.size(); ++i) {
    const auto entry = palette.find({image.data[3 * i], image.data[3 * i + 1], image.data[3 * i + 2]});
    if (entry == palette.end()) {
      throw InputError(
          file.string(),
          fmt::format("colour [{}, {}, {}] at pixel ({}, {}) is not in the palette of '{}': add it there, "
                      "with classes = [] to ignore it",
                      image.data[3 * i], image.data[3 * i + 1], image.data[3 * i + 2],
                      i % static_cast<std::size_t>(image.width), i / static_cast<std::size_t>(image.width), data.name));
    }
    sets.data[i] = entry->second;
  }
  return sets;
}

TrainingScene scene_of(std::string name, Raster<std::uint8_t> rgb, Raster<ClassSet> allowed, double gsd_m,
                       const SceneUse& use) {
  return {std::move(name), std::move(rgb), std::move(allowed), gsd_m,        use.weight,
          use.min_zoom,    use.max_zoom,   use.from_step,      use.crf_only, {}};
}

enum class DataPart { training, held_out };

/// Images at the scale they are said to have.
void add_images(TrainingData& result, const ImageData& data, DataPart part, const ClassTable& classes) {
  std::vector<fs::path> files;
  if (!fs::is_directory(data.images)) throw InputError(data.images.string(), "is no folder of images");
  for (const auto& entry : fs::directory_iterator(data.images)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  const std::size_t first = result.scenes.size();
  for (const fs::path& file : files) {
    const std::string stem = file.stem().string();
    const auto named_in = [&](const std::vector<std::string>& prefixes) {
      return std::ranges::any_of(prefixes, [&](const std::string& p) { return p == "*" || stem.starts_with(p); });
    };
    const bool held_out = named_in(data.held_out);
    if (held_out != (part == DataPart::held_out)) continue;
    Raster<std::uint8_t> rgb = io::read_image(file);
    const fs::path label_file = data.labels / (stem + ".png");
    const Raster<std::uint8_t> label_image = io::read_image(label_file);
    if (label_image.width != rgb.width || label_image.height != rgb.height) {
      throw InputError(label_file.string(),
                       fmt::format("has {} x {} px, its image {} x {}: labels need the size of their image",
                                   label_image.width, label_image.height, rgb.width, rgb.height));
    }
    Raster<ClassSet> allowed = sets_from_colors(label_image, label_file, data, classes);
    if (part == DataPart::training) {
      result.scenes.push_back(scene_of(stem, std::move(rgb), std::move(allowed), data.gsd_m, data.use));
      result.scenes.back().crf_only = named_in(data.crf_only);
      continue;
    }
    const int width = rgb.width, height = rgb.height;
    result.validation.push_back({data.name,
                                 {{},
                                  {0.0, height * data.gsd_m, data.gsd_m, width, height},
                                  std::move(rgb),
                                  Raster<std::uint8_t>(width, height, 1, 1)},
                                 std::move(allowed),
                                 {}});
  }
  // The weight is that of the data set: each image gets its share by area, those for the CRF apart from the others.
  std::map<bool, double> area;
  for (std::size_t i = first; i < result.scenes.size(); ++i)
    area[result.scenes[i].crf_only] += static_cast<double>(result.scenes[i].allowed.data.size());
  for (std::size_t i = first; i < result.scenes.size(); ++i)
    result.scenes[i].weight *=
        static_cast<double>(result.scenes[i].allowed.data.size()) / area[result.scenes[i].crf_only];
}

void add_labelled(TrainingData& result, const std::string& name, LabelledPhoto labelled, DataPart part,
                  const SceneUse& use) {
  if (part == DataPart::held_out) {
    result.validation.push_back(
        {name, std::move(labelled.photo), std::move(labelled.allowed), std::move(labelled.map)});
  } else {
    result.scenes.push_back(
        scene_of(name, std::move(labelled.photo.rgb), std::move(labelled.allowed), labelled.photo.frame.gsd_m, use));
    if (labelled.map) result.scenes.back().map = std::move(*labelled.map);
  }
}

/// Each piece with what the network sees around it.
void add_polygons(TrainingData& result, const PolygonData& data, double gsd_m, const ClassTable& classes, int threads) {
  const double surroundings_m = data.held_out ? 150.0 : 50.0;  // crops should hit the piece
  const Box2 photo_box = bounds_of(io::raster_info(data.photo).outline_lonlat.outer);
  const Crs crs = utm_crs(0.5 * (photo_box.min_x + photo_box.max_x), 0.5 * (photo_box.min_y + photo_box.max_y));
  std::map<std::string, std::vector<io::Feature>> pieces;
  for (io::Feature& feature : io::read_features(data.polygons, crs)) {
    const std::string piece = feature.tags["piece"];
    if (feature.polygons.empty())
      throw InputError(data.polygons.string(), fmt::format("piece '{}': a feature is no polygon", piece));
    if (data.pieces.empty() || std::find(data.pieces.begin(), data.pieces.end(), piece) != data.pieces.end())
      pieces[piece].push_back(std::move(feature));
  }
  for (const std::string& name : data.pieces)
    if (!pieces.contains(name)) throw InputError(data.polygons.string(), fmt::format("has no piece '{}'", name));
  if (pieces.empty()) throw InputError(data.polygons.string(), "has no polygons");
  std::vector<RoadLine> roads_m;  // of all the photo shows: a piece may be without roads
  if (!data.osm.empty()) roads_m = road_lines(io::read_osm_roads(data.osm, site_of(photo_box)));
  for (const auto& [piece, features] : pieces) {
    Box2 box = bounds_of(features.front().polygons.front().outer);
    for (const io::Feature& feature : features)
      for (const Polygon& polygon : feature.polygons) {
        const Box2 own = bounds_of(polygon.outer);
        box = {std::min(box.min_x, own.min_x), std::min(box.min_y, own.min_y), std::max(box.max_x, own.max_x),
               std::max(box.max_y, own.max_y)};
      }
    box = {box.min_x - surroundings_m, box.min_y - surroundings_m, box.max_x + surroundings_m,
           box.max_y + surroundings_m};
    const SiteFrame site{crs, polygon_of(box)};
    LabelledPhoto scene{resample_photo(io::read_photo(data.photo, site, {.threads = threads}), gsd_m, threads), {}, {}};
    const GridFrame& frame = scene.photo.frame;
    if (!data.osm.empty()) scene.map = lines_on(frame, roads_m);
    scene.allowed = Raster<ClassSet>(frame.width, frame.height, 1, unknown_class);
    for (const io::Feature& feature : features) {
      const auto tag = feature.tags.find("class");
      if (tag == feature.tags.end())
        throw InputError(data.polygons.string(), fmt::format("piece '{}': a feature has no 'class'", piece));
      const ClassSet set =
          tag->second == "unknown" ? unknown_class : class_set({tag->second}, classes, data.polygons.string());
      for (const Polygon& polygon : feature.polygons) fill_polygon(scene.allowed, frame, polygon, set);
    }
    forget_missing_photo(scene.photo, scene.allowed);
    SceneUse use = data.use;
    use.weight /= static_cast<double>(pieces.size());
    add_labelled(result, data.held_out ? data.name : data.name + "-" + piece, std::move(scene),
                 data.held_out ? DataPart::held_out : DataPart::training, use);
  }
}

void add_part(TrainingData& result, const Experiment& experiment, DataPart part, double gsd_m,
              const ClassTable& classes, int threads, Monitor* monitor) {
  const auto tell = [&](const std::string& name) {
    if (monitor) monitor->info("reading " + name + (part == DataPart::held_out ? ", held out" : ""));
  };
  for (const MapData& data : experiment.maps) {
    const std::optional<Box2> lonlat = part == DataPart::held_out ? data.held_out_lonlat : data.area_lonlat;
    if (!lonlat) continue;
    tell(data.name);
    add_labelled(result, data.name, read_map_data(data, *lonlat, gsd_m, classes, threads), part, data.use);
  }
  for (const RasterData& data : experiment.rasters) {
    if (data.held_out != (part == DataPart::held_out)) continue;
    tell(data.name);
    add_labelled(result, data.name, read_raster_data(data, gsd_m, classes, threads), part, data.use);
  }
  for (const ImageData& data : experiment.images) {
    tell(data.name);
    add_images(result, data, part, classes);
  }
  for (const PolygonData& data : experiment.polygons) {
    if (data.held_out != (part == DataPart::held_out)) continue;
    tell(data.name);
    add_polygons(result, data, gsd_m, classes, threads);
  }
}

}  // namespace

TrainingData read_training_data(const Experiment& experiment, double gsd_m, const ClassTable& classes, int threads,
                                Monitor* monitor) {
  TrainingData result;
  add_part(result, experiment, DataPart::training, gsd_m, classes, threads, monitor);
  add_part(result, experiment, DataPart::held_out, gsd_m, classes, threads, monitor);
  return result;
}

std::vector<ValidationScene> read_held_out_data(const Experiment& experiment, double gsd_m, const ClassTable& classes,
                                                int threads, Monitor* monitor) {
  TrainingData result;
  add_part(result, experiment, DataPart::held_out, gsd_m, classes, threads, monitor);
  return std::move(result.validation);
}

namespace {
std::vector<std::int64_t> known_pixels(const Raster<ClassSet>& allowed, std::size_t classes) {
  std::vector<std::int64_t> counts(classes, 0);
  for (const ClassSet set : allowed.data)
    if (std::has_single_bit(set)) ++counts[static_cast<std::size_t>(std::countr_zero(set))];
  return counts;
}
std::vector<double> shares(const std::vector<std::int64_t>& counts) {
  const std::int64_t all = std::accumulate(counts.begin(), counts.end(), std::int64_t{0});
  std::vector<double> result;
  result.reserve(counts.size());
  for (const std::int64_t count : counts)
    result.push_back(all > 0 ? static_cast<double>(count) / static_cast<double>(all) : 0.0);
  return result;
}
}  // namespace

ClassShares class_shares(const TrainingData& data, std::size_t classes) {
  std::vector<std::int64_t> training(classes, 0), held_out(classes, 0);
  const auto add = [&](std::vector<std::int64_t>& sums, const Raster<ClassSet>& allowed) {
    const auto counts = known_pixels(allowed, classes);
    std::ranges::transform(sums, counts, sums.begin(), std::plus{});
  };
  for (const TrainingScene& scene : data.scenes) add(training, scene.allowed);
  for (const ValidationScene& scene : data.validation) add(held_out, scene.allowed);
  return {shares(training), shares(held_out)};
}

Raster<std::uint8_t> label_preview(const Raster<std::uint8_t>& rgb, const Raster<ClassSet>& allowed,
                                   const ClassTable& classes) {
  Raster<std::uint8_t> preview = rgb;
  for (std::size_t i = 0; i < allowed.data.size(); ++i) {
    int count = 0;
    std::array<int, 3> sum{};
    for (std::size_t c = 0; c < classes.classes.size(); ++c) {
      if (!(allowed.data[i] >> c & 1U)) continue;
      ++count;
      for (std::size_t k = 0; k < 3; ++k) sum[k] += classes.classes[c].color[k];
    }
    if (count == 0) continue;
    for (std::size_t k = 0; k < 3; ++k)
      preview.data[3 * i + k] = static_cast<std::uint8_t>((rgb.data[3 * i + k] + sum[k] / count) / 2);
  }
  return preview;
}

}  // namespace orthodrive
