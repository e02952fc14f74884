// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/remote/source/source_record.hpp"

#include <gtest/gtest.h>

#include "io/places.hpp"
#include "io/scratch.hpp"

namespace orthodrive::remote {
namespace {

TEST(SourceRecord, tells_whose_a_file_is_and_for_what_it_was_fetched) {
  const Scratch scratch;
  FetchSource source{.to = scratch / "a.tif", .url = "http://a"};
  const SiteFrame site = site_of(100.0), other = site_of(101.0);
  EXPECT_EQ(local_state(source, site), LocalState::absent);
  write_bytes(source.to, "pixels");
  EXPECT_EQ(local_state(source, site), LocalState::users_own);
  write_bytes(placing_mark(source), "");  // killed between the file and its record
  EXPECT_EQ(local_state(source, site), LocalState::outdated);
  write_record(source, {.request = request_hash(source, site)});
  EXPECT_EQ(local_state(source, site), LocalState::outdated);
  std::filesystem::remove(placing_mark(source));
  EXPECT_EQ(local_state(source, site), LocalState::complete);
  EXPECT_EQ(local_state(source, other), LocalState::outdated);
  source.resolution_m = 0.25;
  EXPECT_EQ(local_state(source, site), LocalState::outdated);
  write_bytes(record_file(source), "{\"request\": 7");  // damaged
  EXPECT_EQ(local_state(source, site), LocalState::outdated);
}

}  // namespace
}  // namespace orthodrive::remote
