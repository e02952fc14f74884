// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <memory>
#include <stdexcept>

#include "fmu/road_model.hpp"
#include "vehicle/car.hpp"
#include "vehicle/read_car.hpp"
#include "vehicle/road_ground.hpp"

namespace fmu {
namespace {

constexpr double step_s = 0.001;
constexpr std::size_t wheels = 4;

enum Parameter : std::size_t {
  car_file_ref = road_parameters_end,
  x_start,
  y_start,
  z_start,
  heading_start,
  speed_start,
  parameters_end
};
enum Input : std::size_t {
  steering_in = parameters_end,
  throttle_in,
  brake_in,
  clutch_in,
  automatic_in,
  gear_in,
  inputs_end
};
enum Output : std::size_t {
  x_out = inputs_end,
  y_out,
  z_out,
  heading_out,
  pitch_out,
  roll_out,
  speed_out,
  lateral_out,
  vertical_out,
  roll_rate_out,
  pitch_rate_out,
  yaw_rate_out,
  ax_out,
  ay_out,
  az_out,
  rpm_out,
  torque_out,
  gear_out,
  fuel_out,
  outputs_end
};
enum WheelOutput : std::size_t {
  load_out,
  long_force_out,
  lat_force_out,
  slip_ratio_out,
  slip_angle_out,
  spin_out,
  travel_out,
  on_road_out,
  wheel_outputs
};

constexpr std::size_t wheel_ref(std::size_t wheel, WheelOutput output) {
  return outputs_end + wheel * wheel_outputs + output;
}

struct Row {
  const char *name, *unit, *description;
  Type type = Type::float64;
  double start = 0.0;
};
void append(std::vector<Variable>& all, Causality causality, std::initializer_list<Row> rows,
            const std::string& prefix = "") {
  for (const Row& row : rows)
    all.push_back({prefix + row.name, row.type, causality, row.unit, row.description, row.start});
}

std::vector<Variable> variables() {
  std::vector<Variable> all = road_variables();
  append(all, Causality::parameter,
         {{"car_file", "", "parameters of the car; empty: car.toml that is packed with the FMU", Type::string},
          {"start.x", "m", "east"},
          {"start.y", "m", "north"},
          {"start.z_guess", "m", "height near the road: tells a deck from the road below"},
          {"start.heading", "rad", "from east, counter-clockwise"},
          {"start.speed", "m/s", "ahead"}});
  append(all, Causality::input,
         {{"steering", "rad", "mean angle of the front wheels, positive = left"},
          {"throttle", "", "0 ... 1"},
          {"brake", "", "0 ... 1"},
          {"clutch", "", "0: left to the automatic clutch, 1: pressed"},
          {"automatic", "", "the gearbox chooses among the forward gears", Type::boolean, 1.0},
          {"gear_request", "", "when not automatic: -1 reverse, 0 neutral, 1 ...", Type::int32, 1.0}});
  append(all, Causality::output,
         {{"x", "m", "east, middle of the wheelbase at road level"},
          {"y", "m", "north"},
          {"z", "m", "height"},
          {"heading", "rad", "from east, counter-clockwise"},
          {"pitch", "rad", "positive = nose down"},
          {"roll", "rad", "positive = left side up"},
          {"speed", "m/s", "of the centre of gravity, ahead"},
          {"lateral_speed", "m/s", "of the centre of gravity, to the left"},
          {"vertical_speed", "m/s", "of the centre of gravity, upwards"},
          {"roll_rate", "rad/s", "in the car's frame"},
          {"pitch_rate", "rad/s", "in the car's frame"},
          {"yaw_rate", "rad/s", "in the car's frame"},
          {"acceleration.x", "m/s2", "of the centre of gravity, ahead, without gravity"},
          {"acceleration.y", "m/s2", "of the centre of gravity, to the left, without gravity"},
          {"acceleration.z", "m/s2", "of the centre of gravity, upwards, without gravity"},
          {"engine.speed", "rpm", "of the crankshaft"},
          {"engine.torque", "N.m", "at the crankshaft"},
          {"gear", "", "-1 reverse, 0 neutral", Type::int32},
          {"fuel", "kg", "burnt since the start"}});
  for (std::size_t i = 0; i < wheels; ++i)
    append(all, Causality::output,
           {{"load", "N", "of the tyre on the road"},
            {"force.x", "N", "along the wheel's heading, in the road plane"},
            {"force.y", "N", "to the left, in the road plane"},
            {"slip_ratio", "", "negative when braking"},
            {"slip_angle", "rad", "positive = velocity to the left of the wheel"},
            {"spin", "rad/s", "about the axle"},
            {"travel", "m", "from the design position, positive = bump"},
            {"on_road", "", "false: beside the road", Type::boolean}},
           "wheel[" + std::to_string(i + 1) + "].");
  return all;
}

void write_wheel(std::vector<double>& number, std::size_t i, const vehicle::WheelState& wheel) {
  number[wheel_ref(i, load_out)] = wheel.load_n;
  number[wheel_ref(i, long_force_out)] = wheel.fx_n;
  number[wheel_ref(i, lat_force_out)] = wheel.fy_n;
  number[wheel_ref(i, slip_ratio_out)] = wheel.slip_ratio;
  number[wheel_ref(i, slip_angle_out)] = wheel.slip_angle_rad;
  number[wheel_ref(i, spin_out)] = wheel.spin_radps;
  number[wheel_ref(i, travel_out)] = wheel.travel_m;
  number[wheel_ref(i, on_road_out)] = wheel.on_road ? 1.0 : 0.0;
}

class CarModel final : public Model {
 public:
  void start(const Values& values, const std::filesystem::path& resources) override {
    const auto file = file_of(values.text[car_file_ref], resources, "car.toml");
    if (!file) throw std::runtime_error("no car: set the parameter car_file, or pack the FMU with one");
    for (std::size_t i = x_start; i <= speed_start; ++i)
      if (!std::isfinite(values.number[i])) throw std::runtime_error("a start value is not a number");
    vehicle::Car car(vehicle::read_car(*file));
    roads_ = read_ground(values, resources);
    ground_ = std::make_unique<vehicle::RoadGround>(roads_->roads());
    roadquery::Cursor cursor;
    const double x = values.number[x_start], y = values.number[y_start], z = values.number[z_start];
    if (!roads_->roads().find(x, y, z, cursor)) throw std::runtime_error("no road at start.x, start.y");
    car.place(x, y, values.number[heading_start], values.number[speed_start], *ground_, z);
    car_ = std::make_unique<vehicle::Car>(std::move(car));
    steps_ = 0;
  }

