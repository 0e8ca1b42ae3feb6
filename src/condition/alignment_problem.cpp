#include "alignment_problem.h"

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <utility>

#include "alignment_costs.h"
#include "math/solve_least_squares.h"

namespace piste {
namespace {

using Layout = AlignmentLayout;

// Priors of the unknown parameters [m], [rad/s], [m/s²]: so wide that they have no effect.
constexpr double kWidestLeverArm = 10, kWidestGyroBias = 1, kWidestAccelBias = 10;
constexpr double kHuber = 4;

class Builder {
 public:
  Builder(const FilteredPair& pair, const ImuSensor& sensor, AlignmentState& x) : pair_(pair), sensor_(sensor), x_(x) {}

  ceres::Problem& build(const std::vector<AlignmentEpoch>& epochs) {
    problem_.AddParameterBlock(x_.clock.data(), 2);
    problem_.AddParameterBlock(x_.q_rb.coeffs().data(), 4, new RotationManifold);
    for (const AlignmentEpoch& epoch : epochs) add(epoch);
    add_prior(x_.p_rb_r, kWidestLeverArm);
    add_prior(x_.gyro_bias, kWidestGyroBias);
    add_prior(x_.accel_bias, kWidestAccelBias);
    add_scale(x_.gyro_scale, sensor_.gyro.scale);
    add_scale(x_.accel_scale, sensor_.accel.scale);
    add_drift(x_.gyro_drift, sensor_.gyro.drift);
    add_drift(x_.accel_drift, sensor_.accel.drift);
    return problem_;
  }

 private:
  void add(const AlignmentEpoch& epoch) {
    const BodySignals& body = pair_.body;
    const double m = body.time[epoch.sample];
    const auto [knot, part] = x_.knot(m);
    TriadSample triad{m,
                      m - body.time.front(),
                      body.gyro[epoch.sample],
                      pair_.gyro_gain,
                      part,
                      weights(epoch.usable.gyro, epoch.gyro_sigma),
                      &pair_.reference};
    if (epoch.usable.gyro != 0) {
      problem_.AddResidualBlock(new TriadCost<false>(triad), new ceres::HuberLoss(kHuber), x_.clock.data(),
                                x_.q_rb.coeffs().data(), x_.gyro_bias.data(), x_.gyro_scale.data(),
                                x_.gyro_drift[knot].data(), x_.gyro_drift[knot + 1].data());
    }
    triad.measured = body.accel[epoch.sample];
    triad.gain = pair_.accel_gain;
    triad.weight = weights(epoch.usable.accel, epoch.accel_sigma);
    if (epoch.usable.accel != 0) {
      problem_.AddResidualBlock(new TriadCost<true>(triad), new ceres::HuberLoss(kHuber), x_.clock.data(),
                                x_.q_rb.coeffs().data(), x_.p_rb_r.data(), x_.accel_bias.data(), x_.accel_scale.data(),
                                x_.accel_drift[knot].data(), x_.accel_drift[knot + 1].data());
    }
  }

  void add_prior(Vector3d& value, double sigma) {
    problem_.AddResidualBlock(new PriorCost(sigma), nullptr, value.data());
  }

  void add_scale(Vector3d& scale, double sigma) {
    if (sigma > 0) {
      add_prior(scale, sigma);
    } else {
      hold(scale);
    }
  }

  void hold(Vector3d& value) {
    value.setZero();
    problem_.AddParameterBlock(value.data(), 3);
    problem_.SetParameterBlockConstant(value.data());
  }

  void add_drift(std::vector<Vector3d>& knots, const DriftProcess& process) {
    if (process.kind == DriftProcess::Kind::kNone) {
      for (Vector3d& knot : knots) hold(knot);
      return;
    }
    double factor = 1, sigma = process.density * std::sqrt(x_.knot_spacing);
    if (process.kind == DriftProcess::Kind::kGaussMarkov) {
      factor = std::exp(-x_.knot_spacing / process.correlation_time);
      sigma = process.sigma * std::sqrt(1 - factor * factor);
      add_prior(knots.front(), process.sigma);
    } else {
      hold(knots.front());  // the bias is the value there
    }
    for (std::size_t i = 0; i + 1 < knots.size(); ++i) {
      problem_.AddResidualBlock(new StepCost(factor, sigma), nullptr, knots[i].data(), knots[i + 1].data());
    }
  }

