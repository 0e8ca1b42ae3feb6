#include "batch_rows.h"

#include <Eigen/LU>

namespace piste {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// A block of the covariance of the run's errors from one of two parts.
void put(Covariance& P, const BatchLayout::Part& rows, const BatchLayout::Part& columns, const MatrixXd& from) {
  for (int j = 0; j < columns.size(); ++j) {
    for (int i = 0; i < rows.size(); ++i) {
      P(rows.rows[static_cast<std::size_t>(i)], columns.rows[static_cast<std::size_t>(j)]) = from(i, j);
    }
  }
}

// The way through one interval: what is summed until each of its steps, and how an error in it goes on to the end.
class Bridge {
 public:
  Bridge(const BatchTerms& terms, const FilterOptions& options, const World& world, const BatchStates& states,
         std::size_t interval)
      : layout_(terms.layout()),
        options_(options),
        earth_rate_(world.earth_rate()),
        node_(terms.chain().nodes[interval]),
        start_(states[interval]),
        end_(states[interval + 1]) {
    const Chain& chain = terms.chain();
    const ChainInterval& i = chain.intervals[interval];
    Preintegration sum(start_);
    for (std::size_t k = i.first; k < i.last; ++k) {
      const ChainStep& s = chain.steps[k];
      const SumStep step = sum.add(s.step, s.noise, s.told, drift_step(options, layout_, Block::kGyroDrift, s.step.dt),
                                   drift_step(options, layout_, Block::kAccelDrift, s.step.dt));
      sums_.push_back(sum.sum());
      transitions_.push_back(transition(step, s.step.dt));
    }
    const MatrixXd W = whitening(interval_noise(layout_, options_, sums_.back()));
    information_ = W.transpose() * W;
    at_end_ = compare_ends(layout_, options_, sums_.back(), start_, start_, end_, earth_rate_, node_.gravity);
  }

  std::size_t steps() const { return sums_.size(); }

  // Estimates after each step.
  std::vector<Estimate> estimates() const {
    std::vector<Estimate> out(steps());
    VectorXd pull = information_ * at_end_.residual;
    for (std::size_t k = steps(); k-- > 0;) {
      out[k] = estimate(k, interval_noise(layout_, options_, sums_[k]) * pull);
      pull = (transitions_[k].transpose() * pull).eval();
    }
    return out;
  }

  // Estimate and covariance after step `k`, by the joint covariance of the errors of both nodes and the constants.
  SmoothedState state(std::size_t k, const MatrixXd& joint) const {
    const int n = layout_.node.size(), g = layout_.constant.size();
    MatrixXd F = MatrixXd::Identity(n, n);  // from k to the end
    for (std::size_t i = k + 1; i < steps(); ++i) F = (transitions_[i] * F).eval();
    const MatrixXd noise = interval_noise(layout_, options_, sums_[k]);
    const MatrixXd M = F.transpose() * information_, K = noise * M;
    SmoothedState out{estimate(k, K * at_end_.residual), Covariance(layout_.whole.size(), layout_.whole.size())};
    const BatchTerm here = compare_ends(layout_, options_, sums_[k], start_, start_, out.x, earth_rate_, node_.gravity);
    const MatrixXd left = noise - noise * (M * F) * noise;  // of the noise until k, given that until the end
    const Eigen::PartialPivLU<MatrixXd> by_here(here.by_second);
    MatrixXd T(n, 2 * n + g);
    T << K * at_end_.by_first - here.by_first, K * at_end_.by_second, K * at_end_.by_constant - here.by_constant;
    T = by_here.solve(T).eval();
    const MatrixXd with_joint = T * joint;
    const MatrixXd P = with_joint * T.transpose() + by_here.solve(by_here.solve(left).transpose());
    put(out.P, layout_.node, layout_.node, P);
    put(out.P, layout_.node, layout_.constant, with_joint.rightCols(g));
    put(out.P, layout_.constant, layout_.node, with_joint.rightCols(g).transpose());
    put(out.P, layout_.constant, layout_.constant, joint.bottomRightCorner(g, g));
    return out;
  }

