// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/pipeline/files/network_spec.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/scratch.hpp"
#include "orthodrive/core/error.hpp"
#include "paths.hpp"

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
}

TEST(ClassTableFile, colours_are_numbers_or_text) {
  const auto read = [](const std::string& color) {
    return parse_class_table("name = \"t\"\n[[class]]\nname = \"a\"\ncolor = " + color +
                                 "\nrole = \"road\"\n[[class]]\nname = \"b\"\ncolor = [0, 0, 0]\nrole = \"ground\"\n",
                             "t.toml")
        .classes.front()
        .color;
  };
  EXPECT_EQ(read("[255, 16, 0]"), read("\"#FF1000\""));
  EXPECT_EQ(read("\"#ac0b07\""), (std::array<std::uint8_t, 3>{0xac, 0x0b, 0x07}));
  for (const char* wrong :
       {"[1, 2]", "[1, 2, 256]", "[-1, 2, 3]", "\"FF1000\"", "\"#FF100\"", "\"#FF100G\"", "\"red\"", "7"})
    EXPECT_THAT([&] { static_cast<void>(read(wrong)); },
                ThrowsMessage<InputError>(HasSubstr("t.toml:4: 'color' must be [r, g, b]")))
        << wrong;
}

TEST(ClassTableFile, the_reference_has_38_classes) {
  const std::filesystem::path file = paths::in_source("models/classes/reference-38.toml");
  const ClassTable table = parse_class_table(bytes_of(file), file);
  ASSERT_EQ(table.classes.size(), 38u);
  EXPECT_EQ(table.classes[1].color, (std::array<std::uint8_t, 3>{0xac, 0xe6, 0xa1}));
  for (const ClassInfo& a : table.classes)
    for (const ClassInfo& b : table.classes) {
      EXPECT_EQ(a.name == b.name, &a == &b);
      EXPECT_EQ(a.color == b.color, &a == &b) << a.name << " and " << b.name;
    }
}

}  // namespace
}  // namespace orthodrive
