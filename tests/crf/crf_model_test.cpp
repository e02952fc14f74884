// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/crf/crf_model.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "orthodrive/core/error.hpp"

namespace orthodrive {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

TEST(CrfModel, comes_back_from_a_model_file) {
  CrfModel crf = reference_crf(3);
  crf.widths.theta_beta = 7.25;
  crf.parameters.iterations = 4;
  crf.parameters.appearance_weight[1] = 0.5F;
  crf.parameters.compatibility[2] = 1.5F;
  TensorFile file;
  add_crf(file, crf);
  const auto read = read_crf(file, 3, "m");
  ASSERT_TRUE(read);
  EXPECT_EQ(read->widths.theta_alpha_px, crf.widths.theta_alpha_px);
  EXPECT_EQ(read->widths.theta_beta, 7.25);
  EXPECT_EQ(read->widths.theta_gamma_px, crf.widths.theta_gamma_px);
  EXPECT_EQ(read->parameters.iterations, 4);
  EXPECT_EQ(read->parameters.classes, 3);
  EXPECT_EQ(read->parameters.appearance_weight, crf.parameters.appearance_weight);
  EXPECT_EQ(read->parameters.smoothness_weight, crf.parameters.smoothness_weight);
  EXPECT_EQ(read->parameters.compatibility, crf.parameters.compatibility);
}

TEST(CrfModel, unary_compatibility_comes_back_where_there_is_one) {
  CrfModel crf = reference_crf(2);
  TensorFile without, with;
  add_crf(without, crf);
  EXPECT_FALSE(without.tensors.contains("crf/unary_compatibility"));
  const std::optional<CrfModel> none = read_crf(without, 2, "m");
  ASSERT_TRUE(none);
  EXPECT_TRUE(none->parameters.unary_compatibility.empty());
  crf.parameters.unary_compatibility = {-1.0F, 0.25F, 0.5F, -2.0F};
  add_crf(with, crf);
  const std::optional<CrfModel> some = read_crf(with, 2, "m");
  ASSERT_TRUE(some);
  EXPECT_EQ(some->parameters.unary_compatibility, crf.parameters.unary_compatibility);
  with.tensors["crf/unary_compatibility"].values.pop_back();
  EXPECT_THAT([&] { (void)read_crf(with, 2, "m"); }, ThrowsMessage<InputError>(HasSubstr("crf/unary_compatibility")));
}

TEST(CrfModel, the_references_values) {
  const CrfModel crf = reference_crf(2);
  EXPECT_EQ(crf.widths.theta_alpha_px, 13.5);
  EXPECT_EQ(crf.widths.theta_beta, 11.0);
  EXPECT_EQ(crf.widths.theta_gamma_px, 1.75);
  EXPECT_EQ(crf.parameters.appearance_weight, (std::vector<float>{5.2F, 5.2F}));
  EXPECT_EQ(crf.parameters.smoothness_weight, (std::vector<float>{1.5F, 1.5F}));
  EXPECT_EQ(crf.parameters.compatibility, (std::vector<float>{0.0F, 1.0F, 1.0F, 0.0F}));
}

TEST(CrfSet, names_of_table_2_2_and_five_numbers) {
  EXPECT_EQ(parse_crf_set("thesis").theta_alpha_px, 13.5);
  EXPECT_EQ(parse_crf_set("zheng").theta_alpha_px, 160.0);
  const CrfModel crf = crf_of(parse_crf_set("kraehenbuehl"), 2);
  EXPECT_EQ(crf.widths.theta_beta, 13.0);
  EXPECT_EQ(crf.parameters.appearance_weight, (std::vector<float>{10.0F, 10.0F}));
  const CrfSet own = parse_crf_set("2.5,9,20,0,1.75");
  EXPECT_EQ(own.w1, 2.5F);
  EXPECT_EQ(own.theta_alpha_px, 9.0);
  EXPECT_EQ(own.theta_beta, 20.0);
  EXPECT_EQ(own.w2, 0.0F);
  EXPECT_EQ(own.theta_gamma_px, 1.75);
}

TEST(CrfSet, what_is_none_is_refused) {
  for (const char* text : {"", "Zheng", "1,2,3,4", "1,2,3,4,", "1,2,3,4,5,", "1,2,3,4,5,6", "1;2;3;4;5", "1,2,x,4,5"})
    EXPECT_THAT([&] { (void)parse_crf_set(text); }, ThrowsMessage<OptionError>(HasSubstr("need kraehenbuehl, zheng")))
        << text;
  for (const char* text : {"-1,2,3,4,5", "1,2,3,1001,5", "nan,2,3,4,5"})
    EXPECT_THAT([&] { (void)parse_crf_set(text); }, ThrowsMessage<OptionError>(HasSubstr("not from 0 to 1000")))
        << text;
  for (const char* text : {"1,0,3,4,5", "1,2,1e9,4,5", "1,2,3,4,inf"})
    EXPECT_THAT([&] { (void)parse_crf_set(text); }, ThrowsMessage<OptionError>(HasSubstr("not from 0.1 to 1000")))
        << text;
}

TEST(CrfModel, none_and_damaged_ones) {
  EXPECT_FALSE(read_crf({}, 3, "m"));
  TensorFile file;
  add_crf(file, reference_crf(3));
  EXPECT_THAT([&] { (void)read_crf(file, 4, "m"); }, ThrowsMessage<InputError>(HasSubstr("not of 4 values")));
  TensorFile no_number = file;
  no_number.metadata["crf"] = R"({"theta_alpha_px": "wide"})";
  EXPECT_THAT([&] { (void)read_crf(no_number, 3, "m"); }, ThrowsMessage<InputError>(HasSubstr("'crf' is damaged")));
  file.tensors.erase("crf/compatibility");
  EXPECT_THAT([&] { (void)read_crf(file, 3, "m"); }, ThrowsMessage<InputError>(HasSubstr("crf/compatibility")));
}

}  // namespace
}  // namespace orthodrive
