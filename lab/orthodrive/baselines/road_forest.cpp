// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/baselines/road_forest.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/ml.hpp>
#include <utility>
#include <vector>

#include "orthodrive/baselines/one_cv_thread.hpp"
#include "orthodrive/baselines/tile_grid.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/core/parallel.hpp"
#include "orthodrive/core/random.hpp"

namespace orthodrive {

struct RoadForests::Trees {
  SuperpixelOptions superpixels;
  double finest_gsd_m = 0.0, coarsest_gsd_m = 0.0;
  cv::Ptr<cv::ml::RTrees> road, context;
};

namespace {

constexpr int forest_depth = 14;
constexpr int least_node_samples = 20;  // a node with fewer is a leaf
constexpr double least_purity = 0.7;    // superpixels of which less is of one kind teach nothing
constexpr double near_road_m = 8.0;     // the context forest learns from what lies so near to a road

using namespace baselines;

constexpr const char* format_key = "orthodrive_road_forests";
constexpr int format_version = 1;
constexpr double gsd_factor = 1.6;

enum Kind { road, near_context, far_context, kinds };

/// Feature rows by kind.
using Rows = std::array<std::vector<float>, kinds>;

/// A superpixel's neighbours and its coarse window must be inside the margin for most superpixels of the tile.
int margin_px(const SuperpixelOptions& options, double gsd_m) { return 3 * superpixel_px(options, gsd_m); }

/// A part of a raster; the box lies inside it.
Raster<std::uint8_t> cut(const Raster<std::uint8_t>& raster, const PixelBox& box) {
  Raster<std::uint8_t> part(box.width, box.height, raster.channels);
  for (int y = 0; y < box.height; ++y)
    std::copy_n(&raster.at(static_cast<int>(box.col), static_cast<int>(box.row) + y), box.width * raster.channels,
                &part.at(0, y));
  return part;
}

/// Distance of every pixel of the mask to the nearest road, in pixels.
cv::Mat road_distance(const Raster<std::uint8_t>& mask) {
  cv::Mat no_road(mask.height, mask.width, CV_8UC1), distance;
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x)
      no_road.at<std::uint8_t>(y, x) = mask.at(x, y) != static_cast<std::uint8_t>(RoadMask::road);
  cv::distanceTransform(no_road, distance, cv::DIST_L2, cv::DIST_MASK_5);
  return distance;
}

/// The superpixels of a tile that are of one kind. Those of the margin belong to the tiles beside it.
Rows collect_rows(const RoadForestSample& sample, const PixelBox& tile, const RoadForestOptions& options) {
  const int margin =
      std::max(margin_px(options.superpixels, sample.gsd_m), static_cast<int>(near_road_m / sample.gsd_m) + 1);
  const PixelBox box = intersection(tile.grown(margin), {0, 0, sample.rgb.width, sample.rgb.height});
  const Raster<std::uint8_t> mask = cut(sample.mask, box);
  const Superpixels superpixels =
      make_superpixels(cut(sample.rgb, box), sample.valid.empty() ? Raster<std::uint8_t>() : cut(sample.valid, box),
                       sample.gsd_m, options.superpixels);
  const cv::Mat to_road = road_distance(mask);

  struct Votes {
    int road = 0, context = 0, pixels = 0;
    double x = 0.0, y = 0.0, to_road_px = 0.0;
  };
  std::vector<Votes> votes(static_cast<std::size_t>(superpixels.count));
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x) {
      Votes& v = votes[static_cast<std::size_t>(superpixels.labels.at(x, y))];
      v.road += mask.at(x, y) == static_cast<std::uint8_t>(RoadMask::road);
      v.context += mask.at(x, y) == static_cast<std::uint8_t>(RoadMask::context);
      v.x += x, v.y += y, v.to_road_px += to_road.at<float>(y, x), ++v.pixels;
    }
  Rows rows;
  for (int i = 0; i < superpixels.count; ++i) {
    const Votes& v = votes[static_cast<std::size_t>(i)];
    if (v.pixels == 0) continue;
    const PixelBox center{box.col + static_cast<std::int64_t>(v.x / v.pixels),
                          box.row + static_cast<std::int64_t>(v.y / v.pixels), 1, 1};
    if (intersection(center, tile).empty()) continue;
    Kind kind = road;
    if (v.context >= least_purity * v.pixels)
      kind = v.to_road_px / v.pixels * sample.gsd_m <= near_road_m ? near_context : far_context;
    else if (v.road < least_purity * v.pixels)
      continue;
    const auto features = superpixels.features_of(i);
    rows[kind].insert(rows[kind].end(), features.begin(), features.end());
  }
  return rows;
}

