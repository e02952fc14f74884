// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/report/site_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>

#include "orthodrive/core/escape_xml.hpp"
#include "orthodrive/core/median.hpp"
#include "orthodrive/model/rasters/sample_height.hpp"
#include "orthodrive/report/site_pictures.hpp"
#include "orthodrive/report/svg_plot.hpp"

namespace orthodrive {
namespace {
using nlohmann::json;

constexpr double offset_scale_m = 4.0, gradient_scale = 0.12;

std::string figure(const SiteReportView& in, const Raster<std::uint8_t>& rgb, const std::string& caption) {
  return html_figure(in.encoders.jpeg(rgb, 82), "jpeg", caption);
}
std::string figure(const SiteReportView& in, const Canvas& canvas, const std::string& caption) {
  return figure(in, canvas.rgb, caption);
}

std::string color_bar(const std::string& label, double high, const std::string& unit) {
  std::string stops;
  for (int i = 0; i <= 8; ++i) {
    const Color c = viridis(i / 8.0);
    stops += fmt::format("{}#{:02x}{:02x}{:02x}", i ? "," : "", c[0], c[1], c[2]);
  }
  return fmt::format("<p class=bar>{} 0 <span style=\"background:linear-gradient(90deg,{})\"></span> {:g} {}</p>\n",
                     label, stops, high, unit);
}

double median_of(const std::vector<double>& values) { return values.empty() ? std::nan("") : median(values); }

/// Share of values in bins of `step`, as a stepped line.
PlotSeries histogram(const std::vector<double>& values, double low, double high, double step, const std::string& name) {
  std::vector<double> count(static_cast<std::size_t>(std::lround((high - low) / step)), 0.0);
  for (const double v : values)
    count[static_cast<std::size_t>(std::clamp((v - low) / step, 0.0, static_cast<double>(count.size() - 1)))] += 1.0;
  PlotSeries series{.name = name};
  for (std::size_t i = 0; i < count.size(); ++i)
    for (const double x : {low + step * static_cast<double>(i), low + step * static_cast<double>(i + 1)}) {
      series.x.push_back(x);
      series.y.push_back(100.0 * count[i] / std::max<std::size_t>(1, values.size()));
    }
  return series;
}

const ReportStage* find_stage(const SiteReportView& in, const std::string& name) {
  const auto it =
      std::find_if(in.stages.begin(), in.stages.end(), [&](const ReportStage& r) { return r.name == name; });
  return it == in.stages.end() ? nullptr : &*it;
}

/// The photo for a picture of a box: a wide one does not show more than the overview has.
Photo photo_of(const SiteReportView& in, const Box2& box) {
  constexpr double wide_m = 2000.0;
  return std::max(box.width(), box.height()) > wide_m ? in.overview : window_of(in.photo, box);
}

/// The numbers a stage reported, one row each.
std::string numbers_of(const SiteReportView& in, const std::string& stage) {
  const ReportStage* record = find_stage(in, stage);
  if (!record || record->numbers.empty()) return "";
  std::vector<std::vector<std::string>> rows;
  for (const auto& [key, value] : record->numbers.items())
    if (!value.is_object())  // those have tables of their own
      rows.push_back({key, value.is_number_float() ? fmt::format("{:.5g}", value.get<double>())
                           : value.is_string()     ? value.get<std::string>()
                                                   : value.dump()});
  return html_table({stage, "value"}, rows);
}

std::string source_section(const SiteReportView& in, const Box2& box) {
  return "<h2>1. Sources: photo and OpenStreetMap roads</h2>\n" +
         figure(in, picture_of_input(in.overview, in.osm, box),
                "The orthophoto in the site's UTM zone with the roads as OpenStreetMap has them");
}

std::string segment_section(const SiteReportView& in, const Box2& box) {
  const LabelMap& labels = in.labels;
  std::vector<double> count(labels.classes.classes.size(), 0.0);
  double total = 0.0;
  for (const std::uint8_t label : labels.labels.data)
    if (label < count.size()) count[label] += 1.0, total += 1.0;
  std::string legend = "<p class=legend>";
  for (std::size_t i = 0; i < count.size(); ++i) {
    const ClassInfo& info = labels.classes.classes[i];
    legend +=
        fmt::format("<span><i style=\"background:#{:02x}{:02x}{:02x}\"></i>{} {:.1f} %</span>", info.color[0],
                    info.color[1], info.color[2], escape_xml(info.name), total > 0 ? 100.0 * count[i] / total : 0.0);
  }
  return "<h2>2. Segmentation</h2>\n" + legend + "</p>\n" +
         figure(in, canvas_of(labels, box, 1400),
                fmt::format("The class of every pixel, {:g} m/px", labels.frame.gsd_m)) +
         numbers_of(in, "segment");
}

std::string refine_section(const SiteReportView& in, const Box2& box) {
  const RoadNetwork& roads = in.roads;
  std::vector<double> offsets, sigmas;
  struct ByClass {
    double length_m = 0.0;
    std::vector<double> input, refined, sigma;
  };
  std::map<std::string, ByClass> classes;
  for (const RoadPath& path : in.osm.paths)
    for (const RoadNode& n : path.nodes) classes[path.highway].input.push_back(n.width_m);
  for (const RoadPath& path : roads.paths) {
    ByClass& c = classes[path.highway];
    c.length_m += length_m(centerline(path));
    for (const RoadNode& n : path.nodes) {
      offsets.push_back(n.offset_m);
      c.refined.push_back(n.width_m);
      c.sigma.push_back(n.sigma_width_m);
    }
  }
  std::vector<std::vector<std::string>> rows;
  rows.reserve(classes.size());
  for (const auto& [name, c] : classes)
    rows.push_back({name, fmt::format("{:.2f}", c.length_m / 1000.0), fmt::format("{:.2f}", median_of(c.input)),
                    fmt::format("{:.2f}", median_of(c.refined)), fmt::format("{:.2f}", median_of(c.sigma))});
  std::string html = "<h2>3. Roads moved onto the photo</h2>\n" +
                     color_bar("offset from OpenStreetMap", offset_scale_m, "m") +
                     figure(in, picture_of_offsets(in.overview, roads, box, offset_scale_m),
                            "Refined carriageways, colored by how far they moved") +
                     "<div class=row>";
  for (const Box2& place : telling_places(roads, 120.0, 6))
    html += figure(in, picture_of_refinement(photo_of(in, place), in.osm, roads, place),
                   "White: OpenStreetMap. Orange: refined carriageway. 120 m");
  html += "</div>\n" + html_table({"highway", "km", "input width m", "refined width m", "sigma width m"}, rows);
  const PlotSeries shares = histogram(offsets, -8.0, 8.0, 0.25, "");
  html += svg_line_plot(std::span(&shares, 1), {.title = "Offset of the centre line from OpenStreetMap",
                                                .x_label = "offset, left positive (m)",
                                                .y_label = "share of nodes (%)",
                                                .y_from_zero = true});
  return html + numbers_of(in, "refine");
}

std::string elevate_section(const SiteReportView& in, const Box2& box) {
  const RoadNetwork& roads = in.roads;
  std::string html = "<h2>4. Heights</h2>\n" + color_bar("gradient", 100.0 * gradient_scale, "%") +
                     figure(in, picture_of_gradients(in.overview, roads, box, gradient_scale),
                            "Carriageways colored by their gradient");
  std::vector<const RoadPath*> longest;
  longest.reserve(roads.paths.size());
  for (const RoadPath& path : roads.paths) longest.push_back(&path);
  std::stable_sort(longest.begin(), longest.end(),
                   [](const RoadPath* a, const RoadPath* b) { return a->nodes.back().s_m > b->nodes.back().s_m; });
  longest.resize(std::min<std::size_t>(3, longest.size()));
  for (const RoadPath* path : longest) {
    PlotSeries terrain{.name = "terrain model"}, profile{.name = "road"};
    for (const RoadNode& n : path->nodes) {
      double z = std::nan("");
      for (const HeightGrid& dtm : in.dtms)
        if (std::isnan(z)) z = sample_bilinear(dtm, n.p);
      terrain.x.push_back(n.s_m), terrain.y.push_back(z);
      profile.x.push_back(n.s_m), profile.y.push_back(n.z_m);
    }
    const PlotSeries both[2] = {terrain, profile};
    html += svg_line_plot(both, {.title = fmt::format("{} ({}, way {})", path->name.empty() ? "unnamed" : path->name,
                                                      path->highway, path->osm_id),
                                 .x_label = "distance along the way (m)",
                                 .y_label = "height (m)"});
  }
  return html + numbers_of(in, "elevate");
}

/// Kilometres of way by what they are made of, and how one knows.
std::string surface_table(const RoadNetwork& roads) {
  struct Length {
    double tagged_m = 0.0, usual_m = 0.0, seen_m = 0.0;
  };
  std::map<SurfaceClass, Length> lengths;
  for (const RoadPath& path : roads.paths) {
    Length& length = lengths[path.known_surface.surface];
    const SurfaceSource source = path.known_surface.source;
    (source == SurfaceSource::highway || source == SurfaceSource::unset ? length.usual_m
     : source == SurfaceSource::photo                                   ? length.seen_m
                                      : length.tagged_m) += length_m(centerline(path));
  }
  std::vector<std::vector<std::string>> rows;
  const auto km = [](double m) { return fmt::format("{:.2f}", m / 1000.0); };
  rows.reserve(lengths.size());
  for (const auto& [surface, length] : lengths)
    rows.push_back({roadquery::to_string(surface), km(length.tagged_m + length.usual_m + length.seen_m),
                    km(length.tagged_m), km(length.seen_m), km(length.usual_m)});
  return html_table({"surface", "km", "by tag", "by photo", "usual for the class"}, rows);
}

/// Whether every lane can be driven, the limits, and the worst places.
std::string verdict_table(const SiteReportView& in) {
  const ReportStage* network = find_stage(in, "network");
  if (!network || !network->numbers.contains("verdict")) return "";
  const json& verdict = network->numbers.at("verdict");
  std::vector<std::vector<std::string>> rows;
  for (const auto& [kind, value] : verdict.items())
    if (value.is_object())
      rows.push_back({kind, fmt::format("{:g}", value.at("limit").get<double>()),
                      fmt::format("{:.4g}", value.at("worst").get<double>()), value.at("places").dump()});
  std::string html = fmt::format("<h3>Verdict: {}</h3>\n<p>{} lanes and {} links followed with both wheels.</p>\n",
                                 verdict.at("pass").get<bool>() ? "pass" : "fail", verdict.at("lanes").dump(),
                                 verdict.at("links").dump()) +
                     html_table({"what a tyre feels", "limit", "worst", "places that fail"}, rows);
  std::vector<std::vector<std::string>> places;
  std::map<std::string, int> shown;  // the worst three of a kind come first in the findings
  for (const Finding& f : network->findings)
    if (f.code.starts_with("verdict.") && shown[f.code]++ < 3)
      places.push_back({f.code.substr(8), f.message, fmt::format("{:.1f}, {:.1f}", f.x_m, f.y_m)});
  return places.empty() ? html : html + html_table({"worst places", "", "x, y"}, places);
}

std::string network_section(const SiteReportView& in, const Box2& box) {
  const roadquery::RoadMap& map = in.map;
  const Box2 junction = busiest_junction(map, 120.0);
  return "<h2>5. OpenDRIVE road network</h2>\n" +
         figure(in, picture_of_network(in.overview, map, box),
                "Carriageway borders: roads white, connecting roads of junctions orange, bridges blue") +
         "<div class=row>" +
         figure(in, picture_of_network(photo_of(in, junction), map, junction),
                "The junction with the most connections, 120 m") +
         "</div>\n" + verdict_table(in) + surface_table(in.roads) + numbers_of(in, "network");
}

std::string scene_section(const SiteReportView& in) {
  std::string html = "<h2>6. 3D Tiles</h2>\n<div class=row>";
  if (in.scene_tile)
    html +=
        figure(in, *in.scene_tile, "The triangles of one 480 m tile from above: roads orange, cut out of the terrain");
  html += "</div>\n";
  // The screenshots are taken later, by the test of the viewer: they show up once they are there.
  for (const auto& [name, caption] :
       {std::pair{"viewer_fly.png", "The viewer over the site"}, {"viewer_follow.png", "The viewer behind the car"}})
    html += fmt::format(
        "<figure><img alt=\"{1}\" src=\"{0}\" "
        "onerror=\"this.parentNode.remove()\"><figcaption>{1}</figcaption></figure>\n",
        name, caption);
  return html + "<p>Look at it with <code>orthodrive view</code> and this folder.</p>\n" + numbers_of(in, "scene");
}

std::string drive_section(const SiteReportView& in) {
  std::istringstream csv(in.lap_csv);
  std::string line, cell;
  if (!std::getline(csv, line)) return "";
  std::map<std::string, std::vector<double>> column;
  std::vector<std::string> names;
  for (std::istringstream head(line); std::getline(head, cell, ',');) names.push_back(cell);
  while (std::getline(csv, line)) {
    std::istringstream row(line);
    for (std::size_t i = 0; i < names.size() && std::getline(row, cell, ','); ++i)
      column[names[i]].push_back(std::strtod(cell.c_str(), nullptr));
  }
  Polyline lap;
  for (std::size_t i = 0; i < column["x_m"].size(); ++i) lap.push_back({column["x_m"][i], column["y_m"][i]});
  if (lap.empty()) return "";
  const std::vector<double>& speed = column["speed_mps"];
  const double fastest = 3.6 * *std::max_element(speed.begin(), speed.end());
  Box2 box = bounds_of(lap);
  const double side = std::max({box.width(), box.height(), 100.0});
  box = Box2{0.5 * (box.min_x + box.max_x), 0.5 * (box.min_y + box.max_y), 0.5 * (box.min_x + box.max_x),
             0.5 * (box.min_y + box.max_y)}
            .grown(0.58 * side);
  std::string html = "<h2>7. The simulated drive</h2>\n" + color_bar("speed", std::round(fastest), "km/h") +
                     figure(in, picture_of_lap(photo_of(in, box), lap, speed, box), "The driven lap, colored by speed");
  return html + in.lap_plots + numbers_of(in, "drive") +
         "<p>More in <a href=\"drive/report.html\">drive/report.html</a>.</p>\n";
}

std::string score_section(const SiteReportView& in) {
  if (in.scores.is_null()) return "";
  const json& result = in.scores.at("result");
  std::vector<std::vector<std::string>> rows;
  const auto number = [](const json& object, const json::json_pointer& at) {
    return object.contains(at) && object.at(at).is_number() ? fmt::format("{:.3f}", object.at(at).get<double>())
                                                            : std::string("-");
  };
  for (const auto& [label, pointer] :
       std::vector<std::pair<std::string, std::string>>{{"road surface IoU", "/roads/surface_iou"},
                                                        {"centre line offset, mean (m)", "/roads/offset_m/mean_abs"},
                                                        {"centre line offset, 95 % (m)", "/roads/offset_m/p95"},
                                                        {"centre line offset, bias (m)", "/roads/offset_m/bias"},
                                                        {"width error, mean (m)", "/roads/width_m/mean_abs"},
                                                        {"width error, bias (m)", "/roads/width_m/bias"},
                                                        {"height error, mean (m)", "/heights/z_m/mean_abs"},
                                                        {"height error, 95 % (m)", "/heights/z_m/p95"},
                                                        {"road IoU of the labels", "/labels/road_iou"},
                                                        {"mean IoU of the labels", "/labels/mean_iou"}})
    rows.push_back({label, number(in.scores.at("input"), json::json_pointer(pointer)),
                    number(result, json::json_pointer(pointer))});
  return "<h2>8. Against the truth of this site</h2>\n" + html_table({"", "input OpenStreetMap", "result"}, rows);
}

std::string findings_section(const SiteReportView& in) {
  std::map<std::pair<std::string, std::string>, std::pair<int, std::string>>
      by_code;  // stage, code -> count, an example
  for (const ReportStage& stage : in.stages)
    for (const Finding& f : stage.findings) {
      auto& [count, example] = by_code[{stage.name, f.code}];
      if (count++ == 0) example = f.message;
    }
  if (by_code.empty()) return "<h2>Findings</h2><p>None.</p>\n";
  std::vector<std::vector<std::string>> rows;
  rows.reserve(by_code.size());
  for (const auto& [key, value] : by_code)
    rows.push_back({key.first, key.second, std::to_string(value.first), value.second});
  return "<h2>Findings</h2>\n<p>Each is a point in <a href=\"findings.geojson\">findings.geojson</a>.</p>\n" +
         html_table({"stage", "code", "places", "for example"}, rows);
}

std::string stage_section(const SiteReportView& in) {
  std::vector<std::vector<std::string>> rows;
  double total = 0.0;
  std::uint64_t peak = 0;
  rows.reserve(in.stages.size());
  for (const ReportStage& r : in.stages) {
    rows.push_back({r.name, fmt::format("{:.1f}", r.seconds),
                    fmt::format("{:.0f}", static_cast<double>(r.peak_memory_bytes) / 1e6),
                    r.taken_over ? "unchanged, taken over" : ""});
    total += r.seconds, peak = std::max(peak, r.peak_memory_bytes);
  }
  rows.push_back({"all", fmt::format("{:.1f}", total), fmt::format("{:.0f}", static_cast<double>(peak) / 1e6), ""});
  return "<h2>Seconds and memory</h2>\n" + html_table({"stage", "seconds", "peak MB", ""}, rows);
}

std::string site_headline(const SiteReportView& in) {
  double road_m = 0.0, seconds = 0.0;
  for (const RoadPath& path : in.roads.paths) road_m += length_m(centerline(path));
  std::size_t findings = 0;
  for (const ReportStage& stage : in.stages) findings += stage.findings.size(), seconds += stage.seconds;

  std::string tiles;
  const auto tile = [&](const std::string& value, const std::string& label) {
    tiles += fmt::format("<div><b>{}</b><span>{}</span></div>", escape_xml(value), label);
  };
  tile(fmt::format("{:.2f} km\u00b2", area_m2(in.area) / 1e6), "area");
  tile(fmt::format("{:.1f} km", road_m / 1000.0), "roads");
  tile(std::to_string(in.map.junctions.size()), "junctions");
  if (const ReportStage* drive = find_stage(in, "drive"); drive && drive->numbers.contains("lap_time_s"))
    tile(fmt::format("{:.1f} s", drive->numbers["lap_time_s"].get<double>()), "driven");
  tile(std::to_string(findings), "findings");
  tile(fmt::format("{:.0f} s", seconds), "to build");
  return tiles;
}

}  // namespace

std::string site_report_html(const SiteReportView& in) {
  const Box2 box = bounds_of(in.area.outer);
  std::string html = fmt::format(
      "<!doctype html>\n<html lang=en><meta charset=utf-8><meta name=viewport content=\"width=device-width\">\n"
      "<title>{0} - Orthodrive</title><style>{1}</style>\n<header><div><h1>{0}</h1><p>A drivable environment from an "
      "orthophoto, "
      "OpenStreetMap and a terrain model</p><div class=tiles>{2}</div></div></header>\n<main>\n",
      escape_xml(in.name), html_style, site_headline(in));
  html += source_section(in, box) + segment_section(in, box) + refine_section(in, box) + elevate_section(in, box);
  html += network_section(in, box) + scene_section(in) + drive_section(in) + score_section(in) + findings_section(in) +
          stage_section(in);
  html += "</main>\n<footer>";
  for (const std::string& text : in.attribution) html += "<p>" + escape_xml(text) + "</p>";
  return html +
         "<p>Made by Orthodrive. <a href=\"run.json\">run.json</a> has the version, options, hashes and "
         "timings.</p></footer></html>\n";
}

}  // namespace orthodrive
