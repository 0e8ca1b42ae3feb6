#include "rows.h"

#include <Eigen/LU>
#include <algorithm>

#include "math/parallel.h"

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

using NodeError = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMostStates, 1>;

// The estimate after some steps, with what the interval's noise has come to there. `left`: by row of a node, the part
// of a process that is left.
Estimate estimate_after(const BatchLayout& layout, const SummedMotion& sum, const NodeError& left,
                        const NodeError& noise, const Estimate& start, const Vector3d& earth_rate,
                        const Gravity& gravity) {
  Estimate x = carry(sum, noise.head<9>(), start, earth_rate, gravity);
  int row = 0;
  for (const Block b : layout.node.blocks) {
    const int size = info(b).size;
    if (!is_navigation(b)) {
      auto value = additive(x, b);
      for (int k = 0; k < size; ++k) value(k) = left(row + k) * value(k) + noise(row + k);
    }
    row += size;
  }
  return x;
}

// Estimates after each step of one interval, given both nodes. The noise w_k of a step is Q_k times the adjoint there,
// which is Fᵀ times that of the next step, and at the end the information of the interval times its residual: what
// smoothing gives where nothing is measured between (Bryson and Frazier 1963).
class MeanBridge {
 public:
  MeanBridge(const BatchTerms& terms, const FilterOptions& options, const World& world)
      : terms_(terms), layout_(terms.layout()), world_(world), processes_(options, layout_) {}

  void estimates(const BatchStates& states, std::size_t interval, std::vector<Estimate>& out) {
    const Chain& chain = terms_.chain();
    const ChainInterval& i = chain.intervals[interval];
    const Gravity& gravity = chain.nodes[interval].gravity;
    const Estimate& start = states[interval];
    const Estimate& end = states[interval + 1];
    Preintegration sum(start);
    NodeError left = NodeError::Ones(layout_.node.size());
    steps_.clear();
    for (std::size_t k = i.first; k < i.last; ++k) {
      const ChainStep& s = chain.steps[k];
      processes_.over(s.step.dt);
      const SumStep step = sum.move(s.step, processes_.of(Block::kGyroDrift), processes_.of(Block::kAccelDrift));
      for_each_process([&](Block b, int row, int size) { left.segment(row, size) *= processes_.of(b).decay; });
      steps_.push_back({step, sum.motion(), left, {}});
    }
    NodeError residual(layout_.node.size());
    residual.head<9>() = residual_of(sum.motion(), start, end, world_.earth_rate(), gravity);
    for_each_process([&](Block b, int row, int size) {
      residual.segment(row, size) = additive(end, b) - left(row) * additive(start, b);
    });
    NodeError pull = terms_.information(interval).lazyProduct(residual);
    for (std::size_t k = steps_.size(); k-- > 0;) {
      steps_[k].pull = pull;
      processes_.over(chain.steps[i.first + k].step.dt);
      pull = adjoint(steps_[k].step, pull);
    }
    NodeError noise = NodeError::Zero(layout_.node.size());
    out.clear();
    for (std::size_t k = 0; k < steps_.size(); ++k) {
      const ChainStep& s = chain.steps[i.first + k];
      processes_.over(s.step.dt);
      noise = onward(steps_[k], s, noise);
      out.push_back(estimate_after(layout_, steps_[k].sum, steps_[k].left, noise, start, world_.earth_rate(), gravity));
    }
  }

 private:
  struct Step {
    SumStep step;
    SummedMotion sum;  // until its end
    NodeError left;    // of the processes, likewise
    NodeError pull;    // the adjoint there
  };

  // Fᵀ `pull`.
  NodeError adjoint(const SumStep& step, const NodeError& pull) const {
    NodeError out(pull.size());
    const Eigen::Matrix<double, 9, 1> of_sum = pull.head<9>();
    out.head<9>() = step.by_sum.transpose().lazyProduct(of_sum);
    const Eigen::Matrix<double, 6, 1> of_reading = step.by_reading.transpose().lazyProduct(of_sum);
    for_each_process([&](Block b, int row, int size) {
      out.segment(row, size) = processes_.of(b).decay * pull.segment(row, size);
      if (b == Block::kGyroDrift) out.segment<3>(row) += of_reading.head<3>();
      if (b == Block::kAccelDrift) out.segment<3>(row) += of_reading.tail<3>();
    });
    return out;
  }

  // F `noise` + Q pull.
  NodeError onward(const Step& at, const ChainStep& sample, const NodeError& noise) const {
    NodeError out(noise.size());
    Eigen::Matrix<double, 6, 1> drift = Eigen::Matrix<double, 6, 1>::Zero();
    for_each_process([&](Block b, int row, int size) {
      if (b == Block::kGyroDrift) drift.head<3>() = noise.segment<3>(row);
      if (b == Block::kAccelDrift) drift.tail<3>() = noise.segment<3>(row);
      const DriftStep& process = processes_.of(b);
      out.segment(row, size) = process.decay * noise.segment(row, size) +
                               process.variance.head(size).cwiseProduct(at.pull.segment(row, size));
    });
    out.head<9>() = at.step.by_sum.lazyProduct(noise.head<9>()) + at.step.by_reading.lazyProduct(drift) +
                    white_noise_of(at.step, sample.noise, sample.step.dt, at.pull.head<9>());
    return out;
  }

