// SPDX-License-Identifier: Apache-2.0
// Bad data: one clear line, exit code 1, nothing half-written, earlier outputs untouched.

#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>

#include "app/expect_clean_failure.hpp"
#include "paths.hpp"

namespace orthodrive {
namespace {

namespace fs = std::filesystem;

/// A small synthetic site, made by the tool, and an output folder that holds the results of an earlier run.
struct SmallSite {
  Scratch scratch;
  fs::path site = scratch / "site", out = scratch / "out";
  SmallSite() {
    const ToolRun made = run_tool({"--quiet", "synth", "--seed", "5", "--size", "300", "--gsd", "0.5", "-o", site});
    EXPECT_EQ(made.exit_code, 0) << made.err;
    fs::create_directories(out);
    write_bytes(out / "labels.tif", "labels of an earlier run");
    write_bytes(out / "roads.gpkg", "roads of an earlier run");
    write_bytes(out / "run.json", "{}");
  }
  void expect_failure(const std::string& named_file, Arguments arguments) const {
    SCOPED_TRACE(testing::PrintToString(arguments));
    arguments.insert(arguments.begin(), "--quiet");
    expect_clean_failure(scratch.folder(), named_file, [&] { return run_tool(arguments); });
  }
  /// The same bad source given to the whole pipeline and to one stage.
  void expect_build_failure(const std::string& named_file, const std::string& setting) const {
    expect_failure(named_file, {"build", site / "site.toml", "-o", out, "--set", setting});
  }
};

/// A raster of zeros: an empty band of GDAL's virtual format.
void write_flat_raster(const fs::path& path, const std::string& epsg, double west_m, double north_m) {
  write_bytes(path, "<VRTDataset rasterXSize=\"50\" rasterYSize=\"50\"><SRS>EPSG:" + epsg + "</SRS><GeoTransform>" +
                        std::to_string(west_m) + ",10,0," + std::to_string(north_m) +
                        ",0,-10</GeoTransform><VRTRasterBand dataType=\"Float32\" band=\"1\"/></VRTDataset>");
}

TEST(BadInput, photo_without_georeferencing) {
  const SmallSite small;
  const std::string photo = small.scratch / "photo.ppm";
  write_bytes(photo, "P6\n64 64\n255\n" + std::string(std::size_t{3 * 64 * 64}, '\x60'));
  small.expect_failure(photo, {"segment", photo, "-o", small.out / "labels.tif"});
  small.expect_build_failure(photo, "sources.photo=\"" + photo + "\"");
}

TEST(BadInput, list_of_photos_with_one_that_is_missing_or_broken) {
  const SmallSite small;
  std::string text = bytes_of(small.site / "site.toml");
  const std::string one = "photo = \"ortho.tif\"";
  const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(text.find(one)), '\n');
  text.replace(text.find(one), one.size(), "photo = [\"ortho.tif\", \"second.tif\"]");
  write_bytes(small.site / "site.toml", text);
  small.expect_failure("site.toml:" + std::to_string(line) + ": 'photo': there is no ",
                       {"build", small.site / "site.toml", "-o", small.out});
  write_bytes(small.site / "second.tif", "<html>404</html>");
  small.expect_failure("second.tif", {"build", small.site / "site.toml", "-o", small.out});
  fs::copy_file(small.site / "ortho.tif", small.site / "second.tif", fs::copy_options::overwrite_existing);
  truncate_to(small.site / "second.tif", 0.5);
  small.expect_failure("second.tif: is truncated", {"build", small.site / "site.toml", "-o", small.out});
  small.expect_failure("second.tif: is truncated", {"segment", small.site / "ortho.tif", small.site / "second.tif",
                                                    "-o", small.out / "labels.tif"});
}

TEST(BadInput, truncated_geotiff) {
  const SmallSite small;
  truncate_to(small.site / "ortho.tif", 0.5);
  small.expect_failure("ortho.tif", {"segment", small.site / "ortho.tif", "-o", small.out / "labels.tif"});
  small.expect_failure("ortho.tif", {"build", small.site / "site.toml", "-o", small.out});
}

TEST(BadInput, file_that_is_no_raster) {
  const SmallSite small;
  write_bytes(small.site / "dtm_1m.tif", "<html>404</html>");
  small.expect_failure("dtm_1m.tif", {"build", small.site / "site.toml", "-o", small.out});
}

TEST(BadInput, osm_with_no_road_in_the_area) {
  const SmallSite small;
  const std::string osm = small.scratch / "far.osm";
  write_bytes(
      osm,
      "<osm version=\"0.6\"><node id=\"1\" lat=\"-33.9\" lon=\"18.4\"/><node id=\"2\" lat=\"-33.9\" lon=\"18.41\"/>"
      "<way id=\"3\"><nd ref=\"1\"/><nd ref=\"2\"/><tag k=\"highway\" v=\"residential\"/></way></osm>");
  small.expect_build_failure(osm, "sources.osm=[\"" + osm + "\"]");
  small.expect_failure(
      osm, {"refine", "--osm", osm, "--labels", small.site / "truth/labels.tif", "-o", small.out / "roads.gpkg"});
}

TEST(BadInput, truncated_osm) {
  const SmallSite small;
  truncate_to(small.site / "roads.osm", 0.7);
  small.expect_failure("roads.osm", {"build", small.site / "site.toml", "-o", small.out});
  // The header of a PBF file, cut off where its first block should begin.
  const std::string pbf = small.scratch / "roads.osm.pbf";
  write_bytes(pbf, std::string("\0\0\0\x0d\x0a\x09OSMHeader\x18\x50\x0a\x10", 19));
  small.expect_build_failure(pbf, "sources.osm=[\"" + pbf + "\"]");
}

TEST(BadInput, dtm_that_does_not_cover_the_area) {
  const SmallSite small;
  const std::string dtm = small.scratch / "far.vrt";
  write_flat_raster(dtm, "32633", 400000.0, 6000000.0);
  small.expect_build_failure(dtm, "sources.dtm=[\"" + dtm + "\"]");
}

TEST(BadInput, dtm_without_a_height_in_the_roads_bounds) {
  const SmallSite small;
  const std::string dtm = small.scratch / "far.vrt";
  write_flat_raster(dtm, "32633", 400000.0, 6000000.0);
  small.expect_failure(
      dtm, {"elevate", "--roads", small.site / "truth/roads.gpkg", "--dtm", dtm, "-o", small.out / "roads.gpkg"});
}

TEST(BadInput, drive_log_with_a_broken_line) {
  const SmallSite small;
  const std::string log = small.scratch / "drive.csv";
  write_bytes(log, "time_s,lat,lon\n1,57.6,12.0\n2,57.6\n");
  small.expect_failure(log, {"elevate", "--roads", small.site / "truth/roads.gpkg", "--dtm", small.site / "dtm_1m.tif",
                             "--log", log, "-o", small.out / "roads.gpkg"});
  small.expect_build_failure(log, "sources.drive_logs=[\"" + log + "\"]");
}

TEST(BadInput, control_points_without_a_height) {
  const SmallSite small;
  const std::string points = small.scratch / "heights.geojson";
  write_bytes(points,
              R"({"type":"Feature","properties":{"z":3},"geometry":{"type":"Point","coordinates":[12.0,57.6]}})");
  small.expect_failure(points, {"elevate", "--roads", small.site / "truth/roads.gpkg", "--dtm",
                                small.site / "dtm_1m.tif", "--control-points", points, "-o", small.out / "roads.gpkg"});
  small.expect_build_failure(points, "sources.control_points=[\"" + points + "\"]");
}

TEST(BadInput, class_table_that_does_not_match_the_weights) {
  const SmallSite small;
  // A model file is 8 bytes of length, that many bytes of JSON, and the weights.
  std::string model = bytes_of(paths::in_source("models/default.safetensors"));
  ASSERT_GT(model.size(), 8u);
  std::uint64_t header_bytes = 0;
  std::memcpy(&header_bytes, model.data(), 8);
  auto header = nlohmann::json::parse(model.substr(8, header_bytes));
  auto table = nlohmann::json::parse(header["__metadata__"]["classes"].get<std::string>());
  table["classes"].erase(table["classes"].size() - 1);
  header["__metadata__"]["classes"] = table.dump();
  const std::string text = header.dump(), weights = model.substr(8 + header_bytes);
  header_bytes = text.size();
  std::string length(8, '\0');
  std::memcpy(length.data(), &header_bytes, 8);
  const std::string file = small.scratch / "one_class_less.safetensors";
  write_bytes(file, length + text + weights);
  small.expect_failure(file, {"segment", small.site / "ortho.tif", "-o", small.out / "labels.tif", "--model", file});

  truncate_to(file, 0.5);
  small.expect_failure(file, {"segment", small.site / "ortho.tif", "-o", small.out / "labels.tif", "--model", file});
}

TEST(BadInput, no_space_left) {
  const SmallSite small;
  constexpr int limit_kib = 16;  // less than a photo, a label map or a road file needs
  expect_clean_failure(small.scratch.folder(), "labels.tif", [&] {
    return run_tool_with_file_limit(limit_kib,
                                    {"--quiet", "segment", small.site / "ortho.tif", "-o", small.out / "labels.tif"});
  });
  expect_clean_failure(small.scratch.folder(), "roads.gpkg", [&] {
    return run_tool_with_file_limit(limit_kib, {"--quiet", "refine", "--osm", small.site / "roads.osm", "--labels",
                                                small.site / "truth/labels.tif", "-o", small.out / "roads.gpkg"});
  });
  fs::create_directories(small.scratch / "again");
  expect_clean_failure(small.scratch.folder(), "again", [&] {
    return run_tool_with_file_limit(
        limit_kib, {"--quiet", "synth", "--size", "300", "--gsd", "0.5", "-o", small.scratch / "again"});
  });
}

TEST(BadInput, site_file_with_a_typing_error_names_the_line_or_key) {
  const SmallSite small;
  write_bytes(small.scratch / "typo.toml", "name = \"x\"\n[area\n");
  small.expect_failure("typo.toml", {"build", small.scratch / "typo.toml", "-o", small.out});
  const ToolRun unknown_key =
      run_tool({"build", small.site / "site.toml", "-o", small.out, "--set", "sources.foto=x.tif"});
  EXPECT_EQ(unknown_key.exit_code, 2);
  EXPECT_THAT(unknown_key.err, testing::HasSubstr("sources.foto"));
}

}  // namespace
}  // namespace orthodrive
