// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/pipeline/score/score_json.hpp"

#include <fmt/format.h>

#include <cmath>

namespace orthodrive {
namespace {
ScoreJson to_json(const ErrorSummary& e) {
  return {{"bias", e.bias}, {"mean_abs", e.mean_abs}, {"p95", e.p95}, {"n", e.n}};
}
ScoreJson to_json(const SigmaCoverage& c) { return {{"1", c.one}, {"2", c.two}}; }
ScoreJson to_json(const ProfileKink& k) { return {{"size", k.size}, {"x_m", k.where.x}, {"y_m", k.where.y}}; }
}  // namespace

namespace {
ScoreJson by_class(const LabelScores& scores, double ClassScore::*value) {
  ScoreJson json = ScoreJson::object();
  for (const ClassScore& c : scores.classes) json[c.info.name] = c.*value;
  return json;
}

ScoreJson absent_classes(const LabelScores& scores) {
  ScoreJson both = ScoreJson::array(), truth = both, prediction = both;
  for (const ClassScore& c : scores.classes) {
    if (c.truth_pixels == 0 && c.predicted_pixels == 0) both.push_back(c.info.name);
    if (c.truth_pixels == 0 && c.predicted_pixels > 0) truth.push_back(c.info.name);
    if (c.truth_pixels > 0 && c.predicted_pixels == 0) prediction.push_back(c.info.name);
  }
  return {{"from_both", both}, {"from_truth", truth}, {"from_prediction", prediction}};
}

ScoreJson to_json(const ConfusionMatrix& confusion, const std::vector<ClassScore>& classes) {
  ScoreJson names = ScoreJson::array(), rows = ScoreJson::array();
  for (std::size_t t = 0; t < confusion.classes; ++t) {
    names.push_back(classes[t].info.name);
    ScoreJson row = ScoreJson::array();
    for (std::size_t p = 0; p < confusion.classes; ++p) row.push_back(confusion.at(t, p));
    rows.push_back(std::move(row));
  }
  return {{"classes", names}, {"pixels_by_truth", rows}};
}

ScoreJson to_json(const Calibration& calibration) {
  ScoreJson bins = ScoreJson::array();
  for (std::size_t b = 0; b < calibration.bins.size(); ++b) {
    const CalibrationBin& bin = calibration.bins[b];
    bins.push_back({{"from", static_cast<double>(b) / 10.0},
                    {"to", static_cast<double>(b + 1) / 10.0},
                    {"pixels", bin.pixels},
                    {"mean_confidence", bin.mean_confidence},
                    {"accuracy", bin.accuracy}});
  }
  return {{"expected_error", calibration.expected_error},
          {"mean_confidence", calibration.mean_confidence},
          {"accuracy", calibration.accuracy},
          {"pixels", calibration.pixels},
          {"bins", bins}};
}
}  // namespace

ScoreJson to_json(const LabelScores& scores) {
  ScoreJson truth_pixels = ScoreJson::object();
  for (const ClassScore& c : scores.classes) truth_pixels[c.info.name] = c.truth_pixels;
  ScoreJson json = {{"pixel_accuracy", scores.pixel_accuracy},
                    {"mean_iou", scores.mean_iou},
                    {"mean_iou_of_truth_classes", scores.mean_iou_of_truth},
                    {"iou", by_class(scores, &ClassScore::iou)},
                    {"precision", by_class(scores, &ClassScore::precision)},
                    {"recall", by_class(scores, &ClassScore::recall)},
                    {"road_iou", scores.road_iou},
                    {"pixels", scores.pixels},
                    {"truth_nodata", scores.truth_nodata},
                    {"not_predicted", scores.not_predicted},
                    {"truth_pixels", truth_pixels},
                    {"absent", absent_classes(scores)},
                    {"confusion", to_json(scores.confusion, scores.classes)}};
  if (scores.calibration) json["calibration"] = to_json(*scores.calibration);
  return json;
}

void add_pieces(ScoreJson& json, const std::vector<PieceScores>& pieces) {
  ScoreJson scored = ScoreJson::object(), elsewhere = ScoreJson::array();
  for (const PieceScores& piece : pieces) {
    if (piece.scores.pixels == 0)
      elsewhere.push_back(piece.name);
    else
      scored[piece.name] = {{"pixel_accuracy", piece.scores.pixel_accuracy},
                            {"mean_iou", piece.scores.mean_iou},
                            {"mean_iou_of_truth_classes", piece.scores.mean_iou_of_truth},
                            {"road_iou", piece.scores.road_iou},
                            {"pixels", piece.scores.pixels},
                            {"not_predicted", piece.scores.not_predicted}};
  }
  json["pieces"] = scored;
  json["pieces_elsewhere"] = elsewhere;
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
  const CurvatureJump& jump = scores.curvature_jump;
  ScoreJson json = {{"surface_iou", scores.surface_iou},  {"offset_m", to_json(scores.offset_m)},
                    {"width_m", to_json(scores.width_m)}, {"edge_m", to_json(scores.edge_m)},
                    {"length_m", scores.length_m},        {"truth_length_m", scores.truth_length_m},
                    {"sigma_coverage", coverage},         {"matched_share", scores.matched_share},
                    {"samples", scores.samples},          {"width_variance_m2", scores.width_variance_m2}};
  json["largest_curvature_jump"] = {{"per_m", jump.per_m}, {"mean_per_m", jump.mean_per_m}};
  if (!std::isnan(jump.per_m)) {
    ScoreJson& where = json["largest_curvature_jump"];
    where["osm_id"] = jump.osm_id, where["x_m"] = jump.where.x, where["y_m"] = jump.where.y;
  }
  if (!std::isnan(scores.surface_iou_of_known_ways))
    json["surface_iou_of_known_ways"] = scores.surface_iou_of_known_ways;
  if (const auto& moved = scores.moved_away)
    json["moved_away"] = {
        {"share", moved->share}, {"share_by_more_than_0_3_m", moved->share_by_more_than_0_3_m}, {"n", moved->n}};
  return json;
}

ScoreJson to_json(const HeightScores& scores) {
  return {{"z_m", to_json(scores.z_m)},
          {"gradient", to_json(scores.gradient)},
          {"banking", to_json(scores.banking)},
          {"gradient_energy", scores.gradient_energy},
          {"true_gradient_energy", scores.true_gradient_energy},
          {"gradient_error_energy", scores.gradient_error_energy},
          {"height_error_energy", scores.height_error_energy_m2},
          {"sigma_coverage", to_json(scores.sigma)},
          {"largest_kink", to_json(scores.shape.along)},
          {"largest_junction_kink", to_json(scores.shape.junction)},
          {"largest_step_m", to_json(scores.shape.step_m)},
          {"junctions", scores.shape.junctions},
          {"crossings", scores.shape.crossings},
          {"level_crossings", scores.shape.level_crossings},
          {"min_clearance_m", scores.shape.min_clearance_m},
          {"nodes", scores.nodes},
          {"compared_share", scores.compared_share}};
}

ScoreJson to_json(const SceneScores& scores) {
  ScoreJson faults = ScoreJson::array();
  for (const Finding& fault : scores.faults)
    faults.push_back({{"code", fault.code}, {"message", fault.message}, {"x", fault.x_m}, {"y", fault.y_m}});
  return {{"levels", scores.levels},
          {"tiles", scores.tiles},
          {"tiles_of_level_0", scores.tiles_of_level_0},
          {"ground_km2", scores.ground_km2},
          {"triangles", scores.triangles},
          {"draw_calls", scores.draw_calls},
          {"bytes", scores.bytes},
          {"mb_per_km2", scores.ground_km2 > 0.0 ? 1e-6 * static_cast<double>(scores.bytes) / scores.ground_km2 : 0.0},
          {"open_edges", scores.open_edges},
          {"crowded_edges", scores.crowded_edges},
          {"road_samples", scores.road_samples},
          {"road_samples_off", scores.road_samples_off},
          {"road_error_m", scores.road_error_m},
          {"road_error_p999_m", scores.road_error_p999_m},
          {"shared_vertices", scores.shared_vertices},
          {"normal_error_deg", scores.normal_error_deg},
          {"standing_vertices", scores.standing_vertices},
          {"on_road", scores.on_road},
          {"in_building", scores.in_building},
          {"faults", std::move(faults)}};
}

ScoreJson to_json(const NetworkScores& scores) {
  ScoreJson crossings = ScoreJson::array(), dead_lanes = ScoreJson::array();
  for (const Overpass& c : scores.crossing_places)
    crossings.push_back({{"clearance_m", c.clearance_m},
                         {"x", c.x},
                         {"y", c.y},
                         {"upper",
                          {{"road", c.upper_road},
                           {"osm_id", c.upper_osm_id},
                           {"highway", c.upper_highway},
                           {"layer", c.upper_layer},
                           {"bridge", c.bridge}}},
                         {"lower",
                          {{"road", c.lower_road},
                           {"osm_id", c.lower_osm_id},
                           {"highway", c.lower_highway},
                           {"layer", c.lower_layer}}}});
  for (const LaneEnd& end : scores.dead_lane_places)
    dead_lanes.push_back({{"road", end.road}, {"lane", end.lane}, {"x", end.x}, {"y", end.y}});
  return {{"roads", scores.roads},
          {"connecting_roads", scores.connecting_roads},
          {"junctions", scores.junctions},
          {"length_m", scores.length_m},
          {"elements", scores.elements},
          {"road_length_m", scores.road_length_m},
          {"road_elements", scores.road_elements},
          {"mean_road_element_m", scores.mean_road_element_m},
          {"max_gradient_kink", scores.max_gradient_kink},
          {"max_joint_gap_m", scores.max_joint_gap_m},
          {"max_heading_jump_rad", scores.max_heading_jump_rad},
          {"max_curvature_jump", scores.max_curvature_jump},
          {"max_curvature_rate", scores.max_curvature_rate},
          {"broken_links", scores.broken_links},
          {"lane_link_errors", scores.lane_link_errors},
          {"dead_lanes", scores.dead_lanes},
          {"dead_lane_places", dead_lanes},
          {"min_lane_width_m", scores.min_lane_width_m},
          {"crossings", scores.crossings},
          {"min_clearance_m", scores.min_clearance_m},
          {"crossing_places", crossings},
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
    if (value.is_array()) {  // names are listed; what is deeper is for JSON
      if (value.empty() || !value.front().is_string()) continue;
      table += name + " ";
      for (const ScoreJson& item : value) table += " " + item.get<std::string>();
      table += '\n';
    } else if (key == "confusion") {
      continue;
    } else if (!value.is_object()) {
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
