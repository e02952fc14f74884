// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/crf/crf_model.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>
#include <ranges>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/whole_number.hpp"

namespace orthodrive {

CrfSet parse_crf_set(std::string_view text) {
  const auto named = std::ranges::find(crf_sets, text, &CrfSet::name);
  if (named != crf_sets.end()) return *named;
  std::array<double, 5> values{};
  std::size_t read = 0;
  const char *at = text.data(), *end = text.data() + text.size();
  while (read < values.size()) {
    const auto [after, error] = std::from_chars(at, end, values[read]);
    if (error != std::errc{}) break;
    at = after, ++read;
    if (read == values.size() || at == end || *at != ',') break;
    ++at;
  }
  if (read != values.size() || at != end)
    throw OptionError(
        fmt::format("'{}' is no set of a CRF: need {}, or five numbers w1,theta_alpha,theta_beta,w2,theta_gamma", text,
                    fmt::join(crf_sets | std::views::transform(&CrfSet::name), ", ")));
  const auto [w1, alpha, beta, w2, gamma] = values;
  for (const double weight : {w1, w2})
    if (!(weight >= 0.0 && weight <= 1000.0))
      throw OptionError(fmt::format("the CRF's weight {} is not from 0 to 1000", weight));
  for (const double width : {alpha, beta, gamma})
    if (!(width >= 0.1 && width <= 1000.0))
      throw OptionError(fmt::format("the CRF's width {} is not from 0.1 to 1000", width));
  return {"", static_cast<float>(w1), alpha, beta, static_cast<float>(w2), gamma};
}

CrfModel crf_of(const CrfSet& set, int classes) {
  return {{set.theta_alpha_px, set.theta_beta, set.theta_gamma_px}, potts_crf(classes, set.w1, set.w2, 10)};
}

CrfModel reference_crf(int classes) { return crf_of(crf_sets.back(), classes); }

void add_crf(TensorFile& file, const CrfModel& crf) {
  const CrfParameters& p = crf.parameters;
  const std::int64_t n = p.classes;
  file.tensors["crf/appearance_weight"] = {{n}, p.appearance_weight};
  file.tensors["crf/smoothness_weight"] = {{n}, p.smoothness_weight};
  file.tensors["crf/compatibility"] = {{n, n}, p.compatibility};
  if (!p.unary_compatibility.empty()) file.tensors["crf/unary_compatibility"] = {{n, n}, p.unary_compatibility};
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
  if (file.tensors.contains("crf/unary_compatibility"))
    crf.parameters.unary_compatibility = values("crf/unary_compatibility", n * n);
  return crf;
}

}  // namespace orthodrive
