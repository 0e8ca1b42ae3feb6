#include "terms.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <stdexcept>
#include <utility>

#include "math/parallel.h"
#include "piste/core/error.h"

namespace piste {
namespace {

[[noreturn]] void not_definite() {
  throw DataError("batch", "a covariance is not positive definite: is a block estimated that has no error?");
}

// By how much the errors of the IMU differ, in the order of the columns of a sum.
ImuErrorVector imu_change(const Estimate& now, const Estimate& before) {
  ImuErrorVector change;
  int row = 0;
  for (const ImuErrorBlock& b : kImuErrorBlocks) {
    change.segment(row, b.size()) = additive(now, b.block) - additive(before, b.block);
    row += b.size();
  }
  return change;
}

// Columns of a Jacobian for the run's error vector that belong to a part.
Eigen::MatrixXd columns_of(const BatchLayout::Part& part, const Eigen::MatrixXd& whole) {
  Eigen::MatrixXd out(whole.rows(), part.size());
  for (int k = 0; k < part.size(); ++k) out.col(k) = whole.col(part.rows[static_cast<std::size_t>(k)]);
  return out;
}

// G⁻¹ of a correction for the whole layout: what a small error about x ⊞ e adds to e.
Eigen::MatrixXd by_error(const StateLayout& layout, const FullError& e) {
  const ResetJacobian G = reset_jacobian(e);
  Eigen::MatrixXd out = Eigen::MatrixXd::Identity(layout.size(), layout.size());
  const int velocity = layout.offset(Block::kVelocity);
  out.block<6, 6>(velocity, velocity) = G.velocity_attitude.inverse();
  for (std::size_t i = 0; i < kMountingBlocks.size(); ++i) {
    if (!layout.has(kMountingBlocks[i])) continue;
    const int row = layout.offset(kMountingBlocks[i]);
    out.block<3, 3>(row, row) = G.mountings[i].inverse();
  }
  return out;
}

// The derivatives of a linearised fix by the blocks that have a place in `offsets`, whitened: a column for each row.
template <class Offsets>
void put_whitened(const Linearization& lin, const Matrix3d& W, const Offsets& offsets, Blocks::View out) {
  out.setZero();
  for (int i = 0; i < lin.count(); ++i) {
    const Linearization::Term& term = lin.term(i);
    const int offset = offsets[static_cast<std::size_t>(term.block)];
    if (offset < 0) continue;
    for (int k = 0; k < term.size(); ++k) {
      for (int row = 0; row < lin.rows; ++row) {
        double sum = 0;
        for (int j = 0; j <= row; ++j) sum -= W(row, j) * term.jacobian(j, k);
        out(offset + term.column + k, row) = sum;
      }
    }
  }
}

// `variance`: that of a process other than the IMU's, with its first row.
template <class Variance>
void fill_noise(const BatchLayout& layout, const ImuSum& sum, Blocks::View P, const Variance& variance) {
  // m. Over milliseconds the samples determine the distance to nanometres, beyond the digits of the difference of two
  // positions. Ten nanometres at each node come to a third of a micrometre in a minute.
  constexpr double kFinest = 1e-8;
  P.setZero();
  P.topLeftCorner<9, 9>() = sum.noise.topLeftCorner<9, 9>();
  P.diagonal().head<3>().array() += kFinest * kFinest;
  int row = 0;
  for (const Block b : layout.node.blocks) {
    if (b == Block::kGyroDrift || b == Block::kAccelDrift) {
      const int from = b == Block::kGyroDrift ? 9 : 12;
      P.block<9, 3>(0, row) = sum.noise.block<9, 3>(0, from);
      P.block<3, 9>(row, 0) = sum.noise.block<3, 9>(from, 0);
      P.block<3, 3>(row, row) = sum.noise.block<3, 3>(from, from);
    } else if (!is_navigation(b)) {
      P.diagonal().segment(row, info(b).size) = variance(row, b);
    }
    row += info(b).size;
  }
}

// That of the filter. A random walk begins at exactly zero, which no weight can say: a millionth of the variance that
// it gains in a second stands for it.
Eigen::MatrixXd prior_of(const BatchLayout& layout, const FilterOptions& options, const Start& start) {
  constexpr double kAsGoodAsZero = 1e-6;
  Eigen::MatrixXd P = initial_covariance(layout.whole, options, start);
  for (const Block b : layout.node.blocks) {
    if (is_navigation(b)) continue;
    const Vector3d gained = process_step(options, b, 1).variance;
    for (int k = 0; k < info(b).size; ++k) {
      double& variance = P(layout.whole.offset(b) + k, layout.whole.offset(b) + k);
      if (variance == 0) variance = kAsGoodAsZero * gained(k);
    }
  }
  return P;
}

}  // namespace

BatchTerm compare_ends(const BatchLayout& layout, const FilterOptions& options, const ImuSum& sum,
                       const Estimate& linearised_at, const Estimate& start, const Estimate& end,
                       const Vector3d& earth_rate, const Gravity& gravity) {
  const int n = layout.node.size();
  const SumResidual r = compare(sum, imu_change(start, linearised_at), start, end, earth_rate, gravity);
  BatchTerm out{Eigen::VectorXd::Zero(n), Eigen::MatrixXd::Zero(n, n), Eigen::MatrixXd::Zero(n, n),
                Eigen::MatrixXd::Zero(n, layout.constant.size())};
  out.residual.head<9>() = r.value;
  out.by_first.topLeftCorner<9, 9>() = r.by_start;
  out.by_second.topLeftCorner<9, 9>() = r.by_end;
  int column = 0;
  for (const ImuErrorBlock& b : kImuErrorBlocks) {
    if (const int offset = layout.constant.offset(b.block); offset >= 0) {
      out.by_constant.block(0, offset, 9, b.size()) = r.by_imu.middleCols(column, b.size());
    }
    if (const int offset = layout.node.offset(b.block); offset >= 0) {
      out.by_first.block(0, offset, 9, b.size()) = r.by_imu.middleCols(column, b.size());
    }
    column += b.size();
  }
  for (const Block b : layout.node.blocks) {
    if (is_navigation(b)) continue;
    const int row = layout.node.offset(b), size = info(b).size;
    const double decay = process_step(options, b, sum.time).decay;
    out.residual.segment(row, size) = additive(end, b) - decay * additive(start, b);
    out.by_first.block(row, row, size, size).diagonal().setConstant(-decay);
    out.by_second.block(row, row, size, size).setIdentity();
  }
  return out;
}

Eigen::MatrixXd interval_noise(const BatchLayout& layout, const FilterOptions& options, const ImuSum& sum) {
  Blocks P(1, layout.node.size(), layout.node.size());
  fill_noise(layout, sum, P[0], [&](int, Block b) -> Eigen::VectorXd {
    return process_step(options, b, sum.time).variance.head(info(b).size);
  });
  return P[0];
}

Eigen::MatrixXd whitening(const Eigen::MatrixXd& P) {
  const Eigen::LLT<Eigen::MatrixXd> root(P);
  if (root.info() != Eigen::Success) not_definite();
  return root.matrixL().solve(Eigen::MatrixXd::Identity(P.rows(), P.cols()));
}

BatchTerms::Offsets BatchTerms::offsets_of(const BatchLayout::Part& part) {
  Offsets out;
  for (const BlockInfo& row : kBlocks) out[static_cast<std::size_t>(row.block)] = part.offset(row.block);
  return out;
}

BatchTerms::BatchTerms(const World& world, const FilterOptions& options, const BatchLayout& layout, const Start& start,
                       const Chain& chain)
    : world_(world),
      options_(options),
      layout_(layout),
      chain_(chain),
      of_node_(offsets_of(layout.node)),
      of_constant_(offsets_of(layout.constant)),
      start_(start.x),
      prior_(whitening(prior_of(layout, options, start))) {}

void BatchTerms::follow_chain(const std::vector<Estimate>& states, std::size_t threads) {
  const int n = layout_.node.size();
  const std::size_t intervals = chain_.intervals.size(), fixes = chain_.fixes.size();
  processes_.resize(intervals, n, 2);
  information_.resize(intervals, n, n);
  fixes_.resize(fixes);
  rows_.resize(fixes, n, layout_.constant.size());
  for_each_stretch(intervals, kPerTask, threads, [&](std::size_t first, std::size_t last) {
    ProcessSteps processes(options_, layout_);
    for (std::size_t i = first; i < last; ++i) weigh_interval(i, processes);
  });
  for_each_stretch(fixes, kPerTask, threads, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) weigh_fix(i, states[chain_.fixes[i].node]);
  });
}

