#include "piste/core/solution.h"

#include <algorithm>
#include <cmath>

namespace piste {
namespace {

constexpr std::string_view kSigma = "sigma_";

// Where the first parts of a row stand, behind the time and the attitude.
constexpr std::size_t kVelocityAt = 5, kPositionAt = 8, kNavigationSigmasAt = 11;

// Goes through the parts of a row in the order of their storage. F is called with the name of every part and its
// values, to read or to write them.
template <class EstimateRef, class SigmasRef, class F>
void visit(const StateLayout& layout, EstimateRef& x, SigmasRef& s, F&& f) {
  f("", "q_wb", x.q_wb.coeffs());
  f("", "v_wb", x.v_wb);
  f("", "p_wb", x.p_wb);
  f(kSigma, "position", s.position);
  f(kSigma, "velocity", s.velocity);
  f(kSigma, "euler", s.euler);
  f(kSigma, "gyro_total_bias", s.gyro_total_bias);
  f(kSigma, "accel_total_bias", s.accel_total_bias);
  for (const Block b : layout.blocks()) {
    if (is_navigation(b)) continue;
    if (is_rotation(b)) {
      f("", info(b).name, rotation(x, b).coeffs());
    } else {
      f("", info(b).name, additive(x, b));
    }
    f(kSigma, info(b).name, s.blocks.segment(full_offset(b), info(b).size));
  }
}

/// Takes the parts of a row from where it is stored.
struct ReadRow {
  const double* p;
  template <class Values>
  void operator()(std::string_view, std::string_view, Values&& values) {
    for (Eigen::Index k = 0; k < values.size(); ++k) values(k) = *p++;
  }
};

Vector3d root(const Vector3d& variance) { return variance.cwiseMax(0).cwiseSqrt(); }

Vector3d total_bias_sigma(const StateLayout& layout, const Covariance& P, Block bias, Block drift) {
  Vector3d variance = Vector3d::Zero();
  for (int i = 0; i < 3; ++i) {
    for (const Block a : {bias, drift}) {
      for (const Block b : {bias, drift}) {
        if (layout.has(a) && layout.has(b)) variance(i) += P(layout.offset(a) + i, layout.offset(b) + i);
      }
    }
  }
  return root(variance);
}

}  // namespace

std::string_view outcome_name(Outcome outcome) {
  switch (outcome) {
    case Outcome::kUsed:
      return "used";
    case Outcome::kRejected:
      return "rejected";
    case Outcome::kReadmitted:
      return "readmitted";
    case Outcome::kDisputed:
      return "disputed";
    case Outcome::kRepeated:
      break;
  }
  return "repeated";
}

namespace {

Navigation navigation_of(const World& world, const Quaterniond& q_wb, const Vector3d& v_wb, const Vector3d& p_wb) {
  const auto [place, R_wn] = world.local_level(p_wb);
  const Matrix3d R_nw = R_wn.transpose();
  return {place, R_nw * v_wb, to_euler(R_nw * q_wb.toRotationMatrix())};
}

// Sigmas of an error after the linear map `turn`.
Vector3d sigmas_along(const Matrix3d& turn, const Matrix3d& covariance) {
  return root((turn * covariance).cwiseProduct(turn).rowwise().sum());
}

}  // namespace

Navigation navigation_of(const World& world, const Estimate& x) { return navigation_of(world, x.q_wb, x.v_wb, x.p_wb); }

Sigmas sigmas_of(const World& world, const Estimate& x, const StateLayout& layout, const Covariance& P) {
  const Matrix3d R_nw = world.rotation_wn(x.p_wb).transpose();
  // The part of level_from_invariant() for the diagonal blocks: ordinary velocity depends on ν and θ, position and
  // attitude on themselves.
  constexpr int kVelocity = full_offset(Block::kVelocity), kAttitude = full_offset(Block::kAttitude);
  const Matrix3d attitude = P.block<3, 3>(kAttitude, kAttitude);
  const Matrix3d V = -skew(x.v_wb);
  const Matrix3d turned = V * P.block<3, 3>(kAttitude, kVelocity);
  const Matrix3d velocity =
      P.block<3, 3>(kVelocity, kVelocity) + turned + turned.transpose() + V * attitude * V.transpose();
  Sigmas s;
  s.position = sigmas_along(R_nw, P.topLeftCorner<3, 3>());
  s.velocity = sigmas_along(R_nw, velocity);
  s.euler = euler_sigma(R_nw * x.R_wb(), R_nw, attitude);
  for (const Block b : layout.blocks()) {
    if (is_navigation(b)) continue;
    const int o = layout.offset(b);
    auto out = s.blocks.segment(full_offset(b), info(b).size);
    if (is_rotation(b)) {
      out = euler_sigma(rotation(x, b), P.block<3, 3>(o, o));
    } else {
      out = P.diagonal().segment(o, info(b).size).cwiseMax(0).cwiseSqrt();
    }
  }
  s.gyro_total_bias = total_bias_sigma(layout, P, Block::kGyroBias, Block::kGyroDrift);
  s.accel_total_bias = total_bias_sigma(layout, P, Block::kAccelBias, Block::kAccelDrift);
  return s;
}

Navigation Solution::navigation(std::size_t i) const {
  const double* p = rows_.data() + i * stride_;
  return navigation_of(world_, Quaterniond(p + 1), Vector3d(p + kVelocityAt), Vector3d(p + kPositionAt));
}

NavigationSigmas Solution::navigation_sigmas(std::size_t i) const {
  const double* p = rows_.data() + i * stride_ + kNavigationSigmasAt;
  return {Vector3d(p), Vector3d(p + 3), Vector3d(p + 6)};
}

Vector3d Solution::position(std::size_t i) const { return Vector3d(rows_.data() + i * stride_ + kPositionAt); }

Solution::Solution(StateLayout layout, World world) : layout_(std::move(layout)), world_(std::move(world)) {
  for (const StoredColumn& column : columns()) stride_ += column.size;
}

std::vector<StoredColumn> Solution::columns() const {
  std::vector<StoredColumn> all{{"time", 0, 1}};
  const Estimate x;
  const Sigmas s;
  visit(layout_, x, s, [&all](std::string_view prefix, std::string_view name, const auto& values) {
    const std::size_t offset = all.back().offset + all.back().size;
    all.push_back({std::string(prefix).append(name), offset, static_cast<std::size_t>(values.size())});
  });
  return all;
}

Estimate Solution::estimate(std::size_t i) const {
  Estimate x = fixed;
  Sigmas s;
  ReadRow read{rows_.data() + i * stride_ + 1};
  visit(layout_, x, s, read);
  return x;
}

Sigmas Solution::sigmas(std::size_t i) const {
  Estimate x;
  Sigmas s;
  ReadRow read{rows_.data() + i * stride_ + 1};
  visit(layout_, x, s, read);
  return s;
}

void Solution::append(double time, const Estimate& x, const Sigmas& s) {
  rows_.resize(rows_.size() + stride_);
  set(size() - 1, time, x, s);
}

void Solution::set(std::size_t i, double time, const Estimate& x, const Sigmas& s) {
  double* p = rows_.data() + i * stride_;
  *p++ = time;
  visit(layout_, x, s, [&p](std::string_view, std::string_view, const auto& values) {
    for (Eigen::Index k = 0; k < values.size(); ++k) *p++ = values(k);
  });
}

AdaptedNoise::Range AdaptedNoise::range(std::size_t name) const {
  if (time.empty()) return {};
  const double first = factor(0, name);
  Range range{0, first, first, factor(time.size() - 1, name)};
  for (std::size_t row = 0; row < time.size(); ++row) {
    const double value = factor(row, name);
    range.mean += std::log(value);
    range.least = std::min(range.least, value);
    range.most = std::max(range.most, value);
  }
  range.mean = std::exp(range.mean / static_cast<double>(time.size()));
  return range;
}

}  // namespace piste
