// SPDX-License-Identifier: Apache-2.0
// The C functions of FMI 3.0 (Functional Mock-up Interface Specification 3.0, ch. 2 and 4) for co-simulation.
// Signatures are those of the standard. What belongs to other kinds of FMUs, or to capabilities that the
// modelDescription denies, must exist and returns fmi3Error.

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>

#include "fmu/instance.hpp"

#define FMI3_EXPORT extern "C" __attribute__((visibility("default")))

namespace {

using fmu::Instance;
using fmu::Type;

using Reference = unsigned;  // fmi3ValueReference
enum Status : int { ok, warning, discard, error, fatal };
using LogMessage = void (*)(void* environment, int status, const char* category, const char* message);

Instance* self(void* instance) { return static_cast<Instance*>(instance); }
Status status(bool good) { return good ? ok : error; }

template <typename T>
Status get(void* instance, Type type, const Reference* references, std::size_t count, T* values, std::size_t n) {
  if (instance == nullptr) return error;
  if (n != count)
    return status(self(instance)->refuse("as many values as variables are expected: there are no arrays"));
  return status(self(instance)->get(type, references, count, values));
}
template <typename T>
Status set(void* instance, Type type, const Reference* references, std::size_t count, const T* values, std::size_t n) {
  if (instance == nullptr) return error;
  if (n != count)
    return status(self(instance)->refuse("as many values as variables are expected: there are no arrays"));
  return status(self(instance)->set(type, references, count, values));
}
/// Of types that no variable has, no variables is a fair question.
Status none_of_type(void* instance, std::size_t count) {
  if (instance == nullptr) return error;
  return status(count == 0 || self(instance)->refuse("no variable has this type"));
}
Status not_offered(void* instance, const char* function) {
  if (instance == nullptr) return error;
  return status(self(instance)->refuse(std::string(function) + " is not offered: see the modelDescription"));
}

}  // namespace

FMI3_EXPORT const char* fmi3GetVersion() { return "3.0"; }

FMI3_EXPORT int fmi3SetDebugLogging(void* instance, bool, std::size_t, const char* const*) {
  return instance != nullptr ? ok : error;  // errors are always told, there is nothing else to tell
}

FMI3_EXPORT void* fmi3InstantiateCoSimulation(const char* name, const char* token, const char* resources, bool, bool,
                                              bool, bool, const Reference*, std::size_t, void* environment,
                                              LogMessage log, void*) {
  const auto tell = [environment, log](const std::string& what) {
    if (log != nullptr) log(environment, error, "logStatusError", what.c_str());
  };
  try {
    if (name == nullptr || token == nullptr || fmu::instantiation_token(fmu::this_model()) != token) {
      tell("the instantiation token is not that of this FMU");
      return nullptr;
    }
    return new Instance(resources == nullptr ? "" : resources, tell);
  } catch (...) {
    return nullptr;
  }
}

FMI3_EXPORT void* fmi3InstantiateModelExchange(const char*, const char*, const char*, bool, bool, void*, LogMessage) {
  return nullptr;
}
FMI3_EXPORT void* fmi3InstantiateScheduledExecution(const char*, const char*, const char*, bool, bool, void*,
                                                    LogMessage, void*, void*, void*) {
  return nullptr;
}
FMI3_EXPORT void fmi3FreeInstance(void* instance) { delete self(instance); }

FMI3_EXPORT int fmi3EnterInitializationMode(void* instance, bool, double, double start_time, bool, double) {
  if (instance == nullptr || !std::isfinite(start_time)) return error;
  self(instance)->set_start_time(start_time);
  return status(self(instance)->enter_initialization());
}
FMI3_EXPORT int fmi3ExitInitializationMode(void* instance) {
  return status(instance != nullptr && self(instance)->exit_initialization());
}
FMI3_EXPORT int fmi3Terminate(void* instance) { return status(instance != nullptr && self(instance)->terminate()); }
FMI3_EXPORT int fmi3Reset(void* instance) { return status(instance != nullptr && self(instance)->reset()); }

