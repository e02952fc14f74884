// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/synth/ground/site_objects.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "orthodrive/core/noise.hpp"
#include "orthodrive/core/random.hpp"
#include "orthodrive/model/roads/highway_class.hpp"
#include "orthodrive/synth/plan/planner.hpp"

namespace orthodrive::synth {
namespace {
constexpr double pi = std::numbers::pi;

Vec2 unit(double heading) { return {std::cos(heading), std::sin(heading)}; }

/// Tiles in the reds and browns of Central Europe, slate and sheet metal in greys; each with its own tint.
Rgb roof_color(Random& random) {
  static constexpr std::array<Rgb, 8> tones{{{0.62f, 0.34f, 0.26f},
                                             {0.55f, 0.30f, 0.24f},
                                             {0.68f, 0.42f, 0.32f},
                                             {0.46f, 0.29f, 0.24f},
                                             {0.40f, 0.33f, 0.30f},
                                             {0.36f, 0.37f, 0.39f},
                                             {0.27f, 0.27f, 0.29f},
                                             {0.60f, 0.57f, 0.54f}}};
  Rgb color = tones[random.below(tones.size())];
  const auto gain = static_cast<float>(random.uniform(0.85, 1.15));
  for (float& c : color) c = std::min(1.0f, c * gain + static_cast<float>(random.uniform(-0.02, 0.02)));
  return color;
}

Rgb car_color(Random& random) {
  static constexpr std::array<Rgb, 9> colors{{{0.93f, 0.93f, 0.93f},
                                              {0.90f, 0.90f, 0.89f},
                                              {0.70f, 0.71f, 0.72f},
                                              {0.50f, 0.51f, 0.53f},
                                              {0.30f, 0.31f, 0.32f},
                                              {0.12f, 0.12f, 0.13f},
                                              {0.60f, 0.12f, 0.12f},
                                              {0.16f, 0.25f, 0.48f},
                                              {0.10f, 0.13f, 0.22f}}};
  return colors[random.below(colors.size())];
}

/// Of the plan's areas: nothing grows or is built there.
bool is_kept_free(Cover cover) {
  switch (cover) {
    case Cover::gravel_trap:
    case Cover::paved:
    case Cover::apron:
    case Cover::snow:
    case Cover::dirt:
    case Cover::debris:
    case Cover::rock:
    case Cover::river:
    case Cover::rails:
    case Cover::barrier:
      return true;
    default:
      return false;
  }
}

class Placer {
 public:
  Placer(const SitePlan& plan, const Raster<float>& clearance, const GridFrame& frame, std::uint64_t seed)
      : plan_(plan),
        clearance_(clearance),
        frame_(frame),
        random_(derive_seed(seed, 3)),
        box_{0.0, 0.0, plan.size_m, plan.size_m},
        stretches_(whole_roads(plan)),
        circuit_{plan.circuit ? sample(plan.roads[*plan.circuit].alignment, 4.0) : Ring{}, {}} {
    for (const PlannedRoad& road : plan.roads)
      if (is_fast(road)) fast_.push_back({sample(road.alignment, 10.0), 0.5 * road.width_at(0.0)});
    for (const PlannedBridge& b : plan.bridges) add_deck(b);
  }
  Placer(const SitePlan& plan, const ObjectCell& cell, const Raster<float>& clearance, const GridFrame& frame)
      : plan_(plan),
        clearance_(clearance),
        frame_(frame),
        random_(cell.seed),
        box_(cell.box),
        one_cell_(true),
        stretches_(cell.stretches) {
    constexpr double step_m = 10.0;
    for (const Stretch& stretch : stretches_) {
      const PlannedRoad& road = plan.roads[stretch.road];
      if (!is_fast(road)) continue;
      Polyline line;
      for (double s = stretch.s_begin_m; s < stretch.s_end_m + step_m; s += step_m)
        line.push_back(evaluate(road.alignment, s).p);
      fast_.push_back({std::move(line), 0.5 * road.width_at(0.0)});
    }
    for (const PlannedBridge& b : plan.bridges) add_deck(b);
    std::erase_if(decks_, [&](const Deck& deck) { return !box_.grown(100.0).contains(deck.middle); });
    for (const std::size_t area : cell.areas) plan_areas_.push_back(&plan.areas[area]);
  }

  SiteObjects village() {
    place_woods_and_pond();
    place_paths();
    objects_.areas.insert(objects_.areas.end(), plan_.areas.begin(), plan_.areas.end());
    objects_.houses = plan_.buildings;
    place_parking(plan_.parkings.front());
    place_shop(plan_.parkings.front().outer);
    for (const Stretch& stretch : stretches_) place_lots(stretch);
    grow_woods();
    plant_orchards();
    for (const Stretch& stretch : stretches_) place_roadside_trees(stretch), place_traffic(stretch);
    scatter_trees();
    return numbered();
  }

