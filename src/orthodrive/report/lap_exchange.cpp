// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/report/lap_exchange.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "orthodrive/core/escape_xml.hpp"
#include "orthodrive/geo/crs.hpp"

namespace orthodrive {
namespace {

constexpr std::size_t every = 10;      // of the samples, which are 10 ms apart
constexpr double overhang_m = 0.9;     // of a passenger car, before and behind the axles
constexpr double car_height_m = 1.45;  // boxes are drawn with it, nothing is computed from it

/// Every tenth sample, and the last.
template <typename Call>
void for_each_tenth(const DriveResult& result, Call&& call) {
  const auto& samples = result.samples;
  for (std::size_t i = 0; i < samples.size(); i += every) call(samples[i]);
  if (!samples.empty() && (samples.size() - 1) % every != 0) call(samples.back());
}

std::string world_position(const DriveSample& s, double to_rear_axle_m) {
  const double level_m = to_rear_axle_m * std::cos(s.pitch_rad);
  return fmt::format(
      R"(<Position><WorldPosition x="{:.3f}" y="{:.3f}" z="{:.3f}" h="{:.6f}" p="{:.6f}" r="{:.6f}"/></Position>)",
      s.x_m - level_m * std::cos(s.heading_rad), s.y_m - level_m * std::sin(s.heading_rad),
      s.z_m - to_rear_axle_m * std::sin(s.pitch_rad), s.heading_rad, -s.pitch_rad, s.roll_rad);
}

std::string vehicle_xml(const DriveResult& result) {
  const vehicle::CarParameters& car = result.car;
  const double wheelbase_m = car.body.wheelbase_m, length_m = wheelbase_m + 2.0 * overhang_m;
  const double width_m = std::max(car.front.track_m, car.rear.track_m) + 0.25;
  const auto axle = [](const char* name, double steer_rad, const vehicle::Tyre& tyre,
                       const vehicle::Suspension& suspension, double x_m) {
    return fmt::format(
        "          <{} maxSteering=\"{:.4f}\" wheelDiameter=\"{:.4f}\" trackWidth=\"{:.4f}\" "
        "positionX=\"{:.4f}\" positionZ=\"{:.4f}\"/>\n",
        name, steer_rad, 2.0 * tyre.radius_m, suspension.track_m, x_m, tyre.radius_m);
  };
  return fmt::format(
             "      <Vehicle name=\"{}\" vehicleCategory=\"car\" mass=\"{:.1f}\">\n"
             "        <BoundingBox>\n          <Center x=\"{:.4f}\" y=\"0\" z=\"{:.4f}\"/>\n"
             "          <Dimensions width=\"{:.4f}\" length=\"{:.4f}\" height=\"{:.4f}\"/>\n        </BoundingBox>\n"
             "        <Performance maxSpeed=\"{:.2f}\" maxAcceleration=\"{:.2f}\" maxDeceleration=\"{:.2f}\"/>\n"
             "        <Axles>\n",
             escape_xml(car.name), car.body.mass_kg, 0.5 * wheelbase_m, 0.5 * car_height_m, width_m, length_m,
             car_height_m, std::max(result.max_speed_mps, 1.0), std::max(result.max_driving_mps2, 1.0),
             std::max(result.max_braking_mps2, 1.0)) +
         axle("FrontAxle", car.steering.max_wheel_rad, car.front_tyre, car.front, wheelbase_m) +
         axle("RearAxle", 0.0, car.rear_tyre, car.rear, 0.0) +
         "        </Axles>\n        <Properties/>\n      </Vehicle>\n";
}

std::string init_xml(const DriveResult& result, double to_rear_axle_m) {
  const DriveSample first = result.samples.empty() ? DriveSample{} : result.samples.front();
  return "    <Init>\n      <Actions>\n        <Private entityRef=\"Ego\">\n"
         "          <PrivateAction><TeleportAction>" +
         world_position(first, to_rear_axle_m) +
         "</TeleportAction></PrivateAction>\n"
         "          <PrivateAction><LongitudinalAction><SpeedAction>"
         "<SpeedActionDynamics dynamicsShape=\"step\" value=\"0\" dynamicsDimension=\"time\"/>" +
         fmt::format("<SpeedActionTarget><AbsoluteTargetSpeed value=\"{:.4f}\"/></SpeedActionTarget>",
                     first.speed_mps) +
         "</SpeedAction></LongitudinalAction></PrivateAction>\n        </Private>\n      </Actions>\n    </Init>\n";
}

std::string condition_xml(const char* name, const char* rule, double time_s) {
  return fmt::format(
      "<ConditionGroup><Condition name=\"{}\" delay=\"0\" conditionEdge=\"none\"><ByValueCondition>"
      "<SimulationTimeCondition value=\"{:.3f}\" rule=\"{}\"/></ByValueCondition></Condition></ConditionGroup>",
      name, time_s, rule);
}

std::string trajectory_xml(const DriveResult& result, double to_rear_axle_m) {
  std::string xml = "<Trajectory name=\"driven way\" closed=\"false\">\n                          <Shape><Polyline>\n";
  for_each_tenth(result, [&](const DriveSample& s) {
    fmt::format_to(std::back_inserter(xml), "                            <Vertex time=\"{:.3f}\">{}</Vertex>\n", s.t_s,
                   world_position(s, to_rear_axle_m));
  });
  return xml + "                          </Polyline></Shape>\n                        </Trajectory>";
}

}  // namespace

std::string lap_gpx(const DriveResult& result, const std::string& crs) {
  const CoordinateTransform transform(Crs{crs}, Crs{"EPSG:4326"});
  std::string xml =
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<gpx version=\"1.1\" creator=\"Orthodrive\" xmlns=\"http://www.topografix.com/GPX/1/1\">\n  <trk>\n    <name>" +
      escape_xml(result.route.name) + "</name>\n    <trkseg>\n";
  for_each_tenth(result, [&](const DriveSample& s) {
    const Vec2 place = transform.target_from_source({s.x_m, s.y_m});
    const auto ms = static_cast<long>(std::lround(1000.0 * s.t_s));
    fmt::format_to(std::back_inserter(xml),
                   "      <trkpt lat=\"{:.8f}\" lon=\"{:.8f}\"><ele>{:.3f}</ele>"
                   "<time>2000-01-{:02}T{:02}:{:02}:{:02}.{:03}Z</time></trkpt>\n",
                   place.y, place.x, s.z_m, 1 + ms / 86400000, ms / 3600000 % 24, ms / 60000 % 60, ms / 1000 % 60,
                   ms % 1000);
  });
  return xml + "    </trkseg>\n  </trk>\n</gpx>\n";
}

std::string lap_openscenario(const DriveResult& result, const std::string& network) {
  const double to_rear_axle_m = 0.5 * result.car.body.wheelbase_m;
  const double end_s = result.samples.empty() ? 0.0 : result.samples.back().t_s;
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<OpenSCENARIO>\n"
         "  <FileHeader revMajor=\"1\" revMinor=\"2\" date=\"2000-01-01T00:00:00\" description=\"" +
         escape_xml("Simulated drive: " + result.route.name) +
         "\" author=\"Orthodrive\"/>\n  <CatalogLocations/>\n  <RoadNetwork>\n    <LogicFile filepath=\"" +
         escape_xml(network) + "\"/>\n  </RoadNetwork>\n  <Entities>\n    <ScenarioObject name=\"Ego\">\n" +
         vehicle_xml(result) + "    </ScenarioObject>\n  </Entities>\n  <Storyboard>\n" +
         init_xml(result, to_rear_axle_m) +
         "    <Story name=\"drive\">\n      <Act name=\"drive\">\n"
         "        <ManeuverGroup name=\"drive\" maximumExecutionCount=\"1\">\n"
         "          <Actors selectTriggeringEntities=\"false\"><EntityRef entityRef=\"Ego\"/></Actors>\n"
         "          <Maneuver name=\"drive\">\n            <Event name=\"drive\" priority=\"overwrite\">\n"
         "              <Action name=\"follow\">\n                <PrivateAction>\n"
         "                  <RoutingAction>\n                    <FollowTrajectoryAction>\n"
         "                      <TrajectoryRef>\n                        " +
         trajectory_xml(result, to_rear_axle_m) +
         "\n                      </TrajectoryRef>\n"
         "                      <TimeReference><Timing domainAbsoluteRelative=\"relative\" scale=\"1\" "
         "offset=\"0\"/></TimeReference>\n"
         "                      <TrajectoryFollowingMode followingMode=\"position\"/>\n"
         "                    </FollowTrajectoryAction>\n                  </RoutingAction>\n"
         "                </PrivateAction>\n              </Action>\n              <StartTrigger>" +
         condition_xml("at once", "greaterOrEqual", 0.0) +
         "</StartTrigger>\n            </Event>\n          </Maneuver>\n        </ManeuverGroup>\n        "
         "<StartTrigger>" +
         condition_xml("begin", "greaterOrEqual", 0.0) +
         "</StartTrigger>\n      </Act>\n    </Story>\n    <StopTrigger>" + condition_xml("end", "greaterThan", end_s) +
         "</StopTrigger>\n  </Storyboard>\n</OpenSCENARIO>\n";
}

}  // namespace orthodrive