void BatchTerms::linearise(const std::vector<Estimate>& states, std::size_t threads) {
  for_each_stretch(fixes_.size(), kPerTask, threads, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      const Estimate& x = states[chain_.fixes[i].node];
      put_fix(i, about(i, x), x, rows_.J[i], rows_.K[i]);
    }
  });
}

void BatchTerms::weigh_interval(std::size_t i, ProcessSteps& processes) {
  processes.over(chain_.intervals[i].sum.time);
  for (const Block b : layout_.node.blocks) {
    if (is_navigation(b)) continue;
    auto to = processes_[i].middleRows(of_node_[static_cast<std::size_t>(b)], info(b).size);
    to.col(0).setConstant(processes.of(b).decay);
    to.col(1) = processes.of(b).variance.head(info(b).size);
  }
  put_noise(i, information_[i]);
  if (!invert_definite(information_[i])) not_definite();
}

void BatchTerms::weigh_fix(std::size_t i, const Estimate& x) {
  const ChainFix& fix = chain_.fixes[i];
  const Linearization lin = linearize(fix, chain_.nodes[fix.node].x);
  Matrix3d R = Matrix3d::Identity();
  R.topLeftCorner(lin.rows, lin.rows) = lin.covariance.topLeftCorner(lin.rows, lin.rows);
  const Eigen::LLT<Matrix3d> root(R);
  if (root.info() != Eigen::Success) not_definite();
  Matrix3d W = root.matrixL().solve(Matrix3d::Identity());
  W.bottomRows(3 - lin.rows).setZero();
  fixes_[i] = {lin.rows, W};
  put_whitened(lin, W, of_constant_, rows_.K[i]);
  put_fix(i, lin, x, rows_.J[i], rows_.K[i]);
}

