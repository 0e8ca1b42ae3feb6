#include "piste/core/options.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "piste/core/error.h"
#include "piste/core/state_table.h"
#include "support/text_file.h"

namespace piste {
namespace {

FilterOptions good() {
  FilterOptions options;
  options.sensor.gyro = {.noise = 1e-3, .bias = 0.01, .drift = {}, .scale = 0.01};
  options.sensor.accel = {.noise = 3e-3, .bias = 0.05, .drift = {}, .scale = 0.02};
  return options;
}

TEST(FilterOptions, RefuseWhatNoFilterCanRunOn) {
  EXPECT_NO_THROW(good().validate());
  struct Wrong {
    const char* says;
    std::function<void(FilterOptions&)> spoil;
  };
  const GaussMarkov drift{Vector3d::Ones(), 60};
  const Wrong all[] = {
      {"gate 0", [](FilterOptions& o) { o.behaviour.trust.gate = 0; }},
      {"gate 1", [](FilterOptions& o) { o.behaviour.trust.gate = 1; }},
      {"gate nan", [](FilterOptions& o) { o.behaviour.trust.gate = std::numeric_limits<double>::quiet_NaN(); }},
      {"noise of the IMU", [](FilterOptions& o) { o.sensor.gyro.noise = 0; }},
      {"noise of the IMU", [](FilterOptions& o) { o.sensor.accel.noise = -1; }},
      {"only the first 4 receivers", [&](FilterOptions& o) { o.gnss.assign(5, {.name = "", .drift = drift}); }},
      {"below 1",
       [&](FilterOptions& o) { o.gnss = {{.name = "", .drift = PositionDrift::of_share(Vector3d::Ones(), 60)}}; }},
      {"one source at most",
       [&](FilterOptions& o) { o.attitude.assign(2, {.name = "", .drift = {}, .boresight_drift = drift}); }},
      {"rest", [](FilterOptions& o) { o.behaviour.rest.sigma_velocity = 0; }},
      {"rest", [](FilterOptions& o) { o.behaviour.rest.sigma_rate = 0; }},
      {"rest", [](FilterOptions& o) { o.behaviour.rest.interval = 0; }},
      {"rest", [](FilterOptions& o) { o.behaviour.rest.correlation_time = -1; }},
      {"cell", [](FilterOptions& o) { o.behaviour.rest.cell = 0; }},
      {"hypotheses", [](FilterOptions& o) { o.behaviour.start.hypotheses = 0; }},
      {"distrust", [](FilterOptions& o) { o.behaviour.trust.distrust = -1; }},
      {"longest", [](FilterOptions& o) { o.behaviour.gaps.longest = 0; }},
  };
  for (const Wrong& wrong : all) {
    FilterOptions options = good();
    wrong.spoil(options);
    EXPECT_TRUE(test::contains(test::message_of<ConfigError>([&] { options.validate(); }), wrong.says));
  }
  FilterOptions one_of_each = good();
  one_of_each.gnss = {{.name = "", .drift = drift}, {.name = "", .drift = {}}};
  one_of_each.attitude = {{.name = "", .drift = drift, .boresight_drift = drift}, {.name = "", .drift = drift}};
  EXPECT_NO_THROW(one_of_each.validate());
}

// What a sensor has no error of is not estimated, and nothing else is left out for it.
TEST(ImuErrorBlocks, AreThoseThatTheSensorHas) {
  ImuSensor sensor = good().sensor;
  EXPECT_EQ(imu_error_blocks(sensor),
            (std::vector{Block::kGyroBias, Block::kAccelBias, Block::kGyroScale, Block::kAccelScale}));
  sensor.gyro.drift = {.kind = DriftProcess::Kind::kGaussMarkov, .sigma = 1e-3, .correlation_time = 100};
  sensor.accel.drift = {.kind = DriftProcess::Kind::kRandomWalk, .density = 1e-3};
  sensor.gyro.scale = 0;
  sensor.accel.bias = 0;
  EXPECT_EQ(imu_error_blocks(sensor),
            (std::vector{Block::kGyroBias, Block::kGyroDrift, Block::kAccelDrift, Block::kAccelScale}));
  EXPECT_TRUE(imu_error_blocks({}).empty());
}

}  // namespace
}  // namespace piste