  template <class Visit>
  void for_each_process(const Visit& visit) const {
    for (const Block b : layout_.node.blocks) {
      if (!is_navigation(b)) visit(b, layout_.node.offset(b), info(b).size);
    }
  }

  const BatchTerms& terms_;
  const BatchLayout& layout_;
  const World& world_;
  ProcessSteps processes_;
  std::vector<Step> steps_;
};

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
    ProcessSteps processes(options, layout_);
    NodeError left = NodeError::Ones(layout_.node.size());
    for (std::size_t k = i.first; k < i.last; ++k) {
      const ChainStep& s = chain.steps[k];
      processes.over(s.step.dt);
      const SumStep step =
          sum.add(s.step, s.noise, s.reference, processes.of(Block::kGyroDrift), processes.of(Block::kAccelDrift));
      sums_.push_back(sum.sum());
      transitions_.push_back(transition(step, processes));
      left.tail(left.size() - 9).array() *= transitions_.back().diagonal().tail(left.size() - 9).array();
      left_.push_back(left);
    }
    const MatrixXd W = whitening(interval_noise(layout_, options_, sums_.back()));
    information_ = W.transpose() * W;
    at_end_ = compare_ends(layout_, options_, sums_.back(), start_, start_, end_, earth_rate_, node_.gravity);
  }

  std::size_t steps() const { return sums_.size(); }

  // Estimate and covariance after step `k`, by the joint covariance of the errors of both nodes and the constants.
  SmoothedState state(std::size_t k, const MatrixXd& joint) const {
    const int n = layout_.node.size(), g = layout_.constant.size();
    MatrixXd F = MatrixXd::Identity(n, n);  // from k to the end
    for (std::size_t i = k + 1; i < steps(); ++i) F = (transitions_[i] * F).eval();
    const MatrixXd noise = interval_noise(layout_, options_, sums_[k]);
    const MatrixXd M = F.transpose() * information_, K = noise * M;
    SmoothedState out{
        estimate_after(layout_, sums_[k], left_[k], K * at_end_.residual, start_, earth_rate_, node_.gravity),
        Covariance(layout_.whole.size(), layout_.whole.size())};
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
  MatrixXd transition(const SumStep& step, const ProcessSteps& processes) const {
    MatrixXd F = MatrixXd::Zero(layout_.node.size(), layout_.node.size());
    F.topLeftCorner<9, 9>() = step.by_sum;
    for (const Block b : layout_.node.blocks) {
      if (is_navigation(b)) continue;
      const int row = layout_.node.offset(b), size = info(b).size;
      F.block(row, row, size, size).diagonal().setConstant(processes.of(b).decay);
      if (b == Block::kGyroDrift) F.block<9, 3>(0, row) = step.by_reading.leftCols<3>();
      if (b == Block::kAccelDrift) F.block<9, 3>(0, row) = step.by_reading.rightCols<3>();
    }
    return F;
  }

  const BatchLayout& layout_;
  const FilterOptions& options_;
  Vector3d earth_rate_;
  const ChainNode& node_;
  const Estimate &start_, &end_;
  std::vector<ImuSum> sums_;           // until the end of each step
  std::vector<NodeError> left_;        // of the processes, likewise
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

std::shared_ptr<const Reference> epochs_between(const BatchTerms& terms, const FilterOptions& options,
                                                const World& world, const BatchStates& states, std::size_t threads) {
  const Chain& chain = terms.chain();
  auto out = std::make_shared<Reference>(terms.layout().whole);
  out->start = states.front();
  // So many are kept at a time. The last are stored first, as a reference takes them.
  std::vector<std::vector<Estimate>> between(std::max<std::size_t>(threads, 1) * kPerTask);
  std::size_t end = chain.intervals.size();
  auto last = chain.epochs.end();
  do {
    const std::size_t from = end - std::min(end, between.size());
    for_each_stretch(end - from, kPerTask, threads, [&](std::size_t begin, std::size_t until) {
      MeanBridge bridge(terms, options, world);
      for (std::size_t k = begin; k < until; ++k) bridge.estimates(states, from + k, between[k]);
    });
    const auto first = std::partition_point(chain.epochs.begin(), last,
                                            [from](const ChainEpoch& epoch) { return epoch.interval < from; });
    for (auto e = first; e != last; ++e) {
      out->add(e->time, e->steps == 0 ? states[e->interval] : between[e->interval - from][e->steps - 1]);
    }
    out->close();
    end = from;
    last = first;
  } while (end > 0);
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
