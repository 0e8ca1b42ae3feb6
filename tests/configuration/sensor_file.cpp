#include "piste/configuration/sensor_file.h"

#include <gtest/gtest.h>

#include <cstdlib>

#include "piste/core/error.h"
#include "piste/math/earth.h"
#include "piste/math/units.h"
#include "support/places.h"
#include "support/text_file.h"

namespace piste {
namespace {

using test::contains;
using test::message_of;
using test::TemporaryFolder;

constexpr const char* kWholeSensor =
    "name: Xsens MT-9A\n"
    "gyro:\n"
    "  noise: 0.05 deg/s/sqrt(Hz)\n"
    "  bias: 0.5 deg/s\n"
    "  drift: {process: gauss_markov, sigma: 0.01 deg/s, correlation_time: 200 s}\n"
    "  scale: 10000 ppm\n"
    "  cross_axis: 3000 ppm\n"
    "  g_sensitivity: 0.1 deg/s/g\n"
    "  range: 300 deg/s\n"
    "accel: {noise: 200 ug/sqrt(Hz), bias: 0.05 m/s^2, drift: {process: random_walk, density: 4e-5 m/s^3/sqrt(Hz)}}\n";

TEST(SensorFile, ReadsAndWritesBack) {
  const TemporaryFolder folder;
  const ImuSensor sensor = read_sensor(folder.write("s.yaml", kWholeSensor));
  EXPECT_EQ(sensor.name, "Xsens MT-9A");
  EXPECT_DOUBLE_EQ(sensor.gyro.noise, 0.05 * kDegree);
  EXPECT_EQ(sensor.gyro.drift.kind, DriftProcess::Kind::kGaussMarkov);
  EXPECT_EQ(sensor.gyro.drift.correlation_time, 200);
  EXPECT_DOUBLE_EQ(sensor.gyro.scale, 0.01);
  EXPECT_DOUBLE_EQ(sensor.gyro.cross_axis.value(), 0.003);
  EXPECT_DOUBLE_EQ(sensor.gyro_g_sensitivity.value(), 0.1 * kDegree / kStandardGravity);
  EXPECT_FALSE(sensor.accel.cross_axis);
  EXPECT_EQ(sensor.accel.scale, 0);
  EXPECT_EQ(sensor.accel.range, 0);
  EXPECT_EQ(sensor.accel.drift.density, 4e-5);

  const ImuSensor again = read_sensor(folder.write("again.yaml", sensor_text(sensor)));
  EXPECT_EQ(again.name, sensor.name);
  EXPECT_EQ(again.gyro.noise, sensor.gyro.noise);
  EXPECT_EQ(again.gyro.drift.sigma, sensor.gyro.drift.sigma);
  EXPECT_EQ(again.gyro.range, sensor.gyro.range);
  EXPECT_EQ(again.gyro.cross_axis, sensor.gyro.cross_axis);
  EXPECT_EQ(again.gyro_g_sensitivity, sensor.gyro_g_sensitivity);
  EXPECT_EQ(again.accel.noise, sensor.accel.noise);
  EXPECT_EQ(again.accel.drift.density, sensor.accel.drift.density);
}

TEST(SensorFile, RefusesWhatDoesNotFitTheProcess) {
  const TemporaryFolder folder;
  const auto refusal = [&](const std::string& drift) {
    const std::string file = folder.write("s.yaml", "name: x\ngyro:\n  noise: 1 deg/s/sqrt(Hz)\n  drift: {" + drift +
                                                        "}\naccel: {noise: 1 ug/sqrt(Hz)}\n");
    return message_of<ConfigError>([&] { read_sensor(file); });
  };
  EXPECT_TRUE(
      contains(refusal("process: walk"), "s.yaml:4: process: `walk` is none of: none, random_walk, gauss_markov"));
  EXPECT_TRUE(contains(refusal("process: none, sigma: 1 deg/s"), "s.yaml:4: unknown key `sigma`"));
  EXPECT_TRUE(contains(refusal("process: random_walk, density: 1 deg/s"), "a random walk of angular rate"));
  EXPECT_TRUE(contains(refusal("process: gauss_markov, sigma: 1 deg/s, correlation_time: 0 s"), "above zero"));
}

// What is installed is found by name; a file beside the configuration goes before it.
TEST(SensorFile, IsFoundByName) {
  ASSERT_EQ(setenv("PISTE_SHARE", (test::kSource / "config").c_str(), 1), 0);
  const TemporaryFolder folder;
  const auto found = [&](const std::string& text) {
    return sensor_file(Config::parse("sensor: " + text + "\n", folder.path() / "run.yaml"), "sensor");
  };
  EXPECT_EQ(found("ln200"), test::kSource / "config/sensors/ln200.yaml");
  const std::string message = message_of<ConfigError>([&] { found("ln2000"); });
  EXPECT_TRUE(contains(message, "run.yaml:1: sensor: there is no file")) << message;
  EXPECT_TRUE(contains(message, "there are: ln200, ")) << message;
  folder.write("ln200", kWholeSensor);
  EXPECT_EQ(found("ln200"), folder.path() / "ln200");
  EXPECT_TRUE(contains(message_of<ConfigError>([&] { found("sensors/ln200.yaml"); }), "relative to the folder of"));
  unsetenv("PISTE_SHARE");
}

}  // namespace
}  // namespace piste
