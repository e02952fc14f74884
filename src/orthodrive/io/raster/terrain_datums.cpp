// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/raster/terrain_datums.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include "orthodrive/geo/geoid.hpp"
#include "orthodrive/model/rasters/height_offset.hpp"

namespace orthodrive::io {
namespace fs = std::filesystem;

namespace {

/// Of two models of one place, the one that is 3.28 times as high is in feet.
void feet_to_metres(const std::vector<fs::path>& paths, const Box2& box, std::vector<HeightGrid>& grids,
                    Findings* findings) {
  constexpr double foot_m = 0.3048;
  for (std::size_t a = 0; a < grids.size(); ++a)
    for (std::size_t b = a + 1; b < grids.size(); ++b) {
      const std::optional<HeightOffset> offset = height_offset(grids[a], grids[b], box);
      if (!offset || (!offset->first_in_feet && !offset->second_in_feet)) continue;
      const auto [feet, metres] = offset->first_in_feet ? std::pair(a, b) : std::pair(b, a);
      for (float& z : grids[feet].height_m.data) z = static_cast<float>(foot_m * static_cast<double>(z));
      if (findings)
        findings->push_back({Severity::warning, "terrain.feet",
                             fmt::format("{} is 3.28 times as high as {}: its heights are taken for feet",
                                         paths[feet].filename().string(), paths[metres].filename().string()),
                             offset->middle.x, offset->middle.y});
    }
}

constexpr double largest_shift_m = 120.0;  // sea level is nowhere farther from the ellipsoid

/// What is done about two models that differ.
enum class DatumVerdict { agree, differ, shift };

/// Models of different sources differ by decimetres, and coarse ones more on steep ground. What is the same everywhere
/// is a datum; what is not may be trees and houses in a surface model, and a shift would not mend it.
DatumVerdict verdict_on(const HeightOffset& offset) {
  constexpr double least_shift_m = 0.5, least_difference_m = 2.0;
  const double size_m = std::abs(offset.median_m), sigma_m = offset.sigma_m();
  if (size_m >= least_shift_m && size_m <= largest_shift_m && sigma_m <= 0.1 * size_m) return DatumVerdict::shift;
  const bool differ = size_m >= least_shift_m && size_m >= 3.0 * sigma_m;
  return differ || (size_m >= least_difference_m && size_m >= sigma_m) ? DatumVerdict::differ : DatumVerdict::agree;
}

/// Height of sea level over the ellipsoid; 0 where it is not known.
double sea_level_m(const Crs& crs, Vec2 p) {
  const Vec2 lonlat = CoordinateTransform(crs, {"EPSG:4326"}).target_from_source(p);
  return Geoid().height_m(lonlat.x, lonlat.y);
}

/// Two models, a before b, that differ by a constant.
class DatumStep {
 public:
  DatumStep(const fs::path& path_a, const HeightGrid& a, const fs::path& path_b, const HeightGrid& b,
            const HeightOffset& offset)
      : a_(path_a.filename().string()), b_(path_b.filename().string()), offset_(offset) {
    const double sea_m = sea_level_m(a.crs, offset.middle), dz_m = offset.median_m;
    const double near_m = std::max(1.5, 0.1 * std::abs(sea_m));
    constexpr double least_sea_m = 5.0;  // less is no proof
    const bool a_is_ellipsoidal = std::abs(sea_m) > least_sea_m && std::abs(dz_m - sea_m) < near_m;
    const bool b_is_ellipsoidal = std::abs(sea_m) > least_sea_m && std::abs(dz_m + sea_m) < near_m;
    ellipsoidal_ = a_is_ellipsoidal || b_is_ellipsoidal;
    moves_a_ = a_is_ellipsoidal || (!ellipsoidal_ && a.vertical_datum.empty() && !b.vertical_datum.empty());
    named_ = !ellipsoidal_ && a.vertical_datum.empty() != b.vertical_datum.empty();
  }
  /// The first is moved onto the second, instead of the second onto the first.
  [[nodiscard]] bool moves_a() const { return moves_a_; }

  [[nodiscard]] Finding shifted() const {
    const std::string why = ellipsoidal_ ? "its heights are over the ellipsoid, those of the other over sea level"
                            : named_     ? "the other names its vertical datum"
                                         : "the other is given before it";
    return {Severity::warning, "terrain.shifted",
            fmt::format("{}; {} is {} by that, since {}", told(), moves_a_ ? a_ : b_,
                        (offset_.median_m > 0.0) == moves_a_ ? "lowered" : "raised", why),
            offset_.middle.x, offset_.middle.y};
  }
  [[nodiscard]] Finding left_as_it_is() const {
    return {Severity::warning, "terrain.models_differ",
            told() +
                (std::abs(offset_.median_m) > largest_shift_m ? ", more than datums differ" : ", not by a constant") +
                ": taken as they are, so roads may step where the models meet; take one of them, or bring both to one "
                "vertical datum",
            offset_.middle.x, offset_.middle.y};
  }

