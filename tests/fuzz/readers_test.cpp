// SPDX-License-Identifier: Apache-2.0
// Files of pictures, maps, roads, drives and weights.

#include <gtest/gtest.h>

#include <limits>
#include <osmium/io/any_input.hpp>
#include <osmium/io/any_output.hpp>

#include "caffe_net.pb.h"
#include "fuzz/expect_survives.hpp"
#include "io/npy_bytes.hpp"
#include "io/places.hpp"
#include "orthodrive/core/random.hpp"
#include "orthodrive/io/models/caffe_model.hpp"
#include "orthodrive/io/models/safetensors.hpp"
#include "orthodrive/io/models/safetensors_stream.hpp"
#include "orthodrive/io/opendrive/drive_log_io.hpp"
#include "orthodrive/io/opendrive/opencrg_io.hpp"
#include "orthodrive/io/osm/osm_reader.hpp"
#include "orthodrive/io/raster/raster_io.hpp"
#include "orthodrive/io/support/npy_reader.hpp"
#include "orthodrive/io/support/vector_io.hpp"
#include "orthodrive/io/vector/building_reader.hpp"
#include "orthodrive/io/vector/control_point_reader.hpp"
#include "orthodrive/io/vector/gpx_reader.hpp"
#include "orthodrive/io/vector/tree_reader.hpp"
#include "paths.hpp"
#include "roadquery/query/road_query.hpp"

namespace orthodrive::fuzz {
namespace {
namespace fs = std::filesystem;

// --- samples

const std::string osm = R"(<?xml version="1.0" encoding="UTF-8"?>
<osm version="0.6">
  <node id="1" lat="50.0000" lon="15.0000"/>
  <node id="2" lat="50.0010" lon="15.0010"/>
  <node id="3" lat="50.0020" lon="15.0010"><tag k="highway" v="traffic_signals"/></node>
  <node id="4" lat="50.0020" lon="15.0000"/>
  <node id="5" lat="50.0015" lon="15.0005"><tag k="natural" v="tree"/></node>
  <way id="10">
    <nd ref="1"/><nd ref="2"/><nd ref="3"/>
    <tag k="highway" v="primary"/><tag k="lanes" v="3"/><tag k="width" v="9.5"/><tag k="oneway" v="yes"/>
    <tag k="turn:lanes" v="left|through|right"/><tag k="maxspeed" v="50 mph"/><tag k="layer" v="1"/>
    <tag k="width:lanes" v="3|3|3.5"/><tag k="lanes:forward" v="2"/><tag k="placement" v="right_of:1"/>
  </way>
  <way id="11"><nd ref="1"/><nd ref="2"/><nd ref="3"/><nd ref="4"/><nd ref="1"/><tag k="building" v="yes"/>
    <tag k="height" v="7.5 m"/><tag k="building:levels" v="2"/><tag k="roof:shape" v="hipped"/></way>
  <way id="12"><nd ref="3"/><nd ref="4"/><tag k="highway" v="residential"/></way>
  <way id="13"><nd ref="2"/><nd ref="4"/><tag k="natural" v="tree_row"/></way>
  <relation id="20">
    <member type="way" ref="11" role="outer"/><tag k="type" v="multipolygon"/><tag k="landuse" v="grass"/>
  </relation>
  <relation id="21">
    <member type="way" ref="10" role="from"/><member type="node" ref="3" role="via"/>
    <member type="way" ref="12" role="to"/><tag k="type" v="restriction"/><tag k="restriction" v="no_left_turn"/>
  </relation>
</osm>
)";

std::string pbf_of(const std::string& xml) {
  const Scratch scratch;
  const fs::path from = scratch / "a.osm", to = scratch / "a.osm.pbf";
  write_bytes(from, xml);
  osmium::io::Reader reader(from.string());
  osmium::io::Writer writer(osmium::io::File(to.string(), "pbf,pbf_compression=none"));
  while (osmium::memory::Buffer buffer = reader.read()) writer(std::move(buffer));
  writer.close();
  return bytes_of(to);
}

const std::string gpx = R"(<?xml version="1.0"?>
<gpx version="1.1" xmlns="http://www.topografix.com/GPX/1/1"><trk><name>a</name><trkseg>
<trkpt lat="50.0001" lon="15.0001"><ele>250</ele><time>2016-05-01T12:00:00.5Z</time><fix>3d</fix></trkpt>
<trkpt lat="50.0002" lon="15.0001"><ele>251</ele><time>2016-05-01T12:00:01.5Z</time></trkpt>
<trkpt lat="50.0003" lon="15.0002"><ele>252</ele><time>2016-05-01T12:00:02.5Z</time></trkpt>
</trkseg></trk></gpx>
)";

