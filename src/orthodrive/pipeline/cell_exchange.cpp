#include "orthodrive/pipeline/cell_exchange.hpp"

#include <fmt/format.h>

#include "orthodrive/core/error.hpp"

namespace orthodrive {
namespace fs = std::filesystem;

std::optional<std::string> CellExchange::load(const std::string& loop, std::size_t block) const {
  return store_.part(loop).load(block);
}

std::optional<std::string> CellExchange::claim(const std::string& loop, std::size_t block,
                                               const std::set<std::string>& lost) {
  if (!takes_part_) return std::nullopt;
  const fs::path folder = store_.part(loop).folder(block).parent_path();
  std::error_code failed;
  fs::create_directories(folder, failed);
  if (failed) throw Error(fmt::format("{}: cannot be created ({})", folder.string(), failed.message()));
  for (int before = 0;; ++before) {
    const fs::path link = folder / fmt::format("{}.claim-{}", block, before);
    fs::create_symlink(CellStore::this_process(), link, failed);
    if (!failed) return std::nullopt;
    std::error_code unread;
    const std::string maker = fs::read_symlink(link, unread).string();
    if (unread) throw Error(fmt::format("{}: cannot be written ({})", link.string(), failed.message()));
    if (!lost.contains(maker)) return maker;
  }
}

void CellExchange::keep(const std::string& loop, std::size_t block, const std::string& bytes) {
  if (takes_part_) CellFolder(store_.part(loop), block).commit(bytes);
}

}  // namespace orthodrive
