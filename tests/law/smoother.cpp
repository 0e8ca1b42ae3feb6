// The smoother against one dense least-squares problem over the whole run, linear and Gaussian.

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "filter/considered.h"
#include "filter/feeder.h"
#include "filter/filter_walk.h"
#include "math/linear_algebra.h"
#include "piste/smoother/rts.h"
#include "smoother/lagged_errors.h"
#include "support/synthetic_log.h"

namespace piste {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using test::SyntheticRun;

// A root of a covariance that may be singular, with as many columns as it has directions.
MatrixXd root(const MatrixXd& P) {
  constexpr double kNone = 1e-14;  // of a variance: rounding
  const VectorXd sigma = P.diagonal().cwiseSqrt();
  const VectorXd inverse = (sigma.array() > 0).select(sigma.cwiseInverse(), 0);
  const Eigensystem eigen = eigensystem(inverse.asDiagonal() * P * inverse.asDiagonal());
  MatrixXd out(P.rows(), (eigen.values.array() > kNone).count());
  Eigen::Index column = 0;
  for (Eigen::Index k = 0; k < eigen.values.size(); ++k) {
    if (eigen.values(k) > kNone)
      out.col(column++) = std::sqrt(eigen.values(k)) * sigma.cwiseProduct(eigen.vectors.col(k));
  }
  return out;
}

// Of what a step adds.
MatrixXd root_of_noise(const StateLayout& layout, const Transition& t) {
  MatrixXd Q = MatrixXd::Zero(layout.size(), layout.size());
  Q.topLeftCorner<9, 9>() = t.noise;
  for (const Block b : layout.blocks()) {
    const auto& variance = t.variance[static_cast<std::size_t>(index_of(b))];
    Q.diagonal().segment(layout.offset(b), info(b).size) += variance.head(info(b).size);
  }
  return root(Q);
}

// Error of every epoch as an affine function of whitened unknowns: the start's error and the noise of every step. What
// the filter measured are equations in them, solved at once; nothing here runs backwards or knows a gain. It takes down
// what the filter does as it does it (src/filter/filter_walk.h), and nothing of what a History has stored.
class Batch {
 public:
  /// The whole run of a filter.
  explicit Batch(const SyntheticRun& s) : layout_(filter_layout(s.options)), considered_(s.options, layout_) {
    KalmanFilter filter(s.options, s.log.world, s.start);
    const int n = layout_.size();
    offset_.setZero(n);
    A_.setZero(n, 0);
    add_unknowns(root(filter.covariance()));
    FilterWalk walk(filter, *this);
    for (Feeder feeder(s.log, place_at(s.log, s.start.time, {}), walk); !feeder.done();) feeder.step();
    walk.finish();
    covariance_ = inverse(normal_);
    solution_ = covariance_ * right_;
    for (int i = 0; i < 2; ++i) solution_ += covariance_ * (right_ - normal_ * solution_);  // what rounding left
  }

  void add_step(const Transition& t) {
    const MatrixXd Phi = dense_transition(layout_, t);
    A_ = (Phi * A_).eval();
    offset_ = (Phi * offset_).eval();
    add_unknowns(root_of_noise(layout_, t));
  }

  void add_correction(const Update& u) { add_correction(u, reset_jacobian(FullError::Zero()), {}, {}); }

