// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/lab/training/training_report.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <pugixml.hpp>

#include "orthodrive/core/error.hpp"

namespace orthodrive {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::ThrowsMessage;

/// A run of 1000 steps with two validations; the mean IoU of "village" is best at step 600, of "town" at 1000.
std::vector<TrainReport> some_rows() {
  std::vector<TrainReport> rows;
  for (int step = 10; step <= 1000; step += 10) {
    TrainReport row;
    row.step = step;
    row.seconds = 1.5 * step;
    row.learning_rate = step < 500 ? 1e-3 : 1e-3 * (1010 - step) / 510;
    row.loss = 2.0 / (1.0 + step / 50.0) * (1.0 + 0.3 * std::sin(step * 0.7));
    rows.push_back(row);
    if (step % 200 != 0) continue;
    TrainReport village = row;
    village.validation = "village";
    village.mean_iou = 0.8 - 1e-6 * (step - 600) * (step - 600);
    village.road_iou = 0.9;
    rows.push_back(village);
    TrainReport town = row;
    town.validation = "town <B&B>, west";
    town.mean_iou = 0.0005 * step;
    town.road_iou = std::nan("");  // no road there
    town.pixel_accuracy = 0.75;
    rows.push_back(town);
  }
  return rows;
}

std::string csv_of(const std::vector<TrainReport>& rows) {
  std::string csv = format_log_header();
  for (const TrainReport& row : rows) csv += format_log_row(row);
  return csv;
}

pugi::xml_document parse_page(const std::string& html) {
  pugi::xml_document page;
  const std::string xml = html.substr(html.find('\n') + 1);  // without <!DOCTYPE html>
  EXPECT_TRUE(page.load_string(xml.c_str()));
  return page;
}

std::vector<std::string> cells_of(const pugi::xml_document& page, const char* validation) {
  std::vector<std::string> cells;
  for (const auto& row : page.select_nodes("//tbody/tr")) {
    if (std::string(row.node().child("th").text().get()) != validation) continue;
    for (const auto& cell : row.node().children("td")) cells.emplace_back(cell.text().get());
  }
  return cells;
}

TEST(TrainingLog, write_read_gives_the_same) {
  const std::vector<TrainReport> rows = some_rows(), back = parse_training_log(csv_of(rows), "log.csv");
  ASSERT_EQ(back.size(), rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_EQ(back[i].step, rows[i].step);
    EXPECT_EQ(back[i].validation, rows[i].validation);
    EXPECT_NEAR(back[i].learning_rate, rows[i].learning_rate, 5.1e-6 * rows[i].learning_rate);  // six digits
    if (rows[i].validation.empty()) {
      EXPECT_NEAR(back[i].loss, rows[i].loss, 5.1e-6 * rows[i].loss);
    }
    EXPECT_EQ(back[i].mean_iou.has_value(), rows[i].mean_iou.has_value());
    if (rows[i].mean_iou) {
      EXPECT_NEAR(*back[i].mean_iou, *rows[i].mean_iou, 5.1e-5);
    }
    EXPECT_EQ(back[i].road_iou && std::isnan(*back[i].road_iou), rows[i].road_iou && std::isnan(*rows[i].road_iou));
  }
  EXPECT_EQ(csv_of(back), csv_of(rows));
}

TEST(TrainingLog, a_resumed_run_replaces_what_it_trained_anew) {
  const std::string csv =
      "step,loss\n10,1\n20,2\n30,3\n40,4\n"
      "step,loss\n30,33\n40,44\n"  // resumed from a checkpoint of step 20, the header written again
      "50,55\r\n";
  const auto rows = parse_training_log(csv, "log.csv");
  std::vector<double> losses;
  for (const TrainReport& row : rows) losses.push_back(row.loss);
  EXPECT_EQ(losses, (std::vector<double>{1, 2, 33, 44, 55}));
}

// A killed run may leave half a number: "0.4" of "0.4321".
TEST(TrainingLog, an_unfinished_last_line_is_left_out) {
  EXPECT_EQ(parse_training_log("step,loss\n10,1\n20,0.4", "log.csv").size(), 1u);
  EXPECT_TRUE(parse_training_log("step,lo", "log.csv").empty());
  EXPECT_TRUE(parse_training_log("", "log.csv").empty());
}

TEST(TrainingLog, other_columns_are_ignored_and_missing_ones_empty) {
  const auto rows = parse_training_log("stage,step,loss\n\"a, b\",7,0.5\n", "log.csv");
  ASSERT_EQ(rows.size(), 1u);
  EXPECT_EQ(rows[0].step, 7);
  EXPECT_EQ(rows[0].loss, 0.5);
  EXPECT_FALSE(rows[0].mean_iou);
}

TEST(TrainingLog, errors_name_file_and_line) {
  const auto parsing = [](const char* csv) {
    return [csv] { static_cast<void>(parse_training_log(csv, "run/log.csv")); };
  };
  const auto message = [](const char* text) { return ThrowsMessage<InputError>(HasSubstr(text)); };
  EXPECT_THAT(parsing("x,y\n1,2\n"), message("run/log.csv:1: has no column 'step'"));
  EXPECT_THAT(parsing("step,loss\n1,2\n2,much\n"), message("run/log.csv:3: loss 'much' is no number"));
  EXPECT_THAT(parsing("step,loss\n1,2,3\n"), message("run/log.csv:2: 3 fields, need 2"));
}

TEST(TrainingReport, is_well_formed_and_marks_the_best) {
  const std::string html = format_training_report(some_rows(), {.title = "Run <1> & more"});
  const pugi::xml_document page = parse_page(html);
  EXPECT_STREQ(page.child("html").child("body").child("h1").text().get(), "Run <1> & more");
  EXPECT_EQ(page.select_nodes("//svg").size(), 5u);  // loss, three scores, learning rate
  // A ring per validation on mean IoU; the road IoU of "town" is unknown, the accuracy of "village" too.
  EXPECT_EQ(page.select_nodes("//circle").size(), 4u);
  EXPECT_EQ(cells_of(page, "village"),
            (std::vector<std::string>{"600", "0.8000", "0.9000", "–", "1000", "0.6400", "0.9000", "–"}));
  EXPECT_EQ(cells_of(page, "town <B&B>, west"),
            (std::vector<std::string>{"1000", "0.5000", "–", "0.7500", "1000", "0.5000", "–", "0.7500"}));
  EXPECT_THAT(html, HasSubstr("1000 steps in 0.4 h"));
  for (const char* outside : {"<script", "http-equiv", "href=", "src="}) EXPECT_THAT(html, Not(HasSubstr(outside)));
  if (const char* file = std::getenv("ORTHODRIVE_KEEP_REPORT")) std::ofstream(file) << html;  // to look at
}

TEST(TrainingReport, nothing_and_almost_nothing_are_pages_too) {
  parse_page(format_training_report({}));
  TrainReport row;
  row.step = 1;
  row.loss = std::nan("");  // a diverged run
  const std::string one = format_training_report(std::vector{row});
  parse_page(one);
  EXPECT_THAT(one, HasSubstr("No validation yet"));
  EXPECT_THAT(one, Not(HasSubstr("nan")));
  row.validation = "only this";
  row.mean_iou = std::nan("");
  const pugi::xml_document page = parse_page(format_training_report(std::vector{row}));
  EXPECT_EQ(cells_of(page, "only this"), (std::vector<std::string>{"", "", "", "", "1", "–", "–", "–"}));
}

TEST(TrainingReport, time_adds_up_over_resumed_processes) {
  std::vector<TrainReport> rows(3);
  rows[0].step = 1, rows[0].seconds = 100;
  rows[1].step = 2, rows[1].seconds = 250;
  rows[2].step = 3, rows[2].seconds = 30;  // another process
  EXPECT_THAT(format_training_report(rows), HasSubstr("3 steps in 280 s"));
}

}  // namespace
}  // namespace orthodrive
