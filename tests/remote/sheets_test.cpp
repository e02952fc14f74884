// SPDX-License-Identifier: Apache-2.0
// What indices of sheets say, and which sheets an area needs.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "fuzz/mutate.hpp"
#include "io/scratch.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/remote/http/link_address.hpp"
#include "orthodrive/remote/sheets/atom_feed.hpp"
#include "orthodrive/remote/sheets/sheet_choice.hpp"
#include "orthodrive/remote/sheets/stac_items.hpp"

namespace orthodrive::remote {
namespace {
using testing::ElementsAre;
using testing::HasSubstr;

Box2 bounds(const MultiPolygon& polygons) { return bounds_of_all(polygons); }

TEST(LinkAddress, is_resolved_against_its_page_and_leads_to_http_alone) {
  const std::string page = "https://me:pw@a.b/c/feed.xml?x=1";
  EXPECT_EQ(absolute_address(page, "d/e.tif"), "https://me:pw@a.b/c/d/e.tif");
  EXPECT_EQ(absolute_address(page, "../e.tif#part"), "https://me:pw@a.b/e.tif");
  EXPECT_EQ(absolute_address(page, "?token=2"), "https://me:pw@a.b/c/feed.xml?token=2");
  EXPECT_EQ(absolute_address(page, "//x.y/e f.zip"), "https://x.y/e%20f.zip");
  EXPECT_EQ(absolute_address("", "http://x.y/a%20b.tif"), "http://x.y/a%20b.tif");
  for (const char* bad :
       {"file:///etc/passwd", "s3://bucket/a.tif", "ftp://a/b", "javascript:1", "", "http://", "data:,x"})
    EXPECT_EQ(absolute_address(page, bad), "") << bad;
  EXPECT_EQ(absolute_address("", "a.tif"), "");
  EXPECT_EQ(absolute_address(page, std::string(10000, 'a')), "");
}

TEST(LinkAddress, names_a_sheet_at_its_end_or_in_its_query) {
  for (const char* good : {"http://a/b.TIF", "x.jp2?sig=1", "http://a/get.php?file=a.zip&id=4", "a.tiff#b"})
    EXPECT_TRUE(names_sheet(good)) << good;
  for (const char* bad : {"http://a.zip.de/b", "a.tifx", "a.html", "http://a/preview.jpg", "", "tif"})
    EXPECT_FALSE(names_sheet(bad)) << bad;
}

TEST(LinkKeys, go_along_to_the_same_host) {
  const LinkKeys keys("https://{env:A}:{env:B}@h.de/x?layers=1&token={env:B}",
                      "https://me:pw@h.de/x?layers=1&token=pw");
  EXPECT_EQ(keys.with("https://h.de/y.tif"), "https://me:pw@h.de/y.tif?token=pw");
  EXPECT_EQ(keys.with("https://h.de/y.tif?a=1&Token=2"), "https://me:pw@h.de/y.tif?a=1&Token=2");
  for (const char* other : {"http://h.de/y.tif", "https://h.de:444/y.tif", "https://h.de.evil.org/y.tif"})
    EXPECT_EQ(keys.with(other), other);
}

const char* const stac_page = R"({"type": "FeatureCollection", "features": [
 {"id": "a", "geometry": {"type": "Polygon", "coordinates": [[[15, 50], [16, 50], [16, 51], [15, 50]]]},
  "bbox": [1, 2, 3, 4], "properties": {"datetime": "2022-01-02T00:00:00Z", "proj:code": "EPSG:25833"},
  "assets": {"image": {"href": "a.tif", "type": "image/tiff; profile=cloud-optimized", "roles": ["data"], "file:size": 7},
             "thumb": {"href": "a.jpg", "type": "image/jpeg", "roles": ["thumbnail"]}}},
 {"id": "b", "geometry": null, "bbox": [15, 50, 0, 16, 51, 9], "properties": {"datetime": null, "end_datetime": "2021"},
  "assets": {"x": {"href": "b.jp2", "type": "image/jp2"}, "meta": {"href": "b.xml", "type": "application/xml"}}},
 {"id": "c", "geometry": {"type": "Point", "coordinates": [1, 2]}, "bbox": [170, 50, -170, 51], "properties": {},
  "assets": {"data": {"href": "c.zip"}, "B02": {"href": "c.tif"}}}],
 "links": [{"rel": "self", "href": "x"}, {"rel": "next", "href": "y", "method": "POST", "body": {"token": 3}, "merge": true}]})";

