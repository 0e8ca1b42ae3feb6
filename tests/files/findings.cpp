// findings.json says what was found, in the units that it names.

#include "piste/files/findings.h"

#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <cmath>

#include "piste/condition/aligned_signals.h"
#include "piste/math/units.h"
#include "piste/report/findings_text.h"
#include "support/alignment_picture.h"
#include "support/text_file.h"

namespace piste {
namespace {

using test::contains;

Findings found_in(const test::PictureOfRun& plate, const test::AlignedRun& run, bool rest = true) {
  Phases phases{run.before(), run.moving(), run.after()};
  if (!rest) phases.before = phases.after = std::nullopt;
  return findings(low_passed(plate.aligned, 12), phases, {&plate.alignment, nullptr});
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
    expect_term(node["both_noisy"]["scale"], a.run->both_noisy.scale(), 1e6);
    EXPECT_NEAR(node["noise_ratio"].as<double>(), a.run->noise_ratio, 1e-5 * a.run->noise_ratio);
    const PolynomialFit& polynomial = *a.run->polynomial;
    EXPECT_EQ(node["polynomial"]["order"].as<int>(), polynomial.order);
    ASSERT_EQ(node["polynomial"]["coefficients"].size(), static_cast<std::size_t>(polynomial.order) + 1);
    for (int j = 0; j <= polynomial.order; ++j) {
      expect_term(node["polynomial"]["coefficients"][j], polynomial.coefficients.term(j), std::pow(factor, 1 - j));
    }
    EXPECT_NEAR(node["polynomial"]["bic"][2].as<double>(), polynomial.bic[2], 1e-5 * std::abs(polynomial.bic[2]));
    expect_term(node["polynomial"]["tangent"]["bias"], polynomial.tangent.bias(), factor);
    const int k = static_cast<int>(i % 3);
    const YAML::Node triad = json["matrix"][i < 3 ? "accel" : "gyro"];
    const YAML::Node row = triad[std::string(1, "xyz"[k])];
    const MatrixFit& matrix = i < 3 ? *found.accel_matrix : *found.gyro_matrix;
    EXPECT_EQ(triad["gain_unit"].as<std::string>(), "ppm");
    expect_term(row["bias"], matrix.bias(k), factor);
    for (int of = 0; of < 3; ++of) {
      expect_term(row["gain"][of], matrix.gain(k, of), 1e6);
      if (i >= 3) expect_term(row["g_sensitivity"][of], matrix.g_sensitivity(k, of), factor);
    }
    EXPECT_EQ(row["inflation"].size(), i < 3 ? 4U : 7U);
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
  Findings without = found_in(plate, run);
  without.gyro_matrix.reset();
  without.axes[5].run->polynomial.reset();
  const YAML::Node less = YAML::Load(findings_json(without, plate.alignment));
  EXPECT_TRUE(less["matrix"]["gyro"].IsNull());
  EXPECT_TRUE(less["axes"]["wz"]["run"]["polynomial"].IsNull());
  EXPECT_FALSE(contains(findings_text(without), "gyro x"));
}

TEST(FindingsText, IsATable) {
  const test::AlignedRun run{.rest = 10, .run = 30};
  const test::PictureOfRun plate(run);
  const std::string text = findings_text(found_in(plate, run));
  for (const char* part :
       {"rest 1000.0 to 1010.0 s, run 1010.0 to 1040.0 s, rest 1040.0 to 1050.0 s", "fx m/s^2", "wz deg/s",
        "run: scale [ppm]", "both noisy", " ± ", "gain on y [ppm]", "on fz [deg/s/(m/s^2)]", "gyro z"}) {
    EXPECT_TRUE(contains(text, part)) << part;
  }
  EXPECT_TRUE(contains(findings_text(found_in(plate, run, false)), "no rest, run 1010.0 to 1040.0 s, no rest"));
}

}  // namespace
}  // namespace piste
