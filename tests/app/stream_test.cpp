// SPDX-License-Identifier: Apache-2.0
// Whole mosaics through the tool: memory that does not grow with them, and photos of unusual kinds.

#include <sys/resource.h>
#include <sys/wait.h>

#include <cstdlib>

#include "app/expect_clean_failure.hpp"
#include "orthodrive/io/raster/raster_io.hpp"
#include "paths.hpp"

namespace orthodrive {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

/// A photo of 128 x 128 m.
fs::path small_photo(const Scratch& scratch) {
  Photo photo{{"EPSG:32633"},
              {500000.0, 5540000.0, 0.5, 256, 256},
              Raster<std::uint8_t>(256, 256, 3),
              Raster<std::uint8_t>(256, 256, 1, 1)};
  for (std::size_t i = 0; i < photo.rgb.data.size(); ++i)
    photo.rgb.data[i] = static_cast<std::uint8_t>(60 + 13 * i % 101);
  io::write_photo(scratch / "photo.tif", photo);
  return scratch / "photo.tif";
}

/// The small photo in the middle of a mosaic of so many pixels a side; nodata around it.
fs::path mosaic_of(const Scratch& scratch, const fs::path& photo, int size_px) {
  const std::string size = std::to_string(size_px), offset = std::to_string(size_px / 2 - 128);
  std::string bands;
  for (const char* band : {"1", "2", "3"})
    bands += std::string("<VRTRasterBand dataType=\"Byte\" band=\"") + band +
             "\"><NoDataValue>0</NoDataValue><ComplexSource><SourceFilename>" + photo.string() +
             "</SourceFilename><SourceBand>" + band +
             "</SourceBand><SrcRect xOff=\"0\" yOff=\"0\" xSize=\"256\" ySize=\"256\"/><DstRect xOff=\"" + offset +
             "\" yOff=\"" + offset + "\" xSize=\"256\" ySize=\"256\"/></ComplexSource></VRTRasterBand>";
  const fs::path path = scratch / ("mosaic-" + size + ".vrt");
  write_bytes(path, "<VRTDataset rasterXSize=\"" + size + "\" rasterYSize=\"" + size +
                        "\"><SRS>EPSG:32633</SRS><GeoTransform>500000,0.5,0,5540000,0,-0.5</GeoTransform>" + bands +
                        "</VRTDataset>");
  return path;
}

/// Largest resident size of the tool while it segments, in MB.
double peak_mb(const Scratch& scratch, const fs::path& photo) {
  const pid_t child = start_program({paths::tool, "--quiet", "--threads", "1", "segment", photo, "-o",
                                     scratch / "labels.tif", "--confidence", scratch / "confidence.tif"},
                                    scratch / "out", scratch / "err");
  int status = 0;
  rusage usage{};
  EXPECT_EQ(wait4(child, &status, 0, &usage), child);
  EXPECT_EQ(status, 0) << bytes_of(scratch / "err");
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

TEST(Stream, memory_does_not_grow_with_the_mosaic) {
  const Scratch scratch;
  setenv("GDAL_CACHEMAX", "16", 1);  // MB: the cache of 128 MB, full or not, would hide what grows
  const fs::path photo = small_photo(scratch);
  const double small = peak_mb(scratch, mosaic_of(scratch, photo, 3000));
  const double large = peak_mb(scratch, mosaic_of(scratch, photo, 9000));
  unsetenv("GDAL_CACHEMAX");
  // One thread, or the network itself would make the difference. 72 megapixels more: photo and labels in memory would
  // be 400 MB of that and the resampled photo 300 MB.
  EXPECT_LT(large, small + 100.0);
  EXPECT_LT(small, 2000.0);
  const LabelMap labels = io::read_labels(scratch / "labels.tif");
  EXPECT_NEAR(labels.frame.width, 9000, 1);
  EXPECT_EQ(labels.labels.at(4500 - 130, 4500), label_nodata);
  EXPECT_LT(labels.labels.at(4500, 4500), 8);
}

TEST(Stream, sixteen_bits_are_refused_with_the_remedy_and_one_band_is_grey) {
  const Scratch scratch;
  fs::create_directories(scratch / "out");
  const std::string sixteen = scratch / "sixteen.vrt", one = scratch / "one.vrt";
  const std::string photo = small_photo(scratch);
  const auto vrt = [&](const std::string& type) {
    return "<VRTDataset rasterXSize=\"256\" "
           "rasterYSize=\"256\"><SRS>EPSG:32633</SRS><GeoTransform>500000,0.5,0,5540000,0,"
           "-0.5</GeoTransform><VRTRasterBand dataType=\"" +
           type + "\" band=\"1\"><SimpleSource><SourceFilename>" + photo +
           "</SourceFilename><SourceBand>1</SourceBand></SimpleSource></VRTRasterBand></VRTDataset>";
  };
  write_bytes(sixteen, vrt("UInt16"));
  expect_clean_failure(scratch.folder(), sixteen, [&] {
    const ToolRun run = run_tool({"--quiet", "segment", sixteen, "-o", scratch / "out/labels.tif"});
    EXPECT_THAT(run.err, HasSubstr("gdal_translate -ot Byte"));
    return run;
  });
  write_bytes(one, vrt("Byte"));
  EXPECT_EQ(run_tool({"--quiet", "segment", one, "-o", scratch / "out/labels.tif"}).exit_code, 0);
  EXPECT_LT(io::read_labels(scratch / "out/labels.tif").labels.at(100, 100), 8);
}

TEST(Stream, photo_without_data_is_told_and_gets_no_label) {
  const Scratch scratch;
  const fs::path nothing = mosaic_of(scratch, scratch / "missing.tif", 300);
  std::string text = bytes_of(nothing);
  while (text.find("<ComplexSource>") != std::string::npos)
    text.erase(text.find("<ComplexSource>"),
               text.find("</ComplexSource>") + sizeof "</ComplexSource>" - 1 - text.find("<ComplexSource>"));
  write_bytes(nothing, text);
  const ToolRun run = run_tool({"segment", nothing, "-o", scratch / "labels.tif"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr("no data anywhere"));
  const LabelMap labels = io::read_labels(scratch / "labels.tif");
  EXPECT_TRUE(std::all_of(labels.labels.data.begin(), labels.labels.data.end(),
                          [](int label) { return label == label_nodata; }));
}

TEST(Stream, output_that_cannot_be_written_is_told_before_the_work) {
  const Scratch scratch;
  const std::string photo = small_photo(scratch);
  expect_clean_failure(scratch.folder(), photo, [&] {  // a file is no folder
    return run_tool({"--quiet", "segment", photo, "-o", photo + "/labels.tif"});
  });
}

}  // namespace
}  // namespace orthodrive
