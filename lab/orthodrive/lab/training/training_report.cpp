// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/lab/training/training_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/escape_xml.hpp"
#include "orthodrive/report/svg_plot.hpp"

namespace orthodrive {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr const char* raw_color = "#b9cfe0";
constexpr const char* smooth_color = "#0072b2";
// Okabe and Ito's palette as in svg_plot.cpp: a validation keeps its colour on all plots.
constexpr std::array curve_colors = {"#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"};

/// Fields of a CSV line; a quoted field may hold commas and doubled quotes.
std::vector<std::string> split_csv(std::string_view line) {
  std::vector<std::string> fields(1);
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (quoted && c == '"' && i + 1 < line.size() && line[i + 1] == '"') {
      fields.back() += '"', ++i;
    } else if (c == '"') {
      quoted = !quoted;
    } else if (c == ',' && !quoted) {
      fields.emplace_back();
    } else {
      fields.back() += c;
    }
  }
  return fields;
}

std::string quote_csv(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"') quoted += '"';
    quoted += c == '\n' || c == '\r' ? ' ' : c;
  }
  return quoted + '"';
}

/// A row by the names of its columns.
class LogLine {
 public:
  LogLine(const std::map<std::string, std::size_t>& columns, std::vector<std::string> fields, std::string place)
      : columns_(columns), fields_(std::move(fields)), place_(std::move(place)) {}

  [[nodiscard]] std::string text(const char* column) const {
    const auto it = columns_.find(column);
    return it == columns_.end() ? "" : fields_.at(it->second);
  }
  template <typename T>
  [[nodiscard]] std::optional<T> number(const char* column) const {
    const std::string field = text(column);
    if (field.empty()) return std::nullopt;
    T value{};
    const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
    if (error != std::errc() || end != field.data() + field.size()) {
      throw InputError(place_, fmt::format("{} '{}' is no number: repair or remove the line", column, field));
    }
    return value;
  }

 private:
  const std::map<std::string, std::size_t>& columns_;
  std::vector<std::string> fields_;
  std::string place_;
};

TrainReport parse_row(const LogLine& line) {
  TrainReport row;
  row.step = line.number<std::int64_t>("step").value_or(0);
  row.learning_rate = line.number<double>("learning_rate").value_or(0.0);
  row.loss = line.number<double>("loss").value_or(0.0);
  row.seconds = line.number<double>("seconds").value_or(0.0);
  row.validation = line.text("validation");
  row.stage = line.text("stage");
  row.road_iou = line.number<double>("road_iou");
  row.mean_iou = line.number<double>("mean_iou");
  row.pixel_accuracy = line.number<double>("pixel_accuracy");
  return row;
}

/// Geometric mean over `half_width` rows to each side; losses are positive and spread over decades.
std::vector<double> smoothed(const std::vector<double>& loss, std::size_t half_width) {
  std::vector<double> sum(loss.size() + 1, 0.0), count(loss.size() + 1, 0.0), result(loss.size(), nan);
  for (std::size_t i = 0; i < loss.size(); ++i) {
    const bool usable = std::isfinite(loss[i]) && loss[i] > 0.0;
    sum[i + 1] = sum[i] + (usable ? std::log(loss[i]) : 0.0);
    count[i + 1] = count[i] + (usable ? 1.0 : 0.0);
  }
  for (std::size_t i = 0; i < loss.size(); ++i) {
    const std::size_t begin = i - std::min(i, half_width), end = std::min(loss.size(), i + half_width + 1);
    if (count[end] > count[begin]) result[i] = std::exp((sum[end] - sum[begin]) / (count[end] - count[begin]));
  }
  return result;
}

/// The rows of one validation, and which of them has the highest mean IoU (the first of equals).
struct Validation {
  std::string name, color;
  std::vector<const TrainReport*> rows;
  const TrainReport* best = nullptr;
};

std::vector<Validation> validations_of(std::span<const TrainReport> rows) {
  std::vector<Validation> all;
  for (const TrainReport& row : rows) {
    if (row.validation.empty()) continue;
    auto it = std::find_if(all.begin(), all.end(), [&](const Validation& v) { return v.name == row.validation; });
    if (it == all.end())
      it = all.insert(all.end(), Validation{row.validation, curve_colors[all.size() % curve_colors.size()], {}});
    it->rows.push_back(&row);
    const double iou = row.mean_iou.value_or(nan);
    if (std::isfinite(iou) && (!it->best || iou > it->best->mean_iou.value_or(nan))) it->best = &row;
  }
  return all;
}

