// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/lab/training/parts.hpp"

#include "orthodrive/core/find_resource.hpp"
#include "orthodrive/core/load_part.hpp"

namespace orthodrive {
namespace {
const void* load(const std::string& name, const std::string& what) {
  return load_part({what, "parts/" + name + ".so", "orthodrive_part_" + name, "orthodrive-parts"}, library_folders());
}
}  // namespace

const TrainPart& train_part() {
  static const void* table = load("train", "training a network");
  return *static_cast<const TrainPart*>(table);
}

const ForestsPart& forests_part() {
  static const void* table = load("forests", "the MRF baseline and its forests");
  return *static_cast<const ForestsPart*>(table);
}

}  // namespace orthodrive