TEST(StacItems, footprint_date_crs_and_the_asset_with_the_picture) {
  const StacPage page = parse_stac_page(stac_page, "u");
  ASSERT_EQ(page.items.size(), 3U);
  const StacItem &a = page.items[0], &b = page.items[1], &c = page.items[2];
  EXPECT_EQ(bounds(a.footprint), (Box2{15, 50, 16, 51}));
  EXPECT_EQ(bounds(b.footprint), (Box2{15, 50, 16, 51}));  // with heights
  EXPECT_TRUE(c.footprint.empty());                        // across the antimeridian
  EXPECT_THAT((std::vector{a.date, b.date, c.date}), ElementsAre("2022-01-02T00:00:00Z", "2021", ""));
  EXPECT_EQ(a.crs, "EPSG:25833");
  EXPECT_EQ(chosen_asset(a, "", "u")->href, "a.tif");
  EXPECT_EQ(chosen_asset(a, "", "u")->bytes, 7);
  EXPECT_EQ(chosen_asset(a, "thumb", "u")->href, "a.jpg");
  EXPECT_EQ(chosen_asset(a, "other", "u"), nullptr);
  EXPECT_EQ(chosen_asset(b, "", "u")->href, "b.jp2");
  EXPECT_THAT(message_of<InputError>([&] { (void)chosen_asset(c, "", "u"); }), HasSubstr("2 pictures (B02, data)"));
  ASSERT_TRUE(page.next);
  EXPECT_EQ(page.next->href, "y");
  EXPECT_TRUE(page.next->merge);
  EXPECT_EQ(merged_json(R"({"limit":5,"token":1})", page.next->body), R"({"limit":5,"token":3})");
}

const char* const atom_feed =
    R"(<?xml version="1.0"?><a:feed xmlns:a="http://www.w3.org/2005/Atom" xmlns:georss="http://www.georss.org/georss"
 xmlns:gml="http://www.opengis.net/gml" xmlns:inspire_dls="http://inspire.ec.europa.eu/schemas/inspire_dls/1.0">
<a:title>DOP</a:title><a:link rel="next" href="page2.xml"/><georss:box>49 14 52 17</georss:box>
<a:entry><a:title>one</a:title><a:id>1</a:id><a:updated>2022-01-02T00:00:00Z</a:updated>
 <inspire_dls:spatial_dataset_identifier_code>c-1</inspire_dls:spatial_dataset_identifier_code>
 <a:category term="http://www.opengis.net/def/crs/EPSG/0/25833" label="ETRS89 / UTM zone 33N"/>
 <georss:polygon>50 15 50 16 51 16 51 15 50 15</georss:polygon>
 <a:link href="a.zip" rel="section" type="application/zip" bbox="15.1 50.1 15.2 50.2" length="12"/>
 <a:link href="b.zip" rel="section" type="application/zip" bbox="50.1, 15.1, 50.2, 15.2"/>
 <a:link href="c.xml" type="application/atom+xml"/><a:link href="m.xml" rel="describedby" type="application/xml"/></a:entry>
<a:entry><a:title>two</a:title><georss:where><gml:Polygon><gml:exterior><gml:LinearRing><gml:posList>50 15 50 16 51 16 50 15
 </gml:posList></gml:LinearRing></gml:exterior></gml:Polygon></georss:where></a:entry>
<a:entry><a:title>three</a:title><georss:where><gml:Envelope><gml:lowerCorner>50 15</gml:lowerCorner>
 <gml:upperCorner>51 16</gml:upperCorner></gml:Envelope></georss:where></a:entry></a:feed>)";

