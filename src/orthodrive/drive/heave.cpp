#include "orthodrive/drive/heave.hpp"

#include <algorithm>
#include <cmath>

namespace orthodrive {
namespace {

constexpr double step_s = 5e-3, slowest_mps = 1.0;

/// Springs and dampers of all four wheels for each kilogram of the body.
struct Mount {
  double spring_ps2 = 0.0, damper_ps = 0.0;
  explicit Mount(const vehicle::CarParameters& car) {
    const double body_kg = car.body.mass_kg - 2.0 * (car.front.unsprung_mass_kg + car.rear.unsprung_mass_kg);
    const auto add = [&](const vehicle::Suspension& s, const vehicle::Tyre& t) {
      spring_ps2 += 2.0 * s.spring_npm * t.vertical_npm / (s.spring_npm + t.vertical_npm) / body_kg;
      damper_ps += (s.bump_damping_nspm + s.rebound_damping_nspm) / body_kg;  // of two wheels, mean of both directions
    };
    add(car.front, car.front_tyre), add(car.rear, car.rear_tyre);
  }
};

/// Height and slope of the line at places that only go on: cubics between its points.
class Profile {
 public:
  explicit Profile(const DrivingLine& line) : points_(line.points) {}
  struct At {
    double z_m = 0.0, slope = 0.0;
  };
  [[nodiscard]] At at(double s_m) {
    s_m = std::clamp(s_m, points_.front().s_m, points_.back().s_m);
    while (i_ + 2 < points_.size() && points_[i_ + 1].s_m < s_m) ++i_;
    const LinePoint &a = points_[i_], &b = points_[i_ + 1];
    const double h = b.s_m - a.s_m, u = (s_m - a.s_m) / h, rise = b.z_m - a.z_m;
    const double c2 = 3.0 * rise - h * (2.0 * a.gradient + b.gradient), c3 = h * (a.gradient + b.gradient) - 2.0 * rise;
    return {a.z_m + u * (h * a.gradient + u * (c2 + u * c3)), (h * a.gradient + u * (2.0 * c2 + 3.0 * u * c3)) / h};
  }

 private:
  const std::vector<LinePoint>& points_;
  std::size_t i_ = 0;
};

}  // namespace

std::vector<double> heave_mps2(const DrivingLine& line, const std::vector<double>& speed_mps,
                               const vehicle::CarParameters& car) {
  const auto& p = line.points;
  std::vector<double> most(p.size(), 0.0);
  if (p.size() < 2) return most;
  const Mount mount(car);
  const double half_m = 0.5 * car.body.wheelbase_m, share = car.body.front_share;
  Profile front(line), rear(line);
  const Profile::At start = Profile(line).at(0.0);
  double z_m = start.z_m, rise_mps = std::max(speed_mps.front(), slowest_mps) * start.slope;
  std::size_t i = 0;
  for (double s_m = 0.0; s_m < line.length_m();) {
    while (i + 2 < p.size() && p[i + 1].s_m <= s_m) ++i;
    const double u = (s_m - p[i].s_m) / (p[i + 1].s_m - p[i].s_m);
    const double v = std::max(speed_mps[i] + u * (speed_mps[i + 1] - speed_mps[i]), slowest_mps);
    const Profile::At f = front.at(s_m + half_m), r = rear.at(s_m - half_m);
    const double road_m = share * f.z_m + (1.0 - share) * r.z_m;
    const double road_mps = v * (share * f.slope + (1.0 - share) * r.slope);
    const double up_mps2 = mount.spring_ps2 * (road_m - z_m) + mount.damper_ps * (road_mps - rise_mps);
    rise_mps += step_s * up_mps2, z_m += step_s * rise_mps, s_m += step_s * v;
    most[i] = std::max(most[i], std::abs(up_mps2)), most[i + 1] = std::max(most[i + 1], std::abs(up_mps2));
  }
  return most;
}

}  // namespace orthodrive
