// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/opendrive/fmu_io.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <pugixml.hpp>
#include <set>
#include <sstream>

#include "orthodrive/core/error.hpp"
#include "orthodrive/io/support/write_zip.hpp"

namespace orthodrive::io {
namespace {

using fmu::Causality;
using fmu::Type;
using fmu::Variable;

void set(pugi::xml_node node, const char* name, const std::string& value) {
  node.append_attribute(name) = value.c_str();
}

const char* type_name(Type type, int version) {
  switch (type) {
    case Type::float64:
      return version == 3 ? "Float64" : "Real";
    case Type::int32:
      return version == 3 ? "Int32" : "Integer";
    case Type::boolean:
      return "Boolean";
    case Type::string:
      return "String";
  }
  return "";
}

const char* causality_name(Causality causality) {
  switch (causality) {
    case Causality::independent:
      return "independent";
    case Causality::parameter:
      return "parameter";
    case Causality::input:
      return "input";
    case Causality::output:
      return "output";
  }
  return "";
}

const char* variability_of(const Variable& variable) {
  if (variable.causality == Causality::parameter) return "fixed";
  return variable.type == Type::float64 ? "continuous" : "discrete";
}

std::string start_of(const Variable& variable) {
  if (variable.type == Type::boolean) return variable.start != 0.0 ? "true" : "false";
  if (variable.type == Type::int32) return fmt::format("{}", static_cast<int>(variable.start));
  return variable.type == Type::string ? "" : fmt::format("{}", variable.start);
}

void add_units(pugi::xml_node root, const fmu::ModelKind& kind) {
  std::set<std::string> used;
  for (const Variable& variable : kind.variables) used.insert(variable.unit);
  pugi::xml_node definitions = root.append_child("UnitDefinitions");
  for (const fmu::Unit& unit : fmu::units()) {
    if (!used.contains(unit.name)) continue;
    pugi::xml_node node = definitions.append_child("Unit");
    set(node, "name", unit.name);
    pugi::xml_node base = node.append_child("BaseUnit");
    for (const auto& [name, exponent] : {std::pair("kg", unit.kg), {"m", unit.m}, {"s", unit.s}, {"rad", unit.rad}})
      if (exponent != 0) set(base, name, std::to_string(exponent));
    if (unit.factor != 1.0) set(base, "factor", fmt::format("{}", unit.factor));
  }
}

bool has_start(const Variable& variable) {
  return variable.causality == Causality::parameter || variable.causality == Causality::input;
}

/// The attributes that both versions have in the same place.
void describe(pugi::xml_node node, const Variable& variable, std::size_t reference) {
  set(node, "name", variable.name);
  set(node, "valueReference", std::to_string(reference));
  set(node, "causality", causality_name(variable.causality));
  set(node, "variability", variability_of(variable));
  if (!variable.description.empty()) set(node, "description", variable.description);
  if (variable.causality == Causality::output) set(node, "initial", "calculated");
}

/// FMI 3: <Float64 name=... start=.../>, texts have their start as an element.
void add_variable_3(pugi::xml_node list, const Variable& variable, std::size_t reference) {
  pugi::xml_node node = list.append_child(type_name(variable.type, 3));
  describe(node, variable, reference);
  if (!variable.unit.empty()) set(node, "unit", variable.unit);
  if (!has_start(variable)) return;
  if (variable.type == Type::string)
    set(node.append_child("Start"), "value", start_of(variable));
  else
    set(node, "start", start_of(variable));
}

/// FMI 2: <ScalarVariable name=...><Real start=.../></ScalarVariable>.
void add_variable_2(pugi::xml_node list, const Variable& variable, std::size_t reference) {
  pugi::xml_node node = list.append_child("ScalarVariable");
  describe(node, variable, reference);
  pugi::xml_node type = node.append_child(type_name(variable.type, 2));
  if (has_start(variable)) set(type, "start", start_of(variable));
  if (!variable.unit.empty()) set(type, "unit", variable.unit);
}

/// `first` is the number of the first variable: 0 for value references (FMI 3), 1 for indices (FMI 2).
std::string dependencies_of(const Variable& variable, std::size_t first) {
  std::string text;
  for (const std::size_t reference : variable.depends_on)
    text += (text.empty() ? "" : " ") + std::to_string(reference + first);
  return text;
}

void add_structure(pugi::xml_node root, const fmu::ModelKind& kind, int version) {
  pugi::xml_node structure = root.append_child("ModelStructure");
  const auto each_output = [&](pugi::xml_node parent, const char* element) {
    for (std::size_t i = 0; i < kind.variables.size(); ++i) {
      const Variable& variable = kind.variables[i];
      if (variable.causality != Causality::output) continue;
      pugi::xml_node node = parent.append_child(element);
      set(node, version == 3 ? "valueReference" : "index", std::to_string(version == 3 ? i : i + 1));
      // At the start all depends on the files that the parameters name, so nothing is said.
      if (std::string(element) == "Output" || parent.name() == std::string("Outputs"))
        set(node, "dependencies", dependencies_of(variable, version == 3 ? 0 : 1));
    }
  };
  if (version == 3) {
    each_output(structure, "Output");
    each_output(structure, "InitialUnknown");
  } else {
    each_output(structure.append_child("Outputs"), "Unknown");
    each_output(structure.append_child("InitialUnknowns"), "Unknown");
  }
}

std::string read_bytes(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  if (!in || bytes.empty()) throw InputError(path.string(), "cannot be read, or is empty");
  return bytes;
}

}  // namespace

std::string model_description(const fmu::ModelKind& kind, int version) {
  pugi::xml_document document;
  pugi::xml_node root = document.append_child("fmiModelDescription");
  set(root, "fmiVersion", version == 3 ? "3.0" : "2.0");
  set(root, "modelName", kind.identifier);
  set(root, version == 3 ? "instantiationToken" : "guid", fmu::instantiation_token(kind));
  set(root, "description", kind.description);
  set(root, "generationTool", "Orthodrive");
  set(root, "variableNamingConvention", "structured");
  pugi::xml_node co_simulation = root.append_child("CoSimulation");
  set(co_simulation, "modelIdentifier", kind.identifier);
  set(co_simulation, "canHandleVariableCommunicationStepSize", "true");
  if (version == 3 && kind.internal_step_s > 0.0)
    set(co_simulation, "fixedInternalStepSize", fmt::format("{}", kind.internal_step_s));
  add_units(root, kind);
  set(root.append_child("LogCategories").append_child("Category"), "name", "logStatusError");
  pugi::xml_node experiment = root.append_child("DefaultExperiment");
  set(experiment, "startTime", "0");
  set(experiment, "stepSize", fmt::format("{}", kind.default_step_s));
  pugi::xml_node list = root.append_child("ModelVariables");
  for (std::size_t i = 0; i < kind.variables.size(); ++i)
    (version == 3 ? add_variable_3 : add_variable_2)(list, kind.variables[i], i);
  add_structure(root, kind, version);
  std::ostringstream text;
  document.save(text, " ", pugi::format_indent, pugi::encoding_utf8);
  return text.str();
}

void write_fmu(const std::filesystem::path& path, const fmu::ModelKind& kind, int version,
               const std::filesystem::path& shared_library, const std::vector<FmuResource>& resources) {
  if (version != 2 && version != 3) throw OptionError(fmt::format("FMI {} cannot be written, choose 2 or 3", version));
  const std::string platform = version == 3 ? "x86_64-linux" : "linux64";
  std::vector<ZipEntry> entries = {
      {"modelDescription.xml", model_description(kind, version)},
      {fmt::format("binaries/{}/{}.so", platform, kind.identifier), read_bytes(shared_library)}};
  for (const FmuResource& resource : resources)
    entries.push_back({"resources/" + resource.name, read_bytes(resource.file)});
  write_zip(path, entries);
}

}  // namespace orthodrive::io
