#include "piste/core/solution.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <string_view>

#include "support/blocks.h"
#include "support/random.h"

namespace piste {
namespace {

using test::Random;

Sigmas random_sigmas(Random& random, const StateLayout& layout) {
  Sigmas s{{random.vector(), random.vector(), random.vector()}, FullError::Zero(), random.vector(), random.vector()};
  for (const Block b : layout.blocks()) {
    if (index_of(b) > index_of(Block::kAttitude))
      s.blocks.segment(full_offset(b), info(b).size) = random.matrix(info(b).size, 1);
  }
  return s;
}

TEST(Solution, RowsComeBackWhole) {
  Random random(1);
  for (const auto& blocks :
       {std::vector<Block>{}, std::vector<Block>{Block::kGyroBias, Block::kBoresight}, test::most_blocks()}) {
    Solution solution(StateLayout(blocks), World({0.8, 0.1, 500}));
    std::vector<Estimate> estimates;
    std::vector<Sigmas> sigmas;
    const Estimate constant = random.estimate();
    solution.fixed = constant;
    for (int i = 0; i < 5; ++i) {
      Estimate x = constant;
      const Estimate other = random.estimate();
      x.q_wb = other.q_wb;
      x.v_wb = other.v_wb;
      x.p_wb = other.p_wb;
      for (const Block b : solution.layout().blocks()) {
        if (is_rotation(b)) {
          rotation(x, b) = rotation(other, b);
        } else {
          additive(x, b) = additive(other, b);
        }
      }
      estimates.push_back(x);
      sigmas.push_back(random_sigmas(random, solution.layout()));
    }
    for (std::size_t i = 0; i < 5; ++i) solution.append(static_cast<double>(i), estimates[4 - i], sigmas[4 - i]);
    for (std::size_t i = 0; i < 5; ++i) solution.set(i, static_cast<double>(i) + 0.5, estimates[i], sigmas[i]);
    ASSERT_EQ(solution.size(), 5U);
    for (std::size_t i = 0; i < 5; ++i) {
      EXPECT_EQ(solution.time(i), static_cast<double>(i) + 0.5);
      const Estimate x = solution.estimate(i);
      EXPECT_TRUE(x.q_wb.coeffs() == estimates[i].q_wb.coeffs());
      EXPECT_TRUE(x.q_rb.coeffs() == estimates[i].q_rb.coeffs());
      for (const BlockInfo& row : kBlocks) {
        if (is_rotation(row.block)) {
          EXPECT_TRUE(rotation(x, row.block).coeffs() == rotation(estimates[i], row.block).coeffs()) << row.name;
          continue;
        }
        EXPECT_TRUE(additive(x, row.block) == additive(estimates[i], row.block)) << row.name;
      }
      const Sigmas s = solution.sigmas(i);
      EXPECT_TRUE(s.position == sigmas[i].position && s.velocity == sigmas[i].velocity && s.euler == sigmas[i].euler);
      EXPECT_TRUE(s.gyro_total_bias == sigmas[i].gyro_total_bias && s.accel_total_bias == sigmas[i].accel_total_bias);
      EXPECT_TRUE(s.blocks == sigmas[i].blocks);
    }
  }
}

TEST(Solution, SigmasAreTheOrdinaryOnes) {
  Random random(2);
  const StateLayout layout(test::most_blocks());
  Estimate x = random.estimate();
  const Covariance P = 1e-4 * random.covariance(layout.size());
  const World world({0.8, 0.1, 500});
  x.p_wb = world.from_geodetic({0.9, 0.2, 100});  // a thousand kilometres away
  const Sigmas s = sigmas_of(world, x, layout, P);
  const Eigen::Matrix<double, 9, 9> T = ordinary_from_invariant(x);
  const Eigen::Matrix<double, 9, 9> ordinary = T * P.topLeftCorner<9, 9>() * T.transpose();
  const Matrix3d R_nw = world.rotation_wn(x.p_wb).transpose();
  const auto level = [&](const Matrix3d& covariance) -> Matrix3d { return R_nw * covariance * R_nw.transpose(); };
  EXPECT_LT((s.position - level(ordinary.topLeftCorner<3, 3>()).diagonal().cwiseSqrt()).norm(), 1e-15);
  EXPECT_LT((s.velocity - level(ordinary.block<3, 3>(3, 3)).diagonal().cwiseSqrt()).norm(), 1e-13);
  EXPECT_LT((s.euler - euler_sigma(Quaterniond(R_nw) * x.q_wb, level(P.block<3, 3>(6, 6)))).norm(), 1e-14);
  // Of the sum of two correlated errors.
  const int b = layout.offset(Block::kAccelBias), d = layout.offset(Block::kAccelDrift);
  for (int i = 0; i < 3; ++i) {
    const double variance = P(b + i, b + i) + P(d + i, d + i) + 2 * P(b + i, d + i);
    EXPECT_NEAR(s.accel_total_bias(i), std::sqrt(variance), 1e-15);
  }
}

// A total bias is what of bias and drift is estimated.
TEST(Solution, TotalBiasOfWhatIsEstimated) {
  Random random(3);
  const StateLayout layout(std::vector<Block>{Block::kGyroBias, Block::kAccelDrift});
  const Covariance P = random.covariance(layout.size());
  const Sigmas s = sigmas_of(World(), random.estimate(), layout, P);
  const int gyro = layout.offset(Block::kGyroBias), accel = layout.offset(Block::kAccelDrift);
  for (int i = 0; i < 3; ++i) {
    EXPECT_DOUBLE_EQ(s.gyro_total_bias(i), std::sqrt(P(gyro + i, gyro + i)));
    EXPECT_DOUBLE_EQ(s.accel_total_bias(i), std::sqrt(P(accel + i, accel + i)));
  }
  const StateLayout none;
  EXPECT_EQ(sigmas_of(World(), {}, none, P.topLeftCorner(9, 9)).gyro_total_bias, Vector3d::Zero());
}

TEST(Solution, EveryOutcomeHasItsName) {
  std::set<std::string_view> names;
  for (const Outcome outcome :
       {Outcome::kUsed, Outcome::kRejected, Outcome::kReadmitted, Outcome::kDisputed, Outcome::kRepeated}) {
    EXPECT_TRUE(names.insert(outcome_name(outcome)).second) << outcome_name(outcome);
  }
  EXPECT_EQ(outcome_name(Outcome::kRejected), "rejected");
}

TEST(Solution, NavigationIsLocal) {
  const World world({0.8, 0.1, 500});
  Solution solution(StateLayout(), world);
  Estimate x;
  // A thousand kilometres away, level and heading north there, at rest but for ten metres a second east.
  const Geodetic there{0.9, 0.2, 100};
  x.p_wb = world.from_geodetic(there);
  const Matrix3d R_wn = world.rotation_wn(x.p_wb);
  x.q_wb = Quaterniond(R_wn) * from_euler({0.1, 0.2, 0.3});
  x.v_wb = R_wn * Vector3d(0, 10, 0);
  solution.append(1, x, {});
  const auto shown = solution.navigation(0);
  EXPECT_NEAR(shown.position.latitude, 0.9, 1e-12);
  EXPECT_NEAR(shown.position.longitude, 0.2, 1e-12);
  EXPECT_NEAR(shown.position.height, 100, 1e-6);
  EXPECT_LT((shown.velocity - Vector3d(0, 10, 0)).norm(), 1e-12);
  EXPECT_LT((shown.euler - Vector3d(0.1, 0.2, 0.3)).norm(), 1e-12);
}

}  // namespace
}  // namespace piste
