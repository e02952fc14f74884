// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/pipeline/files/network_spec.hpp"

#include <fmt/format.h>

#include "orthodrive/core/error.hpp"
#include "orthodrive/model/rasters/allowed_classes.hpp"
#include "orthodrive/nets/make_network.hpp"
#include "orthodrive/pipeline/files/toml_section.hpp"

namespace orthodrive {

NetworkSpec parse_network_spec(std::string_view text, const std::filesystem::path& file) {
  const toml::table table = parse_toml(text, file);
  TomlSection section(table, file);
  NetworkSpec spec;
  for (const char* key : {"trunk", "stride", "decoder", "gsd_m"}) section.require(key);
  section.read("trunk", spec.trunk);
  section.read("stride", spec.stride);
  section.read("decoder", spec.decoder);
  section.read("gsd_m", spec.gsd_m);
  section.read("finest_gsd_m", spec.finest_gsd_m);
  section.read("classes", spec.class_table_file);
  section.finish();
  if (!(spec.gsd_m > 0.0))
    throw InputError(file.string(), "'gsd_m' must be above 0: the input scale in metres a pixel");
  try {
    (void)make_network(spec.architecture(), 2);
  } catch (const OptionError& error) {
    throw InputError(file.string(), error.what());
  }
  return spec;
}

ClassTable parse_class_table(std::string_view text, const std::filesystem::path& file) {
  const toml::table table = parse_toml(text, file);
  TomlSection section(table, file);
  ClassTable classes;
  for (const char* key : {"name", "class"}) section.require(key);
  section.read("name", classes.name);
  section.for_each_table("class", [&](TomlSection& entry) {
    for (const char* key : {"name", "role"}) entry.require(key);
    ClassInfo info;
    std::string role;
    entry.read("name", info.name);
    entry.read_color("color", info.color);
    entry.read("role", role);
    entry.read("cost_false_positive", info.cost_false_positive);
    entry.read("cost_false_negative", info.cost_false_negative);
    try {
      info.role = role_from_string(role);
    } catch (const OptionError& error) {
      throw InputError(file.string(), fmt::format("class '{}': {}", info.name, error.what()));
    }
    classes.classes.push_back(std::move(info));
  });
  section.finish();
  if (classes.classes.size() < 2 || classes.classes.size() > max_classes)
    throw InputError(file.string(), fmt::format("{} classes: need 2 to {}", classes.classes.size(), max_classes));
  return classes;
}

std::string NetworkSpec::architecture() const {
  return decoder == "fcn" ? fmt::format("{}-{}s", trunk, stride) : fmt::format("{}-s{}-{}", trunk, stride, decoder);
}

}  // namespace orthodrive