  /// Woods and fields, what the plan itself lays out, a farm here and there; nothing grows beside fast roads.
  SiteObjects country() {
    place_woods_and_pond();
    place_paths();
    objects_.areas.insert(objects_.areas.end(), plan_.areas.begin(), plan_.areas.end());
    objects_.houses = plan_.buildings;
    for (const Polygon& lot : plan_.parkings) place_parking(lot);
    for (const Stretch& stretch : stretches_) {
      const PlannedRoad& road = plan_.roads[stretch.road];
      if (!is_fast(road) && road.highway != "service" && !road.roundabout) place_lots(stretch);
    }
    grow_woods();
    plant_orchards();
    line_roads();
    scatter_trees();
    return numbered();
  }

  /// Houses along the streets of the plan's settlements; what the plan lays out and plants besides.
  SiteObjects settled() {
    objects_.areas.insert(objects_.areas.end(), plan_.areas.begin(), plan_.areas.end());
    objects_.houses = plan_.buildings;
    for (const Polygon& lot : plan_.parkings) place_parking(lot);
    for (const Stretch& stretch : stretches_) place_lots(stretch);
    grow_woods();
    for (const Orchard& orchard : plan_.settling.orchards) plant(orchard);
    line_roads();
    scatter_trees();
    return numbered();
  }

  /// A square of a region: houses where the settlements are, woods and parked cars on the plan's areas.
  SiteObjects cell() {
    place_paths();
    for (const House& house : plan_.buildings)
      if (box_.contains(house.center)) objects_.houses.push_back(house);
    for (const Area* area : plan_areas_)
      if (area->cover == Cover::parking) park_cars(area->polygon);
    for (const Stretch& stretch : stretches_) {
      const PlannedRoad& road = plan_.roads[stretch.road];
      if (!is_fast(road) && !road.roundabout) place_lots(stretch);
    }
    for (const Area* area : plan_areas_) grow_wood(*area);
    if (random_.uniform() < 0.3) plant_orchard();
    line_roads();
    scatter_trees();
    return std::move(objects_);
  }

 private:
  /// Trees along roads and cars on them.
  void line_roads() {
    for (const Stretch& stretch : stretches_) {
      const PlannedRoad& road = plan_.roads[stretch.road];
      if (!is_fast(road) && !road.roundabout) place_roadside_trees(stretch);
      if (!is_raceway(road.highway)) place_traffic(stretch);
    }
  }

  /// Every object has a number of its own.
  SiteObjects numbered() {
    std::int32_t number = 0;
    for (House& house : objects_.houses) house.id = number++;
    for (Tree& tree : objects_.trees) tree.id = number++;
    number = 0;
    for (Area& area : objects_.areas) area.id = number++;
    return std::move(objects_);
  }

  /// Distance to the edge of the nearest carriageway or bridge; far outside counts as far from roads.
  [[nodiscard]] double clearance(Vec2 p) const {
    const Vec2 q = frame_.pixel_from_world(p);
    const int col = static_cast<int>(std::floor(q.x)), row = static_cast<int>(std::floor(q.y));
    double clearance_m = clearance_.inside(col, row) ? clearance_.at(col, row) : 40.0;
    for (const Deck& deck : decks_) clearance_m = std::min(clearance_m, distance(p, deck.middle) - deck.half_length_m);
    return clearance_m;
  }
  void add_deck(const PlannedBridge& b) {
    decks_.push_back({evaluate(plan_.roads[b.over].alignment, b.s_over_m).p, b.half_length_m});
  }
  /// Where cells are placed on their own, each keeps to what lies in it.
  [[nodiscard]] bool mine(Vec2 p) const { return !one_cell_ || box_.contains(p); }
  /// Nearer to a fast road than its verge and the crown allow.
  [[nodiscard]] bool in_verge_of_fast_road(Vec2 p, double radius_m) const {
    constexpr double verge_m = 5.0;
    return std::any_of(fast_.begin(), fast_.end(), [&](const FastRoad& road) {
      return project_onto(road.line, p).distance_m < road.half_width_m + 1.3 * radius_m + verge_m;
    });
  }
  /// On ground that is kept free: run-off areas, paved areas of the plan.
  [[nodiscard]] bool on_paved_or_gravel(Vec2 p) const {
    const auto kept_free = [&](const Area& area) { return is_kept_free(area.cover) && contains(area.polygon, p); };
    if (one_cell_)
      return std::any_of(plan_areas_.begin(), plan_areas_.end(), [&](const Area* area) { return kept_free(*area); });
    return std::any_of(plan_.areas.begin(), plan_.areas.end(), kept_free);
  }
  [[nodiscard]] bool in_site(Vec2 p, double margin) const {
    return p.x > box_.min_x + margin && p.y > box_.min_y + margin && p.x < box_.max_x - margin &&
           p.y < box_.max_y - margin;
  }
  [[nodiscard]] bool on_water_or_parking(Vec2 p) const {
    const auto wet_or_parking = [&](const Area& area) {
      return (area.cover == Cover::water || area.cover == Cover::river || area.cover == Cover::parking) &&
             contains(area.polygon, p);
    };
    return std::any_of(objects_.areas.begin(), objects_.areas.end(), wet_or_parking) ||
           std::any_of(plan_areas_.begin(), plan_areas_.end(), [&](const Area* area) { return wet_or_parking(*area); });
  }
  [[nodiscard]] bool near_house(Vec2 p, double margin) const {
    return std::any_of(objects_.houses.begin(), objects_.houses.end(), [&](const House& h) {
      const Vec2 d = p - h.center, u = unit(h.heading_rad);
      return std::abs(dot(d, u)) < h.half_length_m + margin && std::abs(cross(u, d)) < h.half_width_m + margin;
    });
  }