TEST(AtomFeed, places_links_and_systems) {
  const AtomFeed feed = parse_atom_feed(atom_feed, "u");
  ASSERT_EQ(feed.entries.size(), 3U);
  EXPECT_EQ(feed.title, "DOP");
  EXPECT_EQ(feed.links.at(0).rel, "next");
  EXPECT_EQ(bounds(feed.footprint), (Box2{14, 49, 17, 52}));
  for (const AtomEntry& entry : feed.entries) EXPECT_EQ(bounds(entry.footprint), (Box2{15, 50, 16, 51})) << entry.title;
  const AtomEntry& one = feed.entries[0];
  EXPECT_EQ(one.crs, "EPSG:25833");
  EXPECT_EQ(one.code, "c-1");
  EXPECT_EQ(one.links.at(0).bytes, 12);
  for (const int i : {0, 1}) {  // providers write both orders
    const auto box = box_of_link(one.links.at(static_cast<std::size_t>(i)), one.footprint);
    ASSERT_TRUE(box);
    EXPECT_EQ(bounds_of(box->outer), (Box2{15.1, 50.1, 15.2, 50.2}));
  }
  std::vector<bool> sheets, feeds;
  for (const AtomLink& link : one.links) sheets.push_back(leads_to_sheet(link)), feeds.push_back(leads_to_feed(link));
  EXPECT_THAT(sheets, ElementsAre(true, true, false, false));
  EXPECT_THAT(feeds, ElementsAre(false, false, true, false));
}

SiteFrame site_of(double side_m) {
  return {
      {"EPSG:32633"},
      {{{550000, 5542000}, {550000 + side_m, 5542000}, {550000 + side_m, 5542000 + side_m}, {550000, 5542000 + side_m}},
       {}}};
}

TEST(SheetChoice, one_per_place_of_the_offer_that_covers_most) {
  const SheetArea area(site_of(1000.0), "photo.tif");
  const Box2 b = area.box();
  const double middle = 0.5 * (b.min_x + b.max_x), width = b.width();
  const MultiPolygon left{lonlat_rectangle(b.min_x - 1, b.min_y - 1, middle, b.max_y + 1)},
      right{lonlat_rectangle(middle, b.min_y - 1, b.max_x + 1, b.max_y + 1)},
      away{lonlat_rectangle(b.max_x + 0.1 * width, b.min_y, b.max_x + width, b.max_y)};
  EXPECT_TRUE(area.touches(left));
  EXPECT_FALSE(area.touches(away));
  EXPECT_FALSE(area.touches({}));
  const SheetChoice choice = choose_sheets({{"old", left, "EPSG:25833", "", "2010", 0},
                                            {"new", left, "EPSG:25833", "", "2020", 0},
                                            {"new", left, "EPSG:25833", "", "2020", 0},
                                            {"right", right, "EPSG:25833", "", "2015", 0},
                                            {"half", left, "EPSG:32633", "", "2022", 0}},
                                           area, {"EPSG:32633"}, "photo.tif");
  ASSERT_EQ(choice.sheets.size(), 2U);
  EXPECT_EQ(choice.sheets[0].url, "new");
  EXPECT_EQ(choice.sheets[1].url, "right");
  EXPECT_EQ(choice.same_place, 1U);
  EXPECT_EQ(choice.other_offers, 1U);
  const SheetChoice equal = choose_sheets({{"a", left, "EPSG:25833", "", "", 0}, {"b", left, "EPSG:32633", "", "", 0}},
                                          area, {"EPSG:32633"}, "photo.tif");
  ASSERT_EQ(equal.sheets.size(), 1U);
  EXPECT_EQ(equal.sheets[0].url, "b");  // the site's
  // Two zones that meet: what one lacks is added of the other, but not in a format that only a licensed GDAL reads.
  const SheetChoice zones = choose_sheets({{"west", left, "EPSG:25832", "", "2020", 0},
                                           {"both", left, "EPSG:25833", "", "2024", 0},
                                           {"east", right, "EPSG:25833", "", "2022", 0},
                                           {"ecw", right, "EPSG:25833", "image/x-ecw", "2023", 0}},
                                          area, {"EPSG:25832"}, "photo.tif");
  ASSERT_EQ(zones.sheets.size(), 2U);
  EXPECT_EQ(zones.sheets[0].url, "both");
  const SheetChoice meeting = choose_sheets({{"west", left, "EPSG:25832", "", "2020", 0},
                                             {"ecw", right, "EPSG:25833", "image/x-ecw", "2023", 0},
                                             {"east", right, "EPSG:25833", "", "2022", 0},
                                             {"nothing new", left, "EPSG:25831", "", "2024", 0}},
                                            area, {"EPSG:25832"}, "photo.tif");
  ASSERT_EQ(meeting.sheets.size(), 2U);
  EXPECT_EQ(meeting.sheets[0].url, "east");  // the newest first
  EXPECT_EQ(meeting.sheets[1].url, "west");
  EXPECT_EQ(meeting.other_offers, 2U);
}

