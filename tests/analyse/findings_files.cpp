// findings.json says what was found, in the units that it names.

#include "piste/analyse/findings_files.h"

#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include "support/alignment_picture.h"
#include "support/text_file.h"

namespace piste {
namespace {

using test::contains;

Findings found_in(const test::PictureOfRun& plate, const test::AlignedRun& run, bool rest = true) {
  Phases phases{run.before(), run.moving(), run.after()};
  if (!rest) phases.before = phases.after = std::nullopt;
  return findings(plate.aligned, phases, {12, &plate.alignment, nullptr});
}

TEST(FindingsJson, HoldsTheAlignmentThePhasesAndEveryAxis) {
  const test::AlignedRun run{.rest = 10, .run = 30};
  const test::PictureOfRun plate(run);
  const Findings found = found_in(plate, run);
  const std::string text = findings_json(found, plate.alignment);
  EXPECT_EQ(text, findings_json(found, plate.alignment));
  const YAML::Node json = YAML::Load(text);
  EXPECT_DOUBLE_EQ(json["clock_offset_s"].as<double>(), 2.5);
  EXPECT_EQ(json["lever_arm_m"].size(), 3U);
  EXPECT_TRUE(contains(json["convention"].as<std::string>(), "measured = (1 + scale) true + bias"));
  EXPECT_DOUBLE_EQ(json["phases"]["run"][0].as<double>(), run.moving().start);
  EXPECT_DOUBLE_EQ(json["phases"]["after"][1].as<double>(), run.after().end);
  ASSERT_EQ(json["axes"].size(), 6U);
  for (std::size_t i = 0; i < 6; ++i) {
    const AxisFindings& a = found.axes[i];
    const YAML::Node axis = json["axes"][std::string(a.name)];
    const double factor = i < 3 ? 1 : kDegreesPerRadian;
    EXPECT_EQ(axis["unit"].as<std::string>(), i < 3 ? "m/s^2" : "deg/s");
    EXPECT_EQ(axis["scale_unit"].as<std::string>(), "ppm");
    const auto expect_term = [](const YAML::Node& node, const Term& term, double unit) {
      EXPECT_NEAR(node["value"].as<double>(), unit * term.value, 1e-8 * std::abs(unit * term.value));
      EXPECT_NEAR(node["sigma"].as<double>(), unit * term.sigma, 1e-8 * unit * term.sigma);
      EXPECT_NEAR(node["standard_error"].as<double>(), unit * term.standard_error, 1e-8 * unit * term.standard_error);
      EXPECT_NEAR(node["systematic"].as<double>(), unit * term.systematic, 1e-8 * unit * term.systematic);
      EXPECT_NEAR(node["p_value"].as<double>(), term.p_value(), 1e-5);
      EXPECT_GE(node["dof"].as<double>(), 1);
    };
    expect_term(axis["rest"]["before"], *a.before, factor);
    expect_term(axis["rest"]["after"], *a.after, factor);
    expect_term(axis["rest"]["change"], *a.change, factor);
    const YAML::Node node = axis["run"];
    EXPECT_EQ(node["samples"].as<int>(), a.run->samples);
    expect_term(node["bias_only"], a.run->bias_only, factor);
    const BiasScale& line = a.run->joint.forward;
    expect_term(node["joint"]["forward"]["bias"], line.bias(), factor);
    expect_term(node["joint"]["forward"]["scale"], line.scale(), 1e6);
    expect_term(node["joint"]["reverse"]["scale"], a.run->joint.reverse.scale(), 1e6);
    expect_term(node["scale_only"]["reverse"]["scale"], a.run->scale_only->reverse.scale(), 1e6);
    EXPECT_NEAR(node["joint"]["forward"]["correlation"].as<double>(), line.correlation(), 1e-5);
    EXPECT_NEAR(node["joint"]["forward"]["inflation"].as<double>(), line.inflation(), 1e-4 * line.inflation());
    EXPECT_NEAR(node["joint"]["forward"]["article"]["scale"].as<double>(), -1e6 * line.value(1) / (1 + line.value(1)),
                0.1);
    EXPECT_GT(a.run->joint.forward.scale().systematic, 0) << "of the alignment";
  }
}

TEST(FindingsJson, SaysNullWhereThereIsNothing) {
  const test::AlignedRun run{.rest = 10, .run = 30};
  const test::PictureOfRun plate(run);
  const YAML::Node json = YAML::Load(findings_json(found_in(plate, run, false), plate.alignment));
  EXPECT_TRUE(json["phases"]["before"].IsNull());
  EXPECT_TRUE(json["axes"]["wz"]["rest"]["change"].IsNull());
  EXPECT_TRUE(json["axes"]["wz"]["run"]["scale_only"].IsNull());
  EXPECT_FALSE(json["axes"]["wz"]["run"]["joint"].IsNull());
}

TEST(FindingsText, IsATable) {
  const test::AlignedRun run{.rest = 10, .run = 30};
  const test::PictureOfRun plate(run);
  const std::string text = findings_text(found_in(plate, run));
  for (const char* part : {"rest 1000.0 to 1010.0 s, run 1010.0 to 1040.0 s, rest 1040.0 to 1050.0 s", "fx m/s^2",
                           "wz deg/s", "run: scale [ppm]", " ± "}) {
    EXPECT_TRUE(contains(text, part)) << part;
  }
  EXPECT_TRUE(contains(findings_text(found_in(plate, run, false)), "no rest, run 1010.0 to 1040.0 s, no rest"));
}

}  // namespace
}  // namespace piste