  [[nodiscard]] bool near_car(Vec2 p) const {
    constexpr double two_lorries_m = 9.0;
    return std::any_of(objects_.cars.begin(), objects_.cars.end(),
                       [&](const Car& car) { return distance(car.center, p) < two_lorries_m; });
  }

  void place_woods_and_pond() {
    const double size = plan_.size_m;
    // Woods: from the corners inwards, and a copse in the village.
    for (const Vec2 corner : {Vec2{0.1, 0.1}, {0.9, 0.1}, {0.1, 0.9}, {0.9, 0.9}, {0.93, 0.5}, {0.5, 0.95}}) {
      if (random_.uniform() < 0.3) continue;
      const Vec2 center = (corner + Vec2{random_.uniform(-0.06, 0.06), random_.uniform(-0.06, 0.06)}) * size;
      objects_.areas.push_back(
          {{blob(random_, center, size * random_.uniform(0.06, 0.13)), {}}, Cover::forest_floor, true});
    }
    const Vec2 copse = Vec2{random_.uniform(0.3, 0.7), random_.uniform(0.3, 0.7)} * size;
    objects_.areas.push_back({{blob(random_, copse, size * 0.035), {}}, Cover::forest_floor, true});
    // The pond goes where most room is left among random places.
    Vec2 best;
    double room = 0.0;
    for (int i = 0; i < 200; ++i) {
      const Vec2 p = Vec2{random_.uniform(0.08, 0.92), random_.uniform(0.08, 0.92)} * size;
      if (clearance(p) > room) best = p, room = clearance(p);
      if (room >= 39.0) break;
    }
    const double radius = std::min(0.045 * size, 0.6 * room - 1.0);
    if (radius > 3.0) {
      objects_.areas.push_back({{blob(random_, best, 1.25 * radius), {}}, Cover::meadow, false});
      objects_.areas.push_back({{blob(random_, best, radius), {}}, Cover::water, true});
    }
  }

  /// Unpaved tracks into the fields and footpaths, none of them in the OSM file: light strips that are no roads.
  void place_paths() {
    if (stretches_.empty()) return;
    const int count = one_cell_ ? 2 : static_cast<int>(8.0 * std::min(1.0, plan_.size_m / 1000.0)) + 2;
    for (int i = 0; i < count; ++i) {
      const Stretch& stretch = stretches_[random_.below(stretches_.size())];
      const PlannedRoad& road = plan_.roads[stretch.road];
      if (is_fast(road) || road.roundabout) continue;
      const AlignmentPoint q = evaluate(
          road.alignment, stretch.s_begin_m + random_.uniform(0.1, 0.9) * (stretch.s_end_m - stretch.s_begin_m));
      const double side = random_.below(2) ? 1.0 : -1.0,
                   half_m = random_.uniform(0.7, 1.5) * (plan_.only_footpaths ? 0.5 : 1.0),
                   bend = random_.uniform(-0.01, 0.01);
      const double length_m = random_.uniform(0.08, 0.25) * std::min(plan_.size_m, 4000.0),
                   start = q.heading_rad + side * random_.uniform(1.0, 2.1);
      Polyline line{q.p};
      for (double s = 0.0; s < length_m; s += 6.0) {
        line.push_back(line.back() + unit(start + bend * s + 0.25 * std::sin(s / 31.0)) * 6.0);
        if (s > 12.0 && clearance(line.back()) < 4.0) break;  // reached another road
        if (!mine(line.back())) break;
      }
      const std::vector<double> half(line.size(), half_m);
      objects_.areas.push_back({{strip_ring(line, half, half), {}}, Cover::path, false});
    }
  }

