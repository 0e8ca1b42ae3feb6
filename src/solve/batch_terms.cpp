#include "batch_terms.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <stdexcept>
#include <utility>

#include "piste/core/error.h"

namespace piste {
namespace {

using ImuChange = Eigen::Matrix<double, 18, 1>;

// By how much the errors of the IMU differ, in the order of the columns of a sum.
ImuChange imu_change(const Estimate& now, const Estimate& before) {
  ImuChange change;
  int row = 0;
  for (const Block b : ImuSum::kImuErrors) {
    change.segment<3>(row) = additive(now, b) - additive(before, b);
    row += 3;
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
  for (const Block b : ImuSum::kImuErrors) {
    const bool constant = info(b).prior != nullptr;
    const int offset = (constant ? layout.constant : layout.node).offset(b);
    if (offset >= 0) {
      (constant ? out.by_constant : out.by_first).block<9, 3>(0, offset) += r.by_imu.middleCols<3>(column);
    }
    column += 3;
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
  // m: over milliseconds the samples tell the way to nanometres, of which the difference of two places has no digits
  // left. Ten nanometres at each node come to a third of a micrometre in a minute.
  constexpr double kFinest = 1e-8;
  const int n = layout.node.size();
  Eigen::MatrixXd P = Eigen::MatrixXd::Zero(n, n);
  P.topLeftCorner<9, 9>() = sum.noise.topLeftCorner<9, 9>();
  P.diagonal().head<3>().array() += kFinest * kFinest;
  int from = 9;
  for (const Block drift : {Block::kGyroDrift, Block::kAccelDrift}) {
    if (const int to = layout.node.offset(drift); to >= 0) {
      P.block<9, 3>(0, to) = sum.noise.block<9, 3>(0, from);
      P.block<3, 9>(to, 0) = sum.noise.block<3, 9>(from, 0);
      P.block<3, 3>(to, to) = sum.noise.block<3, 3>(from, from);
    }
    from += 3;
  }
  for (const Block b : layout.node.blocks) {
    if (is_navigation(b) || b == Block::kGyroDrift || b == Block::kAccelDrift) continue;
    P.diagonal().segment(layout.node.offset(b), info(b).size) =
        process_step(options, b, sum.time).variance.head(info(b).size);
  }
  return P;
}

Eigen::MatrixXd whitening(const Eigen::MatrixXd& P) {
  const Eigen::LLT<Eigen::MatrixXd> root(P);
  if (root.info() != Eigen::Success)
    throw DataError("batch", "a covariance is not positive definite: is a block estimated that has no error?");
  return root.matrixL().solve(Eigen::MatrixXd::Identity(P.rows(), P.cols()));
}

BatchTerms::BatchTerms(const World& world, const FilterOptions& options, const BatchLayout& layout, const Start& start,
                       const Chain& chain)
    : world_(world),
      options_(options),
      layout_(layout),
      chain_(chain),
      start_(start.x),
      prior_(whitening(prior_of(layout, options, start))) {
  intervals_.reserve(chain.intervals.size());
  for (const ChainInterval& i : chain.intervals) {
    intervals_.push_back(whitening(interval_noise(layout, options, i.sum)));
  }
  fixes_.reserve(chain.fixes.size());
  for (const ChainFix& f : chain.fixes) {
    const Linearization lin = linearize(f, chain.nodes[f.node].x);
    const Eigen::MatrixXd W = whitening(lin.covariance.topLeftCorner(lin.rows, lin.rows));
    fixes_.push_back({W, columns_of(layout.constant, -W * assemble(layout.whole, lin).topRows(lin.rows))});
  }
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
                                   .moved = fix.moved,
                                   .recent = fix.recent,
                                   .rate_before = fix.rate_before,
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
  const auto W = intervals_[i].triangularView<Eigen::Lower>();
  term.residual = W * term.residual;
  term.by_first = W * term.by_first;
  term.by_second = W * term.by_second;
  term.by_constant = W * term.by_constant;
  return term;
}

BatchTerms::Tie BatchTerms::tie(std::size_t i, const Estimate& start, const Estimate& end) const {
  const ChainNode& node = chain_.nodes[i];
  const ImuSum& sum = chain_.intervals[i].sum;
  const BatchTerm t = compare_ends(layout_, options_, sum, node.x, start, end, world_.earth_rate(), node.gravity);
  const double square = (intervals_[i].triangularView<Eigen::Lower>() * t.residual).squaredNorm();
  // By the end of processes the residual is the identity.
  const Matrix9d by_end = t.by_second.topLeftCorner<9, 9>().inverse();
  const auto solved = [&by_end](Eigen::MatrixXd rows) {
    rows.topRows<9>() = (by_end * rows.topRows<9>()).eval();
    return rows;
  };
  const Eigen::MatrixXd half = solved(interval_noise(layout_, options_, sum));
  return {{-solved(t.by_first), -solved(t.by_constant), solved(half.transpose()), -solved(t.residual)}, square};
}

BatchTerm BatchTerms::fix(std::size_t i, const Estimate& x) const {
  const ChainFix& fix = chain_.fixes[i];
  const Estimate& laid = chain_.nodes[fix.node].x;
  Estimate at = x;
  layout_.constant.copy(laid, at);
  const Linearization lin = linearize(fix, at);
  const auto& [W, by_constant] = fixes_[i];
  const Eigen::MatrixXd J = -W * assemble(layout_.whole, lin).topRows(lin.rows);
  const Eigen::VectorXd change = layout_.constant.select(boxminus(x, laid));
  return {W * lin.residual.head(lin.rows) + by_constant * change, columns_of(layout_.node, J), {}, by_constant};
}

}  // namespace piste