std::string loss_plot(std::span<const TrainReport> rows) {
  PlotSeries raw{.name = "each report", .color = raw_color, .width = 1.0};
  for (const TrainReport& row : rows) {
    if (!row.validation.empty()) continue;
    raw.x.push_back(static_cast<double>(row.step));
    raw.y.push_back(row.loss);
  }
  if (raw.x.empty()) return "";
  const PlotSeries smooth{.name = "smoothed",
                          .x = raw.x,
                          .y = smoothed(raw.y, std::max<std::size_t>(1, raw.y.size() / 40)),
                          .color = smooth_color,
                          .width = 2.0};
  return svg_line_plot(std::array{smooth, raw}, {.title = "Loss", .x_label = "step", .height_px = 300, .y_log = true});
}

std::string rate_plot(std::span<const TrainReport> rows) {
  PlotSeries rate{.color = smooth_color};
  for (const TrainReport& row : rows) {
    if (!row.validation.empty()) continue;
    rate.x.push_back(static_cast<double>(row.step));
    rate.y.push_back(row.learning_rate);
  }
  if (rate.x.empty()) return "";
  return svg_line_plot(std::array{rate},
                       {.title = "Learning rate", .x_label = "step", .height_px = 180, .y_from_zero = true});
}

std::string score_plot(std::span<const TrainReport> rows, const std::vector<Validation>& validations, const char* title,
                       std::optional<double> TrainReport::*score) {
  // Without points, for its range of steps: all plots have the same, so that they can be read one below the other.
  const PlotSeries all_steps{.x = {static_cast<double>(rows.front().step), static_cast<double>(rows.back().step)},
                             .y = {nan, nan}};
  std::vector<PlotSeries> rings{all_steps}, lines;
  bool any = false;
  for (const Validation& v : validations) {
    PlotSeries line{.name = v.name, .color = v.color};
    for (const TrainReport* row : v.rows) {
      line.x.push_back(static_cast<double>(row->step));
      line.y.push_back((row->*score).value_or(nan));
      any = any || std::isfinite(line.y.back());
    }
    lines.push_back(std::move(line));
    if (!v.best) continue;
    rings.push_back({.x = {static_cast<double>(v.best->step)},
                     .y = {(v.best->*score).value_or(nan)},
                     .color = v.color,
                     .dots = true});
  }
  if (!any) return "";
  rings.insert(rings.end(), lines.begin(), lines.end());  // the first is drawn on top
  return svg_line_plot(rings, {.title = title, .x_label = "step", .height_px = 280});
}

std::string score_cells(const TrainReport* row) {
  if (!row) return "<td></td><td></td><td></td><td></td>";
  std::string cells = fmt::format("<td>{}</td>", row->step);
  for (const auto& score : {row->mean_iou, row->road_iou, row->pixel_accuracy}) {
    cells += score && std::isfinite(*score) ? fmt::format("<td>{:.4f}</td>", *score) : "<td>–</td>";
  }
  return cells;
}

std::string score_table(const std::vector<Validation>& validations) {
  if (validations.empty()) return "<p>No validation yet.</p>\n";
  const std::string heads = "<th>step</th><th>mean IoU</th><th>road IoU</th><th>accuracy</th>";
  std::string html =
      "<table><thead><tr><th rowspan=\"2\">validation</th><th colspan=\"4\">best mean IoU</th>"
      "<th colspan=\"4\">last</th></tr><tr>" +
      heads + heads + "</tr></thead><tbody>\n";
  for (const Validation& v : validations) {
    html += fmt::format("<tr><th><i style=\"background:{}\"></i>{}</th>{}{}</tr>\n", v.color, escape_xml(v.name),
                        score_cells(v.best), score_cells(v.rows.back()));
  }
  return html + "</tbody></table>\n<p>A ring marks the step of the best mean IoU.</p>\n";
}

