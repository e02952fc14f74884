// SPDX-License-Identifier: Apache-2.0
#include "fmu/instance.hpp"

#include <cmath>
#include <exception>

namespace fmu {

Instance::Instance(std::filesystem::path resources, std::function<void(const std::string&)> log)
    : resources_(std::move(resources)),
      log_(std::move(log)),
      values_(start_values(this_model())),
      model_(this_model().make()) {}

bool Instance::refuse(const std::string& why) {
  if (log_) log_(why);
  return false;
}

bool Instance::guarded(const std::function<void()>& work) {
  try {
    work();
    return true;
  } catch (const std::exception& error) {
    phase_ = Phase::failed;
    return refuse(error.what());
  } catch (...) {
    phase_ = Phase::failed;
    return refuse("internal error");
  }
}

bool Instance::refresh() {
  return guarded([&] {
    if (!started_) model_->start(values_, resources_);
    started_ = true;
    if (!evaluated_) model_->evaluate(values_);
    evaluated_ = true;
  });
}

bool Instance::enter_initialization() {
  if (phase_ != Phase::instantiated) return refuse("the initialization mode follows the instantiation");
  phase_ = Phase::initializing;
  values_.number[0] = start_time_s_;
  return true;
}

bool Instance::exit_initialization() {
  if (phase_ != Phase::initializing) return refuse("not in the initialization mode");
  if (!refresh()) return false;
  phase_ = Phase::stepping;
  return true;
}

bool Instance::terminate() {
  if (phase_ != Phase::stepping) return refuse("not in the step mode");
  phase_ = Phase::terminated;
  return true;
}

bool Instance::reset() {
  return guarded([&] {
    values_ = start_values(this_model());
    model_ = this_model().make();
    started_ = evaluated_ = false;
    phase_ = Phase::instantiated;
  });
}

bool Instance::step(double t_s, double step_s) {
  if (phase_ != Phase::stepping) return refuse("a step needs the step mode");
  if (!std::isfinite(t_s) || !(step_s >= 0.0) || !std::isfinite(step_s)) return refuse("a step needs a finite time");
  return guarded([&] {
    model_->advance(values_, t_s + step_s - start_time_s_);
    values_.number[0] = t_s + step_s;
    evaluated_ = false;
  });
}

bool Instance::may(Type type, std::size_t reference, Access access) {
  const std::vector<Variable>& all = this_model().variables;
  if (reference >= all.size()) return refuse("there is no variable " + std::to_string(reference));
  const Variable& variable = all[reference];
  if (variable.type != type) return refuse(variable.name + " has another type");
  if (access == Access::get) return true;
  if (variable.causality == Causality::output || variable.causality == Causality::independent)
    return refuse(variable.name + " cannot be set");
  const bool before_steps = phase_ == Phase::instantiated || phase_ == Phase::initializing;
  if (variable.causality == Causality::parameter && !before_steps)
    return refuse(variable.name + " can be set before the end of the initialization mode only");
  return phase_ != Phase::failed || refuse("after an error the FMU must be reset");
}

bool Instance::each(Type type, const unsigned* references, std::size_t count, bool has_values, Access access,
                    const std::function<void(std::size_t, std::size_t)>& visit) {
  if (count > 0 && (references == nullptr || !has_values)) return refuse("no place for values given");
  bool outputs = false;
  for (std::size_t i = 0; i < count; ++i) {
    if (!may(type, references[i], access)) return false;
    outputs = outputs || this_model().variables[references[i]].causality == Causality::output;
  }
  if (access == Access::get && outputs) {
    if (phase_ == Phase::instantiated) return refuse("outputs are there from the initialization mode on");
    if (phase_ != Phase::failed && !refresh()) return false;
    if (phase_ == Phase::failed) return refuse("after an error the FMU must be reset");
  }
  for (std::size_t i = 0; i < count; ++i) {
    visit(i, references[i]);
    if (access == Access::get) continue;
    evaluated_ = false;
    if (this_model().variables[references[i]].causality == Causality::parameter) started_ = false;
  }
  return true;
}

bool Instance::get_text(const unsigned* references, std::size_t count, const char** values) {
  return each(Type::string, references, count, values != nullptr, Access::get,
              [&](std::size_t i, std::size_t reference) { values[i] = values_.text[reference].c_str(); });
}

bool Instance::set_text(const unsigned* references, std::size_t count, const char* const* values) {
  for (std::size_t i = 0; values != nullptr && i < count; ++i)
    if (values[i] == nullptr) return refuse("a text is NULL");
  return each(Type::string, references, count, values != nullptr, Access::set,
              [&](std::size_t i, std::size_t reference) { values_.text[reference] = values[i]; });
}

}  // namespace fmu
