// SPDX-License-Identifier: Apache-2.0
#include "vehicle/car.hpp"

#include <utility>

#include "vehicle/car_model.hpp"
#include "vehicle/parse_car.hpp"

namespace vehicle {

Car::Car(CarParameters parameters) {
  check(parameters);
  model_ = std::make_unique<Model>(std::move(parameters));
}
Car::Car(const Car& other) : model_(std::make_unique<Model>(*other.model_)) {}
Car& Car::operator=(const Car& other) {
  if (this != &other) *model_ = *other.model_;
  return *this;
}
Car::Car(Car&&) noexcept = default;
Car& Car::operator=(Car&&) noexcept = default;
Car::~Car() = default;

void Car::place(double x_m, double y_m, double heading_rad, double speed_mps, Ground& ground, double z_guess_m) {
  model_->place(x_m, y_m, heading_rad, speed_mps, ground, z_guess_m);
}
void Car::step(double dt_s, const Controls& controls, Ground& ground) { model_->step(dt_s, controls, ground); }
const State& Car::state() const { return model_->state; }
const CarParameters& Car::parameters() const { return model_->car; }
double Car::energy_j() const { return model_->energy_j(); }

}  // namespace vehicle
