#include <filesystem>
#include <memory>
#include <optional>

#include "commands.hpp"
#include "photo_site.hpp"
#include "orthodrive/io/raster_io.hpp"
#include "orthodrive/io/weights_io.hpp"
#include "orthodrive/segment/segment_mosaic.hpp"

namespace orthodrive::app {
namespace {
namespace fs = std::filesystem;

struct SegmentCommand {
  fs::path photo, labels, confidence, road_probability;
  std::string model = "default";
  bool crf = false;
  int crf_iterations = 0;  ///< 0: the model's
  SegmentOptions options;
};

void run(SegmentCommand& command, const Context& context) {
  command.options.threads = context.threads;
  const fs::path model_file = io::find_model(command.model);
  const SegmentModel model = load_model(io::read_file(model_file), model_file.string());
  if (command.crf) {
    if (!model.crf)
      context.monitor->info("the model has no trained CRF: using the widths and weights of the reference's grid search");
    command.options.crf = model.crf ? *model.crf : reference_crf(static_cast<int>(model.classes.classes.size()));
    if (command.crf_iterations > 0) command.options.crf->parameters.iterations = command.crf_iterations;
  }
  const PhotoSource photo = io::open_photo(command.photo, site_of_photo(command.photo), {.threads = context.threads});
  const GridFrame frame = label_frame(photo.frame, model);
  io::RasterStream labels = io::stream_labels(command.labels, photo.crs, frame, model.classes);
  std::optional<io::RasterStream> confidence, road_probability;
  if (!command.confidence.empty()) confidence.emplace(io::stream_confidence(command.confidence, photo.crs, frame));
  if (!command.road_probability.empty())
    road_probability.emplace(io::stream_confidence(command.road_probability, photo.crs, frame));
  const SegmentSummary summary = segment_mosaic(
      photo, model,
      [&](const PixelBox& box, const LabelledPixels& pixels) {
        labels.write(box, pixels.labels);
        if (confidence) confidence->write(box, pixels.confidence);
        if (road_probability) road_probability->write(box, pixels.road_probability);
      },
      command.options, context.monitor);
  labels.finish();
  if (confidence) confidence->finish();
  if (road_probability) road_probability->finish();
  for (const Finding& finding : summary.findings) context.monitor->info(finding.message);
}

}  // namespace

void add_segment(CLI::App& app, Context& context) {
  auto command = std::make_shared<SegmentCommand>();
  CLI::App* cmd = app.add_subcommand("segment", "Labels every pixel of an orthophoto: road, building, vegetation, ...");
  cmd->add_option("photo", command->photo, "orthophoto, any georeferenced raster GDAL reads")->required();
  cmd->add_option("-o,--output", command->labels, "label map (palette GeoTIFF with class table)")->required();
  cmd->add_option("--confidence", command->confidence, "also write the probability of each label (GeoTIFF, 0..255)");
  cmd->add_option("--road-probability", command->road_probability,
                  "also write the probability of road, whatever the label (GeoTIFF, 0..255): for `refine`");
  cmd->add_option("--model", command->model, "name in the models folder or a .safetensors file")->capture_default_str();
  cmd->add_flag("--crf", command->crf, "refine the labels along the photo's edges by a dense conditional random field");
  cmd->add_option("--crf-iterations", command->crf_iterations, "mean-field iterations; 0: as trained")->check(CLI::Range(0, 100));
  cmd->add_option("--window", command->options.window_px,
                  "pixels decided at once, in each direction; 0: as suits memory; the labels do not depend on it")
      ->capture_default_str();
  cmd->footer(
      "Reads the photo and a model; writes the labels in the photo's UTM zone at the model's scale (0.5 m/px);\n"
      "a photo of 0.3 m/px and finer is read at the finest scale the model knows (0.4 m/px) and gets labels of 0.2 m/px.\n"
      "The photo: 8 bit a band; its first three bands are red, green, blue; one band is taken as grey, a palette as "
      "its\n"
      "colours. Pixels that are nodata, transparent or masked get no label (255). 16 bit is refused: convert it "
      "first.\n"
      "Photo and labels stream: memory does not grow with the mosaic, about 0.9 GB a thread; 93 megapixels take half\n"
      "a minute on two cores, with the CRF a minute and a half.\n"
      "Examples:\n"
      "  orthodrive segment ortho.tif -o labels.tif\n"
      "  orthodrive segment ortho.tif -o labels.tif --confidence confidence.tif --model out/train/model.safetensors");
  cmd->callback([command, &context] { run(*command, context); });
}

}  // namespace orthodrive::app
