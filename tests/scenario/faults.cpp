// What breaks in real logs, one fault at a time in the shipped ski run: the program says where it stands, or gets over
// it as well as without.

#include <gtest/gtest.h>

#include "support/navigation.h"
#include "support/places.h"
#include "support/spoiled_run.h"

namespace piste::test {
namespace {

std::string header_of(const std::string& text) { return text.substr(0, text.find('\n') + 1); }

auto only_header(const char* file) {
  return [=](const SkiRun& run) { run.write(file, header_of(run.text(file))); };
}

auto without_rows(const char* file, const std::string& from, const std::string& to) {
  return [=](const SkiRun& run) {
    const std::string all = run.text(file);
    run.write(file, all.substr(0, all.find("\n" + from)) + all.substr(all.find("\n" + to)));
  };
}

auto later(const char* file, double by) {
  return [=](const SkiRun& run) { shift_times(run, file, by); };
}

/// Names the log at `from` once more in the configuration.
auto twice(const std::string& from, const std::string& entry) { return in_config(from, entry + from); }

/// A fix 111 m off.
auto moved_north(int line) {
  return [=](const SkiRun& run) {
    run.edit_line(kGnss, line, [](std::string& text) {
      const std::size_t begin = text.find(',') + 1, end = text.find(',', begin);
      text.replace(begin, end - begin, fmt::format("{:.9f}", std::stod(text.substr(begin, end - begin)) + 0.001));
    });
  };
}

constexpr double kToRollover = 604800 - 302475;  // puts the end of the week into the run

// ---- Refused ----

std::vector<Fault> refused() {
  return {
      {"TextInANumber", field(kImu, 1000, 3, "12.x"), kData, {"mt9a_1.csv:1000: ", "12.x"}},
      {"EmptyField", field(kImu, 1000, 3, ""), kData, {"mt9a_1.csv:1000: "}},
      {"NotANumber", field(kImu, 1000, 4, "nan"), kData, {"mt9a_1.csv:1000: ", "finite"}},
      {"NotANumberInGnss", field(kGnss, 77, 1, "NaN"), kData, {"gnss.csv:77: ", "finite"}},
      {"NotANumberInAttitude", field(kAttitude, 77, 3, "-nan"), kData, {"ln200_attitude.csv:77: ", "finite"}},
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
      {"RepeatedFix",
       [](const SkiRun& run) { run.edit_line(kGnss, 77, [](std::string& s) { s += "\n" + s; }); },
       kData,
       {"gnss.csv:78: ", "time"}},
      {"TimeRunsBackInTheImu", field(kImu, 1000, 0, "302436.0"), kData, {"mt9a_1.csv:1000: ", "time"}},
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
      {"Spike", field(kImu, 4000, 2, "1e6"), kData, {"mt9a_1.csv:4000: ", "1e+06 rad/s"}},
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
      {"EmptyImu", [](const SkiRun& run) { run.write(kImu, ""); }, kData, {"mt9a_1.csv:1: ", "empty"}},
      {"EmptyGnss", [](const SkiRun& run) { run.write(kGnss, ""); }, kData, {"gnss.csv:1: ", "empty"}},
      {"HeaderOnlyImu", only_header(kImu), kData, {"mt9a_1.csv:1: ", "fewer than two"}},
      {"HeaderOnlyGnss", only_header(kGnss), kData, {"gnss.csv:1: ", "holds no fix"}},
      {"HeaderOnlyAttitude", only_header(kAttitude), kData, {"ln200_attitude.csv:1: ", "holds no attitude"}},
      {"NoCommonTime", later(kGnss, -5000), kData, {"mt9a_1.csv:1: no time in common", "302434", "297435", "clock"}},
      {"NoCommonTimeWithAttitude", later(kAttitude, -5000), kData, {"mt9a_1.csv:1: no time in common", "297435"}},
      {"NoGnss",
       [](const SkiRun& run) {
         const std::string all = run.text(SkiRun::kConfig);
         run.write(SkiRun::kConfig, all.substr(0, all.find("gnss:")) + all.substr(all.find("attitude:")));
       },
       kUsage,
       {"ski_run.yaml:", "`gnss`"}},
      {"GnssTwice",
       twice("attitude:", "  - {file: ../data/ski_run/gnss.csv, use: position}\n"),
       kUsage,
       {config_line("attitude:"), "file: ", "count twice"}},
      {"CopyOfGnss",
       [](const SkiRun& run) {
         run.write("data/ski_run/copy.csv", run.text(kGnss));
         twice("attitude:", "  - {file: ../data/ski_run/copy.csv, use: position}\n")(run);
       },
       kUsage,
       {config_line("attitude:"), "file: ", "a copy of it"}},
      {"AttitudeTwice",
       twice("initial:", "  - {file: ../data/ski_run/ln200_attitude.csv}\n"),
       kUsage,
       {config_line("initial:"), "file: ", "count twice"}},
  };
}

class RefusedFault : public ::testing::TestWithParam<Fault> {};

TEST_P(RefusedFault, IsToldWithItsPlace) {
  const SkiRun run;
  GetParam().spoil(run);
  expect_refusal(run, GetParam(), run.replay());
}

INSTANTIATE_TEST_SUITE_P(Table, RefusedFault, ::testing::ValuesIn(refused()),
                         [](const auto& each) { return each.param.name; });

TEST(SecondImu, MayNotBeTheFirstOneAgain) {
  const SkiRun run;
  run.write("data/ski_run/copy.csv", run.text(kImu));
  const auto entry = [](const std::string& name) {
    return fmt::format("{{file: ../data/ski_run/{}.csv, sensor: sensors/xsens_mt9a.yaml}}\n", name);
  };
  for (const std::string& other : {std::string("mt9a_1"), std::string("copy")}) {
    for (const std::string& config :
         {"imu: " + entry("mt9a_1") + "reference:\n  " + entry(other),
          "imu:\n- " + entry("mt9a_1") + "- " + entry(other) + "reference: " + entry("ln200_attitude")}) {
      run.write("config/align.yaml", config);
      const Fault fault{"", nullptr, kUsage, {"config/align.yaml:3: file: is the log of another entry", "count twice"}};
      expect_refusal(run, fault,
                     run_program(program("align"), {"config/align.yaml", "--output", "result", "--quiet"}, run.folder));
    }
  }
}

// ---- Survived ----

constexpr double kLargestOffset = 0.1, kLargestAngle = 0.3;  // [m, deg], RMSE and at every epoch
constexpr double kLargestAngleInSilence = 0.4;               // the body's vibration is in it, which nobody measured

struct Survived {
  std::string name;
  std::function<void(const SkiRun&)> spoil;
  double later = 0;                    ///< by which its times differ from the truth's [s]
  Interval silent = {302476, 302476};  ///< without an IMU in the run, where attitude is not known at every epoch
};

std::vector<Survived> survived() {
  return {
      {"Nothing", [](const SkiRun&) {}},
      {"BlankLines",
       [](const SkiRun& run) {
         for (const char* name : {kImu, kGnss, kAttitude}) run.edit_line(name, 77, [](auto& s) { s += "\n\n \t"; });
       }},
      {"CarriageReturns",
       [](const SkiRun& run) {
         for (const char* name : {kImu, kGnss, kAttitude, SkiRun::kConfig}) {
           std::string all;
           for (const char c : run.text(name)) all += c == '\n' ? std::string("\r\n") : std::string(1, c);
           run.write(name, all);
         }
       }},
      {"GapAtRest", without_rows(kImu, "302445.0", "302447.0")},
      {"GapInTheRun", without_rows(kImu, "302475.0", "302475.5"), 0, {302474.95, 302475.55}},
      {"GapOfGnssAtRest", without_rows(kGnss, "302445.0", "302447.0")},
      {"GapOfGnssInTheRun", without_rows(kGnss, "302475.0", "302475.5")},
      {"SpikeInDegrees",
       [](const SkiRun& run) {
         run.edit_rows(kImu, [](auto& row) {
           for (std::size_t i = 1; i <= 3; ++i) row[i] = fmt::format("{:.9f}", std::stod(row[i]) * 57.295779513);
         });
         run.edit_line(kImu, 1, [](std::string& line) {
           line = "time_s,gyro_x_deg_s,gyro_y_deg_s,gyro_z_deg_s,accel_x_m_s2,accel_y_m_s2,accel_z_m_s2";
         });
         field(kImu, 4000, 2, "57295779.513")(run);
       }},
      {"SpikeOfSpecificForce", field(kImu, 4000, 5, "1e6")},
      {"Outlier", moved_north(400)},
      {"OutlierAtRest", moved_north(77)},
      {"OutlierInTheFirstFix", moved_north(2)},
      {"WeekRollsOver",
       [](const SkiRun& run) {
         for (const char* name : {kImu, kGnss, kAttitude}) shift_times(run, name, kToRollover);
       },
       kToRollover},
  };
}

void PrintTo(const Survived& fault, std::ostream* out) { *out << fault.name; }

class SurvivedFault : public ::testing::TestWithParam<Survived> {};

TEST_P(SurvivedFault, CostsNoAccuracy) {
  const SkiRun run;
  GetParam().spoil(run);
  const Said said = run.replay();
  ASSERT_EQ(said.code, 0) << said.err;
  expect_numbers(run);
  const Table truth = read_table(kSource / "data/ski_run/truth.csv");
  const Interval& silent = GetParam().silent;
  for (const char* name : {"filtered", "smoothed"}) {
    Table solution = read_table(run.folder / fmt::format("result/{}.csv", name));
    for (double& t : solution.columns.at("time_s")) t -= GetParam().later;
    const Accuracy whole = accuracy(solution, truth, {302465, 302488});
    EXPECT_GT(whole.epochs, 400u);
    EXPECT_LT(whole.horizontal, kLargestOffset) << name;
    EXPECT_LT(std::max({whole.roll, whole.pitch, whole.heading}), kLargestAngle) << name;
    EXPECT_LT(whole.largest_horizontal, kLargestOffset) << name;
    EXPECT_LT(whole.largest_angle, kLargestAngleInSilence) << name;
    for (const Interval& during : {Interval{302465, silent.start}, {silent.end, 302488}}) {
      EXPECT_LT(accuracy(solution, truth, during).largest_angle, kLargestAngle) << name;
    }
    std::printf("%s: at most %.4f m and %.3f deg off\n", name, whole.largest_horizontal, whole.largest_angle);
  }
}

INSTANTIATE_TEST_SUITE_P(Table, SurvivedFault, ::testing::ValuesIn(survived()),
                         [](const auto& each) { return each.param.name; });

}  // namespace
}  // namespace piste::test