  void add_correction(const Update& u, const ResetJacobian& reset, const Estimate&, const std::optional<Standing>&) {
    const MatrixXd H = u.H.topRows(u.rows);
    const MatrixXd R = u.S.topLeftCorner(u.rows, u.rows) - H * u.PHt.leftCols(u.rows);
    const MatrixXd HA = H * A_, weighted = solve_symmetric(R, HA);
    normal_ += HA.transpose() * weighted;
    const MatrixXd seen = known_ * HA.transpose();
    known_ -= seen * solve_symmetric(MatrixXd(HA * seen + R), MatrixXd(seen.transpose()));
    right_ += weighted.transpose() * (u.residual.head(u.rows) - H * offset_);
    // The estimate was moved by `moved`: the error about it now.
    const VectorXd moved = gain(u) * u.residual;
    // Considered states stay where they are, by a noise as large as the correction that they do not take.
    if (!considered_.none()) {
      const MatrixXd K = gain(u), all = K * u.S * K.transpose();
      ErrorVector estimated = ErrorVector::Ones(layout_.size());
      considered_.hold(estimated);
      const VectorXd is_considered = 1 - estimated.array();
      add_unknowns(root(is_considered.asDiagonal() * all * is_considered.asDiagonal()));
    }
    MatrixXd G = MatrixXd::Identity(layout_.size(), layout_.size());
    const int v = layout_.offset(Block::kVelocity), b = layout_.offset(Block::kBoresight),
              m = layout_.offset(Block::kVehicleMounting);
    G.block<6, 6>(v, v) = reset.velocity_attitude;
    G.block<3, 3>(0, layout_.offset(Block::kAttitude)) = reset.position_attitude;
    if (const int l = layout_.offset(Block::kLeverArm); l >= 0) G.block<3, 3>(0, l) = reset.position_lever_arm;
    if (b >= 0) G.block<3, 3>(b, b) = reset.mountings[0];
    if (m >= 0) G.block<3, 3>(m, m) = reset.mountings[1];
    A_ = (G * A_).eval();
    offset_ = (G * (offset_ - moved)).eval();
  }

  // A score that the data gave wrongly: the equations lose it, and the estimate moved by P times it.
  void add_score_correction(const ScaleScore& removed, const ErrorVector&, bool) {
    VectorXd score = VectorXd::Zero(layout_.size());
    for (const auto& [block, at] : {std::pair{Block::kGyroScale, 0}, std::pair{Block::kAccelScale, 3}}) {
      if (layout_.has(block)) score.segment<3>(layout_.offset(block)) = removed.segment<3>(at);
    }
    const VectorXd told = A_.transpose() * score;
    right_ -= told;
    offset_ += A_ * (known_ * told);
  }

  static void add_inflation(const ErrorVector&) { FAIL() << "the covariance grew without a step"; }
  static void add_moved(const ErrorVector&) { FAIL() << "there is no reference"; }
  void end_row(const FilterState& state) { epochs_.push_back({A_, offset_, state.x}); }

  std::size_t size() const { return epochs_.size(); }
  /// What the filter had at an epoch, and of its error there the mean and the covariance.
  const Estimate& filtered(std::size_t i) const { return epochs_[i].x; }
  ErrorVector mean(std::size_t i) const {
    const Epoch& e = epochs_[i];
    return e.A * solution_.head(e.A.cols()) + e.offset;
  }
  Covariance covariance(std::size_t i) const { return of_both(epochs_[i].A, epochs_[i].A); }
  /// E[(a · e_i) (b · e_j)] of the errors at two epochs.
  double covariance(std::size_t i, const VectorXd& a, std::size_t j, const VectorXd& b) const {
    return a.dot(of_both(epochs_[i].A, epochs_[j].A) * b);
  }
  /// E[θ_i θ_jᵀ] of the attitude at two epochs.
  Matrix3d attitude_covariance(std::size_t i, std::size_t j) const {
    const int a = layout_.offset(Block::kAttitude);
    return of_both(epochs_[i].A.middleRows<3>(a), epochs_[j].A.middleRows<3>(a));
  }

