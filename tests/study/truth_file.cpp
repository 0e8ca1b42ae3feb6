#include "study/truth_file.h"

#include <gtest/gtest.h>

#include "piste/math/units.h"
#include "support/text_file.h"

namespace piste {
namespace {

using test::contains;
using test::message_of;
using test::TemporaryFolder;

std::string triad(const std::string& unit, const std::string& after) {
  return "{\"bias_" + unit + "\": [1, 2, 3], \"scale_ppm\": [10000, 0, -5000],\n" +
         "\"misalignment\": [[1, 0.01, 0], [0, 1, 0], [0, 0.02, 1]],\n" + "\"drift_before_" + unit +
         "\": [0.1, 0, 0], \"mean_before_" + unit + "\": [0, 0, -9],\n" + "\"drift_run_" + unit +
         "\": [0.2, 0, 0], \"run_mean_" + unit + "\": [0, 1, -8],\n" + "\"drift_after_" + unit + "\": " + after +
         ", \"mean_after_" + unit + "\": " + after + "}";
}

std::string truth(const std::string& gyro) {
  return "{\"imus\": {\"mt9a_1\": {\n\"gyro\": " + gyro + ",\n\"accel\": " + triad("m_s2", "[0, 0, 4]") + "}}}\n";
}

TEST(TruthFile, ErrorsAreInSiAndPhasesMayBeMissing) {
  const TemporaryFolder folder;
  const ImuTruth imu = read_truth(folder.write("truth.json", truth(triad("deg_s", "null"))), "mt9a_1");
  EXPECT_DOUBLE_EQ(imu.gyro.bias.y(), 2 / kDegreesPerRadian);
  EXPECT_DOUBLE_EQ(imu.gyro.run->drift.x(), 0.2 / kDegreesPerRadian);
  EXPECT_FALSE(imu.gyro.after);
  EXPECT_EQ(imu.accel.bias, Vector3d(1, 2, 3));
  EXPECT_EQ(imu.accel.scale, Vector3d(0.01, 0, -0.005));
  EXPECT_EQ(imu.accel.misalignment(2, 1), 0.02);
  EXPECT_EQ(imu.accel.before->signal, Vector3d(0, 0, -9));
  EXPECT_EQ(imu.accel.run->signal, Vector3d(0, 1, -8));
  EXPECT_EQ(imu.accel.after->drift.z(), 4);
}

TEST(TruthFile, WhatIsMissingIsNamed) {
  const TemporaryFolder folder;
  const std::string file = folder.write("truth.json", truth(triad("m_s2", "null")));
  EXPECT_TRUE(contains(message_of<DataError>([&] { read_truth(file, "mt9a_1"); }), "bias_deg_s"));
  EXPECT_TRUE(contains(message_of<DataError>([&] { read_truth(file, "mt9a_2"); }), "mt9a_2"));
  EXPECT_TRUE(contains(message_of<DataError>([&] { read_truth(folder / "none.json", "a"); }), "none.json"));
}

}  // namespace
}  // namespace piste