  /// Those of the plan, or some.
  void plant_orchards() {
    for (const Orchard& orchard : plan_.settling.orchards) plant(orchard);
    if (!plan_.settling.orchards.empty()) return;
    const int count = static_cast<int>(5.0 * std::min(1.0, plan_.size_m / 1000.0)) + 1;
    for (int i = 0; i < count; ++i) plant_orchard();
  }

  /// Fruit trees in rows.
  void plant_orchard() {
    const double size = box_.width();
    const Vec2 corner =
        Vec2{box_.min_x, box_.min_y} + Vec2{random_.uniform(0.2, 0.8), random_.uniform(0.2, 0.8)} * size;
    const Vec2 along = unit(random_.uniform(0.0, pi)), across = left_normal(along);
    const double spacing_m = random_.uniform(7.0, 9.0), radius_m = random_.uniform(1.4, 2.4);
    for (int u = 0; u < 8; ++u)
      for (int v = 0; v < 5; ++v) {
        const double jitter_u = random_.uniform(-0.5, 0.5), jitter_v = random_.uniform(-0.5, 0.5);
        add_tree(corner + along * (u * spacing_m + jitter_u) + across * (v * spacing_m + jitter_v),
                 radius_m * random_.uniform(0.8, 1.2), 3.0, 0.0);
      }
  }

  void place_parking(const Polygon& lot) {
    objects_.areas.push_back({lot, Cover::parking, true});
    park_cars(lot);
  }

  void park_cars(const Polygon& lot) {
    const Ring& corners = lot.outer;
    const Vec2 along = normalized(corners[1] - corners[0]), inward = normalized(corners[3] - corners[0]);
    const double length_m = distance(corners[0], corners[1]), depth_m = distance(corners[0], corners[3]);
    constexpr double bay_m = 2.5, bay_depth_m = 5.0;
    for (const double row_m : {0.5 * bay_depth_m, depth_m - 0.5 * bay_depth_m})
      for (double s = 0.5 * bay_m; s + 0.5 * bay_m <= length_m; s += bay_m)
        if (random_.uniform() < 0.55 && mine(corners[0] + along * s))
          add_car(corners[0] + along * s + inward * (row_m + random_.uniform(-0.25, 0.25)),
                  std::atan2(inward.y, inward.x));
  }

  /// A shop with a flat roof on the other side of the service road.
  void place_shop(const Ring& corners) {
    const Vec2 along = normalized(corners[1] - corners[0]), inward = normalized(corners[3] - corners[0]);
    const Vec2 middle = (corners[0] + corners[1]) * 0.5;
    for (double half = 16.0; half > 5.0; half -= 1.0) {
      const House shop{
          middle - inward * (9.0 + half), std::atan2(along.y, along.x), 1.25 * half, half, 6.0, 0.0, RoofShape::flat,
          {0.62f, 0.62f, 0.61f}};
      const Ring ring = outline(shop);
      if (std::any_of(ring.begin(), ring.end(), [&](Vec2 p) { return clearance(p) < 3.0; }) ||
          clearance(shop.center) < 5.0)
        continue;
      objects_.areas.push_back(
          {{rectangle(shop.center, shop.heading_rad, 1.25 * half + 3.0, half + 3.0), {}}, Cover::paved, false});
      objects_.houses.push_back(shop);
      break;
    }
  }

  void add_car(Vec2 p, double heading) {
    Car car{p, heading + random_.normal() * 0.02 + (random_.below(2) ? pi : 0.0)};
    car.half_length_m = random_.uniform(1.95, 2.4), car.half_width_m = random_.uniform(0.85, 0.95);
    if (random_.uniform() < 0.06)
      car.half_length_m = random_.uniform(3.0, 4.5), car.half_width_m = 1.15, car.height_m = 2.8;  // van, lorry
    car.color = car_color(random_);
    objects_.cars.push_back(car);
  }

  /// Lots with a house, a garden and a drive on both sides of the streets; farther apart along the larger roads.
  void place_lots(const Stretch& stretch) {
    const std::size_t r = stretch.road;
    const PlannedRoad& road = plan_.roads[r];
    const double share = road.highway == "residential" ? 0.92
                         : road.highway == "tertiary"  ? 0.5
                         : road.highway == "service"   ? 0.6
                                                       : 0.12;
    for (const double side : {1.0, -1.0})
      for (double s = stretch.s_begin_m + random_.uniform(10.0, 20.0); s < stretch.s_end_m - 8.0;) {
        const double lot_m = random_.uniform(lots_.least_length_m, lots_.most_length_m);
        const AlignmentPoint q = evaluate(road.alignment, s + 0.5 * lot_m);
        if (one_cell_ || settled_) {
          if (random_.uniform() < built_share(road, q.p) && mine(q.p)) place_lot(q, side, lot_m, 0.5 * road.width_m);
        } else if (random_.uniform() < share &&
                   contains(circuit_, q.p + left_normal(unit(q.heading_rad)) * (side * 20.0)))
          place_lot(q, side, lot_m, 0.5 * road.width_m);
        else if (r != plan_.circuit && random_.uniform() < 0.3 * share)
          place_lot(q, side, lot_m, 0.5 * road.width_m);
        s += lot_m;
      }
  }

