// SPDX-License-Identifier: Apache-2.0
// The C functions of the shared libraries, as a simulator loads them: what is allowed when, and errors with text.

#include <dlfcn.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "fmu/model.hpp"
#include "fmu/road_model.hpp"
#include "paths.hpp"

namespace fmu {
namespace {

using testing::HasSubstr;

constexpr int ok = 0, error = 3;

struct Log {
  std::vector<std::string> lines;
};
void keep_line(void* environment, int status, const char* category, const char* message) {
  EXPECT_EQ(status, error);
  EXPECT_STREQ(category, "logStatusError");
  static_cast<Log*>(environment)->lines.emplace_back(message);
}

class Library {
 public:
  explicit Library(const ModelKind& kind)
      : handle_(dlopen((std::string(FMU_FOLDER "/") + kind.identifier + ".so").c_str(), RTLD_NOW | RTLD_LOCAL)) {
    if (handle_ == nullptr) throw std::runtime_error(dlerror());
  }
  ~Library() { dlclose(handle_); }
  Library(const Library&) = delete;
  Library& operator=(const Library&) = delete;
  template <typename... Arguments>
  int call(const char* name, Arguments... arguments) const {
    return reinterpret_cast<int (*)(Arguments...)>(symbol(name))(arguments...);
  }
  [[nodiscard]] void* symbol(const char* name) const {
    void* found = dlsym(handle_, name);
    if (found == nullptr) throw std::runtime_error(std::string("no ") + name);
    return found;
  }

 private:
  void* handle_;
};

const std::string arc = orthodrive::paths::in_source("tests/roadquery/arc.xodr").string();

class RoadsFmu : public testing::Test {
 protected:
  void* instantiate(const std::string& token) {
    using Make = void* (*)(const char*, const char*, const char*, bool, bool, bool, bool, const unsigned*, std::size_t,
                           void*, decltype(&keep_line), void*);
    return reinterpret_cast<Make>(library.symbol("fmi3InstantiateCoSimulation"))(
        "roads", token.c_str(), "/nowhere", false, false, false, false, nullptr, 0, &log, keep_line, nullptr);
  }
  void SetUp() override {
    instance = instantiate(instantiation_token(road_model()));
    ASSERT_NE(instance, nullptr);
  }
  void TearDown() override {
    if (instance != nullptr) library.call("fmi3FreeInstance", instance);
  }
  int set_text(unsigned reference, const char* text) {
    return library.call<void*, const unsigned*, std::size_t, const char* const*, std::size_t>("fmi3SetString", instance,
                                                                                              &reference, 1, &text, 1);
  }
  int set(unsigned reference, double value, std::size_t values = 1) {
    return library.call<void*, const unsigned*, std::size_t, const double*, std::size_t>("fmi3SetFloat64", instance,
                                                                                         &reference, 1, &value, values);
  }
  int get(unsigned reference, double* value) {
    return library.call<void*, const unsigned*, std::size_t, double*, std::size_t>("fmi3GetFloat64", instance,
                                                                                   &reference, 1, value, 1);
  }
  int enter() {
    return library.call<void*, bool, double, double, bool, double>("fmi3EnterInitializationMode", instance, false, 0.0,
                                                                   0.0, false, 0.0);
  }
  int leave() { return library.call("fmi3ExitInitializationMode", instance); }
  int step(double t, double h) {
    bool event = true, end = true, early = true;
    double last = -1.0;
    const int status = library.call<void*, double, double, bool, bool*, bool*, bool*, double*>(
        "fmi3DoStep", instance, t, h, true, &event, &end, &early, &last);
    EXPECT_FALSE(event || end || early);
    return status;
  }
  unsigned reference_of(const std::string& name) const {
    for (unsigned i = 0; i < road_model().variables.size(); ++i)
      if (road_model().variables[i].name == name) return i;
    throw std::runtime_error("no variable " + name);
  }

