// What a user may get wrong, and what is unusual but right, made from the shipped ski run.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <limits>

#include "support/navigation.h"
#include "support/ski_run.h"

namespace piste::test {
namespace {

struct Fault {
  std::string name;
  std::function<void(const SkiRun&)> spoil;
  int code;
  std::vector<std::string> says;  ///< parts of the message: where, what, and what would be right
};

void set_field(std::string& line, std::size_t field, const std::string& value) {
  std::size_t begin = 0;
  for (std::size_t i = 0; i < field; ++i) begin = line.find(',', begin) + 1;
  line.replace(begin, std::min(line.find(',', begin), line.size()) - begin, value);
}

auto field(const char* file, int line, std::size_t index, const std::string& value) {
  return
      [=](const SkiRun& run) { run.edit_line(file, line, [&](std::string& text) { set_field(text, index, value); }); };
}

auto in_config(const std::string& from, const std::string& to) {
  return [=](const SkiRun& run) { run.replace(SkiRun::kConfig, from, to); };
}

auto in_sensor(const std::string& from, const std::string& to) {
  return [=](const SkiRun& run) { run.replace(SkiRun::kSensor, from, to); };
}

/// Where the shipped configuration has this text, as errors name it.
std::string config_line(const std::string& text, int below = 0) {
  const std::string all = read_text(kSource / SkiRun::kConfig);
  return fmt::format("ski_run.yaml:{}: ", std::count(all.begin(), all.begin() + all.find(text), '\n') + 1 + below);
}

const char *const kImu = SkiRun::kImu, *const kGnss = SkiRun::kGnss, *const kAttitude = SkiRun::kAttitude;
constexpr int kData = 1, kUsage = 2;

std::vector<Fault> faults() {
  return {
      // Rows
      {"TextInANumber", field(kImu, 1000, 3, "12.x"), kData, {"mt9a_1.csv:1000: ", "12.x"}},
      {"EmptyField", field(kImu, 1000, 3, ""), kData, {"mt9a_1.csv:1000: "}},
      {"NotANumber", field(kImu, 1000, 4, "nan"), kData, {"mt9a_1.csv:1000: ", "finite"}},
      {"Infinite", field(kGnss, 77, 3, "inf"), kData, {"gnss.csv:77: ", "finite"}},
      {"TooLargeForANumber", field(kGnss, 77, 3, "1e999"), kData, {"gnss.csv:77: "}},
      {"ShortRow",
       [](const SkiRun& run) { run.edit_line(kImu, 1000, [](std::string& s) { s.erase(s.rfind(',')); }); },
       kData,
       {"mt9a_1.csv:1000: 6 fields", "7 columns"}},
      {"LongRow",
       [](const SkiRun& run) { run.edit_line(kImu, 1000, [](std::string& s) { s += ",0"; }); },
       kData,
       {"mt9a_1.csv:1000: 8 fields", "7 columns"}},
      {"DecimalCommas",
       [](const SkiRun& run) {
         run.edit_line(kImu, 1000, [](std::string& s) { std::replace(s.begin(), s.end(), '.', ','); });
       },
       kData,
       {"mt9a_1.csv:1000: ", "fields"}},
      {"RepeatedTime",
       [](const SkiRun& run) { run.edit_line(kImu, 1000, [](std::string& s) { s += "\n" + s; }); },
       kData,
       {"mt9a_1.csv:1001: ", "time"}},
      {"TimeRunsBack", field(kGnss, 77, 0, "302436.0"), kData, {"gnss.csv:77: ", "time"}},
      {"CutInTheLastLine",
       [](const SkiRun& run) {
         std::string all = run.text(kGnss);
         run.write(kGnss, all.substr(0, all.size() - 40));
       },
       kData,
       {"gnss.csv:602: ", "cut"}},
      {"LatitudeOutOfRange", field(kGnss, 77, 1, "95.0"), kData, {"gnss.csv:77: latitude 95", "90"}},
      {"SigmaOfZero", field(kGnss, 77, 4, "0"), kData, {"gnss.csv:77: ", "sigma", "above zero"}},
      {"NegativeSigma", field(kAttitude, 77, 5, "-0.02"), kData, {"ln200_attitude.csv:77: ", "above zero"}},
      {"RollOutOfRange", field(kAttitude, 77, 1, "190"), kData, {"ln200_attitude.csv:77: ", "180"}},
      // Files and headers
      {"DegreesLabelledAsRadians",
       [](const SkiRun& run) {
         run.edit_rows(kImu, [](std::vector<std::string>& row) {
           for (std::size_t i = 1; i <= 3; ++i) row[i] = fmt::format("{:.5f}", 57.29578 * std::stod(row[i]));
         });
       },
       kData,
       {"mt9a_1.csv:", "degrees", "gyro_x_deg_s"}},
      {"GLabelledAsMetres",
       [](const SkiRun& run) {
         run.edit_rows(kImu, [](std::vector<std::string>& row) {
           for (std::size_t i = 4; i <= 6; ++i) row[i] = fmt::format("{:.7f}", std::stod(row[i]) / 9.80665);
         });
       },
       kData,
       {"mt9a_1.csv", "accel_x_g"}},
      {"MetresLabelledAsG",
       [](const SkiRun& run) {
         run.edit_line(kImu, 1, [](std::string& line) {
           for (const char axis : {'x', 'y', 'z'}) {
             const std::string name = fmt::format("accel_{}_m_s2", axis);
             line.replace(line.find(name), name.size(), fmt::format("accel_{}_g", axis));
           }
         });
       },
       kData,
       {"mt9a_1.csv", "accel_x_m_s2"}},
      {"ColumnMissing", in_config("mt9a_1.csv", "gnss.csv"), kData, {"gnss.csv:1: ", "gyro_x_rad_s"}},
      {"ColumnMisspelt",
       [](const SkiRun& run) { run.replace(kGnss, "height_m", "heigth_m"); },
       kData,
       {"gnss.csv:1: column `height_m` is missing", "heigth_m"}},
      {"UnknownColumn",
       [](const SkiRun& run) {
         run.edit_rows(kImu, [](std::vector<std::string>& row) { row.push_back("1"); });
         run.replace(kImu, "accel_z_m_s2", "accel_z_m_s2,odometer");
       },
       kData,
       {"mt9a_1.csv:1: unknown column `odometer`", "ignore_columns"}},
      {"NoHeader",
       [](const SkiRun& run) { run.write(kGnss, run.text(kGnss).substr(run.text(kGnss).find('\n') + 1)); },
       kData,
       {"gnss.csv:1: ", "header"}},
      {"EmptyFile", [](const SkiRun& run) { run.write(kImu, ""); }, kData, {"mt9a_1.csv:1: ", "empty"}},
      {"HeaderOnlyImu",
       [](const SkiRun& run) { run.write(kImu, run.text(kImu).substr(0, run.text(kImu).find('\n') + 1)); },
       kData,
       {"mt9a_1.csv: ", "fewer than two"}},
      {"HeaderOnlyGnss",
       [](const SkiRun& run) { run.write(kGnss, run.text(kGnss).substr(0, run.text(kGnss).find('\n') + 1)); },
       kData,
       {"gnss.csv", "no "}},
      {"HeaderOnlyAttitude",
       [](const SkiRun& run) {
         run.write(kAttitude, run.text(kAttitude).substr(0, run.text(kAttitude).find('\n') + 1));
       },
       kData,
       {"ln200_attitude.csv", "no "}},
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
      {"NoCommonTime",
       [](const SkiRun& run) {
         run.edit_rows(kGnss, [](auto& row) { row[0] = fmt::format("{:.3f}", std::stod(row[0]) - 5000); });
       },
       kData,
       {"mt9a_1.csv: no time in common", "302434", "297435", "clock"}},
      {"NoCommonTimeWithAttitude",
       [](const SkiRun& run) {
         run.edit_rows(kAttitude, [](auto& row) { row[0] = fmt::format("{:.3f}", std::stod(row[0]) - 5000); });
       },
       kData,
       {"no time in common", "297435"}},
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
      {"NoGnss",
       [](const SkiRun& run) {
         const std::string all = run.text(SkiRun::kConfig);
         run.write(SkiRun::kConfig, all.substr(0, all.find("gnss:")) + all.substr(all.find("attitude:")));
       },
       kUsage,
       {"ski_run.yaml:", "`gnss`"}},
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

void PrintTo(const Fault& fault, std::ostream* out) { *out << fault.name; }

class BadInput : public ::testing::TestWithParam<Fault> {};

TEST_P(BadInput, IsRefused) {
  const SkiRun run;
  GetParam().spoil(run);
  const Said said = run.replay();
  EXPECT_EQ(said.code, GetParam().code) << said.err;
  for (const std::string& part : GetParam().says) EXPECT_TRUE(contains(said.err, part));
  EXPECT_EQ(said.out, "");
  EXPECT_EQ(std::count(said.err.begin(), said.err.end(), '\n'), 1) << said.err;
  EXPECT_FALSE(std::filesystem::exists(run.folder / "result"));
}

INSTANTIATE_TEST_SUITE_P(Table, BadInput, ::testing::ValuesIn(faults()),
                         [](const auto& each) { return each.param.name; });

// ---- Unusual, and right ----

struct Unusual {
  std::string name;
  std::function<void(const SkiRun&)> change;
  double horizontal = 0.05, tilt = 1, heading = 3;  ///< bounds of the smoothed RMSE while skiing [m, deg]
  double later = 0;                                 ///< by which its times differ from the truth's [s]
};

std::string without_attitude(const std::string& config) {
  std::string all = config.substr(0, config.find("attitude:")) + config.substr(config.find("initial:"));
  return all.replace(all.find(", boresight"), 11, "");
}

void no_attitude(const SkiRun& run) { run.write(SkiRun::kConfig, without_attitude(run.text(SkiRun::kConfig))); }

void shift_times(const SkiRun& run, const char* file, double by) {
  run.edit_rows(file, [&](std::vector<std::string>& row) {
    const double t = std::stod(row[0]) + by;
    row[0] = fmt::format("{:.6f}", t >= 604800 ? t - 604800 : t);
  });
}

constexpr double kToRollover = 604800 - 302465;                // puts the end of the week into the run
constexpr double kToNextWeek = 604800 - SkiRun::kBegin - 0.5;  // half a second before it

std::vector<Unusual> unusual() {
  return {
      {"CarriageReturns",
       [](const SkiRun& run) {
         for (const char* name : {kImu, kGnss, SkiRun::kConfig}) {
           std::string all;
           for (const char c : run.text(name)) all += c == '\n' ? std::string("\r\n") : std::string(1, c);
           run.write(name, all);
         }
       }},
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
      {"InstantSampling", in_config("sampling: mean", "sampling: instant"), 0.1, 2, 5},  // half a sample late
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
      {"ImuGap",
       [](const SkiRun& run) {
         const std::string all = run.text(kImu);
         const auto begin = all.find("\n302475.0"), end = all.find("\n302475.5");
         run.write(kImu, all.substr(0, begin) + all.substr(end));
       },
       0.3, 2, 5},
      {"WeekRollsOver",
       [](const SkiRun& run) {
         for (const char* name : {kImu, kGnss, kAttitude}) shift_times(run, name, kToRollover);
       },
       0.05, 1, 3, kToRollover},
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
  EXPECT_EQ(said.err, "");
  for (const char* name : {"filtered.csv", "smoothed.csv", "biases.csv", "biases_smoothed.csv", "innovations.csv"}) {
    const std::string text = read_text(run.folder / (std::string("result/") + name));
    EXPECT_EQ(text.find("nan"), std::string::npos) << name;
    EXPECT_EQ(text.find("inf"), std::string::npos) << name;
  }
  EXPECT_EQ(read_text(run.folder / "result/summary.json").find("null"), std::string::npos);

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
