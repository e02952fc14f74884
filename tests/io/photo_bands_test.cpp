// SPDX-License-Identifier: Apache-2.0
// Photos whose format says of their bands what is not so, or does not say what is.

#include <fmt/format.h>
#include <gdal_priv.h>
#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <functional>
#include <vector>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/random.hpp"
#include "orthodrive/io/raster/raster_io.hpp"
#include "orthodrive/io/support/gdal_support.hpp"
#include "places.hpp"
#include "scratch.hpp"

namespace orthodrive {
namespace {
using testing::HasSubstr;
namespace fs = std::filesystem;

constexpr int size_px = 300;

/// A value of the scene, 40..215 with some noise: no pixel is black or white.
int scene(int col, int row, int channel) {
  Random random(static_cast<std::uint64_t>(col) * 1000003U + static_cast<std::uint64_t>(row) * 7U +
                static_cast<std::uint64_t>(channel));
  return 60 + 40 * channel + static_cast<int>(30.0 * std::sin(0.05 * col) + 20.0 * random.uniform());
}

using Paint = std::function<double(int col, int row, int band)>;

struct PhotoFile {
  int bands = 3;
  GDALDataType type = GDT_Byte;
  std::vector<std::string> options;
  std::vector<GDALColorInterp> roles;
  double nodata = NAN;
};

fs::path write(const fs::path& path, const PhotoFile& file, const Paint& paint) {
  if (fs::exists(path)) fs::remove(path);
  io::start_gdal();
  std::vector<char*> options;
  std::vector<std::string> texts = file.options;
  options.reserve(texts.size() + 1);
  for (std::string& text : texts) options.push_back(text.data());
  options.push_back(nullptr);
  GDALDataset* dataset = GetGDALDriverManager()->GetDriverByName("GTiff")->Create(
      path.c_str(), size_px, size_px, file.bands, file.type, options.data());
  double place[6] = {origin.x, 0.5, 0.0, origin.y + 0.5 * size_px, 0.0, -0.5};
  dataset->SetGeoTransform(place);
  OGRSpatialReference reference;
  reference.importFromEPSG(32633);
  dataset->SetSpatialRef(&reference);
  for (int b = 1; b <= file.bands; ++b) {
    GDALRasterBand& band = *dataset->GetRasterBand(b);
    if (static_cast<std::size_t>(b) <= file.roles.size())
      band.SetColorInterpretation(file.roles[static_cast<std::size_t>(b - 1)]);
    if (!std::isnan(file.nodata)) band.SetNoDataValue(file.nodata);
    std::vector<double> row(size_px);
    for (int r = 0; r < size_px; ++r) {
      for (int c = 0; c < size_px; ++c) row[static_cast<std::size_t>(c)] = paint(c, r, b - 1);
      EXPECT_EQ(band.RasterIO(GF_Write, 0, r, size_px, 1, row.data(), size_px, 1, GDT_Float64, 0, 0, nullptr), CE_None);
    }
  }
  GDALClose(dataset);
  return path;
}

struct ReadBack {
  Photo photo;
  Findings findings;
  double valid_share = 0.0;
};

ReadBack read_back(const fs::path& path) {
  ReadBack back;
  const SiteFrame site = site_of(0.5 * size_px);
  const PhotoSource source = io::open_photo(path, site, {}, &back.findings);
  PhotoWindow whole = source.read(pixels_of(source.frame));
  back.photo = {source.crs, source.frame, std::move(whole.rgb), std::move(whole.valid)};
  for (const std::uint8_t valid : back.photo.valid.data) back.valid_share += valid;
  back.valid_share /= static_cast<double>(back.photo.valid.data.size());
  const Photo native = io::read_photo_native(path);  // the same on its own grid
  EXPECT_EQ(native.valid.data, back.photo.valid.data);
  return back;
}

TEST(PhotoBands, near_infrared_that_is_called_alpha_is_no_mask) {
  const Scratch scratch;
  const std::vector<std::string> rgba{"PHOTOMETRIC=RGB", "ALPHA=YES"};
  const auto nir = [](int c, int r) { return (c / 20 + r / 30) % 2 ? 30 + scene(c, r, 0) : scene(c, r, 1) / 2; };
  for (const bool with_zeros : {false, true}) {
    const ReadBack back =
        read_back(write(scratch / "naip.tif", {.bands = 4, .options = rgba}, [&](int c, int r, int b) {
          return b < 3 ? scene(c, r, b) : with_zeros && c < 40 ? 0 : nir(c, r);  // water is black in near infrared
        }));
    EXPECT_EQ(back.valid_share, 1.0);
    EXPECT_EQ(back.photo.rgb.at(100, 50, 1), scene(100, 50, 1));
    ASSERT_EQ(back.findings.size(), 1u);
    EXPECT_EQ(back.findings[0].code, "photo.alpha_is_none");
    EXPECT_THAT(back.findings[0].message, HasSubstr("naip.tif: band 4 is said to be transparency"));
  }
}

TEST(PhotoBands, masks_stay_masks_soft_ones_too_and_those_of_another_range) {
  const Scratch scratch;
  const std::vector<std::string> rgba{"PHOTOMETRIC=RGB", "ALPHA=YES"};
  const auto with_alpha = [&](const std::function<int(int)>& alpha_of_col) {
    return read_back(write(scratch / "a.tif", {.bands = 4, .options = rgba},
                           [&](int c, int r, int b) { return b < 3 ? scene(c, r, b) : alpha_of_col(c); }));
  };
  const ReadBack hard = with_alpha([](int c) { return c < 150 ? 0 : 255; });
  EXPECT_NEAR(hard.valid_share, 0.5, 0.01);
  EXPECT_TRUE(hard.findings.empty());
  const ReadBack soft = with_alpha([](int c) { return std::min(255, 4 * c); });
  EXPECT_NEAR(soft.valid_share, 1.0 - 32.0 / 300.0, 0.01);
  EXPECT_TRUE(soft.findings.empty());
  const ReadBack ones = with_alpha([](int c) { return c < 150 ? 0 : 1; });
  EXPECT_NEAR(ones.valid_share, 0.5, 0.01);
  ASSERT_EQ(ones.findings.size(), 1u);
  EXPECT_EQ(ones.findings[0].code, "photo.alpha_range");
  EXPECT_EQ(with_alpha([](int) { return 0; }).valid_share, 0.0);
}

TEST(PhotoBands, collars_are_no_data_black_and_white_frayed_by_jpeg_or_not) {
  const Scratch scratch;
  const auto in_collar = [](int c, int r) { return c > 180 || r + c < 150; };  // a strip, and a corner
  const auto photo = [&](int color) {
    return [=](int c, int r, int b) { return in_collar(c, r) ? color : scene(c, r, b); };
  };
  const std::vector<std::string> jpeg{"COMPRESS=JPEG", "PHOTOMETRIC=YCBCR", "INTERLEAVE=PIXEL"};
  for (const int color : {0, 255})
    for (const auto& options : {std::vector<std::string>{}, jpeg}) {
      SCOPED_TRACE(fmt::format("{} {}", color, options.size()));
      const ReadBack back = read_back(write(scratch / "collar.tif", {.options = options}, photo(color)));
      int wrong = 0;
      for (int r = 0; r < size_px; ++r)
        for (int c = 0; c < size_px; ++c) wrong += (back.photo.valid.at(c, r) != 0) == in_collar(c, r) ? 1 : 0;
      EXPECT_LE(wrong, options.empty() ? 0 : 1500);  // three pixels along the rim
      ASSERT_EQ(back.findings.size(), 1u);
      EXPECT_EQ(back.findings[0].code, "photo.collar");
      EXPECT_THAT(back.findings[0].message, HasSubstr(color ? "flat and white" : "flat and black"));
      EXPECT_THAT(back.findings[0].message, HasSubstr("% of it are flat"));
      EXPECT_NEAR(back.findings[0].x_m, origin.x + 0.5 * 240.0, 2.0);  // on the map, in the larger part
    }
}

TEST(PhotoBands, dark_and_bright_ground_is_no_collar) {
  const Scratch scratch;
  const auto untouched = [&](const char* what, const Paint& paint) {
    const ReadBack back = read_back(write(scratch / "ground.tif", {}, paint));
    EXPECT_EQ(back.valid_share, 1.0) << what;
    EXPECT_TRUE(back.findings.empty()) << what;
  };
  untouched("a black roof inside",
            [](int c, int r, int b) { return c > 100 && c < 160 && r > 100 && r < 160 ? 0 : scene(c, r, b); });
  untouched("deep water at the border",
            [](int c, int r, int b) { return c < 80 ? scene(c, r, b) % 11 : scene(c, r, b); });
  untouched("a shadow at the border", [](int c, int r, int b) { return c < 12 && r < 12 ? 0 : scene(c, r, b); });
  untouched("one colour", [](int, int, int) { return 0; });
}

TEST(PhotoBands, a_declared_mask_needs_no_word) {
  const Scratch scratch;
  const ReadBack back = read_back(
      write(scratch / "a.tif", {.bands = 4, .options = {"PHOTOMETRIC=RGB", "ALPHA=YES"}}, [](int c, int r, int b) {
        if (c < 100) return 0;
        return b < 3 ? scene(c, r, b) : 255;
      }));
  EXPECT_NEAR(back.valid_share, 2.0 / 3.0, 0.01);
  EXPECT_TRUE(back.findings.empty());
}

TEST(PhotoBands, sixteen_bit_is_scaled_from_the_range_that_it_fills) {
  const Scratch scratch;
  const auto twelve_bit = [](int c, int r, int b) { return c == 7 && r == 7 ? 65535 : 10 * scene(c, r, b); };
  const ReadBack back = read_back(write(scratch / "s.tif", {.type = GDT_UInt16}, twelve_bit));
  EXPECT_EQ(back.valid_share, 1.0);
  ASSERT_EQ(back.findings.size(), 1u);
  EXPECT_EQ(back.findings[0].code, "photo.sample_range");
  EXPECT_THAT(back.findings[0].message, HasSubstr("s.tif: has UInt16 samples"));
  std::uint8_t least = 255, most = 0;
  for (const std::uint8_t value : back.photo.rgb.data) least = std::min(least, value), most = std::max(most, value);
  EXPECT_LT(least, 10);
  EXPECT_GT(most, 245);
  EXPECT_GT(back.photo.rgb.at(50, 50, 2), back.photo.rgb.at(50, 50, 0));  // colours stay
  // No data of 16 bit stays no data; 8 bit in 16 stay what they are.
  const ReadBack holed = read_back(write(scratch / "h.tif", {.type = GDT_UInt16, .nodata = 65535},
                                         [](int c, int r, int b) { return c < 150 ? 65535 : 10 * scene(c, r, b); }));
  EXPECT_NEAR(holed.valid_share, 0.5, 0.01);
  const ReadBack eight = read_back(write(scratch / "e.tif", {.type = GDT_UInt16}, scene));
  EXPECT_EQ(eight.photo.rgb.at(100, 50, 1), scene(100, 50, 1));
  EXPECT_TRUE(eight.findings.empty());
  const ReadBack collar = read_back(write(scratch / "c.tif", {.type = GDT_UInt16},
                                          [](int c, int r, int b) { return c > 200 ? 0 : 10 * scene(c, r, b); }));
  EXPECT_NEAR(collar.valid_share, 201.0 / 300.0, 0.01);
  EXPECT_EQ(collar.findings.size(), 2u);
}

TEST(PhotoBands, bands_are_taken_by_their_names) {
  const Scratch scratch;
  const ReadBack back = read_back(write(scratch / "bgr.tif",
                                        {.bands = 4,
                                         .options = {"PHOTOMETRIC=MINISBLACK"},
                                         .roles = {GCI_BlueBand, GCI_GreenBand, GCI_RedBand, GCI_Undefined}},
                                        [](int c, int r, int b) { return b < 3 ? scene(c, r, 2 - b) : 0; }));
  for (int channel = 0; channel < 3; ++channel) EXPECT_EQ(back.photo.rgb.at(100, 50, channel), scene(100, 50, channel));
}

TEST(PhotoBands, inks_become_colours) {
  const Scratch scratch;
  const ReadBack back = read_back(write(scratch / "cmyk.tif", {.bands = 4, .options = {"PHOTOMETRIC=CMYK"}},
                                        [](int c, int r, int b) { return b < 3 ? 255 - scene(c, r, b) : 0; }));
  EXPECT_EQ(back.valid_share, 1.0);
  for (int channel = 0; channel < 3; ++channel)
    EXPECT_NEAR(back.photo.rgb.at(100, 50, channel), scene(100, 50, channel), 1);
  ASSERT_EQ(back.findings.size(), 1u);
  EXPECT_EQ(back.findings[0].code, "photo.inks");
}

TEST(PhotoBands, a_palette_in_any_order_keeps_its_colours_and_its_holes) {
  const Scratch scratch;
  const fs::path path = write(scratch / "p.tif", {.bands = 1, .nodata = 7}, [](int c, int, int) { return c % 8; });
  GDALDataset* dataset = GDALDataset::FromHandle(GDALOpen(path.c_str(), GA_Update));
  GDALColorTable table;
  for (int i = 0; i < 256; ++i) {
    const auto value = static_cast<short>((i * 37 + 60) % 200 + 20);
    const GDALColorEntry entry{value, static_cast<short>(255 - value), 90, 255};
    table.SetColorEntry(i, &entry);
  }
  dataset->GetRasterBand(1)->SetColorTable(&table);
  GDALClose(dataset);
  const ReadBack back = read_back(path);
  EXPECT_EQ(back.photo.rgb.at(3, 5, 0), (3 * 37 + 60) % 200 + 20);
  EXPECT_EQ(back.photo.rgb.at(3, 5, 1), 255 - back.photo.rgb.at(3, 5, 0));
  EXPECT_EQ(back.photo.valid.at(3, 5), 1);
  EXPECT_EQ(back.photo.valid.at(7, 5), 0);
}

}  // namespace
}  // namespace orthodrive
