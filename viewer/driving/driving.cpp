// SPDX-License-Identifier: Apache-2.0
// The car on the roads of a site, for WebAssembly: the same surface and the same vehicle as the tool's own drive. One
// of each a module. src/car/driving.ts is the other side.

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <memory>
#include <new>
#include <optional>
#include <string>
#include <vector>

#include "lane_strips.hpp"
#include "roadquery/opendrive/opendrive_builder.hpp"
#include "roadquery/query/road_query.hpp"
#include "vehicle/car.hpp"
#include "vehicle/parse_car.hpp"
#include "vehicle/road_ground.hpp"

#define EXPORT(name) extern "C" __attribute__((export_name(#name)))

/// Of the page: throws there, and no call returns.
extern "C" __attribute__((import_module("page"), import_name("fail"))) void fail(const char* text, std::size_t length);

// The toolchain has no exceptions: whatever is thrown ends the module with its text. All that is thrown here is a
// std::exception.
extern "C" {
void* __cxa_allocate_exception(std::size_t bytes) noexcept { return std::malloc(bytes); }
[[noreturn]] void __cxa_throw(void* thrown, void* /*type*/, void (* /*destroy*/)(void*)) {
  const char* text = static_cast<std::exception*>(thrown)->what();
  fail(text, std::strlen(text));
  std::abort();
}
}

namespace {

constexpr double step_s = 0.001;

/// Roads, and beside them the plane that the page has last told.
class SiteGround final : public vehicle::Ground {
 public:
  explicit SiteGround(const roadquery::RoadQuery& query) : roads_(query) {}

  [[nodiscard]] vehicle::GroundPoint at(int wheel, double x_m, double y_m, double z_guess_m) override {
    vehicle::GroundPoint point = roads_.at(wheel, x_m, y_m, z_guess_m);
    if (point.on_road || !beside_) return point;
    const vehicle::GroundPoint beside = beside_->at(wheel, x_m, y_m, z_guess_m);
    return {beside.z_m, beside.normal, beside.friction, false};
  }
  void set_beside(const vehicle::PlaneGround& plane) { beside_ = plane; }

 private:
  vehicle::RoadGround roads_;
  std::optional<vehicle::PlaneGround> beside_;
};

constexpr double grass_friction = 0.55;  // of dry asphalt's

std::unique_ptr<roadquery::OpenDriveBuilder> builder;
std::unique_ptr<roadquery::RoadQuery> roads;
std::unique_ptr<vehicle::Car> car;
std::optional<SiteGround> ground;
double time_owed_s = 0.0;

std::vector<float> strips;

// In the order of `stateNames` in src/car/driving.ts.
std::array<double, 25> values;

void write_state() {
  const vehicle::State& s = car->state();
  std::size_t n = 0;
  for (const double v :
       {s.x_m, s.y_m, s.z_m, s.heading_rad, -s.pitch_rad, s.roll_rad, s.speed_mps, s.acceleration_mps2[1],
        s.acceleration_mps2[0], s.throttle, static_cast<double>(s.gear), s.engine_rpm, s.steering_rad})
    values[n++] = v;
  for (const vehicle::WheelState& wheel : s.wheels) values[n++] = wheel.ground_z_m;
  for (const vehicle::WheelState& wheel : s.wheels) values[n++] = wheel.load_n;
  for (const vehicle::WheelState& wheel : s.wheels) values[n++] = wheel.on_road ? 1.0 : 0.0;
}

/// The text up to its 0, and `at` behind it.
const char* next_text(const char*& at) {
  const char* text = at;
  at += std::strlen(at) + 1;
  return text;
}

}  // namespace

EXPORT(allocate) void* allocate(std::size_t bytes) { return std::malloc(bytes); }

/// Elements of an OpenDRIVE file. Each begins with a letter: S and the name, then names and values of attributes, then
/// an empty text; E and the name; T and characters. All texts end with a 0.
EXPORT(add_elements) void add_elements(const char* bytes, std::size_t count) {
  if (!builder) builder = std::make_unique<roadquery::OpenDriveBuilder>();
  std::vector<const char*> attributes;
  for (const char *at = bytes, *end = bytes + count; at < end;) {
    const char kind = *at++;
    const char* text = next_text(at);
    if (kind == 'E') {
      builder->end(text);
    } else if (kind == 'T') {
      builder->text(text);
    } else {
      attributes.clear();
      while (*at != '\0') attributes.push_back(next_text(at));
      ++at;
      attributes.push_back(nullptr);
      builder->start(text, attributes.data());
    }
  }
}

EXPORT(finish_roads) void finish_roads() {
  if (!builder) builder = std::make_unique<roadquery::OpenDriveBuilder>();
  roads = std::make_unique<roadquery::RoadQuery>(builder->finish(roadquery::HeaderOffset::add));
  builder.reset();
}

/// How many numbers lane_strips() gives; strips_at() tells where they are.
EXPORT(make_strips) std::size_t make_strips(double x_m, double y_m, double z_m) {
  strips = lane_strips(*roads, {x_m, y_m, z_m});
  return strips.size();
}
EXPORT(strips_at) const float* strips_at() { return strips.data(); }

/// Text of a file of models/vehicles.
EXPORT(set_car) void set_car(const char* text, std::size_t count) {
  car = std::make_unique<vehicle::Car>(vehicle::parse_car({text, count}, "car"));
}

/// Puts the car on the road, at rest or rolling; z: near the road's height. Returns the state's values.
EXPORT(place) const double* place(double x_m, double y_m, double heading_rad, double speed_mps, double z_m) {
  ground.emplace(*roads);
  time_owed_s = 0.0;
  car->place(x_m, y_m, heading_rad, speed_mps, *ground, z_m);
  write_state();
  return values.data();
}

/// What lies beside the roads near the car: z = z0 + gradient_x x + gradient_y y.
EXPORT(set_beside) void set_beside(double z0_m, double gradient_x, double gradient_y) {
  if (ground) ground->set_beside(vehicle::PlaneGround(z0_m, gradient_x, gradient_y, grass_friction));
}

/// Drives on; gear 1: the gearbox chooses, 0: neutral, -1: reverse.
EXPORT(advance)
void advance(double elapsed_s, double steering_rad, double throttle, double brake, int gear) {
  if (!ground) return;  // nobody has placed the car
  const vehicle::Controls controls{
      .steering_rad = steering_rad, .throttle = throttle, .brake = brake, .automatic = gear > 0, .gear = gear};
  for (time_owed_s += elapsed_s; time_owed_s >= step_s; time_owed_s -= step_s) car->step(step_s, controls, *ground);
  write_state();
}