/// Draws `count` of the rows without putting back, in their order.
std::vector<float> draw(const std::vector<float>& rows, std::size_t count, Random& random) {
  const std::size_t all = rows.size() / superpixel_features;
  if (all <= count) return rows;
  std::vector<float> drawn;
  for (std::size_t i = 0; i < all && count > 0; ++i) {  // Knuth, selection sampling
    if (random.below(all - i) >= count) continue;
    --count;
    const float* const row = &rows[i * superpixel_features];
    drawn.insert(drawn.end(), row, row + superpixel_features);
  }
  return drawn;
}

/// What the road forest learns as no road: `near_share` of it beside roads, the rest from anywhere else. Pavements are
/// the smallest part of a map and the likest to a road: drawn with all else they would hardly be seen.
std::vector<float> no_road(const Rows& rows, const RoadForestOptions& options) {
  const auto count = [&](Kind kind) { return rows[kind].size() / superpixel_features; };
  const std::size_t wanted =
      std::min({count(road), count(near_context) + count(far_context), static_cast<std::size_t>(options.max_samples)});
  const auto share = static_cast<std::size_t>(std::lround(options.near_share * static_cast<double>(wanted)));
  const std::size_t far = std::min(count(far_context), wanted - std::min(share, count(near_context)));
  Random random(derive_seed(options.seed, 3));
  std::vector<float> drawn = draw(rows[near_context], wanted - far, random);
  const std::vector<float> others = draw(rows[far_context], far, random);
  drawn.insert(drawn.end(), others.begin(), others.end());
  return drawn;
}

/// Class 1 against class 0, as many of each.
cv::Ptr<cv::ml::RTrees> train(const std::vector<float>& yes, const std::vector<float>& no,
                              const RoadForestOptions& options, std::uint64_t seed) {
  Random random(seed);
  const std::size_t count = std::min({yes.size() / superpixel_features, no.size() / superpixel_features,
                                      static_cast<std::size_t>(options.max_samples)});
  std::vector<float> rows = draw(yes, count, random);
  const std::vector<float> others = draw(no, count, random);
  rows.insert(rows.end(), others.begin(), others.end());
  const cv::Mat samples(static_cast<int>(2 * count), superpixel_features, CV_32F, rows.data());
  cv::Mat responses(static_cast<int>(2 * count), 1, CV_32S, cv::Scalar(0));
  responses.rowRange(0, static_cast<int>(count)).setTo(1);

  const auto trees = cv::ml::RTrees::create();
  trees->setMaxDepth(forest_depth);
  trees->setMinSampleCount(least_node_samples);
  trees->setUseSurrogates(false);
  trees->setTermCriteria({cv::TermCriteria::MAX_ITER, options.trees, 0.0});
  // OpenCV draws from a generator of the thread: ours while we train, then it is given back as it was.
  const std::uint64_t state = std::exchange(cv::theRNG().state, random.next());
  trees->train(cv::ml::TrainData::create(samples, cv::ml::ROW_SAMPLE, responses));
  cv::theRNG().state = state;
  return trees;
}

void check(std::span<const RoadForestSample> samples, const RoadForestOptions& options) {
  if (options.trees < 1 || options.max_samples < 1 || !(options.superpixels.size_m > 0.0) ||
      options.superpixels.iterations < 1 || !(options.superpixels.texture_m > 0.0) ||
      !(options.near_share >= 0.0 && options.near_share <= 1.0))
    throw OptionError(
        "road forests: trees, depth, samples, superpixel size, iterations and texture must be positive, purity above "
        "0.5, the share near roads within 0..1");
  for (const RoadForestSample& s : samples) {
    if (!(s.gsd_m > 0.0) || s.rgb.channels != 3)
      throw OptionError("road forests: a sample needs 3 channels and a ground sampling distance");
    const auto fits = [&](const Raster<std::uint8_t>& r) {
      return r.width == s.rgb.width && r.height == s.rgb.height && r.channels == 1;
    };
    if (!fits(s.mask) || (!s.valid.empty() && !fits(s.valid)))
      throw OptionError(fmt::format("road forests: photo of {} x {} pixels with a mask of {} x {}", s.rgb.width,
                                    s.rgb.height, s.mask.width, s.mask.height));
  }
}

