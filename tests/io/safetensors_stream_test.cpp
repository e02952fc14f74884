// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/models/safetensors_stream.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <sstream>

#include "io/temporary_file.hpp"
#include "orthodrive/core/error.hpp"

namespace orthodrive {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

const std::vector<std::uint8_t> some_u8{0, 255, 7};
const std::vector<std::int64_t> some_i64{std::numeric_limits<std::int64_t>::min(), -1, 1LL << 53};

template <typename T>
std::span<const std::byte> bytes(const std::vector<T>& values) {
  return std::as_bytes(std::span(values));
}

std::string all_types() {
  std::ostringstream out;
  SafetensorsWriter writer(out, {{"key", "value"}},
                           {{"z", TensorType::u8, {3, 1}},
                            {"none", TensorType::f32, {0, 4}},
                            {"a", TensorType::i64, {3}},
                            {"f", TensorType::f32, {}}});
  writer.write("z", bytes(some_u8));
  writer.write("a", bytes(some_i64).first(5));  // in pieces, not even of whole numbers
  writer.write("a", bytes(some_i64).subspan(5));
  writer.write("f", bytes(std::vector<float>{1.5F}));
  writer.finish();
  return std::move(out).str();
}

std::string with_header(const std::string& header, std::size_t data_bytes) {
  const std::uint64_t size = header.size();
  return std::string(reinterpret_cast<const char*>(&size), 8) + header + std::string(data_bytes, '\0');
}

TEST(SafetensorsStream, every_type_comes_back_in_any_order) {
  const TemporaryFile file(all_types());
  SafetensorsReader reader(file.path());
  EXPECT_EQ(reader.metadata().at("key"), "value");
  EXPECT_EQ(reader.tensors().size(), 4u);
  EXPECT_EQ(reader.read_floats("f").values, std::vector<float>{1.5F});
  EXPECT_TRUE(reader.read_floats("f").shape.empty());  // a single number
  EXPECT_EQ(reader.read_i64("a"), some_i64);
  EXPECT_EQ(reader.read_u8("z"), some_u8);
  EXPECT_EQ(reader.place("z", TensorType::u8).shape, (std::vector<std::int64_t>{3, 1}));
  EXPECT_TRUE(reader.read_floats("none").values.empty());
}

TEST(SafetensorsStream, a_part_of_a_tensor_and_no_more) {
  const TemporaryFile file(all_types());
  SafetensorsReader reader(file.path());
  std::vector<std::uint8_t> part(2);
  const TensorPlace& place = reader.place("z", TensorType::u8);
  reader.read(place, 1, std::as_writable_bytes(std::span(part)));
  EXPECT_EQ(part, (std::vector<std::uint8_t>{255, 7}));
  EXPECT_THROW(reader.read(place, 2, std::as_writable_bytes(std::span(part))), Error);
}

TEST(SafetensorsStream, weights_are_the_same_by_file_and_by_bytes) {
  TensorFile weights;
  weights.metadata["a"] = "b";
  weights.tensors["half"] = {{3}, {0.1F, -2.0F, 6e-8F}, TensorType::f16};
  weights.tensors["single"] = {{2, 1}, {1.0F / 3.0F, -0.0F}, TensorType::f32};
  weights.tensors["long half"] = {{70000}, std::vector<float>(70000, 0.25F), TensorType::f16};  // several pieces
  const std::string bytes = format_safetensors(weights);
  const TemporaryFile file(bytes);
  EXPECT_EQ(format_safetensors(read_safetensors(file.path())), bytes);
  EXPECT_EQ(format_safetensors(parse_safetensors(bytes, "x")), bytes);
}

TEST(SafetensorsStream, every_truncation_and_any_tail_is_an_input_error) {
  const std::string bytes = all_types();
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    const TemporaryFile file(std::string_view(bytes).substr(0, length));
    EXPECT_THROW(SafetensorsReader{file.path()}, InputError) << length;
  }
  const TemporaryFile longer(bytes + "x");
  EXPECT_THROW(SafetensorsReader{longer.path()}, InputError);
  EXPECT_THROW(SafetensorsReader{"/no/such/file"}, InputError);
  EXPECT_THROW(SafetensorsReader{"/"}, InputError);  // a folder
}