const std::string geojson = R"({"type": "FeatureCollection", "features": [
{"type": "Feature", "properties": {"class": "road", "width": 3.5}, "geometry":
 {"type": "Polygon", "coordinates": [[[15.0, 50.0], [15.001, 50.0], [15.001, 50.001], [15.0, 50.0]]]}},
{"type": "Feature", "properties": {"class": null}, "geometry":
 {"type": "LineString", "coordinates": [[15.0, 50.0], [15.001, 50.001]]}},
{"type": "Feature", "properties": {}, "geometry": {"type": "GeometryCollection", "geometries": [
 {"type": "Point", "coordinates": [15.0, 50.0]},
 {"type": "MultiPolygon", "coordinates": [[[[15.0, 50.0], [15.001, 50.0], [15.001, 50.001], [15.0, 50.0]]]]}]}}
]}
)";

const std::string drive_log = R"(# a car
time_s,lat,lon,alt_m,sigma_m,roll_deg,pitch_deg,heading_deg,acc_x_mps2,acc_y_mps2,acc_z_mps2,speed_mps,note
0.0,50.0001,15.0001,250.0,0.02,0.5,1.0,0.0,0.1,0.0,9.81,10.0,a
0.1,50.00011,15.0001,250.0,0.02,0.5,1.0,0.0,0.1,0.0,9.81,10.0,b
0.15,,,,,,,,0.1,0.0,9.81,,
0.2,50.00012,15.0001,250.1,0.02,0.5,1.0,0.0,0.1,0.0,9.81,10.0,c
0.3,50.00013,15.0001,250.1,0.02,0.5,1.0,0.0,0.1,0.0,9.81,10.0,d
)";

CrgSurface small_crg() {
  CrgSurface s;
  s.comment = "a strip";
  s.u_increment_m = 0.5;
  s.v_m = {-1.0, 0.0, 1.0};
  for (int row = 0; row < 8; ++row) {
    s.phi_rad.push_back(0.01 * row), s.slope.push_back(0.02), s.banking.push_back(0.0);
    for (int column = 0; column < 3; ++column)
      s.grid_m.push_back(row == 4 && column == 2 ? std::numeric_limits<double>::quiet_NaN()
                                                 : 0.01 * row + 0.1 * column);
  }
  s.phi_rad[0] = s.phi_rad[1];
  integrate_reference_line(s, 1.0, 2.0, 3.0);
  return s;
}

template <typename Write>
std::string written(const std::string& name, const Write& write) {
  const Scratch scratch;
  write(scratch / name);
  return bytes_of(scratch / name);
}

TensorFile small_tensors() {
  TensorFile file;
  file.metadata = {{"architecture", "mobilenetv2-s16-fpn2"}, {"gsd_m", "0.5"}};
  file.tensors["a/kernel"] = {{2, 3}, {1, 2, 3, 4, 5, 6}, TensorType::f32};
  file.tensors["b"] = {{4}, {1, 2, 3, 4}, TensorType::f16};
  file.tensors["empty"] = {{0}, {}, TensorType::f32};
  return file;
}

std::string small_caffe_net() {
  caffe::NetParameter net;
  net.set_name("small");
  const auto add = [&net](const char* name, const char* type, const std::vector<std::vector<int>>& shapes) {
    caffe::LayerParameter* layer = net.add_layer();
    layer->set_name(name), layer->set_type(type);
    for (const auto& shape : shapes) {
      caffe::BlobProto* blob = layer->add_blobs();
      int count = 1;
      for (const int n : shape) blob->mutable_shape()->add_dim(n), count *= n;
      for (int i = 0; i < count; ++i) blob->add_data(static_cast<float>(i));
    }
    return layer;
  };
  add("conv", "Convolution", {{4, 2, 3, 3}, {4}});
  add("depthwise", "Convolution", {{4, 1, 3, 3}})->mutable_convolution_param()->set_group(4);
  add("up", "Deconvolution", {{2, 2, 4, 4}});
  add("norm", "BatchNorm", {{4}, {4}, {1}});
  add("scale", "Scale", {{4}, {4}});
  add("fc", "InnerProduct", {{2, 5}, {2}});
  caffe::V1LayerParameter* old = net.add_layers();
  old->set_name("old"), old->set_type(4);
  caffe::BlobProto* blob = old->add_blobs();
  blob->set_num(1), blob->set_channels(1), blob->set_height(2), blob->set_width(2);
  for (int i = 0; i < 4; ++i) blob->add_data(1.0F);
  return net.SerializeAsString();
}

