// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/models/safetensors.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "orthodrive/core/error.hpp"

namespace orthodrive {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

TensorFile small_file() {
  TensorFile file;
  file.metadata["made by"] = "test \"quoted\"";
  file.tensors["b"] = {{2, 3}, {1.0F, -2.5F, 0.0F, 3e-8F, 1e5F, -0.125F}, TensorType::f32};
  file.tensors["a/half"] = {{4}, {1.0F, 0.1F, -65504.0F, 6e-8F}, TensorType::f16};
  file.tensors["empty"] = {{0}, {}, TensorType::f32};
  return file;
}

TEST(Safetensors, write_read_gives_the_same) {
  const TensorFile file = small_file();
  const TensorFile back = parse_safetensors(format_safetensors(file), "x");
  EXPECT_EQ(back.metadata, file.metadata);
  ASSERT_EQ(back.tensors.size(), 3u);
  EXPECT_EQ(back.tensors.at("b").shape, file.tensors.at("b").shape);
  EXPECT_EQ(back.tensors.at("b").values, file.tensors.at("b").values);
  EXPECT_EQ(back.tensors.at("a/half").stored_as, TensorType::f16);
  EXPECT_EQ(format_safetensors(back), format_safetensors(file));
}

// Values of IEEE 754 binary16: exact ones stay, others go to the nearest, ties to even.
TEST(Safetensors, half_rounds_to_nearest_even) {
  const float inf = std::numeric_limits<float>::infinity();
  const std::vector<std::pair<float, float>> cases{{0.0F, 0.0F},
                                                   {1.0F, 1.0F},
                                                   {2049.0F, 2048.0F},  // tie: even
                                                   {2051.0F, 2052.0F},
                                                   {0.1F, 0.0999755859375F},
                                                   {65504.0F, 65504.0F},
                                                   {65519.9F, 65504.0F},
                                                   {65520.0F, inf},
                                                   {1e9F, inf},
                                                   {-inf, -inf},
                                                   {0x1.0p-24F, 0x1.0p-24F},
                                                   {0x1.8p-24F, 0x1.0p-23F},  // tie between 1 and 2 units: even
                                                   {0x1.0p-25F, 0.0F},
                                                   {0x1.ff8p-15F, 0x1.ff8p-15F},
                                                   {-0x1.0p-14F, -0x1.0p-14F}};
  for (const auto& [value, expected] : cases) {
    TensorFile file;
    file.tensors["t"] = {{1}, {value}, TensorType::f16};
    EXPECT_EQ(parse_safetensors(format_safetensors(file), "x").tensors.at("t").values.at(0), expected) << value;
  }
  TensorFile nan;
  nan.tensors["t"] = {{1}, {std::nanf("")}, TensorType::f16};
  EXPECT_TRUE(std::isnan(parse_safetensors(format_safetensors(nan), "x").tensors.at("t").values.at(0)));
}

TEST(Safetensors, every_truncation_is_an_input_error) {
  const std::string bytes = format_safetensors(small_file());
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    EXPECT_THROW(static_cast<void>(parse_safetensors(bytes.substr(0, length), "w.safetensors")), InputError) << length;
  }
}

TEST(Safetensors, message_names_the_file_and_the_tensor) {
  const std::string bytes = format_safetensors(small_file());
  EXPECT_THAT([&] { static_cast<void>(parse_safetensors(bytes.substr(0, bytes.size() - 1), "w.safetensors")); },
              ThrowsMessage<InputError>(HasSubstr("w.safetensors: not a complete safetensors file (tensor 'b'")));
  EXPECT_THROW(static_cast<void>(parse_safetensors("\x89PNG\r\n\x1a\n and so on", "photo.png")), InputError);
}

TEST(Safetensors, refuses_other_types_and_lying_offsets) {
  const auto with_header = [](const std::string& header) {
    const std::uint64_t size = header.size();
    return std::string(reinterpret_cast<const char*>(&size), 8) + header + std::string(8, '\0');
  };
  EXPECT_THROW(static_cast<void>(
                   parse_safetensors(with_header(R"({"t":{"dtype":"I64","shape":[1],"data_offsets":[0,8]}})"), "x")),
               InputError);
  EXPECT_THROW(static_cast<void>(
                   parse_safetensors(with_header(R"({"t":{"dtype":"F32","shape":[3],"data_offsets":[0,8]}})"), "x")),
               InputError);
  EXPECT_THROW(static_cast<void>(
                   parse_safetensors(with_header(R"({"t":{"dtype":"F32","shape":[1],"data_offsets":[8,4]}})"), "x")),
               InputError);
  EXPECT_THROW(static_cast<void>(
                   parse_safetensors(with_header(R"({"t":{"dtype":"F32","shape":[-1],"data_offsets":[0,8]}})"), "x")),
               InputError);
  EXPECT_THROW(static_cast<void>(parse_safetensors(with_header("[1, 2]"), "x")), InputError);
}

}  // namespace
}  // namespace orthodrive
