// `study` as its user sees it: a campaign of two short runs, whole and broken.

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <map>

#include "piste/math/statistics.h"
#include "support/navigation.h"
#include "support/places.h"
#include "support/program.h"
#include "support/thorough.h"

namespace piste::test {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> fields_of(const std::string& line) {
  std::vector<std::string> fields;
  for (std::size_t at = 0; at <= line.size();) {
    const std::size_t comma = std::min(line.find(',', at), line.size());
    fields.push_back(line.substr(at, comma - at));
    at = comma + 1;
  }
  return fields;
}

/// The shipped campaign's first ski run and first lap, with short rests and two IMUs, in `in`.
class Study : public testing::Test {
 protected:
  void SetUp() override {
    const std::string shipped = source_folder() + "/config/scenarios/campaign";
    const std::string motion = "motion: {rest_before: 30 s, run: 60 s, rest_after: 20 s, net_turn: 240 deg}";
    folder_.write("short.yaml",
                  fmt::format("base: {0}.yaml\nmems:\n  - {{imu: mt9a_1, name: MT-9A 1, article_sensor: sensor 1}}\n"
                              "  - {{imu: mt9a_2, name: MT-9A 2, article_sensor: sensor 2}}\nruns:\n"
                              "  - {{name: ski-1, activity: ski, scenario: {0}/ski.yaml, {1}}}\n"
                              "  - {{name: lap, activity: bicycle, scenario: {0}/bicycle.yaml, {1}}}\n",
                              shipped, motion));
    const Said said = simulate();
    ASSERT_EQ(said.code, 0) << said.err;
  }

  Said simulate(std::vector<std::string> words = {}) const {
    words.insert(words.begin(), "short.yaml");
    words.insert(words.end(), {"--output", "in", "--quiet"});
    return run_program(program("simulate"), words, folder_);
  }
  Said study(std::vector<std::string> words = {}) const {
    words.insert(words.begin(), "in/campaign.yaml");
    words.insert(words.end(), {"--output", "out"});
    return run_program(program("study"), words, folder_);
  }
  std::string header(const std::string& file) const {
    const std::string text = read_text(folder_ / ("out/" + file));
    return text.substr(0, text.find('\n'));
  }
  /// Everything that is missing, as one text.
  std::string missing() const {
    std::string all;
    const YAML::Node summary = YAML::LoadFile(folder_ / "out/summary.json");
    for (const YAML::Node& m : summary["missing"]) all += m.as<std::string>() + "\n";
    return all;
  }
  /// Rewrites every row of a csv but its header; the fields are numbers as text.
  void edit(const std::string& name, const std::function<void(std::vector<std::string>&)>& change) const {
    std::ifstream in(folder_ / name);
    std::string line, out;
    for (bool first = true; std::getline(in, line); first = false) {
      if (!first) {
        std::vector<std::string> fields = fields_of(line);
        change(fields);
        if (fields.empty()) continue;
        line = fmt::format("{}", fmt::join(fields, ","));
      }
      out += line + "\n";
    }
    in.close();
    folder_.write(name, out);
  }
  // Of the two runs as they are.
  void expect_contract(const Said& said) const;
  void expect_all_as_one_are_better(const Said& said) const;
  void expect_gyroscopes_agree() const;
  // Squares of error over sigma, by method, quantity and triad.
  struct Cell;
  void add_to(std::map<std::string, Cell>& cells) const;
  static void expect_intervals_are_true(const std::map<std::string, Cell>& cells, int campaigns);