TEST(SafetensorsStream, refuses_headers_that_lie) {
  const auto reading = [](const std::string& header, std::size_t data_bytes) {
    const TemporaryFile file(with_header(header, data_bytes));
    SafetensorsReader reader(file.path());
  };
  const auto message = [](const char* text) { return ThrowsMessage<InputError>(HasSubstr(text)); };
  EXPECT_THAT(
      [&] {
        reading(R"({"a":{"dtype":"U8","shape":[4],"data_offsets":[0,4]},)"
                R"("b":{"dtype":"U8","shape":[4],"data_offsets":[2,6]}})",
                6);
      },
      message("tensor 'b': overlaps"));
  EXPECT_THAT([&] { reading(R"({"a":{"dtype":"U8","shape":[4],"data_offsets":[2,6]}})", 6); },
              message("2 bytes before it"));
  EXPECT_THAT([&] { reading(R"({"a":{"dtype":"U8","shape":[4],"data_offsets":[0,4]}})", 6); },
              message("2 bytes after it"));
  EXPECT_THAT([&] { reading(R"({"a":{"dtype":"I64","shape":[4],"data_offsets":[0,4]}})", 4); },
              message("inconsistent"));
  EXPECT_THAT([&] { reading(R"({"a":{"dtype":"BF16","shape":[2],"data_offsets":[0,4]}})", 4); }, message("BF16"));
  EXPECT_THAT([&] { reading(R"({"a":{"dtype":"U8","shape":[-1,-4],"data_offsets":[0,4]}})", 4); }, message("shape"));
  // 2^32 * 2^32 bytes wrap around to none.
  EXPECT_THAT([&] { reading(R"({"a":{"dtype":"U8","shape":[4294967296,4294967296],"data_offsets":[0,0]}})", 0); },
              message("impossible shape"));
  EXPECT_THAT([&] { reading(R"({"a":{"dtype":"U8","shape":[4],"data_offsets":[-4,0]}})", 4); },
              message("data_offsets"));
  EXPECT_THAT([&] { reading(R"({"a":{"dtype":"U8","shape":[4]}})", 4); }, message("'a'"));
  EXPECT_THAT([&] { reading(R"({"__metadata__":{"k":1}})", 0); }, message("__metadata__"));
  EXPECT_THAT([&] { reading("[]", 0); }, message("no JSON object"));
}

TEST(SafetensorsStream, another_file_than_expected_is_named) {
  const TemporaryFile file(all_types());
  SafetensorsReader reader(file.path());
  EXPECT_THAT([&] { static_cast<void>(reader.read_u8("rgb")); },
              ThrowsMessage<InputError>(HasSubstr(file.path().string() + ": has no tensor 'rgb'")));
  EXPECT_THAT([&] { static_cast<void>(reader.read_u8("a")); },
              ThrowsMessage<InputError>(HasSubstr("'a' is I64, need U8")));
  EXPECT_THAT([&] { static_cast<void>(reader.read_floats("a")); }, ThrowsMessage<InputError>(HasSubstr("need F32")));
  EXPECT_THAT([&] { static_cast<void>(parse_safetensors(all_types(), "w")); },
              ThrowsMessage<InputError>(HasSubstr("w: tensor 'a' is I64")));
}

TEST(SafetensorsStream, writer_refuses_what_was_not_announced) {
  const auto writer_of = [](std::ostream& out) {
    return SafetensorsWriter(out, {}, {{"a", TensorType::u8, {2}}, {"b", TensorType::u8, {3}}});
  };
  std::ostringstream out;
  EXPECT_THROW(writer_of(out).write("b", bytes(some_u8)), Error);  // before its turn
  EXPECT_THROW(writer_of(out).write("a", bytes(some_u8)), Error);  // too long
  EXPECT_THROW(writer_of(out).finish(), Error);                    // nothing written
  EXPECT_THROW(SafetensorsWriter(out, {}, {{"a", TensorType::u8, {2}}, {"a", TensorType::u8, {2}}}), Error);
  EXPECT_THROW(SafetensorsWriter(out, {}, {{"a", TensorType::u8, {-2}}}), Error);
  TensorFile torn;  // fewer values than the shape says
  torn.tensors["a"] = {{3}, {1.0F}, TensorType::f32};
  EXPECT_THROW(static_cast<void>(format_safetensors(torn)), Error);
}

TEST(SafetensorsStream, a_full_disk_is_an_error) {
  std::ofstream full("/dev/full", std::ios::binary);
  if (!full) GTEST_SKIP() << "no /dev/full here";
  TensorFile weights;
  weights.tensors["a"] = {{1}, {1.0F}, TensorType::f32};
  EXPECT_THROW(write_safetensors(full, weights), Error);
}

}  // namespace
}  // namespace orthodrive
