// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "io/scratch.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/remote/http/http_client.hpp"
#include "orthodrive/remote/http/secrets.hpp"
#include "orthodrive/remote/http/url_template.hpp"
#include "orthodrive/remote/tiles/tile_store.hpp"

namespace orthodrive::remote {
namespace {
using testing::ElementsAre;
using testing::HasSubstr;

TEST(RetryAfter, is_seconds_or_a_date) {
  EXPECT_EQ(retry_after_s("120", 0), 120.0);
  EXPECT_EQ(retry_after_s("Thu, 01 Jan 1970 00:02:00 GMT", 60), 60.0);
  EXPECT_EQ(retry_after_s("Thu, 01 Jan 1970 00:02:00 GMT", 300), 0.0);  // past
  EXPECT_EQ(retry_after_s("", 0), std::nullopt);
  EXPECT_EQ(retry_after_s("soon", 0), std::nullopt);
  EXPECT_EQ(retry_after_s("99999999999999999999", 0), 1e9);
}

TEST(Pause, doubles_up_to_the_longest) {
  const HttpOptions options{.first_pause_s = 0.5, .longest_pause_s = 60.0};
  EXPECT_EQ(pause_before(2, options), 0.5);
  EXPECT_EQ(pause_before(3, options), 1.0);
  EXPECT_EQ(pause_before(8, options), 32.0);
  EXPECT_EQ(pause_before(9, options), 60.0);
  EXPECT_EQ(pause_before(1000000, options), 60.0);
}

TEST(UrlTemplate, names_are_filled_without_case) {
  EXPECT_THAT(names_in("http://a/{z}/{env:KEY}/{-y}{"), ElementsAre("z", "-y"));
  EXPECT_EQ(filled("a/{TileMatrix}/{tilecol}/{other}/{", {{"TILEMATRIX", "3"}, {"TileCol", "4"}}), "a/3/4/{other}/{");
  EXPECT_EQ(filled("{a}", {{"a", "{a}"}}), "{a}");
  EXPECT_EQ(with_query("http://a/b?map=1&service=old", {{"SERVICE", "WMTS"}, {"X", "a b"}}),
            "http://a/b?map=1&SERVICE=WMTS&X=a%20b");
  EXPECT_EQ(with_query("http://a/b", {{"X", "1"}}), "http://a/b?X=1");
  EXPECT_EQ(host_of("HTTPS://me:pw@A.b:80/c?d"), "https://a.b:80");
}

TEST(Secrets, come_from_the_environment_and_are_hidden) {
  setenv("ORTHODRIVE_TEST_KEY", "a/b c", 1);
  unsetenv("ORTHODRIVE_TEST_NONE");
  Secrets secrets;
  EXPECT_EQ(secrets.resolve("http://h/?k={env:ORTHODRIVE_TEST_KEY}&z={z}"), "http://h/?k=a%2Fb%20c&z={z}");
  EXPECT_EQ(secrets.hide("GET http://h/?k=a%2Fb%20c failed: a/b c"),
            "GET http://h/?k={env:ORTHODRIVE_TEST_KEY} failed: {env:ORTHODRIVE_TEST_KEY}");
  EXPECT_EQ(secrets.hide("http://me:pw@h/a?apikey=123&x=1&Token=abc"), "http://h/a?apikey=***&x=1&Token=***");
  EXPECT_EQ(secrets.hide("http://h/?key={env:ORTHODRIVE_TEST_KEY}"), "http://h/?key={env:ORTHODRIVE_TEST_KEY}");
  EXPECT_THAT(message_of<OptionError>([&] { (void)secrets.resolve("{env:ORTHODRIVE_TEST_NONE}"); }),
              HasSubstr("ORTHODRIVE_TEST_NONE is not set"));
}

TEST(TileStore, keeps_what_was_put_and_writes_the_same_bytes_in_any_order) {
  const Scratch scratch;
  const std::vector<TileAddress> tiles{{5, 2}, {6, 2}, {5, 3}, {6, 3}};
  std::string bytes;
  for (const bool backwards : {false, true}) {
    const auto file = scratch / (backwards ? "b.fetching" : "a.fetching");
    {
      TileStore store(file, "plan 1");
      std::vector<TileAddress> order = tiles;
      if (backwards) std::reverse(order.begin(), order.end());
      for (const TileAddress t : order)
        store.put(t, {t.column == 6 && t.row == 3, "tile " + std::to_string(t.column * 10 + t.row), "\"e\"", ""});
      store.put({9, 9}, {false, "not of the area", "", ""});
    }
    TileStore store(file, "plan 1");
    EXPECT_TRUE(store.has({5, 3}));
    EXPECT_TRUE(store.get({6, 3})->missing);
    EXPECT_EQ(store.get({6, 2})->bytes, "tile 62");
    EXPECT_FALSE(store.has({7, 7}));
    write_mbtiles(scratch / "out.mbtiles", store, 4, tiles, {{"format", "jpg"}, {"plan", "plan 1"}});
    if (backwards) {
      EXPECT_EQ(bytes_of(scratch / "out.mbtiles"), bytes);
    }
    bytes = bytes_of(scratch / "out.mbtiles");
  }
  std::vector<TileAddress> seen;
  EXPECT_TRUE(visit_mbtiles(scratch / "out.mbtiles", "plan 1", 4, [&](TileAddress t, const StoredTile& s) {
    seen.push_back(t);
    EXPECT_EQ(s.etag, "\"e\"");
  }));
  EXPECT_THAT(seen, testing::UnorderedElementsAre(tiles[0], tiles[1], tiles[2]));
  EXPECT_FALSE(
      visit_mbtiles(scratch / "out.mbtiles", "plan 2", 4, [](TileAddress, const StoredTile&) { ADD_FAILURE(); }));
  EXPECT_FALSE(TileStore(scratch / "a.fetching", "plan 2").has({5, 3}));  // another service: nothing of it counts
  write_bytes(scratch / "c.fetching", "this is no database, it is a text of some length");
  EXPECT_THAT(message_of<InputError>([&] { TileStore(scratch / "c.fetching", "p"); }), HasSubstr("is damaged"));
}

}  // namespace
}  // namespace orthodrive::remote
