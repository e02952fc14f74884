// SPDX-License-Identifier: Apache-2.0
// One road, spelt as OpenDRIVE 1.4, 1.6 and 1.8 allow and as their writers do: the same surface, lanes and limits.

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "roadquery/road_surface.hpp"
#include "roadquery/speed_limits.hpp"

namespace roadquery {
namespace {

/// Numbers of a random road of 100 m with a lane on the left and two on the right.
struct Drawn {
  double hdg, elevation[4], bank[2], slope_right, slope_left, width[3], widening, limit_kmh, bridge_s;
};

/// How it is spelt.
struct Spelling {
  bool borders = false, crossfall = false, shuffled = false, repeated = false, prefix = false, text_ids = false;
};

Drawn draw(std::mt19937& random) {
  const auto between = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(random()) / static_cast<double>(std::mt19937::max());
  };
  return {between(-3.0, 3.0),
          {between(0.0, 9.0), between(-0.05, 0.05), between(-1e-4, 1e-4), between(-1e-6, 1e-6)},
          {between(-0.05, 0.05), between(-1e-4, 1e-4)},
          between(0.0, 0.04),
          between(0.0, 0.04),
          {between(2.5, 4.0), between(2.5, 4.0), between(1.0, 3.0)},
          between(0.0, 0.02),
          between(30.0, 130.0),
          between(10.0, 40.0)};
}

std::string number(double v) {
  std::ostringstream text;
  text.precision(17);
  text << v;
  return text.str();
}

std::string cubic_element(const std::string& name, const std::string& at, double s, double a, double b = 0.0,
                          double c = 0.0, double d = 0.0) {
  return "<" + name + " " + at + "=\"" + number(s) + "\" a=\"" + number(a) + "\" b=\"" + number(b) + "\" c=\"" +
         number(c) + "\" d=\"" + number(d) + "\"/>";
}

/// Elements of one list in any order, each of them perhaps preceded by another one that the last one overrules.
std::string listed(std::vector<std::string> elements, const std::string& overruled, const Spelling& how,
                   std::mt19937& random) {
  if (how.shuffled) std::shuffle(elements.begin(), elements.end(), random);
  std::string text = how.repeated ? overruled : "";
  for (const std::string& element : elements) text += element;
  return text;
}

std::string lane_text(int id, double inner, double sign, double width, double widening, const Spelling& how) {
  const std::string at = "<lane id=\"" + std::to_string(id) + "\" type=\"driving\" level=\"false\">";
  return at +
         (how.borders ? cubic_element("border", "sOffset", 0.0, inner + sign * width, sign * widening)
                      : cubic_element("width", "sOffset", 0.0, width, widening)) +
         "</lane>";
}

std::string lateral_text(const Drawn& drawn, const Spelling& how, std::mt19937& random) {
  const std::string bank = cubic_element("superelevation", "s", 0.0, drawn.bank[0], drawn.bank[1]);
  const std::string wrong_bank = cubic_element("superelevation", "s", 0.0, 0.3);
  std::string text = listed({bank, cubic_element("superelevation", "s", 50.0, drawn.bank[0] + 50.0 * drawn.bank[1])},
                            wrong_bank, how, random);
  if (how.crossfall) {
    for (const bool left : {true, false}) {
      std::string element =
          cubic_element("crossfall", "s", 0.0, std::atan(left ? drawn.slope_left : drawn.slope_right));
      text += element.insert(11, left ? "side=\"left\" " : "side=\"right\" ");
    }
    return text;
  }
  const auto shape = [](double t, double a, double b) {
    std::string element = cubic_element("shape", "s", 0.0, a, b);
    return element.insert(7, "t=\"" + number(t) + "\" ");
  };
  return text + listed({shape(-20.0, -20.0 * drawn.slope_right, drawn.slope_right), shape(0.0, 0.0, -drawn.slope_left)},
                       shape(0.0, 0.5, 0.0), how, random);
}

std::string spelt(const Drawn& drawn, const Spelling& how, std::mt19937& random) {
  const auto& e = drawn.elevation;
  const double ds = 40.0;
  const std::string profile =
      listed({cubic_element("elevation", "s", 0.0, e[0], e[1], e[2], e[3]),
              cubic_element("elevation", "s", ds, e[0] + ds * (e[1] + ds * (e[2] + ds * e[3])),
                            e[1] + ds * (2 * e[2] + ds * 3 * e[3]), e[2] + 3 * ds * e[3], e[3])},
             cubic_element("elevation", "s", 0.0, 77.0), how, random);
  const auto& w = drawn.width;
  std::string text =
      "<OpenDRIVE><header revMajor=\"1\" revMinor=\"4\"/><road name=\"\" length=\"100\" id=\"" +
      std::string(how.text_ids ? "{road}" : "1") + "\" junction=\"-1\"><type s=\"0\" type=\"town\"><speed max=\"" +
      number(how.shuffled ? drawn.limit_kmh / 3.6 : drawn.limit_kmh) + "\" unit=\"" + (how.shuffled ? "m/s" : "km/h") +
      "\"/></type><planView><geometry s=\"0\" x=\"3\" y=\"4\" hdg=\"" + number(drawn.hdg) +
      "\" length=\"100\"><arc curvature=\"0.004\"/></geometry></planView><elevationProfile>" + profile +
      "</elevationProfile><lateralProfile>" + lateral_text(drawn, how, random) +
      "</lateralProfile><lanes><laneSection s=\"0\"><left>" + lane_text(1, 0.0, 1.0, w[0], drawn.widening, how) +
      "</left><center><lane id=\"0\" type=\"none\"/></center><right>" + lane_text(-1, 0.0, -1.0, w[1], 0.0, how) +
      lane_text(-2, -w[1], -1.0, w[2], 0.0, how) + "</right></laneSection></lanes><objects><bridge s=\"" +
      number(drawn.bridge_s) + "\" length=\"30\" id=\"b\" type=\"concrete\"/></objects></road></OpenDRIVE>";
  if (!how.prefix) return text;
  for (std::size_t at = 0; (at = text.find('<', at)) != std::string::npos; ++at)
    text.insert(at + (text[at + 1] == '/' ? 2 : 1), "odr:");
  return text.insert(text.find('>'), " xmlns:odr=\"http://code.asam.net/simulation/standard/opendrive_schema\"");
}

TEST(Spellings, of_one_road_read_to_one_surface) {
  const std::string file = (std::filesystem::path(testing::TempDir()) / "spelt.xodr").string();
  std::mt19937 random(40);
  for (int round = 0; round < 12; ++round) {
    const Drawn drawn = draw(random);
    std::vector<Road> roads;
    for (unsigned bits = 0; bits < 64; bits += bits == 0 ? 1 : 1 + random() % 9) {
      const Spelling how{(bits & 1u) != 0, (bits & 2u) != 0,  (bits & 4u) != 0,
                         (bits & 8u) != 0, (bits & 16u) != 0, (bits & 32u) != 0};
      std::ofstream(file) << "<?xml version=\"1.0\"?>" << spelt(drawn, how, random);
      roads.push_back(read_opendrive(file).roads.at(0));
      const Road &first = roads.front(), &road = roads.back();
      for (double s = 0.0; s <= 100.0; s += 12.5)
        for (double t = -5.0; t <= 2.5; t += 0.75) {
          const SurfacePoint p = surface_point(first, s, t), q = surface_point(road, s, t);
          ASSERT_NEAR(p.x, q.x, 1e-9) << bits;
          ASSERT_NEAR(p.y, q.y, 1e-9) << bits;
          ASSERT_NEAR(p.z, q.z, 1e-9) << bits << " at " << s << ", " << t;
          ASSERT_EQ(lane_id_at(first, s, t), lane_id_at(road, s, t));
        }
      ASSERT_NEAR(lane_limit_mps(first, -1, 50.0), lane_limit_mps(road, -1, 50.0), 1e-9);
      ASSERT_EQ(first.bridges.at(0).s_start, road.bridges.at(0).s_start);
    }
  }
  std::filesystem::remove(file);
}

}  // namespace
}  // namespace roadquery
