// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/synth/paint/label_classes.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/parallel.hpp"
#include "orthodrive/synth/paint/world.hpp"

namespace orthodrive::synth {
namespace {
enum Fine : std::uint8_t {
  snow,
  grassland,
  lawn,
  shrub,
  tree,
  orchard,
  field,
  dirt,
  debris,
  rock,
  paved,
  parking,
  pool,
  river,
  water,
  shed,
  detached,
  residential,
  highrise,
  agricultural,
  industrial,
  railroad,
  cartway,
  sidewalk,
  macadam,
  driveway,
  secondary,
  avenue,
  highway,
  freeway,
  ramp,
  curbs,
  pitlane,
  track,
  barrier,
  apron,
  grandstand,
  gravel,
  fine_count
};
constexpr std::array<const char*, fine_count> fine_names{
    "snow",     "grassland",   "lawn",      "shrub",        "tree",       "orchard",  "field",   "dirt",
    "debris",   "rock",        "paved",     "parking",      "pool",       "river",    "water",   "shed",
    "detached", "residential", "highrise",  "agricultural", "industrial", "railroad", "cartway", "sidewalk",
    "macadam",  "driveway",    "secondary", "avenue",       "highway",    "freeway",  "ramp",    "curbs",
    "pitlane",  "track",       "barrier",   "apron",        "grandstand", "gravel"};

std::array<std::uint8_t, fine_count> values_of(const ClassTable& table) {
  std::array<std::uint8_t, fine_count> values{};
  std::vector<std::string> missing;
  for (std::size_t i = 0; i < fine_count; ++i) {
    const auto found = std::find_if(table.classes.begin(), table.classes.end(),
                                    [&](const ClassInfo& info) { return info.name == fine_names[i]; });
    if (found == table.classes.end())
      missing.emplace_back(fine_names[i]);
    else
      values[i] = static_cast<std::uint8_t>(found - table.classes.begin());
  }
  if (!missing.empty())
    throw OptionError(fmt::format("the class table {} lacks {} of {} classes that synthetic sites show: {}", table.name,
                                  missing.size(), static_cast<int>(fine_count), fmt::join(missing, ", ")));
  return values;
}

Fine road_class(const SitePlan& plan, std::size_t number) {
  const PlannedRoad& road = plan.roads[number];
  const std::string& highway_tag = road.highway;
  if (highway_tag == "raceway") return plan.circuit == number ? track : pitlane;
  if (highway_tag == "track" || road.pavement == Pavement::dirt) return cartway;
  if (road.pavement == Pavement::gravel || road.surface.find("gravel") != std::string::npos) return macadam;
  if (highway_tag == "motorway" || highway_tag == "trunk") return freeway;
  if (highway_tag.ends_with("_link")) return ramp;
  if (highway_tag == "service") return driveway;
  if (highway_tag == "footway" || highway_tag == "cycleway" || highway_tag == "path") return sidewalk;
  if (road.lanes >= 3) return avenue;
  return highway_tag == "primary" || highway_tag == "secondary" ? highway : secondary;
}

Fine house_class(const House& house) {
  switch (house.use) {
    case Use::town_house:
      return residential;
    case Use::tower:
      return highrise;
    case Use::farm:
      return agricultural;
    case Use::works:
      return industrial;
    case Use::stand:
      return grandstand;
    case Use::dwelling:
      break;
  }
  const double built_m2 = 4.0 * house.half_length_m * house.half_width_m;
  if (built_m2 < 45.0) return shed;
  if (house.roof == RoofShape::flat && built_m2 > 400.0) return industrial;  // shops
  return built_m2 > 260.0 || house.eave_m > 7.5 ? residential : detached;
}

Fine field_class(const SceneSource& source, std::uint16_t number) {
  if (source.world != nullptr) return field_look(*source.world, number).soil ? dirt : field;
  return static_cast<Crop>(number % crop_count) == Crop::hay ? grassland : field;
}

/// Of what covers the ground, but roads and fields.
Fine cover_class(Cover cover) {
  switch (cover) {
    case Cover::road:
    case Cover::field:
    case Cover::meadow:
    case Cover::verge:
      return grassland;
    case Cover::lawn:
      return lawn;
    case Cover::garden_bed:
      return shrub;
    case Cover::forest_floor:
      return tree;
    case Cover::paved:
      return paved;
    case Cover::parking:
      return parking;
    case Cover::gravel:
    case Cover::dirt:
      return dirt;
    case Cover::path:
      return cartway;
    case Cover::water:
      return water;
    case Cover::pool:
      return pool;
    case Cover::sidewalk:
      return sidewalk;
    case Cover::gravel_trap:
      return gravel;
    case Cover::kerb:
      return curbs;
    case Cover::drive:
      return driveway;
    case Cover::apron:
      return apron;
    case Cover::snow:
      return snow;
    case Cover::debris:
      return debris;
    case Cover::rock:
      return rock;
    case Cover::river:
      return river;
    case Cover::rails:
      return railroad;
    case Cover::orchard:
      return orchard;
    case Cover::barrier:
      return barrier;
  }
  return grassland;
}

class FineLabels {
 public:
  FineLabels(const SceneSource& source, const SceneRaster& scene)
      : source_(source), scene_(scene), counts_(counts_of(source.objects)) {
    for (std::size_t r = 0; r < source.plan.roads.size(); ++r) roads_.push_back(road_class(source.plan, r));
  }
  [[nodiscard]] Fine at(int col, int row) const {
    const std::int32_t object = scene_.object.at(col, row);
    if (object >= 0 && object < counts_.houses)
      return house_class(source_.objects.houses[static_cast<std::size_t>(object)]);
    const Cover cover = scene_.cover.at(col, row);
    if (object >= counts_.houses && object < counts_.houses + counts_.trees) {
      constexpr double shrub_m = 1.0;
      if (cover == Cover::orchard) return orchard;
      return source_.objects.trees[static_cast<std::size_t>(object - counts_.houses)].radius_m < shrub_m ? shrub : tree;
    }
    const Fine below = ground(cover, col, row);
    const bool bare_crown = object < 0 && !scene_.bare_crown.data.empty() && scene_.bare_crown.at(col, row) != 0;
    return bare_crown && (below == grassland || below == lawn || below == dirt) ? tree : below;
  }

 private:
  [[nodiscard]] Fine ground(Cover cover, int col, int row) const {
    if (cover == Cover::road)
      return roads_[source_.road_samples[static_cast<std::size_t>(scene_.road_segment.at(col, row))].road];
    if (cover == Cover::path && source_.plan.only_footpaths) return sidewalk;
    return cover == Cover::field ? field_class(source_, scene_.detail.at(col, row)) : cover_class(cover);
  }

  const SceneSource& source_;
  const SceneRaster& scene_;
  ObjectCounts counts_;
  std::vector<Fine> roads_;
};
}  // namespace

void check_synth_classes(const ClassTable& table) { (void)values_of(table); }

Raster<std::uint8_t> label_scene(const SceneSource& source, const SceneRaster& scene, const ClassTable& table,
                                 int threads) {
  const std::array<std::uint8_t, fine_count> values = values_of(table);
  const FineLabels fine(source, scene);
  Raster<std::uint8_t> labels(scene.frame.width, scene.frame.height);
  parallel_for(static_cast<std::size_t>(scene.frame.height), threads, [&](std::size_t i) {
    const int row = static_cast<int>(i);
    for (int col = 0; col < scene.frame.width; ++col) labels.at(col, row) = values[fine.at(col, row)];
  });
  return labels;
}

}  // namespace orthodrive::synth