/// Shares of the votes for class 1, one per row.
std::vector<std::uint8_t> predict(const cv::ml::RTrees& trees, const cv::Mat& rows) {
  cv::Mat votes;
  trees.getVotes(rows, votes, 0);  // first row: the classes
  std::vector<std::uint8_t> shares;
  const int yes = votes.at<int>(0, 0) == 1 ? 0 : 1;
  for (int i = 0; i < rows.rows; ++i) {
    const double all = votes.at<int>(i + 1, 0) + votes.at<int>(i + 1, 1);
    shares.push_back(static_cast<std::uint8_t>(std::lround(255.0 * votes.at<int>(i + 1, yes) / all)));
  }
  return shares;
}

/// Whether a forest as read can be asked: of our features, and every tree votes for 0 or 1.
bool is_usable(const cv::ml::RTrees& trees) {
  if (!trees.isTrained() || !trees.isClassifier() || trees.getVarCount() != superpixel_features) return false;
  cv::Mat votes;
  trees.getVotes(cv::Mat::zeros(1, superpixel_features, CV_32F), votes, 0);
  return votes.rows == 2 && votes.cols == 2 && votes.type() == CV_32S &&
         std::min(votes.at<int>(0, 0), votes.at<int>(0, 1)) == 0 &&
         std::max(votes.at<int>(0, 0), votes.at<int>(0, 1)) == 1 && votes.at<int>(1, 0) + votes.at<int>(1, 1) > 0;
}

void predict_tile(const RoadForests::Trees& trees, const PhotoSource& photo, const PixelBox& tile, const PixelBox& box,
                  RoadProbabilities& result) {
  const PixelBox core = intersection(tile, box);
  const PixelBox window = tile.grown(margin_px(trees.superpixels, photo.frame.gsd_m));
  if (core.empty() || intersection(tile, pixels_of(photo.frame)).empty()) return;
  const PhotoWindow pixels = photo.read(window);
  if (std::all_of(pixels.valid.data.begin(), pixels.valid.data.end(), [](std::uint8_t v) { return v == 0; })) return;
  Superpixels superpixels = make_superpixels(pixels.rgb, pixels.valid, photo.frame.gsd_m, trees.superpixels);
  const cv::Mat rows(superpixels.count, superpixel_features, CV_32F, superpixels.features.data());
  const std::vector<std::uint8_t> road = predict(*trees.road, rows), context = predict(*trees.context, rows);
  for (std::int64_t row = core.row; row < core.end_row(); ++row)
    for (std::int64_t col = core.col; col < core.end_col(); ++col) {
      const int u = static_cast<int>(col - window.col), v = static_cast<int>(row - window.row);
      if (pixels.valid.at(u, v) == 0) continue;
      const int x = static_cast<int>(col - box.col), y = static_cast<int>(row - box.row);
      const auto superpixel = static_cast<std::size_t>(superpixels.labels.at(u, v));
      result.valid.at(x, y) = 1;
      result.road.at(x, y) = road[superpixel];
      result.context.at(x, y) = context[superpixel];
    }
}

}  // namespace

RoadMask road_mask_of(Role role) {
  return role == Role::road ? RoadMask::road : role == Role::maybe_road ? RoadMask::unknown : RoadMask::context;
}

Raster<std::uint8_t> road_mask(const LabelMap& labels, const GridFrame& frame) {
  Raster<std::uint8_t> mask(frame.width, frame.height);
  for (int row = 0; row < frame.height; ++row)
    for (int col = 0; col < frame.width; ++col) {
      const Vec2 p = labels.frame.pixel_from_world(frame.center_of(col, row));
      const int x = static_cast<int>(std::floor(p.x)), y = static_cast<int>(std::floor(p.y));
      if (!labels.labels.inside(x, y)) continue;
      const std::uint8_t label = labels.labels.at(x, y);
      if (label < labels.classes.classes.size())
        mask.at(col, row) = static_cast<std::uint8_t>(road_mask_of(labels.classes.classes[label].role));
    }
  return mask;
}

RoadForests train_road_forests(std::span<const RoadForestSample> samples, const RoadForestOptions& options) {
  const OneCvThread guard;
  check(samples, options);
  auto trees = std::make_shared<RoadForests::Trees>();
  trees->superpixels = options.superpixels;
  struct Task {
    const RoadForestSample* sample;
    PixelBox tile;
  };
  std::vector<Task> tasks;
  for (const RoadForestSample& sample : samples) {
    trees->finest_gsd_m = tasks.empty() ? sample.gsd_m : std::min(trees->finest_gsd_m, sample.gsd_m);
    trees->coarsest_gsd_m = std::max(trees->coarsest_gsd_m, sample.gsd_m);
    for (const PixelBox& tile : tiles_of({0, 0, sample.rgb.width, sample.rgb.height})) tasks.push_back({&sample, tile});
  }
  std::vector<Rows> of_tile(tasks.size());
  parallel_for(tasks.size(), options.threads,
               [&](std::size_t i) { of_tile[i] = collect_rows(*tasks[i].sample, tasks[i].tile, options); });
  Rows rows;
  for (const Rows& tile : of_tile)
    for (std::size_t kind = 0; kind < kinds; ++kind)
      rows[kind].insert(rows[kind].end(), tile[kind].begin(), tile[kind].end());
  if (rows[road].empty() || rows[near_context].empty())
    throw OptionError(
        "road forests: the samples show no road or nothing beside one, label at least a few roads and their "
        "surroundings");

  trees->road = train(rows[road], no_road(rows, options), options, derive_seed(options.seed, 1));
  trees->context = train(rows[near_context], rows[road], options, derive_seed(options.seed, 2));
  return RoadForests(std::move(trees));
}