  const FilteredPair& pair_;
  const ImuSensor& sensor_;
  AlignmentState& x_;
  ceres::Problem problem_;
};

// A parameter block, and the place of its tangent in the normal equations.
struct Placed {
  double* data;
  int size, column;
};

// The blocks that are estimated: the parameters in the order of AlignmentLayout, then the drifts knot by knot.
std::vector<Placed> placed_blocks(const ceres::Problem& problem, AlignmentState& x) {
  std::vector<Placed> placed{
      {x.clock.data(), 2, Layout::kClockOffset},     {x.q_rb.coeffs().data(), 3, Layout::kBoresight},
      {x.p_rb_r.data(), 3, Layout::kLeverArm},       {x.gyro_bias.data(), 3, Layout::kGyroBias},
      {x.accel_bias.data(), 3, Layout::kAccelBias},  {x.gyro_scale.data(), 3, Layout::kGyroScale},
      {x.accel_scale.data(), 3, Layout::kAccelScale}};
  int column = Layout::kSize;
  for (auto* knots : {&x.gyro_drift, &x.accel_drift}) {
    for (Vector3d& knot : *knots) {
      placed.push_back({knot.data(), 3, column});
      column += 3;
    }
  }
  std::erase_if(placed, [&](const Placed& p) {
    return !problem.HasParameterBlock(p.data) || problem.IsParameterBlockConstant(p.data);
  });
  return placed;
}

// The normal equations. They have the shape of an arrow: a drift is coupled only to its neighbours and to the
// parameters.
struct Arrow {
  AlignmentInformation A = AlignmentInformation::Zero();  // of the parameters
  Eigen::MatrixXd B;                                      // drifts by parameters
  std::vector<Eigen::Triplet<double>> C;                  // of the drifts
};

Arrow normal_equations(ceres::Problem& problem, const std::vector<Placed>& placed, int drifts) {
  ceres::Problem::EvaluateOptions options;
  std::vector<int> column_of;
  for (const Placed& p : placed) {
    options.parameter_blocks.push_back(p.data);
    for (int i = 0; i < p.size; ++i) column_of.push_back(p.column + i);
  }
  ceres::CRSMatrix J;
  problem.Evaluate(options, nullptr, nullptr, nullptr, &J);
  Arrow sum;
  sum.B = Eigen::MatrixXd::Zero(drifts, Layout::kSize);
  for (int row = 0; row < J.num_rows; ++row) {
    const auto begin = static_cast<std::size_t>(J.rows[static_cast<std::size_t>(row)]),
               end = static_cast<std::size_t>(J.rows[static_cast<std::size_t>(row) + 1]);
    for (std::size_t i = begin; i < end; ++i) {
      const int at = column_of[static_cast<std::size_t>(J.cols[i])];
      for (std::size_t j = begin; j < end; ++j) {
        const double product = J.values[i] * J.values[j];
        const int to = column_of[static_cast<std::size_t>(J.cols[j])];
        if (product == 0) continue;
        if (at < Layout::kSize && to < Layout::kSize) sum.A(at, to) += product;
        if (at >= Layout::kSize && to < Layout::kSize) sum.B(at - Layout::kSize, to) += product;
        if (at >= Layout::kSize && to >= Layout::kSize) {
          sum.C.emplace_back(at - Layout::kSize, to - Layout::kSize, product);
        }
      }
    }
  }
  return sum;
}

// Information matrix of the parameters after elimination of the drifts. Drifts that are held constant get a one on the
// diagonal.
AlignmentInformation information(ceres::Problem& problem, AlignmentState& x) {
  const int drifts = 3 * static_cast<int>(x.gyro_drift.size() + x.accel_drift.size());
  auto [A, B, entries] = normal_equations(problem, placed_blocks(problem, x), drifts);
  std::vector<bool> held(static_cast<std::size_t>(drifts), true);
  for (const auto& entry : entries) held[static_cast<std::size_t>(entry.row())] = false;
  for (int i = 0; i < drifts; ++i) {
    if (held[static_cast<std::size_t>(i)]) entries.emplace_back(i, i, 1);
  }
  Eigen::SparseMatrix<double> C(drifts, drifts);
  C.setFromTriplets(entries.begin(), entries.end());
  return A - B.transpose() * Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(C).solve(B);
}

}  // namespace

std::pair<std::size_t, double> AlignmentState::knot(double m) const {
  const double at = std::clamp((m - first_knot) / knot_spacing, 0.0, static_cast<double>(gyro_drift.size() - 1));
  const auto before = std::min(static_cast<std::size_t>(at), gyro_drift.size() - 2);
  return {before, at - static_cast<double>(before)};
}

Vector3d AlignmentState::drift(const std::vector<Vector3d>& knots, double m) const {
  const auto [before, part] = knot(m);
  return (1 - part) * knots[before] + part * knots[before + 1];
}

Vector3d weights(std::uint8_t usable, double sigma) {
  Vector3d w;
  for (int i = 0; i < 3; ++i) w(i) = usable >> i & 1 ? 1 / sigma : 0;
  return w;
}

AlignmentResidual residual(const FilteredPair& pair, const AlignmentState& x, std::size_t sample) {
  const double m = pair.body.time[sample];
  const double t = x.reference_time(m, pair.body.time.front());
  const Matrix3d R_br = x.q_rb.toRotationMatrix().transpose();
  const MeanSignal s = pair.reference.at(t).signal;
  const Vector3d w = R_br * s.gyro;
  const Vector3d f = R_br * (s.accel + s.lever * x.p_rb_r);
  return {pair.body.gyro[sample] - w - x.gyro_scale.cwiseProduct(w) -
              pair.gyro_gain * (x.gyro_bias + x.drift(x.gyro_drift, m)),
          pair.body.accel[sample] - f - x.accel_scale.cwiseProduct(f) -
              pair.accel_gain * (x.accel_bias + x.drift(x.accel_drift, m))};
}

AlignmentInformation solve_alignment(const FilteredPair& pair, const std::vector<AlignmentEpoch>& epochs,
                                     const ImuSensor& sensor, AlignmentState& x) {
  Builder builder(pair, sensor, x);
  ceres::Problem& problem = builder.build(epochs);
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.logging_type = ceres::SILENT;
  options.max_num_iterations = 50;
  options.function_tolerance = 1e-10;
  ceres::Solver::Summary summary;
  solve_least_squares(options, problem, summary);
  return information(problem, x);
}

}  // namespace piste