 private:
  [[nodiscard]] std::string told() const {
    const bool a_is_higher = offset_.median_m > 0.0;
    const double low_m = a_is_higher ? offset_.low_m : -offset_.high_m,
                 high_m = a_is_higher ? offset_.high_m : -offset_.low_m;
    return fmt::format("{} is {:.2f} m higher than {} {} (half of it {:.2f} to {:.2f} m)", a_is_higher ? a_ : b_,
                       std::abs(offset_.median_m), a_is_higher ? b_ : a_,
                       offset_.along_border ? "where one ends and the other goes on" : "where both have heights", low_m,
                       high_m);
  }

  std::string a_, b_;
  HeightOffset offset_;
  bool ellipsoidal_ = false, named_ = false, moves_a_ = false;
};

void lift(HeightGrid& grid, double by_m) {
  for (float& z : grid.height_m.data) z = static_cast<float>(static_cast<double>(z) + by_m);
}

/// Each model against the best one before it that it can be compared with. Those that were found to be over one datum
/// move together.
void shift_datums(const std::vector<fs::path>& paths, const Box2& box, std::vector<HeightGrid>& grids,
                  Findings* findings) {
  std::vector<std::size_t> group(grids.size());
  std::iota(group.begin(), group.end(), std::size_t{0});
  for (std::size_t b = 1; b < grids.size(); ++b)
    for (std::size_t a = 0; a < b; ++a) {
      const std::optional<HeightOffset> offset = height_offset(grids[a], grids[b], box);
      if (!offset) continue;
      const DatumVerdict verdict = verdict_on(*offset);
      const DatumStep step(paths[a], grids[a], paths[b], grids[b], *offset);
      if (findings && verdict == DatumVerdict::shift) findings->push_back(step.shifted());
      if (findings && verdict == DatumVerdict::differ) findings->push_back(step.left_as_it_is());
      if (verdict != DatumVerdict::shift) {
        if (verdict == DatumVerdict::agree) group[b] = group[a];
        break;
      }
      const std::string datum = grids[step.moves_a() ? b : a].vertical_datum;
      for (std::size_t k = 0; k <= b; ++k) {
        if (step.moves_a() ? k == b || group[k] != group[a] : k != b) continue;
        lift(grids[k], step.moves_a() ? -offset->median_m : offset->median_m);
        grids[k].vertical_datum = datum;
      }
      group[b] = group[a];
      break;
    }
}

/// Heights over one datum lie up to metres from those over another one: where two models meet, roads would step.
void tell_datums(const std::vector<fs::path>& paths, const Box2& box, const std::vector<HeightGrid>& grids,
                 Findings& findings) {
  const Vec2 p{0.5 * (box.min_x + box.max_x), 0.5 * (box.min_y + box.max_y)};
  std::string unnamed;
  const HeightGrid* named = nullptr;
  for (std::size_t i = 0; i < grids.size(); ++i) {
    const std::string& datum = grids[i].vertical_datum;
    if (datum.empty()) {
      unnamed += (unnamed.empty() ? "" : ", ") + paths[i].filename().string();
    } else if (named && named->vertical_datum != datum) {
      findings.push_back(
          {Severity::warning, "terrain.datums_differ",
           fmt::format("heights of {} are over {}, those of a model before it over {}: taken as they are, "
                       "so roads may step where the models meet; convert one of them",
                       paths[i].filename().string(), datum, named->vertical_datum),
           p.x, p.y});
    } else {
      named = &grids[i];
    }
  }
  if (!unnamed.empty())
    findings.push_back({Severity::info, "terrain.datum_not_named",
                        fmt::format("{}: no vertical datum is named, heights are taken as they are", unnamed), p.x,
                        p.y});
}

}  // namespace

void to_one_datum(const std::vector<fs::path>& paths, const Box2& box, std::vector<HeightGrid>& grids,
                  Findings* findings) {
  feet_to_metres(paths, box, grids, findings);
  shift_datums(paths, box, grids, findings);
  if (findings) tell_datums(paths, box, grids, *findings);
}

}  // namespace orthodrive::io
