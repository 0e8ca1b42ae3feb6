// What a page carries is what the data are: columns to their steps, every innovation, charts by their names.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "piste/io/solution_io.h"
#include "piste/replay/replay.h"
#include "piste/report/html.h"
#include "piste/sim/random.h"
#include "report/packed_columns.h"
#include "report/packed_table.h"
#include "report/replay_charts.h"
#include "report/synthetic_run.h"
#include "support/text_file.h"

namespace piste {
namespace {

using test::columns_of;
using test::inflated;

std::map<std::string, std::vector<double>> table_of(const page::Data& data, const std::string& name) {
  for (const auto& [table, json] : data.tables) {
    if (table == name) return columns_of(json);
  }
  ADD_FAILURE() << "no table " << name;
  return {};
}

TEST(PackedTable, KeepsValuesToHalfAStep) {
  RandomStream random(1, "packed");
  std::vector<double> smooth, noisy, holes, sigma;
  for (int i = 0; i < 5000; ++i) {
    smooth.push_back(1e6 * std::sin(0.001 * i));
    noisy.push_back(-4e4 + 300 * random.normal());
    holes.push_back(i % 7 == 3 || i < 2 ? std::nan("") : i * 0.25);
    sigma.push_back(i == 9 ? 0 : std::exp(4 * random.normal()));
  }
  page::PackedTable table;
  table.add("smooth", smooth, 1e-4);
  table.add("noisy", noisy, 0.01);
  table.add("holes", holes, 0.25);
  table.add_sigma("sigma", sigma);
  const std::string json = table.json();
  EXPECT_LT(json.size(), 50'000U);  // of 160 000 bytes as doubles
  auto there = columns_of(json);
  ASSERT_EQ(there["smooth"].size(), smooth.size());
  for (std::size_t i = 0; i < smooth.size(); ++i) {
    EXPECT_NEAR(there["smooth"][i], smooth[i], 0.501e-4);
    EXPECT_NEAR(there["noisy"][i], noisy[i], 0.00501);
    EXPECT_EQ(std::isnan(there["holes"][i]), std::isnan(holes[i])) << i;
    if (!std::isnan(holes[i])) {
      EXPECT_EQ(there["holes"][i], holes[i]);
    }
    EXPECT_NEAR(there["sigma"][i], sigma[i], 0.0026 * sigma[i] + 1e-14);
  }
  EXPECT_EQ(columns_of(page::PackedTable().json()).size(), 0U);
}

TEST(PackedTable, StepsAreASmallPartOfTheLeastSigma) {
  EXPECT_DOUBLE_EQ(page::step_below(std::vector{0.5, 0., 0.1}, 1e-5), 0.1 / 150);
  EXPECT_DOUBLE_EQ(page::step_below(std::vector{1e-6}, 1e-5), 1e-5);
  EXPECT_DOUBLE_EQ(page::step_below({}, 1e-5), 1e-5);
}

TEST(PageData, BytesBecomeText) {
  EXPECT_EQ(page::base64(""), "");
  EXPECT_EQ(page::base64("f"), "Zg==");
  EXPECT_EQ(page::base64("fo"), "Zm8=");
  EXPECT_EQ(page::base64("foobar"), "Zm9vYmFy");
  std::string bytes;
  for (unsigned i = 0; i < 100'000; ++i) bytes += static_cast<char>(i * i % 251);
  EXPECT_EQ(inflated(page::deflated(bytes), bytes.size() + 1), bytes);
}

page::Data data_of(const Log& log, const Solution& filtered, const Solution* smoothed = nullptr, double rate = 0) {
  return page::replay_data({.title = "run",
                            .version = "1",
                            .config_text = "",
                            .log = &log,
                            .filtered = &filtered,
                            .smoothed = smoothed,
                            .rate = rate});
}

Sigmas no_sigmas() {
  Sigmas s;
  s.position = s.velocity = s.euler = Vector3d::Zero();
  return s;
}

// Every row of the file is on the page: to a three-hundredth of its sigma, its sigma to a quarter of a per cent.
TEST(PageData, RowsAreThoseOfTheFiles) {
  const auto run = test::synthetic_run(50);
  const page::Data data = data_of(run.log, run.filtered, &run.smoothed);
  const NumberTable file = navigation_table(run.smoothed);
  auto page = table_of(data, "smoothed");
  const std::size_t width = file.names.size(), rows = file.values.size() / width;
  for (const auto& [value, sigma] : {std::pair{"height_m", "sigma_down_m"},
                                     {"velocity_east_m_s", "sigma_velocity_east_m_s"},
                                     {"heading_deg", "sigma_heading_deg"}}) {
    const auto of = [&](const char* name) { return std::ranges::find(file.names, name) - file.names.begin(); };
    ASSERT_EQ(page[value].size(), rows);
    for (std::size_t i = 0; i < rows; ++i) {
      const double *row = &file.values[i * width], s = row[of(sigma)];
      ASSERT_NEAR(page[value][i], row[of(value)], 0.0034 * s + 1e-5);
      ASSERT_NEAR(page[sigma][i], s, 0.0026 * s);
      ASSERT_NEAR(page["time_s"][i], row[0], 1e-6);
    }
  }
  for (const char* chart : {"roll", "pitch", "heading", "velocity_north", "velocity_east", "height"}) {
    std::string shortest;
    for (const page::Chart& c : data.charts) {
      if (c.name.find(chart) != std::string::npos && (shortest.empty() || c.name.size() < shortest.size()))
        shortest = c.name;
    }
    EXPECT_EQ(shortest, chart);
  }
  EXPECT_EQ(table_of(data_of(run.log, run.filtered, nullptr, 10), "filtered")["time_s"].size(), 1601U) << "at 10 Hz";
}

// Beyond 100 000 rows a page has every n-th, and says so.
TEST(PageData, ALongRunHasItsRowsAtALowerRate) {
  EXPECT_EQ(rows_apart(kKeptRows), 1U);
  for (const std::size_t all : {kKeptRows + 1, std::size_t{360'000}, std::size_t{36'000'000}}) {
    EXPECT_LE(all / rows_apart(all) + 2, kKeptRows / 2) << all;
  }
  Log log;
  Solution run{StateLayout(), World()};
  const std::size_t all = kKeptRows + 10;
  for (std::size_t i = 0; i < all; ++i) run.append(0.01 * static_cast<double>(i), {}, no_sigmas());
  log.imu.resize(all);
  for (std::size_t i = 0; i < all; ++i) log.imu[i] = {.time = 0.01 * static_cast<double>(i), .interval = 0.01};
  const page::Data data = data_of(log, run);
  EXPECT_EQ(table_of(data, "filtered")["time_s"].size(), all / 3 + 1);
  EXPECT_LE(table_of(data, "motion")["time_s"].size(), 12'001U);
  const std::string page =
      html_report({.title = "run", .version = "1", .config_text = "", .log = &log, .filtered = &run});
  EXPECT_TRUE(test::contains(page, "Curves hold 33337 of the 100010 rows of the files, 33.3 a second"));
}

// Between the samples of an interval a signal may reach further than its mean: least and largest are there.
TEST(PageData, SignalsKeepTheirExtremes) {
  Log log;
  Solution run{StateLayout(), World()};
  constexpr std::size_t kSamples = 50'000;
  for (std::size_t i = 0; i < kSamples; ++i) {
    const double t = 0.01 * static_cast<double>(i);
    log.imu.push_back(
        {.time = t, .interval = 0.01, .dtheta = Vector3d(0, 0, i == 4321 ? 0.02 : 0.01), .dvel = Vector3d::Zero()});
    if (i % 100 == 0) run.append(t, {}, no_sigmas());
  }
  auto motion = table_of(data_of(log, run), "motion");
  const auto [low, high] = std::ranges::minmax(motion["rate_z_most"]);
  EXPECT_NEAR(low, kDegreesPerRadian, 1e-2);
  EXPECT_NEAR(high, 2 * kDegreesPerRadian, 1e-2);
  EXPECT_LT(std::ranges::max(motion["rate_z"]), 1.5 * kDegreesPerRadian);
}

TEST(PageData, EveryInnovationIsThere) {
  Log log;
  log.gnss.resize(1);
  Solution run{StateLayout(), World()};
  run.append(0, {}, no_sigmas());
  run.append(100, {}, no_sigmas());
  run.sources = {"gnss[0].position", "rest.rate", "barometer"};
  RandomStream random(1, "residuals");
  constexpr int kFixes = 36000;
  for (int i = 0; i < kFixes; ++i) {
    const Vector3d sigma(0.02, 0.02, 0.03), z = (i % 50 == 7 ? 3 : 1) * random.normal3();
    const bool out = z.squaredNorm() > 16.27;
    log.gnss[0].push_back(
        {.time = 0.1 * i + 0.02, .position = Vector3d(i, -i, 3), .sigma_position = sigma, .velocity = {}});
    run.innovations.push_back({.time = 0.1 * i,
                               .source = 0,
                               .residual = z.cwiseProduct(sigma),
                               .sigma = sigma,
                               .nis = z.squaredNorm(),
                               .gate = 16.27,
                               .outcome = out ? Outcome::kRejected : Outcome::kUsed,
                               .late = 0.02});
  }
  run.innovations.push_back({.time = 1, .source = 1, .residual = {1, 1, 1}, .sigma = {1, 1, 1}, .nis = 3});
  run.innovations.push_back({.time = 2, .source = 2, .dof = 1, .residual = {1, 0, 0}, .sigma = {1, 1, 1}, .nis = 1});
  const page::Data data = data_of(log, run);
  auto fixes = table_of(data, "source_0");
  ASSERT_EQ(fixes["time_s"].size(), static_cast<std::size_t>(kFixes));
  for (std::size_t i = 0; i < kFixes; ++i) {
    const Innovation& v = run.innovations[i];
    ASSERT_NEAR(fixes["residual_3"][i], v.residual.z(), 0.0101 * v.sigma.z());
    ASSERT_NEAR(fixes["sigma_1"][i], v.sigma.x(), 0.0051 * v.sigma.x());
    ASSERT_NEAR(fixes["nis"][i], v.nis, 0.0051 * v.nis);
    ASSERT_EQ(fixes["outcome"][i], static_cast<double>(v.outcome));
    ASSERT_NEAR(fixes["north_m"][i], static_cast<double>(i), 1e-5) << "the fix, although it was late";
  }
  EXPECT_EQ(table_of(data, "source_1").count("residual_3"), 1U);
  EXPECT_EQ(table_of(data, "source_2").count("residual_2"), 0U) << "a height has one row";
}

TEST(PageData, NumbersHaveNoExponents) {
  const auto run = test::synthetic_run(20);
  const std::array blocks{Block::kGyroScale};
  Solution scaled{StateLayout(blocks), World()};
  Estimate x;
  x.gyro_scale = {-0.02262, 0.01, 0};
  Sigmas s = no_sigmas();
  s.blocks.segment<3>(full_offset(Block::kGyroScale)) = Vector3d(5.3e-4, 2e-3, 1e-5);
  scaled.append(0, x, s);
  const std::string page =
      html_report({.title = "run", .version = "1", .config_text = "", .log = &run.log, .filtered = &scaled});
  for (const char* text : {"x: -22620 ± 530", "y: 10000 ± 2000", "z: 0 ± 10"}) EXPECT_TRUE(test::contains(page, text));
  EXPECT_TRUE(page::replay_data({.title = "", .version = "", .config_text = "", .log = &run.log, .filtered = &scaled})
                  .charts.size() > 5);
  const Solution empty{StateLayout(), World()};
  EXPECT_TRUE(data_of(run.log, empty).charts.empty());
}

}  // namespace
}  // namespace piste
