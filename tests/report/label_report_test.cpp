// SPDX-License-Identifier: Apache-2.0
// Truth from polygons, merge tables, pictures of errors and the page, from maps small enough to count by hand.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <pugixml.hpp>

#include "io/scratch.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/io/raster/raster_io.hpp"
#include "orthodrive/io/support/vector_io.hpp"
#include "orthodrive/pipeline/files/network_spec.hpp"
#include "orthodrive/pipeline/score/score.hpp"
#include "orthodrive/report/label_pictures.hpp"
#include "orthodrive/report/svg_plot.hpp"
#include "paths.hpp"

namespace orthodrive {
namespace {
namespace fs = std::filesystem;
using testing::HasSubstr;

const Crs utm33{"EPSG:32633"};
const Vec2 map_origin{500000.0, 5540000.0};
constexpr std::uint8_t ground = 0, road = 1, building = 3;

LabelMap labels_of(int width, int height, std::uint8_t label, double gsd_m = 1.0) {
  return {utm33,
          {map_origin.x, map_origin.y, gsd_m, width, height},
          Raster<std::uint8_t>(width, height, 1, label),
          default_class_table()};
}
void paint(LabelMap& map, int col0, int row0, int col1, int row1, std::uint8_t label) {
  for (int row = row0; row < row1; ++row)
    for (int col = col0; col < col1; ++col) map.labels.at(col, row) = label;
}
/// From column and row to column and row, of 1 m from the map_origin.
io::Feature square(int col0, int row0, int col1, int row1, std::map<std::string, std::string> tags) {
  const auto at = [](double col, double row) { return map_origin + Vec2{col, -row}; };
  return {.polygons = {{{at(col0, row0), at(col1, row0), at(col1, row1), at(col0, row1)}, {}}},
          .tags = std::move(tags)};
}
LabelTruth painted(const Scratch& scratch, const std::vector<io::Feature>& features, const LabelMap& prediction) {
  io::write_geojson(scratch / "truth.geojson", features, utm33);  // in longitude and latitude
  return std::get<LabelTruth>(read_label_truth(scratch / "truth.geojson", prediction));
}

TEST(LabelTruthFromPolygons, later_features_cover_earlier_ones) {
  const Scratch scratch;
  const LabelMap prediction = labels_of(20, 10, road);
  const LabelTruth truth =
      painted(scratch,
              {square(0, 0, 10, 10, {{"class", "ground"}}), square(0, 4, 10, 8, {{"class", "road"}}),
               square(2, 6, 4, 10, {{"class", "building"}}), square(8, 0, 10, 10, {{"class", "unknown"}}),
               square(9, 9, 10, 10, {{"class", "road"}})},
              prediction);
  const LabelScores scores = evaluate_labels(prediction, truth.map);
  EXPECT_EQ(scores.pixels, 81u) << "without 20 px of 'unknown' but with the one painted over it";
  EXPECT_EQ(scores.truth_nodata, 119u);
  EXPECT_EQ(scores.classes[road].truth_pixels, 8u * 4u - 2u * 2u + 1u);
  EXPECT_EQ(scores.classes[building].truth_pixels, 8u);
  EXPECT_EQ(scores.classes[ground].truth_pixels, 81u - 29u - 8u);
  EXPECT_TRUE(truth.pieces.names.empty());
}

TEST(LabelTruthFromPolygons, pieces_in_the_order_of_the_file_and_a_class_nobody_predicts) {
  const Scratch scratch;
  const LabelMap prediction = labels_of(20, 10, road);
  const LabelTruth truth = painted(
      scratch,
      {square(5, 0, 10, 10, {{"class", "road"}, {"piece", "b"}}),
       square(0, 0, 5, 10, {{"class", "road"}, {"piece", "a"}}),
       square(0, 0, 1, 10, {{"class", "hedge"}, {"piece", "a"}}),
       square(900, 0, 910, 10, {{"class", "road"}, {"piece", "far"}}), square(15, 0, 20, 10, {{"class", "road"}})},
      prediction);
  EXPECT_EQ(truth.pieces.names, (std::vector<std::string>{"b", "a", "far"}));
  const LabelComparisonView view(prediction, truth.map);
  const std::vector<PieceScores> pieces = evaluate_pieces(view, truth.pieces);
  EXPECT_EQ(pieces[0].scores.pixels, 50u);
  EXPECT_DOUBLE_EQ(pieces[0].scores.road_iou, 1.0);
  EXPECT_DOUBLE_EQ(pieces[1].scores.pixel_accuracy, 0.8);
  EXPECT_EQ(pieces[2].scores.pixels, 0u);
  EXPECT_EQ(evaluate_labels(view).pixels, 150u) << "what is in no piece counts in the whole";
}

TEST(MergeTableFile, shipped_one_takes_38_classes_to_32) {
  const fs::path folder = paths::in_source("models/classes");
  const fs::path file = folder / "reference-38.toml";
  const std::vector<ClassInfo> classes = parse_class_table(bytes_of(file), file).classes;
  double road_false_positive = 0.0;
  for (const ClassInfo& info : classes) {
    EXPECT_EQ(info.role == Role::road, info.cost_false_positive == 1.0) << info.name;
    EXPECT_EQ(info.role == Role::road || info.role == Role::maybe_road, info.cost_false_negative < 1.0) << info.name;
    road_false_positive += info.cost_false_positive;
  }
  ASSERT_EQ(classes.size(), 38u);
  EXPECT_EQ(road_false_positive, 10.0) << "cartway, macadam, driveway, secondary ... ramp, pitlane, track";
  const MergeTable table = read_merge_table(folder / "merge_38_to_32.toml");
  const MergedClasses merged = merge_classes(classes, table);
  EXPECT_EQ(merged.classes.size(), 32u);
  for (std::size_t i = 0; i < classes.size(); ++i)
    EXPECT_EQ(merged.classes[merged.from_old[i]].role, classes[i].role) << classes[i].name;
}

TEST(MergeTableFile, faults_name_file_and_line) {
  const Scratch scratch;
  const auto message = [&](const std::string& text) -> std::string {
    write_bytes(scratch / "merge.toml", text);
    try {
      static_cast<void>(read_merge_table(scratch / "merge.toml"));
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_EQ(message("shed = \"detached\"\n"), "accepted");
  EXPECT_THAT(message("\nshed = 3\n"), testing::AllOf(HasSubstr("merge.toml: line 2"), HasSubstr("shed")));
  EXPECT_THAT(message("shed = detached\n"), HasSubstr("merge.toml: line 1"));
  EXPECT_THAT(message("# nothing\n"), HasSubstr("merges nothing"));
  EXPECT_THROW(static_cast<void>(read_merge_table(scratch / "none.toml")), InputError);
}

TEST(ConfidenceFile, reads_back_what_was_written_and_refuses_a_photo) {
  const Scratch scratch;
  ConfidenceMap map{utm33, {map_origin.x, map_origin.y, 0.5, 30, 20}, Raster<std::uint8_t>(30, 20, 1, 7)};
  map.confidence.at(29, 19) = 255, map.confidence.at(3, 0) = 0;
  io::write_confidence(scratch / "confidence.tif", map);
  const ConfidenceMap read = io::read_confidence(scratch / "confidence.tif");
  EXPECT_EQ(read.confidence.data, map.confidence.data);
  EXPECT_EQ(read.frame, map.frame);
  EXPECT_EQ(read.crs, map.crs);
  io::write_photo(scratch / "photo.tif",
                  {utm33, map.frame, Raster<std::uint8_t>(30, 20, 3), Raster<std::uint8_t>(30, 20, 1, 1)});
  EXPECT_THROW(static_cast<void>(io::read_confidence(scratch / "photo.tif")), InputError);
}

TEST(ShareColor, ten_percent_is_bright_orange_and_one_percent_can_be_told_from_none) {
  const auto none = share_color(0.0), one = share_color(0.01), ten = share_color(0.1), all = share_color(1.0);
  EXPECT_LT(none[0] + none[1] + none[2], 10);
  EXPECT_GT(one[0] - none[0], 50);
  EXPECT_GT(ten[0], 240);
  EXPECT_TRUE(ten[1] > 100 && ten[1] < 180 && ten[2] < 40);
  EXPECT_GT(all[1], 240);
  EXPECT_EQ(share_color(2.0), all);
}

Photo photo_of(const GridFrame& frame, Color color) {
  Photo photo{utm33, frame, Raster<std::uint8_t>(frame.width, frame.height, 3),
              Raster<std::uint8_t>(frame.width, frame.height, 1, 1)};
  for (std::size_t i = 0; i < photo.rgb.data.size(); ++i) photo.rgb.data[i] = color[i % 3];
  return photo;
}
Color color_at(const Canvas& canvas, int col, int row) {
  return {canvas.rgb.at(col, row, 0), canvas.rgb.at(col, row, 1), canvas.rgb.at(col, row, 2)};
}

TEST(PictureOfErrors, grey_where_right_colour_where_wrong_pale_where_not_scored) {
  LabelMap truth = labels_of(8, 8, ground), prediction = truth;
  paint(prediction, 0, 0, 1, 1, building);
  truth.labels.at(7, 7) = label_nodata;
  const LabelComparisonView view(prediction, truth);
  const GridFrame frame = picture_frame(view, truth.frame.bounds(), 100);
  EXPECT_EQ(frame, truth.frame) << "never finer than the labels";
  const Photo photo = photo_of(truth.frame, {200, 100, 50});  // BT.601: 124.2
  const Canvas canvas = picture_of_errors(view, frame, &photo);
  EXPECT_EQ(color_at(canvas, 4, 4), (Color{124, 124, 124}));
  // A quarter of the grey and three quarters of the building's 230, 23, 23.
  EXPECT_EQ(color_at(canvas, 0, 0), (Color{204, 48, 48}));
  EXPECT_EQ(color_at(canvas, 7, 7), (Color{209, 209, 209}));
  EXPECT_EQ(color_at(picture_of_errors(view, frame, nullptr), 4, 4), (Color{190, 190, 190}));
}

TEST(PictureOfErrors, one_wrong_pixel_still_shows_in_a_reduced_picture) {
  const LabelMap truth = labels_of(8, 8, ground);
  LabelMap prediction = truth;
  paint(prediction, 0, 0, 1, 1, building);
  const LabelComparisonView view(prediction, truth);
  const GridFrame frame = picture_frame(view, truth.frame.bounds(), 2);
  ASSERT_EQ(frame.width, 2);
  const Canvas canvas = picture_of_errors(view, frame, nullptr);
  // One of 16: weight 0.75 * sqrt(1 / 16) of the building's 230, 23, 23 over 190.
  EXPECT_EQ(color_at(canvas, 0, 0), (Color{198, 159, 159}));
  EXPECT_EQ(color_at(canvas, 1, 0), (Color{190, 190, 190}));
}

TEST(PictureOfErrors, grey_classes_get_vivid_colours_of_their_own) {
  const std::vector<Color> colors =
      error_colors({{"tree", {28, 115, 11}}, {"road", {76, 76, 76}}, {"snow", {255, 255, 255}}});
  EXPECT_EQ(colors[0], (Color{28, 115, 11}));
  for (const std::size_t c : {std::size_t{1}, std::size_t{2}})
    EXPECT_GT(
        *std::max_element(colors[c].begin(), colors[c].end()) - *std::min_element(colors[c].begin(), colors[c].end()),
        200);
  EXPECT_NE(colors[1], colors[2]);
}

TEST(LabelPlaces, worst_tiles_first_and_pieces_by_accuracy) {
  const LabelMap truth = labels_of(20, 10, ground);
  LabelMap prediction = truth;
  paint(prediction, 9, 0, 10, 3, road);    // 3 px in tile 2 of 4, columns 8..11
  paint(prediction, 16, 8, 20, 10, road);  // 8 px in the last
  const LabelComparisonView view(prediction, truth);
  const std::vector<LabelPlace> places = worst_places(view, 4, 6);
  ASSERT_EQ(places.size(), 2u) << "tiles without errors are not listed";
  EXPECT_EQ(places[0].wrong, 8u);
  EXPECT_EQ(places[0].pixels, 8u) << "cut off by the edge of the map";
  EXPECT_DOUBLE_EQ(places[0].box.min_x, map_origin.x + 16.0);
  EXPECT_DOUBLE_EQ(places[0].box.min_y, map_origin.y - 10.0);
  EXPECT_EQ(places[1].wrong, 3u);
  EXPECT_DOUBLE_EQ(places[1].box.max_y, map_origin.y);
  EXPECT_EQ(worst_places(view, 4, 1).size(), 1u);

  TruthPieces pieces{{"good", "empty", "bad"}, Raster<std::uint16_t>(20, 10)};
  pieces.index.at(0, 0) = pieces.index.at(2, 1) = 1;
  pieces.index.at(9, 0) = 3;
  const std::vector<LabelPlace> by_piece = piece_places(view, pieces);
  ASSERT_EQ(by_piece.size(), 2u);
  EXPECT_EQ(by_piece[0].name, "bad");
  EXPECT_DOUBLE_EQ(by_piece[0].accuracy(), 0.0);
  EXPECT_DOUBLE_EQ(by_piece[1].box.width(), 3.0);
  EXPECT_DOUBLE_EQ(by_piece[1].box.height(), 2.0);
}

/// Labels, truth, confidence and photo of 64 x 64 m on disk.
class LabelPage : public testing::Test {
 protected:
  LabelPage() {
    LabelMap truth = labels_of(64, 64, ground), prediction = truth;
    paint(truth, 0, 20, 64, 30, road);
    paint(prediction, 0, 20, 64, 29, road);  // 64 of 640 px missed: 10 % of the road is taken for ground
    paint(prediction, 0, 63, 1, 64, 6);      // one pixel of water, which the truth has not
    paint(truth, 60, 60, 64, 64, building);  // never predicted
    io::write_labels(scratch_ / "truth.tif", truth);
    io::write_labels(scratch_ / "labels.tif", prediction);
    io::write_confidence(scratch_ / "confidence.tif", {utm33, truth.frame, Raster<std::uint8_t>(64, 64, 1, 204)});
    io::write_photo(scratch_ / "photo.tif", photo_of(truth.frame, {90, 120, 60}));
    write_bytes(scratch_ / "merge.toml", "parking = \"road\"\n");
  }
  ScoreJson score(const LabelScoreOptions& options, const char* truth = "truth.tif") const {
    return score_labels({.scored = scratch_ / "labels.tif", .truth = scratch_ / truth, .region = {}}, options);
  }
  Scratch scratch_;
};

TEST_F(LabelPage, is_one_well_formed_file_that_says_what_was_measured) {
  const ScoreJson json = score({.merge = scratch_ / "merge.toml",
                                .confidence = scratch_ / "confidence.tif",
                                .page = scratch_ / "page",
                                .photo = scratch_ / "photo.tif"});
  const std::string page = bytes_of(scratch_ / "page" / "labels.html");
  pugi::xml_document document;
  const pugi::xml_parse_result parsed = document.load_string(page.c_str(), pugi::parse_full);
  ASSERT_TRUE(parsed) << parsed.description() << " at " << page.substr(static_cast<std::size_t>(parsed.offset), 80);
  std::string titles;
  for (const pugi::xpath_node& title : document.select_nodes("//h2"))
    titles += title.node().child_value() + std::string("|");
  EXPECT_EQ(titles, "Classes|Confusion|Calibration|What is wrong|The worst places|");
  EXPECT_EQ(document.select_nodes("//img").size(), 1u + 4u)
      << "the overview; photo, truth, prediction, errors of a tile";
  for (const pugi::xpath_node& image : document.select_nodes("//img"))
    EXPECT_THAT(image.node().attribute("src").value(), testing::StartsWith("data:image/"));
  EXPECT_THAT(page, HasSubstr("<title>road -&gt; ground: 10.00 %</title>"));
  EXPECT_THAT(page, HasSubstr("absent from the truth: <b>water</b>"));
  EXPECT_THAT(page, HasSubstr("Never predicted: <b>building</b>"));
  EXPECT_THAT(page, HasSubstr("<b>parking</b> into <b>road</b>"));
  EXPECT_THAT(page, HasSubstr("In neither map, so in no mean: <b>vegetation, grass, rail</b>"));

  constexpr double right = 4096.0 - 64.0 - 1.0 - 16.0;
  EXPECT_DOUBLE_EQ(json["pixel_accuracy"], right / 4096.0);
  EXPECT_THAT(page, HasSubstr("<b>98.02 %</b><span>pixel accuracy</span>"));
  EXPECT_DOUBLE_EQ(json["iou"]["road"], 0.9);
  EXPECT_DOUBLE_EQ(json["recall"]["road"], 0.9);
  EXPECT_DOUBLE_EQ(json["precision"]["road"], 1.0);
  EXPECT_EQ(json["absent"].dump(),
            R"({"from_both":["vegetation","grass","rail"],"from_truth":["water"],"from_prediction":["building"]})");
  EXPECT_EQ(json["confusion"]["pixels_by_truth"][1][0], 64);
  EXPECT_EQ(json["confusion"]["classes"][1], "road");
  EXPECT_EQ(json["merged"]["parking"], "road");
  EXPECT_NEAR(json["calibration"]["expected_error"].get<double>(), right / 4096.0 - 0.8, 1e-12);
  EXPECT_EQ(json["calibration"]["bins"][8]["pixels"], 4096);
  const double ground_iou = (4096.0 - 640.0 - 16.0 - 1.0) / (4096.0 - 576.0);
  EXPECT_NEAR(json["mean_iou"].get<double>(), (ground_iou + 0.9) / 4.0, 1e-12) << "water and building are zeros";
  EXPECT_NEAR(json["mean_iou_of_truth_classes"].get<double>(), (ground_iou + 0.9) / 3.0, 1e-12);
  EXPECT_THAT(to_table(json),
              testing::AllOf(HasSubstr("from_truth"), HasSubstr(" water"), testing::Not(HasSubstr("pixels_by_truth"))));
}

TEST_F(LabelPage, pieces_stand_for_the_worst_places_and_a_file_name_is_taken_as_it_is) {
  io::write_geojson(scratch_ / "truth.geojson",
                    {square(0, 0, 16, 16, {{"class", "ground"}, {"piece", "meadow"}}),
                     square(16, 16, 32, 32, {{"class", "ground"}, {"piece", "lane & kerb"}}),
                     square(16, 20, 32, 30, {{"class", "road"}, {"piece", "lane & kerb"}}),
                     square(900, 16, 910, 32, {{"class", "ground"}, {"piece", "far"}})},
                    utm33);
  const ScoreJson json = score({.page = scratch_ / "pieces.html"}, "truth.geojson");
  EXPECT_DOUBLE_EQ(json["pieces"]["meadow"]["pixel_accuracy"], 1.0);
  EXPECT_DOUBLE_EQ(json["pieces"]["lane & kerb"]["road_iou"], 0.9);
  EXPECT_EQ(json["pieces_elsewhere"].dump(), R"(["far"])");
  pugi::xml_document document;
  ASSERT_TRUE(document.load_file((scratch_ / "pieces.html").c_str(), pugi::parse_full));
  std::string titles;
  for (const pugi::xpath_node& title : document.select_nodes("//h3"))
    titles += title.node().child_value() + std::string("|");
  EXPECT_EQ(titles, "lane & kerb|meadow|");
  EXPECT_EQ(document.select_nodes("//img").size(), 1u + 2u * 3u) << "no photo";
}

TEST_F(LabelPage, options_and_files_that_do_not_fit) {
  io::write_geojson(scratch_ / "roads.geojson", {square(0, 20, 64, 30, {{"kind", "road"}})}, utm33);
  EXPECT_THROW(score({.page = scratch_ / "page"}, "roads.geojson"), OptionError);
  EXPECT_DOUBLE_EQ(score({}, "roads.geojson")["road_iou"], 0.9);
  io::write_confidence(scratch_ / "other.tif",
                       {utm33, {map_origin.x, map_origin.y, 1.0, 63, 64}, Raster<std::uint8_t>(63, 64)});
  EXPECT_THROW(score({.confidence = scratch_ / "other.tif"}), InputError);
  EXPECT_THROW(score({.page = scratch_ / "page", .photo = scratch_ / "none.tif"}), InputError);
  GridFrame far{map_origin.x + 9000.0, map_origin.y, 1.0, 64, 64};
  io::write_photo(scratch_ / "far.tif", photo_of(far, {90, 120, 60}));
  EXPECT_THROW(score({.page = scratch_ / "page", .photo = scratch_ / "far.tif"}), InputError);
  write_bytes(scratch_ / "bad.toml", "shed = \"detached\"\n");
  EXPECT_THROW(score({.merge = scratch_ / "bad.toml"}), InputError);
  EXPECT_FALSE(fs::exists(scratch_ / "page" / "labels.html")) << "no page of a failed run";
}

}  // namespace
}  // namespace orthodrive
