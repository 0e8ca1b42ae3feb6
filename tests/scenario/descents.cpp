// Gained times against the truth: three simulated skiers on one course, with an L1/L2 and with an L1 receiver. Are the
// sigmas of gained times true, at gates, in sections and along the line, and how small are they?

#include "piste/descents/descents.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "piste/math/statistics.h"
#include "piste/math/units.h"
#include "piste/outputs/folders.h"
#include "piste/sim/simulation.h"
#include "support/places.h"
#include "support/text_file.h"
#include "support/thorough.h"

namespace piste::test {
namespace {

constexpr int kSkiers = 3;
constexpr double kSpeed = 15;  // m/s, of the course

/// GainedErrors of gained times in sigmas: one list for each three skiers, who share the first of them.
struct GainedErrors {
  std::vector<std::vector<double>> of_course;
  double largest_sigma = 0, squares = 0, count = 0;  // at 15 m/s: of another speed a place has another time
  void add(double error, double sigma, double speed) {
    of_course.back().push_back(error / sigma);
    largest_sigma = std::max(largest_sigma, sigma * speed / kSpeed);
    squares += square(sigma * speed / kSpeed);
    ++count;
  }
  double rms_sigma() const { return std::sqrt(squares / count); }
};

/// One receiver's.
struct ShownGains {
  GainedErrors gates, sections, along;
  double independent = 0;  // the largest sigma at gates at that speed, were two epochs of one run independent
};

// The true time at which a body passes the plane of a passage, which is in east, north, up at `origin`.
double true_time(const Truth& body, const Passage& passage, const Geodetic& origin, double about) {
  const auto north_east_down = [](const Vector3d& enu) { return Vector3d(enu.y(), enu.x(), -enu.z()); };
  const World local(origin);
  const Vector3d place = body.world().from_geodetic(local.to_geodetic(north_east_down(passage.place)));
  const Matrix3d turn = body.world().rotation_wn(place) * local.rotation_wn(north_east_down(passage.place)).transpose();
  return crossing_time(body, place, turn * north_east_down(passage.direction), about);
}

// Gained against the first skier since the first passage, in truth.
std::vector<std::vector<double>> truly_gained(const std::vector<Truth>& bodies, const std::vector<Passage>& passages,
                                              const Geodetic& origin) {
  std::vector<std::vector<double>> since(bodies.size()), gained(bodies.size());
  for (std::size_t r = 0; r < bodies.size(); ++r) {
    for (const Passage& p : passages) since[r].push_back(true_time(bodies[r], p, origin, p.runs[r].time));
    const double first = since[r].front();
    for (double& time : since[r]) time -= first;
    for (std::size_t i = 0; i < passages.size(); ++i) gained[r].push_back(since[0][i] - since[r][i]);
  }
  return gained;
}

void compare_with_truth(const std::vector<Descent>& runs, const std::vector<Gate>& gates,
                        const std::vector<Truth>& bodies, ShownGains& shown) {
  const DescentReport report = compare_descents(runs, gates);
  const Geodetic& origin = runs.front().track.place.front();
  const auto at_gates = truly_gained(bodies, report.gates, origin), along = truly_gained(bodies, report.along, origin);
  for (GainedErrors* errors : {&shown.gates, &shown.sections, &shown.along}) errors->of_course.emplace_back();
  for (std::size_t r = 1; r < runs.size(); ++r) {
    for (std::size_t i = 1; i < report.gates.size(); ++i) {
      const Crossing &at = report.gates[i].runs[r], &start = report.gates[0].runs[r];
      const Crossing &at_0 = report.gates[i].runs[0], &start_0 = report.gates[0].runs[0];
      shown.gates.add(at.gained - at_gates[r][i], at.sigma_gained, at.speed);
      const double independent = std::sqrt(square(at.sigma_time) + square(start.sigma_time) + square(at_0.sigma_time) +
                                           square(start_0.sigma_time));
      shown.independent = std::max(shown.independent, independent * at.speed / kSpeed);
      const Section& section = report.sections[i - 1];
      shown.sections.add(section.gained[r] - (at_gates[r][i] - at_gates[r][i - 1]), section.sigma[r], at.speed);
    }
    for (std::size_t i = 1; i < report.along.size(); ++i) {
      const Crossing& at = report.along[i].runs[r];
      shown.along.add(at.gained - along[r][i], at.sigma_gained, at.speed);
    }
  }
}

class Skiers : public testing::Test {
 protected:
  // Simulates three skiers, and compares them as each receiver has them.
  void ski(const Scenario& course, std::uint64_t first_seed) {
    std::vector<Truth> bodies;
    std::array<std::vector<Descent>, 2> runs;
    for (int k = 0; k < kSkiers; ++k) {
      const std::uint64_t seed = first_seed + static_cast<std::uint64_t>(k);
      const Simulation simulation = simulate(course, seed);
      OutputFolder output(folder_.path());
      write_simulation(output, "", course, simulation, seed);
      output.commit();
      bodies.push_back(simulation.bodies.front());
      for (std::size_t i = 0; i < runs.size(); ++i) {
        const std::string file = folder_.write(
            "run.yaml",
            fmt::format("imu: {{file: mt9a_1.csv, sensor: {}/config/sensors/xsens_mt9a.yaml}}\n"
                        "gnss: {{file: {}, lever_arm: -0.06 0.03 -0.42 m}}\n"
                        "estimate: [gyro_bias, accel_bias, gyro_drift, accel_drift, gyro_scale, accel_scale]\n",
                        source_folder(),
                        i == 0 ? "gnss.csv" : "gnss_l1.csv, drift: {sigma: 0.4 0.4 0.7 m, correlation_time: 60 s}"));
        runs[i].push_back(descent_of(read_replay_config(file), "", fmt::format("skier_{}", k + 1)));
      }
    }
    const std::vector<Gate> gates = read_gates(folder_ / "gates.csv");
    for (std::size_t i = 0; i < runs.size(); ++i) compare_with_truth(runs[i], gates, bodies, shown_[i]);
  }