 private:
  struct Epoch {
    MatrixXd A;  // by the unknowns until then
    VectorXd offset;
    Estimate x;
  };
  // They enter the error by `columns`.
  void add_unknowns(const MatrixXd& columns) {
    const Eigen::Index before = A_.cols(), all = before + columns.cols();
    A_.conservativeResize(Eigen::NoChange, all);
    A_.rightCols(columns.cols()) = columns;
    for (MatrixXd* m : {&normal_, &known_}) {
      MatrixXd larger = MatrixXd::Identity(all, all);
      larger.topLeftCorner(before, before) = *m;
      *m = larger;
    }
    right_.conservativeResize(all);
    right_.tail(columns.cols()).setZero();
  }
  MatrixXd of_both(const MatrixXd& A, const MatrixXd& B) const {
    return A * covariance_.topLeftCorner(A.cols(), B.cols()) * B.transpose();
  }
  StateLayout layout_;
  Considered considered_;
  MatrixXd A_;  // the error now: A times the unknowns, and the offset
  VectorXd offset_;
  MatrixXd normal_, known_;  // known: the inverse of `normal` so far
  VectorXd right_;
  std::vector<Epoch> epochs_;
  MatrixXd covariance_;  // of the unknowns
  VectorXd solution_;
};

void expect_near(const Vector3d& a, const Vector3d& b, const char* what, std::size_t row) {
  EXPECT_LT((a - b).cwiseAbs().maxCoeff(), 1e-6 * b.maxCoeff()) << what << " of row " << row << ": " << a.transpose();
}

class Smoother : public testing::TestWithParam<std::vector<Block>> {};

INSTANTIATE_TEST_SUITE_P(Rts, Smoother,
                         testing::Values(std::vector<Block>{}, test::all_blocks(),
                                         std::vector<Block>{Block::kGyroBias, Block::kAccelBias, Block::kAccelDrift}));

// Three IMUs in place of the one, whose scales act across the axes of their mean. What they differ by is not measured.
SyntheticRun with_turned_imus(double duration) {
  SyntheticRun s = test::synthetic_run(
      duration, {Block::kGyroBias, Block::kGyroDrift, Block::kAccelDrift, Block::kGyroScale, Block::kAccelScale});
  s.options.imus.assign(3, s.options.sensor);
  s.options.unit_axes = {Matrix3d::Identity(), so3_exp(Vector3d(0.1, -0.7, 0.3)).toRotationMatrix(),
                         so3_exp(Vector3d(0.2, 0.4, 0.1)).toRotationMatrix()};
  s.options.estimate = with_implied_blocks(s.options, s.options.estimate);
  return s;
}

void expect_dense_batch_solution(SyntheticRun s) {
  s.options.behaviour.rest.interval = 0.1;
  const FilterRun run = run_filter(s.log, s.options, s.start, Keep::kHistory);
  const Solution smoothed = smooth_rts(run);
  ASSERT_EQ(smoothed.size(), s.log.imu.size());
  for (const Innovation& i : run.solution.innovations) ASSERT_EQ(i.outcome, Outcome::kUsed);
  ASSERT_GT(run.solution.innovations.size(), 20U);

  const StateLayout layout = filter_layout(s.options);
  const Batch batch(s);
  ASSERT_EQ(batch.size(), smoothed.size());
  double moved = 0;
  for (std::size_t row = 0; row < batch.size(); ++row) {
    const FullError correction = expand(layout, batch.mean(row));
    const Estimate expected = boxplus(batch.filtered(row), correction);
    Covariance P = batch.covariance(row);
    const VectorXd sigma = P.diagonal().cwiseSqrt();
    reset(P, layout, reset_jacobian(correction));
    const FullError difference = boxminus(smoothed.estimate(row), expected);
    for (const Block b : smoothed.layout().blocks()) {
      for (int k = 0; k < info(b).size; ++k) {
        const double scale = sigma(layout.offset(b) + k);
        EXPECT_LE(std::abs(difference(full_offset(b) + k)), 1e-6 * scale) << info(b).name << " of row " << row;
        if (scale > 0) moved = std::max(moved, std::abs(correction(full_offset(b) + k)) / scale);
      }
    }
    const Sigmas is = smoothed.sigmas(row), wanted = sigmas_of(smoothed.world(), expected, layout, P);
    expect_near(is.position, wanted.position, "position", row);
    expect_near(is.velocity, wanted.velocity, "velocity", row);
    expect_near(is.euler, wanted.euler, "euler", row);
    for (const Block b : smoothed.layout().blocks()) {
      const int o = full_offset(b), size = info(b).size;
      const double largest = wanted.blocks.segment(o, size).maxCoeff();
      EXPECT_LE((is.blocks - wanted.blocks).segment(o, size).cwiseAbs().maxCoeff(), 1e-6 * largest)
          << info(b).name << " of row " << row;
    }
  }
  EXPECT_GT(moved, 0.5) << "the smoother had nothing to do";
}

TEST_P(Smoother, IsTheDenseBatchSolution) { expect_dense_batch_solution(test::synthetic_run(0.5, GetParam())); }

TEST(Rts, OfUnitsThatAreTurnedIsTheDenseBatchSolution) { expect_dense_batch_solution(with_turned_imus(0.5)); }

TEST_P(Smoother, AttitudeErrorsGoTogetherAsInTheDenseBatchSolution) {
  SyntheticRun s = test::synthetic_run(0.5, GetParam());
  s.options.behaviour.rest.interval = 0.1;
  const FilterRun run = run_filter(s.log, s.options, s.start, Keep::kHistory);
  std::vector<AttitudeLag> lags;
  smooth_rts(run, {}, nullptr, &lags);
  const StateLayout layout = filter_layout(s.options);
  const Batch batch(s);
  const auto turn = [&](std::size_t i) {
    return Matrix3d(reset_jacobian(expand(layout, batch.mean(i))).velocity_attitude.bottomRightCorner<3, 3>());
  };
  ASSERT_GT(lags.size(), 300U);
  double longest = 0, weakest = 1;
  for (std::size_t pair = 0; pair < lags.size(); pair += 5) {
    const AttitudeLag& l = lags[pair];
    ASSERT_LE(l.early, l.late);
    EXPECT_NEAR(l.lag, run.solution.time(l.late) - run.solution.time(l.early), 1e-9);
    const auto expected = [&](std::size_t i, std::size_t j) {
      return Matrix3d(turn(i) * batch.attitude_covariance(i, j) * turn(j).transpose());
    };
    const Matrix3d early = expected(l.early, l.early), late = expected(l.late, l.late);
    const Matrix3d scale = early.diagonal().cwiseSqrt() * late.diagonal().cwiseSqrt().transpose();
    const Matrix3d covariance = expected(l.early, l.late);
    EXPECT_LT((l.covariance - covariance).cwiseQuotient(scale).cwiseAbs().maxCoeff(), 1e-6)
        << l.early << " and " << l.late << ", is:\n"
        << l.covariance << "\nexpected:\n"
        << covariance;
    EXPECT_LT((l.of_early - early).cwiseAbs().maxCoeff(), 1e-6 * early.maxCoeff());
    EXPECT_LT((l.of_late - late).cwiseAbs().maxCoeff(), 1e-6 * late.maxCoeff());
    longest = std::max(longest, l.lag);
    weakest = std::min(weakest, covariance.cwiseQuotient(scale).diagonal().minCoeff());
  }
  EXPECT_GT(longest, 0.45);
  EXPECT_LT(weakest, 0.999) << "all errors were the same one";
}

// Of positions along several directions, as the times of crossings need them.
TEST_P(Smoother, NumbersOfTheErrorGoTogetherAsInTheDenseBatchSolution) {
  SyntheticRun s = test::synthetic_run(0.5, GetParam());
  s.options.behaviour.rest.interval = 0.1;
  const FilterRun run = run_filter(s.log, s.options, s.start, Keep::kHistory);
  const Batch batch(s);
  const auto whole = [&](const ErrorNumber& number) {
    VectorXd a = VectorXd::Zero(filter_layout(s.options).size());
    a.head<9>() = number.a;
    return a;
  };
  std::vector<ErrorNumber> numbers;
  const std::vector<std::size_t> rows{0, 3, 3, 17, 18, 30, batch.size() - 1};
  for (const std::size_t row : rows) {
    numbers.push_back({.row = row});
    numbers.back().a.head<3>() = Vector3d(1, 0.1 * static_cast<double>(numbers.size()), -0.3);
  }
  const std::vector<std::size_t> early{0, 1, 3, 4};
  const MatrixXd is = lagged_covariances(run, numbers, early);
  const std::vector<double> alone = variances(run, numbers);
  const auto expected = [&](std::size_t i, std::size_t j) {
    return batch.covariance(numbers[i].row, whole(numbers[i]), numbers[j].row, whole(numbers[j]));
  };
  for (std::size_t i = 0; i < numbers.size(); ++i) EXPECT_NEAR(alone[i], expected(i, i), 1e-6 * expected(i, i));
  double weakest = 1;
  for (std::size_t k = 0; k < early.size(); ++k) {
    for (std::size_t j = early[k]; j < numbers.size(); ++j) {
      const double scale = std::sqrt(expected(early[k], early[k]) * expected(j, j)), right = expected(early[k], j);
      EXPECT_NEAR(is(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(j)), right, 1e-6 * scale)
          << early[k] << " and " << j;
      weakest = std::min(weakest, right / scale);
    }
  }
  EXPECT_LT(weakest, 0.99) << "all errors were the same one";
}

TEST_P(Smoother, IsNeverLessSureThanTheFilterAndEndsWithIt) {
  const SyntheticRun s = test::synthetic_run(4, GetParam());
  const FilterRun run = run_filter(s.log, s.options, s.start, Keep::kHistory);
  const Solution smoothed = smooth_rts(run);
  const StateLayout& layout = smoothed.layout();
  double gained = 0;
  for (std::size_t i = 0; i < smoothed.size(); ++i) {
    const Sigmas f = run.solution.sigmas(i), b = smoothed.sigmas(i);
    EXPECT_TRUE((b.position.array() <= f.position.array() * (1 + 1e-9)).all()) << i;
    for (const Block block : layout.blocks()) {
      if (is_rotation(block) && block != Block::kAttitude) continue;  // Euler sigmas depend on the estimate
      const int o = full_offset(block), size = info(block).size;
      EXPECT_TRUE((b.blocks.segment(o, size).array() <= f.blocks.segment(o, size).array() * (1 + 1e-9)).all())
          << info(block).name << " " << i;
    }
    gained = std::max(gained, 1 - b.position.norm() / f.position.norm());
  }
  EXPECT_GT(gained, 0.2);
  const std::size_t last = smoothed.size() - 1;
  const FullError difference = boxminus(smoothed.estimate(last), run.solution.estimate(last));
  EXPECT_LT(difference.cwiseAbs().maxCoeff(), 1e-14);
}

// The reference of a second pass carries the smoothed error from epoch to epoch instead.
void expect_trajectory_of_the_whole(const SyntheticRun& s) {
  const FilterRun run = run_filter(s.log, s.options, s.start, Keep::kHistory);
  const Solution whole = smooth_rts(run);
  const auto trajectory = std::make_shared<const Reference>(smoothed_trajectory(run));
  ASSERT_EQ(trajectory->size(), whole.size());
  Reference::Reader rows(trajectory);
  for (std::size_t i = 0; i < whole.size(); ++i) {
    const Reference::Row& row = rows.at(whole.time(i));
    EXPECT_EQ(row.time, whole.time(i));
    EXPECT_LT(boxminus(row.x, whole.estimate(i)).cwiseAbs().maxCoeff(), 1e-8) << i;
  }
}

TEST(Rts, TheTrajectoryWithoutCovariancesIsThatOfTheWhole) {
  expect_trajectory_of_the_whole(test::synthetic_run(4, test::all_blocks()));
  expect_trajectory_of_the_whole(with_turned_imus(4));
  expect_trajectory_of_the_whole(test::synthetic_run(4, {Block::kGyroBias, Block::kAccelDrift}));
}

// Runs that begin about a smoothed trajectory and go on by themselves.
struct LeavesItsReference {
  SyntheticRun s;
  FilterRun plain, run;
  Solution whole;

