#include "orthodrive/pipeline/score_json.hpp"

#include <fmt/format.h>

#include <cmath>

namespace orthodrive {
namespace {
ScoreJson to_json(const ErrorSummary& e) {
  return {{"bias", e.bias}, {"mean_abs", e.mean_abs}, {"p95", e.p95}, {"n", e.n}};
}
ScoreJson to_json(const SigmaCoverage& c) { return {{"1", c.one}, {"2", c.two}}; }
}  // namespace

ScoreJson to_json(const LabelScores& scores) {
  ScoreJson iou = ScoreJson::object();
  for (const ClassScore& c : scores.classes) iou[c.name] = c.iou;
  return {{"pixel_accuracy", scores.pixel_accuracy},
          {"mean_iou", scores.mean_iou},
          {"iou", iou},
          {"road_iou", scores.road_iou},
          {"pixels", scores.pixels},
          {"truth_nodata", scores.truth_nodata},
          {"not_predicted", scores.not_predicted}};
}

ScoreJson to_json(const RoadRoleScores& scores) {
  return {{"road_iou", scores.road_iou},
          {"road_precision", scores.precision},
          {"road_recall", scores.recall},
          {"pixels", scores.pixels}};
}

ScoreJson to_json(const RoadScores& scores) {
  ScoreJson coverage = to_json(scores.offset_sigma);  // of the offset; of the width one level deeper
  coverage["width"] = to_json(scores.width_sigma);
  return {{"surface_iou", scores.surface_iou},     {"offset_m", to_json(scores.offset_m)},
          {"width_m", to_json(scores.width_m)},    {"sigma_coverage", coverage},
          {"matched_share", scores.matched_share}, {"samples", scores.samples}};
}

ScoreJson to_json(const HeightScores& scores) {
  return {{"z_m", to_json(scores.z_m)},
          {"gradient", to_json(scores.gradient)},
          {"banking", to_json(scores.banking)},
          {"gradient_energy", scores.gradient_energy},
          {"height_error_energy", scores.height_error_energy_m2},
          {"nodes", scores.nodes},
          {"compared_share", scores.compared_share}};
}

ScoreJson to_json(const NetworkScores& scores) {
  return {{"roads", scores.roads},
          {"connecting_roads", scores.connecting_roads},
          {"junctions", scores.junctions},
          {"length_m", scores.length_m},
          {"elements", scores.elements},
          {"max_gradient_kink", scores.max_gradient_kink},
          {"max_joint_gap_m", scores.max_joint_gap_m},
          {"broken_links", scores.broken_links},
          {"crossings", scores.crossings},
          {"min_clearance_m", scores.min_clearance_m},
          {"connected_share", scores.connected_share}};
}

namespace {
std::string number(const ScoreJson& value) {
  if (value.is_number_float())
    return std::isnan(value.get<double>()) ? "-" : fmt::format("{:.4f}", value.get<double>());
  return value.is_null() ? "-" : value.dump();
}

void append(std::string& table, const ScoreJson& scores, int depth) {
  const std::string indent(static_cast<std::size_t>(2 * depth), ' ');
  for (const auto& [key, value] : scores.items()) {
    const std::string name = indent + key;
    if (!value.is_object()) {
      table += fmt::format("{:<24}{:>12}\n", name, number(value));
    } else if (value.contains("bias")) {
      table += fmt::format("{:<24}{:>12} bias {:>10} mean {:>10} p95 {:>8} n\n", name, number(value["bias"]),
                           number(value["mean_abs"]), number(value["p95"]), number(value["n"]));
    } else {
      table += name + "\n";
      append(table, value, depth + 1);
    }
  }
}
}  // namespace

std::string to_table(const ScoreJson& scores) {
  std::string table;
  append(table, scores, 0);
  return table;
}

}  // namespace orthodrive
