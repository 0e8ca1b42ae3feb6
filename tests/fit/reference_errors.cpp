// Each error of the reference moves its signal as the real thing does, and intervals know of it.

#include "fit/reference_errors.h"

#include <gtest/gtest.h>

#include <limits>

#include "piste/fit/imu_fit.h"
#include "support/aligned_run.h"

namespace piste {
namespace {

using Parameters = Eigen::Matrix<double, ReferenceErrors::kSize, 1>;

/// The reference's signals at b, as an alignment with these errors would bring them there: truth = estimate + error.
struct Plate {
  test::AlignedRun run{.gyro_noise = 0, .accel_noise = 0, .rest = 10, .run = 10};
  Quaterniond q_rb = from_euler({0.3, -0.2, 1.7});  // as estimated
  Vector3d p_rb_r{0.07, -0.02, 0.04};

  AlignedImus reference(const Parameters& p, double at_first) const {
    AlignedImus out = run.simulate(1);
    const Matrix3d R_br = (so3_exp(p.segment<3>(2)) * q_rb).toRotationMatrix().transpose();
    const Vector3d arm = p_rb_r + p.segment<3>(5);
    for (std::size_t i = 0; i < out.time.size(); ++i) {
      const double t = out.time[i] - run.start - p(0) - p(1) * (out.time[i] - at_first), h = 1e-5;
      Vector3d w, f, after, before, unused;
      run.motion(t, w, f);
      run.motion(t + h, after, unused);
      run.motion(t - h, before, unused);
      const Vector3d w_dot = (after - before) / (2 * h);
      out.reference_gyro[i] = R_br * w * (1 + p(9)) + Vector3d::Constant(p(8));
      out.reference_accel[i] =
          R_br * (f + w_dot.cross(arm) + w.cross(w.cross(arm))) * (1 + p(9)) + Vector3d::Constant(p(8));
    }
    return out;
  }
};

TEST(ReferenceErrors, RowsAreDerivatives) {
  const Plate plate;
  Parameters none = Parameters::Zero();
  const AlignedImus imus = plate.reference(none, 1000);
  Alignment alignment;
  alignment.q_rb = plate.q_rb;
  alignment.covariance.setIdentity();
  const ReferenceErrors errors(imus, &alignment, nullptr);
  for (int j = 0; j < ReferenceErrors::kSize; ++j) {
    Parameters p = none;
    p(j) = j == 1 ? 1e-6 : 1e-5;
    const AlignedImus moved = plate.reference(p, imus.time.front());
    double worst = 0, largest = 0;
    for (std::size_t i = 1250; i < 1750; ++i) {
      for (int axis = 0; axis < 6; ++axis) {
        const auto& of = axis < 3 ? &AlignedImus::reference_accel : &AlignedImus::reference_gyro;
        const double expected = ((moved.*of)[i](axis % 3) - (imus.*of)[i](axis % 3)) / p(j);
        worst = std::max(worst, std::abs(errors.row(i, axis)(j) - expected));
        largest = std::max(largest, std::abs(expected));
      }
    }
    EXPECT_GT(largest, 0.1) << j;
    EXPECT_LT(worst, 0.01 * largest) << j;
  }
}

TEST(ReferenceErrors, KnowsWhatIsNotThere) {
  const AlignedImus imus = test::AlignedRun{.rest = 5, .run = 5}.simulate(1);
  EXPECT_TRUE(ReferenceErrors(imus, nullptr, nullptr).covariance(0).isZero());
  Alignment alignment;
  alignment.covariance.setIdentity();
  alignment.covariance(AlignmentLayout::kLeverArm, AlignmentLayout::kLeverArm) =
      std::numeric_limits<double>::infinity();
  ImuSensor sensor;
  sensor.accel.bias = 0.003;
  sensor.accel.drift = {.kind = DriftProcess::Kind::kGaussMarkov, .sigma = 0.004};
  sensor.gyro.scale = 1e-4;
  const ReferenceErrors errors(imus, &alignment, &sensor);
  EXPECT_TRUE(errors.covariance(2).allFinite());
  EXPECT_EQ(errors.covariance(2)(5, 5), 0) << "not determined, and not applied";
  EXPECT_EQ(errors.covariance(2)(6, 6), 1);
  EXPECT_NEAR(errors.covariance(2)(8, 8), 25e-6, 1e-12);
  EXPECT_EQ(errors.covariance(5)(8, 8), 0);
  EXPECT_NEAR(errors.covariance(5)(9, 9), 1e-8, 1e-15);
}

// One error of one sigma, without noise: every estimate moves by its systematic sigma.
TEST(ReferenceErrors, EstimatesMoveByWhatTheySay) {
  Plate plate;
  plate.q_rb = Quaterniond::Identity();
  plate.p_rb_r.setZero();  // its force jumps where the motion sets off
  const Phases phases{plate.run.before(), plate.run.moving(), plate.run.after()};
  for (int j = 0; j < ReferenceErrors::kSize; ++j) {
    Parameters p = Parameters::Zero();
    p(j) = j == 1 ? 1e-6 : 1e-5;
    Alignment alignment;
    alignment.covariance.setZero();
    if (j < 8) alignment.covariance(j, j) = p(j) * p(j);
    ImuSensor sensor;
    sensor.accel.bias = sensor.gyro.bias = p(8);
    sensor.accel.scale = sensor.gyro.scale = p(9);
    AlignedImus right = plate.reference(Parameters::Zero(), 1000), wrong = plate.reference(p, right.time.front());
    right.gyro = wrong.gyro = right.reference_gyro;  // an IMU without errors
    right.accel = wrong.accel = right.reference_accel;
    const Findings before = findings(right, phases, {&alignment, &sensor});
    const Findings after = findings(wrong, phases, {&alignment, &sensor});
    for (std::size_t a = 0; a < 6; ++a) {
      const AxisFindings &x = before.axes[a], &y = after.axes[a];
      // To first order. A clock's error is one of the motion's kinks, too, and of all the time since its first sample.
      const double reach = j == 1 ? 30 * p(j) : p(j);
      const auto expect_moved = [&](const Term& was, const Term& is, const char* what) {
        const double moved = std::abs(is.value - was.value);
        EXPECT_NEAR(moved, was.systematic, 0.03 * was.systematic + 0.02 * reach) << j << " " << x.name << " " << what;
      };
      expect_moved(*x.before, *y.before, "rest");
      expect_moved(*x.change, *y.change, "change");
      expect_moved(x.run->bias_only, y.run->bias_only, "bias only");
      expect_moved(x.run->joint.reverse.bias(), y.run->joint.reverse.bias(), "joint bias");
      expect_moved(x.run->joint.reverse.scale(), y.run->joint.reverse.scale(), "joint scale");
      expect_moved(x.run->joint.forward.bias(), y.run->joint.forward.bias(), "forward bias");
      expect_moved(x.run->scale_only->reverse.scale(), y.run->scale_only->reverse.scale(), "scale only");
      expect_moved(x.run->scale_only->reverse.bias(), y.run->scale_only->reverse.bias(), "its bias");
      expect_moved(x.run->both_noisy.scale(), y.run->both_noisy.scale(), "both noisy");
      // Of an IMU without errors, whose polynomial is zero in any order, the other one moves by what itself says.
      const auto expect_is = [&](const Term& is, const char* what) {
        EXPECT_NEAR(std::abs(is.value), is.systematic, 0.03 * is.systematic + 0.02 * reach)
            << j << " " << x.name << what;
      };
      expect_is(y.run->polynomial->tangent.bias(), "tangent's bias");
      expect_is(y.run->polynomial->tangent.scale(), "tangent's scale");
      const MatrixFit& matrix = a < 3 ? *after.accel_matrix : *after.gyro_matrix;
      const int k = static_cast<int>(a % 3);
      expect_is(matrix.bias(k), "matrix' bias");
      for (int of = 0; of < 3; ++of) {
        expect_is(matrix.gain(k, of), "matrix' gain");
        if (a >= 3) expect_is(matrix.g_sensitivity(k, of), "g-sensitivity");
      }
    }
  }
}

// Plates with errors drawn from the covariance: intervals hold the truth as often as they say, and without the
// covariance they do not.
TEST(ReferenceErrors, IntervalsKnowOfThem) {
  Plate plate;
  plate.q_rb = Quaterniond::Identity();
  plate.run.gyro_noise = 0.002;
  plate.run.accel_noise = 0.005;
  Alignment alignment;
  alignment.covariance.setZero();
  const Vector3d sigma(2e-4, 3e-4, 1e-4);
  alignment.covariance.diagonal().segment<3>(AlignmentLayout::kBoresight) = sigma.cwiseAbs2();
  ImuSensor sensor;
  sensor.accel.bias = sensor.gyro.bias = 1e-3;
  sensor.accel.scale = sensor.gyro.scale = 5e-4;
  double inside = 0, without = 0, count = 0;
  for (int seed = 1; seed <= 60; ++seed) {
    test::Random random(static_cast<std::uint64_t>(seed));
    Parameters p = Parameters::Zero();
    p.segment<3>(2) = sigma.cwiseProduct(random.vector());
    p(8) = random.gaussian(1e-3);
    p(9) = random.gaussian(5e-4);
    AlignedImus imus = plate.run.simulate(static_cast<std::uint64_t>(seed));
    const AlignedImus truth = plate.reference(Parameters::Zero(), 1000), wrong = plate.reference(p, 1000);
    for (std::size_t i = 0; i < imus.time.size(); ++i) {  // what the IMU measures, at its own place
      Vector3d w, f;
      plate.run.motion(imus.time[i] - plate.run.start, w, f);
      const Vector3d moved = truth.reference_accel[i] - f;
      imus.accel[i] += moved + plate.run.accel_scale.cwiseProduct(moved);
    }
    imus.reference_gyro = wrong.reference_gyro;
    imus.reference_accel = wrong.reference_accel;
    const Phases phases{plate.run.before(), plate.run.moving(), plate.run.after()};
    for (const bool known : {true, false}) {
      const Findings found = findings(imus, phases, {known ? &alignment : nullptr, known ? &sensor : nullptr});
      for (std::size_t a = 0; a < 6; ++a) {
        const auto k = static_cast<Eigen::Index>(a % 3);
        const RunFit& fit = *found.axes[a].run;
        const double scale = (a < 3 ? plate.run.accel_scale : plate.run.gyro_scale)(k);
        const double bias = (a < 3 ? plate.run.accel_bias : plate.run.gyro_bias)(k);
        const double rest = bias + scale * (a < 3 ? Vector3d(-2, 0.1, -9.6)(k) : 0);
        const auto hit = [&](const Term& t, double right) { return std::abs(t.value - right) < t.half_width(0.95); };
        const MatrixFit& matrix = a < 3 ? *found.accel_matrix : *found.gyro_matrix;
        const int row = static_cast<int>(k);
        for (const bool held : {hit(fit.joint.reverse.scale(), scale), hit(fit.joint.reverse.bias(), bias),
                                hit(fit.scale_only->forward.scale(), scale), hit(*found.axes[a].before, rest),
                                hit(fit.both_noisy.scale(), scale), hit(matrix.line(row).scale(), scale),
                                hit(matrix.gain(row, (row + 1) % 3), 0), hit(matrix.gain(row, (row + 2) % 3), 0)}) {
          (known ? inside : without) += held;
          count += known;
        }
      }
      if (known) {
        EXPECT_LT(found.axes[3].change->systematic, 1e-7) << "what is constant is no change";
      }
    }
  }
  EXPECT_GT(inside / count, 0.9);
  EXPECT_LT(inside / count, 0.99);
  EXPECT_LT(without / count, 0.6);
}

}  // namespace
}  // namespace piste