  /// Share of the lots beside a road of a region that have a house.
  [[nodiscard]] double built_share(const PlannedRoad& road, Vec2 p) const {
    const bool built_up = std::any_of(plan_.settlements.begin(), plan_.settlements.end(),
                                      [&](const Settlement& s) { return contains(s.outline, p); });
    if (!built_up && settled_) return 0.0;
    if (!built_up) return road.highway == "service" ? 0.3 : road.highway == "unclassified" ? 0.05 : 0.02;
    if (settled_) return plan_.settling.built_share * (road.highway == "service" ? 0.0 : 1.0);
    return road.highway == "residential" ? 0.88 : 0.65;
  }

  /// A building lot beside a road. Distances are from the road's centre line.
  struct Lot {
    AlignmentPoint q;  ///< of the road, in the middle of the lot
    Vec2 along, outward;
    double length_m = 0.0, half_road_m = 0.0;
    double walk_m = 0.0;  ///< to the outer edge of the pavement
    double setback_m = 0.0, depth_m = 0.0;
    double half_front = 0.0, half_deep = 0.0;  ///< of the house
    double turn = 0.0;                         ///< heading of house, beds and terrace: not quite the road's
    [[nodiscard]] Vec2 center() const { return q.p + outward * (walk_m + 0.5 * depth_m); }
  };
  struct Drive {
    double side = 1.0, at_m = 0.0;  ///< along the road
    double end_m = 0.0;
  };

  void place_lot(const AlignmentPoint& q, double side, double lot_m, double half_road_m) {
    Lot lot{q, unit(q.heading_rad)};
    lot.outward = left_normal(lot.along) * side;
    lot.length_m = lot_m, lot.half_road_m = half_road_m;
    const House house = draw_house(lot);
    if (!fits(house)) return;
    lay_garden(lot);
    const Drive drive = lay_drive(lot);
    objects_.houses.push_back(house);
    lay_paths(lot);
    plant_front_hedge(lot, drive);
    end_drive(lot, drive);
    plant_garden(lot, drive);
  }

  /// The house of a lot, whose own measures are drawn on the way.
  House draw_house(Lot& lot) {
    lot.walk_m = lot.half_road_m + lots_.walk_m,
    lot.setback_m = random_.uniform(lots_.least_setback_m, lots_.most_setback_m);
    lot.depth_m = random_.uniform(lots_.least_depth_m, lots_.most_depth_m);
    lot.half_front = random_.uniform(lots_.least_half_front_m,
                                     std::min(lots_.most_half_front_m, 0.5 * lot.length_m - lots_.side_gap_m));
    lot.half_deep = random_.uniform(lots_.least_half_deep_m, lots_.most_half_deep_m);
    const Vec2 center =
        lot.q.p + lot.outward * (lot.walk_m + lot.setback_m + lot.half_deep) + lot.along * random_.uniform(-1.5, 1.5);
    lot.turn = lot.q.heading_rad + random_.normal() * 0.03;
    House house{center,
                lot.turn,
                lot.half_front,
                lot.half_deep,
                random_.uniform(lots_.least_eave_m, lots_.most_eave_m),
                std::tan(random_.uniform(28.0, 46.0) * pi / 180.0),
                RoofShape::gable,
                roof_color(random_)};
    if (house.half_width_m > house.half_length_m || random_.uniform() < 0.3) {  // ridge across the street
      std::swap(house.half_length_m, house.half_width_m);
      house.heading_rad += 0.5 * pi;
    }
    return house;
  }

  [[nodiscard]] bool fits(const House& house) const {
    const Ring ring = outline(house);
    return in_site(house.center, 12.0) &&
           std::all_of(ring.begin(), ring.end(),
                       [&](Vec2 p) {
                         return clearance(p) > lots_.road_gap_m && !near_house(p, lots_.house_gap_m) &&
                                !on_water_or_parking(p) && !in_verge_of_fast_road(p, 12.0) && !on_paved_or_gravel(p);
                       }) &&
           clearance(house.center) > lots_.road_gap_m + 2.0 && !near_house(house.center, 2.0 * lots_.house_gap_m);
  }

