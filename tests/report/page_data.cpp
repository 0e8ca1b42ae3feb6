// What a page shows is what the data are: spread, shares and extremes of residuals, steps of heights, turns of
// headings.

#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "piste/report/html.h"
#include "piste/sim/random.h"
#include "report/charts.h"
#include "report/synthetic_run.h"
#include "support/text_file.h"

namespace piste {
namespace {

using charts::Chart;

/// The values of a chart as the page has them; null is NaN.
struct Shown {
  std::vector<double> time;
  std::vector<std::string> labels;
  std::vector<std::vector<double>> curves, sigmas;
};

std::vector<double> numbers(const YAML::Node& array) {
  std::vector<double> out;
  for (const YAML::Node& value : array) out.push_back(value.IsNull() ? std::nan("") : value.as<double>());
  return out;
}

Shown shown(const YAML::Node& chart) {
  Shown out{.time = numbers(chart["time"]), .labels = {}, .curves = {}, .sigmas = {}};
  for (const YAML::Node& curve : chart["curves"]) {
    out.labels.push_back(curve["label"].as<std::string>());
    out.curves.push_back(numbers(curve["value"]));
    if (curve["sigma"]) out.sigmas.push_back(numbers(curve["sigma"]));
  }
  return out;
}

/// The chart with that title in the list that stands after `list` in the page's script.
Shown shown(const std::string& page, const std::string& list, const std::string& title) {
  const std::size_t begin = page.find(list) + list.size(), end = page.find("}\n]", begin) + 3;
  for (const YAML::Node& chart : YAML::Load(page.substr(begin, end - begin))) {  // JSON is YAML
    if (chart["title"].as<std::string>() == title) return shown(chart);
  }
  ADD_FAILURE() << "no chart " << title;
  return {};
}

Sigmas no_sigmas() {
  Sigmas s;
  s.position = s.velocity = s.euler = Vector3d::Zero();
  return s;
}

std::string page_of(const Log& log, const Solution& filtered) {
  return html_report({.title = "run", .version = "1", .config_text = "", .log = &log, .filtered = &filtered});
}

/// Root mean square, shares beyond 1 and 2, and extremes.
std::vector<double> statistics(const std::vector<double>& values) {
  double square = 0, beyond_1 = 0, beyond_2 = 0;
  for (const double v : values) {
    square += v * v;
    beyond_1 += std::abs(v) > 1 ? 1 : 0;
    beyond_2 += std::abs(v) > 2 ? 1 : 0;
  }
  const auto n = static_cast<double>(values.size());
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  return {std::sqrt(square / n), beyond_1 / n, beyond_2 / n, *low, *high};
}

TEST(PageData, ResidualsOfAnHourHaveTheSpreadAndTheSharesOfTheData) {
  Log log;
  Solution run{StateLayout(), World()};
  run.append(0, {}, no_sigmas());
  run.sources = {"gnss[0].position", "rest.rate"};
  RandomStream random(1, "residuals");
  std::vector<std::vector<double>> data(3);
  double rejected = 0;
  constexpr int kFixes = 36000;
  for (int i = 0; i < kFixes; ++i) {
    const Vector3d sigma(0.02, 0.02, 0.03), z = (i % 50 == 7 ? 3 : 1) * random.normal3();
    const bool out = z.squaredNorm() > 16.27;
    rejected += out ? 1 : 0;
    for (int a = 0; a < 3; ++a) data[static_cast<std::size_t>(a)].push_back(z(a));
    run.innovations.push_back({.time = 0.1 * i,
                               .source = 0,
                               .residual = z.cwiseProduct(sigma),
                               .sigma = sigma,
                               .nis = z.squaredNorm(),
                               .gate = 16.27,
                               .outcome = out ? Outcome::kRejected : Outcome::kUsed});
  }
  run.innovations.push_back({.time = 1, .source = 1, .residual = {1, 1, 1}, .sigma = {1, 1, 1}, .nis = 3});
  const std::string page = page_of(log, run);
  EXPECT_LT(page.size(), 2'000'000U);
  const Shown residuals = shown(page, "innovations: ", "gnss[0].position: residual over its sigma");
  EXPECT_EQ(residuals.labels, (std::vector<std::string>{"north", "east", "down"}));
  EXPECT_LT(residuals.time.size(), 3000U);
  for (std::size_t a = 0; a < 3; ++a) {
    const auto there = statistics(data[a]), here = statistics(residuals.curves.at(a));
    for (std::size_t k = 0; k < there.size(); ++k)
      EXPECT_NEAR(here[k], there[k], 0.02 * std::abs(there[k])) << residuals.labels[a] << ", statistic " << k;
  }
  const Shown nis = shown(page, "innovations: ", "gnss[0].position: NIS");
  ASSERT_EQ(nis.labels, (std::vector<std::string>{"used", "rejected", "gate"}));
  const auto dots =
      std::count_if(nis.curves[1].begin(), nis.curves[1].end(), [](double v) { return std::isfinite(v); });
  EXPECT_NEAR(static_cast<double>(dots) / static_cast<double>(nis.time.size()), rejected / kFixes,
              0.02 * rejected / kFixes + 1e-3);
  EXPECT_EQ(shown(page, "innovations: ", "rest.rate: residual over its sigma").labels,
            (std::vector<std::string>{"x", "y", "z"}));
}

TEST(PageData, ResidualsHaveTheAxesThatAreMeasured) {
  Log log;
  Solution run{StateLayout(), World()};
  run.append(0, {}, no_sigmas());
  const std::vector<std::pair<std::string, std::vector<std::string>>> sources{{"gnss[0].velocity", {"north", "east"}},
                                                                              {"vehicle.right", {"right"}},
                                                                              {"vehicle.down", {"down"}},
                                                                              {"odometer", {"forward"}},
                                                                              {"barometer", {"height"}},
                                                                              {"heading", {"heading", "pitch"}},
                                                                              {"parity[1].accel", {"x", "y", "z"}}};
  for (const auto& [name, axes] : sources) {
    const auto rows = static_cast<int>(axes.size());
    const auto source = static_cast<int>(run.sources.size());
    run.sources.push_back(name);
    // The filter has 0 and 1 beyond the rows.
    for (int i = 0; i < 3; ++i) {
      Innovation z{.time = 0.1 * i,
                   .source = source,
                   .dof = rows,
                   .residual = Vector3d::Zero(),
                   .sigma = Vector3d::Ones(),
                   .nis = 1};
      z.residual.head(rows).setConstant(i + 1);
      run.innovations.push_back(z);
    }
  }
  const std::string page = page_of(log, run);
  for (const auto& [name, axes] : sources)
    EXPECT_EQ(shown(page, "innovations: ", name + ": residual over its sigma").labels, axes) << name;
}

TEST(PageData, HeightsHaveNoStepsThatTheirSigmasWouldShow) {
  const auto run = test::synthetic_run(20);
  const World world({0.81, 0.12, 4000});
  Solution high{StateLayout(), world};
  for (int i = 0; i < 500; ++i) {
    Estimate x;
    x.p_wb.z() = -0.0004 * i;
    Sigmas s = no_sigmas();
    s.position.setConstant(0.003);
    high.append(i, x, s);
  }
  const Shown height = shown(page_of(run.log, high), "\"filtered\": ", "Height above the ellipsoid");
  ASSERT_EQ(height.time.size(), high.size());
  for (std::size_t i = 0; i < high.size(); ++i)
    EXPECT_NEAR(height.curves[0][i], high.navigation(i).position.height, 0.0003) << i;
}

TEST(PageData, AHeadingThatTurnsStaysWithinItsChart) {
  Solution turning{StateLayout(), World()};
  constexpr int kEpochs = 20000;
  constexpr double kStep = 0.36;  // deg: twenty turns
  Sigmas s = no_sigmas();
  s.euler.setConstant(0.01);
  for (int i = 0; i < kEpochs; ++i) {
    Estimate x;
    x.q_wb = from_euler(Vector3d(0.05 * std::sin(0.01 * i), 0, i * kStep * kDegree));
    turning.append(i, x, s);
  }
  const std::string page = page_of({}, turning);
  const Shown heading = shown(page, "\"filtered\": ", "Attitude: heading");
  int breaks = 0;
  for (std::size_t i = 0; i < heading.time.size(); ++i) {
    const double value = heading.curves[0][i];
    if (std::isnan(value)) {
      ++breaks;
      continue;
    }
    EXPECT_LE(std::abs(value), 200);
    EXPECT_NEAR(std::remainder(value - kStep * heading.time[i], 360), 0, 0.01);
    if (i > 0 && !std::isnan(heading.curves[0][i - 1])) {
      EXPECT_GE(value, heading.curves[0][i - 1]);
    }
  }
  EXPECT_EQ(breaks, 20);
  const Shown roll = shown(page, "\"filtered\": ", "Attitude: roll");
  EXPECT_NEAR(*std::max_element(roll.curves[0].begin(), roll.curves[0].end()), 0.05 * kDegreesPerRadian, 0.01);
}

TEST(PageData, HasNoEmptyChartAndNoExponents) {
  auto run = test::synthetic_run(20);
  const auto titles = [&](const Solution& s) {
    std::vector<std::string> all;
    for (const Chart& chart : charts::of_solution(s, s.time(0))) all.push_back(chart.title);
    return all;
  };
  const auto has = [](const std::vector<std::string>& all, const std::string& title) {
    return std::find(all.begin(), all.end(), title) != all.end();
  };
  EXPECT_TRUE(has(titles(run.filtered), "Sigma of velocity"));
  Solution certain{StateLayout(), World()};  // its sigmas are 0, which a logarithmic scale does not have
  certain.append(0, {}, no_sigmas());
  EXPECT_FALSE(has(titles(certain), "Sigma of velocity"));
  EXPECT_TRUE(has(titles(certain), "Velocity"));
  EXPECT_TRUE(charts::of_solution(Solution(StateLayout(), World()), 0).empty());

  const std::array blocks{Block::kGyroScale};
  Solution scaled{StateLayout(blocks), World()};
  Estimate x;
  x.gyro_scale = {-0.02262, 0.01, 0};
  Sigmas s = no_sigmas();
  s.blocks.segment<3>(full_offset(Block::kGyroScale)) = Vector3d(5.3e-4, 2e-3, 1e-5);
  scaled.append(0, x, s);
  const std::string page = page_of(run.log, scaled);
  for (const char* text : {"x: -22620 ± 530", "y: 10000 ± 2000", "z: 0 ± 10"}) EXPECT_TRUE(test::contains(page, text));
}

}  // namespace
}  // namespace piste
