// The tables of a study against small cases by hand.

#include "piste/study/study_tables.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "piste/math/units.h"
#include "piste/study/missing.h"
#include "piste/study/ranking.h"
#include "support/study_case.h"
#include "support/text_file.h"

namespace piste {
namespace {

using test::StudyCase;

constexpr double kRoot3 = 1.7320508075688772;

// Runs and sensors with nothing in them.
Study empty_study(std::size_t runs, std::size_t sensors = 1) {
  Study out;
  for (std::size_t s = 0; s < sensors; ++s) out.sensors.push_back(fmt::format("S{}", s + 1));
  for (std::size_t r = 0; r < runs; ++r) {
    StudyRun run;
    run.name = fmt::format("run-{}", r + 1);
    run.outages = 1;
    out.runs.push_back(run);
    for (std::size_t s = 0; s < sensors; ++s) {
      SensorRun both;
      both.run = r;
      both.sensor = s;
      out.results.push_back(both);
    }
  }
  return out;
}

AxisEstimate& at(SensorRun& run, Method method, std::size_t axis) {
  auto found = std::ranges::find(run.estimates, method, &MethodEstimate::method);
  if (found == run.estimates.end()) found = run.estimates.insert(found, {method, {}});
  return found->axes[axis];
}

// A bias that shows as `correction` in the tables.
void set_bias(SensorRun& run, Method method, std::size_t axis, const Term& correction) {
  const double factor = signal_info(static_cast<int>(axis)).factor;
  Term error = correction;
  error.value = -error.value;
  for (double* size : {&error.value, &error.sigma, &error.standard_error, &error.systematic}) *size /= factor;
  at(run, method, axis).bias_alone = error;
}

void set_score(SensorRun& run, Method method, double error, double drift = 1) {
  run.scores.push_back({method, error, error, error, drift});
}

const RankingRow& row_of(const Ranking& ranking, Method method) {
  return *std::ranges::find(ranking.rows, method, &RankingRow::method);
}

BiasScale line_of(double bias, double scale, double correlation = 0) {
  BiasScale out;
  out.value << bias, scale;
  out.covariance << 4, 2 * correlation, 2 * correlation, 1;
  out.hac_covariance = 4 * out.covariance;
  return out;
}

TEST(StudyCase, IsWholeUnlessItIsToFail) {
  const Study study = StudyCase{}.study();
  EXPECT_TRUE(missing(study).empty()) << missing(study).front();
  EXPECT_EQ(table_of(study, Method::kRest, StudyQuantity::kBias).size(), 18U);
  EXPECT_EQ(before_after(study).size(), 18U);
  EXPECT_EQ(correlations(study).size(), 18U);
  EXPECT_EQ(timing(study).size(), 7U);
  EXPECT_EQ(ranking(study).rows.size(), kMethods.size());
  EXPECT_EQ(ranking(study).winner, Method::kMarkovSmoothed);
  EXPECT_EQ(missing(StudyCase{.failed = true}.study()).size(), 3U);
}

// Whatever rotation the boresight of a run has.
TEST(CrossAxis, IsAlongTheAxesThatTheAccelerometersDefine) {
  const Study study = StudyCase{}.study();
  const auto rows = cross_axis(study);
  ASSERT_EQ(rows.size(), 9 * study.sensors.size());
  const std::string_view xyz = "xyz";
  for (const CrossAxisRow& row : rows) {
    const auto i = static_cast<Eigen::Index>(xyz.find(row.element[0])),
               j = static_cast<Eigen::Index>(xyz.find(row.element[1]));
    EXPECT_EQ(i, row.axis % 3);
    const Matrix3d M = row.axis < 3 ? StudyCase::accel_cross_axis() : StudyCase::gyro_cross_axis();
    EXPECT_NEAR(row.value.mean, -M(i, j), 1e-12) << row.element;
    EXPECT_NEAR(row.value.within, 2e-4, 1e-9) << "two elements, with their systematic errors";
  }
}

TEST(ScaleScatter, IsExplainedAsFarAsItsVarianceFalls) {
  Study study = StudyCase{}.study();
  double k = 0;
  for (SensorRun& run : study.results) {
    at(run, Method::kJoint, 0).line = line_of(0, 0.02 * std::sin(k));
    at(run, Method::kMisalignment, 0).line = line_of(0, 0.01 * std::sin(k));
    k += 1;
  }
  for (const ScaleScatter& row : scale_scatter(study)) {
    if (row.axis != 0) continue;
    EXPECT_NEAR(row.alone, 2 * row.with_cross_axis, 0.03 * row.alone);
    EXPECT_NEAR(row.explained, 0.75, 0.02);
  }
}

TEST(Methods, StandInTheirOrder) {
  for (std::size_t i = 0; i < kMethods.size(); ++i) EXPECT_EQ(static_cast<std::size_t>(kMethods[i].method), i);
}

TEST(Shown, IsACorrectionInTheUnitOfFiles) {
  AxisEstimate line;
  line.line = line_of(0.1, 0.25);
  line.true_bias = 0.1;
  line.true_scale = 0.25;
  EXPECT_DOUBLE_EQ(shown(line, StudyQuantity::kBias, 0)->value, -0.08);
  EXPECT_DOUBLE_EQ(shown(line, StudyQuantity::kScale, 0)->value, -0.2);
  EXPECT_DOUBLE_EQ(shown(line, StudyQuantity::kBias, 3)->value, -0.08 * kDegreesPerRadian);
  EXPECT_DOUBLE_EQ(shown(line, StudyQuantity::kScale, 3)->value, -0.2);
  EXPECT_DOUBLE_EQ(shown(line, StudyQuantity::kScale, 3)->sigma, 0.64) << "1 / (1 + scale)²";
  EXPECT_DOUBLE_EQ(*shown_truth(line, StudyQuantity::kBias, 3), -0.08 * kDegreesPerRadian);
  EXPECT_DOUBLE_EQ(*shown_truth(line, StudyQuantity::kScale, 0), -0.2);
  AxisEstimate alone;
  alone.bias_alone = Term{0.1, 0.01, 0.02, 5, 0.03};
  alone.true_bias = 0.2;
  const Term bias = *shown(alone, StudyQuantity::kBias, 4);
  EXPECT_DOUBLE_EQ(bias.value, -0.1 * kDegreesPerRadian);
  EXPECT_DOUBLE_EQ(bias.sigma, 0.01 * kDegreesPerRadian);
  EXPECT_DOUBLE_EQ(bias.standard_error, 0.02 * kDegreesPerRadian);
  EXPECT_DOUBLE_EQ(bias.systematic, 0.03 * kDegreesPerRadian);
  EXPECT_EQ(bias.dof, 5);
  EXPECT_DOUBLE_EQ(*shown_truth(alone, StudyQuantity::kBias, 0), -0.2);
  EXPECT_FALSE(shown(alone, StudyQuantity::kScale, 0));
  EXPECT_FALSE(shown_truth(alone, StudyQuantity::kScale, 0));
  EXPECT_FALSE(shown(AxisEstimate{}, StudyQuantity::kBias, 0));
  line.true_scale.reset();
  EXPECT_FALSE(shown_truth(line, StudyQuantity::kBias, 0));
}

TEST(SensorRun, HasNoEstimateWhereTheMethodIsSilent) {
  SensorRun run;
  EXPECT_EQ(run.estimate(Method::kRest, 0), nullptr);
  set_bias(run, Method::kRest, 1, {1});
  EXPECT_EQ(run.estimate(Method::kRest, 0), nullptr);
  ASSERT_NE(run.estimate(Method::kRest, 1), nullptr);
  EXPECT_EQ(run.estimate(Method::kRest, 1)->bias_alone->value, -1);
}

TEST(TableOf, IsTheMeanOfTheRunsByStudentsT) {
  Study study = empty_study(3, 2);
  for (std::size_t r = 0; r < 3; ++r) {
    set_bias(study.results[2 * r + 1], Method::kRest, 4, {1.0 + static_cast<double>(r), 0.1, 0.3, 9, 0.4});
  }
  const auto table = table_of(study, Method::kRest, StudyQuantity::kBias);
  ASSERT_EQ(table.size(), 1U) << "an axis without a number is left out";
  EXPECT_EQ(table[0].sensor, 1U);
  EXPECT_EQ(table[0].axis, 4);
  const Across& v = table[0].value;
  EXPECT_EQ(v.runs, 3U);
  EXPECT_DOUBLE_EQ(v.mean, 2);
  EXPECT_DOUBLE_EQ(v.std, 1);
  EXPECT_DOUBLE_EQ(v.standard_error, 1 / kRoot3);
  EXPECT_NEAR(v.p_value, 0.0741799, 1e-6) << "t = 2 √3 with two degrees of freedom";
  EXPECT_DOUBLE_EQ(v.p_holm, v.p_value) << "one number, no correction";
  EXPECT_FALSE(v.significant);
  EXPECT_DOUBLE_EQ(v.formal, 0.1);
  EXPECT_DOUBLE_EQ(v.within, 0.5);
  EXPECT_TRUE(std::isnan(table[0].reverse));
  EXPECT_FALSE(table[0].truth);
  EXPECT_TRUE(table_of(study, Method::kRest, StudyQuantity::kScale).empty());
  EXPECT_TRUE(table_of(study, Method::kJoint, StudyQuantity::kBias).empty());
}

TEST(TableOf, SigmasWithinTheRunsAreRootMeanSquares) {
  Study study = empty_study(2);
  set_bias(study.results[0], Method::kRest, 0, {1, 1, 3, 9, 4});
  set_bias(study.results[1], Method::kRest, 0, {1, 7, 0, 9, 1});
  const Across v = table_of(study, Method::kRest, StudyQuantity::kBias).front().value;
  EXPECT_DOUBLE_EQ(v.formal, 5);
  EXPECT_DOUBLE_EQ(v.within, std::sqrt(13.0)) << "of 5 and 1";
  EXPECT_EQ(v.std, 0);
  EXPECT_EQ(v.p_value, 0) << "no spread, and not zero";
  EXPECT_TRUE(v.significant);
}

TEST(TableOf, OfOneRunTakesTheErrorWithinIt) {
  Study study = empty_study(1);
  const Term term{2, 0.1, 0.3, 9, 0.4};
  set_bias(study.results[0], Method::kRest, 0, term);
  const Across v = table_of(study, Method::kRest, StudyQuantity::kBias).front().value;
  EXPECT_TRUE(std::isnan(v.std));
  EXPECT_DOUBLE_EQ(v.standard_error, 0.5);
  EXPECT_DOUBLE_EQ(v.p_value, term.p_value());
}

TEST(TableOf, CorrectsOverAllItsNumbers) {
  Study study = empty_study(3);
  for (std::size_t r = 0; r < 3; ++r) {
    const auto x = static_cast<double>(r) - 1;
    set_bias(study.results[r], Method::kRest, 0, {8 + x});    // t = 13.9, p = 0.0052
    set_bias(study.results[r], Method::kRest, 1, {2.6 + x});  // t = 4.50, p = 0.046
    set_bias(study.results[r], Method::kRest, 2, {x});        // p = 1
  }
  const auto table = table_of(study, Method::kRest, StudyQuantity::kBias);
  ASSERT_EQ(table.size(), 3U);
  EXPECT_DOUBLE_EQ(table[0].value.p_holm, 3 * table[0].value.p_value);
  EXPECT_DOUBLE_EQ(table[1].value.p_holm, 2 * table[1].value.p_value);
  EXPECT_EQ(table[2].value.p_holm, 1);
  EXPECT_TRUE(table[0].value.significant);
  EXPECT_LT(table[1].value.p_value, kSignificance);
  EXPECT_FALSE(table[1].value.significant) << "of three, one may be below 5 % by chance";
}

TEST(TableOf, OfTheJointLineHasTheOtherDirectionAndTheTruth) {
  Study study = empty_study(2);
  for (std::size_t r = 0; r < 2; ++r) {
    AxisEstimate& forward = at(study.results[r], Method::kJoint, 0);
    forward.line = line_of(0, 0.25);
    forward.true_bias = 0;
    if (r == 0) forward.true_scale = 1;
    at(study.results[r], Method::kJointReverse, 0).line = line_of(0, r == 0 ? 0 : 1);
  }
  auto table = table_of(study, Method::kJoint, StudyQuantity::kScale);
  EXPECT_DOUBLE_EQ(table[0].value.mean, -0.2);
  EXPECT_DOUBLE_EQ(table[0].reverse, -0.25) << "of 0 and −½";
  EXPECT_FALSE(table[0].truth) << "one run does not tell it";
  at(study.results[1], Method::kJoint, 0).true_scale = 0;
  table = table_of(study, Method::kJoint, StudyQuantity::kScale);
  EXPECT_DOUBLE_EQ(table[0].truth.value(), -0.25);
  EXPECT_TRUE(std::isnan(table_of(study, Method::kJointReverse, StudyQuantity::kScale)[0].reverse));
}

TEST(BeforeAfter, IsOverTheRunsThatHaveBoth) {
  Study study = empty_study(3);
  for (std::size_t r = 0; r < 3; ++r) set_bias(study.results[r], Method::kRest, 3, {1.0 + static_cast<double>(r)});
  set_bias(study.results[0], Method::kRestAfter, 3, {1.5});
  set_bias(study.results[2], Method::kRestAfter, 3, {3.1});
  const auto rows = before_after(study);
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_DOUBLE_EQ(rows[0].before, 2);
  EXPECT_DOUBLE_EQ(rows[0].after, 2.3);
  EXPECT_EQ(rows[0].difference.runs, 2U);
  EXPECT_NEAR(rows[0].difference.mean, 0.3, 1e-12);
  EXPECT_NEAR(rows[0].difference.std, 0.4 / std::sqrt(2), 1e-12);
}

TEST(BeforeAfter, LetsTheReferenceCancelWhereTheFindingsSaySo) {
  Study study = empty_study(1);
  SensorRun& run = study.results[0];
  set_bias(run, Method::kRest, 3, {1, 0, 3, 9, 10});
  set_bias(run, Method::kRestAfter, 3, {1, 0, 4, 9, 10});
  EXPECT_NEAR(before_after(study)[0].difference.within, 15, 1e-9) << "of 5, 10 and 10, as nobody knows more";
  run.findings.emplace();
  run.findings->axes[3].change = Term{0, 0, 0, 1, 12 / kDegreesPerRadian};
  const double error = before_after(study)[0].difference.within;
  EXPECT_NEAR(error, 13, 1e-9) << "5 from both, 12 that is left";
}

TEST(Correlations, AreMeanMagnitudesWithTheSignOfTheMean) {
  Study study = empty_study(2);
  at(study.results[0], Method::kJointReverse, 2).line = line_of(0, 0, 0.9);
  at(study.results[1], Method::kJointReverse, 2).line = line_of(0, 0, -0.7);
  const auto rows = correlations(study);
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_EQ(rows[0].axis, 2);
  EXPECT_DOUBLE_EQ(rows[0].correlation, 0.8);
  EXPECT_DOUBLE_EQ(rows[0].lowest, -0.7);
  EXPECT_DOUBLE_EQ(rows[0].highest, 0.9);
  EXPECT_DOUBLE_EQ(rows[0].inflation, 1 / (1 - 0.64));
  EXPECT_TRUE(correlations(study, Method::kMarkovSmoothed).empty());
}

TEST(Comparisons, AreOverTheRunsThatHaveBothAndCorrectedPairByPair) {
  Study study = empty_study(3);
  for (std::size_t r = 0; r < 3; ++r) {
    const auto x = static_cast<double>(r) - 1;
    set_bias(study.results[r], Method::kRest, 0, {8 + x, 0, 3, 9, 0});
    set_bias(study.results[r], Method::kRest, 1, {x});
    if (r < 2) set_bias(study.results[r], Method::kBiasOnly, 0, {5, 0, 4, 9, 12});
    at(study.results[r], Method::kRest, 0).true_bias = -7;
    at(study.results[r], Method::kRest, 1).true_bias = -7;
  }
  const auto rows = comparisons(study, StudyQuantity::kBias);
  ASSERT_EQ(rows.size(), 3U);
  EXPECT_EQ(rows[0].a, Method::kRest);
  EXPECT_EQ(rows[0].b, Method::kBiasOnly);
  EXPECT_EQ(rows[0].difference.runs, 2U);
  EXPECT_DOUBLE_EQ(rows[0].difference.mean, 2.5);
  EXPECT_DOUBLE_EQ(rows[0].difference.within, 13);
  EXPECT_DOUBLE_EQ(rows[0].difference.p_holm, rows[0].difference.p_value) << "alone in its pair";
  EXPECT_EQ(rows[1].b, Method::kTruth);
  EXPECT_DOUBLE_EQ(rows[1].difference.mean, 1) << "against what was put in";
  EXPECT_DOUBLE_EQ(rows[2].difference.mean, -7);
  EXPECT_DOUBLE_EQ(rows[2].difference.p_holm, 2 * rows[2].difference.p_value);
  EXPECT_TRUE(comparisons(study, StudyQuantity::kScale).empty());
}

TEST(Comparisons, ArePairedWithinARun) {
  Study study = empty_study(1);
  const auto set = [&](Method method, const Eigen::Vector2d& averages, double effect) {
    Term term{.value = 1, .standard_error = averages.norm(), .dof = 2, .systematic = std::abs(effect)};
    term.averages = averages;
    term.effects = Eigen::VectorXd::Constant(1, effect);
    set_bias(study.results[0], method, 0, term);
  };
  set(Method::kRest, {3, 4}, 20);
  set(Method::kBiasOnly, {3, 1}, 16);
  const auto rows = comparisons(study, StudyQuantity::kBias);
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_DOUBLE_EQ(rows[0].difference.within, 5) << "3 of the noise, 4 of the reference";
}

TEST(Coverage, CountsWhatLiesInsideTheInterval) {
  Study study = empty_study(2);
  const Term known{0, 0, 3, 9, 4};
  const double edge = known.half_width(0.95);
  const std::array<double, 4> errors{0, 0.99 * edge, -1.01 * edge, 20};
  for (std::size_t i = 0; i < 4; ++i) {
    SensorRun& run = study.results[i / 2];
    set_bias(run, Method::kRest, i % 2, known);
    at(run, Method::kRest, i % 2).true_bias = errors[i];
  }
  EXPECT_TRUE(coverage(study).empty()) << "of a campaign that nobody simulated";
  study.simulated = true;
  const auto rows = coverage(study);
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_EQ(rows[0].method, Method::kRest);
  EXPECT_FALSE(rows[0].gyro);
  EXPECT_EQ(rows[0].inside, 2U);
  EXPECT_EQ(rows[0].all, 4U);
  EXPECT_DOUBLE_EQ(rows[0].rate(), 0.5);
  EXPECT_DOUBLE_EQ(rows[0].worst, 4);
}

TEST(Coverage, IsWhatItSaysWhereSigmasAreTrue) {
  const std::vector<Coverage> all = coverage(StudyCase{.runs = 30}.study());
  EXPECT_GE(all.size(), kMethods.size());
  for (const Coverage& c : all) {
    if (c.method == Method::kJoint) continue;  // too flat by construction
    EXPECT_EQ(c.all, 270U);
    EXPECT_NEAR(c.rate(), 0.96, 0.045) << info(c.method).name;
  }
}

TEST(ImusCompared, HaveAllAsOneLastAndOverTheMeanOfTheSingleOnesInTheSameRuns) {
  Study study = empty_study(2, 2);
  for (SensorRun& r : study.results) {
    const double size = 1 + 2 * static_cast<double>(r.sensor);  // 1 and 3
    r.scores = {{Method::kNothing, 9, 9, 9, 9}, {Method::kInTheFilter, size, size, size, 2 * size}};
  }
  study.results[2].scores[1] = {Method::kInTheFilter, 7, 7, 7, 7};  // of the first, in a run without all as one
  ASSERT_EQ(imus_compared(study).size(), 2U);
  SensorRun together;
  together.imus = {"S1", "S2"};
  together.scores = {{Method::kInTheFilter, 0.5, 0.5, 1, 3}};
  study.as_one = {together};
  const std::vector<ImuCompared> rows = imus_compared(study);
  ASSERT_EQ(rows.size(), 3U);
  EXPECT_EQ(rows[0].name, "S1");
  EXPECT_EQ(rows[0].runs, 2U);
  EXPECT_DOUBLE_EQ(rows[0].attitude_rmse, 5) << "of 1 and 7";
  EXPECT_TRUE(std::isnan(rows[0].attitude_over_single));
  EXPECT_EQ(rows[2].name, kAsOne);
  EXPECT_EQ(rows[2].runs, 1U);
  EXPECT_DOUBLE_EQ(rows[2].position_rmse, 0.5);
  EXPECT_DOUBLE_EQ(rows[2].attitude_over_single, 0.5) << "over the mean of 1 and 3";
  EXPECT_DOUBLE_EQ(rows[2].drift_over_single, 0.75) << "over the mean of 2 and 6";
  EXPECT_EQ(ranking(study).rows.size(), 2U) << "they are not ranked";
  EXPECT_EQ(study.sensors.size(), 2U);
  EXPECT_EQ(of_all_as_one(study).sensors, std::vector<std::string>{std::string(kAsOne)});
  study.as_one[0].failure = "their drifts are of two kinds";
  const std::vector<std::string> lacking = missing(study);
  EXPECT_TRUE(std::ranges::any_of(lacking, [](const std::string& line) {
    return test::contains(line, "all as one failed in run-1: their drifts are of two kinds");
  }));
}

TEST(Ranking, IsTheGeometricMeanOverThatOfKnowingNothing) {
  Study study = empty_study(2, 2);
  for (SensorRun& r : study.results) {
    r.scores = {{Method::kNothing, 1, 2, 3, 4}, {Method::kRest, 2, 4, 6, 8}, {Method::kJoint, 0.5, 1, 1.5, 2}};
  }
  study.results[0].scores[1] = {Method::kRest, 16, 2, 3, 4};  // geometric mean 2
  const Ranking found = ranking(study);
  ASSERT_EQ(found.rows.size(), 3U);
  EXPECT_EQ(found.winner, Method::kJoint);
  const RankingRow &rest = row_of(found, Method::kRest), &joint = row_of(found, Method::kJoint);
  EXPECT_EQ(rest.count, 4U);
  EXPECT_DOUBLE_EQ(row_of(found, Method::kNothing).score, 1);
  EXPECT_DOUBLE_EQ(joint.score, 0.5);
  EXPECT_DOUBLE_EQ(rest.score, 2);
  EXPECT_DOUBLE_EQ(rest.versus_winner, 4);
  EXPECT_DOUBLE_EQ(rest.position_rmse, std::sqrt((256 + 3 * 4) / 4.0));
  EXPECT_DOUBLE_EQ(rest.outage_drift, std::sqrt((16 + 3 * 64) / 4.0));
  EXPECT_NEAR(rest.p_holm, 0, 1e-9) << "the same in both runs";
  EXPECT_EQ(joint.versus_winner, 1);
  EXPECT_EQ(joint.p_holm, 1);
  EXPECT_EQ(found.confidence, 1);
}

TEST(Ranking, LeavesOutWhatThereIsNot) {
  Study study = empty_study(2);
  for (SensorRun& r : study.results) {
    set_score(r, Method::kNothing, 1, 0);
    set_score(r, Method::kRest, 0.25, 0);
  }
  study.results[1].scores[0].outage_drift = 1;
  study.results[1].scores[1].outage_drift = 64;  // geometric mean of ¼, ¼, ¼ and 64: 1
  set_score(study.results[1], Method::kJoint, 0.01);
  const Ranking found = ranking(study);
  EXPECT_EQ(found.rows.size(), 2U) << "joint has no score in the first run";
  EXPECT_EQ(found.winner, Method::kRest);
  EXPECT_DOUBLE_EQ(row_of(found, Method::kRest).score, 0.5);
  EXPECT_DOUBLE_EQ(row_of(found, Method::kRest).outage_drift, 64);
  EXPECT_TRUE(test::contains(missing(study).back(), "joint is not ranked: it has no score for S1 in run-1."));
}

TEST(Ranking, PairsTheRunsAndGivesAnInterval) {
  Study study = empty_study(3);
  for (std::size_t r = 0; r < 3; ++r) {
    const auto x = static_cast<double>(r);
    const double hardness = std::exp(5 * x);  // of the run; the ratio of both is the same but for exp(±0.1)
    set_score(study.results[r], Method::kNothing, 3 * hardness, 3 * hardness);
    set_score(study.results[r], Method::kRest, 2 * hardness * std::exp(0.1 * (x - 1)),
              2 * hardness * std::exp(0.1 * (x - 1)));
    set_score(study.results[r], Method::kJoint, hardness, hardness);
  }
  const RankingRow rest = row_of(ranking(study), Method::kRest);
  EXPECT_NEAR(rest.versus_winner, 2, 1e-9);
  const double half = 4.302653 * 0.1 / kRoot3;  // Student's t, two degrees of freedom
  EXPECT_NEAR(rest.low, 2 * std::exp(-half), 1e-6);
  EXPECT_NEAR(rest.high, 2 * std::exp(half), 1e-6);
  const double t = std::log(2.0) / (0.1 / kRoot3);  // 12.0; of nothing against rest 7.02, against joint without spread
  EXPECT_NEAR(rest.p_holm, 2 * 2 * (1 - (0.5 + t / (2 * std::sqrt(2 + t * t)))), 1e-6) << "two pairs are left";
}

TEST(Ranking, WinsAsOftenAsTheRunsSay) {
  Study study = empty_study(2);
  const auto add = [&study](Method method, double first, double second) {
    set_score(study.results[0], method, std::exp(first), std::exp(first));
    set_score(study.results[1], method, std::exp(second), std::exp(second));
  };
  add(Method::kNothing, 0, 0);
  add(Method::kRest, -1, 0);
  add(Method::kJoint, 0, -0.9);
  add(Method::kTruth, -2, -2);
  const Ranking found = ranking(study);
  EXPECT_EQ(found.winner, Method::kRest) << "the truth does not compete";
  EXPECT_NEAR(found.confidence, 0.75, 0.02) << "lost where the second run is drawn twice";
  EXPECT_EQ(found.confidence, ranking(study).confidence);
  EXPECT_LT(row_of(found, Method::kTruth).versus_winner, 1);
}

TEST(Ranking, OfATieSaysSo) {
  Study study = empty_study(4);
  for (std::size_t r = 0; r < 4; ++r) {
    set_score(study.results[r], Method::kNothing, 2);
    for (const Method m : {Method::kRest, Method::kJoint}) set_score(study.results[r], m, 1 + static_cast<double>(r));
  }
  const Ranking found = ranking(study);
  EXPECT_EQ(found.winner, Method::kRest) << "the first of equals";
  EXPECT_EQ(found.confidence, 0.5);
  EXPECT_EQ(row_of(found, Method::kJoint).p_holm, 1);
  EXPECT_EQ(row_of(found, Method::kJoint).versus_winner, 1);
}

// What the correction for all pairs leaves in doubt is no tie where the method's own interval is beyond 1.
TEST(Ranking, OfTwoThatAreFarApartIsNoTie) {
  Study study = empty_study(4);
  for (std::size_t r = 0; r < 4; ++r) {
    const double wander = 0.12 * (static_cast<double>(r) - 1.5);
    set_score(study.results[r], Method::kNothing, 4);
    set_score(study.results[r], Method::kRest, 1);
    set_score(study.results[r], Method::kJoint, std::exp(0.35 + wander));
    set_score(study.results[r], Method::kBiasOnly, std::exp(0.1 - wander));
    set_score(study.results[r], Method::kScaleOnly, std::exp(0.4 - 0.5 * wander));
  }
  const Ranking found = ranking(study);
  ASSERT_EQ(found.winner, Method::kRest);
  const RankingRow &joint = row_of(found, Method::kJoint), &bias = row_of(found, Method::kBiasOnly);
  ASSERT_GT(joint.p_holm, kSignificance);
  ASSERT_GT(joint.low, 1);
  ASSERT_LT(bias.low, 1);
  std::vector<Method> first;
  for (const RankingRow& row : leaders(found)) first.push_back(row.method);
  EXPECT_EQ(first, (std::vector{Method::kRest, Method::kBiasOnly}));
  for (const std::string& remark : remarks(study, found)) EXPECT_FALSE(test::contains(remark, "winner")) << remark;
}

TEST(Ranking, FindsNoDifferenceWhereThereIsNone) {
  test::Random random(7);
  constexpr int kStudies = 200;
  int found = 0;
  for (int i = 0; i < kStudies; ++i) {
    Study study = empty_study(9);
    for (SensorRun& r : study.results) {
      for (const MethodInfo& m : kMethods) {
        if (!m.competes && m.method != Method::kNothing) continue;
        set_score(r, m.method, std::exp(random.gaussian(0.1)));
      }
    }
    const auto rows = ranking(study).rows;
    if (std::ranges::any_of(rows, [](const RankingRow& r) { return r.p_holm < kSignificance; })) ++found;
  }
  EXPECT_LE(found, 0.08 * kStudies) << "5 % and its own chance";
}

TEST(Ranking, OfOneRunHasNoInterval) {
  Study study = empty_study(1, 3);
  for (SensorRun& r : study.results) {
    set_score(r, Method::kNothing, 2);
    set_score(r, Method::kRest, 1);
    set_score(r, Method::kJoint, 1.5);
  }
  const Ranking found = ranking(study);
  EXPECT_EQ(found.winner, Method::kRest);
  EXPECT_TRUE(std::isnan(found.confidence));
  const RankingRow& joint = row_of(found, Method::kJoint);
  EXPECT_NEAR(joint.versus_winner, std::pow(1.5, 0.75), 1e-12) << "the drift is the same";
  EXPECT_TRUE(std::isnan(joint.low) && std::isnan(joint.high) && std::isnan(joint.p_holm));
}

TEST(Ranking, OfNothingIsEmpty) {
  Study study = empty_study(1);
  EXPECT_TRUE(ranking(study).rows.empty());
  EXPECT_FALSE(ranking(study).winner);
  set_score(study.results[0], Method::kRest, 1);
  EXPECT_TRUE(ranking(study).rows.empty()) << "nothing to hold it against";
}

TEST(Timing, IsTheChangeAgainstNoDelay) {
  Study study = empty_study(2, 2);
  for (std::size_t i = 0; i < 4; ++i) {
    // Corrections: −½ without delay, and −¾, −¾ of the first run, −2/3, −½ of the second with it.
    TimingEffect none, late;
    none.forward.fill(1);
    late.delay = 0.01;
    late.forward.fill(i < 2 ? 3 : i == 2 ? 2 : 1);
    study.results[i].timing = {none, late};
  }
  const auto rows = timing(study);
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[0].delay, 0);
  EXPECT_EQ(rows[0].forward[2], 0);
  EXPECT_EQ(rows[1].delay, 0.01);
  EXPECT_NEAR(rows[1].forward[5], -(0.25 + 1.0 / 12) / 2, 1e-12);
  EXPECT_NEAR(rows[1].forward_error[5], (0.25 - 1.0 / 12) / 2, 1e-12) << "between two runs";
  EXPECT_EQ(rows[1].reverse[5], 0);
  study.results.resize(2);
  EXPECT_TRUE(std::isnan(timing(study)[1].forward_error[0])) << "of one run";
}

TEST(Missing, SaysWhatAndWhere) {
  Study study = StudyCase{.runs = 3, .simulated = false}.study();
  EXPECT_TRUE(missing(study).empty()) << "the truth is not missed where nobody knows it";
  study.runs[0].failure = "no fix";
  study.runs[1].outages = 0;
  SensorRun& third = study.results[3 + 2];
  third.failure = "silent";
  third.estimates.clear();
  third.scores.clear();
  SensorRun& second = study.results[3 + 1];
  std::ranges::find(second.estimates, Method::kPolynomial, &MethodEstimate::method)->axes[2] = {};
  std::erase_if(second.scores, [](const auto& s) { return s.method == Method::kNothing; });
  for (SensorRun& r : study.results) {
    std::erase_if(r.estimates, [](const auto& e) { return e.method == Method::kOtherRuns; });
  }
  study.results.pop_back();
  EXPECT_EQ(missing(study),
            (std::vector<std::string>{
                "ski-1 failed: no fix", "MT-9A 3 in ski-2 failed: silent", "bicycle-3 has no MT-9A 3.",
                "There is no answer by polynomial for fz of MT-9A 2 in ski-2.", "No run has an answer by other_runs.",
                "MT-9A 2 in ski-2 is not in the ranking: its replay that knows nothing has no score.",
                "ski-2 has no outage: it is scored without the drift in one."}));
}

}  // namespace
}  // namespace piste