std::string save_road_forests(const RoadForests& forests) {
  const RoadForests::Trees& trees = forests.trees();
  cv::FileStorage file(".yml", cv::FileStorage::WRITE | cv::FileStorage::MEMORY);
  file << format_key << format_version;
  file << "superpixel_size_m" << trees.superpixels.size_m << "superpixel_ruler" << trees.superpixels.ruler;
  file << "superpixel_iterations" << trees.superpixels.iterations << "texture_m" << trees.superpixels.texture_m;
  file << "finest_gsd_m" << trees.finest_gsd_m << "coarsest_gsd_m" << trees.coarsest_gsd_m;
  file << "road"
       << "{";
  trees.road->write(file);
  file << "}"
       << "context"
       << "{";
  trees.context->write(file);
  file << "}";
  return file.releaseAndGetString();
}

RoadForests load_road_forests(const std::string& text, const std::string& name) {
  if (text.find(format_key) == std::string::npos)
    throw InputError(name, "holds no road forests, train them with this version");
  auto trees = std::make_shared<RoadForests::Trees>();
  bool usable = false;
  try {
    const cv::FileStorage file(text, cv::FileStorage::READ | cv::FileStorage::MEMORY);
    if (!file.isOpened() || static_cast<int>(file[format_key]) != format_version)
      throw InputError(name, fmt::format("no road forests of format {}, train them again", format_version));
    SuperpixelOptions& superpixels = trees->superpixels;
    superpixels.size_m = file["superpixel_size_m"];
    superpixels.ruler = file["superpixel_ruler"];
    superpixels.iterations = file["superpixel_iterations"];
    superpixels.texture_m = file["texture_m"];
    trees->finest_gsd_m = file["finest_gsd_m"];
    trees->coarsest_gsd_m = file["coarsest_gsd_m"];
    trees->road = cv::ml::RTrees::create();
    trees->road->read(file["road"]);
    trees->context = cv::ml::RTrees::create();
    trees->context->read(file["context"]);
    const auto within = [](double value, double largest) { return value > 0.0 && value <= largest; };
    usable = is_usable(*trees->road) && is_usable(*trees->context) && within(superpixels.size_m, 100.0) &&
             within(superpixels.ruler, 1e4) && within(superpixels.iterations, 1000) &&
             within(superpixels.texture_m, 1000.0) && within(trees->coarsest_gsd_m, 100.0) &&
             within(trees->finest_gsd_m, trees->coarsest_gsd_m);
  } catch (const cv::Exception& e) {
    throw InputError(name, fmt::format("cannot be read as road forests ({})", e.err));
  }
  if (!usable) throw InputError(name, "holds road forests that are incomplete, train them again");
  return RoadForests(std::move(trees));
}

RoadProbabilities predict_road_forests(const RoadForests& forests, const PhotoSource& photo, const PixelBox& box,
                                       int threads) {
  const OneCvThread guard;
  const RoadForests::Trees& trees = forests.trees();
  if (photo.frame.gsd_m > gsd_factor * trees.coarsest_gsd_m || photo.frame.gsd_m * gsd_factor < trees.finest_gsd_m)
    throw OptionError(
        fmt::format("road forests: learned at {} to {} m a pixel but the photo has {}, train with such a photo",
                    trees.finest_gsd_m, trees.coarsest_gsd_m, photo.frame.gsd_m));
  RoadProbabilities result{Raster<std::uint8_t>(box.width, box.height), Raster<std::uint8_t>(box.width, box.height),
                           Raster<std::uint8_t>(box.width, box.height)};
  const std::vector<PixelBox> tiles = tiles_of(box);
  parallel_for(tiles.size(), threads, [&](std::size_t i) { predict_tile(trees, photo, tiles[i], box, result); });
  return result;
}

}  // namespace orthodrive
