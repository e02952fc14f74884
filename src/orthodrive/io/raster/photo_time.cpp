// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/raster/photo_time.hpp"

#include <fmt/format.h>

#include <cstdio>

#include "orthodrive/io/support/gdal_support.hpp"

namespace orthodrive::io {

std::optional<std::string> time_of_tag(const std::string& text) {
  int year = 0, month = 0, day = 0, hour = 0, minute = 0, second = 0;
  // NOLINTNEXTLINE(bugprone-unchecked-string-to-number-conversion): of four digits at most
  const int read = std::sscanf(text.c_str(), "%4d:%2d:%2d %2d:%2d:%2d", &year, &month, &day, &hour, &minute, &second);
  const auto within = [](int value, int least, int most) { return value >= least && value <= most; };
  const bool good = read == 6 && within(year, 1900, 2100) && within(month, 1, 12) && within(day, 1, 31) &&
                    within(hour, 0, 23) && within(minute, 0, 59) && within(second, 0, 59);
  if (!good) return std::nullopt;
  return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}Z", year, month, day, hour, minute, second);
}

std::optional<std::string> photo_time(const std::filesystem::path& path) {
  const DatasetPtr dataset = open_dataset(path, GDAL_OF_RASTER);
  for (const char* key : {"EXIF_DateTimeOriginal", "TIFFTAG_DATETIME"})
    if (const char* text = dataset->GetMetadataItem(key))
      if (auto time = time_of_tag(text)) return time;
  return std::nullopt;
}

}  // namespace orthodrive::io
