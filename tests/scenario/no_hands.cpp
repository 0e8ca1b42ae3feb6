// Recordings of strangers with no hands: `inspect` on the logs, then `replay` on the configuration that it writes, with
// fixes withheld in windows. Limits are what tuning by hand had reached.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <ostream>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "piste/configuration/replay_config.h"
#include "support/datasets.h"
#include "support/places.h"
#include "support/program.h"
#include "support/thorough.h"
#include "support/withheld_fixes.h"
#include "support/yaml.h"

namespace piste::test {
namespace {

struct Stranger {
  std::string name;
  std::vector<std::string> logs;
  std::vector<Interval> windows;
  double end, smoothed;  // m: mean of the filter at their ends, and the smoother's worst inside
  bool always = true;    // or at night alone
};

void PrintTo(const Stranger& s, std::ostream* out) { *out << s.name; }

std::vector<Interval> every(std::initializer_list<double> starts, double length) {
  std::vector<Interval> windows;
  for (const double start : starts) windows.push_back({start, start + length});
  return windows;
}

std::vector<Stranger> strangers() {
  std::vector<Stranger> all;
  const std::string phone = "phone/20201104_091730_";
  all.push_back({"Phone",
                 {phone + "Gyro.csv", phone + "Acc.csv", phone + "GNSS.csv"},
                 every({289201, 289406, 289611, 289816, 290021}, 15),
                 16,
                 4});
  const std::vector<Interval> drive = coast_windows();
  all.push_back({"Drive", {"drive/imu.txt", "drive/gnss.txt"}, drive, 5.5, 0.55});
  all.push_back({"RawDrive", {"drive/imu_1934.csv", "drive/gnss_1934_sf.pos"}, drive, 5.5, 0.55, false});
  for (const int flight : {3, 4}) {
    for (int imu = 1; imu <= 4; ++imu) {
      const std::string folder = fmt::format("quadrotor/flight_{}/", flight);
      all.push_back({fmt::format("Flight{}Imu{}", flight, imu),
                     {fmt::format("{}imu_{}.csv", folder, imu), folder + "gnss.csv"},
                     flight == 3 ? every({300012, 300022, 300032}, 6) : every({300012, 300020, 300028}, 6),
                     1,
                     0.3,
                     flight == 3 && imu == 4});
    }
  }
  return all;
}

class NoHands : public ::testing::TestWithParam<Stranger> {};

TEST_P(NoHands, IsRightOrWide) {
  PISTE_REQUIRE_DATASETS();
  const Stranger& s = GetParam();
  if (!s.always && !thorough()) GTEST_SKIP() << "with PISTE_THOROUGH=1";
  const TemporaryFolder folder;
  std::vector<std::string> words;
  for (const std::string& log : s.logs) words.push_back((std::filesystem::absolute(datasets()) / log).string());
  words.insert(words.end(), {"--output", "found", "--quiet"});
  const Said inspected = run_program(program("inspect"), words, folder);
  ASSERT_EQ(inspected.code, 0) << inspected.err;
  std::string outages;
  for (const Interval& w : s.windows)
    outages += fmt::format("{}[{:.3f}, {:.3f}]", outages.empty() ? "" : ", ", w.start, w.end - w.start);
  folder.write("found/windows.yaml", read_text(folder / "found/replay.yaml") + "outages: [" + outages + "]\n");
  const Said replayed = run_program(program("replay"), {"found/windows.yaml", "--output", "result", "--quiet"}, folder);
  ASSERT_EQ(replayed.code, 0) << replayed.err;
  const Vector3d lever_arm =
      vector_of(YAML::LoadFile(folder / "result/summary.json")["estimates"]["lever_arm"]["value"]);
  const Recording logs = read_recording(read_replay_config(folder / "found/windows.yaml"));
  const auto errors = [&](const char* solution) {
    const WindowErrors e = window_errors(read_table(folder / (std::string("result/") + solution)), logs.gnss[0].fixes,
                                         s.windows, lever_arm);
    fmt::print("{} {}: mean end {:.2f} m, worst inside {:.2f} m; inside 3 sigma {:.3f}\n", s.name, solution,
               e.mean_end(), e.worst_inside(), e.count.within());
    EXPECT_GE(e.count.within(), 0.95);
    return e;
  };
  if (s.name == "Phone") {
    EXPECT_LT(lever_arm.norm(), 1) << "the antenna is in the housing; taken to be near by, it comes out 3 m away";
  }
  EXPECT_LE(errors("filtered.csv").mean_end(), s.end);
  EXPECT_LE(errors("smoothed.csv").worst_inside(), s.smoothed);
}

// Half an hour and less in which hardly anything moves the body but vibration, with a clock that is 12.3 s ahead: where
// that is not found, errors were hundreds of metres and more.
class CalmNoHands : public ::testing::TestWithParam<std::tuple<const char*, const char*>> {};

TEST_P(CalmNoHands, IsRightOrWide) {
  if (!thorough()) GTEST_SKIP() << "with PISTE_THOROUGH=1";
  const auto [motion, receiver] = GetParam();
  const TemporaryFolder folder;
  const std::filesystem::path scenario = kSource / fmt::format("config/scenarios/montecarlo/{}.yaml", motion);
  const auto run = [&](const char* name, std::vector<std::string> words) {
    words.emplace_back("--quiet");
    const Said said = run_program(program(name), words, folder);
    EXPECT_EQ(said.code, 0) << said.err;
  };
  run("simulate", {scenario.string(), "--output", "run"});
  run("inspect", {"run/mt9a_1.csv", fmt::format("run/{}.csv", receiver), "--output", "found"});
  run("replay", {"found/replay.yaml", "--output", "result"});
  const YAML::Node truth = YAML::LoadFile(folder / "run/truth.json")["imus"]["mt9a_1"];
  const ReplayConfig config = read_replay_config(folder / "found/replay.yaml");
  const double clock = config.conditioning.imu.clock_offset - truth["clock_offset_s"].as<double>();
  const Table places = read_table(folder / "run/truth.csv"), smoothed = read_table(folder / "result/smoothed.csv");
  SigmaCount count;
  double worst = 0;
  for (std::size_t i = 0; i < places.rows; i += 100) {
    GeodeticFix place;
    place.time = places["time_s"][i];
    place.position = {kDegree * places["latitude_deg"][i], kDegree * places["longitude_deg"][i], places["height_m"][i]};
    place.sigma_position.setZero();
    if (place.time < smoothed["time_s"].front() || place.time > smoothed["time_s"].back()) continue;
    count.add(smoothed, place, Vector3d::Zero());
    worst = std::max(worst, horizontal_error(smoothed, place, Vector3d::Zero()));
  }
  fmt::print("{} {}: clock off by {:.4f} s, worst {:.2f} m; inside 3 sigma {:.3f}\n", motion, receiver, clock, worst,
             count.within());
  EXPECT_LT(std::abs(clock), 0.05);
  EXPECT_LT(worst, 3);
  // The coloured error of the L1 receiver lasts a minute: thirty draws of it at most, of which one or two are outside.
  EXPECT_GE(count.within(), std::string_view(receiver) == "gnss_l1l2" ? 0.95 : 0.9);
}

INSTANTIATE_TEST_SUITE_P(Calm, CalmNoHands,
                         ::testing::Combine(::testing::Values("calm_30min", "gentle_lap", "motorway"),
                                            ::testing::Values("gnss_l1l2", "gnss_l1")),
                         [](const auto& each) {
                           return fmt::format("{}_{}", std::get<0>(each.param), std::get<1>(each.param));
                         });

INSTANTIATE_TEST_SUITE_P(Strangers, NoHands, ::testing::ValuesIn(strangers()),
                         [](const auto& each) { return each.param.name; });

}  // namespace
}  // namespace piste::test
