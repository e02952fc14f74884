// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/nets/model_metadata.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "orthodrive/core/error.hpp"

namespace orthodrive {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

TEST(ModelMetadata, comes_back) {
  const ModelMetadata metadata{"vgg16-8s", default_class_table(), 0.25, 0.1};
  const ModelMetadata read = parse_model_metadata(format_model_metadata(metadata), "m");
  EXPECT_EQ(read.architecture, "vgg16-8s");
  EXPECT_EQ(read.gsd_m, 0.25);
  EXPECT_EQ(read.finest_gsd_m, 0.1);
  ASSERT_EQ(read.classes.classes.size(), metadata.classes.classes.size());
  for (std::size_t i = 0; i < read.classes.classes.size(); ++i) {
    const ClassInfo &a = read.classes.classes[i], &b = metadata.classes.classes[i];
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(a.color, b.color);
    EXPECT_EQ(a.role, b.role);
    EXPECT_EQ(a.cost_false_positive, b.cost_false_positive);
    EXPECT_EQ(a.cost_false_negative, b.cost_false_negative);
  }
}

TEST(ModelMetadata, files_of_others_are_named) {
  EXPECT_THAT([] { (void)parse_model_metadata({}, "m.safetensors"); },
              ThrowsMessage<InputError>(HasSubstr("m.safetensors: has no model metadata")));
  auto items = format_model_metadata({"vgg16-8s", default_class_table(), 0.25});
  for (const char* gsd_m : {"0", "-1", "nan", "wide", ""}) {
    items["gsd_m"] = gsd_m;
    EXPECT_THAT([&] { (void)parse_model_metadata(items, "m"); }, ThrowsMessage<InputError>(HasSubstr("gsd_m")))
        << gsd_m;
  }
}

}  // namespace
}  // namespace orthodrive
