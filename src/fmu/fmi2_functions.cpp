// SPDX-License-Identifier: Apache-2.0
// The C functions of FMI 2.0 (Functional Mock-up Interface 2.0.4, ch. 2 and 4) for co-simulation, over the same
// instances as those of FMI 3.0.

#include <cmath>
#include <cstddef>
#include <memory>

#include "fmu/instance.hpp"

#define FMI2_EXPORT extern "C" __attribute__((visibility("default")))

namespace {

using fmu::Instance;
using fmu::Type;

using Reference = unsigned;  // fmi2ValueReference
enum Status : int { ok, warning, discard, error, fatal, pending };
using Logger = void (*)(void* environment, const char* instance, int status, const char* category, const char* message,
                        ...);
/// fmi2CallbackFunctions; memory is our own.
struct Callbacks {
  Logger logger;
  void* (*allocate)(std::size_t, std::size_t);
  void (*free)(void*);
  void (*step_finished)(void*, int);
  void* environment;
};

Instance* self(void* instance) { return static_cast<Instance*>(instance); }
Status status(bool good) { return good ? ok : error; }
Status not_offered(void* instance, const char* function) {
  if (instance == nullptr) return error;
  return status(self(instance)->refuse(std::string(function) + " is not offered: see the modelDescription"));
}

/// file:///a%20b/resources or file:/a... -> /a b/resources
std::string path_of(const std::string& uri) {
  std::string rest = uri.rfind("file://", 0) == 0 ? uri.substr(7) : uri.rfind("file:", 0) == 0 ? uri.substr(5) : uri;
  if (!rest.empty() && rest[0] != '/') rest.erase(0, rest.find('/'));  // a host
  std::string path;
  const auto digit = [](char c) {
    return c >= '0' && c <= '9'   ? c - '0'
           : c >= 'a' && c <= 'f' ? c - 'a' + 10
           : c >= 'A' && c <= 'F' ? c - 'A' + 10
                                  : -1;
  };
  for (std::size_t i = 0; i < rest.size(); ++i) {
    const bool coded = rest[i] == '%' && i + 2 < rest.size() && digit(rest[i + 1]) >= 0 && digit(rest[i + 2]) >= 0;
    path += coded ? static_cast<char>(16 * digit(rest[i + 1]) + digit(rest[i + 2])) : rest[i];
    if (coded) i += 2;
  }
  return path;
}

}  // namespace

FMI2_EXPORT const char* fmi2GetTypesPlatform() { return "default"; }
FMI2_EXPORT const char* fmi2GetVersion() { return "2.0"; }
FMI2_EXPORT int fmi2SetDebugLogging(void* instance, int, std::size_t, const char* const*) {
  return instance != nullptr ? ok : error;
}

FMI2_EXPORT void* fmi2Instantiate(const char* name, int kind, const char* token, const char* resources,
                                  const Callbacks* callbacks, int, int) {
  try {
    const std::string who = name == nullptr ? "" : name;
    const Logger logger = callbacks == nullptr ? nullptr : callbacks->logger;
    void* environment = callbacks == nullptr ? nullptr : callbacks->environment;
    const auto tell = [=](const std::string& what) {
      if (logger != nullptr) logger(environment, who.c_str(), error, "logStatusError", "%s", what.c_str());
    };
    constexpr int co_simulation = 1;
    if (name == nullptr || token == nullptr || kind != co_simulation ||
        fmu::instantiation_token(fmu::this_model()) != token) {
      tell("the GUID is not that of this FMU, or another kind than co-simulation is wanted");
      return nullptr;
    }
    return new Instance(path_of(resources == nullptr ? "" : resources), tell);
  } catch (...) {
    return nullptr;
  }
}
FMI2_EXPORT void fmi2FreeInstance(void* instance) { delete self(instance); }

