// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/report/lap_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "orthodrive/core/escape_xml.hpp"
#include "orthodrive/report/svg_plot.hpp"
#include "roadquery/surface/road_surface.hpp"
#include "vehicle/envelope.hpp"

namespace orthodrive {
namespace {

constexpr double kmh_per_mps = 3.6;
constexpr double deg_per_rad = 180.0 / std::numbers::pi;

template <typename Value>
std::vector<double> column(const DriveResult& result, Value&& value) {
  std::vector<double> values;
  values.reserve(result.samples.size());
  for (const DriveSample& s : result.samples) values.push_back(value(s));
  return values;
}

/// Reference lines of all roads, as the background of the map.
std::vector<PlotSeries> road_lines(const roadquery::RoadMap& map) {
  constexpr double step_m = 5.0;
  std::vector<PlotSeries> lines;
  for (const roadquery::Road& road : map.roads) {
    PlotSeries line;
    const int steps = 1 + static_cast<int>(road.length / step_m);
    for (int k = 0; k <= steps; ++k) {
      const auto p = roadquery::reference_point(road, road.length * k / steps);
      line.x.push_back(p.x), line.y.push_back(p.y);
    }
    lines.push_back(std::move(line));
  }
  return lines;
}

}  // namespace

namespace {

std::string minutes(double time_s) {
  return fmt::format("{}:{:06.3f}", static_cast<int>(time_s) / 60, std::fmod(time_s, 60.0));
}

}  // namespace

std::vector<std::pair<std::string, std::string>> lap_numbers(const DriveResult& r) {
  std::vector<std::pair<std::string, std::string>> rows;
  const auto add = [&](const char* label, std::string value) { rows.emplace_back(label, std::move(value)); };
  add("Route", r.route.name + (r.route.closed ? " (closed)" : " (open)"));
  add("Car", r.car.name);
  add("Driven", fmt::format("{:.1f} m{}", r.length_m, r.finished ? "" : ", not to the end"));
  add("Lap time", fmt::format("{}, planned {}{}", minutes(r.lap_time_s), minutes(r.plan_time_s),
                              r.lap_times_s.size() > 1 ? fmt::format(", fastest of {}", r.lap_times_s.size()) : ""));
  add("Speed, mean and largest",
      fmt::format("{:.1f} and {:.1f} km/h", r.mean_speed_mps * kmh_per_mps, r.max_speed_mps * kmh_per_mps));
  add("Largest acceleration",
      fmt::format("{:.2f} m/s² lateral, {:.2f} driving, {:.2f} braking, {:.2f} vertical", r.max_lateral_mps2,
                  r.max_driving_mps2, r.max_braking_mps2, r.max_vertical_mps2));
  if (r.fuel_kg > 0.0 && r.length_m > 0.0)
    add("Fuel", fmt::format("{:.3f} kg, {:.2f} kg/100 km", r.fuel_kg, 1e5 * r.fuel_kg / r.length_m));
  if (r.stops > 0) add("Stops", fmt::format("{}", r.stops));
  add("Gradient", fmt::format("{:+.1f} % to {:+.1f} %, {:.1f} m of climb", 100.0 * r.min_gradient,
                              100.0 * r.max_gradient, r.climb_m));
  add("Largest roll", fmt::format("{:.2f}°", r.max_roll_rad * deg_per_rad));
  add("Largest distance from the line", fmt::format("{:.3f} m", r.max_line_error_m));
  add("Tyre contacts off the road", fmt::format("{:.3f} % of {}", 100.0 * r.off_road_share, r.tyre_queries));
  add("Largest step of a contact height in 1 ms",
      fmt::format("{:.2f} mm, {:.0f} m into the lap", 1000.0 * r.max_height_step_m, r.max_height_step_s_m));
  add("Simulation", fmt::format("{:.0f} times real time, {:.2f} million tyre queries a second", r.real_time_factor(),
                                1e-6 * r.tyre_queries_per_s()));
  return rows;
}

namespace {

/// What the car can do at a speed on a level road: the rim of the g-g diagram.
PlotSeries envelope_rim(const vehicle::CarParameters& car, double speed_mps, const char* color) {
  constexpr int steps = 60;
  PlotSeries rim{.name = fmt::format("limit at {:.0f} km/h", speed_mps * kmh_per_mps), .color = color, .dashed = true};
  const double side = vehicle::envelope(car, {.speed_mps = speed_mps}).max_lateral_mps2;
  const auto add = [&](double lateral, double longitudinal) {
    rim.x.push_back(lateral), rim.y.push_back(longitudinal);
  };
  for (int i = -steps; i <= steps; ++i) {
    const double lateral = side * std::sin(0.5 * std::numbers::pi * i / steps);
    add(lateral, vehicle::envelope(car, {.speed_mps = speed_mps, .lateral_mps2 = lateral}).max_drive_mps2);
  }
  for (int i = steps; i >= -steps; --i) {
    const double lateral = side * std::sin(0.5 * std::numbers::pi * i / steps);
    add(lateral, -vehicle::envelope(car, {.speed_mps = speed_mps, .lateral_mps2 = lateral}).max_brake_mps2);
  }
  rim.x.push_back(rim.x.front()), rim.y.push_back(rim.y.front());
  return rim;
}

std::string gg_diagram(const DriveResult& result) {
  constexpr std::size_t every = 10;
  PlotSeries points{.name = "driven", .dots = true, .dot_radius_px = 1.6};
  for (std::size_t i = 0; i < result.samples.size(); i += every)
    points.x.push_back(result.samples[i].a_lat_mps2), points.y.push_back(result.samples[i].a_lon_mps2);
  const std::vector<PlotSeries> series = {std::move(points), envelope_rim(result.car, 60.0 / kmh_per_mps, "#66727f"),
                                          envelope_rim(result.car, std::max(result.max_speed_mps, 1.0), "#d55e00")};
  return svg_line_plot(series, {.title = "g-g diagram",
                                .x_label = "lateral acceleration (left +), m/s²",
                                .y_label = "longitudinal, m/s²",
                                .width_px = 620,
                                .height_px = 520});
}

}  // namespace

std::vector<std::string> lap_plots(const roadquery::RoadMap& map, const DriveResult& result) {
  const std::vector<double> s = column(result, [](const DriveSample& p) { return p.s_m; });
  const auto series = [&](const char* name, auto&& value) {
    return PlotSeries{name, s, column(result, value), "", false};
  };
  const auto wheel = [&](const char* name, std::size_t i, auto&& of) {
    return series(name, [&](const DriveSample& p) { return of(p)[i]; });
  };
  const auto plot = [](std::vector<PlotSeries> lines, const char* title, const char* unit, bool from_zero = false) {
    return svg_line_plot(lines,
                         {.title = title, .x_label = "distance driven, m", .y_label = unit, .y_from_zero = from_zero});
  };
  const auto load = [](const DriveSample& p) {
    auto kn = p.load_n;
    for (double& v : kn) v *= 1e-3;
    return kn;
  };
  PlotSeries planned = series("planned", [](const DriveSample& p) { return p.planned_mps * kmh_per_mps; });
  planned.dashed = true;
  return {
      svg_map_plot({column(result, [](const DriveSample& p) { return p.x_m; }),
                    column(result, [](const DriveSample& p) { return p.y_m; }),
                    column(result, [](const DriveSample& p) { return p.speed_mps * kmh_per_mps; })},
                   road_lines(map), {.title = "The lap", .value_label = "km/h", .start_label = "start"}),
      plot({series("driven", [](const DriveSample& p) { return p.speed_mps * kmh_per_mps; }), std::move(planned)},
           "Speed", "km/h", true),
      plot({series("", [](const DriveSample& p) { return p.a_lat_mps2; })}, "Lateral acceleration (left +)", "m/s²",
           true),
      gg_diagram(result),
      plot({series("throttle", [](const DriveSample& p) { return 100.0 * p.throttle; }),
            series("brake", [](const DriveSample& p) { return 100.0 * p.brake; })},
           "Pedals", "%", true),
      plot({series("", [](const DriveSample& p) { return static_cast<double>(p.gear); })}, "Gear", "", true),
      plot({series("", [](const DriveSample& p) { return p.steering_rad * deg_per_rad; })},
           "Steering angle of the front wheels (left +)", "degrees", true),
      plot({wheel("front left", 0, load), wheel("front right", 1, load), wheel("rear left", 2, load),
            wheel("rear right", 3, load)},
           "Loads of the tyres", "kN", true),
      plot({series("longitudinal (ahead +)", [](const DriveSample& p) { return p.a_lon_mps2; }),
            series("vertical (up +)", [](const DriveSample& p) { return p.a_vert_mps2; })},
           "Longitudinal and vertical acceleration", "m/s²", true),
      plot({series("", [](const DriveSample& p) { return p.z_m; })}, "Height", "m"),
      plot({series("", [](const DriveSample& p) { return 100.0 * p.gradient; })}, "Gradient", "%", true),
      plot({series("roll (left side up +)", [](const DriveSample& p) { return p.roll_rad * deg_per_rad; }),
            series("pitch (nose up +)", [](const DriveSample& p) { return p.pitch_rad * deg_per_rad; })},
           "Roll and pitch of the body", "degrees", true),
  };
}

std::string lap_report_html(const roadquery::RoadMap& map, const DriveResult& result) {
  std::string html = fmt::format(
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>{0}</title>\n<style>\n"
      "body{{font:15px/1.5 system-ui,sans-serif;color:#1f2933;background:#f4f6f8;margin:0;padding:24px}}\n"
      "main{{max-width:1000px;margin:auto}} h1{{font-size:24px;margin:0 0 16px}}\n"
      "section{{background:#fff;border:1px solid #e4e8ec;border-radius:8px;padding:16px;margin-bottom:16px}}\n"
      "table{{border-collapse:collapse;width:100%}} td,th{{padding:4px 12px 4px "
      "0;text-align:left;vertical-align:top}}\n"
      "tr+tr td{{border-top:1px solid #e4e8ec}} td:first-child{{color:#66727f;white-space:nowrap}}\n"
      "</style></head><body><main>\n<h1>{0}</h1>\n",
      escape_xml("Lap: " + result.route.name));
  html += "<section><table>\n";
  for (const auto& [label, value] : lap_numbers(result)) {
    html += "<tr><td>" + escape_xml(label) + "</td><td>" + escape_xml(value) + "</td></tr>\n";
  }
  html += "</table></section>\n";
  for (const std::string& plot : lap_plots(map, result)) html += "<section>\n" + plot + "</section>\n";
  if (!result.findings.empty()) {
    html += "<section><h2>Findings</h2><table>\n";
    for (const Finding& finding : result.findings) {
      html += fmt::format("<tr><td>{}</td><td>{}</td><td>{:.1f}, {:.1f}</td></tr>\n", escape_xml(finding.code),
                          escape_xml(finding.message), finding.x_m, finding.y_m);
    }
    html += "</table></section>\n";
  }
  return html + "</main></body></html>\n";
}

}  // namespace orthodrive