  Library library{road_model()};
  Log log;
  void* instance = nullptr;
};

TEST_F(RoadsFmu, AnswersAtOnceAndFollowsItsInputs) {
  ASSERT_EQ(set_text(road_file_ref, arc.c_str()), ok);
  ASSERT_EQ(set(reference_of("tyre[2].z_guess"), 20.0), ok);
  ASSERT_EQ(enter(), ok);
  double z = 0.0, time = -1.0;
  EXPECT_EQ(get(reference_of("tyre[2].z"), &z), ok);  // (0, 0) is where the road begins
  EXPECT_NEAR(z, 20.0, 1e-3);
  ASSERT_EQ(leave(), ok);
  // Radius 98 at a quarter turn: s = 25 pi.
  ASSERT_EQ(set(reference_of("tyre[2].x"), 98.0 * std::sqrt(0.5)), ok);
  ASSERT_EQ(set(reference_of("tyre[2].y"), 100.0 - 98.0 * std::sqrt(0.5)), ok);
  ASSERT_EQ(step(0.0, 0.25), ok);
  EXPECT_EQ(get(reference_of("tyre[2].z"), &z), ok);
  EXPECT_NEAR(z, 20.0 + 0.02 * 25.0 * M_PI, 1e-3);
  EXPECT_EQ(get(time_ref, &time), ok);
  EXPECT_EQ(time, 0.25);
  EXPECT_EQ(library.call("fmi3Terminate", instance), ok);
  EXPECT_EQ(step(0.25, 0.25), error);
  EXPECT_EQ(library.call("fmi3Reset", instance), ok);
  EXPECT_EQ(enter(), ok);
  EXPECT_EQ(leave(), error);  // the parameter is at its start value again
  EXPECT_THAT(log.lines.back(), HasSubstr("no roads: set the parameter road_file"));
}

TEST_F(RoadsFmu, OfAnInputThatIsNoNumberSaysBadInput) {
  ASSERT_EQ(set_text(road_file_ref, arc.c_str()), ok);
  ASSERT_EQ(set(reference_of("tyre[1].x"), std::numeric_limits<double>::quiet_NaN()), ok);
  ASSERT_EQ(enter(), ok);
  ASSERT_EQ(leave(), ok);
  int status = 7;
  const unsigned reference = reference_of("tyre[1].status");
  ASSERT_EQ((library.call<void*, const unsigned*, std::size_t, int*, std::size_t>("fmi3GetInt32", instance, &reference,
                                                                                  1, &status, 1)),
            ok);
  EXPECT_EQ(status, -1);
}

TEST_F(RoadsFmu, RefusesWhatItsDescriptionDoesNotAllow) {
  EXPECT_EQ(instantiate("{0000}"), nullptr);
  EXPECT_THAT(log.lines.back(), HasSubstr("token"));
  EXPECT_EQ(step(0.0, 0.1), error);
  EXPECT_EQ(leave(), error);
  double z = 5.0;
  EXPECT_EQ(get(reference_of("tyre[1].z"), &z), error);
  EXPECT_EQ(set(reference_of("tyre[1].z"), 1.0), error);
  EXPECT_THAT(log.lines.back(), HasSubstr("tyre[1].z cannot be set"));
  EXPECT_EQ(set(header_offset_ref, 1.0), error);
  EXPECT_THAT(log.lines.back(), HasSubstr("another type"));
  EXPECT_EQ(set(100000, 1.0), error);
  EXPECT_EQ(set(reference_of("tyre[1].x"), 1.0, 2), error);
  EXPECT_EQ(set_text(road_file_ref, nullptr), error);
  ASSERT_EQ(set_text(road_file_ref, arc.c_str()), ok);
  ASSERT_EQ(enter(), ok);
  EXPECT_EQ(enter(), error);
  ASSERT_EQ(leave(), ok);
  EXPECT_EQ(set_text(road_file_ref, arc.c_str()), error);
  EXPECT_THAT(log.lines.back(), HasSubstr("before the end of the initialization mode"));
  EXPECT_EQ(step(0.0, -1.0), error);
  EXPECT_EQ(step(std::numeric_limits<double>::quiet_NaN(), 0.1), error);
  EXPECT_EQ(library.call("fmi3EnterEventMode", instance), error);
  EXPECT_THAT(log.lines.back(), HasSubstr("fmi3EnterEventMode is not offered"));
}

TEST_F(RoadsFmu, SurvivesNull) {
  EXPECT_EQ(library.call<void*>("fmi3ExitInitializationMode", nullptr), error);
  EXPECT_EQ((library.call<void*, const unsigned*, std::size_t, double*, std::size_t>("fmi3GetFloat64", nullptr, nullptr,
                                                                                     0, nullptr, 0)),
            error);
  EXPECT_EQ((library.call<void*, const unsigned*, std::size_t, double*, std::size_t>("fmi3GetFloat64", instance,
                                                                                     nullptr, 1, nullptr, 1)),
            error);
  library.call<void*>("fmi3FreeInstance", nullptr);
}

/// All functions that FMI 3.0 and 2.0 want of a co-simulation FMU are there, and nothing else.
TEST(Exports, AreThoseOfFmiAlone) {
  for (const ModelKind* kind : {&road_model(), &car_model()}) {
    const Library library(*kind);
    for (const char* name : {"fmi3GetVersion",
                             "fmi3SetDebugLogging",
                             "fmi3InstantiateModelExchange",
                             "fmi3InstantiateScheduledExecution",
                             "fmi3GetFloat32",
                             "fmi3SetUInt64",
                             "fmi3GetBinary",
                             "fmi3SetClock",
                             "fmi3GetFMUState",
                             "fmi3SerializeFMUState",
                             "fmi3GetDirectionalDerivative",
                             "fmi3GetAdjointDerivative",
                             "fmi3GetOutputDerivatives",
                             "fmi3EnterStepMode",
                             "fmi3UpdateDiscreteStates",
                             "fmi3ActivateModelPartition",
                             "fmi3GetShiftFraction",
                             "fmi2Instantiate",
                             "fmi2SetupExperiment",
                             "fmi2DoStep",
                             "fmi2CancelStep",
                             "fmi2GetStringStatus",
                             "fmi2GetTypesPlatform"})
      EXPECT_NO_THROW((void)library.symbol(name)) << name;
    EXPECT_THROW((void)library.symbol("XML_Parse"), std::runtime_error);
  }
}

}  // namespace
}  // namespace fmu
