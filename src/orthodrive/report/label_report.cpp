// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/report/label_report.hpp"

#include <fmt/format.h>

#include <cmath>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/escape_xml.hpp"
#include "orthodrive/report/label_pictures.hpp"
#include "orthodrive/report/svg_plot.hpp"

namespace orthodrive {
namespace {
constexpr int overview_px = 1200, piece_px = 512, tile_px = 256;
constexpr std::size_t most_places = 6, most_pieces = 24;

std::string number(double value, int decimals = 4) {
  return std::isnan(value) ? "-" : fmt::format("{:.{}f}", value, decimals);
}
std::string percent(double value) { return std::isnan(value) ? "-" : fmt::format("{:.2f} %", 100.0 * value); }

std::string swatch(const Color& color, const std::string& name) {
  return fmt::format("<i style=\"background:#{:02x}{:02x}{:02x}\"></i>{}", color[0], color[1], color[2],
                     escape_xml(name));
}

std::string headline(const LabelScores& scores) {
  std::string tiles;
  const auto tile = [&](const std::string& value, const char* label) {
    tiles += fmt::format("<div><b>{}</b><span>{}</span></div>", value, label);
  };
  tile(percent(scores.pixel_accuracy), "pixel accuracy");
  tile(percent(scores.mean_iou), "mean IoU");
  tile(percent(scores.mean_iou_of_truth), "mean IoU, classes of the truth");
  tile(percent(scores.road_iou), "road IoU");
  if (scores.calibration) tile(percent(scores.calibration->expected_error), "calibration error");
  tile(fmt::format("{:.3g} Mpx", static_cast<double>(scores.pixels) / 1e6), "compared");
  return tiles;
}

std::string names_where(const LabelScores& scores, bool in_truth, bool in_prediction) {
  std::string names;
  for (const ClassScore& c : scores.classes)
    if ((c.truth_pixels > 0) == in_truth && (c.predicted_pixels > 0) == in_prediction)
      names += (names.empty() ? "" : ", ") + escape_xml(c.info.name);
  return names;
}

/// What was compared and which classes the mean leaves out or counts as zero.
std::string notes(const LabelReportView& report) {
  const LabelScores& scores = report.scores;
  std::string html = fmt::format(
      "<p>{} pixels of {:g} m are compared. The truth leaves {} pixels open; at {} pixels with truth there is no "
      "prediction.</p>\n",
      scores.pixels, report.view.frame().gsd_m, scores.truth_nodata, scores.not_predicted);
  if (const std::string none = names_where(scores, false, false); !none.empty())
    html += fmt::format("<p>In neither map, so in no mean: <b>{}</b>.</p>\n", none);
  if (const std::string zero = names_where(scores, false, true); !zero.empty())
    html += fmt::format(
        "<p>Predicted, but absent from the truth: <b>{}</b>. Their IoU is 0 and counts in the mean IoU, as in the "
        "reference (its class 'water'); the mean over the classes of the truth leaves them out.</p>\n",
        zero);
  if (const std::string missed = names_where(scores, true, false); !missed.empty())
    html += fmt::format("<p>Never predicted: <b>{}</b>. Their IoU is 0 and counts.</p>\n", missed);
  if (!report.merge.empty()) {
    html += "<p>Merged before counting:";
    for (const auto& [from, to] : report.merge)
      html += fmt::format(" <b>{}</b> into <b>{}</b>;", escape_xml(from), escape_xml(to));
    html.back() = '.';
    html += "</p>\n";
  }
  return html;
}

std::string class_section(const LabelReportView& report) {
  std::string html =
      "<h2>Classes</h2>\n<table class=\"legend\"><thead><tr><th>class</th><th>IoU</th><th>precision</th>"
      "<th>recall</th><th>true pixels</th><th>predicted pixels</th><th></th></tr></thead><tbody>\n";
  for (const ClassScore& c : report.scores.classes) {
    const char* note = c.truth_pixels > 0       ? (c.predicted_pixels > 0 ? "" : "never predicted")
                       : c.predicted_pixels > 0 ? "absent from the truth"
                                                : "absent";
    html += fmt::format(
        "<tr><td>{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td>"
        "<td class=\"n\">{}</td><td>{}</td></tr>\n",
        swatch(c.info.color, c.info.name), number(c.iou), number(c.precision), number(c.recall), c.truth_pixels,
        c.predicted_pixels, note);
  }
  return html + "</tbody></table>\n";
}

std::string confusion_section(const LabelScores& scores) {
  std::vector<std::string> names;
  std::vector<double> shares;
  names.reserve(scores.classes.size());
  for (std::size_t t = 0; t < scores.classes.size(); ++t) {
    names.push_back(scores.classes[t].info.name);
    const auto whole = static_cast<double>(scores.classes[t].truth_pixels);  // 0 / 0 is NaN: an empty row
    for (std::size_t p = 0; p < scores.classes.size(); ++p)
      shares.push_back(static_cast<double>(scores.confusion.at(t, p)) / whole);
  }
  return "<h2>Confusion</h2>\n<p>What became of the true pixels of each class, in percent: each row adds up to 100. "
         "The "
         "colours exaggerate small shares; 10&#160;% is bright orange.</p>\n" +
         svg_share_matrix(names, shares,
                          {.title = "Share of the true class (%)", .row_label = "truth", .column_label = "prediction"});
}

std::string calibration_section(const Calibration& calibration, bool merged) {
  PlotSeries ideal{.name = "ideal", .x = {0.0, 1.0}, .y = {0.0, 1.0}, .color = "#66727f", .dashed = true};
  PlotSeries measured{.name = "labels"};
  std::vector<std::vector<std::string>> rows;
  for (std::size_t b = 0; b < calibration.bins.size(); ++b) {
    const CalibrationBin& bin = calibration.bins[b];
    rows.push_back({fmt::format("{:.1f} to {:.1f}", static_cast<double>(b) / 10.0, static_cast<double>(b + 1) / 10.0),
                    std::to_string(bin.pixels), number(bin.mean_confidence), number(bin.accuracy)});
    if (bin.pixels == 0) continue;
    measured.x.push_back(bin.mean_confidence), measured.y.push_back(bin.accuracy);
  }
  const PlotSeries both[] = {measured, ideal};
  return fmt::format(
             "<h2>Calibration</h2>\n<p>The mean stated probability is {}, and {} of these labels are right. In a bin "
             "of "
             "stated probability both differ by {} on average (expected calibration error). {}</p>\n",
             number(calibration.mean_confidence), number(calibration.accuracy), number(calibration.expected_error),
             merged ? "Right means right before merging: the probability is that of one class." : "") +
         svg_line_plot(both, {.title = "Reliability",
                              .x_label = "mean stated probability of a bin",
                              .y_label = "share that is right",
                              .width_px = 560,
                              .height_px = 420,
                              .y_from_zero = true}) +
         html_table({"stated probability", "pixels", "mean", "share right"}, rows);
}

std::string piece_section(const std::vector<PieceScores>& pieces) {
  std::vector<std::vector<std::string>> rows;
  std::string elsewhere;
  for (const PieceScores& piece : pieces) {
    if (piece.scores.pixels == 0)
      elsewhere += (elsewhere.empty() ? "" : ", ") + escape_xml(piece.name);
    else
      rows.push_back({piece.name, number(piece.scores.pixel_accuracy), number(piece.scores.mean_iou),
                      number(piece.scores.mean_iou_of_truth), number(piece.scores.road_iou),
                      std::to_string(piece.scores.pixels)});
  }
  std::string html =
      "<h2>Pieces</h2>\n" +
      html_table({"piece", "pixel accuracy", "mean IoU", "mean IoU, classes of the truth", "road IoU", "pixels"}, rows);
  if (!elsewhere.empty()) html += "<p>Not covered by the prediction: " + elsewhere + ".</p>\n";
  return html;
}

std::optional<Photo> photo_on(const LabelReportView& report, const GridFrame& frame) {
  return report.photo_on ? report.photo_on(frame) : std::nullopt;
}

std::string png_figure(const LabelReportView& report, const Canvas& canvas, const std::string& caption) {
  return html_figure(report.encoders.png(canvas.rgb), "png", caption);
}

std::string place_row(const LabelReportView& report, const LabelPlace& place, int max_px) {
  const GridFrame frame = picture_frame(report.view, place.box, max_px);
  const std::optional<Photo> photo = photo_on(report, frame);
  std::string html = fmt::format("<h3>{}</h3>\n<p>{} of {} pixels are wrong; accuracy {}.</p>\n<div class=\"four\">",
                                 escape_xml(place.name), place.wrong, place.pixels, percent(place.accuracy()));
  if (photo)
    html += html_figure(
        report.encoders.jpeg(canvas_of(*photo, frame.bounds(), std::max(frame.width, frame.height)).rgb, 85), "jpeg",
        "photo");
  html += png_figure(report, picture_of_classes(report.view, frame, LabelSide::truth), "truth");
  html += png_figure(report, picture_of_classes(report.view, frame, LabelSide::prediction), "prediction");
  html += png_figure(report, picture_of_errors(report.view, frame, photo ? &*photo : nullptr), "errors");
  return html + "</div>\n";
}

std::string picture_section(const LabelReportView& report) {
  const LabelPlace whole = whole_place(report.view);
  if (whole.pixels == 0) return "";
  std::string html =
      "<h2>What is wrong</h2>\n<p>Right pixels are grey, pixels out of the score pale. Wrong ones have the colour of "
      "the "
      "predicted class, and classes that are grey themselves a vivid one:</p>\n<p class=\"legend\">";
  const std::vector<Color> colors = error_colors(report.view.classes());
  for (std::size_t c = 0; c < colors.size(); ++c)
    if (report.scores.classes[c].predicted_pixels > 0)
      html += "<span>" + swatch(colors[c], report.view.classes()[c].name) + "</span> ";
  const GridFrame frame = picture_frame(report.view, whole.box, overview_px);
  const std::optional<Photo> photo = photo_on(report, frame);
  if (report.photo_on && !photo) {
    throw InputError(report.photo_name, "shows nothing of what is scored; take the photo that the labels were made of");
  }
  html += "</p>\n" + png_figure(report, picture_of_errors(report.view, frame, photo ? &*photo : nullptr),
                                fmt::format("Errors of the predicted labels, {:.2g} m a pixel", frame.gsd_m));

  std::vector<LabelPlace> places = piece_places(report.view, report.piece_map);
  const bool in_pieces = !places.empty();
  html += in_pieces ? "<h2>Pieces, least accurate first</h2>\n" : "<h2>The worst places</h2>\n";
  if (places.size() > most_pieces) places.resize(most_pieces);
  if (!in_pieces) places = worst_places(report.view, tile_px, most_places);
  for (const LabelPlace& place : places) html += place_row(report, place, in_pieces ? piece_px : tile_px);
  if (places.empty()) html += "<p>None: every label is right.</p>\n";
  return html;
}

/// More than the style of the other pages: four pictures in a row, label pixels as squares.
constexpr const char* more_style =
    "h3{margin:1.6rem 0 0}.four{display:grid;grid-template-columns:repeat(auto-fit,minmax(200px,1fr));gap:.6rem}"
    ".four img{width:100%;image-rendering:pixelated}svg{background:#fff}\n";
}  // namespace

std::string label_report_html(const LabelReportView& report) {
  std::string html = fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"/><meta name=\"viewport\" "
      "content=\"width=device-width\"/>\n<title>Labels of {0} - Orthodrive</title><style>{1}{2}</style></head>\n<body>"
      "<header><div><h1>Labels against truth</h1><p>{0} against {3}</p><div class=\"tiles\">{4}</div></div></header>\n"
      "<main>\n",
      escape_xml(report.scored), html_style, more_style, escape_xml(report.truth), headline(report.scores));
  html += notes(report) + class_section(report) + confusion_section(report.scores);
  if (report.scores.calibration) html += calibration_section(*report.scores.calibration, !report.merge.empty());
  if (!report.pieces.empty()) html += piece_section(report.pieces);
  html += picture_section(report);
  return html + "</main>\n<footer><p>Made by Orthodrive.</p></footer></body></html>\n";
}

}  // namespace orthodrive
