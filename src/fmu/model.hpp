// SPDX-License-Identifier: Apache-2.0
#pragma once
// What an FMU of ours is made of: a table of variables, and a model that turns inputs into outputs. The C functions of
// FMI 2.0 and 3.0 (fmi2_functions, fmi3_functions) and the modelDescription.xml (io/opendrive/fmu_io) are made from the
// table.

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace fmu {

enum class Type { float64, int32, boolean, string };
enum class Causality { independent, parameter, input, output };

/// Its value reference is its place in the table. Float64 inputs and outputs are continuous, the others discrete,
/// parameters fixed before the initialization.
struct Variable {
  std::string name;  ///< structured, as wheel[2].load
  Type type = Type::float64;
  Causality causality = Causality::input;
  std::string unit;  ///< of units(); empty: none
  std::string description;
  double start = 0.0;                        ///< of parameters and inputs; booleans: 0 or 1
  std::vector<std::size_t> depends_on = {};  ///< of outputs: the inputs that they depend on at once
};

/// SI exponents of a unit's name, and its factor.
struct Unit {
  std::string name;
  int kg = 0, m = 0, s = 0, rad = 0;
  double factor = 1.0;
};
[[nodiscard]] const std::vector<Unit>& units();

/// By value reference; each variable uses the one of its type.
struct Values {
  std::vector<double> number;
  std::vector<std::string> text;
};

class Model {
 public:
  Model() = default;
  Model(const Model&) = delete;
  Model& operator=(const Model&) = delete;
  virtual ~Model() = default;

  /// Reads the files that the parameters name; an empty name is the default in `resources`. Throws std::exception with
  /// one clear line.
  virtual void start(const Values& values, const std::filesystem::path& resources) = 0;
  /// Outputs at the present time.
  virtual void evaluate(Values& values) = 0;
  /// Moves on to t_s (after the start of the simulation) with the present inputs.
  virtual void advance(const Values& values, double t_s) = 0;
};

struct ModelKind {
  std::string identifier;  ///< of the shared library and in the modelDescription
  std::string description;
  double internal_step_s = 0.0;  ///< 0: none
  double default_step_s = 0.001;
  std::vector<Variable> variables;  ///< the first is time
  std::unique_ptr<Model> (*make)() = nullptr;
};

/// The road under four tyres.
[[nodiscard]] const ModelKind& road_model();
/// A car on that road.
[[nodiscard]] const ModelKind& car_model();

/// Made from the table: an FMU whose description is another's is refused.
[[nodiscard]] std::string instantiation_token(const ModelKind& kind);
/// Start values of all variables.
[[nodiscard]] Values start_values(const ModelKind& kind);

}  // namespace fmu