FMI3_EXPORT int fmi3DoStep(void* instance, double time, double step, bool, bool* event_needed, bool* terminate,
                           bool* early_return, double* last_time) {
  if (instance == nullptr) return error;
  if (event_needed != nullptr) *event_needed = false;
  if (terminate != nullptr) *terminate = false;
  if (early_return != nullptr) *early_return = false;
  const bool good = self(instance)->step(time, step);
  if (last_time != nullptr) *last_time = self(instance)->time();
  return status(good);
}

FMI3_EXPORT int fmi3GetFloat64(void* i, const Reference* r, std::size_t c, double* v, std::size_t n) {
  return get(i, Type::float64, r, c, v, n);
}
FMI3_EXPORT int fmi3SetFloat64(void* i, const Reference* r, std::size_t c, const double* v, std::size_t n) {
  return set(i, Type::float64, r, c, v, n);
}
FMI3_EXPORT int fmi3GetInt32(void* i, const Reference* r, std::size_t c, std::int32_t* v, std::size_t n) {
  return get(i, Type::int32, r, c, v, n);
}
FMI3_EXPORT int fmi3SetInt32(void* i, const Reference* r, std::size_t c, const std::int32_t* v, std::size_t n) {
  return set(i, Type::int32, r, c, v, n);
}
FMI3_EXPORT int fmi3GetBoolean(void* i, const Reference* r, std::size_t c, bool* v, std::size_t n) {
  return get(i, Type::boolean, r, c, v, n);
}
FMI3_EXPORT int fmi3SetBoolean(void* i, const Reference* r, std::size_t c, const bool* v, std::size_t n) {
  return set(i, Type::boolean, r, c, v, n);
}
FMI3_EXPORT int fmi3GetString(void* i, const Reference* r, std::size_t c, const char** v, std::size_t n) {
  return status(i != nullptr && n == c && self(i)->get_text(r, c, v));
}
FMI3_EXPORT int fmi3SetString(void* i, const Reference* r, std::size_t c, const char* const* v, std::size_t n) {
  return status(i != nullptr && n == c && self(i)->set_text(r, c, v));
}

// Types that no variable has.
#define FMI3_NO_TYPE(NAME, T)                                                                      \
  FMI3_EXPORT int fmi3Get##NAME(void* i, const Reference*, std::size_t c, T*, std::size_t) {       \
    return none_of_type(i, c);                                                                     \
  }                                                                                                \
  FMI3_EXPORT int fmi3Set##NAME(void* i, const Reference*, std::size_t c, const T*, std::size_t) { \
    return none_of_type(i, c);                                                                     \
  }
FMI3_NO_TYPE(Float32, float)
FMI3_NO_TYPE(Int8, std::int8_t)
FMI3_NO_TYPE(UInt8, std::uint8_t)
FMI3_NO_TYPE(Int16, std::int16_t)
FMI3_NO_TYPE(UInt16, std::uint16_t)
FMI3_NO_TYPE(UInt32, std::uint32_t)
FMI3_NO_TYPE(Int64, std::int64_t)
FMI3_NO_TYPE(UInt64, std::uint64_t)
FMI3_EXPORT int fmi3GetBinary(void* i, const Reference*, std::size_t c, std::size_t*, const std::uint8_t**,
                              std::size_t) {
  return none_of_type(i, c);
}
FMI3_EXPORT int fmi3SetBinary(void* i, const Reference*, std::size_t c, const std::size_t*, const std::uint8_t* const*,
                              std::size_t) {
  return none_of_type(i, c);
}
FMI3_EXPORT int fmi3GetClock(void* i, const Reference*, std::size_t c, bool*) { return none_of_type(i, c); }
FMI3_EXPORT int fmi3SetClock(void* i, const Reference*, std::size_t c, const bool*) { return none_of_type(i, c); }

