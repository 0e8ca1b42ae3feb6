// Small logs as people have them, each with what is right (expected.md), and most with the truth: `inspect` on them
// with no hands, then `replay` on the configuration that it writes.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <numbers>
#include <ostream>
#include <regex>
#include <string>
#include <string_view>
#include <vector>

#include "support/navigation.h"
#include "support/places.h"
#include "support/program.h"

namespace piste::test {
namespace {

namespace fs = std::filesystem;

// The folder of the cases: $PISTE_CASES, else ../shared/cases next to the sources.
fs::path cases() {
  if (const char* given = std::getenv("PISTE_CASES")) return given;
  return fs::path(source_folder()).parent_path() / "shared" / "cases";
}

struct Case {
  std::string name;
  /// What inspect says, and what its configuration holds: regular expressions that are found, and that are not.
  std::vector<std::string> says = {}, never = {};
  enum class Replay { kNone, kRuns, kHolds, kHoldsButHeading, kHoldsOrRefused };
  Replay replay = Replay::kNone;
};

void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

const std::vector<Case>& all_cases() {
  using enum Case::Replay;
  static const std::vector<Case> kCases{
      {"a_time_that_leaps", {"column `time` keeps falling back", "falls back at row 2"}},
      {"allan_without_header_accelerometers_first",
       {"accelerometers  x -?0\\.\\d+ to -?0\\.\\d+, y [^\n]*, z 9\\.\\d+ to 9\\.\\d+ m/s"},
       {"faster than those of any body", "are they degrees"}},
      {"antenna_ahead_of_the_axle", {"lever_arm: [12]\\.\\d"}, {"clocks were not set by one another"}, kHolds},
      {"arduino_serial_monitor", {" -> "}, {"A CSV needs a header"}},
      {"barometer_beside_gps_height", {"height: \\{name: gps_height_msl"}, {"height: \\{name: baro"}, kHolds},
      {"calendar_in_14_numbers", {"name|46\\.097"}, {"kf_gins", "Nothing looks wrong"}},
      {"clock_set_back_under_way",
       {"steps: \\[\\[200150(\\.0+)? s, -0\\.7(00*)? s\\]\\]"},
       {"rows sorted"},
       kHoldsOrRefused},
      {"columns_of_a_fix_change_in_different_rows",
       {"rate            10(\\.00\\d*)? Hz", "only_new: true"},
       {},
       kHolds},
      {"course_in_radians", {"course: \\{name: GCrs, unit: rad\\}"}, {}, kHolds},
      {"findings_that_contradict",
       {"1 deg/s"},
       {"degrees under the name of radians", "radians under the name of degrees"}},
      {"fix_every_ten_seconds",
       {"axes: \\+x \\+y \\+z|down as gravity has it", "a fix every 10 s"},
       {"the forces are", "gravity in the forces", "wander at rest"},
       kRuns},
      {"float_between_fixed", {}, {}, kHolds},
      {"flysight_time_rows", {"offset: -241918\\.6[78]\\d* s", "height: above the sea"}, {"no time in common"}, kRuns},
      {"ios_sensor_logger_signs",
       {"accel: \\{names: \\[x, y, z\\], added: \\[x, y, z\\], axes: -x -y -z", "axes: [^\n]* -z  "},
       {"axes: \\+x \\+y \\+z"},
       kRuns},
      {"matlab_datenum", {"unit: datenum"}, {"multiply it by 3600", "480 Hz"}},
      {"nmea_behind_a_stamp", {"rows            120"}},
      {"nmea_dead_reckoned", {"dead-reckoned"}, {}, kHolds},
      {"nmea_speed_and_course", {"rows            120", "velocity        120 fixes"}, {"no velocities"}},
      {"nmea_with_some_ubx_frames", {"format          nmea", "rows            120"}},
      {"nmea_without_checksums", {"rows            120", "without a right checksum"}},
      {"nmea_without_geoid_separation", {"rows            120", "above the sea"}},
      {"phone_fusion_attitude",
       {"Orientation\\.csv: the rates fit only with scales that no gyroscope has"},
       {"\nattitude:"},
       kRuns},
      {"phone_rates_without_a_rest", {"gyro: \\{names: \\[[^\\]]*\\], unit: 'rad/s'"}, {}, kRuns},
      {"racechrono_phone_fix_type", {"rows            120", "fix_type: leaves out every row"}},
      {"rad_s_of_a_log_that_begins_in_the_air",
       {"gyro: \\{names: \\[gyro_x, gyro_y, gyro_z\\], unit: 'rad/s'"},
       {},
       kHoldsButHeading},
      {"reach_llh_without_header", {"rtklib_pos", "from 302460\\.100", "median 0\\.012 0\\.011 0\\.022 m"}},
      {"receiver_just_switched_on", {}, {}, kHolds},
      {"rows_without_gyroscopes", {}, {}, kHolds},
      {"sensorlog_ios_blanks",
       {"name: locationTimestamp_since1970", "axes: -x -y -z"},
       {"course_accuracy: \\{name: locationHeadingAccuracy"},
       kRuns},
      {"smooth_cruise_is_no_rest", {"rest            (8|9)\\d s in"}, {}, kHolds},
      {"time_begins_below_zero", {"lever_arm: [12]\\.\\d"}, {"no second of the GPS week"}, kHolds},
      {"xsens_without_header_magnetometer", {"accel: \\{names: \\[2, 3, 4\\], unit: 'm/s\\^2'"}, {}, kRuns},
  };
  return kCases;
}

// How many of the errors are inside 3 sigma, as a part.
class Share {
 public:
  void add(double error, double sigma) {
    inside_ += std::abs(error) <= 3 * sigma ? 1 : 0;
    ++all_;
  }
  double value() const { return all_ > 0 ? inside_ / all_ : 0; }