  void evaluate(Values& values) override {
    const vehicle::State& s = car_->state();
    const double outputs[] = {s.x_m,
                              s.y_m,
                              s.z_m,
                              s.heading_rad,
                              s.pitch_rad,
                              s.roll_rad,
                              s.speed_mps,
                              s.lateral_mps,
                              s.vertical_mps,
                              s.rates_radps[0],
                              s.rates_radps[1],
                              s.rates_radps[2],
                              s.acceleration_mps2[0],
                              s.acceleration_mps2[1],
                              s.acceleration_mps2[2],
                              s.engine_rpm,
                              s.engine_nm,
                              static_cast<double>(s.gear),
                              s.fuel_kg};
    static_assert(std::size(outputs) == outputs_end - x_out);
    std::copy(std::begin(outputs), std::end(outputs), values.number.begin() + x_out);
    for (std::size_t i = 0; i < wheels; ++i) write_wheel(values.number, i, s.wheels[i]);
  }

  /// Whole steps of 1 ms up to the one nearest to t_s.
  void advance(const Values& values, double t_s) override {
    const vehicle::Controls controls{.steering_rad = values.number[steering_in],
                                     .throttle = values.number[throttle_in],
                                     .brake = values.number[brake_in],
                                     .clutch = values.number[clutch_in],
                                     .automatic = values.number[automatic_in] != 0.0,
                                     .gear = static_cast<int>(values.number[gear_in])};
    for (const long long until = std::llround(t_s / step_s); steps_ < until; ++steps_)
      car_->step(step_s, controls, *ground_);
  }

 private:
  std::unique_ptr<roadquery::GroundQuery> roads_;
  std::unique_ptr<vehicle::RoadGround> ground_;
  std::unique_ptr<vehicle::Car> car_;
  long long steps_ = 0;
};

}  // namespace

const ModelKind& car_model() {
  static const ModelKind kind{"orthodrive_car", "A car on four wheels on the roads of an OpenDRIVE file",
                              step_s,           step_s,
                              variables(),      [] { return std::unique_ptr<Model>(std::make_unique<CarModel>()); }};
  return kind;
}

}  // namespace fmu
