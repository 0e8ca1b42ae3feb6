// The trust region, from where steps of Gauss and Newton would not settle.

#include "batch/solver.h"

#include <gtest/gtest.h>

#include <limits>
#include <memory>
#include <vector>

#include "batch/normal.h"
#include "filter/considered.h"
#include "piste/core/error.h"
#include "support/synthetic_log.h"

namespace piste {
namespace {

/// The terms of a short run, laid about what its filter found.
struct Laid {
  test::SyntheticRun s;
  FilterRun run;
  BatchLayout layout;
  Chain chain;
  BatchTerms terms;
  BatchStates states;
  std::vector<double> weights;

  explicit Laid(const std::vector<Block>& estimate)
      : s(test::synthetic_run(5, estimate)),
        run(run_filter(s.log, s.options, s.start)),
        layout(filter_layout(s.options)),
        terms(s.log.world, s.options, layout, s.start, chain) {
    auto reference = std::make_shared<Reference>(layout.whole);
    reference->start = s.start.x;
    FixWeights known;
    for (const Innovation& v : run.solution.innovations) known[{v.source, v.time + v.late}] = 1;
    for (std::size_t i = 0; i < run.solution.size(); ++i)
      reference->add(run.solution.time(i), run.solution.estimate(i));
    reference->close();
    lay_chain(s.log, s.options, layout, s.start.time, reference, known, 1, 1, chain);
    for (const ChainNode& node : chain.nodes) {
      states.push_back(node.x);
      layout.constant.copy(chain.nodes.back().x, states.back());
    }
    terms.follow_chain(states, 1);
    weights.assign(chain.fixes.size(), 1);
    weights[3] = 0;  // left out
  }
};

TEST(TrustRegion, LeadsFromFarOffToTheMinimum) {
  for (const std::vector<Block>& estimate :
       {std::vector<Block>{}, {Block::kGyroBias, Block::kBoresight, Block::kGyroDrift}}) {
    Laid laid(estimate);
    BatchStates near = laid.states;
    Newton newton;
    const Refined expected = refine(laid.terms, laid.weights, near, newton, WhereNot::kStays, 1);
    ASSERT_TRUE(expected.settled);

    test::Random random(1);
    BatchStates far = laid.states;
    const FullError constant =
        laid.layout.constant.expand(Eigen::VectorXd(0.01 * random.matrix(laid.layout.constant.size(), 1)).data());
    for (Estimate& x : far) {
      FullError error = FullError::Zero();
      error.segment<3>(full_offset(Block::kPosition)) = random.vector(20);
      error.segment<3>(full_offset(Block::kVelocity)) = random.vector(5);
      error.segment<3>(full_offset(Block::kAttitude)) = random.vector(0.5);
      x = boxplus(boxplus(x, error), constant);
    }
    const BatchStep step = minimise(laid.terms, laid.weights, far);
    EXPECT_GT(step.before, 100 * expected.cost);
    EXPECT_GT(step.iterations, 2);
    EXPECT_NEAR(step.after, expected.cost, 1e-3 * expected.cost);
    // And on from there by the steps that settle.
    laid.terms.linearise(far, 1);
    const Refined refined = refine(laid.terms, laid.weights, far, newton, WhereNot::kLowest, 1);
    EXPECT_TRUE(refined.settled);
    for (std::size_t i = 0; i < far.size(); ++i) {
      EXPECT_LT(boxminus(far[i], near[i]).cwiseAbs().maxCoeff(), 1e-5) << i;
      EXPECT_TRUE(laid.layout.constant.select(boxminus(far[i], far[0])).isZero(0)) << "all share the constants";
    }
  }
}

TEST(TrustRegion, SaysThatItCannotSolve) {
  Laid laid({});
  laid.states[7].p_wb.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(minimise(laid.terms, laid.weights, laid.states), DataError);
}

// From far off Gauss and Newton's steps need not settle: then states stay, or are the lowest on the way.
TEST(TrustRegion, StepsThatDoNotSettleLeaveTheStates) {
  Laid laid({});
  test::Random random(2);
  for (Estimate& x : laid.states) x.q_wb = so3_exp(random.vector(2)) * x.q_wb;
  const BatchStates before = laid.states;
  laid.terms.linearise(laid.states, 1);
  Newton newton;
  const Refined stays = refine(laid.terms, laid.weights, laid.states, newton, WhereNot::kStays, 1);
  ASSERT_FALSE(stays.settled);
  for (std::size_t i = 0; i < before.size(); ++i) EXPECT_TRUE(boxminus(laid.states[i], before[i]).isZero(0));
  const Refined lowest = refine(laid.terms, laid.weights, laid.states, newton, WhereNot::kLowest, 1);
  EXPECT_EQ(lowest.cost, stays.cost);
  EXPECT_GE(lowest.fall, 0);
}

}  // namespace
}  // namespace piste