GridFrame small_grid() { return {origin.x, origin.y + 16.0, 1.0, 16, 16}; }

// --- the tests

TEST(FuzzReaders, osm) {
  expect_survives("a.osm", osm, [](const fs::path& file) { (void)io::read_osm(file, utm33); });
}
TEST(FuzzReaders, osm_roads) {
  const SiteFrame site = lonlat_site(14.9, 49.9, 15.1, 50.1);
  expect_survives("a.osm", osm, [&](const fs::path& file) {
    Findings findings;
    (void)io::read_osm_roads(file, site, &findings);
  });
}
TEST(FuzzReaders, osm_features) {
  expect_survives("a.osm", osm, [](const fs::path& file) { (void)io::read_osm_features(file, utm33); });
}
TEST(FuzzReaders, osm_buildings) {
  const SiteFrame site = lonlat_site(14.9, 49.9, 15.1, 50.1);
  expect_survives("a.osm", osm, [&](const fs::path& file) {
    Findings findings;
    (void)io::read_buildings({file}, site, &findings);
  });
}
TEST(FuzzReaders, osm_trees) {
  const SiteFrame site = lonlat_site(14.9, 49.9, 15.1, 50.1);
  expect_survives("a.osm", osm, [&](const fs::path& file) { (void)io::read_trees({file}, site); });
}
TEST(FuzzReaders, osm_pbf) {
  expect_survives("a.osm.pbf", pbf_of(osm), [](const fs::path& file) { (void)io::read_osm(file, utm33); });
}
TEST(FuzzReaders, osm_pbf_roads) {
  const SiteFrame site = lonlat_site(14.9, 49.9, 15.1, 50.1);
  expect_survives("a.osm.pbf", pbf_of(osm), [&](const fs::path& file) {
    Findings findings;
    (void)io::read_osm_roads(file, site, &findings);
  });
}
TEST(FuzzReaders, osm_pbf_features) {
  expect_survives("a.osm.pbf", pbf_of(osm), [](const fs::path& file) { (void)io::read_osm_features(file, utm33); });
}
/// libosmium would walk past the end of the tag list.
TEST(FuzzReaders, osm_pbf_with_a_zero_byte_in_a_tag) {
  std::string bytes = pbf_of(osm);  // before our own scratch folder, which has the same name
  const Scratch scratch;
  const fs::path file = scratch / "a.osm.pbf";
  const std::size_t at = bytes.find("highway");
  ASSERT_NE(at, std::string::npos);
  bytes[at + 3] = '\0';
  write_bytes(file, bytes);
  try {
    (void)io::read_osm(file, utm33);
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("holds a zero byte"), std::string::npos) << error.what();
  }
}
TEST(FuzzReaders, gpx) {
  const SiteFrame site = lonlat_site(14.99, 49.99, 15.01, 50.01);
  expect_survives("a.gpx", gpx, [&](const fs::path& file) { (void)io::read_gpx({file}, site); });
}
TEST(FuzzReaders, geojson) {
  expect_survives("a.geojson", geojson, [](const fs::path& file) { (void)io::read_features(file, utm33); });
}
TEST(FuzzReaders, geojson_buildings) {
  const SiteFrame site = lonlat_site(14.9, 49.9, 15.1, 50.1);
  const std::string sample = R"({"type": "FeatureCollection", "features": [
{"type": "Feature", "properties": {"t": "school", "h": 7, "lv": 2.5, "n": "Škola"}, "geometry": {"type": "Polygon",
 "coordinates": [[[15.0, 50.0], [15.001, 50.0], [15.001, 50.001], [15.0, 50.0]]]}},
{"type": "Feature", "properties": {"building": "yes", "height": "5 m"}, "geometry": {"type": "Polygon",
 "coordinates": [[[15.0, 50.0], [15.001, 50.0], [15.001, 50.001], [15.0, 50.0]]]}}]})";
  expect_survives("a.geojson", sample, [&](const fs::path& file) {
    Findings findings;
    (void)io::read_buildings({file}, site, &findings);
  });
}
TEST(FuzzReaders, control_points_geojson) {
  const SiteFrame site = lonlat_site(14.99, 49.99, 15.01, 50.01);
  const std::string sample = bytes_of(paths::in_source("tests/fuzz/corpus/control_points/heights.geojson"));
  expect_survives("a.geojson", sample, [&](const fs::path& file) { (void)io::read_control_points({file}, site); });
}
TEST(FuzzReaders, drive_log_csv) {
  const SiteFrame site = lonlat_site(14.99, 49.99, 15.01, 50.01);
  expect_survives("a.csv", drive_log, [&](const fs::path& file) { (void)io::read_drive_logs({file}, site); });
}
TEST(FuzzReaders, npy) {
  expect_survives("a.npy", npy<double>("<f8", "(2, 3)", {1, 2, 3, 4, 5, 6}),
                  [](const fs::path& file) { (void)io::read_npy(file); });
}
TEST(FuzzReaders, opendrive) {
  const std::string sample = bytes_of(paths::in_source("tests/roadquery/arc.xodr"));
  expect_survives<std::runtime_error>("a.xodr", sample, [](const fs::path& file) {
    const roadquery::RoadQuery query(roadquery::read_opendrive(file.string()));
    roadquery::Cursor cursor;
    for (const double x : {0.0, 50.0, 99.0}) (void)query.find(x, 0.5 * x, 20.0, cursor);
  });
}
TEST(FuzzReaders, opencrg_text) {
  const std::string sample =
      written("a.crg", [](const fs::path& file) { io::write_crg(file, small_crg(), CrgFormat::lrfi); });
  expect_survives("a.crg", sample, [](const fs::path& file) { (void)io::read_crg(file); });
}
TEST(FuzzReaders, opencrg_binary) {
  const std::string sample =
      written("a.crg", [](const fs::path& file) { io::write_crg(file, small_crg(), CrgFormat::kdbi); });
  expect_survives("a.crg", sample, [](const fs::path& file) { (void)io::read_crg(file); });
}
TEST(FuzzReaders, safetensors) {
  expect_survives("a.safetensors", format_safetensors(small_tensors()),
                  [](const fs::path& file) { (void)parse_safetensors(bytes_of(file), file.string()); });
}
TEST(FuzzReaders, safetensors_stream) {
  expect_survives("a.safetensors", format_safetensors(small_tensors()),
                  [](const fs::path& file) { (void)read_safetensors(file); });
}
TEST(FuzzReaders, caffe_model) {
  expect_survives("a.caffemodel", small_caffe_net(),
                  [](const fs::path& file) { (void)parse_caffe_model(bytes_of(file), file.string()); });
}
TEST(FuzzReaders, terrain_tiff) {
  const std::string sample = written("a.tif", [](const fs::path& file) {
    HeightGrid grid{utm33, small_grid(), Raster<float>(16, 16), ""};
    Random random(1);
    for (float& z : grid.height_m.data) z = static_cast<float>(random.uniform(100.0, 110.0));
    io::write_dtm(file, grid);
  });
  const Box2 box = bounds_of(site_of(16.0).area.outer);
  expect_survives("a.tif", sample, [&](const fs::path& file) { (void)io::read_heights(file, utm33, box); });
}
TEST(FuzzReaders, label_tiff) {
  const std::string sample = written("a.tif", [](const fs::path& file) {
    LabelMap labels{utm33, small_grid(), Raster<std::uint8_t>(16, 16), default_class_table()};
    Random random(2);
    for (std::uint8_t& label : labels.labels.data) label = static_cast<std::uint8_t>(random.below(3));
    io::write_labels(file, labels);
  });
  expect_survives("a.tif", sample, [](const fs::path& file) { (void)io::read_labels(file, default_class_table()); });
}
TEST(FuzzReaders, photo_tiff) {
  const std::string sample = written("a.tif", [](const fs::path& file) {
    Photo photo{utm33, small_grid(), Raster<std::uint8_t>(16, 16, 3), Raster<std::uint8_t>(16, 16, 1, 1)};
    Random random(3);
    for (std::uint8_t& v : photo.rgb.data) v = static_cast<std::uint8_t>(random.below(256));
    io::write_photo(file, photo);
  });
  const SiteFrame site = site_of(16.0);
  expect_survives("a.tif", sample, [&](const fs::path& file) { (void)io::read_photo(file, site, {.threads = 1}); });
}
}  // namespace
}  // namespace orthodrive::fuzz