/// `seconds` starts again with each process: the sum over the processes.
double trained_seconds(std::span<const TrainReport> rows) {
  double before = 0.0, last = 0.0;
  for (const TrainReport& row : rows) {
    if (row.seconds < last) before += last;
    last = row.seconds;
  }
  return before + last;
}

}  // namespace

std::string format_log_header() {
  return "step,learning_rate,loss,seconds,validation,road_iou,mean_iou,pixel_accuracy,stage\n";
}

std::string format_log_row(const TrainReport& row) {
  const auto score = [](const std::optional<double>& value) { return value ? fmt::format("{:.4f}", *value) : ""; };
  return fmt::format("{},{:.6g},{},{:.1f},{},{},{},{},{}\n", row.step, row.learning_rate,
                     row.validation.empty() ? fmt::format("{:.6g}", row.loss) : "", row.seconds,
                     quote_csv(row.validation), score(row.road_iou), score(row.mean_iou), score(row.pixel_accuracy),
                     quote_csv(row.stage));
}

std::vector<TrainReport> parse_training_log(std::string_view csv, const std::string& source) {
  std::vector<TrainReport> rows;
  std::map<std::string, std::size_t> columns;
  std::string header;
  for (std::size_t number = 1; csv.find('\n') != std::string_view::npos; ++number) {
    std::string_view line = csv.substr(0, csv.find('\n'));
    csv.remove_prefix(line.size() + 1);
    if (line.ends_with('\r')) line.remove_suffix(1);
    if (line.empty() || line == header) continue;
    std::vector<std::string> fields = split_csv(line);
    const std::string place = fmt::format("{}:{}", source, number);
    if (header.empty()) {
      header = line;
      for (std::size_t i = 0; i < fields.size(); ++i) columns.emplace(fields[i], i);
      if (!columns.contains("step")) throw InputError(place, "has no column 'step': is it a log.csv of a training?");
      continue;
    }
    if (fields.size() != columns.size()) {
      throw InputError(place,
                       fmt::format("{} fields, need {}: repair or remove the line", fields.size(), columns.size()));
    }
    TrainReport row = parse_row(LogLine(columns, std::move(fields), place));
    if (!rows.empty() && row.step < rows.back().step) {
      std::erase_if(rows, [&](const TrainReport& earlier) { return earlier.step >= row.step; });
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

std::string format_training_report(std::span<const TrainReport> rows, const TrainingReportOptions& options) {
  const std::vector<Validation> validations = validations_of(rows);
  const std::string title = escape_xml(options.title);
  std::string html =
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"/>"
      "<meta name=\"viewport\" content=\"width=device-width\"/><title>" +
      title +
      "</title><style>body{font:15px/1.5 system-ui,sans-serif;max-width:60rem;margin:2rem auto;padding:0 1rem;"
      "color:#1f2933}table{border-collapse:collapse}th,td{padding:.2rem .7rem;border-bottom:1px solid #e4e8ec;"
      "text-align:right;font-variant-numeric:tabular-nums}th{font-weight:600}tbody th{text-align:left}"
      "thead th[colspan]{text-align:center}td:nth-of-type(5),th[colspan]+th,tr+tr th:nth-of-type(5){padding-left:2rem}"
      "i{display:inline-block;width:.8em;height:.8em;margin-right:.4em}svg{display:block;margin:1.2rem 0}"
      "</style></head>\n<body><h1>" +
      title + "</h1>\n";
  if (rows.empty()) return html + "<p>Nothing logged yet.</p>\n</body></html>\n";
  const double seconds = trained_seconds(rows);
  html += fmt::format("<p>{} steps in {}.</p>\n", rows.back().step,
                      seconds < 600.0 ? fmt::format("{:.0f} s", seconds) : fmt::format("{:.1f} h", seconds / 3600.0));
  html += score_table(validations);
  html += loss_plot(rows);
  html += score_plot(rows, validations, "Mean IoU", &TrainReport::mean_iou);
  html += score_plot(rows, validations, "Road IoU", &TrainReport::road_iou);
  html += score_plot(rows, validations, "Pixel accuracy", &TrainReport::pixel_accuracy);
  html += rate_plot(rows);
  return html + "</body></html>\n";
}

}  // namespace orthodrive
