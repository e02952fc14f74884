// SPDX-License-Identifier: Apache-2.0
// Parameter files: what is read, and one clear line for each way to be wrong.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <random>

#include "vehicle/cars.hpp"

namespace vehicle {
namespace {

using testing::HasSubstr;

std::string text_of(const std::string& name) {
  std::ifstream in(orthodrive::paths::in_source(("models/vehicles/" + name + ".toml").c_str()));
  return {std::istreambuf_iterator<char>(in), {}};
}

/// The file with one text replaced.
std::string changed(const std::string& from, const std::string& to) {
  std::string text = text_of("family_car");
  const auto place = text.find(from);
  EXPECT_NE(place, std::string::npos) << from;
  return text.replace(place, from.size(), to);
}

std::string message(const std::string& text) {
  try {
    static_cast<void>(parse_car(text, "car.toml"));
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "read";
}

TEST(ReadCar, reads_the_presets) {
  const CarParameters car = test::preset("family_car");
  EXPECT_EQ(car.name, "family car");
  EXPECT_EQ(car.body.wheelbase_m, 2.636);
  EXPECT_EQ(car.rear.brake_support_rad, 0.2);
  EXPECT_EQ(car.rear_tyre.r_cy1, 1.081);
  EXPECT_EQ(car.engine.fuel_heat_jpkg, 42.7e6);
  EXPECT_EQ(car.gearbox.ratios.size(), 7U);
  EXPECT_EQ(car.gearbox.ratios[2], 1.531);
  for (const std::string& name : test::presets) EXPECT_NO_THROW(check(test::preset(name))) << name;
}

TEST(ReadCar, says_in_one_line_what_is_wrong) {
  EXPECT_EQ(message(changed("mass_kg = 1420.0", "mass = 1420.0")), "car.toml: no value for mass_kg in [body]");
  EXPECT_THAT(message(changed("mass_kg = 1420.0", "mass_kg = 1420.0\ncolour = 3")),
              HasSubstr("car.toml:12: unknown key 'colour' in section 'body'"));
  EXPECT_THAT(message(changed("mass_kg = 1420.0", "mass_kg = 1420.0\nmass_kg = 1.0")),
              HasSubstr("key 'mass_kg' stands twice"));
  EXPECT_EQ(message(changed("mass_kg = 1420.0", "mass_kg = 99")),
            "car.toml:11: mass_kg = 99 is not in 100 to 10000 kg");
  EXPECT_EQ(message(changed("mass_kg = 1420.0", "mass_kg = heavy")), "car.toml:11: needs a number, got 'heavy'");
  for (const char* number : {"nan", "inf", "1e999", "", "0x10", "1,5", "--1", "1 2"}) {
    EXPECT_THAT(message(changed("mass_kg = 1420.0", std::string("mass_kg = ") + number)),
                HasSubstr("car.toml:11: needs a number"))
        << number;
  }
  EXPECT_THAT(message(changed("[steering]", "[steering")), HasSubstr("a section needs a closing ]"));
  EXPECT_THAT(message(changed("[steering]", "[body]")), HasSubstr("section 'body' stands twice"));
  EXPECT_THAT(message(changed("[steering]", "steering")), HasSubstr("neither [section] nor key = value: 'steering'"));
  EXPECT_THAT(message(changed("ratios = [3.765,", "ratios = 3.765 #")), HasSubstr("ratios needs a list in one line"));
  EXPECT_THAT(message(changed("ratios = [3.765,", "ratios = [1.0,")), HasSubstr("ratios have to fall"));
  EXPECT_THAT(message(changed("[800, 1000,", "[1000, 800,")), HasSubstr("speed_rpm has to rise"));
  EXPECT_THAT(message(changed("[800, 1000,", "[1000,")), HasSubstr("same number of values"));
  EXPECT_THAT(message(changed("roll_inertia_kgm2 = 520.0", "roll_inertia_kgm2 = 11.0")),
              HasSubstr("inertias are too small"));
  EXPECT_THAT(message(changed("name = \"family car\"", "name = family")),
              HasSubstr("name needs a text in double quotes"));
  EXPECT_THAT(message(changed("[steering]", "[wings]\n[steering]")), HasSubstr("unknown section 'wings'"));
  EXPECT_EQ(message(""), "car.toml: no value for name in the first lines");
}

TEST(ReadCar, refuses_what_is_no_file) {
  EXPECT_THROW(static_cast<void>(read_car("/nowhere/car.toml")), std::runtime_error);
  EXPECT_THROW(static_cast<void>(read_car("/tmp")), std::runtime_error);
}

TEST(ReadCar, takes_any_bytes) {
  std::mt19937 random(7);
  int read = 0;
  for (int n = 0; n < 3000; ++n) {
    std::string text = text_of("family_car");
    for (std::uint32_t k = random() % 4 + 1; k > 0; --k) {
      const std::size_t place = random() % text.size();
      switch (random() % 3) {
        case 0:
          text[place] = static_cast<char>(random());
          break;
        case 1:
          text.erase(place, random() % 40);
          break;
        default:
          text.insert(place, text.substr(random() % text.size(), random() % 40));
      }
    }
    const std::string said = message(text);
    read += said == "read" ? 1 : 0;
    EXPECT_EQ(said.find('\n'), std::string::npos);
  }
  EXPECT_GT(read, 100);  // changes in comments
  EXPECT_LT(read, 2900);
}

TEST(Check, names_the_value) {
  CarParameters car = test::preset("gt3_like");
  car.rear_tyre.radius_m = -1.0;
  try {
    check(car);
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(), "rear_tyre.radius_m = -1 is not in 0.15 to 1 m");
  }
  EXPECT_THROW(Car{car}, std::invalid_argument);
}

}  // namespace
}  // namespace vehicle