  /// Lawn, and now and then vegetable beds at the back.
  void lay_garden(const Lot& lot) {
    if (settled_ && random_.uniform() > plan_.settling.lawn_share) {
      constexpr std::array yards{Cover::paved, Cover::gravel, Cover::garden_bed, Cover::gravel};
      objects_.areas.push_back({{rectangle(lot.center(), lot.turn, 0.5 * lot.length_m - 0.2, 0.5 * lot.depth_m), {}},
                                yards[random_.below(yards.size())],
                                false});
      return;
    }
    objects_.areas.push_back(
        {{rectangle(lot.center(), lot.q.heading_rad, 0.5 * lot.length_m - 0.3, 0.5 * lot.depth_m), {}},
         Cover::lawn,
         false});
    if (random_.uniform() < 0.45) {
      const Vec2 bed = lot.center() + lot.outward * (0.32 * lot.depth_m) + lot.along * random_.uniform(-4.0, 4.0);
      objects_.areas.push_back({{rectangle(bed, lot.turn, random_.uniform(2.0, 4.0), random_.uniform(1.5, 3.0)), {}},
                                Cover::garden_bed,
                                false});
    }
  }

  Drive lay_drive(const Lot& lot) {
    Drive drive{random_.below(2) ? 1.0 : -1.0};
    drive.at_m = drive.side * (0.5 * lot.length_m - random_.uniform(2.2, 3.2));
    drive.end_m = lot.walk_m + lot.setback_m + random_.uniform(0.0, 8.0);
    const Vec2 middle = lot.q.p + lot.along * drive.at_m + lot.outward * (0.5 * (lot.half_road_m + drive.end_m));
    objects_.areas.push_back({{rectangle(middle, lot.q.heading_rad, 1.6, 0.5 * (drive.end_m - lot.half_road_m)), {}},
                              random_.uniform() < 0.7 ? Cover::drive : Cover::gravel,
                              false});
    return drive;
  }

  /// Path to the door, terrace behind the house, now and then a pool.
  void lay_paths(const Lot& lot) {
    const Vec2 door = lot.q.p + lot.outward * (0.5 * (lot.half_road_m + lot.walk_m + lot.setback_m));
    objects_.areas.push_back(
        {{rectangle(door, lot.q.heading_rad, 0.6, 0.5 * (lot.walk_m + lot.setback_m - lot.half_road_m)), {}},
         Cover::paved,
         false});
    const double back_m = lot.walk_m + lot.setback_m + 2.0 * lot.half_deep;
    const Vec2 terrace = lot.q.p + lot.outward * (back_m + 1.5) + lot.along * random_.uniform(-2.0, 2.0);
    if (random_.uniform() < 0.7)
      objects_.areas.push_back(
          {{rectangle(terrace, lot.turn, random_.uniform(2.0, 4.5), 2.0), {}}, Cover::paved, false});
    if (random_.uniform() < 0.1)
      objects_.areas.push_back({{rectangle(terrace + lot.outward * 6.5, lot.turn, 3.2, 1.6), {}}, Cover::pool, false});
  }

  /// Along the street, with gaps for the drive and the path.
  void plant_front_hedge(const Lot& lot, const Drive& drive) {
    if (random_.uniform() < 0.6)
      for (double a = -0.5 * lot.length_m + 0.5; a < 0.5 * lot.length_m; a += 1.0)
        if (std::abs(a - drive.at_m) > 2.4 && std::abs(a) > 1.2)
          add_tree(lot.q.p + lot.outward * (lot.walk_m + 0.6) + lot.along * a, 0.65, 1.2, 1.3);
  }

  /// A garage or shed at the end of the drive, or a car on it.
  void end_drive(const Lot& lot, const Drive& drive) {
    if (random_.uniform() < 0.5) {
      const House shed{lot.q.p + lot.along * drive.at_m + lot.outward * (drive.end_m + 3.2),
                       lot.turn,
                       1.9,
                       3.1,
                       2.6,
                       0.25,
                       random_.below(2) ? RoofShape::flat : RoofShape::gable,
                       roof_color(random_)};
      const Ring corners = outline(shed);
      if (std::none_of(corners.begin(), corners.end(),
                       [&](Vec2 p) { return clearance(p) < 3.0 || near_house(p, 0.3) || !mine(p); }))
        objects_.houses.push_back(shed);
    } else if (random_.uniform() < 0.6) {
      add_car(lot.q.p + lot.along * drive.at_m + lot.outward * (0.6 * drive.end_m + 0.4 * lot.half_road_m),
              std::atan2(lot.outward.y, lot.outward.x));
    }
  }

