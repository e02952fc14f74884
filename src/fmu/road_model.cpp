// SPDX-License-Identifier: Apache-2.0
#include "fmu/road_model.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace fmu {
namespace {

constexpr std::size_t tyres = 4;
enum Input : std::size_t { x_in, y_in, z_in, inputs };
enum Output : std::size_t { z_out, normal_x, normal_y, normal_z, friction_out, class_out, status_out, outputs };

constexpr std::size_t input_ref(std::size_t tyre, Input input) { return road_parameters_end + tyre * inputs + input; }
constexpr std::size_t output_ref(std::size_t tyre, Output output) {
  return road_parameters_end + tyres * inputs + tyre * outputs + output;
}

std::vector<Variable> variables() {
  std::vector<Variable> all = road_variables();
  const auto tyre = [](std::size_t i, const char* what) { return "tyre[" + std::to_string(i + 1) + "]." + what; };
  for (std::size_t i = 0; i < tyres; ++i) {
    const auto input = [&](const char* name, const char* text) {
      all.push_back({.name = tyre(i, name), .causality = Causality::input, .unit = "m", .description = text});
    };
    input("x", "east");
    input("y", "north");
    input("z_guess", "height near the tyre: tells a deck from the road below");
  }
  for (std::size_t i = 0; i < tyres; ++i) {
    const std::vector<std::size_t> from = {input_ref(i, x_in), input_ref(i, y_in), input_ref(i, z_in)};
    const auto output = [&](const char* name, const char* unit, Type type, const char* text) {
      all.push_back({tyre(i, name), type, Causality::output, unit, text, 0.0, from});
    };
    output("z", "m", Type::float64, "height of the surface; z_guess where there is none");
    output("normal.x", "", Type::float64, "unit normal of the surface, upwards");
    output("normal.y", "", Type::float64, "unit normal of the surface, upwards");
    output("normal.z", "", Type::float64, "unit normal of the surface, upwards");
    output("friction", "", Type::float64, "largest force over load that a tyre finds; 0 where there is no surface");
    output("surface_class", "", Type::int32, "0 asphalt, 1 concrete, 2 setts, 3 gravel, 4 ground");
    output("status", "", Type::int32, "-1 bad input, 0 no surface, 1 road, 2 junction, 3 terrain");
  }
  return all;
}

class RoadModel final : public Model {
 public:
  void start(const Values& values, const std::filesystem::path& resources) override {
    ground_ = read_ground(values, resources);
    cursors_ = {};
  }

  void evaluate(Values& values) override {
    for (std::size_t i = 0; i < tyres; ++i) {
      const double x = values.number[input_ref(i, x_in)], y = values.number[input_ref(i, y_in)];
      const double guess = values.number[input_ref(i, z_in)];
      const auto set = [&](Output output, double value) { values.number[output_ref(i, output)] = value; };
      const bool usable = std::isfinite(x) && std::isfinite(y);
      const roadquery::GroundHit found = usable ? ground_->find(x, y, guess, cursors_[i]) : roadquery::GroundHit{};
      const bool here = found.place != roadquery::Place::none;
      set(z_out, here ? found.hit.z : guess);
      set(normal_x, found.hit.normal[0]);
      set(normal_y, found.hit.normal[1]);
      set(normal_z, found.hit.normal[2]);
      set(friction_out, here ? found.hit.friction : 0.0);
      set(class_out, static_cast<double>(found.hit.surface));
      set(status_out, usable ? static_cast<double>(found.place) : -1.0);
    }
  }

  void advance(const Values&, double) override {}  // roads do not change

 private:
  std::unique_ptr<roadquery::GroundQuery> ground_;
  std::array<roadquery::Cursor, tyres> cursors_;
};

}  // namespace

std::vector<Variable> road_variables() {
  std::vector<Variable> all(road_parameters_end);
  all[time_ref] = {"time", Type::float64, Causality::independent, "s", "simulated time"};
  all[road_file_ref] = {"road_file", Type::string, Causality::parameter, "",
                        "OpenDRIVE file; empty: the one that is packed with the FMU"};
  all[terrain_file_ref] = {"terrain_file", Type::string, Causality::parameter, "",
                           "ESRI ASCII grid beside the roads; empty: the one that is packed with the FMU, if any"};
  all[header_offset_ref] = {"header_offset", Type::int32, Causality::parameter, "",
                            "what is done with the offset of the OpenDRIVE header: 0 added, 1 ignored, 2 subtracted"};
  return all;
}

std::optional<std::filesystem::path> file_of(const std::string& parameter, const std::filesystem::path& resources,
                                             const char* file) {
  if (!parameter.empty()) return parameter;
  std::filesystem::path packed = resources / file;
  if (std::filesystem::is_regular_file(packed)) return packed;
  return std::nullopt;
}

std::unique_ptr<roadquery::GroundQuery> read_ground(const Values& values, const std::filesystem::path& resources) {
  const double offset = values.number[header_offset_ref];
  if (offset != 0.0 && offset != 1.0 && offset != 2.0) throw std::runtime_error("header_offset must be 0, 1 or 2");
  const auto roads = file_of(values.text[road_file_ref], resources, "roads.xodr");
  if (!roads) throw std::runtime_error("no roads: set the parameter road_file, or pack the FMU with a network");
  const auto terrain = file_of(values.text[terrain_file_ref], resources, "terrain.asc");
  roadquery::GroundStage stage{};
  return std::make_unique<roadquery::GroundQuery>(
      roadquery::read_ground({.network = roads->string(),
                              .offset = static_cast<roadquery::HeaderOffset>(static_cast<int>(offset)),
                              .terrain = terrain ? terrain->string() : std::string()},
                             stage));
}

const ModelKind& road_model() {
  static const ModelKind kind{
      "orthodrive_roads", "The road under four tyres: height, normal, friction, from an OpenDRIVE file", 0.0, 0.001,
      variables(),        [] { return std::unique_ptr<Model>(std::make_unique<RoadModel>()); }};
  return kind;
}

}  // namespace fmu
