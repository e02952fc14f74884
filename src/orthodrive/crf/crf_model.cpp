// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/crf/crf_model.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/whole_number.hpp"

namespace orthodrive {

CrfModel reference_crf(int classes) {
  return {{.theta_alpha_px = 13.5, .theta_beta = 11.0, .theta_gamma_px = 1.75}, potts_crf(classes, 5.2F, 1.5F, 10)};
}

void add_crf(TensorFile& file, const CrfModel& crf) {
  const CrfParameters& p = crf.parameters;
  const std::int64_t n = p.classes;
  file.tensors["crf/appearance_weight"] = {{n}, p.appearance_weight};
  file.tensors["crf/smoothness_weight"] = {{n}, p.smoothness_weight};
  file.tensors["crf/compatibility"] = {{n, n}, p.compatibility};
  const nlohmann::ordered_json json{{"theta_alpha_px", crf.widths.theta_alpha_px},
                                    {"theta_beta", crf.widths.theta_beta},
                                    {"theta_gamma_px", crf.widths.theta_gamma_px},
                                    {"iterations", p.iterations}};
  file.metadata["crf"] = json.dump();
}

std::optional<CrfModel> read_crf(const TensorFile& file, int classes, const std::string& source) {
  const auto text = file.metadata.find("crf");
  if (text == file.metadata.end()) return {};
  CrfModel crf;
  crf.parameters.classes = classes;
  try {
    const auto json = nlohmann::json::parse(text->second);
    crf.widths = {json.at("theta_alpha_px").get<double>(), json.at("theta_beta").get<double>(),
                  json.at("theta_gamma_px").get<double>()};
    crf.parameters.iterations = whole_number<int>(json.at("iterations"), "iterations");
  } catch (const std::exception& error) {
    throw InputError(source, fmt::format("its metadata item 'crf' is damaged: {}", error.what()));
  }
  const auto values = [&](const std::string& name, std::size_t count) {
    const auto it = file.tensors.find(name);
    if (it == file.tensors.end() || it->second.values.size() != count)
      throw InputError(source, fmt::format("tensor '{}' is missing or not of {} values", name, count));
    return it->second.values;
  };
  const auto n = static_cast<std::size_t>(classes);
  crf.parameters.appearance_weight = values("crf/appearance_weight", n);
  crf.parameters.smoothness_weight = values("crf/smoothness_weight", n);
  crf.parameters.compatibility = values("crf/compatibility", n * n);
  return crf;
}

}  // namespace orthodrive
