// SPDX-License-Identifier: Apache-2.0
#pragma once
// One instance of an FMU: values, the model behind them, and the order in which things may happen. The same for FMI 2.0
// and 3.0.

#include <functional>
#include <string>

#include "fmu/model.hpp"

namespace fmu {

/// The model of this shared library.
[[nodiscard]] const ModelKind& this_model();

class Instance {
 public:
  /// `log` gets what is wrong, one line.
  Instance(std::filesystem::path resources, std::function<void(const std::string&)> log);

  // All return false after the log has said why.
  bool enter_initialization();
  bool exit_initialization();
  bool terminate();
  bool reset();
  /// From t_s to t_s + step_s, in seconds of the simulation that began at start_time().
  bool step(double t_s, double step_s);
  void set_start_time(double t_s) { start_time_s_ = t_s; }
  [[nodiscard]] double time() const { return values_.number[0]; }

  /// Variables of one type. Outputs are evaluated first.
  template <typename T>
  bool get(Type type, const unsigned* references, std::size_t count, T* values) {
    return each(type, references, count, values != nullptr, Access::get,
                [&](std::size_t i, std::size_t reference) { values[i] = static_cast<T>(values_.number[reference]); });
  }
  template <typename T>
  bool set(Type type, const unsigned* references, std::size_t count, const T* values) {
    return each(type, references, count, values != nullptr, Access::set, [&](std::size_t i, std::size_t reference) {
      values_.number[reference] = static_cast<double>(values[i]);
    });
  }
  /// Texts stay valid until the next call.
  bool get_text(const unsigned* references, std::size_t count, const char** values);
  bool set_text(const unsigned* references, std::size_t count, const char* const* values);

  /// Says that a call is not possible; returns false.
  bool refuse(const std::string& why);

 private:
  enum class Phase { instantiated, initializing, stepping, terminated, failed };
  enum class Access { get, set };
  bool each(Type type, const unsigned* references, std::size_t count, bool has_values, Access access,
            const std::function<void(std::size_t, std::size_t)>& visit);
  bool may(Type type, std::size_t reference, Access access);
  bool guarded(const std::function<void()>& work);
  /// Starts the model when a parameter is new, evaluates it when an input is.
  bool refresh();

  std::filesystem::path resources_;
  std::function<void(const std::string&)> log_;
  Phase phase_ = Phase::instantiated;
  Values values_;
  std::unique_ptr<Model> model_;
  bool started_ = false, evaluated_ = false;
  double start_time_s_ = 0.0;
};

}  // namespace fmu
