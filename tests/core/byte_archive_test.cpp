// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/core/byte_archive.hpp"

#include <gtest/gtest.h>

namespace orthodrive {
namespace {

struct Inner {
  std::array<float, 3> position{};
  std::string name;
  friend bool operator==(const Inner&, const Inner&) = default;
};
template <typename Archive>
void fields(Archive& archive, Inner& inner) {
  archive(inner.position, inner.name);
}
enum class Kind : std::uint8_t { one, two };
struct Outer {
  Kind kind = Kind::one;
  std::vector<Inner> inner;
  std::optional<double> width, height;
  std::vector<std::uint16_t> numbers;
  std::vector<std::vector<Inner>> rings;
  std::vector<bool> flags;
  std::variant<Kind, Inner, double> either;
  friend bool operator==(const Outer&, const Outer&) = default;
};
template <typename Archive>
void fields(Archive& archive, Outer& outer) {
  archive(outer.kind, outer.inner, outer.width, outer.height, outer.numbers, outer.rings, outer.flags, outer.either);
}

std::string bytes_of(const Outer& outer) {
  ByteWriter writer;
  writer(outer);
  return writer.take();
}

const Outer example{Kind::two,
                    {{{1.5F, -2.0F, 0.0F}, "Straße"}, {{}, ""}},
                    3.25,
                    std::nullopt,
                    {1, 65535},
                    {{}, {{{}, "x"}}},
                    {true, false, true},
                    Inner{{}, "held"}};

TEST(ByteArchive, gives_back_what_it_took) {
  const std::string bytes = bytes_of(example);
  ByteReader reader(bytes, "part");
  Outer read;
  read.height = 7.0;  // goes: the archive has none
  reader(read);
  reader.finish();
  EXPECT_EQ(read, example);
}

TEST(ByteArchive, refuses_bytes_that_were_cut_at_any_place) {
  const std::string bytes = bytes_of(example);
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    const std::string cut = bytes.substr(0, size);
    ByteReader reader(cut, "part");
    Outer read;
    EXPECT_THROW(reader(read), InputError) << size;
  }
}

TEST(ByteArchive, refuses_bytes_that_go_on_and_lengths_that_lie) {
  const std::string longer = bytes_of(example) + "x";
  ByteReader reader(longer, "part");
  Outer read;
  reader(read);
  EXPECT_THROW(reader.finish(), InputError);

  std::string lie(8, '\xff');  // a vector of 2^64 - 1 items
  ByteReader of_lie(lie, "part");
  std::vector<double> values;
  EXPECT_THROW(of_lie(values), InputError);
}

}  // namespace
}  // namespace orthodrive
