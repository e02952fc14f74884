// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/buildings/building_style.hpp"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <optional>
#include <string>

namespace orthodrive::scene {
namespace {

constexpr double house_pitch = 0.7, church_pitch = 1.2;  // 35 and 50 degrees
constexpr double small_m2 = 60.0, house_m2 = 300.0, gabled_shed_m2 = 25.0;
constexpr double level_m = 3.0;
constexpr double max_rise_share = 0.5;             // of a building's height
constexpr double least_wall_m = 0.3;               // below a roof whose height is given
constexpr double canopy_m = 4.0, carport_m = 2.6;  // of roofs on posts

bool is_one_of(const std::string& use, std::initializer_list<const char*> names) {
  return std::ranges::find(names, use) != names.end();
}

struct Usual {
  double height_m;
  int storeys;
  BuildingLook look;
  RoofShape roof;
  double pitch = house_pitch;
};

Usual usual_of(const Building& building, double area_m2) {
  const std::string& use = building.use;
  if (!building.has_walls)
    return {use == "carport" || area_m2 < small_m2 ? carport_m : canopy_m, 1, BuildingLook::plain, RoofShape::flat};
  if (is_one_of(use, {"church", "chapel", "cathedral", "mosque", "religious"}))
    return {10.0, 1, BuildingLook::church, RoofShape::gabled, church_pitch};
  const bool garage = is_one_of(use, {"garage", "garages"});
  const bool shed = is_one_of(use, {"shed", "hut", "greenhouse", "kiosk", "bunker", "service", "transformer_tower"});
  if (garage || shed || area_m2 < small_m2)
    return {2.6, 1, garage ? BuildingLook::garage : BuildingLook::plain,
            area_m2 > gabled_shed_m2 && !garage ? RoofShape::gabled : RoofShape::flat};
  if (is_one_of(use, {"industrial", "warehouse", "barn", "hangar", "manufacture", "farm_auxiliary", "sports_hall",
                      "transportation", "parking", "grandstand", "cowshed", "storage_tank"}))
    return {8.0, 2, BuildingLook::hall, RoofShape::flat};
  if (is_one_of(use, {"retail", "supermarket", "commercial"})) return {8.0, 2, BuildingLook::shop, RoofShape::flat};
  if (area_m2 <= house_m2) return {5.6, 2, BuildingLook::house, RoofShape::gabled};
  return {9.0, 3, BuildingLook::house, RoofShape::flat};
}

/// Of flats: what has many storeys or says so.
bool has_flats(const Building& building, double area_m2, double height_m) {
  constexpr double low_m = 8.0, least_m2 = 150.0;
  return area_m2 > least_m2 && height_m > low_m &&
         is_one_of(building.use, {"apartments", "residential", "dormitory", "terrace", "hotel", "yes"});
}

double rise_of(const Building& building, double wall_m) {
  double rise_m = building.roof_height_m > 0.0 ? building.roof_height_m : level_m * building.roof_levels;
  if (building.height_m > 0.0) rise_m = std::min(rise_m, wall_m - least_wall_m);
  return std::max(0.0, rise_m);
}

}  // namespace

BuildingStyle style_of(const Building& building, double area_m2) {
  const Usual usual = usual_of(building, area_m2);
  BuildingStyle style{.height_m = usual.height_m, .storeys = usual.storeys, .look = usual.look};
  const bool low_storeys = usual.look == BuildingLook::plain || usual.look == BuildingLook::garage;
  const bool own_storey = low_storeys || usual.look == BuildingLook::hall || usual.look == BuildingLook::shop;
  if (building.levels > 0.0) {
    style.height_m = (own_storey ? usual.height_m / usual.storeys : level_m) * building.levels;
    style.storeys = std::max(1, static_cast<int>(std::lround(building.levels)));
  }
  if (building.height_m > 0.0) {
    style.height_m = building.height_m;
    style.with_roof = true;
    if (building.levels <= 0.0) style.storeys = 0;
  }
  // A part that is known to begin above what is usual.
  if (style.height_m <= building.min_height_m + least_wall_m) style.height_m = building.min_height_m + level_m;
  if (style.look == BuildingLook::house && has_flats(building, area_m2, style.height_m))
    style.look = BuildingLook::flats;
  if (building.is_part && building.min_height_m > 0.0 && style.look != BuildingLook::flats)
    style.look = style.height_m - building.min_height_m > level_m ? BuildingLook::house : BuildingLook::plain;

  const double wall_m = style.height_m - building.min_height_m;
  style.roof = {
      .shape = roof_shape_of(building.roof_shape).value_or(usual.roof),
      .pitch = building.roof_angle_rad > 0.0 ? std::tan(building.roof_angle_rad) : usual.pitch,
      .max_rise_m = building.roof_angle_rad > 0.0 && !style.with_roof ? style.height_m : max_rise_share * wall_m,
      .rise_m = rise_of(building, wall_m),
      .ridge_across = building.ridge_across};
  if (building.roof_direction_rad)
    style.roof.downwards = Vec2{std::cos(*building.roof_direction_rad), std::sin(*building.roof_direction_rad)};
  return style;
}

}  // namespace orthodrive::scene
