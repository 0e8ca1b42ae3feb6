#include "diagnosis/setting_doubts.h"

#include <gtest/gtest.h>

#include "support/text_file.h"

namespace piste::test {
namespace {

// Of an IMU whose file states its cross-axis errors.
FilterOptions stated() {
  FilterOptions options;
  options.sensor.gyro.cross_axis = options.sensor.accel.cross_axis = 0.001;
  return options;
}

TEST(SettingDoubts, ASensorFileThatIsSilentClaimsSquareAxes) {
  EXPECT_TRUE(setting_lines({}, stated(), {}).empty());
  FilterOptions options = stated();
  options.sensor.accel.cross_axis.reset();
  options.sensor.gyro.noise = 1e-3;
  const std::vector<std::string> lines = setting_lines({}, options, {});
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_TRUE(contains(lines[0], "states no `cross_axis`")) << lines[0];
  EXPECT_TRUE(contains(lines[0], "a consumer IMU is `cross_axis: 3000 ppm`")) << lines[0];
}

TEST(SettingDoubts, AColouredErrorIsAPartOfTheWholeOne) {
  Log log;
  log.gnss = {{}, {}};
  for (int i = 0; i < 5; ++i) {
    log.gnss[0].push_back({100.0 + i, Vector3d::Zero(), Vector3d(1, 1, 2), std::nullopt});
    log.gnss[1].push_back({100.0 + i, Vector3d::Zero(), Vector3d(1, 1, 2), std::nullopt});
  }
  FilterOptions options = stated();
  options.gnss.resize(2);
  options.gnss[0].drift = GaussMarkov{Vector3d(0.9, 0.9, 1.9), 60};
  EXPECT_TRUE(setting_lines(log, options, {}).empty());
  options.gnss[1].drift = GaussMarkov{Vector3d(3, 3, 3), 60};
  const std::vector<std::string> lines = setting_lines(log, options, {});
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_TRUE(contains(lines[0],
                       "gnss[1]: its `drift` of 3 m is a part of the error that its sigmas state, and these "
                       "are 1.4 m in the median"))
      << lines[0];
}

TEST(SettingDoubts, AnOutageOutsideTheLogIsNone) {
  Log log;
  for (int i = 0; i < 100; ++i) {
    ImuSample sample;
    sample.time = 1000 + i;
    log.imu.push_back(sample);
  }
  EXPECT_TRUE(setting_lines(log, stated(), {{990, 1000}, {1010, 1020}, {1099, 2000}}).empty());
  const std::vector<std::string> lines = setting_lines(log, stated(), {{60, 120}, {1010, 1020}, {1100, 1160}});
  ASSERT_EQ(lines.size(), 2U);
  EXPECT_EQ(lines[0], "`outages`: [60, 60] withholds nothing, as the log covers 1000.000 to 1099.000 s");
}

}  // namespace
}  // namespace piste::test
