// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/raster/computed_photo.hpp"

#include <algorithm>
#include <utility>
#include <vector>

namespace orthodrive::io {
namespace {

class ComputedPhoto;

class ComputedBand final : public GDALRasterBand {
 public:
  ComputedBand(ComputedPhoto& photo, int band, GDALRasterBand& like);
  GDALColorInterp GetColorInterpretation() override {
    constexpr GDALColorInterp roles[] = {GCI_RedBand, GCI_GreenBand, GCI_BlueBand, GCI_AlphaBand};
    return roles[nBand - 1];
  }

 protected:
  CPLErr IReadBlock(int block_col, int block_row, void* data) override;
};

class ComputedPhoto final : public GDALDataset {
 public:
  ComputedPhoto(GDALDataset& like, int bands, ComputeBand compute) : compute_(std::move(compute)) {
    nRasterXSize = like.GetRasterXSize(), nRasterYSize = like.GetRasterYSize();
    is_placed_ = like.GetGeoTransform(place_) == CE_None;
    if (const OGRSpatialReference* reference = like.GetSpatialRef()) reference_ = *reference;
    for (int band = 1; band <= bands; ++band)
      SetBand(band, std::make_unique<ComputedBand>(*this, band, *like.GetRasterBand(1)).release());
  }
  CPLErr GetGeoTransform(double* place) override {
    std::copy_n(place_, 6, place);
    return is_placed_ ? CE_None : CE_Failure;
  }
  [[nodiscard]] const OGRSpatialReference* GetSpatialRef() const override {
    return reference_.IsEmpty() ? nullptr : &reference_;
  }
  [[nodiscard]] bool compute(int band, const ComputedWindow& window, std::uint8_t* pixels) const {
    return compute_(band, window, pixels);
  }

 private:
  ComputeBand compute_;
  double place_[6] = {0, 1, 0, 0, 0, 1};
  bool is_placed_ = false;
  OGRSpatialReference reference_;
};

ComputedBand::ComputedBand(ComputedPhoto& photo, int band, GDALRasterBand& like) {
  poDS = &photo, nBand = band;
  nRasterXSize = like.GetXSize(), nRasterYSize = like.GetYSize();
  eDataType = GDT_Byte;
  like.GetBlockSize(&nBlockXSize, &nBlockYSize);
}

CPLErr ComputedBand::IReadBlock(int block_col, int block_row, void* data) {
  const ComputedWindow window{block_col * nBlockXSize, block_row * nBlockYSize,
                              std::min(nBlockXSize, nRasterXSize - block_col * nBlockXSize),
                              std::min(nBlockYSize, nRasterYSize - block_row * nBlockYSize)};
  const auto columns = static_cast<std::size_t>(window.width), stride = static_cast<std::size_t>(nBlockXSize);
  std::vector<std::uint8_t> pixels(columns * static_cast<std::size_t>(window.height));
  if (!static_cast<ComputedPhoto*>(poDS)->compute(nBand, window, pixels.data())) return CE_Failure;
  auto* block = static_cast<std::uint8_t*>(data);
  std::fill_n(block, stride * static_cast<std::size_t>(nBlockYSize), std::uint8_t{0});
  for (std::size_t row = 0; row < static_cast<std::size_t>(window.height); ++row)
    std::copy_n(pixels.data() + row * columns, columns, block + row * stride);
  return CE_None;
}

}  // namespace

DatasetPtr computed_photo(GDALDataset& like, int bands, ComputeBand compute) {
  return DatasetPtr(std::make_unique<ComputedPhoto>(like, bands, std::move(compute)).release());
}

bool read_band(GDALRasterBand& band, const ComputedWindow& window, std::uint8_t* pixels) {
  return band.RasterIO(GF_Read, window.col, window.row, window.width, window.height, pixels, window.width,
                       window.height, GDT_Byte, 0, 0, nullptr) == CE_None;
}

}  // namespace orthodrive::io
