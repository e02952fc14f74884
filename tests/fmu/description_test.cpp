// SPDX-License-Identifier: Apache-2.0
// The modelDescription.xml: valid against the schema of FMI, and in step with the tables.

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <set>

#include "app/run_tool.hpp"
#include "orthodrive/io/opendrive/fmu_io.hpp"
#include "paths.hpp"

namespace orthodrive {
namespace {

namespace fs = std::filesystem;

class Description : public testing::TestWithParam<const fmu::ModelKind* (*)()> {
 protected:
  [[nodiscard]] const fmu::ModelKind& kind() const { return *GetParam()(); }
};

TEST_P(Description, IsValidAgainstTheSchema) {
  const fs::path schema = fs::weakly_canonical(paths::in_source("../shared/data/fmi/fmi3ModelDescription.xsd"));
  if (!fs::exists(schema)) GTEST_SKIP() << "NOT TESTED: no FMI schema at " << schema;
  const fs::path file = fs::path(testing::TempDir()) / (kind().identifier + ".xml");
  std::ofstream(file) << io::model_description(kind(), 3);
  const ToolRun run = run_program({"/usr/bin/xmllint", "--noout", "--schema", schema.string(), file.string()});
  EXPECT_EQ(run.exit_code, 0) << run.err.substr(0, 2000);
  // The check can fail.
  std::string text = io::model_description(kind(), 3);
  text.replace(text.find("valueReference"), 14, "valueReferenze");
  std::ofstream(file) << text;
  EXPECT_NE(run_program({"/usr/bin/xmllint", "--noout", "--schema", schema.string(), file.string()}).exit_code, 0);
}

TEST_P(Description, NamesEveryVariableOnceAndItsUnit) {
  std::set<std::string> names, units = {""};
  for (const fmu::Unit& unit : fmu::units()) units.insert(unit.name);
  for (const fmu::Variable& variable : kind().variables) {
    EXPECT_TRUE(names.insert(variable.name).second) << variable.name;
    EXPECT_TRUE(units.contains(variable.unit)) << variable.unit;
    EXPECT_FALSE(variable.description.empty()) << variable.name;
    for (const std::size_t input : variable.depends_on)
      EXPECT_EQ(kind().variables.at(input).causality, fmu::Causality::input) << variable.name;
    for (const int version : {2, 3})
      EXPECT_NE(io::model_description(kind(), version).find("name=\"" + variable.name + "\""), std::string::npos);
  }
  EXPECT_EQ(kind().variables[0].causality, fmu::Causality::independent);
}

TEST_P(Description, CarriesTheTokenOfItsTable) {
  const std::string token = fmu::instantiation_token(kind());
  EXPECT_EQ(token.size(), 34u);
  EXPECT_NE(io::model_description(kind(), 3).find(token), std::string::npos);
  EXPECT_NE(io::model_description(kind(), 2).find(token), std::string::npos);
  fmu::ModelKind changed = kind();
  changed.variables.back().name += 'x';
  EXPECT_NE(fmu::instantiation_token(changed), token);
}

INSTANTIATE_TEST_SUITE_P(Models, Description,
                         testing::Values([] { return &fmu::road_model(); }, [] { return &fmu::car_model(); }),
                         [](const auto& info) { return info.index == 0 ? "roads" : "car"; });

}  // namespace
}  // namespace orthodrive