  /// A hedge along one side of the lot, and trees.
  void plant_garden(const Lot& lot, const Drive& drive) {
    if (random_.uniform() < 0.6)
      for (double d = lot.walk_m + 1.0; d < lot.walk_m + lot.depth_m; d += 1.1)
        add_tree(lot.q.p + lot.outward * d - lot.along * (drive.side * (0.5 * lot.length_m - 0.4)),
                 random_.uniform(0.6, 0.95), 0.8, 1.5);
    const int trees = static_cast<int>(random_.below(6));
    for (int i = 0; i < trees; ++i)
      add_tree(lot.center() + lot.outward * (lot.depth_m * random_.uniform(-0.45, 0.5)) +
                   lot.along * (lot.length_m * random_.uniform(-0.45, 0.45)),
               random_.uniform(1.0, 3.4), 0.8, 0.0);
  }

  /// A tree unless it stands in a house, on water, on a parking area or nearer to a road than `min_clearance_m`.
  void add_tree(Vec2 p, double radius, double min_clearance_m, double height) {
    if (!in_site(p, one_cell_ ? 0.0 : -5.0) || clearance(p) < min_clearance_m || near_house(p, 0.6 * radius) ||
        on_water_or_parking(p) || in_verge_of_fast_road(p, radius) || on_paved_or_gravel(p))
      return;
    const bool conifer = random_.uniform() < 0.2;
    objects_.trees.push_back({p, conifer ? 0.8 * radius : radius,
                              height > 0.0 ? height : radius * random_.uniform(1.9, 2.9) + 1.0, conifer});
  }

  void grow_woods() {
    for (const Area& area : std::vector<Area>(objects_.areas)) grow_wood(area);
  }

  void plant(const Orchard& orchard) {
    const Box2 box = bounds_of(orchard.polygon.outer);
    const Vec2 middle{0.5 * (box.min_x + box.max_x), 0.5 * (box.min_y + box.max_y)}, along = unit(orchard.heading_rad),
                                                                                     across = left_normal(along);
    const double reach_m = 0.5 * std::hypot(box.width(), box.height());
    for (double v = -reach_m; v < reach_m; v += orchard.row_m)
      for (double u = -reach_m; u < reach_m; u += orchard.tree_m) {
        const Vec2 p = middle + along * (u + random_.uniform(-0.3, 0.3)) + across * (v + random_.uniform(-0.3, 0.3));
        const double radius_m = orchard.radius_m * random_.uniform(0.7, 1.15);
        if (contains(orchard.polygon, p) && random_.uniform() < 0.95)
          add_tree(p, radius_m, radius_m + 0.8, 1.2 + 1.3 * radius_m);
      }
  }

  void grow_wood(const Area& area) {
    if (area.cover != Cover::forest_floor) return;
    Box2 box = bounds_of(area.polygon.outer);
    if (one_cell_)
      box = {std::max(box.min_x, box_.min_x), std::max(box.min_y, box_.min_y), std::min(box.max_x, box_.max_x),
             std::min(box.max_y, box_.max_y)};
    constexpr double spacing_m = 4.3;
    for (double y = box.min_y; y < box.max_y; y += spacing_m)
      for (double x = box.min_x; x < box.max_x; x += spacing_m) {
        const Vec2 p{x + random_.uniform(-1.9, 1.9), y + random_.uniform(-1.9, 1.9)};
        const double radius_m = random_.uniform(2.0, 4.3), height_m = random_.uniform(9.0, 16.0);
        if (contains(area.polygon, p))
          add_tree(p, radius_m, settled_ ? plan_.settling.tree_clearance_m : 1.2, height_m);
      }
  }

  /// Alleys: stretches of a road with trees on a side; large crowns reach over the carriageway.
  void place_roadside_trees(const Stretch& stretch) {
    const std::size_t r = stretch.road;
    const PlannedRoad& road = plan_.roads[r];
    const auto noise_seed = static_cast<std::uint32_t>(random_.next());
    for (const double side : {1.0, -1.0})
      for (double s = stretch.s_begin_m; s < stretch.s_end_m; s += random_.uniform(7.0, 12.0)) {
        if (value_noise(s / 70.0, 3.0 * side, noise_seed) < 0.22 || on_bridge(plan_, r, s)) continue;
        if (settled_ && random_.uniform() > plan_.settling.roadside_trees) continue;
        const AlignmentPoint q = evaluate(road.alignment, s);
        const double away = 0.5 * road.width_m + random_.uniform(1.2, 3.2) +
                            (settled_ ? std::max(0.0, plan_.settling.tree_clearance_m - 1.2) : 0.0);
        add_tree(q.p + left_normal(unit(q.heading_rad)) * (side * away), random_.uniform(1.8, 4.4), 1.0, 0.0);
      }
  }

