#include "orthodrive/model/design_speed.hpp"

#include <algorithm>
#include <array>
#include <string_view>

namespace orthodrive {
namespace {
struct ClassSpeed {
  std::string_view highway;
  double speed_kmh;
  bool local;
};
constexpr std::array speeds{ClassSpeed{"motorway", 120.0, false},    ClassSpeed{"motorway_link", 60.0, false},
                            ClassSpeed{"trunk", 100.0, false},       ClassSpeed{"trunk_link", 60.0, false},
                            ClassSpeed{"primary", 80.0, false},      ClassSpeed{"primary_link", 50.0, false},
                            ClassSpeed{"secondary", 70.0, false},    ClassSpeed{"secondary_link", 50.0, false},
                            ClassSpeed{"tertiary", 60.0, false},     ClassSpeed{"tertiary_link", 50.0, false},
                            ClassSpeed{"raceway", 200.0, false},     ClassSpeed{"unclassified", 50.0, false},
                            ClassSpeed{"road", 50.0, false},         ClassSpeed{"residential", 40.0, true},
                            ClassSpeed{"living_street", 20.0, true}, ClassSpeed{"service", 30.0, true},
                            ClassSpeed{"track", 30.0, true}};

const ClassSpeed& find(const std::string& highway) {
  const auto same = [](std::string_view value) { return [value](const ClassSpeed& c) { return c.highway == value; }; };
  const auto it = std::find_if(speeds.begin(), speeds.end(), same(highway));
  return it == speeds.end() ? *std::find_if(speeds.begin(), speeds.end(), same("service")) : *it;
}
}  // namespace

double design_speed_kmh(const std::string& highway) { return find(highway).speed_kmh; }
bool is_local_street(const std::string& highway) { return find(highway).local; }

}  // namespace orthodrive
