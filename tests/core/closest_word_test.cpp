// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/core/closest_word.hpp"

#include <gtest/gtest.h>

namespace orthodrive {
namespace {

TEST(ClosestWord, distance_counts_letters_inserted_dropped_changed_and_swapped) {
  EXPECT_EQ(edit_distance("", ""), 0);
  EXPECT_EQ(edit_distance("", "osm"), 3);
  EXPECT_EQ(edit_distance("photo", "photo"), 0);
  EXPECT_EQ(edit_distance("foto", "photo"), 2);
  EXPECT_EQ(edit_distance("dirve", "drive"), 1);
  EXPECT_EQ(edit_distance("Driving-Side", "driving_side"), 0);
  for (const auto& [a, b] : {std::pair{"kitten", "sitting"}, {"abc", "yabd"}})
    EXPECT_EQ(edit_distance(a, b), edit_distance(b, a));
}

TEST(ClosestWord, only_near_words_are_offered) {
  const std::vector<std::string> known{"photo", "osm", "dtm", "buildings"};
  EXPECT_EQ(closest_word("foto", known), "photo");
  EXPECT_EQ(closest_word("osn", known), "osm");
  EXPECT_EQ(closest_word("building", known), "buildings");
  EXPECT_EQ(closest_word("xyz", known), std::nullopt);
  EXPECT_EQ(closest_word("", known), std::nullopt);
  EXPECT_EQ(closest_word(std::string(100000, 'x'), known), std::nullopt);  // in no time
  EXPECT_EQ(suggestion("foto", known), "; did you mean 'photo'?");
  EXPECT_EQ(suggestion("xyz", {"a", "b"}), "; known are: a, b");
  EXPECT_EQ(suggestion("xyz", {}), "");
}

}  // namespace
}  // namespace orthodrive
