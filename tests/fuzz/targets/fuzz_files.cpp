// SPDX-License-Identifier: Apache-2.0
// Readers of files that the tool opens. The name of the program says which one: fuzz_gpx reads what is in corpus/gpx.
// To add a reader, add a line to the table below, its name to tools/fuzz and a small valid file to the corpus.

#include <fcntl.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

#include "io/places.hpp"
#include "memory_file.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/io/models/alignment_io.hpp"
#include "orthodrive/io/models/caffe_model.hpp"
#include "orthodrive/io/models/safetensors.hpp"
#include "orthodrive/io/models/safetensors_stream.hpp"
#include "orthodrive/io/opendrive/drive_log_io.hpp"
#include "orthodrive/io/raster/raster_io.hpp"
#include "orthodrive/io/raster/sheet_files.hpp"
#include "orthodrive/io/support/npy_reader.hpp"
#include "orthodrive/io/support/vector_io.hpp"
#include "orthodrive/io/tiles/tile_reader.hpp"
#include "orthodrive/io/vector/building_reader.hpp"
#include "orthodrive/io/vector/control_point_reader.hpp"
#include "orthodrive/io/vector/gpx_reader.hpp"
#include "orthodrive/io/vector/sheet_index_reader.hpp"
#include "orthodrive/io/vector/surroundings_reader.hpp"
#include "orthodrive/io/vector/tree_reader.hpp"
#include "orthodrive/lab/training/experiment.hpp"
#include "orthodrive/model/rasters/class_table_json.hpp"
#include "orthodrive/pipeline/sources/site.hpp"
#include "orthodrive/synth/plan/track_table.hpp"

namespace {
namespace fs = std::filesystem;
using namespace orthodrive;

/// The places of the corpus lie in it: 50 N, 15 E.
const SiteFrame& site() {
  static const SiteFrame frame = lonlat_site(14.99, 49.99, 15.01, 50.01);
  return frame;
}

std::string text_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// Two readers of a run must not save each other: what the first refuses the second gets all the same.
template <typename Read>
void attempt(const Read& read) {
  try {
    read();
  } catch (const Error& error) {
    fuzz::expect_one_line(error.what());
  }
}

void read_osm_file(const fs::path& file) {
  Findings findings;
  attempt([&] { (void)io::read_osm_roads(file, site(), &findings); });
  attempt([&] { (void)io::read_osm_features(file, utm33); });
}

void read_map(const fs::path& file) {
  Findings findings;
  attempt([&] { (void)io::read_features(file, utm33); });
  attempt([&] { (void)io::read_buildings({file}, site(), &findings); });
  attempt([&] { (void)io::read_surroundings({file}, site(), &findings); });
  attempt([&] { (void)io::read_trees({file}, site()); });
}

void read_raster(const fs::path& file) {
  attempt([&] { (void)io::raster_info(file); });
  attempt([&] { (void)io::read_heights(file, utm33, {499990.0, 5539990.0, 500020.0, 5540020.0}); });
  attempt([&] { (void)io::read_labels(file, default_class_table()); });
  attempt([&] { (void)io::read_confidence(file); });
  attempt([&] { (void)io::read_photo(file, site(), {.gsd_m = 10.0, .threads = 1}); });
}

void read_picture(const fs::path& file) {
  const std::string bytes = text_of(file);
  attempt([&] {
    (void)io::decode_image({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
  });  // NOLINT: bytes
  attempt([&] { (void)io::read_image(file); });
}

void read_weights(const fs::path& file) {
  attempt([&] { (void)parse_safetensors(text_of(file), file.string()); });
  attempt([&] { (void)read_safetensors(file); });
}

void read_road_layers(const fs::path& file) {
  attempt([&] { (void)io::holds_roads(file); });
  attempt([&] { (void)io::read_roads(file); });
  attempt([&] { (void)io::read_roughness(file); });
}

void read_table(const fs::path& file) {
  const std::string text = text_of(file);
  attempt([&] { (void)synth::parse_track(text, file.string()); });
  attempt([&] { (void)synth::parse_heights(text, file.string()); });
}

void read_sheets(const fs::path& file) {
  attempt([&] { io::visit_sheet_index(file, "a", {14.0, 49.0, 17.0, 52.0}, [](io::IndexedSheet&&) {}); });
  attempt([&] { (void)io::rasters_in(file, "a"); });
}

struct Reader {
  std::string_view name;       ///< of the target and of its corpus
  std::string_view file_name;  ///< readers go by its end
  void (*read)(const fs::path& file);
};
constexpr Reader readers[] = {
    {"osm_xml", "a.osm", read_osm_file},
    {"osm_pbf", "a.osm.pbf", read_osm_file},
    {"geojson", "a.geojson", read_map},
    {"raster", "a.tif", read_raster},
    {"picture", "a.png", read_picture},
    {"sheet_index", "a", read_sheets},
    {"site", "a.toml", [](const fs::path& file) { (void)read_site(file); }},
    {"experiment", "a.toml", [](const fs::path& file) { (void)parse_experiment(text_of(file), file); }},
    {"safetensors", "a.safetensors", read_weights},
    {"caffemodel", "a.caffemodel", [](const fs::path& file) { (void)parse_caffe_model(text_of(file), file.string()); }},
    {"gpx", "a.gpx", [](const fs::path& file) { (void)io::read_gpx({file}, site()); }},
    {"drive_log", "a.csv", [](const fs::path& file) { (void)io::read_drive_logs({file}, site()); }},
    {"control_points", "a.geojson", [](const fs::path& file) { (void)io::read_control_points({file}, site()); }},
    {"alignment", "a.csv", [](const fs::path& file) { (void)io::read_alignment(file, {}); }},
    {"table", "a.csv", read_table},
    {"npy", "a.npy", [](const fs::path& file) { (void)io::read_npy(file); }},
    {"class_json", "a.json", [](const fs::path& file) { (void)class_table_from_json(text_of(file)); }},
    {"road_layers", "a.gpkg", read_road_layers},
    {"tile", "tile_0_0.glb", [](const fs::path& file) { (void)io::read_tile_glb({.path = file}); }},
    {"tileset", "tileset.json", [](const fs::path& file) { (void)io::read_tileset(file.parent_path()); }},
};

const Reader* chosen = nullptr;
fs::path folder;

/// libosmium 2.19 leaves a damaged PBF file open, one a refused input.
void close_left_open() {
  std::error_code error;
  for (const auto& entry : fs::directory_iterator("/proc/self/fd", error))
    if (fs::read_symlink(entry.path(), error).parent_path() == folder) close(std::stoi(entry.path().filename()));
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int*, char*** arguments) {
  const std::string name = fs::path((*arguments)[0]).filename();
  for (const Reader& reader : readers)
    if (name == "fuzz_" + std::string(reader.name)) chosen = &reader;
  if (!chosen) std::abort();
  folder = fs::path(fs::exists("/dev/shm") ? "/dev/shm" : "/tmp") / ("orthodrive_" + name + std::to_string(getpid()));
  fs::create_directories(folder);
  std::atexit([] {
    std::error_code error;
    fs::remove_all(folder, error);
  });
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static unsigned runs = 0;
  const fs::path file = folder / chosen->file_name;
  {
    const int descriptor = open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    if (descriptor < 0 || write(descriptor, data, size) != static_cast<ssize_t>(size)) std::abort();
    close(descriptor);
  }
  try {
    chosen->read(file);
  } catch (const Error& error) {
    fuzz::expect_one_line(error.what());
  }
  if (++runs % 64 == 0) close_left_open();
  return 0;
}