  void scatter_trees() {
    const double hectares = box_.width() * box_.width() / 1e4;
    const int groups = static_cast<int>((settled_ ? plan_.settling.scattered_per_ha : 4.0) * hectares);
    for (int i = 0; i < groups; ++i) {
      const Vec2 p{random_.uniform(box_.min_x, box_.max_x), random_.uniform(box_.min_y, box_.max_y)};
      if (!settled_ && !contains(circuit_, p) && random_.uniform() < 0.65) continue;  // fewer in the fields
      const int count = 1 + static_cast<int>(random_.below(4));
      for (int k = 0; k < count; ++k)
        add_tree(p + Vec2{random_.normal(), random_.normal()} * 4.0, random_.uniform(1.2, 4.0), 1.5, 0.0);
    }
  }

  void place_traffic(const Stretch& stretch) {
    const PlannedRoad& road = plan_.roads[stretch.road];
    const double spacing_m = road.highway == "residential" ? 160.0 : road.highway == "service" ? 200.0 : 90.0;
    for (double s = stretch.s_begin_m + random_.uniform(0.0, spacing_m); s < stretch.s_end_m;
         s += random_.uniform(0.3, 1.7) * spacing_m) {
      const AlignmentPoint q = evaluate(road.alignment, s);
      double t = road.oneway ? 0.0 : (random_.below(2) ? 0.25 : -0.25) * road.width_m;
      if (road.highway == "motorway")  // strip of 0.75 m, then lanes of 3.75 m from left to right
        t = 0.5 * road.width_m - 0.75 -
            3.75 * (0.5 + static_cast<double>(random_.below(static_cast<std::uint64_t>(road.lanes))));
      const Vec2 p = q.p + left_normal(unit(q.heading_rad)) * t;
      if (!mine(p) || (settled_ && road.highway == "track" && random_.uniform() < 0.8)) continue;
      if (plan_.surroundings != Surroundings::village && near_car(p)) continue;  // where roads run into each other
      add_car(p, q.heading_rad);
    }
    if (road.highway != "residential" || (settled_ && road.width_m < 6.0)) return;
    const double parked_share = settled_ ? plan_.settling.parked_share : 0.16;
    for (const double side : {1.0, -1.0})  // parked at the kerb
      for (double s = stretch.s_begin_m + 15.0; s < stretch.s_end_m - 15.0; s += 6.2) {
        if (random_.uniform() > parked_share) continue;
        const AlignmentPoint q = evaluate(road.alignment, s);
        if (!mine(q.p)) continue;
        add_car(q.p + left_normal(unit(q.heading_rad)) * (side * (0.5 * road.width_m - 1.05)), q.heading_rad);
      }
  }

  struct FastRoad {
    Polyline line;
    double half_width_m = 0.0;
  };
  struct Deck {
    Vec2 middle;
    double half_length_m = 0.0;
  };
  const SitePlan& plan_;
  const Raster<float>& clearance_;
  const GridFrame& frame_;
  Random random_;
  const LotStyle& lots_ = plan_.settling.lots;
  const bool settled_ = plan_.surroundings == Surroundings::settled;
  Box2 box_;               ///< of the site or the cell
  bool one_cell_ = false;  ///< of a region
  std::vector<Stretch> stretches_;
  std::vector<const Area*> plan_areas_;  ///< of a cell
  std::vector<Deck> decks_;
  Polygon circuit_;
  std::vector<FastRoad> fast_;
  SiteObjects objects_;
};
}  // namespace

Ring outline(const House& house) {
  return rectangle(house.center, house.heading_rad, house.half_length_m, house.half_width_m);
}

SiteObjects place_objects(const SitePlan& plan, const Raster<float>& clearance_m, const GridFrame& frame,
                          std::uint64_t seed) {
  Placer placer(plan, clearance_m, frame, seed);
  switch (plan.surroundings) {
    case Surroundings::village:
      return placer.village();
    case Surroundings::settled:
      return placer.settled();
    case Surroundings::country:
    case Surroundings::region:
      break;
  }
  return placer.country();
}

SiteObjects place_cell_objects(const SitePlan& plan, const ObjectCell& cell, const Raster<float>& clearance_m,
                               const GridFrame& frame) {
  SiteObjects objects = Placer(plan, cell, clearance_m, frame).cell();
  std::int32_t number = 0;
  const auto seed = static_cast<std::uint32_t>(cell.seed);
  const auto next_id = [&] { return static_cast<std::int32_t>(hash_lattice(number++, 0, seed) >> 1); };
  for (House& house : objects.houses) house.id = next_id();
  for (Tree& tree : objects.trees) tree.id = next_id();
  for (Area& area : objects.areas) area.id = next_id();
  return objects;
}

}  // namespace orthodrive::synth