  explicit LeavesItsReference(const std::vector<Block>& blocks)
      : s(test::synthetic_run(4, blocks)), plain(run_filter(s.log, s.options, s.start, Keep::kHistory)) {
    // Within a stretch between two fixes, so that rows on both sides of the change share their constants.
    const double middle = plain.solution.time(plain.solution.size() / 2 + 13);
    FilterOptions less = s.options;  // so that the reference is not the solution
    less.gnss[0].use_velocity = false;
    const FilterRun half = run_filter(s.log, less, s.start, Keep::kHistory, {}, {.end = middle});
    const auto about = std::make_shared<const Reference>(smoothed_trajectory(half));
    run = run_filter(s.log, s.options, s.start, Keep::kHistory, {}, {}, about);
    whole = smooth_rts(run);
  }
};

TEST(Rts, ARunThatLeavesItsReferenceEndsWithTheFilter) {
  const LeavesItsReference r(test::all_blocks());
  ASSERT_EQ(r.run.solution.size(), r.plain.solution.size());
  const std::size_t last = r.whole.size() - 1;
  EXPECT_LT(boxminus(r.whole.estimate(last), r.run.solution.estimate(last)).cwiseAbs().maxCoeff(), 1e-14);
  const auto trajectory = std::make_shared<const Reference>(smoothed_trajectory(r.run));
  Reference::Reader rows(trajectory);
  for (std::size_t i = 0; i < r.whole.size(); ++i) {
    const FullError apart = boxminus(rows.at(r.whole.time(i)).x, r.whole.estimate(i)),
                    sigmas = r.whole.sigmas(i).blocks;
    for (const Block b : r.whole.layout().blocks()) {
      if (is_rotation(b)) continue;  // whose sigmas are of Euler angles
      const auto part = [&](const FullError& e) { return e.segment(full_offset(b), info(b).size).array(); };
      EXPECT_TRUE((part(apart).abs() <= 1e-5 * part(sigmas) + 1e-9).all()) << info(b).name << " of row " << i;
    }
  }
}

// Where it matters little about what a run is linearised, it is smoothed as one without a reference.
TEST(Rts, ARunThatLeavesItsReferenceIsSmoothedAsAWhole) {
  const LeavesItsReference r({Block::kGyroBias, Block::kAccelBias, Block::kAccelDrift, Block::kLeverArm});
  const Solution usual = smooth_rts(r.plain);
  for (std::size_t i = 0; i < r.whole.size(); ++i) {
    const FullError apart = boxminus(r.whole.estimate(i), usual.estimate(i));
    const Sigmas is = r.whole.sigmas(i), wanted = usual.sigmas(i);
    for (const Block b : r.whole.layout().blocks()) {
      if (is_navigation(b)) continue;
      const auto part = [&](const FullError& e) { return e.segment(full_offset(b), info(b).size).array(); };
      EXPECT_TRUE((part(apart).abs() <= 0.1 * part(wanted.blocks)).all()) << info(b).name << " of row " << i;
      EXPECT_TRUE(((part(is.blocks) / part(wanted.blocks)).log().abs() < 0.02).all()) << info(b).name << " " << i;
    }
  }
}

TEST(Rts, RowsThatAreAskedForAreThoseOfTheWhole) {
  const SyntheticRun s = test::synthetic_run(4, test::all_blocks());
  const FilterRun run = run_filter(s.log, s.options, s.start, Keep::kHistory);
  SmoothedState whole_start, start;
  const Solution whole = smooth_rts(run, {}, &whole_start);
  const std::vector<std::size_t> rows{120, 121, 300};
  for (SmoothedState* at_start : {&start, static_cast<SmoothedState*>(nullptr)}) {
    std::vector<std::size_t> seen;
    const auto observe = [&](std::size_t row, const FilterState& filtered, const SmoothedState& smoothed) {
      seen.push_back(row);
      EXPECT_EQ(filtered.time, run.solution.time(row));
      EXPECT_TRUE(boxminus(smoothed.x, whole.estimate(row)).isZero(0)) << row;
      EXPECT_TRUE(sigmas_of(whole.world(), smoothed.x, whole.layout(), smoothed.P).blocks == whole.sigmas(row).blocks)
          << row;
    };
    smooth_rows(run, rows, observe, at_start);
    EXPECT_EQ(seen, std::vector<std::size_t>(rows.rbegin(), rows.rend()));
  }
  EXPECT_TRUE(boxminus(start.x, whole_start.x).isZero(0));
  EXPECT_TRUE(start.P == whole_start.P);
}

}  // namespace
}  // namespace piste