 private:
  MatrixXd transition(const SumStep& step, double dt) const {
    MatrixXd F = MatrixXd::Zero(layout_.node.size(), layout_.node.size());
    F.topLeftCorner<9, 9>() = step.by_sum;
    for (const Block b : layout_.node.blocks) {
      if (is_navigation(b)) continue;
      const int row = layout_.node.offset(b), size = info(b).size;
      F.block(row, row, size, size).diagonal().setConstant(process_step(options_, b, dt).decay);
      if (b == Block::kGyroDrift) F.block<9, 3>(0, row) = step.by_reading.leftCols<3>();
      if (b == Block::kAccelDrift) F.block<9, 3>(0, row) = step.by_reading.rightCols<3>();
    }
    return F;
  }

  // The estimate after step k, with what the interval's noise has come to there.
  Estimate estimate(std::size_t k, const VectorXd& noise) const {
    Estimate x = carry(sums_[k], noise.head<9>(), start_, earth_rate_, node_.gravity);
    for (const Block b : layout_.node.blocks) {
      if (is_navigation(b)) continue;
      additive(x, b) = process_step(options_, b, sums_[k].time).decay * additive(start_, b) +
                       noise.segment(layout_.node.offset(b), info(b).size);
    }
    return x;
  }

  const BatchLayout& layout_;
  const FilterOptions& options_;
  Vector3d earth_rate_;
  const ChainNode& node_;
  const Estimate &start_, &end_;
  std::vector<ImuSum> sums_;           // until the end of each step
  std::vector<MatrixXd> transitions_;  // over it
  MatrixXd information_;               // of the noise of the whole interval
  BatchTerm at_end_;
};

// Estimate and covariance at a node itself.
SmoothedState state_of_node(const BatchLayout& layout, const ArrowMatrix& P, std::size_t i, const Estimate& x) {
  SmoothedState out{x, Covariance(layout.whole.size(), layout.whole.size())};
  put(out.P, layout.node, layout.node, P.nodes[i]);
  put(out.P, layout.node, layout.constant, P.sides[i]);
  put(out.P, layout.constant, layout.node, P.sides[i].transpose());
  put(out.P, layout.constant, layout.constant, P.corner);
  return out;
}

// Joint covariance of nodes i and i + 1 and the constants.
MatrixXd joint_of(const ArrowMatrix& P, std::size_t i) {
  const Eigen::Index n = P.nodes[i].rows(), g = P.corner.rows();
  MatrixXd out(2 * n + g, 2 * n + g);
  out << P.nodes[i], P.links[i], P.sides[i], P.links[i].transpose(), P.nodes[i + 1], P.sides[i + 1],
      P.sides[i].transpose(), P.sides[i + 1].transpose(), P.corner;
  return out;
}

}  // namespace

Reference epochs_between(const BatchTerms& terms, const FilterOptions& options, const World& world,
                         const BatchStates& states) {
  const Chain& chain = terms.chain();
  Reference out;
  out.start = states.front();
  out.rows.reserve(chain.epochs.size());
  auto epoch = chain.epochs.begin();
  const auto at_node = [&](std::size_t i) {
    for (; epoch != chain.epochs.end() && epoch->interval == i && epoch->steps == 0; ++epoch) {
      out.rows.push_back({epoch->time, states[i]});
    }
  };
  for (std::size_t i = 0; i < chain.intervals.size(); ++i) {
    at_node(i);
    if (epoch == chain.epochs.end() || epoch->interval != i) continue;
    const std::vector<Estimate> between = Bridge(terms, options, world, states, i).estimates();
    for (; epoch != chain.epochs.end() && epoch->interval == i; ++epoch) {
      out.rows.push_back({epoch->time, between[epoch->steps - 1]});
    }
  }
  at_node(chain.intervals.size());
  return out;
}

void visit_epochs(const BatchTerms& terms, const FilterOptions& options, const World& world, const BatchStates& states,
                  const ArrowMatrix& covariance, const std::vector<std::size_t>& rows,
                  const std::function<void(std::size_t, double, const SmoothedState&)>& visit) {
  const Chain& chain = terms.chain();
  std::optional<Bridge> bridge;
  std::size_t of = chain.intervals.size();
  MatrixXd joint;
  for (const std::size_t row : rows) {
    const ChainEpoch& e = chain.epochs[row];
    if (e.steps == 0) {
      visit(row, e.time, state_of_node(terms.layout(), covariance, e.interval, states[e.interval]));
      continue;
    }
    if (e.interval != of) {
      of = e.interval;
      bridge.emplace(terms, options, world, states, of);
      joint = joint_of(covariance, of);
    }
    visit(row, e.time, bridge->state(e.steps - 1, joint));
  }
}

}  // namespace piste
