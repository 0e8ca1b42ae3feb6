// alignment.json says what was found, in its units, and null of what the motion did not tell.

#include "piste/files/alignment.h"

#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <limits>

#include "piste/math/units.h"
#include "piste/report/alignment_text.h"
#include "support/text_file.h"

namespace piste::test {
namespace {

using Layout = AlignmentLayout;

Alignment found() {
  Alignment a;
  a.clock_offset = 12.3456789;
  a.clock_drift = -25e-6;
  a.q_rb = from_euler(kDegree * Vector3d(1, -2, 90));
  a.p_rb_r = {0.06, -0.05, 0.03};
  a.gyro_bias = kDegree * Vector3d(0.5, 0, -0.25);
  a.accel_scale = {0.01, -0.02, 0};
  a.covariance.setZero();
  a.covariance.diagonal().setConstant(1e-8);
  return a;
}

TEST(AlignmentFiles, SaysWhatWasFoundInItsUnits) {
  const YAML::Node json = YAML::Load(alignment_json(found()));
  EXPECT_EQ(json["clock_offset_s"].as<double>(), 12.3456789);
  EXPECT_NEAR(json["sigma_clock_offset_s"].as<double>(), 1e-4, 1e-12);
  EXPECT_NEAR(json["clock_drift_ppm"].as<double>(), -25, 1e-9);
  EXPECT_NEAR(json["sigma_clock_drift_ppm"].as<double>(), 100, 1e-9);
  EXPECT_NEAR(json["boresight_deg"][1].as<double>(), -2, 1e-9);
  EXPECT_NEAR(json["boresight_deg"][2].as<double>(), 90, 1e-9);
  // All rotations are known alike, but roll and heading turn with a pitch that is not zero.
  EXPECT_NEAR(json["sigma_boresight_deg"][1].as<double>(), 1e-4 * kDegreesPerRadian, 1e-9);
  EXPECT_EQ(json["lever_arm_m"][1].as<double>(), -0.05);
  EXPECT_NEAR(json["gyro_bias_deg_s"][2].as<double>(), -0.25, 1e-9);
  EXPECT_NEAR(json["accel_scale_ppm"][1].as<double>(), -20000, 1e-6);
  EXPECT_EQ(json["undetermined"].size(), 0U);
}

TEST(AlignmentFiles, WhatIsNotDeterminedIsNull) {
  Alignment a = found();
  const double infinite = std::numeric_limits<double>::infinity();
  a.covariance(Layout::kBoresight + 2, Layout::kBoresight + 2) = infinite;  // about r's down axis: the heading
  a.covariance(Layout::kLeverArm + 2, Layout::kLeverArm + 2) = infinite;
  a.undetermined = {"boresight z", "lever arm z"};
  const YAML::Node json = YAML::Load(alignment_json(a));
  EXPECT_TRUE(json["boresight_deg"][2].IsNull());
  EXPECT_TRUE(json["sigma_boresight_deg"][2].IsNull());
  EXPECT_NEAR(json["boresight_deg"][1].as<double>(), -2, 1e-9);
  EXPECT_TRUE(json["lever_arm_m"][2].IsNull());
  EXPECT_EQ(json["lever_arm_m"][0].as<double>(), 0.06);
  EXPECT_EQ(json["undetermined"][1].as<std::string>(), "lever arm z");
  EXPECT_TRUE(std::isinf(a.boresight_sigma().z()));
  EXPECT_TRUE(contains(alignment_text(a), "not determined"));
  EXPECT_TRUE(contains(alignment_text(a), "boresight z, lever arm z"));
}

TEST(AlignmentFiles, AlignedCsvNamesItsUnits) {
  AlignedImus imus;
  imus.time = {302400.01};
  imus.gyro = {Vector3d(kDegree, 0, 0)};
  imus.reference_gyro = {Vector3d(0, 2 * kDegree, 0)};
  imus.accel = {Vector3d(0, 0, -9.8)};
  imus.reference_accel = {Vector3d(0, 0, -9.81)};
  imus.usable = {1};
  EXPECT_EQ(aligned_csv(imus),
            "time_s,gyro_x_deg_s,gyro_y_deg_s,gyro_z_deg_s,accel_x_m_s2,accel_y_m_s2,accel_z_m_s2,"
            "reference_gyro_x_deg_s,reference_gyro_y_deg_s,reference_gyro_z_deg_s,"
            "reference_accel_x_m_s2,reference_accel_y_m_s2,reference_accel_z_m_s2,usable\n"
            "302400.010000,1.000000,0.000000,0.000000,0.000000,0.000000,-9.800000,"
            "0.000000,2.000000,0.000000,0.000000,0.000000,-9.810000,1\n");
}

}  // namespace
}  // namespace piste::test
