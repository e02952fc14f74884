// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/raster/raster_layers.hpp"

#include <fmt/format.h>
#include <gdal_alg.h>
#include <gdal_utils.h>
#include <gdalwarper.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/parallel.hpp"
#include "orthodrive/core/printable.hpp"
#include "orthodrive/core/stop.hpp"
#include "orthodrive/io/raster/photo_bands.hpp"
#include "orthodrive/io/raster/raster_support.hpp"

namespace orthodrive::io {
namespace {
namespace fs = std::filesystem;
constexpr int steps_of_edge = 16;

/// The bounds of places that are transformed; those that cannot be are left out.
class TransformedBox {
 public:
  TransformedBox(const OGRSpatialReference& from, const OGRSpatialReference& to)
      : transform_(OGRCreateCoordinateTransformation(&from, &to)) {}
  void add(double x, double y) {
    if (!transform_ || !transform_->Transform(1, &x, &y)) return;
    box_ = {std::min(box_.min_x, x), std::min(box_.min_y, y), std::max(box_.max_x, x), std::max(box_.max_y, y)};
  }
  [[nodiscard]] const Box2& box() const { return box_; }

 private:
  GdalErrors errors_;
  std::unique_ptr<OGRCoordinateTransformation> transform_;
  Box2 box_{1e300, 1e300, -1e300, -1e300};
};

/// A grid: pixels to its CRS.
struct Canvas {
  OGRSpatialReference reference;
  double left = 0.0, top = 0.0, width_of_pixel = 0.0, height_of_pixel = 0.0, gsd_m = 0.0;
  int width = 0, height = 0;
  [[nodiscard]] PixelBox pixels_of(const Box2& box, int margin) const {
    const auto limited = [](double value, int most) {
      return static_cast<int>(std::clamp(value, 0.0, static_cast<double>(most)));
    };
    const int col = limited(std::floor((box.min_x - left) / width_of_pixel) - margin, width),
              end_col = limited(std::ceil((box.max_x - left) / width_of_pixel) + margin, width),
              row = limited(std::floor((top - box.max_y) / height_of_pixel) - margin, height),
              end_row = limited(std::ceil((top - box.min_y) / height_of_pixel) + margin, height);
    return {col, row, end_col - col, end_row - row};
  }
};

Georeference place_of(const OpenedRaster& raster) {
  Georeference g;
  std::copy_n(raster.c, 6, g.c);
  g.reference = raster.horizontal;
  return g;
}

Box2 box_of(const OpenedRaster& raster, const OGRSpatialReference& reference) {
  TransformedBox box(raster.horizontal, reference);
  for (int i = 0; i <= steps_of_edge; ++i)
    for (int j = 0; j <= steps_of_edge; ++j) {
      const double col = static_cast<double>(raster.width) * i / steps_of_edge,
                   row = static_cast<double>(raster.height) * j / steps_of_edge;
      box.add(raster.c[0] + col * raster.c[1] + row * raster.c[2], raster.c[3] + col * raster.c[4] + row * raster.c[5]);
    }
  return box.box();
}

/// Where pixels of the canvas are those of the raster: none is resampled.
bool lies_on_grid(const OpenedRaster& raster, const Canvas& canvas) {
  constexpr double most_px = 1e-4;
  const auto off = [](double pixels) { return std::abs(pixels - std::round(pixels)); };
  return is_north_up(raster) && same_crs(raster.horizontal, canvas.reference) &&
         std::abs(raster.c[1] / canvas.width_of_pixel - 1.0) * raster.width < most_px &&
         std::abs(-raster.c[5] / canvas.height_of_pixel - 1.0) * raster.height < most_px &&
         off((raster.c[0] - canvas.left) / canvas.width_of_pixel) < most_px &&
         off((canvas.top - raster.c[3]) / canvas.height_of_pixel) < most_px;
}

Canvas canvas_of(const std::vector<OpenedRaster>& rasters, const std::vector<Box2>& boxes, const SiteFrame& site,
                 const OGRSpatialReference& reference, const CutRasterOptions& options) {
  Canvas canvas{.reference = reference};
  const OpenedRaster* finest = nullptr;
  double finest_m = std::numeric_limits<double>::infinity(), anchor_m = finest_m;
  Box2 all{1e300, 1e300, -1e300, -1e300};
  for (std::size_t i = 0; i < rasters.size(); ++i) {
    const double gsd_m = pixel_size(place_of(rasters[i]), rasters[i].width, rasters[i].height).gsd_m();
    finest_m = std::min(finest_m, gsd_m);
    if (is_north_up(rasters[i]) && gsd_m < 0.999 * anchor_m && same_crs(rasters[i].horizontal, reference))
      finest = &rasters[i], anchor_m = gsd_m;
    all = {std::min(all.min_x, boxes[i].min_x), std::min(all.min_y, boxes[i].min_y),
           std::max(all.max_x, boxes[i].max_x), std::max(all.max_y, boxes[i].max_y)};
  }
  canvas.gsd_m = options.gsd_m > 1.05 * finest_m ? options.gsd_m : finest_m;
  const bool own_grid = finest && std::abs(anchor_m / canvas.gsd_m - 1.0) < 0.01;
  if (own_grid) canvas.gsd_m = anchor_m;
  canvas.width_of_pixel = own_grid ? finest->c[1] : finest ? finest->c[1] * canvas.gsd_m / anchor_m : canvas.gsd_m;
  canvas.height_of_pixel = own_grid ? -finest->c[5] : finest ? -finest->c[5] * canvas.gsd_m / anchor_m : canvas.gsd_m;
  const Box2 wanted = box_in_crs(site, options.margin_m, reference);
  const Box2 part{std::max(all.min_x, wanted.min_x), std::max(all.min_y, wanted.min_y),
                  std::min(all.max_x, wanted.max_x), std::min(all.max_y, wanted.max_y)};
  if (!(part.width() > 0.0 && part.height() > 0.0)) return canvas;
  const double x0 = own_grid ? finest->c[0] : 0.0, y0 = own_grid ? finest->c[3] : 0.0;
  constexpr double rounding_px = 1e-6;
  const auto down = [](double pixels) { return std::floor(pixels + rounding_px); };
  const auto up = [](double pixels) { return std::ceil(pixels - rounding_px); };
  const double west = down((part.min_x - x0) / canvas.width_of_pixel),
               east = up((part.max_x - x0) / canvas.width_of_pixel),
               north = up((part.max_y - y0) / canvas.height_of_pixel),
               south = down((part.min_y - y0) / canvas.height_of_pixel);
  canvas.left = x0 + west * canvas.width_of_pixel, canvas.top = y0 + north * canvas.height_of_pixel;
  require_possible_pixels(rasters.front().name, (east - west) * (north - south), canvas.gsd_m);
  canvas.width = static_cast<int>(east - west), canvas.height = static_cast<int>(north - south);
  return canvas;
}

/// Rasters that can be joined without resampling, in order of precedence.
using Layer = std::vector<std::size_t>;

/// A raster may go into an earlier layer where nothing that lies between them reaches its place.
std::vector<Layer> layers_of(const std::vector<OpenedRaster>& rasters, const std::vector<Box2>& boxes) {
  const auto joins = [](const OpenedRaster& raster) { return !raster.scaled && !raster.palette; };
  std::vector<Layer> layers;
  for (std::size_t i = 0; i < rasters.size(); ++i) {
    Layer* into = nullptr;
    for (std::size_t k = layers.size(); k-- > 0 && !into && joins(rasters[i]);) {
      const OpenedRaster& other = rasters[layers[k].front()];
      if (joins(other) && fit_on_one_grid(other, rasters[i])) into = &layers[k];
      if (std::any_of(layers[k].begin(), layers[k].end(), [&](std::size_t m) { return boxes[m].overlaps(boxes[i]); }))
        break;
    }
    if (into)
      into->push_back(i);
    else
      layers.push_back({i});
  }
  return layers;
}

bool has_nodata(GDALDataset& raster) {
  int found = 0;
  (void)raster.GetRasterBand(1)->GetNoDataValue(&found);
  return found != 0;
}

/// Between its rasters a layer shows nothing: they need a sign for that.
std::vector<std::string> options_of_holes(GDALDataset& first, const std::vector<const OpenedRaster*>& rasters,
                                          bool photos) {
  const OpenedRaster& raster = *rasters.front();
  std::vector<std::string> options{"-a_srs", wkt_of(raster.horizontal), "-allow_projection_difference", "-resolution",
                                   "highest"};
  const std::vector<std::string> nodata = nodata_for_all(rasters);
  options.insert(options.end(), nodata.begin(), nodata.end());
  if (!nodata.empty() || raster.nodata || (first.GetRasterBand(1)->GetMaskFlags() & GMF_ALPHA)) return options;
  if (photos)
    options.emplace_back("-addalpha");
  else
    options.insert(options.end(), {"-vrtnodata", no_height_of(raster.type)});
  return options;
}

struct OpenLayer {
  std::vector<DatasetPtr> sources;
  DatasetPtr joined, view;
  [[nodiscard]] GDALDataset& raster() const { return view ? *view : joined ? *joined : *sources.front(); }
};

OpenLayer open_layer(std::vector<OpenedRaster>& rasters, const Layer& layer, bool photos,
                     const CutRasterOptions& options) {
  OpenLayer open;
  std::vector<std::string> names;
  std::vector<const OpenedRaster*> members;
  for (const std::size_t i : layer) {
    names.push_back(rasters[i].name), members.push_back(&rasters[i]);
    if (rasters[i].dataset) open.sources.push_back(std::move(rasters[i].dataset));
  }
  const OpenedRaster& first = rasters[layer.front()];
  if (layer.size() == 1) {
    if (open.sources.empty()) open.sources.push_back(open_raster(first.name, options.of_strangers));
  } else {
    const DatasetPtr again = open.sources.empty() ? open_raster(first.name, options.of_strangers) : nullptr;
    open.joined =
        built_vrt(names, open.sources, options_of_holes(again ? *again : *open.sources.front(), members, photos));
  }
  if (photos)
    open.view = rgb_bands(first.name, open.raster()).view;
  else if (first.scaled)
    open.view = translate_to_vrt(open.raster(), {"-unscale", "-ot", "Float32"});
  return open;
}

struct DestroyTransformer {
  void operator()(void* transformer) const { GDALDestroyGenImgProjTransformer(transformer); }
};
struct DestroyApproximation {
  void operator()(void* transformer) const { GDALDestroyApproxTransformer(transformer); }
};
struct DestroyWarpOptions {
  void operator()(GDALWarpOptions* options) const { GDALDestroyWarpOptions(options); }
};

/// How bands go to bands. `out` must outlive the call that uses it.
void match_bands(GDALWarpOptions& options, GDALDataset& layer, bool photos) {
  const int bands = photos ? 3 : 1;
  options.nBandCount = bands;
  options.panSrcBands = static_cast<int*>(CPLMalloc(sizeof(int) * static_cast<std::size_t>(bands)));
  options.panDstBands = static_cast<int*>(CPLMalloc(sizeof(int) * static_cast<std::size_t>(bands)));
  for (int b = 0; b < bands; ++b) options.panSrcBands[b] = options.panDstBands[b] = b + 1;
  if (photos) options.nDstAlphaBand = 4;
  if (photos && layer.GetRasterCount() == 4 && layer.GetRasterBand(4)->GetColorInterpretation() == GCI_AlphaBand)
    options.nSrcAlphaBand = 4;
  const auto numbers = [bands](const auto& value) {
    auto* list = static_cast<double*>(CPLMalloc(sizeof(double) * static_cast<std::size_t>(bands)));
    for (int b = 0; b < bands; ++b) list[b] = value(b);
    return list;
  };
  if (has_nodata(layer) && options.nSrcAlphaBand == 0)
    options.padfSrcNoDataReal = numbers([&](int b) { return layer.GetRasterBand(b + 1)->GetNoDataValue(nullptr); });
  if (!photos) options.padfDstNoDataReal = numbers([](int) { return std::numeric_limits<double>::quiet_NaN(); });
}

void choose_resampling(GDALWarpOptions& options, const OpenedRaster& raster, const Canvas& canvas) {
  const PixelSize pixel = pixel_size(place_of(raster), raster.width, raster.height);
  const auto set = [&](const char* key, const std::string& value) {
    options.papszWarpOptions = CSLSetNameValue(options.papszWarpOptions, key, value.c_str());
  };
  set("UNIFIED_SRC_NODATA", "YES");
  set("NUM_THREADS", std::to_string(worker_count(0)));
  options.dfWarpMemoryLimit = 64.0 * (1 << 20);
  if (lies_on_grid(raster, canvas)) {
    options.eResampleAlg = GRA_NearestNeighbour;
    return;
  }
  options.eResampleAlg = canvas.gsd_m > 2.0 * pixel.gsd_m() ? GRA_Average : GRA_Cubic;
  set("XSCALE", fmt::format("{}", std::min(1.0, pixel.along_row_m / canvas.gsd_m)));
  set("YSCALE", fmt::format("{}", std::min(1.0, pixel.along_column_m / canvas.gsd_m)));
}

void draw_layer(GDALDataset& target, const Canvas& canvas, GDALDataset& layer, const OpenedRaster& first, bool photos,
                const PixelBox& window) {
  GdalOptions arguments({"SRC_SRS=" + wkt_of(first.horizontal), "DST_SRS=" + wkt_of(canvas.reference)});
  GdalErrors errors;
  const std::unique_ptr<void, DestroyTransformer> transformer(
      GDALCreateGenImgProjTransformer2(GDALDataset::ToHandle(&layer), GDALDataset::ToHandle(&target), arguments.get()));
  const std::unique_ptr<GDALWarpOptions, DestroyWarpOptions> options(GDALCreateWarpOptions());
  bool done = transformer != nullptr;
  if (done) {
    constexpr double least_seen_px = 0.02;  // of a photo; exact coordinates take ten times as long
    const std::unique_ptr<void, DestroyApproximation> approximation(
        GDALCreateApproxTransformer(GDALGenImgProjTransform, transformer.get(), least_seen_px));
    options->hSrcDS = GDALDataset::ToHandle(&layer), options->hDstDS = GDALDataset::ToHandle(&target);
    options->pfnTransformer = photos ? GDALApproxTransform : GDALGenImgProjTransform;
    options->pTransformerArg = photos ? approximation.get() : transformer.get();
    match_bands(*options, layer, photos);
    choose_resampling(*options, first, canvas);
    GDALWarpOperation operation;
    done = operation.Initialize(options.get()) == CE_None &&
           operation.ChunkAndWarpImage(static_cast<int>(window.col), static_cast<int>(window.row),
                                       static_cast<int>(window.width), static_cast<int>(window.height)) == CE_None;
  }
  throw_if_stopped();
  if (!done || errors.any())
    throw InputError(first.name, fmt::format("cannot be read to its end, or not be brought to one CRS with the others "
                                             "({}); run it again",
                                             printable(errors.text())));
}

DatasetPtr created(const fs::path& path, const Canvas& canvas, bool photos) {
  GdalOptions options({"TILED=YES", "SPARSE_OK=TRUE", "BIGTIFF=IF_SAFER", photos ? "PHOTOMETRIC=RGB" : "BLOCKXSIZE=256",
                       photos ? "ALPHA=YES" : "BLOCKYSIZE=256"});
  GdalErrors errors;
  DatasetPtr made(GetGDALDriverManager()->GetDriverByName("GTiff")->Create(
      path.c_str(), canvas.width, canvas.height, photos ? 4 : 1, photos ? GDT_Byte : GDT_Float32, options.get()));
  if (!made) throw Error(fmt::format("{}: cannot be written ({})", path.string(), errors.text()));
  double c[6] = {canvas.left, canvas.width_of_pixel, 0.0, canvas.top, 0.0, -canvas.height_of_pixel};
  made->SetGeoTransform(c);
  made->SetSpatialRef(&canvas.reference);
  if (!photos) made->GetRasterBand(1)->SetNoDataValue(std::numeric_limits<double>::quiet_NaN());
  return made;
}

/// Of all rasters. Bytes are colours, grey or a palette, unless they are told to be heights.
bool are_photos(const std::vector<OpenedRaster>& rasters, const CutRasterOptions& options) {
  const bool told_heights = !options.vertical_datum.empty() || !options.vertical_unit.empty();
  const auto photo = [told_heights](const OpenedRaster& r) {
    return r.type == GDT_Byte && (r.bands >= 3 || r.palette || !told_heights);
  };
  const OpenedRaster& first = rasters.front();
  for (const OpenedRaster& raster : rasters) {
    if (!raster.has_place)
      throw InputError(raster.name, "has no georeferencing; put a world file beside it (.jgw, .tfw)");
    if (photo(raster) != photo(first))
      throw InputError(raster.name, fmt::format("is {}, and {} is {}; give it a [[fetch]] of its own",
                                                photo(raster) ? "a picture" : "no picture", first.name,
                                                photo(first) ? "one" : "none"));
    if (!photo(raster) && raster.bands >= 3)
      throw InputError(raster.name,
                       "has samples that are no bytes, and the rasters have several CRSs; give each CRS a [[fetch]] of "
                       "its own");
    if (!photo(raster) && raster.vertical_unit != first.vertical_unit)
      throw InputError(raster.name, fmt::format("has heights in '{}', {} in '{}'; give it a [[fetch]] of its own",
                                                raster.vertical_unit.empty() ? "m" : raster.vertical_unit, first.name,
                                                first.vertical_unit.empty() ? "m" : first.vertical_unit));
  }
  return photo(first);
}
}  // namespace

Box2 box_in_crs(const SiteFrame& site, double margin_m, const OGRSpatialReference& reference) {
  TransformedBox bounds(spatial_reference(site.crs), reference);
  const Box2 box = bounds_of(site.area.outer).grown(margin_m);
  for (int i = 0; i <= steps_of_edge; ++i)
    for (int j = 0; j <= steps_of_edge; ++j)
      bounds.add(box.min_x + box.width() * i / steps_of_edge, box.min_y + box.height() * j / steps_of_edge);
  return bounds.box();
}

void require_possible_pixels(const std::string& name, double pixels, double gsd_m) {
  constexpr double most_pixels = 2e6 * 256 * 256;  // as many as the tiles of a service may have
  if (pixels > most_pixels)
    throw InputError(name, fmt::format("has {:.0f} thousand million pixels in the area, most are {:.0f}; say "
                                       "resolution_m = {:.2g} or take a smaller area",
                                       pixels / 1e9, most_pixels / 1e9, 1.1 * gsd_m * std::sqrt(pixels / most_pixels)));
}

DatasetPtr built_vrt(const std::vector<std::string>& names, const std::vector<DatasetPtr>& sources,
                     const std::vector<std::string>& extra) {
  std::vector<GDALDatasetH> handles;
  std::vector<const char*> paths;
  for (std::size_t i = names.size(); i-- > 0;)  // in a virtual raster the last lies on top
    if (sources.size() == names.size())
      handles.push_back(GDALDataset::ToHandle(sources[i].get()));
    else
      paths.push_back(names[i].c_str());
  std::vector<std::string> all = extra;
  all.emplace_back("-strict");  // else rasters that do not fit are left out
  GdalOptions arguments(all);
  const std::unique_ptr<GDALBuildVRTOptions, void (*)(GDALBuildVRTOptions*)> options(
      GDALBuildVRTOptionsNew(arguments.get(), nullptr), GDALBuildVRTOptionsFree);
  GdalErrors errors;
  int failed = 0;
  DatasetPtr result(GDALDataset::FromHandle(
      GDALBuildVRT("", static_cast<int>(names.size()), handles.empty() ? nullptr : handles.data(),
                   handles.empty() ? paths.data() : nullptr, options.get(), &failed)));
  if (!result || errors.any())
    throw InputError(names.front(), fmt::format("cannot be joined with the others ({})", printable(errors.text())));
  return result;
}

DrawnRaster draw_rasters(std::vector<OpenedRaster>& rasters, const SiteFrame& site, const fs::path& to,
                         const CutRasterOptions& options) {
  const bool photos = are_photos(rasters, options);
  const OpenedRaster& first = rasters.front();
  const bool one_crs = std::all_of(rasters.begin(), rasters.end(),
                                   [&](const auto& r) { return same_crs(r.horizontal, first.horizontal); });
  const OGRSpatialReference reference = one_crs ? first.horizontal : spatial_reference(site.crs);
  std::vector<Box2> boxes;
  boxes.reserve(rasters.size());
  for (const OpenedRaster& raster : rasters) boxes.push_back(box_of(raster, reference));
  const Canvas canvas = canvas_of(rasters, boxes, site, reference, options);
  if (canvas.width == 0 || canvas.height == 0)
    throw InputError(first.name,
                     fmt::format("shows nothing of the area, and neither do the others: the area is {}; take another "
                                 "source or area",
                                 describe_lonlat(lonlat_bounds(site.area.outer, site.crs))));
  DrawnRaster drawn{std::make_unique<AtomicFile>(fs::path(to).replace_extension(".drawn.tif")), nullptr};
  drawn.raster = created(drawn.file->path(), canvas, photos);
  const std::vector<Layer> layers = layers_of(rasters, boxes);
  for (std::size_t i = layers.size(); i-- > 0;) {
    Box2 box = boxes[layers[i].front()];
    for (const std::size_t k : layers[i])
      box = {std::min(box.min_x, boxes[k].min_x), std::min(box.min_y, boxes[k].min_y),
             std::max(box.max_x, boxes[k].max_x), std::max(box.max_y, boxes[k].max_y)};
    const PixelBox window = canvas.pixels_of(box, 2);
    if (window.empty()) continue;
    const OpenedRaster& of_layer = rasters[layers[i].front()];
    const OpenLayer layer = open_layer(rasters, layers[i], photos, options);
    draw_layer(*drawn.raster, canvas, layer.raster(), of_layer, photos, window);
  }
  drawn.raster->FlushCache(false);
  if (!photos && !first.vertical_unit.empty()) drawn.raster->GetRasterBand(1)->SetUnitType(first.vertical_unit.c_str());
  return drawn;
}

}  // namespace orthodrive::io
