// A mount that gives: the boresight follows a Gauss-Markov process. Told of it, the filter's errors are what it says of
// them; told of a constant, they are not.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "piste/math/statistics.h"
#include "piste/math/units.h"
#include "piste/sim/random.h"
#include "piste/smoother/rts.h"
#include "support/simulated_case.h"
#include "support/thorough.h"

namespace piste::test {
namespace {

const int kDraws = seeds(20, 100);
constexpr double kCorrelationTime = 15;
const GaussMarkov kGiving{{0.2 * kDegree, 0.3 * kDegree, 0.2 * kDegree}, kCorrelationTime};

/// A ski run whose reference sits on a mount that gives, and the boresight at every fix.
struct Flexing {
  Case c;
  std::vector<double> time;
  std::vector<Quaterniond> q_rb;

  explicit Flexing(std::uint64_t seed)
      : c(make_case("easy_ski", 30, seed, [](Scenario& s) {
          s.motion.rest_before = 5;
          s.motion.run = 40;
          s.motion.rest_after = 1;
          s.attitude = read_scenario(s.file).attitude;
          s.attitude[0].drift.reset();
        })) {
    DriftPath path(kGiving, {seed, "mount"});
    for (EulerFix& fix : c.simulation.attitude[0].fixes) {
      const Quaterniond turn = so3_exp(path.value());  // R_wr = R_wb (Exp(d) R_rb)ᵀ
      fix.angles = to_euler(from_euler(fix.angles) * turn.conjugate());
      time.push_back(fix.time);
      q_rb.push_back(turn * c.scenario.imus[0].q_rb);
      path.advance(1 / c.scenario.attitude[0].rate);
    }
    c.options.estimate.push_back(Block::kBoresight);
  }
};

/// eᵀP⁻¹e of the boresight as it stands, e = Log of truth against Exp(drift) R_rb.
double nees(const StateLayout& layout, const Estimate& x, const Covariance& P, const Quaterniond& truth) {
  const Quaterniond turn = so3_exp(x.boresight_drift);
  const Vector3d error = so3_log(truth * (turn * x.q_rb).conjugate());
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(3, layout.size());
  J.middleCols<3>(layout.offset(Block::kBoresight)) = turn.toRotationMatrix();
  if (layout.has(Block::kBoresightDrift)) {
    J.middleCols<3>(layout.offset(Block::kBoresightDrift)) = so3_left_jacobian(x.boresight_drift);
  }
  const Matrix3d covariance = J * P * J.transpose();
  return error.dot(covariance.llt().solve(error));
}

struct Nees {
  double filter = 0, smoother = 0;  ///< a degree of freedom, mean over runs: filter at the end, smoother in the middle
};

Nees mean_nees(bool told) {
  Nees mean;
  for (int seed = 1; seed <= kDraws; ++seed) {
    Flexing flexing(static_cast<std::uint64_t>(seed));
    Case& c = flexing.c;
    if (told) {
      c.options.attitude[0].boresight_drift = kGiving;
      c.options.estimate.push_back(Block::kBoresightDrift);
    }
    const Log log = c.log();
    const double heading = to_euler(c.simulation.bodies[0].at(c.simulation.plate.start_time()).q_wb).z();
    const Start start = find_start(log, c.options, {InitialHeading::Source::kValue, heading, 2 * kDegree}).start;
    const FilterRun run = run_filter(log, c.options, start, Keep::kHistory);
    const auto row_at = [&](double since) {
      std::size_t row = 0;
      while (row + 1 < run.solution.size() && run.solution.time(row) < c.under_way() + since) ++row;
      return row;
    };
    const std::size_t middle = row_at(20), end = row_at(38);
    const auto truth = [&](double t) {
      const auto next = std::lower_bound(flexing.time.begin(), flexing.time.end(), t - 1e-6);
      return flexing.q_rb[static_cast<std::size_t>(next - flexing.time.begin())];
    };
    smooth_rows(run, {middle, end}, [&](std::size_t row, const FilterState& filtered, const SmoothedState& smoothed) {
      const StateLayout& layout = run.solution.layout();
      const Quaterniond q_rb = truth(filtered.time);
      if (row == end) mean.filter += nees(layout, filtered.x, filtered.P, q_rb) / (3 * kDraws);
      if (row == middle) mean.smoother += nees(layout, smoothed.x, smoothed.P, q_rb) / (3 * kDraws);
    });
  }
  fmt::print("{}: NEES per state, filter {:.2f}, smoother {:.2f}\n", told ? "told that it gives" : "told a constant",
             mean.filter, mean.smoother);
  return mean;
}

TEST(Flexing, ErrorsAreWhatTheFilterSaysWhereItIsTold) {
  const Band band = chi_squared_band(0.999, 3, kDraws);
  const Nees told = mean_nees(true);
  EXPECT_TRUE(band.contains(told.filter)) << told.filter << " outside " << band.low << " to " << band.high;
  EXPECT_TRUE(band.contains(told.smoother)) << told.smoother << " outside " << band.low << " to " << band.high;
  const Nees constant = mean_nees(false);
  EXPECT_GT(constant.filter, 3 * band.high);
  EXPECT_GT(constant.smoother, 3 * band.high);
}

}  // namespace
}  // namespace piste::test
