// What a user may get wrong, and what is unusual but right, made from the shipped ski run.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <limits>

#include "support/navigation.h"
#include "support/spoiled_run.h"

namespace piste::test {
namespace {

std::vector<Fault> faults() {
  return {
      // Files
      {"MissingFile",
       [](const SkiRun& run) { std::filesystem::remove(run.folder / kGnss); },
       kUsage,
       {config_line("file: ../data/ski_run/gnss"), "gnss.csv"}},
      {"MissingSensorFile",
       [](const SkiRun& run) { std::filesystem::remove(run.folder / SkiRun::kSensor); },
       kUsage,
       {config_line("sensor:"), "xsens_mt9a.yaml"}},
      {"AFolderForAFile",
       in_config("../data/ski_run/gnss.csv", "../data/ski_run"),
       kUsage,
       {config_line("file: ../data/ski_run/gnss")}},
      // Configuration
      {"UnknownKey",
       in_config("smoother: rts", "smother: rts"),
       kUsage,
       {config_line("smoother:"), "smother", "smoother"}},
      {"UnknownKeyBelow",
       in_config("lever_arm:", "leverarm:"),
       kUsage,
       {config_line("lever_arm:"), "leverarm", "lever_arm"}},
      {"RepeatedKey", in_config("gate: 0.999", "gate: 0.999\ngate: 0.99"), kUsage, {config_line("gate:", 1), "gate"}},
      {"WrongUnit", in_config("-0.42 m", "-0.42 s"), kUsage, {config_line("lever_arm:"), "s", " m"}},
      {"MissingUnit", in_config("-0.42 m", "-0.42"), kUsage, {config_line("lever_arm:"), "unit"}},
      {"TwoNumbersForThree", in_config("-0.06 0.03 -0.42 m", "-0.06 0.03 m"), kUsage, {config_line("lever_arm:")}},
      {"TextForANumber", in_config("gate: 0.999", "gate: high"), kUsage, {config_line("gate:"), "high"}},
      {"GateBeyondOne", in_config("gate: 0.999", "gate: 99.9"), kUsage, {config_line("gate:"), "between 0 and 1"}},
      {"NegativeTime",
       in_config("correlation_time: 60 s", "correlation_time: -60 s"),
       kUsage,
       {config_line("correlation_time:")}},
      {"NoImu", in_config("imu:", "imus:"), kUsage, {"ski_run.yaml:", "imu"}},
      {"UnknownBlock",
       in_config("gyro_bias,", "gyro_bais,"),
       kUsage,
       {config_line("estimate:"), "gyro_bais", "perhaps `gyro_bias`"}},
      {"BlockTwice", in_config("gyro_bias,", "gyro_bias, gyro_bias,"), kUsage, {config_line("estimate:"), "twice"}},
      {"BoresightWithoutAttitude",
       [](const SkiRun& run) {
         const std::string all = run.text(SkiRun::kConfig);
         run.write(SkiRun::kConfig, all.substr(0, all.find("attitude:")) + all.substr(all.find("initial:")));
       },
       kUsage,
       {"ski_run.yaml:", "boresight needs an `attitude:`"}},
      {"HeadingWithoutUnit", in_config("heading: auto", "heading: 75"), kUsage, {config_line("initial:"), "unit"}},
      {"HeadingMisspelt", in_config("heading: auto", "heading: automatic"), kUsage, {config_line("initial:"), "auto"}},
      {"HeadingFromNoMagnetometer", in_config("heading: auto", "heading: from_magnetometer"), kData, {"magnet"}},
      {"UnknownSmoother",
       in_config("smoother: rts", "smoother: rtss"),
       kUsage,
       {config_line("smoother:"), "rtss", "rts"}},
      {"LeftHandedAxes", in_config("+x +y +z", "+x +y -z"), kUsage, {config_line("axes:"), "right-handed"}},
      {"UseOfNothing", in_config("use: position velocity", "use: altitude"), kUsage, {config_line("use:"), "position"}},
      {"SpanReversed",
       in_config("start: 0 s, end: 0 s", "start: 302480 s, end: 302440 s"),
       kUsage,
       {config_line("span:"), "after start"}},
      {"SpanElsewhere", in_config("start: 0 s, end: 0 s", "start: 1 s, end: 2 s"), kData, {"mt9a_1.csv: ", "span"}},
      {"OutageOfEverything", in_config("outages: []", "outages: [[302000, 1000]]"), kData, {"outages"}},
      {"OutageOfNoLength",
       in_config("outages: []", "outages: [[302450, 0]]"),
       kUsage,
       {config_line("outages:"), "length"}},
      {"NotYaml", in_config("gate: 0.999", "gate: [0.999"), kUsage, {"ski_run.yaml:"}},
      {"Tabs", in_config("  lever_arm", "\tlever_arm"), kUsage, {config_line("lever_arm:")}},
      {"EmptyConfig", [](const SkiRun& run) { run.write(SkiRun::kConfig, ""); }, kUsage, {"ski_run.yaml"}},
      // Sensor file
      {"SensorNoiseInTheWrongUnit", in_sensor("200 ug/sqrt(Hz)", "200 ug"), kUsage, {"xsens_mt9a.yaml:", "ug"}},
      {"SensorNoiseOfZero",
       in_sensor("0.05 deg/s/sqrt(Hz)", "0 deg/s/sqrt(Hz)"),
       kUsage,
       {"xsens_mt9a.yaml:", "noise"}},
      {"SensorUnknownKey", in_sensor("  scale:", "  skale:"), kUsage, {"xsens_mt9a.yaml:", "skale", "scale"}},
      {"SensorUnknownProcess",
       in_sensor("gauss_markov", "gauss_markoff"),
       kUsage,
       {"xsens_mt9a.yaml:", "gauss_markov"}},
  };
}

class BadInput : public ::testing::TestWithParam<Fault> {};

TEST_P(BadInput, IsRefused) {
  const SkiRun run;
  GetParam().spoil(run);
  expect_refusal(run, GetParam(), run.replay());
}

INSTANTIATE_TEST_SUITE_P(Table, BadInput, ::testing::ValuesIn(faults()),
                         [](const auto& each) { return each.param.name; });

// ---- Unusual, and right ----

struct Unusual {
  std::string name;
  std::function<void(const SkiRun&)> change;
  double horizontal = 0.05, tilt = 1, heading = 3;  ///< bounds of the smoothed RMSE while skiing [m, deg]
  double later = 0;                                 ///< by which its times differ from the truth's [s]
  std::string warned = {};                          ///< of the warning that it deserves
};

std::string without_attitude(const std::string& config) {
  std::string all = config.substr(0, config.find("attitude:")) + config.substr(config.find("initial:"));
  return all.replace(all.find(", boresight"), 11, "");
}

void no_attitude(const SkiRun& run) { run.write(SkiRun::kConfig, without_attitude(run.text(SkiRun::kConfig))); }

constexpr double kToNextWeek = 604800 - SkiRun::kBegin - 0.5;  // half a second before it

std::vector<Unusual> unusual() {
  return {
      {"NoNewlineAtTheEnd",
       [](const SkiRun& run) {
         for (const char* name : {kImu, kGnss, SkiRun::kConfig}) {
           std::string all = run.text(name);
           all.pop_back();
           run.write(name, all);
         }
       }},
      {"ColumnsInAnotherOrder",
       [](const SkiRun& run) {
         run.edit_rows(kGnss, [](auto& row) { std::reverse(row.begin(), row.end()); });
         std::string header;
         std::istringstream names(run.text(kGnss).substr(0, run.text(kGnss).find('\n')));
         for (std::string name; std::getline(names, name, ',');) header = name + (header.empty() ? "" : "," + header);
         run.edit_line(kGnss, 1, [&](std::string& line) { line = header; });
       }},
      {"IgnoredColumns",
       [](const SkiRun& run) {
         run.edit_rows(kImu, [](auto& row) { row.insert(row.begin() + 1, "not a number"); });
         run.replace(kImu, "time_s,", "time_s,remark,");
         run.replace(SkiRun::kConfig, "  sampling: mean", "  ignore_columns: [remark]\n  sampling: mean");
       }},
      {"DegreesAndG",
       [](const SkiRun& run) {
         run.edit_rows(kImu, [](auto& row) {
           for (std::size_t i = 1; i <= 3; ++i) row[i] = fmt::format("{:.9f}", std::stod(row[i]) * 57.295779513);
           for (std::size_t i = 4; i <= 6; ++i) row[i] = fmt::format("{:.9f}", std::stod(row[i]) / 9.80665);
         });
         run.edit_line(kImu, 1, [](std::string& line) {
           line = "time_s,gyro_x_deg_s,gyro_y_deg_s,gyro_z_deg_s,accel_x_g,accel_y_g,accel_z_g";
         });
       }},
      {"TurnedSensor",  // x right, y back, z down
       [](const SkiRun& run) {
         run.edit_rows(kImu, [](auto& row) {
           for (const std::size_t i : {1u, 4u}) {
             const double forward = std::stod(row[i]);
             row[i] = row[i + 1];
             row[i + 1] = fmt::format("{:.7f}", -forward);
           }
         });
         run.replace(SkiRun::kConfig, "+x +y +z", "-y +x +z");
       }},
      {"InstantSampling", in_config("sampling: mean", "sampling: instant"), 0.1, 2, 5, 0,
       "sigmas are too small"},  // half a sample late
      {"NoAttitude", no_attitude},
      {"GnssAsAMap", in_config("  - file: ../data/ski_run/gnss.csv", "    file: ../data/ski_run/gnss.csv")},
      {"TwoReceivers",
       in_config("    use: position velocity",
                 "    use: position velocity\n  - {file: ../data/ski_run/gnss_l1.csv, lever_arm: -0.06 0.03 -0.42 m, "
                 "drift: {sigma: 0.4 0.4 0.7 m, correlation_time: 60 s}}")},
      {"L1Alone", in_config("gnss.csv\n", "gnss_l1.csv\n    drift: {sigma: 0.4 0.4 0.7 m, correlation_time: 60 s}\n"),
       1.2},
      {"PositionOnly", in_config("use: position velocity", "use: position")},
      {"VelocityOnly", in_config("use: position velocity", "use: velocity"), 5},
      {"HeadingFromAttitude", in_config("heading: auto", "heading: from_attitude")},
      {"HeadingGiven", in_config("heading: auto", "heading: 74 deg")},
      {"Span", in_config("start: 0 s, end: 0 s", "start: 302450 s, end: 302490 s")},
      {"StartsOnTheMove", in_config("start: 0 s, end: 0 s", "start: 302465 s, end: 0 s")},
      {"Outage", in_config("outages: []", "outages: [[302475, 5]]"), 0.3},
      {"GnssBeginsInTheNextWeek",
       [](const SkiRun& run) {
         for (const char* name : {kImu, kGnss, kAttitude}) shift_times(run, name, kToNextWeek);
         std::string all = run.text(kGnss);
         run.write(kGnss, all.substr(0, all.find('\n') + 1) + all.substr(all.find("\n0.") + 1));
       },
       0.05, 1, 3, kToNextWeek},
  };
}

void PrintTo(const Unusual& unusual, std::ostream* out) { *out << unusual.name; }

class UnusualInput : public ::testing::TestWithParam<Unusual> {};

TEST_P(UnusualInput, IsTaken) {
  const SkiRun run;
  GetParam().change(run);
  const Said said = run.replay();
  ASSERT_EQ(said.code, 0) << said.err;
  if (GetParam().warned.empty()) {
    EXPECT_EQ(said.err, "");
  } else {
    EXPECT_TRUE(contains(said.err, GetParam().warned)) << said.err;
  }
  expect_numbers(run);

  Table truth = read_table(kSource / "data/ski_run/truth.csv");
  Table smoothed = read_table(run.folder / "result/smoothed.csv");
  std::vector<double>& time = smoothed.columns.at("time_s");
  EXPECT_TRUE(std::is_sorted(time.begin(), time.end()));
  EXPECT_NEAR(time.back(), SkiRun::kEnd + GetParam().later, 10);  // beyond 604800 where the week rolls over
  for (double& t : time) t -= GetParam().later;
  const Accuracy a = accuracy(smoothed, truth, {302465, 302488});
  EXPECT_GT(a.epochs, 400u);
  EXPECT_LT(a.horizontal, GetParam().horizontal) << text_of(a);
  EXPECT_LT(std::max(a.roll, a.pitch), GetParam().tilt) << text_of(a);
  EXPECT_LT(a.heading, GetParam().heading) << text_of(a);
  std::printf("%s\n", text_of(a).c_str());
}

INSTANTIATE_TEST_SUITE_P(Table, UnusualInput, ::testing::ValuesIn(unusual()),
                         [](const auto& each) { return each.param.name; });

}  // namespace
}  // namespace piste::test
