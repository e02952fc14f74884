// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/remote/tiles/capabilities.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/places.hpp"
#include "io/scratch.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/remote/tiles/tile_services.hpp"

namespace orthodrive::remote {
namespace {
using testing::ElementsAre;
using testing::HasSubstr;

std::string matrix(int zoom, double denominator, const std::string& corner, int columns) {
  return fmt::format(
      "<TileMatrix><ows:Identifier>{}</ows:Identifier><ScaleDenominator>{}</ScaleDenominator><TopLeftCorner>{}</"
      "TopLeftCorner>"
      "<TileWidth>256</TileWidth><TileHeight>256</TileHeight><MatrixWidth>{}</MatrixWidth><MatrixHeight>{}</"
      "MatrixHeight></TileMatrix>",
      zoom, denominator, corner, columns, columns);
}

std::string capabilities(const std::string& sets) {
  return R"(<?xml version="1.0"?><Capabilities xmlns="http://www.opengis.net/wmts/1.0" xmlns:ows="http://www.opengis.net/ows/1.1"
 xmlns:xlink="http://www.w3.org/1999/xlink" version="1.0.0">
<ows:ServiceProvider><ows:ProviderName>Somebody</ows:ProviderName></ows:ServiceProvider>
<ows:OperationsMetadata><ows:Operation name="GetTile"><ows:DCP><ows:HTTP>
<ows:Get xlink:href="http://a/rest"><ows:Constraint name="GetEncoding"><ows:AllowedValues><ows:Value>RESTful</ows:Value></ows:AllowedValues></ows:Constraint></ows:Get>
<ows:Get xlink:href="http://a/kvp?"><ows:Constraint name="GetEncoding"><ows:AllowedValues><ows:Value>KVP</ows:Value></ows:AllowedValues></ows:Constraint></ows:Get>
</ows:HTTP></ows:DCP></ows:Operation></ows:OperationsMetadata>
<Contents><Layer><ows:Identifier>ortho_2023</ows:Identifier>
<Style><ows:Identifier>grey</ows:Identifier></Style><Style isDefault="true"><ows:Identifier>normal</ows:Identifier></Style>
<Format>image/png</Format><Format>image/jpeg</Format>
<Dimension><ows:Identifier>Time</ows:Identifier><Default>current</Default><Value>2020</Value></Dimension>
<TileMatrixSetLink><TileMatrixSet>g</TileMatrixSet><TileMatrixSetLimits><TileMatrixLimits><TileMatrix>2</TileMatrix>
<MinTileRow>1</MinTileRow><MaxTileRow>2</MaxTileRow><MinTileCol>0</MinTileCol><MaxTileCol>3</MaxTileCol></TileMatrixLimits></TileMatrixSetLimits></TileMatrixSetLink>
<TileMatrixSetLink><TileMatrixSet>u</TileMatrixSet></TileMatrixSetLink><TileMatrixSetLink><TileMatrixSet>d</TileMatrixSet></TileMatrixSetLink>
<ResourceURL format="image/jpeg" resourceType="tile" template="http://a/{Style}/{Time}/{TileMatrixSet}/{TileMatrix}/{TileRow}/{TileCol}.jpg"/>
</Layer><Layer><ows:Identifier>terrain</ows:Identifier></Layer>)" +
         sets + "</Contents></Capabilities>";
}

const std::string quad =
    "<TileMatrixSet><ows:Identifier>g</ows:Identifier><ows:SupportedCRS>urn:ogc:def:crs:EPSG:6.18:3:3857</"
    "ows:SupportedCRS>" +
    matrix(2, 139770566.00717944, "-20037508.3428 20037508.3428", 4) +
    matrix(1, 279541132.0143589, "-20037508.3428 20037508.3428", 2) + "</TileMatrixSet>";
const std::string utm =
    "<TileMatrixSet><ows:Identifier>u</ows:Identifier><ows:SupportedCRS>urn:ogc:def:crs:EPSG::25833</"
    "ows:SupportedCRS>" +
    matrix(9, 5000.0, "-46133.17 6301219.54", 900) + "</TileMatrixSet>";
const std::string degrees =
    "<TileMatrixSet><ows:Identifier>d</ows:Identifier><ows:SupportedCRS>urn:ogc:def:crs:EPSG::4326</ows:SupportedCRS>" +
    matrix(0, 279541132.0143589, "90.0 -180.0", 2) + "</TileMatrixSet>";

TEST(WmtsCapabilities, everything_that_is_used_is_read) {
  const WmtsCapabilities found = parse_wmts_capabilities(capabilities(quad + utm), "http://a");
  ASSERT_EQ(found.layers.size(), 2U);
  const WmtsLayer& layer = found.layers[0];
  EXPECT_EQ(layer.identifier, "ortho_2023");
  EXPECT_THAT(layer.styles, ElementsAre("normal", "grey"));
  EXPECT_THAT(layer.formats, ElementsAre("image/png", "image/jpeg"));
  EXPECT_THAT(layer.matrix_sets, ElementsAre("g", "u", "d"));
  EXPECT_EQ(layer.dimensions.at("Time"), "current");
  EXPECT_EQ(layer.limits.at("g").at("2").max_column, 3);
  EXPECT_THAT(layer.resource_urls.at("image/jpeg"), HasSubstr("{TileMatrix}"));
  EXPECT_EQ(found.kvp_url, "http://a/kvp?");
  EXPECT_EQ(found.attribution, "Somebody");
  ASSERT_EQ(found.matrix_sets.size(), 2U);
  EXPECT_EQ(found.matrix_sets[0].matrices[0].identifier, "1");  // coarsest first
  EXPECT_DOUBLE_EQ(found.matrix_sets[1].matrices[0].corner[1], 6301219.54);
}

TEST(WmtsCapabilities, matrix_set_that_suits_best_is_taken) {
  const SiteFrame site = site_of(1000.0);
  const auto chosen = [&](const std::string& sets, const std::string& wanted = "") {
    const WmtsCapabilities found = parse_wmts_capabilities(capabilities(sets), "http://a");
    return choose_matrix_set(found, found.layers[0], wanted, site, "http://a");
  };
  EXPECT_EQ(chosen(utm + quad + degrees).crs.definition, "EPSG:3857");
  EXPECT_EQ(quad_zoom(chosen(quad).matrices[1]), 2);
  const TileMatrixSet in_utm = chosen(degrees + utm);
  EXPECT_EQ(in_utm.crs.definition, "EPSG:25833");
  EXPECT_NEAR(in_utm.matrices[0].resolution, 1.4, 1e-12);
  EXPECT_EQ(chosen(quad + utm, "u").crs.definition, "EPSG:25833");
  const TileMatrixSet in_degrees = chosen(degrees);  // the authority writes latitude first
  EXPECT_DOUBLE_EQ(in_degrees.matrices[0].left, -180.0);
  EXPECT_DOUBLE_EQ(in_degrees.matrices[0].top, 90.0);
  EXPECT_NEAR(in_degrees.matrices[0].resolution, 0.703125, 1e-9);
  const std::string unknown =
      "<TileMatrixSet><ows:Identifier>u</ows:Identifier><ows:SupportedCRS>urn:ogc:def:crs:EPSG::999999</"
      "ows:SupportedCRS>" +
      matrix(9, 5000.0, "0 0", 9) + "</TileMatrixSet>";
  EXPECT_THAT(message_of<InputError>([&] { (void)chosen(unknown); }),
              HasSubstr("no tile matrix set in a known CRS, like EPSG:3857 or UTM; there are: u (urn:ogc"));
  EXPECT_THAT(message_of<InputError>([&] { (void)chosen(quad + utm, "x"); }),
              HasSubstr("no usable tile matrix set 'x'; there are: g (urn"));
}

TEST(WmtsCapabilities, layer_that_is_not_there_names_the_closest_first) {
  const WmtsCapabilities found = parse_wmts_capabilities(capabilities(quad), "http://a");
  EXPECT_THAT(message_of<InputError>([&] { (void)find_layer(found, "Ortho_2022", "http://a"); }),
              testing::EndsWith("no layer 'Ortho_2022'; there are: ortho_2023, terrain"));
  EXPECT_THAT(by_likeness({"b", "orthophoto", "ortho"}, "ortho20cm"), ElementsAre("ortho", "orthophoto", "b"));
}

TEST(WmtsCapabilities, what_is_no_such_document_is_told) {
  const auto said = [](const std::string& xml) {
    return message_of<InputError>([&] { (void)parse_wmts_capabilities(xml, "http://a"); });
  };
  EXPECT_THAT(said("<!DOCTYPE html><html><body>Please log in</body></html>"),
              HasSubstr("http://a: is no capabilities document of a WMTS (the server answers a page of HTML"));
  EXPECT_THAT(said(""), HasSubstr("the answer is empty"));
  EXPECT_THAT(said(capabilities(quad).substr(0, 700)), HasSubstr("XML: "));
  EXPECT_THAT(said("<ows:ExceptionReport "
                   "xmlns:ows='o'><ows:Exception><ows:ExceptionText>no\nkey</ows:ExceptionText></ows:Exception></"
                   "ows:ExceptionReport>"),
              HasSubstr("the server says: no?key"));
  EXPECT_THAT(said("<WMS_Capabilities/>"), HasSubstr("its root is <WMS_Capabilities>"));
  // Entities that expand to gigabytes elsewhere are text here.
  const std::string bomb = "<!DOCTYPE c [<!ENTITY a \"" + std::string(1000, 'x') +
                           "\"><!ENTITY b "
                           "\"&a;&a;&a;&a;\">]><Capabilities><Contents><Layer><Identifier>&b;</Identifier></Layer></"
                           "Contents></Capabilities>";
  EXPECT_EQ(parse_wmts_capabilities(bomb, "a").layers[0].identifier, "&b;");
}

TEST(WmtsCapabilities, matrices_without_sense_are_left_out) {
  const std::string odd =
      "<TileMatrixSet><ows:Identifier>g</ows:Identifier><ows:SupportedCRS>EPSG:3857</ows:SupportedCRS>" +
      matrix(1, -5.0, "0 0", 4) + matrix(2, 1e300, "0 0", 4) + matrix(3, 100.0, "0", 4) + matrix(4, 100.0, "0 0", -4) +
      matrix(5, 100.0, "0 0", 4) + "</TileMatrixSet>";
  const WmtsCapabilities found = parse_wmts_capabilities(capabilities(odd), "a");
  ASSERT_EQ(found.matrix_sets[0].matrices.size(), 1U);
  EXPECT_EQ(found.matrix_sets[0].matrices[0].identifier, "5");
}

TEST(WmsCapabilities, layers_inherit_the_crs_of_those_above) {
  const WmsCapabilities found = parse_wms_capabilities(
      R"(<WMS_Capabilities version="1.3.0" xmlns:xlink="x"><Service><MaxWidth>4096</MaxWidth></Service><Capability><Request><GetMap><Format>image/png</Format>
<DCPType><HTTP><Get><OnlineResource xlink:href="http://a/map?"/></Get></HTTP></DCPType></GetMap></Request>
<Layer><CRS>EPSG:3857</CRS><Layer><Name>photo</Name><CRS>EPSG:25833</CRS></Layer><Layer><Name>other</Name></Layer></Layer></Capability></WMS_Capabilities>)",
      "a");
  ASSERT_EQ(found.layers.size(), 2U);
  EXPECT_THAT(found.layers[0].crs, ElementsAre("EPSG:3857", "EPSG:25833"));
  EXPECT_THAT(found.layers[1].crs, ElementsAre("EPSG:3857"));
  EXPECT_EQ(found.map_url, "http://a/map?");
  EXPECT_EQ(found.max_width, 4096);
  std::string deep = "<WMT_MS_Capabilities version='1.1.1'><Capability>";
  for (int i = 0; i < 20000; ++i) deep += "<Layer><Name>a</Name><SRS>EPSG:900913 EPSG:4326</SRS>";
  for (int i = 0; i < 20000; ++i) deep += "</Layer>";
  const WmsCapabilities nested = parse_wms_capabilities(deep + "</Capability></WMT_MS_Capabilities>", "a");
  EXPECT_LE(nested.layers.size(), 101U);
  EXPECT_THAT(nested.layers[0].crs, ElementsAre("EPSG:900913", "EPSG:4326"));
}

TEST(CrsCode, of_all_ways_to_write_it) {
  for (const char* text : {"urn:ogc:def:crs:EPSG::3857", "urn:ogc:def:crs:EPSG:6.18:3:3857", "EPSG:3857", "epsg:900913",
                           "http://www.opengis.net/def/crs/EPSG/0/3857", "EPSG:102100"})
    EXPECT_EQ(crs_code_of(text), "EPSG:3857") << text;
  EXPECT_EQ(crs_code_of("urn:ogc:def:crs:OGC:1.3:CRS84"), "OGC:CRS84");
  for (const char* text : {"", "EPSG", "urn:ogc:def:crs:FOO::12", "EPSG:12x", "EPSG:123456789012"})
    EXPECT_EQ(crs_code_of(text), "") << text;
}

}  // namespace
}  // namespace orthodrive::remote