// Capabilities that the modelDescription does not claim.
#define FMI3_NOT_OFFERED(NAME, ...) \
  FMI3_EXPORT int NAME(void* instance, __VA_ARGS__) { return not_offered(instance, #NAME); }
#define FMI3_NOT_OFFERED_PLAIN(NAME) \
  FMI3_EXPORT int NAME(void* instance) { return not_offered(instance, #NAME); }
using Refs = const Reference*;
using Size = std::size_t;
FMI3_NOT_OFFERED(fmi3GetNumberOfVariableDependencies, Reference, Size*)
FMI3_NOT_OFFERED(fmi3GetVariableDependencies, Reference, Size*, Reference*, Size*, int*, Size)
FMI3_NOT_OFFERED(fmi3GetFMUState, void**)
FMI3_NOT_OFFERED(fmi3SetFMUState, void*)
FMI3_NOT_OFFERED(fmi3FreeFMUState, void**)
FMI3_NOT_OFFERED(fmi3SerializedFMUStateSize, void*, Size*)
FMI3_NOT_OFFERED(fmi3SerializeFMUState, void*, std::uint8_t*, Size)
FMI3_NOT_OFFERED(fmi3DeserializeFMUState, const std::uint8_t*, Size, void**)
FMI3_NOT_OFFERED(fmi3GetDirectionalDerivative, Refs, Size, Refs, Size, const double*, Size, double*, Size)
FMI3_NOT_OFFERED(fmi3GetAdjointDerivative, Refs, Size, Refs, Size, const double*, Size, double*, Size)
FMI3_NOT_OFFERED(fmi3GetOutputDerivatives, Refs, Size, const std::int32_t*, double*, Size)
FMI3_NOT_OFFERED(fmi3GetIntervalDecimal, Refs, Size, double*, int*)
FMI3_NOT_OFFERED(fmi3GetIntervalFraction, Refs, Size, std::uint64_t*, std::uint64_t*, int*)
FMI3_NOT_OFFERED(fmi3GetShiftDecimal, Refs, Size, double*)
FMI3_NOT_OFFERED(fmi3GetShiftFraction, Refs, Size, std::uint64_t*, std::uint64_t*)
FMI3_NOT_OFFERED(fmi3SetIntervalDecimal, Refs, Size, const double*)
FMI3_NOT_OFFERED(fmi3SetIntervalFraction, Refs, Size, const std::uint64_t*, const std::uint64_t*)
FMI3_NOT_OFFERED(fmi3SetShiftDecimal, Refs, Size, const double*)
FMI3_NOT_OFFERED(fmi3SetShiftFraction, Refs, Size, const std::uint64_t*, const std::uint64_t*)
FMI3_NOT_OFFERED(fmi3UpdateDiscreteStates, bool*, bool*, bool*, bool*, bool*, double*)
FMI3_NOT_OFFERED(fmi3CompletedIntegratorStep, bool, bool*, bool*)
FMI3_NOT_OFFERED(fmi3SetTime, double)
FMI3_NOT_OFFERED(fmi3SetContinuousStates, const double*, Size)
FMI3_NOT_OFFERED(fmi3GetContinuousStateDerivatives, double*, Size)
FMI3_NOT_OFFERED(fmi3GetEventIndicators, double*, Size)
FMI3_NOT_OFFERED(fmi3GetContinuousStates, double*, Size)
FMI3_NOT_OFFERED(fmi3GetNominalsOfContinuousStates, double*, Size)
FMI3_NOT_OFFERED(fmi3GetNumberOfEventIndicators, Size*)
FMI3_NOT_OFFERED(fmi3GetNumberOfContinuousStates, Size*)
FMI3_NOT_OFFERED(fmi3ActivateModelPartition, Reference, double)
FMI3_NOT_OFFERED_PLAIN(fmi3EnterEventMode)
FMI3_NOT_OFFERED_PLAIN(fmi3EnterConfigurationMode)
FMI3_NOT_OFFERED_PLAIN(fmi3ExitConfigurationMode)
FMI3_NOT_OFFERED_PLAIN(fmi3EvaluateDiscreteStates)
FMI3_NOT_OFFERED_PLAIN(fmi3EnterContinuousTimeMode)
FMI3_NOT_OFFERED_PLAIN(fmi3EnterStepMode)
