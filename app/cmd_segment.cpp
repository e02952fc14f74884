#include <filesystem>
#include <memory>

#include "commands.hpp"
#include "orthodrive/io/raster_io.hpp"
#include "orthodrive/io/weights_io.hpp"
#include "orthodrive/segment/segment_mosaic.hpp"

namespace orthodrive::app {
namespace {
namespace fs = std::filesystem;

struct SegmentCommand {
  fs::path photo, labels, confidence;
  std::string model = "default";
  SegmentOptions options;
};

/// The whole photo in the UTM zone of its centre.
Photo read_whole_photo(const fs::path& path, int threads) {
  const io::RasterInfo info = io::raster_info(path);
  const Box2 box = bounds_of(info.outline_lonlat.outer);
  SiteFrame site{utm_crs(0.5 * (box.min_x + box.max_x), 0.5 * (box.min_y + box.max_y)), {}};
  const CoordinateTransform transform({"EPSG:4326"}, site.crs);
  for (const Vec2 p : info.outline_lonlat.outer) site.area.outer.push_back(transform.target_from_source(p));
  return io::read_photo(path, site, {.threads = threads});
}

void run(SegmentCommand& command, const Context& context) {
  command.options.threads = context.threads;
  const fs::path model_file = io::find_model(command.model);
  const SegmentModel model = load_model(io::read_file(model_file), model_file.string());
  const SegmentResult result =
      segment_mosaic(read_whole_photo(command.photo, context.threads), model, command.options, context.monitor);
  io::write_labels(command.labels, result.labels);
  if (!command.confidence.empty()) io::write_confidence(command.confidence, result.confidence);
  for (const Finding& finding : result.findings) context.monitor->info(finding.message);
}

}  // namespace

void add_segment(CLI::App& app, Context& context) {
  auto command = std::make_shared<SegmentCommand>();
  CLI::App* cmd = app.add_subcommand("segment", "Labels every pixel of an orthophoto: road, building, vegetation, ...");
  cmd->add_option("photo", command->photo, "orthophoto, any georeferenced raster GDAL reads")->required();
  cmd->add_option("-o,--output", command->labels, "label map (palette GeoTIFF with class table)")->required();
  cmd->add_option("--confidence", command->confidence, "also write the probability of each label (GeoTIFF, 0..255)");
  cmd->add_option("--model", command->model, "name in the models folder or a .safetensors file")->capture_default_str();
  cmd->add_option("--window", command->options.window_px,
                  "pixels the network sees at once, a multiple of 16; the labels do not depend on it")
      ->capture_default_str();
  cmd->footer(
      "Reads the photo and a model; writes the labels in the photo's UTM zone at the model's scale (0.5 m/px).\n"
      "Needs about 0.7 GB a thread and 10 bytes a pixel; a square kilometre takes about 3 s on two cores.\n"
      "Examples:\n"
      "  orthodrive segment ortho.tif -o labels.tif\n"
      "  orthodrive segment ortho.tif -o labels.tif --confidence confidence.tif --model out/train/model.safetensors");
  cmd->callback([command, &context] { run(*command, context); });
}

}  // namespace orthodrive::app
