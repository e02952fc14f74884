#include "orthodrive/core/aside_file.hpp"

#include <unistd.h>

#include <fstream>
#include <string>

#include "orthodrive/core/error.hpp"

namespace orthodrive {
namespace fs = std::filesystem;

AsideFile::AsideFile(fs::path target) : target_(std::move(target)) {
  const fs::path parent = target_.has_parent_path() ? target_.parent_path() : fs::path(".");
  std::error_code failed;
  fs::create_directories(parent, failed);
  if (failed) throw Error(parent.string() + ": cannot be created (" + failed.message() + ")");
  // The process id keeps two runs into one folder apart; the extension stays last for drivers that look at it.
  aside_ = parent / ("." + target_.stem().string() + ".partial-" + std::to_string(getpid()) + target_.extension().string());
  fs::remove_all(aside_, failed);
}

AsideFile::~AsideFile() {
  if (committed_) return;
  std::error_code ignored;
  fs::remove_all(aside_, ignored);
}

void AsideFile::commit() {
  std::error_code failed;
  if (fs::is_directory(target_)) {  // rename() does not replace a folder that is not empty
    fs::path old = target_;
    old += ".old-" + std::to_string(getpid());
    fs::rename(target_, old, failed);
    if (!failed) fs::rename(aside_, target_, failed);
    std::error_code ignored;
    if (failed) fs::rename(old, target_, ignored);
    else fs::remove_all(old, ignored);
  } else {
    fs::rename(aside_, target_, failed);
  }
  if (failed) throw Error(target_.string() + ": cannot be written (" + failed.message() + ")");
  committed_ = true;
}

void write_text_file(const fs::path& target, std::string_view text) {
  AsideFile out(target);
  {
    std::ofstream stream(out.path(), std::ios::binary);
    stream.write(text.data(), static_cast<std::streamsize>(text.size()));
    stream.close();
    if (!stream) throw Error(target.string() + ": cannot be written, is the disk full or the folder read-only?");
  }
  out.commit();
}

}  // namespace orthodrive