void BatchTerms::put_noise(std::size_t i, const Blocks::View& P) const {
  fill_noise(layout_, chain_.intervals[i].sum, P,
             [&](int row, Block b) { return processes_[i].col(1).segment(row, info(b).size); });
}

Linearization BatchTerms::linearize(const ChainFix& fix, const Estimate& x) const {
  const MeasurementContext context{.options = options_,
                                   .layout = layout_.whole,
                                   .earth_rate = world_.earth_rate(),
                                   .gravity = chain_.nodes[fix.node].gravity,
                                   .step = fix.step,
                                   .into_step = fix.into_step,
                                   .rate_variance = fix.rate_variance,
                                   .still = fix.still,
                                   .elapsed = fix.elapsed,
                                   .moved = fix.moved,
                                   .recent = fix.recent,
                                   .neighbour_rate = fix.neighbour_rate,
                                   .rate_regression = &fix.rate_regression,
                                   .side = &chain_.nodes[fix.node].side};
  std::optional<Linearization> lin;
  MeasurementList::visit(
      [&]<class Type>(const typename Type::Fix& known) {
        lin = Type::linearize(known, fix.place.sensor, fix.place.channel, context, x);
      },
      fix.place.fix);
  if (!lin) throw std::logic_error("a batch has a fix that the filter could not use");
  return *lin;
}

BatchTerm BatchTerms::prior(const Estimate& first) const {
  const FullError e = boxminus(first, start_);
  const Eigen::MatrixXd J = prior_ * by_error(layout_.whole, e);
  return {prior_ * select(layout_.whole, e), columns_of(layout_.node, J), {}, columns_of(layout_.constant, J)};
}

BatchTerm BatchTerms::interval(std::size_t i, const Estimate& start, const Estimate& end) const {
  const ChainNode& node = chain_.nodes[i];
  BatchTerm term =
      compare_ends(layout_, options_, chain_.intervals[i].sum, node.x, start, end, world_.earth_rate(), node.gravity);
  const Eigen::MatrixXd root = whitening(interval_noise(layout_, options_, chain_.intervals[i].sum));
  const auto W = root.triangularView<Eigen::Lower>();
  term.residual = W * term.residual;
  term.by_first = W * term.by_first;
  term.by_second = W * term.by_second;
  term.by_constant = W * term.by_constant;
  return term;
}

