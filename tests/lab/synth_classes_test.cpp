// SPDX-License-Identifier: Apache-2.0
// Synthetic sites with the 38 classes of the thesis, as its class table in models/ names them.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>

#include "orthodrive/core/error.hpp"
#include "orthodrive/io/support/read_file.hpp"
#include "orthodrive/pipeline/files/network_spec.hpp"
#include "orthodrive/synth/make_site.hpp"
#include "paths.hpp"

namespace orthodrive {
namespace {
const ClassTable& reference_classes() {
  const std::filesystem::path file = paths::in_source("models/classes/reference-38.toml");
  static const ClassTable table = parse_class_table(io::read_file(file), file);
  return table;
}

SynthSite site_of(Preset preset, const ClassTable* classes) {
  return make_preset(preset, {.size_m = 900.0, .gsd_m = 1.0, .seed = 4, .classes = classes});
}

std::set<std::string> shown(const SynthSite& site) {
  std::set<std::string> names;
  for (const std::uint8_t label : site.labels.labels.data) names.insert(site.labels.classes.classes.at(label).name);
  return names;
}

TEST(SynthClasses, four_presets_show_all_38) {
  std::set<std::string> all;
  for (const Preset preset : {Preset::circuit, Preset::village, Preset::junction, Preset::grid})
    all.merge(shown(site_of(preset, &reference_classes())));
  ASSERT_EQ(reference_classes().classes.size(), 38U);
  for (const ClassInfo& info : reference_classes().classes) EXPECT_TRUE(all.contains(info.name)) << info.name;
}

TEST(SynthClasses, circuit_has_what_circuits_have) {
  const SynthSite site = site_of(Preset::circuit, &reference_classes());
  EXPECT_THAT(shown(site), testing::IsSupersetOf({"track", "pitlane", "curbs", "apron", "gravel", "barrier",
                                                  "grandstand", "railroad", "river", "rock", "snow", "orchard"}));
  EXPECT_THAT(shown(site), testing::Not(testing::Contains("freeway")));
}

TEST(SynthClasses, roads_and_heights_are_those_of_the_default_table) {
  const SynthSite site = site_of(Preset::village, &reference_classes()), plain = site_of(Preset::village, nullptr);
  EXPECT_EQ(site.true_dtm.height_m.data, plain.true_dtm.height_m.data);
  ASSERT_EQ(site.roads.paths.size(), plain.roads.paths.size());
  for (std::size_t i = 0; i < site.roads.paths.size(); ++i) {
    EXPECT_EQ(centerline(site.roads.paths[i]), centerline(plain.roads.paths[i]));
    EXPECT_EQ(site.roads.paths[i].osm_id, plain.roads.paths[i].osm_id);
    EXPECT_NEAR(site.surfaces[i].visibility, plain.surfaces[i].visibility, 0.25) << "other trees";
  }
  // Where nothing hides a road in either, both labels say road.
  std::size_t both = 0, roads = 0;
  for (std::size_t i = 0; i < plain.labels.labels.data.size(); ++i) {
    if (plain.labels.classes.classes[plain.labels.labels.data[i]].role != Role::road) continue;
    const Role role = site.labels.classes.classes[site.labels.labels.data[i]].role;
    ++roads, both += role == Role::road || role == Role::vegetation ? 1 : 0;
  }
  EXPECT_GT(roads, 10000U);
  EXPECT_GE(both, roads - roads / 500);
}

TEST(SynthClasses, table_in_another_order_gives_the_same_names) {
  ClassTable turned = reference_classes();
  std::reverse(turned.classes.begin(), turned.classes.end());
  const SynthSite site = site_of(Preset::village, &reference_classes()), other = site_of(Preset::village, &turned);
  EXPECT_EQ(site.photo.rgb.data, other.photo.rgb.data);
  for (std::size_t i = 0; i < site.labels.labels.data.size(); i += 97)
    EXPECT_EQ(site.labels.labels.data[i] + other.labels.labels.data[i], 37);
}

TEST(SynthClasses, all_that_a_table_lacks_is_said_at_once) {
  ClassTable few = reference_classes();
  few.name = "few";
  std::erase_if(few.classes, [](const ClassInfo& info) { return info.name == "snow" || info.name == "gravel"; });
  try {
    (void)site_of(Preset::village, &few);
    FAIL();
  } catch (const OptionError& error) {
    EXPECT_STREQ(error.what(), "the class table few lacks 2 of 38 classes that synthetic sites show: snow, gravel");
  }
}
}  // namespace
}  // namespace orthodrive