FMI2_EXPORT int fmi2SetupExperiment(void* instance, int, double, double start_time, int, double) {
  if (instance == nullptr || !std::isfinite(start_time)) return error;
  self(instance)->set_start_time(start_time);
  return ok;
}
FMI2_EXPORT int fmi2EnterInitializationMode(void* instance) {
  return status(instance != nullptr && self(instance)->enter_initialization());
}
FMI2_EXPORT int fmi2ExitInitializationMode(void* instance) {
  return status(instance != nullptr && self(instance)->exit_initialization());
}
FMI2_EXPORT int fmi2Terminate(void* instance) { return status(instance != nullptr && self(instance)->terminate()); }
FMI2_EXPORT int fmi2Reset(void* instance) { return status(instance != nullptr && self(instance)->reset()); }

FMI2_EXPORT int fmi2GetReal(void* i, const Reference* r, std::size_t n, double* v) {
  return status(i != nullptr && self(i)->get(Type::float64, r, n, v));
}
FMI2_EXPORT int fmi2GetInteger(void* i, const Reference* r, std::size_t n, int* v) {
  return status(i != nullptr && self(i)->get(Type::int32, r, n, v));
}
FMI2_EXPORT int fmi2GetBoolean(void* i, const Reference* r, std::size_t n, int* v) {
  return status(i != nullptr && self(i)->get(Type::boolean, r, n, v));
}
FMI2_EXPORT int fmi2GetString(void* i, const Reference* r, std::size_t n, const char** v) {
  return status(i != nullptr && self(i)->get_text(r, n, v));
}
FMI2_EXPORT int fmi2SetReal(void* i, const Reference* r, std::size_t n, const double* v) {
  return status(i != nullptr && self(i)->set(Type::float64, r, n, v));
}
FMI2_EXPORT int fmi2SetInteger(void* i, const Reference* r, std::size_t n, const int* v) {
  return status(i != nullptr && self(i)->set(Type::int32, r, n, v));
}
FMI2_EXPORT int fmi2SetBoolean(void* i, const Reference* r, std::size_t n, const int* v) {
  return status(i != nullptr && self(i)->set(Type::boolean, r, n, v));
}
FMI2_EXPORT int fmi2SetString(void* i, const Reference* r, std::size_t n, const char* const* v) {
  return status(i != nullptr && self(i)->set_text(r, n, v));
}

FMI2_EXPORT int fmi2DoStep(void* instance, double time, double step, int) {
  return status(instance != nullptr && self(instance)->step(time, step));
}
FMI2_EXPORT int fmi2CancelStep(void* instance) { return not_offered(instance, "fmi2CancelStep"); }

// Capabilities that the modelDescription does not claim.
#define FMI2_NOT_OFFERED(NAME, ...) \
  FMI2_EXPORT int NAME(void* instance, __VA_ARGS__) { return not_offered(instance, #NAME); }
using Refs = const Reference*;
using Size = std::size_t;
FMI2_NOT_OFFERED(fmi2GetFMUstate, void**)
FMI2_NOT_OFFERED(fmi2SetFMUstate, void*)
FMI2_NOT_OFFERED(fmi2FreeFMUstate, void**)
FMI2_NOT_OFFERED(fmi2SerializedFMUstateSize, void*, Size*)
FMI2_NOT_OFFERED(fmi2SerializeFMUstate, void*, char*, Size)
FMI2_NOT_OFFERED(fmi2DeSerializeFMUstate, const char*, Size, void**)
FMI2_NOT_OFFERED(fmi2GetDirectionalDerivative, Refs, Size, Refs, Size, const double*, double*)
FMI2_NOT_OFFERED(fmi2SetRealInputDerivatives, Refs, Size, const int*, const double*)
FMI2_NOT_OFFERED(fmi2GetRealOutputDerivatives, Refs, Size, const int*, double*)
FMI2_NOT_OFFERED(fmi2GetStatus, int, int*)
FMI2_NOT_OFFERED(fmi2GetRealStatus, int, double*)
FMI2_NOT_OFFERED(fmi2GetIntegerStatus, int, int*)
FMI2_NOT_OFFERED(fmi2GetBooleanStatus, int, int*)
FMI2_NOT_OFFERED(fmi2GetStringStatus, int, const char**)