  TemporaryFolder folder_;
  std::array<ShownGains, 2> shown_;  // L1/L2, L1
};

// The share inside k sigma, in the binomial band of as many draws as there are pairs of skiers: the errors of one pair
// are alike from gate to gate, so that all its gates are no more than that. And the mean square of the errors in
// sigmas.
void expect_true_sigmas(const GainedErrors& errors, const std::string& what) {
  const double pairs = static_cast<double>(errors.of_course.size()) * (kSkiers - 1);
  std::vector<double> all;
  for (const auto& of_one : errors.of_course) all.insert(all.end(), of_one.begin(), of_one.end());
  const auto count = static_cast<double>(all.size());
  constexpr double kBand = 3;  // standard deviations
  std::string line = fmt::format("{}: {} errors", what, all.size());
  for (const int k : {1, 2, 3}) {
    const double expected = std::erf(k / std::sqrt(2.0)), one = std::sqrt(expected * (1 - expected) / pairs);
    const auto inside = std::count_if(all.begin(), all.end(), [k](double e) { return std::abs(e) <= k; });
    const double share = static_cast<double>(inside) / count;
    EXPECT_LE(std::abs(share - expected), kBand * one) << what << " inside " << k << " sigma";
    line += fmt::format(", inside {} sigma {:.4f} of {:.4f} ± {:.4f}", k, share, expected, one);
  }
  double largest = 0, square_sum = 0;
  for (const double e : all) {
    largest = std::max(largest, std::abs(e));
    square_sum += square(e);
  }
  EXPECT_LT(largest, 5) << what;
  EXPECT_LE(std::abs(square_sum / count - 1), kBand * std::sqrt(2 / pairs)) << what;
  fmt::print("{}, mean square {:.3f}, largest {:.2f}, sigma {:.2f} ms rms, {:.2f} at most\n", line, square_sum / count,
             largest, 1e3 * errors.rms_sigma(), 1e3 * errors.largest_sigma);
}

TEST_F(Skiers, GainedTimesAreAsSureAsTheySay) {
  Scenario course = read_scenario(kSource / "config/scenarios/course.yaml");
  course.motion.rest_before = 30;
  course.motion.rest_after = 5;
  const int courses = seeds(4, 100);
  for (int i = 0; i < courses; ++i) ski(course, static_cast<std::uint64_t>(1 + kSkiers * i));
  for (std::size_t i = 0; i < shown_.size(); ++i) {
    const std::string name = i == 0 ? "L1/L2" : "L1";
    const ShownGains& shown = shown_[i];
    expect_true_sigmas(shown.gates, name + " at gates");
    expect_true_sigmas(shown.sections, name + " in sections");
    expect_true_sigmas(shown.along, name + " along the line");
    fmt::print("{}: at gates {:.2f} ms were two epochs of one run independent\n", name, 1e3 * shown.independent);
  }
  EXPECT_LE(shown_[0].gates.largest_sigma, 1e-3);
  EXPECT_LE(shown_[0].along.largest_sigma, 1e-3);
  EXPECT_LE(shown_[1].gates.rms_sigma(), 25e-3);
  EXPECT_LE(shown_[1].gates.largest_sigma, 27e-3);  // of the last gate: it grows with the time since the first
  EXPECT_LE(shown_[1].sections.largest_sigma, 6e-3);
  // What the covariance between epochs is for: a slow error of the receiver is alike at both.
  EXPECT_LT(shown_[1].gates.largest_sigma, shown_[1].independent / 1.5);
  EXPECT_LT(shown_[1].sections.largest_sigma, shown_[1].independent / 5);
}

}  // namespace
}  // namespace piste::test
