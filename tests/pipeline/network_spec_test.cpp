// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/pipeline/network_spec.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "orthodrive/core/error.hpp"

namespace orthodrive {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

TEST(NetworkSpec, reads_the_description) {
  const NetworkSpec spec = parse_network_spec(
      "trunk = \"vgg16\"\nstride = 8\ndecoder = \"fcn\"\ngsd_m = 0.2\nclasses = \"../classes/c.toml\"\n", "n/a/x.toml");
  EXPECT_EQ(spec.architecture(), "vgg16-8s");
  EXPECT_DOUBLE_EQ(spec.gsd_m, 0.2);
  EXPECT_EQ(spec.class_table_file.lexically_normal(), "n/classes/c.toml");
  EXPECT_THAT(
      [] {
        static_cast<void>(
            parse_network_spec("trunk = \"vgg16\"\nstride = 4\ndecoder = \"fcn\"\ngsd_m = 1.0\n", "x.toml"));
      },
      ThrowsMessage<InputError>(HasSubstr("'vgg16-4s' is unknown")));
  EXPECT_THROW(static_cast<void>(parse_network_spec("trunk = \"vgg16\"\n", "x.toml")), InputError);
}

TEST(ClassTableFile, reads_names_colours_roles_and_refuses_others) {
  const ClassTable table = parse_class_table(
      "name = \"t\"\n[[class]]\nname = \"a\"\ncolor = [1, 2, 3]\nrole = \"road\"\n[[class]]\nname = \"b\"\ncolor = [4, "
      "5, 6]\n"
      "role = \"ground\"\ncost_false_negative = 0.2\n",
      "t.toml");
  ASSERT_EQ(table.classes.size(), 2u);
  EXPECT_EQ(table.classes[0].role, Role::road);
  EXPECT_DOUBLE_EQ(table.classes[1].cost_false_negative, 0.2);
  EXPECT_THROW(static_cast<void>(
                   parse_class_table("name = \"t\"\n[[class]]\nname = \"a\"\ncolor = [1, 2]\nrole = \"road\"\n", "t")),
               InputError);
}

}  // namespace
}  // namespace orthodrive