TEST(StacItems, assets_may_be_named_by_a_pattern) {
  StacItem item{.id = "i"};
  for (const char* key : {"a_2019_0.5_2056.tif", "a_2019_2_2056.tif", "a_2019_2_2056.xyz.zip", "x*"})
    item.assets.push_back({key, std::string("h/") + key, "", {}, 0, ""});
  EXPECT_EQ(chosen_asset(item, "*_2_2056.tif", "u")->key, "a_2019_2_2056.tif");
  EXPECT_EQ(chosen_asset(item, "a*0.5*", "u")->key, "a_2019_0.5_2056.tif");
  EXPECT_EQ(chosen_asset(item, "x*", "u")->key, "x*");
  for (const char* none : {"*_1_2056.tif", "b*", "a_2019", "", "a_2019_2_2056.ti", "*tif.zip"})
    if (*none) EXPECT_EQ(chosen_asset(item, none, "u"), nullptr) << none;
  EXPECT_THAT(message_of<InputError>([&] { (void)chosen_asset(item, "*_2_*", "u"); }), HasSubstr("has 2 pictures"));
}

TEST(SheetChoice, footprints_of_any_shape) {
  const SheetArea area(site_of(1000.0), "photo.tif");
  const Box2 b = area.box();
  const Polygon whole = lonlat_rectangle(b.min_x, b.min_y, b.max_x, b.max_y);
  EXPECT_NEAR(area.area_m2(), 1200.0 * 1200.0, 12000.0);
  MultiPolygon bow{{{{b.min_x, b.min_y}, {b.max_x, b.max_y}, {b.max_x, b.min_y}, {b.min_x, b.max_y}}, {}}};
  EXPECT_TRUE(area.touches(bow));
  EXPECT_TRUE(area.touches({whole, whole}));
  Ring many;
  for (int i = 0; i < 20000; ++i) many.push_back({b.min_x + (i % 2 ? 1e-3 : 0.0), b.min_y + 1e-7 * i});
  EXPECT_TRUE(area.touches({{many, {}}}));
  EXPECT_THAT(message_of<InputError>([&] {
                std::vector<Sheet> sheets;
                for (std::size_t i = 0; i <= most_sheets; ++i)
                  sheets.push_back({"u" + std::to_string(i), {}, "", "", "", 0});
                (void)choose_sheets(sheets, area, {"EPSG:32633"}, "photo.tif");
              }),
              HasSubstr("needs more than 5000 sheets"));
}

template <typename Read>
void expect_one_line(const std::string& sample, const Read& read) {
  ASSERT_NO_THROW(read(sample));
  for (std::uint64_t seed = 0; seed < 1000; ++seed) try {
      read(fuzz::mutate(sample, seed));
    } catch (const InputError& error) {
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << "seed " << seed;
    }
}

TEST(SheetIndices, damage_is_one_line) {
  expect_one_line(stac_page, [](const std::string& text) {
    for (const StacItem& item : parse_stac_page(text, "u").items) (void)item.assets.size();
  });
  expect_one_line(atom_feed, [](const std::string& text) {
    for (const AtomEntry& entry : parse_atom_feed(text, "u").entries)
      for (const AtomLink& link : entry.links) (void)box_of_link(link, entry.footprint);
  });
}

}  // namespace
}  // namespace orthodrive::remote
