// SPDX-License-Identifier: Apache-2.0
#include "roadquery/crg/road_crgs.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

#include "roadquery/crg/read_crg.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace roadquery {
namespace {

constexpr double range_rounding_m = 1e-6;
constexpr double knot_m = 4.0;  // of the table that tells where along the file a road runs
constexpr std::size_t most_knots_of_one = 4096, most_knots = 20'000'000;

[[noreturn]] void refuse(const Road& road, const std::string& what) {
  throw std::runtime_error("road " + std::to_string(road.id) + ": " + what);
}

std::string path_of(const std::string& folder, const std::string& file) {
  return folder.empty() || file.starts_with('/') ? file : folder.ends_with('/') ? folder + file : folder + "/" + file;
}

}  // namespace

RoadCrgs::RoadCrgs(const RoadMap& map, const std::string& folder) {
  std::map<std::string, std::shared_ptr<const CrgGrid>> grids;
  for (const Road& road : map.roads) {
    first_layer_.push_back(layers_.size());
    for (const SurfaceCrg& reference : road.surface) {
      std::shared_ptr<const CrgGrid>& grid = grids[path_of(folder, reference.file)];
      try {
        if (!grid) grid = std::make_shared<const CrgGrid>(read_crg(path_of(folder, reference.file)));
      } catch (const std::runtime_error& error) {
        const std::string what = error.what(), path = path_of(folder, reference.file);
        refuse(road, what.starts_with(path) ? what : path + ": " + what);
      }
      add(road, reference, grid);
    }
    std::stable_partition(layers_.begin() + static_cast<std::ptrdiff_t>(first_layer_.back()), layers_.end(),
                          [](const Layer& layer) { return layer.mode != Mode::attached; });
  }
  first_layer_.push_back(layers_.size());
}

void RoadCrgs::add(const Road& road, const SurfaceCrg& reference, const std::shared_ptr<const CrgGrid>& grid) {
  const auto note = [&](const std::string& what) {
    notes_.push_back("road " + std::to_string(road.id) + ": " + reference.file + ": " + what);
  };
  Layer layer;
  layer.grid = grid;
  const std::map<std::string, Mode> modes = {{"attached", Mode::attached},
                                             {"attached0", Mode::attached0},
                                             {"genuine", Mode::genuine},
                                             {"global", Mode::global}};
  const auto mode = modes.find(reference.mode);
  if (mode == modes.end())
    refuse(road, "<CRG> has the mode '" + reference.mode + "', need attached, attached0, genuine or global");
  layer.mode = mode->second;
  if (reference.orientation == "opposite") layer.sign = -1.0;
  if (reference.orientation != "same" && reference.orientation != "opposite" && !reference.orientation.empty())
    refuse(road, "<CRG> has the orientation '" + reference.orientation + "', need same or opposite");
  layer.is_friction = reference.purpose == "friction";
  if (!layer.is_friction && reference.purpose != "elevation") {
    note("purpose '" + reference.purpose + "' is neither elevation nor friction, the file is passed over");
    return;
  }
  if (layer.is_friction && layer.mode == Mode::attached) {
    layer.mode = Mode::attached0;  // road.crg.attach_vs_friction
    note("friction cannot be attached, it is taken as attached0");
  }
  layer.s_start = reference.s_start, layer.s_end = reference.s_end;
  layer.s_offset = reference.s_offset, layer.t_offset = reference.t_offset;
  if (!layer.is_friction) layer.z_offset = reference.z_offset, layer.z_scale = reference.z_scale;
  if (layer.mode == Mode::genuine || layer.mode == Mode::global) place_line(layer, road, reference);
  layers_.push_back(std::move(layer));
}

/// Puts the file's reference line beside the road's, and finds where along it the road runs.
void RoadCrgs::place_line(Layer& layer, const Road& road, const SurfaceCrg& reference) {
  const CrgGrid& grid = *layer.grid;
  double turn = reference.h_offset;
  layer.from_x = reference.x_offset, layer.from_y = reference.y_offset;
  if (layer.mode == Mode::genuine) {
    const PlanPoint start = reference_point(road, layer.s_offset);
    const SurfacePoint at = surface_point(road, layer.s_offset, layer.t_offset, start);
    turn += start.hdg - grid.start_phi_rad();
    layer.from_x = at.x, layer.from_y = at.y;
    layer.to_x = grid.start_x_m(), layer.to_y = grid.start_y_m();
  }
  layer.cos_turn = std::cos(turn), layer.sin_turn = std::sin(turn);

  const double begin = std::clamp(layer.s_start, 0.0, road.length), end = std::clamp(layer.s_end, begin, road.length);
  const auto count = static_cast<std::size_t>(
      std::clamp(std::ceil((end - begin) / knot_m), 1.0, static_cast<double>(most_knots_of_one)));
  knots_ += count + 1;
  if (knots_ > most_knots) refuse(road, "the map's references to OpenCRG files are too many to hold");
  layer.s_start_of_knots = begin;
  layer.knots_per_s = end > begin ? static_cast<double>(count) / (end - begin) : 0.0;
  double u = grid.u_first_m() + begin - layer.s_offset;
  for (std::size_t i = 0; i <= count; ++i) {
    const PlanPoint p =
        reference_point(road, begin + (end - begin) * static_cast<double>(i) / static_cast<double>(count));
    const double dx = p.x - layer.from_x, dy = p.y - layer.from_y;
    const double x = layer.cos_turn * dx + layer.sin_turn * dy + layer.to_x;
    const double y = layer.cos_turn * dy - layer.sin_turn * dx + layer.to_y;
    auto place = i == 0 && layer.mode == Mode::global ? grid.place(x, y) : grid.place(x, y, u);
    if (place) u = place->u_m;
    layer.u_of_knot.push_back(static_cast<float>(u - grid.u_first_m()));
  }
}