  TemporaryFolder folder_;
};

void Study::expect_contract(const Said& said) const {
  EXPECT_EQ(said.err, "");
  EXPECT_TRUE(contains(said.out, "written to out"));
  const std::string bias = "sensor,axis,unit,bias,std,standard_error,p_value,significant";
  for (const char* file : {"table_1.csv", "table_6.csv", "filter_bias.csv"}) EXPECT_EQ(header(file), bias) << file;
  EXPECT_EQ(header("table_2.csv"), "sensor,axis,unit,before,after,difference,p_value");
  for (const char* file : {"table_3.csv", "table_4.csv"}) {
    EXPECT_EQ(header(file), "sensor,axis,unit,value,std,standard_error,p_value,reverse_value") << file;
  }
  EXPECT_EQ(header("table_5.csv"), "sensor,axis,correlation");
  EXPECT_EQ(header("table_7.csv"),
            "method,estimates,position_rmse_m,velocity_rmse_m_s,attitude_rmse_deg,outage_drift_m,remark");
  EXPECT_TRUE(fs::exists(folder_ / "out/study.html"));
  for (const char* figure : {"figure_07_accel", "figure_08_gyro", "figure_09_accel", "figure_10_gyro", "figure_13",
                             "figure_14", "figure_15_accel", "figure_16", "figure_17", "table_5", "ranking"}) {
    EXPECT_TRUE(fs::exists(folder_ / fmt::format("out/figures/{}.svg", figure))) << figure;
  }
  const YAML::Node summary = YAML::LoadFile(folder_ / "out/summary.json");
  EXPECT_TRUE(summary["simulated"].as<bool>());
  ASSERT_EQ(summary["runs"].size(), 2U);
  EXPECT_TRUE(contains(missing(), "other_runs")) << "two runs do not tell how a scale changes from run to run";

  // A reference that comes late makes scales that are negative corrections in the article's direction, positive ones
  // in the other.
  const std::string timing = read_text(folder_ / "out/timing.csv");
  for (const char* axis : {"fx", "fy", "fz", "wx", "wy", "wz"}) {
    const auto at = timing.find(fmt::format("\n10,{},", axis));
    ASSERT_NE(at, std::string::npos) << timing;
    const std::vector<std::string> row = fields_of(timing.substr(at + 1, timing.find('\n', at + 1) - at - 1));
    EXPECT_LT(std::stod(row[2]), axis[0] == 'f' ? -0.02 : 0) << axis;
    EXPECT_GT(std::stod(row[4]), axis[0] == 'f' ? 0.02 : 0) << axis;
  }
}

// What was put in, as each method could see it, is as far from the estimates as their intervals say: the mean square of
// error over sigma (a half width over 1.96) within the band of as many draws. The two IMUs of a run share the
// reference's errors, so that only runs and axes count. docs/study.md explains which do not hold: a line that the
// gyroscopes' noise flattens, and constants that know of no drift, are exempted; a filter's sigma is that of an
// instant, and cautious for the mean over the run, so that it has no lower end. Of seeds 1 to 6, the band of which is
// 0.40 to 1.95, the others lie between 0.61 and 1.47.
struct Study::Cell {
  double squares = 0, count = 0;
};

void Study::add_to(std::map<std::string, Cell>& cells) const {
  std::ifstream estimates(folder_ / "out/estimates.csv");
  std::string line;
  for (std::getline(estimates, line); std::getline(estimates, line);) {
    const std::vector<std::string> f = fields_of(line);
    ASSERT_EQ(f.size(), 12U);
    ASSERT_FALSE(f[11].empty()) << line;
    const double in_sigmas = 1.96 * (std::stod(f[6]) - std::stod(f[11])) / std::stod(f[10]);
    Cell& cell = cells[fmt::format("{} {} {}", f[4], f[5], f[2][0] == 'f' ? "accel" : "gyro")];
    cell.squares += in_sigmas * in_sigmas;
    cell.count += 1;
  }
}

void Study::expect_intervals_are_true(const std::map<std::string, Cell>& cells, int campaigns) {
  constexpr int kRuns = 2, kImus = 2, kAxes = 3;
  const Band band = chi_squared_band(0.999, 1, campaigns * kRuns * kAxes);
  std::size_t held = 0;
  for (const auto& [name, cell] : cells) {
    EXPECT_EQ(cell.count, campaigns * kRuns * kImus * kAxes) << name;
    const double mean = cell.squares / cell.count;
    if (name.starts_with("joint ") || name.starts_with("constant_")) continue;
    ++held;
    EXPECT_LT(mean, band.high) << name;
    if (name.find("_filtered") == std::string::npos) {
      EXPECT_GT(mean, band.low) << name;
    }
  }
  EXPECT_EQ(cells.size(), 78U);
  EXPECT_EQ(held, 58U);
  // The drift of which a constant does not know is there: beyond the band where there are enough draws to tell, and
  // always beside the model that knows it.
  for (const char* kind : {"_smoothed bias accel", "_attitude_smoothed bias accel"}) {
    const auto mean = [&](const char* model) {
      const Cell& cell = cells.at(std::string(model) + kind);
      return cell.squares / cell.count;
    };
    EXPECT_GT(mean("constant"), 2 * mean("gauss_markov")) << kind;
    if (campaigns > 1) {
      EXPECT_GT(mean("constant"), band.high) << kind;
    }
  }
}

TEST_F(Study, IntervalsAreTrue) {
  if (!thorough()) GTEST_SKIP() << "with PISTE_THOROUGH=1";
  std::map<std::string, Cell> cells;
  constexpr int kCampaigns = 6;
  for (int seed = 1; seed <= kCampaigns; ++seed) {
    ASSERT_EQ(simulate({"--seed", std::to_string(seed)}).code, 0);
    ASSERT_EQ(study({"--quiet"}).code, 0);
    add_to(cells);
  }
  expect_intervals_are_true(cells, kCampaigns);
}

// All IMUs as one stand beside the single ones, and are better than one of them.
void Study::expect_all_as_one_are_better(const Said& said) const {
  EXPECT_EQ(header("imus.csv"),
            "sensor,runs,position_rmse_m,velocity_rmse_m_s,attitude_rmse_deg,outage_drift_m,attitude_over_single,"
            "outage_drift_over_single");
  const YAML::Node summary = YAML::LoadFile(folder_ / "out/summary.json");
  const YAML::Node imus = summary["imus"];
  ASSERT_EQ(imus.size(), 3U);
  EXPECT_EQ(imus[0]["name"].as<std::string>(), "MT-9A 1");
  EXPECT_EQ(imus[2]["name"].as<std::string>(), "all as one");
  EXPECT_EQ(imus[2]["runs"].as<int>(), 2);
  for (const char* error : {"attitude_rmse_deg", "outage_drift_m"}) {
    const auto of = [&](std::size_t row) { return imus[row][error].as<double>(); };
    EXPECT_LT(of(2), (of(0) + of(1)) / 2) << error;
  }
  EXPECT_LT(imus[2]["attitude_over_single"].as<double>(), 1);
  const YAML::Node as_one = summary["runs"][0]["as_one"];
  EXPECT_EQ(as_one["imus"].as<std::vector<std::string>>(), (std::vector<std::string>{"MT-9A 1", "MT-9A 2"}));
  EXPECT_EQ(summary["sensors"].size(), 2U) << "they are no sensor of the campaign";
  const std::string page = read_text(folder_ / "out/study.html");
  EXPECT_TRUE(contains(page, "The IMUs compared, and all as one"));
  EXPECT_TRUE(contains(page, "all as one fx")) << "in the tables of biases and scales";
  EXPECT_TRUE(contains(page, "Taken as one, the IMUs have"));
  EXPECT_TRUE(contains(said.out, "all as one"));

  // What was put in, of their mean, lies within five sigmas of what the filter with the reference's attitude found.
  std::ifstream estimates(folder_ / "out/as_one.csv");
  std::string line;
  int compared = 0;
  for (std::getline(estimates, line); std::getline(estimates, line);) {
    const std::vector<std::string> f = fields_of(line);
    ASSERT_EQ(f.size(), 12U);
    EXPECT_EQ(f[1], "all as one");
    if (f[4] != "gauss_markov_attitude_smoothed") continue;
    EXPECT_LT(std::abs(std::stod(f[6]) - std::stod(f[11])), 5 * std::stod(f[10]) / 1.96) << line;
    ++compared;
  }
  EXPECT_EQ(compared, 24) << "two runs of six axes, bias and scale";
}

// Gyroscope biases at rest and from the Gauss-Markov filter agree, which is the article's finding.
void Study::expect_gyroscopes_agree() const {
  std::map<std::string, std::vector<std::string>> gyro_rest;
  int compared = 0, agree = 0;
  std::ifstream estimates(folder_ / "out/estimates.csv");
  std::string line;
  for (std::getline(estimates, line); std::getline(estimates, line);) {
    const std::vector<std::string> f = fields_of(line);
    ASSERT_EQ(f.size(), 12U);
    const std::string place = f[0] + f[1] + f[2];
    if (f[2][0] == 'w' && f[4] == "rest") gyro_rest[place] = f;
    if (f[2][0] != 'w' || f[4] != "gauss_markov_smoothed" || f[5] != "bias") continue;
    const std::vector<std::string>& rest = gyro_rest.at(place);
    const double apart = std::abs(std::stod(f[6]) - std::stod(rest[6]));
    EXPECT_LT(apart, 0.05) << place << " [deg/s]";
    ++compared;
    agree += apart < std::hypot(std::stod(f[10]), std::stod(rest[10]), 0.02) ? 1 : 0;
  }
  EXPECT_EQ(compared, 12);
  EXPECT_GE(agree, 11) << "of 12, each with 0.02 deg/s for the drift from rest to run";
}

// Where the axes of two IMUs are apart, their scales act across those of the mean: with gravity that is a bias, which a
// line for each axis would be wrong by, by five of its sigmas.
TEST_F(Study, LinesOfAllAsOneAreTrueWhereAxesAreApart) {
  const std::string shipped = source_folder() + "/config/scenarios/campaign";
  const std::string sensors = source_folder() + "/config/sensors";
  folder_.write(
      "apart.yaml",
      fmt::format("base: {0}/ski.yaml\nmotion: {{rest_before: 30 s, run: 60 s, rest_after: 20 s}}\nimus:\n"
                  "  - {{name: mt9a_1, sensor: {1}/xsens_mt9a.yaml, rate: 100 Hz, boresight: 1.9 -2.4 2 deg}}\n"
                  "  - {{name: mt9a_2, sensor: {1}/xsens_mt9a.yaml, rate: 100 Hz, boresight: -1 25 -30 deg}}\n"
                  "  - {{name: ln200, sensor: {1}/ln200.yaml, rate: 200 Hz}}\n",
                  shipped, sensors));
  folder_.write("short.yaml", fmt::format("base: {}.yaml\nmems:\n  - {{imu: mt9a_1, name: MT-9A 1}}\n"
                                          "  - {{imu: mt9a_2, name: MT-9A 2}}\nruns:\n"
                                          "  - {{name: apart, activity: ski, scenario: apart.yaml}}\n",
                                          shipped));
  ASSERT_EQ(simulate({"--seed", "1"}).code, 0);
  const Said said = study({"--quiet"});
  ASSERT_EQ(said.code, 0) << said.err;
  std::ifstream estimates(folder_ / "out/as_one.csv");
  std::string line;
  double squares = 0;
  int count = 0;
  for (std::getline(estimates, line); std::getline(estimates, line);) {
    const std::vector<std::string> f = fields_of(line);
    ASSERT_EQ(f.size(), 12U);
    if (f[2][0] != 'f' || (f[4] != "joint_reverse" && f[4] != "joint_both_noisy")) continue;
    squares += std::pow(1.96 * (std::stod(f[6]) - std::stod(f[11])) / std::stod(f[10]), 2);
    ++count;
  }
  EXPECT_EQ(count, 12) << "bias and scale of three axes by two methods";
  EXPECT_LT(std::sqrt(squares / count), 2);
}

// One study, as it lasts for long: one of each thing that it must hold.
TEST_F(Study, HoldsItsContract) {
  ASSERT_EQ(simulate({"--seed", "1"}).code, 0);
  const Said said = study({"--jobs", "2"});
  ASSERT_EQ(said.code, 0) << said.err;
  expect_contract(said);
  expect_all_as_one_are_better(said);
  expect_gyroscopes_agree();
  std::map<std::string, Cell> cells;
  add_to(cells);
  expect_intervals_are_true(cells, 1);
}

TEST_F(Study, WritesTheSameBytesWithAnyNumberOfJobs) {
  if (!thorough()) {  // signals alone, which is quick
    fs::remove(folder_.path() / "in/ski-1/gnss_l1l2.csv");
    fs::remove(folder_.path() / "in/lap/gnss_l1l2.csv");
  }
  const Said quiet = study({"--jobs", "2", "--quiet"});
  ASSERT_EQ(quiet.code, 0) << quiet.err;
  EXPECT_EQ(quiet.out, "");
  fs::rename(folder_.path() / "out", folder_.path() / "two");
  ASSERT_EQ(study({"--jobs", "1"}).code, 0);
  for (const auto& file : fs::recursive_directory_iterator(folder_.path() / "out")) {
    if (!file.is_regular_file()) continue;
    const fs::path name = fs::relative(file.path(), folder_.path() / "out");
    EXPECT_EQ(read_text(file.path()), read_text(folder_.path() / "two" / name)) << name;
  }
}

TEST_F(Study, GoesOnWithoutWhatIsBroken) {
  // One file that is not there, one accelerometer that stands at its range in the run, one run without a rest, cut
  // from the middle of the motion.
  fs::remove(folder_.path() / "in/ski-1/mt9a_2.csv");
  edit("in/ski-1/mt9a_1.csv", [](std::vector<std::string>& f) {
    if (std::stod(f[0]) > 302445 && std::stod(f[0]) < 302455) f[6] = "-19.6133";
  });
  const auto moving = [](std::vector<std::string>& f) {
    const double t = std::stod(f[0]);
    if (t < 302455 || t > 302500) f.clear();
  };
  for (const char* file : {"ln200", "mt9a_1", "mt9a_2", "gnss_l1l2"}) edit(fmt::format("in/lap/{}.csv", file), moving);
  const Said said = study();
  ASSERT_EQ(said.code, 0) << said.err;
  const std::string page = read_text(folder_ / "out/study.html");
  EXPECT_TRUE(contains(missing(), "mt9a_2.csv")) << missing();
  EXPECT_TRUE(contains(page, "mt9a_2.csv: cannot be read"));
  EXPECT_TRUE(contains(page, "samples stand at the sensor&#39;s range")) << "the saturated accelerometer";
  EXPECT_TRUE(contains(page, "there is no rest before the start"));
  EXPECT_TRUE(contains(said.out, "mt9a_2.csv"));
  const std::string rest = read_text(folder_ / "out/table_1.csv"), run = read_text(folder_ / "out/table_3.csv");
  EXPECT_TRUE(contains(rest, "MT-9A 1,fx")) << "of ski-1";
  EXPECT_FALSE(contains(rest, "MT-9A 2,fx")) << "its one run with a rest has no file";
  EXPECT_TRUE(contains(run, "MT-9A 2,fx")) << "of lap";
}

TEST_F(Study, WithoutAReceiverSignalsAreStillCompared) {
  fs::remove(folder_.path() / "in/lap/truth.json");
  fs::remove(folder_.path() / "in/ski-1/gnss_l1l2.csv");
  fs::remove(folder_.path() / "in/lap/gnss_l1l2.csv");
  const Said said = study();
  ASSERT_EQ(said.code, 0) << said.err;
  EXPECT_TRUE(contains(read_text(folder_ / "out/table_4.csv"), "MT-9A 1,fx"));
  EXPECT_EQ(read_text(folder_ / "out/filter_bias.csv"), header("filter_bias.csv") + "\n");
  EXPECT_TRUE(contains(read_text(folder_ / "out/study.html"), "gnss_l1l2.csv"));
  EXPECT_TRUE(contains(read_text(folder_ / "out/study.html"), "what was put in is not known"));
}

TEST_F(Study, RefusesWhatItCannotUse) {
  const std::string text = read_text(folder_ / "in/campaign.yaml");
  folder_.write("in/campaign.yaml", "low_pas: 12 Hz\n" + text);
  EXPECT_EQ(study().code, 2);
  EXPECT_FALSE(fs::exists(folder_ / "out"));
  folder_.write("in/campaign.yaml", text);
  fs::remove_all(folder_.path() / "in/ski-1");
  fs::remove_all(folder_.path() / "in/lap");
  const Said nothing = study();
  EXPECT_EQ(nothing.code, 1);
  EXPECT_TRUE(contains(nothing.err, "ln200.csv")) << nothing.err;
  EXPECT_FALSE(fs::exists(folder_ / "out"));
}

}  // namespace
}  // namespace piste::test
