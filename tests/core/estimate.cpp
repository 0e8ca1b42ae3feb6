#include "piste/core/estimate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "piste/math/so3.h"
#include "support/random.h"

namespace piste {
namespace {

using test::Random;

FullError random_error(Random& random, double size) {
  FullError e;
  for (int k = 0; k < kFullSize; ++k) e(k) = random.gaussian(size);
  return e;
}

TEST(Estimate, MinusUndoesPlus) {
  Random random(1);
  for (const double size : {1e-8, 1e-3, 0.5}) {
    for (int i = 0; i < 20; ++i) {
      const Estimate x = random.estimate();
      const FullError e = random_error(random, size);
      EXPECT_LT((boxminus(boxplus(x, e), x) - e).norm(), 2e-12);
    }
  }
}

TEST(Estimate, PlusUndoesMinus) {
  Random random(2);
  for (int i = 0; i < 20; ++i) {
    const Estimate x = random.estimate(), y = random.estimate();
    const Estimate back = boxplus(x, boxminus(y, x));
    EXPECT_LT(boxminus(back, y).norm(), 1e-11);
  }
}

TEST(Estimate, NoErrorIsNoChange) {
  Random random(3);
  const Estimate x = random.estimate();
  EXPECT_LT(boxminus(boxplus(x, FullError::Zero()), x).norm(), 1e-13);
}

// Two parts of one motion of the group compose, as a curve through it does.
TEST(Estimate, AttitudeAndVelocityAreOneGroupElement) {
  Random random(4);
  const Estimate x = random.estimate();
  FullError e = FullError::Zero();
  e.segment<3>(full_offset(Block::kAttitude)) = random.vector(0.3);
  e.segment<3>(full_offset(Block::kVelocity)) = random.vector(5);
  const Estimate once = boxplus(x, e), twice = boxplus(boxplus(x, 0.5 * e), 0.5 * e);
  EXPECT_LT(boxminus(once, twice).norm(), 1e-13);
  // A pure attitude error turns the velocity with it: in the body it is as it was.
  e.segment<3>(full_offset(Block::kVelocity)).setZero();
  const Estimate turned = boxplus(x, e);
  EXPECT_LT((turned.R_wb().transpose() * turned.v_wb - x.R_wb().transpose() * x.v_wb).norm(), 1e-13);
}

// What a filter knows of the antenna, of the velocity, and of tilt beside an accelerometer's bias is the same before
// and after a correction of the attitude; and no direction of the heading becomes known.
TEST(Estimate, ACarriedErrorIsOfTheSameAntennaVelocityAndTilt) {
  Random random(8);
  const std::array estimated{Block::kAccelBias, Block::kLeverArm};
  const StateLayout layout(estimated);
  const int lever_arm = layout.offset(Block::kLeverArm), attitude = layout.offset(Block::kAttitude);
  using Rows = Eigen::Matrix<double, 3, Eigen::Dynamic>;
  const auto antenna = [&](const Estimate& x) {
    Rows H = Rows::Zero(3, layout.size());
    H.leftCols<3>().setIdentity();
    H.middleCols<3>(attitude) = -skew(x.R_wb() * x.lever_arm);
    H.middleCols<3>(lever_arm) = x.R_wb();
    return H;
  };
  const auto velocity = [&](const Estimate& x) {
    Rows H = Rows::Zero(3, layout.size());
    H.middleRows<3>(0) = ordinary_from_invariant(x).middleRows<3>(3) * Eigen::MatrixXd::Identity(9, layout.size());
    return H;
  };
  for (int i = 0; i < 20; ++i) {
    const bool stands = i % 2 == 1;
    const Vector3d down = random.vector(1).normalized();
    const Estimate x = random.estimate();
    // The estimate at the last correction, which the noise of the gyroscopes has turned since.
    Estimate last = x;
    if (stands) last.q_wb = so3_exp(random.vector(0.05)) * x.q_wb;
    const auto standing = [&](const Estimate& since) {
      return stands ? std::optional<Standing>({down, since.q_wb}) : std::nullopt;
    };
    ErrorVector correction(layout.size());
    for (int k = 0; k < layout.size(); ++k) correction(k) = random.gaussian(0.2);
    const Estimate after = corrected(x, layout, correction, stands);
    const ResetJacobian J = transport_jacobian(x, layout, correction, standing(last));
    Eigen::MatrixXd G = Eigen::MatrixXd::Identity(layout.size(), layout.size());
    G.block<6, 6>(3, 3) = J.velocity_attitude;
    G.block<3, 3>(0, attitude) = J.position_attitude;
    G.block<3, 3>(0, lever_arm) = J.position_lever_arm;
    EXPECT_LT((antenna(after) * G - antenna(last)).norm(), 1e-13);
    if (stands) {
      EXPECT_TRUE(
          (G.middleRows<3>(3).isApprox(Eigen::MatrixXd::Identity(layout.size(), layout.size()).middleRows<3>(3))));
    } else {
      EXPECT_LT((velocity(after) * G - velocity(x)).norm(), 1e-12 * x.v_wb.norm());
      EXPECT_LT((after.v_wb - x.v_wb - velocity(x) * correction).norm(), 1e-12 * x.v_wb.norm()) << "and is linear";
    }
    const Vector3d put = x.R_wb() * x.lever_arm + x.p_wb + antenna(x) * correction;
    EXPECT_LT((after.p_wb + after.R_wb() * after.lever_arm - put).norm(), 1e-9) << "the antenna's place is linear";

    // Tilt by which gravity hides a bias, for a correction of the heading alone; and the heading, for any.
    if (!stands) continue;
    EXPECT_TRUE((J.velocity_attitude.bottomRightCorner<3, 3>() * down).isApprox(down));
    correction.segment<3>(attitude) = random.gaussian(0.2) * down;
    const Matrix3d R = so3_exp(Vector3d(correction.segment<3>(attitude))).toRotationMatrix();
    const Vector3d bias = random.vector(1), hidden = (x.R_wb() * bias).cross(down);
    const Vector3d turned =
        transport_jacobian(x, layout, correction, standing(x)).velocity_attitude.bottomRightCorner<3, 3>() * hidden;
    EXPECT_LT((turned - (R * x.R_wb() * bias).cross(down)).norm(), 1e-13);
  }
}

// Exp(c + d) = Exp(J d) Exp(c): an error d about a correction c that is not applied yet is J d once it is.
TEST(Estimate, TheResetJacobianHoldsForCorrectionsOfAnySize) {
  Random random(7);
  for (const double angle : {1e-3, 0.1, 0.5, 1.5, 3.0}) {
    const Estimate x = random.estimate();
    FullError c = FullError::Zero();
    c.segment<3>(full_offset(Block::kAttitude)) = angle * random.vector(1).normalized();
    c.segment<3>(full_offset(Block::kVelocity)) = random.vector(20);
    c.segment<3>(full_offset(Block::kBoresight)) = angle * random.vector(1).normalized();
    const ResetJacobian J = reset_jacobian(c);
    const Estimate corrected = boxplus(x, c);
    constexpr double kStep = 1e-5;
    for (const Block block : {Block::kAttitude, Block::kVelocity, Block::kBoresight}) {
      for (int k = 0; k < 3; ++k) {
        const FullError d = kStep * FullError::Unit(full_offset(block) + k);
        const FullError moved =
            (boxminus(boxplus(x, c + d), corrected) - boxminus(boxplus(x, c - d), corrected)) / (2 * kStep);
        FullError expected = FullError::Zero();
        if (block == Block::kBoresight) {
          const auto at = std::find(kMountingBlocks.begin(), kMountingBlocks.end(), block) - kMountingBlocks.begin();
          expected.segment<3>(full_offset(block)) = J.mountings.at(static_cast<std::size_t>(at)).col(k);
        } else {
          const int first = full_offset(Block::kVelocity);
          expected.segment<6>(first) = J.velocity_attitude.col(full_offset(block) + k - first);
        }
        EXPECT_LT((moved - expected).norm(), 1e-7) << angle << " rad, " << info(block).name << " " << k;
      }
    }
  }
}

TEST(Estimate, EveryBlockOfTheTableMovesItsOwnValueOnly) {
  Random random(5);
  const Estimate x = random.estimate();
  for (const BlockInfo& row : kBlocks) {
    for (int k = 0; k < row.size; ++k) {
      const FullError e = 0.01 * FullError::Unit(full_offset(row.block) + k);
      const Estimate y = boxplus(x, e);
      if (!is_rotation(row.block) && row.block != Block::kVelocity) {
        EXPECT_NEAR(additive(y, row.block)(k) - additive(x, row.block)(k), 0.01, 1e-14) << row.name;
      }
      EXPECT_LT((boxminus(y, x) - e).norm(), 1e-12) << row.name;
    }
  }
}

TEST(Estimate, OrdinaryVelocityErrorIsTheDifference) {
  Random random(6);
  const Estimate x = random.estimate();
  const FullError e = random_error(random, 1e-6);
  const Eigen::Matrix<double, 9, 1> ordinary = ordinary_from_invariant(x) * e.head<9>();
  const Estimate truth = boxplus(x, e);
  EXPECT_LT((truth.v_wb - x.v_wb - ordinary.segment<3>(3)).norm(), 1e-9);
  EXPECT_LT((truth.p_wb - x.p_wb - ordinary.head<3>()).norm(), 1e-13);
}

TEST(Estimate, ErrorOfALayoutLeavesTheOthersAlone) {
  Random random(7);
  const StateLayout layout(std::vector<Block>{Block::kBoresight, Block::kGnssDelay});
  const Estimate x = random.estimate();
  const ErrorVector e = random.matrix(layout.size(), 1);
  const FullError full = expand(layout, e);
  EXPECT_EQ(full.segment<3>(full_offset(Block::kBoresight)), e.segment<3>(9));
  EXPECT_EQ(full(full_offset(Block::kGnssDelay)), e(12));
  EXPECT_NEAR(full.squaredNorm(), e.squaredNorm(), 1e-12);
  EXPECT_EQ(boxplus(x, layout, e).gyro_bias, x.gyro_bias);
  EXPECT_TRUE(boxminus(boxplus(x, layout, e), boxplus(x, full)).isZero(1e-14));
}

}  // namespace
}  // namespace piste