RoadCrgs::Height RoadCrgs::by_st(const Layer& layer, const RoadPlace& place) {
  const CrgHeight h =
      layer.grid->evaluate(layer.sign * (place.s - layer.s_offset), layer.sign * (place.t - layer.t_offset),
                           layer.mode == Mode::attached ? CrgPart::grid : CrgPart::whole);
  return {h.z_m, layer.sign * (h.dz_du * place.s_per_along + h.dz_dv * place.t_per_along),
          layer.sign * (h.dz_du * place.s_per_left + h.dz_dv * place.t_per_left)};
}

RoadCrgs::Height RoadCrgs::by_xy(const Layer& layer, const RoadPlace& place) {
  const double dx = place.x - layer.from_x, dy = place.y - layer.from_y;
  const double x = layer.cos_turn * dx + layer.sin_turn * dy + layer.to_x;
  const double y = layer.cos_turn * dy - layer.sin_turn * dx + layer.to_y;
  const std::size_t last = layer.u_of_knot.size() - 1;
  const double knot =
      std::clamp((place.s - layer.s_start_of_knots) * layer.knots_per_s, 0.0, static_cast<double>(last));
  const std::size_t i = std::min(static_cast<std::size_t>(knot), last - 1);
  const double u_hint =
      layer.u_of_knot[i] + (knot - static_cast<double>(i)) * (layer.u_of_knot[i + 1] - layer.u_of_knot[i]);
  const auto at = layer.grid->place(x, y, layer.grid->u_first_m() + u_hint);
  if (!at) return {std::nan(""), 0.0, 0.0};
  const CrgHeight h = layer.grid->evaluate(at->u_m, at->v_m, CrgPart::whole);
  const double dz_dx = h.dz_du * at->du_dx + h.dz_dv * at->dv_dx, dz_dy = h.dz_du * at->du_dy + h.dz_dv * at->dv_dy;
  // The road's heading in the file's coordinates.
  const double c = layer.cos_turn * place.cos_hdg + layer.sin_turn * place.sin_hdg;
  const double n = layer.cos_turn * place.sin_hdg - layer.sin_turn * place.cos_hdg;
  return {h.z_m, dz_dx * c + dz_dy * n, dz_dy * c - dz_dx * n};
}

void RoadCrgs::lay(int road, const RoadPlace& place, LaidSurface& surface) const {
  const auto index = static_cast<std::size_t>(road);
  for (std::size_t i = first_layer_[index]; i < first_layer_[index + 1]; ++i) {
    const Layer& layer = layers_[i];
    if (!(place.s >= layer.s_start - range_rounding_m && place.s <= layer.s_end + range_rounding_m)) continue;
    const bool in_plane = layer.mode == Mode::genuine || layer.mode == Mode::global;
    const Height h = in_plane ? by_xy(layer, place) : by_st(layer, place);
    if (std::isnan(h.z)) continue;
    if (layer.is_friction) {
      surface.friction = h.z;
      continue;
    }
    const double z = layer.z_scale * h.z + layer.z_offset;
    const double along = layer.z_scale * h.along, left = layer.z_scale * h.left;
    if (layer.mode == Mode::attached) {
      surface.z += z, surface.rise_along += along, surface.rise_left += left;
    } else {
      surface.z = z, surface.rise_along = along, surface.rise_left = left;
    }
  }
}

std::vector<CrgStep> find_crg_steps(const RoadMap& map, const RoadCrgs& crgs, double least_m) {
  constexpr double beside_m = 1e-4, columns = 16.0;
  const auto height = [&](std::size_t index, double s, double t) {
    const Road& road = map.roads[index];
    const PlanPoint p = reference_point(road, s);
    const SurfacePoint point = surface_point(road, s, t, p);
    LaidSurface surface{point.z, 0.0, 0.0, 1.0};
    if (crgs.on(static_cast<int>(index)))
      crgs.lay(static_cast<int>(index), {s, t, point.x, point.y, std::cos(p.hdg), std::sin(p.hdg), 1.0, 1.0}, surface);
    return surface.z;
  };
  std::vector<CrgStep> steps;
  for (std::size_t index = 0; index < map.roads.size(); ++index) {
    const Road& road = map.roads[index];
    for (const SurfaceCrg& reference : road.surface)
      for (const double s : {reference.s_start, reference.s_end}) {
        if (!(s - beside_m > 0.0 && s + beside_m < road.length)) continue;
        const Edges edges = road_edges(road, s);
        CrgStep worst{static_cast<int>(index), s, 0.0, least_m};
        for (double k = 0.0; k <= columns; k += 1.0) {
          const double t = edges.right_t + k / columns * (edges.left_t - edges.right_t);
          const double step = std::abs(height(index, s + beside_m, t) - height(index, s - beside_m, t));
          if (step > worst.step_m) worst.t = t, worst.step_m = step;
        }
        if (worst.step_m > least_m) steps.push_back(worst);
      }
  }
  return steps;
}

void load_crgs(RoadMap& map, const std::string& xodr) {
  const std::size_t slash = xodr.rfind('/');
  const std::string folder = slash == std::string::npos ? "" : slash == 0 ? "/" : xodr.substr(0, slash);
  map.crgs = std::make_shared<const RoadCrgs>(map, folder);
}

}  // namespace roadquery