double BatchTerms::tie(std::size_t i, const Estimate& start, const Estimate& end, ChainLinks& links) const {
  const ChainNode& node = chain_.nodes[i];
  const ImuSum& sum = chain_.intervals[i].sum;
  const SumTie t = tie_ends(sum, imu_change(start, node.x), start, end, world_.earth_rate(), node.gravity);
  const int n = layout_.node.size(), g = layout_.constant.size();
  auto F = links.F[i], B = links.B_transposed[i], noise = links.noise[i];
  Eigen::Matrix<double, kMostStates, 1> residual;
  residual.head<9>() = t.value;
  F.topLeftCorner<9, 9>() = t.by_start;
  B.row(g).head<9>() = t.shift.transpose();
  int column = 0;
  for (const ImuErrorBlock& b : kImuErrorBlocks) {
    if (const int at = of_constant_[static_cast<std::size_t>(b.block)]; at >= 0) {
      B.block(at, 0, b.size(), 9) = t.by_imu.middleCols(column, b.size()).transpose();
    }
    if (const int at = of_node_[static_cast<std::size_t>(b.block)]; at >= 0) {
      F.block(0, at, 9, b.size()) = t.by_imu.middleCols(column, b.size());
    }
    column += b.size();
  }
  const auto process = processes_[i];
  for (const Block b : layout_.node.blocks) {
    if (is_navigation(b)) continue;
    const int row = of_node_[static_cast<std::size_t>(b)];
    const auto last = additive(end, b), first = additive(start, b);
    for (int k = row; k < row + info(b).size; ++k) {
      F(k, k) = process(k, 0);
      residual(k) = last(k - row) - process(k, 0) * first(k - row);
      B(g, k) = -residual(k);
    }
  }
  put_noise(i, noise);
  // That of the sum seen from the end, as T N Tᵀ = T (T N)ᵀ.
  for (int k = 0; k < n; ++k) t.turn_to_end(noise.col(k).data());
  const Matrix9d turned = noise.topLeftCorner<9, 9>();
  noise.topLeftCorner<9, 9>() = turned.transpose();
  for (int k = 0; k < 9; ++k) t.turn_to_end(noise.col(k).data());
  noise.bottomLeftCorner(n - 9, 9) = noise.topRightCorner(9, n - 9).transpose();
  return residual.head(n).dot(information_[i].lazyProduct(residual.head(n)));
}

// With the constants of the chain.
Linearization BatchTerms::about(std::size_t i, const Estimate& x) const {
  Estimate at = x;
  layout_.constant.copy(chain_.nodes[chain_.fixes[i].node].x, at);
  return linearize(chain_.fixes[i], at);
}

// `K` has the derivatives by the constants already.
void BatchTerms::put_fix(std::size_t i, const Linearization& lin, const Estimate& x, const Blocks::View& J,
                         Blocks::View K) const {
  const Matrix3d& W = fixes_[i].whitening;
  put_whitened(lin, W, of_node_, J);
  const int g = layout_.constant.size();
  std::array<double, kMostStates> change;
  layout_.constant.difference(x, chain_.nodes[chain_.fixes[i].node].x, change.data());
  for (int row = 0; row < 3; ++row) {
    double sum = 0;
    for (int k = 0; k < g; ++k) sum += K(k, row) * change[static_cast<std::size_t>(k)];
    for (int j = 0; j < lin.rows; ++j) sum += W(row, j) * lin.residual(j);
    K(g, row) = sum;
  }
}

BatchTerm BatchTerms::fix(std::size_t i, const Estimate& x) const {
  const int g = layout_.constant.size(), n = rows_of_fix(i);
  ArrowRows rows(1, layout_.node.size(), g);
  rows.K[0] = rows_.K[i];
  put_fix(i, about(i, x), x, rows.J[0], rows.K[0]);
  return {rows.K[0].row(g).head(n).transpose(),
          rows.J[0].leftCols(n).transpose(),
          {},
          rows.K[0].topLeftCorner(g, n).transpose()};
}

}  // namespace piste
