// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/pipeline/score/network_verdict.hpp"

#include <fmt/format.h>

#include "orthodrive/io/support/vector_io.hpp"

namespace orthodrive {
namespace {

FaultKind kind_at(std::size_t i) { return static_cast<FaultKind>(i); }

std::string say(const Fault& fault) {
  const double v = fault.value;
  switch (fault.kind) {
    case FaultKind::hole:
      return fmt::format("no road under a tyre for {:.2f} m", v);
    case FaultKind::step:
      return fmt::format("a step of {:.0f} mm", 1e3 * v);
    case FaultKind::vertical_acceleration:
      return fmt::format("{:.1f} m/s2 up or down at the legal speed", v);
    case FaultKind::twist:
      return fmt::format("the slope across changes by {:.1f} % within a wheelbase", 1e2 * v);
    case FaultKind::gap:
      return fmt::format("linked lanes end {:.2f} m apart", v);
    case FaultKind::heading_jump:
      return fmt::format("the heading jumps by {:.3f} rad", v);
    case FaultKind::curvature_jump:
      return fmt::format("the curvature jumps: {:.1f} m/s2 at once", v);
    case FaultKind::width_jump:
      return fmt::format("the width of linked lanes differs by {:.2f} m", v);
    case FaultKind::grip_jump:
      return fmt::format("the grip changes by a factor of {:.2f}", v);
  }
  return "";
}

}  // namespace

ScoreJson to_json(const NetworkVerdict& verdict) {
  ScoreJson json{{"pass", verdict.pass()},
                 {"lanes", verdict.lanes},
                 {"links", verdict.links},
                 {"track_km", verdict.track_length_m / 1e3}};
  for (std::size_t i = 0; i < fault_kinds; ++i)
    json[to_string(kind_at(i))] = {
        {"limit", driving_limit(kind_at(i))}, {"worst", verdict.worst[i]}, {"places", verdict.places[i]}};
  return json;
}

ScoreJson faults_json(const NetworkVerdict& verdict) {
  ScoreJson faults = ScoreJson::array();
  for (const Fault& fault : verdict.faults)
    faults.push_back({{"kind", to_string(fault.kind)},
                      {"value", fault.value},
                      {"limit", fault.limit},
                      {"x", fault.x},
                      {"y", fault.y},
                      {"road", fault.road},
                      {"lane", fault.lane},
                      {"s", fault.s}});
  return faults;
}

Findings findings_of(const NetworkVerdict& verdict) {
  Findings findings;
  for (const Fault& fault : verdict.faults)
    findings.push_back({Severity::warning, std::string("verdict.") + to_string(fault.kind),
                        fmt::format("road {}, lane {} at {:.1f} m: {}", fault.road, fault.lane, fault.s, say(fault)),
                        fault.x, fault.y});
  return findings;
}

std::string summary_of(const NetworkVerdict& verdict) {
  if (verdict.pass()) return fmt::format("verdict: pass, {} lanes and {} links followed", verdict.lanes, verdict.links);
  std::string kinds;
  for (std::size_t i = 0; i < fault_kinds; ++i)
    if (verdict.places[i] > 0)
      kinds += fmt::format("{}{} {}", kinds.empty() ? "" : ", ", to_string(kind_at(i)), verdict.places[i]);
  return fmt::format("verdict: fail at {} places ({})", verdict.faults.size(), kinds);
}

void write_verdict_layers(const std::filesystem::path& path, const NetworkVerdict& verdict, const Crs& crs) {
  std::vector<io::NumberLayer> layers;
  for (std::size_t i = 0; i < fault_kinds; ++i) {
    io::NumberLayer layer{.name = to_string(kind_at(i)), .fields = {"value", "limit_", "road", "lane", "s_m"}};
    for (const Fault& fault : verdict.faults)
      if (fault.kind == kind_at(i))
        layer.rows.push_back(
            {Vec2{fault.x, fault.y},
             {fault.value, fault.limit, static_cast<double>(fault.road), static_cast<double>(fault.lane), fault.s}});
    layers.push_back(std::move(layer));
  }
  io::write_layers(path, layers, crs);
}

}  // namespace orthodrive
