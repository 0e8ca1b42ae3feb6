#include "reference_noise.h"

#include <algorithm>
#include <cmath>

namespace piste {
namespace {

using Layout = AlignmentLayout;
using Rows = Eigen::Matrix<double, 3, Layout::kSize>;

// The difference of the signals of two references at one sample.
struct Apart {
  MeanSignal signal{Vector3d::Zero(), Vector3d::Zero(), Matrix3d::Zero()}, slope = signal;

  void add(const Apart& other, double factor) {
    const auto sum = [factor](MeanSignal& to, const MeanSignal& more) {
      to.gyro += factor * more.gyro;
      to.accel += factor * more.accel;
      to.lever += factor * more.lever;
    };
    sum(signal, other.signal);
    sum(slope, other.slope);
  }
};

Apart difference(const ReferenceGrid::Value& a, const ReferenceGrid::Value& b) {
  Apart apart{a.signal, a.slope};
  apart.add({b.signal, b.slope}, -1);
  return apart;
}

// −d residual / d parameters of one triad, of the part `signal` of its regressors, whose slope is `slope`.
Rows regressors(const Vector3d& signal, const Vector3d& slope, double since_first, const Matrix3d& scaled,
                const Matrix3d& R_br, int scale) {
  Rows J = Rows::Zero();
  J.col(Layout::kClockOffset) = -scaled * slope;
  J.col(Layout::kClockDrift) = -since_first * scaled * slope;
  J.middleCols<3>(Layout::kBoresight) = scaled * skew(signal);
  J.middleCols<3>(scale) = (R_br * signal).asDiagonal();
  return J;
}

// The difference of the two, epoch by epoch. Its mean from knot to knot is removed, as it is no noise: an error of the
// boresight, a drift.
std::vector<Apart> noise_of_both(const FilteredPair& pair, const FilteredPair& witness,
                                 const std::vector<AlignmentEpoch>& epochs, const AlignmentState& x) {
  const auto knot_of = [&](const AlignmentEpoch& epoch) { return x.knot(pair.body.time[epoch.sample]).first; };
  std::vector<Apart> noise;
  noise.reserve(epochs.size());
  for (std::size_t first = 0; first < epochs.size(); first = noise.size()) {
    Apart mean;
    while (noise.size() < epochs.size() && knot_of(epochs[noise.size()]) == knot_of(epochs[first])) {
      const double t = x.reference_time(pair.body.time[epochs[noise.size()].sample], pair.body.time.front());
      noise.push_back(difference(pair.reference.at(t), witness.reference.at(t)));
      mean.add(noise.back(), 1);
    }
    const auto count = static_cast<double>(noise.size() - first);
    for (std::size_t k = first; k < noise.size(); ++k) noise[k].add(mean, -1 / count);
  }
  return noise;
}

}  // namespace

NoiseShares noise_shares(const ImuSensor& body, const ImuSensor& reference) {
  const auto share = [](const TriadErrors& b, const TriadErrors& r) {
    const double both = b.noise * b.noise + r.noise * r.noise;
    return b.noise > 0 ? r.noise * r.noise / both : 0;
  };
  return {share(body.gyro, reference.gyro), share(body.accel, reference.accel)};
}

std::vector<ImuSample> as_reference(const std::vector<ImuSample>& body, const AlignmentState& x) {
  const Matrix3d R_rb = x.q_rb.toRotationMatrix();
  const double first = body.front().time;
  std::vector<ImuSample> moved = body;
  for (ImuSample& s : moved) {
    s.dtheta = R_rb * (s.dtheta - s.interval * (x.gyro_bias + x.drift(x.gyro_drift, s.time)));
    s.dvel = R_rb * (s.dvel - s.interval * (x.accel_bias + x.drift(x.accel_drift, s.time)));
    s.time = x.reference_time(s.time, first);
    s.interval *= 1 - x.clock(1);
  }
  const ReferenceIntegrals integrals(moved);
  for (ImuSample& s : moved) s.dvel -= s.interval * integrals.mean(s.time, s.interval).lever * x.p_rb_r;
  return moved;
}

ApparentInformation apparent_information(const FilteredPair& pair, const FilteredPair& witness,
                                         const std::vector<AlignmentEpoch>& epochs, const AlignmentState& x,
                                         const NoiseShares& shares) {
  const std::vector<Apart> noise = noise_of_both(pair, witness, epochs, x);
  const Matrix3d R_br = x.q_rb.toRotationMatrix().transpose();
  const Matrix3d gyro_turned = (Vector3d::Ones() + x.gyro_scale).asDiagonal() * R_br,
                 accel_turned = (Vector3d::Ones() + x.accel_scale).asDiagonal() * R_br;
  const double gyro_share = std::sqrt(shares.gyro), accel_share = std::sqrt(shares.accel);
  ApparentInformation sum;
  for (std::size_t k = 0; k < epochs.size(); ++k) {
    const AlignmentEpoch& epoch = epochs[k];
    const auto& [signal, slope] = noise[k];
    const double since_first = pair.body.time[epoch.sample] - pair.body.time.front();
    const auto of_forces = [&](const Vector3d& force, const Vector3d& by_time) {
      return regressors(force, by_time, since_first, accel_turned, R_br, Layout::kAccelScale);
    };
    Rows gyro = gyro_share * regressors(signal.gyro, slope.gyro, since_first, gyro_turned, R_br, Layout::kGyroScale);
    // The lever arm's force follows from the rates, and has their share.
    Rows accel = accel_share * of_forces(signal.accel, slope.accel) +
                 gyro_share * of_forces(signal.lever * x.p_rb_r, slope.lever * x.p_rb_r);
    accel.middleCols<3>(Layout::kLeverArm) = gyro_share * accel_turned * signal.lever;
    gyro = (weights(epoch.usable.gyro, epoch.gyro_sigma).asDiagonal() * gyro).eval();
    accel = (weights(epoch.usable.accel, epoch.accel_sigma).asDiagonal() * accel).eval();
    sum.add(gyro.transpose() * gyro + accel.transpose() * accel, x);
  }
  return sum;
}

Parameters20 ApparentInformation::gradient(const AlignmentInformation& S, const AlignmentState& x) {
  Parameters20 gradient = Parameters20::Zero();
  const auto of_block = [&](int block, const Vector3d& value) {
    gradient.segment<3>(block) = S.block<3, 3>(block, block) * value;
  };
  of_block(Layout::kLeverArm, x.p_rb_r);
  of_block(Layout::kGyroScale, Vector3d::Ones() + x.gyro_scale);
  of_block(Layout::kAccelScale, Vector3d::Ones() + x.accel_scale);
  return gradient;
}

void ApparentInformation::add(const AlignmentInformation& one, const AlignmentState& x) {
  information += one;
  const Parameters20 g = gradient(one, x);
  squares += g * g.transpose();
  ++count;
}

AlignmentInformation ApparentInformation::variance(const AlignmentState& x) const {
  if (count == 0) return AlignmentInformation::Zero();
  const Parameters20 g = gradient(information, x);
  return squares - g * g.transpose() / static_cast<double>(count);
}

void take_back(AlignmentState& x, const ApparentInformation& apparent, const AlignmentInformation& inverse) {
  const Parameters20 step = inverse * ApparentInformation::gradient(apparent.information, x);
  x.clock += step.head<2>();
  x.q_rb = (so3_exp(step.segment<3>(Layout::kBoresight)) * x.q_rb).normalized();
  x.p_rb_r += step.segment<3>(Layout::kLeverArm);
  x.gyro_bias += step.segment<3>(Layout::kGyroBias);
  x.accel_bias += step.segment<3>(Layout::kAccelBias);
  x.gyro_scale += step.segment<3>(Layout::kGyroScale);
  x.accel_scale += step.segment<3>(Layout::kAccelScale);
}

AlignmentInformation of_reference_scales(const AlignmentState& x, const ImuSensor& reference) {
  const double accel = reference.accel.scale * reference.accel.scale,
               gyro = reference.gyro.scale * reference.gyro.scale;
  // Variance of the off-diagonal elements of R_br diag(s) R_rb, for unit variance of s. The largest bounds the part
  // that a rotation may explain.
  const Matrix3d squares = x.q_rb.toRotationMatrix().cwiseAbs2(), shear = squares.transpose() * squares;
  const double most = std::max({shear(0, 1), shear(0, 2), shear(1, 2)});
  AlignmentInformation P = AlignmentInformation::Zero();
  P.diagonal().segment<3>(Layout::kBoresight).setConstant(std::max(accel, gyro) * most);
  P.diagonal().segment<3>(Layout::kLeverArm) = (accel + gyro) * x.p_rb_r.cwiseAbs2();
  return P;
}

}  // namespace piste