 private:
  double inside_ = 0, all_ = 0;
};

double turn_between(double a, double b) { return std::remainder(a - b, 360); }

// Compares a solution with the truth. A log that counts from power-up has its 0 at 200000 s of the truth.
void expect_within(const Table& solution, const Table& truth, bool heading_counts, const std::string& what) {
  constexpr double kAsked = 0.95, kPowerUp = 200000, kEarly = 1e5;
  const double zero = solution["time_s"].front() < kEarly && truth["time_s"].front() > kEarly ? kPowerUp : 0;
  Share north, east, down, heading;
  double turned = 0;
  const auto each = [&](auto&& take) {
    for (std::size_t i = 0; i < truth.rows; ++i) {
      const double t = truth["time_s"][i] - zero;
      if (t >= solution["time_s"].front() && t <= solution["time_s"].back()) take(i, t);
    }
  };
  const auto off = [&](std::size_t i, double t) {
    return turn_between(at(solution, "heading_deg", t), truth["heading_deg"][i]);
  };
  if (!heading_counts) {  // up to a constant
    double sine = 0, cosine = 0;
    each([&](std::size_t i, double t) {
      sine += std::sin(kDegree * off(i, t));
      cosine += std::cos(kDegree * off(i, t));
    });
    turned = std::atan2(sine, cosine) / kDegree;
  }
  each([&](std::size_t i, double t) {
    const auto value = [&](std::string_view column) { return at(solution, column, t); };
    const World world({kDegree * truth["latitude_deg"][i], kDegree * truth["longitude_deg"][i], truth["height_m"][i]});
    const Vector3d error =
        world.from_geodetic({kDegree * value("latitude_deg"), kDegree * value("longitude_deg"), value("height_m")});
    north.add(error.x(), value("sigma_north_m"));
    east.add(error.y(), value("sigma_east_m"));
    down.add(error.z(), value("sigma_down_m"));
    heading.add(turn_between(off(i, t), turned), value("sigma_heading_deg"));
  });
  const std::array<std::pair<const char*, double>, 4> shares{
      {{"north", north.value()}, {"east", east.value()}, {"down", down.value()}, {"heading", heading.value()}}};
  for (const auto& [axis, share] : shares) {
    EXPECT_GE(share, kAsked) << what << " " << axis;
    fmt::print("{} {}: {:.1f} % inside 3 sigma\n", what, axis, 100 * share);
  }
}

class Cases : public ::testing::TestWithParam<Case> {};

TEST_P(Cases, ComesOutRight) {
  const Case& c = GetParam();
  if (!fs::is_directory(cases())) {
    if (std::getenv("PISTE_CASES") != nullptr) FAIL() << "$PISTE_CASES is no folder";
    GTEST_SKIP() << "the cases are not here: set PISTE_CASES to their folder";
  }
  const fs::path place = cases() / c.name;
  ASSERT_TRUE(fs::is_directory(place)) << place;
  const TemporaryFolder folder;
  std::vector<std::string> words;
  for (const auto& entry : fs::directory_iterator(place)) {
    const std::string name = entry.path().filename().string();
    if (name != "expected.md" && name != "truth.csv") words.push_back(fs::absolute(entry.path()).string());
  }
  std::sort(words.begin(), words.end());
  words.insert(words.end(), {"--output", "found"});
  const Said inspected = run_program(program("inspect"), words, folder);
  const std::string said = inspected.out + inspected.err;
  for (const std::string& pattern : c.says) EXPECT_TRUE(std::regex_search(said, std::regex(pattern))) << pattern;
  for (const std::string& pattern : c.never) EXPECT_FALSE(std::regex_search(said, std::regex(pattern))) << pattern;
  if (HasFailure()) fmt::print("{}\n", said);
  const fs::path config = folder / "found/replay.yaml";
  if (!fs::exists(config)) {
    EXPECT_EQ(c.replay, Case::Replay::kNone) << "no configuration\n" << said;
    return;
  }
  const Said replayed = run_program(program("replay"), {config.string(), "--output", "run", "--quiet"}, folder);
  if (c.replay == Case::Replay::kHoldsOrRefused && replayed.code != 0) return;
  ASSERT_EQ(replayed.code, 0) << "replay refuses what inspect wrote: " << replayed.err;
  if (c.replay == Case::Replay::kNone || c.replay == Case::Replay::kRuns) return;
  const Table truth = read_table(place / "truth.csv");
  for (const char* solution : {"filtered", "smoothed"}) {
    expect_within(read_table(folder / fmt::format("run/{}.csv", solution)), truth,
                  c.replay != Case::Replay::kHoldsButHeading, solution);
  }
}

INSTANTIATE_TEST_SUITE_P(AsPeopleHaveThem, Cases, ::testing::ValuesIn(all_cases()),
                         [](const auto& each) { return each.param.name; });

// Each folder is in the table: none is skipped.
TEST(CasesTable, HasEachFolder) {
  if (!fs::is_directory(cases())) GTEST_SKIP() << "the cases are not here";
  for (const auto& entry : fs::directory_iterator(cases())) {
    if (!entry.is_directory()) continue;
    const std::string name = entry.path().filename().string();
    EXPECT_TRUE(std::ranges::any_of(all_cases(), [&](const Case& c) { return c.name == name; })) << name;
  }
}

}  // namespace
}  // namespace piste::test
